"""From a sampled system back to the plant, by any method, and never unchecked.

The coefficients of a system lie in floats twice, in z and in w: fast poles keep their digits in
z, slow ones in w. The way back is gone from either, the plant found is sampled again, and the
one that returns closer to both forms is the answer, if it comes within 1e-9.
"""

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from math import log10

from zoh.errors import SpecError
from zoh.lti import digits, poly
from zoh.lti.digits import Exact
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.algebra import solve
from zoh.sampling.differences import replaced, trimmed
from zoh.sampling.distance import distance
from zoh.sampling.logarithm import NoLogarithm, artanh_of_roots
from zoh.sampling.ring import StepResponse, digits_needed

TOLERANCE = 1e-9  # of the distance between a system and its plant sampled again
_ROUNDING = 1e-15  # what the last digits of floats can do to that distance

_ZERO, _ONE = Decimal(0), Decimal(1)
_RESPONSE = {"impulse": 0, "zoh": 1, "foh": 2}  # integrations from an impulse to the input


@dataclass(frozen=True, slots=True, kw_only=True)
class Form:
    """The exact value of one form of a system, without its delay, in both variables.

    num_w, den_w  the same length n + 1
    num_z, den_z  without leading zeros; den_z has n + 1
    """

    num_w: Exact
    den_w: Exact
    num_z: Exact
    den_z: Exact
    dt: float


def by_rule(
    system: Sampled, back: Callable[[Form], Plant], again: Callable[[Plant], Sampled]
) -> Plant:
    """Return the plant by ``back``, which is exact; ``again`` samples it."""
    bare = _without(system, system.delay)
    return _checked(bare, back, again, system.delay)


def by_logarithm(system: Sampled, method: str, again: Callable[[Plant], Sampled]) -> Plant:
    """Return the plant of a system sampled with zoh, foh, impulse or matched.

    Raises SpecError where a pole has no logarithm or the plant does not come back.
    """
    delay = _trailing_zeros(system.den)
    if len(system.num) > len(system.den) - delay:
        raise SpecError(
            "system",
            f"must have no pole at z = 0 but those of a pure delay for method {method!r}",
            list(system.den),
            "no plant has one: exp(s dt) is never 0; use method 'forward'",
        )
    bare = _without(system, delay)

    def back(form: Form) -> Plant:
        with digits.precision(_digits(form)):
            try:
                return _unmatched(form) if method == "matched" else _unheld(form, method)
            except (NoLogarithm, ZeroDivisionError):
                raise SpecError(
                    "system",
                    "must have no pole (nor zero, if matched) on the negative real axis "
                    f"for method {method!r}",
                    [complex(z) for z in bare.poles()],
                    "no plant has one: use method 'tustin' or 'forward'",
                ) from None

    return _checked(bare, back, again, delay)


def _checked(
    bare: Sampled,
    back: Callable[[Form], Plant],
    again: Callable[[Plant], Sampled],
    delay: int,
) -> Plant:
    """Return the better of the two plants, with its dead time, if it is good enough."""
    best, least = None, float("inf")
    for form in (_in_z, _in_w):
        plant = back(form(bare))
        gap = distance(bare, again(plant))
        if best is None or gap < least:
            best, least = plant, gap
        if least <= _ROUNDING / 8:
            break
    if best is None or not least <= TOLERANCE:
        raise SpecError(
            "system",
            f"must come back within {TOLERANCE:g} when its plant is sampled again",
            least,
            "this method did not make it, or its digits no longer hold the plant; "
            "use method 'tustin', whose inverse is exact",
        )
    plain = _plainest(bare, best, again, max(least, _ROUNDING))
    return Plant.from_exact(*plain.exact, dead_time=delay * bare.dt)


def _plainest(
    bare: Sampled, plant: Plant, again: Callable[[Plant], Sampled], allowed: float
) -> Plant:
    """Return the plant with the lowest degree above the line that rounding cannot tell apart.

    Sampling turns zeros at infinity into finite ones, so rounded coefficients bring them back
    as zeros far out. Where the system is the same to its last digits without them, they go.
    """
    num, den = plant.exact
    for start in range(len(num) - 1, 0, -1):
        if not num[start]:
            continue
        plain = Plant.from_exact(num[start:], den)
        if distance(bare, again(plain)) <= allowed:
            return plain
    return plant


def _unheld(form: Form, method: str) -> Plant:
    """Return the plant whose response to the method's input is the system's.

    The samples of that response are linear in the derivatives at 0+, and the matrix is that of
    exp(sigma j) in the ring of the plant's poles.
    """
    order, den = _RESPONSE[method], _poles(form)
    values = _responses(form, order)
    augmented = (*den, _ZERO) if method == "foh" else den
    ring = StepResponse.of((_ONE,), augmented, _ONE, Decimal(form.dt))
    rows = [
        ring.exponential(Decimal(j)) if j else _unit(len(augmented)) for j in range(len(values))
    ]
    markov = solve(rows, values)
    n = len(augmented) - 1
    monic = [c * Decimal(form.dt) ** i for i, c in enumerate(augmented)]
    top = [
        sum((monic[i] * markov[j - i] for i in range(j + 1)), _ZERO) / Decimal(form.dt) ** j
        for j in range(n + 1)
    ]
    num = {"zoh": top, "foh": top[1:], "impulse": top[:-1]}[method]
    return Plant.from_exact(_cleaned(num, den, form), den)


