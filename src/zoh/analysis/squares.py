"""A loop on its frequency axis as real polynomials in q = v^2, exact.

With N = num(jv), D = den(jv) and whole samples of delay multiplied into both, everything that
is measured is a sign or a ratio of polynomials in q::

    |D|^2,    |N|^2,    |D +- N|^2 = |D|^2 + |N|^2 +- 2 Re(N conj D),    T = Im(N conj D)/v

    |L| = 1 where |N|^2 = |D|^2,    L is real where T = 0

Their coefficients are whole numbers, the floats of the loop taken exactly; floats of them are
rounded once. They are computed as one whole number each, see ``whole.packed_on_axis``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, sqrt

from zoh.analysis.loop import Loop
from zoh.lti import whole
from zoh.lti.whole import Whole, packed_on_axis, unpacked

DROP = 10**-0.3  # -3 dB of |T|^2: where the bandwidth ends
_OVER, _UNIT = DROP.as_integer_ratio()
_LEVEL = sqrt(DROP)
SHORT = 6  # samples of delay that are multiplied in: more of them cost more than a grid does
LONG = 12  # samples of delay that are multiplied in where a grid has proved too little

Below = tuple[float, float]  # what |D + N| is measured against: |b D + a N| as (b, a)
ON_DEN: Below = (1.0, 0.0)
ON_NUM: Below = (0.0, 1.0)
ON_OPPOSITE: Below = (1.0, -1.0)


@dataclass(slots=True, kw_only=True)
class Squares:
    """The polynomials of a loop in q = v^2, all of them times one power of two.

    bottom, top, closed, opposite  |D|^2, |N|^2, |D + N|^2 and |D - N|^2
    gain   |N|^2 - |D|^2, above 0 where |L| > 1
    turn   T, with the sign of Im L
    drop   |N|^2 - level^2 |D + N|^2, above 0 where |T| is above level, 3 dB below its value at
           w = 0; level is 0, and drop says nothing, where T is 0 or infinite there
    whole  whether a delay, if there is one, is in them; else only gain, bottom and top hold
    """

    bottom: Whole
    top: Whole
    closed: Whole
    opposite: Whole
    gain: Whole
    turn: Whole
    drop: Whole
    level: float
    whole: bool

    @classmethod
    def of(cls, loop: Loop, most: int = SHORT) -> "Squares":
        """Return the polynomials of a loop, up to ``most`` samples of delay multiplied in."""
        num, den = loop.exact
        m = 0
        if loop.dead_time and loop.dt is not None:
            m = round(loop.dead_time / loop.dt)
            if m <= most:
                half, one = (loop.dt / 2).as_integer_ratio()
                for _ in range(m):
                    num, den = whole.times((-half, one), num), whole.times((half, one), den)
        length = max(len(num), 2)
        # no sum of so many products, twice that, has more bits than this
        bits = 2 * max(map(int.bit_length, (*num, *den))) + length.bit_length() + 4
        (ne, no), (de, do) = packed_on_axis(num, bits), packed_on_axis(den, bits)
        bottom, top = de * de + (do * do << bits), ne * ne + (no * no << bits)
        both, cross = bottom + top, 2 * (ne * de + (no * do << bits))
        above, closed = unpacked(top, bits, length), unpacked(both + cross, bits, length)
        drop, level = _drop(above, closed)
        return cls(
            bottom=unpacked(bottom, bits, length),
            top=above,
            closed=closed,
            opposite=unpacked(both - cross, bits, length),
            gain=unpacked(top - bottom, bits, length),
            turn=unpacked(no * de - ne * do, bits, length - 1),
            drop=drop,
            level=level,
            whole=not loop.dead_time or 0 < m <= most,
        )

    def below(self, which: Below) -> Whole:
        """Return |D|^2, |N|^2 or |D - N|^2."""
        if which == ON_DEN:
            return self.bottom
        return self.top if which == ON_NUM else self.opposite

    def ratio(self, v: float, which: Below) -> float:
        """Return |D + N| over |D|, |N| or |D - N| at v, of the exact values there."""
        return self.ratio_at(squared(v), which)

    def ratio_at(self, q: tuple[int, int], which: Below) -> float:
        """Return the same where v^2 is a fraction whose bottom is a power of two."""
        above, under = whole.at_fraction(self.closed, *q), whole.at_fraction(self.below(which), *q)
        return whole.root_of_ratio(above, under) if under else inf

    @property
    def cross(self) -> Whole:
        """Return 2 Re(N conj D)."""
        return whole.plus(whole.plus(self.closed, self.bottom, -1), self.top, -1)

    def factor(self, q: tuple[int, int]) -> float:
        """Return -1/L of the exact values where v^2 is a fraction and L is real; inf over 0."""
        under = whole.at_fraction(self.cross, *q)
        return -2 * whole.at_fraction(self.bottom, *q) / under if under else inf

    def direction(self, q: tuple[int, int]) -> complex:
        """Return a number that points as N conj D does, of the exact values there."""
        re = whole.at_fraction(self.cross, *q)
        im = 2 * whole.at_fraction(self.turn, *q) * q[1]
        down = max(re.bit_length(), im.bit_length())
        unit = 1 << down
        return complex(re / unit, im / unit * whole.root_of_ratio(*q))

    def over_bottom(self, a: Whole, v: float, octaves: int = 0) -> float:
        """Return a/(|D|^2 2^octaves) at v, of the exact values: |L|^2 - 1 where a is ``gain``."""
        q = squared(v)
        under = whole.at_fraction(self.bottom, *q) << octaves
        return whole.at_fraction(a, *q) / under if under else inf


def size(a: Whole) -> list[int]:
    """Return |a(jv)|^2 as a polynomial in q = v^2.

    >>> size((1, 2, 3))  # (3 - q)^2 + 4 q
    [1, -2, 9]
    """
    even, odd = whole.on_axis(a)
    return whole.plus(whole.times(even, even), [*whole.times(odd, odd), 0])


def squared(v: float) -> tuple[int, int]:
    """Return v^2 as a fraction, of the float where that has all its digits.

    >>> squared(1.5)
    (9, 4)
    """
    if 1e-290 < (q := v * v) < inf:
        return q.as_integer_ratio()
    top, bottom = v.as_integer_ratio()
    return top * top, bottom * bottom


def _drop(top: Whole, closed: Whole) -> tuple[Whole, float]:
    """Return (drop, level) of |T|^2 = top/closed."""
    at_rest = next(filter(any, zip(top[::-1], closed[::-1], strict=True)))
    if not all(at_rest):
        return [0], 0.0
    over, unit = _OVER * at_rest[0], _UNIT * at_rest[1]
    drop = [unit * t - over * c for t, c in zip(top, closed, strict=True)]
    return drop, _LEVEL * whole.root_of_ratio(*at_rest)


def corners(polynomials: Sequence[Whole]) -> list[float]:
    """Return log2 of about where the roots of the polynomials lie, by Newton's polygon.

    >>> corners([(1, 0, 4)])  # |roots| = 2
    [1.0]
    """
    found: list[float] = []
    for a in polynomials:
        hull: list[tuple[int, int]] = []
        slopes: list[float] = []  # from each point of the hull to the next
        for i, c in enumerate(a):
            if not c:
                continue
            y = c.bit_length()
            while hull:
                left, low = hull[-1]
                slope = (y - low) / (i - left)
                if not slopes or slope < slopes[-1]:
                    slopes.append(slope)
                    break
                hull.pop()  # it lies on or below the line between its neighbours
                slopes.pop()
            hull.append((i, y))
        found += slopes
    return found
