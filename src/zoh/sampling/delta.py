"""Fractions in delta = z - 1, in whole numbers with known errors, rounded once into z and w.

A sampled plant is, with h_0, h_1 ... the samples of its step response,

    G = h_0 + (D h)_0/delta + (D^2 h)_0/delta^2 + ...,    D h = h_1 - h_0, h_2 - h_1 ...

so differences of the step response over the poles' polynomial give the numerator. At a small dt
nothing cancels here, as it does between powers of z; what cancels on the way to a float is seen
in the errors that come along, and answered with more bits.
Source: R. H. Middleton and G. C. Goodwin, Digital Control and Estimation: A Unified Approach
(the delta operator).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import comb
from operator import mul

from zoh.lti.systems import Sampled
from zoh.sampling.fixed import Ratio

_ENOUGH = 60  # bits of a coefficient that are sure; a float has 53
_NO_FLOAT = 1076  # 2^-1076 rounds to 0

Rows = tuple[tuple[int, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Known:
    """Whole numbers, descending powers, and a bound on the error of each, all in one unit."""

    values: Sequence[int]
    errors: Sequence[int]

    def dot(self, weights: "Known") -> tuple[int, int]:
        """Return sum values_i weights_i and a bound on its error."""
        error = sum(map(mul, map(abs, self.values), weights.errors))
        error += sum(map(mul, map(abs, weights.values), self.errors))
        error += sum(map(mul, self.errors, weights.errors))
        return sum(map(mul, self.values, weights.values)), error

    def padded(self, k: int) -> "Known":
        """Return these and k exact zeros."""
        return Known(values=[*self.values, *[0] * k], errors=[*self.errors, *[0] * k])

    def ending_in_zeros(self, k: int) -> "Known":
        """Return these with the last k exactly zero, as they are by structure."""
        kept = len(self.values) - k
        return Known(values=self.values[:kept], errors=self.errors[:kept]).padded(k)

    def shifted(self, scale: int) -> "Known":
        """Return the coefficients of x^n, x^(n-1) ..., given those of x 2^scale, unit 2^-scale n."""
        n = len(self.values) - 1
        shifts = range(scale * n, -1, -scale) if scale else [0] * (n + 1)
        return Known(
            values=[v << s for v, s in zip(self.values, shifts, strict=True)],
            errors=[e << s for e, s in zip(self.errors, shifts, strict=True)],
        )

    def upto(self, k: int) -> "Known":
        """Return the first k."""
        return Known(values=self.values[:k], errors=self.errors[:k])

    def last(self, k: int) -> "Known":
        """Return the k last, in the other order."""
        return Known(values=self.values[: -k - 1 : -1], errors=self.errors[: -k - 1 : -1])

    def mixed(self, weights: tuple[Rows, Rows]) -> "Known":
        """Return the weighted sums; the weights come with their sizes, as below."""
        return Known(
            values=[sum(map(mul, row, self.values)) for row in weights[0]],
            errors=[sum(map(mul, row, self.errors)) for row in weights[1]],
        )

    def missing_bits(self, least: int) -> int | None:
        """Return how many more bits make every value sure, None where one is nowhere in sight.

        What is below ``least`` with its error is 0 in a float, and sure.
        """
        missing = 0
        for value, error in zip(self.values, self.errors, strict=True):
            size = abs(value)
            if size >> _ENOUGH >= error or size + error < least:
                continue
            if size <= error:
                return None
            missing = max(missing, _ENOUGH + 2 + error.bit_length() - size.bit_length())
        return missing

    def visible(self) -> list[int]:
        """Return the values, 0 for those that do not rise above their errors."""
        return [v if abs(v) > e else 0 for v, e in zip(self.values, self.errors, strict=True)]


def from_power_sums(sums: Known, bits: int) -> Known:
    """Return the monic polynomial whose roots have these sums of powers 1 ... n; unit 2^-bits.

    >>> from_power_sums(Known(values=[3 << 9, 5 << 9], errors=[0, 0]), 9).values
    [512, -1536, 1024]
    """
    values, errors = [1 << bits], [0]
    for k in range(1, len(sums.values) + 1):
        value, error = Known(values=values[::-1], errors=errors[::-1]).dot(sums.upto(k))
        values.append(-value // (k << bits))
        errors.append(error // (k << bits) + 2)
    return Known(values=values, errors=errors)


def product(den: Known, differences: Known, bits: int) -> Known:
    """Return the numerator over ``den`` whose quotient begins with these differences."""
    pairs = [
        den.upto(j + 1).dot(differences.upto(j + 1).last(j + 1)) for j in range(len(den.values))
    ]
    return Known(values=[v >> bits for v, _ in pairs], errors=[(e >> bits) + 2 for _, e in pairs])


@lru_cache(maxsize=64)
def in_z(n: int) -> tuple[Rows, Rows]:
    """Return the weights from powers of delta to powers of z, delta = z - 1, and their sizes.

    >>> in_z(1)[0]
    ((1, 0), (-1, 1))
    """
    return _with_sizes(
        [[comb(n - j, i - j) * (-1) ** (i - j) if i >= j else 0 for j in range(n + 1)]
         for i in range(n + 1)]
    )  # fmt: skip


@lru_cache(maxsize=64)
def in_p(n: int) -> tuple[Rows, Rows]:
    """Return the weights from powers of delta to powers of p = (z-1)/(z+1), times (1-p)^n.

    delta = 2 p/(1 - p), so that delta^(n-j) becomes (2 p)^(n-j) (1 - p)^j.

    >>> in_p(1)[0]
    ((2, -1), (0, 1))
    """
    return _with_sizes(
        [[comb(j, j - i) * (-1) ** (j - i) << n - j if j >= i else 0 for j in range(n + 1)]
         for i in range(n + 1)]
    )  # fmt: skip


def _with_sizes(rows: Sequence[Sequence[int]]) -> tuple[Rows, Rows]:
    return tuple(map(tuple, rows)), tuple(tuple(map(abs, row)) for row in rows)


@dataclass(frozen=True, slots=True, kw_only=True)
class BothForms:
    """One fraction in z and in p = (z-1)/(z+1); its numerators are to be times 2^gain.

    num_z, den_z, num_p, den_p  shape (n + 1,), in units of 2^-bits
    """

    num_z: Known
    den_z: Known
    num_p: Known
    den_p: Known
    bits: int
    gain: int

    @classmethod
    def of(cls, num: Known, den: Known, bits: int, scale: int, gain: int) -> "BothForms":
        """Return num/den, given in powers of delta 2^scale and units of 2^-bits."""
        n = len(den.values) - 1
        num, den = num.shifted(scale), den.shifted(scale)
        return cls(
            num_z=num.mixed(in_z(n)),
            den_z=den.mixed(in_z(n)),
            num_p=num.mixed(in_p(n)),
            den_p=den.mixed(in_p(n)),
            bits=bits + scale * n,
            gain=gain,
        )

    def missing_bits(self) -> int | None:
        """Return how many more bits make every coefficient sure, None for no one knows."""
        no_float = 1 << max(self.bits - _NO_FLOAT, 0) if self.bits > _NO_FLOAT else 0
        no_num = 1 << self.bits - _NO_FLOAT - self.gain if self.bits > _NO_FLOAT + self.gain else 0
        each = [
            self.num_z.missing_bits(no_num),
            self.den_z.missing_bits(no_float),
            self.num_p.missing_bits(0),
            self.den_p.missing_bits(0),
        ]
        known = [bits for bits in each if bits is not None]
        return max(known) if len(known) == len(each) else None

    def lost_bits(self) -> int:
        """Return the bits that the largest error takes up."""
        parts = (self.num_z, self.den_z, self.num_p, self.den_p)
        return max(max(part.errors) for part in parts).bit_length()

    def rounded(self, dt: float, delay: int) -> Sampled:
        """Return the system, every coefficient the float next to it; delay in samples.

        In w = (2/dt) p the denominator's first coefficient is 1. Raises OverflowError where one
        leaves a float's range.
        """
        num_z, den_z, num_p, den_p = (
            part.visible() for part in (self.num_z, self.den_z, self.num_p, self.den_p)
        )
        unit = 1 << self.bits
        first = next(i for i, c in enumerate(den_p) if c)
        top, bottom = dt.as_integer_ratio()
        powers = [_power(2 * bottom, top, i - first, den_p[first]) for i in range(len(den_p))]
        return Sampled.made(
            num=tuple(_float(c, unit, self.gain) for c in num_z),
            den=tuple(c / unit for c in den_z) + (0.0,) * delay,
            dt=dt,
            num_w=tuple(_float(c * a, b, self.gain) for c, (a, b) in zip(num_p, powers, strict=True)),
            den_w=tuple(c * a / b for c, (a, b) in zip(den_p, powers, strict=True)),
            delay=delay,
        )


def _power(top: int, bottom: int, exponent: int, unit: int) -> Ratio:
    """Return (top/bottom)^exponent/unit."""
    if exponent < 0:
        top, bottom, exponent = bottom, top, -exponent
    return top**exponent, bottom**exponent * unit


def _float(top: int, bottom: int, exponent: int) -> float:
    """Return top/bottom 2^exponent, correctly rounded."""
    return (top << exponent) / bottom if exponent >= 0 else top / (bottom << -exponent)
