"""Systems in series: of one kind and one clock, multiplied in whole numbers, exactly."""

from operator import is_

from zoh.errors import SpecError
from zoh.lti import whole
from zoh.lti.systems import Plant, Sampled
from zoh.lti.whole import Whole

System = Plant | Sampled


class These:
    """Systems as a key: these very objects. Two that are equal in z may not be so in w."""

    __slots__ = ("systems",)

    def __init__(self, systems: tuple[System, ...]) -> None:
        self.systems = systems

    def __hash__(self) -> int:
        return hash(tuple(map(id, self.systems)))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, These)
            and len(self.systems) == len(other.systems)
            and all(map(is_, self.systems, other.systems))
        )


def product(systems: tuple[System, ...]) -> tuple[Whole, Whole, int, float]:
    """Return the product of systems, 1 of none: (num, den, unit, delay) as of each in ``wholes``.

    num and den have one length.
    """
    num: Whole
    den: Whole
    num, den, unit, dead_time = wholes(systems[0]) if systems else ((1,), (1,), 1, 0.0)
    for system in systems[1:]:
        top, bottom, its_unit, wait = wholes(system)
        num, den = whole.times(num, top), whole.times(den, bottom)
        unit, dead_time = unit * its_unit, dead_time + wait
    return [0] * (len(den) - len(num)) + list(num), den, unit, dead_time


def clock(systems: tuple[System, ...]) -> float | None:
    """Return the sample time that all have, None of continuous ones; refuse a mixture."""
    times: list[float | None] = []
    for system in systems:
        if not isinstance(system, (Plant, Sampled)):
            raise SpecError("loop", "must be a zoh.Plant or zoh.Sampled", system, "make one first")
        times.append(system.dt if isinstance(system, Sampled) else None)
        if times[-1] != times[0]:
            raise SpecError(
                "dt",
                f"must be the same throughout a loop ({times[0]!r} first)",
                times[-1],
                "zoh.sample the plant with the controller's dt",
            )
    return times[0] if times else None


def wholes(system: System) -> tuple[Whole, Whole, int, float]:
    """Return (num, den, unit, delay): whole numbers that are the coefficients times unit."""
    if isinstance(system, Sampled):
        return *system.whole_w, system.delay * system.dt
    (num, den, sensor, one), unit = whole.of(system.num, system.den, (system.sensor,), (1.0,))
    num, den = whole.times(num, sensor), whole.times(den, one)
    return num, den, unit * unit, system.dead_time


def out_of_range(coefficients: object) -> SpecError:
    """Return the error of a loop whose gains leave the range of a float."""
    return SpecError(
        "loop",
        "must have gains that a 64-bit float can hold",
        coefficients,
        "use other units for the signals or for time",
    )
