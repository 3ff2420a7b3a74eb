"""Where loops side by side have a gain of 1, turn by -180 deg, and |T| has fallen by 3 dB.

The usual loop has the first once, the others once or never, and Descartes' rule says so: what has
more goes to ``zoh.batch.compiled.margins``, one at a time.
"""

from math import inf, nan, pi, sqrt

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.abreast.angles import angle
from zoh.batch.compiled.abreast.room import DT, LOOPS, X
from zoh.batch.compiled.abreast.rows import CHANGES, ROOT, on_axis, only_roots, with_slope
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.margins import AT_ONE, LAST, POLISH
from zoh.batch.tolerances import DROP, UNITY

# rows of what is found: v where the gain is 1, then rad/s, the phase margin in rad; the factor that
# brings L to -1, v, then rad/s; where |T| has fallen by 3 dB
_V, WC, MARGIN, GM, _V_180, W_180, W_DROP = range(7)
_MOVES = 0  # row of ``rest``: 1.0 where a v still moves


@compiled
def frequency(plant: Array, i: int, v: float) -> float:
    """Return rad/s of u = jv in lane i; u = p/x."""
    return float(2.0 / plant[DT, i] * angle(plant[X, i] * v, 1.0))


@compiled
def polished(w: int, n: int, row: int) -> None:
    """Move each v of a row by Newton's method: _V to where log |L| is 0, _V_180 to where L is real.

    No step is a function of its own: it would have num beside den as a vector, see ``jit``.
    """
    r = work.abreast(w)
    num, den, found, rest = r.num, r.den, r.found, r.rest
    for _ in range(POLISH):
        far = 0
        for i in range(LOOPS):
            v, moves = found[row, i], rest[_MOVES, i]
            a, b, of_a, of_b = on_axis(num, n, i, v)
            c, d, of_c, of_d = on_axis(den, n, i, v)
            if row == _V:
                square_n, square_d = a * a + b * b, c * c + d * d
                slope = -((of_b * a - of_a * b) / square_n - (of_d * c - of_c * d) / square_d)
                step = (square_n - square_d) / ((square_n + square_d) * slope)
            else:
                step = (b * c - a * d) / (of_a * c + of_b * d - a * of_c - b * of_d)
            on = int(abs(step) > LAST * v) & int(moves > 0.0)
            found[row, i] = v - step if moves > 0.0 else v
            rest[_MOVES, i] = 1.0 if on else 0.0
            far |= on
        if far == 0:
            break


@compiled
def by_gain(w: int, n: int) -> None:
    """Write where the gain is 1; a loop is fine where that is at its crossover alone."""
    r = work.abreast(w)
    num, den, found, fine = r.num, r.den, r.found, r.fine
    only_at_one(w, n)
    for i in range(LOOPS):
        found[_V, i], r.rest[_MOVES, i] = 1.0, 1.0
    polished(w, n, _V)
    for i in range(LOOPS):
        a, b, _, _ = on_axis(num, n, i, found[_V, i])
        c, d, _, _ = on_axis(den, n, i, found[_V, i])
        found[MARGIN, i] = angle(-(b * c - a * d), -(a * c + b * d))
        wc = frequency(r.plant, i, found[_V, i])
        found[WC, i] = wc
        known = int(wc > 0.0) & int(abs(found[MARGIN, i]) <= pi) & int(fine[i] > 0.0)
        fine[i] = 1.0 if known else 0.0


@compiled
def only_at_one(w: int, n: int) -> None:
    """Write whether the gain is 1 at q = 1 alone, and not at an end of the axis: fine, for now.

    That is where (|num|^2 - |den|^2)/(q - 1) has powers of one sign: those in front of the largest
    power of the dividend are summed from the bottom, the others from the top.
    """
    r = work.abreast(w)
    num, den, gain, rest = r.num, r.den, r.some, r.rest
    for i in range(LOOPS):
        value, bulk, most, largest = 0.0, 0.0, -1.0, 0.0
        for k in range(n + 1):
            term = r.nn[k, i] - r.dd[k, i]
            gain[k, i] = term
            value += term
            size = abs(term)
            bulk += size
            largest = float(k) if size > most else largest
            most = size if size > most else most
        carry = 0.0  # from the top
        for k in range(n - 1, -1, -1):
            carry += gain[k + 1, i]
            rest[k, i] = carry
        carry, highest, lowest = 0.0, 0.0, 0.0  # and from the bottom
        for k in range(n):
            carry -= gain[k, i]
            term = carry if float(k) < largest else rest[k, i]
            highest = term if term > highest else highest
            lowest = term if term < lowest else lowest
        top, bottom = abs(num[n, i]), abs(den[n, i])
        one = int(abs(value) <= AT_ONE * bulk) & (int(highest == 0.0) | int(lowest == 0.0))
        one &= int(abs(top - bottom) > UNITY * bottom)
        one &= int(abs(abs(num[0, i]) - abs(den[0, i])) > UNITY * abs(den[0, i]))
        r.fine[i] = 1.0 if one else 0.0


