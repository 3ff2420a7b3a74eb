"""The metrics of many step responses at once, at the samples.

Every sample is looked at while a mode lives that turns by more than a quarter of a radian in two
of them; then every second, every fourth, ..., the matrices being squared. What was met at a long
stride is closed in on by halving. A response is left as soon as what remains of its modes cannot
show anything new: see ``modes``.
"""

import numpy as np

from zoh.batch.arrays.between import Piece, estimate, pieces
from zoh.batch.arrays.closing import RISE, between, closed_in
from zoh.batch.arrays.crests import Passed
from zoh.batch.arrays.held import Held
from zoh.batch.arrays.look import Index, Part, Seen, along, twice
from zoh.batch.arrays.modes import Modes
from zoh.batch.arrays.motion import Motion
from zoh.batch.arrays.rows import Array, Complex, Mask
from zoh.batch.arrays.turns import Turns
from zoh.batch.tolerances import BAND, LEVELS, MOST, NOTHING, TURN

_BLOCK = 16  # samples between two looks at which loops are done


def step_metrics(
    motion: Motion, plant: Held, delay: int, z: Complex, dt: Array, reference: float = 1.0
) -> tuple[dict[str, Array], Mask]:
    """Return (the metrics by name, which loops had better be measured one by one).

    z  the closed loop's poles to a few digits, shape (n, B): see ``motion.poles``
    """
    size = np.abs(motion.final)
    sign = np.where(motion.final < 0, -1.0, 1.0)
    parts = pieces(plant, motion, delay)
    turns = Turns.of(plant, motion, parts, delay) if len(plant.before) > 2 else None
    seen, passed, at_crest, doubt = _followed(motion, parts, turns, sign, size, z)
    late = closed_in(motion, sign, size, seen, passed)
    over = seen.top / size - 1
    most, least = np.maximum(seen.most, motion.at_rest), np.minimum(seen.least, motion.at_rest)
    reach = abs(reference)
    highest, when, known = between(plant, parts, sign, size, seen, at_crest, late, turns)
    beyond = highest / size - 1
    return {
        "between.overshoot_pct": np.where(beyond > NOTHING, 100 * beyond, 0.0),
        "between.peak_time": np.where(beyond > NOTHING, when * dt, np.nan),
        "overshoot_pct": np.where(over > NOTHING, 100 * over, 0.0),
        "rise_time": (seen.k_90 - seen.k_10) * dt,
        "settling_time": (seen.k_out + 1) * dt,
        "peak": np.maximum(seen.top, size) * reach,
        "peak_time": np.where(over > NOTHING, seen.k_top * dt, np.nan),
        "steady_state_error": (1 - motion.final) * reference,
        "peak_effort": np.maximum(most, -least) * reach,
    }, doubt | ~known | (size == 0)


