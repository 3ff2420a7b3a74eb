"""From a sampled system back to the plant, by any method, and never unchecked.

The coefficients of a system lie in floats twice, in z and in w: fast poles keep their digits in
z, slow ones in w. The way back is gone from either, the plant found is sampled again, and the
one that returns closer to both forms is the answer, if it comes within 1e-9.
"""

from collections.abc import Callable
from contextlib import suppress
from decimal import Decimal, getcontext
from math import log10

from zoh.errors import SpecError
from zoh.lti import digits
from zoh.lti.digits import Exact
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.algebra import Ring, solve
from zoh.sampling.differences import TUSTIN, to_plant, trimmed
from zoh.sampling.distance import distance
from zoh.sampling.forms import Form, in_w, in_z, trailing_zeros, with_zeros_at_minus_one
from zoh.sampling.logarithm import NoLogarithm, artanh_of_roots
from zoh.sampling.ring import StepResponse, digits_needed

TOLERANCE = 1e-9  # of the distance between a system and its plant sampled again
_ROUNDING = 1e-15  # what the last digits of floats can do to that distance
_DOUBTFUL = Decimal("1e-6")  # of the largest term at |s| = 1/dt: more is no rounding

_ZERO, _ONE = Decimal(0), Decimal(1)
_RESPONSE = {"impulse": 0, "zoh": 1, "foh": 2}  # integrations from an impulse to the input


def by_rule(
    system: Sampled, theta: Decimal, a: Decimal, again: Callable[[Plant], Sampled]
) -> Plant:
    """Return the plant of a system made by the difference rule theta, a; ``again`` makes it."""
    bare = _without(system, system.delay)
    if theta == TUSTIN:  # w is s, up to a: nothing to lose, whatever z looks like
        num, den = digits.exact(bare.num_w), digits.exact(bare.den_w)
        plant = to_plant(num, den, bare.dt, theta=theta, a=a)
    else:
        plant = _checked(
            bare,
            lambda form: to_plant(form.shaped_w, form.den_w, form.dt, theta=theta, a=a),
            again,
        )
    return _late(plant, system.delay * system.dt)


def by_logarithm(system: Sampled, method: str, again: Callable[[Plant], Sampled]) -> Plant:
    """Return the plant of a system sampled with zoh, foh, impulse or matched.

    Raises SpecError where a pole has no logarithm or the plant does not come back.
    """
    delay = trailing_zeros(system.den)
    if len(system.num) > len(system.den) - delay:
        raise SpecError(
            "system",
            f"must have no pole at z = 0 but those of a pure delay for method {method!r}",
            list(system.den),
            "no plant has one: exp(s dt) is never 0; use method 'forward'",
        )
    bare = _without(system, delay)

    def back(form: Form) -> Plant:
        try:
            with digits.precision(_digits(form)):
                return _unmatched(form) if method == "matched" else _unheld(form, method)
        except (NoLogarithm, ZeroDivisionError):
            raise SpecError(
                "system",
                "must have no pole (nor zero, if matched) on the negative real axis "
                f"for method {method!r}",
                [complex(z) for z in bare.poles()],
                "no plant has one: use method 'tustin' or 'forward'",
            ) from None

    plain = with_zeros_at_minus_one(bare) if method == "matched" else bare
    if plain.num_w != bare.num_w:
        with suppress(SpecError):  # the plainer plant, where rounding cannot tell
            return _late(_checked(plain, back, again), delay * bare.dt)
    return _late(_checked(bare, back, again), delay * bare.dt)


def _checked(
    bare: Sampled, back: Callable[[Form], Plant], again: Callable[[Plant], Sampled]
) -> Plant:
    """Return the better of the two forms' plants, if it is good enough."""
    found: list[tuple[float, Plant]] = []
    for form in (in_w, in_z):
        try:
            found.append(_plainest(bare, back(form(bare)), again))
        except SpecError as error:  # rounding may have moved a pole to where none can be
            refused = error
        if found and found[-1][0] <= _ROUNDING:
            break
    if not found:
        raise refused
    gap, plant = min(found, key=lambda pair: pair[0])
    if not gap <= TOLERANCE:
        raise SpecError(
            "system",
            f"must come back within {TOLERANCE:g} when its plant is sampled again",
            gap,
            "this method did not make it, or its digits no longer hold the plant; "
            "use method 'tustin', whose inverse is exact",
        )
    return plant


def _plainest(
    bare: Sampled, plant: Plant, again: Callable[[Plant], Sampled]
) -> tuple[float, Plant]:
    """Return the plant of lowest degree above the line that rounding cannot tell, and its gap.

    Sampling turns zeros at infinity into finite ones, so rounded coefficients bring them back
    as zeros far out. Where the system is the same to its last digits without them, they go.
    """
    gap = distance(bare, again(plant))
    num, den = plant.exact
    with digits.precision(digits.KEPT):
        sizes = [abs(c) * Decimal(bare.dt) ** i for i, c in enumerate(num)]
        doubtful = _DOUBTFUL * max(sizes)
    noise = next(i for i, s in enumerate(sizes) if s > doubtful)
    for start in range(noise, 0, -1):
        plain = Plant.from_exact(num[start:], den)
        without = distance(bare, again(plain))
        if without <= max(gap, _ROUNDING):
            return without, plain
    return gap, plant


