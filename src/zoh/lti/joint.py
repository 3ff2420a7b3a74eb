"""A joint from its data sheet: DC motor, gear and load as one plant, volts in, motion out.

With the armature current i, the motor's speed W, and everything seen from the motor's side of
a gear of N motor turns for one turn of the load::

    (L s + R) i + Ke W = u           J = Jm + Jl/N^2
    (J s + b) W = Kt i               b = bm + bl/N^2

    W/u = Kt / ((L s + R)(J s + b) + Kt Ke)       load speed = W/N, load angle = W/(N s)

Source: M. W. Spong, S. Hutchinson and M. Vidyasagar, Robot Modeling and Control, the section
on actuator dynamics (permanent-magnet DC motor and gear train); without a gear it is the motor
of the Control Tutorials for MATLAB and Simulink, University of Michigan, "DC Motor Speed".
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from fractions import Fraction
from math import degrees
from typing import Any

import numpy as np
import numpy.typing as npt

from zoh import checks
from zoh.errors import SpecError
from zoh.lti import digits
from zoh.lti.systems import Plant

OUTPUTS = ("rad", "deg", "rad/s", "deg/s")
_ABOVE_ZERO = ("torque_constant", "resistance", "gear_ratio")


@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """The constants of a geared DC motor and its load; every number in SI units.

    torque_constant  N m/A, Kt, above 0
    resistance       ohm, R of the armature, above 0
    motor_inertia    kg m^2, Jm of the rotor
    load_inertia     kg m^2, Jl, behind the gear; Jm + Jl is above 0
    motor_damping    N m s/rad, bm, viscous, at the rotor
    load_damping     N m s/rad, bl, viscous, behind the gear
    back_emf         V s/rad, Ke; None means equal to Kt, as it is in SI units without loss
    inductance       H, L of the armature; 0 neglects it and lowers the order by one
    gear_ratio       motor turns for one turn of the load, above 0
    output           what is measured: the load's angle in "rad" or "deg", or its speed in
                     "rad/s" or "deg/s"
    """

    torque_constant: float
    resistance: float
    motor_inertia: float = 0.0
    load_inertia: float = 0.0
    motor_damping: float = 0.0
    load_damping: float = 0.0
    back_emf: float | None = None
    inductance: float = 0.0
    gear_ratio: float = 1.0
    output: str = "rad"

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "output" or (field.name == "back_emf" and value is None):
                continue
            check = checks.positive if field.name in _ABOVE_ZERO else checks.not_negative
            object.__setattr__(self, field.name, check(field.name, value))
        if not isinstance(self.output, str) or self.output not in OUTPUTS:
            raise SpecError(
                "output", f"must be one of {', '.join(OUTPUTS)}", self.output, "choose one"
            )
        if not _has_mass(self.motor_inertia, self.load_inertia):
            raise SpecError(
                "motor_inertia", "and load_inertia must not both be 0", 0.0, "give either"
            )


def possible(constants: Mapping[str, npt.NDArray[np.float64]]) -> npt.NDArray[np.bool_]:
    """Return which of many joints, their constants in columns by name, ``Joint`` would accept.

    >>> ones = {f.name: np.ones(2) for f in fields(Joint) if f.name != "output"}
    >>> possible({**ones, "load_damping": np.array([0.0, -1.0])}).tolist()
    [True, False]
    """
    found: npt.NDArray[np.bool_]
    found = _has_mass(constants["motor_inertia"], constants["load_inertia"])
    for name, column in constants.items():
        found = found & (column > 0 if name in _ABOVE_ZERO else column >= 0)
    return found


def _has_mass(motor: Any, load: Any) -> Any:
    return motor + load > 0


def joint_plant(joint: Joint, *, dead_time: float = 0.0, sensor: float = 1.0) -> Plant:
    """Return the plant from the motor's volts to the load's motion, exactly::

        Kt/N / (s^k (L J s^2 + (L b + R J) s + R b + Kt Ke))     k = 1: angle, 0: speed

    >>> motor = Joint(torque_constant=0.5, resistance=2.0, motor_inertia=0.25, output="rad/s")
    >>> joint_plant(motor)  # Kt/(R J s + Kt^2)
    Plant(num=(0.5,), den=(0.5, 0.25), dead_time=0.0, sensor=1.0)
    """
    n = Fraction(joint.gear_ratio)
    kt, r, l_a = (Fraction(x) for x in (joint.torque_constant, joint.resistance, joint.inductance))
    ke = kt if joint.back_emf is None else Fraction(joint.back_emf)
    j = Fraction(joint.motor_inertia) + Fraction(joint.load_inertia) / n**2
    b = Fraction(joint.motor_damping) + Fraction(joint.load_damping) / n**2
    den = [l_a * j, l_a * b + r * j, r * b + kt * ke]
    if not joint.output.endswith("/s"):
        den.append(Fraction(0))
    unit = Fraction(degrees(1)) if joint.output.startswith("deg") else Fraction(1)
    num = digits.exact([kt * unit / n])
    return Plant.from_exact(
        num, digits.exact(den if joint.inductance else den[1:]), dead_time=dead_time, sensor=sensor
    )
