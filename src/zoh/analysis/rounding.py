"""What the rounding of given coefficients has already cost.

z-coefficients are floats, and at a small dt everything is in their last digits. If each may be
off by half a unit of its last place, |c| 2^-53, then num(z) may be off by 2^-53 sum |c| and L by
a part rho of itself, which moves a crossing by rho over the slope of the gain or the phase
there. That is first order, and an upper bound: rounding seldom conspires.
Source: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., sec. 1.6 and 5.3
(condition of a polynomial's value in its coefficients).
"""

from collections.abc import Iterator
from math import degrees, hypot, inf, radians, tau

from zoh.analysis.loop import Loop
from zoh.analysis.results import Margins
from zoh.analysis.sharp import as_v
from zoh.analysis.squares import Squares
from zoh.lti import poly, signs, whole
from zoh.lti.poly import Poly
from zoh.lti.wplane import warp

LOST_DEG = 0.1  # a phase margin that may be off by this much is lost
LOST = 0.01  # relative, the same for a gain margin and for Ms
_HALF_A_UNIT = 2.0**-53
_SHORT = 2.0**32  # a coefficient of no more bits than that is meant as it stands
_ANY = 1e4  # beyond it a bound says nothing
_SLOW = 1e-7  # of Nyquist's frequency: nothing below it is asked for
_GRID = 60  # points on which stability is asked for
_ONE_PLACE = 1e-15  # relative; a root of two polynomials, each to 2^-71, as a float
_FEW_BITS = 4 * _HALF_A_UNIT  # of |L| in s: half a unit of num and of den, and as much

_WAYS_OUT = {
    "z-coefficients": "build the loop from its parameters (zoh.sample, Sampled.from_w) or sample "
    "more slowly",
    "gain": "the last digit of a parameter decides there: choose another gain or another dt",
    "coefficients": "give them so that |L| is 1, or is not, in the digits that you know",
}


def doubts(loop: Loop, m: Margins) -> tuple[str, ...]:
    """Return what rounding has done to the figures and to stability, if too much.

    Only z-coefficients that were given as such are doubted; those that zoh made from a plant
    stand beside their w-form, which is what is measured. In s and in z alike a crossing is
    doubted that the last bits make at an end of the axis, where L is near -1; near 1 it costs
    nothing, as in 0.1/(z - 0.9). So is one where |L| is greatest or least, and all but touches 1.
    """
    places = [
        v
        for v, top, bottom in loop.ends()
        if top * bottom < 0 and abs(abs(top / bottom) - 1) <= _in_doubt(loop, v)
    ]
    places += _all_but_touched(loop) if loop.exact_but_for_gains else []
    found = [f"|L| may pass through 1 beside {loop.frequency(v):.6g} rad/s or not" for v in places]
    found += _of_z(loop, m) if loop.rounded else []
    if not found:
        return ()
    kind = "coefficients" if loop.dt is None else _kind(loop)
    return (f"by the rounding of the given {kind} alone {', '.join(found)}: {_WAYS_OUT[kind]}",)


def _kind(loop: Loop) -> str:
    """Return what was given: a gain beside what zoh made is a parameter, in z as in w."""
    only_gains = loop.made and all(len(s.den) == 1 for s in loop.rounded)
    return "gain" if only_gains else "z-coefficients"


def _in_doubt(loop: Loop, v: float) -> float:
    """Return how near to 1 |L| is in doubt where its slope is 0; below 0: never.

    What is 1 exactly is meant to be in s, where no more is known than the coefficients.
    """
    if loop.rounded:
        part = sum(_parts(loop, v))
        part += sum([s.off for s in loop.made]) if loop.exact_but_for_gains else 0.0
        return part if 0 < part < inf else -1.0
    at_an_end = v in (0.0, inf)
    return -1.0 if not loop.given or (at_an_end and loop.is_one_at(v)) else _FEW_BITS


