"""``zoh explain`` without its terminal: where each margin comes from, what it costs otherwise."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import zoh
from zoh.analysis.budget import Budget, budget
from zoh.analysis.verify import Measured
from zoh.app.commands import Entry, design_all, requirements_of, warnings
from zoh.app.instead import instead
from zoh.app.project import Given, Project, Request
from zoh.choice.map import MAPPED, Map, law_map
from zoh.clock import SampleTimes, sample_times
from zoh.design.sections import SecondOrder
from zoh.emulation import Emulated, emulate
from zoh.lti.systems import Plant
from zoh.lti.weights import WEIGHTS
from zoh.report.text import number
from zoh.request import LAWS, SPARE, Progress, is_closed

_SIX_DIGITS = 1e-7  # to which the longest sample time is found, for six are printed


@dataclass(frozen=True, slots=True, kw_only=True)
class Explained:
    """One controller: where its degrees went, what emulation would cost, why it is as it is.

    budget    None where there is no loop, or none that crosses a gain of 1
    prices    empty for a controller that was given, and for a plant that is a table
    clocks    what other sample times cost; None where there are no prices
    reasons   one sentence each
    """

    entry: Entry
    budget: Budget | None
    prices: tuple[Emulated, ...]
    clocks: SampleTimes | None
    reasons: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form, one entry of ``designs``."""
        return {
            "name": self.entry.name,
            "law": self.entry.law,
            "met": self.entry.failure is None,
            "budget": None if self.budget is None else self.budget.to_dict(),
            "prices": [row.to_dict() for row in self.prices],
            "sample_times": None if self.clocks is None else self.clocks.to_dict(),
            "reasons": list(self.reasons),
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Priceable:
    """A plant and a law with all its parameters."""

    plant: Plant
    law: str
    parameters: Mapping[str, float]


def explain_all(project: Project, progress: Progress | None = None) -> tuple[Explained, ...]:
    """Return every controller of the file, explained; ``progress`` as for ``design_all``."""
    entries = design_all(project, progress)
    return tuple(
        _explained(project, *pair, progress)
        for pair in zip(project.controllers, entries, strict=True)
    )


def _explained(
    project: Project, asked: Request | Given, entry: Entry, progress: Progress | None
) -> Explained:
    found = _budget(project, entry)
    other = instead(project, asked, entry, progress) if isinstance(asked, Request) else None
    model = _priceable(project, asked, entry)
    return Explained(
        entry=entry,
        budget=found,
        prices=() if model is None else _prices(project, model, asked),
        clocks=None if model is None else _clocks(project, model, asked, entry),
        reasons=(*_reasons(project, entry, found), *([other] if other else ())),
    )


def _priceable(project: Project, asked: Request | Given, entry: Entry) -> Priceable | None:
    """Return what can be made in s and at another clock: a model, and a law with all it needs.

    What was left open is what was chosen; but a P has the margin that the plant leaves it at wc,
    and one that was not asked for is not asked for elsewhere.
    """
    if not isinstance(project.plant, Plant) or not isinstance(asked, Request):
        return None
    law, found = asked.law, entry.measured
    known = dict(asked.parameters)
    if isinstance(found, Measured) and found.choice is not None:
        law, m = found.law, found.margins
        chosen = {"wc": m.crossover or 0.0, "pm_deg": m.phase_margin_deg, **found.gains}
        takes = (n for n in LAWS[law] if n != "ki" or not any(k in known for k in SPARE))
        known |= {n: chosen[n] for n in takes if n not in known}
    if law == "p" and "pm_deg" not in asked.parameters:
        known.pop("pm_deg", None)
    closed = is_closed(law, known)
    return Priceable(plant=project.plant, law=law, parameters=known) if closed else None


def _budget(project: Project, entry: Entry) -> Budget | None:
    if entry.measured is None or entry.measured.margins.crossover is None:
        return None
    law = entry.measured.controller
    return budget(project.plant, law, compute_delay=project.compute_delay)


def _prices(project: Project, of: Priceable, asked: Request | Given) -> tuple[Emulated, ...]:
    """Return what emulation would cost; nothing for a P without a margin, a gain in s as in z."""
    if "pm_deg" not in of.parameters:
        return ()
    return emulate(
        of.plant, of.law, of.parameters, dt=project.dt, compute_delay=project.compute_delay,
        sections=_sections(asked), allow=_allow(asked),
    )  # fmt: skip


def _clocks(project: Project, of: Priceable, asked: Request | Given, entry: Entry) -> SampleTimes:
    """Return what clocks from eight times as fast to 64 times as slow, as wc allows, would cost.

    What a choice assumed, where nothing was asked, is asked of every clock.
    """
    slowest, found = pi / of.parameters["wc"], entry.measured
    assumed = isinstance(found, Measured) and found.choice is not None
    return sample_times(
        of.plant, of.law, of.parameters,
        requirements=found.requirements if found and assumed else project.requirements,
        compute_delay=project.compute_delay, sections=_sections(asked), allow=_allow(asked),
        reference=project.reference,
        dts=[project.dt * 2.0**k for k in range(-3, 7) if project.dt * 2.0**k < slowest],
        fine=_SIX_DIGITS,
    )  # fmt: skip


def _sections(asked: Request | Given) -> tuple[SecondOrder, ...]:
    return asked.sections if isinstance(asked, Request) else ()


def _allow(asked: Request | Given) -> tuple[str, ...]:
    return asked.allow if isinstance(asked, Request) else ()


def _reasons(project: Project, entry: Entry, found: Budget | None) -> list[str]:
    """Return what is refused or missed; else what took the most, and how near the limits are."""
    if entry.measured is None:
        return [entry.failure or ""]
    said = [f"missed: {miss}" for miss in entry.measured.misses]
    if found is None:
        return [*said, "the gain of the loop is never 1: there is no phase margin to account for"]
    lost = sorted(found.items, key=lambda item: item.deg)[:2]
    if isinstance(entry.measured, Measured) and entry.measured.choice is not None:
        said += entry.measured.choice.sentences
    said.append("most is taken by " + " and ".join(f"{i.name} ({i.deg:+.4g} deg)" for i in lost))
    if not entry.measured.margins.stable:
        return said
    late = entry.measured.margins.delay_margin
    share = number(late / project.dt)
    said.append(f"the loop bears {number(late)} s more delay, {share} samples")
    return said


def maps(project: Project, explained: Sequence[Explained]) -> Iterator[tuple[Entry, Map]]:
    """Yield the map of every controller whose law has one, with what is known of the controller."""
    for asked, e in zip(project.controllers, explained, strict=True):
        law = e.entry.law if e.entry.measured is None else e.entry.measured.law
        if not isinstance(project.plant, Plant) or not isinstance(asked, Request):
            continue
        if law in MAPPED and not asked.sections:  # a map knows no sections
            known = (*LAWS[law][2:], "filter_pole", "ti_td", *WEIGHTS)
            shown = e.entry.measured if isinstance(e.entry.measured, Measured) else None
            required = requirements_of(project, asked) if shown is None else shown.requirements
            yield e.entry, law_map(
                project.plant, law, dt=project.dt, compute_delay=project.compute_delay,
                requirements=required, reference=project.reference, allow=asked.allow,
                given={k: v for k, v in asked.parameters.items() if k in known},
            )  # fmt: skip


def to_dict(project: Project, explained: Sequence[Explained]) -> Mapping[str, Any]:
    """Return the JSON object of ``zoh explain --json``."""
    return {
        "zoh": zoh.__version__,
        "dt": project.dt,
        "compute_delay": project.compute_delay,
        "designs": [e.to_dict() for e in explained],
        "warnings": list(warnings(project, [e.entry for e in explained])),
    }
