"""From a verified controller to what is built: number format, realisation, limits, all of it said.

The coefficients are rounded, the controller that they really make is put together exactly, and it
is verified again in the loop that the design was verified in. A word that a value does not fit, a
gain that vanishes, a loop that rounding has taken beyond what was asked is an error here, never
a surprise on a board.
"""

from dataclasses import dataclass
from hashlib import sha256
from math import floor

from zoh import checks
from zoh.errors import NotMet, SpecError, ZohError
from zoh.firmware.asked import Asked, Design, asked
from zoh.firmware.book import Features, Format
from zoh.firmware.build import Built, built, candidates, controller_of
from zoh.firmware.lines import NUMBERS, Coefficient, Number, Program
from zoh.firmware.ranges import Ranges
from zoh.lti.frequency_response import FrequencyResponse

_LOST_PCT = 1.0  # of a rate: more that whole steps take from it is said
_SAME_DEG = 0.01  # losses this near to each other do not decide between realisations


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """One controller as it is built; lines that are not what was verified make none.

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
    y_range      the ends of what is measured, as they were asked for; None where they were not
    said         why it is as it is, one sentence each
    """

    name: str
    number: Number
    realisation: str
    dt: float
    design: Design
    quantised: Design
    program: Program
    ranges: Ranges | None
    features: Features
    format: Format
    y_range: tuple[float, float] | None
    said: tuple[str, ...]

    def __post_init__(self) -> None:
        made = controller_of(self.program, self.format, self.dt)
        if made != self.quantised.controller:
            way_out = "zoh.plan(...) makes the two together"
            raise SpecError("program", "must be the controller verified", made, way_out)

    @property
    def coefficients(self) -> tuple[Coefficient, ...]:
        """Return every constant, exactly as the C has it."""
        return self.program.coefficients

    @property
    def holds_u(self) -> bool:
        """Return whether ``track`` can hold any output: all but parallel forms without integral."""
        return _holds_u(self.realisation, self.program)

    @property
    def pm_loss_deg(self) -> float:
        """Return by how many degrees rounding the coefficients has moved the phase margin."""
        a, b = self.design.margins.phase_margin_deg, self.quantised.margins.phase_margin_deg
        return 0.0 if a == b else abs(a - b)

    @property
    def sha256(self) -> str:
        """Return the hash of plant, design and coefficients."""
        law = self.design.controller
        parts: list[object] = [self.name, self.number, self.realisation, self.features, self.format]
        parts += _plant_of(self.design)
        parts += [_hexes(a) for a in (law.num_w, law.den_w, (law.dt, self.design.compute_delay))]
        parts += [(c.name, _hexes((c.value,)), c.point) for c in self.coefficients]
        return sha256(repr(parts).encode()).hexdigest()


