"""Where a function of frequency changes sign, and where it is least.

A sign change between two neighbours on a grid is a root, and is closed in on with the function
itself. Two roots nearer to each other than rounding can tell apart (``_ONE``) count as one.
"""

from collections.abc import Callable, Iterable
from itertools import pairwise
from math import inf

import numpy as np

from zoh.analysis.loop import Array

_LAST_BIT = 2.3e-16
_TWINS = 1e-9  # relative distance of points that look at the same place
_ONE = 1e-12  # relative distance of crossings that rounding cannot tell apart
_VALLEYS = 500  # the lowest that are followed; a delay of 10 000 samples makes that many
_GOLDEN = (5**0.5 - 1) / 2
_FLAT = 1e-11  # relative; a minimum is flat, and its slope has no more digits to find it by


def sign_changes(f: Callable[[float], float], v: Array, signs: Array) -> list[float]:
    """Return every root of f between neighbouring v whose signs differ, each root once."""
    v, signs = _signed(f, v, signs)
    flips = np.flatnonzero(signs[1:] != signs[:-1])
    return merged(bracketed(f, float(v[i]), float(v[i + 1])) for i in flips)


def _signed(f: Callable[[float], float], v: Array, signs: Array) -> tuple[Array, Array]:
    """Return the points at which f is not 0, and beside one where it is, if its neighbours agree.

    There f may touch 0, or pass it and come back before the next point: its sign beside tells.
    """
    between = (signs[1:-1] == 0) & (signs[:-2] * signs[2:] > 0)
    if between.any():
        on_it = v[1:-1][between]
        beside = np.concatenate([on_it * (1 - _TWINS), on_it * (1 + _TWINS)])
        v = np.concatenate([v, beside])
        signs = np.concatenate([signs, np.sign([f(x) for x in beside.tolist()])])
        order = v.argsort()
        v, signs = v[order], signs[order]
    return v[signs != 0], signs[signs != 0]


def bracketed(f: Callable[[float], float], a: float, b: float, within: float = _LAST_BIT) -> float:
    """Return the root of f in [a, b], where f changes sign, to ``within`` of it.

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
        smallest = within * abs(best) / abs(b - c) if b != c else 1.0
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
) -> float:
    """Return where a function known as y at v, and between by its value and slope, is least.

    Every valley of y is followed to where the slope changes sign: how deep one goes between its
    points, these do not tell.
    """
    y = np.where(y >= 0, y, inf)  # no number is no valley
    lowest = int(y.argmin())
    best_v, best = float(v[lowest]), float(y[lowest])
    for i in _valleys(y)[:_VALLEYS]:
        here = float(v[i])
        step = -1 if slope(here) > 0 else 1
        side = i + step
        # points a rounding apart make a dent that is no valley: the slope is asked beyond them
        while 0 <= side < len(v) and abs(v[side] - here) <= _TWINS * here:
            side += step
        if not 0 <= side < len(v):
            continue
        found = bracketed(slope, here, float(v[side]), _FLAT)
        if value(found) < best:
            best_v, best = found, value(found)
    return best_v


def _valleys(y: Array) -> list[int]:
    """Return where y is lowest among its neighbours, the deepest first."""
    padded = np.concatenate([[inf], y, [inf]])
    found = np.flatnonzero((y <= padded[:-2]) & (y <= padded[2:]) & np.isfinite(y))
    return list(found[np.argsort(y[found])].tolist())


def valley(f: Callable[[float], float], a: float, b: float) -> tuple[float, float]:
    """Return (x, f(x)) at the minimum between a and b, x to the half of a float's digits."""
    c, d = b - _GOLDEN * (b - a), a + _GOLDEN * (b - a)
    fc, fd = f(c), f(d)
    while b - a > 1e-8 * b:  # f is flat there: nearer, it changes by rounding only
        if fc < fd:
            b, d, fd = d, c, fc
            c = b - _GOLDEN * (b - a)
            fc = f(c)
        else:
            a, c, fc = c, d, fd
            d = a + _GOLDEN * (b - a)
            fd = f(d)
    return (c, fc) if fc < fd else (d, fd)


def merged(found: Iterable[float]) -> list[float]:
    """Return the roots ascending, each once: two brackets may close in on the same one."""
    ordered = sorted(found)
    kept = ordered[:1]
    for a, b in pairwise(ordered):
        if b > a * (1 + _ONE):
            kept.append(b)
    return kept
