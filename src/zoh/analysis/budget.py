"""Where the degrees went: the phase of a loop at its crossover, part by part.

The loop's phase at wc is a sum, and 180 deg plus that sum is the phase margin::

    PM = 180 + plant + dead time + sensor + hold + compute delay + remainder + controller

The hold alone turns by -wc dt/2, exactly, and the delays by wc times their length. The sampled
plant is more than the plant behind its hold: images of it around multiples of the sampling
frequency come through, and what they turn is the remainder. It is small where the plant falls
fast below Nyquist's frequency, and it is listed, not spread over the others.
The parts are angles of parts; the margin is measured on the loop as one. Nothing makes them
agree but arithmetic.
Source: K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed., sec. 7.4 and 8.2
(the hold as a delay of half a sample; aliasing of the sampled frequency response).
"""

from cmath import phase
from dataclasses import dataclass
from math import degrees, fsum
from typing import Any

from zoh import checks
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.sections import Section, sections
from zoh.analysis.tabled.margins import table_margins
from zoh.errors import SpecError
from zoh.lti import poly
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.systems import Plant, Sampled
from zoh.lti.wplane import warp
from zoh.sampling.hold import sample

_TURN = 360.0
_SURE_DEG = 1e-10  # a tenth of what the sum is promised to; roots that lie close lose more


@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """The phase margin of a loop and its parts.

    wc                rad/s, the crossover whose margin is nearest to 0
    phase_margin_deg  deg, measured on the loop as a whole
    items             each part's name and its deg; 180 and all of them make up the margin
    """

    wc: float
    phase_margin_deg: float
    items: tuple[Section, ...]

    @property
    def total_deg(self) -> float:
        """Return 180 deg and all items, which is the margin within 1e-9 deg."""
        return fsum([180.0, *(item.deg for item in self.items)])

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        return {
            "wc": self.wc,
            "phase_margin_deg": self.phase_margin_deg,
            "items": [{"name": item.name, "deg": item.deg} for item in self.items],
        }

    def report(self) -> str:
        """Return the budget as lines of text, one for each part."""
        rows = [(item.name, item.deg) for item in self.items]
        rows = [("at -180 deg the margin would be 0", 180.0), *rows]
        rows.append((f"phase margin at {self.wc:.6g} rad/s", self.phase_margin_deg))
        width = max(len(name) for name, _ in rows)
        lines = [f"{name:<{width}}  {deg + 0.0:+10.4f} deg" for name, deg in rows]
        return "\n".join([*lines[:-1], "-" * (width + 16), lines[-1]])


def budget(
    plant: Plant | Sampled | FrequencyResponse, controller: Sampled, *, compute_delay: float = 0.0
) -> Budget:
    """Return the phase budget of plant and controller at the crossover of the smallest margin.

    compute_delay  s, from sampling to output, 0 or more

    Of a plant that comes sampled, as a ``Sampled`` or as a table of one, the hold and the dead
    time cannot be told apart: it is one item, and compute_delay must be 0. A continuous table is
    split as a plant is, its dead time left in it.
    The controller's sections are in the w-plane, where an integrator turns by -90 deg; one whose
    roots lie too close to be told apart to 1e-10 deg is one item. Phases run on from zero frequency
    without a jump, so a loop that has gone round has whole turns among its items.
    Raises SpecError for what is no plant, and where the gain of the loop is never 1.

    >>> from math import pi
    >>> b = budget(Plant(num=[1], den=[1, 0]), Sampled(num=[2**0.5], den=[1], dt=1.0))
    >>> abs(b.wc - pi / 2) < 1e-15  # 1/(z - 1) at z = j: -135 deg
    True
    >>> {item.name: round(item.deg, 9) for item in b.items if abs(item.deg) > 1e-9}
    {'plant': -90.0, 'hold, wc dt/2': -45.0}
    """
    if not isinstance(controller, Sampled):
        raise SpecError("controller", "must be a zoh.Sampled", controller, "give num, den and dt")
    wait = checks.not_negative("compute_delay", compute_delay, "give seconds, 0 or more")
    sampled = _sampled(plant, controller.dt, wait)
    wc, margin = _crossover(sampled, controller)
    items = [*_plant_items(plant, sampled, wait, wc), *_controller_items(controller, wc)]
    turns = round((margin - fsum([180.0, *(i.deg for i in items)])) / _TURN)
    if turns:
        items.append(Section(name="whole turns", deg=turns * _TURN))
    return Budget(wc=wc, phase_margin_deg=margin, items=tuple(items))


