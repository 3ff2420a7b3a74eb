"""The positive roots of many real polynomials at once.

They are found where signs change, so none is invented, and between the roots of the derivative,
found the same way down to a straight line, so none is missed.
Source: W. H. Press et al., Numerical Recipes, 3rd ed., sec. 9.4 (Newton's method kept in a
bracket) and 9.5 (polynomials).
"""

import numpy as np

from zoh.batch.arrays.rows import Array, Mask, at, changes, derivative, taken, with_slope
from zoh.batch.tolerances import DOUBLE, GRID

_ENDS = 1e25  # roots are looked for between its inverse and it
_RANGE = 280.0  # decades that a power of a float may fill
_STEPS = 120  # halvings of a bracket's logarithm, and Newton's steps between them
_LAST = 1e-8  # relative: the error after a Newton's step as small as this is its square
_CLOSE = 1e-15  # relative; between two ends this near there is nothing but rounding
_WORTH = 0.75  # of the brackets: with no more of them open the others are left out


def positive_roots(a: Array) -> tuple[Array, Mask]:
    """Return (the roots > 0 where a changes its sign, whether more may be there).

    Rows of roots ascend, inf where there are no more. Doubt: an extreme that touches 0 but for
    rounding.

    >>> roots, doubt = positive_roots(np.array([[6.0, 1.0], [-5.0, 0.0], [1.0, 1.0]]))
    >>> roots.round(12).tolist(), doubt.tolist()
    ([[2.0, inf], [3.0, inf]], [False, False])
    """
    count, degree = changes(a), len(a) - 1
    roots, doubt = np.full((max(degree, 1), a.shape[1]), np.inf), np.zeros(a.shape[1], bool)
    low, high = _ends(degree)
    (one,) = np.nonzero(count == 1)
    if len(one):
        single = taken(a, one)
        roots[0, one] = _only(single, *_bounds(single, low, high))
    (more,) = np.nonzero(count > 1)
    if len(more):
        roots[:, more], doubt[more] = _by_extremes(taken(a, more), low, high)
    rows = int(np.max(np.sum(np.isfinite(roots), axis=0), initial=0))
    return roots[:rows], doubt


def _ends(degree: int) -> tuple[float, float]:
    high = min(_ENDS, 10.0 ** (_RANGE / max(degree, 1)))
    return 1 / high, high


def _bounds(a: Array, low: float, high: float) -> tuple[Array, Array]:
    """Return two numbers between which every positive root is (Cauchy), low and high at most."""
    size = np.abs(a)
    with np.errstate(all="ignore"):
        least = 0.99 * size[0] / (size[0] + np.max(size[1:], axis=0))
        most = 1.01 * (1.0 + np.max(size[:-1], axis=0) / size[-1])
    return np.fmax(least, low), np.fmin(most, high)


def _only(a: Array, low: Array, high: Array) -> Array:
    """Return the root where there is one: first between which points of the grid."""
    a = np.where(at(a, low) < 0, a, -a)
    values = at(a, GRID[:, None])
    place = np.sum(values < 0, axis=0)  # of the first point after the root
    before, after = np.maximum(place - 1, 0), np.minimum(place, len(GRID) - 1)
    low = np.where(place > 0, np.maximum(low, GRID[before]), low)
    high = np.where(place < len(GRID), np.minimum(high, GRID[after]), high)
    f, g = (np.take_along_axis(values, i[None, :], axis=0)[0] for i in (before, after))
    inner = (place > 0) & (place < len(GRID))
    x = np.where(inner, low + f / (f - g) * (high - low), np.sqrt(low) * np.sqrt(high))
    return closed_in(a, low, high, np.clip(x, low, high))


def _by_extremes(a: Array, low: float, high: float) -> tuple[Array, Mask]:
    ladder = [a]
    while len(ladder[-1]) > 2:
        d = derivative(ladder[-1])
        size = np.max(np.abs(d), axis=0)
        ladder.append(d / np.where(size > 0, size, 1.0))
    edges = np.full((0, a.shape[1]), high)
    for f in reversed(ladder):
        inner = edges
        edges = np.concatenate(
            [np.full((1, a.shape[1]), low), inner, np.full((1, a.shape[1]), high)]
        )
        values = at(f, edges)
        below, above = values[:-1], values[1:]
        where, lanes = np.nonzero((below < 0) != (above < 0))
        found = np.full(below.shape, high)
        starts, ends = edges[where, lanes], edges[where + 1, lanes]
        signs = np.where(below[where, lanes] < 0, 1.0, -1.0)
        middle = np.sqrt(starts * ends)
        found[where, lanes] = closed_in(taken(f, lanes) * signs, starts, ends, middle)
        edges = np.sort(found, axis=0)
    bulk = at(np.abs(a), inner)
    touching = (np.abs(at(a, inner)) <= DOUBLE * bulk) & (inner < high)
    return np.where(edges < high, edges, np.inf), np.asarray(touching.any(axis=0))


def closed_in(a: Array, low: Array, high: Array, x: Array, last: float = _LAST) -> Array:
    """Return where a goes from below 0 to above it between low and high, x a first guess.

    last  relative: a Newton's step as small as this ends the search
    """
    out, index = np.empty_like(x), np.arange(len(x))
    step, open_ = np.full(len(x), np.inf), np.ones(len(x), bool)
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            f, slope = with_slope(a, x)
            below = f < 0
            low, high = np.where(below, x, low), np.where(below, high, x)
            newton = x - f / slope
            inside = (newton >= low) & (newton <= high) & (2 * np.abs(newton - x) <= step)
            new = np.where(inside, newton, np.sqrt(low) * np.sqrt(high))
            step = np.abs(new - x)
            x = np.where(open_, new, x)
            open_ &= (~inside | (step > last * x)) & (high > low * (1 + _CLOSE))
            left = np.count_nonzero(open_)
            if not left:
                break
            if left <= _WORTH * len(x):
                out[index] = x
                (go,) = np.nonzero(open_)
                index, a = index[go], taken(a, go)
                low, high, x, step = low[go], high[go], x[go], step[go]
                open_ = np.ones(left, bool)
    out[index] = x
    return out
