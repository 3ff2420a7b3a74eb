"""A controller in one realisation and one number format, fitted, put together, verified again."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from math import sqrt
from typing import TypedDict

from zoh.analysis.tabled.verify import TableVerified, verify_table
from zoh.analysis.verify import verify
from zoh.errors import NotMet, SpecError
from zoh.firmware.asked import Asked, Design
from zoh.firmware.book import Format
from zoh.firmware.cascade import CascadeStep
from zoh.firmware.levels import levelled
from zoh.firmware.linear import reference_path, transfer
from zoh.firmware.lines import Number, Program
from zoh.firmware.pid import PidStep
from zoh.firmware.ranges import Overflow, Ranges, proved
from zoh.firmware.realise import Parallel, from_d, in_parts, parallel, sections
from zoh.lti.systems import Sampled

Step = PidStep | CascadeStep


@dataclass(frozen=True, slots=True, kw_only=True)
class Built:
    """What was built of a design: its step, and the loop of its rounded coefficients."""

    realisation: str
    step: Step
    program: Program
    ranges: Ranges | None
    design: Design
    quantised: Design

    @property
    def pm_loss_deg(self) -> float:
        """Return by how many degrees rounding the coefficients has moved the phase margin."""
        a, b = self.design.margins.phase_margin_deg, self.quantised.margins.phase_margin_deg
        return 0.0 if a == b else abs(a - b)


def candidates(request: Asked, number: Number) -> dict[str, Callable[[], Step]]:
    """Return what makes each realisation's step, by name."""
    law = parallel(request.verified.controller)
    found: dict[str, Callable[[], Step]] = {}
    if request.realisation in ("auto", "pid"):
        if law is not None:
            found["pid"] = partial(_pid, request, number, law)
        elif request.realisation == "pid":
            raise SpecError(
                "realisation", "must fit the controller, and pid is P, I and filtered differences",
                "pid", "choose cascade or delta",
            )  # fmt: skip
    if law is not None and len(law.filters) > 1 and request.weighted:
        raise SpecError(
            request.weighted, "must be 1 where there are two filters",
            getattr(request, request.weighted), "weights belong to P, PI, PD and PID",
        )  # fmt: skip
    alone = law is not None and not (law.ki or law.filters) and request.realisation == "auto"
    if not request.needs_parallel and not alone:  # a gain alone has one form
        for name in ("cascade", "delta"):
            if request.realisation in ("auto", name):
                found[name] = partial(_cascade, request, number, name == "delta")
    if not found:
        raise SpecError(
            request.needs_parallel, request.in_sections, getattr(request, request.needs_parallel),
            "the rest belongs to the parallel form: P, I and filtered differences",
        )  # fmt: skip
    return found


def _pid(request: Asked, number: Number, law: Parallel) -> PidStep:
    format_ = request.format(number)
    features = request.features(format_, integral=bool(law.ki), sections=False, back=_back(law))
    return PidStep.begun(law, features, format_)


def _cascade(request: Asked, number: Number, delta: bool) -> CascadeStep:
    format_ = request.format(number)
    parts = sections(request.verified.controller)
    if any(p.a[p.order - 1] == 0 for p in parts[:-1]):
        raise SpecError(
            "controller",
            "must have two integrators at most",
            sum(p.a[: p.order].count(Fraction(0)) for p in parts),
            "there is no use for more",
        )
    if format_.whole:
        parts = levelled(parts)
    features = request.features(format_, integral=False, sections=True, back=Fraction(1))
    return CascadeStep.begun(parts, features, format_, delta=delta)


def _back(law: Parallel) -> Fraction:
    """Return dt/Tt, Tt = sqrt(Ti Td) or Ti without a derivative; 1 at most.

    Source: K. J. Astrom and T. Hagglund, Advanced PID Control, sec. 3.5.
    """
    kp = law.kp - law.ki / 2
    if kp <= 0 or law.ki <= 0:
        return Fraction(1)
    ti = float(kp / law.ki)
    td = max(0.0, float(sum(f.kd / f.alpha for f in law.filters) / kp))
    return min(Fraction(1), Fraction(1 / (sqrt(ti * td) if td else ti)))


