"""The unit of every column, and what people call it.

SI; "1" of what has none. What a plant or a controller stands between has units of its own:
"input" is the actuator's, "output" the plant's, "reference" what the controller compares.
"""

from zoh.batch.figures import BY_NAME
from zoh.batch.sources import GAIN, Geared, Roots, Source

_JOINT = "plant.joint."
_GAIN_UNIT = "input/reference"
_KNOWN = {
    "dt": ("s", "sample time"),
    "compute_delay": ("s", "delay from sampling to output"),
    "dead_time": ("s", "dead time of the plant"),
    "wc": ("rad/s", "crossover asked for"),
    "pm_deg": ("deg", "phase margin asked for"),
    "kp": (_GAIN_UNIT, "proportional gain"),
    "ki": (f"{_GAIN_UNIT}/s", "integral gain"),
    "kd": (f"{_GAIN_UNIT} s", "derivative gain"),
    "filter_pole": ("rad/s", "pole of the derivative's filter"),
    "ti_td": ("1", "integral time over derivative time"),
    "largest_ki_ms": ("1", "bound on Ms under which ki is largest"),
    "least_iae_ms": ("1", "bound on Ms under which the IAE is least"),
    "setpoint_weight": ("1", "weight of the reference in the proportional part"),
    "derivative_weight": ("1", "weight of the reference in the derivative part"),
    "dc_gain": (_GAIN_UNIT, "controller's gain at w = 0"),
    "w0": ("rad/s", "controller's zero"),
    "wp": ("rad/s", "controller's pole"),
    "lag_corner": ("rad/s", "corner of the lag"),
    "lag_ratio": ("1", "zero over pole of the lag"),
    "lag_zero": ("rad/s", "zero of the lag"),
    "lag_pole": ("rad/s", "pole of the lag"),
    "lead_zero": ("rad/s", "zero of the lead"),
    "lead_pole": ("rad/s", "pole of the lead"),
    "stable": ("1", "whether the closed loop is proved to be stable"),
    "reason": ("1", "why a loop has figures or has none"),
    f"{_JOINT}torque_constant": ("N m/A", "torque constant of the motor"),
    f"{_JOINT}resistance": ("ohm", "resistance of the armature"),
    f"{_JOINT}motor_inertia": ("kg m^2", "inertia of the rotor"),
    f"{_JOINT}load_inertia": ("kg m^2", "inertia behind the gear"),
    f"{_JOINT}motor_damping": ("N m s/rad", "viscous damping of the rotor"),
    f"{_JOINT}load_damping": ("N m s/rad", "viscous damping behind the gear"),
    f"{_JOINT}back_emf": ("V s/rad", "constant of the back EMF"),
    f"{_JOINT}inductance": ("H", "inductance of the armature"),
    f"{_JOINT}gear_ratio": ("1", "turns of the motor for one of the load"),
}


def unit_and_name(column: str, plant: Source) -> tuple[str, str]:
    """Return the unit of a column and its long name.

    A plant's coefficients are as those of a transfer function whose den[0] has no unit.

    >>> from zoh.lti.systems import Plant
    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0])
    >>> unit_and_name("plant.gain", arm)
    ('output/input/s^2', 'num[0]/den[0] of the plant')
    >>> unit_and_name("plant.den.1", arm)
    ('1/s', 'den[1] of the plant')
    """
    if column in BY_NAME:
        return BY_NAME[column].unit, BY_NAME[column].long_name
    short = column.removeprefix("gains.")
    if short in _KNOWN:
        return _KNOWN[short]
    if column == GAIN:
        return f"output/input{_per_s(_excess(plant))}", "num[0]/den[0] of the plant"
    _, kind, place = column.split(".")
    name = f"{kind}[{place}] of the plant"
    if kind in ("zero", "pole"):
        return "rad/s", name
    if kind == "num":
        return f"output/input{_per_s(_excess(plant) + int(place))}", name
    return "1" + _per_s(int(place)), name


def _excess(plant: Source) -> int:
    """Return how many poles a plant has more than zeros."""
    if isinstance(plant, Roots):
        return len(plant.poles) - len(plant.zeros)
    whole = plant.plant() if isinstance(plant, Geared) else plant
    return len(whole.den) - len(whole.num)


def _per_s(power: int) -> str:
    """Return what divides by s to a power.

    >>> _per_s(0), _per_s(1), _per_s(2), _per_s(-1)
    ('', '/s', '/s^2', ' s')
    """
    size = f"s^{abs(power)}" if abs(power) > 1 else "s"
    return f"/{size}" if power > 0 else f" {size}" if power else ""
