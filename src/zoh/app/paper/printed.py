"""Every number the paper prints, as its text, with its place.

D. Chowdhury and M. Sarkar, Digital Controllers in Discrete and Continuous Time Domains for a
Robot Arm Manipulator. The text and not the float, because its last digit is what a
recomputed value has to agree with.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from types import MappingProxyType

LAWS = ("lag", "lead", "pi", "pid")
METRICS = ("overshoot_pct", "rise_s", "settling_s")


@dataclass(frozen=True, slots=True, kw_only=True)
class Printed:
    """One printed number.

    id     section.key, or section.key.i for the i-th of a list
    text   as it stands on the page
    place  section, equation or table of the paper

    >>> number = Printed(id="lag.w0", text="0.3290", place="sec. III")
    >>> number.value, number.half_unit
    (0.329, 5e-05)
    """

    id: str
    text: str
    place: str

    @property
    def value(self) -> float:
        """The number."""
        return float(self.text)

    @property
    def half_unit(self) -> float:
        """Half a unit of the last printed digit."""
        last = Decimal(self.text).as_tuple().exponent
        return float(Decimal((0, (5,), int(last) - 1)))


_PAGE = {
    "plant": (
        ("sampling_time_s", "0.1", "sec. II"),
        ("potentiometer_V_per_deg", "0.0667", "sec. II"),
        ("Gc_numerator", "0.1533", "sec. II"),
        ("Gc_denominator", "1 0.7809 0", "sec. II"),
        ("Gd_numerator", "0.0007471 0.0007279", "eq. (2)"),
        ("Gd_denominator", "1 -1.925 0.9249", "eq. (2)"),
        ("uncompensated_phase_margin_deg", "75.7", "sec. III, as 75.7 - 40"),
    ),
    "lag": (
        ("dc_gain", "10", "sec. III"),
        ("wc_rad_s", "3.29", "sec. III"),
        ("w0", "0.3290", "sec. III"),
        ("wp", "2.3979", "sec. III"),
        ("D_num", "66.15 -64.01", "sec. III"),
        ("D_den", "1 -0.7859", "sec. III"),
        ("phase_margin_deg", "40", "sec. III, fig. 5"),
        ("crossover_rad_s", "3.29", "sec. III, fig. 5"),
        ("gain_margin_dB", "14.3", "sec. III, fig. 5"),
    ),
    "lead": (
        ("dc_gain", "10", "sec. IV"),
        ("wc_rad_s", "2.5", "sec. IV"),
        ("theta_r_deg", "389.8149", "sec. IV, eq. (5)"),
        ("cos_theta_r", "0.9671", "sec. IV"),
        ("a1", "27.4649", "sec. IV, eq. (6)"),
        ("b1", "0.5101", "sec. IV, eq. (6)"),
        ("w0", "0.3641", "sec. IV"),
        ("wp", "1.9603", "sec. IV"),
        ("D_gain", "49.927", "sec. IV"),
        ("D_zero", "0.9642", "sec. IV"),
        ("D_pole", "0.8251", "sec. IV"),
        ("phase_margin_deg", "40", "sec. IV, fig. 7"),
        ("crossover_rad_s", "2.5", "sec. IV, fig. 7"),
        ("gain_margin_dB", "15.3", "sec. IV, fig. 7"),
    ),
    "pi": (
        ("wc_rad_s", "0.8", "sec. V"),
        ("theta_r_deg", "357.9840", "sec. V, eq. (10)"),
        ("KP", "5.8307", "sec. V, eq. (11)"),
        ("KI", "0.1642", "sec. V, eq. (11)"),
        ("D_num", "5.839 -5.823", "eq. (12)"),
        ("D_den", "1 -1", "eq. (12)"),
        ("phase_margin_deg", "40", "sec. V, fig. 9"),
        ("crossover_rad_s", "0.8", "sec. V, fig. 9"),
        ("gain_margin_dB", "24.6", "sec. V, fig. 9"),
    ),
    "pid": (
        ("wc_rad_s", "1.95", "sec. VI"),
        ("KI", "0.85", "sec. VI"),
        ("theta_r_deg", "383.7620", "sec. VI"),
        ("KP", "23.3942", "sec. VI, eq. (19)"),
        ("KD", "5.8069", "sec. VI, eq. (20)"),
        ("D_num", "81.51 -139.5 58.07", "eq. (21)"),
        ("D_den", "1 -1 0", "eq. (21)"),
        ("phase_margin_deg", "40", "sec. VI, fig. 11"),
        ("crossover_rad_s", "1.95", "sec. VI, fig. 11"),
        ("gain_margin_dB", "24.1", "sec. VI, fig. 11"),
    ),
}

_TABLE = {  # Table I, one row per characteristic, columns as in LAWS
    "overshoot_pct": "0 0 19.1 11.6",
    "rise_s": "18.4 17.9 15.5 4.6",
    "settling_s": "34.1 33 106 51.9",
}


def _typed_in() -> dict[str, Printed]:
    numbers = []
    for section, entries in _PAGE.items():
        for key, text, place in entries:
            parts = text.split()
            for i, part in enumerate(parts):
                name = f"{section}.{key}" + (f".{i}" if len(parts) > 1 else "")
                numbers.append(Printed(id=name, text=part, place=place))
    for law, *column in zip(LAWS, *(row.split() for row in _TABLE.values()), strict=True):
        for metric, part in zip(METRICS, column, strict=True):
            numbers.append(Printed(id=f"table_1.{law}.{metric}", text=part, place="Table I"))
    numbers.append(Printed(id="table_1.steady_state_error", text="0", place="Table I, sec. VII"))
    return {number.id: number for number in numbers}


NUMBERS: Mapping[str, Printed] = MappingProxyType(_typed_in())

LAG_IS_CALLED = "phase-lag"  # sec. III, its title, and w0 = 0.3290 < wp = 2.3979
LAG_SEES_DEG = -135.0  # sec. III, the plant's phase at a lag's crossover: -180 + 5 + 40
MARGIN_ASKED_DEG = 40.0  # abstract and every section


def value(number_id: str) -> float:
    """Return a printed number.

    >>> value("lead.D_pole")
    0.8251
    """
    return NUMBERS[number_id].value


def values(number_id: str) -> tuple[float, ...]:
    """Return a printed list, such as the coefficients of a polynomial.

    >>> values("plant.Gd_denominator")
    (1.0, -1.925, 0.9249)
    """
    return tuple(n.value for key, n in NUMBERS.items() if key.startswith(number_id + "."))
