"""How many bits a controller's z-coefficients need.

In words of b bits, sign included, num and den each have one binary point that lets their largest
coefficient fit; with 2^m above it the quantum is q = 2^(m - b + 1), and rounding moves a
coefficient by q/2 at most. To first order, with L'/L = g + j p at the crossover,

    d ln L = z^k/num(z) dc    or    -z^k/den(z) dc,        dPM = Im d ln L - (p/g) Re d ln L

so the sum of the sizes of all dPM is what q/2 may cost at worst. Fewer bits may do by luck, the
coefficients lying near the grid; a gain that is trimmed later has no such luck.
Source: C. L. Phillips and H. T. Nagle, Digital Control System Analysis and Design, the chapter
on finite word lengths (coefficient quantisation).
"""

from cmath import exp
from collections.abc import Sequence
from math import ceil, degrees, frexp, inf, ldexp, log2

from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.results import Margins
from zoh.lti import poly
from zoh.lti.poly import Poly
from zoh.lti.systems import Sampled

_MOST = 53  # bits: a float's own
_STEP = 1e-6  # of wc: the slope of L to 1e-9 of itself, where a bit is a factor of 2


def word_length(
    sampled: Sampled, controller: Sampled, margins: Margins, tol_deg: float
) -> int | None:
    """Return the bits with which no rounding moves the phase margin by tol_deg or more.

    margins  of the loop as it is, stable and with a crossover

    A bound to first order, tried on the coefficients as they are. None where 53 bits do not do.

    >>> plant = Sampled(num=[1.0], den=[1.0, -1.0], dt=1.0)
    >>> law = Sampled(num=[0.7], den=[1.0], dt=1.0)
    >>> word_length(plant, law, measure_loop(Loop.of(law, plant)), 0.1)
    10
    """
    for bits in range(sure_bits(sampled, controller, margins, tol_deg), _MOST + 1):
        if _holds(sampled, controller, margins, tol_deg, bits):
            return bits
    return None


def sure_bits(sampled: Sampled, controller: Sampled, margins: Margins, tol_deg: float) -> int:
    """Return the bits with which no rounding can cost more than tol_deg, to first order."""
    wc, dt = margins.crossover or 0.0, controller.dt
    loop = controller * sampled
    ahead, behind = loop.at(wc * (1 + _STEP)), loop.at(wc * (1 - _STEP))
    slope = (ahead - behind) / loop.at(wc)  # times a real number, which is of no matter
    turn = slope.imag / slope.real if slope.real else inf
    worst = 0.0
    for part in (controller.num, controller.den):
        z, value = exp(1j * wc * dt), poly.at(part, exp(1j * wc * dt))
        moves = [z ** (len(part) - 1 - i) / value for i in range(len(part))]
        worst += ldexp(sum(abs(d.imag - turn * d.real) for d in moves), _point(part))
    # worst 2^(1 - b)/2 is below tol where b is above log2(worst/tol)
    need = degrees(worst) / tol_deg
    if not need < inf:
        return _MOST
    return ceil(log2(need)) if need > 4 else 2


def rounded(controller: Sampled, bits: int) -> Sampled:
    """Return the controller with coefficients of so many bits.

    >>> rounded(Sampled(num=[0.7], den=[1.0, -0.9], dt=1.0), 4)  # quanta 1/8 and 1/4
    Sampled(num=(0.75,), den=(1.0, -1.0), dt=1.0)
    """

    def to_grid(part: Sequence[float]) -> Poly:
        quantum = _point(part) - bits + 1
        return tuple([ldexp(round(ldexp(c, -quantum)), quantum) for c in part])

    return Sampled(num=to_grid(controller.num), den=to_grid(controller.den), dt=controller.dt)


def _point(part: Sequence[float]) -> int:
    """Return m, the least whole number with 2^m above every coefficient."""
    return max(frexp(c)[1] for c in part if c)


def _holds(
    sampled: Sampled, controller: Sampled, margins: Margins, tol_deg: float, bits: int
) -> bool:
    """Return whether the loop is stable with its margin where it was, coefficients rounded."""
    found = measure_loop(Loop.of(rounded(controller, bits), sampled))
    return bool(found.stable) and (abs(found.phase_margin_deg - margins.phase_margin_deg) < tol_deg)
