"""Difference rules: Euler forward and backward, and Tustin between them.

All three are one rule, which puts a difference quotient of z in the place of s::

    s = (a/dt) (z - 1)/(theta z + 1 - theta)      theta = 0 forward, 1/2 Tustin, 1 backward

and in w, where the arithmetic is exact for whatever floats come in::

    s = a w/(1 + (2 theta - 1) w dt/2)            Tustin: s = a w

a is 1, or for a Tustin that is exact at wp the number x cot x, x = wp dt/2, which puts the
w-plane point of wp back at s = j wp.
Source: K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed., ch. 8
(approximating continuous-time controllers; frequency prewarping).
"""

from collections.abc import Sequence
from decimal import Decimal
from math import ceil, inf

from zoh.errors import SpecError
from zoh.lti import digits
from zoh.lti.digits import Exact
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.rounding import out_of_range

FORWARD, TUSTIN, BACKWARD = Decimal(0), Decimal("0.5"), Decimal(1)

_ZERO, _ONE = Decimal(0), Decimal(1)
_EXACT_TO = 6000  # digits; only a dt far from any clock needs more to be exact


def to_sampled(plant: Plant, dt: float, *, theta: Decimal, a: Decimal, delay: int) -> Sampled:
    """Return the plant with s replaced, z^-delay in the place of its dead time.

    theta, a  as above; dt s; delay in samples

    Raises SpecError where a pole of the plant comes out at z = infinity.

    >>> to_sampled(Plant(num=[1], den=[1, 0]), 2.0, theta=TUSTIN, a=Decimal(1), delay=0)
    Sampled(num=(1.0, 1.0), den=(1.0, -1.0), dt=2.0)
    """
    num, den = plant.exact
    n = len(den) - 1
    with digits.precision(_needed((*num, *den), (dt, plant.sensor), a, n)):
        step = Decimal(dt)
        top = tuple(Decimal(plant.sensor) * c for c in num)
        in_w = (a, _ZERO), ((2 * theta - 1) * step / 2, _ONE)
        in_z = (a, -a), (theta * step, (1 - theta) * step)
        top_z, bottom_z = (replaced(c, *in_z, n) for c in (top, den))
        lead = bottom_z[0]
        if not lead:
            raise SpecError(
                "dt",
                f"must not send the plant's pole at s = {float(a / theta / step):.6g} rad/s "
                "to z = infinity",
                dt,
                "sample faster, or use method 'zoh'",
            )
        forms = [c / lead for c in top_z], [c / lead for c in bottom_z]
        num_z, den_z = (digits.rounded(form) for form in forms)
        num_w, den_w = (digits.rounded(replaced(c, *in_w, n)) for c in (top, den))
    if inf in map(abs, num_z + den_z + num_w + den_w):
        raise out_of_range(dt)
    return Sampled.made(
        num=num_z,
        den=den_z + (0.0,) * delay,
        dt=dt,
        num_w=num_w,
        den_w=den_w,
        delay=delay,
    )


def to_plant(num_w: Exact, den_w: Exact, dt: float, *, theta: Decimal, a: Decimal) -> Plant:
    """Return the plant that ``to_sampled`` turns into num_w/den_w: the same rule backwards.

    w = s/(a - (2 theta - 1) s dt/2). num_w and den_w have the same length.
    Raises SpecError where a pole goes to s = infinity.

    >>> one, zero = Decimal(1), Decimal(0)
    >>> to_plant((zero, one), (one, zero), 2.0, theta=TUSTIN, a=one).den
    (1.0, 0.0)
    """
    n = len(den_w) - 1
    with digits.precision(_needed((*num_w, *den_w), (dt,), a, n)):
        rule = (_ONE, _ZERO), ((1 - 2 * theta) * Decimal(dt) / 2, a)
        num, den = (replaced(c, *rule, n) for c in (num_w, den_w))
    if not den[0]:
        raise SpecError(
            "system",
            f"must have no pole at z = {0 if theta == BACKWARD else -1} for this method",
            list(digits.rounded(den_w)),
            "its plant would be improper; use method 'forward', whose inverse always exists",
        )
    return Plant.from_exact(*(trimmed(c) for c in (num, den)))


def stretch(prewarp: float, dt: float) -> Decimal:
    """Return x cot x at x = prewarp dt/2: what maps w at that frequency to s = j prewarp.

    >>> float(stretch(1e-9, dt=1.0))
    1.0
    >>> from math import pi
    >>> abs(float(stretch(pi / 2, dt=1.0)) - pi / 4) < 1e-15  # x = 45 deg
    True
    """
    with digits.precision(digits.KEPT + 40):
        x = Decimal(prewarp) * Decimal(dt) / 2
        sine, cosine, term, k = _ZERO, _ZERO, _ONE, 0
        while term.adjusted() > -digits.KEPT - 40 or k < 4:
            cosine += term
            sine += term * x / (k + 1)
            term = -term * x * x / ((k + 1) * (k + 2))
            k += 2
        value = x * cosine / sine
    with digits.precision(digits.KEPT):
        return +value


def replaced(c: Sequence[Decimal], top: Exact, bottom: Exact, n: int) -> Exact:
    """Return bottom(x)^n c(top(x)/bottom(x)), n + 1 coefficients; top and bottom have degree 1.

    >>> from zoh.lti.digits import exact, rounded
    >>> one, both = exact([1.0, -1.0]), exact([1.0, 1.0])  # s^2 + 1 at (x - 1)/(x + 1)
    >>> rounded(replaced(exact([1.0, 0.0, 1.0]), one, both, 2))
    (2.0, 0.0, 2.0)
    """
    value: Exact = (_ZERO,)
    power: Exact = (_ONE,)
    for i, x in enumerate((_ZERO,) * (n + 1 - len(c)) + tuple(c)):
        if i:
            value, power = digits.times(value, top), digits.times(power, bottom)
        value = digits.plus(value, [x * p for p in power])
    return value


def trimmed(a: Exact) -> Exact:
    """Return ``a`` from its first coefficient that is not 0 on."""
    return a[next(i for i, c in enumerate(a) if c) :]


def _needed(values: Exact, floats: tuple[float, ...], a: Decimal, n: int) -> int:
    """Return the digits in which sums of n-fold products of these are exact."""
    of_factors = sum(digits.span([Decimal(f)]) for f in floats) + digits.span([a]) + 2
    return min(digits.span(values) + ceil((n + 1) * of_factors), _EXACT_TO) + 60
