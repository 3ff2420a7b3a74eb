"""Where a quotient of two polynomials in q is least, of many loops at once: a peak's place.

The sensitivities' peaks are the least of |num + den|^2/|below|^2 over q = v^2 in [0, inf]. One is
proved by what is left of |num + den|^2 - m |below|^2 without its double root, which is above 0 for
every q > 0 if m is the least.

Beside an undamped pole |den|^2 is what rounding left of a double root, below 0 as often as above
it, and a quotient by that is nothing. So a square counts where it is above its own rounding; below
it the quotient there is at least that by the rounding.
"""

import numpy as np

from zoh.batch.arrays import rows
from zoh.batch.arrays.roots import closed_in, positive_roots
from zoh.batch.arrays.rows import Array, Mask
from zoh.batch.tolerances import DOUBLE, GRID

_HALF = 0.5 * np.log(GRID[1] / GRID[0])  # of the distance of two points in log q
_FLAT = 1e-6  # of q: a Newton's step as small as this leaves its square, and a/b the square of that
_MISSED = 1e-10  # of the least value: where a glance saw one lower by more, a root was missed


def lowest(a: Array, below: list[Array]) -> tuple[Array, Mask]:
    """Return (v where a/b is least over q = v^2 in [0, inf], whether that is in doubt), a row a b.

    below  several b, done at once
    """
    shape = (len(below), a.shape[1])
    points = GRID[:, None]
    over = rows.at(a, points)
    low, high, near = np.concatenate([_about(over / rows.at(b, points)) for b in below], axis=1)
    a, b = np.tile(a, len(below)), np.concatenate(below, axis=1)
    slope = _slope(a, b)
    q, inside = _flat(slope, low, high, near)
    value = _firm(a, q) / _firm(b, q)
    v = np.sqrt(q)
    for end, here in ((0.0, a[0] / b[0]), (np.inf, a[-1] / b[-1])):
        lower = here <= value * (1 + 1e-14)
        v, value = np.where(lower, end, v), np.where(lower, here, value)
    proved = (inside | (v == 0) | np.isinf(v)) & _nothing_below(a - value * b, v * v)
    (open_,) = np.nonzero(~proved)
    doubt = np.zeros(len(v), bool)
    if len(open_):
        v[open_], least, doubt[open_] = _by_slopes(*(rows.taken(c, open_) for c in (a, b, slope)))
        doubt[open_] |= value[open_] < least * (1 - _MISSED)
    return v.reshape(shape), doubt.reshape(shape)


def _about(ratio: Array) -> tuple[Array, Array, Array]:
    """Return the points of the grid beside the least, and where a parabola in log q has its own."""
    best = np.clip(np.argmin(ratio, axis=0), 1, len(GRID) - 2)
    before, here, after = (
        np.take_along_axis(ratio, (best + i)[None, :], axis=0)[0] for i in (-1, 0, 1)
    )
    bend = before + after - 2 * here
    t = np.where(bend > 0, _HALF * (before - after) / bend, 0.0)
    return GRID[best - 1], GRID[best + 1], GRID[best] * np.exp(np.clip(t, -2 * _HALF, 2 * _HALF))


def _flat(slope: Array, low: Array, high: Array, q: Array) -> tuple[Array, Mask]:
    """Return (where the slope becomes positive in (low, high), whether it does).

    Half the digits of it are enough, as a/b is flat there; the last of Newton's steps has more.
    """
    inside = (rows.at(slope, low) < 0) & (rows.at(slope, high) > 0)
    (who,) = np.nonzero(inside)
    out = q.copy()
    out[who] = closed_in(rows.taken(slope, who), low[who], high[who], q[who], last=_FLAT)
    return out, inside


def _slope(a: Array, b: Array) -> Array:
    """Return a' b - a b', of the sign of the slope of a/b; its highest power drops out."""
    return (rows.times(rows.derivative(a), b) - rows.times(a, rows.derivative(b)))[:-1]


