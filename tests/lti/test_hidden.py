"""What num and den share, taken apart exactly."""

from decimal import Decimal
from math import sqrt

import numpy as np
import pytest

import zoh
from zoh.lti.hidden import Apart, hidden_modes, unstable_hidden, without_hidden
from zoh.lti.plant import Plant


def decimals(*values):
    return tuple(Decimal(v) for v in values)


def test_apart_by_hand():
    # (3 s^2 + 1)(s + 2) under (3 s^2 + 1)(s + 0.1): divided by its lead it has no decimal digits
    found = Apart.of(decimals("3", "6", "1", "2"), decimals("3", "0.3", "1", "0.1"))
    assert found.num == decimals("1", "2")
    assert found.den == decimals("1", "0.1")
    assert found.modes == decimals("3", "0", "1")
    assert not found.stable
    # (s + 1)^2 on the left
    assert Apart.of(decimals("1", "2", "1"), decimals("1", "3", "3", "1")).stable


@pytest.mark.parametrize(
    ("num", "den"),
    [
        (("2",), ("2", "4")),
        (("1", "1"), ("1", "3", "3")),
        (("1", "0.1"), ("1", "0.1000000000000000000000000000000001")),
    ],
)
def test_nothing_shared(num, den):
    assert Apart.of(decimals(*num), decimals(*den)) is None


@pytest.mark.parametrize("square", [2.0, 3.3, 1e-9, 1e9])
def test_a_mode_on_the_axis_is_not_stable_whatever_its_roots_round_to(square):
    plant = Plant(num=[1, 0, square], den=[1, 1, square, square])  # (s + 1)(s^2 + square)
    assert sorted(abs(s.imag) for s in unstable_hidden(plant)) == pytest.approx([sqrt(square)] * 2)
    assert len(hidden_modes(plant)) == 2
    assert without_hidden(plant).den == (1.0, 1.0)


def test_of_the_hidden_only_those_that_do_not_die_out():
    plant = Plant.parse("(s-1)*(s+3)/((s-1)*(s+3)*(s+2))")
    assert sorted(hidden_modes(plant).real) == pytest.approx([-3.0, 1.0])
    assert unstable_hidden(plant) == pytest.approx([1.0])
    kept = Plant.parse("(s+3)/((s+3)*(s+2))")
    assert unstable_hidden(kept) == []
    none = Plant.parse("1/(s+2)")
    assert without_hidden(none) is none
    assert unstable_hidden(none) == []
    for plant in (none, kept):  # real modes, or none, are an array of complex numbers as any other
        assert hidden_modes(plant).dtype == complex
    assert hidden_modes(none).tolist() == []


@pytest.mark.parametrize("times", [1, 2])
def test_a_hidden_integrator_does_not_die_out(times):
    plant = Plant(num=[1, *[0] * times], den=[1, 2, *[0] * times])
    assert unstable_hidden(plant) == [0]
    assert hidden_modes(plant).tolist() == [0] * times
    assert without_hidden(plant) == Plant(num=[1], den=[1, 2])


def test_what_is_left_waits_and_measures_as_before():
    plant = Plant(num=[1, 3], den=[1, 5, 6], dead_time=0.25, sensor=-0.5)
    assert without_hidden(plant) == Plant(num=[1], den=[1, 2], dead_time=0.25, sensor=-0.5)


@pytest.mark.parametrize("dt", [1e-4, 0.01, 0.1, 0.5, 1.0, 3.0])
@pytest.mark.parametrize(
    ("num", "den"),
    [([1, 0, 4], [1, 1, 4, 4]), ([1, 0, 9], [1, 2, 9, 18]), ([2, 0, 4], [1, 1, 2, 2])],
)
def test_an_undamped_hidden_mode_leaves_no_loop_stable(num, den, dt):
    plant, controller = Plant(num=num, den=den), zoh.Sampled(num=[0.5], den=[1], dt=dt)
    with_it = zoh.measure(plant, controller).margins
    # without it the loop is a lag under a P of less than 1
    without = zoh.measure(without_hidden(plant), controller).margins
    assert with_it.stable is False
    assert without.stable is True
    assert with_it.certificate.holds
    for name in ("gain_margin", "phase_margin_deg", "modulus_margin", "mt", "disk_margin"):
        assert getattr(with_it, name) == pytest.approx(getattr(without, name), rel=1e-12)
    with pytest.raises(zoh.SpecError, match="must make the closed loop stable"):
        zoh.noise_gains(plant, controller)
    with pytest.raises(zoh.NotMet, match="unstable"):
        zoh.verify(plant, controller)


@pytest.mark.parametrize("arithmetic", ["arrays", "compiled"])
def test_nor_in_a_sweep(arithmetic):
    if arithmetic == "compiled":
        pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")
    plant, controller = (
        Plant(num=[1, 0, 4], den=[1, 1, 4, 4]),
        zoh.Sampled(num=[0.5], den=[1], dt=0.1),
    )
    found = zoh.sweep(
        plant, "given", controller=controller, over={"dt": [0.01, 0.1, 0.5]}, arithmetic=arithmetic
    )
    assert {zoh.Reason(code) for code in found["reason"].tolist()} == {zoh.Reason.UNSTABLE}


@pytest.mark.parametrize("times", [2, 3, 4])
def test_a_repeated_mode_on_the_axis_is_there_once(times):
    shared = np.poly([1j, -1j] * times).real  # (s^2 + 1)^times
    plant = Plant(num=shared, den=np.polymul(shared, [1, 1]))
    assert len(hidden_modes(plant)) == 2 * times
    assert sorted(s.imag for s in unstable_hidden(plant)) == pytest.approx([-1.0, 1.0], rel=1e-12)
