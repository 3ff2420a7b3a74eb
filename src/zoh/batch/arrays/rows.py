"""Real polynomials of many loops at once: a row a power, ascending; a column a loop."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

Kept = TypeVar("Kept", bound=Any)  # a dataclass
Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
Mask = npt.NDArray[np.bool_]
Index = npt.NDArray[np.intp]
Kind = TypeVar("Kind", bound=np.generic)


def only(loops: Kept, keep: Index) -> Kept:
    """Return some of the loops of a record whose arrays have a loop a column."""
    return replace(loops, **{f.name: _some(getattr(loops, f.name), keep) for f in fields(loops)})


def joined(parts: Sequence[Kept]) -> Kept:
    """Return the loops of several such records as those of one."""
    names = [f.name for f in fields(parts[0])]
    return replace(
        parts[0], **{n: np.concatenate([getattr(p, n) for p in parts], axis=-1) for n in names}
    )


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
