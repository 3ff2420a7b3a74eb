"""The margins of a loop, every crossing counted, z = 1 and z = -1 included.

Gain crossings are sign changes of |num|^2 - |den|^2, phase crossings those of
Im(num conj den) where the real part is negative; on the axis both are polynomials in
q = v^2, v = (2/dt) tan(w dt/2) for a sampled loop and v = w for a continuous one.
Source: K. J. Astrom and R. M. Murray, Feedback Systems, 2nd ed., sec. 10.3 and 13.2 (margins,
sensitivity peaks); P. Seiler, A. Packard, P. Gahinet, An Introduction to Disk Margins, IEEE
Control Systems 40(5), 2020, eq. (5) with sigma = 0.
"""

from cmath import exp, phase
from collections.abc import Callable
from math import comb, degrees, inf, log, pi, radians, tau

import numpy as np

from zoh.analysis.crossings import Array, landmarks, least, merged, sign_changes, suspects
from zoh.analysis.loop import Loop, scalar
from zoh.analysis.results import Margins
from zoh.analysis.stability import closed_loop_stable
from zoh.lti import poly
from zoh.lti.poly import Poly
from zoh.lti.systems import Plant, Sampled

_EXPANDED = 12  # samples of delay multiplied into a polynomial to find its roots
_TOUCHES = 4e-15  # |L| this near to 1 at an end of the axis is 1: a few roundings, and
_BLUR = 1e-6  # the crossing they make up this near to it (|L| is flat there) is none


def margins(loop: Plant | Sampled) -> Margins:
    """Return the margins of ``loop``, the open loop of a unity negative feedback.

    Frequencies are real ones in rad/s, below or at Nyquist's. Raises SpecError for anything
    that is no system.

    >>> m = margins(Sampled(num=[0.1], den=[1, -0.9], dt=1.0))  # leaves at z = -1
    >>> round(m.gain_margin, 12), m.phase_crossover == pi
    (19.0, True)
    """
    return measure_loop(Loop.of(loop))


def measure_loop(loop: Loop) -> Margins:
    """Return the margins of a loop on its frequency axis."""
    grid = landmarks(loop)
    by_phase = _phase_crossings(loop, grid)
    by_gain = _gain_crossings(loop, grid, by_phase)
    nearest_gain = min(by_phase, key=lambda c: abs(log(c[1])), default=(None, inf))
    nearest_phase = min(by_gain, key=lambda c: abs(c[1]), default=(None, inf))
    modulus = _least_ratio(loop, grid, 1.0, _den)
    complementary = _least_ratio(loop, grid, 1.0, _num)
    disk = _least_ratio(loop, grid, 1.0, _other)
    return Margins(
        stable=closed_loop_stable(loop),
        gain_margin=nearest_gain[1],
        phase_crossover=nearest_gain[0],
        phase_margin_deg=nearest_phase[1],
        crossover=nearest_phase[0],
        delay_margin=min((_delay(w, pm) for w, pm in by_gain if w), default=inf),
        modulus_margin=modulus[1],
        ms_frequency=loop.frequency(modulus[0]),
        mt=1 / complementary[1] if complementary[1] else inf,
        mt_frequency=loop.frequency(complementary[0]),
        disk_margin=2 * disk[1],
        gain_crossings=tuple(by_gain),
        phase_crossings=tuple(by_phase),
    )


def _delay(w: float, pm_deg: float) -> float:
    """Return the delay in s that turns the loop at w rad/s onto -1."""
    return radians(pm_deg) % tau / w


