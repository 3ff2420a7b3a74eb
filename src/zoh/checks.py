"""Arguments, checked once where they come in.

Each function returns the value in the form the library works with, or raises ``SpecError``.
"""

from collections.abc import Iterable, Mapping, Set
from math import inf, isfinite
from numbers import Real
from typing import Any, TypeGuard, TypeVar

import numpy as np
import numpy.typing as npt

from zoh.errors import SpecError

_NO_NUMBER = (bool, np.bool_, np.ma.MaskedArray)

Numbers = TypeVar("Numbers", npt.NDArray[np.float64], npt.NDArray[np.complex128])


def number(name: str, value: object, way_out: str = "give one real number") -> float:
    """Return ``value`` as a finite float; a bool or a string is no number.

    >>> number("dt", 1)
    1.0
    """
    if type(value) is float and isfinite(value):  # nearly always
        return value
    if type(value) is not int:
        if _is_0d(value) and not isinstance(value, np.ma.MaskedArray):  # what is masked says 0.0
            value = value.item()
        if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
            raise SpecError(name, "must be a real number", value, way_out)
    try:
        result = float(value)
    except OverflowError:
        raise SpecError(name, "must fit a 64-bit float", value, way_out) from None
    if not isfinite(result):
        raise SpecError(name, "must be finite", value, way_out)
    return result


def positive(name: str, value: object, way_out: str = "give a number above zero") -> float:
    """Return ``value`` as a finite float above zero."""
    if type(value) is float and 0 < value < inf:  # nearly always
        return value
    result = number(name, value, way_out)
    if result <= 0:
        raise SpecError(name, "must be above 0", value, way_out)
    return result


def not_negative(name: str, value: object, way_out: str = "give zero or more") -> float:
    """Return ``value`` as a finite float, zero or above."""
    if type(value) is float and 0 <= value < inf:  # nearly always
        return value
    result = number(name, value, way_out)
    if result < 0:
        raise SpecError(name, "must be 0 or more", value, way_out)
    return result


def coefficients(name: str, value: object) -> tuple[float, ...]:
    """Return polynomial coefficients, descending powers, without leading zeros.

    >>> coefficients("num", [0, 0, 1, 2])
    (1.0, 2.0)
    """
    way_out = "give the coefficients as a list of real numbers in descending powers"
    items = sequence(name, value, way_out)
    if not items:
        raise SpecError(name, "must have at least one coefficient", value, way_out)
    result = [
        item if type(item) is float and isfinite(item) else number(f"{name}[{i}]", item, way_out)
        for i, item in enumerate(items)
    ]
    while len(result) > 1 and result[0] == 0:
        del result[0]
    return tuple(result)


def sequence(name: str, value: object, way_out: str) -> list[Any]:
    """Return the entries of a list in their order; a text, a set or a masked array is none.

    >>> sequence("num", (1, 2), "give a list")
    [1, 2]
    """
    if type(value) is list or type(value) is tuple:  # nearly always
        return list(value)
    without_order = isinstance(value, str | bytes | Mapping | Set | np.ma.MaskedArray)
    if without_order or not isinstance(value, Iterable) or _is_0d(value):
        raise SpecError(name, "must be a list of numbers", value, way_out)
    return list(value)


def text(name: str, value: object) -> str:
    """Return ``value`` as it is; raise SpecError unless it is a text."""
    if not isinstance(value, str):
        raise SpecError(name, "must be a text", value, "put it in quotes")
    return value


def whole(name: str, value: object, least: int, way_out: str) -> int:
    """Return ``value`` as a whole number of at least ``least``.

    >>> whole("per_sample", 20, 1, "give the points")
    20
    """
    result = number(name, value, way_out)
    if result != int(result) or result < least:
        raise SpecError(name, f"must be a whole number of {least} or more", value, way_out)
    return int(result)


def frequencies(name: str, value: object) -> npt.NDArray[np.float64]:
    """Return a finite frequency, or an array of them, as a float64 array."""
    way_out = "give rad/s, a number or an array of numbers"
    return numbers(name, value, "must be a frequency", way_out)


def numbers(
    name: str, value: object, bound: str = "must be numbers", way_out: str = "one for each row"
) -> npt.NDArray[np.float64]:
    """Return a finite number, or an array of them, as a float64 array."""
    result = _array(name, value, "fiu", bound, way_out).astype(float)
    return _finite(name, result, way_out)


def complex_gains(name: str, value: object) -> npt.NDArray[np.complex128]:
    """Return a finite complex gain, or an array of them, as a complex128 array."""
    way_out = "give one complex number per frequency"
    array = _array(name, value, "fiuc", "must be complex numbers", way_out)
    return _finite(name, array.astype(complex), way_out)


def _array(
    name: str, value: object, kinds: str, bound: str, way_out: str
) -> npt.NDArray[np.generic]:
    """Return an array of these kinds of numbers; NumPy alone would read a bool as one."""
    if isinstance(value, str | bytes | np.ma.MaskedArray) or value is None:
        raise SpecError(name, bound, value, way_out)
    try:
        entries = () if isinstance(value, np.ndarray) else np.asarray(value, object).flat
        if any(isinstance(x, _NO_NUMBER) for x in entries):
            raise TypeError
        array = np.asarray(value)
        if array.dtype.kind not in kinds:
            raise TypeError
    except (TypeError, ValueError):
        raise SpecError(name, bound, value, way_out) from None
    return array


def _finite(name: str, array: Numbers, way_out: str) -> Numbers:
    finite = np.isfinite(array)
    if not finite.all():
        raise SpecError(name, "must be finite", array[~finite].flat[0].item(), way_out)
    return array


def column(
    name: str, value: object, length: int | None = None, *,
    above: float | None = None, least: float | None = None,
) -> npt.NDArray[np.float64]:  # fmt: skip
    """Return one column of a table as a read-only float64 array, each entry within its bound.

    >>> column("magnitude", [1, 2], 2, above=0.0)
    array([1., 2.])
    """
    way_out = "give one number for each row"
    result = np.array(np.atleast_1d(numbers(name, value, way_out=way_out)))
    if result.ndim != 1 or len(result) != (len(result) if length is None else length):
        bound = "must be one column" if length is None else f"must be {length} numbers, one per w"
        raise SpecError(name, bound, result.shape, "complete the rows")
    low = np.zeros(len(result), bool)
    if above is not None:
        low = result <= above
    if least is not None:
        low = result < least
    if low.any():
        i = int(np.flatnonzero(low)[0])
        bound = f"must be above {above:g}" if least is None else f"must be {least:g} or more"
        raise SpecError(f"{name}[{i}]", bound, float(result[i]), "mend this row or leave it out")
    result.flags.writeable = False
    return result


def ascending(name: str, value: object) -> npt.NDArray[np.float64]:
    """Return a column of frequencies: two or more, above 0, each above the one before.

    >>> ascending("w", [1, 2])
    array([1., 2.])
    """
    found = column(name, value, above=0.0)
    if len(found) < 2:
        raise SpecError(name, "must have two points or more", found.tolist(), "measure more")
    wrong = np.flatnonzero(np.diff(found) <= 0)
    if wrong.size:
        i = int(wrong[0]) + 1
        bound = f"must be above {name}[{i - 1}]"
        raise SpecError(f"{name}[{i}]", bound, float(found[i]), "sort the rows")
    return found


def _is_0d(value: object) -> TypeGuard[npt.NDArray[Any]]:
    return isinstance(value, np.ndarray) and value.ndim == 0
