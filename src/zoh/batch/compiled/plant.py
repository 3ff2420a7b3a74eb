"""The zero-order hold of one plant; see ``zoh.batch.arrays.held``, its arithmetic."""

from math import pi, sqrt

import numpy as np

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.room import LATE, ORDER, WHOLE
from zoh.batch.compiled.transfer import transfer
from zoh.batch.tolerances import EULERS, SERIES, SLOW, SMALL

NOTHING = 1e-18


def _eulers() -> Array:
    """Return E_k(0)/k!, from 2 = (e^x + 1) sum_k E_k(0)/k! x^k."""
    found = np.zeros(EULERS + 1)
    found[0] = 1.0
    for k in range(1, EULERS + 1):
        weight, total = 1.0, 0.0
        for j in range(k - 1, -1, -1):
            weight /= k - j
            total += found[j] * weight
        found[k] = -total / 2
    return found


EULER = _eulers()
RECIPROCAL = 1.0 / np.maximum(np.arange(SERIES + ORDER + 1.0), 1.0)
_FACTORIAL = np.cumprod(np.concatenate([[1.0], np.arange(1.0, EULERS + 2)]))


@compiled
def held(w: int, n: int, dt: float, lead: float) -> None:
    """Hold a strictly proper p.b/p.a (ascending powers of s, a[n] = 1, overwritten) of order n."""
    if n == 2:  # of the usual order the compiler knows every place beforehand
        hold(w, 2, dt, lead)
    else:
        hold(w, n, dt, lead)


@compiled
def hold(w: int, n: int, dt: float, lead: float) -> None:
    """Do what ``held`` does."""
    p = work.plant(w)
    a, b, h, numbers = p.a, p.b, p.markov, p.numbers
    power = 1.0
    for j in range(n, -1, -1):
        a[j] *= power
        b[j] *= power
        power *= dt
    reach = 0.0
    for j in range(n):
        size = abs(a[j])
        if n - j == 2:
            size = sqrt(size)
        elif n - j > 2:
            size = size ** (1.0 / (n - j))
        reach = max(reach, 2.0 * size)
    numbers[1] = reach
    rest, power = 0, 1.0
    while rest < n and a[rest] == 0.0:
        rest, power = rest + 1, 2.0 * power
    at_rest = power * a[rest] / b[0] if b[0] != 0.0 else 0.0
    unit, halvings = 1.0, 0
    while reach * unit > SMALL and halvings < 60:
        unit, halvings = unit / 2.0, halvings + 1
    numbers[0] = 1.0 / unit
    terms = min(n + needed(reach * unit), SERIES)  # the first n may be 0
    numbers[3] = terms
    euler = 0
    if reach <= SLOW:
        size = 1.0
        while euler < EULERS and (euler < n + 2 or size > NOTHING):
            euler += 1
            size *= reach / pi if euler > n else 1.0
    count = max(terms + n, euler) + 1
    for j in range(count):
        value = b[n - 1 - j] if j < n else 0.0
        for i in range(1, min(j, n) + 1):
            value -= a[n - i] * h[j - i]
        h[j] = value
    at_nyquist = 0.0
    if euler:
        at_nyquist = nyquist(h, euler, lead)
    if halvings:
        power = 1.0
        for j in range(n, -1, -1):
            a[j] *= power
            power *= unit
        power = unit
        for j in range(count):
            h[j] *= power
            power *= unit
    powers_of(a, n, terms, p.rows)
    advanced(w, n, terms, halvings, 1.0, WHOLE)
    for i in range(n):
        p.enters[LATE, i] = 0.0
    if lead > 0.0:
        advanced(w, n, terms, halvings, lead, LATE)
    transfer(p, n)
    if euler:
        p.top[n] = at_nyquist * p.bottom[n]
    numbers[2] = at_rest * p.top[0] / p.bottom[rest] - 1.0 if at_rest != 0.0 else 0.0


@compiled
def needed(reach: float) -> int:
    """Return how many terms the exponential's series needs."""
    m, size = 0, 1.0
    while m < SERIES and size > NOTHING:
        m += 1
        size *= reach * RECIPROCAL[m]
    return m


@compiled
def nyquist(h: Array, count: int, lead: float) -> float:
    """Return the gain at z = -1 from E_k(lead)/k! = sum_j E_j(0)/j! lead^(k-j)/(k-j)!."""
    total = 0.0
    for k in range(1, count + 1):
        value = EULER[k]
        if lead > 0.0:
            power = 1.0
            for j in range(k - 1, -1, -1):
                power *= lead
                value += EULER[j] * power / _FACTORIAL[k - j]
        total += value * h[k - 1]
    return total


@compiled
def powers_of(a: Array, n: int, terms: int, rows: Array) -> None:
    """Write C A^m of the companion matrix for m < n + terms."""
    for m in range(n):
        for j in range(n):
            rows[m, j] = 1.0 if m == j else 0.0
    for m in range(n, n + terms + 1):
        last = rows[m - 1, n - 1]
        for j in range(n - 1, 0, -1):
            rows[m, j] = rows[m - 1, j - 1] - last * a[j]
        rows[m, 0] = -last * a[0]


@shared
def advanced(w: int, n: int, terms: int, halvings: int, t: float, which: int) -> None:
    """Write delta and B over t samples, as the one of this number."""
    if n == 2:
        advance(w, 2, terms, halvings, t, which)
    else:
        advance(w, n, terms, halvings, t, which)


@compiled
def advance(w: int, n: int, terms: int, halvings: int, t: float, which: int) -> None:
    """Do what ``advanced`` does."""
    p = work.plant(w)
    rows, h, delta, b, matrix = p.rows, p.markov, p.delta[which], p.enters[which], p.matrix
    for i in range(n):
        b[i] = 0.0
        for j in range(n):
            delta[i, j] = 0.0
    weight = 1.0
    for m in range(1, terms + 1):
        weight *= t * RECIPROCAL[m]
        for i in range(n):
            b[i] += weight * h[m - 1 + i]
            for j in range(n):
                delta[i, j] += weight * rows[m + i, j]
    for _ in range(halvings):
        for i in range(n):
            total = 2.0 * b[i]
            for j in range(n):
                total += delta[i, j] * b[j]
            matrix[0, i] = total
        for i in range(n):
            b[i] = matrix[0, i]
        for i in range(n):
            for k in range(n):
                total = 2.0 * delta[i, k]
                for j in range(n):
                    total += delta[i, j] * delta[j, k]
                matrix[i, k] = total
        for i in range(n):
            for k in range(n):
                delta[i, k] = matrix[i, k]
