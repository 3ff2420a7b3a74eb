"""The project file: every way to say a plant is the same plant, and every key arrives."""

from decimal import Decimal
from math import isclose, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zoh.app.project import Given, Request, Sensor, read
from zoh.app.toml import Literal, tables
from zoh.errors import SpecError
from zoh.lti.joint import Joint, joint_plant

REST = """
[sampling]
dt = 0.1
[[controller]]
law = "pi"
wc = 0.8
pm_deg = 40
"""

# All are 6 (s + 2)/((s + 1)(s^2 + 2 s + 5)); the state space is its controllable form.
SAME_PLANT = [
    'model = "6(s + 2)/((s + 1)*(s^2 + 2 s + 5))"',
    "num = [6, 12]\nden = [1, 3, 7, 5]",
    "zeros = [-2]\npoles = [-1, [-1, 2], [-1, -2]]\ngain = 6",
    'zeros = [-2.0]\npoles = ["-1+2j", -1, " -1 - 2j "]\ngain = 6.0',
    "A = [[0, 1, 0], [0, 0, 1], [-5, -7, -3]]\nB = [0, 0, 1]\nC = [12, 6, 0]\nD = 0",
    "A = [[0, 1, 0], [0, 0, 1], [-5, -7, -3]]\nB = [[0], [0], [1]]\nC = [[12, 6, 0]]",
]


@pytest.mark.parametrize("form", SAME_PLANT)
def test_every_form_is_the_same_plant(form):
    plant = read(f"[plant]\n{form}\ndead_time = 0.25\n{REST}").plant
    assert (plant.num, plant.den) == ((6.0, 12.0), (1.0, 3.0, 7.0, 5.0))
    assert plant.dead_time == 0.25


def test_every_key_arrives():
    project = read("""
[plant]
model = "2.3/(s^2 + 0.7809 s)"
input_unit = "V"
output_unit = "deg"
dead_time = 0.02
[sensor]
gain = "12/180"
unit = "V/deg"
bits = 10
range = [0, 5.0]
[actuator]
min = -12
max = 12.5
[sampling]
dt = 0.1
compute_delay = 0.03
[[controller]]
name = "PID"
law = "pid"
wc = 1.95
pm_deg = 40
ki = 0.85
[[controller]]
name = "theirs"
law = "given"
num = [5.839, -5.823]
den = [1, -1]
claims = {kind = "pi", wc = 0.80, pm_deg = 40, gain_margin_db = 24.6}
[requirements]
pm_deg = 39.9
ms = 2
[reference]
step = -3
""")
    assert (project.plant.sensor, project.plant.dead_time) == (12 / 180, 0.02)
    assert (project.input_unit, project.output_unit) == ("V", "deg")
    assert project.sensor == Sensor(gain=12 / 180, unit="V/deg", bits=10, low=0.0, high=5.0)
    assert (project.actuator.low, project.actuator.high) == (-12.0, 12.5)
    assert (project.dt, project.compute_delay, project.reference) == (0.1, 0.03, -3.0)
    pid, theirs = project.controllers
    asked = {"wc": 1.95, "pm_deg": 40.0, "ki": 0.85}
    assert pid == Request(name="PID", law="pid", parameters=asked)
    assert isinstance(theirs, Given)
    assert (theirs.controller.num, theirs.controller.dt) == ((5.839, -5.823), 0.1)
    assert [(c.key, getattr(c.value, "text", c.value)) for c in theirs.claims] == [
        ("kind", "pi"),
        ("wc", "0.80"),
        ("pm_deg", "40"),
        ("gain_margin_db", "24.6"),
    ]
    assert (project.requirements.pm_deg, project.requirements.ms) == (39.9, 2.0)
    assert project.requirements.overshoot_pct is None


def test_what_is_left_out_is_neutral():
    project = read(f'plant.model = "1/s"\n{REST}')
    assert (project.plant.sensor, project.plant.dead_time, project.compute_delay) == (1, 0, 0)
    assert (project.reference, project.input_unit, project.actuator.low) == (1.0, "", None)
    assert project.controllers[0].name == "pi"


LITERALS = [("0.80", "0.005"), ("40", "0.5"), ("14.3", "0.05"), ("1e3", "5E+2"), ("1_0.5", "0.05")]


