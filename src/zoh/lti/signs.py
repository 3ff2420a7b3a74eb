"""Signs and roots of polynomials in whole numbers: counted or excluded without rounding.

Coefficients are in descending powers.
"""

from math import frexp, gcd, inf, ldexp
from operator import ne

from zoh.lti.whole import Whole, shifted, trim

_PRIME = (1 << 61) - 1


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
    """Return the number of different positive roots, by Sturm's chain.

    Source: F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV, sec. 2 (Sturm's theorem).

    >>> positive_roots((1, -3, 2)), positive_roots((1, -2, 1)), positive_roots((1, 0, 1))
    (2, 1, 0)
    """
    chain = [trim(a)]
    if len(chain[0]) < 2:
        return 0
    chain.append(_derivative(chain[0]))
    while len(chain[-1]) > 1:
        rest = _negative_remainder(chain[-2], chain[-1])
        if not rest:
            break
        chain.append(rest)
    return variations([b[-1] for b in chain]) - variations([b[0] for b in chain])


def crossings(a: Whole) -> int:
    """Return the number of positive roots of odd multiplicity, at which the sign changes.

    >>> crossings((1, -2, 1)), crossings((1, -3, 3, -1)), crossings((1, -4, 5, -2))
    (0, 1, 1)
    """
    # the roots of the k-th repeated divisor are those of multiplicity k + 1 and more
    total, sign, rest = 0, 1, trim(a)
    while len(rest) > 1:
        total += sign * positive_roots(rest)
        rest, sign = repeated(rest), -sign
    return total


def repeated(a: Whole) -> list[int]:
    """Return the greatest common divisor of a and its derivative, up to a factor.

    >>> repeated((1, -4, 5, -2))  # (x - 1)^2 (x - 2)
    [1, -1]
    """
    return common(a, _derivative(a))


def common(a: Whole, b: Whole) -> list[int]:
    """Return the greatest common divisor, its coefficients without a common factor.

    >>> common((2, 2), (1, 0, -1))
    [1, 1]
    """
    one, other = _led(a), _led(b)
    if len(one) < len(other):
        one, other = other, one
    while other:
        one, other = other, _negative_remainder(one, other)
    one = _reduced(one)
    return one if one[0] > 0 else [-c for c in one]


def share_nothing(a: Whole, b: Whole) -> bool:
    """Return whether no root is common to both, where a look modulo a prime can tell.

    What is common to both is so modulo a prime, too, unless that divides both leads.

    >>> share_nothing((1, 2), (1, 0, -1)), share_nothing((1, 1), (1, 0, -1))
    (True, False)
    """
    one, other = ([c % _PRIME for c in _led(x)] for x in (a, b))
    if not (one and other and (one[0] or other[0])):
        return False
    while other := _led(other):
        inverse = pow(other[0], -1, _PRIME)
        while len(one) >= len(other):
            factor = one[0] * inverse
            for i, c in enumerate(other):
                one[i] = (one[i] - factor * c) % _PRIME
            del one[0]
        one, other = other, one
    return len(one) == 1


def _led(a: Whole) -> list[int]:
    """Return the coefficients from the first that is not 0 on."""
    first = next((i for i, c in enumerate(a) if c), len(a))
    return list(a[first:])


def _derivative(a: Whole) -> list[int]:
    n = len(a) - 1
    return [c * (n - i) for i, c in enumerate(a[:-1])]


def _negative_remainder(a: Whole, b: Whole) -> list[int]:
    """Return -(a mod b) times a positive number, its coefficients without a common factor."""
    rest, lead = list(a), abs(b[0])
    sign = 1 if b[0] > 0 else -1
    while len(rest) >= len(b):
        factor = sign * rest[0]
        for i in range(len(rest)):
            rest[i] = lead * rest[i] - (factor * b[i] if i < len(b) else 0)
        del rest[0]
    return _reduced([-c for c in _led(rest)])


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
    return None if positive_roots(a) else "Sturm"


def _above_both_ways(a: Whole, near: float) -> bool:
    """Return whether a is plainly positive above and below ``near``, there with 1/x for x."""
    mantissa, exponent = frexp(near)
    top, bottom = int(ldexp(mantissa, 32)), 32 - exponent
    if bottom < 0:
        top, bottom = top << -bottom, 0
    n, scaled = len(a) - 1, []
    up = 1
    for i in range(n, -1, -1):  # power n - i
        scaled.append((a[i] * up) << (bottom * i))
        up *= top
    return _plainly_positive(shifted(scaled)) and _plainly_positive(shifted(scaled[::-1]))


def _plainly_positive(a: Whole) -> bool:
    """Return whether a(x) > 0 for x >= 0 is seen at a glance: c0 + c1 x + c2 x^2 > 0, rest >= 0."""
    if a[-1] <= 0 or min(a[:-2], default=0) < 0:
        return False
    if len(a) < 2 or a[-2] >= 0:
        return True
    return len(a) > 2 and a[-2] ** 2 < 4 * a[-1] * a[-3]


def hurwitz(a: Whole) -> bool:
    """Return whether every root has a negative real part; a missing leading power says no.

    In w a leading zero is a root at infinity, z = -1, on the boundary.
    Each row is divided by the lead of the third before it, exactly: what is left are minors of
    Hurwitz's matrix, and grow no faster than these.
    Source: F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV (Routh's scheme); R. Jeltsch,
    An optimal fraction free Routh array, Int. J. Control 30(4), 1979.

    >>> hurwitz((1, 2, 3)), hurwitz((1, 0, 3))
    (True, False)
    """
    if len(a) == 1:
        return a[0] != 0
    if a[0] == 0:
        return False
    sign = 1 if a[0] > 0 else -1
    upper, lower = [sign * c for c in a[0::2]], [sign * c for c in a[1::2]]
    divisor, next_one = 1, 1
    while lower:
        if lower[0] <= 0:
            return False
        first, second, below = upper[0], lower[0], [*lower, 0]  # one more where it is shorter
        rest = [(second * upper[i] - first * below[i]) // divisor for i in range(1, len(upper))]
        divisor, next_one = next_one, second
        upper, lower = lower, rest
    return True


def _reduced(a: list[int]) -> list[int]:
    common = gcd(*a)
    return [c // common for c in a] if common > 1 else a
