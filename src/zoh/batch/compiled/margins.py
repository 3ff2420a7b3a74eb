"""All margins of one loop; see ``zoh.batch.arrays.margins``, the arithmetic of which this is."""

from math import atan, atan2, degrees, inf, log, nan, pi, radians, sqrt

import numpy as np

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.polynomials import (
    MOST,
    at,
    changes,
    on_axis,
    positive_roots,
    squared,
    times,
    with_slope,
    without,
)
from zoh.batch.tolerances import DROP, ON_IT_DEG, PIVOT, UNITY

_GRID = np.geomspace(1e-2, 1e4, 16)
_LAST = 1e-8  # relative: the error after a Newton's step as small as this is its square
_POLISH = 3
_STEPS = 100
_AT_ONE = 1e-10  # of its terms: what is left of the gain at the crossover it was solved at

# places of the figures
GM, PHASE_CROSSOVER, PM, CROSSOVER, DELAY, MODULUS, MS, MT, DISK, BANDWIDTH = range(10)
FIGURES = 10


@compiled
def frequency(x: float, dt: float, v: float) -> float:
    """Return rad/s of u = jv; u = p/x."""
    return pi / dt if v == inf else 2.0 / dt * atan(x * v)


@compiled
def stable(num: Array, den: Array, n: int, c: Array, d: Array) -> tuple[bool, bool]:
    """Return (whether the closed loop is stable, whether rounding may have decided it); Routh."""
    size = 0.0
    for k in range(n + 1):
        size = max(size, abs(num[k] + den[k]))
    if not 0.0 < size < inf:
        return False, True
    m, rest = n // 2 + 1, (n + 1) // 2
    for k in range(m):
        c[k] = (num[n - 2 * k] + den[n - 2 * k]) / size
    for k in range(rest):
        d[k] = (num[n - 2 * k - 1] + den[n - 2 * k - 1]) / size
    for k in range(rest, m + 1):
        d[k] = 0.0
    sign = 1.0 if c[0] > 0.0 else -1.0
    good, doubt = sign * (num[0] + den[0]) > 0.0, False
    for _ in range(n):
        bulk = 0.0
        for k in range(rest):
            bulk = max(bulk, abs(d[k]))
        good = good and d[0] * sign > 0.0
        doubt = doubt or abs(d[0]) <= PIVOT * bulk
        factor = c[0] / d[0]
        first = abs(c[1]) + abs(factor * d[1]) if m > 1 else 0.0
        for k in range(m - 1):
            minus = factor * d[k + 1] if k + 1 < rest else 0.0
            c[k] = c[k + 1] - minus
        m -= 1
        if m == 0:
            break
        doubt = doubt or abs(c[0]) <= PIVOT * first
        m, rest = rest, m
        for k in range(max(m, rest)):
            c[k], d[k] = d[k], c[k]
    return good, doubt


@compiled
def by_gain(
    num: Array, den: Array, n: int, gain: Array, x: float, dt: float, out: Array, roots: Array,
    work: Array,
) -> bool:  # fmt: skip
    """Write what the gain crossings say; return any doubt."""
    count, doubt = unities(gain, n, roots, work)
    top, bottom = abs(num[n]), abs(den[n])
    doubt = doubt or abs(top - bottom) <= UNITY * bottom
    doubt = doubt or abs(abs(num[0]) - abs(den[0])) <= UNITY * abs(den[0])
    out[PM], out[CROSSOVER], out[DELAY] = inf, nan, inf
    for k in range(count):
        v = sqrt(roots[k])
        for _ in range(_POLISH):
            a, b, of_a, of_b = on_axis(num, n, v)
            c, d, of_c, of_d = on_axis(den, n, v)
            square_n, square_d = a * a + b * b, c * c + d * d
            slope = -((of_b * a - of_a * b) / square_n - (of_d * c - of_c * d) / square_d)
            step = 0.5 * log(square_n / square_d) / slope
            v -= step
            if abs(step) <= 4e-16 * v:
                break
        a, b, _, _ = on_axis(num, n, v)
        c, d, _, _ = on_axis(den, n, v)
        pm = degrees(atan2(-(b * c - a * d), -(a * c + b * d)))
        if pm <= -180.0:
            pm = 180.0
        w = frequency(x, dt, v)
        late = 0.0 if abs(pm) < ON_IT_DEG else radians(pm) % (2.0 * pi) / w
        out[DELAY] = min(out[DELAY], late)
        if abs(pm) < abs(out[PM]):
            out[PM], out[CROSSOVER] = pm, w
    if top >= bottom and top > 0.0:
        out[DELAY] = min(out[DELAY], dt)
    return doubt


@compiled
def unities(gain: Array, n: int, roots: Array, work: Array) -> tuple[int, bool]:
    """Return ``positive_roots``; of a law's loop one is q = 1, the crossover asked for."""
    value, bulk = 0.0, 0.0
    for k in range(n + 1):
        value += gain[k]
        bulk += abs(gain[k])
    if abs(value) <= _AT_ONE * bulk:
        rest = work[MOST]
        without(gain, n, 1.0, rest)
        if changes(rest, n - 1) == 0:
            roots[0] = 1.0
            return 1, False
    return positive_roots(gain, n, roots, work)


