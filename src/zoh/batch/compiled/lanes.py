"""``LANES`` numbers in a row, with which the same is done: as one vector, once compiled."""

import numpy as np

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.jit import compiled

Lanes = tuple[float, float, float, float, float, float, float, float]
_1, _2, _3, _4, _5, _6, _7 = (np.uint64(i) for i in range(1, 8))  # places that are never < 0


@compiled
def everywhere(x: float) -> Lanes:
    """Return the same number in every lane."""
    return x, x, x, x, x, x, x, x


@compiled
def taken(row: Array, first: int) -> Lanes:
    """Return a row's numbers from a place on."""
    i = np.uint64(first)
    return (
        row[i], row[i + _1], row[i + _2], row[i + _3],
        row[i + _4], row[i + _5], row[i + _6], row[i + _7],
    )  # fmt: skip


@compiled
def put(x: Lanes, row: Array, first: int) -> None:
    """Write them to a row, from a place on."""
    i = np.uint64(first)
    row[i], row[i + _1], row[i + _2], row[i + _3] = x[0], x[1], x[2], x[3]
    row[i + _4], row[i + _5], row[i + _6], row[i + _7] = x[4], x[5], x[6], x[7]


@compiled
def plus(x: Lanes, y: Lanes) -> Lanes:
    """Return x + y."""
    return (
        x[0] + y[0], x[1] + y[1], x[2] + y[2], x[3] + y[3],
        x[4] + y[4], x[5] + y[5], x[6] + y[6], x[7] + y[7],
    )  # fmt: skip


@compiled
def plus_times(x: Lanes, part: float, y: Lanes) -> Lanes:
    """Return x + part y."""
    return (
        x[0] + part * y[0], x[1] + part * y[1], x[2] + part * y[2], x[3] + part * y[3],
        x[4] + part * y[4], x[5] + part * y[5], x[6] + part * y[6], x[7] + part * y[7],
    )  # fmt: skip


@compiled
def plus_sizes(x: Lanes, part: float, y: Lanes, middle: float) -> Lanes:
    """Return x + part |y - middle|."""
    return (
        x[0] + part * abs(y[0] - middle), x[1] + part * abs(y[1] - middle),
        x[2] + part * abs(y[2] - middle), x[3] + part * abs(y[3] - middle),
        x[4] + part * abs(y[4] - middle), x[5] + part * abs(y[5] - middle),
        x[6] + part * abs(y[6] - middle), x[7] + part * abs(y[7] - middle),
    )  # fmt: skip
