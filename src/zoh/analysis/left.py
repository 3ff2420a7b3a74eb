"""What is left of a motion that was not followed to its rest: a bound by its modes.

With the eigenvectors v_i of the states' step and what is left, sum a_i v_i, an output c z is from
any sample on no further from its rest than

    sum |a_i| |c v_i|

for no mode grows. Between the samples the same holds with Bernstein's coefficients of the output
in the place of c. Source: R. A. Horn and C. R. Johnson, Matrix Analysis, 2nd ed., sec. 1.3.
"""

from math import inf

import numpy as np

from zoh.analysis.loop import Array

_SKEWED = 1e8  # of the eigenvectors' condition: beyond, modes are not told from their neighbours


def farthest(delta: Array, moves: Array, rows: Array) -> float:
    """Return a bound on how far any of the rows is from its rest from now on; inf if none is known.

    delta  what the states move by in a sample, shape (n, n), of modes that decay
    moves  what they move by in this one, shape (n,);  rows  on the states, shape (K, n)

    None is known where a mode is not told from its neighbour.

    >>> farthest(np.array([[-0.5]]), np.array([0.5]), np.array([[1.0]]))  # 1 - 2^-k
    1.0
    """
    with np.errstate(over="ignore", invalid="ignore"):  # what comes of it bounds nothing
        values, vectors = np.linalg.eig(delta)
        if not np.linalg.cond(vectors) < _SKEWED:
            return inf
        sizes = np.abs(np.linalg.solve(vectors, moves.astype(complex)) / values)
        return float(np.abs(rows.dot(vectors)).dot(sizes).max())
