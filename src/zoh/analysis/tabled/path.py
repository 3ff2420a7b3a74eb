"""A tabled loop along its frequencies, and what is taken for granted outside its table.

Below the table the plant is taken as K/(j w)^k, where its slope and its phase at the low end
say so; above it, its gain is taken to stay below the last one. The controller is known there.
"""

from dataclasses import dataclass
from math import pi, remainder

import numpy as np

from zoh.analysis.close import around
from zoh.errors import SpecError
from zoh.lti import poly
from zoh.lti.curve import Array
from zoh.lti.frequency_response import FrequencyResponse, TabledLoop
from zoh.lti.poly import ComplexArray
from zoh.lti.systems import Plant, Sampled
from zoh.lti.wplane import unwarp

_PER_CELL = 8  # points from one row of the table to the next: what the controller does between
_MOST = 40_000  # points in all; a longer table is dense enough for fewer
_SLOPE = 0.2  # of a slope from a whole number: a corner half an octave away turns it as much
_PHASE_DEG = 30.0  # of a phase from its asymptote: that corner again, and some delay
_NEARER_DEG = 45.0  # of a phase at w = 0 from its asymptote: beyond, another one is nearer
_FAR_BELOW = 1e-4  # of the lowest corner: there a loop is its asymptote within 1e-4 rad


@dataclass(frozen=True, slots=True, kw_only=True)
class LowEnd:
    """The plant below its table: gain/(j w)^integrators with a real gain of either sign."""

    integrators: int
    gain: float

    def at(self, w: Array) -> ComplexArray:
        """Return the complex gain."""
        return np.asarray(self.gain / (1j * w) ** self.integrators)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Path:
    """A loop in its band.

    table, controller  the loop's two parts; the controller is None where all is in the table
    w, gain            rad/s from the table's first point to its last, and the loop there
    low                the plant below the table, None where its low end does not say
    above              a bound on |L| beyond the table if the plant's gain rises no more; 0
                       where the table reaches Nyquist's frequency
    """

    table: FrequencyResponse
    controller: Plant | Sampled | None
    w: Array
    gain: ComplexArray
    low: LowEnd | None
    above: float

    @classmethod
    def of(cls, loop: FrequencyResponse | TabledLoop) -> "Path":
        """Return the path of a loop."""
        table, controller = (loop, None) if isinstance(loop, FrequencyResponse) else _parts(loop)
        low, high = table.band
        corners = _corners(controller)
        inside = corners[(corners > low) & (corners < high)]
        w = np.unique(np.concatenate([_between(table.w), inside, _turns(controller, low, high)]))
        above = 0.0
        if not table.reaches_nyquist:
            above = float(table.magnitude[-1]) * _most_above(controller, corners, high)
        return cls(
            table=table, controller=controller, w=w, gain=loop.at(w), low=low_end(table),
            above=above,
        )  # fmt: skip

    def coarser(self) -> tuple["Path", "Path"]:
        """Return the paths of the two tables without every second point."""
        first, second = (self.table.without(start) for start in (1, 2))
        if self.controller is None:
            return Path.of(first), Path.of(second)
        return Path.of(self.controller * first), Path.of(self.controller * second)

    def at(self, w: float) -> complex:
        """Return the loop's gain at one frequency in the band."""
        gain = self.table.at(w)
        return gain if self.controller is None else self.controller.at(w) * gain

    def below(self) -> tuple[Array, ComplexArray]:
        """Return (w, L) from far below the table up to its first point, by ``low``."""
        if self.low is None:
            return np.empty(0), np.empty(0, complex)
        first = self.table.band[0]
        corners = _corners(self.controller)
        lowest = _FAR_BELOW * min([first, *corners[corners > 0].tolist()])
        even = np.geomspace(lowest, first, int(40 * np.log10(first / lowest)) + 2)
        w = np.unique(np.concatenate([even, corners[(corners > lowest) & (corners < first)]]))
        gain = self.low.at(w)
        return w, gain if self.controller is None else self.controller.at(w) * gain


def low_end(table: FrequencyResponse) -> LowEnd | None:
    """Return what the plant is below its table, by the slope and the phase of its first octave.

    >>> low_end(FrequencyResponse(w=[1, 2, 3], magnitude=[6, 3, 2], phase_deg=[-95, -100, -110]))
    LowEnd(integrators=1, gain=6.0)
    """
    slope = low_slope(table)
    k = -round(slope)
    off = (float(table.phase_deg[0]) + 90 * k + 90) % 180 - 90  # of either sign of the gain
    if abs(slope + k) > _SLOPE or abs(off) > _PHASE_DEG:
        return None
    turned = round((float(table.phase_deg[0]) - off + 90 * k) / 180)
    size = float(table.magnitude[0] * table.w[0] ** k)
    return LowEnd(integrators=k, gain=-size if turned % 2 else size)


