"""Pole-zero matching: every finite pole and zero goes through z = exp(s dt).

Of the zeros at s = infinity one stays at z = infinity, the others come to z = -1, so a plant
with relative degree one or more keeps one sample between input and output. The gain is that of
the plant as s goes to 0: with P(s) = c s^q (1 + ...) there, G(z) = c ((z-1)/dt)^q (1 + ...),
which is the gain at zero frequency for q = 0 and its limit for integrators and differentiators.
Source: G. F. Franklin, J. D. Powell and M. L. Workman, Digital Control of Dynamic Systems,
3rd ed., ch. 6 (zero-pole matching equivalents; the modified form that keeps a delay).
"""

from decimal import Decimal

from zoh.lti import digits
from zoh.lti.digits import Exact
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.ring import StepResponse, digits_needed
from zoh.sampling.rounding import in_both_forms

_ONE = Decimal(1)
_PLUS_ONE = (_ONE, _ONE)
_MINUS_ONE = (_ONE, -_ONE)


def match(plant: Plant, dt: float, *, delay: int) -> Sampled:
    """Return the plant with its poles and zeros matched; dt in s, delay in samples.

    >>> match(Plant(num=[1], den=[1, 0]), 0.5, delay=0)
    Sampled(num=(0.5,), den=(1.0, -1.0), dt=0.5)
    >>> match(Plant(num=[1], den=[1, 0, 0]), 1.0, delay=0)  # (z + 1)/2 is 1 at z = 1
    Sampled(num=(0.5, 0.5), den=(1.0, -2.0, 1.0), dt=1.0)
    """
    num, den = plant.exact
    needed = digits_needed((_ONE,), num, dt) + digits_needed((_ONE,), den, dt)
    with digits.precision(needed):
        top, zeros_at_one = _mapped(num, dt)
        bottom, poles_at_one = _mapped(den, dt)
        lowest = Decimal(plant.sensor) * _lowest(num) / _lowest(den)
        at_minus_one = max(len(den) - len(num) - 1, 0)
        # divided by (z-1)^q and at z = 1, a polynomial is the sum of its coefficients
        gain = lowest * Decimal(dt) ** (poles_at_one - zeros_at_one)
        gain *= sum(bottom) / sum(top) / 2**at_minus_one
        full = top
        for factor, times in ((_PLUS_ONE, at_minus_one), (_MINUS_ONE, zeros_at_one)):
            for _ in range(times):
                full = digits.times(full, factor)
        zeros = (Decimal(0),) * (len(den) - len(full))
        return in_both_forms(
            num=(*zeros, *(gain * c for c in full)),
            moving=bottom,
            at_one=poles_at_one,
            zeros_at_one=zeros_at_one,
            dt=dt,
            delay=delay,
        )


def _mapped(a: Exact, dt: float) -> tuple[Exact, int]:
    """Return (the monic polynomial of exp(root dt), roots not at 0; how many are at 0)."""
    ring = StepResponse.of((_ONE,), a, _ONE, Decimal(dt))
    return ring.sampled(Decimal(0))[0], ring.integrators


def _lowest(a: Exact) -> Decimal:
    """Return the coefficient of the lowest power that has one."""
    return next(c for c in reversed(a) if c)
