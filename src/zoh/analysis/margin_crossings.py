"""Where a loop crosses: |L| = 1 with its phase margin, L < 0 with the factor onto -1.

What was found along the axis is given; the ends of the axis, and where L touches instead of
passing, are looked at here. A loop is real at both ends, whatever it is, and a hold's rounding may
put |L| on either side of 1 there.
"""

from cmath import exp, phase
from collections.abc import Sequence
from math import degrees, frexp, inf, remainder, ulp
from operator import itemgetter

from zoh.analysis.axis import terms
from zoh.analysis.loop import Loop
from zoh.analysis.series import wholes
from zoh.analysis.sharp import EXACT, FINE, ROUNDED, as_v, closed_in, is_nothing, places
from zoh.analysis.squares import Squares, size
from zoh.lti import poly, signs
from zoh.lti.systems import Plant, Sampled
from zoh.lti.whole import Point, Whole

_TOUCHES = 4e-15  # |L| this near to 1 at an end of what a hold made is 1: a few roundings, and
_BLUR = 1e-6  # the crossing they make up this near to it (|L| is flat there) is none
_SHARP = 1e-3  # of its terms: num conj den below that is beside a root of num or den, and lacks
# the digits in floats, as does its place
_MEANT = 2.0**-EXACT  # of a coefficient: what is off by less says where a root is, as given ones do
_AT_A_ROOT = 1e-13  # of its terms: what num conj den is, in floats, at a root of num or den
_ROUNDINGS = 4  # of a frequency, from v and back
_SAME_DEG = 1e-5  # an angle found twice in exact arithmetic
_SMALL, _LARGE = 1e-100, 1e100  # sizes whose squares a float holds, with room for a ratio

Crossings = list[tuple[float, float]]


def margin_deg(gain: complex) -> float:
    """Return the angle from -180 deg to L, in (-180, 180], from L or what points as L does.

    >>> margin_deg(-1j), margin_deg(2 + 0j), margin_deg(complex(2, -0.0))
    (90.0, 180.0, 180.0)
    """
    angle = degrees(phase(-gain))
    return 180.0 if angle <= -180 else angle


def gain_crossings(
    loop: Loop, squares: Squares, unities: list[float], by_phase: Crossings, beside: list[float]
) -> Crossings:
    """Return (frequency, phase margin in deg) wherever |L| passes through 1 or touches it.

    v of those beside a root of num or den is added to ``beside``.
    """
    if not any(squares.gain):  # |L| is 1 everywhere: what counts is where L is -1
        return [(w, 0.0) for w, _ in by_phase]
    exactly = [*zip(unities, places(squares.gain, unities), strict=True)]
    exactly += [(as_v(q), q) for q in touches(loop, squares.gain, unities)]
    crossings = [_at_unity(loop, squares, v, beside, q) for v, q in exactly]
    for v, top, bottom in loop.ends():
        if not bottom or abs(abs(top / bottom) - 1) > _TOUCHES:
            continue
        w = loop.frequency(v)
        if not loop.given:
            crossings = [c for c in crossings if abs(c[0] - w) > _BLUR * _scale(loop)]
        elif not loop.is_one_at(v):
            continue
        if top / bottom < 0:
            crossings.append((w, 0.0))
    return sorted(crossings, key=itemgetter(0))  # two of one float as they come


def surely_crosses(loop: Loop, w: float, pm_deg: float) -> bool:
    """Return whether |L| passes 1 at w in rad/s with this phase margin, by exact arithmetic.

    For where the float w does not tell L: beside an undamped pole or zero.
    """
    loop = loop.finer()
    squares = Squares.of(loop)
    for q in signs.odd_roots(squares.gain, FINE):
        at, pm = _exactly_at_unity(loop, squares, q)
        turned = remainder(pm - pm_deg, 360.0)
        if abs(at - w) <= _ROUNDINGS * ulp(w) and abs(turned) <= _SAME_DEG:
            return True
    return False


def phase_crossings(
    loop: Loop, squares: Squares, unities: list[float], turns: list[float], beside: list[float]
) -> Crossings:
    """Return (frequency, factor on L that closes onto -1) wherever L is negative real.

    v of those beside a root of num or den is added to ``beside``.
    """
    if not loop.dead_time and not any(squares.turn):
        return _always_real(loop, squares, unities, beside)
    exactly = [*zip(turns, places(squares.turn, turns), strict=True)]
    if squares.whole:
        exactly += [(as_v(q), q) for q in touches(loop, squares.turn, turns)]
    found = [_at_turn(loop, squares, v, beside, q) for v, q in exactly]
    every = [c for c in found if c] + _at_the_ends(loop)
    return sorted([c for c in every if 0 < c[1] < inf])  # what a float holds


