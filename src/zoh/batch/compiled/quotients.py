"""Where three quotients of one numerator are least, of one loop: side by side in lanes.

The same is done to all three at once, for a step of Newton's method is a chain in which each
operation waits for the one before. The fourth lane does again what the third one does.
"""

from math import inf

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.peaks import about
from zoh.batch.compiled.room import NOTES, SIDES
from zoh.batch.tolerances import DOUBLE, GRID

LAST = 1e-6  # relative: the error after a Newton's step as small as this is its square
CLOSED = 1e-15  # relative: a bracket with nothing left in it
STEPS = 100
# rows of the room: where a quotient is least, in which bracket, how far that moved last, 1.0 where
# it still moves, and 1.0 where it ended by Newton's method in a valley
Q, _LOW, _HIGH, _MOVED, _MOVES, VALLEY = range(6)
_ROWS = 6
_A, _A1, _A2, _B, _B1, _B2 = range(6, 12)  # values, slopes and half the bends
_LARGEST, _WHERE, _POWER, _VALUE, LEAST, _SUM, _SUMS, _OVER, _UNDER = range(12, NOTES)
_PARTS = NOTES  # from here on: the terms of numerator - value denominator


@compiled
def valleys(w: int, n: int) -> None:
    """Write where aa/dd, aa/nn and aa/bb are least, and the proof; aa on the grid is known."""
    lines, bulk = work.lines(w), 0.0
    for k in range(n + 1):
        bulk += abs(lines.dd[k])
    scale = 1.0 / bulk  # at q = 1 all are about as large: their products stay numbers
    for k in range(n + 1):
        three = lines.bb[k] * scale
        lines.under[k, 0], lines.under[k, 1] = lines.dd[k] * scale, lines.nn[k] * scale
        lines.under[k, 2], lines.under[k, 3] = three, three
    begun(w, n)
    for _ in range(STEPS):
        values(w, n)
        if not nearer(w):
            break
    values(w, n)
    proof(w, n)


@compiled
def begun(w: int, n: int) -> None:
    """Write where each quotient is looked for first: a place of the grid between its neighbours."""
    lines = work.lines(w)
    first(w, lines.dd, n, 0)
    first(w, lines.nn, n, 1)
    first(w, lines.bb, n, 2)
    for row in range(_ROWS):
        lines.sides[row, 3] = lines.sides[row, 2]


@compiled
def first(w: int, b: Array, n: int, i: int) -> None:
    """Write where the one of lane i is looked for first."""
    room = work.lines(w).sides
    best, near = about(w, b, n)
    room[Q, i], room[_LOW, i], room[_HIGH, i] = near, GRID[best - 1], GRID[best + 1]
    room[_MOVED, i], room[_MOVES, i], room[VALLEY, i] = inf, 1.0, 0.0


@compiled
def values(w: int, n: int) -> None:
    """Write both polynomials, their slopes and half their bends at each Q."""
    lines = work.lines(w)
    over, under, room = lines.aa, lines.under, lines.sides
    for i in range(SIDES):
        room[_A, i], room[_A1, i], room[_A2, i] = over[n], 0.0, 0.0
        room[_B, i], room[_B1, i], room[_B2, i] = under[n, i], 0.0, 0.0
    for k in range(n - 1, -1, -1):
        next_one = over[k]
        for i in range(SIDES):
            q = room[Q, i]
            room[_A2, i] = room[_A2, i] * q + room[_A1, i]
            room[_A1, i] = room[_A1, i] * q + room[_A, i]
            room[_A, i] = room[_A, i] * q + next_one
            room[_B2, i] = room[_B2, i] * q + room[_B1, i]
            room[_B1, i] = room[_B1, i] * q + room[_B, i]
            room[_B, i] = room[_B, i] * q + under[k, i]


@compiled
def nearer(w: int) -> bool:
    """Move each Q, by Newton's method or to its bracket's middle; return whether one goes on.

    (a/b)' = (a' b - a b')/b^2, and (a/b)'' b^3 = (a'' b - a b'') b - 2 (a' b - a b') b'
    """
    room, far = work.lines(w).sides, 0
    for i in range(SIDES):
        q, low, high, moves = room[Q, i], room[_LOW, i], room[_HIGH, i], room[_MOVES, i]
        a, a1, a2 = room[_A, i], room[_A1, i], room[_A2, i]
        b, b1, b2 = room[_B, i], room[_B1, i], room[_B2, i]
        slope = a1 * b - a * b1
        bend = 2.0 * ((a2 * b - a * b2) * b - slope * b1)
        low, high = q if slope < 0.0 else low, high if slope < 0.0 else q
        new = q - slope * b / bend
        by_newton = int(low < new) & int(new < high) & int(2.0 * abs(new - q) <= room[_MOVED, i])
        new = new if by_newton else 0.5 * (low + high)
        by = (new - q) * moves
        valley = 1.0 if by_newton & int(bend > 0.0) else 0.0
        room[VALLEY, i] = valley if moves > 0.0 else room[VALLEY, i]
        room[_LOW, i], room[_HIGH, i], room[_MOVED, i], room[Q, i] = low, high, abs(by), q + by
        far_by = int(abs(by) > LAST * q) | 1 - by_newton  # a half of little is not the end
        on = far_by & int(high > low * (1.0 + CLOSED)) & int(moves > 0.0)
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
    lines = work.lines(w)
    over, under, room = lines.aa, lines.under, lines.sides
    for i in range(SIDES):
        room[_VALUE, i] = room[_A, i] / room[_B, i]
        room[_LARGEST, i], room[_WHERE, i], room[_POWER, i] = -1.0, 0.0, 1.0
        room[_OVER, i], room[_UNDER, i] = 0.0, 0.0
    for k in range(n + 1):
        term, place = over[k], float(k)
        for i in range(SIDES):
            part = (term - room[_VALUE, i] * under[k, i]) * room[_POWER, i]
            larger = abs(part) > room[_LARGEST, i]
            room[_LARGEST, i] = abs(part) if larger else room[_LARGEST, i]
            room[_WHERE, i] = place if larger else room[_WHERE, i]
            room[_PARTS + k, i] = part
            room[_OVER, i] += abs(term) * room[_POWER, i]
            room[_UNDER, i] += abs(under[k, i]) * room[_POWER, i]
            room[_POWER, i] *= room[Q, i]
    for i in range(SIDES):
        firm = int(room[_A, i] > DOUBLE * room[_OVER, i])
        firm &= int(room[_B, i] > DOUBLE * room[_UNDER, i])
        room[LEAST, i] = inf if firm & int(room[VALLEY, i] > 0.0) else -1.0
        room[_SUM, i], room[_SUMS, i] = 0.0, 0.0
    for k in range(n - 1):
        place = float(k)
        for i in range(SIDES):
            room[_SUM, i] += room[_PARTS + k, i]
            room[_SUMS, i] += room[_SUM, i]
            term = room[_SUMS, i] if place < room[_WHERE, i] else inf
            room[LEAST, i] = term if term < room[LEAST, i] else room[LEAST, i]
    for i in range(SIDES):
        room[_SUM, i], room[_SUMS, i] = 0.0, 0.0
    for k in range(n - 2, -1, -1):
        place = float(k)
        for i in range(SIDES):
            room[_SUM, i] += room[_PARTS + k + 2, i]
            room[_SUMS, i] += room[_SUM, i]
            term = inf if place < room[_WHERE, i] else room[_SUMS, i]
            room[LEAST, i] = term if term < room[LEAST, i] else room[LEAST, i]
