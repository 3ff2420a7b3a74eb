"""All margins of one loop; see ``zoh.batch.arrays.margins``, the arithmetic of which this is."""

from math import atan, atan2, degrees, inf, nan, pi, radians, sqrt

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.peaks import lowest, valleys
from zoh.batch.compiled.places import (
    BANDWIDTH,
    CROSSOVER,
    DELAY,
    DISK,
    GM,
    MODULUS,
    MS,
    MT,
    PHASE_CROSSOVER,
    PM,
)
from zoh.batch.compiled.polynomials import (
    changes,
    on_axis,
    positive_roots,
    squared,
    times,
    with_slope,
    without,
)
from zoh.batch.compiled.quotients import LEAST, VALLEY, Q
from zoh.batch.tolerances import DROP, ON_IT_DEG, UNITY

POLISH = 3
LAST = 1e-8  # relative: the error after a Newton's step as small as this is its square
AT_ONE = 1e-10  # of its terms: what is left of the gain at the crossover it was solved at


@compiled
def frequency(x: float, dt: float, v: float) -> float:
    """Return rad/s of u = jv; u = p/x."""
    return pi / dt if v == inf else 2.0 / dt * atan(x * v)


@compiled
def by_gain(w: int, n: int, x: float, dt: float, out: Array) -> bool:
    """Write what the gain crossings say; return any doubt."""
    lines = work.lines(w)
    num, den, gain, roots = lines.num, lines.den, lines.some, lines.roots
    for k in range(n + 1):
        gain[k] = lines.nn[k] - lines.dd[k]
    count, doubt = unities(w, gain, n)
    top, bottom = abs(num[n]), abs(den[n])
    doubt = doubt or abs(top - bottom) <= UNITY * bottom
    doubt = doubt or abs(abs(num[0]) - abs(den[0])) <= UNITY * abs(den[0])
    out[PM], out[CROSSOVER], out[DELAY] = inf, nan, inf
    for k in range(count):
        v = sqrt(roots[k])
        for _ in range(POLISH):
            a, b, of_a, of_b = on_axis(num, n, v)
            c, d, of_c, of_d = on_axis(den, n, v)
            square_n, square_d = a * a + b * b, c * c + d * d
            slope = -((of_b * a - of_a * b) / square_n - (of_d * c - of_c * d) / square_d)
            step = (square_n - square_d) / ((square_n + square_d) * slope)
            v -= step
            if abs(step) <= LAST * v:
                break
        a, b, _, _ = on_axis(num, n, v)
        c, d, _, _ = on_axis(den, n, v)
        pm = degrees(atan2(-(b * c - a * d), -(a * c + b * d)))
        if pm <= -180.0:
            pm = 180.0
        wc = frequency(x, dt, v)
        turn = pm if pm > 0.0 else pm + 360.0
        late = 0.0 if abs(pm) < ON_IT_DEG else radians(turn) / wc
        out[DELAY] = min(out[DELAY], late)
        if abs(pm) < abs(out[PM]):
            out[PM], out[CROSSOVER] = pm, wc
    if top >= bottom and top > 0.0:
        out[DELAY] = min(out[DELAY], dt)
    return doubt


@compiled
def unities(w: int, gain: Array, n: int) -> tuple[int, bool]:
    """Return ``positive_roots``; of a law's loop one is q = 1, the crossover asked for."""
    rest, roots = work.lines(w).rest, work.lines(w).roots
    value, bulk = 0.0, 0.0
    for k in range(n + 1):
        value += gain[k]
        bulk += abs(gain[k])
    if abs(value) <= AT_ONE * bulk:
        without(gain, n, 1.0, rest)
        if changes(rest, n - 1) == 0:
            roots[0] = 1.0
            return 1, False
    return positive_roots(w, gain, n)


