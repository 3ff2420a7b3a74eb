"""Where a function of frequency changes sign or turns, with none missed.

Roots of the squared polynomials say where to look; a grid that is dense around every pole,
zero and closed-loop pole looks once more; a sign change between neighbours is then a root, and
is closed in on with the function itself. No tolerance decides whether a root is there.
"""

from collections.abc import Callable, Iterable
from itertools import pairwise
from math import inf, isfinite, pi, sqrt

import numpy as np
import numpy.typing as npt

from zoh.analysis.loop import Loop
from zoh.lti import poly

Array = npt.NDArray[np.float64]

# distances from a mode's frequency in units of its damping: near enough to see its peak, far
# enough to meet the decades grid
_ONE = 1e-12  # relative distance of crossings that rounding cannot tell apart
_MOST = 200_000  # points on a dead time's turns; more turns than that are not a control loop
_AROUND = np.array([-30.0, -10, -4, -2, -1, -0.5, -0.2, 0, 0.2, 0.5, 1, 2, 4, 10, 30])


def landmarks(loop: Loop) -> Array:
    """Return frequencies v > 0, ascending, between which the loop does nothing sudden."""
    modes = [poly.roots(a) for a in (loop.num, loop.den, loop.closed(), loop.closed(-1.0))]
    every = np.concatenate(modes)
    size = np.abs(every)
    size = size[(size > 0) & np.isfinite(size)]
    if loop.dt is not None:
        size = np.append(size, 2 / loop.dt)
    if loop.dead_time:
        size = np.append(size, 1 / loop.dead_time)
    if not size.size:
        size = np.array([1.0])
    low, high = size.min() / 100, size.max() * 100
    count = int(12 * np.log10(high / low)) + 2
    around = np.abs(every.imag)[:, None] + np.abs(every.real)[:, None] * _AROUND
    v = np.concatenate([np.geomspace(low, high, count), around.ravel(), np.abs(every)])
    v = v[(v >= low * 1e-3) & (v <= high * 1e3)]
    return np.unique(np.concatenate([v, _delay_grid(loop, np.sort(v))]))


def _delay_grid(loop: Loop, v: Array) -> Array:
    """Return frequencies at every 0.2 rad of the delay's phase lag.

    A continuous dead time turns the loop for ever: it is followed while |L| is above a
    thousandth on the grid v, and two turns further.
    """
    if not loop.dead_time:
        return np.empty(0)
    if loop.dt is None:
        top, bottom = np.abs(loop.parts(v))
        loud = v[top > 1e-3 * bottom]
        reach = (loud[-1] if loud.size else 0.0) + 4 * pi / loop.dead_time
        turn = 0.2 / loop.dead_time
        return np.asarray(turn * np.arange(1, min(_MOST, int(reach / turn)) + 2), float)
    turns = loop.dead_time / loop.dt
    half = np.arange(1, int(turns * pi / 0.2) + 2) * 0.1 / turns
    return np.asarray(2 / loop.dt * np.tan(half[half < pi / 2]), float)


def suspects(a: poly.Poly) -> Array:
    """Return v = sqrt(q) near every positive root q of a polynomial in q, and around each.

    A close pair of real roots may come out complex; its middle is then between the two, and so
    is asked too.
    """
    q = poly.roots(a)
    q = q[np.isfinite(q) & (np.abs(q) > 0) & (q.real > -0.1 * np.abs(q))]
    v = np.sqrt(np.concatenate([np.abs(q), np.abs(q.real)]))
    v = v[v > 0]
    return np.concatenate([v, v * (1 - 1e-7), v * (1 + 1e-7)])


def sign_changes(
    f: Callable[[float], float], on: Callable[[Array], Array], points: Iterable[Array]
) -> list[float]:
    """Return every v at which f changes sign between neighbouring points.

    f takes a number, ``on`` does the same for an array of points.
    """
    v = np.unique(np.concatenate(list(points)))
    v = v[np.isfinite(v) & (v > 0)]
    sign = np.sign(on(v))
    v, sign = v[sign != 0], sign[sign != 0]
    return [
        bracketed(f, float(v[i]), float(v[i + 1])) for i in np.flatnonzero(sign[1:] != sign[:-1])
    ]


def bracketed(f: Callable[[float], float], a: float, b: float) -> float:
    """Return the root of f in [a, b], where f changes sign, to the last bit.

    Secant steps kept inside the bracket (the Illinois rule), halved where they stall.
    """
    fa, fb = f(a), f(b)
    if fa == 0 or fb == 0 or (fa > 0) == (fb > 0):  # a sign lost to rounding: an end is the root
        return a if abs(fa) <= abs(fb) else b
    for _ in range(200):
        width = b - a
        c = b - fb * width / (fb - fa)
        if not a < c < b:
            c = a + width / 2
            if not a < c < b:
                break
        fc = f(c)
        if fc == 0:
            return c
        if (fc > 0) == (fb > 0):
            b, fb, fa = c, fc, fa / 2
        else:
            a, fa, fb = c, fc, fb / 2
        if b - a > width * 0.9:
            middle = sqrt(a * b) if a > 0 else (a + b) / 2
            if a < middle < b:
                fm = f(middle)
                if (fm > 0) == (fb > 0):
                    b, fb = middle, fm
                else:
                    a, fa = middle, fm
    return (a + b) / 2


def least(
    value: Callable[[Array], Array], slope: Callable[[float], float], points: Array
) -> tuple[float, float]:
    """Return (v, minimum) of a function over the points and the valleys between them.

    ``slope`` is its derivative's sign: each valley on the grid is followed to its bottom.
    """
    y = value(points)
    y = np.where(np.isnan(y), inf, y)
    padded = np.concatenate([[inf], y, [inf]])
    valleys = np.flatnonzero((y <= padded[:-2]) & (y <= padded[2:]) & np.isfinite(y))
    floor = y.min() * 1.5 + 1e-300  # only valleys that could hold the least are worth following
    best_v, best = float(points[int(np.argmin(y))]), float(y.min())
    for i in valleys[y[valleys] <= floor]:
        a, b = float(points[max(i - 1, 0)]), float(points[min(i + 1, len(points) - 1)])
        sa, sb = slope(a), slope(b)
        if not (isfinite(sa) and isfinite(sb) and sa < 0 < sb):
            continue
        v = bracketed(slope, a, b)
        found = float(value(np.array([v]))[0])
        if found < best:
            best_v, best = v, found
    return best_v, best


def merged(found: Iterable[float]) -> list[float]:
    """Return the roots ascending, each once: two brackets may close in on the same one."""
    ordered = sorted(found)
    kept = ordered[:1]
    for a, b in pairwise(ordered):
        if b > a * (1 + _ONE):
            kept.append(b)
    return kept
