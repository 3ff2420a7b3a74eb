"""One controller for a whole set of plants: which one is best where it is worst.

Controllers are designed on the plant as it stands, one for each combination of what is given,
and each is measured, as it is, on every plant of the set. The one taken keeps every requirement
on every plant and as it stands, and of those it has the least worst Ms on all of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf

import numpy as np

from zoh import checks
from zoh.analysis.asked import NOTHING_ASKED, missed
from zoh.analysis.verify import Measured, Verified
from zoh.batch import backend, bounds
from zoh.batch.blocks import computed
from zoh.batch.job import GIVEN, Job, refuse_weights
from zoh.batch.reason import Reason
from zoh.batch.result import Extreme, Sweep
from zoh.batch.sources import FloatArray, Source, nominal_plant
from zoh.batch.space import Grid, Space, as_space
from zoh.batch.sweep import Over
from zoh.design.sections import SecondOrder
from zoh.errors import NotMet, SpecError
from zoh.pipeline import design
from zoh.spec import Requirements

_SHOWN = 3  # plants of which a refusal tells what they miss


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Robust:
    """One controller, and what it has on every plant of a set.

    design  the controller on the plant as it stands, verified
    asked   what it was designed for
    sweep   the same controller on each plant of the set, the one as it stands not among them
    tried   how many combinations were designed
    """

    design: Verified
    asked: Mapping[str, float]
    sweep: Sweep
    tried: int

    @property
    def worst_pm(self) -> Extreme:
        """Return the phase margin in deg that is nearest to 0 on the set, and where it is."""
        return self.sweep.worst("phase_margin_deg")

    @property
    def worst_ms(self) -> Extreme:
        """Return the largest Ms on the set, and where it is."""
        return self.sweep.worst("ms")


def robust(
    plant: Source, law: str, given: Mapping[str, float | Sequence[float]], *, over: Over,
    dt: float, compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (),
    requirements: Requirements = NOTHING_ASKED, reference: float = 1.0,
    arithmetic: str | None = None,
) -> Robust:  # fmt: skip
    """Return the controller whose worst Ms over a set of plants, and as it stands, is least.

    given         the law's parameters; one that is a list is tried with each of its values
    over          the set: what varies of the plant, its dead time and the compute delay, as for
                  ``zoh.sweep``; ``zoh.corners`` gives the ends of intervals
    requirements  what the controller must keep on every plant of the set, and as it stands

    Raises SpecError for what is no request; NotMet, with what the best one misses and where,
    where no combination gives a controller that is stable and keeps them everywhere.

    >>> from zoh.batch.space import corners
    >>> from zoh.batch.spread import Uniform
    >>> from zoh.lti.systems import Plant
    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> spread = corners({"plant.gain": Uniform(low=1.8, high=2.8)})
    >>> found = robust(arm, "pd", {"wc": 2.0, "pm_deg": [40, 50, 60]}, dt=0.1, over=spread)
    >>> found.asked["pm_deg"], found.worst_ms.at["plant.gain"]
    (60.0, 2.8)
    """
    space = as_space(over)
    tried = _tried_values(given)
    bounds.asked(requirements)
    _refuse_what_is_chosen(space)
    refuse_weights(given, "one controller over a set")
    job = _candidates(plant, law, tried, dt, compute_delay, sections, reference)
    made = partial(
        design, nominal_plant(plant), law, dt=job.dt, sections=sections,
        compute_delay=job.compute_delay, reference=job.reference,
    )  # fmt: skip
    combinations = _that_can(job, tried)
    found = [
        (asked, evidence, _over(plant, evidence, space, requirements, arithmetic))
        for asked in combinations
        if (evidence := _tried(made, asked)) is not None
    ]
    if not found:
        bound = "must have a combination that can be designed on the plant as it stands"
        raise SpecError("given", bound, dict(given), f"zoh.{law} says why it cannot")
    asked, evidence, over_set = min(found, key=lambda one: _rank(*one[1:]))
    if misses := _misses(over_set):
        raise NotMet(misses, evidence)
    verified = made(asked, requirements=requirements)
    return Robust(design=verified, asked=asked, sweep=over_set, tried=len(combinations))


def _tried_values(given: object) -> dict[str, FloatArray]:
    """Return the values of each parameter that are tried; raise SpecError for what is none."""
    if not isinstance(given, Mapping):
        raise SpecError("given", "must name the law's parameters", given, '{"wc": [1, 2]}')
    return {checks.text("given", key): checks.column(key, value) for key, value in given.items()}


def _refuse_what_is_chosen(space: Space) -> None:
    """One controller is run on every plant: what varies is the machine, not the request."""
    for key in space.keys:
        if not key.startswith("plant.") and key not in ("dead_time", "compute_delay"):
            way_out = "a list in given tries values; what varies over the set is the machine's"
            raise SpecError("over", "must vary the plant or its delays", key, way_out)


def _candidates(
    plant: Source, law: str, given: Mapping[str, FloatArray], dt: float,
    compute_delay: float, sections: Sequence[SecondOrder], reference: float,
) -> Job:  # fmt: skip
    """Return the design on the plant as it stands, with all that is given to vary."""
    return Job(
        plant=plant, law=law, dt=dt, compute_delay=compute_delay, reference=reference,
        sections=sections, varying=tuple(given),
    )  # fmt: skip


def _that_can(job: Job, given: Mapping[str, FloatArray]) -> list[dict[str, float]]:
    """Return every combination of what is given that the law can be designed for."""
    grid = Grid(axes=given)
    columns = grid.columns(0, grid.size)
    way = backend.choose(job, grid.size).way
    good = np.flatnonzero(computed(job, columns, way.name)["reason"] == Reason.OK)
    return [{key: float(column[i]) for key, column in columns.items()} for i in good]


def _tried(made: Callable[..., Verified], asked: Mapping[str, float]) -> Verified | None:
    """Return the design, None where it misses what was asked of it."""
    try:
        return made(asked)
    except NotMet:
        return None


def _over(
    plant: Source, evidence: Measured, space: Space, requirements: Requirements,
    arithmetic: str | None,
) -> Sweep:  # fmt: skip
    """Return one controller measured on every plant of the set."""
    job = Job(
        plant=plant, law=GIVEN, controller=evidence.controller, dt=evidence.dt,
        compute_delay=evidence.compute_delay, reference=evidence.reference, varying=space.keys,
    )  # fmt: skip
    choice = backend.choose(job, space.size, arithmetic)
    columns: dict[str, FloatArray] = space.columns(0, space.size)
    return Sweep(
        job=job, space=space, columns=columns, requirements=requirements,
        results=computed(job, columns, choice.way.name), computed_by=choice.why,
    )  # fmt: skip


def _rank(standing: Measured, found: Sweep) -> tuple[int, float]:
    """Return what is least for the best controller: plants that miss something, then worst Ms."""
    kept = bounds.met(found.requirements, found.results)
    here = missed(found.requirements, standing.margins, standing.step)
    worst = [found.worst("ms").value, standing.margins.ms]
    most = max(inf if ms is None else ms for ms in worst)
    return int(np.count_nonzero(~kept)) + bool(here), most


def _misses(found: Sweep) -> tuple[str, ...]:
    """Return what is missed and where, a sentence for each of the first few plants."""
    missing = np.flatnonzero(~bounds.met(found.requirements, found.results))
    said = [_miss(found, int(i)) for i in missing[:_SHOWN]]
    more = len(missing) - len(said)
    return (*said, *([f"and {more} more of {len(found)} plants"] if more else []))


def _miss(found: Sweep, i: int) -> str:
    at = ", ".join(f"{key} = {column[i]:.6g}" for key, column in found.columns.items())
    reason, row = Reason(int(found.results["reason"][i])), found.take([i]).results
    if reason is not Reason.OK:
        return f"at {at} {reason.words}"
    wanted = bounds.asked(found.requirements)
    broken = [name for name, bound in wanted.items() if not bounds.keeps(name, bound, row)[0]]
    return f"at {at} " + "; ".join(bounds.sentence(name, wanted[name], row) for name in broken)
