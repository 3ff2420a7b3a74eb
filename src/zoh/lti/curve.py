"""A curve through points that does nothing between them that they do not show.

Cubic pieces whose slopes are those of the parabola through three neighbours, lowered where the
curve would otherwise leave the range of the two points around it. So it crosses a level exactly
where the points change sides, once: a crossing is neither invented nor lost. On smooth data the
error falls with the third power of the spacing, next to a local extreme with the second.
Source: F. N. Fritsch and R. E. Carlson, Monotone piecewise cubic interpolation, SIAM J. Numer.
Anal. 17(2), 1980 (a slope of at most three times that of either chord keeps a piece monotone).
"""

from bisect import bisect_right
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curve:
    """The curve through (x, y), x ascending and distinct, shape (n,) each with n >= 2.

    >>> x = np.array([0.0, 1.0, 2.0, 3.0])
    >>> Curve(x=x, y=x**2).at(1.5)  # a parabola is met exactly wherever nothing is lowered
    2.25
    >>> Curve(x=x, y=np.array([0.0, 0.0, 1.0, 1.0])).at(0.5)  # no overshoot beside a step
    0.0
    """

    x: Array
    y: Array
    slopes: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "slopes", _slopes(self.x, self.y))

    def at(self, x: Any) -> Any:
        """Return the value at x, a number or an array within the points."""
        if isinstance(x, float):
            return self._one(x)
        i = np.clip(np.searchsorted(self.x, x, side="right") - 1, 0, len(self.x) - 2)
        h = self.x[i + 1] - self.x[i]
        t = (x - self.x[i]) / h
        rise = self.y[i + 1] - self.y[i]
        first, last = h * self.slopes[i], h * self.slopes[i + 1]
        bend = t * (1 - t) * ((1 - t) * (first - rise) + t * (rise - last))
        value = np.where(t <= 0.5, self.y[i] + t * rise, self.y[i + 1] - (1 - t) * rise) + bend
        return float(value) if np.ndim(x) == 0 else value

    def _one(self, x: float) -> float:
        """Return the value at one x in plain Python, ten times as fast: crossings are sought so."""
        i = min(max(bisect_right(self.x, x) - 1, 0), len(self.x) - 2)
        near = slice(i, i + 2)
        (left, right), (low, high) = self.x[near].tolist(), self.y[near].tolist()
        first, last = self.slopes[near].tolist()
        h, rise = right - left, high - low
        t = (x - left) / h
        value = low + t * rise if t <= 0.5 else high - (1 - t) * rise
        bend = t * (1 - t) * ((1 - t) * (h * first - rise) + t * (rise - h * last))
        return float(value + bend)

    def weights(self, x: float) -> Array:
        """Return how much the value at x moves with each y, shape (n,).

        Few are not 0. Where a slope is lowered these are the derivatives as it stands.
        """
        i = int(np.clip(np.searchsorted(self.x, x) - 1, 0, len(self.x) - 2))
        near = slice(max(0, i - 2), i + 4)
        points, values = self.x[near], self.y[near]
        size = 1e-6 * max(1.0, float(np.abs(values).max()))
        moved = np.zeros(len(self.x))
        for k in range(len(points)):
            bump = size * (np.arange(len(points)) == k)
            up, down = (Curve(x=points, y=values + sign * bump).at(x) for sign in (1, -1))
            moved[near.start + k] = (up - down) / (2 * size)
        return moved


def _slopes(x: Array, y: Array) -> Array:
    """Return the slope at every point."""
    h = np.diff(x)
    chord = np.diff(y) / h
    if len(chord) == 1:
        return np.repeat(chord, 2)
    inner = (h[1:] * chord[:-1] + h[:-1] * chord[1:]) / (h[1:] + h[:-1])
    first = chord[0] + (chord[0] - chord[1]) * h[0] / (h[0] + h[1])
    last = chord[-1] + (chord[-1] - chord[-2]) * h[-1] / (h[-1] + h[-2])
    slopes = np.concatenate([[first], inner, [last]])
    before, after = np.append(chord[0], chord), np.append(chord, chord[-1])
    most = 3 * np.minimum(np.abs(before), np.abs(after))
    lowered = np.sign(before) * np.minimum(np.abs(slopes), most)
    return np.where((before * after > 0) & (slopes * before > 0), lowered, 0.0)
