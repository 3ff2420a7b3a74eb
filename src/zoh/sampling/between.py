"""A plant under a held input, at any time between two samples.

The state is that of the controllable canonical form in units of the sample time: x_0 is what
1/den answers, x_i its i-th derivative times dt^i. Over a fraction t of a sample::

    x(t) = x + (Phi(t) - I) x + Gamma(t) u,    y = c x + d u

Phi - I is given, not Phi: at a small dt the difference is what counts. Modulo sigma den(sigma),
sigma = s dt, both are one polynomial, exp(sigma t) (see ``ring``). Where the fastest mode turns
by little in a sample every sum on the way is led by its first term, and floats serve; elsewhere
digits do.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from math import factorial, log10
from typing import Any

import numpy as np
import numpy.typing as npt

from zoh.lti import digits
from zoh.lti.systems import Plant
from zoh.sampling.ring import StepResponse, digits_needed

Array = npt.NDArray[np.float64]

GENTLE = 0.5  # rad that the fastest mode turns at most where floats serve
SPAN = 1.0  # rad that a live mode turns at most in a stretch with one Taylor series
MOST_STRETCHES = 2000  # in a sample; a resonance that swings more often is not followed
_TERM = 1e-18  # of the first: a term that is not added any more
_DEAD = 40.0  # a mode at exp(-40) is gone


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """A plant (sensor included, dead time not) whose input is held for dt at a time.

    low   shape (n,): the monic denominator in sigma, ascending, its leading 1 left out
    c     shape (n,): the output's row on the state;  d  direct gain
    size  bound of the size of the poles, in rad per sample
    """

    plant: Plant
    dt: float
    low: tuple[float, ...]
    c: tuple[float, ...]
    d: float
    size: float

    @classmethod
    def of(cls, plant: Plant, dt: float) -> "Held":
        """Return the plant with time counted in units of dt seconds."""
        low, c, d = _scaled(plant, dt)
        n = len(low)
        return cls(
            plant=plant, dt=dt, low=tuple(map(float, low)), c=tuple(map(float, c)), d=float(d),
            # Fujiwara's bound of the roots
            size=2 * max((abs(float(a)) ** (1 / (n - i)) for i, a in enumerate(low)), default=0.0),
        )  # fmt: skip

    def move(self, t: float | Decimal) -> tuple[Array, Array]:
        """Return (Phi(t) - I, Gamma(t)) for a fraction t of a sample, shapes (n, n) and (n,)."""
        n = len(self.low)
        rows: list[list[Any]] = []
        if self.size * float(t) <= GENTLE:
            element = self._less_one(float(t))
            for _ in range(n):
                rows.append(element)
                element = _times_sigma(element, self.low)
        else:
            response, precision = self._exact()
            with digits.precision(precision):
                exact = response.exponential(Decimal(t))
                exact[0] -= 1
                for _ in range(n):
                    rows.append(exact)
                    exact = response.times_sigma(exact)
                return _split(rows, response.modulus[1:])
        return _split(rows, self.low)

    def taylor(self, t: float, terms: int) -> tuple[Array, Array]:
        """Return y's Taylor coefficients at t as rows on state and input at 0, (terms, n) and (terms,)."""
        rows: list[list[Any]] = []
        if not t:
            q: list[Any] = [*self.c, 0.0]
            for j in range(1, terms + 1):
                rows.append(q)
                q = [a / j for a in _times_sigma(q, self.low)]
            on_state, on_input = _split(rows, self.low)
        else:
            response, precision = self._exact()
            with digits.precision(precision + int(terms * max(0.0, log10(self.size)))):
                exact = response.exponential(Decimal(t))
                q = [Decimal(0)] * len(exact)
                for weight in reversed(_scaled(self.plant, self.dt)[1]):
                    shifted = response.times_sigma(q)
                    q = [a + weight * b for a, b in zip(shifted, exact, strict=True)]
                for j in range(1, terms + 1):
                    rows.append(q)
                    q = [a / j for a in response.times_sigma(q)]
                on_state, on_input = _split(rows, response.modulus[1:])
        on_input[0] += self.d
        return on_state, on_input

    def stretches(self, length: float) -> list[tuple[float, float]]:
        """Return (begin, span) of stretches of [0, length] short enough for one Taylor series.

        A mode that is over does not count, as long as its series, too, stays below what is left
        of it. None at all where there would be too many.
        """
        if self.size * length <= SPAN:
            return [(0.0, length)]
        poles = self.plant.poles() * self.dt
        poles = poles[np.abs(poles) > 0]
        sizes, t = np.abs(poles), 0.0
        out: list[tuple[float, float]] = []
        while t < length * (1 - 1e-12):
            reach = np.maximum(SPAN / sizes, (-poles.real * t - _DEAD) / sizes)
            span = min(float(reach.min(initial=np.inf)), length - t)
            if len(out) == MOST_STRETCHES:
                return []
            out.append((t, span))
            t += span
        return out

    def terms(self, span: float) -> int:
        """Return how many Taylor terms carry a stretch to the last bit."""
        turn, j = min(self.size * span, SPAN), 1
        while turn**j > _TERM * factorial(j):
            j += 1
        return len(self.low) + j

    def _less_one(self, t: float) -> list[float]:
        """Return exp(sigma t) - 1 in floats."""
        n = len(self.low)
        term = [1.0] + [0.0] * n
        total, j, weight = [0.0] * (n + 1), 0, 1.0
        while j <= n or weight > _TERM:
            j += 1
            term = [a * t / j for a in _times_sigma(term, self.low)]
            total = [a + b for a, b in zip(total, term, strict=True)]
            if j > n:
                weight *= self.size * t / (j - n)
        return total

    def _exact(self) -> tuple[StepResponse, int]:
        num, den = self.plant.exact
        needed = digits_needed(num, den, self.dt)
        with digits.precision(needed):
            gain = Decimal(self.plant.sensor)
            return StepResponse.of(num, den, gain, Decimal(self.dt)), needed


def _scaled(plant: Plant, dt: float) -> tuple[list[Decimal], list[Decimal], Decimal]:
    """Return (low, c, d) in units of dt, exactly."""
    num, den = plant.exact
    n = len(den) - 1
    with digits.precision(digits.KEPT):
        gain, unit, power = Decimal(plant.sensor), Decimal(dt), Decimal(1)
        top = [Decimal(0)] * (n + 1 - len(num)) + [c / den[0] for c in num]
        low, c, d = [], [], gain * top[0]
        for a, b in zip(den[1:], top[1:], strict=True):
            power *= unit
            low.append(a / den[0] * power)
            c.append((gain * b - d * (a / den[0])) * power)
    return low[::-1], c[::-1], d


def _times_sigma(a: Sequence[float], low: Sequence[float]) -> list[float]:
    """Return sigma a mod sigma den(sigma)."""
    top = a[-1]
    return [0.0, *[b - top * c for b, c in zip(a[:-1], low, strict=True)]]


def _split(rows: Sequence[Sequence[Any]], low: Sequence[Any]) -> tuple[Array, Array]:
    """Return polynomials mod sigma den as (rows on the state, weights of the input)."""
    n = len(low)
    on_state = [[float(a - row[n] * b) for a, b in zip(row, low, strict=False)] for row in rows]
    return np.array(on_state).reshape(len(rows), n), np.array([float(row[n]) for row in rows])
