"""A block at a stride of many samples; what it meets is closed in on at once by halving."""

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.between import Pieces, crest
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.motion import Motion
from zoh.batch.compiled.plant import Plant
from zoh.batch.compiled.track import (
    BEFORE,
    BLOCK,
    FOUND,
    HIGHEST,
    K1,
    K2,
    K_10,
    K_90,
    K_OUT,
    K_TOP,
    LAST,
    LEAST_U,
    MOST_U,
    NEXT,
    OTHER,
    THERE,
    TOP,
    U1,
    U2,
    WHEN,
    Y1,
    Y2,
    Z,
    along,
    last,
    move,
    pass_on,
)
from zoh.batch.tolerances import BAND, CREST


@compiled
def long_stride(
    m: Motion, p: Plant, pieces: Pieces, count: int, n: int, ladder: Array, level: int, zs: Array,
    seen: Array, sign: float, full: float, k: float, size: int,
) -> bool:  # fmt: skip
    """Look at a block at a stride of 2^level; return whether a crest between is not known."""
    stride, unknown = 2.0**level, False
    z = zs[Z]
    for i in range(BLOCK):
        here = k + i * stride
        y, u = sign * along(m.output, z, size), along(m.effort, z, size)
        y1, y2, u1, u2 = seen[Y1], seen[Y2], seen[U1], seen[U2]
        before, start = seen[K1], seen[K2]
        if seen[TOP] < 0.1 * full <= y:
            seen[K_10] = 1.0 + last(m.output, -sign, -0.1 * full, ladder, level, zs, LAST, before,
                                    here, size)  # fmt: skip
        if seen[TOP] < 0.9 * full <= y:
            seen[K_90] = 1.0 + last(m.output, -sign, -0.9 * full, ladder, level, zs, LAST, before,
                                    here, size)  # fmt: skip
        side = 1.0 if y1 > full else -1.0
        off1, off2 = side * (y1 - full), side * (y2 - full)
        if off1 > BAND * full >= abs(y - full):
            seen[K_OUT] = last(m.output, side * sign, (BAND + side) * full, ladder, level, zs,
                               LAST, before, here, size)  # fmt: skip
        if y1 >= y2 and y1 > y and y1 > seen[TOP] - 0.02 * full:
            lost = crest_of_y(
                m, p, pieces, count, n, ladder, level, zs, seen, sign, start, here, size
            )
            unknown = unknown or lost
        if off1 >= off2 and off1 > side * (y - full) and off1 > CREST * BAND * full:
            crest_of_band(m, ladder, level, zs, seen, sign, full, side, start, here, size)
        for way in (1.0, -1.0):
            place = MOST_U if way > 0.0 else LEAST_U
            if (
                way * (u1 - u2) >= 0.0
                and way * (u1 - u) > 0.0
                and (way * u1 > way * seen[place] - 0.02 * abs(u1))
            ):
                last(m.effort_moves, way, 0.0, ladder, level + 1, zs, BEFORE, start, here, size)
                move(ladder[0], zs[FOUND], size, zs[THERE])
                seen[place] = way * max(way * seen[place], way * along(m.effort, zs[THERE], size))
        if y > seen[TOP]:
            seen[TOP], seen[K_TOP] = y, here
        seen[MOST_U], seen[LEAST_U] = max(seen[MOST_U], u), min(seen[LEAST_U], u)
        if abs(y - full) > BAND * full:
            seen[K_OUT] = here
        pass_on(z, zs, seen, y, u, here, size)
        move(ladder[level], z, size, zs[NEXT])
        for j in range(size):
            z[j] = zs[NEXT, j]
    return unknown


@compiled
def crest_of_y(
    m: Motion, p: Plant, pieces: Pieces, count: int, n: int, ladder: Array, level: int, zs: Array,
    seen: Array, sign: float, k: float, end: float, size: int,
) -> bool:  # fmt: skip
    """Close in on a crest, also between the samples; return whether that is not known."""
    k = last(m.output_moves, sign, 0.0, ladder, level + 1, zs, BEFORE, k, end, size)
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


@compiled
def crest_of_band(
    m: Motion, ladder: Array, level: int, zs: Array, seen: Array, sign: float, full: float,
    side: float, k: float, end: float, size: int,
) -> None:  # fmt: skip
    """Note where the band is left for less than a stride."""
    k = last(m.output_moves, side * sign, 0.0, ladder, level + 1, zs, BEFORE, k, end, size)
    move(ladder[0], zs[FOUND], size, zs[THERE])
    if side * (sign * along(m.output, zs[THERE], size) - full) > BAND * full:
        for j in range(size):
            zs[OTHER, j] = zs[THERE, j]
        row, most = m.output, (BAND + side) * full
        seen[K_OUT] = last(row, side * sign, most, ladder, level + 1, zs, OTHER, k + 1.0, end, size)
