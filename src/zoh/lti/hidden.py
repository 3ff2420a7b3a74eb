"""Hidden modes: what the numerator and the denominator of a plant share.

A shared factor is a part of the machine that the input does not move or the output does not
see. A controller cannot change it, so one that is unstable keeps every loop unstable.
"""

from fractions import Fraction

import numpy as np

from zoh.lti import poly
from zoh.lti.poly import ComplexArray
from zoh.lti.rational import Unreadable, common
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
