"""Evidence about one loop, and evidence that everything asked is met.

``Measured`` is what was measured; ``Verified`` cannot be built from less than a loop that is stable
and meets all that was asked. The law, its gains and the choice are labels.
"""

from dataclasses import dataclass
from typing import Any

from zoh.analysis.asked import missed
from zoh.analysis.loop import Loop
from zoh.analysis.margin_crossings import surely_crosses
from zoh.analysis.record import Record, coefficients, crosses, or_no
from zoh.analysis.results import Choice, Margins, StepInfo
from zoh.analysis.stability import surely_stable
from zoh.errors import NotMet
from zoh.lti.forms import ringing_poles
from zoh.lti.systems import Plant, Sampled
from zoh.lti.weights import feedforward, fits, reference_path
from zoh.sampling.hold import sample


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured(Record):
    """One loop and what was measured of it.

    plant              as given; sampled is the plant behind its hold, sensor included
    reference          the step asked of the loop, in the units the controller compares
    step               None where the closed loop is unstable
    noise_gain         standard deviation of u per unit of white measurement noise, one value a
                       sample; None where nothing is asked of it
    setpoint_weight, derivative_weight  the shares of the reference that the proportional and the
                       derivative part see; see ``zoh.lti.weights``
    feedforward        what those weights add to u from the reference; None where that is nothing
    choice             what was left open and how it was closed, a label; None where nothing was
    allowed            what was allowed by name, a label
    """

    plant: Plant
    sampled: Sampled
    reference: float
    margins: Margins
    step: StepInfo | None
    noise_gain: float | None = None
    setpoint_weight: float = 1.0
    derivative_weight: float = 1.0
    feedforward: Sampled | None = None
    choice: Choice | None = None
    allowed: tuple[str, ...] = ()

    @property
    def loop(self) -> Sampled:
        """Return the open loop, controller times sampled plant."""
        return self.controller * self.sampled

    @property
    def reference_path(self) -> Sampled:
        """Return what u owes to the reference, u = reference_path r - controller y."""
        return reference_path(self.controller, self.feedforward)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form, one entry of ``designs``."""
        ahead = self.feedforward
        return {
            **self._labels(),
            "setpoint_weight": self.setpoint_weight,
            "derivative_weight": self.derivative_weight,
            "reference_path": None if ahead is None else coefficients(self.reference_path),
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
        head, ahead = self._head(m, "NOT PROVED to be stable"), self.feedforward
        lines = [
            *head,
            *([f"  reference weighted by {_weights(self)}"] if ahead else []),
            f"  delay margin {m.delay_margin:.4g} s, Ms {m.ms:.4g}, Mt {m.mt:.4g},"
            f" bandwidth {or_no(m.bandwidth)} rad/s",
        ]
        if self.step is not None:
            lines.append(_step_line(self.step))
        if m.certificate is not None and m.certificate.holds:
            lines.append("  proved: stability, every crossing, every peak")
        if self.choice is not None:
            lines += [f"  {sentence}" for sentence in self.choice.sentences]
        lines += [f"  allowed: {word}" for word in self.allowed]
        notes = (*ringing_poles(self.controller, self.gains), *m.warnings)
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
        loop = Loop.of(self.controller, sampled)
        if not surely_stable(loop, self.margins.modulus_margin):
            return False
        gain = self.margins.gain_crossings
        if not crosses(at := lambda w: self.controller.at(w) * sampled.at(w), gain):
            # beside an undamped pole no float tells what L is
            if not all(crosses(at, [c]) or surely_crosses(loop, *c) for c in gain):
                return False
        return self._weights_hold()

    def _weights_hold(self) -> bool:
        """Return whether the feedforward is what the weights and the gains say."""
        weights, ahead = (self.setpoint_weight, self.derivative_weight), self.feedforward
        if ahead is None:
            return feedforward(self.gains, *weights, self.dt) is None
        return fits(self.controller, ahead, self.gains, *weights)


def _weights(d: Measured) -> str:
    """Return the weights in words, of a law with a derivative both."""
    said = f"b = {d.setpoint_weight:g}"
    return said + (f", c = {d.derivative_weight:g}" if "kd" in d.gains else "")


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