def touches(loop: Loop, a: Whole, passed: Sequence[float]) -> list[Point]:
    """Return every q = v^2 at which a polynomial is 0 and keeps its sign.

    Only of a loop all of whose coefficients are exact, but for gains: what a hold has rounded says
    of no two roots that they are one. Descartes' rule, with the roots where it passes, says mostly
    that there are none.
    """
    if not loop.exact_but_for_gains or signs.variations(a) < len(passed) + 2:
        return []
    return signs.even_roots(a)


def _at_unity(
    loop: Loop, squares: Squares, v: float, beside: list[float], place: Point | None
) -> tuple[float, float]:
    """Return (frequency, phase margin in deg) where |L| = 1.

    place  where that is in q, if v alone does not tell
    """
    (top, of_top), (bottom, of_bottom) = map(_within_floats, loop.point(v))
    product = top * bottom.conjugate()
    if abs(product) > _SHARP * _bulk(loop, v, of_top, of_bottom):
        return loop.frequency(v), margin_deg(product)
    beside.append(v)
    return _exactly_at_unity(loop, squares, place or closed_in(squares.gain, v))


def _exactly_at_unity(loop: Loop, squares: Squares, q: Point) -> tuple[float, float]:
    """Return (frequency, phase margin in deg) at a root of ``squares.gain``."""
    v, product = as_v(q), squares.direction(q)
    if not squares.whole:
        product *= exp(-1j * loop.psi(v))
    return loop.frequency(v), margin_deg(product)


def _at_turn(
    loop: Loop, squares: Squares, v: float, beside: list[float], place: Point | None
) -> tuple[float, float] | None:
    """Return (frequency, factor onto -1) where L is real, None where it is not below 0.

    place  where that is in q, if v alone does not tell
    """
    (top, of_top), (bottom, of_bottom) = map(_within_floats, loop.point(v))
    product = (top * bottom.conjugate()).real
    bulk = _bulk(loop, v, of_top, of_bottom)
    near = not abs(product) > _SHARP * bulk
    if near:
        beside.append(v)
    if near and squares.whole:
        q = place or closed_in(squares.turn, v)
        if any(_is_nothing_at(q, factor) for factor in loop.factors):
            return None  # L is 0 or infinite there
        return loop.frequency(as_v(q)), squares.factor(q)
    if not product < -_AT_A_ROOT * bulk:
        return None
    return loop.frequency(v), -_square(bottom) / product * (of_top / of_bottom)


def _is_nothing_at(q: Point, factor: Plant | Sampled) -> bool:
    """Return whether a factor of the loop is 0 or infinite there, as far as its digits tell."""
    meant = isinstance(factor, Plant) or factor.off < _MEANT
    num, den, *_ = wholes(factor)
    return any(is_nothing(size(a), q, EXACT if meant else ROUNDED) for a in (num, den))


def _at_the_ends(loop: Loop) -> Crossings:
    """Return the phase crossings at w = 0 and at the Nyquist frequency."""
    return [
        (loop.frequency(v), -bottom / top) for v, top, bottom in loop.ends() if top * bottom < 0
    ]


def _always_real(
    loop: Loop, squares: Squares, unities: list[float], beside: list[float]
) -> Crossings:
    """Return the phase crossings of a loop that is real at every frequency.

    Any gain inside its range then makes it marginal somewhere: where |L| is 1 the factor is 1.
    """
    found = [
        (w, 1.0)
        for w, pm in gain_crossings(loop, squares, unities, [], beside)
        if abs(pm) < 1e-9  # deg: at -1, not at +1
    ]
    return sorted({*found, *_at_the_ends(loop)})


def _square(x: complex) -> float:
    return x.real * x.real + x.imag * x.imag


def _scale(loop: Loop) -> float:
    """Return the least frequency in rad/s at which the loop does anything."""
    sizes = [abs(r) for r in (*poly.roots(loop.num), *poly.roots(loop.den)) if r]
    return loop.frequency(min(sizes))


def _bulk(loop: Loop, v: float, of_top: float, of_bottom: float) -> float:
    """Return what |num den| would be at v if nothing cancelled, each times its unit."""
    return terms(loop.num, v) * of_top * (terms(loop.den, v) * of_bottom)


def _within_floats(x: complex) -> tuple[complex, float]:
    """Return (x unit, unit), a power of two that keeps products of two such within a float."""
    size = abs(x)
    if _SMALL < size < _LARGE or not 0 < size < inf:
        return x, 1.0
    unit = 2.0 ** -frexp(size)[1]
    return x * unit, unit
