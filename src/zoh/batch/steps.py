"""The metrics of many step responses at once, at the samples.

Every sample is looked at while a mode lives that turns by more than a quarter of a radian in two
of them; then every second, every fourth, ..., the matrices being squared. What was met at a long
stride is closed in on by halving. A response is left where one mode, or one pair, is alone and
cannot leave the band any more.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from math import inf, log

import numpy as np
import numpy.typing as npt

from zoh.batch.between import Piece, crest, estimate, pieces
from zoh.batch.held import Held
from zoh.batch.motion import Motion
from zoh.batch.rows import Array, Complex, Mask, only

_LOST = 2e-9  # of the final value: what is left of a mode no longer says where to look
_TURN = 0.25  # rad
_BAND = 0.02
_NEAR = 0.9  # of the band: what is alone and inside this stays inside
_CREST = 0.98  # of the band: between samples at a long stride it may be left
_RISE = (0.1, 0.9)
_BLOCK = 16  # samples between two looks at which loops are done
_QUIET = log(1e8)  # the slowest mode is followed until it has fallen so far
_NOTHING = 1e-10  # an overshoot below this part of the final value is rounding
_LEVELS = 40
_MOST = 4096  # samples at one stride after which a loop is left to the careful road

Index = npt.NDArray[np.int64]


@dataclass(slots=True, kw_only=True)
class Seen:
    """What was seen of each loop, y counted in the direction of its final value.

    k_*  samples: of the highest, of those first reaching 10 % and 90 %, of the last outside the
    band, of the last crest just inside it; stride_* the stride at which it was met
    """

    top: Array
    bottom: Array
    most: Array
    least: Array
    k_top: Array
    k_most: Array
    k_least: Array
    k_10: Array
    k_90: Array
    k_out: Array
    k_near: Array
    stride_top: Array
    stride_most: Array
    stride_least: Array
    stride_10: Array
    stride_90: Array
    stride_out: Array
    stride_near: Array
    crest: Array
    k_crest: Array
    piece: Array

    @classmethod
    def of(cls, count: int) -> "Seen":
        """Return what is seen before anything is."""
        start = {"top": -inf, "bottom": inf, "most": -inf, "least": inf, "crest": -inf}
        return cls(**{f.name: np.full(count, start.get(f.name, -1.0)) for f in fields(cls)})


def step_metrics(
    motion: Motion, plant: Held, delay: int, z: Complex, dt: Array, reference: float = 1.0
) -> tuple[dict[str, Array], Mask]:
    """Return (the metrics by name, which loops had better be measured one by one).

    z  the closed loop's poles to a few digits, shape (n, B): see ``motion.poles``
    """
    size = np.abs(motion.final)
    sign = np.where(motion.final < 0, -1.0, 1.0)
    parts = pieces(plant, motion, delay)
    seen, at_crest, doubt = _followed(motion, parts, sign, size, z)
    _closed_in(motion, sign, size, seen)
    over, under = seen.top / size - 1, -seen.bottom / size
    most, least = np.maximum(seen.most, motion.at_rest), np.minimum(seen.least, motion.at_rest)
    reach = abs(reference)
    highest, when, known = _between(motion, plant, parts, sign, seen, at_crest)
    beyond = highest / size - 1
    return {
        "between.overshoot_pct": np.where(beyond > _NOTHING, 100 * beyond, 0.0),
        "between.peak_time": np.where(beyond > _NOTHING, when * dt, np.nan),
        "overshoot_pct": np.where(over > _NOTHING, 100 * over, 0.0),
        "undershoot_pct": np.where(under > _NOTHING, 100 * under, 0.0),
        "rise_time": (seen.k_90 - seen.k_10) * dt,
        "settling_time": (seen.k_out + 1) * dt,
        "peak": np.maximum(seen.top, size) * reach,
        "peak_time": np.where(over > _NOTHING, seen.k_top * dt, np.nan),
        "steady_state_error": (1 - motion.final) * reference,
        "peak_effort": np.maximum(most, -least) * reach,
    }, doubt | ~known | (size == 0)


def _followed(
    motion: Motion, parts: list[Piece], sign: Array, size: Array, z: Complex
) -> tuple[Seen, Array, Mask]:
    """Return what was seen, Z before the highest crest, and which loops were left too early."""
    count = len(size)
    seen, doubt = Seen.of(count), np.zeros(count, bool)
    at_crest = np.zeros(motion.output.shape)
    modes = _Modes.of(z, len(motion.delta))
    lanes, moved = np.arange(count), motion.delta
    state, k = np.zeros(motion.output.shape), np.zeros(count)
    state[-1] = 1.0
    for level in range(_LEVELS):
        stride = 2.0**level
        here = np.arange(len(lanes))
        waiting: list[Index] = []
        for _ in range(_MOST // _BLOCK):
            who = lanes[here]
            zs = _run(moved, state, here)
            ys = _along(motion.output[:, who] * sign[who], zs)
            us = _along(motion.effort[:, who], zs)
            if level == 0:
                _note_crests(seen, at_crest, parts, who, zs, sign[who], k[here])
            _note(seen, who, ys, size[who], k[here], stride)
            _note_effort(seen, who, us, k[here], stride)
            k[here] += _BLOCK * stride
            part = _Part.of(motion, sign, size, who)
            done, turning = modes.look(
                who, k[here], part, motion.effort[:, who], motion.at_rest[who], state[:, here], seen
            )
            on = ~done & (turning * 2 * stride <= _TURN)
            waiting.append(here[on])
            here = here[~done & ~on]
            if not len(here):
                break
        doubt[lanes[here]] = True
        keep = np.concatenate(waiting)
        if not len(keep):
            return seen, at_crest, doubt
        lanes, state, k = lanes[keep], state[:, keep], k[keep]
        moved = _twice(moved[:, :, keep])
    doubt[lanes] = True
    return seen, at_crest, doubt


def _twice(s: Array) -> Array:
    out = 2 * s
    for j in range(len(s)):
        out += s[:, j, None] * s[None, j]
    return out


def _run(moved: Array, state: Array, here: Index) -> Array:
    """Move the state over a block, in place, and return Z at its samples, (block, N, B)."""
    s, z = moved[:-1, :, here], state[:, here]
    zs = np.empty((_BLOCK, *z.shape))
    step = np.empty_like(z[:-1])
    part = np.empty_like(step)
    for at in zs:
        at[:] = z
        np.multiply(s[:, 0], z[0], out=step)
        for j in range(1, len(z)):
            np.multiply(s[:, j], z[j], out=part)
            step += part
        z[:-1] += step
    state[:, here] = z
    return zs


def _along(row: Array, zs: Array) -> Array:
    """Return a signal at each sample of a block, (block, B); zeros of its row cost nothing."""
    out = np.zeros((len(zs), zs.shape[2]))
    for j, weight in enumerate(row):
        if weight.any():
            out += weight * zs[:, j]
    return out


def _note_crests(
    seen: Seen, at_crest: Array, parts: list[Piece], who: Index, zs: Array, sign: Array, k: Array
) -> None:
    """Note which piece of which sample has the highest crest, and Z before it.

    Where the input changes within a sample the end of a piece may be a corner: ``piece`` and half.
    """
    for number, part in enumerate(parts):
        ends = [_along(row[:, who] * sign, zs) for row in (part.slope0, part.slope1)]
        if ((ends[0] > 0) & (ends[1] < 0)).any():
            values = [_along(row[:, who] * sign, zs) for row in (part.y0, part.y1)]
            span = (part.end - part.begin)[who]
            heights = estimate(*values, ends[0] * span, ends[1] * span)
            _note_crest(seen, at_crest, heights, float(number), who, zs, k)
    for number, part in enumerate(parts[:-1]):
        corner = _along(part.y1[:, who] * sign, zs)
        _note_crest(seen, at_crest, corner, number + 0.5, who, zs, k)


def _note_crest(
    seen: Seen, at_crest: Array, heights: Array, piece: float, who: Index, zs: Array, k: Array
) -> None:
    best = np.argmax(heights, axis=0)
    height = np.take_along_axis(heights, best[None, :], axis=0)[0]
    (new,) = np.nonzero(height > seen.crest[who])
    which = who[new]
    seen.crest[which] = height[new]
    seen.k_crest[which] = k[new] + best[new]
    seen.piece[which] = piece
    at_crest[:, which] = zs[best[new], :, new].T


def _between(
    motion: Motion, plant: Held, parts: list[Piece], sign: Array, seen: Seen, at_crest: Array
) -> tuple[Array, Array, Mask]:
    """Return (the highest value at all times, the time of it in samples, whether it is known)."""
    highest, when, known = seen.top.copy(), seen.k_top.copy(), np.ones(len(sign), bool)
    for number, part in enumerate(parts[:-1]):
        (who,) = np.nonzero((seen.piece == number + 0.5) & (seen.crest > highest))
        highest[who], when[who] = seen.crest[who], seen.k_crest[who] + part.end[who]
    (late,) = np.nonzero((seen.stride_top > 1) & (seen.k_top > 0))
    tries = [(np.nonzero(seen.piece == i)[0], part, None) for i, part in enumerate(parts)]
    tries += [(late, part, -1.0) for part in parts] + [(late, part, 0.0) for part in parts]
    for who, part, shift in tries:
        if not len(who):
            continue
        k = seen.k_crest[who] if shift is None else seen.k_top[who] + shift
        some = _Part(delta=motion.delta[:, :, who], output=motion.output[:, who], size=k)
        z = at_crest[:, who] if shift is None else some.state(k)
        height, after, sure = crest(only(plant, who), only(part, who), z, sign[who])
        known[who] &= sure
        if shift is not None and part is not parts[-1]:
            corner = np.sum(part.y1[:, who] * z, axis=0) * sign[who]
            after = np.where(corner > height, part.end[who], after)
            height = np.maximum(height, corner)
        higher = height > highest[who]
        highest[who] = np.where(higher, height, highest[who])
        when[who] = np.where(higher, k + after, when[who])
    return highest, when, known


def _note_effort(seen: Seen, who: Index, us: Array, k: Array, stride: float) -> None:
    for side, best, places, strides in (
        (1.0, seen.most, seen.k_most, seen.stride_most),
        (-1.0, seen.least, seen.k_least, seen.stride_least),
    ):
        reached = (side * us).max(axis=0)
        new = reached > side * best[who]
        if new.any():
            which = who[new]
            best[which] = side * reached[new]
            places[which] = k[new] + stride * np.argmax(side * us[:, new], axis=0)
            strides[which] = stride


def _note(seen: Seen, who: Index, ys: Array, size: Array, k: Array, stride: float) -> None:
    """Note what a block shows; k is its first sample."""
    before = seen.top[who]
    so_far = np.maximum.accumulate(ys, axis=0)
    top = so_far[-1]
    higher = top > before
    seen.k_top[who] = np.where(
        higher, k + stride * np.sum(so_far < top, axis=0), seen.k_top[who]
    )
    seen.stride_top[who] = np.where(higher, stride, seen.stride_top[who])
    for level, places, strides in (
        (_RISE[0], seen.k_10, seen.stride_10), (_RISE[1], seen.k_90, seen.stride_90),
    ):  # fmt: skip
        new = (before < level * size) & (top >= level * size)
        if new.any():
            which = who[new]
            places[which] = k[new] + stride * np.sum(
                so_far[:, new] < level * size[new], axis=0
            )
            strides[which] = stride
    seen.top[who] = np.maximum(before, top)
    seen.bottom[who] = np.minimum(seen.bottom[who], ys.min(axis=0))
    off = np.maximum.accumulate(np.abs(ys[::-1] - size), axis=0)
    _last(seen.k_out, seen.stride_out, who, off > _BAND * size, k, stride)
    if stride > 1:
        _last(seen.k_near, seen.stride_near, who, off > _CREST * _BAND * size, k, stride)


def _last(
    places: Array, strides: Array, who: Index, outside: Mask, k: Array, stride: float
) -> None:
    """Note the last sample at which something was outside; rows count back from the block's end."""
    count = np.sum(outside, axis=0)  # rows from the first outside one, seen from the end
    new = count > 0
    places[who[new]] = k[new] + stride * (count[new] - 1)
    strides[who[new]] = stride


