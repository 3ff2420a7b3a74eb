"""A sweep that fits in memory: its columns, and the questions that are asked of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from zoh.batch import bounds
from zoh.batch.columns import Columns, Results
from zoh.batch.figures import BY_NAME, FIGURES
from zoh.batch.job import Job
from zoh.batch.space import Rows, Space
from zoh.batch.summary import Summary
from zoh.errors import SpecError
from zoh.spec import Requirements

if TYPE_CHECKING:
    from xarray import Dataset


@dataclass(frozen=True, slots=True, kw_only=True)
class Extreme:
    """The worst value of a figure, the loop that has it, and what varies in that loop.

    without  how many loops do not have this figure: they have no design, are unstable, or it does
             not exist in them; value and loop are None where none has it
    """

    name: str
    value: float | None
    loop: int | None
    at: Mapping[str, float]
    without: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sweep:
    """Every loop of a sweep, computed.

    job, space    what was asked
    columns       what goes in: one float64 column for each key that varies, shape (loops,)
    results       what came out: the columns of ``zoh.batch.figures``, "stable" and "reason"
    requirements  what every loop is held against by ``yield_``
    computed_by   which arithmetic, and why, in one sentence
    """

    job: Job
    space: Space
    columns: Columns
    results: Results
    requirements: Requirements
    computed_by: str

    def __len__(self) -> int:
        return len(self.results["reason"])

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """Return a column, of what varies or of what came out."""
        found = {**self.results, **self.columns}
        if name not in found:
            raise SpecError("name", "must be a column of this sweep", name, ", ".join(found))
        return found[name]

    @property
    def summary(self) -> Summary:
        """Return counts by reason, the extremes of every figure and the yield."""
        return Summary.of(self.results, self.requirements)

    def yield_(self, requirements: Requirements | None = None) -> float:
        """Return the share of all loops that are as asked for and keep every requirement.

        Those of the sweep where none are given here. A loop without a design keeps none.
        """
        asked = self.requirements if requirements is None else requirements
        return float(np.mean(bounds.met(asked, self.results)))

    def worst(self, name: str) -> Extreme:
        """Return the worst value of a figure; raise SpecError for one that has no better end."""
        figure = BY_NAME.get(name)
        if figure is None or not figure.better:
            known = ", ".join(f.name for f in FIGURES if f.better)
            raise SpecError("name", "must be a figure with a better end", name, f"one of {known}")
        worse = figure.better * self._figure(name)
        missing = int(np.isnan(worse).sum())
        if missing == len(self):
            return Extreme(name=name, value=None, loop=None, at={}, without=missing)
        i = int(np.nanargmin(worse))
        at = {key: float(column[i]) for key, column in self.columns.items()}
        value = float(self._figure(name)[i])
        return Extreme(name=name, value=value, loop=i, at=at, without=missing)

    def _figure(self, name: str) -> npt.NDArray[np.float64]:
        return self.results[name].astype(np.float64, copy=False)

    def pareto(self, *names: str) -> "Sweep":
        """Return the loops of which none is better in one of these figures and no worse in another.

        Among those that keep every requirement; of equal ones the first. Sorted by the first name.
        Raises SpecError where no loop has these figures and keeps the requirements.
        """
        if not names or not all(name in BY_NAME and BY_NAME[name].better for name in names):
            known = ", ".join(f.name for f in FIGURES if f.better)
            raise SpecError("names", "must be figures with a better end", names, f"some of {known}")
        good = np.flatnonzero(bounds.met(self.requirements, self.results))
        costs = np.column_stack([-BY_NAME[n].better * self._figure(n)[good] for n in names])
        known_all = ~np.isnan(costs).any(axis=1)
        if not known_all.any():
            bound = "must be figures of a loop that keeps every requirement"
            raise SpecError("names", bound, names, "see the reasons of the loops")
        return self.take(good[known_all][_undominated(costs[known_all])])

    def take(self, loops: npt.ArrayLike) -> "Sweep":
        """Return some of the loops, by their numbers, in this order, or by a mask of all.

        Raises SpecError for no loop, or one that is not there.
        """
        i = np.asarray(loops)
        if i.dtype == bool and i.shape == (len(self),):
            (i,) = np.nonzero(i)
            if not len(i):
                bound = f"must select one of the {len(self)} loops or more"
                way_out = "this mask selects nothing: loosen its condition"
                raise SpecError("loops", bound, loops, way_out)
        whole = i.ndim == 1 and len(i) and np.issubdtype(i.dtype, np.integer)
        if not (whole and -len(self) <= i.min() and i.max() < len(self)):
            bound = f"must be numbers of some of the {len(self)} loops, or a mask of all"
            raise SpecError("loops", bound, loops, "numbers begin at 0")
        columns = {key: column[i] for key, column in self.columns.items()}
        return Sweep(
            job=self.job, space=Rows(values=columns), columns=columns,
            results={name: column[i] for name, column in self.results.items()},
            requirements=self.requirements, computed_by=self.computed_by,
        )  # fmt: skip

    @property
    def dataset(self) -> "Dataset":
        """Return all of it as an ``xarray.Dataset`` with units; a grid has an axis for each key."""
        from zoh.batch.labelled import dataset

        return dataset(self)

    def to_netcdf(self, path: str) -> None:
        """Write the dataset to a new netCDF 4 file."""
        from zoh.batch.saved import write_netcdf

        write_netcdf(self.dataset, path)

    def to_zarr(self, path: str) -> None:
        """Write the dataset to a new Zarr store."""
        from zoh.batch.saved import write_zarr

        write_zarr(self.dataset, path)


def _undominated(costs: npt.NDArray[np.float64]) -> npt.NDArray[np.intp]:
    """Return the rows that no other row is below in one column and not above in any.

    In lexicographic order the first row that is left is never dominated by one after it.

    >>> _undominated(np.array([[2.0, 1.0], [1.0, 2.0], [2.0, 2.0], [1.0, 2.0]])).tolist()
    [1, 0]
    """
    alive = np.lexsort(costs.T[::-1])
    front: list[int] = []
    while alive.size:
        front.append(int(alive[0]))
        alive = alive[(costs[alive] < costs[alive[0]]).any(axis=1)]
    return np.array(front, np.intp)
