"""The [plant] of a project file whose plant is a table in a file beside it.

frequency_response = "plant.csv"   # columns Hz or rad/s, ratio or dB, deg; more are left out
response_of = "sampled"            # from u_k to y_k with hold, delay and sensor; "continuous"
columns = ["Hz", "dB", "deg"]      # only where the file's first line does not name them so
averages = 32                      # only with a column "coherence"
unstable_poles = 0                 # of the plant, if it has any
"""

from collections.abc import Callable, Sequence

import numpy as np

from zoh import checks
from zoh.app.toml import Section, within
from zoh.errors import SpecError
from zoh.lti.coherence import random_error
from zoh.lti.frequency_response import FrequencyResponse

KEYS = ("frequency_response", "response_of", "columns", "averages", "unstable_poles")
MOST_ROWS = 100_000

_FREQUENCY = {"rad/s": 1.0, "w": 1.0, "hz": 2 * np.pi, "f_hz": 2 * np.pi, "khz": 2e3 * np.pi}
_GAIN = {"ratio": False, "magnitude": False, "db": True, "magnitude_db": True}
_PHASE = ("deg", "phase_deg")
_TRUST = ("uncertainty", "coherence")
_KNOWN = (*_FREQUENCY, *_GAIN, *_PHASE, *_TRUST)


def read_table(
    section: Section, sensor: float, dt: float, compute_delay: float,
    attached: Callable[[str], str],
) -> FrequencyResponse:  # fmt: skip
    """Return the table that the section names; ``attached`` returns the text of a file.

    A sampled response has the sensor, the hold and the delays in it already: a second one said
    elsewhere is an error. A continuous one may leave the sensor out.
    """
    section.only([*KEYS, "input_unit", "output_unit", "dead_time"])
    if "dead_time" in section.data:
        bound = "must be left out: a measured response has it in it already"
        raise SpecError(f"{section.path}dead_time", bound, section.data["dead_time"], "delete it")
    name, kind = section.text("frequency_response"), section.text("response_of")
    if name is None:
        raise section.missing("frequency_response", "the name of a file beside this one")
    if kind not in ("sampled", "continuous"):
        way_out = '"sampled" from u_k to y_k with its hold, "continuous" without one'
        if kind is None:
            raise section.missing("response_of", way_out)
        raise SpecError(f"{section.path}response_of", "must be one of two", kind, way_out)
    if kind == "sampled":
        _refuse_twice(sensor, compute_delay)
    rows = _rows(attached(name), section)
    if "coherence" in rows and "averages" not in section.data:
        raise section.missing("averages", "how many independent averages the coherence is of")
    averages = _whole(section, "averages", 1)
    unstable_poles = _whole(section, "unstable_poles", 0)
    with within(f"{section.path}frequency_response: "):
        table = _table(rows, dt if kind == "sampled" else None, averages, unstable_poles)
    return table if kind == "sampled" else table.scaled(sensor)


def _refuse_twice(sensor: float, compute_delay: float) -> None:
    """Raise SpecError for what a sampled response has in it already."""
    rows = (("sensor.gain", sensor, 1.0), ("sampling.compute_delay", compute_delay, 0.0))
    for key, value, nothing in rows:
        if value != nothing:
            bound = "must be left out: a sampled response has it in it already"
            raise SpecError(key, bound, value, "or say response_of otherwise")


def _whole(section: Section, key: str, least: int) -> int:
    way_out = "give a whole number, or leave it out"
    return checks.whole(f"{section.path}{key}", section.data.get(key, least), least, way_out)


def _table(
    rows: dict[str, list[float]], dt: float | None, averages: int, unstable_poles: int
) -> FrequencyResponse:
    frequency = next(name for name in rows if name in _FREQUENCY)
    gain = next(name for name in rows if name in _GAIN)
    phase = next(name for name in rows if name in _PHASE)
    size = np.array(rows[gain])
    uncertainty = rows.get("uncertainty")
    if "coherence" in rows:
        uncertainty = random_error(rows["coherence"], averages).tolist()
    return FrequencyResponse(
        w=np.array(rows[frequency]) * _FREQUENCY[frequency],
        magnitude=10 ** (size / 20) if _GAIN[gain] else size,
        phase_deg=np.array(rows[phase]),
        dt=dt,
        uncertainty=None if uncertainty is None else np.array(uncertainty),
        unstable_poles=unstable_poles,
    )


def _rows(text: str, section: Section) -> dict[str, list[float]]:
    """Return the columns by name, in lower case."""
    lines = [
        (number, [cell.strip() for cell in line.replace(";", ",").replace("\t", ",").split(",")])
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    path = f"{section.path}frequency_response"
    if not 1 < len(lines) <= MOST_ROWS:
        bound = f"must have 2 to {MOST_ROWS} rows"
        raise SpecError(path, bound, len(lines), "export one sweep as CSV")
    names = _names(section, lines[0][1], path)
    if not _is_number(lines[0][1][0]):
        lines = lines[1:]
    columns: dict[str, list[float]] = {name: [] for name in names if name in _KNOWN}
    for number, cells in lines:
        for name, cell in zip(names, cells + [""] * (len(names) - len(cells)), strict=False):
            if name in columns:
                if not _is_number(cell):
                    where = f"{path}, line {number}"
                    raise SpecError(where, f"must have a number for {name}", cell, "mend the row")
                columns[name].append(float(cell))
    return columns


def _names(section: Section, first: Sequence[str], path: str) -> list[str]:
    """Return what each column is, as the section says or else the first line."""
    said = section.data.get("columns")
    if said is not None and (
        not isinstance(said, list) or not all(isinstance(x, str) for x in said)
    ):
        raise SpecError(f"{section.path}columns", "must be names", said, '["Hz", "dB", "deg"]')
    names = [name.lower() for name in (first if said is None else said)]
    for what, known in (("frequency", _FREQUENCY), ("gain", _GAIN), ("phase", _PHASE)):
        if sum(name in known for name in names) != 1:
            raise SpecError(
                path if said is None else f"{section.path}columns",
                f"must name one {what} column ({', '.join(known)})",
                ", ".join(names),
                'say what the columns are, such as columns = ["Hz", "dB", "deg"]',
            )
    return names


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
