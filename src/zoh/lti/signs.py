"""Signs and roots of polynomials in whole numbers: counted or excluded without rounding.

Coefficients are in descending powers.
"""

from collections.abc import Callable
from fractions import Fraction
from itertools import accumulate
from math import frexp, inf, ldexp
from operator import ne

from zoh.lti import divisors
from zoh.lti.whole import Point, Whole, at_fraction, derivative, divided, shifted, trim

_BITS = 72  # of a root: a float has 53
_DEEP = 64  # halvings of what holds all roots; those that are closer are asked whether they are one


def variations(a: Whole) -> int:
    """Return how often the coefficients change sign: at least the number of positive roots.

    The excess over the roots, each counted as often as it is repeated, is even.
    Source: Descartes' rule of signs.

    >>> variations((1, -3, 2))  # roots 1 and 2
    2
    """
    signs = [c > 0 for c in a if c]
    return sum(map(ne, signs, signs[1:]))


def positive_roots(a: Whole) -> int:
    """Return the number of different positive roots.

    >>> positive_roots((1, -3, 2)), positive_roots((1, -2, 1)), positive_roots((1, 0, 1))
    (2, 1, 0)
    """
    return len(_apart(trim(a), divisors.each_once)[1])


def crossings(a: Whole) -> int:
    """Return the number of positive roots of odd multiplicity, at which the sign changes.

    >>> crossings((1, -2, 1)), crossings((1, -3, 3, -1)), crossings((1, -4, 5, -2))
    (0, 1, 1)
    """
    return sum([times % 2 for _, _, times, _ in _apart(trim(a), divisors.odd_once)[1]])


def odd_roots(a: Whole, bits: int = _BITS) -> list[Point]:
    """Return these roots to so many bits, ascending: none is invented, none is missed.

    >>> odd_roots((1, -4, 5, -2))  # (x - 1)^2 (x - 2)
    [(16, 8)]
    """
    high, parts = _apart(trim(a), divisors.odd_once)
    up, down = max(high, 0), max(-high, 0)
    found = [_closed_in(part, bits) for part in parts if part[2] % 2]
    return sorted(
        [(top << up, bottom << down) for top, bottom in found], key=lambda q: Fraction(*q)
    )


def even_roots(a: Whole) -> list[Point]:
    """Return the positive roots at which the sign stays, to 2^-71 of themselves, ascending.

    >>> even_roots((1, -4, 5, -2)), even_roots((1, -3, 3, -1))  # (x - 1)^2 (x - 2), (x - 1)^3
    ([(4, 4)], [])
    """
    if divisors.share_nothing(a, derivative(a)):
        return []
    return odd_roots(divisors.repeated(a))  # a root is there one time less


_Part = tuple[int, int, int, Whole]  # first, depth, times, a: ``times`` one root at first 2^-depth,
# or, with a, the one between 0 and 1 of this polynomial in t at (first + t) 2^-depth


def _apart(a: Whole, simpler: Callable[[Whole], Whole]) -> tuple[int, list[_Part]]:
    """Return (high, where a's positive roots are, counted in 2^high).

    Halved is what may hold several until Descartes' rule says that it does not. What a root that
    is repeated would halve for ever is left to ``simpler``.
    Source: G. E. Collins, A. G. Akritas, Polynomial real root isolation using Descartes' rule of
    signs, Proc. SYMSAC 1976; and Budan's theorem: signs that change as often on both sides of the
    middle leave no root before it.
    """
    found: list[_Part] = []
    if not variations(a):
        return 0, found
    high, deepest = _above(a), float(_DEEP)
    waiting: list[_Part] = [(0, 0, 1, _stretched(a, high))]
    while waiting:
        part = waiting.pop()
        first, depth, _, inside = part
        seen = variations(shifted(inside[::-1]))
        if seen == 1:
            found.append(part)
        elif seen:
            if depth > deepest:
                if len(plain := simpler(a)) < len(a):
                    return _apart(plain, simpler)
                deepest = inf
            left: Whole = [c << i for i, c in enumerate(inside)]
            right, times = shifted(left), 0
            while not right[-1]:  # a root in the middle
                left, times = divided(left, (1, -1)), times + 1
                del right[-1]
            first, depth = 2 * first, depth + 1
            if times:
                found.append((first + 1, depth, times, ()))
            beyond = variations(right)
            if beyond:
                waiting.append((first + 1, depth, 1, right))
            if variations(left) > beyond:
                waiting.append((first, depth, 1, left))
    return high, found


