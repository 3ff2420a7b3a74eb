"""PI controllers, solved exactly at one crossover:  D(w) = kp + ki/w.

At the crossover D must be exp(j theta)/|G|: one complex equation in two real unknowns, hence a
closed form, with no search and no tolerance.
Source: C. L. Phillips and H. T. Nagle, Digital Control System Analysis and Design, the section
on PI compensation (D(w) = KP + KI/w, solved at the phase-margin frequency).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, pi, sin

from zoh.design.target import Phases, Response, Target, refusal
from zoh.lti.systems import Sampled
from zoh.spec import Crossover


@dataclass(frozen=True, slots=True, kw_only=True)
class PI:
    """Gains in the w-plane: kp in u/y, ki in u/(y s); dt in s."""

    kp: float
    ki: float
    dt: float

    @property
    def gains(self) -> Mapping[str, float]:
        """Return the gains by name."""
        return {"kp": self.kp, "ki": self.ki}

    def controller(self) -> Sampled:
        """Return kp + ki/w; in z it is kp + ki (dt/2) (z + 1)/(z - 1)."""
        return Sampled.from_w(num_w=(self.kp, self.ki), den_w=(1.0, 0.0), dt=self.dt)


def phases(target: Target) -> Phases:
    """Return the phases that a PI with positive gains can give: (-90, 0) deg."""
    return -pi / 2, 0.0


def solve(plant: Response, spec: Crossover, *, any_sign: bool = False) -> PI:
    """Return the PI whose loop crosses 1 at ``spec.wc`` with margin ``spec.pm_deg``.

    With v, |G| and theta of ``Target``::

        kp = cos(theta)/|G|        ki = -v sin(theta)/|G|

    This is a proposal: only ``analysis.verify`` says that the loop is stable. Raises SpecError
    if wc is not below Nyquist, Infeasible if theta is not inside (-90, 0) deg, where the gains are
    positive, unless they may be of ``any_sign``.

    >>> plant = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)
    >>> solve(plant, Crossover(wc=pi / 2, pm_deg=30))  # kp = (sqrt(3)+1)/2, ki = sqrt(3)-1
    PI(kp=1.366025..., ki=0.732050..., dt=1.0)
    """
    target = Target.of(plant, spec)
    if not any_sign and not target.inside(phases(target)):
        raise refusal("a PI", target, spec, phases(target), "")
    size, theta = target.size, target.theta
    return PI(kp=cos(theta) / size, ki=-target.v * sin(theta) / size, dt=plant.dt)
