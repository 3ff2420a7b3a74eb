"""A batch by the single design, one loop after the other: the truth, and the way for any loop.

Each loop is sampled, solved, measured and verified as ``zoh.design`` does it, without the search
for what could be had instead of a request that cannot be met.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan, pi
from warnings import catch_warnings, simplefilter

import numpy as np

from zoh.analysis.load_error import load_iae
from zoh.analysis.on_target import not_as_asked
from zoh.analysis.results import Margins, StepInfo
from zoh.analysis.verify import Measured, measure, verified
from zoh.batch import sources
from zoh.batch.columns import Columns, Results, empty, length
from zoh.batch.figures import FIGURES
from zoh.batch.job import Job
from zoh.batch.reason import Reason
from zoh.design.sections import in_series
from zoh.errors import AccuracyWarning, Infeasible, NotMet, SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.lti.weights import WEIGHTS
from zoh.pipeline import design
from zoh.request import OPTIONS, checked
from zoh.sampling.hold import sample
from zoh.solving import SolvedLaw, solved
from zoh.spec import Crossover

_ANY_MARGIN = 90.0  # deg; a rule that takes no margin does not look at it


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What became of one loop: why, its gains, and what was measured where it is stable."""

    reason: Reason
    gains: Mapping[str, float]
    measured: Measured | None = None


def run(job: Job, columns: Columns) -> Results:
    """Return the columns of ``zoh.batch.figures`` for every loop of the batch.

    >>> import numpy as np
    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> job = Job(plant=arm, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc",))
    >>> found = run(job, {"wc": np.array([0.8, 3.0, 40.0])})
    >>> [Reason(code).name for code in found["reason"]]
    ['OK', 'INFEASIBLE', 'BEYOND_NYQUIST']
    >>> found["phase_margin_deg"].round(9).tolist()
    [40.0, nan, nan]
    """
    n = length(job, columns)
    out = empty(job, n)
    with catch_warnings(), np.errstate(over="raise", invalid="raise", divide="raise"):
        simplefilter("ignore", AccuracyWarning)  # of a million loops nobody reads a million lines
        for i in range(n):
            outcome = one(job, {key: float(column[i]) for key, column in columns.items()})
            out["reason"][i] = outcome.reason
            for name, gain in outcome.gains.items():
                out[f"gains.{name}"][i] = gain
            if outcome.measured is not None:
                out["stable"][i] = True
                for name, value in _figures(outcome.measured).items():
                    out[name][i] = nan if value is None else value
    return out


def one(job: Job, values: Mapping[str, float]) -> Outcome:
    """Return what becomes of the loop with these values of what varies."""
    try:
        return _one(job, values)
    except Infeasible:
        return Outcome(reason=Reason.INFEASIBLE, gains={})
    except NotMet as missed:
        return _not_met(missed.measured)
    except (SpecError, ArithmeticError):  # a number beyond a float is an answer here, too
        return Outcome(reason=Reason.MALFORMED, gains={})


def _one(job: Job, values: Mapping[str, float]) -> Outcome:
    clock = {**job.clock, **values}
    dt, delay, late = clock["dt"], clock["compute_delay"], clock["dead_time"]
    changes = {key: v for key, v in values.items() if key.startswith("plant.")}
    plant = sources.plant_of(job.plant, changes, late)
    asked = {**job.asked, **{k: v for k, v in values.items() if k in job.law_keys}}
    if job.controller is None:
        asked = checked(job.law, asked)
    if "wc" in asked and dt > 0 and not asked["wc"] * dt < pi:
        return Outcome(reason=Reason.BEYOND_NYQUIST, gains={})
    weights = {k: asked.pop(k, 1.0) for k in WEIGHTS}
    if job.law == "p" and len(asked) == 1:
        weight = {k: w for k, w in weights.items() if k in OPTIONS["p"]}
        return _free_p(job, plant, dt, delay, {**asked, **weight})
    fixed = in_series(job.sections, dt)
    spec = None
    if job.controller is not None:
        found = SolvedLaw(controller=_at_clock(job.controller, dt), gains={})
    else:
        spec = Crossover(wc=asked["wc"], pm_deg=asked.get("pm_deg", _ANY_MARGIN))
        found = _solved(job.law, plant, dt, delay, fixed, spec, asked)
    controller = found.controller * fixed if fixed else found.controller
    made = verified(
        measure(
            plant, controller, compute_delay=delay, reference=job.reference, law=job.law,
            gains=found.gains, fixed=fixed,
            setpoint_weight=weights["setpoint_weight"],
            derivative_weight=weights["derivative_weight"],
        )
    )  # fmt: skip
    spec = spec if "pm_deg" in asked else None
    off = not_as_asked(made.margins, spec, lambda wc: made.loop.at(wc))
    return Outcome(reason=Reason.OFF_TARGET if off else Reason.OK, gains=found.gains, measured=made)


def _free_p(job: Job, plant: Plant, dt: float, delay: float, asked: Mapping[str, float]) -> Outcome:
    """Return the P of a crossover alone or of a margin alone, as ``zoh.p`` chooses it."""
    try:
        made = design(
            plant, "p", asked, dt=dt, compute_delay=delay, reference=job.reference,
            sections=job.sections,
        )  # fmt: skip
    except NotMet as missed:
        found = missed.measured
        if not found.margins.stable:
            raise
        return Outcome(reason=Reason.OFF_TARGET, gains=found.gains, measured=found)
    return Outcome(reason=Reason.OK, gains=made.gains, measured=made)


def _solved(
    law: str, plant: Plant, dt: float, delay: float, fixed: Sampled | None, spec: Crossover,
    asked: Mapping[str, float],
) -> SolvedLaw:  # fmt: skip
    sampled = sample(plant, dt, delay)

    def iae(controller: Sampled) -> float:
        return load_iae(plant, controller * fixed if fixed else controller, delay)

    return solved(law, fixed * sampled if fixed else sampled, spec, asked, iae)


def _at_clock(given: Sampled, dt: float) -> Sampled:
    """Return the same difference equation, run every dt seconds."""
    return given if given.dt == dt else Sampled(num=given.num, den=given.den, dt=dt)


def _not_met(evidence: Measured) -> Outcome:
    unstable = evidence.margins.stable is False
    return Outcome(reason=Reason.UNSTABLE if unstable else Reason.NOT_PROVED, gains=evidence.gains)


def _figures(made: Measured) -> dict[str, float | None]:
    """Return every figure of a stable loop by its name, None for what does not exist."""
    margins, step = made.margins, made.step or StepInfo()
    between = step.between_samples or StepInfo()
    return {figure.name: _figure(figure.name, margins, step, between) for figure in FIGURES}


def _figure(name: str, margins: Margins, step: StepInfo, between: StepInfo) -> float | None:
    value: float | None
    if name.startswith("between."):
        value = getattr(between, name.removeprefix("between."))
    elif hasattr(margins, name):
        value = getattr(margins, name)
    else:
        value = getattr(step, name)
    return value


def lacks(job: Job) -> str:
    """Return what of this job the single design cannot do: nothing."""
    return ""
