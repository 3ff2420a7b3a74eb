"""Blocks spread over the workers of a Dask cluster, or done here one after the other.

What is sent is a block's number and what it is made of, never its columns; what comes back is what
a function makes of the block there. A block that a lost worker had is made again elsewhere: it
is the same bits wherever it is made.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any, TypeVar

from zoh.batch.backend import CORES
from zoh.batch.blocks import Task
from zoh.batch.extras import needed
from zoh.errors import SpecError

T = TypeVar("T")
Progress = Callable[[int, int], None]  # told the loops that are done, and all of them

_AHEAD = 3  # blocks for each thread: one at work, one waiting, one on its way
_PATIENCE = 5  # s, for a scheduler to answer
_RETRIES = 3  # of a block whose worker could not do it


def checked(client: Any) -> None:
    """Raise SpecError for a client that can do no work here: before there is any."""
    if client is None:
        return
    distributed = needed("distributed", "a sweep over a cluster")
    if not isinstance(client, distributed.Client):
        way_out = "give dask.distributed.Client(address), or leave it out"
        raise SpecError("client", "must be a dask.distributed.Client", client, way_out)
    if client.asynchronous or client.status != "running":
        bound = "must be connected, and not asynchronous"
        raise SpecError("client", bound, client, "give dask.distributed.Client(address)")


def each(
    function: Callable[[Task], T], tasks: Iterable[Task], client: Any = None
) -> Iterator[tuple[Task, T]]:
    """Yield (task, what ``function`` made of it), in the order in which they are done.

    client  a ``dask.distributed.Client``; None does the work here
    """
    if client is None:
        return ((task, function(task)) for task in tasks)
    return _spread(function, iter(tasks), client)


def watched(
    function: Callable[[Task], T], tasks: Iterable[Task], client: Any, progress: Progress | None,
    already: int, loops: int,
) -> Iterator[T]:  # fmt: skip
    """Yield what ``each`` does, without the tasks; tell ``progress`` of the loops done so far."""
    done = already
    if progress is not None:
        progress(done, loops)
    for task, value in each(function, tasks, client):
        done += task.stop - task.start
        if progress is not None:
            progress(done, loops)
        yield value


def connected(address: str) -> Any:
    """Return a client of the scheduler at this address; raise SpecError where there is none."""
    distributed = needed("distributed", "--scheduler")
    try:
        return distributed.Client(address, set_as_default=False, timeout=_PATIENCE)
    except (OSError, ValueError) as absent:
        way_out = "start one with: dask scheduler"
        raise SpecError("scheduler", "must answer at its address", address, way_out) from absent


def _alone(function: Callable[[Task], T], task: Task) -> T:
    """Return what the function makes of the task on one core: each worker has its own."""
    token = CORES.set(1)
    try:
        return function(task)
    finally:
        CORES.reset(token)


def _spread(
    function: Callable[[Task], T], tasks: Iterator[Task], client: Any
) -> Iterator[tuple[Task, T]]:
    distributed = needed("distributed", "a sweep over a cluster")
    waiting: dict[Any, Task] = {}
    done = distributed.as_completed(loop=client.loop)

    def submit(count: int) -> None:
        for task in islice(tasks, count):
            future = client.submit(_alone, function, task, pure=False, retries=_RETRIES)
            waiting[future] = task
            done.add(future)

    submit(_AHEAD * max(1, sum(client.nthreads().values())))
    for future in done:
        task, value = waiting.pop(future), future.result()
        future.release()
        submit(1)
        yield task, value
