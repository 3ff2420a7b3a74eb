"""What was asked against what a table shows.

``TableMeasured`` is evidence about one loop of a controller and a tabled plant; ``TableVerified``
is evidence that the table decides stability and that all that was asked is met, and cannot be
built from anything less. It is a type of its own: a table shows margins and no responses, and
what they rest on outside it is in ``margins.warnings``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import log
from typing import Any

from zoh import checks
from zoh.analysis.asked import OF_TIME, missed
from zoh.analysis.record import Record, crosses, labels
from zoh.analysis.results import StepInfo
from zoh.analysis.tabled.count import count
from zoh.analysis.tabled.margins import table_margins
from zoh.analysis.tabled.path import Path
from zoh.analysis.tabled.results import TableMargins
from zoh.analysis.verify import Measured
from zoh.errors import NotMet, SpecError
from zoh.lti.forms import ringing_poles
from zoh.lti.frequency_response import FrequencyResponse, TabledLoop
from zoh.lti.systems import Sampled, sample_time
from zoh.sampling.hold import sample
from zoh.spec import Requirements


@dataclass(frozen=True, slots=True, kw_only=True)
class TableMeasured(Record):
    """One loop of a controller and a tabled plant, and what was measured of it.

    plant  as given; sampled is its table behind its hold. The compute delay is one that the
    table does not have in it
    """

    plant: FrequencyResponse
    sampled: FrequencyResponse
    margins: TableMargins

    @property
    def loop(self) -> TabledLoop:
        """Return the open loop, controller times table."""
        return self.controller * self.sampled

    @property
    def step(self) -> StepInfo | None:
        """Return None: a table in a band shows no step response."""
        return None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form, one entry of ``designs``."""
        return {
            **self._labels(),
            "margins": self.margins.to_dict(),
            "step": None,
            "met": self.met,
            "misses": list(self.misses),
        }

    def report(self) -> str:
        """Return what was measured in a few lines."""
        m = self.margins
        lines = [
            *self._head(m, "NOT DECIDED by the table"),
            f"  delay margin {m.delay_margin:.4g} s, Ms {m.ms:.4g}, Mt {m.mt:.4g} in the table",
        ]
        notes = (*ringing_poles(self.controller, self.gains), *m.warnings)
        lines += [f"  note: {sentence}" for sentence in notes]
        lines += [f"  MISSED: {miss}" for miss in self.misses]
        return "\n".join(lines)


@dataclass(frozen=True, slots=True, kw_only=True)
class TableVerified(TableMeasured):
    """A loop that its table shows to be stable and to meet every requirement."""

    def __post_init__(self) -> None:
        found = table_missed(self.requirements, self.margins)
        if not self._evidence_holds():
            found.append("the evidence is not this loop's")
        if found or self.misses:
            raise NotMet(tuple(found) or self.misses, self)

    def _evidence_holds(self) -> bool:
        """Return whether the loop, put together anew, is stable and crosses where it is said to."""
        loop = self.controller * in_clock(self.plant, self.controller.dt, self.compute_delay)
        if count(Path.of(loop)).unstable != 0:
            return False
        return crosses(loop.at, self.margins.gain_crossings)


Evidence = Measured | TableMeasured  # of a loop with a model, or with a table


def measure_table(
    plant: FrequencyResponse, controller: Sampled, *, compute_delay: float = 0.0,
    requirements: Requirements | None = None, law: str = "given",
    gains: Mapping[str, float] | None = None, name: str | None = None,
) -> TableMeasured:  # fmt: skip
    """Return everything that a plant's table shows of it under a controller in unity feedback.

    A continuous table is put behind a hold with the controller's dt and the compute delay; a
    sampled one has both in it. Raises SpecError for a wrong type or two clocks.
    """
    if not isinstance(plant, FrequencyResponse):
        raise SpecError("plant", "must be a zoh.FrequencyResponse", plant, "zoh.measure has models")
    if not isinstance(controller, Sampled):
        raise SpecError("controller", "must be a zoh.Sampled", controller, "give num, den and dt")
    asked = Requirements() if requirements is None else requirements
    if not isinstance(asked, Requirements):
        raise SpecError("requirements", "must be zoh.Requirements", asked, "Requirements(ms=1.8)")
    called = labels(law, gains, name)
    sampled = in_clock(plant, controller.dt, compute_delay)
    margins = table_margins(controller * sampled)
    return TableMeasured(
        **called,
        plant=plant,
        sampled=sampled,
        controller=controller,
        compute_delay=float(compute_delay),
        requirements=asked,
        margins=margins,
        misses=tuple(table_missed(asked, margins)),
    )


