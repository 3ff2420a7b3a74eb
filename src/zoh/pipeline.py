"""Plant and specification in, verified controller out: sample, solve, measure, verify.

The functions named after the laws are what users call. Each returns a ``Verified`` design that
meets its specification in the loop it was measured in, or raises; none clamps.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import overload

from zoh import checks
from zoh.analysis.load_error import load_iae
from zoh.analysis.tabled.verify import TableVerified
from zoh.analysis.verify import NOTHING_ASKED, Verified, measure, verified
from zoh.certificate import (
    LAWS,
    OPTIONS,
    SPARE,
    SolvedLaw,
    certified,
    least_turn,
    not_as_asked,
    solved,
)
from zoh.choice.choose import AUTO, OF_AUTO, choose
from zoh.choice.judge import Judge
from zoh.design import p as p_law
from zoh.design.target import Target
from zoh.errors import Infeasible, NotMet, SpecError
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample
from zoh.spec import Crossover, Requirements
from zoh.table_design import design_on_table

Known = Plant | FrequencyResponse  # a plant as a model, or as the table of its response
Design = Verified | TableVerified  # verified on the one, or on the other


def p(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    compute_delay: float = 0.0, requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the P controller with the margin pm_deg in deg, or crossing over at wc in rad/s.

    With pm_deg alone the fastest stable crossover is taken. Raises SpecError, Infeasible, NotMet.

    >>> d = p(Plant(num=[1], den=[1, 0]), dt=1.0, pm_deg=45)
    >>> d.gains["kp"]  # 1/(z - 1): |z - 1| = sqrt(2) at wc = pi/2
    1.414213...
    """
    given = {"wc": wc, "pm_deg": pm_deg}
    return design(plant, "p", given, dt=dt, compute_delay=compute_delay, requirements=requirements)


