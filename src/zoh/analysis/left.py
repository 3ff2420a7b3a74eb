"""What is left of a motion that was not followed to its rest: a bound by its modes.

With the eigenvectors v_i of the states' step and what is left, sum a_i v_i, an output c z is from
any sample on no further from its rest than

    sum |a_i| |c v_i|

for no mode grows. Between the samples the same holds with Bernstein's coefficients of the output
in the place of c. Source: R. A. Horn and C. R. Johnson, Matrix Analysis, 2nd ed., sec. 1.3.
"""

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from zoh.analysis.loop import Array
from zoh.analysis.pieces import bernstein

if TYPE_CHECKING:  # a motion asks this of itself
    from zoh.analysis.motion import Motion

_SKEWED = 1e8  # of the eigenvectors' condition: beyond, modes are not told from their neighbours


def farthest(motion: "Motion", state: Array) -> float:
    """Return a bound on |y - its rest| at all times from this state on; inf where none is known.

    None is where a mode does not decay or is not told from its neighbour, where what drives the
    motion still moves, and of a queue, whose state is not all there.

    >>> from zoh.analysis.motion import Motion
    >>> delta, start = np.array([[-0.5, 0.5], [0.0, 0.0]]), np.array([0.0, 1.0])
    >>> lag = Motion(dt=1.0, delta=delta, start=start, own=1, output=np.array([1.0, 0.0]),
    ...              effort=None, stretches=())
    >>> farthest(lag, start)  # 1 - 2^-k
    1.0
    """
    own, moves = motion.own, motion.delta.dot(state)
    if motion.wait or moves[own:].any():
        return inf
    with np.errstate(over="ignore", invalid="ignore"):  # what comes of it bounds nothing
        values, vectors = np.linalg.eig(motion.delta[:own, :own])
        if min(motion.rates())[0] <= 0 or not np.linalg.cond(vectors) < _SKEWED:
            return inf
        sizes = np.abs(np.linalg.solve(vectors, moves[:own].astype(complex)) / values)
        parts = [bernstein(len(part.rows)).dot(part.rows) for part in motion.stretches]
        rows = np.concatenate([motion.output[None], *parts])
        return float(np.abs(rows[:, :own].dot(vectors)).dot(sizes).max())
