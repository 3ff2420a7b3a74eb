"""Angles, sines and cosines that the compiler can work out in every lane at once.

It has them of no library: each call of the C library's is for one number. Sums of Taylor's series
where the next term is below 1e-17, after halvings of the angle; to 7 roundings of 1.
"""

from math import pi, sqrt

import numpy as np

from zoh.batch.compiled.jit import compiled

_ODD = 1.0 / np.arange(1.0, 24.0, 2.0) * (-1.0) ** np.arange(12)  # of the arc tangent: 0.2^24/25
_SINE = 1.0 / np.cumprod([1.0, *(-2.0 * k * (2.0 * k + 1.0) for k in range(1, 9))])  # 0.4^18/19!
_COSINE = 1.0 / np.cumprod([1.0, *(-2.0 * k * (2.0 * k - 1.0) for k in range(1, 9))])
_REST = 6.123233995736766e-17  # of pi/2
_ARC, _TERMS = len(_ODD) - 1, len(_SINE) - 1


@compiled
def angle(y: float, x: float) -> float:
    """Return the angle of x + jy in rad, in [-pi, pi]; not a number where both are 0.

    atan t = 2 atan(t/(1 + sqrt(1 + t^2))): twice, and t is below 0.2.
    """
    high, low = abs(x), abs(y)
    steep = low > high
    t = (high if steep else low) / (low if steep else high)
    t = t / (1.0 + sqrt(1.0 + t * t))
    t = t / (1.0 + sqrt(1.0 + t * t))
    square, total = t * t, _ODD[_ARC]
    for k in range(_ARC - 1, -1, -1):
        total = total * square + _ODD[k]
    found = 4.0 * t * total
    found = 0.5 * pi - found if steep else found
    found = pi - found if x < 0.0 else found
    return float(-found if y < 0.0 else found)


@compiled
def sine_cosine(x: float) -> tuple[float, float]:
    """Return both of |x| <= pi, from those of x/8."""
    part = 0.125 * x
    square, sine, cosine = part * part, _SINE[_TERMS], _COSINE[_TERMS]
    for k in range(_TERMS - 1, -1, -1):
        sine, cosine = sine * square + _SINE[k], cosine * square + _COSINE[k]
    sine *= part
    for _ in range(3):
        sine, cosine = 2.0 * sine * cosine, (cosine - sine) * (cosine + sine)
    return sine, cosine


@compiled
def tangent(x: float) -> float:
    """Return that of 0 <= x <= pi/2, beyond pi/4 as the inverse of its complement's.

    pi/2 is the sum of two floats, so that the complement has all its digits beside it.
    """
    steep = x > 0.25 * pi
    sine, cosine = sine_cosine((0.5 * pi - x) + _REST if steep else x)
    return float((cosine if steep else sine) / (sine if steep else cosine))
