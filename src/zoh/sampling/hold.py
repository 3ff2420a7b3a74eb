"""The zero-order hold, exact, for any proper plant and any dead time.

Between samples the plant sees a constant, so its samples follow from its step response y(t)
alone. With a delay of m dt - e, 0 <= e < dt, and h_j = y(j dt + e)::

    G(z) = z^-m sum_j (h_j - h_{j-1}) z^-j          (the modified z-transform)

y is a linear functional l of the exponential in the ring modulo s den(s), where no root is
sought, so repeated, complex, unstable and integrating poles are one case::

    y(t) = l(exp(s t)),    l(s^i) = the i-th derivative of y at 0+

Its differences are l((exp(s dt) - 1)^i exp(s e)), and the traces of the same powers are the power
sums of the poles in delta = z - 1. All of it is done in whole numbers of so many bits with a
bound on every error; where a coefficient of the result is not sure to a float, it is done again
with the bits that were missing.
Source: K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed., ch. 2 (sampling
by the step response, systems with time delay); E. I. Jury, Theory and Application of the
z-Transform Method (modified z-transform).
"""

from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal
from fractions import Fraction
from functools import lru_cache, partial
from math import ceil, ulp
from typing import overload

from zoh import checks
from zoh.errors import SpecError
from zoh.lti import digits
from zoh.lti.digits import Exact
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.hidden import Apart
from zoh.lti.sampled import Wholes
from zoh.lti.systems import Plant, Sampled, sample_time
from zoh.lti.whole import times
from zoh.sampling.delta import SURE, Forms
from zoh.sampling.fixed import Ratio
from zoh.sampling.images import sampled_table
from zoh.sampling.response import FixedResponse, Scaled
from zoh.sampling.rounding import with_a_gain

MAX_DELAY = 10_000  # samples; a loop that waits longer is not a feedback loop
_NOTHING = 256  # bits beyond all that was lost: no true coefficient is anywhere near as small
_FINE = 256  # bits of a coefficient in w beside an undamped mode or the limit of stability
_NOW: Ratio = (0, 1)
_ONE = Decimal(1)
KEPT = Context(prec=digits.KEPT, Emax=MAX_EMAX, Emin=MIN_EMIN)  # of a delay's fraction


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
    if not isinstance(plant, Plant) and not isinstance(plant, FrequencyResponse):
        raise SpecError("plant", "must be a zoh.Plant", plant, "sample a continuous plant")
    dt = sample_time(dt)
    compute_delay = checks.not_negative("compute_delay", compute_delay, "give seconds, 0 or more")
    if isinstance(plant, Plant):
        return _held(plant.exact, plant.sensor, dt, plant.dead_time, compute_delay)
    _samples(0.0, compute_delay, dt)  # refuses a delay beyond those of loops
    return sampled_table(plant, dt, compute_delay)


Held = tuple[tuple[Exact, Exact], float, float, float, float]  # num/den, sensor, dt, two delays


@lru_cache(maxsize=256)
def _held(
    exact: tuple[Exact, Exact], sensor: float, dt: float, dead_time: float, compute_delay: float
) -> Sampled:
    """Return the plant held; kept, for a design and each of its measurements ask for it again.

    What its num and den share they share afterwards, too: a hidden mode on the boundary is there.
    """
    what = exact, sensor, dt, dead_time, compute_delay
    try:
        forms, m = _forms(what, SURE)
        held = with_a_gain(forms.rounded(dt, m, partial(_finer, what)))
        if (apart := Apart.of(*exact)) is None:
            return held
        plain, modes = (_forms(part, SURE)[0].rounded(dt, m) for part in _parted(what, apart))
    except OverflowError:
        raise SpecError(
            "dt",
            "must keep the sampled plant within a float's range",
            dt,
            "sample faster: an unstable mode outgrows 1e308 within one sample",
        ) from None
    return held.holding(_sharing(plain.whole_w, modes.whole_w), held.off)


@lru_cache(maxsize=8)
def _finer(what: Held) -> Sampled:
    """Return the plant held, its w-coefficients with the digits that an undamped mode asks for.

    Or the limit of stability. A common factor of the two gains at rest costs one bit.
    """
    exact, *_ = what
    apart = Apart.of(*exact)
    found = _sharing(*map(_whole, _parted(what, apart))) if apart else _whole(what)
    return _held(*what).holding(found, 2.0 ** (2 - _FINE))


