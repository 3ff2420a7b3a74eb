"""Hidden modes: what the numerator and the denominator of a plant share.

A shared factor is a part of the machine that the input does not move or the output does not
see. A controller cannot change it, so one that is unstable keeps every loop unstable.
"""

from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm

import numpy as np

from zoh.lti import digits, divisors, poly, signs, whole
from zoh.lti.digits import Exact
from zoh.lti.poly import ComplexArray
from zoh.lti.systems import Plant
from zoh.lti.whole import Whole

_ON_AXIS = 1e-9  # of its size: how far from the imaginary axis rounding may put a mode on it


@dataclass(frozen=True, slots=True)
class Apart:
    """num and den that share nothing, and ``modes``, what they shared; all exact.

    factor  the modes' polynomial in whole numbers
    """

    num: Exact
    den: Exact
    modes: Exact
    factor: Whole

    @property
    def stable(self) -> bool:
        """Return whether every hidden mode is strictly on the left."""
        return signs.hurwitz(self.factor)

    @classmethod
    def of(cls, num: Exact, den: Exact) -> "Apart | None":
        """Return the parts of num/den; None where nothing is shared."""
        if len(num) == 1:
            return None
        ratios = [[c.as_integer_ratio() for c in a] for a in (num, den)]
        unit = lcm(*(bottom for a in ratios for _, bottom in a))
        top, bottom = ([a * (unit // b) for a, b in ratio] for ratio in ratios)
        if divisors.share_nothing(top, bottom) or len(modes := divisors.common(top, bottom)) == 1:
            return None
        part = gcd(modes[0], 10 ** modes[0].bit_length())  # decimals can divide by it
        top, bottom = ([c * part for c in whole.divided(a, modes)] for a in (top, bottom))
        num, den, shared = (
            digits.exact([Fraction(c, over) for c in a])
            for a, over in ((top, unit), (bottom, unit), (modes, part))
        )
        return cls(num, den, shared, modes)


def hidden_modes(plant: Plant) -> ComplexArray:
    """Return the poles in rad/s that a zero of the plant hides exactly, shape (k,).

    >>> hidden_modes(Plant.parse("(s-1)/((s-1)(s+2))")).tolist()
    [(1+0j)]
    """
    apart = Apart.of(*plant.exact)
    return np.zeros(0, complex) if apart is None else _roots(apart.factor)


def _roots(a: Whole) -> ComplexArray:
    return poly.roots([c / a[0] for c in a]).astype(complex)


def unstable_hidden(plant: Plant) -> list[complex]:
    """Return the hidden modes on the imaginary axis or to its right, in rad/s, each once."""
    apart = Apart.of(*plant.exact)
    if apart is None or apart.stable:
        return []
    # rounding moves a repeated root by far
    once = whole.divided(apart.factor, divisors.repeated(apart.factor))
    return [complex(s) for s in _roots(once).tolist() if s.real >= -_ON_AXIS * abs(s)]


def without_hidden(plant: Plant) -> Plant:
    """Return the plant of the same gain everywhere whose num and den share nothing.

    >>> without_hidden(Plant.parse("(s-1)/((s-1)(s+2))")).den
    (1.0, 2.0)
    """
    apart = Apart.of(*plant.exact)
    if apart is None:
        return plant
    return Plant.from_exact(apart.num, apart.den, dead_time=plant.dead_time, sensor=plant.sensor)