def built(request: Asked, realisation: str, step: Step) -> Built:
    """Return what a step builds, its binary points found, its controller verified again.

    Raises SpecError where a value does not fit, NotMet where the rounded loop misses what is asked.
    """
    step, program, ranges = _fitted(step, request)
    design = request.verified
    try:
        quantised = _verified_again(request, program, step.format)
    except NotMet as missed:
        told = tuple(f"rounded to {step.format.number}: {m}" for m in missed.misses)
        raise NotMet(told, missed.measured) from None
    return Built(
        realisation=realisation, step=step, program=program, ranges=ranges, design=design,
        quantised=quantised,
    )  # fmt: skip


def controller_of(program: Program, form: Format, dt: float) -> Sampled:
    """Return the controller that a program's lines make, in physical units."""
    num, den = transfer(program)
    return from_d(tuple(c / form.gain for c in num), den, dt)


def _verified_again(request: Asked, program: Program, form: Format) -> Design:
    """Return the loop that a program makes, verified as the design was, on its model or table."""
    d, asked = request.verified, request.eased
    controller = controller_of(program, form, d.dt)
    if isinstance(d, TableVerified):
        return verify_table(
            d.plant, controller, compute_delay=d.compute_delay, requirements=asked, law=d.law,
            gains=d.gains, name=d.name,
        )  # fmt: skip
    return verify(
        d.plant, controller, compute_delay=d.compute_delay, requirements=asked,
        reference=d.reference, law=d.law, name=d.name, **_entered(request, program, form),
    )  # fmt: skip


class Entered(TypedDict, total=False):
    """Gains, and the weights with which the reference enters."""

    gains: Mapping[str, float]
    setpoint_weight: float
    derivative_weight: float


def _entered(request: Asked, program: Program, form: Format) -> Entered:
    """Return how the reference enters; where it is weighted, as the program's own lines have it."""
    if request.setpoint_weight == request.derivative_weight == 1:
        return {"gains": request.verified.gains}
    law, path = in_parts(*transfer(program)), in_parts(*reference_path(program))
    assert law is not None, "weights belong to the parallel form"
    assert path is not None, "weights belong to the parallel form"
    assert law.ki == path.ki, "the integral sees the whole reference"
    dt, gain = Fraction(request.verified.dt), form.gain
    kp, on_r = law.kp - law.ki / 2, path.kp - path.ki / 2
    found: dict[str, Fraction] = {"kp": kp / gain}
    # a weight of 0 of which rounding leaves a part of a step below 0 is 0
    entered: Entered = {"setpoint_weight": max(0.0, float(on_r / kp)) if kp else 1.0}
    if law.ki:
        found["ki"] = law.ki / dt / gain
    if law.filters:
        (part,) = law.filters
        seen = sum(f.kd for f in path.filters)
        found |= {"kd": part.kd * dt / part.alpha / gain}
        found |= {"filter_pole": 2 / (dt * (2 / part.alpha - 1))}
        entered["derivative_weight"] = float(seen / part.kd)
    entered["gains"] = {name: float(value) for name, value in found.items()}
    return entered


def _fitted(step: Step, request: Asked) -> tuple[Step, Program, Ranges | None]:
    """Return the step whose binary points are the highest at which no value can overflow."""
    while True:
        program = step.program()
        if not step.format.whole:
            return step, program, None
        found = proved(program)
        if isinstance(found, Ranges):
            return step, program, found
        lower: Step | None = step
        needed = max(found.most, -1 - found.least).bit_length() + 1 - found.word
        for _ in range(needed if found.group else 0):
            lower = lower.moved(found.group) if lower else None
        if lower is None or not found.group:
            raise _too_large(found, request)
        step = lower


def _too_large(found: Overflow, request: Asked) -> SpecError:
    limit = (1 << found.word - 1) - 1
    return SpecError(
        "u_range",
        f"must leave room for '{found.name}' ({found.says}), which needs "
        f"{max(found.most, -found.least) / limit:.3g} times what {found.word} bits hold",
        request.u_range,
        "give a wider u_range, a narrower y_range, or choose a longer number",
    )
