"""Where quotients of two polynomials are least, and the proof of it; many side by side, in lanes.

The same is done to all at once, for a step of Newton's method is a chain in which each operation
waits for the one before. ``wide`` says how many there are, and n of what degree both polynomials
are: where the compiler knows the two, lanes are vectors.

room         the rows below, and n + 1 more
over, under  numerator and denominator, ascending powers in rows
"""

from math import inf, log

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.polynomials import CLOSED, LAST
from zoh.batch.compiled.room import NOTES
from zoh.batch.tolerances import DOUBLE, GRID

STEPS = 100
_HALF = 0.5 * log(GRID[1] / GRID[0])
# rows of the room: where a quotient is least, in which bracket, how far that moved last, 1.0 where
# it still moves, 1.0 where it ended by Newton's method in a valley, and what is proved of it; from
# PARTS on: the terms of numerator - value denominator
Q, _LOW, _HIGH, _MOVED, _MOVES, VALLEY, LEAST = range(NOTES)
PARTS = NOTES


@compiled
def begin(room: Array, i: int, q: float, low: float, high: float) -> None:
    """Write where quotient i is looked for first, and between what."""
    room[Q, i], room[_LOW, i], room[_HIGH, i] = q, low, high
    room[_MOVED, i], room[_MOVES, i], room[VALLEY, i] = inf, 1.0, 0.0


@compiled
def vertex(before: float, here: float, after: float) -> tuple[float, float]:
    """Return (a, b): a parabola through values at three neighbours of ``GRID`` is least at q a/b.

    q is the place in the middle; it is a parabola in log q, and a/b an approximate exponential.
    """
    bend = before + after - 2.0 * here
    t = _HALF * (before - after) / bend if bend > 0.0 else 0.0
    t = t if t > -2.0 * _HALF else -2.0 * _HALF
    t = t if t < 2.0 * _HALF else 2.0 * _HALF
    even, odd = 12.0 + t * t, 6.0 * t
    return even + odd, even - odd


@compiled
def minimised(room: Array, over: Array, under: Array, n: int, wide: int) -> None:
    """Move each Q to where its quotient is least, from where it begins; write what is proved."""
    for _ in range(STEPS):
        if not nearer(room, over, under, n, wide):
            break
    proof(room, over, under, n, wide)


@compiled
def nearer(room: Array, over: Array, under: Array, n: int, wide: int) -> bool:
    """Move each Q, by Newton's method or to its bracket's middle; return whether one goes on.

    (a/b)' = (a' b - a b')/b^2, and (a/b)'' b^3 = (a'' b - a b'') b - 2 (a' b - a b') b'
    """
    far = 0
    for i in range(wide):
        q, low, high, moves = room[Q, i], room[_LOW, i], room[_HIGH, i], room[_MOVES, i]
        was = room[VALLEY, i]
        a, a1, a2, b, b1, b2 = over[n, i], 0.0, 0.0, under[n, i], 0.0, 0.0  # half the bends: a2, b2
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
        room[VALLEY, i] = valley if moves > 0.0 else was
        room[_LOW, i], room[_HIGH, i], room[_MOVED, i], room[Q, i] = low, high, abs(by), q + by
        far_by = int(abs(by) > LAST * q) | 1 - by_newton  # a half of little is not the end
        on = far_by & int(high > low * (1.0 + CLOSED)) & int(moves > 0.0) & int(slope == slope)
        room[_MOVES, i] = 1.0 if on else 0.0
        far |= on
    return far != 0


@compiled
def proof(room: Array, over: Array, under: Array, n: int, wide: int) -> None:
    """Write LEAST: where it is not below 0, nowhere is the quotient below its value at Q.

    Numerator - value denominator is (q - Q)^2 times a rest, none of whose terms may be below 0.
    Those below the largest term of the whole come from the terms at its bottom, the others from
    the top, so that none is a difference of larger ones. Where rounding may have made either
    polynomial, beside an undamped pole, their quotient proves nothing.
    """
    for i in range(wide):
        q = room[Q, i]
        a, b = over[n, i], under[n, i]
        for k in range(n - 1, -1, -1):
            a, b = a * q + over[k, i], b * q + under[k, i]
        value, power, bulk_a, bulk_b, largest, where = a / b, 1.0, 0.0, 0.0, -1.0, 0.0
        for k in range(n + 1):
            part = (over[k, i] - value * under[k, i]) * power
            room[PARTS + k, i] = part
            where = float(k) if abs(part) > largest else where
            largest = abs(part) if abs(part) > largest else largest
            bulk_a += abs(over[k, i]) * power
            bulk_b += abs(under[k, i]) * power
            power *= q
        firm = int(a > DOUBLE * bulk_a) & int(b > DOUBLE * bulk_b) & int(room[VALLEY, i] > 0.0)
        least, total, sums = inf if firm else -1.0, 0.0, 0.0
        for k in range(n - 1):
            total += room[PARTS + k, i]
            sums += total
            term = sums if float(k) < where else inf
            least = term if term < least else least
        total, sums = 0.0, 0.0
        for k in range(n - 2, -1, -1):
            total += room[PARTS + k + 2, i]
            sums += total
            term = inf if float(k) < where else sums
            least = term if term < least else least
        room[LEAST, i] = least
