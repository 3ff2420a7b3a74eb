"""Real polynomials of many loops at once: a row a power, ascending; a column a loop.

Roots are found where signs change, so none is invented, and between the roots of the derivative,
found the same way down to a straight line, so none is missed.
Source: W. H. Press et al., Numerical Recipes, 3rd ed., sec. 9.4 (Newton's method kept in a
bracket) and 9.5 (polynomials).
"""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from zoh.batch.tolerances import DOUBLE

Kept = TypeVar("Kept", bound=Any)  # a dataclass
Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
Mask = npt.NDArray[np.bool_]
Index = npt.NDArray[np.intp]
Kind = TypeVar("Kind", bound=np.generic)

_ENDS = 1e25  # roots are looked for between its inverse and it
_RANGE = 280.0  # decades that a power of a float may fill
_STEPS = 120  # halvings of a bracket's logarithm, and Newton's steps between them
_LAST = 1e-8  # relative: the error after a Newton's step as small as this is its square
_CLOSE = 1e-15  # relative; between two ends this near there is nothing but rounding


def only(loops: Kept, keep: Index) -> Kept:
    """Return some of the loops of a record whose arrays have a loop a column."""
    return replace(loops, **{f.name: _some(getattr(loops, f.name), keep) for f in fields(loops)})


def _some(value: Any, keep: Index) -> Any:
    if isinstance(value, Mapping):
        return {name: taken(array, keep) for name, array in value.items()}
    return taken(value, keep) if isinstance(value, np.ndarray) else value


def taken(array: npt.NDArray[Kind], keep: Index) -> npt.NDArray[Kind]:
    """Return some columns; a row's values stay side by side, as ``array[..., keep]`` has them not.

    >>> taken(np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]), np.array([0, 2])).strides
    (16, 8)
    """
    return array.take(keep, axis=-1)


def times(a: Array, b: Array) -> Array:
    """Return the product.

    >>> times(np.array([[1.0], [1.0]]), np.array([[1.0], [-1.0]])).ravel()
    array([ 1.,  0., -1.])
    """
    out = np.zeros((len(a) + len(b) - 1, max(a.shape[1], b.shape[1])))
    for i, row in enumerate(a):
        out[i : i + len(b)] += row * b
    return out


def at(a: Array, x: Array) -> Array:
    """Return the value at x, shape (..., B)."""
    if len(a) == 1:
        return np.asarray(a[0] + np.zeros(x.shape))
    out: Array = a[-1] * x
    out += a[-2]
    for row in a[-3::-1]:
        out *= x
        out += row
    return out


def with_slope(a: Array, x: Array) -> tuple[Array, Array]:
    """Return the value and the derivative at x."""
    if len(a) == 1:
        return a[0] + np.zeros(x.shape), np.zeros(x.shape)
    value, slope = a[-1] * x, a[-1] + np.zeros(x.shape)
    value += a[-2]
    for row in a[-3::-1]:
        slope *= x
        slope += value
        value *= x
        value += row
    return value, slope


def derivative(a: Array) -> Array:
    """Return the derivative, of at least one row."""
    if len(a) == 1:
        return np.zeros_like(a)
    return a[1:] * np.arange(1.0, len(a))[:, None]


def halves(a: Array) -> tuple[Array, Array]:
    """Return (even, odd) in q = v^2 with a(jv) = even + j v odd.

    >>> even, odd = halves(np.array([[1.0], [2.0], [3.0], [4.0]]))
    >>> even.ravel(), odd.ravel()  # 1 - 3 q, 2 - 4 q
    (array([ 1., -3.]), array([ 2., -4.]))
    """
    even, odd = a[::2].copy(), a[1::2].copy()
    even[1::2] *= -1
    odd[1::2] *= -1
    return even, odd if len(odd) else np.zeros_like(a[:1])


def squared(a: Array) -> Array:
    """Return |a(jv)|^2 in q, of as many rows as a."""
    even, odd = halves(a)
    out = np.zeros_like(a)
    square, other = times(even, even), times(odd, odd)
    out[: len(square)] += square[: len(a)]
    if len(a) > 1:
        out[1 : 1 + len(other)] += other[: len(a) - 1]
    return out


def on_axis(a: Array, v: Array) -> tuple[Complex, Complex]:
    """Return a(jv) and a'(jv), the derivative by its argument."""
    s = 1j * v
    value, slope = a[-1] + np.zeros(s.shape, complex), np.zeros(s.shape, complex)
    for row in a[-2::-1]:
        slope *= s
        slope += value
        value *= s
        value += row
    return value, slope


def changes(a: Array) -> npt.NDArray[np.int64]:
    """Return the number of sign changes along the rows, zeros left out (Descartes)."""
    last, count = np.zeros(a.shape[1]), np.zeros(a.shape[1], np.int64)
    for row in a:
        sign = np.sign(row)
        count += sign * last < 0
        last = np.where(sign != 0, sign, last)
    return count


def positive_roots(a: Array) -> tuple[Array, Mask]:
    """Return (the roots > 0 where a changes its sign, whether more may be there).

    Rows of roots ascend, inf where there are no more. Doubt: an extreme that touches 0 but for
    rounding.

    >>> roots, doubt = positive_roots(np.array([[6.0, 1.0], [-5.0, 0.0], [1.0, 1.0]]))
    >>> roots.round(12).tolist(), doubt.tolist()
    ([[2.0, inf], [3.0, inf]], [False, False])
    """
    count = changes(a)
    degree = len(a) - 1
    roots, doubt = np.full((max(degree, 1), a.shape[1]), np.inf), np.zeros(a.shape[1], bool)
    low, high = _ends(degree)
    (one,) = np.nonzero(count == 1)
    if len(one):
        least, most = _bounds(taken(a, one), low, high)
        roots[0, one] = _closed_in(taken(a, one), least, most, np.clip(1.0, least, most))
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
        found[where, lanes] = _closed_in(taken(f, lanes), starts, ends, np.sqrt(starts * ends))
        edges = np.sort(found, axis=0)
    bulk = at(np.abs(a), inner)
    touching = (np.abs(at(a, inner)) <= DOUBLE * bulk) & (inner < high)
    return np.where(edges < high, edges, np.inf), np.asarray(touching.any(axis=0))


def _closed_in(a: Array, low: Array, high: Array, x: Array) -> Array:
    """Return the roots between low and high, where a has two signs."""
    out = np.empty_like(x)
    index = np.arange(len(x))
    rising = at(a, low) < 0
    with np.errstate(all="ignore"):
        last = np.full(len(x), np.inf)
        for _ in range(_STEPS):
            f, slope = with_slope(a, x)
            left = (f < 0) == rising
            low, high = np.where(left, x, low), np.where(left, high, x)
            newton = x - f / slope
            inside = (newton > low) & (newton < high) & (2 * np.abs(newton - x) <= last)
            new = np.where(inside, newton, np.sqrt(low) * np.sqrt(high))
            last = np.abs(new - x)
            done = (last <= _LAST * x) | (f == 0) | (high <= low * (1 + _CLOSE))
            x = np.where(f == 0, x, new)
            if done.any():
                out[index[done]] = x[done]
                go = ~done
                if not go.any():
                    return out
                index, a, low, high, x = index[go], a[:, go], low[go], high[go], x[go]
                rising, last = rising[go], last[go]
    out[index] = x
    return out
