"""Where three quotients of each of the loops side by side are least, by ``compiled.quotients``."""

from math import inf

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.abreast.room import LOOPS, QUOTIENTS
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.quotients import LEAST, PARTS, Q, begin, minimised, vertex
from zoh.batch.tolerances import GRID

_APART = float(GRID[1] / GRID[0])  # neighbours on the grid
# rows of the room that the terms will have: the least value on the grid, those beside it, the last
_BEST, _BEFORE, _AFTER, _LAST_ONE = range(PARTS, PARTS + 4)


@compiled
def valleys(w: int, n: int) -> None:
    """Write Q where aa/dd, aa/nn and aa/bb are least, inf at the end; LEAST >= 0 proves it."""
    r = work.abreast(w)
    for i in range(LOOPS):
        bulk = 0.0
        for k in range(n + 1):
            bulk += abs(r.dd[k, i])
        scale = 1.0 / bulk  # at q = 1 all are about as large: their products stay numbers
        for k in range(n + 1):
            r.under[k, i] = r.dd[k, i] * scale
            r.under[k, LOOPS + i] = r.nn[k, i] * scale
            r.under[k, 2 * LOOPS + i] = r.bb[k, i] * scale
            r.over[k, i], r.over[k, LOOPS + i] = r.aa[k, i], r.aa[k, i]
            r.over[k, 2 * LOOPS + i] = r.aa[k, i]
    about(w, n)
    minimised(r.valleys, r.over, r.under, n, QUOTIENTS)
    at_end(w, n, 0, 0.0)
    at_end(w, n, n, inf)


@compiled
def about(w: int, n: int) -> None:
    """Begin at the inner place of the grid where each is least, or where a parabola there is."""
    r = work.abreast(w)
    room, over, under = r.valleys, r.over, r.under
    for i in range(QUOTIENTS):
        room[_LAST_ONE, i] = ratio(over, under, n, i, GRID[0])
        room[_BEST, i], room[_BEFORE, i], room[_AFTER, i], room[Q, i] = inf, inf, inf, 1.0
    for j in range(1, len(GRID)):
        x, lower, end = GRID[j], GRID[j - 1], 0.0 if j < len(GRID) - 1 else inf
        for i in range(QUOTIENTS):
            value, last, q = ratio(over, under, n, i, x), room[_LAST_ONE, i], room[Q, i]
            before, after, least = room[_BEFORE, i], room[_AFTER, i], room[_BEST, i]
            best = value + end < least
            room[_AFTER, i] = value if q == lower else after
            room[_BEFORE, i] = last if best else before
            room[_BEST, i] = value if best else least
            room[Q, i] = x if best else q
            room[_LAST_ONE, i] = value
    for i in range(QUOTIENTS):
        top, bottom = vertex(room[_BEFORE, i], room[_BEST, i], room[_AFTER, i])
        q = room[Q, i]
        begin(room, i, q * (top / bottom), q / _APART, q * _APART)


@compiled
def ratio(over: Array, under: Array, n: int, i: int, q: float) -> float:
    """Return the quotient of lane i at q."""
    a, b = over[n, i], under[n, i]
    for k in range(n - 1, -1, -1):
        a, b = a * q + over[k, i], b * q + under[k, i]
    return float(a / b)


@compiled
def at_end(w: int, n: int, place: int, end: float) -> None:
    """Put Q at an end of the axis where every term of numerator - value denominator says so."""
    r = work.abreast(w)
    room, over, under = r.valleys, r.over, r.under
    for i in range(QUOTIENTS):
        value, least = over[place, i] / under[place, i], inf
        for k in range(n + 1):
            term = over[k, i] - value * under[k, i] if k != place else inf
            least = least if term >= least else term  # what is no number proves nothing
        q, proved = room[Q, i], room[LEAST, i]
        there = int(least > 0.0) & int(proved < 0.0)
        room[Q, i] = end if there else q
        room[LEAST, i] = 0.0 if there else proved
