"""Lag and lead: one section, two signs, solved exactly at one crossover.

    D(w) = a0 (1 + w/w0)/(1 + w/wp)          lead: w0 < wp, lag: wp < w0

a0, the gain at w = 0, is given; the two corners follow from the complex equation at wc.
Source: C. L. Phillips and H. T. Nagle, Digital Control System Analysis and Design, the section
on phase-lead design at a given phase-margin frequency; the same equations with sin(theta) < 0
give a lag, which the textbook rule (w0 = wc/10) only approximates.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import acos, atan, cos, degrees, sin

from zoh.design.target import Phases, Response, Target, refusal
from zoh.errors import Infeasible
from zoh.lti.systems import Sampled
from zoh.spec import Crossover


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstOrder:
    """dc_gain in u/y; w0, wp: zero and pole at w = -w0, -wp in rad/s (w-plane); dt in s."""

    dc_gain: float
    w0: float
    wp: float
    dt: float

    @property
    def gains(self) -> Mapping[str, float]:
        """Return the gains by name."""
        return {"dc_gain": self.dc_gain, "w0": self.w0, "wp": self.wp}

    def controller(self) -> Sampled:
        """Return dc_gain (1 + w/w0)/(1 + w/wp)."""
        return Sampled.from_w(
            num_w=(self.dc_gain * self.wp / self.w0, self.dc_gain * self.wp),
            den_w=(1.0, self.wp),
            dt=self.dt,
        )


def lead_phases(target: Target, dc_gain: float) -> Phases:
    """Return the phases a lead can give: 0 to acos(a0 |G|); none where a0 |G| >= 1.

    A lead's gain only rises, so at wc it must be above a0.
    """
    ratio = dc_gain * target.size
    return (0.0, acos(ratio)) if ratio < 1 else None


def lag_phases(target: Target, dc_gain: float) -> Phases:
    """Return the phases a lag can give: -acos(1/(a0 |G|)) to 0; none where a0 |G| <= 1.

    A lag's gain only falls, so at wc it must be below a0.
    """
    ratio = dc_gain * target.size
    return (-acos(1 / ratio), 0.0) if ratio > 1 else None


def lead(
    plant: Response, spec: Crossover, dc_gain: float, *, any_sign: bool = False,
    any_pole: bool = False,
) -> FirstOrder:  # fmt: skip
    """Return the lead of this gain at w = 0 whose loop crosses 1 at wc with the margin asked.

    With v, |G| and theta of ``Target``::

        1/w0 = (1/(a0 |G|) - cos(theta))/(v sin(theta))
        1/wp = (cos(theta) - a0 |G|)/(v sin(theta))

    Raises Infeasible unless 0 < theta < acos(a0 |G|), or unless ``any_sign`` of w0 or
    ``any_pole``, an unstable one, too, makes one.

    >>> from math import pi
    >>> plant = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)
    >>> lead(plant, Crossover(wc=pi / 2, pm_deg=75), dc_gain=1.0)  # theta = 30 deg
    FirstOrder(dc_gain=1.0, w0=1.824191..., wp=6.292528..., dt=1.0)
    """
    target = Target.of(plant, spec)
    able = lead_phases(target, dc_gain)
    if not target.inside(able):
        found = _beyond(target, dc_gain, any_sign, any_pole, rises=True)
        if found is not None:
            return found
        raise refusal(
            f"a lead of dc_gain {dc_gain:g}", target, spec, able, "has a gain above that everywhere"
        )
    return corners(target, dc_gain)


def lag(
    plant: Response, spec: Crossover, dc_gain: float, *, any_sign: bool = False,
    any_pole: bool = False,
) -> FirstOrder:  # fmt: skip
    """Return the lag of this gain at w = 0 whose loop crosses 1 at wc with the margin asked.

    The equations are the lead's. Raises Infeasible unless -acos(1/(a0 |G|)) < theta < 0, or as
    the lead does.

    >>> from math import pi
    >>> plant = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)
    >>> lag(plant, Crossover(wc=pi / 2, pm_deg=30), dc_gain=5.0)  # theta = -15 deg
    FirstOrder(dc_gain=5.0, w0=0.757796..., wp=0.201446..., dt=1.0)
    """
    target = Target.of(plant, spec)
    able = lag_phases(target, dc_gain)
    if not target.inside(able):
        found = _beyond(target, dc_gain, any_sign, any_pole, rises=False)
        if found is not None:
            return found
        raise refusal(
            f"a lag of dc_gain {dc_gain:g}", target, spec, able, "has a gain below that everywhere"
        )
    return corners(target, dc_gain)


def textbook_lag(plant: Response, wc: float, dc_gain: float) -> FirstOrder:
    """Return the lag of the textbook's rule: zero at v/10, pole at v/(10 a0 |G|).

    Its gain far above its corners makes |D G| = 1; at wc it is not there yet, and still turns by
    some 5 deg, which the rule allows for and does not compute. So the loop crosses near wc, not
    at it. Raises Infeasible unless a0 |G| > 1.

    >>> from math import pi, sqrt
    >>> plant = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)
    >>> law = textbook_lag(plant, wc=pi / 2, dc_gain=10 * sqrt(2))  # v = 2, a0 |G| = 10
    >>> round(law.w0, 12), round(law.wp, 12)
    (0.2, 0.02)
    """
    target = Target.of(plant, Crossover(wc=wc, pm_deg=90.0))
    ratio = dc_gain * target.size
    if not ratio > 1:
        raise Infeasible(
            f"a lag of dc_gain {dc_gain:g} has a gain below that everywhere; the textbook's rule "
            f"needs more than {1 / target.size:.4g} at {wc:g} rad/s",
            needed_deg=degrees(atan(10.0) - atan(10.0 * ratio)),  # what the rule's lag turns by
        )
    w0 = target.v / 10
    return FirstOrder(dc_gain=dc_gain, w0=w0, wp=w0 / ratio, dt=plant.dt)


def corners(target: Target, dc_gain: float) -> FirstOrder:
    """Return the section, for a phase that is known to be possible."""
    ratio, turn = dc_gain * target.size, target.v * sin(target.theta)
    return FirstOrder(
        dc_gain=dc_gain,
        w0=turn / (1 / ratio - cos(target.theta)),
        wp=turn / (cos(target.theta) - ratio),
        dt=target.dt,
    )


def _beyond(
    target: Target, dc_gain: float, any_sign: bool, any_pole: bool, *, rises: bool
) -> FirstOrder | None:
    """Return the section whose zero or pole is on the other side, where that is allowed.

    rises  whether its gain has to be larger at wc than at w = 0, as a lead's is
    """
    if not (any_sign or any_pole) or not sin(target.theta):
        return None
    found = corners(target, dc_gain)
    if (found.w0 < 0 and not any_sign) or (found.wp < 0 and not any_pole):
        return None
    return found if (dc_gain * target.size < 1) == rises else None
