"""Evidence about one loop, and evidence that everything asked is met.

``Measured`` is what was measured; ``Verified`` cannot be built from less than a loop that is stable
and meets all that was asked. The law, its gains and the choice are labels.
"""

from cmath import exp
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import radians
from typing import Any

from zoh.analysis.asked import missed
from zoh.analysis.loop import Loop
from zoh.analysis.results import Choice, Margins, StepInfo
from zoh.analysis.stability import closed_loop_stable
from zoh.errors import NotMet
from zoh.lti.forms import forms, ringing, sentences
from zoh.lti.systems import Plant, Sampled
from zoh.lti.weights import feedforward, fits, reference_path
from zoh.lti.written import fraction, number
from zoh.sampling.hold import sample
from zoh.spec import Requirements

_SAME_GAIN = 1e-6  # two roads to one gain; they differ by rounding, another loop by far more


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """One loop and what was measured of it.

    plant, controller  as given; sampled is the plant behind its hold, sensor included
    compute_delay      s, from sampling to output
    reference          the step asked of the loop, in the units the controller compares
    law, gains, name   labels
    step               None where the closed loop is unstable
    noise_gain         standard deviation of u per unit of white measurement noise, one value a
                       sample; None where nothing is asked of it
    setpoint_weight, derivative_weight  the shares of the reference that the proportional and the
                       derivative part see; see ``zoh.lti.weights``
    feedforward        what those weights add to u from the reference; None where that is nothing
    misses             one sentence for each requirement missed; empty where all is met
    choice             what was left open and how it was closed, a label; None where nothing was
    allowed            what was allowed by name, a label
    """

    name: str
    law: str
    gains: Mapping[str, float]
    plant: Plant
    sampled: Sampled
    controller: Sampled
    compute_delay: float
    reference: float
    requirements: Requirements
    margins: Margins
    step: StepInfo | None
    noise_gain: float | None = None
    setpoint_weight: float = 1.0
    derivative_weight: float = 1.0
    feedforward: Sampled | None = None
    misses: tuple[str, ...] = field(default=())
    choice: Choice | None = None
    allowed: tuple[str, ...] = ()

    @property
    def dt(self) -> float:
        """Return the sample time in s."""
        return self.controller.dt

    @property
    def forms(self) -> dict[str, Any]:
        """Return the gains in parallel, standard and series form; {} for a law without kp."""
        return forms(self.gains)

    @property
    def loop(self) -> Sampled:
        """Return the open loop, controller times sampled plant."""
        return self.controller * self.sampled

    @property
    def reference_path(self) -> Sampled:
        """Return what u owes to the reference, u = reference_path r - controller y."""
        return reference_path(self.controller, self.feedforward)

    @property
    def met(self) -> bool:
        """Return whether everything asked is met, stability first."""
        return not self.misses

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form, one entry of ``designs``."""
        ahead = self.feedforward
        return {
            "name": self.name,
            "law": self.law,
            "feasible": True,
            "reason": None,
            "gains": dict(self.gains),
            "forms": self.forms,
            "controller": _coefficients(self.controller),
            "setpoint_weight": self.setpoint_weight,
            "derivative_weight": self.derivative_weight,
            "reference_path": None if ahead is None else _coefficients(self.reference_path),
            "margins": self.margins.to_dict(),
            "step": self._step_dict(),
            "noise_gain": self.noise_gain,
            "met": self.met,
            "misses": list(self.misses),
            "choice": None if self.choice is None else self.choice.to_dict(),
            "allowed": list(self.allowed),
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
        gains = ", ".join(f"{k} = {number(v)}" for k, v in self.gains.items())
        controller = fraction(self.controller.num, self.controller.den, "z")
        verdict = {True: "stable", False: "UNSTABLE", None: "NOT PROVED to be stable"}[m.stable]
        lines = [
            f"{self.name}: {self.law}" + (f" with {gains}" if gains else ""),
            *(f"  {sentence}" for sentence in sentences(self.gains)),
            *([f"  reference weighted by {_weights(self)}"] if self.feedforward else []),
            f"  D(z) = {controller}, dt = {self.dt:g} s",
            f"  closed loop {verdict}",
            f"  phase margin {m.phase_margin_deg:.6g} deg at {_or_none(m.crossover)} rad/s,"
            f" gain margin {m.gain_margin_db:.4g} dB at {_or_none(m.phase_crossover)} rad/s",
            f"  delay margin {m.delay_margin:.4g} s, Ms {m.ms:.4g}, Mt {m.mt:.4g},"
            f" bandwidth {_or_none(m.bandwidth)} rad/s",
        ]
        if self.step is not None:
            lines.append(_step_line(self.step))
        if m.certificate is not None and m.certificate.holds:
            lines.append("  proved: stability, every crossing, every peak")
        if self.choice is not None:
            lines += [f"  {sentence}" for sentence in self.choice.sentences]
        lines += [f"  allowed: {word}" for word in self.allowed]
        notes = (*ringing(self.gains, self.dt), *m.warnings)
        lines += [f"  NOTE: {note}" for note in notes]
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
        for wc, pm_deg in self.margins.gain_crossings:
            gain = self.controller.at(wc) * sampled.at(wc)
            if abs(gain + exp(1j * radians(pm_deg))) > _SAME_GAIN:
                return False
        return self._weights_hold()

    def _weights_hold(self) -> bool:
        """Return whether the feedforward is what the weights and the gains say."""
        weights, ahead = (self.setpoint_weight, self.derivative_weight), self.feedforward
        if ahead is None:
            return feedforward(self.gains, *weights, self.dt) is None
        return fits(self.controller, ahead, self.gains, *weights)


def _coefficients(system: Sampled) -> dict[str, Any]:
    return {
        "num": list(system.num),
        "den": list(system.den),
        "dt": system.dt,
        "num_w": list(system.num_w),
        "den_w": list(system.den_w),
    }


def _weights(d: Measured) -> str:
    """Return the weights in words, of a law with a derivative both."""
    said = f"b = {d.setpoint_weight:g}"
    return said + (f", c = {d.derivative_weight:g}" if "kd" in d.gains else "")


def _or_none(value: float | None) -> str:
    return "no" if value is None else f"{value:.6g}"


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
