"""A plant under a held input, at any time between two samples.

The state is that of the controllable canonical form in units of the sample time: x_0 is what
1/den answers, x_i its i-th derivative times dt^i. Over a fraction t of a sample::

    x(t) = x + (Phi(t) - I) x + Gamma(t) u,    y = c x + d u

Phi - I is given, not Phi: at a small dt the difference is what counts. Modulo sigma den(sigma),
sigma = s dt, both are one polynomial, exp(sigma t) (see ``fixed``). Where the fastest mode turns
by little in a sample every sum on the way is led by its first term, and floats serve; elsewhere
whole numbers do (see ``moves``).
"""

from dataclasses import dataclass
from decimal import Decimal
from itertools import chain
from math import isinf, log

import numpy as np
import numpy.typing as npt

from zoh.lti import digits
from zoh.lti.systems import Plant
from zoh.sampling.moves import Moves

Array = npt.NDArray[np.float64]
Series = tuple[float, float, Array]  # begin, span, coefficients

_GENTLE = 0.5  # rad that the fastest mode turns at most where floats serve
_SPAN = 2.0  # rad that a live mode turns at most in a stretch with one Taylor series
_MOST_STRETCHES = 2000  # in a sample; a resonance that swings more often is not followed
_MOST_TERMS = 27  # of a series over _SPAN, beside one for each state
_TERM = 1e-17  # of the first: a term that is not added any more
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
        sizes = sorted([abs(a) ** (1 / (n - i)) for i, a in enumerate(low)])
        # Lagrange's bound of the roots: the two largest together
        return cls(plant=plant, dt=dt, low=low, c=c, d=d, size=sum(sizes[-2:]))

    def over(self, t: float | Decimal) -> tuple[Array, list[Series]]:
        """Return what the state moves by over a fraction t of a sample, and y's series in it.

        The first has shape (n, n + 1), Phi(t) - I beside Gamma(t). A series is (begin, span,
        rows), rows of shape (terms, n + 1) on state and input at 0, in powers of the time after
        begin in units of span; there are none where there would be too many.
        """
        n, length = len(self.low), float(t)
        if not n:
            return np.zeros((0, 1)), [(0.0, length, np.array([[self.d]]))]
        if self.size * length > _GENTLE:
            moves, stretches = Moves.of(self.plant, self.dt), self._stretches(length)
            return moves.moved(t), [
                (a, span, self._taylor(a, span, moves)) for a, span in stretches
            ]
        first = self._series([1.0] + [0.0] * (n - 1), length)
        rows, low = [[sum(column[:0:-1]) for column in zip(*first, strict=True)]], (*self.low, -1.0)
        for _ in range(1, n):  # the derivative of x_0 is x_1, and so on
            top = rows[-1][-2]
            shifted = zip((0.0, *rows[-1][:-2], 0.0), low, strict=True)
            rows.append([a - top * b for a, b in shifted])
        if any(self.c[1:]):
            series = _array(self._series(list(self.c), length))
        else:  # without zeros y is x_0 but for its size
            series = self.c[0] * _array(first)
        series[0, n] += self.d
        return np.array(rows), [(0.0, length, series)]

    def _taylor(self, t: float, span: float, moves: Moves) -> Array:
        """Return y's series from t on."""
        if t:
            rows = moves.series(t, span, self.terms(span))
        else:
            rows = _array(self._series(list(self.c), span))
        rows[0, -1] += self.d
        return rows

    def _series(self, row: list[float], t: float) -> list[list[float]]:
        """Return t^j/j! times the j-th derivatives of ``row`` x, on the state and on the input."""
        low, row = list(enumerate((*self.low, -1.0))), [*row, 0.0]
        rows = [row]
        for j in range(1, self.terms(t)):
            step, top, row = t / j, row[-2], [0.0, *row[:-2], 0.0]
            for i, a in low:
                row[i] = (row[i] - top * a) * step
            rows.append(row)
        return rows

    def _stretches(self, length: float) -> list[tuple[float, float]]:
        """Return (begin, span) of stretches of [0, length] short enough for one Taylor series.

        A mode that is over does not count, as long as its series, too, stays below what is left
        of it. None at all where there would be too many.
        """
        if self.size * length <= _SPAN:
            return [(0.0, length)]
        poles = self.plant.poles() * self.dt
        terms = _MOST_TERMS + len(self.low)
        modes = [
            (-rate, size, terms * log(max(1.0, size * length)))
            for rate, size in zip(poles.real.tolist(), np.abs(poles).tolist(), strict=True)
            if size > 0
        ]
        out: list[tuple[float, float]] = []
        t = 0.0
        while t < length * (1 - 1e-12):
            span = length - t
            for decay, size, series in modes:
                over = decay * t - _DEAD
                if over <= series:
                    span = min(span, max(_SPAN, over) / size)
            if len(out) == _MOST_STRETCHES:
                return []
            out.append((t, span))
            t += span
        return out

    def terms(self, span: float) -> int:
        """Return how many Taylor terms carry a stretch to the last bit."""
        turn, j, term = min(self.size * span, _SPAN), 0, 1.0
        while term > _TERM:
            j += 1
            term *= turn / j
        return len(self.low) + j


def _array(rows: list[list[float]]) -> Array:
    """Return the rows as an array; flat, they are read twice as fast."""
    count, width = len(rows), len(rows[0])
    flat = np.fromiter(chain.from_iterable(rows), float, count * width)
    return flat.reshape(count, width)


def _scaled(plant: Plant, dt: float) -> tuple[tuple[float, ...], tuple[float, ...], float]:
    """Return (low, c, d) in units of dt; exactly, where floats subtract or outgrow their range."""
    lead, n, power = plant.den[0], len(plant.den) - 1, 1.0
    gain, shorter = plant.sensor / lead, len(plant.den) - len(plant.num)
    if not shorter or isinf(gain):
        low, c, d = _exactly(plant, dt)
        return tuple(map(float, low)), tuple(map(float, c)), float(d)
    monic, top = [], []
    for i in range(1, n + 1):
        power *= dt
        monic.append(plant.den[i] / lead * power)
        top.append(gain * plant.num[i - shorter] * power if i >= shorter else 0.0)
    return tuple(monic[::-1]), tuple(top[::-1]), 0.0


def _exactly(plant: Plant, dt: float) -> tuple[list[Decimal], list[Decimal], Decimal]:
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
