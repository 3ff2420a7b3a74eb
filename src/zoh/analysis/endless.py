"""How far a continuous dead time, which turns a loop for ever, has to be followed.

With R = num/den, |L| is |R|, and the turns of the delay bring L onto the negative real axis about
every 2 pi/dead_time. Where |R| neither is 1 nor has a stationary value any more, it moves
to its end on one side of 1. So it comes either ever nearer to 1, and its end is the nearest, or
goes away from it, and the first turn is. Whether that was far enough is proved: beyond it |R|^2
stays outside the band around 1 that the gain margin found leaves, in whole numbers.
"""

from cmath import phase
from fractions import Fraction
from math import inf, log, pi, tau

import numpy as np

from zoh.analysis.crossings import valley
from zoh.analysis.loop import Array, Loop
from zoh.analysis.sharp import as_v
from zoh.analysis.squares import ON_DEN, ON_NUM, Below, Squares, squared
from zoh.errors import SpecError
from zoh.lti import signs, whole
from zoh.lti.whole import Point, Whole

_QUIET = 1e-3  # |L| at a turn that is listed in any case: a factor of 1000
_LIKE_THE_END = 1.01  # times |L| at infinity: the turns from there on look alike
_MOST = 200_000  # points on a dead time's turns; more turns than that are not a control loop
_STEP = 0.2  # rad of the delay's phase from one point to the next
_FURTHER = 4 * pi  # rad, two turns
_SURELY = 0.999 * _MOST * _STEP  # rad up to the last that decides; with two turns more it is less
_CORRECTIONS = 4
GAIN_TOL = 1e-9  # relative; a turn that was not seen changes the gain margin by no more


def followed(loop: Loop, squares: Squares, v: Array) -> list[Array]:
    """Return frequencies at every 0.2 rad of a continuous dead time, as far as turns matter.

    First those from the beginning on, then those around what decides further off.

    That is while |L| is above a thousandth (of its largest value on the grid v, where that is
    below 1; a half, where that would be too far), and two turns further. Where |L| ends at more
    than that, the end is what every further turn is like. Up to the last that decides it is at
    least, or, where that would be too far, around it: two turns to both sides. A loop that is 1
    too far off is refused, but for one that is all but at its end before.
    """
    v = np.concatenate([v, v[-1] * np.geomspace(1.1, 1e6, 150)])  # |L| may fall slowly
    top, bottom = (np.abs(part) for part in loop.parts(v))
    size = top / bottom
    turn, further = _STEP / loop.dead_time, _FURTHER / loop.dead_time
    end = abs(loop.num[0] / loop.den[0])
    unities = [as_v(q) for q in signs.odd_roots(squares.gain)]
    deciding = sorted([*unities, *_turning_back(squares, size, end)])
    last = max(deciding, default=0.0)
    loud = [
        _last_passage(squares, max(quiet, _LIKE_THE_END * end))
        for quiet in (_QUIET * min(1.0, float(size.max())), 0.5)
    ]
    at_least = [*(loud if end else ()), max(unities, default=0.0)]
    for upto in (*(max(x, last) for x in loud), last, *at_least):
        reach = upto + further
        if reach <= _MOST * turn:
            grid = np.asarray(turn * np.arange(1, int(reach / turn) + 2), float)
            around = np.arange(-further, further, turn)
            return [grid, *(x + around for x in deciding if x > grid[-1])]
    raise SpecError(
        "dead_time",
        f"must be at most {_SURELY / min(at_least):.4g} s for a loop as fast as this",
        loop.dead_time,
        "what turns that often is no control loop",
    )


def around_the_fall(loop: Loop, squares: Squares, beyond: float) -> Array:
    """Return frequencies where |T| may first fall to ``level``, along three turns if beyond v.

    It is |L|/(1 + |L|) at least, where L > 0: above the level while |L| is above level/(1 - level),
    and below it beside one of the next two places, maybe for a small part of a turn.
    """
    if not 0 < squares.level < 1:
        return np.empty(0)
    first = min(_passages(squares, squares.level / (1 - squares.level)), default=0.0)
    if not first:
        return np.empty(0)
    place = _next_positive(loop, first)
    dips = [_dip(loop, v) for v in (place - tau / loop.dead_time, place)]
    if first <= beyond:
        return np.array(dips)
    turns = np.arange(-_FURTHER / 2, _FURTHER, _STEP) / loop.dead_time
    return np.concatenate([first + turns, dips])


