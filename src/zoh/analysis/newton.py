"""Newton's method on polynomials in floats, between two points that hold the root."""

from collections.abc import Sequence
from math import inf

from zoh.lti import poly

_LAST_STEP = 1e-10  # relative; Newton's next step would be its square, below a float's digits
_LAST_FLAT_STEP = 1e-6  # that of a least value, which is flat and needs half the digits
_NEAREST = 30  # octaves; roots nearer to each other than that are left to exact isolation


def part(a: Sequence[float], left: list[float], right: list[float]) -> None:
    """Move the point that two brackets (low, high, a there) share from the root it is on.

    The other root is on one side of it, and between the two a has the sign it seemed to have.

    >>> left, right = [0.5, 1.0, 0.55, -1e-17], [1.0, 2.0, -1e-17, 0.4]
    >>> part([1.0, -2.6, 1.6], left, right)
    >>> left[1] == right[0] == 1.125
    True
    """
    for octave in range(3, _NEAREST, 2):
        for x in (left[1] * (1 - 2.0**-octave), left[1] * (1 + 2.0**-octave)):
            value = poly.at(a, x)
            if value * left[2] < 0 and abs(value) > abs(left[3]):
                left[1] = right[0] = x
                left[3] = right[2] = value
                return


def root(a: Sequence[float], low: float, high: float, at_low: float, at_high: float) -> float:
    """Return the root of a polynomial between two points at which its signs differ.

    Newton's method from the secant's point on, halving where it leaves the bracket.

    >>> root([1.0, 0.0, -2.0], 1.0, 2.0, -1.0, 2.0)
    1.41421356237309...
    """
    rising, last, (lead, second, *rest) = at_high > at_low, inf, a
    x = low - at_low * (high - low) / (at_high - at_low)
    for _ in range(100):
        value, slope = lead * x + second, lead
        for c in rest:
            slope = slope * x + value
            value = value * x + c
        if (value > 0) == rising:
            high = x
        else:
            low = x
        step = value / slope if slope else inf
        moved, size = x - step, abs(step)
        if size <= _LAST_STEP * x or last <= size < 1e-9 * x:  # rounding is all there is
            return moved
        if not low < moved < high:
            step = x - (low + high) / 2
            moved, size = x - step, abs(step)
        x, last = moved, size
    return x


def stationary(p: Sequence[float], q: Sequence[float], x: float, low: float, high: float) -> float:
    """Return where p'q - pq' changes from below to above 0, near x in [low, high].

    p and q have one length.

    >>> stationary([1.0, 0.0, 1.0], [0.0, 1.0, 0.0], 1.1, 0.5, 2.0)  # x + 1/x
    1.0
    """
    last, ((p_lead, q_lead), (p_second, q_second), *rest) = inf, zip(p, q, strict=True)
    for _ in range(100):
        p0, q0 = p_lead * x + p_second, q_lead * x + q_second
        p1, q1, p2, q2 = p_lead, q_lead, 0.0, 0.0  # p2 and q2 are half the second derivatives
        for c, d in rest:
            p2, q2 = p2 * x + p1, q2 * x + q1
            p1, q1 = p1 * x + p0, q1 * x + q0
            p0, q0 = p0 * x + c, q0 * x + d
        value, slope = p1 * q0 - p0 * q1, 2 * p2 * q0 - p0 * (2 * q2)
        if value > 0:
            high = x
        else:
            low = x
        step = value / slope if slope > 0 else inf
        moved, size = x - step, abs(step)
        if size <= _LAST_FLAT_STEP * x or last <= size < 1e-6 * x:
            return moved
        if not low < moved < high:
            step = x - (low + high) / 2
            moved, size = x - step, abs(step)
        x, last = moved, size
    return x


def parabola(left: float, middle: float, right: float) -> float:
    """Return where the parabola through three equidistant values is least, in their distances.

    >>> parabola(4.0, 1.0, 0.0)
    1.0
    """
    bend = left - 2 * middle + right
    return (left - right) / (2 * bend) if 0 < bend < inf else 0.0