def pi(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    compute_delay: float = 0.0, requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the PI controller kp + ki/w that crosses over at wc (rad/s) with pm_deg (deg).

    Raises SpecError for a malformed request, Infeasible where a PI cannot, NotMet where the
    loop it gives is unstable or misses a requirement.
    """
    given = {"wc": wc, "pm_deg": pm_deg}
    return design(plant, "pi", given, dt=dt, compute_delay=compute_delay, requirements=requirements)


def pd(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    filter_pole: float | None = None, compute_delay: float = 0.0,
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the PD controller kp + kd w/(1 + w/p) that crosses over at wc with pm_deg.

    p is ``filter_pole`` in rad/s, 2/dt where it is left out.
    """
    given = {"wc": wc, "pm_deg": pm_deg, "filter_pole": filter_pole}
    return design(plant, "pd", given, dt=dt, compute_delay=compute_delay, requirements=requirements)


def pid(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    ki: float | None = None, ti_td: float | None = None, largest_ki_ms: float | None = None,
    least_iae_ms: float | None = None, filter_pole: float | None = None,
    compute_delay: float = 0.0, requirements: Requirements = NOTHING_ASKED,
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
        plant, "pid", given, dt=dt, compute_delay=compute_delay, requirements=requirements
    )


def lag(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, compute_delay: float = 0.0,
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
    """Return the lag with gain dc_gain at w = 0 that crosses over at wc with pm_deg."""
    given = {"wc": wc, "pm_deg": pm_deg, "dc_gain": dc_gain}
    return design(
        plant, "lag", given, dt=dt, compute_delay=compute_delay, requirements=requirements
    )


def lead(
    plant: Known, *, dt: float, wc: float | None = None, pm_deg: float | None = None,
    dc_gain: float | None = None, compute_delay: float = 0.0,
    requirements: Requirements = NOTHING_ASKED,
) -> Design:  # fmt: skip
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


@overload
def design(
    plant: Plant, law: str, given: Mapping[str, float | None], *, dt: float,
    compute_delay: float = 0.0, requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0, name: str | None = None,
) -> Verified: ...  # fmt: skip
@overload
def design(
    plant: FrequencyResponse, law: str, given: Mapping[str, float | None], *, dt: float,
    compute_delay: float = 0.0, requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0, name: str | None = None,
) -> TableVerified: ...  # fmt: skip
def design(
    plant: Known, law: str, given: Mapping[str, float | None], *, dt: float,
    compute_delay: float = 0.0, requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0, name: str | None = None,
) -> Design:  # fmt: skip
    """Return the verified design of ``law``; ``given`` are its parameters, named in ``LAWS``.

    Raises SpecError for an unknown law or parameter, one that is missing or out of range;
    Infeasible where the law cannot, with what could; NotMet where the loop is unstable, has a
    smaller margin at another crossover, or misses a requirement. On a table it is a
    ``TableVerified``, which has no step response and so no use for the reference.
    """
    parameters = _checked(law, given)
    missing = left_open(law, parameters)
    if isinstance(plant, FrequencyResponse):
        if missing:
            raise _must_be_given(law, missing[0])
        return design_on_table(
            plant, law, parameters, dt=dt, compute_delay=compute_delay, requirements=requirements,
            name=name,
        )  # fmt: skip
    sampled = sample(plant, dt, compute_delay)
    requirements = _bounded(requirements, parameters)

    def iae(controller: Sampled) -> float:
        return load_iae(plant, controller, compute_delay)

    def checked(found: SolvedLaw, spec: Crossover | None) -> Verified:
        evidence = measure(
            plant, found.controller, compute_delay=compute_delay, requirements=requirements,
            reference=reference, law=law, gains=found.gains, name=name,
        )  # fmt: skip
        off = not_as_asked(evidence.margins, spec)
        if off:
            raise NotMet((*evidence.misses, *off), evidence)
        return verified(evidence)

    if law == "p" and len(parameters) == 1:
        return _free_p(sampled, parameters, checked)
    if missing:
        judge = Judge(
            plant=plant, sampled=sampled, compute_delay=compute_delay,
            requirements=requirements, reference=reference,
        )  # fmt: skip
        return _chosen(judge, law, parameters, name)
    spec = Crossover(wc=parameters["wc"], pm_deg=parameters["pm_deg"])
    try:
        return checked(solved(law, sampled, spec, parameters, iae), spec)
    except Infeasible as refused:
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
    bounds = [parameters[k] for k in ("largest_ki_ms", "least_iae_ms") if k in parameters]
    if not bounds or not isinstance(asked, Requirements):
        return asked
    return replace(asked, ms=min(bounds + ([] if asked.ms is None else [asked.ms])))


def _checked(law: str, given: Mapping[str, float | None]) -> dict[str, float]:
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
    for name in ("largest_ki_ms", "least_iae_ms"):
        if name in parameters:
            _check_searched(name, parameters)
    return parameters


def _check_searched(name: str, parameters: Mapping[str, float]) -> None:
    if parameters[name] <= 1:
        raise SpecError(name, "must be above 1", parameters[name], "1.4 to 2 is usual")
    for other in OF_AUTO:
        if other not in parameters:
            bound = f"must be given with {name}"
            raise SpecError(other, bound, None, "leave ki open, ask for Requirements(ms=...)")


def left_open(law: str, parameters: Mapping[str, float]) -> list[str]:
    """Return the parameters that were left open; a P has one of two, a PID one of ``SPARE``."""
    if law == "p" and parameters:
        return []
    if law == AUTO:
        return ["law"]
    closed = any(name in parameters for name in SPARE)
    return [k for k in LAWS[law] if k not in parameters and not (k == "ki" and closed)]


def _must_be_given(law: str, name: str) -> SpecError:
    takes = ", ".join(LAWS.get(law, ())) or "a plant's model"
    return SpecError(name, f"must be given for {law} on a table", None, f"{law} takes {takes}")
