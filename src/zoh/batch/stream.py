"""Long sweeps on disk: blocks of a Zarr store, written once each, taken up again after any end.

A block's columns are written first and its row last; each write is a file put in its place whole,
and the row has the seal of every one (``zoh.batch.store``). So a block either has its row, and all
of it is there as it was written, or it is made again, to the same bits. The row is the block's
``Summary``: what a sweep comes to is read, not computed again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from zoh.batch import bounds, store, workers
from zoh.batch.blocks import Task
from zoh.batch.extras import needed
from zoh.batch.figures import column_names
from zoh.batch.job import Job
from zoh.batch.labelled import LOOP, attributes, described
from zoh.batch.marks import mark
from zoh.batch.summary import Summary
from zoh.batch.sweep import Over, plan_of
from zoh.batch.workers import Progress, watched
from zoh.errors import SpecError
from zoh.spec import Requirements

if TYPE_CHECKING:
    from xarray import Dataset


def sweep_to(
    path: str, job: Job, over: Over, *, requirements: Requirements = bounds.NOTHING_ASKED,
    keep: Sequence[str] | None = None, arithmetic: str | None = None, block: int | None = None,
    client: Any = None, progress: Progress | None = None,
) -> Summary:  # fmt: skip
    """Write a sweep of any length to a Zarr store, or go on with one; return its summary.

    path    a new folder, or one that the same sweep has begun: what is there, as it was written,
            is not made again, what is missing or damaged is
    keep    the columns to write, of ``zoh.batch.figures`` and of what varies; None writes all
    block   how many loops, all at most, are one block and one chunk of the store; they are held
            in memory
    client  a ``dask.distributed.Client``: its workers write, so they must see the path, too

    Raises SpecError where the path holds anything else, another sweep among them, or cannot be
    written.
    """
    needed("zarr", "a sweep on disk")
    workers.checked(client)
    plan = plan_of(job, over, arithmetic, block)
    bounds.asked(requirements)
    kept, whole = _kept(job, keep), store.absolute(path)
    columns = {name: _column(job, name) for name in kept}
    files = store.laid_out(described(job), mark(plan, kept, requirements), columns)
    store.begin(whole, files)
    found, missing, already, of = Summary.nothing(), [], 0, store.sealed(whole)
    for number in range(len(plan)):
        row = store.summary_of(whole, number, kept, of)
        if row is None:
            missing.append(number)
        else:
            part = Summary.unpacked(row)
            found, already = found.merged(part), already + part.loops
    write = _Write(path=whole, keep=kept, requirements=requirements)
    tasks = (plan.task(number) for number in missing)
    for part in watched(write, tasks, client, progress, already, plan.loops):
        found = found.merged(part)
    return found


def open_sweep(path: str) -> "Dataset":
    """Return the columns of a store as a Dataset that reads what is looked at.

    Raises SpecError where the path holds no store, or one of which something is missing; what is
    damaged raises it when it is read.
    """
    xarray = needed("xarray", "a labelled result")
    needed("zarr", "a sweep on disk")
    from zoh.batch.sealed import Sealed

    whole = store.absolute(path)
    seals = store.seals_of(whole)
    opened = xarray.open_zarr(Sealed(whole, seals=seals), consolidated=False)
    others = set(opened.variables) - {place.partition("/")[0] for place in seals}
    found: Dataset = opened.drop_vars({store.BLOCKS, *others}, errors="ignore")
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class _Write:
    """Makes blocks and writes them; sent to workers as the path and the names it keeps."""

    path: str
    keep: tuple[str, ...]
    requirements: Requirements

    def __call__(self, task: Task) -> Summary:
        """Return the summary of a block that is on disk."""
        block = task.done()
        columns = {**block.columns, **block.results}
        store.clear(self.path, task.number, self.keep)
        group = needed("zarr", "a sweep on disk").open_group(self.path, mode="r+")
        for name in self.keep:
            group[name][block.start : block.stop] = columns[name]
        summary = Summary.of(block.results, self.requirements, block.start)
        store.close(self.path, task.number, self.keep, summary.packed())
        return summary


def _kept(job: Job, keep: Sequence[str] | None) -> tuple[str, ...]:
    known = (*job.varying, *column_names(job.law))
    for name in keep or ():
        if name not in known:
            raise SpecError("keep", "must name columns of this sweep", name, ", ".join(known))
    return known if keep is None else tuple(name for name in known if name in keep)


def _column(job: Job, name: str) -> Mapping[str, Any]:
    """Return what Zarr is to know of a column."""
    dtype, fill = {"stable": ("bool", False), "reason": ("int8", -1)}.get(name, ("float64", np.nan))
    return {
        "dtype": dtype, "fill_value": fill, "dimension_names": (LOOP,),
        "attributes": attributes(name, job.plant),
    }  # fmt: skip