def low_slope(table: FrequencyResponse) -> float:
    """Return d ln|G|/d ln w over the first octave, two points or more, by least squares."""
    many = _first_octave(table)
    return _slope(np.log(table.w[:many]), np.log(table.magnitude[:many]))


def settled(path: Path) -> bool:
    """Return whether the phase, too, goes to that of ``low`` at w = 0, in line over w.

    So does that of a lag or a delay. At a crest the gain is level as a constant is, and the phase
    goes on to that of the slope before it.
    """
    if path.low is None:
        return False
    many = _first_octave(path.table)
    w, phase = path.table.w[:many], path.table.phase_deg[:many]
    rest = float(phase.mean()) - _slope(w, phase) * float(w.mean())
    asymptote = -90 * path.low.integrators + (180 if path.low.gain < 0 else 0)
    return abs(remainder(rest - asymptote, 360)) <= _NEARER_DEG


def _first_octave(table: FrequencyResponse) -> int:
    """Return how many points the first octave has, two or more."""
    return max(2, int(np.searchsorted(table.w, 2 * table.w[0], side="right")))


def _slope(x: Array, y: Array) -> float:
    """Return the slope of a line by least squares."""
    x = x - x.mean()
    return float(x @ y / (x @ x))


def quiet_below(path: Path) -> bool:
    """Return whether L is below 1 where the table begins, and was rising up to there or level."""
    level = boundary_poles(path.controller)[0] <= 0 and low_slope(path.table) > -_SLOPE
    return level and abs(path.gain[0]) < 1


def boundary_poles(controller: Plant | Sampled | None) -> tuple[int, int]:
    """Return (integrators less zeros at the origin, unstable poles) of a controller.

    Raises SpecError for another pole on the boundary: the loop's gain is infinite there.
    """
    if controller is None:
        return 0, 0
    zeros, poles = at_rest(controller)
    _, den = _fraction(controller)
    rest = poly.roots(den[: len(den) - poles])
    if den[0] == 0 or any(abs(r.real) <= 1e-9 * abs(r) for r in rest):
        raise SpecError(
            "controller",
            "must have no pole on the stability boundary but integrators",
            list(controller.den),
            "its loop has an infinite gain there, which no table shows",
        )
    return poles - zeros, sum(1 for r in rest if r.real > 0)


def at_rest(controller: Plant | Sampled | None) -> tuple[int, int]:
    """Return how many zeros and how many poles a controller has at s = 0, or z = 1.

    >>> at_rest(Sampled(num=[1.0, -1.0], den=[1.0, -0.5], dt=0.1))
    (1, 0)
    """
    if controller is None:
        return 0, 0
    num, den = _fraction(controller)
    return _at_origin(num), _at_origin(den)


def _parts(loop: TabledLoop) -> tuple[FrequencyResponse, Plant | Sampled]:
    return loop.table, loop.controller


def _between(w: Array) -> Array:
    """Return the table's own frequencies and even steps of ln w between them."""
    per_cell = max(2, min(_PER_CELL, _MOST // len(w)))
    parts = np.arange(per_cell) / per_cell
    inner = w[:-1, None] * (w[1:] / w[:-1])[:, None] ** parts
    return np.append(inner.ravel(), w[-1])  # the points themselves to the bit: w (...)^0


def _corners(controller: Plant | Sampled | None) -> Array:
    """Return frequencies in rad/s around every pole and zero of the controller, ascending."""
    if controller is None:
        return np.empty(0)
    every = np.concatenate([poly.roots(a) for a in _fraction(controller)])
    v = around(every[np.isfinite(every)])
    v = np.unique(v[v > 0])
    if isinstance(controller, Plant):
        return v
    return np.array([unwarp(float(x), controller.dt) for x in v])


def _turns(controller: Plant | Sampled | None, low: float, high: float) -> Array:
    """Return frequencies at every 0.2 rad of the controller's own delay."""
    wait = 0.0
    if isinstance(controller, Sampled):
        wait = controller.delay * controller.dt
    elif controller is not None:
        wait = controller.dead_time
    if not wait:
        return np.empty(0)
    return np.linspace(low, high, min(int((high - low) * wait / 0.2) + 2, _MOST))


def _most_above(controller: Plant | Sampled | None, corners: Array, high: float) -> float:
    """Return the controller's largest gain from ``high`` on."""
    if controller is None:
        return 1.0
    if isinstance(controller, Sampled):
        w = np.linspace(high, pi / controller.dt, 400)
    else:
        w = high * np.geomspace(1.0, 1e6, 600)
    w = np.concatenate([w, corners[(corners > high) & (corners < w[-1])]])
    return float(np.abs(controller.at(w)).max())


def _fraction(controller: Plant | Sampled) -> tuple[poly.Poly, poly.Poly]:
    if isinstance(controller, Plant):
        return controller.num, controller.den
    return controller.num_w, controller.den_w


def _at_origin(a: poly.Poly) -> int:
    return len(a) - 1 - max(i for i, c in enumerate(a) if c)
