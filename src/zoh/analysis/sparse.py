"""A first look at a loop: few points, on which its exact polynomials in q = v^2 are evaluated.

The grid reaches from below the first corner of the polynomials to beyond the last one. Between
two points of different sign lies a root, followed by Newton's method on the polynomial; beside
the lowest point of a ratio P/Q lies its least value, where P'Q = PQ'. A look as short as this
can miss something: whether it has, ``proof`` says.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import pairwise
from math import ceil, floor, inf, isfinite, sqrt

import numpy as np

from zoh.analysis.loop import Array, Loop
from zoh.analysis.newton import parabola, part, root, stationary
from zoh.analysis.sharp import sharpened
from zoh.analysis.squares import ON_DEN, ON_NUM, ON_OPPOSITE, Below, Squares, corners
from zoh.lti import whole
from zoh.lti.whole import Whole

_BEYOND = 7  # octaves in q that are looked at beyond the first and the last corner
_PER_OCTAVE = 2
_NEAR = 1e-7  # relative distance of the two points of a last secant: half a float's digits
_AGREE = 1e-11  # relative; the loop and its polynomial tell of one root to a float's digits
_LOST = 1e-9  # of the values beside it: one so small has no sign in floats, a root is there
_STEPS = 3  # of the secant, each with 7 digits more
_UNDER = (ON_DEN, ON_NUM, ON_OPPOSITE)  # the first three rows; the others:
_CLOSED, _GAIN, _TURN, _DROP = range(3, 7)
_FINITE = 500  # octaves of the highest power: half of a float's, more than coefficients need
_NOTHING = 1e-300  # instead of 0, or of less by rounding


@dataclass(slots=True, kw_only=True)
class Sparse:
    """The polynomials of ``Squares`` in q/unit, as floats, and what they are on a grid.

    octaves    log2(q/unit), K of them
    values     shape (7, K)
    above      1 where one of the last three is above 0, else 0, row after row
    ratios     |D + N|^2 over |D|^2, |N|^2 and |D - N|^2, shape (3, K); lowest_at: where
    """

    loop: Loop
    squares: Squares
    unit: float
    polynomials: list[list[float]]
    octaves: Sequence[float]
    values: Array
    above: bytes
    ratios: Array
    lowest_at: list[int]

    @classmethod
    def of(cls, loop: Loop, s: Squares) -> "Sparse | None":
        """Return the look, None where polynomials do not tell or floats do not hold them."""
        if not s.whole:
            return None
        exact: Sequence[Whole] = (s.bottom, s.top, s.opposite, s.closed, s.gain, s.turn, s.drop)
        found = corners((s.bottom, s.closed, s.gain, s.turn, s.drop))
        low, high = floor(min(found, default=0.0)), ceil(max(found, default=0.0))
        middle = low + (high - low) // 2
        longest = len(s.bottom)
        # one power of two for those of which ratios are taken, and none of it underflows
        shared = max(whole.size(s.bottom, middle), whole.size(s.top, middle))
        sizes = [shared] * _TURN + [whole.size(s.turn, middle), whole.size(s.drop, middle)]
        rows = [
            [0.0] * (longest - len(a)) + whole.floats(a, middle, bits)
            for a, bits in zip(exact, sizes, strict=True)
        ]
        octaves, powers = _grid(high - low, longest)
        values = np.array(rows).dot(powers)
        if octaves[-1] * longest > _FINITE and not isfinite(values.sum()):
            return None
        ratios = values[_CLOSED] / np.maximum(values[:_CLOSED], _NOTHING)
        return cls(
            loop=loop, squares=s, unit=2.0**middle, polynomials=rows, octaves=octaves,
            values=values, above=(values[_GAIN:] > 0.0).tobytes(), ratios=ratios,
            lowest_at=ratios.argmin(axis=1).tolist(),
        )  # fmt: skip

    @property
    def reach(self) -> float:
        """Return up to where signs are followed: everywhere."""
        return inf

    def unities(self) -> list[float]:
        """Return every v seen at which |L| = 1, ascending."""
        s = self.squares
        return [_polished(self.loop.excess, v, s, s.gain) for v in self._roots(_GAIN)]

    def turns(self) -> list[float]:
        """Return every v seen at which L is real, ascending."""
        found, turn = self._roots(_TURN), self.squares.turn
        # a root alone is where terms of one sign cancel those of the other: that has its digits
        return found if len(found) < 2 else [sharpened(turn, v) for v in found]

    def drops(self) -> list[float]:
        """Return every v seen at which |T| passes ``level``, ascending."""
        s = self.squares
        above = partial(self.loop.above, level=s.level)
        return [_polished(above, v, s, s.drop) for v in self._roots(_DROP)]

    def lowest(self, below: Below) -> float:
        """Return the v seen at which |D + N|/|below| is least."""
        which = _UNDER.index(below)
        i = self.lowest_at[which]
        place = self.octaves[i]
        if 0 < i < len(self.octaves) - 1:
            start = place + parabola(*self.ratios[which, i - 1 : i + 2].tolist()) / _PER_OCTAVE
            ends = 2.0 ** (place - 1 / _PER_OCTAVE), 2.0 ** (place + 1 / _PER_OCTAVE)
            q = stationary(self.polynomials[_CLOSED], self.polynomials[which], 2.0**start, *ends)
        else:
            q = 2.0**place
        return sqrt(q) * sqrt(self.unit)

    def _roots(self, row: int) -> list[float]:
        polynomial, brackets, count = self.polynomials[row], [], len(self.octaves)
        above = self.above[(row - _GAIN) * count : (row - _GAIN + 1) * count]
        i = 0
        while (i := above.find(1 - above[i], i)) > 0:  # the next point of the other sign
            low, high = self.octaves[i - 1 : i + 1]
            at_low, at_high = self.values[row, i - 1 : i + 1].tolist()
            brackets.append([2.0**low, 2.0**high, at_low, at_high])
        for left, right in pairwise(brackets):
            if left[1] == right[0] and abs(left[3]) < _LOST * max(abs(left[2]), abs(right[3])):
                part(polynomial, left, right)
        return [sqrt(root(polynomial, *ends)) * sqrt(self.unit) for ends in brackets]


@lru_cache(maxsize=256)
def _grid(wide: int, length: int) -> tuple[tuple[float, ...], Array]:
    """Return (log2 of x, so many powers of x, descending) on a grid around corners so wide apart.

    wide  octaves from the first corner to the last; x is 1 in the middle between them

    >>> octaves, powers = _grid(2, 2)
    >>> octaves[::32], powers[:, 0].tolist()  # 7 octaves more on either side
    ((-8.0, 8.0), [0.00390625, 1.0])
    """
    count = (wide + 2 * _BEYOND) * _PER_OCTAVE + 1
    octaves = np.arange(count) / _PER_OCTAVE - (wide // 2 + _BEYOND)
    powers = np.exp2(np.arange(length - 1, -1, -1)[:, None] * octaves)
    powers.flags.writeable = False
    return tuple(octaves.tolist()), powers


def _polished(f: Callable[[float], float], v: float, squares: Squares, a: Whole) -> float:
    """Return v moved by one secant step onto a root of f, which the loop itself gives.

    Where the loop and the polynomial it came from do not agree, the one has lost digits, or the
    other: there |L| is all but flat, or the roots are close; a itself, exact, decides.
    """
    moved = _by_secant(f, v)
    if abs(moved - v) <= _AGREE * v:
        return moved
    longer = _bits(a) - _bits(squares.bottom)  # of ``drop``, whose unit is any number
    for _ in range(_STEPS):
        v = _by_secant(lambda x: squares.over_bottom(a, x, max(longer, 0)), v)
    return v


def _bits(a: Whole) -> int:
    return max(c.bit_length() for c in a)


def _by_secant(f: Callable[[float], float], v: float) -> float:
    """Return v moved by a secant step onto a root of f, or v where that is far."""
    near = v * (1 + _NEAR)
    here, there = f(v), f(near)
    moved = v - here / (there - here) * (near - v) if there != here else v
    return moved if abs(moved - v) < 1e-3 * v else v
