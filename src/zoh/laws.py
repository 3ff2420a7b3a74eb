"""The laws by name: what users call.

Each returns a ``Verified`` design that meets its specification in the loop it was measured in, or
raises; none clamps. What is left out is chosen, see docs/choice.md. ``sections`` stand in series
with the law; ``allow`` names what is refused otherwise, see ``zoh.request.ALLOWABLE``.
"""

from collections.abc import Sequence

from zoh.analysis.asked import NOTHING_ASKED
from zoh.design.sections import SecondOrder
from zoh.pipeline import Design, Known, design
from zoh.spec import Requirements


def p(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    setpoint_weight: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the P controller with the margin pm_deg in deg, or crossing over at wc in rad/s.

    With pm_deg alone the fastest stable crossover is taken. Raises SpecError, Infeasible, NotMet.

    >>> import zoh
    >>> d = p(zoh.Plant(num=[1], den=[1, 0]), dt=1.0, pm_deg=45)
    >>> d.gains["kp"]  # 1/(z - 1): |z - 1| = sqrt(2) at wc = pi/2
    1.414213...
    """
    given = {"wc": wc, "pm_deg": pm_deg, "setpoint_weight": setpoint_weight}
    return design(
        plant, "p", given, dt=dt, compute_delay=compute_delay, sections=sections,
        allow=allow, requirements=requirements,
    )  # fmt: skip


def pi(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    setpoint_weight: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the PI controller kp + ki/w that crosses over at wc (rad/s) with pm_deg (deg).

    ``setpoint_weight`` b is the share of the reference that kp sees, u = kp (b r - y) + ki/w
    (r - y), 1 where it is left out: the margins do not change. Raises SpecError for a malformed
    request, Infeasible where a PI cannot, NotMet where the loop it gives is unstable or misses a
    requirement.
    """
    given = {"wc": wc, "pm_deg": pm_deg, "setpoint_weight": setpoint_weight}
    return design(
        plant, "pi", given, dt=dt, compute_delay=compute_delay, sections=sections,
        allow=allow, requirements=requirements,
    )  # fmt: skip


def pd(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    filter_pole: float | None = None, setpoint_weight: float | None = None,
    derivative_weight: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the PD controller kp + kd w/(1 + w/p) that crosses over at wc with pm_deg.

    p is ``filter_pole`` in rad/s, 2/dt where it is left out; the weights as for ``pid``.
    """
    given = {
        "wc": wc, "pm_deg": pm_deg, "filter_pole": filter_pole,
        "setpoint_weight": setpoint_weight, "derivative_weight": derivative_weight,
    }  # fmt: skip
    return design(
        plant, "pd", given, dt=dt, compute_delay=compute_delay, sections=sections,
        allow=allow, requirements=requirements,
    )  # fmt: skip


def pid(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    ki: float | None = None, ti_td: float | None = None, largest_ki_ms: float | None = None,
    least_iae_ms: float | None = None, filter_pole: float | None = None,
    setpoint_weight: float | None = None, derivative_weight: float | None = None,
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the PID that crosses over at wc (rad/s) with pm_deg (deg).

    D(w) = kp + ki/w + kd w/(1 + w/p), w = (2/dt)(z-1)/(z+1); p is ``filter_pole`` in rad/s,
    2/dt where it is left out. One gain is left free, and exactly one of these closes it:

    ki             the integral gain itself, in u/(y s)
    ti_td          Ti/Td = kp^2/(ki kd)
    largest_ki_ms  this bound on Ms, and the largest ki under it
    least_iae_ms   this bound on Ms, and the least IAE after a load step under it

    ``setpoint_weight`` b and ``derivative_weight`` c are the shares of the reference that kp and
    kd see, u = kp (b r - y) + ki/w (r - y) + kd w/(1 + w/p) (c r - y); 1 where they are left out.

    >>> import zoh
    >>> arm = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> d = pid(arm, dt=0.1, wc=1.95, pm_deg=40, ki=0.85)
    >>> round(d.margins.phase_margin_deg, 9), round(d.margins.crossover, 9)
    (40.0, 1.95)
    >>> d = pid(arm, dt=0.1, wc=1.95, pm_deg=40, largest_ki_ms=1.7)
    >>> round(d.margins.ms, 6)
    1.7
    >>> d = pid(arm, dt=0.1, wc=1.95, pm_deg=40, ki=0.85, setpoint_weight=0.5, derivative_weight=0)
    >>> round(d.margins.phase_margin_deg, 9), round(d.step.overshoot_pct, 1)
    (40.0, 0.0)
    """
    given = {
        "wc": wc, "pm_deg": pm_deg, "ki": ki, "ti_td": ti_td, "largest_ki_ms": largest_ki_ms,
        "least_iae_ms": least_iae_ms, "filter_pole": filter_pole,
        "setpoint_weight": setpoint_weight, "derivative_weight": derivative_weight,
    }  # fmt: skip
    return design(
        plant, "pid", given, dt=dt, compute_delay=compute_delay, sections=sections,
        allow=allow, requirements=requirements,
    )  # fmt: skip


def lag(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the lag with gain dc_gain at w = 0 that crosses over at wc with pm_deg."""
    given = {"wc": wc, "pm_deg": pm_deg, "dc_gain": dc_gain}
    return design(
        plant, "lag", given, dt=dt, compute_delay=compute_delay, sections=sections,
        allow=allow, requirements=requirements,
    )  # fmt: skip


def textbook_lag(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the lag of the textbook's rule: its zero a decade below wc, its far gain 1/|G(wc)|.

    The rule does not solve for wc and a margin: the loop crosses near wc, with what margin the
    result says. With pm_deg it is held to wc and to that margin, which it misses: NotMet says by
    how much. ``lag`` is the exact one.

    >>> import zoh
    >>> arm = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> d = textbook_lag(arm, dt=0.1, wc=0.5, dc_gain=10)
    >>> d.margins.crossover > 0.5
    True
    """
    given = {"wc": wc, "pm_deg": pm_deg, "dc_gain": dc_gain}
    return design(
        plant, "textbook_lag", given, dt=dt, compute_delay=compute_delay, sections=sections,
        allow=allow, requirements=requirements,
    )  # fmt: skip


def lead(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the lead with gain dc_gain at w = 0 that crosses over at wc with pm_deg.

    >>> import zoh
    >>> arm = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> lag(arm, dt=0.1, wc=3.29, pm_deg=40, dc_gain=10)
    Traceback (most recent call last):
    zoh.errors.Infeasible: a lag ... needs +36.07 deg ... laws that can here: pd, pid, lead
    """
    given = {"wc": wc, "pm_deg": pm_deg, "dc_gain": dc_gain}
    return design(
        plant, "lead", given, dt=dt, compute_delay=compute_delay, sections=sections,
        allow=allow, requirements=requirements,
    )  # fmt: skip


def leadlag(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, lag_corner: float | None = None,
    lag_ratio: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the lead-lag with gain dc_gain at w = 0 that crosses over at wc with pm_deg.

    ``lag_corner`` is the lag's zero in rad/s (w-plane), v/10 where it is left out; ``lag_ratio``
    its zero over its pole, where left out the one whose lead is centred at the crossover.

    >>> import zoh
    >>> arm = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> d = leadlag(arm, dt=0.1, wc=1.95, pm_deg=40, dc_gain=100)
    >>> round(d.margins.phase_margin_deg, 9), round(d.margins.crossover, 9)
    (40.0, 1.95)
    """
    given = {
        "wc": wc, "pm_deg": pm_deg, "dc_gain": dc_gain, "lag_corner": lag_corner,
        "lag_ratio": lag_ratio,
    }  # fmt: skip
    return design(
        plant, "leadlag", given, dt=dt, compute_delay=compute_delay, sections=sections,
        allow=allow, requirements=requirements,
    )  # fmt: skip
