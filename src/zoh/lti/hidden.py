"""Hidden modes: what the numerator and the denominator of a plant share.

A shared factor is a part of the machine that the input does not move or the output does not
see. A controller cannot change it, so one that is unstable keeps every loop unstable.
"""

from fractions import Fraction

import numpy as np

from zoh.lti import digits, poly
from zoh.lti.poly import ComplexArray
from zoh.lti.rational import Unreadable, common, divided
from zoh.lti.systems import Plant


def hidden_modes(plant: Plant) -> ComplexArray:
    """Return the poles in rad/s that a zero of the plant hides exactly, shape (k,).

    >>> hidden_modes(Plant.parse("(s-1)/((s-1)(s+2))")).tolist()
    [(1+0j)]
    """
    num, den = (tuple(Fraction(c) for c in a) for a in plant.exact)
    try:
        shared = common(den, num)
    except Unreadable:  # digits that share nothing exactly grow until they are refused
        return np.zeros(0, complex)
    return poly.roots([float(c / shared[0]) for c in shared]).astype(complex)


def unstable_hidden(plant: Plant) -> list[complex]:
    """Return the hidden modes on the imaginary axis or to its right, in rad/s."""
    return [complex(s) for s in hidden_modes(plant).tolist() if s.real >= 0]


def without_hidden(plant: Plant) -> Plant:
    """Return the plant of the same gain everywhere whose num and den share nothing.

    >>> without_hidden(Plant.parse("(s-1)/((s-1)(s+2))")).den
    (1.0, 2.0)
    """
    num, den = (tuple(Fraction(c) for c in a) for a in plant.exact)
    shared = common(den, num)
    shared = tuple(c / shared[0] for c in shared)
    top, bottom = (digits.exact(divided(a, shared)) for a in (num, den))
    return Plant.from_exact(top, bottom, dead_time=plant.dead_time, sensor=plant.sensor)
