"""Sampling that keeps a response: to an impulse, or to straight lines between the samples.

With a dead time of m dt - e, 0 <= e < dt, time counted from e on (the modified z-transform)::

    impulse   G(z) = z^-m dt sum_j g(j dt + e) z^-j
    ramp      G(z) = z^-m (z - 2 + 1/z)/dt sum_j r(j dt + e) z^-j

g is the response to an impulse, r the one to a ramp that starts at 0. The second is the
first-order ("triangle") hold: straight lines through the inputs at the samples, so G answers
now to the input of now. Both come from the ring of the step response: g is the step response
of s P(s), r that of P(s)/s.
Source: K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed., ch. 2 and 8
(ramp invariance, impulse invariance); the scale dt and the full weight of g(0+) are the
convention of scipy.signal.cont2discrete(method="impulse").
"""

from collections.abc import Sequence
from decimal import Decimal

from zoh.errors import SpecError
from zoh.lti import digits
from zoh.lti.digits import Exact
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import whole_samples
from zoh.sampling.ring import StepResponse, digits_needed
from zoh.sampling.rounding import in_both_forms

_ZERO, _ONE = Decimal(0), Decimal(1)


def impulse(plant: Plant, dt: float) -> Sampled:
    """Return the system whose pulse response is dt times the plant's impulse response.

    At t = 0 the value just after the jump is taken. Raises SpecError for a plant with
    feedthrough, whose impulse response holds an impulse itself.

    >>> impulse(Plant(num=[1], den=[1, 0]), dt=0.5)  # 1/s: g(t) = 1 at every sample
    Sampled(num=(0.5, 0.0), den=(1.0, -1.0), dt=0.5)
    """
    num, den = plant.exact
    if len(num) == len(den):
        raise SpecError(
            "plant",
            "must have no feedthrough (deg num < deg den) for method 'impulse'",
            list(plant.num),
            "a sampled impulse has no height; use method 'zoh' or 'foh'",
        )
    m, lead = whole_samples(plant.dead_time, 0.0, dt)
    num = (*num, _ZERO)
    with digits.precision(digits_needed(num, den, dt)):
        y = StepResponse.of(num, den, Decimal(plant.sensor) * Decimal(dt), Decimal(dt))
        moving, values = y.sampled(lead)
        zeros = min(y.zeros_at_origin - 1, y.integrators)  # one of those at s = 0 was put there
        return _quotient(moving, values, y.integrators, zeros, dt, m)


def ramp(plant: Plant, dt: float) -> Sampled:
    """Return the plant behind a first-order hold: right at the samples for straight lines.

    >>> ramp(Plant(num=[1], den=[1, 0]), dt=0.5)  # the integral of straight lines: trapezoids
    Sampled(num=(0.25, 0.25), den=(1.0, -1.0), dt=0.5)
    """
    num, den = plant.exact
    den = (*den, _ZERO)
    m, lead = whole_samples(plant.dead_time, 0.0, dt)
    with digits.precision(digits_needed(num, den, dt)):
        y = StepResponse.of(num, den, Decimal(plant.sensor), Decimal(dt))
        moving, r = y.sampled(lead)
        r = [c / Decimal(dt) for c in r]
        before = [_ZERO, _ZERO, *r]
        bends = [a - 2 * b + c for a, b, c in zip(r, before[1:], before, strict=False)]
        zeros = min(y.zeros_at_origin, y.integrators + 1)
        if not lead:  # r starts at 0, and so does the first bend
            return _quotient(moving, bends[1:], y.integrators - 1, zeros, dt, m)
        # the line begins to rise a sample before its input: one pole at 0 for the part of m
        return _quotient((*moving, _ZERO), bends, y.integrators - 1, zeros, dt, m - 1)


def _quotient(
    moving: Exact,
    values: Sequence[Decimal],
    at_one: int,
    zeros_at_one: int,
    dt: float,
    delay: int,
) -> Sampled:
    """Return sum_j values_j z^-j over its poles; there are as many values as coefficients."""
    den = moving
    for _ in range(at_one):
        den = digits.times(den, (_ONE, -_ONE))
    n = len(den) - 1
    num = [sum((den[i] * values[j - i] for i in range(j + 1)), _ZERO) for j in range(n + 1)]
    return in_both_forms(
        num=num, moving=moving, at_one=at_one, zeros_at_one=zeros_at_one, dt=dt, delay=delay
    )
