"""Candidates that cannot meet what is asked, told apart by a glance at some frequencies.

The largest |1/(1 + L)| of a few frequencies is never larger than Ms itself: where it is above
the Ms allowed, nothing need be measured. The same for Mt, and for the effort of the first sample.
"""

from collections.abc import Sequence
from math import inf, pi

import numpy as np
import numpy.typing as npt

from zoh.choice.judge import Judge
from zoh.lti.systems import Sampled
from zoh.lti.wplane import warp
from zoh.solving import SolvedLaw

_POINTS = 160  # frequencies looked at
_BEYOND = 30.0  # times outside the corners

ComplexArray = npt.NDArray[np.complex128]


class Sieve:
    """A plant at frequencies below Nyquist's, and the peaks allowed there."""

    def __init__(self, judge: Judge) -> None:
        sampled, asked = judge.facing, judge.requirements
        top = 0.9999 * pi / sampled.dt
        low = min([top, *sampled.corners().tolist()]) / _BEYOND
        w = np.geomspace(low, top, _POINTS)
        self._s = 1j * np.array([warp(float(x), sampled.dt) for x in w])
        self._plant: ComplexArray = np.asarray(sampled.at(w), complex)
        self._ms, self._mt, self._judge = asked.ms, asked.mt, judge

    @property
    def tells(self) -> bool:
        """Return whether anything is asked that a glance can tell."""
        return self._peaks or self._judge.asks_effort

    @property
    def _peaks(self) -> bool:
        return self._ms is not None or self._mt is not None

    def slack(self, laws: Sequence[SolvedLaw]) -> list[float]:
        """Return for each of one law's solutions a bound that its slack is not above."""
        found = np.array([self._judge.effort_slack(law) for law in laws])
        if self._peaks:
            found = np.minimum(found, self._of_peaks([law.controller for law in laws]))
        return [float(x) if x == x else inf for x in found]

    def _of_peaks(self, controllers: Sequence[Sampled]) -> npt.NDArray[np.float64]:
        num = np.array([c.num_w for c in controllers])
        den = np.array([c.den_w for c in controllers])
        found = np.full(len(controllers), inf)
        with np.errstate(all="ignore"):
            loop = _at(num, self._s) / _at(den, self._s) * self._plant
            back = np.abs(1 + loop)
            if self._ms is not None:
                found = np.minimum(found, 1 - 1 / (back.min(axis=1) * self._ms))
            if self._mt is not None and self._mt > 0:
                found = np.minimum(found, 1 - (np.abs(loop) / back).max(axis=1) / self._mt)
        return found


def _at(a: npt.NDArray[np.float64], s: ComplexArray) -> ComplexArray:
    """Return polynomials, shape (C, n + 1), at the points s, shape (C, K)."""
    out = np.zeros((len(a), len(s)), complex)
    for column in a.T:
        out = out * s + column[:, None]
    return out
