"""The step response of a rational plant, in a ring where the exponential is a polynomial.

Modulo M(sigma) = sigma den(sigma), sigma = s dt, the function exp(sigma t) is a polynomial of
degree n, and every value of the step response y is a linear functional of it::

    y(t dt) = l(exp(sigma t) mod M),    l(sigma^i) = the i-th derivative of y at 0+

That turns sampling into arithmetic on n + 1 numbers, without one root being sought. The digits
of that arithmetic are chosen beforehand, so that what is left at the end is exact to a float.
Source: the ring is that of C. Moler, C. Van Loan, Nineteen Dubious Ways to Compute the
Exponential of a Matrix, SIAM Review 45(1), 2003, method 8 (Cayley-Hamilton), which digits cure.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, Overflow
from math import ceil, log10

from zoh.errors import SpecError
from zoh.lti.digits import Exact, precision
from zoh.sampling.algebra import from_power_sums, power_sums

_ZERO, _ONE = Decimal(0), Decimal(1)
_LN10 = 2.302585092994046
_MOST_HALVINGS = 60  # of the exponential's argument: a mode 1e17 times faster than dt
_CAP = 800.0  # digits; what is smaller than 1e-800 of its neighbour is 0 in a float


def _log10(c: Decimal) -> float:
    return c.adjusted() + log10(abs(float(c.scaleb(-c.adjusted()))))


def _bound(monic: Sequence[Decimal]) -> float:
    """Return log10 of Fujiwara's bound 2 max |a_i|^(1/i) on the size of the roots."""
    sizes = [_log10(c) / i for i, c in enumerate(monic) if i and c]
    return log10(2) + max(sizes, default=-_CAP)


def digits_needed(num: Exact, den: Exact, dt: float) -> int:
    """Return the digits that leave 60 after every subtraction on the way.

    Going from z to w cancels a factor of (dt s)^n for slow poles; picking exp(-p dt) of a fast
    pole out of sums of order one cancels exp(p dt); both are known beforehand.
    """
    with precision(40):
        n = len(den) - 1
        step = Decimal(dt)
        monic = [c / den[0] * step**i for i, c in enumerate(den)]
        slow = max(-_log10(c) for c in monic if c)
        sizes = [_log10(c * step**i) for i, c in enumerate(num) if c]
        fast = n * 10 ** min(_bound(monic), 3.0) / _LN10
    return int(60 + 2 * max(slow, 0.0) + max(sizes) - min(sizes) + 2 * n + min(fast, _CAP))


@dataclass(frozen=True, slots=True, kw_only=True)
class StepResponse:
    """y(t) of num/(s den) in units of dt, as a linear function on polynomials mod s den.

    modulus   s den(s), monic in sigma = s dt, ascending, its leading 1 left out
    markov    y's derivatives at 0+ : what the functional gives for sigma^i
    sums      power sums of the poles that are not at 0: the trace of sigma^i
    """

    modulus: Exact
    markov: Exact
    sums: Exact
    order: int
    integrators: int
    zeros_at_origin: int

    @classmethod
    def of(cls, num: Exact, den: Exact, gain: Decimal, dt: Decimal) -> "StepResponse":
        """Return the response of gain num/den, dt the unit of time."""
        n = len(den) - 1
        monic = [c / den[0] * dt**i for i, c in enumerate(den)]
        top = [_ZERO] * (n + 1 - len(num)) + [gain * c / den[0] for c in num]
        top = [c * dt**i for i, c in enumerate(top)]
        k = _trailing_zeros(monic)
        whole = [*monic, _ZERO]
        markov: list[Decimal] = []
        for i in range(n + 1):
            tail = sum((whole[j] * markov[i - j] for j in range(1, i + 1)), _ZERO)
            markov.append(top[i] - tail)
        return cls(
            modulus=tuple(whole[:0:-1]),
            markov=tuple(markov),
            sums=power_sums(monic[: n - k + 1], n + 1),
            order=n,
            integrators=k,
            zeros_at_origin=_trailing_zeros(top),
        )

    def sampled(self, lead: Decimal) -> tuple[Exact, list[Decimal]]:
        """Return (moving poles' polynomial in z, [h_0 ... h_n]), h_j = y(j + lead)."""
        one_sample = self.exponential(_ONE)
        element = self.exponential(lead) if lead else None
        power: list[Decimal] = [_ONE] + [_ZERO] * self.order
        values, traces = [], []
        for j in range(self.order + 1):
            if j:
                power = self._product(power, one_sample)
                traces.append(_dot(power, self.sums))
            shifted = power if element is None else self._product(power, element)
            values.append(_dot(shifted, self.markov))
        return from_power_sums(traces[: self.order - self.integrators]), values

    def exponential(self, t: Decimal) -> list[Decimal]:
        """Return exp(sigma t) mod the modulus, by Taylor's series, halved and squared.

        Raises SpecError where a mode is so fast against dt that no exponent holds its growth.
        """
        size = _bound((_ONE, *self.modulus[::-1])) + _log10(t)
        halvings = max(0, ceil((size + log10(8)) / log10(2)))
        try:
            if halvings > _MOST_HALVINGS:
                raise Overflow
            total = self._series(t / 2**halvings)
            for _ in range(halvings):
                total = self._product(total, total)
        except Overflow:
            raise SpecError(
                "dt",
                "must not be as long against the plant's fastest mode",
                f"1e{size:.0f} times its time constant",
                "sample faster, or leave the fast mode out of the model",
            ) from None
        return total

    def _series(self, step: Decimal) -> list[Decimal]:
        term: list[Decimal] = [_ONE] + [_ZERO] * self.order
        total, k = term, 0
        while any(term):
            k += 1
            factor = step / k
            term = [c * factor for c in self.times_sigma(term)]
            grown = [a + b for a, b in zip(total, term, strict=True)]
            if k > self.order and grown == total:
                break
            total = grown
        return total

    def times_sigma(self, a: list[Decimal]) -> list[Decimal]:
        """Return sigma a mod the modulus."""
        top = a[-1]
        shifted = [_ZERO, *a[:-1]]
        return [s - top * c if c else s for s, c in zip(shifted, self.modulus, strict=True)]

    def _product(self, a: list[Decimal], b: Sequence[Decimal]) -> list[Decimal]:
        out = [c * b[-1] for c in a]
        for factor in reversed(b[:-1]):
            out = [s + c * factor for s, c in zip(self.times_sigma(out), a, strict=True)]
        return out


def _dot(a: Sequence[Decimal], b: Sequence[Decimal]) -> Decimal:
    return sum((x * y for x, y in zip(a, b, strict=True)), _ZERO)


def _trailing_zeros(a: Sequence[Decimal]) -> int:
    return next(i for i, c in enumerate(reversed(a)) if c)