def _above(a: Whole) -> int:
    """Return log2 of a bound on the positive roots: 2 max |a_i/a_0|^(1/i).

    Source: M. Fujiwara, Uber die obere Schranke des absoluten Betrages der Wurzeln einer
    algebraischen Gleichung, Tohoku Math. J. 10, 1916.
    """
    lead = a[0].bit_length() - 1
    return 1 + max([-((lead - c.bit_length()) // i) for i, c in enumerate(a) if i and c])


def _stretched(a: Whole, octaves: int) -> list[int]:
    """Return a(x 2^octaves), times a power of two."""
    n, up, down = len(a) - 1, max(octaves, 0), max(-octaves, 0)
    return [c << (up * (n - i) + down * i) for i, c in enumerate(a)]


def _closed_in(part: _Part, enough: int) -> Point:
    """Return where the root is, to so many bits."""
    first, depth, _, a = part
    if not a:
        return first, 1 << depth
    rising, t, bits = a[-1] < 0, 0, 0  # the root is between t and t + 1, counted in 2^-bits
    while (counted := (first << bits) + t).bit_length() < enough:
        t, bits = 2 * t + 1, bits + 1
        here = at_fraction(a, t, 1 << bits)
        if not here:
            return (first << bits) + t, 1 << depth + bits
        if (here < 0) != rising:
            t -= 1
    return 2 * counted + 1, 2 << depth + bits


def positive(a: Whole, near: float = 0.0) -> str | None:
    """Return how a(x) > 0 for every x > 0 is proved, None where it is not so.

    near  where it is least, if that is known: seen from there, all signs are plain

    >>> positive((1, 2, 3)), positive((100, -200, 101), near=1.0), positive((1, -3, 2))
    ('Descartes', 'Descartes', None)
    """
    a = trim(a)
    if not a or a[0] < 0 or a[-1] < 0:
        return None
    if (0 < near < inf and _above_both_ways(a, near)) or not variations(a):
        return "Descartes"
    return None if positive_roots(a) else "halving"


def _above_both_ways(a: Whole, near: float) -> bool:
    """Return whether a is plainly positive above and below ``near``, there with 1/x for x."""
    mantissa, exponent = frexp(near)
    top, bottom = int(ldexp(mantissa, 32)), 32 - exponent
    if bottom < 0:
        top, bottom = top << -bottom, 0
    scaled, up, bits = [], 1, bottom * (len(a) - 1)
    for c in reversed(a):
        scaled.append(c * up << bits)
        up, bits = up * top, bits - bottom
    return _positive_beyond_one(scaled) and _positive_beyond_one(scaled[::-1])


def _positive_beyond_one(a: Whole) -> bool:
    """Return whether a(1 + t) > 0 for t >= 0 is plain: c0 + c1 t + c2 t^2 > 0, no other ci < 0.

    Divided by x - 1 again and again, the remainders are the ci; once a quotient has no coefficient
    below 0, no later one has.
    """
    *a, c0 = accumulate(a)
    if c0 <= 0 or not a:
        return c0 > 0
    *a, c1 = accumulate(a)
    if c1 < 0 and c1 * c1 >= 4 * c0 * sum(a):  # which is c2
        return False
    while a and min(a) < 0:
        *a, remainder = accumulate(a)
        if remainder < 0:
            return False
    return True


def hurwitz(a: Whole, lost: list[int] | None = None) -> bool:
    """Return whether every root has a negative real part; a missing leading power says no.

    In w a leading zero is a root at infinity, z = -1, on the boundary.
    Each row is divided by the lead of the third before it, exactly: what is left are minors of
    Hurwitz's matrix, and grow no faster than these.
    Source: F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV (Routh's scheme); R. Jeltsch,
    An optimal fraction free Routh array, Int. J. Control 30(4), 1979.

    lost  a list to which the bits are added that cancel in each pivot that is a difference

    >>> hurwitz((1, 2, 3)), hurwitz((1, 0, 3))
    (True, False)
    >>> lost: list[int] = []
    >>> hurwitz((1, 1 << 20, 1, (1 << 20) - 1), lost), lost  # 1 << 20 less the last one
    (True, [20, 0])
    """
    if len(a) == 1:
        return a[0] != 0
    if a[0] == 0:
        return False
    if a[0] < 0:
        a = [-c for c in a]
    upper, lower = a[0::2], a[1::2]
    divisor, next_one = 1, 1
    while lower:
        if lower[0] <= 0:
            return False
        first, second, below = upper[0], lower[0], [*lower, 0]  # one more where it is shorter
        rest = [(second * upper[i] - first * below[i]) // divisor for i in range(1, len(upper))]
        if lost is not None and rest:
            terms = second.bit_length() + upper[1].bit_length() - divisor.bit_length()
            lost.append(terms - rest[0].bit_length())
        divisor, next_one = next_one, second
        upper, lower = lower, rest
    return True
