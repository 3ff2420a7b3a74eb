"""Z on its way: a block of samples at once, and what is seen of it; all in plain arrays.

A block holds Z by columns, in ``LANES`` of which the same is done: each doubling of its length
is one product with a power of the motion, so no sample waits for the one before.
"""

from math import inf

import numpy as np

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.room import BLOCK, DOUBLINGS, LANES, PAST, SEEN, WIDE

_1, _2, _3, _4, _5, _6, _7 = (np.uint64(i) for i in range(1, 8))  # places that are never < 0

# places of what is seen
(
    TOP, K_TOP, MOST_U, LEAST_U, K_10, K_90, K_OUT, HIGHEST, WHEN, CREST, K_CREST, PIECE, K1, K2,
) = range(14)  # fmt: skip
# places of the states that are kept
NEXT, AT_CREST, FOUND, THERE, OTHER = range(5)
# rows of a block behind Z: the output, its sign such that it rises; the effort; two slopes
Y, U, RISE, FALL = WIDE, WIDE + 1, WIDE + 2, WIDE + 3


@compiled
def along(row: Array, z: Array, size: int) -> float:
    """Return row z."""
    total = 0.0
    for j in range(size):
        total += row[j] * z[j]
    return total


@compiled
def product(
    weights: Array, factor: float, rows: Array, first: int, end: int, size: int, out: Array
) -> None:
    """Write factor weights rows from one place to another, a whole number of ``LANES``."""
    for i in range(first, end, LANES):
        at = np.uint64(i)
        a = b = c = d = e = f = g = h = 0.0
        for j in range(size):
            part = factor * weights[j]
            a += part * rows[j, at]
            b += part * rows[j, at + _1]
            c += part * rows[j, at + _2]
            d += part * rows[j, at + _3]
            e += part * rows[j, at + _4]
            f += part * rows[j, at + _5]
            g += part * rows[j, at + _6]
            h += part * rows[j, at + _7]
        out[at], out[at + _1], out[at + _2], out[at + _3] = a, b, c, d
        out[at + _4], out[at + _5], out[at + _6], out[at + _7] = e, f, g, h


@compiled
def move(s: Array, z: Array, size: int, out: Array) -> None:
    """Write z + s z, s by columns."""
    product(z, 1.0, s, 0, LANES if size <= LANES else WIDE, size, out)
    for i in range(size):
        out[i] += z[i]


@shared
def twice(w: int, level: int, size: int) -> None:
    """Write the level after this one: 2 s + s s, by columns."""
    t = work.track(w)
    if size == 4:  # of the usual sizes the compiler knows every place beforehand
        doubled(t.ladder[level], t.ladder[level + 1], 4)
    elif size == 5:
        doubled(t.ladder[level], t.ladder[level + 1], 5)
    else:
        doubled(t.ladder[level], t.ladder[level + 1], size)


@compiled
def doubled(s: Array, out: Array, size: int) -> None:
    """Write 2 s + s s, by columns."""
    for k in range(size):
        for first in range(0, LANES if size <= LANES else WIDE, LANES):
            at = np.uint64(first)
            a, b, c, d = s[k, at], s[k, at + _1], s[k, at + _2], s[k, at + _3]
            e, f, g, h = s[k, at + _4], s[k, at + _5], s[k, at + _6], s[k, at + _7]
            a, b, c, d, e, f, g, h = a + a, b + b, c + c, d + d, e + e, f + f, g + g, h + h
            for j in range(size):
                part = s[k, j]
                a += part * s[j, at]
                b += part * s[j, at + _1]
                c += part * s[j, at + _2]
                d += part * s[j, at + _3]
                e += part * s[j, at + _4]
                f += part * s[j, at + _5]
                g += part * s[j, at + _6]
                h += part * s[j, at + _7]
            out[k, at], out[k, at + _1], out[k, at + _2], out[k, at + _3] = a, b, c, d
            out[k, at + _4], out[k, at + _5], out[k, at + _6], out[k, at + _7] = e, f, g, h


