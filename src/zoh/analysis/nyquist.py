"""What a search asks of a loop: is it stable, and which crossing is the nearest to -1?

Both follow from where |L| passes through 1, and there no delay has a say. Between two such places
L is all the way inside the unit circle, or outside: 1 + L there turns by less than half a turn, or
1 + 1/L does, and num and den turn with their roots. So the encirclements of -1 are counted without
a point between. In floats: a design that a search finds is measured anew, and proved.
Source: H. Nyquist, Regeneration theory, Bell System Technical Journal 11, 1932; the count on the
frequency axis is Mikhailov's.
"""

from cmath import phase
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from math import atan, copysign, inf, nan, pi, remainder, tau

from zoh.analysis.loop import Loop
from zoh.analysis.margin_crossings import gain_crossings, touches
from zoh.analysis.margins import glance, nearest, within_floats
from zoh.analysis.proof import counted
from zoh.analysis.sharp import as_v
from zoh.analysis.sparse import Sparse
from zoh.analysis.squares import Squares
from zoh.analysis.stability import LONGEST, SHORT, decided
from zoh.lti import poly, signs

_ON_THE_AXIS = 1e-9  # of a root is its real part: which side it is on is rounding
_AT_THE_LIMIT = 1e-13  # rad from -1 at a crossing; of num and den, what their sum is at an end
_UNPROVED = 1e-4  # the same; nearer, a long delay may leave no proof
_WHOLE = 1e-3  # of a count; half a turn is 1


@within_floats
def closed_loop_stable(loop: Loop) -> bool:
    """Return whether 1 + L is known to have all its zeros strictly inside the stable region.

    A zero on the boundary is not stable. Shared factors of num and den count: a hidden mode
    that is unstable makes the loop unstable. What a hold has rounded is taken as it stands:
    ``stability.surely_stable`` asks further, and a search need not.

    >>> from zoh.lti.systems import Plant
    >>> late = [Plant(num=[gain], den=[1, 0], dead_time=1.0) for gain in (1.57, 1.58)]  # pi/2
    >>> [closed_loop_stable(Loop.of(plant)) for plant in late]
    [True, False]
    """
    found, samples = None, round(loop.dead_time / loop.dt) if loop.dt else LONGEST + 1
    if loop.dead_time and samples > SHORT:
        with suppress(OverflowError):
            found = none_encircled(loop)
        if found and samples > LONGEST and _is_hard_to_prove(loop):
            found = None
    return decided(loop)[0] is True if found is None else found


@within_floats
def nearest_crossing(loop: Loop) -> tuple[float | None, float]:
    """Return the crossover and the phase margin in deg of the crossing nearest to -1.

    They are those of ``margins``; where there is no crossing they are None and inf.
    """
    squares, passed = _passed(loop)
    if not any(squares.gain):  # |L| is 1 everywhere: what counts is where L is -1
        found = glance(loop)
        return found.crossover, found.phase_margin_deg
    return nearest(gain_crossings(loop, squares, list(passed), [], []))


def none_encircled(loop: Loop) -> bool | None:
    """Return whether den + num exp(-j psi) has no zero on the right or, but for rounding, on the
    axis; None where floats do not tell.

    Over (jv + r)^n it goes to a constant, and from v = 0 to infinity its argument changes by -pi
    for each zero on the right. Where |L| < 1 it turns as den (1 + L), elsewhere as
    num exp(-j psi) (1 + 1/L), the second factors from half of L's angle, or of 1/L's, to half.
    """
    squares, passed = _passed(loop)
    if (loop.dt is None and loop.num[0]) or not any(squares.gain):
        return None  # it turns for ever, or is nowhere on one side of 1
    angles = [_angle(loop, v) for v in passed]
    if _nearness(loop) < _AT_THE_LIMIT:
        return False
    loud = next(c for c in reversed(squares.gain) if c) > 0
    turned = 0.0
    ends = zip((0.0, *passed, inf), (0.0, *angles, 0.0), strict=True)
    for (low, angle), (high, next_angle) in pairwise(ends):
        half = (next_angle - angle) / 2
        if loud:
            late = float(loop.psi(high) - loop.psi(low))
            turned += _turn(loop.num, low, high) - half - late
        else:
            turned += _turn(loop.den, low, high) + half
        loud = not loud
    zeros = (len(loop.den) - 1) / 2 - turned / pi
    return abs(zeros) < _WHOLE if abs(remainder(zeros, 1.0)) < _WHOLE else None


@lru_cache(maxsize=8)
def _passed(loop: Loop) -> tuple[Squares, Sequence[float]]:
    """Return the squares of a loop without its delay, and every v where |L| passes through 1.

    Of |L| these are the whole, whatever the delay.
    """
    squares = Squares.of(loop, most=0)
    look = Sparse.of(loop, replace(squares, whole=True))
    found = look.unities() if look else []
    if not counted(squares.gain, found).holds:
        found = [as_v(q) for q in signs.odd_roots(squares.gain)]
    return squares, tuple(found)


def _nearness(loop: Loop) -> float:
    """Return how near L comes to -1 where |L| is 1, in rad, and at the ends of the axis.

    At an end it is what is left of den + num there, in parts of both; 0 where both are 0.
    """
    if loop.num[-1] == loop.den[-1] == 0 or loop.num[0] == loop.den[0] == 0:
        return 0.0
    squares, passed = _passed(loop)
    places = [*passed, *map(as_v, touches(loop, squares.gain, passed))]
    angles = [pi - abs(_angle(loop, v)) for v in places]
    sums = [abs(top + bottom) / (abs(top) + abs(bottom)) for _, top, bottom in loop.ends()]
    return min(*angles, *sums)


def _is_hard_to_prove(loop: Loop) -> bool:
    """Return whether L comes so near to -1, or at an end |L| to 1, that ``decided`` is to be asked.

    A long delay turns what is all but 1 by any angle.
    """
    sizes = [(abs(top), abs(bottom)) for _, top, bottom in loop.ends()]
    return min(_nearness(loop), *[abs(x - y) / (x + y) for x, y in sizes]) < _UNPROVED


def _angle(loop: Loop, v: float) -> float:
    """Return the angle of L in rad, from -pi to pi."""
    top, bottom = loop.point(v)
    return remainder(phase(top) - phase(bottom), tau)


def _turn(a: Sequence[float], low: float, high: float) -> float:
    """Return by how much a(jv) turns from v = low to high, in rad; nan where a root says not.

    >>> _turn((1.0, 1.0), 0.0, 1.0) == -_turn((1.0, -1.0), 0.0, 1.0) == pi / 4
    True
    >>> _turn((1.0, 0.0, 1.0), 0.0, 2.0)  # through j: either way
    nan
    """
    turned = 0.0
    for root in poly.roots(a).tolist():
        x, y = root.real, root.imag
        if abs(x) > _ON_THE_AXIS * abs(root):
            turned -= copysign(atan((high - y) / abs(x)) - atan((low - y) / abs(x)), x)
        elif low < y < high:
            return nan
    return turned
