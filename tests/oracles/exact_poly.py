"""Polynomials with Fraction coefficients, ascending powers, and their real roots."""

from fractions import Fraction
from itertools import zip_longest

from mpmath import mp, mpc, mpf

ZERO, ONE = Fraction(0), Fraction(1)


def trim(a):
    a = list(a)
    while len(a) > 1 and a[-1] == 0:
        a.pop()
    return a


def mul(a, b):
    out = [ZERO] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i + j] += x * y
    return trim(out)


def add(a, b, sign=1):
    return trim(x + sign * y for x, y in zip_longest(a, b, fillvalue=ZERO))


def slope(a):
    return trim([c * i for i, c in enumerate(a)][1:] or [ZERO])


def divide(a, b):
    """Return quotient and remainder."""
    a, out = list(a), [ZERO] * max(len(a) - len(b) + 1, 1)
    for i in range(len(a) - len(b), -1, -1):
        out[i] = a[i + len(b) - 1] / b[-1]
        for j, y in enumerate(b):
            a[i + j] -= out[i] * y
    return trim(out), trim(a[: len(b) - 1] or [ZERO])


def gcd(a, b):
    while any(b):
        rest = divide(a, b)[1]
        size = max(abs(c) for c in rest) or ONE
        a, b = b, [c / size for c in rest]
    return a


def squarefree(a):
    return divide(a, gcd(a, slope(a)))[0] if len(a) > 1 else a


def horner(a, x):
    value = mpf(0) * x
    for c in reversed(a):
        value = value * x + mpf(c.numerator) / mpf(c.denominator)
    return value


def roots_between(a, top):
    """Return the real roots of ``a`` strictly inside (0, top), top None for infinity."""
    a = trim(a)
    while len(a) > 1 and a[0] == 0:
        a = a[1:]
    while top is not None and len(a) > 1 and sum(c * top**i for i, c in enumerate(a)) == 0:
        a = divide(a, [-top, ONE])[0]
    if len(a) < 2:
        return []
    a = squarefree(a)
    n = len(a) - 1
    # the variable is scaled by a power of two so that first and last coefficient match
    lead = abs(a[0] / a[-1])
    shift = round((lead.numerator.bit_length() - lead.denominator.bit_length()) / n)
    a = [c * Fraction(2) ** (shift * i) for i, c in enumerate(a)]
    with mp.workdps(160):
        top_first = [mpf(c.numerator) / mpf(c.denominator) for c in reversed(a)]
        found = mp.polyroots(top_first, maxsteps=2000, extraprec=1200, cleanup=False)
        real = [r.real for r in map(mpc, found) if abs(r.imag) < abs(r) * mpf(10) ** -60]
        scale = mpf(2) ** shift
        return sorted(r * scale for r in real if r > 0 and (top is None or r * scale < top))
