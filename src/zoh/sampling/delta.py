"""Fractions in delta = z - 1, in whole numbers with known errors, rounded once into z and w.

A sampled plant is, with h_0, h_1 ... the samples of its step response,

    G = h_0 + (D h)_0/delta + (D^2 h)_0/delta^2 + ...,    D h = h_1 - h_0, h_2 - h_1 ...

so differences of the step response times the poles' polynomial give the numerator. At a small
dt nothing cancels here, as it does between powers of z; what cancels on the way to a float is
seen beside the error that came along, and answered with more bits.
Source: R. H. Middleton and G. C. Goodwin, Digital Control and Estimation: A Unified Approach
(the delta operator).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import comb
from operator import mul

from zoh.lti.sampled import Sampled, Wholes

SURE = 60  # bits of a coefficient; a float has 53
_NO_FLOAT = 1076  # 2^-1076 rounds to 0

Table = tuple[tuple[int, ...], ...]


def from_power_sums(sums: Sequence[int], error: int, bits: int) -> tuple[list[int], int]:
    """Return the monic polynomial whose roots have these sums of powers 1 ... n, and its error.

    The error is a bound for each coefficient; all is in units of 2^-bits. A rounding of the k-th
    coefficient is one of k units in the k-th sum, and the polynomial is exp(-sum p_k t^k/k): sums
    off by d at most make it times exp(sum d t^k/k), whose coefficients are d, or d^n, at most.

    >>> from_power_sums([3 << 9, 5 << 9], 0, 9)
    ([512, -1536, 1024], 10)
    """
    values, size = [1 << bits], 0
    for k in range(1, len(sums) + 1):
        size += (abs(values[-1]) >> bits) + (k > 1)
        values.append(-sum(map(mul, values, sums[k - 1 :: -1])) // (k << bits))
    off = error + len(sums)
    return values, off * ((off >> bits) + 1) ** (len(sums) - 1) * size if sums else 0


def product(
    den: Sequence[int], den_error: int, differences: Sequence[int], error: int, bits: int
) -> tuple[list[int], int]:
    """Return the numerator over ``den`` whose quotient begins with these differences; its error.

    >>> product([512, -512], 0, [0, 512], 0, 9)  # 1/delta + 1/delta^2 + ...
    ([0, 512], 2)
    """
    size = sum(map(abs, den)) + sum(map(abs, differences)) >> bits
    num = [sum(map(mul, den, differences[j::-1])) >> bits for j in range(len(den))]
    both = den_error * error * len(den) >> bits
    return num, (size + 2) * max(den_error, error) + both + 2


@lru_cache(maxsize=256)
def in_z(n: int, scale: int) -> Table:
    """Return the weights from powers of delta 2^scale to powers of z, in units of 2^-(scale n).

    >>> in_z(1, 0)  # z - 1
    ((1, 0), (-1, 1))
    """
    return tuple(
        tuple(
            comb(n - j, i - j) * (-1) ** (i - j) << scale * (n - j) if i >= j else 0
            for j in range(n + 1)
        )
        for i in range(n + 1)
    )


@lru_cache(maxsize=256)
def in_p(n: int, scale: int) -> Table:
    """Return the weights from powers of delta 2^scale to those of p = (z-1)/(z+1).

    delta = 2 p/(1 - p), so that delta^(n-j) (1 - p)^n becomes (2 p)^(n-j) (1 - p)^j; in units of
    2^-(scale n).

    >>> in_p(1, 0)
    ((2, -1), (0, 1))
    """
    return tuple(
        tuple(
            comb(j, j - i) * (-1) ** (j - i) << (scale + 1) * (n - j) if j >= i else 0
            for j in range(n + 1)
        )
        for i in range(n + 1)
    )


@lru_cache(maxsize=1024)
def _in_both(n: int, scale: int, first: int, last: int) -> list[tuple[Table, list[int]]]:
    """Return ``in_z`` and ``in_p``, and what one unit of error in each of first ... last makes."""
    return [
        (table, [sum(map(abs, row[first : last + 1])) for row in table])
        for table in (in_z(n, scale), in_p(n, scale))
    ]


@dataclass(slots=True, kw_only=True)
class InDelta:
    """The fraction 2^gain num/den in powers of delta 2^scale, n + 1 coefficients each.

    num, den                in units of 2^-bits; den begins with 1 and ends with k zeros
    num_error, den_error    bounds on the error of one coefficient, in units
    first, last             those of num that are not 0 by structure
    """

    num: Sequence[int]
    den: Sequence[int]
    num_error: int
    den_error: int
    first: int
    last: int
    at_one: int
    scale: int
    gain: int
    bits: int

    def forms(self) -> "Forms":
        """Return the same in z and in p."""
        n, found, errors = len(self.den) - 1, [], []
        for values, error, first, last in (
            (self.num, self.num_error, self.first, self.last),
            (self.den, self.den_error, 0, n - self.at_one),
        ):
            for table, sizes in _in_both(n, self.scale, first, last):
                found.append([sum(map(mul, row, values)) for row in table])
                errors.append([error * size for size in sizes])
        return Forms(values=found, errors=errors, bits=self.bits + self.scale * n, gain=self.gain)


@dataclass(slots=True, kw_only=True)
class Forms:
    """A fraction in z and in p, descending powers, in units of 2^-bits; num is to be times 2^gain.

    values, errors  num in z, num in p, den in z, den in p, and a bound on each error
    """

    values: list[list[int]]
    errors: list[list[int]]
    bits: int
    gain: int

    def missing_bits(self, sure: int = SURE) -> int | None:
        """Return how many more bits make every coefficient sure, None for no one knows.

        sure  how many bits of it are to be right

        What is below the least float with its error is 0 in z, and sure.
        """
        missing = 0
        least = [self.bits - _NO_FLOAT - self.gain, 0, self.bits - _NO_FLOAT, 0]
        for values, errors, nothing in zip(self.values, self.errors, least, strict=True):
            for i, error in enumerate(errors):
                size = abs(values[i])
                if size >> sure >= error or (size + error).bit_length() <= nothing:
                    continue
                if size <= error:
                    return None
                missing = max(missing, sure + 2 + error.bit_length() - size.bit_length())
        return missing

    def lost_bits(self) -> int:
        """Return the bits that the largest error takes up."""
        return max(map(max, self.errors)).bit_length()

    def cleared(self) -> "Forms":
        """Return the same with 0 for what does not rise above its error."""
        values = [
            [v if abs(v) > e else 0 for v, e in zip(vs, es, strict=True)]
            for vs, es in zip(self.values, self.errors, strict=True)
        ]
        return replace(self, values=values)

    def whole(self, dt: float, sure: int) -> Wholes:
        """Return (num, den, unit) in w = (2/dt) p, whole numbers times unit, so many bits of each.

        In units of it the first coefficient of the denominator is 1.
        """
        top, bottom = dt.as_integer_ratio()
        up, down = max(self.gain, 0), max(-self.gain, 0)
        n = len(self.values[1]) - 1
        units = [top ** (n - i) * (2 * bottom) ** i for i in range(n + 1)]
        num = [c * u << up for c, u in zip(self.values[1], units, strict=True)]
        den = [c * u << down for c, u in zip(self.values[3], units, strict=True)]
        spare = min([c.bit_length() for c in (*num, *den) if c]) - sure
        if spare > 0:
            num, den = ([(c >> spare - 1) + 1 >> 1 for c in a] for a in (num, den))
        return num, den, next(c for c in den if c)

    def rounded(self, dt: float, delay: int, finer: Callable[[], Sampled] | None = None) -> Sampled:
        """Return the system, every coefficient the float next to it; delay in samples.

        finer  what computes the same with more digits

        In w = (2/dt) p the first coefficient of the denominator is 1. Raises OverflowError where
        one leaves a float's range.
        """
        num_z, num_p, den_z, den_p = self.values
        up, down = max(self.gain, 0), max(-self.gain, 0)
        unit, num_unit = 1 << self.bits, 1 << self.bits + down
        first = 0
        while not den_p[first]:
            first += 1
        lead, num_w, den_w = den_p[first], [], []
        for top, bottom, (above, below) in zip(
            num_p, den_p, _powers(dt, len(den_p), first), strict=True
        ):
            below *= lead
            num_w.append((top * above << up) / (below << down))
            den_w.append(bottom * above / below)
        return Sampled.made(
            num=tuple([(c << up) / num_unit for c in num_z]),
            den=tuple([c / unit for c in den_z] + [0.0] * delay),
            dt=dt,
            num_w=tuple(num_w),
            den_w=tuple(den_w),
            delay=delay,
            finer=finer,
        )


@lru_cache(maxsize=64)
def _powers(dt: float, count: int, first: int) -> list[tuple[int, int]]:
    """Return (2/dt)^(i - first) as fractions, i = 0 ... count - 1."""
    bottom, top = dt.as_integer_ratio()
    ratios = (2 * top, bottom), (bottom, 2 * top)
    return [
        (ratios[i < first][0] ** abs(i - first), ratios[i < first][1] ** abs(i - first))
        for i in range(count)
    ]
