"""Plant and specification in, verified controller out: sample, solve, measure, verify.

The functions named after the laws are what users call. Each returns a ``Verified`` design that
meets its specification in the loop it was measured in, or raises; none clamps.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import overload

from zoh import checks
from zoh.analysis.load_error import load_iae
from zoh.analysis.tabled.verify import TableVerified
from zoh.analysis.verify import NOTHING_ASKED, Verified, measure, verified
from zoh.certificate import (
    LAWS,
    OPTIONS,
    SPARE,
    UNDER_MS,
    SolvedLaw,
    certified,
    least_turn,
    not_as_asked,
    solved,
)
from zoh.choice.choose import AUTO, OF_AUTO, choose
from zoh.choice.judge import Judge
from zoh.design import p as p_law
from zoh.design.sections import SecondOrder, in_series
from zoh.design.target import Target
from zoh.errors import Infeasible, NotMet, SpecError
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample
from zoh.spec import Crossover, Requirements
from zoh.table_design import design_on_table

Known = Plant | FrequencyResponse  # a plant as a model, or as the table of its response
_ANY_MARGIN = 90.0  # deg; a rule that takes no margin does not look at it
Design = Verified | TableVerified  # verified on the one, or on the other


def p(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (),
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the P controller with the margin pm_deg in deg, or crossing over at wc in rad/s.

    With pm_deg alone the fastest stable crossover is taken. Raises SpecError, Infeasible, NotMet.

    >>> d = p(Plant(num=[1], den=[1, 0]), dt=1.0, pm_deg=45)
    >>> d.gains["kp"]  # 1/(z - 1): |z - 1| = sqrt(2) at wc = pi/2
    1.414213...
    """
    given = {"wc": wc, "pm_deg": pm_deg}
    return design(
        plant, "p", given, dt=dt, compute_delay=compute_delay, sections=sections,
        requirements=requirements,
    )  # fmt: skip


