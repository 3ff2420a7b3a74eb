"""Table I three ways: as printed, with the sensor counted twice, and of the loop as designed.

Samples at kT only, a unit step of the reference, 10 to 90 % rise, 2 % band.
"""

from collections.abc import Mapping

from zoh.analysis.verify import Measured
from zoh.app.paper.printed import LAWS, METRICS, value
from zoh.app.paper.study import Study

Table = dict[str, dict[str, float | None]]

# How near a recomputed entry must come to count as the printed one: a rise time by one sample,
# a settling time by six of them along a slow tail, an overshoot by the 0.5 % that the PID's
# stays unexplained. The two readings of the loop are twelve percent of overshoot, or a factor
# of two in time, apart, so no tolerance of this size can confuse them.
NEAR = {"overshoot_pct": 0.6, "rise_s": 0.1, "settling_s": 0.6}


def three_ways(found: Study) -> dict[str, Table]:
    """Return the table in the words of ``zoh paper --json``."""
    printed: Table = {
        law: {metric: value(f"table_1.{law}.{metric}") for metric in METRICS} for law in LAWS
    }
    return {
        "printed": printed,
        "sensor_counted_twice": read_off(found.twice),
        "loop_as_designed": read_off(found.as_printed),
    }


def read_off(loops: Mapping[str, Measured]) -> Table:
    """Return overshoot, rise and settling time of each law's step response at the samples."""
    table: Table = {}
    for law in LAWS:
        step = loops[law].step
        read = (step.overshoot_pct, step.rise_time, step.settling_time) if step else (None,) * 3
        table[law] = dict(zip(METRICS, read, strict=True))
    return table


def near(metric: str, one: float | None, other: float | None) -> bool:
    """Return whether two entries are the same within what the paper's could be read off.

    >>> near("rise_s", 17.9, 17.8), near("rise_s", 17.9, 0.5)
    (True, False)
    """
    if one is None or other is None:
        return False
    return abs(one - other) <= NEAR[metric] + 1e-9  # 17.9 - 17.8 is not 0.1 in binary
