"""Gains at rest to a float's last digits, against fractions of the very floats that were given."""

from fractions import Fraction as F
from math import copysign

import pytest

import zoh
from zoh.analysis.responses import response
from zoh.analysis.rest import gains_at_rest, under_a_load
from zoh.analysis.step import closed_loop_step, step_info
from zoh.lti.systems import Plant, Sampled

ROUNDED = 1e-15  # relative: four or five roundings of what is a product of floats


def gain(system):
    """Return the gain at rest: of z-coefficients their sums, of a plant's its last ones."""
    if isinstance(system, Sampled):
        return F(sum(map(F, system.num))) / F(sum(map(F, system.den)))
    return F(system.sensor) * F(system.num[-1]) / F(system.den[-1])


def truth(plant, controller, ahead=None):
    p, c, f = gain(plant), gain(controller), gain(ahead) if ahead else 0
    back = 1 + c * p
    return (c + f) * p / back, (c + f) / back, (1 - f * p) / back


def near(value):
    return pytest.approx(float(value), rel=ROUNDED, abs=0)


def proportional(k, dt=0.1):
    return Sampled(num=[k], den=[1.0], dt=dt)


LOOPS = [
    (Plant(num=[0.7], den=[1, 0.3]), proportional(k)) for k in (0.1, 1.0, 1e3, 1e9, 1e12, 1e18)
] + [
    (Plant(num=[0.7], den=[1, -0.3]), proportional(0.3 / 0.7 * (1 + off)))
    for off in (1e-12, 1e-9, 1e-6, 1e-3, 0.5, 5.0)
] + [
    (Plant(num=[1, -0.7], den=[1, 2, 0.3], sensor=0.1), proportional(3 / 0.7 * (1 - off)))
    for off in (1e-12, 1e-9, 1e-3)
] + [
    (Plant(num=[0.7], den=[1, 0.3], sensor=-12 / 180),
     Sampled(num=[-5e8, 4.999e8], den=[1, -0.9], dt=0.1)),
    (Plant(num=[0.7], den=[1, 0.3]), Sampled(num=[2.0, -1.9], den=[1.0, -1.0 + 1e-9], dt=0.1)),
    (Plant(num=[3e-200], den=[1, 1]), proportional(1e200)),
]  # fmt: skip


@pytest.mark.parametrize(("plant", "controller"), LOOPS)
def test_what_a_loop_comes_to_has_all_its_digits(plant, controller):
    output, effort, error = truth(plant, controller)
    got = gains_at_rest(plant, controller)
    assert got == (near(output), near(effort), near(error))
    assert under_a_load(plant, controller) == (
        near(gain(plant) / (1 + gain(plant) * gain(controller))), near(-output),
    )  # fmt: skip


def test_an_unstable_plant_s_exact_coefficients_count_not_their_floats():
    """0.7/(s - 0.3) of decimals is 7/3 at rest; of the nearest floats L is 1e-16 of 1e-9 off."""
    plant = Plant.parse("0.7/(s - 0.3)")
    k = 0.3 / 0.7 * (1 + 1e-9)
    exact = F(-7, 3) * F(k)
    assert gains_at_rest(plant, proportional(k)).output == near(exact / (1 + exact))
    floats = gain(plant) * F(k)
    assert abs(floats / (1 + floats) / (exact / (1 + exact)) - 1) > 1e-9


# b of r in a P or PI law: its feedforward is (b - 1) kp; 1 + 0.3/(0.7 k) leaves no error
WEIGHTED = [(k, b) for k in (0.5, 2.0, 1e9) for b in (0.0, 1e-9, 0.3, 0.999, 1 + 1e-9, 2.0)]


@pytest.mark.parametrize(("k", "b"), [*WEIGHTED, (2.0, 1 + 0.3 / 1.4), (2.0, 1 + 0.3 / 1.4 + 1e-9)])
def test_a_weighted_reference_leaves_an_error_with_all_its_digits(k, b):
    plant, law = Plant(num=[0.7], den=[1, 0.3]), proportional(k)
    ahead = Sampled(num=[(b - 1) * k], den=[1.0], dt=0.1) if b != 1 else None
    if b == 0:  # u owes nothing to r
        assert gains_at_rest(plant, law, ahead) == (0.0, 0.0, 1.0)
        return
    assert gains_at_rest(plant, law, ahead) == tuple(map(near, truth(plant, law, ahead)))


