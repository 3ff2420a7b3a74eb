"""Where three quotients of each of the loops side by side are least; see ``quotients``."""

from math import inf, log

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.abreast.room import LOOPS, QUOTIENTS
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.quotients import CLOSED, LAST, STEPS
from zoh.batch.tolerances import DOUBLE, GRID

_APART = float(GRID[1] / GRID[0])  # neighbours on the grid
_HALF = 0.5 * log(_APART)
# rows of the room: where a quotient is least, in which bracket, how far that moved last, 1.0 where
# it still moves, 1.0 where it ended by Newton's method in a valley; values, the least one on the
# grid and beside it; the terms of numerator - value denominator and what is said of them
(
    Q, _LOW, _HIGH, _MOVED, _MOVES, _VALLEY, _BEST, _BEFORE, _AFTER, _LAST_ONE, LEAST, _PARTS,
) = range(12)  # fmt: skip


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
    for _ in range(STEPS):
        if not nearer(w, n):
            break
    proof(w, n)


@compiled
def about(w: int, n: int) -> None:
    """Write the inner place of the grid where each is least, or where a parabola there is.

    The parabola is one in log q, its exponential that of a fraction.
    """
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
        before, here, after = room[_BEFORE, i], room[_BEST, i], room[_AFTER, i]
        bend = before + after - 2.0 * here
        t = _HALF * (before - after) / bend if bend > 0.0 else 0.0
        t = t if t > -2.0 * _HALF else -2.0 * _HALF
        t = t if t < 2.0 * _HALF else 2.0 * _HALF
        even, odd, q = 12.0 + t * t, 6.0 * t, room[Q, i]
        room[Q, i] = q * ((even + odd) / (even - odd))
        room[_LOW, i], room[_HIGH, i] = q / _APART, q * _APART
        room[_MOVED, i], room[_MOVES, i], room[_VALLEY, i] = inf, 1.0, 0.0


@compiled
def ratio(over: Array, under: Array, n: int, i: int, q: float) -> float:
    """Return the quotient of lane i at q."""
    a, b = over[n, i], under[n, i]
    for k in range(n - 1, -1, -1):
        a, b = a * q + over[k, i], b * q + under[k, i]
    return float(a / b)


@compiled
def nearer(w: int, n: int) -> bool:
    """Move each Q, by Newton's method or to its bracket's middle; return whether one goes on.

    (a/b)' = (a' b - a b')/b^2, and (a/b)'' b^3 = (a'' b - a b'') b - 2 (a' b - a b') b'
    """
    r, far = work.abreast(w), 0
    room, over, under = r.valleys, r.over, r.under
    for i in range(QUOTIENTS):
        q, low, high, moves = room[Q, i], room[_LOW, i], room[_HIGH, i], room[_MOVES, i]
        was = room[_VALLEY, i]
        a, a1, a2, b, b1, b2 = over[n, i], 0.0, 0.0, under[n, i], 0.0, 0.0
        for k in range(n - 1, -1, -1):
            a2, b2 = a2 * q + a1, b2 * q + b1
            a1, b1 = a1 * q + a, b1 * q + b
            a, b = a * q + over[k, i], b * q + under[k, i]
        slope = a1 * b - a * b1
        bend = 2.0 * ((a2 * b - a * b2) * b - slope * b1)
        low, high = q if slope < 0.0 else low, high if slope < 0.0 else q
        new = q - slope * b / bend
        by_newton = int(low < new) & int(new < high) & int(2.0 * abs(new - q) <= room[_MOVED, i])
        new = new if by_newton else 0.5 * (low + high)
        by = (new - q) * moves
        valley = 1.0 if by_newton & int(bend > 0.0) else 0.0
        room[_VALLEY, i] = valley if moves > 0.0 else was
        room[_LOW, i], room[_HIGH, i], room[_MOVED, i], room[Q, i] = low, high, abs(by), q + by
        far_by = int(abs(by) > LAST * q) | 1 - by_newton  # a half of little is not the end
        on = far_by & int(high > low * (1.0 + CLOSED)) & int(moves > 0.0) & int(slope == slope)
        room[_MOVES, i] = 1.0 if on else 0.0
        far |= on
    return far != 0


@compiled
def proof(w: int, n: int) -> None:
    """Write LEAST: where it is not below 0, nowhere is the quotient below its value at Q.

    Numerator - value denominator is (q - Q)^2 times a rest, none of whose terms may be below 0.
    Those below the largest term of the whole come from the terms at its bottom, the others from
    the top, so that none is a difference of larger ones. Where rounding may have made either
    polynomial, beside an undamped pole, their quotient proves nothing.
    """
    r = work.abreast(w)
    room, over, under = r.valleys, r.over, r.under
    for i in range(QUOTIENTS):
        q = room[Q, i]
        a, b = over[n, i], under[n, i]
        for k in range(n - 1, -1, -1):
            a, b = a * q + over[k, i], b * q + under[k, i]
        value, power, bulk_a, bulk_b, largest, where = a / b, 1.0, 0.0, 0.0, -1.0, 0.0
        for k in range(n + 1):
            part = (over[k, i] - value * under[k, i]) * power
            room[_PARTS + k, i] = part
            where = float(k) if abs(part) > largest else where
            largest = abs(part) if abs(part) > largest else largest
            bulk_a += abs(over[k, i]) * power
            bulk_b += abs(under[k, i]) * power
            power *= q
        firm = int(a > DOUBLE * bulk_a) & int(b > DOUBLE * bulk_b) & int(room[_VALLEY, i] > 0.0)
        least, total, sums = inf if firm else -1.0, 0.0, 0.0
        for k in range(n - 1):
            total += room[_PARTS + k, i]
            sums += total
            term = sums if float(k) < where else inf
            least = term if term < least else least
        total, sums = 0.0, 0.0
        for k in range(n - 2, -1, -1):
            total += room[_PARTS + k + 2, i]
            sums += total
            term = inf if float(k) < where else sums
            least = term if term < least else least
        room[LEAST, i] = least
    at_end(room, over, under, n, 0, 0.0)
    at_end(room, over, under, n, n, inf)


@compiled
def at_end(room: Array, over: Array, under: Array, n: int, place: int, end: float) -> None:
    """Put Q at an end of the axis where every term of numerator - value denominator says so."""
    for i in range(QUOTIENTS):
        value, least = over[place, i] / under[place, i], inf
        for k in range(n + 1):
            term = over[k, i] - value * under[k, i] if k != place else inf
            least = least if term >= least else term  # what is no number proves nothing
        q, proved = room[Q, i], room[LEAST, i]
        there = int(least > 0.0) & int(proved < 0.0)
        room[Q, i] = end if there else q
        room[LEAST, i] = 0.0 if there else proved
