"""A look at a loop with a delay from close by, for what a sparse one may have missed.

The grid is dense around every pole, zero and closed-loop pole, near every root of the
polynomials in v^2 and along every turn of a delay. A sign change between neighbours is closed
in on with the loop itself, and every valley of a ratio is followed to its bottom.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, pi

import numpy as np

from zoh.analysis.axis import scalar
from zoh.analysis.crossings import least, merged, sign_changes
from zoh.analysis.endless import around_the_fall, followed
from zoh.analysis.loop import Array, ComplexArray, Loop
from zoh.analysis.sharp import sharpened
from zoh.analysis.squares import Below, Squares, corners
from zoh.analysis.undamped import without_undamped
from zoh.lti import poly, whole
from zoh.lti.whole import Whole

_FLAT = 1e-12  # |L| - 1 that may be rounding
# distances from a mode's frequency in units of its damping: near enough to see its peak, far
# enough to meet the decades grid
_AROUND = np.array([-30.0, -10, -4, -2, -1, -0.5, -0.2, 0, 0.2, 0.5, 1, 2, 4, 10, 30])


@dataclass(frozen=True, slots=True, kw_only=True)
class Close:
    """A loop at frequencies v, rad/s on its axis, ascending.

    top, bottom  num, the delay in it, and den there
    reach        up to where L is followed around its turns: a continuous dead time turns what is
                 left of the loop for ever
    further      from where to where it is followed beyond that
    """

    loop: Loop
    squares: Squares
    v: Array
    top: ComplexArray
    bottom: ComplexArray
    reach: float
    further: Sequence[tuple[float, float]] = ()

    @classmethod
    def of(cls, loop: Loop, squares: Squares) -> "Close":
        """Return the look; raise SpecError for a dead time that turns too often."""
        signed = (squares.gain, squares.turn, squares.drop)
        roots = [_suspects(a) for a in signed]
        marks = _landmarks(loop, [2.0 ** (x / 2) for x in corners(signed)])
        turns, *further = _delay_grid(loop, squares, marks)
        endless = bool(loop.dead_time) and loop.dt is None
        reach = float(turns[-1]) if endless else inf
        fall = around_the_fall(loop, squares, reach) if endless else np.empty(0)
        v = np.unique(np.concatenate([marks, turns, *further, fall, *roots]))
        v = v[np.isfinite(v) & (v > 0)]
        top, bottom = loop.parts(v)
        return cls(
            loop=loop, squares=squares, v=v, top=top, bottom=bottom, reach=reach,
            further=[(float(x[0]), float(x[-1])) for x in further],
        )  # fmt: skip

    def unities(self) -> list[float]:
        """Return every v at which |L| = 1, ascending."""
        over = np.abs(self.top) - np.abs(self.bottom)
        for i in np.flatnonzero(np.abs(over) < _FLAT * np.abs(self.bottom)):
            over[i] = self.squares.over_bottom(self.squares.gain, float(self.v[i]))
        return _sharpened(self.squares.gain, sign_changes(self._excess, self.v, np.sign(over)))

    def _excess(self, v: float) -> float:
        """Return |L| - 1, from the exact polynomials where floats do not tell it from 0."""
        bottom = abs(scalar(self.loop.den, v))
        if bottom and abs(over := self.loop.excess(v) / bottom) >= _FLAT:
            return over
        return self.squares.over_bottom(self.squares.gain, v) / 2

    def turns(self) -> list[float]:
        """Return every v up to ``reach``, and in what is ``further``, at which L is real.

        Where a polynomial tells, an undamped pole or zero is one of its roots and is among them.
        """
        loop, top, bottom = self.loop, self.top, self.bottom
        if not self.squares.whole and (left := without_undamped(loop)[0]) is not loop:
            loop, (top, bottom) = left, left.parts(self.v)
        signs = np.sign((top * np.conj(bottom)).imag)
        found: list[float] = []
        for low, high in ((0.0, self.reach), *self.further):
            seen = (low <= self.v) & (self.v <= high)
            found += sign_changes(loop.side, self.v[seen], signs[seen])
        found = merged(found)
        return _sharpened(self.squares.turn, found) if self.squares.whole else found

    def drops(self) -> list[float]:
        """Return every v at which |T| passes the level at which the bandwidth ends, ascending."""
        level = self.squares.level
        if not level:
            return []
        signs = np.sign(np.abs(self.top) - level * np.abs(self.bottom + self.top))
        found = sign_changes(lambda v: self.loop.above(v, level), self.v, signs)
        return _sharpened(self.squares.drop, found) if self.squares.whole else found

    def lowest(self, below: Below) -> float:
        """Return the v at which |den + num|/|below| is least."""
        on_bottom, on_top = below

        def slope(v: float) -> float:
            top, bottom, dtop, dbottom = self.loop.slopes(v)
            above, under = bottom + top, on_bottom * bottom + on_top * top
            if above == 0 or under == 0:
                return 0.0
            dunder = on_bottom * dbottom + on_top * dtop
            return ((dbottom + dtop) / above).real - (dunder / under).real

        def ratio(v: float) -> float:
            return self.squares.ratio(v, below) if self.squares.whole else self.loop.ratio(v, below)

        under = np.abs(on_bottom * self.bottom + on_top * self.top)
        return least(ratio, slope, self.v, np.abs(self.bottom + self.top) / under)


def _sharpened(a: Whole, found: Sequence[float]) -> list[float]:
    """Return the roots of a that were found, to a float's last digits, each once."""
    return merged([sharpened(a, v) for v in found])


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
    q = poly.roots(whole.floats(a, octaves, whole.size(a, octaves)))
    q = q[np.isfinite(q) & (np.abs(q) > 0) & (q.real > -0.1 * np.abs(q))]
    half, odd = divmod(octaves, 2)  # the root is within a float where q may not be
    v = np.sqrt(np.concatenate([np.abs(q), np.abs(q.real)]) * 2.0**odd) * 2.0**half
    v = v[v > 0]
    return np.concatenate([v, v * (1 - 1e-7), v * (1 + 1e-7)])


