"""Real polynomials as tuples of floats, descending powers.

The zero polynomial is ``(0.0,)``. Nothing here knows what a frequency is.
"""

from collections.abc import Iterable, Sequence
from math import floor, frexp, isqrt, ldexp, log2
from operator import mul
from typing import Any

import numpy as np
import numpy.typing as npt

from zoh.errors import SpecError
from zoh.lti.whole import of

Poly = tuple[float, ...]
ComplexArray = npt.NDArray[np.complex128]


def trim(a: Iterable[float]) -> Poly:
    """Return ``a`` without leading zeros.

    >>> trim((0.0, 1.0, 2.0))
    (1.0, 2.0)
    """
    a = tuple(a)
    for i, c in enumerate(a):
        if c != 0:
            return a[i:]
    return (0.0,)


def at(a: Sequence[float], x: Any) -> Any:
    """Return a(x) by Horner's rule; x is a number or an array, real or complex.

    >>> at((1.0, 2.0, 3.0), 2.0)
    11.0
    """
    value = x * 0 + a[0]
    for c in a[1:]:
        value = value * x + c
    return value


def homogeneous(a: Sequence[float], x: Any, y: Any) -> Any:
    """Return sum a_k x**(n-k) y**k, that is y**n a(x/y), also where y is 0.

    >>> homogeneous((1.0, 2.0, 3.0), 1.0, 0.0)
    1.0
    """
    value, power = x * 0 + a[0], y * 0 + 1.0
    for c in a[1:]:
        power = power * y
        value = value * x + c * power
    return value


def quotient(top: Any, bottom: Any) -> Any:
    """Return top/bottom of arrays, infinite where bottom is 0 or the quotient beyond a float.

    >>> quotient(np.array([1.0, 1.0]), np.array([2.0, 0.0]))
    array([0.5+0.j, inf+0.j])
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        value = top / np.where(bottom == 0, 1, bottom)
        return np.where((bottom == 0) | ~np.isfinite(value), complex(np.inf, 0), value)


def times(a: Sequence[float], b: Sequence[float]) -> Poly:
    """Return the product a b.

    >>> times((1.0, 1.0), (1.0, -1.0))
    (1.0, 0.0, -1.0)
    """
    if len(a) < len(b):
        a, b = b, a
    n, zeros = len(a) - 1, (0.0,) * (len(b) - 1)
    rows, backwards = (*zeros, *a, *zeros), b[::-1]
    return tuple([sum(map(mul, rows[i:], backwards)) for i in range(n + len(b))])


def plus(a: Sequence[float], b: Sequence[float], sign: float = 1.0) -> Poly:
    """Return a + sign b.

    >>> plus((1.0, 2.0), (3.0,), sign=-1)
    (1.0, -1.0)
    """
    n = max(len(a), len(b))
    return tuple(x + sign * y for x, y in zip(padded(a, n), padded(b, n), strict=True))


def padded(a: Sequence[float], n: int) -> Poly:
    """Return ``a`` with leading zeros up to n coefficients."""
    return (0.0,) * (n - len(a)) + tuple(a)


def roots(a: Sequence[float]) -> ComplexArray:
    """Return the roots of ``a``, those at zero exact; the empty array for a constant.

    The variable is scaled so that the first and last coefficients match before the companion
    matrix is formed: the eigenvalue error is relative to the largest root, and this brings the
    roots of a badly scaled polynomial together.

    >>> [round(r, 12) for r in sorted(roots((1.0, -3.0, 2.0, 0.0)).real.tolist())]
    [0.0, 1.0, 2.0]
    """
    a = trim(a)
    zeros_at_origin = 0
    while len(a) > 1 and a[-1] == 0:
        a, zeros_at_origin = a[:-1], zeros_at_origin + 1
    n = len(a) - 1
    if n < 1:
        return np.zeros(zeros_at_origin, complex)
    try:
        found = _line(a) if n == 1 else _parabola(a) if n == 2 else _companion(a)
    except (OverflowError, ValueError):  # too large for a float, or made of such
        raise SpecError(
            "coefficients",
            "must have roots that a 64-bit float can hold",
            list(a),
            "count time in another unit, or reduce the model",
        ) from None
    return np.array([*found, *[0.0] * zeros_at_origin], complex)


def _line(a: Poly) -> list[complex]:
    return [complex(-a[1] / a[0])]


def _parabola(a: Poly) -> list[complex]:
    """Return the roots of a parabola, each as a float next to it.

    The discriminant is taken in whole numbers and its root to 64 bits beyond the point, and of
    two real roots the one that is a difference comes from the product of both.
    """
    ((a0, a1, a2),), _ = of(a)
    inside = a1 * a1 - 4 * a0 * a2
    more = max(64, 192 - inside.bit_length()) // 2
    root = isqrt(abs(inside) << 2 * more)
    if inside < 0:
        re, im = -a1 / (2 * a0), root / (abs(2 * a0) << more)
        return [complex(re, im), complex(re, -im)]
    far = -(a1 << more) - (root if a1 > 0 else -root)
    return [complex(far / (a0 << more + 1)), complex((a2 << more + 1) / far)]


def _companion(a: Poly) -> list[complex]:
    n = len(a) - 1
    scale = (log2(abs(a[-1])) - log2(abs(a[0]))) / n
    companion = np.zeros((n, n))
    companion.flat[n :: n + 1] = 1.0  # below the diagonal
    companion[0] = [-_ratio(c, a[0], -i * scale) for i, c in enumerate(a) if i]
    roots: list[complex] = (np.linalg.eigvals(companion).astype(complex) * 2.0**scale).tolist()
    return roots


def _ratio(x: float, y: float, log2_factor: float) -> float:
    """Return x/y 2**log2_factor; the parts may be beyond a float's range where it is not."""
    (x, x_exponent), (y, y_exponent) = frexp(x), frexp(y)
    whole = floor(log2_factor)
    return ldexp(x / y * 2.0 ** (log2_factor - whole), x_exponent - y_exponent + whole)
