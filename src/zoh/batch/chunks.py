"""A batch a chunk at a time: what a faster arithmetic leaves, the single design does."""

from collections.abc import Callable, Iterable

import numpy as np
import numpy.typing as npt

from zoh.batch.columns import Columns, Results, length, unwritten
from zoh.batch.job import Job

Each = Callable[[Callable[[int], None], range], Iterable[None]]
Some = Callable[[Job, Columns, int], tuple[Results, npt.NDArray[np.bool_]]]


def in_chunks(job: Job, columns: Columns, chunk: int, some: Some, each: Each = map) -> Results:
    """Return the results of a batch.

    some  makes all those of a chunk of so many loops, and says which it leaves
    each  calls a function with every chunk's start, as ``map`` does, or a pool's
    """
    n = length(job, columns)
    out = unwritten(job, n)

    def made(start: int) -> None:
        part = slice(start, min(start + chunk, n))
        here = {key: values[part] for key, values in columns.items()}
        found, left = some(job, here, part.stop - part.start)
        (which,) = np.nonzero(left)
        for name, values in out.items():
            values[part] = found[name]
        if len(which):
            from zoh.batch import single  # what it needs is not needed where nothing is left

            again = single.run(job, {key: values[which] for key, values in here.items()})
            for name, values in again.items():
                out[name][start + which] = values

    for _ in each(made, range(0, n, chunk)):
        pass
    return out
