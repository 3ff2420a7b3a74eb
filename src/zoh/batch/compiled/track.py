"""Z on its way: a block of samples at once, and what is seen of it; all in plain arrays.

A block holds Z by columns, in ``LANES`` of which the same is done: each doubling of its length
is one product with a power of the motion, so no sample waits for the one before.
"""

from math import inf

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.lanes import everywhere, plus, plus_times, put, taken
from zoh.batch.compiled.room import BLOCK, DOUBLINGS, LANES, PAST, SEEN, WIDE

# places of what is seen
(
    TOP, K_TOP, MOST_U, LEAST_U, K_10, K_90, K_OUT, HIGHEST, WHEN, UNKNOWN, K1, K2,
) = range(12)  # fmt: skip
# places of the states that are kept
NEXT, FOUND, THERE, OTHER = range(4)
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
        total = everywhere(0.0)
        for j in range(size):
            total = plus_times(total, factor * weights[j], taken(rows[j], i))
        put(total, out, i)


@compiled
def move(s: Array, z: Array, size: int, out: Array) -> None:
    """Write z + s z, s by columns."""
    product(z, 1.0, s, 0, LANES if size <= LANES else WIDE, size, out)
    for i in range(size):
        out[i] += z[i]


@shared
def first_ones(w: int, level: int, size: int) -> None:
    """Write Z at a block's first ``LANES`` samples, 2^level apart, from the first one.

    Levels up to that of so many samples are made as they are come to.
    """
    if size == 4:  # of the usual sizes the compiler knows every place beforehand
        begun(w, level, 4)
    elif size == 5:
        begun(w, level, 5)
    else:
        begun(w, level, size)


@compiled
def begun(w: int, level: int, size: int) -> None:
    """Do what ``first_ones`` does."""
    ladder, block = work.track(w).ladder, work.track(w).block
    if level == 0:
        doubled(ladder[0], ladder[1], size)
        doubled(ladder[1], ladder[2], size)
    doubled(ladder[level + DOUBLINGS - 1], ladder[level + DOUBLINGS], size)
    as_many(ladder[level], block, 1, size)
    as_many(ladder[level + 1], block, 2, size)
    as_many(ladder[level + 2], block, LANES // 2, size)


@compiled
def doubled(s: Array, out: Array, size: int) -> None:
    """Write 2 s + s s, by columns; the last number of Z does not move.

    Two sums wait half as long for one another as one does, here and in ``next_ones``.
    """
    for k in range(size):
        for first in range(0, LANES if size <= LANES else WIDE, LANES):
            one = taken(s[k], first)
            other = one
            for j in range(0, size - 1, 2):
                one = plus_times(one, s[k, j], taken(s[j], first))
            for j in range(1, size - 1, 2):
                other = plus_times(other, s[k, j], taken(s[j], first))
            put(plus(one, other), out[k], first)


@compiled
def as_many(s: Array, block: Array, many: int, size: int) -> None:
    """Write as many columns after a block's first ones; the last number of Z stays, 1."""
    for i in range(size - 1):
        for at in range(PAST, PAST + many):
            total = block[i, at]
            for j in range(size - 1):
                total += s[j, i] * block[j, at]
            block[i, at + many] = total + s[size - 1, i]


@shared
def ahead(w: int, level: int, size: int) -> None:
    """Write Z at a block's samples, and at the next one's first, from its first ``LANES``."""
    if size == 4:
        filled(w, level, 4)
    elif size == 5:
        filled(w, level, 5)
    else:
        filled(w, level, size)


@compiled
def filled(w: int, level: int, size: int) -> None:
    """Do what ``ahead`` does, ``LANES`` samples at once."""
    t = work.track(w)
    s, block = t.ladder[level + DOUBLINGS], t.block
    for first in range(PAST, PAST + BLOCK, LANES):
        next_ones(s, block, first, size)


@compiled
def next_ones(s: Array, block: Array, first: int, size: int) -> None:
    """Write the ``LANES`` columns after as many; the last number of Z stays, 1."""
    for i in range(size - 1):
        one, other = taken(block[i], first), everywhere(s[size - 1, i])
        for j in range(0, size - 1, 2):
            one = plus_times(one, s[j, i], taken(block[j], first))
        for j in range(1, size - 1, 2):
            other = plus_times(other, s[j, i], taken(block[j], first))
        put(plus(one, other), block[i], first + LANES)


@compiled
def go_on(block: Array, size: int) -> None:
    """Make what follows a block its first samples, its last ones the past."""
    for j in range(size - 1):
        for i in range(PAST):
            block[j, i], block[j, PAST + i] = block[j, BLOCK + i], block[j, PAST + BLOCK + i]
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
    if size == 5:  # of the usual size the compiler knows every place beforehand
        return halved(w, row, factor, above, level, k, end, 5)
    return halved(w, row, factor, above, level, k, end, size)


@compiled
def halved(
    w: int, row: Array, factor: float, above: float, level: int, k: float, end: float, size: int
) -> float:
    """Do what ``last`` does."""
    t = work.track(w)
    ladder, found, there = t.ladder, t.states[FOUND], t.states[THERE]
    for step in range(level, -1, -1):
        length = 1.0 * (1 << step)
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
    seen[HIGHEST] = -inf
