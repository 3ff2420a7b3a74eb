"""A plant's step response at the samples: its differences and its poles, in whole numbers."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from math import frexp
from operator import mul

from zoh.errors import SpecError
from zoh.lti.digits import Exact
from zoh.sampling import delta
from zoh.sampling.delta import BothForms, Known
from zoh.sampling.fixed import FixedRing, Ratio, fixed, log2_above

_MOST_HALVINGS = 60  # of the exponential's argument: a mode 1e17 times faster than dt
_FAST = 1200  # bits; what is smaller than 2^-1076 is 0 in a float


@dataclass(frozen=True, slots=True, kw_only=True)
class Scaled:
    """A plant with time counted in units of T = 2^-rate s and amplitude in units of 2^gain.

    den, num  exact ratios to den's first, descending powers of s, shape (n + 1,)
    rate      such that the sizes of den's coefficients in sigma = s T, but the first, add up
              to less than 1; then no root sigma is larger than 1
    gain      such that no coefficient of num in sigma is larger than 1
    dt        s
    """

    num: Sequence[Ratio]
    den: Sequence[Ratio]
    rate: int
    gain: int
    dt: float

    @classmethod
    def of(cls, num: Exact, den: Exact, sensor: float, dt: float) -> "Scaled":
        """Return sensor num/den in these units."""
        unit = den[0].as_integer_ratio()
        factor = Decimal(sensor).as_integer_ratio()
        bottom = [_quotient(c.as_integer_ratio(), unit) for c in den]
        top = [(0, 1)] * (len(den) - len(num))
        top += [_quotient(_times(c.as_integer_ratio(), factor), unit) for c in num]
        rates = [-(-log2_above(c) // i) + 1 for i, c in enumerate(bottom) if i and c[0]]
        rate = max(rates, default=-frexp(dt)[1])
        gain = max(log2_above(c) - rate * i for i, c in enumerate(top) if c[0])
        return cls(num=top, den=bottom, rate=rate, gain=gain, dt=dt)

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
        n, halvings = len(self.den) - 1, self.halvings()
        slow = max(self.rate * i - log2_above(c) for i, c in enumerate(self.den) if c[0])
        weak = max(self.rate * i - log2_above(c) for i, c in enumerate(self.num) if c[0])
        late = next(i for i, c in enumerate(self.num) if c[0])
        fast = min(3 * n << max(halvings, 0), _FAST) if halvings > 0 else -halvings * late
        return 80 + 5 * n + max(slow, 0) + weak + self.gain + fast


def _quotient(a: Ratio, b: Ratio) -> Ratio:
    top, bottom = a[0] * b[1], a[1] * b[0]
    return (top, bottom) if bottom > 0 else (-top, -bottom)


def _times(a: Ratio, b: Ratio) -> Ratio:
    return a[0] * b[0], a[1] * b[1]


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedResponse:
    """The step response of a scaled plant as a functional on the ring modulo sigma den.

    markov   its derivatives at 0+: what the functional gives for sigma^i
    sums     power sums of the poles that are not at 0: the trace of sigma^i
    error    bound on the error of each, in units of 2^-bits
    """

    plant: Scaled
    ring: FixedRing
    markov: Sequence[int]
    sums: Sequence[int]
    error: int

    @classmethod
    def of(cls, plant: Scaled, bits: int) -> "FixedResponse":
        """Return the response with numbers of so many bits behind the point.

        markov_i = num_i - sum_j den_j markov_{i-j} is i + 1 at most, a power sum n; each adds
        n roundings times that to the errors of those before it, whose weights add up to 1.
        """
        rate, n = plant.rate, len(plant.den) - 1
        den = [fixed(c, bits - rate * i) for i, c in enumerate(plant.den)]
        markov: list[int] = []
        for i, c in enumerate(plant.num):
            tail = sum(map(mul, den[i:0:-1], markov)) >> bits
            markov.append(fixed(c, bits - rate * i - plant.gain) - tail)
        moving = n - _at_origin(plant.den)
        sums = [moving << bits]
        for j in range(1, n + 1):
            known = sum(map(mul, den[min(j - 1, moving) : 0 : -1], sums[max(j - moving, 1) :]))
            sums.append(-(j * den[j] if j <= moving else 0) - (known >> bits))
        return cls(
            plant=plant,
            ring=FixedRing(modulus=(0, *den[:0:-1]), bits=bits),
            markov=markov,
            sums=sums,
            error=(n + 1) * (n * n + 2 * n + 3),
        )

    def sampled(self, lead: Ratio) -> BothForms:
        """Return the plant held, the first sample of its response taken at ``lead`` s.

        In units of 2^-scale, delta = exp(sigma dt/T) - 1 is of order 1 at a small dt too.
        """
        plant, ring, bits = self.plant, self.ring, self.ring.bits
        n, k = len(plant.den) - 1, _at_origin(plant.den)
        halvings = plant.halvings()
        halvings, scale = max(halvings, 0), max(1 - halvings, 0)
        step = ring.growth(plant.in_units(plant.dt.as_integer_ratio()), halvings, scale)
        functional = self._late(ring.growth(plant.in_units(lead), halvings, 0)) if lead[0] else (
            Known(values=self.markov, errors=[self.error] * (n + 1))
        )  # fmt: skip
        traces = Known(values=self.sums, errors=[self.error] * (n + 1))
        differences, sums = [(functional.values[0] << bits, functional.errors[0] << bits)], []
        for power in self._powers(*step):
            differences.append(functional.dot(power))
            sums.append(traces.dot(power))
        den = delta.from_power_sums(_fixed(sums[: n - k], bits), bits).padded(k)
        num = delta.product(den, _fixed(differences, bits), bits)
        return BothForms.of(
            num.ending_in_zeros(min(_at_origin(plant.num), k + 1)), den, bits, scale, plant.gain
        )

    def _powers(self, a: list[int], error: int) -> Iterator[Known]:
        """Yield a, a^2 ... a^n with the error of each in every coefficient."""
        ring, size = self.ring, self.ring.norm(a)
        power, power_error, rows = a, error, ring.rows(a)
        for i in range(len(a) - 1):
            if i:
                power_error = ring.product_error(size, error, ring.norm(power), power_error)
                power = ring.applied(rows, power)
            yield Known(values=power, errors=[power_error] * len(a))

    def _late(self, growth: tuple[list[int], int]) -> Known:
        """Return the derivatives at a later time: sigma^i exp(sigma t) for sigma^i."""
        ring, (element, error) = self.ring, growth
        element = [element[0] + (1 << ring.bits), *element[1:]]
        markov = Known(values=self.markov, errors=[self.error] * len(element))
        rounding = len(element) * (1 + ring.norm(element))
        found = []
        for _ in element:
            found.append(markov.dot(Known(values=element, errors=[error] * len(element))))
            element, error = ring.times_sigma(element), error + rounding
        return _fixed(found, ring.bits)


def _fixed(dots: Sequence[tuple[int, int]], bits: int) -> Known:
    """Return products in units of 2^-2 bits in units of 2^-bits."""
    return Known(values=[v >> bits for v, _ in dots], errors=[(e >> bits) + 2 for _, e in dots])


def _at_origin(a: Sequence[Ratio]) -> int:
    """Return how many roots of this polynomial are at 0."""
    return next(i for i, c in enumerate(reversed(a)) if c[0])
