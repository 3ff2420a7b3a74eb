"""What the rounding of coefficients in w costs where a loop has a mode with hardly any damping.

A hold's coefficients are proved to 60 bits and rounded once, so each may be off by a part 2^-53 of
itself. A factor's num(jv) is then off by that part of its terms, and where they cancel, beside a
zero or a pole next to the axis, L by a larger part rho of itself. A crossing moves by rho over the
slope of the gain or of the phase there, and |1 + L| by rho |L|. First order, and an upper bound.
Source: that of ``rounding``, which asks the same of given z-coefficients.
"""

from collections.abc import Sequence
from functools import lru_cache
from math import copysign, degrees, inf, sqrt

from zoh.analysis.axis import scalar, terms
from zoh.analysis.loop import Loop
from zoh.analysis.results import Margins
from zoh.lti import poly
from zoh.lti.poly import Poly
from zoh.lti.wplane import warp

_SAID = 1e-6  # deg, and relative: what is off by less is not worth a word
_ASKED = 5e-10  # deg, and relative: more digits are taken where a figure is off by more
_LOST = 1e-5  # by more of itself L is off only in the middle of a mode
_LEAST = 2.0**-53  # of its terms: no float of a polynomial tells less from 0
_BESIDE = 1e-6  # of its terms: by less a polynomial is beside a root next to the axis
_END = 1e9  # v dt; beyond it is the end of the axis, where L is real whatever it is


def next_to_the_axis(loop: Loop) -> list[float]:
    """Return v of the zeros and poles with next to no damping of what a hold made.

    Rounding may split two that are close to each other and lose, or make up, a crossing there.
    """
    return [v for s in loop.made for a in (s.num_w, s.den_w) for v in _undamped(a)]


def is_blurred(loop: Loop, found: Margins, near: Sequence[float]) -> bool:
    """Return whether rounding of w-coefficients leaves a figure fewer than ten digits.

    near  v at which it may have lost L itself, and what passes there is not among the figures
    """
    if loop.given:
        return False
    dt = loop.made[0].dt
    if max([_part(loop, v) for v in near if v * dt < _END], default=0.0) > _LOST:
        return True
    _, by_phase = _worst(loop, found.gain_crossings, turning=True)
    _, by_gain = _worst(loop, found.phase_crossings, turning=False)
    peaks = {found.ms_frequency, found.mt_frequency, found.disk_frequency}
    return max(degrees(by_phase), by_gain, *[_peak_off(loop, w) for w in peaks]) > _ASKED


def blurs(loop: Loop, found: Margins) -> tuple[str, ...]:
    """Return a sentence on the margins that may be off by a millionth or more; () is none."""
    if loop.exact_but_for_gains:
        return ()
    said = []
    w, off = _worst(loop, found.gain_crossings, turning=True)
    if (off := degrees(off)) > _SAID:
        said.append(f"the phase margin at {w:.6g} rad/s may be off by {off:.1g} deg")
    w, off = _worst(loop, found.phase_crossings, turning=False)
    if off > _SAID:
        said.append(f"the gain margin at {w:.6g} rad/s may be off by {100 * off:.1g} %")
    if not said:
        return ()
    reason = "a zero or a pole next to the axis is beside it"
    return (f"by the rounding of coefficients in w {', '.join(said)}: {reason}",)


@lru_cache(maxsize=64)
def _undamped(a: Poly) -> tuple[float, ...]:
    """Return every v > 0 beside which a has a root next to the axis.

    At a root j v of a both its even and its odd part are 0; the larger of the two tells v.

    >>> _undamped((1.0, 1e-9, 4.0)), _undamped((1.0, 0.1, 4.0))
    ((2.0,), ())
    """
    while len(a) > 1 and not a[-1]:  # a root at 0 is exact
        a = a[:-1]
    if len(a) < 3:
        return ()
    n = len(a) - 1
    places = [sqrt(-x) for part in (a[n % 2 :: 2], a[1 - n % 2 :: 2]) for x in _roots(part)]
    return tuple([v for v in places if abs(scalar(a, v)) < _BESIDE * terms(a, v)])


def _roots(a: Poly) -> list[float]:
    """Return the real parts of the roots of a that are below 0: a double one may come out complex.

    >>> _roots((1.0, 3.0, 2.0)), _roots((1.0, 2.0, 1.0 + 2.0**-52))
    ([-2.0, -1.0], [-1.0])
    """
    a = a if a[0] else poly.trim(a)
    if len(a) > 3:
        found = poly.roots(a).real.tolist()
    elif len(a) == 3:
        inside = a[1] * a[1] - 4 * a[0] * a[2]
        larger = -(a[1] + copysign(sqrt(max(inside, 0.0)), a[1])) / 2
        found = [larger / a[0], *([a[2] / larger] if inside > 0 else [])]
    else:
        found = [-a[1] / a[0]] if len(a) == 2 else []
    return [x for x in found if -inf < x < 0]


def _worst(
    loop: Loop, crossings: tuple[tuple[float, float], ...], *, turning: bool
) -> tuple[float, float]:
    """Return (w, by how much it may be off) of the crossing that is moved most."""
    moved = [(w, _off(loop, w, turning=turning)) for w, _ in crossings if w]
    return max(moved, key=lambda pair: pair[1], default=(0.0, 0.0))


def _off(loop: Loop, w: float, *, turning: bool) -> float:
    """Return by how much rounding moves ln L at a crossing: its phase in rad, or its gain."""
    dt = loop.made[0].dt
    v = warp(w, dt)
    if not v * dt < _END:
        return 0.0
    top, bottom, slope_top, slope_bottom = loop.slopes(v)
    if not (top and bottom):
        return 0.0
    slope = slope_top / top - slope_bottom / bottom
    own, other = (slope.imag, slope.real) if turning else (slope.real, slope.imag)
    part = _part(loop, v)
    return part * (1 + abs(own / other)) if other else inf if part else 0.0


def _peak_off(loop: Loop, w: float) -> float:
    """Return by which part of itself rounding moves |1 + L|."""
    dt = loop.made[0].dt
    v = warp(w, dt)
    if not 0 < v * dt < _END:
        return 0.0
    top, bottom = loop.point(v)
    part = _part(loop, v)
    return part * max(1.0, abs(top) / above) if (above := abs(bottom + top)) else inf


def _part(loop: Loop, v: float) -> float:
    """Return by which part of itself rounding of its factors moves L."""
    return sum([s.off * (_lost(s.num_w, v) + _lost(s.den_w, v)) for s in loop.made])


def _lost(a: Poly, v: float) -> float:
    """Return how much larger the terms of a(jv) are than it is."""
    size = terms(a, v)
    if not size:  # at 0, a root there by structure
        return 1.0
    return size / max(abs(scalar(a, v)), _LEAST * size)