def _dip(loop: Loop, v: float) -> float:
    """Return where |T| is least within 1 rad of v, counted from there: so it has its digits."""
    start = v - 1 / loop.dead_time

    def complementary(x: float) -> float:
        return 1 / loop.ratio(start + x, ON_NUM)

    return start + valley(complementary, 0.0, 2 / loop.dead_time)[0]


def _next_positive(loop: Loop, v: float) -> float:
    """Return the next v at which the delay has turned L onto the positive real axis, about.

    The phase of R moves little on the way.
    """
    top, bottom = loop.point(v)
    angle = phase(top * bottom.conjugate()) % tau
    for _ in range(_CORRECTIONS):
        v += angle / loop.dead_time
        top, bottom = loop.point(v)
        angle = phase(top * bottom.conjugate())
    return v


def _turning_back(squares: Squares, size: Array, end: float) -> list[float]:
    """Return every v where |L| is stationary and nearer to 1 than at its end.

    size  |L| on a grid; what is further from 1 by another factor of 2 does not count either
    """
    slope = whole.plus(
        whole.times(whole.derivative(squares.top), squares.bottom),
        whole.times(squares.top, whole.derivative(squares.bottom)), -1,
    )  # fmt: skip
    far = min(_off(end), min(map(_off, size.tolist()), default=inf) + log(2.0))
    return [as_v(q) for q in signs.odd_roots(slope) if _off(_size(squares, q)) < far]


def _last_passage(squares: Squares, level: float) -> float:
    """Return the last v at which |L| passes the level, 0 where it never does."""
    return max(_passages(squares, level), default=0.0)


def _passages(squares: Squares, level: float) -> list[float]:
    """Return every v at which |L| passes the level, each to its last digits."""
    top, bottom = (level * level).as_integer_ratio()
    over = whole.plus([bottom * c for c in squares.top], [top * c for c in squares.bottom], -1)
    return [as_v(q) for q in signs.odd_roots(over)]


def _size(squares: Squares, q: Point) -> float:
    """Return |L| where v^2 is a fraction."""
    top, bottom = (whole.at_fraction(a, *q) for a in (squares.top, squares.bottom))
    return whole.root_of_ratio(top, bottom) if bottom else inf


def _off(size: float) -> float:
    """Return how far |L| is from 1, by which factor either way."""
    return abs(log(size)) if 0 < size < inf else inf


def none_decides(squares: Squares, factor: float, beyond: float) -> bool:
    """Return whether |L| is nowhere beyond v nearer to 1 than a factor on it that was found.

    But for GAIN_TOL of it.
    """
    low = Fraction(min(factor, 1 / factor)) * (1 + Fraction(GAIN_TOL))
    return low >= 1 or (low > 0 and _outside(squares, low, 1 / low, beyond))


def keeps_above(squares: Squares, least: float, below: Below, beyond: float) -> bool:
    """Return whether |D + N| >= least |below| beyond v, whichever way a dead time turns L.

    With r = |L|, |1 + L| is |1 - r| at least, |1 + 1/L| is |1 - r|/r and |1 + L|/|1 - L| is
    |1 - r|/(1 + r).
    """
    m = Fraction(least)
    if below == ON_DEN:
        return _outside(squares, 1 - m, 1 + m, beyond)
    if below == ON_NUM:
        return _outside(squares, 1 / (1 + m), 1 / (1 - m) if m < 1 else None, beyond)
    return m < 1 and _outside(squares, (1 - m) / (1 + m), (1 + m) / (1 - m), beyond)


def _outside(squares: Squares, low: Fraction, high: Fraction | None, beyond: float) -> bool:
    """Return whether all of |L| beyond v is below ``low``, or all of it above ``high``.

    In q = v^2, seen from its value there: q (1 + t) for t > 0.
    """
    q = squared(beyond)

    def above(a: Whole, b: Whole, level: Fraction) -> bool:
        """Return whether a > level^2 b."""
        top, bottom = level.numerator**2, level.denominator**2
        over = whole.plus([bottom * c for c in a], [top * c for c in b], -1)
        return signs.positive(_from(over, q)) is not None

    quiet = low > 0 and above(squares.bottom, squares.top, 1 / low)
    return quiet or (high is not None and above(squares.top, squares.bottom, high))


def _from(a: Whole, q: Point) -> list[int]:
    """Return a(q (1 + t)) as a polynomial in t, times a positive number.

    >>> _from((1, -3), (2, 1))  # 2 (1 + t) - 3
    [2, -1]
    """
    n, (top, bottom) = len(a) - 1, q
    return whole.shifted([c * top ** (n - i) * bottom**i for i, c in enumerate(a)])
