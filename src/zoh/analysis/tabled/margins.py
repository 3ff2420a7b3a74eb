"""The margins of a tabled loop: every crossing that its table shows.

Crossings are those of the curve between the points, so of the points themselves, and of the
controller, which is known between them too. Source: that of ``analysis.margins``.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, log, radians, tau

import numpy as np

from zoh.analysis.crossings import sign_changes, valley
from zoh.analysis.margin_crossings import margin_deg
from zoh.analysis.squares import DROP
from zoh.analysis.tabled.beyond import beyond
from zoh.analysis.tabled.count import agreed
from zoh.analysis.tabled.path import Path, boundary_poles
from zoh.analysis.tabled.results import Spread, TableMargins
from zoh.analysis.tabled.spread import spread
from zoh.analysis.tabled.words import warnings
from zoh.lti.frequency_response import FrequencyResponse, TabledLoop

_VALLEYS = 6  # the lowest that are followed
_FEWEST = 5  # points of which every second can be left out


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What a path shows; the fields are those of ``Margins``."""

    gain_crossings: tuple[tuple[float, float], ...]
    phase_crossings: tuple[tuple[float, float], ...]
    gain_margin: float
    phase_crossover: float | None
    phase_margin_deg: float
    crossover: float | None
    modulus_margin: float
    ms_frequency: float

    @classmethod
    def of(cls, path: Path) -> "Seen":
        """Return what this path shows."""
        by_gain, by_phase = _gain_crossings(path), _phase_crossings(path)
        nearest_gain = min(by_phase, key=lambda c: abs(log(c[1])), default=(None, inf))
        nearest_phase = min(by_gain, key=lambda c: abs(c[1]), default=(None, inf))
        at, least = _least(lambda g: abs(1 + g), path)
        return cls(
            gain_crossings=by_gain,
            phase_crossings=by_phase,
            gain_margin=nearest_gain[1],
            phase_crossover=nearest_gain[0],
            phase_margin_deg=nearest_phase[1],
            crossover=nearest_phase[0],
            modulus_margin=least,
            ms_frequency=at,
        )


def table_margins(loop: FrequencyResponse | TabledLoop) -> TableMargins:
    """Return the margins of a tabled open loop in unity negative feedback.

    Raises SpecError for a controller with poles on the stability boundary other than
    integrators.

    >>> w = np.geomspace(0.1, 10, 41)
    >>> m = table_margins(FrequencyResponse.from_complex(w=w, gain=1 / (1j * w)))
    >>> m.stable, round(m.crossover, 9), round(m.phase_margin_deg, 9)
    (True, 1.0, 90.0)
    """
    path = Path.of(loop)
    coarse = path.coarser() if len(path.table.w) >= _FEWEST else ()
    seen, verdict, outside = Seen.of(path), agreed(path, coarse), beyond(path)
    mt_frequency, complementary = _least(lambda g: abs(1 + g) / abs(g), path)
    disk_frequency, disk = _least(lambda g: abs(1 + g) / max(abs(1 - g), 1e-300), path)
    spreads = _spreads(path, coarse, seen)
    none_seen = seen.phase_crossover is None
    return TableMargins(
        stable=None if verdict.unstable is None else verdict.unstable == 0,
        gain_margin=outside.gain_margin if none_seen else seen.gain_margin,
        phase_crossover=seen.phase_crossover,
        phase_margin_deg=seen.phase_margin_deg,
        crossover=seen.crossover,
        delay_margin=min((radians(pm) % tau / w for w, pm in seen.gain_crossings), default=inf),
        modulus_margin=seen.modulus_margin,
        ms_frequency=seen.ms_frequency,
        mt=1 / complementary if complementary else inf,
        mt_frequency=mt_frequency,
        disk_margin=2 * disk,
        disk_frequency=disk_frequency,
        bandwidth=_bandwidth(path),
        gain_crossings=seen.gain_crossings,
        phase_crossings=seen.phase_crossings,
        band=path.table.band,
        beyond=outside,
        warnings=warnings(path, seen, verdict, outside, spreads),
        interpolation=spreads["interpolation"],
        noise=spreads["noise"],
        neglected=spreads["neglected"],
        dt=path.table.dt,
    )


def _spreads(path: Path, coarse: Sequence[Path], seen: Seen) -> dict[str, Spread | None]:
    """Return how far the figures may be off, by cause; None where a cause is not known."""
    table = path.table
    return {
        "interpolation": _left_out(coarse, seen),
        "noise": None if table.uncertainty is None else spread(path, seen, table.spread_at),
        "neglected": None if table.neglected is None else spread(path, seen, table.neglected_at),
    }


