"""A look at a loop that misses nothing and invents nothing: every root by itself, exactly.

For what a short look has missed: roots of the polynomials in q = v^2 that lie close together,
beside several modes at one frequency, and least values in a needle. It costs more than the others.
"""

from dataclasses import dataclass
from math import inf

from zoh.analysis.needles import slope
from zoh.analysis.sharp import as_v, closer
from zoh.analysis.squares import Below, Squares
from zoh.lti import signs
from zoh.lti.whole import Whole


@dataclass(frozen=True, slots=True, kw_only=True)
class Isolated:
    """The look at a loop whose polynomials hold the delay, too."""

    squares: Squares

    def unities(self) -> list[float]:
        """Return every v at which |L| passes 1, ascending."""
        return _places(self.squares.gain)

    def turns(self) -> list[float]:
        """Return every v at which L becomes real, ascending."""
        return _places(self.squares.turn)

    def drops(self) -> list[float]:
        """Return every v at which |T| passes ``level``, ascending."""
        return _places(self.squares.drop)

    def least(self, below: Below) -> tuple[float, float]:
        """Return (v, the ratio there) where |D + N|/|below| is least between the ends."""
        s = self.squares
        over = slope(s, below)
        seen = signs.odd_roots(over)
        every = [*seen, *[closer(over, q) for q in seen]]  # a needle may be narrower than was seen
        ratio, q = min([(s.ratio_at(q, below), q) for q in every], default=(inf, (0, 1)))
        return as_v(q), ratio


def _places(a: Whole) -> list[float]:
    return [as_v(q) for q in signs.odd_roots(a)]
