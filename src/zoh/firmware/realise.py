"""A controller as what a processor can run: a sum of parts, or second-order sections.

Everything is in d = z - 1, where a pole near z = 1 is a small number that keeps its digits, and in
fractions, so that nothing is rounded before a number format rounds it::

    Parallel   D = kp + ki/d + kd d/(d + alpha)        0 < alpha < 2, the pole is at z = 1 - alpha
    Section    (b0 d^2 + b1 d + b2)/(d^2 + a1 d + a2)

Source: R. H. Middleton and G. C. Goodwin, Digital Control and Estimation: A Unified Approach
(the delta operator); K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed.,
ch. 8 (PID) and ch. 9 (realisation of digital controllers).
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import zip_longest
from math import floor, inf, log2

import numpy as np
import numpy.typing as npt

from zoh.errors import SpecError
from zoh.lti import poly
from zoh.lti.systems import Sampled

Exact = tuple[Fraction, ...]  # coefficients in d, descending powers
MOST_SECTIONS = 12
_GRID = np.expm1(1j * np.geomspace(1e-7, np.pi, 400))  # d on the unit circle, z = 1 near by


@dataclass(frozen=True, slots=True, kw_only=True)
class Parallel:
    """kp + ki/d + kd d/(d + alpha); ki or kd is 0 where the part is not there."""

    kp: Fraction
    ki: Fraction
    kd: Fraction
    alpha: Fraction


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

    @classmethod
    def from_z(cls, b: Exact, a: Exact, order: int) -> "Section":
        """Return the section with these coefficients of z^-1."""
        (b0, b1, b2), (a1, a2) = b, a
        if order == 1:
            return cls(b=(b0, b1 + b0, b2), a=(a1 + 1, a2), order=1)
        return cls(b=(b0, b1 + 2 * b0, b2 + b1 + b0), a=(a1 + 2, a2 + a1 + 1), order=2)


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
            total = _sum(total, term)
        parts.append(total)
    unit = max(abs(c) for c in parts[1])
    num_w, den_w = (tuple(float(c / unit) for c in part) for part in parts)
    return Sampled.from_w(num_w=num_w, den_w=den_w, dt=dt)


def parallel(controller: Sampled) -> Parallel | None:
    """Return kp + ki/d + kd d/(d + alpha), None where the controller has another shape.

    >>> found = parallel(Sampled(num=[2.0, -1.5], den=[1.0, -1.0], dt=1.0))
    >>> found.kp == 2 and found.ki == Fraction(1, 2)  # 2 + 0.5/(z - 1)
    True
    """
    num, den = in_d(controller)
    integral = len(den) > 1 and den[-1] == 0
    rest = den[:-1] if integral else den
    if len(rest) > 2 or (len(rest) == 2 and not 0 < rest[1] < 2):
        return None
    alpha = rest[1] if len(rest) == 2 else Fraction(0)
    top = (Fraction(0),) * (len(den) - len(num)) + num
    far = top[0]
    ki = (num[-1] / rest[-1]) if integral else Fraction(0)
    # at d = -alpha: the residue of den = d^integral (d + alpha) is -kd alpha
    kd = Fraction(0)
    if alpha:
        residue = _value(top, -alpha) / (-alpha if integral else 1)
        kd = -residue / alpha
    return Parallel(kp=far - kd, ki=ki, kd=kd, alpha=alpha)


def sections(controller: Sampled) -> tuple[Section, ...]:
    """Return second-order sections whose product is the controller, the slowest poles last.

    An integrator stays one exactly. All of the gain is in the last section, whose output is u.
    """
    num, den = in_d(controller)
    count = len(den) // 2
    if count > MOST_SECTIONS:
        most = f"must be {2 * MOST_SECTIONS} or lower"
        raise SpecError("order", most, len(den) - 1, "choose a simpler controller")
    poles, zeros = _quadratics(den), _quadratics(num)
    pairs = _matched(zeros, poles)
    gain = num[0]
    made = []
    for i, (top, bottom) in enumerate(pairs):
        last = i == len(pairs) - 1
        scaled = tuple(c * gain for c in top) if last else top
        made.append(_section(scaled, bottom))
    return tuple(made) or (_section((gain, gain), (Fraction(1), Fraction(1))),)


def product(a: Exact, b: Exact) -> Exact:
    """Return the product of two polynomials."""
    out = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i + j] += x * y
    return tuple(out)


def together(parts: tuple[Section, ...]) -> tuple[Exact, Exact]:
    """Return num and den of sections in series."""
    num: Exact = (Fraction(1),)
    den: Exact = (Fraction(1),)
    for part in parts:
        n = part.order
        num = product(num, part.b[: n + 1])
        den = product(den, (Fraction(1), *part.a[:n]))
    return num, den


def levelled(parts: tuple[Section, ...]) -> tuple[Section, ...]:
    """Return the same product, powers of two moved so that no section but the last amplifies.

    Up to each of them the gain at every frequency is then 1/2 at most, so that an error of twice
    full scale passes; what is taken away is given back by the last one.
    """
    passed = np.ones(_GRID.shape, complex)
    moved, owed = [], Fraction(1)
    for part in parts[:-1]:
        gain = _on_circle(part)
        peak = float(np.abs(passed * gain).max())
        factor = Fraction(2) ** (-2 - floor(log2(peak))) if 0 < peak < inf else Fraction(1)
        moved.append(replace(part, b=_scaled(part.b, factor)))
        passed, owed = passed * gain * float(factor), owed / factor
    last = parts[-1]
    return (*moved, replace(last, b=_scaled(last.b, owed)))


def _scaled(
    b: tuple[Fraction, Fraction, Fraction], c: Fraction
) -> tuple[Fraction, Fraction, Fraction]:
    return c * b[0], c * b[1], c * b[2]


def _on_circle(part: Section) -> npt.NDArray[np.complex128]:
    b, a = (np.array([float(c) for c in x]) for x in (part.b, (Fraction(1), *part.a)))
    n = part.order
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.polyval(b[: n + 1], _GRID) / np.polyval(a[: n + 1], _GRID)
    return np.asarray(found, complex)


def _from_w(a: tuple[float, ...], dt: float) -> Exact:
    """Return (1 + d/2)^n a(w) at w = (2/dt) d/(2 + d), times (dt/2)^n: a polynomial in d."""
    h, n = Fraction(dt) / 2, len(a) - 1
    total: Exact = (Fraction(0),) * (n + 1)
    for i, c in enumerate(a):  # w^(n-i) is d^(n-i) (2 + d)^i h^i
        term: Exact = (Fraction(c) * h**i,) + (Fraction(0),) * (n - i)
        for _ in range(i):
            term = product(term, (Fraction(1), Fraction(2)))
        total = _sum(total, term)
    return total


def _sum(a: Exact, b: Exact) -> Exact:
    pairs = zip_longest(reversed(a), reversed(b), fillvalue=Fraction(0))
    return tuple(x + y for x, y in pairs)[::-1]


def _value(a: Exact, x: Fraction) -> Fraction:
    value = Fraction(0)
    for c in a:
        value = value * x + c
    return value


def _quadratics(a: Exact) -> list[Exact]:
    """Return factors of degree 2, and one of degree 1 where there must be, smallest roots last.

    The roots at d = 0 are exact. A pair of real or conjugate roots is put together exactly.
    """
    if len(a) <= 3:
        return [tuple(c / a[0] for c in a)] if len(a) > 1 else []
    found = poly.roots(tuple(float(c / a[0]) for c in a))
    real = sorted((r.real for r in found if r.imag == 0), key=abs)
    factors: list[Exact] = []
    for r in found:
        if r.imag > 0:
            re, im = Fraction(r.real), Fraction(r.imag)
            factors.append((Fraction(1), -2 * re, re * re + im * im))
    for i in range(0, len(real), 2):
        factor: Exact = (Fraction(1),)
        for root in real[i : i + 2]:
            factor = product(factor, (Fraction(1), -Fraction(root)))
        factors.append(factor)
    return sorted(factors, key=_size, reverse=True)


def _size(factor: Exact) -> tuple[float, float]:
    """Return how far from 0 the roots of a factor are; what has a root there comes first."""
    n = len(factor) - 1
    away = float(abs(factor[-1])) ** (1 / n)
    return away, float(abs(factor[1]))


def _matched(zeros: list[Exact], poles: list[Exact]) -> list[tuple[Exact, Exact]]:
    """Return each pole factor with a zero factor of no higher degree, the nearest that is left."""
    left = list(zeros)
    pairs: list[tuple[Exact, Exact]] = []
    for bottom in reversed(poles):  # the slowest choose first
        spare = sum(len(p) == 3 for p in poles) - sum(len(b) == 3 for _, b in pairs)
        wanted = sum(len(z) == 3 for z in left)
        fits = [z for z in left if len(z) <= len(bottom)]
        if len(bottom) == 3 and wanted == spare and wanted:
            fits = [z for z in fits if len(z) == 3]
        if fits:
            near = min(fits, key=lambda z: abs(_size(z)[0] - _size(bottom)[0]))
            left.remove(near)
        else:
            near = (Fraction(1),)
        pairs.append((near, bottom))
    return pairs[::-1]


def _section(top: Exact, bottom: Exact) -> Section:
    order = max(1, len(bottom) - 1)
    top = (Fraction(0),) * (len(bottom) - len(top)) + top
    b0, b1, b2 = (*top, Fraction(0), Fraction(0))[:3]
    a1, a2 = (*bottom[1:], Fraction(0), Fraction(0))[:2]
    return Section(b=(b0, b1, b2), a=(a1, a2), order=order)
