"""A polynomial on [0, 1] between bounds that hold but for the rounding of its coefficients.

Written in Bernstein's basis, a polynomial lies between its least and its largest coefficient,
and changes its sign at most as often as they do. So where they do not, there is no crossing;
where they do once, there is exactly one; otherwise the interval is halved.
Source: G. Farin, Curves and Surfaces for CAGD, 5th ed., ch. 5 and 6 (convex hull, variation
diminishing, de Casteljau's subdivision).
"""

from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from math import comb

import numpy as np

from zoh.analysis.loop import Array

_CONVERGED = 1e-11  # of the interval: Newton's next step would be its square
_STEPS = 6  # of Newton from the middle: where they do not reach the top the bound is only looser
_NARROW = 2.0**-40  # of the interval: two crossings as near as that are a touch


@lru_cache(maxsize=64)
def bernstein(terms: int) -> Array:
    """Return the matrix that takes ascending powers to Bernstein's coefficients.

    >>> bernstein(3) @ [0.0, 0.0, 1.0]  # t^2 has 0, 0, 1
    array([0., 0., 1.])
    """
    d = terms - 1
    out = np.array([[comb(i, j) / comb(d, j) for j in range(terms)] for i in range(terms)])
    out.flags.writeable = False
    return out


class Piece:
    """A polynomial on [0, 1] in ascending powers ``a``, with its Bernstein coefficients ``b``."""

    __slots__ = ("a", "b")

    def __init__(self, a: list[float], b: list[float]) -> None:
        self.a, self.b = a, b

    @classmethod
    def of(cls, a: Array) -> "Piece":
        """Return the polynomial of these ascending powers."""
        return cls(a.tolist(), bernstein(len(a)).dot(a).tolist())

    def at(self, t: float) -> float:
        """Return the value at t."""
        total = 0.0
        for c in reversed(self.a):
            total = total * t + c
        return total

    def slope(self) -> "Piece":
        """Return the derivative; that of a constant is 0."""
        d = len(self.a) - 1
        if d == 0:
            return Piece([0.0], [0.0])
        a = [j * self.a[j] for j in range(1, d + 1)]
        return Piece(a, [d * (q - p) for p, q in pairwise(self.b)])

    def crossings(self, level: float) -> Iterator[float]:
        """Return where the polynomial crosses a level, in order.

        >>> list(Piece.of(np.array([0.0, 0.0, 4.0])).crossings(1.0))
        [0.5]
        """
        return self._crossings(level, [c - level for c in self.b], 0.0, 1.0)

    def _crossings(self, level: float, b: list[float], low: float, high: float) -> Iterator[float]:
        """Yield the crossings between two times, in order.

        b  Bernstein's coefficients between these times, less the level
        """
        changes, below = 0, b[0] < 0
        for c in b:
            if (c < 0) != below:
                below = not below
                changes += 1
        if changes == 1:
            yield self._root(level, low, high, (b[0], b[-1]))
        elif changes and high - low > _NARROW:
            left, right = _halved(b)
            middle = (low + high) / 2
            yield from self._crossings(level, left, low, middle)
            yield from self._crossings(level, right, middle, high)

    def highest(self) -> tuple[float, float]:
        """Return (t, value) where the polynomial is largest on [0, 1].

        >>> Piece.of(np.array([0.0, 1.0, -1.0])).highest()
        (0.5, 0.25)
        """
        best, high = 0.0, self.a[0]
        for t in (*self.slope().crossings(0.0), 1.0):
            value = self.at(t)
            if value > high:
                best, high = t, value
        return best, high

    def _root(self, level: float, low: float, high: float, ends: tuple[float, float]) -> float:
        """Return the one crossing between two times, by Newton's steps kept in the bracket.

        ends  how far from the level the polynomial is at both
        """
        left, right = ends
        rises, (first, *powers) = left < 0, self.a[::-1]
        # inside: at an end that is a crossing, too, rounding decides the sign
        t = low + min(max(left / (left - right), 0.02), 0.98) * (high - low)
        for _ in range(80):
            value, slope = first, 0.0
            for c in powers:
                slope = slope * t + value
                value = value * t + c
            value -= level
            if (value >= 0) == rises:
                high = t
            else:
                low = t
            step = value / slope if slope else high - low
            if low <= t - step <= high:
                t -= step
                if abs(step) < _CONVERGED:
                    break
            else:
                t = (low + high) / 2
        return t


def highest_bounds(a: Array) -> Array:
    """Return upper bounds on [0, 1] of many polynomials, a column each, ascending powers.

    One that is concave is below each of its tangents, of which the one at its top is level; of any
    other it is the largest Bernstein coefficient.

    >>> highest_bounds(np.array([[0.0], [1.0], [-1.0]]))  # t - t^2; its coefficients reach 0.5
    array([0.25])
    """
    loose: Array = bernstein(len(a)).dot(a).max(axis=0)
    if len(a) < 3:
        return loose
    first = a[1:] * np.arange(1.0, len(a))[:, None]
    second = first[1:] * np.arange(1.0, len(first))[:, None]
    concave = (bernstein(len(second)).dot(second) < 0).all(axis=0)
    t = np.full(a.shape[1], 0.5)
    for _ in range(_STEPS):
        bend = np.where(concave, _horner(second, t), -1.0)
        t = np.clip(t - _horner(first, t) / bend, 0.0, 1.0)
    slope = _horner(first, t)
    tangent = _horner(a, t) + np.maximum(slope * (1 - t), -slope * t)
    return np.where(concave, np.minimum(tangent, loose), loose)


def _horner(a: Array, t: Array) -> Array:
    total = np.zeros_like(t)
    for row in a[::-1]:
        total = total * t + row
    return total


def _halved(b: list[float]) -> tuple[list[float], list[float]]:
    """Return the Bernstein coefficients on both halves of the interval."""
    left, right = [], []
    while b:
        left.append(b[0])
        right.append(b[-1])
        b = [(p + q) / 2 for p, q in pairwise(b)]
    return left, right[::-1]
