"""``zoh design`` and ``zoh check`` without their terminal: a project in, what came out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import zoh
from zoh.analysis.tabled.verify import Evidence, in_clock, measure_table
from zoh.analysis.verify import measure
from zoh.app.claims import Finding, check
from zoh.app.project import GIVEN, Given, Project, Request
from zoh.app.toml import within
from zoh.errors import Infeasible, NotMet, SpecError
from zoh.lti.forms import ringing_poles
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.hidden import unstable_hidden
from zoh.pipeline import design
from zoh.request import Progress, left_open
from zoh.sampling.hold import sample
from zoh.spec import Requirements


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One controller: measured, or refused by its law; with the claims made of it.

    Exactly one of ``measured`` and ``refusal`` is there.
    """

    name: str
    law: str
    measured: Evidence | None = None
    refusal: Infeasible | None = None
    findings: tuple[Finding, ...] = ()

    @property
    def failure(self) -> str | None:
        """Why this controller fails, in one line; None where it does not."""
        if self.refusal is not None:
            return str(self.refusal)
        wrong = [f.sentence for f in self.findings if not f.holds]
        misses = [] if self.measured is None else list(self.measured.misses)
        return "; ".join([*misses, *wrong]) or None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form, one entry of ``designs``."""
        if self.measured is not None:
            return self.measured.to_dict()
        refusal = self.refusal
        return {
            "name": self.name,
            "law": self.law,
            "feasible": False,
            "reason": None if refusal is None else refusal.reason,
            "gains": None,
            "controller": None,
            "margins": None,
            "step": None,
            "met": False,
            "misses": [],
            "needed_deg": None if refusal is None else refusal.needed_deg,
            "needed_gain": None if refusal is None else refusal.needed_gain,
            "gives_deg": None if refusal is None else refusal.gives_deg,
            "best_pm_deg": None if refusal is None else refusal.best_pm_deg,
            "nearest_wc": None if refusal is None else refusal.nearest_wc,
            "laws_that_can": [] if refusal is None else list(refusal.laws_that_can),
        }


def design_all(project: Project, progress: Progress | None = None) -> tuple[Entry, ...]:
    """Return every controller of the file: designed, refused, or measured where it is given.

    ``progress`` is called with a sentence now and then while something is searched.
    """
    return tuple(
        _designed(project, c, progress) if isinstance(c, Request) else _measured(project, c)
        for c in project.controllers
    )


def check_all(project: Project) -> tuple[Entry, ...]:
    """Return every given controller, measured, with its claims beside what is true."""
    given = [c for c in project.controllers if isinstance(c, Given)]
    if not given:
        laws = ", ".join(c.law for c in project.controllers if isinstance(c, Request))
        way_out = 'add law = "given" with num and den, or run zoh design'
        raise SpecError("controller", 'must have law = "given" to be checked', laws, way_out)
    return tuple(_measured(project, c, claimed=True) for c in given)


def _designed(project: Project, request: Request, progress: Progress | None) -> Entry:
    name, law = request.name, request.law
    try:
        with within(f'controller "{name}": '):
            made: Evidence = design(
                project.plant,
                law,
                request.parameters,
                sections=request.sections,
                allow=request.allow,
                progress=None if progress is None else lambda said: progress(f"{name}, {said}"),
                dt=project.dt,
                compute_delay=project.compute_delay,
                requirements=requirements_of(project, request),
                reference=project.reference,
                name=name,
            )
    except NotMet as e:
        return Entry(name=name, law=law, measured=e.measured)
    except Infeasible as e:
        return Entry(name=name, law=law, refusal=e)
    return Entry(name=name, law=law, measured=made)


def requirements_of(project: Project, request: Request) -> Requirements:
    """Return what is asked; of what is left open, to stay within the actuator's ends, too.

    The reference of the file is in output units; the sensor turns it into what is compared.
    """
    asked, gain = project.requirements, project.sensor.gain
    if not left_open(request.law, request.parameters) or isinstance(
        project.plant, FrequencyResponse
    ):
        return asked
    ends = (project.actuator.low, project.actuator.high)
    low, high = (None if end is None else end / gain for end in (ends if gain > 0 else ends[::-1]))
    return replace(
        asked,
        effort_min=low if asked.effort_min is None else asked.effort_min,
        effort_max=high if asked.effort_max is None else asked.effort_max,
    )


def _measured(project: Project, given: Given, *, claimed: bool = False) -> Entry:
    with within(f'controller "{given.name}": '):
        found = _evidence(project, given)
    findings = check(given.claims, found) if claimed else ()
    return Entry(name=given.name, law=GIVEN, measured=found, findings=findings)


def _evidence(project: Project, given: Given) -> Evidence:
    if isinstance(project.plant, FrequencyResponse):
        return measure_table(
            project.plant,
            given.controller,
            compute_delay=project.compute_delay,
            requirements=project.requirements,
            law=GIVEN,
            name=given.name,
        )
    return measure(
        project.plant,
        given.controller,
        compute_delay=project.compute_delay,
        requirements=project.requirements,
        reference=project.reference,
        law=GIVEN,
        name=given.name,
    )


def to_dict(project: Project, entries: Sequence[Entry]) -> dict[str, Any]:
    """Return the JSON object of the contract; findings only where claims were checked."""
    designs = []
    for entry in entries:
        findings = [f.to_dict() for f in entry.findings]
        designs.append(entry.to_dict() | ({"findings": findings} if findings else {}))
    return {
        "zoh": zoh.__version__,
        "plant": _plant(project),
        "designs": designs,
        "warnings": list(warnings(project, entries)),
    }


def _plant(project: Project) -> dict[str, Any]:
    """Return the sampled plant; of a table there are no coefficients, but a band."""
    if isinstance(project.plant, FrequencyResponse):
        table = in_clock(project.plant, project.dt, project.compute_delay)
        about = {"band": list(table.band), "points": len(table.w)}
        return {"num": None, "den": None, "dt": project.dt, "frequency_response": about}
    plant = sample(project.plant, project.dt, project.compute_delay)
    return {"num": list(plant.num), "den": list(plant.den), "dt": plant.dt}


def hidden_instability(project: Project) -> str | None:
    """Return a line on the modes that keep every loop of this plant unstable, None without any."""
    if isinstance(project.plant, FrequencyResponse):
        return None
    modes = unstable_hidden(project.plant)
    if not modes:
        return None
    listed = ", ".join(f"{s.real:.6g}" if s.imag == 0 else f"{s:.6g}" for s in modes)
    return (
        f"the plant hides an unstable mode at s = {listed} (num and den share it): no controller "
        "reaches it, so no loop is stable; cancel it only if the machine does not have it"
    )


def warnings(project: Project, entries: Sequence[Entry]) -> tuple[str, ...]:
    """Return what the numbers do not show: hidden modes, lost digits, an actuator's ends."""
    hidden = hidden_instability(project)
    said = [] if hidden is None else [hidden]
    left = [c.name for c in project.controllers if c.name not in {e.name for e in entries}]
    if left:
        said.append(f"not checked, nothing being given of them: {', '.join(left)}; run zoh design")
    for entry in entries:
        if entry.measured is None:
            continue
        notes = (
            *ringing_poles(entry.measured.controller, entry.measured.gains),
            *entry.measured.margins.warnings,
        )  # fmt: skip
        said += [f"{entry.name}: {sentence}" for sentence in notes]
        step = entry.measured.step
        if step is not None and step.effort_range is not None:
            said += _saturation(project, entry.name, step.effort_range)
    return tuple(said)


def _saturation(project: Project, name: str, effort: tuple[float, float]) -> list[str]:
    """Return a line for each end of the actuator that a step of the output passes.

    The reference of the file is in output units; the sensor turns it into what is compared.
    """
    low, high = sorted(project.sensor.gain * u for u in effort)
    unit = f" {project.input_unit}" if project.input_unit else ""
    ends = ((low, project.actuator.low, min), (high, project.actuator.high, max))
    return [
        f"{name} asks for {u:.4g}{unit} in a step of {project.reference:g}"
        f"{' ' + project.output_unit if project.output_unit else ''} of the output, the actuator "
        f"ends at {end:g}{unit}: it saturates, and the response is not the linear one shown"
        for u, end, further in ends
        if end is not None and further(u, end) != end
    ]
