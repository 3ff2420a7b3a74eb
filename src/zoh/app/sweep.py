"""``zoh sweep``: the controllers of a project over a grid or a sample, and what came of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from typing import Any

import zoh
from zoh.app.project import GIVEN, Given, Project, Request
from zoh.app.toml import within
from zoh.batch import backend
from zoh.batch.figures import FIGURES
from zoh.batch.job import Job, refuse_weights
from zoh.batch.reason import Reason
from zoh.batch.result import Sweep
from zoh.batch.saved import refuse_netcdf, refuse_zarr
from zoh.batch.sources import nominal_plant
from zoh.batch.space import Random, Space
from zoh.batch.stream import sweep_to
from zoh.batch.summary import Summary
from zoh.batch.sweep import sweep_of, sweep_summary
from zoh.batch.workers import Progress
from zoh.errors import SpecError
from zoh.pipeline import design
from zoh.report.text import number

NETCDF, ZARR = ".nc", ".zarr"


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """How a sweep is computed and where it goes.

    out         the name of a file that ends in .nc or .zarr, None for a summary alone
    arithmetic  the name of one, None where the number of loops chooses
    client      a Dask client, None where the work is done here
    fixed       whether each controller is designed once, on the plant as it stands
    held        whether every loop is held in memory, for figures
    """

    out: str | None = None
    arithmetic: str | None = None
    client: Any = None
    fixed: bool = False
    held: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Swept:
    """One controller of the project, swept; ``held`` are its loops, where they are in memory."""

    name: str
    law: str
    space: Space
    summary: Summary
    computed_by: str
    held: Sweep | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form: the summary, each extreme with what varies in its loop."""
        found = self.summary.to_dict()
        for ends in found["extremes"].values():
            for end in ("least", "most") if ends is not None else ():
                ends[f"{end}_over"] = at(self.space, ends[f"{end}_at"])
        if not isinstance(self.space, Random):
            del found["yield_interval_95"]
        return {"name": self.name, "law": self.law, "computed_by": self.computed_by, **found}


def sweep_all(
    project: Project, space: Space, names: Sequence[str], options: Options,
    watched: Callable[[str], Progress | None],
) -> tuple[Swept, ...]:  # fmt: skip
    """Return the controllers of these names, all where none is named, each swept over the space.

    ``watched`` returns what is told of a controller's progress.
    """
    chosen = _chosen(project, names)
    if options.out is not None and len(chosen) > 1:
        listed = ", ".join(c.name for c in chosen)
        raise SpecError("--out", "must be of one controller", listed, "add --controller NAME")
    if options.out is not None and not options.out.endswith((NETCDF, ZARR)):
        raise SpecError("--out", "must end in .nc or .zarr", options.out, "name it so")
    found = []
    for controller in chosen:
        with within(f'controller "{controller.name}": '):
            found.append(_swept(project, controller, space, options, watched(controller.name)))
    return tuple(found)


def _chosen(project: Project, names: Sequence[str]) -> list[Request | Given]:
    known = {controller.name: controller for controller in project.controllers}
    for name in names:
        if name not in known:
            way_out = f"one of {', '.join(known)}"
            raise SpecError("--controller", "must be in the file", name, way_out)
    return [controller for name, controller in known.items() if not names or name in names]


def _swept(
    project: Project, controller: Request | Given, space: Space, options: Options,
    progress: Progress | None,
) -> Swept:  # fmt: skip
    job = job_of(project, controller, space, fixed=options.fixed)
    choice = backend.choose(job, space.size, options.arithmetic)
    more: dict[str, Any] = {
        "requirements": project.requirements, "arithmetic": options.arithmetic,
        "client": options.client, "progress": progress,
    }  # fmt: skip
    held = None
    if options.held or (options.out or "").endswith(NETCDF):
        if options.out is not None:  # not after the work
            (refuse_zarr if options.out.endswith(ZARR) else refuse_netcdf)(options.out)
        held = sweep_of(job, space, **more)
        if options.out is not None:
            (held.to_zarr if options.out.endswith(ZARR) else held.to_netcdf)(options.out)
        summary = held.summary
    elif options.out is not None:
        summary = sweep_to(options.out, job, space, **more)
    else:
        summary = sweep_summary(job, space, **more)
    return Swept(
        name=controller.name, law=job.law, space=space, summary=summary, computed_by=choice.why,
        held=held,
    )  # fmt: skip


