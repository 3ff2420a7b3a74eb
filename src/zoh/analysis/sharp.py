"""Roots of a polynomial in q = v^2 beyond a float's digits, in whole numbers.

Where a loop passes an undamped zero or pole, its gain changes by much while v changes by its last
digit: no float is the crossing then. And a float cannot say whether a polynomial is 0 at its
root's neighbour, or below.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import inf

from zoh.analysis.squares import squared
from zoh.lti import signs, whole
from zoh.lti.whole import Point, Whole, derivative

_MORE = 128  # bits of a root beyond those of the float it starts from
_ALMOST = 100  # bits that are right: the next step makes them more than _MORE, beside others too
_STEPS = 12
_AWAY = 10  # bits: a root that is not within a thousandth of where it was seen is another one
# bits that |num|^2 is below its own terms at a root of num: of coefficients that are meant to the
# last bit, of such as are rounded
EXACT, ROUNDED = 240, 93
_JUST_BELOW, _JUST_ABOVE = 1 - 4e-15, 1 + 4e-15  # a float there is the root but for roundings
FINE = 320  # bits of roots that no float tells apart: coefficients have 256
APART = 2.0**-40  # relative; a root is within this of where it was found


def closed_in(a: Whole, v: float) -> Point:
    """Return the root of a near q = v^2, to 2^-127 of itself or better; v^2 where there is none.

    Newton's method on a/a', which a root that is repeated does not slow down.

    >>> top, bottom = closed_in((1, 0, -2), 1.18920711)  # q = sqrt(2)
    >>> abs(top**2 - 2 * bottom**2) * 2**130 < bottom**2
    True
    """
    return closer(a, squared(v))


def closer(a: Whole, first: Point) -> Point:
    """Return the root of a near q = first, 128 bits more of it; first where there is none.

    >>> top, bottom = closer((1, 0, -2), (181, 128))
    >>> abs(top**2 - 2 * bottom**2) * 2**130 < bottom**2
    True
    """
    top, bottom = first[0] << _MORE, first[1] << _MORE
    slope = derivative(a)
    bend = derivative(slope)
    here = top
    for _ in range(_STEPS):
        y, dy, ddy = (whole.at_fraction(c, here, bottom) for c in (a, slope, bend))
        if not y:
            return here, bottom
        if not (under := dy * dy - y * ddy):
            return first
        step = y * dy // under
        here -= step
        if abs(here - top) > top >> _AWAY:
            return first
        if abs(step) <= here >> _ALMOST:
            return here, bottom
    return first


def places(a: Whole, found: Sequence[float]) -> list[Point | None]:
    """Return each root of a where two of those found, in v and ascending, are one float; else None.

    >>> below, above = places((1, -2 << 99, (1 << 198) - 1), [2.0**49.5] * 2)  # 2^99 -+ 1
    >>> [round((q[0] - (q[1] << 99)) / q[1], 9) for q in (below, above)]
    [-1.0, 1.0]
    >>> places((1, -3, 2), [1.0, 1.5])
    [None, None]
    """
    if len(set(found)) == len(found):
        return [None] * len(found)
    every = signs.odd_roots(a, FINE)
    return [*every] if [as_v(q) for q in every] == [*found] else [None] * len(found)


def as_v(q: Point) -> float:
    """Return v, the root of q.

    >>> as_v((9, 4))
    1.5
    """
    return whole.root_of_ratio(*q)


def sharpened(a: Whole, v: float) -> float:
    """Return v closed in on a root of a, the same float where that is a rounding away.

    >>> sharpened((1, -5, 4), 1.9999), sharpened((1, -5, 4), 2.0000000000000004)
    (2.0, 2.0000000000000004)
    """
    below, above = (whole.at_fraction(a, *squared(x)) for x in (v * _JUST_BELOW, v * _JUST_ABOVE))
    if below < 0 < above or above < 0 < below:
        return v
    return as_v(closed_in(a, v))


def is_nothing(a: Whole, at: Point, bits: int = EXACT) -> bool:
    """Return whether a is so many bits below its own terms: 0, where the point has as many.

    >>> is_nothing((1, -4, 4), closed_in((1, -2), 1.4142)), is_nothing((1, -1), (3, 2))
    (True, False)
    """
    terms = whole.at_fraction([abs(c) for c in a], *at)
    return abs(whole.at_fraction(a, *at)) <= terms >> bits


def apart(f: Callable[[float], float], found: Sequence[float], within: float = APART) -> bool:
    """Return whether f changes sign around every v found, each in an interval of its own.

    found   ascending
    within  relative, how far an interval reaches to both sides, if not up to half way to the next

    >>> apart(lambda v: (v - 1) * (v - 2), [1.0, 2.0]), apart(lambda v: v - 1, [1.0, 1.0])
    (True, False)
    """
    between = [0.0, *((left + right) / 2 for left, right in pairwise(found)), inf]
    for v, (low, high) in zip(found, pairwise(between), strict=False):  # none found: no interval
        below, above = f(max(low, v * (1 - within))), f(min(high, v * (1 + within)))
        if not (below < 0 < above or above < 0 < below):
            return False
    return True
