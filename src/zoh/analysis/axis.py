"""A real polynomial at one point j v of the imaginary axis, in plain Python: the fastest way."""

from collections.abc import Sequence


def scalar(a: Sequence[float], v: float) -> complex:
    """Return a(j v).

    >>> scalar((1.0, 2.0, 3.0), 1.0)
    (2+2j)
    """
    re, im = a[0], 0.0
    for c in a[1:]:
        re, im = c - im * v, re * v
    return complex(re, im)


def terms(a: Sequence[float], v: float) -> float:
    """Return the sizes of a polynomial's terms at j v, added up.

    >>> terms((1.0, -2.0, 3.0), 2.0)
    11.0
    """
    size = abs(a[0])
    for c in a[1:]:
        size = size * v + abs(c)
    return size


def with_slope(a: Sequence[float], v: float) -> tuple[complex, complex]:
    """Return a(j v) and its derivative with respect to v.

    >>> with_slope((1.0, 2.0, 3.0), 1.0)  # 3 - v^2 + 2 v j
    ((2+2j), (-2+2j))
    """
    s, value, slope = complex(0.0, v), complex(a[0]), 0j
    for c in a[1:]:
        slope = slope * s + value
        value = value * s + c
    return value, 1j * slope
