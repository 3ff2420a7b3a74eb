"""A frequency response known at some frequencies: measured, or computed elsewhere.

Between its points the logarithm of the gain, ln|G| + j arg G, is a smooth function of ln w, and
each of its parts is joined by a ``Curve``, which crosses a level where the points do and nowhere
else. Outside its points a response is not known, and asking is an error.
"""

from cmath import exp
from dataclasses import dataclass, field
from math import log, pi, tau
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from zoh import checks
from zoh.errors import SpecError
from zoh.lti.curve import Array, Curve
from zoh.lti.poly import ComplexArray
from zoh.lti.systems import Plant, Sampled, sample_time

AMBIGUOUS_DEG = 120.0  # a turn between neighbours: the other way round would be 240 or less
_MOST_DB = 6160.0  # 1e308: beyond it, or below its opposite, a gain is no float's
_MOST_HZ = 1e307  # beyond it rad/s are no float's
_AT_NYQUIST = 1e-9  # relative: k 2 pi/(N dt) comes out this near to pi/dt, and nothing else does


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrequencyResponse:
    """A table of w, gain and phase; shape (n,) each, n >= 2, kept as read-only float64 arrays.

    w            rad/s, ascending, distinct, above 0
    magnitude    |G|, above 0 (a ratio, not dB)
    phase_deg    deg, wrapped in any way; kept unwrapped, each turn the shorter way round
    dt           s, where it is the response from a sampled input u_k to a sampled output y_k:
                 hold, compute delay and sensor included, no point above Nyquist's frequency.
                 None for a continuous response
    uncertainty  1 sigma of the complex value relative to its size, in the magnitude (relative)
                 and in the phase (rad) alike, independent from point to point; None: not known
    neglected    a bound, relative to |G|, on what the values leave out; None: nothing known of
    unstable_poles  how many the plant has behind its table, where nothing shows them

    Raises SpecError for columns of different lengths, values out of range or out of order.

    >>> servo = FrequencyResponse(w=[1, 2, 4], magnitude=[1, 0.5, 0.25], phase_deg=[-90] * 3)
    >>> abs(servo.at(3.0) + 1j / 3) < 1e-15  # 1/s is a straight line over ln w
    True
    >>> servo.at(5.0)
    Traceback (most recent call last):
    zoh.errors.SpecError: wc must be inside the table, 1 to 4 rad/s, got 5.0: ...
    """

    w: Array
    magnitude: Array
    phase_deg: Array
    dt: float | None = None
    uncertainty: Array | None = None
    neglected: Array | None = None
    unstable_poles: int = 0
    log_gain: Curve = field(init=False, repr=False)
    turn: Curve = field(init=False, repr=False)

    def __post_init__(self) -> None:
        put = object.__setattr__
        w = checks.ascending("w", self.w)
        magnitude = checks.column("magnitude", self.magnitude, len(w), above=0.0)
        phase = np.unwrap(checks.column("phase_deg", self.phase_deg, len(w)), period=360.0)
        put(self, "w", w)
        put(self, "magnitude", magnitude)
        put(self, "phase_deg", checks.column("phase_deg", phase))
        way_out = "count the plant's poles on the right, or outside the unit circle"
        put(self, "unstable_poles", checks.whole("unstable_poles", self.unstable_poles, 0, way_out))
        put(self, "dt", None if self.dt is None else _clock(self.dt, w))
        for name in ("uncertainty", "neglected"):
            value = getattr(self, name)
            if value is not None:
                given = checks.numbers(name, value)
                each = given if given.ndim else np.full(len(w), given)
                put(self, name, checks.column(name, each, len(w), least=0.0))
        put(self, "log_gain", Curve(x=np.log(w), y=np.log(magnitude)))
        put(self, "turn", Curve(x=np.log(w), y=np.radians(self.phase_deg)))

    @classmethod
    def from_complex(
        cls, *, w: npt.ArrayLike, gain: npt.ArrayLike, dt: float | None = None,
        uncertainty: Any = None, unstable_poles: int = 0,
    ) -> "FrequencyResponse":  # fmt: skip
        """Return the table of complex gains at w in rad/s, such as a cross spectrum's quotient.

        >>> FrequencyResponse.from_complex(w=[1, 2], gain=[-1j, -0.5j]).phase_deg.tolist()
        [-90.0, -90.0]
        """
        value, w = np.atleast_1d(checks.complex_gains("gain", gain)), checks.ascending("w", w)
        if value.shape != w.shape:
            bound = f"must be {len(w)} numbers, one per w"
            raise SpecError("gain", bound, value.shape, "complete the rows")
        with np.errstate(over="ignore"):
            size = np.abs(value)
        wrong = np.flatnonzero((size == 0) | ~np.isfinite(size))
        if wrong.size:
            i, bound = int(wrong[0]), "must have a size above 0 that a 64-bit float can hold"
            raise SpecError(f"gain[{i}]", bound, complex(value[i]), "mend this row or leave it out")
        return cls(
            w=w,
            magnitude=size,
            phase_deg=np.degrees(np.angle(value)),
            dt=dt,
            uncertainty=uncertainty,
            unstable_poles=unstable_poles,
        )

    @classmethod
    def from_bode(
        cls, *, hz: npt.ArrayLike, db: npt.ArrayLike, phase_deg: npt.ArrayLike,
        dt: float | None = None, uncertainty: Any = None, unstable_poles: int = 0,
    ) -> "FrequencyResponse":  # fmt: skip
        """Return the table of an analyser's columns: Hz, dB and degrees.

        >>> FrequencyResponse.from_bode(hz=[1, 10], db=[20, 0], phase_deg=[0, -90]).magnitude
        array([10.,  1.])
        """
        f = checks.ascending("hz", hz)
        if f[-1] > _MOST_HZ:
            bound = f"must be at most {_MOST_HZ:g} Hz"
            raise SpecError(f"hz[{len(f) - 1}]", bound, float(f[-1]), "leave this row out")
        if dt is not None:
            _below_nyquist("hz", f, 0.5 / sample_time(dt), "1/(2 dt)", "Hz")
        level = checks.column("db", db, len(f))
        beyond = np.flatnonzero(np.abs(level) > _MOST_DB)
        if beyond.size:
            i = int(beyond[0])
            bound = f"must be a gain in dB within +-{_MOST_DB:g}"
            raise SpecError(f"db[{i}]", bound, float(level[i]), "mend this row or leave it out")
        return cls(
            w=tau * f,
            magnitude=10 ** (level / 20),
            phase_deg=checks.column("phase_deg", phase_deg, len(f)),
            dt=dt,
            uncertainty=uncertainty,
            unstable_poles=unstable_poles,
        )

    @property
    def band(self) -> tuple[float, float]:
        """Return the lowest and the highest frequency in rad/s."""
        return float(self.w[0]), float(self.w[-1])

    @property
    def reaches_nyquist(self) -> bool:
        """Return whether nothing is left above the table: its last point is pi/dt."""
        return self.dt is not None and self.w[-1] * self.dt >= pi * (1 - _AT_NYQUIST)

    @property
    def ambiguous(self) -> tuple[int, ...]:
        """Return every i whose turn to point i + 1 is so large that it may be the other way."""
        return tuple(np.flatnonzero(np.abs(np.diff(self.phase_deg)) > AMBIGUOUS_DEG).tolist())

    @overload
    def at(self, wc: float) -> complex: ...
    @overload
    def at(self, wc: npt.ArrayLike) -> ComplexArray: ...
    def at(self, wc: Any) -> Any:
        """Return the complex gain at wc in rad/s, a number or an array; SpecError outside."""
        low, high = self.band
        if isinstance(wc, float) and low <= wc <= high:
            return exp(complex(self.log_gain.at(log(wc)), self.turn.at(log(wc))))
        w = self._inside(checks.frequencies("wc", wc))
        x = np.log(w)
        value = np.exp(self.log_gain.at(x) + 1j * self.turn.at(x))
        return complex(value) if w.ndim == 0 else value

    def spread_at(self, wc: float) -> float:
        """Return the relative 1 sigma of ``at(wc)`` that the points' own leads to; 0 unknown."""
        x = self._log_of(wc)
        if self.uncertainty is None:
            return 0.0
        parts = (self.log_gain.weights(x), self.turn.weights(x))
        return max(float(np.linalg.norm(part * self.uncertainty)) for part in parts)

    def neglected_at(self, wc: float) -> float:
        """Return the relative bound on what ``at(wc)`` leaves out; 0 where none was given."""
        x = self._log_of(wc)
        if self.neglected is None:
            return 0.0
        parts = (self.log_gain.weights(x), self.turn.weights(x))
        return max(float(np.abs(part) @ self.neglected) for part in parts)

    def _log_of(self, wc: float) -> float:
        """Return ln wc; SpecError where wc is no number inside the table."""
        return log(self._inside(np.array(checks.number("wc", wc, "give rad/s"))))

    def _inside(self, w: Array) -> Array:
        """Return w in rad/s; raise SpecError where any of it is outside the table."""
        low, high = self.band
        outside = w[(w < low) | (w > high)]
        if outside.size:
            raise SpecError(
                "wc",
                f"must be inside the table, {low:.6g} to {high:.6g} rad/s",
                float(outside.flat[0]),
                "measure there; nothing is known outside",
            )
        return w

    def scaled(self, gain: float) -> "FrequencyResponse":
        """Return the response times a real gain, such as a sensor's."""
        k = checks.number("gain", gain)
        if k == 0:
            raise SpecError("gain", "must not be 0", gain, "a response of 0 is no response")
        with np.errstate(over="ignore"):  # what overflows is refused as not finite
            magnitude = abs(k) * self.magnitude
        if not np.isfinite(magnitude).all() or not magnitude.all():
            bound = "must leave gains that a 64-bit float can hold"
            raise SpecError("gain", bound, gain, "use other units")
        return FrequencyResponse(
            w=self.w, magnitude=magnitude,
            phase_deg=self.phase_deg - (180.0 if k < 0 else 0.0), dt=self.dt,
            uncertainty=self.uncertainty, neglected=self.neglected,
            unstable_poles=self.unstable_poles,
        )  # fmt: skip

    def without(self, first: int) -> "FrequencyResponse":
        """Return the response without every second point from ``first`` on, both ends kept."""
        kept = np.ones(len(self.w), bool)
        kept[first:-1:2] = False
        return FrequencyResponse(
            w=self.w[kept], magnitude=self.magnitude[kept], phase_deg=self.phase_deg[kept],
            dt=self.dt, unstable_poles=self.unstable_poles,
        )  # fmt: skip

    def __rmul__(self, controller: Plant | Sampled) -> "TabledLoop":
        """Return the loop of a controller and this table; the controller stays exact."""
        if not isinstance(controller, Plant | Sampled):
            return NotImplemented
        return TabledLoop(controller=controller, table=self)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TabledLoop:
    """A controller, known everywhere, in series with a table, known at its points.

    Made by ``controller * table``: a Sampled with a sampled response of the same dt, or a
    continuous one (a Plant) with a continuous response. Raises SpecError for any other pair.

    >>> table = FrequencyResponse(w=[1, 2], magnitude=[1, 1], phase_deg=[0, -10], dt=0.1)
    >>> abs((Sampled(num=[2], den=[1], dt=0.1) * table).at(1.0))
    2.0
    """

    controller: Plant | Sampled
    table: FrequencyResponse

    def __post_init__(self) -> None:
        if not isinstance(self.controller, Plant | Sampled):
            way_out = "zoh.Sampled for a sampled table, zoh.Plant for a continuous one"
            raise SpecError("controller", "must be a system", self.controller, way_out)
        if not isinstance(self.table, FrequencyResponse):
            way_out = "multiply two models with *"
            raise SpecError("table", "must be a zoh.FrequencyResponse", self.table, way_out)
        clock = self.controller.dt if isinstance(self.controller, Sampled) else None
        if clock != self.table.dt:
            raise SpecError(
                "dt",
                f"must be the same throughout a loop ({clock!r} in the controller)",
                self.table.dt,
                "sample a continuous response with zoh.sample, or say dt where it was sampled",
            )

    @property
    def dt(self) -> float | None:
        """Return the sample time in s, None for a continuous loop."""
        return self.table.dt

    @overload
    def at(self, wc: float) -> complex: ...
    @overload
    def at(self, wc: npt.ArrayLike) -> ComplexArray: ...
    def at(self, wc: Any) -> Any:
        """Return the complex gain at wc in rad/s; SpecError outside the table."""
        return self.controller.at(wc) * self.table.at(wc)

    def __rmul__(self, controller: Sampled) -> "TabledLoop":
        """Return the loop with one more controller in series."""
        if not isinstance(controller, Sampled) or not isinstance(self.controller, Sampled):
            return NotImplemented
        return TabledLoop(controller=controller * self.controller, table=self.table)


def _clock(dt: Any, w: Array) -> float:
    """Return dt in s; raise SpecError where a point lies above Nyquist's frequency."""
    clock = sample_time(dt)
    _below_nyquist("w", w, pi / clock, "pi/dt", "rad/s")
    return clock


def _below_nyquist(name: str, column: Array, top: float, formula: str, unit: str) -> None:
    """Raise SpecError where a frequency is above Nyquist's, ``top``, in its unit."""
    if float(column[-1]) > top * (1 + _AT_NYQUIST):
        raise SpecError(
            name,
            f"must not go beyond the Nyquist frequency {formula} = {top:.6g} {unit}",
            float(column[-1]),
            "leave those rows out: they repeat the ones below",
        )
