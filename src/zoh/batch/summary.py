"""What a long sweep comes to: counts and extremes, which merge in any order to the same bits.

Nothing is summed in floats. A least value that two loops share is the first one's.
"""

from dataclasses import dataclass
from math import inf, isnan, nan, sqrt
from typing import Any

import numpy as np
import numpy.typing as npt

from zoh.analysis.results import jsonable
from zoh.batch import bounds
from zoh.batch.columns import Results
from zoh.batch.figures import FIGURES
from zoh.batch.reason import Reason
from zoh.spec import Requirements

_EACH = 4  # of one figure: the least value and its loop, the largest and its loop
_95 = 1.959963984540054  # of a standard normal, 95 % are within so many standard deviations


@dataclass(frozen=True, slots=True, kw_only=True)
class Extremes:
    """The least and the largest value of a figure, and the loops, counted from 0, they are in.

    Over the loops in which the figure exists; without any, the values are NaN and the loops -1.
    """

    least: float = nan
    least_at: int = -1
    most: float = nan
    most_at: int = -1

    def merged(self, other: "Extremes") -> "Extremes":
        """Return the extremes of both."""
        low = min((self.least, self.least_at), (other.least, other.least_at), key=_first_of_least)
        high = min((self.most, self.most_at), (other.most, other.most_at), key=_first_of_most)
        return Extremes(least=low[0], least_at=low[1], most=high[0], most_at=high[1])


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """Counts and extremes of the loops of a sweep.

    reasons   how many loops each ``Reason`` has, in their order
    met       how many are as asked for and keep every requirement
    extremes  one for each of ``zoh.batch.figures.FIGURES``
    """

    reasons: tuple[int, ...]
    met: int
    extremes: tuple[Extremes, ...]

    @classmethod
    def of(cls, results: Results, requirements: Requirements, start: int = 0) -> "Summary":
        """Return the summary of a batch whose first loop is number ``start``."""
        counts = np.bincount(results["reason"], minlength=len(Reason))
        return cls(
            reasons=tuple(int(n) for n in counts),
            met=int(np.count_nonzero(bounds.met(requirements, results))),
            extremes=tuple(_extremes(results[f.name], start) for f in FIGURES),
        )

    @classmethod
    def nothing(cls) -> "Summary":
        """Return the summary of no loop."""
        empty = tuple(Extremes() for _ in FIGURES)
        return cls(reasons=(0,) * len(Reason), met=0, extremes=empty)

    @property
    def loops(self) -> int:
        """Return how many loops there are."""
        return sum(self.reasons)

    @property
    def share(self) -> float:
        """Return the yield: the share of all loops that is met; NaN of none."""
        return self.met / self.loops if self.loops else nan

    @property
    def interval(self) -> tuple[float, float]:
        """Return 95 % confidence limits of the yield, if the loops are a random sample.

        Source: E. B. Wilson, Probable Inference, JASA 22 (1927).

        >>> results = {f.name: np.full(10, np.nan) for f in FIGURES}
        >>> results["reason"] = np.zeros(10, np.int8)
        >>> low, high = Summary.of(results, Requirements()).interval
        >>> round(low, 4), round(high, 4)  # 10/(10 + 1.96^2) and 1
        (0.7225, 1.0)
        """
        n, p, z = self.loops, self.share, _95
        middle, half = p + z * z / (2 * n), z * sqrt(p * (1 - p) / n + (z / (2 * n)) ** 2)
        low, high = (
            max(0.0, min(1.0, x / (1 + z * z / n))) for x in (middle - half, middle + half)
        )
        return low, high

    def merged(self, other: "Summary") -> "Summary":
        """Return the summary of both."""
        return Summary(
            reasons=tuple(a + b for a, b in zip(self.reasons, other.reasons, strict=True)),
            met=self.met + other.met,
            extremes=tuple(a.merged(b) for a, b in zip(self.extremes, other.extremes, strict=True)),
        )

    def packed(self) -> npt.NDArray[np.float64]:
        """Return all of it as one row of numbers, which ``unpacked`` reads."""
        ends = [x for e in self.extremes for x in (e.least, e.least_at, e.most, e.most_at)]
        return np.array([*self.reasons, self.met, *ends], float)

    @classmethod
    def unpacked(cls, row: npt.NDArray[np.float64]) -> "Summary":
        """Return the summary that ``packed`` made the row of."""
        n = len(Reason)
        ends = row[n + 1 :].reshape(-1, _EACH).tolist()
        return cls(
            reasons=tuple(int(x) for x in row[:n]),
            met=int(row[n]),
            extremes=tuple(
                Extremes(least=a, least_at=int(i), most=b, most_at=int(j)) for a, i, b, j in ends
            ),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form; a figure that no loop has is None."""
        found = {}
        for figure, e in zip(FIGURES, self.extremes, strict=True):
            ends = {"least": jsonable(e.least), "least_at": e.least_at,
                    "most": jsonable(e.most), "most_at": e.most_at}  # fmt: skip
            found[figure.name] = None if isnan(e.least) else ends
        return {
            "loops": self.loops,
            "reasons": {r.name.lower(): n for r, n in zip(Reason, self.reasons, strict=True)},
            "met": self.met,
            "yield": None if isnan(self.share) else self.share,
            "yield_interval_95": list(self.interval) if self.loops else None,
            "extremes": found,
        }


WIDTH = len(Reason) + 1 + _EACH * len(FIGURES)
"""The length of a packed row."""


def _extremes(values: npt.NDArray[np.generic], start: int) -> Extremes:
    column = values.astype(np.float64, copy=False)
    least, most = float(np.fmin.reduce(column)), float(np.fmax.reduce(column))  # a NaN is no end
    if isnan(least):
        return Extremes()
    low, high = int(np.argmax(column == least)), int(np.argmax(column == most))
    return Extremes(least=least, least_at=start + low, most=most, most_at=start + high)


def _first_of_least(end: tuple[float, int]) -> tuple[bool, float, int]:
    value, at = end
    return isnan(value), inf if isnan(value) else value, at


def _first_of_most(end: tuple[float, int]) -> tuple[bool, float, int]:
    value, at = end
    return isnan(value), inf if isnan(value) else -value, at
