"""Where the gain of loops side by side is 1, and where they turn by -180 deg.

The usual loop has one of each, and Descartes' rule says so: what has more goes to
``zoh.batch.compiled.margins``, one at a time.
"""

from math import inf, nan, pi, sqrt

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.abreast.angles import angle
from zoh.batch.compiled.abreast.room import DT, LOOPS, X
from zoh.batch.compiled.abreast.rows import CHANGES, ROOT, on_axis, only_roots
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.margins import AT_ONE, LAST, POLISH
from zoh.batch.tolerances import DROP, UNITY

# rows of what is found: v where the gain is 1, then rad/s, the turn from -180 deg there, a delay
# that needs no turn; the factor that brings L to -1, v, then rad/s; where |T| has fallen by 3 dB
_V, WC, TURN, LATE, GM, _V_180, W_180, W_DROP = range(8)


@compiled
def frequency(plant: Array, i: int, v: float) -> float:
    """Return rad/s of u = jv in lane i; u = p/x."""
    return float(2.0 / plant[DT, i] * angle(plant[X, i] * v, 1.0))


@compiled
def by_gain(w: int, n: int) -> None:
    """Write where the gain is 1; the loop is FINE where that is at its crossover alone."""
    r = work.abreast(w)
    num, den, gain, rest, found, fine = r.num, r.den, r.some, r.rest, r.found, r.fine
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
        carry = 0.0  # gain/(q - 1), of its terms in front of the largest one
        for k in range(n - 1, -1, -1):
            carry += gain[k + 1, i]
            rest[k, i] = carry
        carry, highest, lowest = 0.0, 0.0, 0.0
        for k in range(n):
            carry -= gain[k, i]
            term = carry if float(k) < largest else rest[k, i]
            highest = term if term > highest else highest
            lowest = term if term < lowest else lowest
        top, bottom = abs(num[n, i]), abs(den[n, i])
        one = int(abs(value) <= AT_ONE * bulk) & (int(highest == 0.0) | int(lowest == 0.0))
        one &= int(abs(top - bottom) > UNITY * bottom)
        one &= int(abs(abs(num[0, i]) - abs(den[0, i])) > UNITY * abs(den[0, i]))
        fine[i] = 1.0 if one else 0.0
        found[_V, i], found[LATE, i] = 1.0, inf if top < bottom else r.plant[DT, i]
    for i in range(LOOPS):
        rest[0, i] = 1.0  # where it still moves
    for _ in range(POLISH):
        far = 0
        for i in range(LOOPS):
            v, moves = found[_V, i], rest[0, i]
            a, b, of_a, of_b = on_axis(num, n, i, v)
            c, d, of_c, of_d = on_axis(den, n, i, v)
            square_n, square_d = a * a + b * b, c * c + d * d
            slope = -((of_b * a - of_a * b) / square_n - (of_d * c - of_c * d) / square_d)
            step = (square_n - square_d) / ((square_n + square_d) * slope)
            on = int(abs(step) > LAST * v) & int(moves > 0.0)
            found[_V, i] = v - step if moves > 0.0 else v
            rest[0, i] = 1.0 if on else 0.0
            far |= on
        if far == 0:
            break
    for i in range(LOOPS):
        a, b, _, _ = on_axis(num, n, i, found[_V, i])
        c, d, _, _ = on_axis(den, n, i, found[_V, i])
        found[TURN, i] = angle(-(b * c - a * d), -(a * c + b * d))
        wc = frequency(r.plant, i, found[_V, i])
        found[WC, i] = wc
        known = int(wc > 0.0) & int(abs(found[TURN, i]) <= pi) & int(fine[i] > 0.0)
        fine[i] = 1.0 if known else 0.0


@compiled
def by_phase(w: int, n: int, degree: int) -> None:
    """Write the gain margin; a loop that crosses more than once is FINE no more.

    degree  n - 1, as a number that the compiler knows: of Im L in v^2
    """
    r = work.abreast(w)
    num, den, turn, found, fine = r.num, r.den, r.some, r.found, r.fine
    for i in range(LOOPS):  # Im num conj(den) = v turn(v^2)
        for k in range(degree + 1):
            total = 0.0
            for j in range(1, n + 1, 2):
                if 0 <= 2 * k + 1 - j <= n:
                    of_num = num[j, i] * den[2 * k + 1 - j, i]
                    total += of_num - num[2 * k + 1 - j, i] * den[j, i]
            turn[k, i] = total if k % 2 == 0 else -total
    only_roots(w, turn, degree)
    for i in range(LOOPS):
        changes, v = r.search[CHANGES, i], sqrt(r.search[ROOT, i])
        one = int(fine[i] > 0.0) & int(changes == 1.0)
        fine[i] = 1.0 if one | (int(fine[i] > 0.0) & int(changes == 0.0)) else 0.0
        found[_V_180, i] = v if one else 1.0
        r.rest[0, i] = 1.0 if one else 0.0
    for _ in range(POLISH):
        far = 0
        for i in range(LOOPS):
            v, moves = found[_V_180, i], r.rest[0, i]
            a, b, of_a, of_b = on_axis(num, n, i, v)
            c, d, of_c, of_d = on_axis(den, n, i, v)
            step = (b * c - a * d) / (of_a * c + of_b * d - a * of_c - b * of_d)
            on = int(abs(step) > LAST * v) & int(moves > 0.0)
            found[_V_180, i] = v - step if moves > 0.0 else v
            r.rest[0, i] = 1.0 if on else 0.0
            far |= on
        if far == 0:
            break
    for i in range(LOOPS):
        a, b, _, _ = on_axis(num, n, i, found[_V_180, i])
        c, d, _, _ = on_axis(den, n, i, found[_V_180, i])
        product, square = a * c + b * d, c * c + d * d
        never = int(r.search[CHANGES, i] == 0.0)
        sure = int(product * product >= 1e-20 * (a * a + b * b) * square) | never
        fine[i] = 1.0 if sure & int(fine[i] > 0.0) else 0.0
        factor = -square / product
        nearest, gm, v = inf, inf, found[_V_180, i]
        good = int(factor > 0.0) & int(factor < inf) & (1 - never)
        away = factor if factor > 1.0 else 1.0 / factor
        nearest, gm = away if good else nearest, factor if good else gm
        factor = -den[0, i] / num[0, i]
        away = factor if factor > 1.0 else 1.0 / factor
        good = int(factor > 0.0) & int(factor < inf) & int(away < nearest)
        nearest, gm, v = away if good else nearest, factor if good else gm, 0.0 if good else v
        factor = -den[n, i] / num[n, i]
        away = factor if factor > 1.0 else 1.0 / factor
        good = int(factor > 0.0) & int(factor < inf) & int(away < nearest)
        gm, v = factor if good else gm, inf if good else v
        found[GM, i], found[W_180, i] = gm, frequency(r.plant, i, v)


@compiled
def by_drop(w: int, n: int) -> None:
    """Write where |T| falls 3 dB below its value at rest, nan if never; FINE where that is told."""
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
        value, slope = low[n, i], 0.0
        for k in range(n - 1, -1, -1):
            slope = slope * x + value
            value = value * x + low[k, i]
        w_drop = frequency(r.plant, i, sqrt(x - value / slope))
        found[W_DROP, i] = w_drop if changes == 1.0 else nan
