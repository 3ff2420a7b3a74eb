"""How a held plant moves within a sample, in whole numbers, where floats would subtract.

Modulo sigma den(sigma) the exponential is 1 + sigma P, P = (exp(sigma t) - 1)/sigma modulo den,
and an element e + sigma H acts on the state as the remainder of e + sigma H modulo den, on the
input as H's last number does. So the state moves by sigma P, and with the output's row c::

    y(t) = (c_0 + sigma H) (x, u),    H = c P + (c_1, c_2 ... c_(n-1), 0)

Each derivative is sigma times the one before: its H is what acted on the state there. Errors are
bounded (see ``fixed``); what is not sure to a float is found again with the bits that were missing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import pairwise
from math import factorial, frexp
from typing import Self

import numpy as np
import numpy.typing as npt

from zoh.errors import SpecError
from zoh.lti.plant import Plant
from zoh.sampling.fixed import Element, FixedRing, Ratio, fixed, grown, log2_above
from zoh.sampling.response import Scaled

Array = npt.NDArray[np.float64]
Powers = npt.NDArray[np.int64]

_FIRST = 80  # bits, and some for each mode and each halving, that are mostly enough
_SHORT = 12  # halvings: beyond, too few bits to begin with cost more than too many
_SURE = 2.0**-58  # of a number is left open at most: it becomes a float
_NOTHING = 2.0**-400  # of the largest number beside it: what is smaller may be anything
_LARGE = 1000  # the exponent of an error that is too large in any case
_MOST = 16_384  # bits; what is not sure with so many is left as it is


@dataclass(frozen=True, slots=True, kw_only=True)
class Moves:
    """A plant whose input is held, time in units of T = 2^-rate s within and of dt outside.

    ratio, exponent  ratio 2^exponent is dt/T, ratio in [1/2, 1)
    bits, held       to begin with: what mostly is enough, and what the hold has begun with
    """

    scaled: Scaled
    ratio: float
    exponent: int
    bits: int
    held: int

    @classmethod
    def of(cls, plant: Plant, dt: float) -> Self:
        """Return the plant sampled every dt s; raise SpecError where a mode is too fast for it."""
        scaled, (ratio, exponent) = Scaled.of(*plant.exact, plant.sensor, dt), frexp(dt)
        held, halvings = scaled.first_bits(), scaled.halvings()
        mostly = _FIRST + 8 * len(scaled.den) + halvings * (halvings + 6) // 2
        return cls(
            scaled=scaled, ratio=ratio, exponent=exponent + scaled.rate,
            bits=min(held, mostly) if 0 < halvings <= _SHORT else held, held=held,
        )  # fmt: skip

    def moved(self, t: float | Decimal) -> Array:
        """Return Phi(t) - I beside Gamma(t), shape (n, n + 1), t in samples."""
        n, e = len(self.scaled.den) - 1, self.exponent
        bits = self.held if t == 1 else self.bits  # over a whole sample the hold has been
        powers = np.arange(n)[:, None] - np.arange(n + 1)  # derivative less column
        while True:
            rows, errors = self._rows(t, bits, e * powers, seen=False)
            for j in range(n - self.scaled.moving):
                errors[j:, j] = 0.0  # sigma^j P has no power below j, den none below its roots at 0
            sizes = np.abs(rows)
            allowed = np.maximum(_SURE * sizes, _NOTHING * sizes.max(axis=1, keepdims=True))
            missing = _missing(errors, allowed)
            if not missing or bits > _MOST:
                return rows * self.ratio**powers
            bits += missing

    def series(self, t: float, span: float, terms: int) -> Array:
        """Return y's Taylor series from t on, shape (terms, n + 1), in powers of (time - t)/span.

        t, span  in samples; the direct path is left out
        """
        n, e = len(self.scaled.den) - 1, self.exponent
        unit, doublings = frexp(span * self.ratio)
        doublings += e
        weights = np.array([unit**j / factorial(j) for j in range(terms)])[:, None]
        column = e * np.arange(n, -1, -1) + self.scaled.gain
        units = doublings * np.arange(terms)[:, None] + column
        bits = self.bits + max(0, doublings * terms)
        while True:
            rows, errors = self._rows(t, bits, units, seen=True)
            rows *= weights
            sizes = np.abs(rows).max(axis=0)
            allowed = np.maximum(_SURE * sizes, _NOTHING * sizes.max())
            missing = _missing(errors * weights, allowed)
            if not missing or bits > _MOST:
                return rows * self.ratio ** np.arange(n, -1.0, -1.0)
            bits += missing

    def _rows(
        self, t: float | Decimal, bits: int, units: Powers, *, seen: bool
    ) -> tuple[Array, Array]:
        """Return derivatives, a row each on state and input, and bounds on their errors.

        units  the power of two that each number is to be times
        seen   those of the output, the direct path left out; else those of x_0 less itself
        """
        plant = self.scaled
        den = [fixed(c, bits - plant.rate * i) for i, c in enumerate(plant.den)]
        ring = FixedRing(modulus=tuple(den[:0:-1]), bits=bits)
        element, error = grown(ring, *self._time(t), 0)
        ahead, n, count = 0, len(element), len(units)
        if seen:
            c = self._output(den, bits)
            moved = ring.applied(ring.rows(element), c)
            error = ring.product_error(ring.norm(element), error, ring.norm(c), 4 * n + 4)
            element = [a + b for a, b in zip(moved, (*c[1:], 0), strict=True)]
            ahead = c[0]
        error += (count + 1) * n * (2 + ring.norm(element) + (abs(ahead) >> bits))
        first = ring.times_sigma(element)
        first[0] += ahead
        wholes: list[int] = []
        for before, here in pairwise([element, *ring.multiples(first, count)]):
            wholes += here
            wholes.append(before[-1])
        rows = _scaled(wholes, (units - bits).ravel().tolist(), plant.dt).reshape(count, -1)
        return rows, np.ldexp(1.0, np.minimum(units + (error.bit_length() - bits), _LARGE))

    def _time(self, t: float | Decimal) -> tuple[Ratio, int]:
        """Return t samples in units of T, and how often that must be halved to be 1/2 at most."""
        top, bottom = Decimal(t).as_integer_ratio()
        above, below = self.scaled.in_units(self.scaled.dt.as_integer_ratio())
        time = top * above, bottom * below
        return time, max(0, log2_above(time) + 1)

    def _output(self, den: Sequence[int], bits: int) -> Element:
        """Return c with y = c x + d u, in units of 2^gain, ascending."""
        plant = self.scaled
        shift = bits - plant.gain
        num = [fixed(c, shift - plant.rate * i) for i, c in enumerate(plant.num)]
        return [a - (num[0] * b >> bits) for a, b in zip(num[:0:-1], den[:0:-1], strict=True)]


def _scaled(a: Element, exponents: list[int], dt: float) -> Array:
    """Return a 2^exponent for each; raise SpecError where that is no float."""
    try:
        return np.array(
            [c / (1 << -e) if e < 0 else float(c << e) for c, e in zip(a, exponents, strict=True)]
        )
    except OverflowError:
        raise SpecError(
            "dt",
            "must keep the plant's motion within a sample within a float's range",
            dt,
            "sample faster, or leave the fast mode out of the model",
        ) from None


def _missing(errors: Array, allowed: Array) -> int:
    """Return the bits that bring every error down to what is allowed."""
    short = errors > allowed
    if not short.any():
        return 0
    with np.errstate(all="ignore"):
        worst = float((errors / allowed)[short].max())
    return frexp(min(worst, 2.0**_LARGE))[1] + 1
