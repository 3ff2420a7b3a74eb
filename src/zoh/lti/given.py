"""What a user gives for a system, checked and in the form the library works with."""

from collections.abc import Sequence
from math import isfinite
from numbers import Complex
from typing import Any

import numpy as np

from zoh import checks
from zoh.errors import SpecError
from zoh.lti.poly import Poly

MAX_ORDER = 50  # beyond it a double holds no polynomial; real loops stay far below
MOST_DELAY = 1_000_000  # samples; z^-delay is written out in the z-coefficients


def check_fraction(num: Poly, den: Poly, variable: str) -> None:
    """Raise SpecError unless num/den is a proper (causal) fraction of a known order.

    What is delay of a fraction in z is no order: it is kept as a number of samples.
    """
    if not any(den):
        raise SpecError("den", "must not be all zeros", list(den), "give at least one coefficient")
    if not any(num):
        raise SpecError(
            "num", "must not be all zeros", list(num), "a plant that does nothing has no loop"
        )
    if len(num) > len(den):
        reason = "proper" if variable == "s" else "causal"
        raise SpecError(
            "num",
            f"must not have a higher degree in {variable} than den ({len(den) - 1})",
            len(num) - 1,
            f"a {reason} system has deg num <= deg den",
        )
    if len(den) - 1 > MAX_ORDER:
        _check_order(num, den, variable)


def _check_order(num: Poly, den: Poly, variable: str) -> None:
    """Raise SpecError where den has too many coefficients to work with, or too much delay."""
    bound = f"must have order {MAX_ORDER} or less"
    if variable == "s":
        raise SpecError("den", bound, len(den) - 1, "reduce the model first")
    delay = delay_at_zero(num, den)
    if delay > MOST_DELAY:
        few = f"must be {MOST_DELAY} samples of delay or fewer"
        raise SpecError("den", few, delay, "sample more slowly")
    if len(den) - 1 - delay > MAX_ORDER:
        why = "the digits of a float hold no polynomial beyond"
        way_out = "reduce the model, or multiply systems of lower order, a * b"
        raise SpecError("den", f"{bound} besides its delay ({why})", len(den) - 1 - delay, way_out)


def paired(name: str, values: Any) -> list[complex]:
    """Return roots as complex numbers; raise SpecError unless they come in conjugate pairs."""
    roots = complex_numbers(name, values, "give a list of numbers, complex ones in conjugate pairs")
    for r in roots:
        if r.imag and roots.count(r) != roots.count(r.conjugate()):
            raise SpecError(name, "must come in conjugate pairs", r, f"add {r.conjugate()}")
    return roots


def complex_numbers(name: str, values: Any, way_out: str) -> list[complex]:
    """Return a list of finite complex numbers; a text or a bool is no number."""
    found = []
    for i, value in enumerate(checks.sequence(name, values, way_out)):
        if isinstance(value, bool | np.bool_) or not isinstance(value, Complex):
            raise SpecError(f"{name}[{i}]", "must be a number", value, way_out)
        try:
            number = complex(value)
        except OverflowError:
            raise SpecError(f"{name}[{i}]", "must fit a 64-bit float", value, way_out) from None
        if not np.isfinite(number):
            raise SpecError(f"{name}[{i}]", "must be finite", value, way_out)
        found.append(number)
    return found


def checked_state_space(
    a: Any, b: Any, c: Any, d: Any
) -> tuple[list[list[float]], list[float], list[float], float]:
    """Return (A, B, C, D) as lists and a float; raise SpecError unless they are SISO and fit."""
    arrays = []
    for name, value in (("A", a), ("B", b), ("C", c), ("D", d)):
        arrays.append(checks.numbers(name, value, "must be a matrix of numbers", "a list of rows"))
    matrix = np.atleast_2d(arrays[0])
    n = matrix.shape[0]
    if matrix.ndim != 2 or matrix.shape != (n, n):
        raise SpecError("A", "must be square", list(matrix.shape), "give n rows of n numbers")
    if n > MAX_ORDER:
        raise SpecError("A", f"must have {MAX_ORDER} rows or less", n, "reduce the model first")
    for name, array, size in (("B", arrays[1], n), ("C", arrays[2], n), ("D", arrays[3], 1)):
        if array.size != size:
            raise SpecError(
                name, f"must have {size} entries (one input, one output)", array.size, "SISO only"
            )
    b_c = [x.ravel().tolist() for x in arrays[1:3]]
    return matrix.tolist(), b_c[0], b_c[1], float(arrays[3].ravel()[0])


def in_w(name: str, value: Sequence[float]) -> Sequence[float]:
    """Return w-coefficients, checked; leading zeros are kept."""
    if type(value) is tuple and value and all([type(c) is float and isfinite(c) for c in value]):
        return value  # what zoh makes itself
    way_out = "give the coefficients as a list of real numbers in descending powers of w"
    items = checks.sequence(name, value, way_out)
    if not items:
        raise SpecError(name, "must have at least one coefficient", value, way_out)
    return tuple(checks.number(f"{name}[{i}]", c, way_out) for i, c in enumerate(items))


def delay_at_zero(num: Poly, den: Poly) -> int:
    """Return how many poles at z = 0 are a delay: those that leave a causal rest.

    >>> delay_at_zero((1.0,), (1.0, -0.5, 0.0, 0.0)), delay_at_zero((1.0, 2.0), (1.0, 0.0))
    (2, 0)
    """
    at_zero = next(k for k, c in enumerate(reversed(den)) if c)
    return min(at_zero, len(den) - len(num))