def _unheld(form: Form, method: str) -> Plant:
    """Return the plant whose response to the method's input is the system's.

    The samples of that response are linear in the derivatives at 0+, and the matrix is that of
    exp(sigma j) in the ring of the plant's poles.
    """
    if method == "impulse" and len(form.den_z) == 1:
        raise SpecError(
            "system",
            "must have a pole for method 'impulse'",
            [float(form.num_z[0] / form.den_z[0])],
            "a gain without poles has no sampled impulse response; use method 'zoh'",
        )
    order, den = _RESPONSE[method], _poles(form)
    values = _responses(form, order)
    augmented = (*den, _ZERO) if method == "foh" else den
    ring = StepResponse.of((_ONE,), augmented, _ONE, Decimal(form.dt))
    powers = Ring(modulus=ring.modulus)
    rows, one_sample = [powers.constant(_ONE)], ring.exponential(_ONE)
    for _ in values[1:]:
        rows.append(powers.product(rows[-1], one_sample))
    markov = solve(rows, values)
    n = len(augmented) - 1
    monic = [c * Decimal(form.dt) ** i for i, c in enumerate(augmented)]
    top = [
        sum((monic[i] * markov[j - i] for i in range(j + 1)), _ZERO) / Decimal(form.dt) ** j
        for j in range(n + 1)
    ]
    num = {"zoh": top, "foh": top[1:], "impulse": top[:-1]}[method]
    return Plant.from_exact(_cleaned(num, form.dt), den)


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
    at_one = trailing_zeros(form.top_w)
    core = trimmed(form.top_w)  # zeros at z = -1 are zeros at s = infinity
    top = _logarithms(core[: len(core) - at_one], form.dt) + (_ZERO,) * at_one
    bottom = _poles(form)
    gain = _lowest(form.num_w) / _lowest(form.den_w) * _lowest(bottom) / _lowest(top)
    return Plant.from_exact(_cleaned([gain * c for c in top], form.dt), bottom)


def _poles(form: Form) -> Exact:
    """Return the plant's monic denominator."""
    at_one = trailing_zeros(form.den_w)
    return _logarithms(form.den_w[: len(form.den_w) - at_one], form.dt) + (_ZERO,) * at_one


def _logarithms(a_w: Exact, dt: float) -> Exact:
    """Return the monic polynomial in s of log(z)/dt for the roots z of one given in w."""
    if not a_w[0]:
        raise NoLogarithm  # z = -1
    half = Decimal(dt) / 2
    halves = artanh_of_roots([c / a_w[0] * half**i for i, c in enumerate(a_w)])
    return tuple(c / half**i for i, c in enumerate(halves))


def _cleaned(num: list[Decimal], dt: float) -> Exact:
    """Return num without what is only the rounding of a zero."""
    unit = Decimal(dt)
    sizes = [abs(c) * unit**i for i, c in enumerate(num)]
    nothing = max(sizes) * Decimal(10) ** (-getcontext().prec // 3)
    kept = tuple(c if s > nothing else _ZERO for c, s in zip(num, sizes, strict=True))
    return trimmed(kept)


def _digits(form: Form) -> int:
    """Return digits enough for slow poles, whose powers cancel, and for fast ones near z = 0."""
    if not form.den_z[-1]:
        raise NoLogarithm  # in this form a fast pole has been rounded to z = 0
    half = Decimal(form.dt) / 2
    moving = form.den_w[: len(form.den_w) - trailing_zeros(form.den_w)]
    with digits.precision(60):
        in_p = tuple(c * half**i for i, c in enumerate(trimmed(moving)))
        fast = abs(form.den_z[-1] / form.den_z[0])
        depth = max(-log10(float(fast.scaleb(-fast.adjusted()))) - fast.adjusted(), 0.0)
    return digits_needed((_ONE,), in_p, 1.0) + 2 * int(depth) + 40


def _late(plant: Plant, dead_time: float) -> Plant:
    """Return the plant with this dead time in s."""
    return Plant.from_exact(*plant.exact, dead_time=dead_time)


def _without(system: Sampled, delay: int) -> Sampled:
    """Return the system without z^-delay."""
    den = system.den[: len(system.den) - delay]
    if delay != system.delay:
        return Sampled(num=system.num, den=den, dt=system.dt)
    return Sampled.made(
        num=system.num, den=den, dt=system.dt, num_w=system.num_w, den_w=system.den_w
    )


def _lowest(a: Exact) -> Decimal:
    return a[len(a) - 1 - trailing_zeros(a)]
