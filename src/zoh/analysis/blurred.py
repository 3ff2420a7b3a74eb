"""What the rounding of coefficients in w costs where a loop has a mode with hardly any damping.

A hold's coefficients are proved to 60 bits and rounded once. Each may be off by a part 2^-53 of
itself, twice that in a loop of two; so num(jv) is off by that part of its terms, and
where they cancel, beside a zero or a pole next to the axis, L by a larger part rho of itself. A
crossing moves by rho over the slope of the gain or of the phase there. First order, and an upper
bound. Source: that of ``rounding``, which asks the same of given z-coefficients.
"""

from math import degrees, inf

from zoh.analysis.axis import terms
from zoh.analysis.loop import Loop
from zoh.analysis.margin_crossings import Crossings
from zoh.lti.wplane import warp

_UNIT = 2.0**-52
_SAID = 1e-6  # deg, and relative: what is off by less is not worth a word
_NOTHING = 1e-10  # relative; no slope makes more than _SAID of less
_END = 1e9  # v dt; beyond it is the end of the axis, where L is real whatever it is


def blurs(loop: Loop, by_gain: Crossings, by_phase: Crossings) -> tuple[str, ...]:
    """Return a sentence on the margins that may be off by a millionth or more; () is none.

    by_gain, by_phase  every crossing of |L| = 1 and of L < 0 with its margin
    """
    if loop.given:
        return ()
    found = []
    w, off = _worst(loop, by_gain, turning=True)
    if (off := degrees(off)) > _SAID:
        found.append(f"the phase margin at {w:.6g} rad/s may be off by {off:.1g} deg")
    w, off = _worst(loop, by_phase, turning=False)
    if off > _SAID:
        found.append(f"the gain margin at {w:.6g} rad/s may be off by {100 * off:.1g} %")
    if not found:
        return ()
    reason = "a zero or a pole next to the axis is beside it"
    return (f"by the rounding of coefficients in w {', '.join(found)}: {reason}",)


def _worst(loop: Loop, crossings: Crossings, *, turning: bool) -> tuple[float, float]:
    """Return (w, by how much it may be off) of the crossing that is moved most."""
    moved = [(w, _off(loop, w, turning=turning)) for w, _ in crossings if w]
    return max(moved, key=lambda pair: pair[1], default=(0.0, 0.0))


def _off(loop: Loop, w: float, *, turning: bool) -> float:
    """Return by how much rounding moves ln L at a crossing: its phase in rad, or its gain."""
    v = w if loop.dt is None else warp(w, loop.dt)
    if not v * (loop.dt or 0.0) < _END:
        return 0.0
    top, bottom = map(abs, loop.point(v))
    if not (top and bottom):
        return 0.0
    part = _UNIT * (terms(loop.num, v) / top + terms(loop.den, v) / bottom)
    if not _NOTHING < part < inf:
        return 0.0
    n, d, dn, dd = loop.slopes(v)
    slope = dn / n - dd / d
    own, other = (slope.imag, slope.real) if turning else (slope.real, slope.imag)
    return part * (1 + abs(own / other)) if other else inf