def _landmarks(loop: Loop, turning: Sequence[float] = ()) -> Array:
    """Return frequencies v > 0, ascending, between which the loop does nothing sudden.

    turning  v at which its polynomials turn from one power to the next, beside its modes
    """
    modes = [poly.roots(a) for a in (loop.num, loop.den, loop.closed(), loop.closed(-1.0))]
    every = np.concatenate(modes)
    size = np.append(np.abs(every), turning)
    size = size[(size > 0) & np.isfinite(size)]
    if loop.dt is not None:
        size = np.append(size, 2 / loop.dt)
    if loop.dead_time:
        size = np.append(size, 1 / loop.dead_time)
    if not size.size:
        size = np.array([1.0])
    low, high = max(size.min() / 100, 1e-307), min(size.max() * 100, 1e300)
    count = int(12 * (np.log10(high) - np.log10(low))) + 2
    v = np.concatenate([np.geomspace(low, high, count), around(every)])
    return np.unique(v[(v >= low * 1e-3) & (v <= high * 1e3)])


def around(modes: ComplexArray) -> Array:
    """Return frequencies at and around that of every pole or zero, and its size.

    >>> around(np.array([-0.1 + 2j]))[6:9]
    array([1.98, 2.  , 2.02])
    """
    beside = np.abs(modes.imag)[:, None] + np.abs(modes.real)[:, None] * _AROUND
    return np.concatenate([beside.ravel(), np.abs(modes)])


def _delay_grid(loop: Loop, squares: Squares, v: Array) -> list[Array]:
    """Return frequencies at every 0.2 rad of the delay's phase lag, a continuous one's as far as
    ``followed`` on the grid v.
    """
    if not loop.dead_time:
        return [np.empty(0)]
    if loop.dt is None:
        return followed(loop, squares, v)
    turns = loop.dead_time / loop.dt
    half = np.arange(1, int(turns * pi / 0.2) + 2) * 0.1 / turns
    return [np.asarray(2 / loop.dt * np.tan(half[half < pi / 2]), float)]
