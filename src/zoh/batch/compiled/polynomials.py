"""Polynomials of one loop: ascending powers in the first n + 1 places of an array.

The methods and their sources are those of ``zoh.batch.arrays.rows``.
"""

from math import inf, sqrt

import numpy as np

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.tolerances import DOUBLE, GRID

_1, _2, _3, _4, _5, _6, _7 = (np.uint64(i) for i in range(1, 8))  # places that are never < 0
STEPS = 120
LAST = 1e-6  # relative: the error after a Newton's step as small as this is its square
CLOSED = 1e-15  # relative: a bracket with nothing left in it


@compiled
def at(a: Array, n: int, x: float) -> float:
    """Return the value at x."""
    value: float = a[n]
    for k in range(n - 1, -1, -1):
        value = value * x + a[k]
    return value


@compiled
def with_slope(a: Array, n: int, x: float) -> tuple[float, float]:
    """Return the value and the derivative at x."""
    value, slope = a[n], 0.0
    for k in range(n - 1, -1, -1):
        slope = slope * x + value
        value = value * x + a[k]
    return value, slope


@compiled
def times(a: Array, n: int, b: Array, m: int, out: Array) -> int:
    """Write the product into ``out``; return its degree."""
    for k in range(n + m + 1):
        out[k] = 0.0
    for i in range(n + 1):
        for j in range(m + 1):
            out[i + j] += a[i] * b[j]
    return n + m


@compiled
def squared(a: Array, n: int, out: Array) -> None:
    """Write |a(jv)|^2 by powers of q = v^2 into ``out``, of degree n."""
    for k in range(n + 1):
        total = a[k] * a[k]
        sign = -2.0
        for i in range(1, min(k, n - k) + 1):
            total += sign * a[k - i] * a[k + i]
            sign = -sign
        out[k] = total


@compiled
def on_axis(a: Array, n: int, v: float) -> tuple[float, float, float, float]:
    """Return a(jv) and a'(jv), the derivative by its argument: two real parts, two imaginary."""
    real, imag, of_real, of_imag = a[n], 0.0, 0.0, 0.0
    for k in range(n - 1, -1, -1):
        of_real, of_imag = real - v * of_imag, imag + v * of_real
        real, imag = a[k] - v * imag, v * real
    return real, imag, of_real, of_imag


@compiled
def on_grid(a: Array, n: int, out: Array) -> None:
    """Write the values at the points of ``GRID``."""
    for first in range(0, len(GRID), 8):
        i = np.uint64(first)
        x0, x1, x2, x3 = GRID[i], GRID[i + _1], GRID[i + _2], GRID[i + _3]
        x4, x5, x6, x7 = GRID[i + _4], GRID[i + _5], GRID[i + _6], GRID[i + _7]
        y0 = y1 = y2 = y3 = y4 = y5 = y6 = y7 = a[n]
        for k in range(n - 1, -1, -1):
            y0, y1, y2, y3 = y0 * x0 + a[k], y1 * x1 + a[k], y2 * x2 + a[k], y3 * x3 + a[k]
            y4, y5, y6, y7 = y4 * x4 + a[k], y5 * x5 + a[k], y6 * x6 + a[k], y7 * x7 + a[k]
        out[i], out[i + _1], out[i + _2], out[i + _3] = y0, y1, y2, y3
        out[i + _4], out[i + _5], out[i + _6], out[i + _7] = y4, y5, y6, y7


@compiled
def changes(a: Array, n: int) -> int:
    """Return the number of sign changes, zeros left out (Descartes)."""
    count, last = 0, 0.0
    for k in range(n + 1):
        if a[k] != 0.0:
            if a[k] * last < 0.0 or (last != 0.0 and (a[k] < 0.0) != (last < 0.0)):
                count += 1
            last = a[k]
    return count


@shared
def closed_in(a: Array, n: int, low: float, high: float, x: float, rising: bool) -> float:
    """Return the root between low and high, where a has two signs, the first - if it is rising."""
    last = inf
    for _ in range(STEPS):
        f, slope = with_slope(a, n, x)
        if f == 0.0:
            return x
        if (f < 0.0) == rising:
            low = x
        else:
            high = x
        new = x - f / slope
        by_newton = low < new < high and 2.0 * abs(new - x) <= last
        if not by_newton:
            new = sqrt(low) * sqrt(high)
        last = abs(new - x)
        if (by_newton and last <= LAST * x) or high <= low * (1.0 + CLOSED):
            return new
        x = new
    return x


