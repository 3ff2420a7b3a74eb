"""A sweep as blocks: each is made from its number alone, wherever and whenever it is asked for."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version

import numpy as np

import zoh
from zoh.batch import backend
from zoh.batch.columns import Columns, Results
from zoh.batch.job import Job
from zoh.batch.sources import FloatArray
from zoh.batch.space import Rows, Space
from zoh.errors import SpecError


@cache
def versions(arithmetic: str) -> str:
    """Return what the bits of an arithmetic's figures depend on, besides the machine."""
    needs = backend.named(arithmetic).needs
    packages = ("numpy", *([needs] if needs else []))
    return ", ".join([f"zoh {zoh.__version__}", *(f"{p} {_version(p)}" for p in packages)])


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Loops start ... stop - 1 of a sweep: what goes in and what comes out."""

    start: int
    stop: int
    columns: Columns
    results: Results


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """One block still to be computed; small, for it is what is sent to a worker.

    offset  the loop that the space begins at, where it is a part of the sweep's
    told_by the versions that whoever does it must have; "" where it is done at home
    """

    job: Job
    space: Space
    arithmetic: str
    number: int
    start: int
    stop: int
    offset: int = 0
    told_by: str = ""

    def done(self) -> Block:
        """Return the block; the same bits on every run of the same arithmetic.

        Raises SpecError where other versions of what the bits depend on are installed here.
        """
        here = versions(self.arithmetic)
        if self.told_by not in ("", here):
            bound = f"must have {self.told_by} on every worker"
            raise SpecError("client", bound, here, "install the same ones")
        columns = self.space.columns(self.start - self.offset, self.stop - self.offset)
        results = computed(self.job, columns, self.arithmetic)
        return Block(start=self.start, stop=self.stop, columns=columns, results=results)


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """A sweep, cut into blocks of ``block`` loops, the last one shorter."""

    job: Job
    space: Space
    arithmetic: str
    block: int

    @property
    def loops(self) -> int:
        """Return how many loops there are."""
        return self.space.size

    def __len__(self) -> int:
        return -(-self.loops // self.block)

    def __iter__(self) -> Iterator[Task]:
        return (self.task(k) for k in range(len(self)))

    def task(self, number: int) -> Task:
        """Return block ``number`` as something to be computed; of rows, with its own alone."""
        start = number * self.block
        stop = min(start + self.block, self.loops)
        space, offset = self.space, 0
        if isinstance(space, Rows):
            space, offset = Rows(values=space.columns(start, stop)), start
        return Task(
            job=self.job, space=space, arithmetic=self.arithmetic, number=number, start=start,
            stop=stop, offset=offset, told_by=versions(self.arithmetic),
        )  # fmt: skip


def computed(job: Job, columns: dict[str, FloatArray], arithmetic: str) -> Results:
    """Return the results of a batch, a chunk of it at a time."""
    way = backend.named(arithmetic)
    n = len(next(iter(columns.values())))
    with np.errstate(all="ignore"):  # what a loop cannot have, its reason says
        parts = [
            way.run(job, {key: column[i : i + way.chunk] for key, column in columns.items()})
            for i in range(0, n, way.chunk)
        ]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
