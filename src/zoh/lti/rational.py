"""Exact fractions of polynomials in s with a delay: what a formula is while it is being read.

Coefficients are ``fractions.Fraction`` in descending powers, so 0.7809 is 7809/10000 and
nothing is rounded. Factors that a formula writes above and below the line are kept: they are
hidden modes, facts about the machine. Only what school arithmetic shares is shared: a sum
stands over the least common denominator.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from zoh.lti.given import MAX_ORDER

MAX_BITS = 8192  # of one coefficient: (s + a)^50 with 17 digits in a has 2900

Coefficients = tuple[Fraction, ...]
_ONE: Coefficients = (Fraction(1),)


class Unreadable(ValueError):
    """An operation that has no meaning here; says what is wrong and the way out."""

    def __init__(self, bound: str, way_out: str) -> None:
        super().__init__(bound)
        self.bound, self.way_out = bound, way_out


@dataclass(frozen=True, slots=True, kw_only=True)
class Rational:
    """The value num(s)/den(s) exp(-delay s).

    num, den  exact coefficients in descending powers of s, without leading zeros
    delay     s, 0 or more; None where no exp() was written, which is not the same as exp(0 s)
    """

    num: Coefficients
    den: Coefficients = _ONE
    delay: Fraction | None = None

    @property
    def is_number(self) -> bool:
        """Whether the value is a plain number."""
        return len(self.num) == len(self.den) == 1 and self.delay is None

    def plus(self, other: "Rational", sign: int = 1) -> "Rational":
        """Return self + sign * other over the least common denominator."""
        if self.delay != other.delay:
            raise Unreadable(
                "must not add terms with different delays",
                "exp() is a factor of the whole formula; a sum of delays is no rational plant",
            )
        shared = common(self.den, other.den)
        mine, others = divided(other.den, shared), divided(self.den, shared)
        num = _sum(_product(self.num, mine), _product(other.num, others), sign)
        return _value(num, _product(self.den, mine), self.delay)

    def times(self, other: "Rational") -> "Rational":
        """Return self * other."""
        delay = self.delay if other.delay is None else other.delay + (self.delay or 0)
        return _value(_product(self.num, other.num), _product(self.den, other.den), delay)

    def over(self, other: "Rational") -> "Rational":
        """Return self / other."""
        if not any(other.num):
            raise Unreadable("must not divide by zero", "correct the divisor")
        if other.delay is not None:
            raise Unreadable(
                "must not divide by exp()",
                "that would be an output before its input; write exp(-T*s) above the line",
            )
        return _value(_product(self.num, other.den), _product(self.den, other.num), self.delay)

    def power(self, exponent: int) -> "Rational":
        """Return self ** exponent."""
        if not any(self.num) and exponent <= 0:
            raise Unreadable("must not raise zero to a power of 0 or less", "correct the base")
        result = Rational(num=_ONE)
        for _ in range(abs(exponent)):
            result = result.times(self)
        return result if exponent >= 0 else Rational(num=_ONE).over(result)

    def as_delay(self) -> "Rational":
        """Return exp(self), which is a pure delay for -T*s with T >= 0 only."""
        slope, constant = ((Fraction(0), *self.num)[-2:]) if len(self.num) < 3 else (None, None)
        if len(self.den) > 1 or self.delay is not None or constant or slope is None or slope > 0:
            raise Unreadable("must have exp() of -T*s with T >= 0 only", "write exp(-0.05*s)")
        return Rational(num=_ONE, delay=-slope)


def _value(num: Coefficients, den: Coefficients, delay: Fraction | None) -> Rational:
    """Return the fraction with a plain number below the line divided out; check its size."""
    if len(den) == 1:
        num, den = tuple(c / den[0] for c in num), _ONE
    order = max(len(num), len(den)) - 1
    if order > MAX_ORDER:
        bound = f"must have order {MAX_ORDER} or less (this is {order})"
        raise Unreadable(bound, "reduce the model")
    return Rational(num=num, den=den, delay=delay)


def _product(a: Coefficients, b: Coefficients) -> Coefficients:
    # without this, (((s+1)^50)^50)^50 and its digits would grow until the memory is full
    if len(a) + len(b) - 2 > 2 * MAX_ORDER:
        raise Unreadable(f"must have order {MAX_ORDER} or less", "reduce the model")
    out = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i + j] += x * y
    return _trimmed(out)


def _sum(a: Coefficients, b: Coefficients, sign: int) -> Coefficients:
    n = max(len(a), len(b))
    zeros = (Fraction(0),) * n
    left, right = (*zeros[len(a) :], *a), (*zeros[len(b) :], *b)
    return _trimmed([x + sign * y for x, y in zip(left, right, strict=True)])


def common(a: Coefficients, b: Coefficients) -> Coefficients:
    """Return the greatest common divisor by Euclid's algorithm, with the first one's scale.

    Raises Unreadable where the digits outgrow their limit.

    >>> common((Fraction(2), Fraction(2)), (Fraction(1), Fraction(0), Fraction(-1)))
    (Fraction(2, 1), Fraction(2, 1))
    """
    lead = a[0]
    while any(b):
        a, b = b, _divmod(a, b)[1]
    return tuple(c * lead / a[0] for c in a)


def divided(a: Coefficients, b: Coefficients) -> Coefficients:
    """Return a/b where b divides a."""
    return _divmod(a, b)[0]


def _divmod(a: Coefficients, b: Coefficients) -> tuple[Coefficients, Coefficients]:
    """Return quotient and remainder of a by b."""
    rest, quotient = list(a), []
    while len(rest) >= len(b):
        factor = rest[0] / b[0]
        quotient.append(factor)
        for i, c in enumerate(b):
            rest[i] -= factor * c
        del rest[0]
    return tuple(quotient) or (Fraction(0),), _trimmed(rest)


def _trimmed(a: Sequence[Fraction]) -> Coefficients:
    """Return ``a`` without leading zeros; refuse digits beyond use."""
    if any(max(c.numerator.bit_length(), c.denominator.bit_length()) > MAX_BITS for c in a):
        raise Unreadable(
            f"must need no more than {MAX_BITS} bits in a coefficient",
            "write fewer digits, or smaller powers",
        )
    for i, c in enumerate(a):
        if c:
            return tuple(a[i:])
    return (Fraction(0),)
