"""The w-plane: w = (2/dt)(z-1)/(z+1), the bilinear picture of z.

On the unit circle z = exp(j wc dt) it is w = j v with v = (2/dt) tan(wc dt/2): what a
frequency response is in s, it is in w, at every sample time and without approximation.
Source: C. L. Phillips and H. T. Nagle, Digital Control System Analysis and Design, the
chapter on sampled frequency response (bilinear transformation).
"""

from collections.abc import Sequence
from decimal import Decimal
from functools import lru_cache
from math import atan, comb, tan
from operator import mul

import numpy as np

from zoh.lti import poly
from zoh.lti.digits import Exact
from zoh.lti.poly import ComplexArray
from zoh.lti.whole import of

Ratio = tuple[list[int], int]  # whole numbers, and the one number that divides them all


def warp(wc: float, dt: float) -> float:
    """Return v in rad/s, the w-plane frequency of the real frequency wc in rad/s.

    >>> from math import pi
    >>> warp(pi / 2, dt=1.0)  # tan(45 deg) = 1
    1.9999999999999998
    """
    return 2 / dt * tan(wc * dt / 2)


def unwarp(v: float, dt: float) -> float:
    """Return the real frequency in rad/s of the w-plane frequency v; infinity is Nyquist's.

    >>> from math import pi
    >>> unwarp(2.0, dt=1.0) == pi / 2
    True
    >>> unwarp(float("inf"), dt=1.0) == pi
    True
    """
    return 2 / dt * atan(v * dt / 2)


@lru_cache(maxsize=64)
def bilinear_weights(n: int) -> tuple[tuple[int, ...], ...]:
    """Return the integers W[i][k], the coefficient of p**(n-k) in (1+p)**(n-i) (1-p)**i.

    They turn a polynomial of degree n in z, times (1-p)**n, into one in p by z = (1+p)/(1-p).

    >>> bilinear_weights(1)
    ((1, 1), (-1, 1))
    """
    rows = []
    for i in range(n + 1):
        row = [0] * (n + 1)
        for a in range(n - i + 1):
            for b in range(i + 1):
                row[n - a - b] += comb(n - i, a) * comb(i, b) * (-1) ** b
        rows.append(tuple(row))
    return tuple(rows)


def to_bilinear(a: Sequence[Decimal], n: int) -> Exact:
    """Return (1-p)^n a(z) at z = (1+p)/(1-p), a polynomial of degree n in p.

    The same sum brings it back: z = (1+p)/(1-p) means p = (z-1)/(z+1), and
    ``to_bilinear(to_bilinear(a))`` with every second sign turned is 2^n a.
    """
    a = (Decimal(0),) * (n + 1 - len(a)) + tuple(a)
    out = [Decimal(0)] * (n + 1)
    for c, row in zip(a, bilinear_weights(n), strict=True):
        if c:
            for k, weight in enumerate(row):
                out[k] += c * weight
    return tuple(out)


@lru_cache(maxsize=64)
def _columns(n: int) -> tuple[tuple[tuple[int, ...], ...], tuple[tuple[int, ...], ...]]:
    """Return, by the power that comes out, the weights from z to p and those from p to z."""
    rows = bilinear_weights(n)  # (z-1)^(n-k) (z+1)^k is row n - k with the sign of (-1)^(n-k)
    back = [[c * (-1) ** (n - k) for c in rows[n - k]] for k in range(n + 1)]
    return tuple(zip(*rows, strict=True)), tuple(zip(*back, strict=True))


def z_to_w(a: Sequence[float], dt: float, n: int) -> Ratio:
    """Return the polynomial in w that is (1 - w dt/2)^n a(z), degree n, n + 1 coefficients.

    Exact: w = (2/dt)(z-1)/(z+1) only mixes the coefficients with integers.

    >>> z_to_w((1.0, -1.0), dt=2.0, n=1)  # z - 1 = 2 w/(1 - w)
    ([4, 0], 2)
    """
    (values,), unit = of(a)
    values = [0] * (n + 1 - len(values)) + values
    top, bottom = dt.as_integer_ratio()
    bottom *= 2
    out = [sum(map(mul, column, values)) for column in _columns(n)[0]]
    return [c * top ** (n - k) * bottom**k for k, c in enumerate(out)], unit * bottom**n


def w_to_z(a: Sequence[int], dt: float) -> Ratio:
    """Return the polynomial in z that is (z+1)^n a(w), n the degree of a, exactly.

    >>> w_to_z((1, 0), dt=2.0)  # w = (z - 1)/(z + 1)
    ([2, -2], 2)
    """
    n = len(a) - 1
    top, bottom = dt.as_integer_ratio()
    octaves, unit, in_p = bottom.bit_length(), 1, []  # of twice the bottom, a power of two
    for k, c in enumerate(a):
        in_p.append(c * unit << octaves * (n - k))
        unit *= top
    return [sum(map(mul, column, in_p)) for column in _columns(n)[1]], top**n


def roots_in_z(a: Sequence[float], dt: float) -> ComplexArray:
    """Return the z at which a(w) is 0; leading zeros are roots at z = -1, w = 2/dt is z infinite.

    >>> roots_in_z((0.0, 1.0, 0.0), dt=2.0)  # w = 0, and one at infinity
    array([ 1.+0.j, -1.+0.j])
    """
    at_nyquist = len(a) - len(poly.trim(a))
    half = poly.roots(a) * dt / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.where(half == 1, np.inf, (1 + half) / (1 - half))
    return np.concatenate([found, np.full(at_nyquist, -1.0)])