@compiled
def by_phase(
    num: Array, den: Array, n: int, x: float, dt: float, out: Array, roots: Array, work: Array,
    parts: Array,
) -> bool:  # fmt: skip
    """Write what the phase crossings say; return any doubt. parts: shape (5, MOST)."""
    even, odd = n // 2, (n - 1) // 2 if n else 0
    for k in range(even + 1):
        sign = 1.0 if k % 2 == 0 else -1.0
        parts[0, k], parts[1, k] = sign * num[2 * k], sign * den[2 * k]
    for k in range(odd + 1):
        sign = 1.0 if k % 2 == 0 else -1.0
        parts[2, k] = sign * num[2 * k + 1] if 2 * k + 1 <= n else 0.0
        parts[3, k] = sign * den[2 * k + 1] if 2 * k + 1 <= n else 0.0
    turn = parts[4]
    degree = times(parts[2], odd, parts[1], even, turn)
    for i in range(even + 1):
        for j in range(odd + 1):
            turn[i + j] -= parts[0, i] * parts[3, j]
    while degree > 0 and turn[degree] == 0.0:
        degree -= 1
    count, doubt = positive_roots(turn, degree, roots, work)
    out[GM], out[PHASE_CROSSOVER] = inf, nan
    nearest = inf
    for k in range(count + 2):
        if k < count:
            v = sqrt(roots[k])
            for _ in range(_POLISH):
                a, b, of_a, of_b = on_axis(num, n, v)
                c, d, of_c, of_d = on_axis(den, n, v)
                step = (b * c - a * d) / (of_a * c + of_b * d - a * of_c - b * of_d)
                v -= step
                if abs(step) <= 4e-16 * v:
                    break
            a, b, _, _ = on_axis(num, n, v)
            c, d, _, _ = on_axis(den, n, v)
            product = a * c + b * d
            square = c * c + d * d
            doubt = doubt or product * product < 1e-20 * (a * a + b * b) * square
            factor = -square / product
        else:
            v, place = (0.0, 0) if k == count else (inf, n)
            factor = -den[place] / num[place]
        if not 0.0 < factor < inf:
            continue
        away = abs(log(factor))
        if away < nearest:
            nearest, out[GM] = away, factor
            out[PHASE_CROSSOVER] = frequency(x, dt, v)
    return doubt


@shared
def lowest(
    a: Array, b: Array, n: int, roots: Array, work: Array, rest: Array, grid: Array
) -> tuple[float, bool]:
    """Return (v where a/b is least over q = v^2, whether in doubt); grid has two rows."""
    best = on_grid(a, b, n, grid)
    q, inside = flat(a, b, n, _GRID[best - 1], _GRID[best + 1], _GRID[best])
    value = at(a, n, q) / at(b, n, q)
    v = sqrt(q)
    end = a[0] / b[0]
    if end <= value * (1.0 + 1e-14):
        v, value = 0.0, end
    end = a[n] / b[n]
    if end <= value * (1.0 + 1e-14):
        v, value = inf, end
    if inside or v == 0.0 or v == inf:
        for k in range(n + 1):
            rest[k] = a[k] - value * b[k]
        degree = n
        if v == 0.0:
            rest[0] = 0.0
        elif v == inf:
            rest[n] = 0.0
        else:
            without(rest, n, q, rest)
            without(rest, n - 1, q, rest)
            degree = n - 2
        count = changes(rest, degree)
        if count == 0:
            return v, False
        if count % 2 == 0:
            found, doubt = positive_roots(rest, degree, roots, work)
            if found == 0 and not doubt:
                return v, False
    return by_slopes(a, b, n, roots, work, rest)


@compiled
def on_grid(a: Array, b: Array, n: int, grid: Array) -> int:
    """Return the inner place of the grid where a/b is least; a loop over places for each power."""
    over, under = grid[0], grid[1]
    for j in range(len(_GRID)):
        over[j], under[j] = a[n], b[n]
    for k in range(n - 1, -1, -1):
        for j in range(len(_GRID)):
            over[j] = over[j] * _GRID[j] + a[k]
            under[j] = under[j] * _GRID[j] + b[k]
    for j in range(len(_GRID)):
        over[j] /= under[j]
    best, least = 0, inf
    for j in range(len(_GRID)):
        if over[j] < least:
            best, least = j, over[j]
    return min(max(best, 1), len(_GRID) - 2)