def test_an_integrator_leaves_none_whatever_is_ahead():
    plant, ahead = Plant(num=[-0.7], den=[1, 0.3]), proportional(0.4)
    law = Sampled(num=[-2.0, 1.9], den=[1.0, -1.0], dt=0.1)
    for got in (gains_at_rest(plant, law), gains_at_rest(plant, law, ahead)):
        assert got == (1.0, near(gain(Plant(num=[-0.3], den=[0.7]))), 0.0)
    step = closed_loop_step(plant, law, reference=-3.0)
    assert copysign(1, step.steady_state_error) == 1  # 0, not -0


@pytest.mark.parametrize("k", [1e9, 1e12])
@pytest.mark.parametrize("reference", [1.0, -2.5])
def test_a_strong_loop_s_error_in_a_measurement(k, reference):
    """0.7/(s + 0.3) under k: 1/(1 + 0.7 k/0.3) of the reference."""
    plant, law = Plant(num=[0.7], den=[1, 0.3]), proportional(k, dt=1e-3 / k)
    got = zoh.measure(plant, law, reference=reference).step
    error = F(reference) / (1 + F(0.7) * F(k) / F(0.3))
    assert got.steady_state_error == near(error)
    assert got.between_samples.steady_state_error == near(error)
    assert got.final_value == near(F(reference) - error)
    bound = abs(float(error))  # kept but for 1e-9 of it, which counts as rounding
    over, under = (zoh.Requirements(steady_state_error=bound * x) for x in (1 + 1e-8, 1 - 1e-8))
    assert zoh.verify(plant, law, reference=reference, requirements=over).met
    with pytest.raises(zoh.NotMet):
        zoh.verify(plant, law, reference=reference, requirements=under)


@pytest.mark.parametrize("off", [1e-9, 1e-6])
def test_a_loop_near_minus_1_in_a_measurement(off):
    """0.7/(s - 0.3) under 3/7 (1 + off): T = L/(1 + L), and P/(1 + L) under a disturbance."""
    plant, law = Plant(num=[0.7], den=[1, -0.3]), proportional(0.3 / 0.7 * (1 + off))
    back = 1 + gain(law) * gain(plant)
    got = closed_loop_step(plant, law)
    assert got.final_value == near(gain(law) * gain(plant) / back)
    assert got.steady_state_error == near(1 / back)
    assert got.effort_range[0] == near(gain(law) / back)
    load, step = (response(plant, law, by=by) for by in ("disturbance", "step"))
    assert load.final_value == near(gain(plant) / back)
    assert load.peak_effort == near(abs(gain(law) * gain(plant) / back))
    assert step.final_value == near(gain(law) * gain(plant) / back)


@pytest.mark.parametrize("away", [0.0, 2.0**-40, -(2.0**-40), 2.0**-52, 0.25, -0.5, 3.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_system_by_itself_is_that_far_from_1(away, sign):
    """(0.3 + 0.3 away)/(s + 0.3), and the like in z; with both signs turned the same."""
    num, den = sign * 0.3 * (1 + away), [sign, sign * 0.3]
    got = step_info(Plant(num=[num], den=den))
    assert got.steady_state_error == near(1 - F(num) / F(den[1]))
    num, den = sign * 0.5 * (1 + away), [sign, -sign * 0.5]
    got = step_info(Sampled(num=[num], den=den, dt=1.0))
    assert got.steady_state_error == near(1 - F(num) / (sign * F(1, 2)))


def test_a_formula_by_itself_is_what_its_decimals_say():
    """0.7/(s + 0.7000000001) is 1/7000000001 short of 1; that of the floats is 8e-8 of it off."""
    got = step_info(Plant.parse("0.7/(s + 0.7000000001)")).steady_state_error
    assert got == near(F(1, 7_000_000_001))
    assert abs(F(0.7000000001) - F(0.7) - F(1, 10**10)) > F(8, 10**18)