def _followed(
    motion: Motion, parts: list[Piece], turns: Turns | None, sign: Array, size: Array, z: Complex
) -> tuple[Seen, Passed, Array, Mask]:
    """Return what was seen, what passed, Z before the highest crest, and which were left early."""
    count = len(size)
    seen, passed, doubt = Seen.of(count), Passed.of(count), np.zeros(count, bool)
    at_crest = np.zeros(motion.output.shape)
    modes = Modes.of(z, len(motion.delta))
    lanes, moved = np.arange(count), motion.delta
    state, k = motion.start.copy(), np.zeros(count)
    for level in range(LEVELS):
        stride = 2.0**level
        here = np.arange(len(lanes))
        waiting: list[Index] = []
        for _ in range(MOST // _BLOCK):
            who = lanes[here]
            zs = _run(moved, state, here)
            ys = _along(motion.output[:, who] * sign[who], zs)
            us = _along(motion.effort[:, who], zs)
            if level == 0:
                if turns is None:
                    _note_crests(seen, at_crest, parts, who, zs, sign[who], k[here])
                corners = _note_corners(seen, at_crest, parts, who, zs, sign[who], k[here])
            _note(seen, who, ys, size[who], k[here], stride)
            if level == 0 and turns is not None:
                after = along(motion.output[:, who] * sign[who], state[:, here])
                ends = np.concatenate([ys, after[None]])
                top = np.maximum(seen.top[who], size[who] * (1 + NOTHING))
                turns.note(who, zs, us, ends, corners, k[here], top)
            _note_effort(seen, who, us)
            passed.note(who, ys, us, k[here], stride, size[who], seen)
            k[here] += _BLOCK * stride
            part = Part.of(motion, sign, size, who)
            done, turning = modes.look(
                who, k[here], part, motion.effort[:, who], motion.at_rest[who], state[:, here], seen
            )
            on = ~done & (turning * 2 * stride <= TURN)
            waiting.append(here[on])
            here = here[~done & ~on]
            if not len(here):
                break
        doubt[lanes[here]] = True
        keep = np.concatenate(waiting)
        if not len(keep):
            return seen, passed, at_crest, doubt
        lanes, state, k = lanes[keep], state[:, keep], k[keep]
        moved = twice(moved[:, :, keep])
    doubt[lanes] = True
    return seen, passed, at_crest, doubt


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
    """Note which piece of which sample has the highest crest, and Z before it."""
    for number, part in enumerate(parts):
        ends = [_along(row[:, who] * sign, zs) for row in (part.slope0, part.slope1)]
        if ((ends[0] > 0) & (ends[1] < 0)).any():
            y0, y1 = (_along(row[:, who] * sign, zs) for row in (part.y0, part.y1))
            span = (part.end - part.begin)[who]
            heights = estimate(y0, y1, ends[0] * span, ends[1] * span)
            _note_crest(seen, at_crest, heights, float(number), who, zs, k)


def _note_corners(
    seen: Seen, at_crest: Array, parts: list[Piece], who: Index, zs: Array, sign: Array, k: Array
) -> Array | None:
    """Note the highest corner, and return all of them.

    There the input changes within a sample, and the end of a piece is: ``piece`` and a half.
    """
    corner = None
    for number, part in enumerate(parts[:-1]):
        corner = _along(part.y1[:, who] * sign, zs)
        _note_crest(seen, at_crest, corner, number + 0.5, who, zs, k)
    return corner


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


def _note_effort(seen: Seen, who: Index, us: Array) -> None:
    seen.most[who] = np.maximum(seen.most[who], us.max(axis=0))
    seen.least[who] = np.minimum(seen.least[who], us.min(axis=0))


def _note(seen: Seen, who: Index, ys: Array, size: Array, k: Array, stride: float) -> None:
    """Note what a block shows; k is its first sample."""
    before = seen.top[who]
    so_far = np.maximum.accumulate(ys, axis=0)
    top = so_far[-1]
    higher = top > before
    seen.k_top[who] = np.where(higher, k + stride * np.sum(so_far < top, axis=0), seen.k_top[who])
    for level, places, strides in (
        (RISE[0], seen.k_10, seen.stride_10), (RISE[1], seen.k_90, seen.stride_90),
    ):  # fmt: skip
        new = (before < level * size) & (top >= level * size)
        if new.any():
            which = who[new]
            places[which] = k[new] + stride * np.sum(so_far[:, new] < level * size[new], axis=0)
            strides[which] = stride
    seen.top[who] = np.maximum(before, top)
    off = np.maximum.accumulate(np.abs(ys[::-1] - size), axis=0)
    _last(seen.k_out, seen.stride_out, who, off > BAND * size, k, stride)


def _last(
    places: Array, strides: Array, who: Index, outside: Mask, k: Array, stride: float
) -> None:
    """Note the last sample at which something was outside; rows count back from the block's end."""
    count = np.sum(outside, axis=0)  # rows from the first outside one, seen from the end
    new = count > 0
    places[who[new]] = k[new] + stride * (count[new] - 1)
    strides[who[new]] = stride
