"""Whether one closed loop is stable, by Routh's scheme."""

from math import inf

from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled
from zoh.batch.tolerances import PIVOT


@compiled
def stable(w: int, n: int) -> tuple[bool, bool]:
    """Return (whether the closed loop is stable, whether rounding may have decided it); Routh."""
    if n == 4:  # of the usual degree the compiler knows every place beforehand
        return scheme(w, 4)
    return scheme(w, n)


@compiled
def scheme(w: int, n: int) -> tuple[bool, bool]:
    """Do what ``stable`` does."""
    lines = work.lines(w)
    num, den, c, d = lines.num, lines.den, lines.rest, lines.roots
    size = 0.0
    for k in range(n + 1):
        size = max(size, abs(num[k] + den[k]))
    if not 0.0 < size < inf:
        return False, True
    doubt = False
    for k in (0, n):  # a pole at z = 1, or -1, but for rounding
        doubt = doubt or abs(num[k] + den[k]) <= PIVOT * (abs(num[k]) + abs(den[k]))
    m, rest = n // 2 + 1, (n + 1) // 2
    for k in range(m):
        c[k] = (num[n - 2 * k] + den[n - 2 * k]) / size
    for k in range(rest):
        d[k] = (num[n - 2 * k - 1] + den[n - 2 * k - 1]) / size
    for k in range(rest, m + 1):
        d[k] = 0.0
    sign = 1.0 if c[0] > 0.0 else -1.0
    good = sign * (num[0] + den[0]) > 0.0
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
