"""Z on its way: moved by one sample or by many, and what is seen of it; all in plain arrays."""

from math import inf

import numpy as np

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.tolerances import LEVELS

BLOCK = 32  # samples between two looks at whether a loop is done
WIDE, NARROW = 16, 8  # numbers that are moved at once, a whole number of vectors; the rest are 0

# places of what is seen
(
    TOP, K_TOP, MOST_U, LEAST_U, K_10, K_90, K_OUT, HIGHEST, WHEN, CREST, K_CREST, PIECE,
    Y1, Y2, U1, U2, K1, K2,
) = range(18)  # fmt: skip
SEEN = 18
# places of the states that are kept
Z, NEXT, LAST, BEFORE, AT_CREST, FOUND, THERE, OTHER = range(8)
KEPT = 8


def ladder() -> Array:
    """Return the array of the doublings of delta, by columns: [level, j, i] is s_ij."""
    return np.zeros((LEVELS + 1, WIDE, WIDE))


def states() -> Array:
    """Return the array of the states that are kept; behind them a block of samples."""
    return np.zeros((KEPT + BLOCK + 1, WIDE))


@compiled
def along(row: Array, z: Array, size: int) -> float:
    """Return row z."""
    total = 0.0
    for j in range(size):
        total += row[j] * z[j]
    return total


@compiled
def move(s: Array, z: Array, size: int, out: Array) -> None:
    """Write z + s z, s by columns."""
    if size <= NARROW:
        for i in range(NARROW):
            out[i] = z[i]
        for j in range(size):
            part = z[j]
            for i in range(NARROW):
                out[i] += s[j, i] * part
    else:
        for i in range(WIDE):
            out[i] = z[i]
        for j in range(size):
            part = z[j]
            for i in range(WIDE):
                out[i] += s[j, i] * part


@shared
def twice(s: Array, size: int, out: Array) -> None:
    """Write 2 s + s s, by columns."""
    wide = NARROW if size <= NARROW else WIDE
    for k in range(size):
        for i in range(wide):
            out[k, i] = 2.0 * s[k, i]
        for j in range(size):
            part = s[k, j]
            for i in range(wide):
                out[k, i] += s[j, i] * part


@shared
def last(
    row: Array, factor: float, above: float, ladder: Array, level: int, zs: Array, start: int,
    k: float, end: float, size: int,
) -> float:  # fmt: skip
    """Return the last sample before ``end`` up to which factor row z > above; z into FOUND."""
    found, there = zs[FOUND], zs[THERE]
    for j in range(size):
        found[j] = zs[start, j]
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


@compiled
def pass_on(z: Array, zs: Array, seen: Array, y: float, u: float, k: float, size: int) -> None:
    """Make the sample looked at the last one, and the last one the one before."""
    seen[Y1], seen[Y2], seen[U1], seen[U2], seen[K1], seen[K2] = (
        y,
        seen[Y1],
        u,
        seen[U1],
        k,
        seen[K1],
    )
    for j in range(size):
        zs[BEFORE, j], zs[LAST, j] = zs[LAST, j], z[j]