@dataclass(frozen=True, slots=True, kw_only=True)
class _Modes:
    """Each loop's modes z = 1 + mu, and the weights that tell their amplitudes from n samples.

    With d_i the i-th difference of what moves, d_i = sum_m c_m mu_m^i, so that
    c_m = sum_i weights[m, i] d_i, Lagrange's polynomial through the other modes.
    turn  |log z|, shape (n, B);  creeping  which mode is the slowest and does not swing
    """

    turn: Array
    weights: Complex
    creeping: Mask
    end: Array

    @classmethod
    def of(cls, z: Complex, rows: int) -> "_Modes":
        decay, turn = -np.log(np.abs(z)), np.abs(np.log(z))
        slowest = np.min(decay, axis=0, initial=inf)
        mu = z - 1
        n = len(mu)
        weights = np.zeros((n, n, mu.shape[1]), complex)
        for m in range(n):
            weights[m, 0] = 1.0
            for other in range(n):
                if other != m:
                    apart = mu[m] - mu[other]
                    weights[m, 1:] = (weights[m, :-1] - mu[other] * weights[m, 1:]) / apart
                    weights[m, 0] *= -mu[other] / apart
        swings = np.abs(np.angle(z)) > 1e-9 * decay
        return cls(
            turn=turn, weights=weights, creeping=(decay == slowest) & ~swings,
            end=np.maximum(8.0, np.ceil(_QUIET / np.maximum(slowest, 1e-14)) + 4 * rows),
        )  # fmt: skip

    def look(
        self, who: Index, k: Array, part: "_Part", effort: Array, at_rest: Array, z: Array,
        seen: Seen,
    ) -> tuple[Mask, Array]:  # fmt: skip
        """Return (which loops can show nothing new, how fast what is left of each still turns)."""
        size, top, most, least = part.size, seen.top[who], seen.most[who], seen.least[who]
        of_y, of_u = self._amplitudes(who, part, [(part.output, size), (effort, at_rest)], z)
        total, higher = self._beyond(who, of_y)
        still = total < _NEAR * _BAND * size
        with np.errstate(invalid="ignore"):
            still &= (higher <= top - size) | (total <= _LOST * size)
            total, higher = self._beyond(who, of_u)
            _, lower = self._beyond(who, -of_u)
            reach = _LOST * np.maximum(np.abs(most), np.abs(least))
            still &= (total <= reach) | ((at_rest + higher <= most) & (at_rest - lower >= least))
        alive = (np.abs(of_y) > _LOST * size) | (np.abs(of_u) > reach)
        turning = np.max(np.where(alive, self.turn[:, who], 0.0), axis=0, initial=0.0)
        return still | (k > self.end[who]), turning

    def _amplitudes(
        self, who: Index, part: "_Part", signals: list[tuple[Array, Array]], z: Array
    ) -> list[Complex]:
        """Return each signal's share of each mode at Z, shape (n, B)."""
        found = [np.zeros((len(self.turn), len(who)), complex) for _ in signals]
        moved = z
        for i in range(len(self.turn)):
            for (row, rest), into in zip(signals, found, strict=True):
                difference = np.sum(row * moved, axis=0) - (0.0 if i else rest)
                into += self.weights[:, i, who] * difference
            moved = _moved(part.delta, moved)
        return found

    def _beyond(self, who: Index, shares: Complex) -> tuple[Array, Array]:
        """Return (a bound on what is left, a bound on how far it can go above its rest).

        What creeps from below outlives the others, and keeps what is left below if it is more.
        """
        sizes, creeping = np.abs(shares), self.creeping[:, who]
        total = np.sum(sizes, axis=0)
        slow = np.sum(np.where(creeping, shares.real, 0.0), axis=0)
        others = total - np.sum(np.where(creeping, sizes, 0.0), axis=0)
        return total, np.where(others <= -slow, 0.0, others + np.maximum(slow, 0.0))