def plan(
    verified: Design, *, name: str = "controller", number: str = "f32",
    u_min: float | None = None, u_max: float | None = None, rate: float | None = None,
    anti_windup: str = "auto", setpoint_weight: float | None = None,
    derivative_weight: float | None = None,
    y_range: tuple[float, float] | None = None, u_range: tuple[float, float] | None = None,
    realisation: str = "auto", pm_loss_deg: float = 0.1,
) -> Plan:  # fmt: skip
    """Return the plan of a verified controller's firmware.

    number             f32, f64, q31, q15; "auto" is the first of q15, q31, f32, f64 that will do
    pm_loss_deg        the most that rounding the coefficients may move the phase margin by
    u_min, u_max       limits of the output, in its units; rate the most it moves, in units/s
    anti_windup        conditional (an integral's default), back_calculation, tracking or none;
                       sections have tracking or none
    setpoint_weight, derivative_weight   shares of the reference, 0 to 1, in the proportional part
                       and in the derivative, of the parallel form alone; the design's own where
                       they are left out
    y_range, u_range   what the numbers of q15 and q31 have to span, in the units that the
                       controller compares and in those of u; u_range is the limits if left out
    realisation        pid, cascade, delta; "auto" takes the one that costs the least phase margin

    Raises SpecError for a request that is malformed, a value that no word of the format holds or a
    gain that vanishes in it; NotMet where the rounded controller misses what the design met, or
    moves its phase margin by more than pm_loss_deg.

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
        return _planned(request, request.number, most)
    passed_over: list[str] = []
    lost = False
    for one in NUMBERS:
        try:
            return _planned(request, one, most, tuple(passed_over))
        except NotMet as refused:
            lost = True
            passed_over.append(f"not {one}: {'; '.join(refused.misses)}")
        except ZohError as refused:
            passed_over.append(f"not {one}: {refused}")
    why = "; ".join(passed_over)
    if not lost:
        raise SpecError("number", "must be one that takes this controller", "auto", why)
    way_out = f"allow more, or see why: {why}"
    raise SpecError("pm_loss_deg", "must be what some format keeps", most, way_out)


def _planned(request: Asked, number: Number, most: float, before: tuple[str, ...] = ()) -> Plan:
    """Return the plan in one number format, with the realisation that loses the least."""
    made: list[Built] = []
    refused: list[tuple[str, ZohError]] = []
    for name, begun in candidates(request, number).items():
        try:
            made.append(_kept(built(request, name, begun()), most))
        except ZohError as error:
            refused.append((name, error))
    if not made:
        raise refused[0][1]
    least = min(b.pm_loss_deg for b in made)
    chosen = next(b for b in made if b.pm_loss_deg <= least + _SAME_DEG)
    losses = [f"{b.realisation} {b.pm_loss_deg:.2g} deg" for b in made]
    why = f"phase margin lost by rounding: {', '.join(losses)}; built: {chosen.realisation}"
    others = [f"not {name}: {error}" for name, error in refused]
    step = chosen.step
    return Plan(
        name=request.name, number=number, realisation=chosen.realisation, dt=chosen.design.dt,
        design=chosen.design, quantised=chosen.quantised, program=chosen.program,
        ranges=chosen.ranges, features=step.features, format=step.format, y_range=request.y_range,
        said=(
            *before, why, *others, *_windup(chosen, request), *_handed_over(chosen),
            *_slower(chosen), *_inside(chosen, request),
        ),
    )  # fmt: skip


def _kept(found: Built, most: float) -> Built:
    """Return what was built; raise NotMet where it has lost more phase margin than is allowed."""
    if found.pm_loss_deg > most:
        number, lost = found.step.format.number, found.pm_loss_deg
        miss = f"rounded to {number} the phase margin moves by {lost:.3g} deg, above {most:g}"
        raise NotMet((miss,), found.quantised)
    return found


def _windup(made: Built, request: Asked) -> tuple[str, ...]:
    how, wanted = made.step.features.anti_windup, request.anti_windup
    if not made.step.features.limited:
        return ("anti-windup: none, for nothing limits u",)
    if how == "none" and wanted != "none":
        asked_for = "" if wanted == "auto" else f" ({wanted} was asked for)"
        return (f"anti-windup: none, for no state of this form hears of a limit{asked_for}",)
    if how == "tracking" and made.realisation != "pid":
        return ("anti-windup: the last section is told the limited output",)
    return (f"anti-windup: {how}",)


def _holds_u(realisation: str, program: Program) -> bool:
    return realisation != "pid" or any(s.name == "x" for s in program.states)


def _handed_over(made: Built) -> tuple[str, ...]:
    """Return that a law in parallel form that does not integrate cannot hold an output."""
    if _holds_u(made.realisation, made.program):
        return ()
    return ("track: has no integral that could hold u_manual; the step that follows may jump",)


def _slower(made: Built) -> tuple[str, ...]:
    """Return by how much a rate in whole steps is less than the one asked for, where it matters."""
    form, change = made.step.format, made.step.features.change
    if change is None or not form.whole:
        return ()
    steps = floor(change / form.u_unit)
    lost = float(100 * (1 - steps * form.u_unit / change))
    said = f"rate: {steps} steps a sample, {lost:.2g} % less than asked"
    return (said,) if lost > _LOST_PCT else ()


def _inside(made: Built, request: Asked) -> tuple[str, ...]:
    """Return by how much limits in whole steps are inside those asked for, where it matters."""
    said = []
    for name in ("u_min", "u_max") if made.step.format.whole else ():
        bound = getattr(request, name)
        steps = made.program.value(name)
        held = float(steps * made.step.format.u_unit)
        if bound and abs(held - bound) > _LOST_PCT / 100 * abs(bound):
            lost = 100 * (1 - held / bound)
            said.append(f"{name}: {steps} steps, {held:.6g}, {lost:.2g} % inside what was asked")
    return tuple(said)


def _plant_of(design: Design) -> list[object]:
    """Return what tells one plant from another."""
    plant = design.plant
    if isinstance(plant, FrequencyResponse):
        columns = (plant.w, plant.magnitude, plant.phase_deg)
        return [sha256(a.astype("<f8").tobytes()).hexdigest() for a in columns]
    return [_hexes(a) for a in (plant.num, plant.den, (plant.dead_time, plant.sensor))]


def _hexes(values: tuple[float | int, ...]) -> list[str]:
    return [v.hex() if isinstance(v, float) else str(v) for v in values]
