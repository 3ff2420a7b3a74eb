"""The metrics of many step responses at once, at the samples.

Every sample is looked at while a mode lives that turns by more than a quarter of a radian in two
of them; then every second, every fourth, ..., the matrices being squared. What was met at a long
stride is closed in on by halving. A response is left as soon as what remains of its modes cannot
show anything new: see ``modes``.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from zoh.batch.arrays.between import Piece, doubtful, estimate, pieces
from zoh.batch.arrays.closing import RISE, between, closed_in
from zoh.batch.arrays.crests import Passed
from zoh.batch.arrays.held import Held
from zoh.batch.arrays.look import Seen, Suspects, twice
from zoh.batch.arrays.modes import Modes, restless
from zoh.batch.arrays.motion import Motion
from zoh.batch.arrays.rows import Array, Complex, Index, Mask, joined, only, taken
from zoh.batch.arrays.turns import Turns
from zoh.batch.tolerances import BAND, FAINT, LEVELS, MOST, NOTHING, TURN

_BLOCK = 16  # samples between two looks at which loops are done
_PLACES = np.arange(1, _BLOCK + 1, dtype=np.int8)  # small numbers, which are quickly compared


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
    rough = (plant.markov[0] != 0) & (len(plant.before) > 1)
    seen, passed, met, doubt = _followed(motion, parts, turns, sign, size, z, rough)
    late = closed_in(motion, sign, size, seen, passed)
    over = seen.top / size - 1
    most, least = np.maximum(seen.most, motion.at_rest), np.minimum(seen.least, motion.at_rest)
    reach = abs(reference)
    highest, when, known = between(plant, parts, sign, size, seen, met, late, turns)
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
    }, doubt | restless(z) | ~known | (size < FAINT)


@dataclass(frozen=True, slots=True, kw_only=True)
class UnderWay:
    """Responses that are still followed: which, the sample they are at, how they go on from it.

    state    Z, shape (N, B);  moved, delta  by what it moves in a stride, in a sample
    signals  rows on Z, shape (2, N, B), of y in the direction of its final value, and of u
    rest     what they settle to, shape (2, B)
    """

    who: Index
    k: Array
    state: Array
    moved: Array
    delta: Array
    signals: Array
    rest: Array

    @classmethod
    def of(cls, motion: Motion, sign: Array, size: Array) -> "UnderWay":
        """Return all of them, before their first sample."""
        return cls(
            who=np.arange(len(size)), k=np.zeros(len(size)), state=motion.start,
            moved=motion.delta, delta=motion.delta,
            signals=np.stack([motion.output * sign, motion.effort]),
            rest=np.stack([size, motion.at_rest]),
        )  # fmt: skip


def _followed(
    motion: Motion,
    parts: list[Piece],
    turns: Turns | None,
    sign: Array,
    size: Array,
    z: Complex,
    rough: Mask,
) -> tuple[Seen, Passed, list[list[Suspects]], Mask]:
    """Return what was seen, what passed, crests in each part, and which loops were left early.

    rough  where the slope leaps at each sample, so that any may have a crest: all are looked at
    """
    seen, passed, doubt = Seen.of(len(size)), Passed.of(len(size)), np.zeros(len(size), bool)
    met: list[list[Suspects]] = [[] for _ in parts]
    modes, way = Modes.of(z, len(motion.delta)), UnderWay.of(motion, sign, size)
    for level in range(LEVELS):
        stride = 2.0**level
        waiting: list[UnderWay] = []
        for _ in range(MOST // _BLOCK):
            who, k = way.who, way.k
            zs, state = _run(way.moved, way.state)
            ys, us = (_along(row, zs) for row in way.signals)
            if level == 0:
                if turns is None:
                    _note_crests(seen, met, parts, who, zs, sign[who], k)
                corners = _note_corners(seen, met, parts, who, zs, sign[who], k)
            highest = seen.top[who]
            _note(seen, who, ys, size[who], k, stride)
            if level == 0 and turns is not None:
                after = np.sum(way.signals[0] * state, axis=0)
                ends = np.concatenate([ys, after[None]])
                top = np.maximum(seen.top[who], size[who] * (1 + NOTHING))
                turns.note(who, zs, us, ends, corners, k, top)
            _note_effort(seen, who, us)
            passed.note(who, ys, us, k, stride, size[who], highest, seen)
            way = replace(way, state=state, k=k + _BLOCK * stride)
            done, turning = modes.look(who, way.k, way.delta, way.signals, way.rest, state, seen)
            slow = (turning * 2 * stride <= TURN) & ~rough[who]
            waiting.append(only(way, np.flatnonzero(~done & slow)))
            way = only(way, np.flatnonzero(~done & ~slow))
            if not len(way.who):
                break
        doubt[way.who] = True
        way = joined(waiting)
        if not len(way.who):
            return seen, passed, met, doubt
        way = replace(way, moved=twice(way.moved))
    doubt[way.who] = True
    return seen, passed, met, doubt


def _run(s: Array, z: Array) -> tuple[Array, Array]:
    """Return Z at the samples of a block, shape (block, N, B), and Z after it."""
    zs = np.empty((_BLOCK + 1, *z.shape))
    zs[0], zs[:, -1] = z, z[-1]  # the one that Z ends with stays
    step = np.empty_like(z[:-1])
    for here, there in pairwise(zs):
        np.einsum("ijb,jb->ib", s[:-1], here, out=step)
        np.add(here[:-1], step, out=there[:-1])
    return zs[:-1], zs[-1]


def _along(row: Array, zs: Array) -> Array:
    """Return a signal at each sample of a block, (block, B); zeros about its row cost nothing."""
    used = np.flatnonzero(row.any(axis=1))
    part = slice(used[0], used[-1] + 1) if len(used) else slice(0)
    out: Array = np.einsum("jb,kjb->kb", row[part], zs[:, part])
    return out


def _note_crests(
    seen: Seen, met: list[list[Suspects]], parts: list[Piece], who: Index, zs: Array, sign: Array,
    k: Array,
) -> None:  # fmt: skip
    """Note the crests in each piece of each sample that may be the highest."""
    for part, found in zip(parts, met, strict=True):
        first, last = (_along(taken(row, who) * sign, zs) for row in (part.slope0, part.slope1))
        row, lane = np.nonzero((first > 0) & (last < 0))
        if len(lane):
            z, these, up = zs[row, :, lane].T, who[lane], sign[lane]
            y0, y1 = (np.sum(taken(y, these) * z, axis=0) * up for y in (part.y0, part.y1))
            span = (part.end - part.begin)[these]
            slopes = first[row, lane] * span, last[row, lane] * span
            height = estimate(y0, y1, *slopes)
            off = doubtful(part.reach[these], *slopes)
            _note_crest(seen, found, height - off, height + off, these, z, k[lane] + row)


def _note_corners(
    seen: Seen, met: list[list[Suspects]], parts: list[Piece], who: Index, zs: Array, sign: Array,
    k: Array,
) -> Array | None:  # fmt: skip
    """Note the highest corner, where the input changes within a sample, and return all of them."""
    corner = None
    for part, found in zip(parts[:-1], met[:-1], strict=True):
        corner = _along(taken(part.y1, who) * sign, zs)
        best = np.argmax(corner, axis=0)
        height = np.take_along_axis(corner, best[None, :], axis=0)[0]
        z = zs[best, :, np.arange(len(who))].T
        _note_crest(seen, found, height, height, who, z, k + best)
    return corner


def _note_crest(
    seen: Seen, found: list[Suspects], least: Array, most: Array, who: Index, z: Array, k: Array
) -> None:
    np.maximum.at(seen.crest, who, least)
    (may,) = np.nonzero(most >= np.maximum(seen.crest, seen.top)[who])
    if len(may):
        found.append(Suspects(who=who[may], k=k[may], z=taken(z, may), bound=most[may]))


def _note_effort(seen: Seen, who: Index, us: Array) -> None:
    seen.most[who] = np.maximum(seen.most[who], us.max(axis=0))
    seen.least[who] = np.minimum(seen.least[who], us.min(axis=0))


def _note(seen: Seen, who: Index, ys: Array, size: Array, k: Array, stride: float) -> None:
    """Note what a block shows; k is its first sample."""
    before, top = seen.top[who], ys.max(axis=0)
    (higher,) = np.nonzero(top > before)
    first = _first(taken(ys, higher) == top[higher])
    seen.k_top[who[higher]] = k[higher] + stride * first
    for level, places, strides in (
        (RISE[0], seen.k_10, seen.stride_10), (RISE[1], seen.k_90, seen.stride_90),
    ):  # fmt: skip
        (new,) = np.nonzero((before < level * size) & (top >= level * size))
        first = _first(taken(ys, new) >= level * size[new])
        places[who[new]] = k[new] + stride * first
        strides[who[new]] = stride
    seen.top[who] = np.maximum(before, top)
    last = np.max((np.abs(ys - size) > BAND * size) * _PLACES[:, None], axis=0)
    (new,) = np.nonzero(last)
    seen.k_out[who[new]] = k[new] + stride * (last[new] - 1)
    seen.stride_out[who[new]] = stride


def _first(holds: Mask) -> Index:
    """Return the first row that holds, of columns in which one does."""
    return np.asarray(_BLOCK - np.max(holds * _PLACES[::-1, None], axis=0))
