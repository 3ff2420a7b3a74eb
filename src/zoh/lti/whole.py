"""Polynomials with whole-number coefficients: floats taken exactly, so that signs are certain.

A float is a whole number times a power of two, and so is every sum and product of floats. What
is decided here, a sign or a count of roots, is decided without rounding. Coefficients are in
descending powers; a common factor of a power of two is immaterial and left out.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import frexp, gcd, inf, ldexp, sqrt

Whole = Sequence[int]


def of(*polynomials: Sequence[float]) -> tuple[list[list[int]], int]:
    """Return (wholes, unit): the polynomials times unit, the least power of two that serves all.

    >>> of((0.5, 1.0), (0.25,))
    ([[2, 4], [1]], 4)
    """
    ratios = [[c.as_integer_ratio() for c in a] for a in polynomials]
    unit = max([bottom for a in ratios for _, bottom in a])
    return [[top * (unit // bottom) for top, bottom in a] for a in ratios], unit


def times(a: Whole, b: Whole) -> list[int]:
    """Return the product a b.

    >>> times((1, 1), (1, -1))
    [1, 0, -1]
    """
    out = [0] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        if x:
            for j, y in enumerate(b, i):
                out[j] += x * y
    return out


def power(a: Whole, n: int) -> list[int]:
    """Return a to the n-th power, n >= 0.

    >>> power((1, 1), 3)
    [1, 3, 3, 1]
    """
    out = [1]
    for _ in range(n):
        out = times(out, a)
    return out


def plus(a: Whole, b: Whole, factor: int = 1) -> list[int]:
    """Return a + factor b.

    >>> plus((1, 2), (3,), -1)
    [1, -1]
    """
    if len(a) != len(b):
        n = max(len(a), len(b))
        a, b = [0] * (n - len(a)) + list(a), [0] * (n - len(b)) + list(b)
    return [x + factor * y for x, y in zip(a, b, strict=True)]


def trim(a: Whole) -> list[int]:
    """Return ``a`` without leading and trailing zeros: the same roots but for those at 0.

    >>> trim((0, 1, 2, 0))
    [1, 2]
    """
    nonzero = [i for i, c in enumerate(a) if c]
    return list(a[nonzero[0] : nonzero[-1] + 1]) if nonzero else []


def at(a: Whole, x: float) -> int:
    """Return a(x) times a power of two that depends on x and the degree alone.

    >>> at((4, 1), 0.25), at((0, 1), 0.25)  # 2 and 1, times 4
    (8, 4)
    """
    return at_fraction(a, *x.as_integer_ratio())


def at_fraction(a: Whole, top: int, bottom: int) -> int:
    """Return a(top/bottom) times bottom to the power of the degree.

    >>> at_fraction((4, 1), 1, 4)
    8
    """
    value, unit = a[0], 1
    for c in a[1:]:
        unit *= bottom
        value = value * top + c * unit
    return value


def root_of_ratio(top: int, bottom: int) -> float:
    """Return sqrt(top/bottom), also where that fraction is beyond a float and its root is not.

    >>> root_of_ratio(9, 4), root_of_ratio(10**600, 10**200)
    (1.5, 1e+200)
    """
    half = (top.bit_length() - bottom.bit_length()) // 2
    part = top / (bottom << 2 * half) if half >= 0 else (top << -2 * half) / bottom
    return ldexp(sqrt(part), half)


def size(a: Whole, octaves: int) -> int:
    """Return how many bits the largest coefficient of a(x 2**octaves) has.

    >>> size((3, 0, 1), octaves=1)
    4
    """
    n = len(a) - 1
    return max((c.bit_length() + octaves * (n - i) for i, c in enumerate(a) if c), default=0)


def floats(a: Whole, octaves: int, bits: int) -> list[float]:
    """Return a(x 2**octaves) 2**-bits, each coefficient the nearest float.

    Raises OverflowError where one is beyond a float's range.

    >>> floats((3, 0, 1), octaves=1, bits=1)
    [6.0, 0.0, 0.5]
    """
    down, out = bits - octaves * (len(a) - 1), []
    for c in a:
        out.append(c / (1 << down) if down >= 0 else float(c << -down))
        down += octaves
    return out


def variations(a: Whole) -> int:
    """Return how often the coefficients change sign: at least the number of positive roots.

    The excess over the roots, each counted as often as it is repeated, is even.
    Source: Descartes' rule of signs.

    >>> variations((1, -3, 2))  # roots 1 and 2
    2
    """
    signs = [c > 0 for c in a if c]
    return sum(one != other for one, other in pairwise(signs))


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
    one, other = list(a), _derivative(a)
    while other:
        one, other = other, _negative_remainder(one, other)
    one = _reduced(one)
    return one if one[0] > 0 else [-c for c in one]


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
    while rest and not rest[0]:
        del rest[0]
    return _reduced([-c for c in rest])


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


def shifted(a: Whole) -> list[int]:
    """Return the polynomial a(x + 1).

    >>> shifted((1, 0, 0))
    [1, 2, 1]
    """
    out = list(a)
    for end in range(len(out), 1, -1):
        for j in range(1, end):
            out[j] += out[j - 1]
    return out


def _plainly_positive(a: Whole) -> bool:
    """Return whether a(x) > 0 for x >= 0 is seen at a glance: c0 + c1 x + c2 x^2 > 0, rest >= 0."""
    if a[-1] <= 0 or any(c < 0 for c in a[:-2]):
        return False
    if len(a) < 2 or a[-2] >= 0:
        return True
    return len(a) > 2 and a[-2] ** 2 < 4 * a[-1] * a[-3]


def hurwitz(a: Whole) -> bool:
    """Return whether every root has a negative real part; a missing leading power says no.

    In w a leading zero is a root at infinity, z = -1, on the boundary.
    Source: F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV (Routh's scheme).

    >>> hurwitz((1, 2, 3)), hurwitz((1, 0, 3))
    (True, False)
    """
    if len(a) == 1:
        return a[0] != 0
    if a[0] == 0 or a[-1] == 0:
        return False
    sign = 1 if a[0] > 0 else -1
    upper, lower = [sign * c for c in a[0::2]], [sign * c for c in a[1::2]]
    while lower:
        if lower[0] <= 0:
            return False
        padded = [*lower[1:], *[0] * (len(upper) - len(lower))]
        rest = [lower[0] * u - upper[0] * c for u, c in zip(upper[1:], padded, strict=True)]
        upper, lower = lower, _reduced(rest)
    return True


def on_axis(a: Whole) -> tuple[list[int], list[int]]:
    """Return (e, o) with a(j v) = e(q) + j v o(q), q = v**2.

    >>> on_axis((1, 2, 3))  # (jv)^2 + 2 jv + 3
    ([-1, 3], [2])
    """
    even, odd = list(a[::-1][0::2]), list(a[::-1][1::2])
    for part in (even, odd):
        part[1::2] = [-c for c in part[1::2]]
        part.reverse()
    return even, odd or [0]


def _reduced(a: list[int]) -> list[int]:
    common = gcd(*a)
    return [c // common for c in a] if common > 1 else a
