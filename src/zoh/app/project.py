"""The project file: a plant, its sensor, actuator and clock, and the controllers asked for.

Every key is checked, an unknown one is an error, and a message has the full name of its key.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields

from zoh import checks
from zoh.app.claims import CLAIMS, Claim
from zoh.app.kinds import KINDS
from zoh.app.measured import read_table
from zoh.app.plants import is_table, output_unit, read_source
from zoh.app.sections import read_sections
from zoh.app.toml import Literal, Section, tables, within
from zoh.batch.sources import Source, nominal_plant
from zoh.design.sections import SecondOrder
from zoh.errors import SpecError
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.parse import quotient
from zoh.lti.systems import Plant, Sampled
from zoh.request import AUTO, LAWS, OF_AUTO, OPTIONS, allowed, checked
from zoh.spec import Crossover, Requirements

SECTIONS = ("plant", "sensor", "actuator", "sampling", "controller", "requirements", "reference")
GIVEN = "given"
MOST_CONTROLLERS = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """A controller to be designed: its name, its law, and what the law is asked for (SI)."""

    name: str
    law: str
    parameters: Mapping[str, float]
    sections: tuple[SecondOrder, ...] = ()
    allow: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Given:
    """A controller from elsewhere, and what is claimed of it."""

    name: str
    controller: Sampled
    claims: tuple[Claim, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """Sensor units per output unit; bits over [low, high] in sensor units where it is digital."""

    gain: float = 1.0
    unit: str = ""
    bits: int | None = None
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Actuator:
    """The least and the largest input, in input units; None where there is no limit."""

    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Project:
    """A project file, checked.

    plant          with its dead time and its sensor's gain, a model or a table
    source         the model as the file says it, by coefficients, roots or a joint; None of a table
    dt             s, sample time
    compute_delay  s, from sampling to output
    controllers    in the order of the file
    reference      the step that responses are computed for
    input_unit, output_unit  for people; empty where the file does not say
    """

    plant: Plant | FrequencyResponse
    source: Source | None
    dt: float
    compute_delay: float
    controllers: tuple[Request | Given, ...]
    requirements: Requirements
    reference: float
    sensor: Sensor
    actuator: Actuator
    input_unit: str
    output_unit: str


def nothing_attached(name: str) -> str:
    """Refuse a file that a text names: there is no folder to look for it."""
    bound = "must not name a file where there is no folder"
    raise SpecError("plant.frequency_response", bound, name, "read the project from a file")


def read(text: str, attached: Callable[[str], str] = nothing_attached) -> Project:
    """Return the project that a TOML text describes; ``attached`` returns a file it names.

    >>> read("plant.model = '1/s'")
    Traceback (most recent call last):
    zoh.errors.SpecError: sampling.dt must be given, got nothing: the sample time in seconds
    """
    file = tables(text)
    file.only(SECTIONS)
    if "plant" not in file.data:
        raise file.missing("plant", 'write [plant] and model = "1/(s + 1)" below it')
    sensor = _sensor(file.section("sensor"))
    section = file.section("plant")
    source = None if is_table(section) else read_source(section, sensor.gain)
    dt, compute_delay = _sampling(file.section("sampling"))
    if source is None:
        plant: Plant | FrequencyResponse = read_table(
            section, sensor.gain, dt, compute_delay, attached
        )
    else:
        plant = nominal_plant(source)
    reference = file.section("reference")
    reference.only(["step"])
    step = reference.number("step")
    if step is not None and float(step) == 0.0:
        raise SpecError("reference.step", "must not be 0", step, "give the size of the step")
    return Project(
        plant=plant,
        source=source,
        dt=dt,
        compute_delay=compute_delay,
        controllers=_controllers(file, dt),
        requirements=_requirements(file.section("requirements")),
        reference=1.0 if step is None else float(step),
        sensor=sensor,
        actuator=_actuator(file.section("actuator")),
        input_unit=file.section("plant").text("input_unit") or "",
        output_unit=output_unit(file.section("plant")),
    )


def _sensor(section: Section) -> Sensor:
    section.only(["gain", "unit", "bits", "range"])
    gain = quotient(section.data.get("gain", 1.0), f"{section.path}gain")
    if gain == 0:
        raise SpecError("sensor.gain", "must not be 0", gain, "a loop needs a sensor")
    low, high = _range(section)
    bits = section.data.get("bits")
    if bits is not None and (type(bits) is not int or not 1 <= bits <= 32):
        way_out = "give the converter's resolution"
        raise SpecError("sensor.bits", "must be a whole number from 1 to 32", bits, way_out)
    if bits is not None and low is None:
        raise section.missing("range", "bits need the range [lo, hi] that they divide")
    return Sensor(gain=gain, unit=section.text("unit") or "", bits=bits, low=low, high=high)


def _range(section: Section) -> tuple[float | None, float | None]:
    if "range" not in section.data:
        return None, None
    ends, name = section.numbers("range"), f"{section.path}range"
    if len(ends) != 2 or not ends[0] < ends[1]:
        raise SpecError(name, "must be [lo, hi] with lo < hi", list(ends), "such as [0, 5]")
    return ends[0], ends[1]


def _actuator(section: Section) -> Actuator:
    section.only(["min", "max"])
    low, high = section.number("min"), section.number("max")
    if low is not None and high is not None and not low < high:
        raise SpecError("actuator.max", f"must be above min = {low!r}", high, "swap the two")
    return Actuator(low=low, high=high)


def _sampling(section: Section) -> tuple[float, float]:
    section.only(["dt", "compute_delay"])
    if "dt" not in section.data:
        raise section.missing("dt", "the sample time in seconds")
    dt = checks.positive("sampling.dt", section.data["dt"], "give the sample time in seconds")
    name, way_out = "sampling.compute_delay", "give the seconds from sampling to output"
    delay = checks.not_negative(name, section.data.get("compute_delay", 0.0), way_out)
    return dt, delay


def _requirements(section: Section) -> Requirements:
    names = [field.name for field in fields(Requirements)]
    section.only(names)
    found = {name: section.number(name) for name in names}
    with within(section.path):
        return Requirements(**{k: float(v) for k, v in found.items() if v is not None})


def _controllers(file: Section, dt: float) -> tuple[Request | Given, ...]:
    entries = file.data.get("controller")
    if not entries:
        raise file.missing("controller", "write [[controller]] and law = ... below it")
    if not isinstance(entries, list) or not all(isinstance(e, dict) for e in entries):
        raise SpecError("controller", "must be a list of tables", entries, "write [[controller]]")
    if len(entries) > MOST_CONTROLLERS:
        bound = f"must have {MOST_CONTROLLERS} entries or fewer"
        raise SpecError("controller", bound, len(entries), "use several files")
    made = [
        _controller(Section(path=f"controller[{i}].", data=e), dt) for i, e in enumerate(entries)
    ]
    names = [c.name for c in made]
    for i, name in enumerate(names):
        if name in names[:i]:
            way_out = "give each controller a name of its own"
            raise SpecError(f"controller[{i}].name", "must not be used twice", name, way_out)
    return tuple(made)


def _controller(entry: Section, dt: float) -> Request | Given:
    law = entry.data.get("law")
    known = [*LAWS, AUTO, GIVEN]
    if law is None:
        raise entry.missing("law", f"one of {', '.join(known)}")
    if not isinstance(law, str) or law not in known:
        raise SpecError(f"{entry.path}law", "must be a law", law, f"one of {', '.join(known)}")
    name = entry.text("name") or law
    named = Section(path=f'controller "{name}": ', data=entry.data)
    if law == GIVEN:
        return _given(named, name, dt)
    takes = LAWS.get(law, OF_AUTO) + OPTIONS.get(law, ())
    named.only(["name", "law", "sections", "allow", *takes])
    found = {key: named.number(key) for key in takes}
    parameters = {key: float(value) for key, value in found.items() if value is not None}
    _check_crossover(named, parameters, dt)
    sections = read_sections(named, dt)
    with within(named.path):
        allow = tuple(sorted(allowed(entry.data.get("allow", []))))
        parameters = checked(law, parameters, frozenset(allow))
    return Request(name=name, law=law, parameters=parameters, sections=sections, allow=allow)


def _check_crossover(entry: Section, parameters: Mapping[str, float], dt: float) -> None:
    """Refuse a crossover that no law could have; one that is left open is the law's to choose."""
    wc, pm_deg = parameters.get("wc", 1e-9 / dt), parameters.get("pm_deg", 45.0)
    with within(entry.path):
        Crossover(wc=wc, pm_deg=pm_deg).below_nyquist(dt)


def _given(entry: Section, name: str, dt: float) -> Given:
    entry.only(["name", "law", "num", "den", "claims"])
    for key in ("num", "den"):
        if key not in entry.data:
            raise entry.missing(key, "a list of coefficients in descending powers of z")
    with within(entry.path):
        controller = Sampled(num=entry.data["num"], den=entry.data["den"], dt=dt)
    return Given(name=name, controller=controller, claims=_claims(entry.section("claims")))


def _claims(section: Section) -> tuple[Claim, ...]:
    section.only(["kind", *CLAIMS])
    kind = section.text("kind")
    if kind is not None and kind not in KINDS:
        way_out = f"one of {', '.join(KINDS)}"
        raise SpecError(f"{section.path}kind", "must be a kind of controller", kind, way_out)
    claims = [] if kind is None else [Claim(key="kind", value=kind)]
    for key in CLAIMS:
        value: Literal | None = section.number(key)
        if value is not None:
            claims.append(Claim(key=key, value=value))
    return tuple(claims)
