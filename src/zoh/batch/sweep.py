"""Many loops at once: a law designed and verified over a space, in memory or as a summary."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from zoh import checks
from zoh.batch import backend, bounds
from zoh.batch.blocks import Plan, Task
from zoh.batch.job import Job
from zoh.batch.result import Sweep
from zoh.batch.sources import FloatArray, Source
from zoh.batch.space import Space, as_space
from zoh.batch.summary import Summary
from zoh.batch.workers import Progress, checked, watched
from zoh.design.sections import SecondOrder
from zoh.errors import SpecError
from zoh.lti.systems import Sampled
from zoh.spec import Requirements

Over = Space | Mapping[str, Sequence[float] | FloatArray]

MOST_IN_MEMORY = 20_000_000  # loops, some 5 GB of figures


def sweep(
    plant: Source, law: str, given: Mapping[str, float] | None = None, *, over: Over,
    dt: float | None = None, compute_delay: float = 0.0, controller: Sampled | None = None,
    reference: float = 1.0, sections: Sequence[SecondOrder] = (),
    requirements: Requirements = bounds.NOTHING_ASKED, arithmetic: str | None = None,
    client: Any = None, progress: Progress | None = None,
) -> Sweep:  # fmt: skip
    """Return every loop of a space, each designed, measured and verified as ``zoh.design`` does.

    plant         a ``zoh.Plant``, or ``zoh.Roots`` or ``zoh.Geared`` where a root or a motor's
                  constant varies
    law, given    as for ``zoh.design``; or "given" with ``controller``, which stays as it is
    over          a mapping of lists is the grid of them; or ``zoh.Random``, ``zoh.Rows``,
                  ``zoh.corners``. Keys are those of ``zoh.Job``
    dt            s; may be left out where it varies, or where a controller is given
    requirements  what ``yield_`` holds every loop against
    arithmetic    the name of one; None chooses by the number of loops and by what is installed
    client        a ``dask.distributed.Client``, whose workers then do the work
    progress      called with the loops done and the loops there are

    A loop that cannot be designed carries a ``zoh.Reason`` and stops nothing. Raises SpecError for
    what is no sweep.

    >>> from zoh.lti.systems import Plant
    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> found = sweep(arm, "pi", {"pm_deg": 40}, dt=0.1, over={"wc": [0.4, 0.8, 3.0]})
    >>> found["phase_margin_deg"].round(9).tolist(), found["reason"].tolist()
    ([40.0, 40.0, nan], [0, 0, 1])
    >>> round(found.yield_(), 3)
    0.667
    """
    space = as_space(over)
    if dt is None and "dt" not in space.keys and isinstance(controller, Sampled):
        dt = controller.dt
    if given is not None and not isinstance(given, Mapping):
        raise SpecError("given", "must name the law's parameters", given, '{"pm_deg": 50}')
    job = Job(
        plant=plant, law=law, asked=given or {}, controller=controller, dt=dt,
        compute_delay=compute_delay, reference=reference, sections=sections,
        varying=space.keys,
    )  # fmt: skip
    return sweep_of(
        job, space, requirements=requirements, arithmetic=arithmetic, client=client,
        progress=progress,
    )  # fmt: skip


def sweep_of(
    job: Job, over: Over, *, requirements: Requirements = bounds.NOTHING_ASKED,
    arithmetic: str | None = None, client: Any = None, progress: Progress | None = None,
) -> Sweep:  # fmt: skip
    """Return every loop of a space, of a job that is already put together; as ``sweep`` does."""
    checked(client)
    plan = plan_of(job, over, arithmetic, None)
    if plan.loops > MOST_IN_MEMORY:
        way_out = "zoh.sweep_to writes a longer one to disk, zoh.sweep_summary keeps no loop"
        raise SpecError("over", f"must have {MOST_IN_MEMORY} loops or fewer", plan.loops, way_out)
    bounds.asked(requirements)
    found = watched(Task.done, plan, client, progress, 0, plan.loops)
    done = sorted(found, key=lambda block: block.start)
    return Sweep(
        job=job, space=plan.space, columns=_joined([b.columns for b in done]),
        results=_joined([b.results for b in done]), requirements=requirements,
        computed_by=backend.choose(job, plan.loops, arithmetic).why,
    )  # fmt: skip


def sweep_summary(
    job: Job, over: Over, *, requirements: Requirements = bounds.NOTHING_ASKED,
    arithmetic: str | None = None, block: int | None = None, client: Any = None,
    progress: Progress | None = None,
) -> Summary:  # fmt: skip
    """Return counts, extremes and yield of a sweep of any length; no loop is kept.

    With a client only a block's number goes out and only its summary comes back. The answer is
    the same to the last bit on any number of workers, and where one of them is lost.
    """
    checked(client)
    plan = plan_of(job, over, arithmetic, block)
    bounds.asked(requirements)
    found = Summary.nothing()
    summarised = Summarised(requirements=requirements)
    for part in watched(summarised, plan, client, progress, 0, plan.loops):
        found = found.merged(part)
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class Summarised:
    """Makes the summary of a block, where the block is made."""

    requirements: Requirements

    def __call__(self, task: Task) -> Summary:
        """Return the summary of a block."""
        return Summary.of(task.done().results, self.requirements, task.start)


def plan_of(job: Job, over: Over, arithmetic: str | None, block: int | None) -> Plan:
    """Return the sweep cut into blocks; raise SpecError where its keys are not the job's."""
    space = as_space(over)
    if space.keys != job.varying:
        raise SpecError("over", f"must have the keys {list(job.varying)}", space.keys, "in order")
    way = backend.choose(job, space.size, arithmetic).way
    size = way.block if block is None else checks.whole("block", block, 1, "65536 is usual")
    # a longer block would be the same loops, in room for all that it could hold
    return Plan(job=job, space=space, arithmetic=way.name, block=min(size, space.size))


def _joined(parts: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
