"""PID and PD controllers, solved exactly at one crossover.

    D(w) = kp + ki/w + kd w/(1 + w/p)

The derivative's pole p is any; 2/dt, the usual one, is the pole at z = 0 of kd (z - 1)/(dt z).
With x = v/p the derivative is kd v (x + j)/(1 + x^2) at w = j v, so that one gain is left free:
with b = kd v/(1 + x^2) every PID of this crossover is

    kp = cos(theta)/|G| - x b        ki = v (b - sin(theta)/|G|)        kd = b (1 + x^2)/v

Source: C. L. Phillips and H. T. Nagle, Digital Control System Analysis and Design, the section
on PID controllers (the derivative with a pole, real and imaginary parts matched at the
phase-margin frequency); K. J. Astrom and T. Hagglund, Advanced PID Control, ch. 6 (Ti/Td = 4).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import acos, asin, atan, cos, hypot, inf, pi, sin, sqrt

from zoh.design.target import Phases, Response, Target, refusal
from zoh.lti.forms import time_constant
from zoh.lti.systems import Sampled
from zoh.spec import Crossover


@dataclass(frozen=True, slots=True, kw_only=True)
class PID:
    """Gains in the w-plane: kp in u/y, ki in u/(y s), kd in u s/y; dt in s. A PD has ki = 0.

    filter_pole  rad/s, the derivative's pole is at w = -filter_pole
    """

    kp: float
    ki: float
    kd: float
    filter_pole: float
    dt: float

    @property
    def gains(self) -> Mapping[str, float]:
        """Return the gains by name."""
        return {"kp": self.kp, "ki": self.ki, "kd": self.kd, "filter_pole": self.filter_pole}

    def controller(self) -> Sampled:
        """Return kp + ki/w + kd w/(1 + w/p); without the integrator where ki is 0."""
        tau = time_constant(self.filter_pole, self.dt)
        lead = self.kp * tau + self.kd
        if self.ki == 0:
            return Sampled.from_w(num_w=(lead, self.kp), den_w=(tau, 1.0), dt=self.dt)
        return Sampled.from_w(
            num_w=(lead, self.kp + self.ki * tau, self.ki), den_w=(tau, 1.0, 0.0), dt=self.dt
        )


def phases(target: Target, ki: float, tau: float) -> Phases:
    """Return the phases that a PID with this ki and positive kp and kd can give.

    With k = ki |G|/v: kd > 0 where sin(theta) > -k; kp > 0 where
    cos(theta) - x sin(theta) > x k, that is cos(theta + atan x) > x k/sqrt(1 + x^2).
    """
    x, k = target.v * tau, ki * target.size / target.v
    reach = x * k / hypot(1.0, x)
    if reach >= 1:
        return None
    low = -asin(k) if k < 1 else -pi
    return max(low, -acos(reach) - atan(x)), acos(reach) - atan(x)


def phases_of_any(target: Target, tau: float) -> Phases:
    """Return the phases that a PID of any positive gains can give: (-90, 90 - atan x) deg."""
    return -pi / 2, pi / 2 - atan(target.v * tau)


def room(target: Target, tau: float) -> tuple[float, float] | None:
    """Return the open interval of ki in which kp and kd are positive, None where it is empty.

    kd > 0 from -v sin(theta)/|G| on, kp > 0 up to v (cos(theta)/x - sin(theta))/|G|.

    >>> target = Target(v=2.0, size=0.5, theta=0.0, dt=1.0)
    >>> room(target, 0.5)  # x = 1
    (0.0, 4.0)
    """
    if not target.inside(phases_of_any(target, tau)):
        return None
    x, unit = target.v * tau, target.v / target.size
    low = max(0.0, -unit * sin(target.theta))
    high = unit * (cos(target.theta) / x - sin(target.theta)) if x else inf
    return (low, high) if low < high else None


def solve(
    plant: Response, spec: Crossover, ki: float, filter_pole: float | None = None, *,
    any_sign: bool = False,
) -> PID:  # fmt: skip
    """Return the PID with this ki whose loop crosses 1 at ``spec.wc`` with ``spec.pm_deg``.

    With v, |G| and theta of ``Target``, and x = v/p, p the filter's pole, 2/dt where left open::

        kd = (sin(theta)/|G| + ki/v) (1 + x^2)/v
        kp = cos(theta)/|G| - x (sin(theta)/|G| + ki/v)

    A proposal: only ``analysis.verify`` says that the loop is stable. Raises SpecError if wc is
    not below Nyquist, Infeasible if kp or kd would not be positive, unless they may be of
    ``any_sign``. ki = 0 gives a PD.

    >>> plant = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)
    >>> solve(plant, Crossover(wc=pi / 2, pm_deg=45), ki=1.0)  # theta = 0, v = 2, x = 1
    PID(kp=0.914213..., ki=1.0, kd=0.5..., filter_pole=2.0, dt=1.0)
    """
    target, tau = Target.of(plant, spec), time_constant(filter_pole, plant.dt)
    if any_sign:
        return _with_ki(target, ki, filter_pole)
    able = phases(target, ki, tau)
    if not target.inside(able):
        raise refusal(_name(ki), target, spec, able, _no_room(target, tau))
    return _with_ki(target, ki, filter_pole)


def solve_ratio(
    plant: Response, spec: Crossover, ti_td: float, filter_pole: float | None = None
) -> PID:
    """Return the PID whose Ti/Td = kp^2/(ki kd) is given, on target as ``solve`` is.

    With b = v kd/(1 + x^2) and c = ki/v, b - c = s = sin(theta)/|G|, it is a quadratic in the
    smaller of both, u, with q = |s| and a = cos(theta)/|G|, less x s where c is the smaller::

        (a - x u)^2 = r (1 + x^2) u (u + q)

    The left side falls to 0 and the right side rises from 0 over the u of positive gains, so
    exactly one root is there. Raises as ``solve`` does.

    >>> plant = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)
    >>> d = solve_ratio(plant, Crossover(wc=pi / 2, pm_deg=45), ti_td=4.0)
    >>> round(d.kp**2 / (d.ki * d.kd), 12)
    4.0
    """
    target, tau = Target.of(plant, spec), time_constant(filter_pole, plant.dt)
    able = phases_of_any(target, tau)
    if not target.inside(able):
        raise refusal("a PID with positive gains", target, spec, able, "")
    x, s = target.v * tau, sin(target.theta) / target.size
    r, q = ti_td * (1 + x * x), abs(s)
    a = cos(target.theta) / target.size - x * max(s, 0.0)
    # (r - x^2) u^2 + (r q + 2 a x) u = a^2; of two positive roots the smaller one
    root = sqrt(r * (r * q * q + 4 * q * a * x + 4 * a * a))
    u = 2 * a * a / (r * q + 2 * a * x + root)
    b, c = (u + q, u) if s > 0 else (u, u + q)
    return PID(
        kp=sqrt(r * u * (u + q)),
        ki=target.v * c,
        kd=b * (1 + x * x) / target.v,
        filter_pole=2 / target.dt if filter_pole is None else filter_pole,
        dt=target.dt,
    )


def _with_ki(target: Target, ki: float, filter_pole: float | None) -> PID:
    x = target.v * time_constant(filter_pole, target.dt)
    imaginary = sin(target.theta) / target.size + ki / target.v
    return PID(
        kp=cos(target.theta) / target.size - x * imaginary,
        ki=ki,
        kd=imaginary * (1 + x * x) / target.v,
        filter_pole=2 / target.dt if filter_pole is None else filter_pole,
        dt=target.dt,
    )


def _name(ki: float) -> str:
    return f"a PID with ki = {ki:g} and positive kp and kd" if ki else "a PD with positive gains"


def _no_room(target: Target, tau: float) -> str:
    """Return why there is no positive kp: at w = j v the integral's share is too large."""
    x = target.v * tau
    most = target.v * hypot(1.0, x) / (x * target.size)
    return f"has no positive kp here: its ki must be below {most:.4g}"
