"""A plant under a held input, at any time between two samples.

The state is that of the controllable canonical form in units of the sample time: x_0 is what
1/den answers, x_i its i-th derivative times dt^i. Over a fraction t of a sample::

    x(t) = x + (Phi(t) - I) x + Gamma(t) u,    y = c x + d u

Phi - I is given, not Phi: at a small dt the difference is what counts.
"""

from dataclasses import dataclass
from decimal import Decimal

import numpy as np
import numpy.typing as npt

from zoh.lti import digits
from zoh.lti.systems import Plant
from zoh.sampling.ring import StepResponse, digits_needed

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """A plant (sensor included, dead time not) whose input is held.

    a  shape (n, n), dx/dt in units of the sample time; input enters the last state with gain 1
    c  shape (n,); d  direct gain
    fastest  size of the fastest pole in rad per sample
    """

    a: Array
    c: Array
    d: float
    fastest: float
    response: StepResponse
    digits: int

    @classmethod
    def of(cls, plant: Plant, dt: float) -> "Held":
        """Return the plant with time counted in units of dt seconds."""
        num, den = plant.exact
        needed = digits_needed(num, den, dt)
        with digits.precision(needed):
            response = StepResponse.of(num, den, Decimal(plant.sensor), Decimal(dt))
            n = response.order
            den_ascending = response.modulus[1:]  # s den(s) without its lowest, which is 0
            top = [Decimal(0)] * (n + 1 - len(num)) + list(num)
            gain, unit = Decimal(plant.sensor) / den[0], Decimal(dt)
            scaled = [gain * c * unit**i for i, c in enumerate(top)]
            d = scaled[0]
            c = [b - d * a for a, b in zip(den_ascending, scaled[:0:-1], strict=True)]
        a = np.eye(n, k=1)
        if n:
            a[-1] = [-float(x) for x in den_ascending]
        return cls(
            a=a,
            c=np.array([float(x) for x in c]),
            d=float(d),
            fastest=float(np.abs(plant.poles()).max(initial=0.0)) * dt,
            response=response,
            digits=needed,
        )

    def move(self, t: float | Decimal) -> tuple[Array, Array]:
        """Return (Phi(t) - I, Gamma(t)) for a fraction t of a sample, each entry to a float."""
        n = self.response.order
        delta, gamma = np.zeros((n, n)), np.zeros(n)
        if not n or not t:
            return delta, gamma
        with digits.precision(self.digits):
            element = self.response.exponential(Decimal(t))
            for i in range(n):
                top = element[n]
                gamma[i] = float(top)
                lower = self.response.modulus[1:]
                row = [e - top * m for e, m in zip(element[:n], lower, strict=True)]
                row[i] -= 1
                delta[i] = [float(e) for e in row]
                element = self.response.times_sigma(element)
        return delta, gamma
