"""Plant and specification in, verified controller out: sample, solve, measure, verify.

The functions named after the laws are what users call. Each returns a ``Verified`` design that
meets its specification in the loop it was measured in, or raises; none clamps.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import cos

import numpy as np

from zoh import checks
from zoh.analysis.closed import followable
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.results import Margins
from zoh.analysis.stability import closed_loop_stable
from zoh.analysis.verify import NOTHING_ASKED, Measured, Verified, measure, verified
from zoh.design import first_order
from zoh.design import p as p_law
from zoh.design import pi as pi_law
from zoh.design import pid as pid_law
from zoh.design.target import Target, nearest
from zoh.errors import Infeasible, NotMet, SpecError
from zoh.lti.systems import Plant, Sampled, sample_time
from zoh.sampling.hold import sample
from zoh.spec import Crossover, Requirements

LAWS: Mapping[str, tuple[str, ...]] = {
    "p": ("wc", "pm_deg"),
    "pi": ("wc", "pm_deg"),
    "pd": ("wc", "pm_deg"),
    "pid": ("wc", "pm_deg", "ki"),
    "lag": ("wc", "pm_deg", "dc_gain"),
    "lead": ("wc", "pm_deg", "dc_gain"),
}
"""Every law and the parameters it takes."""

_MARGIN_TOL_DEG = 1e-9  # the promise of this library; the closed forms reach some 1e-13
_CROSSOVER_TOL = 1e-9  # relative
_SMALL_KI = 1e-3  # times wc/|G|: an integral that is there and turns next to nothing


@dataclass(frozen=True, slots=True, kw_only=True)
class _Law:
    """A solved law, whichever it is."""

    controller: Sampled
    gains: Mapping[str, float]


def p(
    plant: Plant, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    compute_delay: float = 0.0, requirements: Requirements = NOTHING_ASKED,
) -> Verified:  # fmt: skip
    """Return the P controller with the margin pm_deg in deg, or crossing over at wc in rad/s.

    With pm_deg alone the fastest stable crossover is taken. Raises SpecError, Infeasible, NotMet.

    >>> d = p(Plant(num=[1], den=[1, 0]), dt=1.0, pm_deg=45)
    >>> d.gains["kp"]  # 1/(z - 1): |z - 1| = sqrt(2) at wc = pi/2
    1.414213...
    """
    given = {"wc": wc, "pm_deg": pm_deg}
    return design(plant, "p", given, dt=dt, compute_delay=compute_delay, requirements=requirements)


def pi(
    plant: Plant, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    compute_delay: float = 0.0, requirements: Requirements = NOTHING_ASKED,
) -> Verified:  # fmt: skip
    """Return the PI controller kp + ki/w that crosses over at wc (rad/s) with pm_deg (deg).

    Raises SpecError for a malformed request, Infeasible where a PI cannot, NotMet where the
    loop it gives is unstable or misses a requirement.
    """
    given = {"wc": wc, "pm_deg": pm_deg}
    return design(plant, "pi", given, dt=dt, compute_delay=compute_delay, requirements=requirements)


def pd(
    plant: Plant, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    compute_delay: float = 0.0, requirements: Requirements = NOTHING_ASKED,
) -> Verified:  # fmt: skip
    """Return the PD controller kp + kd w/(1 + w dt/2) that crosses over at wc with pm_deg."""
    given = {"wc": wc, "pm_deg": pm_deg}
    return design(plant, "pd", given, dt=dt, compute_delay=compute_delay, requirements=requirements)


def pid(
    plant: Plant, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    ki: float | None = None, compute_delay: float = 0.0,
    requirements: Requirements = NOTHING_ASKED,
) -> Verified:  # fmt: skip
    """Return the PID with integral gain ki that crosses over at wc (rad/s) with pm_deg (deg).

    D(w) = kp + ki/w + kd w/(1 + w dt/2), w = (2/dt)(z-1)/(z+1).

    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> d = pid(arm, dt=0.1, wc=1.95, pm_deg=40, ki=0.85)
    >>> round(d.margins.phase_margin_deg, 9), round(d.margins.crossover, 9)
    (40.0, 1.95)
    """
    given = {"wc": wc, "pm_deg": pm_deg, "ki": ki}
    return design(
        plant, "pid", given, dt=dt, compute_delay=compute_delay, requirements=requirements
    )


def lag(
    plant: Plant, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, compute_delay: float = 0.0,
    requirements: Requirements = NOTHING_ASKED,
) -> Verified:  # fmt: skip
    """Return the lag with gain dc_gain at w = 0 that crosses over at wc with pm_deg."""
    given = {"wc": wc, "pm_deg": pm_deg, "dc_gain": dc_gain}
    return design(
        plant, "lag", given, dt=dt, compute_delay=compute_delay, requirements=requirements
    )


def lead(
    plant: Plant, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, compute_delay: float = 0.0,
    requirements: Requirements = NOTHING_ASKED,
) -> Verified:  # fmt: skip
    """Return the lead with gain dc_gain at w = 0 that crosses over at wc with pm_deg.

    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> lag(arm, dt=0.1, wc=3.29, pm_deg=40, dc_gain=10)
    Traceback (most recent call last):
    zoh.errors.Infeasible: a lag ... needs +36.07 deg ... laws that can here: pd, pid, lead
    """
    given = {"wc": wc, "pm_deg": pm_deg, "dc_gain": dc_gain}
    return design(
        plant, "lead", given, dt=dt, compute_delay=compute_delay, requirements=requirements
    )


def design(
    plant: Plant, law: str, given: Mapping[str, float | None], *, dt: float,
    compute_delay: float = 0.0, requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0, name: str | None = None,
) -> Verified:  # fmt: skip
    """Return the verified design of ``law``; ``given`` are its parameters, named in ``LAWS``.

    Raises SpecError for an unknown law or parameter, one that is missing or out of range;
    Infeasible where the law cannot, with what could; NotMet where the loop is unstable, has a
    smaller margin at another crossover, or misses a requirement.
    """
    parameters = _checked(law, given)
    followable(plant, sample_time(dt), compute_delay)
    sampled = sample(plant, dt, compute_delay)

    def checked(found: _Law, spec: Crossover | None) -> Verified:
        evidence = measure(
            plant, found.controller, compute_delay=compute_delay, requirements=requirements,
            reference=reference, law=law, gains=found.gains, name=name,
        )  # fmt: skip
        off = _not_as_asked(evidence, spec)
        if off:
            raise NotMet((*evidence.misses, *off), evidence)
        return verified(evidence)

    if law == "p" and len(parameters) == 1:
        return _free_p(sampled, parameters, checked)
    spec = Crossover(wc=parameters["wc"], pm_deg=parameters["pm_deg"])
    try:
        return checked(_solved(law, sampled, spec, parameters), spec)
    except Infeasible as refused:
        raise _certified(refused, law, sampled, spec, parameters) from None


def _free_p(
    sampled: Sampled,
    parameters: Mapping[str, float],
    checked: Callable[[_Law, Crossover | None], Verified],
) -> Verified:
    """Return the P of a crossover alone, or of a margin alone: there the fastest that holds."""
    if "wc" in parameters:
        target = Target.of(sampled, Crossover(wc=parameters["wc"], pm_deg=90.0))
        law = p_law.P(kp=1 / target.size, dt=sampled.dt)
        return checked(_Law(controller=law.controller(), gains=law.gains), None)
    pm_deg = Crossover(wc=1.0, pm_deg=parameters["pm_deg"]).pm_deg
    failure: NotMet | None = None
    for wc in p_law.crossovers(sampled, pm_deg):
        law = p_law.P(kp=1 / abs(sampled.at(wc)), dt=sampled.dt)
        try:
            return checked(
                _Law(controller=law.controller(), gains=law.gains),
                Crossover(wc=wc, pm_deg=pm_deg),
            )
        except NotMet as missed:
            failure = failure or missed
    if failure is not None:
        raise failure
    raise Infeasible(
        f"a P turns the phase by nothing, and the plant alone has a margin of {pm_deg:g} deg "
        "at no frequency below Nyquist's",
        needed_deg=_least_turn(sampled, pm_deg),
    )


def _least_turn(sampled: Sampled, pm_deg: float) -> float:
    """Return the smallest phase in deg, over all frequencies, that would make up the margin."""
    phase = np.degrees(np.angle(sampled.at(p_law.looked_at(sampled))))
    turns = (pm_deg - phase) % 360.0 - 180.0
    return float(turns[np.argmin(np.abs(turns))])


def _solved(law: str, sampled: Sampled, spec: Crossover, parameters: Mapping[str, float]) -> _Law:
    found: p_law.P | pi_law.PI | pid_law.PID | first_order.FirstOrder
    if law == "p":
        found = p_law.solve(sampled, spec)
    elif law == "pi":
        found = pi_law.solve(sampled, spec)
    elif law in ("pd", "pid"):
        found = pid_law.solve(sampled, spec, parameters["ki"] if law == "pid" else 0.0)
    elif law == "lag":
        found = first_order.lag(sampled, spec, parameters["dc_gain"])
    else:
        found = first_order.lead(sampled, spec, parameters["dc_gain"])
    gains = {k: v for k, v in found.gains.items() if law != "pd" or k != "ki"}
    return _Law(controller=found.controller(), gains=gains)


def _not_as_asked(evidence: Measured, spec: Crossover | None) -> list[str]:
    """Return what is not as the crossover was asked for; instability speaks for itself."""
    m = evidence.margins
    if spec is None or not m.stable or not _off_target(m, spec):
        return []
    at = "no frequency" if m.crossover is None else f"{m.crossover:.6g} rad/s"
    return [
        f"the phase margin is {m.phase_margin_deg:.6g} deg at {at}, another crossover "
        f"of this loop, not {spec.pm_deg:g} deg at {spec.wc:g} rad/s"
    ]


def _off_target(m: Margins, spec: Crossover) -> bool:
    """Return whether the margin nearest to zero is another one than was asked for."""
    return (
        m.crossover is None
        or abs(m.phase_margin_deg - spec.pm_deg) > _MARGIN_TOL_DEG
        or abs(m.crossover / spec.wc - 1) > _CROSSOVER_TOL
    )


def _certified(
    refused: Infeasible, law: str, sampled: Sampled, spec: Crossover,
    parameters: Mapping[str, float],
) -> Infeasible:  # fmt: skip
    """Return the refusal with where this law can, and which laws can here; all of it tried."""

    def works(name: str, at: Crossover) -> bool:
        try:
            found = _solved(name, sampled, at, {**_free(sampled, at), **parameters})
        except (Infeasible, SpecError):
            return False
        loop = Loop.of(found.controller, sampled)
        return closed_loop_stable(loop) and not _off_target(measure_loop(loop), at)

    return Infeasible(
        refused.reason,
        needed_deg=refused.needed_deg,
        best_pm_deg=refused.best_pm_deg,
        nearest_wc=nearest(
            lambda wc: works(law, Crossover(wc=wc, pm_deg=spec.pm_deg)), spec.wc, sampled.dt
        ),
        laws_that_can=tuple(name for name in LAWS if name != law and works(name, spec)),
    )


def _free(sampled: Sampled, spec: Crossover) -> dict[str, float]:
    """Return values to try for gains that were not given: modest ones that leave room.

    A small integral; a gain at w = 0 from which a lead has to rise, or a lag to fall, to twice
    or half of it along the way.
    """
    target = Target.of(sampled, spec)
    needed = max(cos(target.theta), 0.1) / target.size
    return {
        "ki": _SMALL_KI * spec.wc / target.size,
        "dc_gain": needed / 2 if target.theta > 0 else 2 / (needed * target.size**2),
    }


def _checked(law: str, given: Mapping[str, float | None]) -> dict[str, float]:
    """Return the parameters given (None is not given); raise SpecError unless they fit the law."""
    if not isinstance(law, str) or law not in LAWS:
        raise SpecError("law", f"must be one of {', '.join(LAWS)}", law, "choose one of these")
    if not isinstance(given, Mapping):
        raise SpecError("given", "must name the law's parameters", given, '{"wc": 1, "pm_deg": 50}')
    takes = LAWS[law]
    for name, value in given.items():
        if name not in takes:
            raise SpecError(
                name, f"is no parameter of {law} ({', '.join(takes)})", value, "leave it out"
            )
    parameters = {k: checks.positive(k, v) for k, v in given.items() if v is not None}
    missing = [name for name in takes if name not in parameters]
    if missing and not (law == "p" and parameters):
        raise SpecError(
            missing[0], f"must be given for {law}", None, f"{law} takes {', '.join(takes)}"
        )
    return parameters