def _whole(what: Held) -> Wholes:
    """Return the w-form with 256 bits, the gain at w = 0 exact: it is the plant's own."""
    (num, den), sensor, dt, *_ = what
    forms, _ = _forms(what, _FINE)
    top, bottom, unit = forms.whole(dt, _FINE)
    if not (top[-1] and bottom[-1]):  # a zero or a pole there, by structure
        return top, bottom, unit
    gain = Fraction(num[-1]) * Fraction(sensor) / Fraction(den[-1])
    up, down = gain.as_integer_ratio()
    at_rest = bottom[-1] * up
    top, bottom = ([c * down for c in a] for a in (top, bottom))
    return [*top[:-1], at_rest], bottom, unit * down


def _parted(what: Held, apart: Apart) -> tuple[Held, Held]:
    """Return the plant without its hidden modes, and these."""
    _, sensor, dt, dead_time, compute_delay = what
    plain = (apart.num, apart.den), sensor, dt, dead_time, compute_delay
    return plain, (((_ONE,), apart.modes), 1.0, dt, 0.0, 0.0)


def _sharing(plain: Wholes, modes: Wholes) -> Wholes:
    """Return ``plain`` with the denominator of ``modes`` in its numerator and denominator."""
    (num, den, unit), (_, shared, its_unit) = plain, modes
    return times(num, shared), times(den, shared), unit * its_unit


def _forms(what: Held, sure: int) -> tuple[Forms, int]:
    """Return (the plant held, so many bits of each coefficient sure, its delay in samples).

    Raises OverflowError where an unstable mode outgrows every number.
    """
    exact, sensor, dt, dead_time, compute_delay = what
    m, whole = _samples(dead_time, compute_delay, dt)
    lead = _NOW if whole else _lead(m, dead_time, compute_delay, dt)
    plant = Scaled.of(*exact, sensor, dt)
    bits, last = plant.first_bits() + sure - SURE, False
    while True:
        found = FixedResponse.of(plant, bits).sampled(lead).forms()
        missing = found.missing_bits(sure)
        if missing == 0:
            return found, m
        if missing is not None:
            bits += missing
        elif last:
            return found.cleared(), m
        else:  # where the errors fill the number, they say nothing of what is missing
            lost = found.lost_bits()
            last = lost < bits
            bits += lost + _NOTHING if last else bits


def whole_samples(dead_time: float, compute_delay: float, dt: float) -> tuple[int, Decimal]:
    """Return (m, e/dt): the delay is m dt - e with 0 <= e < dt.

    0.3/0.1 is 2.9999999999999996: a ratio within rounding of a whole number is that number.
    """
    m, whole = _samples(dead_time, compute_delay, dt)
    if whole:
        return m, Decimal(0)
    delay = KEPT.add(Decimal(dead_time), Decimal(compute_delay))
    return m, KEPT.subtract(m, KEPT.divide(delay, Decimal(dt)))


def _samples(dead_time: float, compute_delay: float, dt: float) -> tuple[int, bool]:
    """Return (m, whether the delay is m samples and no fraction)."""
    total = dead_time + compute_delay
    ratio = total / dt
    if ratio > MAX_DELAY:
        raise SpecError(
            "dead_time + compute_delay",
            f"must be at most {MAX_DELAY} samples ({MAX_DELAY * dt:.6g} s)",
            total,
            "sample more slowly",
        )
    nearest = round(ratio)
    if abs(ratio - nearest) <= 8 * ulp(ratio):  # three roundings, doubled and then some
        return nearest, True
    return ceil(ratio), False


def _lead(m: int, dead_time: float, compute_delay: float, dt: float) -> Ratio:
    """Return e = m dt - dead_time - compute_delay in s; floats are fractions over powers of 2."""
    parts = [x.as_integer_ratio() for x in (dt, dead_time, compute_delay)]
    bottom = max([b for _, b in parts])
    period, dead, compute = [a * (bottom // b) for a, b in parts]
    return m * period - dead - compute, bottom
