"""Is the closed loop stable? Decided by its poles, never by its margins.

Without delay the closed loop is a polynomial, and Routh's scheme in whole numbers decides.
Whole samples of delay are multiplied in. A continuous dead time, or a very long one, leaves no
polynomial: there the argument principle counts.
"""

from collections.abc import Sequence
from math import comb, pi

import numpy as np

from zoh.analysis.loop import Loop
from zoh.lti import poly, whole

LONGEST = 60  # samples of delay that are multiplied in


def closed_loop_stable(loop: Loop) -> bool:
    """Return whether 1 + L has all its zeros strictly inside the stable region.

    A zero on the boundary is not stable. Shared factors of num and den count: a hidden mode
    that is unstable makes the loop unstable.
    """
    if not loop.dead_time:
        num, den = whole.of(loop.num, loop.den)
        return whole.hurwitz(whole.plus(den, num))
    if loop.dt is not None:
        m = round(loop.dead_time / loop.dt)
        if m <= LONGEST:
            return whole.hurwitz(_with_delay(loop, loop.dt, m))
    return _none_encircled(loop)


def hurwitz_floats(a: Sequence[float]) -> bool:
    """Return whether every root of a, its coefficients taken exactly, has a negative real part."""
    return whole.hurwitz(whole.of(a)[0])


def _with_delay(loop: Loop, dt: float, m: int) -> list[int]:
    """Return den (1+p)^m + num (1-p)^m in p = w dt/2, times a positive number."""
    num, den = whole.of(loop.num, loop.den)
    top, bottom = (dt / 2).as_integer_ratio()
    n = len(den) - 1
    unit = [bottom ** (n - i) * top**i for i in range(n + 1)]  # w^(n-i) = (p bottom/top)^(n-i)
    grow = [comb(m, k) for k in range(m + 1)]
    fall = [c if (m - k) % 2 == 0 else -c for k, c in enumerate(grow)]
    den = whole.times([c * s for c, s in zip(den, unit, strict=True)], grow)
    return whole.plus(den, whole.times([c * s for c, s in zip(num, unit, strict=True)], fall))


def _none_encircled(loop: Loop) -> bool:
    """Return whether f = den + num exp(-j psi) turns as a stable one does.

    f/(jv + r)^n has its poles on the left and goes to a constant, so from v = 0 to infinity its
    argument changes by -pi times the number of zeros on the right. The path is refined until no
    step turns by more than 0.5 rad and no step is long against the delay.
    Source: Mikhailov's criterion, the argument principle on the imaginary axis; for polynomials
    with exponentials R. Bellman and K. L. Cooke, Differential-Difference Equations, ch. 13.
    """
    n = len(loop.den) - 1
    if loop.dt is None and abs(loop.num[0]) >= abs(loop.den[0]):
        return False  # |L| >= 1 at infinity with dead time: infinitely many poles on the right
    sizes = [abs(r) for r in (*poly.roots(loop.den), *poly.roots(loop.num)) if r]
    scale = max([*sizes, 1 / loop.dead_time])
    low = min([*sizes, 1 / loop.dead_time]) * 1e-6
    v = np.concatenate([[0.0], np.geomspace(low, scale * 1e8, 2000), _turns(loop, scale)])
    v = np.unique(v)
    for _ in range(60):
        top, bottom = loop.parts(v)
        g = (bottom + top) / (1j * v + scale) ** n
        if np.any(g == 0):
            return False
        step = np.angle(g[1:] / g[:-1])
        wide = np.flatnonzero(np.abs(step) > 0.5)
        if not wide.size:
            break
        v = np.sort(np.concatenate([v, (v[wide] + v[wide + 1]) / 2]))
    else:
        return False  # the path runs through -1 to within rounding: on the boundary
    return bool(abs(step.sum()) < pi / 2) and bool((g[0] * g[-1].conjugate()).real > 0)


def _turns(loop: Loop, scale: float) -> np.ndarray:
    """Return frequencies at every 0.3 rad of the delay's phase, as far as the loop matters."""
    count = 20_000
    if loop.dt is None:
        reach = scale * (abs(loop.num[0]) + 2) * 1e3
        return np.linspace(0, min(0.3 / loop.dead_time * count, reach), count)
    half = np.linspace(0, pi / 2, max(2, round(loop.dead_time / loop.dt * 20)), endpoint=False)
    return 2 / loop.dt * np.tan(half)
