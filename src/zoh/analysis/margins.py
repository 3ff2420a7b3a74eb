"""The margins of a loop, every crossing counted, z = 1 and z = -1 included.

Gain crossings are sign changes of |num|^2 - |den|^2, phase crossings those of
Im(num conj den) where the real part is negative; on the axis both are polynomials in
q = v^2, v = (2/dt) tan(w dt/2) for a sampled loop and v = w for a continuous one.
Source: K. J. Astrom and R. M. Murray, Feedback Systems, 2nd ed., sec. 10.3 and 13.2 (margins,
sensitivity peaks); P. Seiler, A. Packard, P. Gahinet, An Introduction to Disk Margins, IEEE
Control Systems 40(5), 2020, eq. (5) with sigma = 0.
"""

from cmath import phase
from dataclasses import dataclass
from math import comb, degrees, inf, isnan, log, radians, tau

import numpy as np

from zoh.analysis.crossings import landmarks, least, sign_changes, suspects
from zoh.analysis.loop import Array, ComplexArray, Loop, scalar
from zoh.analysis.results import Margins
from zoh.analysis.stability import closed_loop_stable
from zoh.analysis.tabled.margins import table_margins
from zoh.errors import SpecError
from zoh.lti import poly
from zoh.lti.frequency_response import FrequencyResponse, TabledLoop
from zoh.lti.poly import Poly
from zoh.lti.systems import Plant, Sampled

_EXPANDED = 12  # samples of delay multiplied into a polynomial to find its roots
_TOUCHES = 4e-15  # |L| this near to 1 at an end of the axis is 1: a few roundings, and
_AT_A_ROOT = 1e-13  # of its terms: what num conj den is, in floats, at a root of num or den
_BLUR = 1e-6  # the crossing they make up this near to it (|L| is flat there) is none


def margins(loop: Plant | Sampled | FrequencyResponse | TabledLoop) -> Margins:
    """Return the margins of ``loop``, the open loop of a unity negative feedback.

    Frequencies are real ones in rad/s, below or at Nyquist's. For a table, or a controller
    times one, the result is a ``zoh.TableMargins``. Raises SpecError for what is no system.

    >>> from math import pi
    >>> m = margins(Sampled(num=[0.1], den=[1, -0.9], dt=1.0))  # leaves at z = -1
    >>> round(m.gain_margin, 12), m.phase_crossover == pi
    (19.0, True)
    """
    if isinstance(loop, FrequencyResponse | TabledLoop):
        return table_margins(loop)
    return measure_loop(Loop.of(loop))


def measure_loop(loop: Loop) -> Margins:
    """Return the margins of a loop on its frequency axis; raise SpecError beyond floats."""
    with np.errstate(all="ignore"):  # what overflows is looked for below
        found = _measured(loop)
    numbers = [found.gain_margin, found.phase_margin_deg, found.modulus_margin, found.mt]
    if any(isnan(x) for x in [*numbers, found.disk_margin]):
        raise SpecError(
            "L",
            "must have gains that a 64-bit float can hold",
            [*loop.num, *loop.den],
            "use other units for the signals or for time",
        )
    return found


