"""The [plant] of a project file: five ways to say a model, one at a time; a table is a sixth."""

from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any

from zoh import checks
from zoh.app.measured import KEYS as TABLE_KEYS
from zoh.app.toml import Section, within
from zoh.batch.sources import Geared, Roots, Source
from zoh.errors import SpecError
from zoh.lti.joint import OUTPUTS, Joint
from zoh.lti.systems import Plant

FORMS = {
    "model": ("model",),
    "num": ("num", "den"),
    "zeros": ("zeros", "poles", "gain"),
    "A": ("A", "B", "C", "D"),
    "joint": ("joint",),
    "frequency_response": TABLE_KEYS,
}
_OPTIONAL = ("zeros", "D", *TABLE_KEYS)
_WAYS = "model | num, den | zeros, poles, gain | A, B, C, D | [plant.joint] | frequency_response"
KEYS = (
    *(key for keys in FORMS.values() for key in keys),
    "input_unit",
    "output_unit",
    "dead_time",
)


def is_table(section: Section) -> bool:
    """Return whether the plant is a table; raise SpecError where it is a model, too."""
    return TABLE_KEYS[0] in section.data and _form(section) == TABLE_KEYS[0]


def read_source(section: Section, sensor: float) -> Source:
    """Return the plant as the section says it, with the sensor's gain in its one place."""
    section.only(KEYS)
    form = _form(section)
    dead_time = section.number("dead_time") or 0.0
    with within(section.path):
        return _READERS[form](section, dead_time, sensor)


def output_unit(section: Section) -> str:
    """Return the unit of the plant's output, empty where nobody says it."""
    said = section.text("output_unit")
    if "joint" not in section.data:
        return said or ""
    made = section.section("joint").text("output") or OUTPUTS[0]
    if said not in (None, made):
        raise SpecError(
            f"{section.path}output_unit",
            f"must be that of the joint, {made!r}",
            said,
            "choose it by joint.output and leave this key out",
        )
    return made


def _form(section: Section) -> str:
    """Return the one form that is given, complete."""
    given = {
        form: next(key for key in keys if key in section.data)
        for form, keys in FORMS.items()
        if any(key in section.data for key in keys)
    }
    if not given:
        raise section.missing("model", f"say the plant in one way: {_WAYS}")
    if len(given) > 1:
        first, second = list(given.values())[:2]
        raise SpecError(
            f"{section.path}{second}",
            f"must not stand beside {first}",
            section.data[second],
            f"say the plant in one way: {_WAYS}",
        )
    form = next(iter(given))
    for key in FORMS[form]:
        if key not in section.data and key not in _OPTIONAL:
            raise section.missing(key, f"it belongs to {', '.join(FORMS[form])}")
    return form


def _from_model(section: Section, dead_time: float, sensor: float) -> Plant:
    return Plant.parse(section.data["model"], dead_time=dead_time, sensor=sensor)


def _from_coefficients(section: Section, dead_time: float, sensor: float) -> Plant:
    num, den = section.data["num"], section.data["den"]
    return Plant(num=num, den=den, dead_time=dead_time, sensor=sensor)


def _from_roots(section: Section, dead_time: float, sensor: float) -> Roots:
    return Roots(
        zeros=_roots("zeros", section.data.get("zeros", [])),
        poles=_roots("poles", section.data["poles"]),
        gain=section.data["gain"],
        dead_time=dead_time,
        sensor=sensor,
    )


def _from_matrices(section: Section, dead_time: float, sensor: float) -> Plant:
    a, b, c, d = (_matrix(key, section.data.get(key, 0.0)) for key in FORMS["A"])
    return Plant.ss(a, b, c, d, dead_time=dead_time, sensor=sensor)


def _from_joint(section: Section, dead_time: float, sensor: float) -> Geared:
    constants = Section(
        path="joint.", data=Section(path="", data=section.data).section("joint").data
    )
    constants.only(field.name for field in fields(Joint))
    for name in ("torque_constant", "resistance"):
        if name not in constants.data:
            raise constants.missing(name, "take it from the motor's data sheet")
    with within(constants.path):
        return Geared(joint=Joint(**constants.data), dead_time=dead_time, sensor=sensor)


_READERS: dict[str, Callable[[Section, float, float], Source]] = {
    "model": _from_model,
    "num": _from_coefficients,
    "zeros": _from_roots,
    "A": _from_matrices,
    "joint": _from_joint,
}


def _roots(name: str, value: Any) -> Sequence[complex]:
    """Return roots given as numbers, [re, im] pairs or texts such as "-1+2j"."""
    if not isinstance(value, list):
        raise SpecError(name, "must be a list of roots", value, 'such as [-1, [-2, 3], "-2-3j"]')
    return [_root(f"{name}[{i}]", x) for i, x in enumerate(value)]


def _root(name: str, value: Any) -> complex:
    if isinstance(value, str):
        try:
            return complex("".join(value.split()))
        except ValueError:
            raise SpecError(name, "must be a number", value, 'such as "-1+2j"') from None
    if isinstance(value, list):
        if len(value) != 2:
            raise SpecError(name, "must be a pair [re, im]", value, "such as [-1, 2]")
        return complex(*(checks.number(name, x) for x in value))
    return complex(checks.number(name, value))


def _matrix(name: str, value: Any) -> Any:
    """Return a number, a list of numbers or a list of rows; NumPy would take a bool or a text."""
    if not isinstance(value, list):
        return checks.number(name, value, "give a list of rows")
    if len({isinstance(x, list) for x in value}) > 1 or not value:
        raise SpecError(name, "must be a list of rows", value, "such as [[0, 1], [-2, -3]]")
    if len({len(x) for x in value if isinstance(x, list)}) > 1:
        raise SpecError(name, "must have rows of one length", value, "complete the short ones")
    return [_matrix(f"{name}[{i}]", x) for i, x in enumerate(value)]
