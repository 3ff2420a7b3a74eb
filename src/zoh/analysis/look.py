"""Where to look at a loop, and what is seen there.

The sparse look is a grid from beyond the first corner to beyond the last one, on which the
exact polynomials are evaluated: cheap, and enough where a proof says so. The close look is
dense around every pole, zero and closed-loop pole, near every root of the polynomials and along
every turn of a delay.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import inf, pi

import numpy as np

from zoh.analysis.loop import Array, Loop
from zoh.analysis.squares import ON_DEN, ON_NUM, Below, Squares, on_grid
from zoh.errors import SpecError
from zoh.lti import poly, whole
from zoh.lti.whole import Whole

_MOST = 200_000  # points on a dead time's turns; more turns than that are not a control loop
# distances from a mode's frequency in units of its damping: near enough to see its peak, far
# enough to meet the decades grid
_AROUND = np.array([-30.0, -10, -4, -2, -1, -0.5, -0.2, 0, 0.2, 0.5, 1, 2, 4, 10, 30])


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """A loop at frequencies v, rad/s on its axis, ascending.

    bottom, top, closed, opposite  |D|, |N|, |D + N| and |D - N| there, up to a common factor
    gain     the sign of |L| - 1
    turn     the sign of Im L; turning is a function of v with that sign. Beyond ``reach``, where
             a continuous dead time turns what is left of the loop for ever, it is 0
    drop     the sign of |T| less the level at which the bandwidth ends
    """

    v: Array
    bottom: Array
    top: Array
    closed: Array
    opposite: Array
    gain: Array
    turn: Array
    drop: Array
    turning: Callable[[float], float]
    reach: float = inf

    def ratio(self, below: Below) -> Array:
        """Return |D + N| over |D|, |N| or |D - N|."""
        if below == ON_DEN:
            return self.closed / self.bottom
        return self.closed / (self.top if below == ON_NUM else self.opposite)


def sparse(squares: Squares) -> Look | None:
    """Return the sparse look, None where polynomials do not tell or floats do not hold them."""
    if not squares.whole:
        return None
    s = squares
    v, values = on_grid((s.bottom, s.top, s.closed, s.opposite, s.gain, s.turn, s.drop))
    if not np.isfinite(values).all():
        return None
    bottom, top, closed, opposite = np.sqrt(np.maximum(values[:4], 0.0))
    gain, turn, drop = np.sign(values[4:])
    return Look(
        v=v, bottom=bottom, top=top, closed=closed, opposite=opposite, gain=gain, turn=turn,
        drop=drop, turning=_by_polynomial(s.turn),
    )  # fmt: skip


def close(loop: Loop, squares: Squares) -> Look:
    """Return the close look."""
    roots = [_suspects(a) for a in (squares.gain, squares.turn, squares.drop)]
    marks = _landmarks(loop)
    turns = _delay_grid(loop, marks)
    v = np.unique(np.concatenate([marks, turns, *roots]))
    v = v[np.isfinite(v) & (v > 0)]
    top, bottom = loop.parts(v)
    reach = float(turns[-1]) if loop.dead_time and loop.dt is None else inf
    turning: Callable[[float], float]
    if loop.dead_time:
        turning = partial(_side, loop)
        turn = np.where(v <= reach, (top * np.conj(bottom)).imag, 0.0)
    else:  # far from all corners the phase nears a multiple of 90 deg, and only this sign holds
        turning = _by_polynomial(squares.turn)
        turn = np.array([turning(x) for x in v.tolist()])
    closed = np.abs(bottom + top)
    return Look(
        v=v, bottom=np.abs(bottom), top=np.abs(top), closed=closed, opposite=np.abs(bottom - top),
        gain=np.sign(np.abs(top) - np.abs(bottom)), turn=np.sign(turn),
        drop=np.sign(np.abs(top) - squares.level * closed), turning=turning,
        reach=reach,
    )  # fmt: skip


def _side(loop: Loop, v: float) -> float:
    """Return Im(num conj den) at v, the delay in it."""
    top, bottom = loop.point(v)
    return (top * bottom.conjugate()).imag


def _by_polynomial(turn: Whole) -> Callable[[float], float]:
    """Return a function of v with the sign of the polynomial ``turn`` of v^2, in floats."""
    octaves = _middle(turn)
    scaled = whole.floats(turn, octaves, whole.size(turn, octaves))
    unit = 2.0**-octaves

    def turning(v: float) -> float:
        q = v * v * unit
        x, y = (q, 1.0) if q < 1 else (1.0, 1 / q)  # no power overflows
        value, power = scaled[0], y
        for c in scaled[1:]:
            value = value * x + c * power
            power *= y
        return value

    return turning


def _middle(a: Whole) -> int:
    """Return log2 of the scale that brings the ends of a polynomial together."""
    a = whole.trim(a)
    return (a[-1].bit_length() - a[0].bit_length()) // (len(a) - 1) if len(a) > 1 else 0


def _suspects(a: Whole) -> Array:
    """Return v = sqrt(q) near every positive root q of a polynomial in q, and around each.

    A close pair of real roots may come out complex; its middle is then between the two, and so
    is asked too.
    """
    octaves = _middle(a)
    q = poly.roots(whole.floats(a, octaves, whole.size(a, octaves))) * 2.0**octaves
    q = q[np.isfinite(q) & (np.abs(q) > 0) & (q.real > -0.1 * np.abs(q))]
    v = np.sqrt(np.concatenate([np.abs(q), np.abs(q.real)]))
    v = v[v > 0]
    return np.concatenate([v, v * (1 - 1e-7), v * (1 + 1e-7)])


def _landmarks(loop: Loop) -> Array:
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
    return np.unique(v[(v >= low * 1e-3) & (v <= high * 1e3)])


def _delay_grid(loop: Loop, v: Array) -> Array:
    """Return frequencies at every 0.2 rad of the delay's phase lag.

    A continuous dead time turns the loop for ever: it is followed while |L| is above a
    thousandth on the grid v (of its largest value, where that is below 1; a half, where that
    would be too far), and two turns further.
    """
    if not loop.dead_time:
        return np.empty(0)
    if loop.dt is None:
        v = np.concatenate([v, v[-1] * np.geomspace(1.1, 1e6, 150)])  # |L| may fall slowly
        top, bottom = (np.abs(part) for part in loop.parts(v))
        turn, loudest = 0.2 / loop.dead_time, float((top / bottom).max())
        for quiet in (1e-3 * min(1.0, loudest), 0.5):
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
