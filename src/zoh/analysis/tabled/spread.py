"""What an error of the points does to the margins, to first order.

With u = ln|L| and phi = arg L over x = ln w, and a relative error e of L (its size and its
angle in rad alike), the crossings move with it, and

    PM:     e sqrt(1 + (phi'/u')^2)          ln GM:  e sqrt(1 + (u'/phi')^2)
    Ms:     Ms^2 |L| e

For e = 1 sigma these are 1 sigma; for a bound on |e| they are bounds.
Source: the implicit function theorem at a crossing (u = 0, phi = -pi); at a minimum of |1 + L|
its place does not matter to first order.
"""

from cmath import phase
from collections.abc import Callable
from math import degrees, exp, hypot, inf, log
from typing import Protocol

from zoh.analysis.tabled.path import Path
from zoh.analysis.tabled.results import Spread

_STEP = 1e-4  # of ln w: a slope to 1e-8 of the curvature, far finer than any error's own size
_DB = 20 / log(10)


class Figures(Protocol):
    """Where the figures were read."""

    @property
    def crossover(self) -> float | None:
        """rad/s, of the phase margin."""

    @property
    def phase_crossover(self) -> float | None:
        """rad/s, of the gain margin."""

    @property
    def ms_frequency(self) -> float:
        """rad/s, of Ms."""

    @property
    def modulus_margin(self) -> float:
        """1/Ms."""


def spread(path: Path, seen: Figures, error: Callable[[float], float]) -> Spread:
    """Return how far the figures may be off where L at w has the relative error error(w)."""
    ms = inf if seen.modulus_margin == 0 else 1 / seen.modulus_margin
    size = abs(path.at(seen.ms_frequency))
    phase_margin = gain_margin = None
    if seen.crossover is not None:
        u, phi = _slopes(path, seen.crossover)
        phase_margin = degrees(error(seen.crossover) * _sheared(phi, u))
    if seen.phase_crossover is not None:
        u, phi = _slopes(path, seen.phase_crossover)
        gain_margin = _DB * error(seen.phase_crossover) * _sheared(u, phi)
    return Spread(
        phase_margin_deg=phase_margin,
        gain_margin_db=gain_margin,
        ms=ms * ms * size * error(seen.ms_frequency),
    )


def _sheared(along: float, across: float) -> float:
    return hypot(1.0, along / across) if across else inf


def _slopes(path: Path, w: float) -> tuple[float, float]:
    """Return d ln|L|/d ln w and d arg L/d ln w."""
    low, high = path.table.band
    a, b = max(low, w * exp(-_STEP)), min(high, w * exp(_STEP))
    ratio = path.at(b) / path.at(a)
    width = log(b / a)
    return log(abs(ratio)) / width, phase(ratio) / width