def _gain_crossings(path: Path) -> tuple[tuple[float, float], ...]:
    """Return (frequency, phase margin in deg) wherever |L| passes through 1."""

    def excess(w: float) -> float:
        return abs(path.at(w)) - 1

    found = sign_changes(excess, path.w, np.sign(np.abs(path.gain) - 1))
    return tuple((w, margin_deg(path.at(w))) for w in found)


def _phase_crossings(path: Path) -> tuple[tuple[float, float], ...]:
    """Return (frequency, factor that closes onto -1) wherever L is negative real.

    At Nyquist's frequency a loop is real: what its point shows beside the axis is noise.
    """

    def side(w: float) -> float:
        gain = path.at(w)
        return gain.imag / abs(gain)

    signs, last = np.sign(path.gain.imag), None
    if path.table.reaches_nyquist:
        signs[-1] = 0
        last = float(path.gain[-1].real)
    crossings = [(w, path.at(w).real) for w in sign_changes(side, path.w, signs)]
    if last is not None:
        crossings.append((path.table.band[1], last))
    return tuple((w, -1 / real) for w, real in crossings if real < 0)


def _bandwidth(path: Path) -> float | None:
    """Return where |T| is first 3 dB below what it is at w = 0.

    That is 1 where the loop integrates, by the table's low end or its controller; elsewhere what
    |T| is at the table's first point stands for it. None where it is never there, or was below it
    already where the table begins.
    """
    level = DROP**0.5
    if not _integrates(path):
        level *= abs(path.gain[0] / (1 + path.gain[0]))

    def above(w: float) -> float:
        gain = path.at(w)
        return float(abs(gain) - level * abs(1 + gain))

    signs = np.sign(np.abs(path.gain) - level * np.abs(1 + path.gain))
    if signs[0] < 0:  # what is met later is a resonance on its way up
        return None
    return next(iter(sign_changes(above, path.w, signs)), None)


def _integrates(path: Path) -> bool:
    """Return whether |L| is known to grow without end below the table."""
    return path.low is not None and path.low.integrators + boundary_poles(path.controller)[0] > 0


def _least(value: Callable[[complex], float], path: Path) -> tuple[float, float]:
    """Return (w, minimum) over the band: every low valley is closed in on by golden sections."""
    y = np.array([value(g) for g in path.gain.tolist()])
    padded = np.concatenate([[inf], y, [inf]])
    valleys = np.flatnonzero((y <= padded[:-2]) & (y <= padded[2:]))
    valleys = valleys[np.argsort(y[valleys], kind="stable")][:_VALLEYS]
    best = float(path.w[valleys[0]]), float(y[valleys[0]])
    for i in valleys.tolist():
        ends = path.w[max(i - 1, 0)], path.w[min(i + 1, len(y) - 1)]
        found = valley(lambda w: value(path.at(w)), float(ends[0]), float(ends[1]))
        best = min(best, found, key=lambda pair: pair[1])
    return best


def _left_out(coarse: Sequence[Path], seen: Seen) -> Spread | None:
    """Return by how much the figures move without every second point, the larger of two moves."""
    if not coarse:
        return None
    others = [Seen.of(path) for path in coarse]
    return Spread(
        phase_margin_deg=_moved(
            seen.crossover, seen.phase_margin_deg, [c.gain_crossings for c in others], float
        ),
        gain_margin_db=_moved(
            seen.phase_crossover, _db(seen.gain_margin), [c.phase_crossings for c in others], _db
        ),
        ms=max(abs(_inverse(c.modulus_margin) - _inverse(seen.modulus_margin)) for c in others),
    )


def _inverse(modulus_margin: float) -> float:
    return 1 / modulus_margin if modulus_margin else inf


def _moved(
    at: float | None,
    value: float,
    others: list[tuple[tuple[float, float], ...]],
    unit: Callable[[float], float],
) -> float | None:
    """Return how far the crossing nearest to ``at`` has moved, inf where there is none."""
    if at is None:
        return None
    moves = []
    for found in others:
        near = min(found, key=lambda c: abs(log(c[0] / at)), default=None)
        moves.append(inf if near is None else abs(unit(near[1]) - value))
    return max(moves)


def _db(factor: float) -> float:
    return 20 * float(np.log10(factor))
