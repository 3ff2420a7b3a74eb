"""A sampled system as states that move by small steps.

x(k+1) = x(k) + delta x(k) + b e(k), u = c x + d e: with delta instead of delta + I a small dt
costs no digits.
Source: the state space of the bilinear transformation, K. J. Astrom and B. Wittenmark,
Computer-Controlled Systems, 3rd ed., ch. 8 (Tustin's approximation).
"""

from collections.abc import Sequence

import numpy as np

from zoh.analysis.loop import Array
from zoh.lti import poly
from zoh.lti.systems import Sampled


def realised(system: Sampled) -> tuple[Array, Array, Array, float]:
    """Return (delta, b, c, d) with x(k+1) = x(k) + delta x(k) + b e(k), u = c x + d e.

    From the w-form: with w = (2/dt)(z-1)/(z+1), (A, B, C, D) in w gives, h = dt/2 and
    M = (I - h A)^-1, the matrices 2 h M A, 2 h M B, C M, D + h C M B. A pole at z = -1 has no
    w-form: there the z-form serves. The delay is not in it.
    """
    if system.den_w[0] == 0:
        a, b, c, d = _companion(
            _without_delay(system.num, system), _without_delay(system.den, system)
        )
        return a - np.eye(len(c)), b, c, d
    h = system.dt / 2
    n = len(system.den_w) - 1
    scale = _scale(system.den_w)
    num = [x * scale ** (k - n) for k, x in zip(range(n, -1, -1), system.num_w, strict=True)]
    den = [x * scale ** (k - n) for k, x in zip(range(n, -1, -1), system.den_w, strict=True)]
    a, b, c, d = _companion(num, den)
    a, b = a * scale, b * scale
    m = np.linalg.inv(np.eye(n) - h * a) if n else a
    return 2 * h * m @ a, 2 * h * m @ b, c @ m, d + h * float(c @ m @ b)


def _scale(den: Sequence[float]) -> float:
    """Return the typical size of the roots, by which the companion form is balanced."""
    sizes = np.abs(poly.roots(den))
    sizes = sizes[sizes > 0]
    return float(np.exp(np.log(sizes).mean())) if sizes.size else 1.0


def _companion(num: Sequence[float], den: Sequence[float]) -> tuple[Array, Array, Array, float]:
    n = len(den) - 1
    monic = np.array(den[1:]) / den[0]
    top = np.array(poly.padded(num, n + 1)) / den[0]
    a = np.eye(n, k=-1)
    if n:
        a[0] = -monic
    return a, np.eye(n, 1).ravel(), top[1:] - top[0] * monic, float(top[0])


def _without_delay(a: Sequence[float], system: Sampled) -> Sequence[float]:
    if a is system.den and system.delay:
        return a[: -system.delay]
    return a
