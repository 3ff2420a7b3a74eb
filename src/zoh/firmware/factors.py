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

    Roots at z = 1, 0 and -1, as integrators, delays and Tustin's rule leave them, are exact, as a
    rest of degree 2 is. A pair of real or conjugate roots is put together exactly.
    """
    if len(a) <= 3:
        return [tuple(c / a[0] for c in a)] if len(a) > 1 else []
    real, rest = _taken_out(a)
    if len(rest) == 3 and len(real) % 2 == 0:
        return sorted([*_paired(real), *quadratics(rest)], key=_size, reverse=True)
    found = poly.roots(tuple(float(c / rest[0]) for c in rest))
    real = sorted([*real, *(Fraction(r.real) for r in found if r.imag == 0)], key=abs)
    factors: list[Exact] = []
    for r in found:
        if r.imag > 0:
            re, im = Fraction(r.real), Fraction(r.imag)
            factors.append((Fraction(1), -2 * re, re * re + im * im))
    return sorted([*factors, *_paired(real)], key=_size, reverse=True)


def _paired(real: list[Fraction]) -> list[Exact]:
    """Return a factor for each two roots, the smallest together, and one for what is left."""
    factors = []
    for i in range(0, len(real), 2):
        factor: Exact = (Fraction(1),)
        for root in real[i : i + 2]:
            factor = product(factor, (Fraction(1), -root))
        factors.append(factor)
    return factors


def _taken_out(a: Exact) -> tuple[list[Fraction], Exact]:
    """Return the roots at d = 0, -1 and -2, each as often as it is one, and what they leave.

    >>> one = Fraction(1)
    >>> _taken_out(product((one, one), product((one, one), (one, 3 * one))))
    ([Fraction(-1, 1), Fraction(-1, 1)], (Fraction(1, 1), Fraction(3, 1)))
    """
    roots = []
    for root in (Fraction(0), Fraction(-1), Fraction(-2)):
        while len(a) > 1 and value(a, root) == 0:
            roots.append(root)
            left = [a[0]]
            for c in a[1:-1]:
                left.append(c + root * left[-1])
            a = tuple(left)
    return roots, a


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