def _all_but_touched(loop: Loop) -> list[float]:
    """Return every v at which |L| is greatest or least, and all but 1, of given coefficients."""
    squares = Squares.of(loop, most=0)
    if signs.variations(squares.gain) < 2:
        return []
    top, bottom = squares.top, squares.bottom
    rising = whole.times(whole.derivative(top), bottom)
    slope = whole.plus(rising, whole.times(top, whole.derivative(bottom)), -1)
    touched = [as_v(q) for q in signs.even_roots(squares.gain)]
    extremes = [as_v(q) for q in signs.odd_roots(slope)]
    return [
        v
        for v in extremes
        if abs(squares.over_bottom(squares.gain, v)) / 2 <= _in_doubt(loop, v)
        and not any(abs(v - place) <= _ONE_PLACE * v for place in touched)
    ]


def _of_z(loop: Loop, m: Margins) -> list[str]:
    """Return what the rounding of the z-coefficients has done."""
    found = []
    pm = 0.0 if m.crossover is None else _phase_shift(loop, m.crossover)
    if pm > LOST_DEG:
        found.append(f"the phase margin may be off by {_shown(pm)} deg")
    gain = 0.0 if m.phase_crossover is None else _gain_shift(loop, m.phase_crossover)
    if gain > LOST:
        found.append(f"the gain margin may be off by {_shown(100 * gain)} %")
    for name, off in _relative(loop, m):
        if off > LOST:
            found.append(f"{name} may be off by {_shown(100 * off)} %")
    ends = (_moved(loop, *end) for end in loop.ends())
    if max(*(_of_return(loop, w) for w in _frequencies(loop, m)), *ends) >= 1:
        found.append("stability may be lost or won")
    return found


def _relative(loop: Loop, m: Margins) -> Iterator[tuple[str, float]]:
    """Yield by which part of themselves rounding moves the other figures that there are."""
    if m.modulus_margin:
        yield "Ms", _of_return(loop, m.ms_frequency)
    if m.mt < inf:
        yield "Mt", _of_complementary(loop, _place(loop, m.mt_frequency))
    if m.disk_margin:
        yield "the disk margin", _of_disk(loop, _place(loop, m.disk_frequency))
    yield "the delay margin", _delay_shift(loop, m)
    if m.bandwidth is not None:
        yield "the bandwidth", _bandwidth_shift(loop, m.bandwidth)


def _place(loop: Loop, w: float) -> tuple[float, complex, complex]:
    """Return (v, num, den) at w in rad/s, both ends included."""
    for v, top, bottom in loop.ends():
        if w == loop.frequency(v):
            return v, top, bottom
    v = warp(w, loop.dt or 0.0)
    return v, *loop.point(v)


def _of_complementary(loop: Loop, place: tuple[float, complex, complex]) -> float:
    """Return by which part of itself rounding moves T: dT/T = S dL/L."""
    v, top, bottom = place
    if not bottom:  # T is 1 whatever L is
        return 0.0
    return sum(_parts(loop, v)) * _over(abs(bottom), abs(bottom + top))


def _of_disk(loop: Loop, place: tuple[float, complex, complex]) -> float:
    """Return by which part of itself rounding moves (1 + L)/(1 - L): 2 L/(1 - L^2) times dL/L."""
    v, top, bottom = place
    if not (top and bottom):  # it is 1 or -1
        return 0.0
    closed, opposite = abs(bottom + top), abs(bottom - top)
    return 2 * sum(_parts(loop, v)) * _over(abs(top), closed) * _over(abs(bottom), opposite)


def _delay_shift(loop: Loop, m: Margins) -> float:
    """Return by which part rounding moves the least delay: its phase, and its crossover."""
    for w, pm_deg in m.gain_crossings:
        if w < _SLOW * _nyquist(loop):  # a delay of millions of samples is none to rely on
            continue
        turn = radians(pm_deg) % tau
        if turn and abs(turn / w - m.delay_margin) <= 1e-9 * m.delay_margin:  # it is this one
            part, gain_slope, _ = _sensitivity(loop, w)
            v = warp(w, loop.dt or 0.0)
            return radians(_phase_shift(loop, w)) / turn + _over(part, abs(gain_slope) * v)
    return 0.0


def _bandwidth_shift(loop: Loop, w: float) -> float:
    """Return by which part rounding moves where |T| is 3 dB below what it is at w = 0."""
    v = warp(w, loop.dt or 0.0)
    top, bottom, dtop, dbottom = loop.slopes(v)
    slope = (dtop / top - (dtop + dbottom) / (top + bottom)).real
    off = _of_complementary(loop, (v, top, bottom)) + _of_complementary(loop, loop.ends()[0])
    return _over(off, abs(slope) * v)