def _nothing_below(rest: Array, q: Array) -> Mask:
    """Return whether ``rest`` without its double root at q is above 0 for every q > 0."""
    inner = (q > 0) & np.isfinite(q)
    divided = rest
    for _ in range(2):
        divided = _without(divided, q)
    divided = np.where(inner, divided, _shorter(rest, q))
    count = rows.changes(divided)
    proved: Mask = np.equal(count, 0)
    above = np.sum(divided, axis=0) > 0  # at q = 1: with no root it is so everywhere
    (maybe,) = np.nonzero((count > 0) & (count % 2 == 0))
    if len(maybe):
        roots, doubt = positive_roots(rows.taken(divided, maybe))
        proved[maybe] = ~np.isfinite(roots).any(axis=0) & ~doubt
    return np.asarray(proved & above)


def _firm(a: Array, q: Array) -> Array:
    """Return the value at q of a square, NaN where rounding may have made its first digits."""
    value = rows.at(a, q)
    return np.where(value > DOUBLE * rows.at(np.abs(a), q), value, np.nan)


def _without(a: Array, q: Array) -> Array:
    """Return a/(x - q), the remainder dropped, in as many rows as before (the last is 0).

    Coefficients above the term that is the largest at q from the top, those below it from the
    bottom: either way through, the rounding of what is large would be all of what is small.
    Source: G. Peters, J. H. Wilkinson, Practical problems arising in the solution of polynomial
    equations, J. Inst. Maths Applics 8, 1971 (composite deflation).
    """
    n = len(a) - 1
    down, up = np.zeros_like(a), np.zeros_like(a)
    carry, carried = np.zeros(a.shape[1]), np.zeros(a.shape[1])
    with np.errstate(all="ignore"):  # where q is 0 or no number what is made is not taken
        part = 1 / q
        for k in range(n, 0, -1):
            carry = a[k] + q * carry
            down[k - 1] = carry
            carried = (carried - a[n - k]) * part
            up[n - k] = carried
        sizes, power = np.abs(a), q
        for size in sizes[1:]:
            size *= power
            power = power * q
    return np.where(np.arange(n + 1)[:, None] < np.argmax(sizes, axis=0), up, down)


def _shorter(rest: Array, q: Array) -> Array:
    """Return ``rest`` with the coefficient that its least at an end has made 0 left out."""
    out = rest.copy()
    out[0] = np.where(q == 0, 0.0, out[0])
    out[-1] = np.where(np.isinf(q), 0.0, out[-1])
    return out


def _by_slopes(a: Array, b: Array, slope: Array) -> tuple[Array, Array, Mask]:
    """Return (v where a/b is least, a/b there, whether in doubt), every flat place of it tried."""
    size = np.max(np.abs(slope), axis=0)
    q, doubt = positive_roots(slope / np.where(size > 0, size, 1.0))
    there = np.isfinite(q)
    inner = np.where(there, q, 1.0)
    over, under = _firm(a, inner), _firm(b, inner)
    firm = np.isfinite(under) & np.isfinite(over)
    over = np.where(np.isfinite(over), over, 0.0)
    under = np.where(np.isfinite(under), under, DOUBLE * rows.at(np.abs(b), inner))
    value = np.where(there, over / under, np.inf)
    value = np.concatenate([value, [a[0] / b[0], a[-1] / b[-1]]])
    places = np.concatenate([q, np.zeros((1, a.shape[1])), np.full((1, a.shape[1]), np.inf)])
    value = np.where(np.isnan(value), np.inf, value)
    best = np.argmin(value, axis=0)[None, :]
    v, least = (np.take_along_axis(x, best, axis=0)[0] for x in (np.sqrt(places), value))
    firm = np.concatenate([firm, np.ones((2, a.shape[1]), bool)])
    return v, least, doubt | ~np.take_along_axis(firm, best, axis=0)[0]
