"""Exact polynomials in z, rounded once into both forms of a ``Sampled``.

A method of sampling ends with a numerator in z, the polynomial of the poles that are not at
z = 1, and the number of those that are. What must be zero by structure is made zero here; all
else is a float of a number with digits to spare.
"""

from collections.abc import Sequence
from decimal import Decimal, getcontext
from math import inf

from zoh.errors import SpecError
from zoh.lti import digits
from zoh.lti.digits import Exact
from zoh.lti.systems import Sampled
from zoh.lti.wplane import to_bilinear

_ZERO, _ONE = Decimal(0), Decimal(1)
_AT_ONE = (_ONE, -_ONE)


def in_both_forms(
    *,
    num: Sequence[Decimal],
    moving: Exact,
    at_one: int,
    zeros_at_one: int,
    dt: float,
    delay: int,
) -> Sampled:
    """Return num(z)/(moving(z) (z-1)^at_one) z^-delay, rounded once in z and once in w.

    num           shape (n + 1,), n = deg moving + at_one
    moving        monic, the poles that are not at z = 1
    zeros_at_one  how many zeros num has at z = 1 by structure
    dt            s; delay in samples

    To be called with the precision num and moving were made with. Raises SpecError where a
    coefficient leaves a float's range.

    >>> num, one = digits.exact([0.0, 1.0]), digits.exact([1.0])
    >>> with digits.precision(60):
    ...     in_both_forms(num=num, moving=one, at_one=1, zeros_at_one=0, dt=2.0, delay=0)
    Sampled(num=(1.0,), den=(1.0, -1.0), dt=2.0)
    """
    n, half = len(num) - 1, Decimal(dt) / 2
    # what cancels exactly leaves rounding behind; no true coefficient is anywhere near as small
    nothing = max(abs(c) for c in num) * Decimal(10) ** (30 - getcontext().prec)
    top = [c if abs(c) > nothing else _ZERO for c in num]
    bottom = moving
    for _ in range(at_one):
        bottom = digits.times(bottom, _AT_ONE)
    top_p = [c if abs(c) > nothing else _ZERO for c in to_bilinear(num, n)]
    top_p[n + 1 - zeros_at_one :] = [_ZERO] * zeros_at_one
    bottom_p = tuple(c * 2**at_one for c in to_bilinear(moving, n - at_one)) + (_ZERO,) * at_one
    scale = [half ** (n - i) for i in range(n + 1)]
    unit = next(c * s for c, s in zip(bottom_p, scale, strict=True) if c)
    try:
        return Sampled.made(
            num=_floats(top),
            den=_floats(bottom) + (0.0,) * delay,
            dt=dt,
            num_w=_floats([c * s / unit for c, s in zip(top_p, scale, strict=True)]),
            den_w=_floats([c * s / unit for c, s in zip(bottom_p, scale, strict=True)]),
            delay=delay,
        )
    except OverflowError:
        raise out_of_range(dt) from None


def out_of_range(dt: float) -> SpecError:
    """Return the error of a system whose coefficients do not fit a float at this dt."""
    return SpecError(
        "dt",
        "must keep the sampled system within a float's range",
        dt,
        "sample faster: a coefficient outgrows 1e308",
    )


def with_a_gain(system: Sampled) -> Sampled:
    """Return the system, or raise SpecError where no float is small enough for its numerator."""
    if any(system.num):
        return system
    raise SpecError(
        "dt",
        "must leave the sampled plant a gain that a float can hold",
        system.dt,
        "sample more slowly, or count the output in a smaller unit",
    )


def _floats(values: Sequence[Decimal]) -> tuple[float, ...]:
    """Return the nearest floats, or raise OverflowError."""
    result = digits.rounded(values)
    if inf in map(abs, result):
        raise OverflowError
    return result
