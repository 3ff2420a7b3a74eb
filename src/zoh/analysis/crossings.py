"""Where a function of frequency changes sign, and where it is least.

Roots of the squared polynomials say where to look; a grid that is dense around every pole,
zero and closed-loop pole looks once more; a sign change between neighbours is then a root, and
is closed in on with the function itself. Two roots nearer to each other than rounding can tell
apart (``_ONE``) count as one.
"""

from collections.abc import Callable, Iterable
from itertools import pairwise
from math import inf, pi

import numpy as np

from zoh.analysis.loop import Array, Loop
from zoh.errors import SpecError
from zoh.lti import poly

_LAST_BIT = 2.3e-16
_TWINS = 1e-9  # relative distance of points that look at the same place
_ONE = 1e-12  # relative distance of crossings that rounding cannot tell apart
_MOST = 200_000  # points on a dead time's turns; more turns than that are not a control loop
_VALLEYS = 500  # the lowest that are followed; a delay of 10 000 samples makes that many
# distances from a mode's frequency in units of its damping: near enough to see its peak, far
# enough to meet the decades grid
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
    low, high = max(size.min() / 100, 1e-300), min(size.max() * 100, 1e300)
    count = int(12 * (np.log10(high) - np.log10(low))) + 2
    around = np.abs(every.imag)[:, None] + np.abs(every.real)[:, None] * _AROUND
    v = np.concatenate([np.geomspace(low, high, count), around.ravel(), np.abs(every)])
    v = v[(v >= low * 1e-3) & (v <= high * 1e3)]
    return np.unique(np.concatenate([v, _delay_grid(loop, np.sort(v))]))


def _delay_grid(loop: Loop, v: Array) -> Array:
    """Return frequencies at every 0.2 rad of the delay's phase lag.

    A continuous dead time turns the loop for ever: it is followed while |L| is above a
    thousandth on the grid v (a half, where that would be too far), and two turns further.
    """
    if not loop.dead_time:
        return np.empty(0)
    if loop.dt is None:
        v = np.concatenate([v, v[-1] * np.geomspace(1.1, 1e6, 150)])  # |L| may fall slowly
        top, bottom = (np.abs(part) for part in loop.parts(v))
        turn = 0.2 / loop.dead_time
        for quiet in (1e-3, 0.5):
            loud = v[top > quiet * bottom]
            reach = (loud[-1] if loud.size else 0.0) + 4 * pi / loop.dead_time
            if reach <= _MOST * turn:
                return np.asarray(turn * np.arange(1, int(reach / turn) + 2), float)
        raise SpecError(
            "dead_time",
            f"must be at most {_MOST * 0.2 / reach:.4g} s for a loop as fast as this",
            loop.dead_time,
            "what turns that often is no control loop",
        )
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


def sign_changes(f: Callable[[float], float], v: Array, signs: Array) -> list[float]:
    """Return every root of f between neighbouring v whose signs differ, each root once."""
    v, signs = v[signs != 0], signs[signs != 0]
    flips = np.flatnonzero(signs[1:] != signs[:-1])
    return merged(bracketed(f, float(v[i]), float(v[i + 1])) for i in flips)


def bracketed(f: Callable[[float], float], a: float, b: float) -> float:
    """Return the root of f in [a, b], where f changes sign, to the last bit or two.

    Inverse quadratic steps where they are safe, halving where they are not.
    Source: T. R. Chandrupatla, A new hybrid quadratic/bisection algorithm for finding the zero
    of a nonlinear function without using derivatives, Adv. Eng. Software 28(3), 1997.

    >>> abs(bracketed(lambda x: x * x - 2, 0.0, 2.0) - 2**0.5) < 1e-15
    True
    """
    fa, fb = f(a), f(b)
    if fa == 0 or fb == 0 or (fa > 0) == (fb > 0):  # a sign lost to rounding: an end is the root
        return a if abs(fa) <= abs(fb) else b
    t = 0.5
    for _ in range(300):
        x = a + t * (b - a)
        fx = f(x)
        if (fx > 0) == (fa > 0):
            c, fc = a, fa
        else:
            c, fc, b, fb = b, fb, a, fa
        a, fa = x, fx
        best, least_f = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        smallest = _LAST_BIT * abs(best) / abs(b - c) if b != c else 1.0
        if smallest > 0.5 or least_f == 0:
            return best
        t = min(1 - smallest, max(smallest, _inverse_quadratic(a, fa, b, fb, c, fc)))
    return a


def _inverse_quadratic(a: float, fa: float, b: float, fb: float, c: float, fc: float) -> float:
    """Return the next step as a part of b - a: the interpolated one where it is safe, else 1/2."""
    xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
    if phi * phi < xi and (1 - phi) * (1 - phi) < 1 - xi:
        return fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
    return 0.5


def least(
    value: Callable[[float], float], slope: Callable[[float], float], v: Array, y: Array
) -> tuple[float, float]:
    """Return (v, minimum) of a function known as y at v, and between by its value and slope.

    Every valley of y is followed to where the slope changes sign: how deep one goes between its
    points, these do not tell.
    """
    y = np.where(np.isnan(y), inf, y)
    padded = np.concatenate([[inf], y, [inf]])
    valleys = np.flatnonzero((y <= padded[:-2]) & (y <= padded[2:]) & np.isfinite(y))
    valleys = valleys[np.argsort(y[valleys])][:_VALLEYS]
    lowest = int(np.argmin(y))
    best_v, best = float(v[lowest]), float(y[lowest])
    for i in valleys.tolist():
        here = float(v[i])
        step = -1 if slope(here) > 0 else 1
        side = i + step
        # points a rounding apart make a dent that is no valley: the slope is asked beyond them
        while 0 <= side < len(v) and abs(v[side] - here) <= _TWINS * here:
            side += step
        if not 0 <= side < len(v):
            continue
        a, b = sorted((here, float(v[side])))
        if not slope(a) <= 0 <= slope(b):
            continue
        found = bracketed(slope, a, b)
        if value(found) < best:
            best_v, best = found, value(found)
    return best_v, best


def merged(found: Iterable[float]) -> list[float]:
    """Return the roots ascending, each once: two brackets may close in on the same one."""
    ordered = sorted(found)
    kept = ordered[:1]
    for a, b in pairwise(ordered):
        if b > a * (1 + _ONE):
            kept.append(b)
    return kept