def _closed_in(motion: Motion, sign: Array, size: Array, seen: Seen) -> None:
    """Close in on what was met at a stride of more than a sample, in place."""
    for level, places, strides in (
        (_RISE[0], seen.k_10, seen.stride_10), (_RISE[1], seen.k_90, seen.stride_90),
    ):  # fmt: skip
        (who,) = np.nonzero(strides > 1)
        if len(who):
            part = _Part.of(motion, sign, size, who)
            places[who] = 1 + part.last(
                places[who] - strides[who], strides[who],
                lambda p, z, level=level: p.y(z) < level * p.size,
            )[0]  # fmt: skip
    (who,) = np.nonzero(seen.stride_top > 1)
    if len(who):
        part = _Part.of(motion, sign, size, who)
        start = np.maximum(seen.k_top[who] - seen.stride_top[who], 0.0)
        k, z = part.last(start, 2 * seen.stride_top[who], lambda p, z: p.slope(z) > 0)
        seen.k_top[who], seen.top[who] = k + 1, part.y(part.after(z))
    for side, best, places, strides in (
        (1.0, seen.most, seen.k_most, seen.stride_most),
        (-1.0, seen.least, seen.k_least, seen.stride_least),
    ):
        (who,) = np.nonzero(strides > 1)
        if len(who):
            part = _Part(delta=motion.delta[:, :, who], output=side * motion.effort[:, who], size=size[who])
            start = np.maximum(places[who] - strides[who], 0.0)
            k, z = part.last(start, 2 * strides[who], lambda p, z: p.slope(z) > 0)
            best[who] = side * np.maximum(part.y(part.after(z)), side * best[who])
    (who,) = np.nonzero((seen.stride_near > 1) & (seen.k_near > seen.k_out))
    if len(who):
        _crests(_Part.of(motion, sign, size, who), who, seen)
    (who,) = np.nonzero(seen.stride_out > 1)
    if len(who):
        part = _Part.of(motion, sign, size, who)
        seen.k_out[who] = part.last(
            seen.k_out[who], seen.stride_out[who], lambda p, z: p.off(z) > _BAND * p.size
        )[0]


