"""What the C of a number format is called, and how a number is written so that it comes back."""

from math import isfinite

import numpy as np

from zoh.firmware.lines import Number

_RESULTS = {"f32": "float", "f64": "double", "q31": "int32_t", "q15": "int16_t"}
_STATES = {"f32": "float", "f64": "double", "q31": "int64_t", "q15": "int32_t"}


def result_type(number: Number) -> str:
    """Return the type of r, y, ff and u."""
    return _RESULTS[number]


def state_type(number: Number) -> str:
    """Return the type of a state."""
    return _STATES[number]


def float_literal(value: float, number: Number) -> str:
    """Return the shortest literal that a compiler reads back as the same float.

    >>> float_literal(0.1, "f64"), float_literal(float(np.float32(0.1)), "f32")
    ('0.1', '0.1f')
    """
    text = str(np.float32(value)) if number == "f32" else repr(float(value))
    back = float(np.float32(text)) if number == "f32" else float(text)
    assert isfinite(value), value
    assert back == value, f"{text} is not {value!r}"
    return f"{text}f" if number == "f32" else text