def pi(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (),
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the PI controller kp + ki/w that crosses over at wc (rad/s) with pm_deg (deg).

    Raises SpecError for a malformed request, Infeasible where a PI cannot, NotMet where the
    loop it gives is unstable or misses a requirement.
    """
    given = {"wc": wc, "pm_deg": pm_deg}
    return design(
        plant, "pi", given, dt=dt, compute_delay=compute_delay, sections=sections,
        requirements=requirements,
    )  # fmt: skip


def pd(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    filter_pole: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the PD controller kp + kd w/(1 + w/p) that crosses over at wc with pm_deg.

    p is ``filter_pole`` in rad/s, 2/dt where it is left out.
    """
    given = {"wc": wc, "pm_deg": pm_deg, "filter_pole": filter_pole}
    return design(
        plant, "pd", given, dt=dt, compute_delay=compute_delay, sections=sections,
        requirements=requirements,
    )  # fmt: skip


def pid(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    ki: float | None = None, ti_td: float | None = None, largest_ki_ms: float | None = None,
    least_iae_ms: float | None = None, filter_pole: float | None = None,
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (),
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the PID that crosses over at wc (rad/s) with pm_deg (deg).

    D(w) = kp + ki/w + kd w/(1 + w/p), w = (2/dt)(z-1)/(z+1); p is ``filter_pole`` in rad/s,
    2/dt where it is left out. One gain is left free, and exactly one of these closes it:

    ki             the integral gain itself, in u/(y s)
    ti_td          Ti/Td = kp^2/(ki kd)
    largest_ki_ms  this bound on Ms, and the largest ki under it
    least_iae_ms   this bound on Ms, and the least IAE after a load step under it

    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> d = pid(arm, dt=0.1, wc=1.95, pm_deg=40, ki=0.85)
    >>> round(d.margins.phase_margin_deg, 9), round(d.margins.crossover, 9)
    (40.0, 1.95)
    >>> d = pid(arm, dt=0.1, wc=1.95, pm_deg=40, largest_ki_ms=1.7)
    >>> round(d.margins.ms, 6)
    1.7
    """
    given = {
        "wc": wc, "pm_deg": pm_deg, "ki": ki, "ti_td": ti_td, "largest_ki_ms": largest_ki_ms,
        "least_iae_ms": least_iae_ms, "filter_pole": filter_pole,
    }  # fmt: skip
    return design(
        plant, "pid", given, dt=dt, compute_delay=compute_delay, sections=sections,
        requirements=requirements,
    )  # fmt: skip


def lag(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the lag with gain dc_gain at w = 0 that crosses over at wc with pm_deg."""
    given = {"wc": wc, "pm_deg": pm_deg, "dc_gain": dc_gain}
    return design(
        plant, "lag", given, dt=dt, compute_delay=compute_delay, sections=sections,
        requirements=requirements,
    )  # fmt: skip


def textbook_lag(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the lag of the textbook's rule: its zero a decade below wc, its far gain 1/|G(wc)|.

    The rule does not solve for wc and a margin: the loop crosses near wc, with what margin the
    result says. With pm_deg it is held to wc and to that margin, which it misses: NotMet says by
    how much. ``lag`` is the exact one.

    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> d = textbook_lag(arm, dt=0.1, wc=0.5, dc_gain=10)
    >>> d.margins.crossover > 0.5
    True
    """
    given = {"wc": wc, "pm_deg": pm_deg, "dc_gain": dc_gain}
    return design(
        plant, "textbook_lag", given, dt=dt, compute_delay=compute_delay, sections=sections,
        requirements=requirements,
    )  # fmt: skip


def lead(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the lead with gain dc_gain at w = 0 that crosses over at wc with pm_deg.

    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> lag(arm, dt=0.1, wc=3.29, pm_deg=40, dc_gain=10)
    Traceback (most recent call last):
    zoh.errors.Infeasible: a lag ... needs +36.07 deg ... laws that can here: pd, pid, lead
    """
    given = {"wc": wc, "pm_deg": pm_deg, "dc_gain": dc_gain}
    return design(
        plant, "lead", given, dt=dt, compute_delay=compute_delay, sections=sections,
        requirements=requirements,
    )  # fmt: skip


def leadlag(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, lag_corner: float | None = None,
    lag_ratio: float | None = None, compute_delay: float = 0.0,
    sections: Sequence[SecondOrder] = (), requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the lead-lag with gain dc_gain at w = 0 that crosses over at wc with pm_deg.

    ``lag_corner`` is the lag's zero in rad/s (w-plane), v/10 where it is left out; ``lag_ratio``
    its zero over its pole, where left out the one whose lead is centred at the crossover.

    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
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
        requirements=requirements,
    )  # fmt: skip


@overload
def design(
    plant: Plant, law: str, given: Mapping[str, float | None], *, dt: float,
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (),
    requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0, name: str | None = None,
) -> Verified: ...  # fmt: skip
@overload
def design(
    plant: FrequencyResponse, law: str, given: Mapping[str, float | None], *, dt: float,
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (),
    requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0, name: str | None = None,
) -> TableVerified: ...  # fmt: skip
def design(
    plant: Known, law: str, given: Mapping[str, float | None], *, dt: float,
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (),
    requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0, name: str | None = None,
) -> Design:  # fmt: skip
    """Return the verified design of ``law``; ``given`` are its parameters, named in ``LAWS``.

    Raises SpecError for an unknown law or parameter, one that is missing or out of range;
    Infeasible where the law cannot, with what could; NotMet where the loop is unstable, has a
    smaller margin at another crossover, or misses a requirement. On a table it is a
    ``TableVerified``, which has no step response and so no use for the reference. Fixed
    ``sections`` are in series with the law, which is solved on their product with the plant.
    """
    parameters = checked_parameters(law, given)
    fixed = in_series(sections, dt)
    missing = left_open(law, parameters)
    if isinstance(plant, FrequencyResponse):
        if missing:
            raise _must_be_given(law, missing[0])
        return design_on_table(
            plant, law, parameters, dt=dt, compute_delay=compute_delay, fixed=fixed,
            requirements=requirements, name=name,
        )  # fmt: skip
    sampled = sample(plant, dt, compute_delay)
    sampled = fixed * sampled if fixed else sampled
    requirements = _bounded(requirements, parameters)

    def iae(controller: Sampled) -> float:
        return load_iae(plant, controller * fixed if fixed else controller, compute_delay)

    def checked(found: SolvedLaw, spec: Crossover | None) -> Verified:
        evidence = measure(
            plant, found.controller * fixed if fixed else found.controller,
            compute_delay=compute_delay, requirements=requirements, reference=reference, law=law,
            gains=found.gains, name=name,
        )  # fmt: skip
        off = not_as_asked(evidence.margins, spec)
        if off:
            raise NotMet((*evidence.misses, *off), evidence)
        return verified(evidence)

    if law == "p" and len(parameters) == 1:
        return _free_p(sampled, parameters, checked)
    if missing:
        _check_choosable(law, missing[0], parameters, sections)
        judge = Judge(
            plant=plant, sampled=sampled, compute_delay=compute_delay,
            requirements=requirements, reference=reference,
        )  # fmt: skip
        return _chosen(judge, law, parameters, name)
    spec = Crossover(wc=parameters["wc"], pm_deg=parameters.get("pm_deg", _ANY_MARGIN))
    asked = spec if "pm_deg" in parameters else None
    try:
        return checked(solved(law, sampled, spec, parameters, iae), asked)
    except Infeasible as refused:
        if asked is None:
            raise
        raise certified(refused, law, sampled, spec, parameters) from None


def _chosen(judge: Judge, law: str, parameters: Mapping[str, float], name: str | None) -> Verified:
    """Return the design whose open parameters were chosen, measured anew."""
    spec = Crossover(
        wc=parameters.get("wc", 1e-9 / judge.sampled.dt), pm_deg=parameters.get("pm_deg", 45.0)
    )
    spec.below_nyquist(judge.sampled.dt)
    chosen = choose(judge, law, parameters)
    found = design(
        judge.plant, chosen.law, chosen.parameters, dt=judge.sampled.dt,
        compute_delay=judge.compute_delay, requirements=chosen.requirements,
        reference=judge.reference, name=name,
    )  # fmt: skip
    return replace(found, choice=chosen.choice)


def _free_p(
    sampled: Sampled,
    parameters: Mapping[str, float],
    checked: Callable[[SolvedLaw, Crossover | None], Verified],
) -> Verified:
    """Return the P of a crossover alone, or of a margin alone: there the fastest that holds."""
    if "wc" in parameters:
        target = Target.of(sampled, Crossover(wc=parameters["wc"], pm_deg=90.0))
        law = p_law.P(kp=1 / target.size, dt=sampled.dt)
        return checked(SolvedLaw(controller=law.controller(), gains=law.gains), None)
    pm_deg = Crossover(wc=1.0, pm_deg=parameters["pm_deg"]).pm_deg
    failure: NotMet | None = None
    for wc in p_law.crossovers(sampled, pm_deg):
        law = p_law.P(kp=1 / abs(sampled.at(wc)), dt=sampled.dt)
        try:
            return checked(
                SolvedLaw(controller=law.controller(), gains=law.gains),
                Crossover(wc=wc, pm_deg=pm_deg),
            )
        except NotMet as missed:
            failure = failure or missed
    if failure is not None:
        raise failure
    raise Infeasible(
        f"a P turns the phase by nothing, and the plant alone has a margin of {pm_deg:g} deg "
        "at no frequency below Nyquist's",
        needed_deg=least_turn(sampled, pm_deg),
    )


def _bounded(asked: Requirements, parameters: Mapping[str, float]) -> Requirements:
    """Return the requirements with the bound on Ms that a search was made under."""
    bounds = [parameters[k] for k in UNDER_MS if k in parameters]
    if not bounds or not isinstance(asked, Requirements):
        return asked
    return replace(asked, ms=min(bounds + ([] if asked.ms is None else [asked.ms])))


def checked_parameters(law: str, given: Mapping[str, float | None]) -> dict[str, float]:
    """Return the parameters given (None is not given); raise SpecError unless they fit the law."""
    if not isinstance(law, str) or law not in (*LAWS, AUTO):
        names = ", ".join((*LAWS, AUTO))
        raise SpecError("law", f"must be one of {names}", law, "choose one of these")
    if not isinstance(given, Mapping):
        raise SpecError("given", "must name the law's parameters", given, '{"wc": 1, "pm_deg": 50}')
    takes = LAWS.get(law, OF_AUTO) + OPTIONS.get(law, ())
    for name, value in given.items():
        if name not in takes:
            raise SpecError(
                name, f"is no parameter of {law} ({', '.join(takes)})", value, "leave it out"
            )
    parameters = {k: checks.positive(k, v) for k, v in given.items() if v is not None}
    spare = [name for name in SPARE if name in parameters]
    if len(spare) > 1:
        bound = f"must not be given beside {spare[0]}"
        raise SpecError(spare[1], bound, parameters[spare[1]], "one closes the PID's freedom")
    usual = {"largest_ki_ms": "1.4 to 2", "least_iae_ms": "1.4 to 2", "lag_ratio": "3 to 20"}
    for name, way_out in usual.items():
        if parameters.get(name, inf) <= 1:
            raise SpecError(name, "must be above 1", parameters[name], f"{way_out} is usual")
    return parameters


def left_open(law: str, parameters: Mapping[str, float]) -> list[str]:
    """Return the parameters that were left open; a P has one of two, a PID one of ``SPARE``."""
    if law == "p" and parameters:
        return []
    closed = any(name in parameters for name in SPARE)
    takes = ("law",) if law == AUTO else LAWS[law]
    return [name for name in takes if name not in parameters and not (name == "ki" and closed)]


def _check_choosable(
    law: str, name: str, parameters: Mapping[str, float], sections: Sequence[SecondOrder]
) -> None:
    """Refuse to choose where the search knows nothing of what was given."""
    known = ("filter_pole", "ti_td")
    options = [name for name in OPTIONS.get(law, ()) if name not in known]
    beside = next((k for k in options if k in parameters), None)
    beside = "sections" if sections and beside is None else beside
    if beside or law in ("leadlag", "textbook_lag"):
        takes = ", ".join(LAWS.get(law, OF_AUTO))
        bound = f"must be given for {law}" + (f" beside {beside}" if beside else "")
        raise SpecError(name, bound, None, f"{law} takes {takes}")


def _must_be_given(law: str, name: str) -> SpecError:
    takes = ", ".join(LAWS.get(law, ())) or "a plant's model"
    return SpecError(name, f"must be given for {law} on a table", None, f"{law} takes {takes}")
