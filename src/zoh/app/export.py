"""``zoh export`` without its terminal: a project's controllers as firmware, proved if asked."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import zoh
from zoh.analysis.tabled.verify import TableMeasured, TableVerified, table_verified
from zoh.analysis.verify import Measured, Verified, verified
from zoh.app.commands import Entry, design_all
from zoh.app.project import Project
from zoh.app.toml import within
from zoh.errors import NotMet, SpecError, Unequal
from zoh.firmware.asked import TAKEN
from zoh.firmware.book import IO_BITS
from zoh.firmware.equality import Equality
from zoh.firmware.export import texts
from zoh.firmware.plan import Plan, plan
from zoh.report.text import slug

Prove = Callable[[Plan], Equality]
Range = tuple[float, float]
_ROOM = 2.0  # times the largest value of a step of the reference, where the file has no range
_LONGEST = 28  # characters of a C name, room for a number behind it


@dataclass(frozen=True, slots=True, kw_only=True)
class Exported:
    """One controller: planned, and proved where that was asked; or why it is not.

    said  what the file left open and how it was closed, one sentence each
    """

    entry: Entry
    plan: Plan | None = None
    proof: Equality | None = None
    failure: str | None = None
    said: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form, one entry of ``controllers``."""
        made = self.plan
        return {
            "name": self.entry.name,
            "law": self.entry.law,
            "exported": self.failure is None,
            "reason": self.failure,
            "c_name": None if made is None else made.name,
            "number": None if made is None else made.number,
            "realisation": None if made is None else made.realisation,
            "sha256": None if made is None else made.sha256,
            "pm_loss_deg": None if made is None else made.pm_loss_deg,
            "margins": None if made is None else made.design.margins.to_dict(),
            "margins_as_built": None if made is None else made.quantised.margins.to_dict(),
            "said": [*self.said, *(() if made is None else made.said)],
            "proof": None if self.proof is None else self.proof.to_dict(),
        }


def export_all(
    project: Project, *, number: str, only: str | None = None, prove: Prove | None = None
) -> tuple[Exported, ...]:
    """Return the controllers of a project, or the one called ``only``, as firmware."""
    names = [c.name for c in project.controllers]
    if only is not None and only not in names:
        raise SpecError("--controller", f"must be one of {', '.join(names)}", only, "name one")
    wanted = [c for c in project.controllers if only in (None, c.name)]
    entries = design_all(replace(project, controllers=tuple(wanted)))
    made: list[Exported] = []
    for entry in entries:
        taken = [e.plan.name for e in made if e.plan is not None]
        made.append(_exported(project, entry, _identifier(entry.name, taken), number, prove))
    return tuple(made)


def _exported(
    project: Project, entry: Entry, name: str, number: str, prove: Prove | None
) -> Exported:
    if entry.failure is not None:
        return Exported(entry=entry, failure=entry.failure)
    assert entry.measured is not None  # else there is a failure
    made: Plan | None = None
    said: tuple[str, ...] = ()
    try:
        design = _verified(entry.measured)
        y_range, u_range, said = _ranges(project, design, number)
        with within(f'controller "{entry.name}": '):
            made = plan(
                design, name=name, number=number, u_min=project.actuator.low,
                u_max=project.actuator.high, y_range=y_range, u_range=u_range,
            )  # fmt: skip
        proof = None if prove is None else prove(made)
    except NotMet as missed:
        return Exported(entry=entry, failure="; ".join(missed.misses), said=said)
    except Unequal as differs:
        found: Equality = differs.found
        return Exported(entry=entry, plan=made, proof=found, failure=str(differs), said=said)
    return Exported(entry=entry, plan=made, proof=proof, said=said)


def _verified(evidence: Measured | TableMeasured) -> Verified | TableVerified:
    if isinstance(evidence, TableMeasured):
        return table_verified(evidence)
    return verified(evidence)


def _ranges(
    project: Project, design: Verified | TableVerified, number: str
) -> tuple[Range | None, Range | None, tuple[str, ...]]:
    """Return what whole numbers span: as the file says, else with room around the step."""
    if number not in (*IO_BITS, "auto"):
        return None, None, ()
    said = []
    sensor, ends = project.sensor, project.actuator
    step = None if isinstance(design, TableVerified) else design.step
    if step is None and number == "auto" and None in (sensor.low, sensor.high, ends.low, ends.high):
        return None, None, ()  # the plan passes whole numbers over, and says that these are missing
    if sensor.low is not None and sensor.high is not None:
        y_range = (sensor.low, sensor.high)
    elif step is None:
        raise _missing("sensor.range")
    else:
        between = step.between_samples or step
        y_range = _around(project.reference, step.peak, between.peak)
        said.append(f"[sensor] has no range: y spans {_shown(y_range)}, {_ROOM:g} times the step")
    if ends.low is not None and ends.high is not None:
        return y_range, None, tuple(said)
    if step is None:
        raise _missing("actuator.min and actuator.max")
    u_range = _around(step.peak_effort, ends.low, ends.high)
    said.append(f"[actuator] has no two ends: u spans {_shown(u_range)}, {_ROOM:g} times its peak")
    return y_range, u_range, tuple(said)


def _missing(keys: str) -> SpecError:
    way_out = "a table of measurements has no step that could say what whole numbers must span"
    return SpecError(keys, "must be given", "nothing", way_out)


def _around(*values: float | None) -> Range:
    largest = max((abs(v) for v in values if v), default=1.0)
    return -_ROOM * largest, _ROOM * largest


def _shown(ends: Range) -> str:
    return f"{ends[0]:.6g} ... {ends[1]:.6g}"


def _identifier(name: str, taken: Sequence[str]) -> str:
    """Return a name that C allows, different from those taken."""
    plain = slug(name).replace("-", "_")
    base = plain if plain[0].isalpha() and plain not in TAKEN else f"c_{plain}"
    return slug(base[:_LONGEST], [t.replace("_", "-") for t in taken]).replace("-", "_")


def files(exported: Sequence[Exported]) -> dict[str, str]:
    """Return the texts of what can be exported, by file name."""
    standing = [(e.plan, e.proof) for e in exported if e.failure is None and e.plan is not None]
    if not standing:
        return {}
    return texts([p for p, _ in standing], proofs=[proof for _, proof in standing])


def to_dict(exported: Sequence[Exported]) -> Mapping[str, Any]:
    """Return the JSON object of ``zoh export --json``."""
    return {
        "zoh": zoh.__version__,
        "target": "c",
        "controllers": [e.to_dict() for e in exported],
        "files": files(exported),
    }


def as_text(exported: Sequence[Exported]) -> str:
    """Return the same for people."""
    return "\n\n".join(map(_block, exported))


def _block(e: Exported) -> str:
    if e.plan is None:
        return f"{e.entry.name}: not exported: {e.failure}"
    made = e.plan
    built, asked = (d.margins.phase_margin_deg for d in (made.quantised, made.design))
    lines = [
        f"{e.entry.name}: {made.name}.h, {made.name}.c; {made.number}, {made.realisation}",
        f"  phase margin {asked:.6g} deg designed, {built:.6g} deg as built",
        *(f"  {sentence}" for sentence in (*e.said, *made.said)),
    ]
    if e.proof is None:
        return "\n".join([*lines, "  equality with the model: not proved; --prove does"])
    return "\n".join([*lines, *(f"  {line}" for line in e.proof.report().splitlines())])
