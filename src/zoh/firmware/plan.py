"""From a verified controller to what is built: number format, realisation, limits, all of it said.

The coefficients are rounded, the controller that they really make is put together exactly, and it
is verified again in the loop that the design was verified in. A word that a value does not fit, a
gain that vanishes, a loop that rounding has taken beyond what was asked is an error here, never
a surprise on a board.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from hashlib import sha256
from math import sqrt

from zoh import checks
from zoh.analysis.verify import Verified, verify
from zoh.errors import NotMet, SpecError, ZohError
from zoh.firmware.asked import Asked, asked
from zoh.firmware.book import Features, Format
from zoh.firmware.cascade import CascadeStep
from zoh.firmware.lines import NUMBERS, Coefficient, Number, Program
from zoh.firmware.pid import GROUPS, PidStep
from zoh.firmware.ranges import Overflow, Ranges, proved
from zoh.firmware.realise import Parallel, from_d, levelled, parallel, sections

REALISATIONS = ("pid", "cascade", "delta")
_SAME_DEG = 1e-4  # losses this near to each other do not decide between realisations

Step = PidStep | CascadeStep


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """One controller as it is built; made by ``plan`` alone.

    name         of the C functions and files
    number       f32, f64, q31 or q15
    realisation  pid (parallel form), cascade (second-order sections) or delta
    dt           s
    design       what was verified
    quantised    the same loop with the coefficients as they are built, verified again
    program      states, coefficients and lines
    ranges       of every value, proved for all time; None for floats
    features     limits, anti-windup and weights
    format       the units of a step of y and of u
    said         why it is as it is, one sentence each
    """

    name: str
    number: Number
    realisation: str
    dt: float
    design: Verified
    quantised: Verified
    program: Program
    ranges: Ranges | None
    features: Features
    format: Format
    said: tuple[str, ...]

    @property
    def coefficients(self) -> tuple[Coefficient, ...]:
        """Return every constant, exactly as the C has it."""
        return self.program.coefficients

    @property
    def pm_loss_deg(self) -> float:
        """Return by how many degrees rounding the coefficients has moved the phase margin."""
        return _loss(self.design, self.quantised)

    @property
    def sha256(self) -> str:
        """Return the hash of plant, design and coefficients."""
        plant, law = self.design.plant, self.design.controller
        parts: list[object] = [self.name, self.number, self.realisation, self.features, self.format]
        parts += [_hexes(a) for a in (plant.num, plant.den, (plant.dead_time, plant.sensor))]
        parts += [_hexes(a) for a in (law.num_w, law.den_w, (law.dt, self.design.compute_delay))]
        parts += [(c.name, _hexes((c.value,)), c.point) for c in self.coefficients]
        return sha256(repr(parts).encode()).hexdigest()


def plan(
    verified: Verified, *, name: str = "controller", number: str = "f32",
    u_min: float | None = None, u_max: float | None = None, rate: float | None = None,
    anti_windup: str = "auto", setpoint_weight: float = 1.0, derivative_weight: float = 1.0,
    y_range: tuple[float, float] | None = None, u_range: tuple[float, float] | None = None,
    realisation: str = "auto", pm_loss_deg: float = 0.1,
) -> Plan:  # fmt: skip
    """Return the plan of a verified controller's firmware.

    number             f32, f64, q31, q15; "auto" is the first of q15, q31, f32, f64 that moves
                       the phase margin by pm_loss_deg or less
    u_min, u_max       limits of the output, in its units; rate the most it moves, in units/s
    anti_windup        conditional (an integral's default), back_calculation, tracking or none;
                       sections have tracking or none
    setpoint_weight, derivative_weight   shares of the reference, 0 to 1, in the proportional part
                       and in the derivative; of the parallel form alone
    y_range, u_range   what the numbers of q15 and q31 have to span, in the units that the
                       controller compares and in those of u; u_range is the limits if left out
    realisation        pid, cascade, delta; "auto" takes the one that costs the least phase margin

    Raises SpecError for a request that is malformed, a value that no word of the format holds or a
    gain that vanishes in it; NotMet where the rounded controller misses what the design met.

    >>> import zoh
    >>> arm = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> made = plan(zoh.pid(arm, dt=0.1, wc=1.95, pm_deg=40, ki=0.85), u_min=-12, u_max=12)
    >>> made.realisation, made.pm_loss_deg < 1e-5
    ('pid', True)
    """
    request = asked(
        verified, name=name, number=number, u_min=u_min, u_max=u_max, rate=rate,
        anti_windup=anti_windup, setpoint_weight=setpoint_weight,
        derivative_weight=derivative_weight, y_range=y_range, u_range=u_range,
        realisation=realisation,
    )  # fmt: skip
    most = checks.positive("pm_loss_deg", pm_loss_deg, "give degrees")
    if request.number != "auto":
        return _planned(request, request.number)
    passed_over: list[str] = []
    for one in NUMBERS:
        try:
            found = _planned(request, one, tuple(passed_over))
        except ZohError as refused:
            passed_over.append(f"not {one}: {refused}")
            continue
        if found.pm_loss_deg <= most:
            return found
        passed_over.append(f"not {one}: it moves the phase margin by {found.pm_loss_deg:.3g} deg")
    way_out = f"allow more, or see why: {'; '.join(passed_over)}"
    raise SpecError("pm_loss_deg", "must be what some format keeps", most, way_out)


def _planned(request: Asked, number: Number, before: tuple[str, ...] = ()) -> Plan:
    """Return the plan in one number format, with the realisation that loses the least."""
    made: list[Plan] = []
    refused: list[tuple[str, ZohError]] = []
    for name, steps in _candidates(request, number).items():
        try:
            made.append(_built(request, name, steps(), before))
        except ZohError as error:
            refused.append((name, error))
    if not made:
        raise refused[0][1]
    least = min(p.pm_loss_deg for p in made)
    chosen = next(p for p in made if p.pm_loss_deg <= least + _SAME_DEG)
    losses = [f"{p.realisation} {p.pm_loss_deg:.2g} deg" for p in made]
    why = f"phase margin lost by rounding: {', '.join(losses)}; built: {chosen.realisation}"
    others = [f"not {name}: {error}" for name, error in refused]
    return _saying(chosen, (*before, why, *others, *_windup(chosen)))


def _saying(plan_: Plan, said: tuple[str, ...]) -> Plan:
    fields = {f: getattr(plan_, f) for f in Plan.__slots__}
    return Plan(**{**fields, "said": said})


def _candidates(request: Asked, number: Number) -> dict[str, Callable[[], Step]]:
    """Return what makes each realisation's step, by name."""
    law = parallel(request.verified.controller)
    found: dict[str, Callable[[], Step]] = {}
    if request.realisation in ("auto", "pid"):
        if law is not None:
            found["pid"] = partial(_pid, request, number, law)
        elif request.realisation == "pid":
            raise SpecError(
                "realisation", "must fit the controller, and pid is P, I and one filtered part",
                "pid", "choose cascade or delta",
            )  # fmt: skip
    alone = law is not None and not (law.ki or law.kd) and request.realisation == "auto"
    if not request.needs_parallel and not alone:  # a gain alone has one form
        for name in ("cascade", "delta"):
            if request.realisation in ("auto", name):
                found[name] = partial(_cascade, request, number, name == "delta")
    if not found:
        raise SpecError(
            request.needs_parallel, "must be left out for a controller in sections",
            request.verified.law, "it belongs to the parallel form: P, I and one filtered part",
        )  # fmt: skip
    return found


def _pid(request: Asked, number: Number, law: Parallel) -> PidStep:
    format_ = request.format(number)
    features = request.features(format_, integral=bool(law.ki), sections=False, back=_back(law))
    start = format_.word - 2 if format_.whole else 0
    return PidStep(
        law=law, features=features, format=format_, points=dict.fromkeys(GROUPS, start)
    )  # fmt: skip


def _cascade(request: Asked, number: Number, delta: bool) -> CascadeStep:
    format_ = request.format(number)
    parts = sections(request.verified.controller)
    if any(p.a[p.order - 1] == 0 for p in parts[:-1]):
        raise SpecError(
            "controller",
            "must have two integrators at most",
            len(parts),
            "there is no use for more",
        )
    if format_.whole:
        parts = levelled(parts)
    start = format_.word - 2 if format_.whole else 0
    return CascadeStep(
        sections=parts, format=format_, delta=delta,
        features=request.features(format_, integral=False, sections=True, back=Fraction(1)),
        points={f"section{i}": start for i in range(1, len(parts) + 1)},
    )  # fmt: skip


def _back(law: Parallel) -> Fraction:
    """Return dt/Tt, Tt = sqrt(Ti Td) or Ti without a derivative; 1 at most.

    Source: K. J. Astrom and T. Hagglund, Advanced PID Control, sec. 3.5.
    """
    kp = law.kp - law.ki / 2
    if kp <= 0 or law.ki <= 0:
        return Fraction(1)
    ti = float(kp / law.ki)
    td = float(law.kd / (law.alpha * kp)) if law.kd > 0 else 0.0
    return min(Fraction(1), Fraction(1 / (sqrt(ti * td) if td else ti)))


def _built(request: Asked, realisation: str, step: Step, before: tuple[str, ...]) -> Plan:
    """Return the plan of a step, its binary points found, its controller verified again."""
    step, program, ranges = _fitted(step, request)
    design = request.verified
    num, den = step.realised(program)
    try:
        quantised = verify(
            design.plant, from_d(num, den, design.dt), compute_delay=design.compute_delay,
            requirements=request.eased, reference=design.reference, law=design.law,
            gains=design.gains, name=design.name,
        )  # fmt: skip
    except NotMet as missed:
        told = tuple(f"rounded to {step.format.number}: {m}" for m in missed.misses)
        raise NotMet(told, missed.measured) from None
    return Plan(
        name=request.name, number=step.format.number, realisation=realisation, dt=design.dt,
        design=design, quantised=quantised, program=program, ranges=ranges,
        features=step.features, format=step.format, said=before,
    )  # fmt: skip


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


def _loss(design: Verified, quantised: Verified) -> float:
    a, b = design.margins.phase_margin_deg, quantised.margins.phase_margin_deg
    return 0.0 if a == b else abs(a - b)


def _windup(made: Plan) -> tuple[str, ...]:
    how, limited = made.features.anti_windup, made.features.limited
    if how == "tracking" and made.realisation != "pid":
        return ("anti-windup: the last section is told the limited output",)
    if how == "none" and limited:
        return ("anti-windup: none",)
    return (f"anti-windup: {how}",) if limited else ()


def _hexes(values: tuple[float | int, ...]) -> list[str]:
    return [v.hex() if isinstance(v, float) else str(v) for v in values]
