"""The ring modulo den(sigma) in whole numbers, with a proved bound on every error.

An element is a tuple of integers, ascending powers of sigma = s T, in units of 2^-bits. T is the
power of two that makes the moduli's coefficients add up to 1 or less, and that is what makes
errors easy to know: sigma then never enlarges the norm |a| = sum |a_i|, so |a b| <= |a| |b|, and
a rounding costs one unit in each coefficient. Nothing is assumed about the roots.
Source: the ring is that of C. Moler, C. Van Loan, Nineteen Dubious Ways to Compute the
Exponential of a Matrix, SIAM Review 45(1), 2003, method 8 (Cayley-Hamilton), with its method 3
(scaling and squaring) inside; digits cure both.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import log2
from operator import mul

Element = Sequence[int]
Ratio = tuple[int, int]  # numerator, denominator > 0


def fixed(ratio: Ratio, shift: int) -> int:
    """Return the ratio times 2^shift, rounded down.

    >>> fixed((5, 4), 2), fixed((5, 4), -1)
    (5, 0)
    """
    top, bottom = ratio
    return (top << shift) // bottom if shift >= 0 else top // (bottom << -shift)


def log2_above(ratio: Ratio) -> int:
    """Return a whole number above log2 |ratio|, by 2 at most; the ratio is not 0.

    >>> log2_above((3, 1)), log2_above((-1, 4))
    (2, -1)
    """
    return ratio[0].bit_length() - ratio[1].bit_length() + 1


@lru_cache(maxsize=256)
def _terms(bits: int, small: int) -> int:
    """Return after how many terms exp(x), |x| < 2^-small, is right to 2^-bits."""
    k, reached = 1, float(small)
    while reached < bits + 2:
        k += 1
        reached += small + log2(k)
    return k


@lru_cache(maxsize=8)
def grown(ring: "FixedRing", t: Ratio, halvings: int, scale: int) -> tuple[list[int], int]:
    """Return ``ring.growth``; kept, for the hold and the motion between its samples ask for it."""
    return ring.growth(t, halvings, scale)


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedRing:
    """The polynomials in sigma modulo a monic one of degree n.

    modulus  shape (n,), ascending, its leading 1 left out; the sizes add up to 1 or less
    bits     of the fraction; each coefficient is within one unit 2^-bits of the truth

    An error is a bound on the norm of what an element is off by, in units.
    """

    modulus: tuple[int, ...]
    bits: int

    def times_sigma(self, a: Element) -> list[int]:
        """Return sigma a."""
        return self.multiples(a, 2)[1]

    def multiples(self, a: Element, count: int) -> list[list[int]]:
        """Return (a, sigma a, ... sigma^(count-1) a)."""
        last, bits = [*a], self.bits
        modulus = [(i, m) for i, m in enumerate(self.modulus) if m]
        found = [last]
        for _ in range(1, count):
            last = [0, *last]
            top = last.pop()
            for i, m in modulus:
                last[i] -= top * m >> bits
            found.append(last)
        return found

    def norm(self, a: Element) -> int:
        """Return a whole number above the sum of the sizes of a's coefficients."""
        return (sum(map(abs, a)) >> self.bits) + 1

    def rows(self, a: Element) -> list[tuple[int, ...]]:
        """Return the matrix of the product with a: columns a, sigma a, sigma^2 a ..."""
        return list(zip(*self.multiples(a, len(a)), strict=True))

    def rows_of_sigma(self, a: Element) -> list[tuple[int, ...]]:
        """Return the matrix of the product with sigma a."""
        return list(zip(*self.multiples(a, len(a) + 1)[1:], strict=True))

    def applied(self, rows: Sequence[Element], b: Element) -> list[int]:
        """Return the product a b, given rows = rows(a)."""
        bits = self.bits
        return [sum(map(mul, row, b)) >> bits for row in rows]

    def product_error(self, size_a: int, error_a: int, size_b: int, error_b: int) -> int:
        """Return the error of a b; sizes are norms.

        Column j of the matrix has gathered j times n roundings of its own and of the modulus.
        """
        n = len(self.modulus)
        column = error_a + n * n * (1 + size_a)
        return size_b * column + size_a * error_b + (column * error_b >> self.bits) + n + 1

    def growth(self, t: Ratio, halvings: int, scale: int) -> tuple[list[int], int]:
        """Return ((exp(t sigma) - 1)/sigma 2^scale, its error).

        t/2^halvings is 1/2 at most. Where scale is not 0, halvings is 0 and t 2^scale is 1 at
        most. The series t + t^2 sigma/2 + ... has its powers divided by the modulus, the highest
        first, which enlarges no sum of sizes; then, for each halving, P (2 + sigma P), which is
        exp(2 x) - 1 = E (2 + E) divided by sigma. Raises OverflowError where an error outgrows
        every use.
        """
        n, bits, x = len(self.modulus), self.bits, fixed(t, self.bits - halvings)
        last = fixed(t, bits - halvings + scale)
        series, count = [last], max(_terms(bits, bits - x.bit_length()), n)
        for m in range(2, count + 1):
            last = (last * x >> bits) // m
            series.append(last)
        modulus = [(i, c) for i, c in enumerate(self.modulus, -n) if c]
        for k in range(count - 1, n - 1, -1):
            last = series.pop()
            for i, c in modulus:
                series[k + i] -= last * c >> bits
        total, error = series[:n], (2 * n + 4) * (count + 1)
        for _ in range(halvings):
            total, error = self._doubled(total, error)
        return total, error

    def _doubled(self, a: list[int], error: int) -> tuple[list[int], int]:
        """Return a (2 + sigma a), and its error."""
        size = self.norm(a)
        if size.bit_length() > 4 * self.bits + 4096:
            raise OverflowError
        n = len(a)
        shifted = error + n * (1 + size)
        moved = self.applied(self.rows_of_sigma(a), a)
        error = self.product_error(size, shifted, size, error) + 2 * error
        return [2 * c + d for c, d in zip(a, moved, strict=True)], error

    def powers(self, a: list[int], error: int) -> tuple[list[list[int]], int, int]:
        """Return (a, a E, ... a E^(n-1)) with E = sigma a, a bound on their norms and errors."""
        found, size, n = [a], self.norm(a), len(a)
        rows = self.rows_of_sigma(a)
        shifted, largest = error + n * (1 + size), size
        for _ in self.modulus[1:]:
            error = self.product_error(size, shifted, largest, error)
            found.append(self.applied(rows, found[-1]))
            largest = max(largest, self.norm(found[-1]))
        return found[:n], largest, error
