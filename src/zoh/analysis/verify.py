"""What was asked against what was measured.

``Measured`` is evidence about one loop; ``Verified`` is evidence that everything asked is met,
and cannot be built from anything less. Nothing here knows how the controller came about: the
law and its gains are labels.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from zoh import checks
from zoh.analysis.asked import checked, missed
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.record import Record, crosses, labels, or_no
from zoh.analysis.responses import noise_gains
from zoh.analysis.results import Choice, Margins, StepInfo
from zoh.analysis.stability import closed_loop_stable
from zoh.analysis.step import closed_loop_step
from zoh.errors import NotMet, SpecError, warn_of_accuracy
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample
from zoh.spec import Requirements

NOTHING_ASKED = Requirements()


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured(Record):
    """One loop and what was measured of it.

    plant       as given; sampled is the plant behind its hold, sensor included
    reference   the step asked of the loop, in the units the controller compares
    step        None where the closed loop is unstable
    noise_gain  standard deviation of u per unit of white measurement noise, one value a
                sample; None where nothing is asked of it
    choice      what was left open and how it was closed, a label; None where nothing was
    """

    plant: Plant
    sampled: Sampled
    reference: float
    margins: Margins
    step: StepInfo | None
    noise_gain: float | None = None
    choice: Choice | None = None

    @property
    def loop(self) -> Sampled:
        """Return the open loop, controller times sampled plant."""
        return self.controller * self.sampled

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form, one entry of ``designs``."""
        return {
            **self._labels(),
            "margins": self.margins.to_dict(),
            "step": self._step_dict(),
            "noise_gain": self.noise_gain,
            "met": self.met,
            "misses": list(self.misses),
            "choice": None if self.choice is None else self.choice.to_dict(),
        }

    def _step_dict(self) -> dict[str, Any] | None:
        """Return the step's JSON form, with the effort that a step of the *output* would ask."""
        if self.step is None or self.step.peak_effort is None:
            return None
        effort = self.step.peak_effort * abs(self.plant.sensor)
        return {**self.step.to_dict(), "peak_effort_output_step": effort}

    def report(self) -> str:
        """Return what was measured in a few lines."""
        m = self.margins
        lines = [
            *self._head(m, "NOT PROVED to be stable"),
            f"  delay margin {m.delay_margin:.4g} s, Ms {m.ms:.4g}, Mt {m.mt:.4g},"
            f" bandwidth {or_no(m.bandwidth)} rad/s",
        ]
        if self.step is not None:
            lines.append(_step_line(self.step))
        if m.certificate is not None and m.certificate.holds:
            lines.append("  proved: stability, every crossing, every peak")
        if self.choice is not None:
            lines += [f"  {sentence}" for sentence in self.choice.sentences]
        lines += [f"  NOTE: {warning}" for warning in m.warnings]
        lines += [f"  MISSED: {miss}" for miss in self.misses]
        return "\n".join(lines)


@dataclass(frozen=True, slots=True, kw_only=True)
class Verified(Measured):
    """A loop that is stable and meets every requirement; made by ``verify`` alone."""

    def __post_init__(self) -> None:
        found = missed(self.requirements, self.margins, self.step, self.noise_gain)
        if self.step is None or not self._evidence_holds():
            found.append("the evidence is not this loop's")
        if found or self.misses:
            raise NotMet(tuple(found) or self.misses, self)

    def _evidence_holds(self) -> bool:
        """Return whether the loop, put together anew, is stable and crosses where it is said to."""
        sampled = sample(self.plant, self.controller.dt, self.compute_delay)
        if not closed_loop_stable(Loop.of(self.controller, sampled)):
            return False
        return crosses(lambda w: self.controller.at(w) * sampled.at(w), self.margins.gain_crossings)


def measure(
    plant: Plant,
    controller: Sampled,
    *,
    dt: float | None = None,
    compute_delay: float = 0.0,
    requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0,
    law: str = "given",
    gains: Mapping[str, float] | None = None,
    name: str | None = None,
) -> Measured:
    """Return everything measured of plant and controller in unity feedback.

    ``dt`` may be given to say which sample time is meant; it must be the controller's.
    Raises SpecError for what is no plant, no controller, or two sample times; warns as
    ``zoh.margins`` does.
    """
    if isinstance(plant, FrequencyResponse):
        raise SpecError("plant", "must be a model", plant, "zoh.measure_table is for tables")
    if not isinstance(controller, Sampled):
        raise SpecError("controller", "must be a zoh.Sampled", controller, "give num, den and dt")
    if dt is not None and checks.number("dt", dt, "give seconds") != controller.dt:
        raise SpecError("dt", f"must be the controller's {controller.dt!r} s", dt, "use one clock")
    reference = checks.number("reference", reference, "give the size of the step")
    if reference == 0:
        raise SpecError("reference", "must not be 0", reference, "a step of 0 shows nothing")
    requirements = checked(requirements)
    called = labels(law, gains, name)
    sampled = sample(plant, controller.dt, compute_delay)
    margins = measure_loop(Loop.of(controller, sampled))
    warn_of_accuracy(margins.warnings)
    step, noise_gain = None, None
    if margins.stable:
        step = closed_loop_step(plant, controller, compute_delay=compute_delay, reference=reference)
        if requirements.noise_gain is not None:
            noise_gain = noise_gains(plant, controller, compute_delay=compute_delay)[1]
    return Measured(
        **called,
        plant=plant,
        sampled=sampled,
        controller=controller,
        compute_delay=float(compute_delay),
        reference=reference,
        requirements=requirements,
        margins=margins,
        step=step,
        noise_gain=noise_gain,
        misses=tuple(missed(requirements, margins, step, noise_gain)),
    )


def verify(
    plant: Plant,
    controller: Sampled,
    *,
    dt: float | None = None,
    compute_delay: float = 0.0,
    requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0,
    law: str = "given",
    gains: Mapping[str, float] | None = None,
    name: str | None = None,
) -> Verified:
    """Return the loop as ``Verified``; raise NotMet, with the evidence, where it is not.

    >>> plant = Plant(num=[1], den=[1, 1])
    >>> verify(plant, Sampled(num=[2.0], den=[1.0], dt=0.1)).margins.stable
    True
    >>> verify(plant, Sampled(num=[30.0], den=[1.0], dt=0.1))
    Traceback (most recent call last):
    zoh.errors.NotMet: not met: the closed loop is unstable
    """
    evidence = measure(
        plant, controller, dt=dt, compute_delay=compute_delay, requirements=requirements,
        reference=reference, law=law, gains=gains, name=name,
    )  # fmt: skip
    return verified(evidence)


def verified(evidence: Measured) -> Verified:
    """Return the evidence as ``Verified``, or raise NotMet that carries it."""
    if evidence.misses:
        raise NotMet(evidence.misses, evidence)
    return Verified(**{f.name: getattr(evidence, f.name) for f in fields(Measured)})


def _step_line(step: StepInfo) -> str:
    between = step.between_samples or step
    over = between.overshoot_pct
    parts = [
        "no overshoot defined" if over is None else f"overshoot {over:.4g} %",
        "never rises" if step.rise_time is None else f"rise {step.rise_time:.4g} s",
        step.settling if step.settling_time is None else f"settling {step.settling_time:.4g} s",
    ]
    if step.peak_effort is not None:
        parts.append(f"peak effort {step.peak_effort:.4g}")
    return "  step: " + ", ".join(parts)


__all__ = ["Measured", "Verified", "measure", "verified", "verify"]
