"""PID and PD controllers, solved exactly at one crossover.

    D(w) = kp + ki/w + kd w/(1 + w dt/2)

The derivative's pole at 2/dt is the pole at z = 0 of kd (z - 1)/(dt z). With x = v dt/2 the
derivative is kd v (x + j)/(1 + x^2) at w = j v, so ki leaves two real equations for kp and kd.
Source: C. L. Phillips and H. T. Nagle, Digital Control System Analysis and Design, the section
on PID controllers (the derivative with a pole, real and imaginary parts matched at the
phase-margin frequency).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import acos, asin, atan, cos, hypot, pi, sin

from zoh.design.target import Phases, Response, Target, refusal
from zoh.lti.systems import Sampled
from zoh.spec import Crossover


@dataclass(frozen=True, slots=True, kw_only=True)
class PID:
    """Gains in the w-plane: kp in u/y, ki in u/(y s), kd in u s/y; dt in s. A PD has ki = 0."""

    kp: float
    ki: float
    kd: float
    dt: float

    @property
    def gains(self) -> Mapping[str, float]:
        """Return the gains by name."""
        return {"kp": self.kp, "ki": self.ki, "kd": self.kd}

    def controller(self) -> Sampled:
        """Return kp + ki/w + kd w/(1 + w dt/2); without the integrator where ki is 0."""
        half, lead = self.dt / 2, self.kp * self.dt / 2 + self.kd
        if self.ki == 0:
            return Sampled.from_w(num_w=(lead, self.kp), den_w=(half, 1.0), dt=self.dt)
        return Sampled.from_w(
            num_w=(lead, self.kp + self.ki * half, self.ki), den_w=(half, 1.0, 0.0), dt=self.dt
        )


def phases(target: Target, ki: float) -> Phases:
    """Return the phases that a PID with this ki and positive kp and kd can give.

    With k = ki |G|/v: kd > 0 where sin(theta) > -k; kp > 0 where
    cos(theta) - x sin(theta) > x k, that is cos(theta + atan x) > x k/sqrt(1 + x^2).
    """
    x, k = target.v * target.dt / 2, ki * target.size / target.v
    reach = x * k / hypot(1.0, x)
    if reach >= 1:
        return None
    low = -asin(k) if k < 1 else -pi
    return max(low, -acos(reach) - atan(x)), acos(reach) - atan(x)


def solve(plant: Response, spec: Crossover, ki: float) -> PID:
    """Return the PID with this ki whose loop crosses 1 at ``spec.wc`` with ``spec.pm_deg``.

    With v, |G| and theta of ``Target``, and x = v dt/2::

        kd = (sin(theta)/|G| + ki/v) (1 + x^2)/v
        kp = cos(theta)/|G| - x (sin(theta)/|G| + ki/v)

    A proposal: only ``analysis.verify`` says that the loop is stable. Raises SpecError if wc is
    not below Nyquist, Infeasible if kp or kd would not be positive. ki = 0 gives a PD.

    >>> plant = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)
    >>> solve(plant, Crossover(wc=pi / 2, pm_deg=45), ki=1.0)  # theta = 0, v = 2, x = 1
    PID(kp=0.914213..., ki=1.0, kd=0.5..., dt=1.0)
    """
    target = Target.of(plant, spec)
    able = phases(target, ki)
    if not target.inside(able):
        raise refusal(_name(ki), target, spec, able, _no_room(target))
    x = target.v * target.dt / 2
    imaginary = sin(target.theta) / target.size + ki / target.v
    return PID(
        kp=cos(target.theta) / target.size - x * imaginary,
        ki=ki,
        kd=imaginary * (1 + x * x) / target.v,
        dt=plant.dt,
    )


def _name(ki: float) -> str:
    return f"a PID with ki = {ki:g} and positive kp and kd" if ki else "a PD with positive gains"


def _no_room(target: Target) -> str:
    """Return why there is no positive kp: at w = j v the integral's share is too large."""
    x = target.v * target.dt / 2
    most = target.v * hypot(1.0, x) / (x * target.size)
    return f"has no positive kp here: its ki must be below {most:.4g}"
