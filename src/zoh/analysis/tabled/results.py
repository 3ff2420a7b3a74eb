"""What was read off a table: margins, and how far they hold."""

from dataclasses import dataclass
from typing import Any

from zoh.analysis.results import Margins, jsonable


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """How far three figures may be off, each in its own unit.

    None where the figure itself does not exist, inf where nothing can be said of it.
    """

    phase_margin_deg: float | None
    gain_margin_db: float | None
    ms: float | None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        return {
            "phase_margin_deg": jsonable(self.phase_margin_deg),
            "gain_margin_db": jsonable(self.gain_margin_db),
            "ms": jsonable(self.ms),
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Beyond:
    """Bounds on what the loop does outside its table, if what is taken for granted holds.

    gain_margin       no phase crossing outside has a factor nearer to 1 (in log) than this
    phase_margin_deg  no gain crossing outside has a margin of smaller size; inf without any
    ms, mt            neither peak is larger than this outside; inf where nothing is known
    """

    gain_margin: float
    phase_margin_deg: float
    ms: float
    mt: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TableMargins(Margins):
    """The margins of a loop in its table's band; what they rest on is in ``warnings``.

    stable           None where the table does not decide; a warning says why
    gain_margin      of the phase crossings in the table; where there is none, the bound that
                     ``beyond`` gives, with phase_crossover None
    modulus_margin, mt, disk_margin   in the band
    bandwidth        where |T| is 3 dB below 1, which it is at w = 0, if the loop integrates by
                     the table's low end; if not, 3 dB below its value at the first point
    certificate      None: a table proves nothing between its points
    band             rad/s, the table's first and last point
    beyond           bounds outside the band
    interpolation    by how much the figures move when every second point is left out, the
                     larger move of two; None where the table is too short
    noise            1 sigma of the figures from that of the points; None where it is not known
    neglected        bounds from what the table's values leave out; None where nothing is known
    """

    band: tuple[float, float]
    beyond: Beyond
    interpolation: Spread | None
    noise: Spread | None
    neglected: Spread | None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        spreads = {"interpolation": self.interpolation, "noise": self.noise}
        spreads["neglected"] = self.neglected
        return {
            **Margins.to_dict(self),
            "band": list(self.band),
            "beyond": {
                "gain_margin": jsonable(self.beyond.gain_margin),
                "phase_margin_deg": jsonable(self.beyond.phase_margin_deg),
                "ms": jsonable(self.beyond.ms),
                "mt": jsonable(self.beyond.mt),
            },
            **{name: None if s is None else s.to_dict() for name, s in spreads.items()},
        }
