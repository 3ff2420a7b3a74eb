"""What a long stride has met of many responses, closed in on by halving; the highest between."""

from functools import partial

import numpy as np

from zoh.batch.arrays.between import Piece, crest
from zoh.batch.arrays.crests import Late, Passed, highest, outside
from zoh.batch.arrays.held import Held
from zoh.batch.arrays.look import Part, Seen
from zoh.batch.arrays.motion import Motion
from zoh.batch.arrays.rows import Array, Index, Mask, only, taken

RISE = (0.1, 0.9)


def closed_in(motion: Motion, sign: Array, size: Array, seen: Seen, passed: Passed) -> Late:
    """Close in on what was met at a stride of more than a sample, in place; return its crests."""
    for level, places, strides in (
        (RISE[0], seen.k_10, seen.stride_10), (RISE[1], seen.k_90, seen.stride_90),
    ):  # fmt: skip
        (who,) = np.nonzero(strides > 1)
        if len(who):
            part, below = Part.of(motion, sign, size, who), partial(_below, level)
            places[who] = 1 + part.last(places[who] - strides[who], places[who], below)[0]
    (who,) = np.nonzero(seen.stride_out > 1)
    if len(who):
        part, last = Part.of(motion, sign, size, who), seen.k_out[who]
        seen.k_out[who] = part.last(last, last + seen.stride_out[who], Part.out)[0]
    outside(motion, sign, size, seen, passed)
    return highest(motion, sign, size, seen, passed)


def _below(level: float, part: Part, z: Array) -> Mask:
    return part.y(z) < level * part.size


def between(
    plant: Held, parts: list[Piece], sign: Array, seen: Seen, at_crest: Array, late: Late
) -> tuple[Array, Array, Mask]:
    """Return (the highest value at all times, the time of it in samples, whether it is known)."""
    top, when, known = seen.top.copy(), seen.k_top.copy(), np.ones(len(sign), bool)
    tries: list[tuple[Index, Piece, Array, Array]] = []
    for number, part in enumerate(parts):
        (who,) = np.nonzero((seen.piece == number + 0.5) & (seen.crest > top))
        top[who], when[who] = seen.crest[who], seen.k_crest[who] + part.end[who]
        (who,) = np.nonzero(seen.piece == number)
        tries.append((who, part, seen.k_crest[who], taken(at_crest, who)))
        tries.append((late.who, part, late.k, late.z))
        tries.append((late.who, part, late.k + 1, late.after))
    for who, part, k, z in tries:
        if not len(who):
            continue
        height, after, sure = crest(only(plant, who), only(part, who), z, sign[who])
        np.logical_and.at(known, who, sure)
        if part is not parts[-1]:
            corner = np.sum(taken(part.y1, who) * z, axis=0) * sign[who]
            after = np.where(corner > height, part.end[who], after)
            height = np.maximum(height, corner)
        order = np.argsort(height)  # of two of one loop the higher is written last
        order = order[height[order] > top[who[order]]]
        top[who[order]], when[who[order]] = height[order], (k + after)[order]
    return top, when, known
