"""Polynomials with whole-number coefficients and their real roots, without one rounding.

A float is a whole number times a power of two, so a loop's polynomials are exact here. Roots
are isolated by Descartes' rule of signs on halved intervals: an interval with no sign variation
holds no root, one with one variation holds one, anything else is halved again. The result is a
proof, not a search. Coefficients are in ascending powers.
Source: G. E. Collins, A. G. Akritas, Polynomial real root isolation using Descartes' rule of
signs, SYMSAC 1976.
"""

from collections.abc import Iterable
from functools import reduce
from itertools import pairwise, zip_longest
from math import gcd

from mpmath import mp, mpf

Poly = list[int]
Dyadic = tuple[int, int]  # (c, k) is c / 2**k

_PRIME = 2**61 - 1
RELATIVE_BITS = 420  # of a refined root; 120 decimal digits


def dyadic(value: float | mpf) -> tuple[int, int]:
    """Return (m, e) with value = m * 2**e exactly.

    >>> dyadic(0.75)
    (3, -2)
    """
    sign, man, exp, _ = mpf(value)._mpf_ if not isinstance(value, mpf) else value._mpf_
    return (-int(man) if sign else int(man)), int(exp)


def integers(*polys: Iterable[float | mpf]) -> list[Poly]:
    """Return the polynomials times one common power of two, as whole numbers.

    >>> integers([0.5, 1.0], [0.25])
    [[2, 4], [1]]
    """
    parts = [[dyadic(c) for c in a] for a in polys]
    least = min((e for a in parts for m, e in a if m), default=0)
    return [[m << (e - least) if m else 0 for m, e in a] for a in parts]


def trim(a: Iterable[int]) -> Poly:
    out = list(a)
    while len(out) > 1 and out[-1] == 0:
        out.pop()
    return out


def add(a: Poly, b: Poly, factor: int = 1) -> Poly:
    return trim(x + factor * y for x, y in zip_longest(a, b, fillvalue=0))


def mul(a: Poly, b: Poly) -> Poly:
    out = [0] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        if x:
            for j, y in enumerate(b):
                out[i + j] += x * y
    return trim(out)


def slope(a: Poly) -> Poly:
    return trim([i * c for i, c in enumerate(a)][1:] or [0])


def value(a: Poly, at: Dyadic) -> mpf:
    """Return a(c/2**k), rounded once."""
    c, k = at
    return mpf((0, 0, 0, 0)) if not any(a) else mp.ldexp(mpf(_scaled(a, c, k)), -k * (len(a) - 1))


def sign(a: Poly, at: Dyadic) -> int:
    """Return the sign of a(c/2**k)."""
    here = _scaled(a, *at)
    return (here > 0) - (here < 0)


def _scaled(a: Poly, c: int, k: int) -> int:
    total, shift = a[-1], 0
    for x in reversed(a[:-1]):
        shift += k
        total = total * c + (x << shift)
    return total


def roots(a: Poly) -> list[tuple[Dyadic, bool]]:
    """Return every root y of ``a`` strictly inside (0, 1), ascending, once each.

    With it comes whether ``a`` changes sign there (False: it touches zero).

    >>> found = roots([1, -6, 8])  # (1 - 2y)(1 - 4y)
    >>> [float(c / 2**k) for (c, k), _ in found]
    [0.25, 0.5]
    """
    if not any(a):
        raise ArithmeticError("the zero polynomial has every root")
    inside = _inside(trim(a))
    free = _squarefree(inside)
    found = [_refined(free, left, right) for left, right in _isolated(free)]
    return sorted(((at, _flips(inside, at)) for at in found), key=lambda r: number(r[0]))


def number(at: Dyadic) -> mpf:
    return mp.ldexp(mpf(at[0]), -at[1])


def _flips(a: Poly, at: Dyadic) -> bool:
    """Return whether ``a`` has different signs just left and just right of a root."""
    c, k = at
    lift = max(0, RELATIVE_BITS - c.bit_length())
    return sign(a, ((c << lift) - 1, k + lift)) * sign(a, ((c << lift) + 1, k + lift)) < 0


def _inside(a: Poly) -> Poly:
    """Return ``a`` without its roots at 0 and at 1."""
    while a[0] == 0:
        a = a[1:]
    while len(a) > 1 and sum(a) == 0:
        a = _without(a)
    return a