@shared
def flat(a: Array, b: Array, n: int, low: float, high: float, q: float) -> tuple[float, bool]:
    """Return (where the slope of a/b becomes positive in (low, high), whether it does)."""
    falls, rises, last = False, False, inf
    for _ in range(_STEPS):
        fa, sa, ca = a[n], 0.0, 0.0
        fb, sb, cb = b[n], 0.0, 0.0
        for k in range(n - 1, -1, -1):
            ca = ca * q + sa
            sa = sa * q + fa
            fa = fa * q + a[k]
            cb = cb * q + sb
            sb = sb * q + fb
            fb = fb * q + b[k]
        slope = sa * fb - fa * sb
        if slope < 0.0:
            low, falls = q, True
        else:
            high, rises = q, True
        new = q - slope / (2.0 * (ca * fb - fa * cb))
        if not (low < new < high) or 2.0 * abs(new - q) > last:
            new = sqrt(low * high)
        last, q = abs(new - q), new
        if last <= _LAST * q or high <= low * (1.0 + 1e-14):
            break
    if not falls:
        falls = slope_at(a, b, n, low) < 0.0
    if not rises:
        rises = slope_at(a, b, n, high) >= 0.0
    return q, falls and rises


@compiled
def slope_at(a: Array, b: Array, n: int, q: float) -> float:
    """Return the numerator of the slope of a/b."""
    fa, sa = with_slope(a, n, q)
    fb, sb = with_slope(b, n, q)
    return sa * fb - fa * sb


@shared
def by_slopes(
    a: Array, b: Array, n: int, roots: Array, work: Array, rest: Array
) -> tuple[float, bool]:
    """Return (v where a/b is least, whether in doubt), every place where its slope is 0 tried."""
    size = 0.0
    for k in range(2 * n):
        total = 0.0
        for i in range(max(0, k + 1 - n), min(n, k + 1) + 1):
            total += (2 * i - k - 1) * a[i] * b[k + 1 - i]
        rest[k] = total
        size = max(size, abs(total))
    degree = max(2 * n - 1, 0)
    for k in range(degree + 1):
        rest[k] /= size
    while degree > 0 and rest[degree] == 0.0:
        degree -= 1
    count, doubt = positive_roots(rest, degree, roots, work)
    v, least = 0.0, a[0] / b[0]
    if not least >= 0.0:
        least = inf
    for k in range(count):
        value = at(a, n, roots[k]) / at(b, n, roots[k])
        if value < least:
            v, least = sqrt(roots[k]), value
    if a[n] / b[n] < least:
        v = inf
    return v, doubt


@compiled
def sizes(num: Array, den: Array, n: int, v: float) -> tuple[float, float, float, float]:
    """Return |num|, |den|, |num + den| and |den - num| at jv."""
    if v == inf:
        a, b, c, d = num[n], 0.0, den[n], 0.0
    else:
        a, b, _, _ = on_axis(num, n, v)
        c, d, _, _ = on_axis(den, n, v)
    return (
        sqrt(a * a + b * b), sqrt(c * c + d * d),
        sqrt((a + c) ** 2 + (b + d) ** 2), sqrt((c - a) ** 2 + (d - b) ** 2),
    )  # fmt: skip


@compiled
def measured(
    num: Array, den: Array, n: int, x: float, dt: float, out: Array, roots: Array, work: Array,
    parts: Array,
) -> bool:  # fmt: skip
    """Write every figure of the loop; return any doubt. parts: shape (12, MOST)."""
    grid = work[MOST + 1 :]
    nn, dd, aa, bb = parts[5], parts[6], parts[7], parts[8]
    some, rest = parts[9], parts[10]
    squared(num, n, nn)
    squared(den, n, dd)
    for k in range(n + 1):
        some[k] = num[k] + den[k]
    squared(some, n, aa)
    for k in range(n + 1):
        some[k] = den[k] - num[k]
    squared(some, n, bb)
    for k in range(n + 1):
        some[k] = nn[k] - dd[k]
    doubt = by_gain(num, den, n, some, x, dt, out, roots, work)
    doubt = by_phase(num, den, n, x, dt, out, roots, work, parts) or doubt
    v, unsure = lowest(aa, dd, n, roots, work, rest, grid)
    doubt = doubt or unsure
    _, d, s, _ = sizes(num, den, n, v)
    out[MODULUS], out[MS] = s / d, d / s
    v, unsure = lowest(aa, nn, n, roots, work, rest, grid)
    doubt = doubt or unsure
    c, _, s, _ = sizes(num, den, n, v)
    out[MT] = c / s
    v, unsure = lowest(aa, bb, n, roots, work, rest, grid)
    doubt = doubt or unsure
    _, _, s, d = sizes(num, den, n, v)
    out[DISK] = 2.0 * s / d
    at_rest = DROP * nn[0] / aa[0]
    out[BANDWIDTH] = nan
    if at_rest > 0.0:
        for k in range(n + 1):
            some[k] = nn[k] - at_rest * aa[k]
        count, unsure = positive_roots(some, n, roots, work)
        doubt = doubt or unsure
        if count:
            value, slope = with_slope(some, n, roots[0])
            out[BANDWIDTH] = frequency(x, dt, sqrt(roots[0] - value / slope))
    return doubt
