"""A batch: one float64 column for each key that varies, all of one length.

A batch goes in beside the ``Job`` that says all the rest; what comes out are columns of the same
length, named in ``zoh.batch.figures``.
"""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from zoh.batch import sources
from zoh.batch.figures import column_names
from zoh.batch.job import Job
from zoh.batch.reason import Reason
from zoh.batch.sources import FloatArray
from zoh.errors import SpecError

Columns = Mapping[str, FloatArray]
Results = dict[str, npt.NDArray[np.generic]]


def length(job: Job, columns: Columns) -> int:
    """Return how many loops the batch has; raise SpecError unless its columns are the job's."""
    if tuple(columns) != job.varying:
        way_out = "one column for each key that varies, in their order"
        raise SpecError("columns", f"must be {list(job.varying)}", list(columns), way_out)
    lengths = {column.shape for column in columns.values()}
    if len(lengths) > 1 or any(len(shape) != 1 for shape in lengths):
        bound = "must be one-dimensional and of one length"
        raise SpecError("columns", bound, sorted(lengths), "complete the short ones")
    for key, column in columns.items():
        if column.dtype != np.float64 or not np.isfinite(column).all():
            raise SpecError(f"columns[{key!r}]", "must be finite float64", column.dtype, "see key")
    return next(iter(lengths))[0] if lengths else 1


def column(job: Job, columns: Columns, key: str, n: int) -> FloatArray:
    """Return the values of a key for all n loops, whether it varies or not."""
    if key in columns:
        return columns[key]
    value = job.value(key)
    if value is None:
        raise SpecError(key, "must be given", None, "it is not part of this job")
    return np.full(n, value)


def coefficients(job: Job, columns: Columns, n: int) -> tuple[FloatArray, FloatArray]:
    """Return num and den of every plant, shapes (m + 1, n) and (d + 1, n), the sensor left out."""
    return sources.coefficients(job.plant, columns, n)


def unwritten(job: Job, n: int) -> Results:
    """Return the columns of results of n loops, each of them to be written.

    They are rows of one array: a system has one large stretch of memory ready sooner than many.
    """
    names = column_names(job.law)[:-2]
    out: Results = dict(zip(names, np.empty((len(names), n)), strict=True))
    return out | {"stable": np.empty(n, bool), "reason": np.empty(n, np.int8)}


def empty(job: Job, n: int) -> Results:
    """Return the columns of results of n loops of which nothing is known yet."""
    out = unwritten(job, n)
    for name, values in out.items():
        values.fill({"stable": False, "reason": Reason.MALFORMED}.get(name, np.nan))
    return out
