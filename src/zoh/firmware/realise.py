"""A controller as what a processor can run: a sum of parts, or second-order sections.

Everything is in d = z - 1, where a pole near z = 1 is a small number that keeps its digits, and in
fractions, so that nothing is rounded before a number format rounds it::

    Parallel   D = kp + ki/d + sum kd d/(d + alpha)    0 < alpha < 2, a pole is at z = 1 - alpha
    Section    (b0 d^2 + b1 d + b2)/(d^2 + a1 d + a2)

Source: R. H. Middleton and G. C. Goodwin, Digital Control and Estimation: A Unified Approach
(the delta operator); K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed.,
ch. 8 (PID) and ch. 9 (realisation of digital controllers).
"""

from dataclasses import dataclass
from fractions import Fraction

from zoh.errors import SpecError
from zoh.firmware.factors import Exact, matched, plus, product, quadratics, value
from zoh.lti import poly
from zoh.lti.systems import Sampled

MOST_SECTIONS = 12
_APART = 1e-3  # of a pole: nearer to each other their parts would all but cancel


@dataclass(frozen=True, slots=True, kw_only=True)
class Filter:
    """kd d/(d + alpha): a difference, filtered; its pole is at z = 1 - alpha."""

    kd: Fraction
    alpha: Fraction