def job_of(
    project: Project, controller: Request | Given, space: Space, *, fixed: bool = False
) -> Job:
    """Return the loop of one controller, with what varies of it; raise SpecError for a table."""
    if project.source is None:
        way_out = "a table does not vary; give the plant as a model"
        raise SpecError("plant", "must be a model", "frequency_response", way_out)
    loop: dict[str, Any] = {
        "plant": project.source, "dt": project.dt, "compute_delay": project.compute_delay,
        "reference": project.reference, "varying": space.keys,
    }  # fmt: skip
    if isinstance(controller, Given):
        return Job(law=GIVEN, controller=controller.controller, **loop)
    asked, sections = controller.parameters, controller.sections
    if controller.allow:
        way_out = "a sweep has no such permission; leave it out, or give the controller itself"
        raise SpecError("allow", "must be empty in a sweep", list(controller.allow), way_out)
    if not fixed:
        return Job(law=controller.law, asked=asked, sections=sections, **loop)
    refuse_weights(asked, "--fixed")
    made = design(
        nominal_plant(project.source), controller.law, asked, dt=project.dt, sections=sections,
        compute_delay=project.compute_delay, reference=project.reference,
    )  # fmt: skip
    return Job(law=GIVEN, controller=made.controller, **loop)


def at(space: Space, loop: int) -> dict[str, float]:
    """Return what varies in one loop."""
    return {key: float(column[0]) for key, column in space.columns(loop, loop + 1).items()}


def to_dict(found: Sequence[Swept]) -> dict[str, Any]:
    """Return the JSON object: each controller's summary, and the counts of all together."""
    whole = Summary.nothing()
    for one in found:
        whole = whole.merged(one.summary)
    together = whole.to_dict()
    ends = {name: _values(e) for name, e in together["extremes"].items()}
    counts = {key: together[key] for key in ("loops", "reasons", "met", "yield")}
    return {
        "zoh": zoh.__version__,
        **counts,
        "extremes": ends,
        "sweeps": [s.to_dict() for s in found],
    }


def _values(ends: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Return the extremes without the loops, which are each controller's own."""
    return None if ends is None else {"least": ends["least"], "most": ends["most"]}


def as_text(found: Swept) -> str:
    """Return what came of one controller, for people."""
    s = found.summary
    share = f"{100 * s.share:.4g} % of {s.loops} loops are as asked and keep every requirement"
    if isinstance(found.space, Random):
        low, high = s.interval
        share += f" (95 %: {100 * low:.4g} to {100 * high:.4g} %)"
    lines = [f"{found.name}: {share}", f"  {found.computed_by}"]
    for reason, count in zip(Reason, s.reasons, strict=True):
        if count and reason is not Reason.OK:
            lines.append(f"  {count} loop{'s' if count > 1 else ''}: {reason.words}")
    for figure, ends in zip(FIGURES, s.extremes, strict=True):
        if not figure.better or isnan(ends.least):
            continue
        worst, loop = (
            (ends.least, ends.least_at) if figure.better > 0 else (ends.most, ends.most_at)
        )
        unit = f" {figure.unit}" if figure.unit not in ("1", "input") else ""
        where = ", ".join(f"{key} = {number(v, 6)}" for key, v in at(found.space, loop).items())
        lines.append(f"  worst {figure.long_name}: {number(worst, 6)}{unit} at {where}")
    return "\n".join(lines)
