"""Long sweeps on disk: blocks of a Zarr store, written once each, taken up again after any end.

A block's columns are written first and its row in "blocks" last; each write is a file put in its
place whole. So a block either has its row, and all of it is there, or it is made again, to the
same bits. The row is the block's ``Summary``: what a sweep comes to is read, not computed again.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from zoh.batch import bounds
from zoh.batch.blocks import Plan, Task, versions
from zoh.batch.extras import needed
from zoh.batch.figures import column_names
from zoh.batch.job import Job
from zoh.batch.labelled import LOOP, attributes, described
from zoh.batch.space import Grid, Random, Space
from zoh.batch.summary import WIDTH, Summary
from zoh.batch.sweep import Over, plan_of
from zoh.batch.workers import Progress, watched
from zoh.errors import SpecError
from zoh.lti.systems import Plant
from zoh.spec import Requirements

if TYPE_CHECKING:
    from xarray import Dataset

_BLOCKS = "blocks"  # one row for each block that is there
_MARK = "zoh"  # the attribute that says of which sweep a store is


def sweep_to(
    path: str, job: Job, over: Over, *, requirements: Requirements = bounds.NOTHING_ASKED,
    keep: Sequence[str] | None = None, arithmetic: str | None = None, block: int | None = None,
    client: Any = None, progress: Progress | None = None,
) -> Summary:  # fmt: skip
    """Write a sweep of any length to a Zarr store, or go on with one; return its summary.

    path    a new folder, or one that the same sweep has begun: what is there is not made again
    keep    the columns to write, of ``zoh.batch.figures`` and of what varies; None writes all
    block   how many loops are one block and one chunk of the store; they are held in memory
    client  a ``dask.distributed.Client``: its workers write, so they must see the path, too

    Raises SpecError where the path holds anything else, another sweep among them.
    """
    needed("zarr", "a sweep on disk")
    plan = plan_of(job, over, arithmetic, block)
    bounds.asked(requirements)
    store = _Store(
        path=str(Path(path).absolute()), keep=_kept(job, keep), requirements=requirements
    )
    rows = _begun(store, plan)
    there = np.isfinite(rows[:, 0])
    missing = (plan.task(k) for k in np.flatnonzero(~there).tolist())
    already = sum(_length(plan, k) for k in np.flatnonzero(there).tolist())
    found = Summary.nothing()
    for row in rows[there]:
        found = found.merged(Summary.unpacked(row))
    for summary in watched(store, missing, client, progress, already, plan.loops):
        found = found.merged(summary)
    return found


def open_sweep(path: str) -> "Dataset":
    """Return the columns of a store as a Dataset that reads what is looked at."""
    xarray = needed("xarray", "a labelled result")
    opened = xarray.open_zarr(path, consolidated=False)
    found: Dataset = opened.drop_vars(_BLOCKS, errors="ignore")
    return found


def write_netcdf(found: "Dataset", path: str) -> None:
    """Write a dataset to a new netCDF 4 file, whole or not at all."""
    refuse_netcdf(path)
    part = f"{path}.{os.getpid()}.part"
    found.to_netcdf(part, engine="h5netcdf")
    os.replace(part, path)


def refuse_netcdf(path: str) -> None:
    """Raise SpecError where no new netCDF file can be written: to be asked before the work."""
    needed("h5netcdf", "a netCDF file")
    _refuse_what_is_there(path)
    folder = Path(path).absolute().parent
    if not folder.is_dir():
        raise SpecError("path", "must be in a folder that is there", path, f"make {folder}")


def write_zarr(found: "Dataset", path: str) -> None:
    """Write a dataset to a new Zarr store."""
    needed("zarr", "a Zarr store")
    _refuse_what_is_there(path)
    found.to_zarr(path, mode="w-", consolidated=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Store:
    """Makes blocks and writes them; sent to workers as its path and the names it keeps."""

    path: str
    keep: tuple[str, ...]
    requirements: Requirements

    def __call__(self, task: Task) -> Summary:
        """Return the summary of a block that is on disk."""
        group = needed("zarr", "a sweep on disk").open_group(self.path, mode="r+")
        block = task.done()
        columns = {**block.columns, **block.results}
        for name in self.keep:
            group[name][block.start : block.stop] = columns[name]
        summary = Summary.of(block.results, self.requirements, block.start)
        group[_BLOCKS][task.number] = summary.packed()
        return summary


def _kept(job: Job, keep: Sequence[str] | None) -> tuple[str, ...]:
    known = (*job.varying, *column_names(job.law))
    for name in keep or ():
        if name not in known:
            raise SpecError("keep", "must name columns of this sweep", name, ", ".join(known))
    return known if keep is None else tuple(name for name in known if name in keep)


def _begun(store: _Store, plan: Plan) -> Any:
    """Return the rows of the blocks that are there; make what is missing of an empty store."""
    zarr, folder = needed("zarr", "a sweep on disk"), Path(store.path)
    mark = _mark(store, plan)
    if _is_fresh(folder):
        about = {**described(plan.job), _MARK: mark}
        group = zarr.create_group(store.path, attributes=about)  # one write: with its mark or not
    else:
        group = _opened(zarr, store.path)
        if group.attrs.get(_MARK) != mark:
            bound = "must be new, or hold the same sweep"
            raise SpecError("path", bound, store.path, "name another folder")
    dtypes = {"stable": ("bool", False), "reason": ("int8", -1)}
    for name in store.keep:
        dtype, fill = dtypes.get(name, ("float64", np.nan))
        _array(group, name, (plan.loops,), (plan.block,), dtype, fill, (LOOP,))
    _array(group, _BLOCKS, (len(plan), WIDTH), (1, WIDTH), "float64", np.nan, ("block", "entry"))
    for part in _scraps(folder):
        part.unlink(missing_ok=True)
    return group[_BLOCKS][:]


def _is_fresh(folder: Path) -> bool:
    """Return whether nothing is there, or only a first write that did not come to its end."""
    return not folder.exists() or all(part in _scraps(folder) for part in folder.iterdir())


def _opened(zarr: Any, path: str) -> Any:
    try:
        return zarr.open_group(path, mode="r+")
    except (OSError, ValueError, KeyError) as strange:
        bound = "must be new, or hold the same sweep"
        raise SpecError("path", bound, path, "name another folder") from strange


def _array(
    group: Any, name: str, shape: tuple[int, ...], chunks: tuple[int, ...], dtype: str,
    fill: Any, dims: tuple[str, ...],
) -> None:  # fmt: skip
    if name in group:
        return
    about = {} if name == _BLOCKS else attributes(name)
    group.create_array(
        name=name, shape=shape, chunks=chunks, dtype=dtype, fill_value=fill,
        dimension_names=dims, attributes=about,
    )  # fmt: skip


def _scraps(folder: Path) -> list[Path]:
    """Return what a write left that did not come to its end; nothing reads it."""
    return list(folder.glob("**/*.partial"))


def _length(plan: Plan, number: int) -> int:
    task = plan.task(number)
    return task.stop - task.start


def _mark(store: _Store, plan: Plan) -> dict[str, Any]:
    """Return what two sweeps must share to be one: all that its bits depend on but the machine."""
    source = plan.job.plant
    digits = repr(source.exact) if isinstance(source, Plant) else ""
    parts = (repr(plan.job), digits, _digest(plan.space), repr(store.requirements))
    return {
        "versions": versions(plan.arithmetic), "arithmetic": plan.arithmetic,
        "loops": plan.loops, "block": plan.block, "keep": list(store.keep),
        "digest": sha256("\n".join(parts).encode()).hexdigest(),
    }  # fmt: skip


def _digest(space: Space) -> str:
    """Return what identifies the loops of a space."""
    if isinstance(space, Random):
        return repr(space)
    found = sha256(type(space).__name__.encode())
    for key, column in (space.axes if isinstance(space, Grid) else space.values).items():
        found.update(key.encode())
        found.update(np.ascontiguousarray(column).tobytes())
    return found.hexdigest()


def _refuse_what_is_there(path: str) -> None:
    if os.path.lexists(path):
        raise SpecError("path", "must not be there already", path, "name another one")