@dataclass(frozen=True, slots=True, kw_only=True)
class Parallel:
    """kp + ki/d + the sum of filtered differences; ki is 0 where there is no integral."""

    kp: Fraction
    ki: Fraction
    filters: tuple[Filter, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """(b0 d^2 + b1 d + b2)/(d^2 + a1 d + a2); of order 1 (b0 d + b1)/(d + a1), b2 = a2 = 0."""

    b: tuple[Fraction, Fraction, Fraction]
    a: tuple[Fraction, Fraction]
    order: int

    @property
    def in_z(self) -> tuple[tuple[Fraction, Fraction, Fraction], tuple[Fraction, Fraction]]:
        """Return (b, a) in powers of z^-1, b0 + b1 z^-1 + b2 z^-2 over 1 + a1 z^-1 + a2 z^-2.

        >>> one, two = Fraction(1), Fraction(2)
        >>> Section(b=(one, one, one), a=(two, one), order=2).in_z == ((1, -1, 1), (0, 0))
        True
        """
        (b0, b1, b2), (a1, a2) = self.b, self.a
        if self.order == 1:
            return (b0, b1 - b0, b2), (a1 - 1, a2)
        return (b0, b1 - 2 * b0, b2 - b1 + b0), (a1 - 2, a2 - a1 + 1)


def in_d(controller: Sampled) -> tuple[Exact, Exact]:
    """Return num and den in d = z - 1, exactly, the first coefficient of den being 1.

    >>> in_d(Sampled(num=[3.0], den=[1.0, -0.5], dt=1.0))
    ((Fraction(3, 1),), (Fraction(1, 1), Fraction(1, 2)))
    """
    num, den = (_from_w(a, controller.dt) for a in (controller.num_w, controller.den_w))
    for _ in range(controller.delay):
        den = product(den, (Fraction(1), Fraction(1)))
    # what z says is no zero is not the rounding of w
    num = num[max(0, len(num) - len(controller.num)) :]
    while den[0] == 0:
        den = den[1:]
    return tuple(c / den[0] for c in num), tuple(c / den[0] for c in den)


def from_d(num: Exact, den: Exact, dt: float) -> Sampled:
    """Return num/den in d as a system; what is rounded is the result, once.

    >>> from_d((Fraction(3),), (Fraction(1), Fraction(1, 2)), 1.0).den
    (1.0, -0.5)
    """
    h, n = Fraction(dt) / 2, len(den) - 1  # d = 2 h w/(1 - h w)
    parts = []
    for part in (num, den):
        total: Exact = (Fraction(0),) * (n + 1)
        for i, c in enumerate(reversed(part)):
            term: Exact = (c * (2 * h) ** i,) + (Fraction(0),) * i
            for _ in range(n - i):
                term = product(term, (-h, Fraction(1)))
            total = plus(total, term)
        parts.append(total)
    unit = max(abs(c) for c in parts[1])
    num_w, den_w = (tuple(float(c / unit) for c in part) for part in parts)
    return Sampled.from_w(num_w=num_w, den_w=den_w, dt=dt)


def parallel(controller: Sampled) -> Parallel | None:
    """Return the controller as a sum of parts, None where it has another shape.

    It has this one where its poles are, beside one at z = 1, at most two, real, apart from each
    other and inside the unit circle.

    >>> found = parallel(Sampled(num=[2.0, -1.5], den=[1.0, -1.0], dt=1.0))
    >>> found.kp == 2 and found.ki == Fraction(1, 2)  # 2 + 0.5/(z - 1)
    True
    """
    return in_parts(*in_d(controller))


def in_parts(num: Exact, den: Exact) -> Parallel | None:
    """Return num/den in d as the sum that ``parallel`` says, None where it has another shape.

    >>> in_parts((Fraction(2), Fraction(1, 2)), (Fraction(1), Fraction(0))).ki == Fraction(1, 2)
    True
    """
    integral = len(den) > 1 and den[-1] == 0
    alphas = _real_poles(den[:-1] if integral else den)
    if alphas is None:
        return None
    filters, top = [], (Fraction(0),) * (len(den) - len(num)) + num
    for alpha in alphas:  # the residue at d = -alpha is -kd alpha
        others = Fraction(1)
        for other in alphas:
            others *= other - alpha if other != alpha else 1
        residue = value(top, -alpha) / (others * (-alpha if integral else 1))
        filters.append(Filter(kd=-residue / alpha, alpha=alpha))
    filters = [f for f in filters if f.kd]
    ki = num[-1] / den[-2] if integral else Fraction(0)
    return Parallel(kp=top[0] - sum(f.kd for f in filters), ki=ki, filters=tuple(filters))


def _real_poles(den: Exact) -> tuple[Fraction, ...] | None:
    """Return alpha of each pole at d = -alpha, None unless they are as ``parallel`` needs them."""
    if len(den) > 3:
        return None
    if len(den) == 3:
        found = [-r for r in poly.roots(tuple(float(c) for c in den))]
        if any(r.imag for r in found) or abs(found[0] - found[1]) < _APART * abs(found[0]):
            return None
        alphas = tuple(Fraction(r.real) for r in found)
    else:
        alphas = den[1:]
    return alphas if all(0 < alpha < 2 for alpha in alphas) else None


def sections(controller: Sampled) -> tuple[Section, ...]:
    """Return second-order sections whose product is the controller, the slowest poles last.

    An integrator stays one exactly. All of the gain is in the last section, whose output is u.
    """
    num, den = in_d(controller)
    count = len(den) // 2
    if count > MOST_SECTIONS:
        most = f"must be {2 * MOST_SECTIONS} or lower"
        raise SpecError("order", most, len(den) - 1, "choose a simpler controller")
    poles, zeros = quadratics(den), quadratics(num)
    pairs = matched(zeros, poles)
    gain = num[0]
    made = []
    for i, (top, bottom) in enumerate(pairs):
        last = i == len(pairs) - 1
        scaled = tuple(c * gain for c in top) if last else top
        made.append(_section(scaled, bottom))
    return tuple(made) or (_section((gain, gain), (Fraction(1), Fraction(1))),)


def _from_w(a: tuple[float, ...], dt: float) -> Exact:
    """Return (1 + d/2)^n a(w) at w = (2/dt) d/(2 + d), times (dt/2)^n: a polynomial in d."""
    h, n = Fraction(dt) / 2, len(a) - 1
    total: Exact = (Fraction(0),) * (n + 1)
    for i, c in enumerate(a):  # w^(n-i) is d^(n-i) (2 + d)^i h^i
        term: Exact = (Fraction(c) * h**i,) + (Fraction(0),) * (n - i)
        for _ in range(i):
            term = product(term, (Fraction(1), Fraction(2)))
        total = plus(total, term)
    return total


def _section(top: Exact, bottom: Exact) -> Section:
    order = max(1, len(bottom) - 1)
    top = (Fraction(0),) * (len(bottom) - len(top)) + top
    b0, b1, b2 = (*top, Fraction(0), Fraction(0))[:3]
    a1, a2 = (*bottom[1:], Fraction(0), Fraction(0))[:2]
    return Section(b=(b0, b1, b2), a=(a1, a2), order=order)
