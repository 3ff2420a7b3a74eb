"""A plant's step response at the samples: its differences and its poles, in whole numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial, frexp, ldexp, log
from operator import mul

from zoh.errors import SpecError
from zoh.lti import poly
from zoh.lti.digits import Exact
from zoh.sampling import delta
from zoh.sampling.delta import InDelta
from zoh.sampling.fixed import FixedRing, Ratio, fixed, grown, log2_above

_MOST_HALVINGS = 60  # of the exponential's argument: a mode 1e17 times faster than dt
_LONG = 6  # halvings: a dt of more than 32 of the fastest mode's time constants
_FLOAT = 1000  # bits behind the point of what becomes a float
_NO_FLOAT = 1100  # doublings within dt: a pole that grows by so much has no float in z
_FAST = 1200  # bits; what is smaller than 2^-1076 is 0 in a float


@dataclass(slots=True, kw_only=True)
class Scaled:
    """A plant with time counted in units of T = 2^-rate s and amplitude in units of 2^gain.

    den, num  exact ratios to den's first, descending powers of s, shape (n + 1,)
    rate      such that the sizes of den's coefficients in sigma = s T, but the first, add up
              to less than 1; then no root sigma is larger than 1
    gain      such that no coefficient of num in sigma is larger than 1
    dt        s
    late      relative degree; zeros_at_one: of the zeros, those at z = 1 by structure
    moving    number of poles that are not at s = 0
    """

    num: Sequence[Ratio]
    den: Sequence[Ratio]
    rate: int
    gain: int
    dt: float
    late: int
    moving: int
    zeros_at_one: int

    @classmethod
    def of(cls, num: Exact, den: Exact, sensor: float, dt: float) -> "Scaled":
        """Return sensor num/den in these units."""
        ratios = [c.as_integer_ratio() for c in den]
        below, above = ratios[0]
        if below < 0:
            below, above = -below, -above
        bottom = [(a * above, b * below) for a, b in ratios]
        factor, divisor = sensor.as_integer_ratio()
        above, below, late = above * factor, below * divisor, len(den) - len(num)
        top = [(a * above, b * below) for a, b in [c.as_integer_ratio() for c in num]]
        rates = [-(-log2_above(c) // i) + 1 for i, c in enumerate(bottom) if i and c[0]]
        rate, k = max(rates, default=-frexp(dt)[1]), _at_origin(bottom)
        return cls(
            num=[(0, 1)] * late + top,
            den=bottom,
            rate=rate,
            gain=max([log2_above(c) - rate * i for i, c in enumerate(top, late) if c[0]]),
            dt=dt,
            late=late,
            moving=len(den) - 1 - k,
            zeros_at_one=min(_at_origin(top), k + 1),
        )

    def in_units(self, seconds: Ratio) -> Ratio:
        """Return a time in units of T."""
        top, bottom = seconds
        return (top << self.rate, bottom) if self.rate >= 0 else (top, bottom << -self.rate)

    def halvings(self) -> int:
        """Return how often dt must be halved to be 1/2 at most; below 0, doubled.

        Raises SpecError where a mode is too fast against dt.
        """
        size = frexp(self.dt)[1] + self.rate
        if size >= _MOST_HALVINGS:
            raise SpecError(
                "dt",
                "must not be as long against the plant's fastest mode",
                f"2^{size} times its time constant",
                "sample faster, or leave the fast mode out of the model",
            )
        return size + 1

    def first_bits(self) -> int:
        """Return the bits to begin with: 60 sure ones, and what is known to be lost on the way.

        Poles and zeros far slower than the fastest, terms of the order of dt^n that fall out
        of terms of order 1, and exp(-p dt) of a fast pole beside 1.
        """
        n, halvings, exponent = len(self.den) - 1, self.halvings(), frexp(self.dt)[1]
        finer = self.rate - max(halvings, 0)  # log2 of what is of order 1, in 1/s
        slow = max([finer * i - log2_above(c) for i, c in enumerate(self.den) if c[0]])
        weak = max([finer * i - log2_above(c) for i, c in enumerate(self.num) if c[0]])
        if halvings <= 0 or not n:
            fast = -halvings * self.late
        else:  # the size of exp(sigma dt) to the n-th; the product of the poles, exp(-den_1 dt)
            size = [k * (halvings - 1) - factorial(k).bit_length() for k in range(n)]
            fast = 3 * halvings + n * max(size) + max(3 * fixed(self.den[1], exponent - 1), 0)
        grown = self._grown(halvings) if halvings > _LONG else 0
        return 74 + 7 * n + max(slow, 0) + max(weak + self.gain, 0) + min(fast, _FAST) + grown

    def _grown(self, halvings: int) -> int:
        """Return about how many bits are lost where a mode grows by far within one dt.

        An element's size is what the mode grows by, and more the closer the poles are; each of
        the n powers adds one to the size and one to the bits that its error takes up. A guess
        to begin with: what is given out is proved. Raises SpecError where no float holds it.
        """
        if all(a >= 0 for a, _ in self.den):
            return 0
        n = len(self.den) - 1
        inside = [fixed(c, _FLOAT - self.rate * i) / 2.0**_FLOAT for i, c in enumerate(self.den)]
        grows = max(0.0, float(poly.roots(inside).real.max()))
        by = int(ldexp(grows * self.dt, self.rate) / log(2.0))
        if by > _NO_FLOAT:
            raise SpecError(
                "dt",
                "must keep the sampled plant within a float's range",
                self.dt,
                "sample faster: an unstable mode outgrows 1e308 within one sample",
            )
        return (n + 2) * (by + 5 * n) + n * by + 10 * halvings if by else 0


@dataclass(slots=True, kw_only=True)
class FixedResponse:
    """The step response of a scaled plant, its slope a functional on the ring modulo den.

    start    h_0 = y(0+)
    slopes   y's derivatives at 0+ from the first on: what the functional gives for sigma^i
    sums     power sums of the poles from the first on: the trace of sigma^(i+1)
    error    bound on the error of each, in units of 2^-bits
    """

    plant: Scaled
    ring: FixedRing
    start: int
    slopes: Sequence[int]
    sums: Sequence[int]
    error: int

    @classmethod
    def of(cls, plant: Scaled, bits: int) -> "FixedResponse":
        """Return the response with numbers of so many bits behind the point.

        y^(i) = num_i - sum_j den_j y^(i-j) is i + 1 at most, a power sum n; each adds n
        roundings times that to the errors of those before it, whose weights add up to 1.
        """
        rate, n = plant.rate, len(plant.den) - 1
        den = [fixed(c, bits - rate * i) for i, c in enumerate(plant.den)]
        slopes: list[int] = []
        sums: list[int] = []
        for i, c in enumerate(plant.num):
            known = sum(map(mul, den[i:0:-1], slopes)) >> bits
            slopes.append(fixed(c, bits - rate * i - plant.gain) - known)
            if i:
                known = sum(map(mul, den[i - 1 : 0 : -1], sums)) >> bits
                sums.append(-i * den[i] - known)
        return cls(
            plant=plant,
            ring=FixedRing(modulus=tuple(den[:0:-1]), bits=bits),
            start=slopes[0],
            slopes=slopes[1:],
            sums=sums,
            error=(n + 1) * (n * n + 2 * n + 3),
        )

    def sampled(self, lead: Ratio) -> InDelta:
        """Return the plant held, the first sample of its response taken at ``lead`` s.

        In units of 2^-scale, delta = exp(sigma dt/T) - 1 is of order 1 at a small dt too. With
        P = delta/sigma the slope's functional gives the differences of y for P delta^(i-1), and
        the trace of sigma P delta^(i-1) is the sum of the i-th powers of the poles.
        """
        plant, ring, bits = self.plant, self.ring, self.ring.bits
        halvings = plant.halvings()
        halvings, scale = max(halvings, 0), max(1 - halvings, 0)
        start, slopes, error = self.start, self.slopes, self.error
        if lead[0]:
            start, slopes, error = self._at(*ring.growth(plant.in_units(lead), halvings, 0))
        step = grown(ring, plant.in_units(plant.dt.as_integer_ratio()), halvings, scale)
        powers, size, power_error = ring.powers(*step)
        differences = [start, *[sum(map(mul, slopes, p)) >> bits for p in powers]]
        sums = [sum(map(mul, self.sums, p)) >> bits for p in powers[: plant.moving]]
        n = len(powers)
        error = _dot_error(ring.norm(slopes), error, size, power_error, bits)
        sums_error = _dot_error(n, self.error, size, power_error, bits)
        den, den_error = delta.from_power_sums(sums, sums_error, bits)
        den += [0] * (n - plant.moving)
        num, num_error = delta.product(den, den_error, differences, error, bits)
        last = n - plant.zeros_at_one
        return InDelta(
            num=[*num[: last + 1], *[0] * plant.zeros_at_one], den=den, num_error=num_error,
            den_error=den_error, first=0 if lead[0] else min(plant.late, 1), last=last,
            at_one=n - plant.moving, scale=scale, gain=plant.gain, bits=bits,
        )  # fmt: skip

    def _at(self, growth: list[int], error: int) -> tuple[int, list[int], int]:
        """Return (y, its derivatives, their error) at a later t; growth = (exp(t sigma) - 1)/sigma.

        The functional's value for x exp(t sigma), x = 1, sigma ..., is the derivative then.
        """
        ring, bits, n = self.ring, self.ring.bits, len(growth)
        size, size_slopes = ring.norm(growth), ring.norm(self.slopes)
        start = self.start + (sum(map(mul, self.slopes, growth)) >> bits)
        element = ring.times_sigma(growth)
        if element:
            element[0] += 1 << bits
        found = [sum(map(mul, self.slopes, e)) >> bits for e in ring.multiples(element, n)[:n]]
        error += (n + 1) * n * (2 + size)
        return start, found, _dot_error(size_slopes, self.error, size + 2, error, bits)


def _dot_error(largest: int, error: int, size: int, element_error: int, bits: int) -> int:
    """Return the error of a functional's value, given its numbers' and the element's sizes."""
    both = error * element_error >> bits
    return largest * element_error + size * error + both + 2


def _at_origin(a: Sequence[Ratio]) -> int:
    """Return how many roots of this polynomial are at 0."""
    k = 0
    while not a[-1 - k][0]:
        k += 1
    return k
