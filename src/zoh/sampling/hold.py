"""The zero-order hold, exact, for any proper plant and any dead time.

Between samples the plant sees a constant, so its samples follow from its step response y(t)
alone. With a delay of m dt - e, 0 <= e < dt, and h_j = y(j dt + e)::

    G(z) = z^-m sum_j (h_j - h_{j-1}) z^-j          (the modified z-transform)

y comes from ``ring``, where no root is sought, so repeated, complex, unstable and integrating
poles are one case. The arithmetic carries as many digits as the subtractions ahead will eat,
and rounds once, at the end, into z and into w.
Source: K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed., ch. 2 (sampling
by the step response, systems with time delay); E. I. Jury, Theory and Application of the
z-Transform Method (modified z-transform).
"""

from collections.abc import Sequence
from decimal import Decimal, getcontext
from itertools import pairwise
from math import ceil, ulp
from typing import overload

from zoh import checks
from zoh.errors import SpecError
from zoh.lti import digits
from zoh.lti.digits import Exact
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.systems import Plant, Sampled, sample_time
from zoh.lti.wplane import to_bilinear
from zoh.sampling.images import sampled_table
from zoh.sampling.ring import StepResponse, digits_needed

MAX_DELAY = 10_000  # samples; a loop that waits longer is not a feedback loop

_ZERO, _ONE = Decimal(0), Decimal(1)


@overload
def sample(plant: Plant, dt: float, compute_delay: float = 0.0) -> Sampled: ...
@overload
def sample(
    plant: FrequencyResponse, dt: float, compute_delay: float = 0.0
) -> FrequencyResponse: ...
def sample(
    plant: Plant | FrequencyResponse, dt: float, compute_delay: float = 0.0
) -> Sampled | FrequencyResponse:
    """Return the plant behind a zero-order hold, seen once every dt seconds, sensor included.

    dt             s, above 0
    compute_delay  s, from sampling to output, added to the plant's dead time; any fraction of
                   dt, or more

    A continuous table becomes a sampled one, by ``images``. Raises SpecError for a dt or a
    delay out of range.

    >>> sample(Plant(num=[1], den=[1, 0]), dt=0.5)  # 1/s becomes dt/(z - 1)
    Sampled(num=(0.5,), den=(1.0, -1.0), dt=0.5)
    >>> sample(Plant(num=[1], den=[1, 0, 0]), dt=1.0, compute_delay=0.5)
    Sampled(num=(0.125, 0.75, 0.125), den=(1.0, -2.0, 1.0, 0.0), dt=1.0)
    """
    if isinstance(plant, FrequencyResponse):
        return sampled_table(plant, dt, compute_delay)
    if not isinstance(plant, Plant):
        raise SpecError("plant", "must be a zoh.Plant", plant, "sample a continuous plant")
    dt = sample_time(dt)
    checks.not_negative("compute_delay", compute_delay, "give seconds, 0 or more")
    m, lead = whole_samples(plant.dead_time, compute_delay, dt)
    num_s, den_s = plant.exact
    with digits.precision(digits_needed(num_s, den_s, dt)):
        step = StepResponse.of(num_s, den_s, Decimal(plant.sensor), Decimal(dt))
        den1_z, values = step.sampled(lead)
        return _rounded(step, den1_z, values, dt, m)


def _rounded(
    step: "StepResponse", den1_z: Exact, values: Sequence[Decimal], dt: float, m: int
) -> Sampled:
    """Return the sampled system from its step response h_0 ... h_n and its moving poles."""
    n, k = step.order, step.integrators
    den_z = den1_z
    for _ in range(k):
        den_z = digits.times(den_z, (_ONE, -_ONE))
    pulse = [values[0]] + [b - a for a, b in pairwise(values)]
    num_z = [sum((den_z[i] * pulse[j - i] for i in range(j + 1)), _ZERO) for j in range(n + 1)]
    half = Decimal(dt) / 2
    den_p = tuple(c * 2**k for c in to_bilinear(den1_z, n - k)) + (_ZERO,) * k
    num_p = list(to_bilinear(num_z, n))
    # what cancels exactly leaves rounding behind; no true coefficient is anywhere near as small
    nothing = max(abs(c) for c in num_z) * Decimal(10) ** (30 - getcontext().prec)
    for i in range(n + 1):
        if abs(num_p[i]) < nothing or n - i < min(step.zeros_at_origin, k + 1):
            num_p[i] = _ZERO  # the second: a zero at s = 0 is a zero at z = 1
    scale = [half ** (n - i) for i in range(n + 1)]
    unit = next(d * s for d, s in zip(den_p, scale, strict=True) if d)
    try:
        return Sampled.made(
            num=tuple(_finite(c) for c in num_z),
            den=tuple(_finite(c) for c in den_z) + (0.0,) * m,
            dt=dt,
            num_w=tuple(_finite(c * s / unit) for c, s in zip(num_p, scale, strict=True)),
            den_w=tuple(_finite(c * s / unit) for c, s in zip(den_p, scale, strict=True)),
            delay=m,
        )
    except OverflowError:
        raise SpecError(
            "dt",
            "must keep the sampled plant within a float's range",
            dt,
            "sample faster: an unstable mode outgrows 1e308 within one sample",
        ) from None


def _finite(c: Decimal) -> float:
    value = float(c)
    if value in (float("inf"), float("-inf")):
        raise OverflowError
    return value


def whole_samples(dead_time: float, compute_delay: float, dt: float) -> tuple[int, Decimal]:
    """Return (m, e/dt): the delay is m dt - e with 0 <= e < dt.

    0.3/0.1 is 2.9999999999999996: a ratio within rounding of a whole number is that number.
    """
    total = dead_time + compute_delay
    ratio = total / dt
    if ratio > MAX_DELAY:
        raise SpecError(
            "dead_time + compute_delay",
            f"must be at most {MAX_DELAY} samples ({MAX_DELAY * dt:.6g} s)",
            total,
            "sample more slowly",
        )
    if abs(ratio - round(ratio)) <= 8 * ulp(ratio):  # three roundings, doubled and then some
        return round(ratio), _ZERO
    m = ceil(ratio)
    with digits.precision(digits.KEPT):
        return m, m - (Decimal(dead_time) + Decimal(compute_delay)) / Decimal(dt)
