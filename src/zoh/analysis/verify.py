"""What was asked against what was measured.

Nothing here knows how the controller came about: the law and its gains are labels.
"""

from collections.abc import Mapping
from dataclasses import fields, replace

from zoh import checks
from zoh.analysis.asked import NOTHING_ASKED, checked, missed
from zoh.analysis.evidence import Measured, Verified
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.record import labels
from zoh.analysis.responses import noise_gains
from zoh.analysis.stability import hurwitz_floats
from zoh.analysis.step import closed_loop_step
from zoh.errors import NotMet, SpecError, warn_of_accuracy
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.systems import Plant, Sampled
from zoh.lti.weights import feedforward, fits
from zoh.sampling.hold import sample
from zoh.sampling.pathological import hidden_by_hold
from zoh.spec import Requirements

_NAMES = tuple(f.name for f in fields(Measured))


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
    setpoint_weight: float = 1.0,
    derivative_weight: float = 1.0,
    fixed: Sampled | None = None,
) -> Measured:
    """Return everything measured of plant and controller in unity feedback.

    ``dt`` may be given to say which sample time is meant; it must be the controller's. Weights of
    the reference need the ``gains`` of the controller, and what is ``fixed`` in series with them.
    Raises SpecError for what is no plant, no controller, or two sample times; warns as
    ``zoh.margins`` does, and of each mode that the hold hides.
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
    weights = (
        checks.not_negative("setpoint_weight", setpoint_weight),
        checks.not_negative("derivative_weight", derivative_weight),
    )
    ahead = _ahead(controller, called["gains"], weights, fixed)
    sampled = sample(plant, controller.dt, compute_delay)
    margins = measure_loop(Loop.of(controller, sampled))
    if hidden := hidden_by_hold(plant, controller.dt):
        margins = replace(margins, warnings=(*hidden, *margins.warnings))
    warn_of_accuracy(margins.warnings)
    step, noise_gain = None, None
    if margins.stable:
        step = closed_loop_step(
            plant, controller, compute_delay=compute_delay, reference=reference, feedforward=ahead
        )
        if requirements.noise_gain is not None:
            noise_gain = noise_gains(plant, controller, compute_delay=compute_delay)[1]
    return Measured(
        **called,
        setpoint_weight=weights[0],
        derivative_weight=weights[1],
        feedforward=ahead,
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


def _ahead(
    controller: Sampled, gains: Mapping[str, float], weights: tuple[float, float],
    fixed: Sampled | None,
) -> Sampled | None:  # fmt: skip
    """Return the feedforward of the weights; raise SpecError where the gains are not these."""
    ahead = feedforward(gains, *weights, controller.dt)
    if ahead is None:
        return None
    ahead = ahead * fixed if fixed else ahead
    if not fits(controller, ahead, gains, *weights):
        bound = "must be those of the controller where its reference is weighted"
        raise SpecError("gains", bound, dict(gains), "give kp, ki, kd and filter_pole")
    if not hurwitz_floats(ahead.den_w):
        bound = "must be stable where the reference is weighted"
        raise SpecError("controller", bound, "an unstable filter", "leave the weights out")
    return ahead


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
    setpoint_weight: float = 1.0,
    derivative_weight: float = 1.0,
    fixed: Sampled | None = None,
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
        reference=reference, law=law, gains=gains, name=name, setpoint_weight=setpoint_weight,
        derivative_weight=derivative_weight, fixed=fixed,
    )  # fmt: skip
    return verified(evidence)


def verified(evidence: Measured) -> Verified:
    """Return the evidence as ``Verified``, or raise NotMet that carries it."""
    if evidence.misses:
        hidden = hidden_by_hold(evidence.plant, evidence.dt)
        raise NotMet(evidence.misses, evidence, "; ".join(hidden))
    return Verified(**{name: getattr(evidence, name) for name in _NAMES})


__all__ = ["Measured", "Verified", "measure", "verified", "verify"]
