"""The least value of |D + N| against |D|, |N| or |D - N| where it is all but 0, exact.

A float of v near the lowest point is then not near enough, and a float of a sum of coefficients
is a rounding of what they are.
"""

from collections.abc import Sequence

from zoh.analysis.loop import Loop
from zoh.analysis.sharp import as_v, closed_in
from zoh.analysis.squares import Below, Squares
from zoh.lti import divisors, signs, whole

_A_ROUNDING = 1e-14  # relative, of the ratio of two sums


def runs_through(squares: Squares) -> bool:
    """Return whether L is -1 somewhere, exactly.

    |D + N|^2 is 0 where it has a root, and so has its slope, for it is nowhere below 0; a root that
    it shares with |D|^2 is a mode that L hides.
    """
    above, bottom = squares.closed, squares.bottom
    if divisors.share_nothing(above, whole.derivative(above)):
        return False
    return signs.positive_roots(whole.times(above, bottom)) > signs.positive_roots(bottom)


def deepest(squares: Squares, places: Sequence[float], below: Below) -> tuple[float, float]:
    """Return (v, the ratio there) at the lowest of the points where it is least beside places.

    places  v, first where the ratio seems to be least: that is returned if none is lower
    """
    if runs_through(squares):  # where L is real, it passes -1 if it does at all
        return min(places, key=lambda v: squares.ratio(v, below)), 0.0
    over = slope(squares, below)
    seen = squares.ratio(places[0], below)
    ratio, q = min((squares.ratio_at(q, below), q) for q in [closed_in(over, v) for v in places])
    return (as_v(q), ratio) if ratio < seen * (1 - _A_ROUNDING) else (places[0], seen)


def slope(squares: Squares, below: Below) -> list[int]:
    """Return P'Q - PQ', the slope of the ratio's square P/Q times Q^2."""
    above, under = squares.closed, squares.below(below)
    rising = whole.times(whole.derivative(above), under)
    return whole.plus(rising, whole.times(above, whole.derivative(under)), -1)


def ratio_at_end(loop: Loop, v: float, below: Below) -> float:
    """Return the ratio at an end of the axis, v = 0 or infinity, one of ``Loop.ends``."""
    top, bottom = next((t, b) for end, t, b in loop.ends() if end == v)
    n, d = loop.exact_end(v)
    n, d = abs(n) * (1 if top > 0 else -1), abs(d) * (1 if bottom > 0 else -1)
    return abs(d + n) / abs(round(below[0]) * d + round(below[1]) * n)