@compiled
def imaginary(w: int, n: int) -> int:
    """Write a polynomial into ``some``, v turn(v^2) = Im num conj(den) at jv; return its degree."""
    lines = work.lines(w)
    num, den, parts, turn = lines.num, lines.den, lines.parts, lines.some
    even, odd = n // 2, (n - 1) // 2 if n else 0
    for k in range(even + 1):
        sign = 1.0 if k % 2 == 0 else -1.0
        parts[0, k], parts[1, k] = sign * num[2 * k], sign * den[2 * k]
    for k in range(odd + 1):
        sign = 1.0 if k % 2 == 0 else -1.0
        parts[2, k] = sign * num[2 * k + 1] if 2 * k + 1 <= n else 0.0
        parts[3, k] = sign * den[2 * k + 1] if 2 * k + 1 <= n else 0.0
    degree = times(parts[2], odd, parts[1], even, turn)
    for i in range(even + 1):
        for j in range(odd + 1):
            turn[i + j] -= parts[0, i] * parts[3, j]
    while degree > 0 and turn[degree] == 0.0:
        degree -= 1
    return degree


@compiled
def by_phase(w: int, n: int, x: float, dt: float, out: Array) -> bool:
    """Write what the phase crossings say; return any doubt."""
    lines = work.lines(w)
    num, den, roots, degree = lines.num, lines.den, lines.roots, imaginary(w, n)
    count, doubt = positive_roots(w, lines.some, degree)
    out[GM], out[PHASE_CROSSOVER] = inf, nan
    nearest = inf
    for k in range(count + 2):
        if k < count:
            v = sqrt(roots[k])
            for _ in range(POLISH):
                a, b, of_a, of_b = on_axis(num, n, v)
                c, d, of_c, of_d = on_axis(den, n, v)
                step = (b * c - a * d) / (of_a * c + of_b * d - a * of_c - b * of_d)
                v -= step
                if abs(step) <= LAST * v:
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
        away = max(factor, 1.0 / factor)
        if away < nearest:
            nearest, out[GM] = away, factor
            out[PHASE_CROSSOVER] = frequency(x, dt, v)
    return doubt


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
def least(w: int, b: Array, n: int, side: int) -> tuple[float, bool]:
    """Return (v where the quotient of aa by b, that of this side, is least, whether in doubt)."""
    lines = work.lines(w)
    q = lines.sides[Q, side]
    if lines.sides[LEAST, side] >= 0.0:
        return sqrt(q), False
    return lowest(w, lines.aa, b, n, q, lines.sides[VALLEY, side] > 0.0)


@shared
def measured(w: int, n: int, x: float, dt: float, out: Array) -> bool:
    """Write every figure of the loop; return any doubt."""
    if n == 4:  # of the usual degree the compiler knows every place beforehand
        return every_figure(w, 4, x, dt, out)
    return every_figure(w, n, x, dt, out)


@compiled
def every_figure(w: int, n: int, x: float, dt: float, out: Array) -> bool:
    """Do what ``measured`` does."""
    lines = work.lines(w)
    num, den, some = lines.num, lines.den, lines.some
    nn, dd, aa, bb = lines.nn, lines.dd, lines.aa, lines.bb
    squared(num, n, nn)
    squared(den, n, dd)
    for k in range(n + 1):
        some[k] = num[k] + den[k]
    squared(some, n, aa)
    for k in range(n + 1):
        some[k] = den[k] - num[k]
    squared(some, n, bb)
    doubt = by_gain(w, n, x, dt, out)
    doubt = by_phase(w, n, x, dt, out) or doubt
    valleys(w, n)
    v, unsure = least(w, dd, n, 0)
    doubt = doubt or unsure
    _, d, s, _ = sizes(num, den, n, v)
    out[MODULUS], out[MS] = s / d, d / s
    v, unsure = least(w, nn, n, 1)
    doubt = doubt or unsure
    c, _, s, _ = sizes(num, den, n, v)
    out[MT] = c / s
    v, unsure = least(w, bb, n, 2)
    doubt = doubt or unsure
    _, _, s, d = sizes(num, den, n, v)
    out[DISK] = 2.0 * s / d
    at_rest = DROP * nn[0] / aa[0]
    out[BANDWIDTH] = nan
    if at_rest > 0.0:
        for k in range(n + 1):
            some[k] = nn[k] - at_rest * aa[k]
        count, unsure = positive_roots(w, some, n)
        doubt = doubt or unsure
        if count:
            value, slope = with_slope(some, n, lines.roots[0])
            out[BANDWIDTH] = frequency(x, dt, sqrt(lines.roots[0] - value / slope))
    return doubt
