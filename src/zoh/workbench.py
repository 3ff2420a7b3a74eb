"""A plant on the bench: what a law is solved in, judged by and measured with."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from zoh.analysis.load_error import load_iae
from zoh.analysis.on_target import not_as_asked
from zoh.analysis.verify import Verified, measure, verified
from zoh.errors import NotMet
from zoh.lti.hidden import unstable_hidden, without_hidden
from zoh.lti.systems import Plant, Sampled
from zoh.request import CANCELLED_UNSTABLE_MODES
from zoh.sampling.pathological import hidden_by_hold
from zoh.solving import SolvedLaw
from zoh.spec import Crossover, Requirements

_WORD = f'allow=["{CANCELLED_UNSTABLE_MODES}"]'
HIDES = f"the plant hides an unstable mode: {_WORD} takes it out of the model"
"""What is said of a plant of which no controller can make a stable loop."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """A plant at its clock, what is in series with the law, what is asked, and for which step.

    sampled  the plant with what is ``fixed``, as the law is solved on it
    weights  of the reference
    """

    plant: Plant
    sampled: Sampled
    compute_delay: float
    requirements: Requirements
    reference: float
    fixed: Sampled | None = None
    weights: Mapping[str, float] = field(default_factory=dict)

    def whole(self, law: Sampled) -> Sampled:
        """Return the controller: the law with what is fixed."""
        return law * self.fixed if self.fixed else law

    def setting(self) -> dict[str, Any]:
        """Return what the setting consists of, by name."""
        return {f.name: getattr(self, f.name) for f in fields(Setting)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench(Setting):
    """A setting, and what the law in it is called; ``allowed`` is said to be so by name."""

    law: str
    name: str | None
    allowed: tuple[str, ...]

    def iae(self, law: Sampled) -> float:
        """Return the absolute error after a load step."""
        return load_iae(self.plant, self.whole(law), self.compute_delay)

    def verified(self, found: SolvedLaw, spec: Crossover | None) -> Verified:
        """Return the measured design; raise NotMet where it is not what was asked."""
        evidence = measure(
            self.plant, self.whole(found.controller), compute_delay=self.compute_delay,
            requirements=self.requirements, reference=self.reference, law=self.law,
            gains=found.gains, name=self.name, fixed=self.fixed, **self.weights,
        )  # fmt: skip
        evidence = replace(evidence, allowed=self.allowed) if self.allowed else evidence
        off = not_as_asked(evidence.margins, spec, lambda wc: evidence.loop.at(wc))
        if evidence.margins.stable is False and unstable_hidden(self.plant):
            off = [HIDES]
        if off:
            hidden = hidden_by_hold(self.plant, self.sampled.dt)
            raise NotMet((*evidence.misses, *off), evidence, "; ".join(hidden))
        return verified(evidence)


def without_cancelled(plant: Plant, allow: frozenset[str]) -> tuple[Plant, tuple[str, ...]]:
    """Return the plant without what it hides, where that is unstable and allowed; and the word."""
    if CANCELLED_UNSTABLE_MODES not in allow:
        return plant, ()
    modes = unstable_hidden(plant)
    if not modes:
        return plant, ()
    listed = ", ".join(f"{s.real:.6g}" if s.imag == 0 else f"{s:.6g}" for s in modes)
    return without_hidden(plant), (f"{CANCELLED_UNSTABLE_MODES} (s = {listed})",)
