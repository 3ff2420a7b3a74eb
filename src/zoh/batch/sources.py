"""Where a plant that varies comes from: its coefficients, its roots, or a joint's data sheet.

Each of the three names the numbers it is made of, so that a number can be replaced where it
stands and the rest stays exact:

    Plant    plant.gain, plant.num.i, plant.den.i   coefficients in descending powers of s
    Roots    plant.gain, plant.zero.i, plant.pole.i real roots in rad/s, counted from 0
    Geared   plant.joint.NAME                       the constants of ``Joint``, in SI units

``plant.gain`` is num[0]/den[0] of the transfer function, whichever way it is written.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from math import degrees
from typing import Any

import numpy as np
import numpy.typing as npt

from zoh.errors import SpecError
from zoh.lti import digits
from zoh.lti.given import paired
from zoh.lti.joint import Joint, joint_plant, possible
from zoh.lti.systems import Plant

FloatArray = npt.NDArray[np.float64]

GAIN = "plant.gain"


@dataclass(frozen=True, slots=True, kw_only=True)
class Roots:
    """gain prod(s - zeros)/prod(s - poles), kept as its roots so that one of them can vary.

    zeros, poles  rad/s, complex ones in conjugate pairs;  dead_time  s;  sensor  as in ``Plant``

    >>> Roots(zeros=[], poles=[0, -0.7809], gain=2.3).plant().den
    (1.0, 0.7809, 0.0)
    """

    zeros: Sequence[complex]
    poles: Sequence[complex]
    gain: float
    dead_time: float = 0.0
    sensor: float = 1.0

    def __post_init__(self) -> None:
        for name in ("zeros", "poles"):
            object.__setattr__(self, name, tuple(paired(name, getattr(self, name))))
        self.plant()  # refuses what is no plant

    def plant(self) -> Plant:
        """Return the plant, exactly."""
        return Plant.zpk(
            zeros=self.zeros, poles=self.poles, gain=self.gain, dead_time=self.dead_time,
            sensor=self.sensor,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Geared:
    """A joint from its data sheet, kept as its constants.

    dead_time in s and sensor are as in ``Plant``.
    """

    joint: Joint
    dead_time: float = 0.0
    sensor: float = 1.0

    def plant(self) -> Plant:
        """Return the plant, exactly."""
        return joint_plant(self.joint, dead_time=self.dead_time, sensor=self.sensor)


Source = Plant | Roots | Geared


def nominal(source: Source) -> dict[str, float]:
    """Return every number that can vary, by its key, as it stands.

    >>> nominal(Plant(num=[2.3], den=[1, 0.5, 0]))
    {'plant.gain': 2.3, 'plant.num.0': 2.3, 'plant.den.0': 1.0, 'plant.den.1': 0.5,
     'plant.den.2': 0.0}
    """
    if isinstance(source, Geared):
        found = {f.name: getattr(source.joint, f.name) for f in fields(Joint)}
        found["back_emf"] = source.joint.torque_constant if (e := found["back_emf"]) is None else e
        return {f"plant.joint.{name}": v for name, v in found.items() if name != "output"}
    if isinstance(source, Roots):
        named = [("zero", source.zeros), ("pole", source.poles)]
        real = {f"plant.{n}.{i}": r.real for n, all_ in named for i, r in enumerate(all_)
                if not r.imag}  # fmt: skip
        return {GAIN: source.gain, **real}
    listed = [("num", source.num), ("den", source.den)]
    entries = {f"plant.{name}.{i}": c for name, a in listed for i, c in enumerate(a)}
    return {GAIN: source.num[0] / source.den[0], **entries}


def plant_of(source: Source, changes: Mapping[str, float], dead_time: float) -> Plant:
    """Return the plant with these numbers replaced; what stands is kept with all its digits."""
    if isinstance(source, Geared):
        changed: dict[str, Any] = {k.removeprefix("plant.joint."): v for k, v in changes.items()}
        return replace(source, joint=replace(source.joint, **changed), dead_time=dead_time).plant()
    if isinstance(source, Roots):
        zeros, poles = (
            [changes.get(f"plant.{name}.{i}", r) for i, r in enumerate(roots)]
            for name, roots in (("zero", source.zeros), ("pole", source.poles))
        )
        return Plant.zpk(
            zeros=zeros, poles=poles, gain=changes.get(GAIN, source.gain), dead_time=dead_time,
            sensor=source.sensor,
        )  # fmt: skip
    num, den = (
        [digits.exact([changes[key]])[0] if (key := f"plant.{name}.{i}") in changes else c
         for i, c in enumerate(a)]
        for name, a in zip(("num", "den"), source.exact, strict=True)
    )  # fmt: skip
    if GAIN in changes:
        with digits.precision(digits.KEPT):
            factor = digits.exact([changes[GAIN]])[0] * den[0] / num[0]
            num = [factor * c for c in num]
    return Plant.from_exact(
        tuple(num), tuple(den), dead_time=dead_time, sensor=source.sensor
    )  # fmt: skip


def nominal_plant(source: Source) -> Plant:
    """Return the plant as it stands, exactly."""
    return source if isinstance(source, Plant) else source.plant()


def coefficients(
    source: Source, columns: Mapping[str, FloatArray], n: int
) -> tuple[FloatArray, FloatArray]:
    """Return num and den of n plants in floats, shapes (m + 1, n) and (d + 1, n).

    Descending powers of s, without the sensor; ``columns`` are what varies of the plant. They are
    those of ``plant_of`` but for a few roundings; num is NaN where a joint is out of its bounds.
    """
    if isinstance(source, Geared):
        return _of_joint(source, columns, n)
    if isinstance(source, Roots):
        gain = columns.get(GAIN, np.full(n, source.gain))
        num, den = (
            _product(roots, [columns.get(f"plant.{name}.{i}") for i in range(len(roots))], n)
            for name, roots in (("zero", source.zeros), ("pole", source.poles))
        )
        return num * gain, den
    num, den = (
        np.array([columns.get(f"plant.{name}.{i}", np.full(n, c)) for i, c in enumerate(a)])
        for name, a in (("num", source.num), ("den", source.den))
    )
    if GAIN in columns:
        num = num * (columns[GAIN] * den[0] / num[0])
    return num, den


def _product(roots: Sequence[complex], varying: Sequence[FloatArray | None], n: int) -> FloatArray:
    """Return prod(s - root): what stands multiplied exactly, what varies in floats after it."""
    fixed = [r for r, column in zip(roots, varying, strict=True) if column is None]
    start = digits.rounded(digits.from_roots(fixed))
    found = np.repeat(np.array(start)[:, None], n, axis=1)
    for column in varying:
        if column is not None:
            found = np.vstack([found, np.zeros(n)]) - np.vstack([np.zeros(n), found * column])
    return found


def _of_joint(
    source: Geared, columns: Mapping[str, FloatArray], n: int
) -> tuple[FloatArray, FloatArray]:
    """Return what ``joint_plant`` does, n times in floats: every sum is of positive numbers."""
    at = {key.removeprefix("plant.joint."): v for key, v in nominal(source).items()}
    c = {name: columns.get(f"plant.joint.{name}", np.full(n, v)) for name, v in at.items()}
    if "plant.joint.back_emf" not in columns and source.joint.back_emf is None:
        c["back_emf"] = c["torque_constant"]
    turns = c["gear_ratio"]
    j = c["motor_inertia"] + c["load_inertia"] / turns**2
    b = c["motor_damping"] + c["load_damping"] / turns**2
    den = [
        c["inductance"] * j,
        c["inductance"] * b + c["resistance"] * j,
        c["resistance"] * b + c["torque_constant"] * c["back_emf"],
    ]
    if not np.any(den[0]):
        del den[0]
    if not source.joint.output.endswith("/s"):
        den.append(np.zeros(n))
    unit = degrees(1) if source.joint.output.startswith("deg") else 1.0
    num = np.where(possible(c), c["torque_constant"] * unit / turns, np.nan)
    return num[None], np.array(den)


def checked(source: object) -> Source:
    """Return the source as it is; raise SpecError unless it is one of the three."""
    if not isinstance(source, Plant | Roots | Geared):
        way_out = "give a zoh.Plant, a zoh.Roots or a zoh.Geared; a table does not vary"
        raise SpecError("plant", "must be a plant that can vary", source, way_out)
    return source


__all__ = [
    "FloatArray",
    "Geared",
    "Roots",
    "Source",
    "coefficients",
    "nominal",
    "nominal_plant",
    "plant_of",
]
