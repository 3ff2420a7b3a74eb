"""Real polynomials as tuples of floats, descending powers.

The zero polynomial is ``(0.0,)``. Nothing here knows what a frequency is.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Poly = tuple[float, ...]


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


def times(a: Sequence[float], b: Sequence[float]) -> Poly:
    """Return the product a b.

    >>> times((1.0, 1.0), (1.0, -1.0))
    (1.0, 0.0, -1.0)
    """
    return tuple(np.convolve(a, b).tolist())


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


def derivative(a: Sequence[float]) -> Poly:
    """Return da/dx.

    >>> derivative((1.0, 2.0, 3.0))
    (2.0, 2.0)
    """
    n = len(a) - 1
    return tuple(c * (n - i) for i, c in enumerate(a[:-1])) or (0.0,)


def roots(a: Sequence[float]) -> npt.NDArray[np.complex128]:
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
    log_scale = (np.log2(abs(a[-1])) - np.log2(abs(a[0]))) / n
    with np.errstate(over="ignore", under="ignore"):
        scaled = [_ldexp(c / a[0], -i * log_scale) for i, c in enumerate(a)]
    found = np.roots(scaled) * 2.0**log_scale
    return np.concatenate([found, np.zeros(zeros_at_origin)])


def _ldexp(x: float, log2_factor: float) -> float:
    """Return x 2**log2_factor; the factor may be beyond a float's range where x is not."""
    half = log2_factor / 2
    return x * float(np.exp2(half)) * float(np.exp2(half))


def even_odd(a: Sequence[float]) -> tuple[Poly, Poly]:
    """Return (e, o) with a(j v) = e(q) + j v o(q), q = v**2.

    >>> even_odd((1.0, 2.0, 3.0))  # (jv)^2 + 2 jv + 3
    ((-1.0, 3.0), (2.0,))
    """
    ascending = tuple(a)[::-1]
    even = [c if k % 2 == 0 else -c for k, c in enumerate(ascending[0::2])]
    odd = [c if k % 2 == 0 else -c for k, c in enumerate(ascending[1::2])]
    return tuple(even[::-1]), tuple(odd[::-1]) or (0.0,)


def size_squared(a: Sequence[float]) -> Poly:
    """Return the polynomial in q = v**2 that equals |a(j v)|**2.

    >>> size_squared((1.0, 2.0))
    (1.0, 4.0)
    """
    even, odd = even_odd(a)
    return trim(plus(times(even, even), times((1.0, 0.0), times(odd, odd))))
