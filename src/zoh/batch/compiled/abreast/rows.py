"""Polynomials of loops side by side: ascending powers in rows, a loop a lane.

The methods are those of ``zoh.batch.compiled.polynomials``. What one lane does depends on no other:
a lane that is done stays as it is until all are.
"""

from math import inf

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.abreast.room import LOOPS
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.polynomials import CLOSED, LAST, STEPS
from zoh.batch.tolerances import GRID

# rows of a search: the root, its bracket, values at the ends of that, how far the root moved last,
# 1.0 where it still moves, the sign below the root, and the number of sign changes
ROOT, _LOW, _HIGH, _AT_LOW, _AT_HIGH, _MOVED, _MOVES, _BELOW, CHANGES = range(9)


@compiled
def squared(a: Array, n: int, out: Array) -> None:
    """Write |a(jv)|^2 by powers of q = v^2, of degree n."""
    for i in range(LOOPS):
        for k in range(n + 1):
            total = a[k, i] * a[k, i]
            sign = -2.0
            for j in range(1, n):
                if j <= k <= n - j:
                    total += sign * a[k - j, i] * a[k + j, i]
                sign = -sign
            out[k, i] = total


@compiled
def with_slope(a: Array, n: int, i: int, x: float) -> tuple[float, float]:
    """Return the value and the derivative at x, of lane i."""
    value, slope = a[n, i], 0.0
    for k in range(n - 1, -1, -1):
        slope = slope * x + value
        value = value * x + a[k, i]
    return value, slope


@compiled
def on_axis(a: Array, n: int, i: int, v: float) -> tuple[float, float, float, float]:
    """Return a(jv) and a'(jv) of lane i, the derivative by its argument: real, imaginary parts."""
    real, imag, of_real, of_imag = a[n, i], 0.0, 0.0, 0.0
    for k in range(n - 1, -1, -1):
        of_real, of_imag = real - v * of_imag, imag + v * of_real
        real, imag = a[k, i] - v * imag, v * real
    return real, imag, of_real, of_imag


@compiled
def only_roots(w: int, a: Array, n: int) -> None:
    """Write ROOT > 0 of each that changes its sign once (Descartes), and CHANGES.

    Where the signs of the powers say more, or where the root is not on ``GRID``, it means nothing:
    CHANGES is not 1 then, and 0 of one that has no root > 0.
    """
    counted(w, a, n)
    bracketed(w, a, n)
    for _ in range(STEPS):
        if not nearer(w, a, n):
            break


@compiled
def counted(w: int, a: Array, n: int) -> None:
    """Write CHANGES of the signs of the powers, zeros left out, and the sign of the first one."""
    s = work.abreast(w).search
    for i in range(LOOPS):
        changes, last, below = 0.0, 0.0, 0.0
        for k in range(n + 1):
            term = a[k, i]
            sign = 1.0 if term > 0.0 else 0.0
            sign = -1.0 if term < 0.0 else sign
            changes += 1.0 if sign * last < 0.0 else 0.0
            last = last if sign == 0.0 else sign
            below = sign if below == 0.0 else below
        s[CHANGES, i], s[_BELOW, i] = changes, below


@compiled
def bracketed(w: int, a: Array, n: int) -> None:
    """Write between which two places of ``GRID`` the sign changes, and where a chord is 0."""
    s = work.abreast(w).search
    for i in range(LOOPS):
        s[_LOW, i], s[_HIGH, i], s[_AT_LOW, i], s[_AT_HIGH, i] = 0.0, inf, 0.0, 0.0
    for point in range(len(GRID)):
        x = GRID[point]
        for i in range(LOOPS):
            value = a[n, i]
            for k in range(n - 1, -1, -1):
                value = value * x + a[k, i]
            low, high, at_low, at_high = s[_LOW, i], s[_HIGH, i], s[_AT_LOW, i], s[_AT_HIGH, i]
            before = value * s[_BELOW, i] > 0.0
            s[_LOW, i] = x if before else low
            s[_AT_LOW, i] = value if before else at_low
            first = int(not before) & int(high == inf)
            s[_AT_HIGH, i] = value if first else at_high
            s[_HIGH, i] = x if first else high
    for i in range(LOOPS):
        low, high, changes = s[_LOW, i], s[_HIGH, i], s[CHANGES, i]
        inside, never = int(low > 0.0) & int(high < inf), int(changes == 0.0) & int(high == inf)
        changes = changes if inside | never else -1.0
        x = low + s[_AT_LOW, i] / (s[_AT_LOW, i] - s[_AT_HIGH, i]) * (high - low)
        x = x if x > low else low
        s[ROOT, i], s[CHANGES, i] = x if x < high else high, changes
        s[_MOVED, i], s[_MOVES, i] = inf, 1.0 if changes == 1.0 else 0.0


@compiled
def nearer(w: int, a: Array, n: int) -> bool:
    """Move each root, by Newton's method or to its bracket's middle; return whether one goes on."""
    s, far = work.abreast(w).search, 0
    for i in range(LOOPS):
        x, moves, low, high = s[ROOT, i], s[_MOVES, i], s[_LOW, i], s[_HIGH, i]
        f, slope = with_slope(a, n, i, x)
        below = f * s[_BELOW, i] > 0.0
        low, high = x if below else low, high if below else x
        new, middle = x - f / slope, 0.5 * (low + high)
        by_newton = int(low < new) & int(new < high) & int(2.0 * abs(new - x) <= s[_MOVED, i])
        new = new if by_newton else middle
        new = x if f == 0.0 else new
        by = abs(new - x)
        on = (int(by > LAST * x) | 1 - by_newton) & int(high > low * (1.0 + CLOSED))
        on &= int(f != 0.0) & int(moves > 0.0)
        s[_LOW, i], s[_HIGH, i], s[_MOVED, i] = low, high, by
        s[ROOT, i] = new if moves > 0.0 else x
        s[_MOVES, i] = 1.0 if on else 0.0
        far |= on
    return far != 0
