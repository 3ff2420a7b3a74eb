"""What the floats of a sampled system say exactly: once in its z-form, once in its w-form.

The two differ by rounding. Fast poles keep their digits in z, slow ones in w.
"""

from dataclasses import dataclass
from decimal import Decimal
from math import comb

from zoh.lti import digits
from zoh.lti.digits import Exact
from zoh.lti.systems import Sampled
from zoh.sampling.differences import replaced, trimmed

_ZERO, _ONE = Decimal(0), Decimal(1)
_LAST_DIGIT = Decimal(2) ** -52


@dataclass(frozen=True, slots=True, kw_only=True)
class Form:
    """The exact value of one form of a system, without its delay, in both variables.

    num_w, den_w  the same length n + 1
    num_z, den_z  without leading zeros; den_z has n + 1
    top_w         num_z in w at its own degree, its zeros at z = 0, -1, 1 and infinity exact
    shaped_w      top_w (1 - w dt/2)^(n - deg num_z): num_w with those zeros exact
    """

    num_w: Exact
    den_w: Exact
    top_w: Exact
    shaped_w: Exact
    num_z: Exact
    den_z: Exact
    dt: float


def in_w(bare: Sampled) -> Form:
    """Return the exact value of the w-form, its numerator as that of z shapes it.

    Zeros at infinity and at 0 are p = 1 and -1, p = w dt/2: rounding has moved them, so their
    factors are divided out, lowest powers first, and what is left above is rounding.
    """
    num, den, n = digits.exact(bare.num_w), digits.exact(bare.den_w), len(bare.den_w) - 1
    with digits.precision(_exact_digits(num, den, bare.dt)):
        half = Decimal(bare.dt) / 2
        den_z = replaced(den, (_ONE, -_ONE), (half, half), n)
        minus_one = len(num) - len(trimmed(num))
        origin = trailing_zeros(bare.num)
        core = trimmed(num)[::-1]
        for factor, times in ((-half, n + 1 - len(bare.num)), (half, origin)):
            for _ in range(times):
                core = _divided(core, factor)
        core = core[::-1]
        for _ in range(origin):
            core = digits.times(core, (half, _ONE))
        top = (_ZERO,) * minus_one + core
        unit = (2 * half) ** (len(den) - len(top))  # (1 - w dt/2) dt/2 (z + 1) is dt
        num_z = tuple(c * unit for c in replaced(top, (_ONE, -_ONE), (half, half), len(top) - 1))
        shaped = top
        for _ in range(len(den) - len(top)):
            shaped = digits.times(shaped, (-half, _ONE))
    return Form(
        num_w=num, den_w=den, top_w=top, shaped_w=shaped, num_z=num_z, den_z=den_z, dt=bare.dt
    )


def _divided(ascending: Exact, slope: Decimal) -> Exact:
    """Return a(w)/(1 + slope w), the remainder left at the highest power and dropped."""
    quotient = [ascending[0]]
    for c in ascending[1:-1]:
        quotient.append(c - slope * quotient[-1])
    return tuple(quotient)


def in_z(bare: Sampled) -> Form:
    """Return the exact value of the z-form, its roots at z = -1 and 1 as the w-form has them.

    There they are p = infinity and 0, where w says exactly how many there are: rounding has
    moved them, so their factors are divided out, lowest powers first, and what is left above is
    rounding.
    """
    num, den, n = digits.exact(bare.num), digits.exact(bare.den), len(bare.den) - 1
    with digits.precision(_exact_digits(num, den, bare.dt)):
        half = Decimal(bare.dt) / 2
        num, den = (_with_ends(a, w) for a, w in ((num, bare.num_w), (den, bare.den_w)))
        num_w, den_w = (replaced(c, (half, _ONE), (-half, _ONE), n) for c in (num, den))
        top_w = replaced(num, (half, _ONE), (-half, _ONE), len(num) - 1)
    return Form(
        num_w=num_w, den_w=den_w, top_w=top_w, shaped_w=num_w, num_z=num, den_z=den, dt=bare.dt
    )


def _with_ends(a: Exact, in_w: tuple[float, ...]) -> Exact:
    """Return a(z) with as many roots at -1 and 1 as its form in w has at infinity and 0."""
    ends = (_ONE, len(in_w) - len(trimmed(digits.exact(in_w)))), (-_ONE, trailing_zeros(in_w))
    core = a[::-1]  # lowest powers first: fast poles lie in the smallest of them
    for slope, times in ends:
        for _ in range(times):
            core = _divided(core, slope)
    core = core[::-1]
    for slope, times in ends:
        for _ in range(times):
            core = digits.times(core, (slope, _ONE))
    return core


def with_zeros_at_minus_one(bare: Sampled) -> Sampled:
    """Return the system with every zero at z = -1 that the rounding of its z-coefficients hides.

    There a zero is one of the leading zeros in w; (z + 1)^k of rounded coefficients leaves next
    to nothing in their place.

    >>> g = Sampled(num=[0.1, 0.3, 0.3, 0.1], den=[1, -0.5, 0.2, 0.1], dt=1.0)
    >>> g.num_w[1] > 0, with_zeros_at_minus_one(g).num_w[:3]
    (True, (0.0, 0.0, 0.0))
    """
    num, n = digits.exact(bare.num), len(bare.num) - 1
    with digits.precision(_exact_digits(num, num, 1.0)):
        in_p = replaced(num, (_ONE, _ONE), (-_ONE, _ONE), n)
        most = sum(map(abs, num)) * _LAST_DIGIT
        hidden = next((j for j in range(n) if abs(in_p[j]) > most * comb(n, j)), n)
    num_w = (0.0,) * hidden + bare.num_w[hidden:]
    return Sampled.made(num=bare.num, den=bare.den, dt=bare.dt, num_w=num_w, den_w=bare.den_w)


def _exact_digits(num: Exact, den: Exact, dt: float) -> int:
    n = len(den) - 1
    return min(digits.span((*num, *den)) + n * (digits.span([Decimal(dt)]) + 2), 6000) + 60


def trailing_zeros(a: tuple[float, ...] | Exact) -> int:
    """Return how many of the last coefficients are 0."""
    return next(i for i, c in enumerate(reversed(a)) if c)