@compiled
def by_phase(w: int, n: int, degree: int) -> None:
    """Write the gain margin; a loop that crosses more than once is fine no more.

    degree  n - 1, as a number that the compiler knows: of Im L in v^2
    """
    r = work.abreast(w)
    found, fine = r.found, r.fine
    imaginary(w, n, degree)
    only_roots(w, r.some, degree)
    for i in range(LOOPS):
        changes, v = r.search[CHANGES, i], sqrt(r.search[ROOT, i])
        one = int(fine[i] > 0.0) & int(changes == 1.0)
        never = int(fine[i] > 0.0) & int(changes == 0.0)
        fine[i] = 1.0 if one | never else 0.0
        found[_V_180, i], r.rest[_MOVES, i] = v if one else 1.0, 1.0 if one else 0.0
    polished(w, n, _V_180)
    for i in range(LOOPS):
        a, b, _, _ = on_axis(r.num, n, i, found[_V_180, i])
        c, d, _, _ = on_axis(r.den, n, i, found[_V_180, i])
        product, square = a * c + b * d, c * c + d * d
        never = int(r.search[CHANGES, i] == 0.0)
        sure = int(product * product >= 1e-20 * (a * a + b * b) * square) | never
        fine[i] = 1.0 if sure & int(fine[i] > 0.0) else 0.0
        least, gm, v = inf, inf, found[_V_180, i]
        least, gm, v = closer(least, gm, v, 0.0 if never else -square / product, v)
        least, gm, v = closer(least, gm, v, -r.den[0, i] / r.num[0, i], 0.0)
        least, gm, v = closer(least, gm, v, -r.den[n, i] / r.num[n, i], inf)
        found[GM, i], found[W_180, i] = gm, frequency(r.plant, i, v)


@compiled
def imaginary(w: int, n: int, degree: int) -> None:
    """Write a polynomial into ``some``: v turn(v^2) = Im num conj(den) at jv."""
    r = work.abreast(w)
    num, den, turn = r.num, r.den, r.some
    for i in range(LOOPS):
        for k in range(degree + 1):
            total = 0.0
            for j in range(1, n + 1, 2):
                if 0 <= 2 * k + 1 - j <= n:
                    of_num = num[j, i] * den[2 * k + 1 - j, i]
                    total += of_num - num[2 * k + 1 - j, i] * den[j, i]
            turn[k, i] = total if k % 2 == 0 else -total


@compiled
def closer(
    least: float, gm: float, v: float, factor: float, at: float
) -> tuple[float, float, float]:
    """Return (how far it is from 1, the factor that brings L to -1, its v): the nearer of two."""
    away = factor if factor > 1.0 else 1.0 / factor
    good = int(factor > 0.0) & int(factor < inf) & int(away < least)
    return away if good else least, factor if good else gm, at if good else v


@compiled
def by_drop(w: int, n: int) -> None:
    """Write where |T| falls 3 dB below its value at rest, nan if never; fine where that is told."""
    r = work.abreast(w)
    low, found, fine = r.some, r.found, r.fine
    for i in range(LOOPS):
        at_rest = DROP * r.nn[0, i] / r.aa[0, i]
        for k in range(n + 1):
            low[k, i] = r.nn[k, i] - at_rest * r.aa[k, i]
        fine[i] = 1.0 if int(at_rest > 0.0) & int(fine[i] > 0.0) else 0.0
    only_roots(w, low, n)
    for i in range(LOOPS):
        changes = r.search[CHANGES, i]
        told = int(changes == 1.0) | int(changes == 0.0)
        fine[i] = 1.0 if told & int(fine[i] > 0.0) else 0.0
        x = r.search[ROOT, i]
        value, slope = with_slope(low, n, i, x)
        w_drop = frequency(r.plant, i, sqrt(x - value / slope))
        found[W_DROP, i] = w_drop if changes == 1.0 else nan