def _measured(loop: Loop) -> Margins:
    seen = _Seen.of(loop)
    by_phase = _phase_crossings(seen)
    by_gain = _gain_crossings(seen, by_phase)
    nearest_gain = min(by_phase, key=lambda c: abs(log(c[1])), default=(None, inf))
    nearest_phase = min(by_gain, key=lambda c: abs(c[1]), default=(None, inf))
    modulus = _least_ratio(seen, 0.0, 1.0)
    complementary = _least_ratio(seen, 1.0, 0.0)
    disk = _least_ratio(seen, -1.0, 1.0)
    return Margins(
        stable=closed_loop_stable(loop),
        gain_margin=nearest_gain[1],
        phase_crossover=nearest_gain[0],
        phase_margin_deg=nearest_phase[1],
        crossover=nearest_phase[0],
        delay_margin=_delay_margin(loop, by_gain),
        modulus_margin=modulus[1],
        ms_frequency=loop.frequency(modulus[0]),
        mt=1 / complementary[1] if complementary[1] else inf,
        mt_frequency=loop.frequency(complementary[0]),
        disk_margin=2 * disk[1],
        gain_crossings=tuple(by_gain),
        phase_crossings=tuple(by_phase),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Seen:
    """A loop looked at wherever something may happen.

    v            frequencies, ascending: the landmarks and near every root below
    top, bottom  num and den there
    square       |num|^2 - |den|^2 as a polynomial in q = v^2
    turn         Im(num conj den)/v in q; short delays are in it, long ones are not
    """

    loop: Loop
    v: Array
    top: ComplexArray
    bottom: ComplexArray
    square: Poly
    turn: Poly

    @classmethod
    def of(cls, loop: Loop) -> "_Seen":
        square = poly.plus(poly.size_squared(loop.num), poly.size_squared(loop.den), -1.0)
        turn = _turning(loop)
        v = np.unique(np.concatenate([landmarks(loop), suspects(square), suspects(turn)]))
        v = v[np.isfinite(v) & (v > 0)]
        top, bottom = loop.parts(v)
        return cls(loop=loop, v=v, top=top, bottom=bottom, square=square, turn=turn)


def _delay_margin(loop: Loop, by_gain: list[tuple[float, float]]) -> float:
    """Return the least delay in s that turns a crossing onto -1.

    A continuous loop whose gain stays above 1 at the highest frequencies bears none at all.
    """
    if loop.dt is None and loop.num[0] != 0 and abs(loop.num[0]) >= abs(loop.den[0]):
        return 0.0
    return min((_delay(w, pm) for w, pm in by_gain if w), default=inf)


def _delay(w: float, pm_deg: float) -> float:
    """Return the delay in s that turns the loop at w rad/s onto -1."""
    return radians(pm_deg) % tau / w


def _gain_crossings(seen: _Seen, by_phase: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return (frequency, phase margin in deg) wherever |L| passes through 1."""
    loop = seen.loop
    if not any(seen.square):  # |L| is 1 everywhere: what counts is where L is -1
        return [(w, 0.0) for w, _ in by_phase]

    def excess(v: float) -> float:
        return abs(scalar(loop.num, v)) - abs(scalar(loop.den, v))

    signs = np.sign(np.abs(seen.top) - np.abs(seen.bottom))
    found = sign_changes(excess, seen.v, signs)
    crossings = [(loop.frequency(v), _margin_deg(*loop.point(v))) for v in found]
    for v, top, bottom in loop.ends():
        if not bottom or abs(abs(top / bottom) - 1) > _TOUCHES:
            continue
        w = loop.frequency(v)
        crossings = [c for c in crossings if abs(c[0] - w) > _BLUR * _scale(loop)]
        if top / bottom < 0:
            crossings.append((w, 0.0))
    return sorted(crossings)


def _phase_crossings(seen: _Seen) -> list[tuple[float, float]]:
    """Return (frequency, factor on L that closes onto -1) wherever L is negative real."""
    loop = seen.loop
    if not loop.dead_time and not any(seen.turn):
        return _always_real(seen)

    def side(v: float) -> float:
        top, bottom = loop.point(v)
        return (top * bottom.conjugate()).imag

    def side_by_polynomial(v: float) -> float:
        return float(poly.homogeneous(seen.turn, v * v / (1 + v * v), 1 / (1 + v * v)))

    if loop.dead_time:
        values, exactly = (seen.top * np.conj(seen.bottom)).imag, side
    else:  # far from all corners the phase nears a multiple of 90 deg, and only this sign holds
        square = seen.v**2
        values = poly.homogeneous(seen.turn, square / (1 + square), 1 / (1 + square))
        exactly = side_by_polynomial
    crossings = []
    for v in sign_changes(exactly, seen.v, np.sign(values)):
        top, bottom = loop.point(v)
        product = (top * bottom.conjugate()).real
        if product < -_AT_A_ROOT * _bulk(loop, v):
            crossings.append((loop.frequency(v), -_square(bottom) / product))
    every = crossings + _at_the_ends(loop)
    return sorted((w, factor) for w, factor in every if 0 < factor < inf)  # what a float holds


def _at_the_ends(loop: Loop) -> list[tuple[float, float]]:
    """Return the phase crossings at w = 0 and at the Nyquist frequency."""
    return [
        (loop.frequency(v), -bottom / top) for v, top, bottom in loop.ends() if top * bottom < 0
    ]


def _always_real(seen: _Seen) -> list[tuple[float, float]]:
    """Return the phase crossings of a loop that is real at every frequency.

    Any gain inside its range then makes it marginal somewhere: where |L| is 1 the factor is 1.
    """
    found = [
        (w, 1.0)
        for w, pm in _gain_crossings(seen, [])
        if abs(pm) < 1e-9  # deg: at -1, not at +1
    ]
    return sorted({*found, *_at_the_ends(seen.loop)})


def _turning(loop: Loop) -> Poly:
    """Return the polynomial in q = v^2 that is Im(num conj den)/v, short delays multiplied in."""
    num, den = loop.num, loop.den
    if loop.dead_time and loop.dt is not None:
        m = min(round(loop.dead_time / loop.dt), _EXPANDED)
        grow = [comb(m, k) * (loop.dt / 2) ** (m - k) for k in range(m + 1)]
        fall = [c if (m - k) % 2 == 0 else -c for k, c in enumerate(grow)]
        num, den = poly.times(num, fall), poly.times(den, grow)
    num_even, num_odd = poly.even_odd(num)
    den_even, den_odd = poly.even_odd(den)
    return poly.trim(poly.plus(poly.times(num_odd, den_even), poly.times(num_even, den_odd), -1.0))


def _least_ratio(seen: _Seen, on_top: float, on_bottom: float) -> tuple[float, float]:
    """Return (v, min |den + num|/|on_bottom den + on_top num|), both ends included."""
    loop = seen.loop

    def ratio(v: float) -> float:
        top, bottom = loop.point(v)
        below = abs(on_bottom * bottom + on_top * top)
        return abs(bottom + top) / below if below else inf

    def slope(v: float) -> float:
        top, bottom, dtop, dbottom = loop.slopes(v)
        above, below = bottom + top, on_bottom * bottom + on_top * top
        if above == 0 or below == 0:
            return 0.0
        dbelow = on_bottom * dbottom + on_top * dtop
        return ((dbottom + dtop) / above).real - (dbelow / below).real

    with np.errstate(divide="ignore", invalid="ignore"):
        above, below = seen.bottom + seen.top, on_bottom * seen.bottom + on_top * seen.top
        best = least(ratio, slope, seen.v, np.abs(above) / np.abs(below))
    for v, top, bottom in loop.ends():
        end = abs(on_bottom * bottom + on_top * top)
        # where the least is at an end, the grid's outermost point says the same but for rounding
        if end and abs(bottom + top) / end <= best[1] * (1 + 1e-14):
            best = v, abs(bottom + top) / end
    return best


def _square(x: complex) -> float:
    return x.real * x.real + x.imag * x.imag


def _scale(loop: Loop) -> float:
    """Return the least frequency in rad/s at which the loop does anything."""
    sizes = [abs(r) for r in (*poly.roots(loop.num), *poly.roots(loop.den)) if r]
    return loop.frequency(min(sizes, default=1.0))


def _margin_deg(top: complex, bottom: complex) -> float:
    """Return the angle from -180 deg to L, in (-180, 180]."""
    angle = degrees(phase(-top * bottom.conjugate()))
    return 180.0 if angle <= -180 else angle


def _bulk(loop: Loop, v: float) -> float:
    """Return what |num den| would be at v if nothing cancelled."""
    top = poly.at([abs(c) for c in loop.num], v)
    return float(top * poly.at([abs(c) for c in loop.den], v))