def _crests(part: "_Part", who: Index, seen: Seen) -> None:
    """Move the last sample outside the band to a crest that the long stride stepped over."""
    stride = seen.stride_near[who]  # the crest is at most 0.4 rad, or one stride, before
    start = np.maximum(seen.k_near[who] - 4 * stride, 0.0)
    side = np.sign(part.y(part.state(seen.k_near[who])) - part.size)
    k, z = part.last(start, 8 * stride, lambda p, z: p.slope(z) * side > 0)
    outside = (part.off(part.after(z)) > _BAND * part.size) & (k + 1 > seen.k_out[who])
    seen.k_out[who] = np.where(outside, k + 1, seen.k_out[who])
    seen.stride_out[who] = np.where(outside, 2 * stride, seen.stride_out[who])


@dataclass(frozen=True, slots=True, kw_only=True)
class _Part:
    """Some of the loops, looked at where a long stride met something."""

    delta: Array
    output: Array
    size: Array

    @classmethod
    def of(cls, motion: Motion, sign: Array, size: Array, who: Index) -> "_Part":
        return cls(
            delta=motion.delta[:, :, who], output=motion.output[:, who] * sign[who], size=size[who]
        )

    def y(self, z: Array) -> Array:
        return np.sum(self.output * z, axis=0)

    def off(self, z: Array) -> Array:
        return np.abs(self.y(z) - self.size)

    def slope(self, z: Array) -> Array:
        return np.sum(self.output * _moved(self.delta, z), axis=0)

    def after(self, z: Array) -> Array:
        return z + _moved(self.delta, z)

    def state(self, k: Array) -> Array:
        """Return Z at sample k, by squaring."""
        z, s, bits = np.zeros(self.output.shape), self.delta, k.astype(np.int64)
        z[-1] = 1.0
        while bits.any():
            z = np.where(bits & 1, z + _moved(s, z), z)
            bits >>= 1
            s = _twice(s)
        return z

    def last(
        self, start: Array, stride: Array, holds: Callable[["_Part", Array], Mask]
    ) -> tuple[Array, Array]:
        """Return (the last sample up to which ``holds`` does, less than start + stride; Z there)."""
        levels = int(np.log2(stride.max()))
        ladder = [self.delta]
        for _ in range(levels):
            ladder.append(_twice(ladder[-1]))
        k, z = start.copy(), self.state(start)
        for level in range(levels - 1, -1, -1):
            there = z + _moved(ladder[level], z)
            go = (2.0**level < stride) & holds(self, there)
            k, z = np.where(go, k + 2.0**level, k), np.where(go, there, z)
        return k, z


def _moved(s: Array, z: Array) -> Array:
    return np.einsum("ijb,jb->ib", s, z)