@shared
def first_four(w: int, level: int, size: int) -> None:
    """Write Z at a block's first four samples, 2^level apart, from the first one."""
    if size == 4:
        begun(w, level, 4)
    elif size == 5:
        begun(w, level, 5)
    else:
        begun(w, level, size)


@compiled
def begun(w: int, level: int, size: int) -> None:
    """Do what ``first_four`` does; the one that Z ends with stays."""
    t = work.track(w)
    block, zs = t.block, t.states
    z0, z1, z2, z3 = zs[NEXT], zs[FOUND], zs[THERE], zs[OTHER]
    take(block, PAST, size, z0)
    move(t.ladder[level], z0, size, z1)
    move(t.ladder[level + 1], z0, size, z2)
    move(t.ladder[level + 1], z1, size, z3)
    for j in range(size - 1):
        block[j, PAST], block[j, PAST + 1] = z0[j], z1[j]
        block[j, PAST + 2], block[j, PAST + 3] = z2[j], z3[j]


@shared
def ahead(w: int, level: int, size: int) -> None:
    """Write Z at a block's samples, and the four after it, from its first four."""
    if size == 4:
        filled(w, level, 4)
    elif size == 5:
        filled(w, level, 5)
    else:
        filled(w, level, size)


@compiled
def filled(w: int, level: int, size: int) -> None:
    """Write Z at what follows the first four samples: at the next four, then at eight at a time."""
    t = work.track(w)
    s, block = t.ladder[level + DOUBLINGS], t.block
    four(t.ladder[level + DOUBLINGS - 1], block, PAST, 4, size)
    for first in range(PAST, PAST + BLOCK - LANES, LANES):
        four(s, block, first, LANES, size)
        four(s, block, first + 4, LANES, size)
    four(s, block, PAST + BLOCK - LANES, LANES, size)


@compiled
def four(s: Array, block: Array, first: int, length: int, size: int) -> None:
    """Write the columns so far after four; the one that Z ends with stays."""
    at, to = np.uint64(first), np.uint64(first + length)
    for i in range(size - 1):
        a, b, c, d = block[i, at], block[i, at + _1], block[i, at + _2], block[i, at + _3]
        for j in range(size):
            part = s[j, i]
            a += part * block[j, at]
            b += part * block[j, at + _1]
            c += part * block[j, at + _2]
            d += part * block[j, at + _3]
        block[i, to], block[i, to + _1], block[i, to + _2], block[i, to + _3] = a, b, c, d


@compiled
def go_on(block: Array, size: int) -> None:
    """Make what follows a block its first four samples, its last ones the past."""
    for j in range(size - 1):
        for i in range(PAST + 4):
            block[j, i] = block[j, BLOCK + i]
    for i in range(PAST):
        block[Y, i], block[U, i] = block[Y, BLOCK + i], block[U, BLOCK + i]


@compiled
def take(block: Array, column: int, size: int, out: Array) -> None:
    """Write Z at one column."""
    for j in range(size):
        out[j] = block[j, column]


@shared
def last(
    w: int, row: Array, factor: float, above: float, level: int, k: float, end: float, size: int
) -> float:
    """Return the last sample before ``end`` up to which factor row z > above, from z in FOUND.

    z there is left in FOUND.
    """
    t = work.track(w)
    ladder, found, there = t.ladder, t.states[FOUND], t.states[THERE]
    for step in range(level, -1, -1):
        length = 2.0**step
        if k + length < end:
            move(ladder[step], found, size, there)
            if factor * along(row, there, size) > above:
                k += length
                for j in range(size):
                    found[j] = there[j]
    return k


@compiled
def start(seen: Array) -> None:
    """Forget what was seen."""
    for i in range(SEEN):
        seen[i] = -1.0
    seen[TOP], seen[MOST_U], seen[LEAST_U] = -inf, -inf, inf
    seen[HIGHEST], seen[CREST] = -inf, -inf
