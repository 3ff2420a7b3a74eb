"""Polynomials with whole-number coefficients: floats taken exactly, so that signs are certain.

A float is a whole number times a power of two, and so is every sum and product of floats.
Coefficients are in descending powers; a common factor of a power of two is immaterial and left
out. What is decided of them is in ``signs``.
"""

from collections.abc import Sequence
from itertools import accumulate
from math import ldexp, sqrt

Whole = Sequence[int]
Point = tuple[int, int]  # a fraction, its bottom a power of two


def of(*polynomials: Sequence[float]) -> tuple[list[list[int]], int]:
    """Return (wholes, unit): the polynomials times unit, the least power of two that serves all.

    >>> of((0.5, 1.0), (0.25,))
    ([[2, 4], [1]], 4)
    """
    ratios = [[c.as_integer_ratio() for c in a] for a in polynomials]
    unit = max([bottom for a in ratios for _, bottom in a])
    most = unit.bit_length()  # of powers of two the bits say the quotient
    return [[top << most - bottom.bit_length() for top, bottom in a] for a in ratios], unit


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


def divided(a: Whole, b: Whole) -> list[int]:
    """Return a/b, where b divides a and its coefficients have no common factor.

    >>> divided((1, 3, 2), (1, 1))
    [1, 2]
    """
    rest, out = list(a), []
    for i in range(len(a) - len(b) + 1):
        factor = rest[i] // b[0]
        out.append(factor)
        for j, c in enumerate(b, i):
            rest[j] -= factor * c
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


def derivative(a: Whole) -> list[int]:
    """Return da/dx.

    >>> derivative((1, 2, 3))
    [2, 2]
    """
    n = len(a) - 1
    return [c * (n - i) for i, c in enumerate(a[:-1])] or [0]


def packed_on_axis(a: Whole, bits: int) -> tuple[int, int]:
    """Return e(2^bits) and o(2^bits) of ``on_axis``: polynomials as one whole number each.

    So products are one product each.
    Source: J. von zur Gathen, J. Gerhard, Modern Computer Algebra, 3rd ed., sec. 8.4 (Kronecker
    substitution).

    >>> packed_on_axis((1, 2, 3), 8)  # e = 3 - q, o = 2
    (-253, 2)
    """
    even = odd = 0
    for c in a:
        even, odd = c - (odd << bits), even
    return even, odd


def unpacked(value: int, bits: int, length: int) -> list[int]:
    """Return so many coefficients of the polynomial whose value at 2^bits this is.

    Each must be below 2^(bits - 1) in size.

    >>> unpacked((1 << 16) - (4 << 8) + 4, 8, length=3)
    [1, -4, 4]
    """
    out, unit = [], 1 << bits
    half, low = unit >> 1, unit - 1
    for _ in range(length):
        c = value & low
        value >>= bits
        if c >= half:
            c -= unit
            value += 1
        out.append(c)
    out.reverse()
    return out


def trim(a: Whole) -> list[int]:
    """Return ``a`` without leading and trailing zeros: the same roots but for those at 0.

    >>> trim((0, 1, 2, 0))
    [1, 2]
    """
    if not any(a):
        return []
    first, end = 0, len(a)
    while not a[first]:
        first += 1
    while not a[end - 1]:
        end -= 1
    return list(a[first:end])


def at(a: Whole, x: float) -> int:
    """Return a(x) times a power of two that depends on x and the degree alone.

    >>> at((4, 1), 0.25), at((0, 1), 0.25)  # 2 and 1, times 4
    (8, 4)
    """
    return at_fraction(a, *x.as_integer_ratio())


def at_fraction(a: Whole, top: int, bottom: int) -> int:
    """Return a(top/bottom), bottom a power of two, times it to the power of the degree.

    >>> at_fraction((4, 1), 1, 4)
    8
    """
    value, bits, octaves = a[0], 0, bottom.bit_length() - 1
    for c in a[1:]:
        bits += octaves
        value = value * top + (c << bits)
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
    most, up = None, octaves * (len(a) - 1)
    for c in a:
        if c:
            bits = c.bit_length() + up
            if most is None or bits > most:
                most = bits
        up -= octaves
    return most or 0


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


def shifted(a: Whole) -> list[int]:
    """Return the polynomial a(x + 1).

    >>> shifted((1, 0, 0))
    [1, 2, 1]
    """
    out: list[int] = []
    while a:  # divided by x - 1 again and again, the remainders are the coefficients
        *a, remainder = accumulate(a)
        out.append(remainder)
    out.reverse()
    return out


def on_axis(a: Whole) -> tuple[list[int], list[int]]:
    """Return (e, o) with a(j v) = e(q) + j v o(q), q = v**2.

    >>> on_axis((1, 2, 3))  # (jv)^2 + 2 jv + 3
    ([-1, 3], [2])
    """
    even, odd = list(a[::-2]), list(a[-2::-2])
    for part in (even, odd):
        part[1::2] = [-c for c in part[1::2]]
        part.reverse()
    return even, odd or [0]