def _responses(form: Form, order: int) -> list[Decimal]:
    """Return the system's response to the sampled input, as long as it has unknowns."""
    n = len(form.den_z) - 1
    num = (_ZERO,) * (n + 1 - len(form.num_z)) + form.num_z
    pulses: list[Decimal] = []
    for j in range(n + 1):
        past = sum((form.den_z[i] * pulses[j - i] for i in range(1, j + 1)), _ZERO)
        pulses.append((num[j] - past) / form.den_z[0])
    if order == 0:
        return [g / Decimal(form.dt) for g in pulses]
    total = [pulses[0]]
    for g in pulses[1:]:
        total.append(total[-1] + g)
    if order == 1:
        return total
    ramp = [_ZERO]
    for g in total:  # bends of r, one sample late: r_1 - 2 r_0 is the first
        ramp.append(ramp[-1] + g * Decimal(form.dt))
    return ramp


def _unmatched(form: Form) -> Plant:
    """Return the plant whose matched poles and zeros these are, its gain that as s goes to 0."""
    at_one = _trailing_zeros(form.num_w)
    at_minus_one = len(form.num_w) - len(trimmed(form.num_w))
    core = form.num_w[at_minus_one : len(form.num_w) - at_one]
    half = Decimal(form.dt) / 2
    core_z = replaced(core, (_ONE, -_ONE), (half, half), len(core) - 1)
    kept = len(form.num_z) - at_one - at_minus_one
    core_z = core_z[len(core_z) - kept :]  # the others are zeros at infinity
    core_w = replaced(core_z, (half, _ONE), (-half, _ONE), kept - 1)
    top = _logarithms(core_w, form.dt) + (_ZERO,) * at_one
    bottom = _poles(form)
    gain = _lowest(form.num_w) / _lowest(form.den_w) * _lowest(bottom) / _lowest(top)
    return Plant.from_exact(tuple(gain * c for c in top), bottom)


def _poles(form: Form) -> Exact:
    """Return the plant's monic denominator."""
    at_one = _trailing_zeros(form.den_w)
    return _logarithms(form.den_w[: len(form.den_w) - at_one], form.dt) + (_ZERO,) * at_one


def _logarithms(a_w: Exact, dt: float) -> Exact:
    """Return the monic polynomial in s of log(z)/dt for the roots z of one given in w."""
    if not a_w[0]:
        raise NoLogarithm  # z = -1
    half = Decimal(dt) / 2
    halves = artanh_of_roots([c / a_w[0] * half**i for i, c in enumerate(a_w)])
    return tuple(c / half**i for i, c in enumerate(halves))


def _cleaned(num: list[Decimal], den: Exact, form: Form) -> Exact:
    """Return num without what is only the rounding of a zero."""
    unit = Decimal(form.dt)
    sizes = [abs(c) * unit**i for i, c in enumerate(num)]
    nothing = max(sizes) * Decimal(10) ** (-_digits(form) // 4)
    kept = tuple(c if s > nothing else _ZERO for c, s in zip(num, sizes, strict=True))
    return trimmed(kept)


def _digits(form: Form) -> int:
    """Return digits enough for slow poles, whose powers cancel, and for fast ones near z = 0."""
    half = Decimal(form.dt) / 2
    moving = form.den_w[: len(form.den_w) - _trailing_zeros(form.den_w)]
    with digits.precision(60):
        in_p = tuple(c * half**i for i, c in enumerate(trimmed(moving)))
        fast = abs(form.den_z[-1] / form.den_z[0])
        depth = max(-log10(float(fast.scaleb(-fast.adjusted()))) - fast.adjusted(), 0.0)
    return 2 * digits_needed((_ONE,), in_p, 1.0) + 4 * int(depth)


def _in_w(bare: Sampled) -> Form:
    """Return the exact value of the w-form."""
    num, den, n = digits.exact(bare.num_w), digits.exact(bare.den_w), len(bare.den_w) - 1
    with digits.precision(_exact_digits(num, den, bare.dt)):
        half = Decimal(bare.dt) / 2
        num_z, den_z = (replaced(c, (_ONE, -_ONE), (half, half), n) for c in (num, den))
    # leading zeros of num are zeros at infinity by structure; in w they are lost to rounding
    return Form(num_w=num, den_w=den, num_z=num_z[n + 1 - len(bare.num) :], den_z=den_z, dt=bare.dt)


def _in_z(bare: Sampled) -> Form:
    """Return the exact value of the z-form."""
    num, den, n = digits.exact(bare.num), digits.exact(bare.den), len(bare.den) - 1
    with digits.precision(_exact_digits(num, den, bare.dt)):
        half = Decimal(bare.dt) / 2
        num_w, den_w = (replaced(c, (half, _ONE), (-half, _ONE), n) for c in (num, den))
    return Form(num_w=num_w, den_w=den_w, num_z=num, den_z=den, dt=bare.dt)


def _exact_digits(num: Exact, den: Exact, dt: float) -> int:
    n = len(den) - 1
    return min(digits.span((*num, *den)) + n * (digits.span([Decimal(dt)]) + 2), 6000) + 60


def _without(system: Sampled, delay: int) -> Sampled:
    """Return the system without z^-delay."""
    den = system.den[: len(system.den) - delay]
    if delay != system.delay:
        return Sampled(num=system.num, den=den, dt=system.dt)
    return Sampled.made(
        num=system.num, den=den, dt=system.dt, num_w=system.num_w, den_w=system.den_w
    )


def _unit(n: int) -> list[Decimal]:
    return [_ONE] + [_ZERO] * (n - 1)


def _trailing_zeros(a: poly.Poly | Exact) -> int:
    return next(i for i, c in enumerate(reversed(a)) if c)


def _lowest(a: Exact) -> Decimal:
    return a[len(a) - 1 - _trailing_zeros(a)]