@pytest.mark.parametrize(("text", "half"), LITERALS)
def test_the_printed_digits_are_known(text, half):
    number = tables(f"x = {text}").number("x")
    assert number.half_a_digit == Decimal(half)
    assert number == float(text)


@given(st.decimals(allow_nan=False, allow_infinity=False, min_value=-1e9, max_value=1e9))
def test_a_literal_is_its_float(value):
    assert float(Literal(str(value))) == float(value)


# The motor of the Control Tutorials for MATLAB and Simulink, "DC Motor Speed":
# K/((Js + b)(Ls + R) + K^2), J = 0.01, b = 0.1, K = 0.01, R = 1, L = 0.5, by hand:
# den = J L s^2 + (J R + b L) s + b R + K^2 = 0.005 s^2 + 0.06 s + 0.1001
CTMS = """
[plant.joint]
torque_constant = 0.01
resistance = 1
inductance = 0.5
motor_inertia = 0.01
motor_damping = 0.1
"""


def test_a_joint_from_its_data_sheet():
    project = read(CTMS + 'output = "rad/s"\n' + REST)
    assert project.output_unit == "rad/s"
    assert project.plant.num == pytest.approx((0.01,), rel=1e-15)
    assert project.plant.den == pytest.approx((0.005, 0.06, 0.1001), rel=1e-15)


def test_the_angle_has_one_more_integrator_and_comes_in_degrees():
    plant = read(CTMS + 'output = "deg"\n' + REST).plant
    assert plant.num == pytest.approx((0.01 * 180 / pi,), rel=1e-15)
    assert plant.den == pytest.approx((0.005, 0.06, 0.1001, 0.0), rel=1e-15)


def test_without_inductance_the_order_is_one_lower():
    plant = read(CTMS.replace("inductance = 0.5\n", "") + REST).plant
    assert plant.den == pytest.approx((0.01, 0.1001, 0.0), rel=1e-15)


motors = st.builds(
    Joint,
    torque_constant=st.floats(1e-3, 10),
    back_emf=st.floats(1e-3, 10),
    resistance=st.floats(0.1, 10),
    inductance=st.floats(1e-4, 1),
    motor_inertia=st.floats(1e-5, 1),
    load_inertia=st.floats(1e-5, 1),
    motor_damping=st.floats(1e-5, 1),
    load_damping=st.floats(1e-5, 1),
    gear_ratio=st.floats(0.1, 300),
    output=st.just("rad/s"),
)


@given(motors, st.floats(0.1, 100))
def test_a_joint_obeys_the_motors_equations(joint, wc):
    """Solve circuit and torque balance at s = j wc for one volt, gear seen from the load's side."""
    s, n = 1j * wc, joint.gear_ratio
    speed = joint_plant(joint).at(wc)  # of the load
    current = (1 - joint.back_emf * n * speed) / (joint.inductance * s + joint.resistance)
    inertia = joint.motor_inertia * n**2 + joint.load_inertia
    damping = joint.motor_damping * n**2 + joint.load_damping
    torque = n * joint.torque_constant * current
    wanted = (inertia * s + damping) * speed
    # 1e-9 of the largest term: the back EMF leaves a difference that rounding is large beside
    scale = abs(torque) + n * joint.torque_constant / joint.resistance
    assert isclose(abs(torque - wanted), 0, abs_tol=1e-9 * scale)


BAD_JOINTS = [
    ({"torque_constant": 0}, "torque_constant must be above 0"),
    ({"resistance": -1}, "resistance must be above 0"),
    ({"gear_ratio": 0}, "gear_ratio must be above 0"),
    ({"motor_inertia": 0}, "motor_inertia and load_inertia must not both be 0"),
    ({"load_damping": -1e-9}, "load_damping must be 0 or more"),
    ({"output": "rpm"}, "output must be one of rad, deg, rad/s, deg/s"),
    ({"back_emf": True}, "back_emf must be a real number"),
]


@pytest.mark.parametrize(("change", "line"), BAD_JOINTS)
def test_a_joint_that_cannot_be(change, line):
    constants = {"torque_constant": 0.01, "resistance": 1.0, "motor_inertia": 0.01}
    with pytest.raises(SpecError, match=f"^{line}"):
        Joint(**(constants | change))