def _gain_crossings(
    loop: Loop, grid: Array, by_phase: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Return (frequency, phase margin in deg) wherever |L| passes through 1."""
    square = poly.plus(poly.size_squared(loop.num), poly.size_squared(loop.den), -1.0)
    if not any(square):  # |L| is 1 everywhere: what counts is where L is -1
        return [(w, 0.0) for w, _ in by_phase]

    def excess(v: float) -> float:
        top, bottom = scalar(loop.num, v), scalar(loop.den, v)
        return _square(top) - _square(bottom)

    def excess_on(v: Array) -> Array:
        top, bottom = poly.at(loop.num, 1j * v), poly.at(loop.den, 1j * v)
        return np.asarray(np.abs(top) - np.abs(bottom))

    found = merged(sign_changes(excess, excess_on, (grid, suspects(square))))
    crossings = [(loop.frequency(v), _margin_deg(*_at(loop, v))) for v in found]
    for v, top, bottom in loop.ends():
        if not bottom or abs(abs(top / bottom) - 1) > _TOUCHES:
            continue
        w = loop.frequency(v)
        crossings = [c for c in crossings if abs(c[0] - w) > _BLUR * _scale(loop)]
        if top / bottom < 0:
            crossings.append((w, 0.0))
    return sorted(crossings)


def _phase_crossings(loop: Loop, grid: Array) -> list[tuple[float, float]]:
    """Return (frequency, factor on L that closes onto -1) wherever L is negative real."""
    turn = _turning(loop)
    if not loop.dead_time and not any(turn):
        return _always_real(loop, grid)
    if loop.dead_time:

        def side(v: float) -> float:
            top, bottom = _at(loop, v)
            return (top * bottom.conjugate()).imag

        def side_on(v: Array) -> Array:
            top, bottom = loop.parts(v)
            return np.asarray((top * np.conj(bottom)).imag)
    else:

        def side(v: float) -> float:
            return float(poly.at(turn, v * v))

        def side_on(v: Array) -> Array:
            return np.asarray(poly.at(turn, v * v))

    crossings = []
    for v in merged(sign_changes(side, side_on, (grid, suspects(turn)))):
        top, bottom = _at(loop, v)
        product = (top * bottom.conjugate()).real
        if product < -1e-13 * _bulk(loop, v):  # smaller is a pole or a zero on the axis
            crossings.append((loop.frequency(v), -_square(bottom) / product))
    for v, top, bottom in loop.ends():
        if top * bottom < 0:
            crossings.append((loop.frequency(v), -bottom / top))
    return sorted(crossings)


def _always_real(loop: Loop, grid: Array) -> list[tuple[float, float]]:
    """Return the phase crossings of a loop that is real at every frequency.

    Any gain inside its range then makes it marginal somewhere: where |L| is 1 the factor is 1.
    """
    found = [
        (w, 1.0)
        for w, pm in _gain_crossings(loop, grid, [])
        if abs(pm) < 1e-9  # deg: -1, not +1
    ]
    for v, top, bottom in loop.ends():
        if top * bottom < 0:
            found.append((loop.frequency(v), -bottom / top))
    return sorted(set(found))


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


def _num(loop: Loop, v: float, top: complex, bottom: complex) -> complex:
    return top


def _den(loop: Loop, v: float, top: complex, bottom: complex) -> complex:
    return bottom


def _other(loop: Loop, v: float, top: complex, bottom: complex) -> complex:
    return bottom - top


def _least_ratio(
    loop: Loop, grid: Array, sign: float, below: Callable[..., complex]
) -> tuple[float, float]:
    """Return (v, min |den + num|/|below|) over the whole axis, both ends included."""

    def ratio(v: Array) -> Array:
        top, bottom = loop.parts(v)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.abs(bottom + top) / np.abs(below(loop, 0.0, top, bottom)))

    def slope(v: float) -> float:
        top, bottom = _at(loop, v)
        dtop, dbottom = loop.slopes(v)
        f, df = bottom + top, dbottom + dtop
        g, dg = below(loop, v, top, bottom), below(loop, v, dtop, dbottom)
        if f == 0 or g == 0:
            return 0.0
        return (df / f).real - (dg / g).real

    best = least(ratio, slope, grid)
    for v, top, bottom in loop.ends():
        g = below(loop, v, complex(top), complex(bottom))
        # where the least is at an end, the grid's outermost point says the same but for rounding
        if g and abs(bottom + top) / abs(g) <= best[1] * (1 + 1e-14):
            best = v, abs(bottom + top) / abs(g)
    return best


def _at(loop: Loop, v: float) -> tuple[complex, complex]:
    top, bottom = scalar(loop.num, v), scalar(loop.den, v)
    return (top * exp(-1j * loop.psi(v)) if loop.dead_time else top), bottom


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


__all__ = ["margins", "measure_loop", "pi"]