def _sampled(
    plant: Plant | Sampled | FrequencyResponse, dt: float, wait: float
) -> Sampled | FrequencyResponse:
    """Return the plant as the controller sees it."""
    if isinstance(plant, Plant) or (isinstance(plant, FrequencyResponse) and plant.dt is None):
        return sample(plant, dt, wait)
    if not isinstance(plant, Sampled | FrequencyResponse):
        raise SpecError("plant", "must be a plant, a sampled one or a table", plant, "zoh.Plant")
    if plant.dt != dt:
        raise SpecError("dt", f"must be the plant's {plant.dt!r} s", dt, "use one clock")
    if wait:
        way_out = "leave it out"
        raise SpecError("compute_delay", "must be 0: a sampled plant has its delay", wait, way_out)
    return plant


def _crossover(sampled: Sampled | FrequencyResponse, controller: Sampled) -> tuple[float, float]:
    """Return the crossover in rad/s and its margin in deg, measured on the loop."""
    if isinstance(sampled, Sampled):
        m = measure_loop(Loop.of(controller, sampled))
    else:
        m = table_margins(controller * sampled)
    if m.crossover is None:
        way_out = "a loop without a crossover has no phase margin to account for"
        raise SpecError("controller", "must make the loop's gain 1 somewhere", controller, way_out)
    return m.crossover, m.phase_margin_deg


def _plant_items(
    plant: Plant | Sampled | FrequencyResponse, sampled: Sampled | FrequencyResponse,
    wait: float, wc: float,
) -> list[Section]:  # fmt: skip
    """Return what plant, sensor, delays, hold and images turn the phase by at wc."""
    whole = degrees(phase(sampled.at(wc)))
    if plant is sampled:
        return [Section(name="plant, hold and delays, as sampled", deg=whole)]
    found = _own_items(plant, wc)
    found.append(Section(name="hold, wc dt/2", deg=-degrees(wc * _clock(sampled) / 2)))
    found.append(Section(name="compute delay", deg=-degrees(wc * wait)))
    rest = _wrapped(whole - fsum(item.deg for item in found))
    return [*found, Section(name="sampling's remainder (images)", deg=rest)]


def _own_items(plant: Plant | Sampled | FrequencyResponse, wc: float) -> list[Section]:
    """Return what the plant itself turns the phase by, before anybody samples it."""
    if not isinstance(plant, Plant):
        return [Section(name="plant, as tabled", deg=degrees(phase(plant.at(wc))))]
    s = 1j * wc
    bare = degrees(phase(poly.at(plant.num, s) * poly.at(plant.den, s).conjugate()))
    run = fsum(part.deg for part in sections(plant.num, plant.den, wc))
    return [
        Section(name="plant", deg=bare + _TURN * round((run - bare) / _TURN)),
        Section(name="dead time", deg=-degrees(wc * plant.dead_time)),
        Section(name="sensor", deg=-180.0 if plant.sensor < 0 else 0.0),
    ]


def _controller_items(controller: Sampled, wc: float) -> list[Section]:
    """Return what each section of the controller turns the phase by at wc."""
    v = warp(wc, controller.dt)
    found = list(sections(controller.num_w, controller.den_w, v))
    if controller.delay:
        late = -degrees(wc * controller.dt * controller.delay)
        found.append(Section(name=f"delay of {controller.delay} samples", deg=late))
    whole = degrees(phase(controller.at(wc)))
    if abs(_wrapped(whole - fsum(part.deg for part in found))) > _SURE_DEG:
        found = [Section(name="in one piece", deg=whole)]
    return [Section(name=f"controller: {part.name}", deg=part.deg) for part in found]


def _clock(sampled: Sampled | FrequencyResponse) -> float:
    """Return the sample time in s, which what was sampled has."""
    return sampled.dt or 0.0


def _wrapped(deg: float) -> float:
    """Return an angle in [-180, 180] deg."""
    return deg - _TURN * round(deg / _TURN)
