"""What a long stride has met of many responses, closed in on by halving; the highest between."""

from functools import partial

import numpy as np

from zoh.batch.arrays.between import Piece, crest
from zoh.batch.arrays.crests import Late, Passed, earlier, highest, later
from zoh.batch.arrays.held import Held
from zoh.batch.arrays.look import Part, Seen, Suspects
from zoh.batch.arrays.motion import Motion
from zoh.batch.arrays.rows import Array, Index, Mask, only, taken
from zoh.batch.arrays.turns import Turns
from zoh.batch.tolerances import NOTHING

RISE = (0.1, 0.9)
_AT_ONCE = 4096  # crests: of so many the series are worked out at a time
Try = tuple[Index, Piece, Array, Array]  # of which loops, a piece, its sample, Z there


def closed_in(motion: Motion, sign: Array, size: Array, seen: Seen, passed: Passed) -> Late:
    """Close in on what was met at a stride of more than a sample, in place; return its crests."""
    for level, places, strides in (
        (RISE[0], seen.k_10, seen.stride_10), (RISE[1], seen.k_90, seen.stride_90),
    ):  # fmt: skip
        (who,) = np.nonzero(strides > 1)
        if len(who):
            part, below = Part.of(motion, sign, size, who), partial(_below, level)
            places[who] = 1 + part.last(places[who] - strides[who], places[who], below)[0]
        earlier(motion, sign, size, passed, level, places)
    (who,) = np.nonzero(seen.stride_out > 1)
    if len(who):
        part, last = Part.of(motion, sign, size, who), seen.k_out[who]
        seen.k_out[who] = part.last(last, last + seen.stride_out[who], Part.out)[0]
    later(motion, sign, size, seen, passed)
    return highest(motion, sign, size, seen, passed)


def _below(level: float, part: Part, z: Array) -> Mask:
    return part.y(z) < level * part.size


def between(
    plant: Held, parts: list[Piece], sign: Array, size: Array, seen: Seen,
    met: list[list[Suspects]], late: Late, turns: Turns | None,
) -> tuple[Array, Array, Mask]:  # fmt: skip
    """Return (the highest value at all times, the time of it in samples, whether it is known)."""
    top, when, known = seen.top.copy(), seen.k_top.copy(), np.ones(len(sign), bool)
    tries: list[Try] = []
    for part, found in zip(parts, met, strict=True):
        crests = Suspects.above(found, len(late.z), np.maximum(top, seen.crest))
        tries.append((crests.who, part, crests.k, crests.z))
        tries.append((late.who, part, late.k, late.z))
        tries.append((late.who, part, late.k + 1, late.after))
    for who, part, k, z in tries:
        for first in range(0, len(who), _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            one = who[some], part, k[some], z[:, some]
            _tried(plant, one, part is not parts[-1], sign, top, when, known)
    if turns is not None:
        hidden = turns.above(np.maximum(top, size * (1 + NOTHING)))
        for part in parts:
            one = hidden.who, part, hidden.k, hidden.z
            _tried(plant, one, part is not parts[-1], sign, top, when, known)
    return top, when, known


def _tried(
    plant: Held, one: Try, corner: bool, sign: Array, top: Array, when: Array, known: Mask
) -> None:
    """Raise the highest values to those of a piece of some samples, in place.

    corner  whether the piece ends within the sample
    """
    who, part, k, z = one
    if not len(who):
        return
    height, after, sure = crest(only(plant, who), only(part, who), z, sign[who])
    np.logical_and.at(known, who, sure)
    if corner:
        end = np.sum(taken(part.y1, who) * z, axis=0) * sign[who]
        after = np.where(end > height, part.end[who], after)
        height = np.maximum(height, end)
    order = np.argsort(height)  # of two of one loop the higher is written last
    order = order[height[order] > top[who[order]]]
    top[who[order]], when[who[order]] = height[order], (k + after)[order]
