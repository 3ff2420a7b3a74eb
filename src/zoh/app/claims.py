"""What somebody says about a controller, against what is measured.

A number is taken at its printed digits: "14.3" claims 14.25 to 14.35, and no more.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from math import isfinite
from typing import Any

from zoh.analysis.results import StepInfo, jsonable
from zoh.analysis.tabled.verify import Evidence
from zoh.app.kinds import described, kinds
from zoh.app.toml import Literal
from zoh.lti.systems import Sampled

_MARGINS: dict[str, Callable[[Evidence], float | None]] = {
    "wc": lambda m: m.margins.crossover,
    "pm_deg": lambda m: m.margins.phase_margin_deg,
    "gain_margin_db": lambda m: m.margins.gain_margin_db,
    "phase_crossover": lambda m: m.margins.phase_crossover,
    "delay_margin": lambda m: m.margins.delay_margin,
    "modulus_margin": lambda m: m.margins.modulus_margin,
    "ms": lambda m: m.margins.ms,
    "mt": lambda m: m.margins.mt,
}
_STEP: dict[str, Callable[[StepInfo], float | None]] = {
    "overshoot_pct": lambda s: s.overshoot_pct,
    "rise_time": lambda s: s.rise_time,
    "settling_time": lambda s: s.settling_time,
    "peak_time": lambda s: s.peak_time,
    "steady_state_error": lambda s: s.steady_state_error,
    "peak_effort": lambda s: s.peak_effort,
}
CLAIMS = (*_MARGINS, *_STEP)
UNITS = {
    "wc": "rad/s",
    "pm_deg": "deg",
    "gain_margin_db": "dB",
    "phase_crossover": "rad/s",
    "delay_margin": "s",
    "overshoot_pct": "%",
    "rise_time": "s",
    "settling_time": "s",
    "peak_time": "s",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A key of ``CLAIMS`` with a number as written, or "kind" with one of ``KINDS``."""

    key: str
    value: Literal | str


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """A claim beside its measurement.

    holds     the measurement rounds to what was claimed, or is of the claimed kind
    claimed   as it was written
    measured  None where there is no such thing, such as a settling time of an unstable loop
    off_by    measured minus claimed; None where that has no meaning
    sentence  for people
    """

    key: str
    holds: bool
    claimed: str
    measured: float | str | None
    off_by: float | None
    sentence: str

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form; a number that was claimed comes as it was written."""
        number = isinstance(self.measured, float)
        return {
            "key": self.key,
            "holds": self.holds,
            "claimed": self.claimed,
            "measured": jsonable(float(self.measured or 0.0)) if number else self.measured,
            "off_by": self.off_by,
            "sentence": self.sentence,
        }


def check(claims: Sequence[Claim], measured: Evidence) -> tuple[Finding, ...]:
    """Return every claim beside its measurement, in the order of the claims."""
    wc = next((float(c.value) for c in claims if c.key == "wc"), measured.margins.crossover)
    return tuple(
        _number(c.key, c.value, measured)
        if isinstance(c.value, Literal)
        else _kind(c.value, measured.controller, wc)
        for c in claims
    )


def _number(key: str, claimed: Literal, measured: Evidence) -> Finding:
    value = _measurement(key, measured)
    unit = f" {UNITS[key]}" if key in UNITS else ""
    off_by = None
    holds = False
    if value is not None and isfinite(value):
        gap = Decimal(value) - Decimal(claimed.text)
        holds, off_by = abs(gap) <= claimed.half_a_digit, float(gap)
    found = "none exists" if value is None else f"{value:.6g}{unit}"
    by = "" if off_by is None or holds else f", off by {off_by:+.3g}{unit}"
    return Finding(
        key=key,
        holds=holds,
        claimed=claimed.text,
        measured=value,
        off_by=off_by,
        sentence=f"{key}: claimed {claimed.text}{unit}, measured {found}{by}",
    )


def _measurement(key: str, measured: Evidence) -> float | None:
    if key in _MARGINS:
        return _MARGINS[key](measured)
    return None if measured.step is None else _STEP[key](measured.step)


def _kind(claimed: str, controller: Sampled, wc: float | None) -> Finding:
    found = kinds(controller)
    kind = found[0] if found else "none of these"
    return Finding(
        key="kind",
        holds=claimed in found,
        claimed=claimed,
        measured=kind,
        off_by=None,
        sentence=f"kind: claimed {claimed}, measured {kind} ({described(controller, wc)})",
    )
