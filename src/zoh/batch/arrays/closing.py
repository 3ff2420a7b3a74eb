"""What a long stride has met of many responses, closed in on by halving; the highest between."""

from functools import partial

import numpy as np

from zoh.batch.arrays.between import Piece, crest
from zoh.batch.arrays.held import Held
from zoh.batch.arrays.look import Index, Part, Seen
from zoh.batch.arrays.motion import Motion
from zoh.batch.arrays.rows import Array, Mask, only
from zoh.batch.tolerances import BAND

RISE = (0.1, 0.9)


def closed_in(motion: Motion, sign: Array, size: Array, seen: Seen) -> None:
    """Close in on what was met at a stride of more than a sample, in place."""
    for level, places, strides in (
        (RISE[0], seen.k_10, seen.stride_10), (RISE[1], seen.k_90, seen.stride_90),
    ):  # fmt: skip
        (who,) = np.nonzero(strides > 1)
        if len(who):
            part = Part.of(motion, sign, size, who)
            below = partial(_below, level)
            places[who] = 1 + part.last(places[who] - strides[who], strides[who], below)[0]
    (who,) = np.nonzero(seen.stride_top > 1)
    if len(who):
        part = Part.of(motion, sign, size, who)
        start = np.maximum(seen.k_top[who] - seen.stride_top[who], 0.0)
        k, z = part.last(start, 2 * seen.stride_top[who], lambda p, z: p.slope(z) > 0)
        seen.k_top[who], seen.top[who] = k + 1, part.y(part.after(z))
    for side, best, places, strides in (
        (1.0, seen.most, seen.k_most, seen.stride_most),
        (-1.0, seen.least, seen.k_least, seen.stride_least),
    ):
        (who,) = np.nonzero(strides > 1)
        if len(who):
            part = Part(
                delta=motion.delta[:, :, who], output=side * motion.effort[:, who], size=size[who]
            )
            start = np.maximum(places[who] - strides[who], 0.0)
            k, z = part.last(start, 2 * strides[who], lambda p, z: p.slope(z) > 0)
            best[who] = side * np.maximum(part.y(part.after(z)), side * best[who])
    (who,) = np.nonzero((seen.stride_near > 1) & (seen.k_near > seen.k_out))
    if len(who):
        _crests(Part.of(motion, sign, size, who), who, seen)
    (who,) = np.nonzero(seen.stride_out > 1)
    if len(who):
        part = Part.of(motion, sign, size, who)
        seen.k_out[who] = part.last(
            seen.k_out[who], seen.stride_out[who], lambda p, z: p.off(z) > BAND * p.size
        )[0]


def _crests(part: Part, who: Index, seen: Seen) -> None:
    """Move the last sample outside the band to a crest that the long stride stepped over."""
    stride = seen.stride_near[who]  # the crest is at most 0.4 rad, or one stride, before
    start = np.maximum(seen.k_near[who] - 4 * stride, 0.0)
    side = np.sign(part.y(part.state(seen.k_near[who])) - part.size)
    k, z = part.last(start, 8 * stride, lambda p, z: p.slope(z) * side > 0)
    outside = (part.off(part.after(z)) > BAND * part.size) & (k + 1 > seen.k_out[who])
    seen.k_out[who] = np.where(outside, k + 1, seen.k_out[who])
    seen.stride_out[who] = np.where(outside, 2 * stride, seen.stride_out[who])


def _below(level: float, part: Part, z: Array) -> Mask:
    return part.y(z) < level * part.size


def between(
    motion: Motion, plant: Held, parts: list[Piece], sign: Array, seen: Seen, at_crest: Array
) -> tuple[Array, Array, Mask]:
    """Return (the highest value at all times, the time of it in samples, whether it is known)."""
    highest, when, known = seen.top.copy(), seen.k_top.copy(), np.ones(len(sign), bool)
    for number, part in enumerate(parts[:-1]):
        (who,) = np.nonzero((seen.piece == number + 0.5) & (seen.crest > highest))
        highest[who], when[who] = seen.crest[who], seen.k_crest[who] + part.end[who]
    (late,) = np.nonzero((seen.stride_top > 1) & (seen.k_top > 0))
    tries: list[tuple[Index, Piece, float | None]] = [
        (np.nonzero(seen.piece == i)[0], part, None) for i, part in enumerate(parts)
    ]
    tries += [(late, part, -1.0) for part in parts] + [(late, part, 0.0) for part in parts]
    for who, part, shift in tries:
        if not len(who):
            continue
        k = seen.k_crest[who] if shift is None else seen.k_top[who] + shift
        some = Part(delta=motion.delta[:, :, who], output=motion.output[:, who], size=k)
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