@compiled
def only_root(w: int, a: Array, n: int) -> float:
    """Return the root > 0 where there is one: first between which grid points."""
    values, falling, place = work.lines(w).grid[0], a[0] > 0.0, 0
    on_grid(a, n, values)
    for i in range(len(GRID)):
        place += int((values[i] > 0.0) == falling)
    if 0 < place < len(GRID):
        low, high = GRID[place - 1], GRID[place]
        x = low + values[place - 1] / (values[place - 1] - values[place]) * (high - low)
    else:
        low, high = bounds(a, n)
        if place:
            low = max(low, GRID[place - 1])
        else:
            high = min(high, GRID[0])
        x = sqrt(low) * sqrt(high)
    return closed_in(a, n, low, high, min(max(x, low), high), not falling)


@compiled
def bounds(a: Array, n: int) -> tuple[float, float]:
    """Return two numbers between which every positive root is; a[0] and a[n] are not 0 (Cauchy)."""
    most = 0.0
    least = 0.0
    for k in range(n):
        most = max(most, abs(a[k]))
        least = max(least, abs(a[k + 1]))
    first, last = abs(a[0]), abs(a[n])
    return 0.99 * first / (first + least), 1.01 * (last + most) / last


@shared
def positive_roots(w: int, a: Array, n: int) -> tuple[int, bool]:
    """Write the roots > 0 where a changes its sign, ascending; return (how many, any doubt)."""
    count = changes(a, n)
    if count == 0:
        return 0, False
    while a[n] == 0.0:
        n -= 1
    lines = work.lines(w)
    derivatives, roots, edges, inner = lines.work, lines.roots, lines.edges, 0
    first = 0
    while a[first] == 0.0:
        first += 1
    top = derivatives[0]
    for k in range(first, n + 1):
        top[k - first] = a[k]
    n -= first
    if count == 1:
        roots[0] = only_root(w, top, n)
        return 1, False
    low, high = bounds(top, n)
    for level in range(1, n - 1):
        size = 0.0
        for k in range(n - level + 1):
            derivatives[level, k] = derivatives[level - 1, k + 1] * (k + 1)
            size = max(size, abs(derivatives[level, k]))
        for k in range(n - level + 1):
            derivatives[level, k] /= size
    found = of_quadratic(derivatives[max(n - 2, 0)], roots, low, high)
    if n == 2:
        c = top[1] * top[1] - 4.0 * top[0] * top[2]
        return found, abs(c) <= 4.0 * DOUBLE * top[1] * top[1]
    for level in range(n - 3, -1, -1):
        degree, poly = n - level, derivatives[level]
        inner = found
        for k in range(found):
            edges[k] = roots[k]
        found = 0
        left, value = low, at(poly, degree, low)
        for k in range(inner + 1):
            right = edges[k] if k < inner else high
            next_value = at(poly, degree, right)
            if (value < 0.0) != (next_value < 0.0):
                middle = sqrt(left) * sqrt(right)
                roots[found] = closed_in(poly, degree, left, right, middle, value < 0.0)
                found += 1
            left, value = right, next_value
    doubt = False
    for k in range(inner):
        bulk, x = abs(top[n]), edges[k]
        for j in range(n - 1, -1, -1):
            bulk = bulk * x + abs(top[j])
        doubt = doubt or abs(at(top, n, x)) <= DOUBLE * bulk
    return found, doubt


@compiled
def of_quadratic(a: Array, roots: Array, low: float, high: float) -> int:
    """Write the two roots of a quadratic that are inside (low, high); return how many are."""
    square = a[1] * a[1] - 4.0 * a[0] * a[2]
    if not square > 0.0:
        return 0
    far = -0.5 * (a[1] + (sqrt(square) if a[1] > 0.0 else -sqrt(square)))
    one, two = far / a[2], a[0] / far
    if two < one:
        one, two = two, one
    found = 0
    if low < one < high:
        roots[found] = one
        found += 1
    if low < two < high:
        roots[found] = two
        found += 1
    return found


@compiled
def without(a: Array, n: int, q: float, out: Array) -> None:
    """Write a/(x - q), its remainder dropped, of degree n - 1; ``out`` may be a itself.

    From the top down to the term that is the largest at q, and from the bottom up to it; see
    ``zoh.batch.arrays.peaks``.
    """
    largest, most, power = 0, -1.0, 1.0
    for k in range(n + 1):
        size = abs(a[k]) * power
        if size > most:
            largest, most = k, size
        power *= q
    carry = 0.0
    for k in range(n, largest, -1):
        carry = a[k] + q * carry
        out[k] = carry
    for k in range(largest, n):
        out[k] = out[k + 1]
    out[n] = 0.0
    carry, share = 0.0, 1.0 / q
    for k in range(largest):
        carry = (carry - a[k]) * share
        out[k] = carry
