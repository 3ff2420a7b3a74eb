"""What a picture of a loop is made of: where to look, and on which branch the phase is."""

from math import floor, log10, pi

import numpy as np
import numpy.typing as npt

from zoh.lti.poly import Poly, roots, trim
from zoh.lti.systems import Plant, Sampled
from zoh.lti.wplane import unwarp, warp

Array = npt.NDArray[np.float64]

_POINTS = 600


def frequencies(system: Plant | Sampled, low: float, high: float) -> Array:
    """Return rad/s from ``low`` to ``high``; a sampled system ends just below Nyquist's.

    Even on a logarithmic scale of w, and for a sampled system on one of v as well, so that
    the last stretch before Nyquist's frequency, where v runs away, is as smooth as the rest.
    """
    if isinstance(system, Plant):
        return np.geomspace(low, high, _POINTS)
    nyquist = pi / system.dt
    top = min(high, nyquist * (1 - 1e-9))
    in_w = np.geomspace(low, top, _POINTS)
    in_v = np.geomspace(warp(low, system.dt), warp(top, system.dt), _POINTS)
    both = np.concatenate([in_w, [unwarp(float(v), system.dt) for v in in_v]])
    return np.unique(np.clip(both, low, top))


def lowest(system: Plant | Sampled, *marks: float | None) -> float:
    """Return a power of ten, rad/s, a decade below every corner and every mark.

    >>> lowest(Plant(num=[1], den=[1, 0.5, 0]), 3.0)
    0.01
    """
    corners = [abs(r) for r in np.concatenate([_corners(p) for p in _fraction(system)])]
    known = [c for c in [*corners, *marks] if c]
    least = min(known, default=1.0)
    if isinstance(system, Sampled):
        least = min(least, 1 / system.dt)
    return float(10.0 ** floor(log10(least) - 1))


def phase_deg(system: Plant | Sampled, w: Array) -> Array:
    """Return the phase in degrees, unwrapped, on the branch that low frequencies are on.

    An integrator starts at -90 deg and two at -180, whatever follows: poles and zeros choose
    the branch, one term each, and the response itself gives the value.

    >>> phase_deg(Plant(num=[1], den=[1, 0, 0, 0]), np.array([0.1]))
    array([-270.])
    """
    num, den = _fraction(system)
    if isinstance(system, Plant):
        x, delay = w, system.dead_time
    else:
        x, delay = 2 / system.dt * np.tan(w * system.dt / 2), system.dt * system.delay
    about = np.degrees(_terms(num, x) - _terms(den, x) - w * delay)
    if _lowest_coefficient(num) * _lowest_coefficient(den) * _sensor(system) < 0:
        about = about - 180
    exact = np.degrees(np.angle(system.at(w)))
    return np.asarray(exact + 360 * np.round((about - exact) / 360))


def _fraction(system: Plant | Sampled) -> tuple[Poly, Poly]:
    if isinstance(system, Plant):
        return system.num, system.den
    return trim(system.num_w), trim(system.den_w)


def _sensor(system: Plant | Sampled) -> float:
    return system.sensor if isinstance(system, Plant) else 1.0


def _lowest_coefficient(a: Poly) -> float:
    return next(c for c in reversed(a) if c)


def _corners(a: Poly) -> npt.NDArray[np.complex128]:
    found = roots(a)
    return np.asarray(found[found != 0])


def _terms(a: Poly, x: Array) -> Array:
    """Return the sum of the phases of j x per root at 0 and of 1 - j x/r per other root, rad.

    1 - j x/r leaves 1 on a straight line that never meets the negative axis: no wrapping.
    """
    corners = _corners(a)
    total = np.full(x.shape, (len(a) - 1 - len(corners)) * pi / 2)
    for r in corners:
        total = total + np.angle(1 - 1j * x / r)
    return total
