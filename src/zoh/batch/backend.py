"""Which arithmetic computes a batch: one table of ways, and one rule that chooses from it.

A way is a module with ``run(job, columns)`` and ``lacks(job)``. All of them give the same
columns; they differ in what they cover, in what must be installed, and in how many loops pay for
their start. The single design covers every job, so there always is one.
"""

from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import cast

from zoh.batch.columns import Columns, Results
from zoh.batch.job import Job
from zoh.errors import SpecError

CORES: ContextVar[int] = ContextVar("CORES", default=0)
"""How many cores an arithmetic may take; 0 is all. A worker beside others has one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """One arithmetic.

    name    as users choose it;  module  where its ``run`` and ``covers`` are
    needs   the package that it cannot do without, None where NumPy is enough
    least   the number of loops from which on it is faster than the way after it
    chunk   how many loops it is given at once;  block  how many make one block of a long sweep
    starts  what to say of its first use, empty where there is nothing to wait for
    """

    name: str
    module: str
    needs: str | None = None
    least: int = 1
    chunk: int = 1
    block: int = 1
    starts: str = ""

    @property
    def installed(self) -> bool:
        """Return whether what it needs is there."""
        return self.needs is None or find_spec(self.needs) is not None

    def lacks(self, job: Job) -> str:
        """Return what of this job it cannot compute, "" where it can compute all of it."""
        return cast(Callable[[Job], str], import_module(self.module).lacks)(job)

    def run(self, job: Job, columns: Columns) -> Results:
        """Return the columns of results of a batch."""
        return cast("Callable[[Job, Columns], Results]", import_module(self.module).run)(
            job, columns
        )


SINGLE = Way(name="single", module="zoh.batch.single", chunk=64, block=256)
ARRAYS = Way(name="arrays", module="zoh.batch.arrays.run", least=16, chunk=4096, block=65536)
COMPILED = Way(
    name="compiled", module="zoh.batch.compiled.run", needs="numba", least=20_000, chunk=65536,
    block=262144,
    starts="the first use compiles for some two minutes, later ones start at once",
)  # fmt: skip
WAYS: tuple[Way, ...] = (COMPILED, ARRAYS, SINGLE)
"""Every way, the fastest for very many loops first; the last one covers every job."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """The way taken, and a sentence on why, to be said once."""

    way: Way
    why: str


def choose(job: Job, loops: int, name: str | None = None) -> Choice:
    """Return the way for so many loops, the one of this name where one is asked for.

    Raises SpecError for a name that is none, a way that is not installed, or one that does not
    cover the job.

    >>> from zoh.lti.systems import Plant
    >>> job = Job(plant=Plant(num=[1], den=[1, 0]), law="p", dt=1.0, varying=("wc",))
    >>> choose(job, 10, "single").why
    'computed by single, as asked'
    """
    if name is not None:
        return Choice(way=_named(job, name), why=f"computed by {name}, as asked")
    passed: list[str] = []
    for way in WAYS[:-1]:
        if loops < way.least:
            passed.append(f"{way.name} pays from {way.least} loops on")
        elif not way.installed:
            passed.append(f"{way.name} needs {way.needs}: pip install 'zoh[fast]' brings it")
        elif lacking := way.lacks(job):
            passed.append(f"{way.name} has no arithmetic for {lacking}")
        else:
            return _said(way, passed)
    return _said(WAYS[-1], passed)


def named(name: str) -> Way:
    """Return the way of this name; raise SpecError where there is none."""
    for way in WAYS:
        if isinstance(name, str) and way.name == name:
            return way
    known = ", ".join(way.name for way in WAYS)
    raise SpecError("arithmetic", f"must be one of {known}", name, "choose one, or leave it out")


def _said(way: Way, passed: list[str]) -> Choice:
    starts = [way.starts] if way.starts else []
    return Choice(way=way, why="; ".join([f"computed by {way.name}", *passed, *starts]))


def _named(job: Job, name: str) -> Way:
    way = named(name)
    if not way.installed:
        way_out = "pip install 'zoh[fast]' brings it"
        raise SpecError("arithmetic", f"must have {way.needs} installed", name, way_out)
    if lacking := way.lacks(job):
        bound = f"must be one that has an arithmetic for {lacking}"
        raise SpecError("arithmetic", bound, name, "leave it out, or take single")
    return way