def _without(a: Poly) -> Poly:
    """Return a/(1 - y) for an ``a`` with a root at 1."""
    out, total = [], 0
    for c in a[:-1]:
        total += c
        out.append(total)
    return trim(out)


def _isolated(a: Poly) -> list[tuple[Dyadic, Dyadic]]:
    """Return open intervals with one root each, or a root twice where it is dyadic."""
    n = len(a) - 1
    found, stack = [], [(a, 0, 0)]
    while stack:
        p, c, k = stack.pop()
        count = _variations(p)
        if count == 0:
            continue
        if count == 1:
            found.append(((c, k), (c + 1, k)))
            continue
        left = [x << (n - i) for i, x in enumerate(p)]
        right = _shifted(left)
        if right[0] == 0:
            found.append(((2 * c + 1, k + 1), (2 * c + 1, k + 1)))
            left, right = [*_without(left), 0], [*right[1:], 0]
            left, right = (x + [0] * (n + 1 - len(x)) for x in (left, right))
        stack += [(left, 2 * c, k + 1), (right, 2 * c + 1, k + 1)]
    return found


def _shifted(p: Poly) -> Poly:
    """Return p(x + 1)."""
    out = list(p)
    for i in range(len(out) - 1):
        for j in range(len(out) - 2, i - 1, -1):
            out[j] += out[j + 1]
    return out


def _variations(p: Poly) -> int:
    """Return the sign variations of (x + 1)**n p(1/(x + 1)): at least the roots in (0, 1)."""
    signs = [c > 0 for c in _shifted(p[::-1]) if c]
    return sum(x != y for x, y in pairwise(signs))


def _refined(a: Poly, left: Dyadic, right: Dyadic) -> Dyadic:
    """Return the root between two dyadic numbers by halving, RELATIVE_BITS of it."""
    if left == right:
        return left
    (c, k), below = left, sign(a, left)
    if below == 0:  # a root of ``a`` may sit on the border of its neighbour's interval
        below = -sign(a, right)
    while c.bit_length() < RELATIVE_BITS:
        c, k = 2 * c, k + 1
        here = sign(a, (c + 1, k))
        if here == 0:
            return c + 1, k
        if here == below:
            c += 1
    return 2 * c + 1, k + 1


def _squarefree(a: Poly) -> Poly:
    if len(a) < 3 or _squarefree_modulo(a):
        return a
    return _quotient(a, _common(a, slope(a)))


def _squarefree_modulo(a: Poly) -> bool:
    """Return True where ``a`` has no repeated factor modulo a prime: then it has none at all."""
    x, y = ([c % _PRIME for c in p] for p in (a, slope(a)))
    if not x[-1]:
        return False
    y = trim(y)
    while any(y):
        inverse = pow(y[-1], -1, _PRIME)
        while len(x) >= len(y):
            factor, at = x[-1] * inverse % _PRIME, len(x) - len(y)
            for i, c in enumerate(y):
                x[at + i] = (x[at + i] - factor * c) % _PRIME
            x.pop()
        x, y = y, trim(x or [0])
    return len(x) == 1


def _primitive(a: Poly) -> Poly:
    divisor = reduce(gcd, a) or 1
    return [c // divisor for c in a]


def _common(a: Poly, b: Poly) -> Poly:
    """Return the greatest common divisor, by pseudo-remainders without their content."""
    a, b = _primitive(a), _primitive(b)
    while any(b):
        rest = list(a)
        while len(rest) >= len(b) and any(rest):
            factor, at = rest[-1], len(rest) - len(b)
            rest = [c * b[-1] for c in rest]
            for i, c in enumerate(b):
                rest[at + i] -= factor * c
            rest = trim(rest[:-1] or [0])
        a, b = b, _primitive(trim(rest))
    return a


def _quotient(a: Poly, b: Poly) -> Poly:
    """Return a/b up to a factor, b dividing a."""
    rest, out = list(a), []
    while len(rest) >= len(b):
        scale = b[-1] // gcd(rest[-1], b[-1])
        rest, out = [c * scale for c in rest], [c * scale for c in out]
        factor, at = rest[-1] // b[-1], len(rest) - len(b)
        for i, c in enumerate(b):
            rest[at + i] -= factor * c
        out.append(factor)
        rest.pop()
    return _primitive(out[::-1])
