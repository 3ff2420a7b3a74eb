"""A block at a stride of many samples; what it meets is closed in on at once by halving."""

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.between import Pieces, crest
from zoh.batch.compiled.jit import shared
from zoh.batch.compiled.motion import Motion
from zoh.batch.compiled.plant import Plant
from zoh.batch.compiled.samples import shown
from zoh.batch.compiled.track import (
    BLOCK,
    FOUND,
    HIGHEST,
    K1,
    K2,
    K_10,
    K_90,
    K_OUT,
    K_TOP,
    LEAST_U,
    MOST_U,
    PAST,
    THERE,
    TOP,
    WHEN,
    U,
    Y,
    along,
    last,
    move,
    take,
)
from zoh.batch.tolerances import BAND, BELOW, CREST


@shared
def long_stride(
    m: Motion, p: Plant, pieces: Pieces, count: int, n: int, ladder: Array, level: int,
    block: Array, zs: Array, seen: Array, sign: float, full: float, k: float, size: int,
) -> bool:  # fmt: skip
    """Look at a block at a stride of 2^level; return whether a crest between is not known."""
    shown(m.output, sign, block, Y, size)
    shown(m.effort, 1.0, block, U, size)
    ys, us = block[Y], block[U]
    stride, unknown = 2.0**level, False
    before, start = seen[K1], seen[K2]
    for i in range(PAST, PAST + BLOCK):
        here = k + (i - PAST) * stride
        y, y1, y2 = ys[i], ys[i - 1], ys[i - 2]
        u, u1, u2 = us[i], us[i - 1], us[i - 2]
        for part, place in ((0.1, K_10), (0.9, K_90)):
            if seen[TOP] < part * full <= y:
                take(block, i - 1, size, zs[FOUND])
                seen[place] = 1.0 + last(m.output, -sign, -part * full, ladder, level, zs, before,
                                         here, size)  # fmt: skip
        side = 1.0 if y1 > full else -1.0
        off1, off2 = side * (y1 - full), side * (y2 - full)
        if off1 > BAND * full >= abs(y - full):
            take(block, i - 1, size, zs[FOUND])
            seen[K_OUT] = last(m.output, side * sign, (BAND + side) * full, ladder, level, zs,
                               before, here, size)  # fmt: skip
        if y1 >= y2 and y1 > y and y1 > seen[TOP] - BELOW * full:
            take(block, i - 2, size, zs[FOUND])
            lost = crest_of_y(
                m, p, pieces, count, n, ladder, level, zs, seen, sign, start, here, size
            )
            unknown = unknown or lost
        if off1 >= off2 and off1 > side * (y - full) and off1 > CREST * BAND * full:
            take(block, i - 2, size, zs[FOUND])
            crest_of_band(m, ladder, level, zs, seen, sign, full, side, start, here, size)
        near = BELOW * abs(u1)
        if u1 >= u2 and u1 > u and u1 > seen[MOST_U] - near:
            take(block, i - 2, size, zs[FOUND])
            most = crest_of_u(m, ladder, level, zs, 1.0, start, here, size)
            seen[MOST_U] = max(seen[MOST_U], most)
        elif u1 <= u2 and u1 < u and u1 < seen[LEAST_U] + near:
            take(block, i - 2, size, zs[FOUND])
            least = crest_of_u(m, ladder, level, zs, -1.0, start, here, size)
            seen[LEAST_U] = min(seen[LEAST_U], least)
        if y > seen[TOP]:
            seen[TOP], seen[K_TOP] = y, here
        seen[MOST_U], seen[LEAST_U] = max(seen[MOST_U], u), min(seen[LEAST_U], u)
        if abs(y - full) > BAND * full:
            seen[K_OUT] = here
        before, start = here, before
    seen[K1], seen[K2] = before, start
    return unknown


@shared
def crest_of_u(
    m: Motion, ladder: Array, level: int, zs: Array, way: float, k: float, end: float, size: int
) -> float:
    """Return the effort at a crest or in a valley after FOUND."""
    last(m.effort_moves, way, 0.0, ladder, level + 1, zs, k, end, size)
    move(ladder[0], zs[FOUND], size, zs[THERE])
    return along(m.effort, zs[THERE], size)


@shared
def crest_of_y(
    m: Motion, p: Plant, pieces: Pieces, count: int, n: int, ladder: Array, level: int, zs: Array,
    seen: Array, sign: float, k: float, end: float, size: int,
) -> bool:  # fmt: skip
    """Close in on a crest, also between the samples; return whether that is not known."""
    k = last(m.output_moves, sign, 0.0, ladder, level + 1, zs, k, end, size)
    unknown = False
    for shift in range(2):
        for piece in range(count):
            height, after, known = crest(p, pieces, piece, n, zs[FOUND], sign, size)
            unknown = unknown or not known
            if piece + 1 < count:
                corner = sign * along(pieces.y1[piece], zs[FOUND], size)
                if corner > height:
                    height, after = corner, pieces.ends[piece + 1]
            if height > seen[HIGHEST]:
                seen[HIGHEST], seen[WHEN] = height, k + shift + after
        if shift == 0:
            move(ladder[0], zs[FOUND], size, zs[THERE])
            y = sign * along(m.output, zs[THERE], size)
            if y > seen[TOP]:
                seen[TOP], seen[K_TOP] = y, k + 1.0
            for j in range(size):
                zs[FOUND, j] = zs[THERE, j]
    return unknown


@shared
def crest_of_band(
    m: Motion, ladder: Array, level: int, zs: Array, seen: Array, sign: float, full: float,
    side: float, k: float, end: float, size: int,
) -> None:  # fmt: skip
    """Note where the band is left for less than a stride."""
    k = last(m.output_moves, side * sign, 0.0, ladder, level + 1, zs, k, end, size)
    move(ladder[0], zs[FOUND], size, zs[THERE])
    if side * (sign * along(m.output, zs[THERE], size) - full) > BAND * full:
        for j in range(size):
            zs[FOUND, j] = zs[THERE, j]
        row, most = m.output, (BAND + side) * full
        seen[K_OUT] = last(row, side * sign, most, ladder, level + 1, zs, k + 1.0, end, size)