def verify_table(
    plant: FrequencyResponse, controller: Sampled, *, compute_delay: float = 0.0,
    requirements: Requirements | None = None, law: str = "given",
    gains: Mapping[str, float] | None = None, name: str | None = None,
) -> TableVerified:  # fmt: skip
    """Return the loop as ``TableVerified``; raise NotMet, with the evidence, where it is not.

    >>> table = FrequencyResponse(w=[0.5, 1, 2], magnitude=[2, 1, 0.5], phase_deg=[-90] * 3, dt=0.1)
    >>> verify_table(table, Sampled(num=[1.0], den=[1.0], dt=0.1)).margins.crossover
    1.0
    >>> verify_table(table, Sampled(num=[9.0], den=[1.0], dt=0.1))
    Traceback (most recent call last):
    zoh.errors.NotMet: not met: the table does not decide stability: |L| may be as large as 4.5 ...
    """
    evidence = measure_table(
        plant, controller, compute_delay=compute_delay, requirements=requirements, law=law,
        gains=gains, name=name,
    )  # fmt: skip
    return table_verified(evidence)


def table_verified(evidence: TableMeasured) -> TableVerified:
    """Return the evidence as ``TableVerified``, or raise NotMet that carries it."""
    if evidence.misses:
        raise NotMet(evidence.misses, evidence)
    return TableVerified(**{f.name: getattr(evidence, f.name) for f in fields(TableMeasured)})


def in_clock(plant: FrequencyResponse, dt: float, compute_delay: float) -> FrequencyResponse:
    """Return the plant's table as the controller sees it, once every dt seconds."""
    checks.not_negative("compute_delay", compute_delay, "give seconds, 0 or more")
    if plant.dt is None:
        return sample(plant, dt, compute_delay)
    if sample_time(dt) != plant.dt:
        raise SpecError("dt", f"must be the table's {plant.dt!r} s", dt, "it was measured so")
    if compute_delay != 0:
        way_out = "leave it out"
        raise SpecError(
            "compute_delay", "must be 0: a sampled table has its delay", compute_delay, way_out
        )
    return plant


def table_missed(asked: Requirements, margins: TableMargins) -> list[str]:
    """Return a sentence for each requirement that the table does not show to be met."""
    if margins.stable is None:
        return [margins.warnings[0]]
    found = missed(asked, margins, None)
    if not margins.stable:
        return found
    found += [
        f"{name} is asked, and a table of margins does not show it"
        for name in OF_TIME
        if getattr(asked, name) is not None
    ]
    return found or _missed_beyond(asked, margins)


def _missed_beyond(asked: Requirements, margins: TableMargins) -> list[str]:
    """Return what is met in the band and may be missed outside it, by the bounds there are."""
    beyond = margins.beyond
    decibels = 20 * abs(log(beyond.gain_margin)) / log(10)
    rows = (
        ("gain_margin_db", asked.gain_margin_db, decibels, True),
        ("pm_deg", asked.pm_deg, beyond.phase_margin_deg, True),
        ("ms", asked.ms, beyond.ms, False),
        ("mt", asked.mt, beyond.mt, False),
    )
    return [
        f"{name} must be at {'least' if at_least else 'most'} {bound:g}, which the table meets; "
        f"outside its band no more than {value:.4g} is known"
        for name, bound, value, at_least in rows
        if bound is not None and (value < bound if at_least else value > bound)
    ]
