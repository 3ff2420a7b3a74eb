"""The controller in its loop with the plant: the plant in Python, the controller anywhere.

Each sample the plant's output is measured in the controller's numbers, the controller answers, and
its answer is held at the plant's input. Two controllers that are the same give the same trajectory;
one that differs in a single bit leaves it, since every sample works on what the last one did.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isnan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from zoh.analysis.realised import realised
from zoh.firmware.book import Format
from zoh.firmware.trials import TYPES
from zoh.lti.systems import Sampled

Answer = Callable[[NDArray[Any]], Any]  # (r, y, ff) -> u, all in the controller's numbers


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop:
    """A plant, the numbers of its controller, and a reference in physical units.

    In the second half the reference is reversed, in the last quarter the input is disturbed by
    a tenth of the largest u that the loop had until then.
    """

    plant: Sampled
    format: Format
    reference: float
    samples: int

    def trajectory(self, answer: Answer) -> NDArray[Any]:
        """Return u of every sample."""
        a, c, direct = realised(self.plant)
        x = [0.0] * len(a)
        under_way, last = [0.0] * self.plant.delay, 0.0
        kind = np.dtype(TYPES[self.format.number])
        given, out = np.zeros(3, kind), np.zeros(self.samples, kind)
        u_unit, largest = float(self.format.u_unit), 0.0
        for k in range(self.samples):
            arrives = under_way[0] if under_way else last  # at once: u of the sample before
            y = sum(p * q for p, q in zip(c, x, strict=True)) + direct * arrives
            r = self.reference if 2 * k < self.samples else -self.reference
            given[0], given[1] = self._number(r), self._number(y)
            out[k] = answer(given)
            u = float(out[k]) * u_unit
            largest = max(largest, abs(u))
            last = u + (0.1 * largest if 4 * k >= 3 * self.samples else 0.0)
            under_way.append(last)
            e = under_way.pop(0)
            first = x[0] - sum(p * q for p, q in zip(a, x, strict=True)) + e if x else 0.0
            x = [first, *(x[i] + x[i - 1] for i in range(1, len(x)))]
        return out

    def _number(self, y: float) -> float:
        """Return y in the controller's numbers, as a converter gives them: rounded, with ends."""
        if not self.format.whole:
            largest = float(np.finfo(TYPES[self.format.number]).max)
            return min(largest, max(-largest, y))  # the comparison leaves NaN to the first
        steps = 0 if isnan(y) else min(1e18, max(-1e18, y / float(self.format.y_unit)))
        return min(self.format.most, max(self.format.least, round(steps)))
