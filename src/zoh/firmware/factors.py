"""Polynomials in fractions, and their factors of degree 2."""

from fractions import Fraction
from itertools import zip_longest

from zoh.lti import poly

Exact = tuple[Fraction, ...]  # coefficients in d, descending powers


def product(a: Exact, b: Exact) -> Exact:
    """Return the product of two polynomials."""
    out = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i + j] += x * y
    return tuple(out)


def plus(a: Exact, b: Exact) -> Exact:
    """Return the sum of two polynomials."""
    pairs = zip_longest(reversed(a), reversed(b), fillvalue=Fraction(0))
    return tuple(x + y for x, y in pairs)[::-1]


def value(a: Exact, x: Fraction) -> Fraction:
    """Return a(x)."""
    total = Fraction(0)
    for c in a:
        total = total * x + c
    return total


def quadratics(a: Exact) -> list[Exact]:
    """Return factors of degree 2, and one of degree 1 where there must be, smallest roots last.

    The roots at d = 0 are exact. A pair of real or conjugate roots is put together exactly.
    """
    if len(a) <= 3:
        return [tuple(c / a[0] for c in a)] if len(a) > 1 else []
    found = poly.roots(tuple(float(c / a[0]) for c in a))
    real = sorted((r.real for r in found if r.imag == 0), key=abs)
    factors: list[Exact] = []
    for r in found:
        if r.imag > 0:
            re, im = Fraction(r.real), Fraction(r.imag)
            factors.append((Fraction(1), -2 * re, re * re + im * im))
    for i in range(0, len(real), 2):
        factor: Exact = (Fraction(1),)
        for root in real[i : i + 2]:
            factor = product(factor, (Fraction(1), -Fraction(root)))
        factors.append(factor)
    return sorted(factors, key=_size, reverse=True)


def _size(factor: Exact) -> tuple[float, float]:
    """Return how far from 0 the roots of a factor are; what has a root there comes first."""
    n = len(factor) - 1
    away = float(abs(factor[-1])) ** (1 / n)
    return away, float(abs(factor[1]))


def matched(zeros: list[Exact], poles: list[Exact]) -> list[tuple[Exact, Exact]]:
    """Return each pole factor with a zero factor of no higher degree, the nearest that is left."""
    left = list(zeros)
    pairs: list[tuple[Exact, Exact]] = []
    for bottom in reversed(poles):  # the slowest choose first
        spare = sum(len(p) == 3 for p in poles) - sum(len(b) == 3 for _, b in pairs)
        wanted = sum(len(z) == 3 for z in left)
        fits = [z for z in left if len(z) <= len(bottom)]
        if len(bottom) == 3 and wanted == spare and wanted:
            fits = [z for z in fits if len(z) == 3]
        if fits:
            near = min(fits, key=lambda z: abs(_size(z)[0] - _size(bottom)[0]))
            left.remove(near)
        else:
            near = (Fraction(1),)
        pairs.append((near, bottom))
    return pairs[::-1]