def _over(a: float, b: float) -> float:
    return a / b if b else inf if a else 0.0


def _phase_shift(loop: Loop, w: float) -> float:
    """Return how many deg rounding moves the phase margin of the crossover at w."""
    part, gain_slope, phase_slope = _sensitivity(loop, w)
    return degrees(part * (1 + (abs(phase_slope / gain_slope) if gain_slope else inf)))


def _gain_shift(loop: Loop, w: float) -> float:
    """Return by which part rounding moves the gain margin of the phase crossing at w."""
    part, gain_slope, phase_slope = _sensitivity(loop, w)
    if w <= 0 or w >= _nyquist(loop):  # there L is real whatever it is: the crossing stays
        return part
    return part * (1 + (abs(gain_slope / phase_slope) if phase_slope else inf))


def _sensitivity(loop: Loop, w: float) -> tuple[float, float, float]:
    """Return (rho, d ln|L|/dv, d arg L/dv) at w in rad/s."""
    v = warp(w, loop.dt or 0.0)
    top, bottom, dtop, dbottom = loop.slopes(v)
    slope = dtop / top - dbottom / bottom if top and bottom else complex(inf, inf)
    return sum(_parts(loop, v)), slope.real, slope.imag


def _of_return(loop: Loop, w: float) -> float:
    """Return by which part of itself rounding moves den + num at w in rad/s."""
    if w >= _nyquist(loop):
        w = _nyquist(loop) * (1 - 1e-9)
    v = warp(w, loop.dt or 0.0)
    return _moved(loop, v, *loop.point(v))


def _moved(loop: Loop, v: float, top: complex, bottom: complex) -> float:
    """Return by which part of itself rounding moves den + num at v, these being den and num."""
    of_top, of_bottom = _parts(loop, v)
    return_difference = abs(bottom + top)
    # what is 0 at an end stays small beside the other
    moved = (abs(top) * of_top if top else 0.0) + (abs(bottom) * of_bottom if bottom else 0.0)
    return _over(moved, return_difference)


def _parts(loop: Loop, v: float) -> tuple[float, float]:
    """Return by which parts of themselves rounding moves num and den at v."""
    of_top = of_bottom = 0.0
    for system in loop.rounded:
        size = hypot(1.0, v * system.dt / 2)
        x, y = (complex(0.0, v / size), 1 / size) if v < inf else (2j / system.dt, 0.0)
        of_top += _part(system.num, abs(poly.homogeneous(system.num_w, x, y)))
        of_bottom += _part(system.den, abs(poly.homogeneous(system.den_w, x, y)))
    return of_top, of_bottom


def _part(a: Poly, value: float) -> float:
    """Return half a unit of each coefficient over |a(z)| = |a_w(jv)|/|1 - jv dt/2|^n."""
    off = _HALF_A_UNIT * sum(abs(c) for c in a if not _exact(c))
    return off / value if value else inf if off else 0.0


def _exact(c: float) -> bool:
    """Return whether a coefficient has so few digits that it is meant as it stands: 1, -2, 0.5.

    >>> _exact(-2.0), _exact(0.1)
    (True, False)
    """
    top = abs(c.as_integer_ratio()[0])
    return top < _SHORT * (top & -top)  # without the zeros it ends in


def _frequencies(loop: Loop, m: Margins) -> Iterator[float]:
    """Return where stability is asked for: crossings, peaks, seven decades below Nyquist's."""
    yield from (m.ms_frequency, m.mt_frequency, m.disk_frequency)
    yield from (w for w, _ in (*m.gain_crossings, *m.phase_crossings))
    top = _nyquist(loop)
    for k in range(_GRID):
        yield top * _SLOW ** (k / (_GRID - 1))


def _nyquist(loop: Loop) -> float:
    return loop.frequency(inf)


def _shown(x: float) -> str:
    """Return an error bound in a few digits.

    >>> _shown(0.1234), _shown(99.7), _shown(1234.0), _shown(inf)
    ('0.12', '100', '1234', 'any number of')
    """
    return "any number of" if x > _ANY else f"{x:.0f}" if x >= 99.5 else f"{x:.2g}"
