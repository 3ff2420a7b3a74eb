"""The columns that come out of a batch: one list, for every arithmetic and every file."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """One column of results.

    name       as in ``zoh.Margins`` and ``zoh.StepInfo``; "between." before what is so at all times
    unit       SI, unless the name says another; "1" for a ratio
    long_name  for axes and files
    better     1 where more is better, -1 where less is, 0 where neither is
    """

    name: str
    unit: str
    long_name: str
    better: int = 0


FIGURES: tuple[Figure, ...] = (
    Figure(name="gain_margin", unit="1", long_name="gain margin, a factor"),
    Figure(name="phase_crossover", unit="rad/s", long_name="frequency of the gain margin"),
    Figure(name="phase_margin_deg", unit="deg", long_name="phase margin", better=1),
    Figure(name="crossover", unit="rad/s", long_name="crossover frequency", better=1),
    Figure(name="delay_margin", unit="s", long_name="delay margin", better=1),
    Figure(name="modulus_margin", unit="1", long_name="modulus margin, min |1 + L|", better=1),
    Figure(name="ms", unit="1", long_name="peak of the sensitivity, Ms", better=-1),
    Figure(name="mt", unit="1", long_name="peak of the closed loop, Mt", better=-1),
    Figure(name="disk_margin", unit="1", long_name="disk margin, balanced", better=1),
    Figure(name="bandwidth", unit="rad/s", long_name="bandwidth, 3 dB", better=1),
    Figure(name="overshoot_pct", unit="%", long_name="overshoot at the samples", better=-1),
    Figure(name="rise_time", unit="s", long_name="rise time, 10 to 90 %", better=-1),
    Figure(name="settling_time", unit="s", long_name="settling time, 2 %", better=-1),
    Figure(name="peak", unit="reference", long_name="size of the peak at the samples"),
    Figure(name="peak_time", unit="s", long_name="time of the peak at the samples"),
    Figure(name="steady_state_error", unit="reference", long_name="error at rest"),
    Figure(name="peak_effort", unit="input", long_name="largest |u| of the step", better=-1),
    Figure(name="between.overshoot_pct", unit="%", long_name="overshoot at all times", better=-1),
    Figure(name="between.peak_time", unit="s", long_name="time of the peak at all times"),
)
"""What is measured of every stable loop, in this order."""

BY_NAME: Mapping[str, Figure] = {figure.name: figure for figure in FIGURES}

_CORNERS = ("dc_gain", "w0", "wp")
_GAINS: Mapping[str, tuple[str, ...]] = {
    "p": ("kp",),
    "pi": ("kp", "ki"),
    "pd": ("kp", "kd", "filter_pole"),
    "pid": ("kp", "ki", "kd", "filter_pole"),
    "lag": _CORNERS,
    "textbook_lag": _CORNERS,
    "lead": _CORNERS,
    "leadlag": ("dc_gain", "lag_zero", "lag_pole", "lead_zero", "lead_pole"),
}


def gain_names(law: str) -> tuple[str, ...]:
    """Return the columns of a law's gains, "gains." before each; none for a given controller.

    >>> gain_names("pi"), gain_names("given")
    (('gains.kp', 'gains.ki'), ())
    """
    return tuple(f"gains.{name}" for name in _GAINS.get(law, ()))


def column_names(law: str) -> tuple[str, ...]:
    """Return every column that a batch of this law has: gains, figures, "stable" and "reason"."""
    return (*gain_names(law), *BY_NAME, "stable", "reason")
