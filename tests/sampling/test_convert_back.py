"""undiscretise finds the plant that discretise made the system of, or says that it cannot."""

import re
from decimal import Decimal
from math import log, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf

from zoh.errors import SpecError
from zoh.lti.digits import exact, precision
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.convert import METHODS, discretise, undiscretise
from zoh.sampling.distance import distance, newton_sizes
from zoh.sampling.logarithm import NoLogarithm, artanh_of_roots

LOGARITHMIC = ["zoh", "foh", "impulse", "matched"]

# Worked by hand, dt = 1, L = log 2:
#   z = 1/2 is s = -L.  zoh: (1-E)/(z-E) of 1/(s/L + 1);  impulse: z/(z-E) of 1/(s + L)
#   foh: (1/2)(z+1)/(z-1) of 1/s;  matched: (z - 1/4)/(z - 1/2) at z = 1 is 3/2 = K 2L/L
#   z/(z^2+1) answers a step with 0, 1, 1, 0, ... = (1 - cos(v t) + sin(v t))/2, v = pi/2, and
#   so does (v s + v^2)/2 over s^2 + v^2
#   tustin: z = (2 + w)/(2 - w), so z + 1 over z - 1/2 is 4/(3 w/2 + 1)
#   forward: z = 1 + s;  backward: z = 1/(1 - s)
L = log(2)
BY_HAND = [
    ("zoh", [1], [2, -1], (L,), (1, L)),
    ("zoh", [1], [2, -1, 0, 0], (L,), (1, L)),
    ("zoh", [1], [1, 0], (1,), (1,)),
    ("zoh", [0.5, 0.5], [1, -2, 1], (1,), (1, 0, 0)),
    ("zoh", [1, -1], [1, -0.5], (1, 0), (1, L)),
    ("zoh", [1, 0], [1, 0, 1], (pi / 4, pi**2 / 8), (1, 0, pi**2 / 4)),
    ("foh", [1, 1], [2, -2], (1,), (1, 0)),
    ("impulse", [1, 0], [1, -0.5], (1,), (1, L)),
    ("matched", [1, -0.25], [1, -0.5], (0.75, 1.5 * L), (1, L)),
    ("matched", [1, 1], [1, -2, 1], (2,), (1, 0, 0)),
    ("tustin", [1, 1], [1, -0.5], (4,), (1.5, 1)),
    ("forward", [1, -0.25], [1, -0.5], (1, 0.75), (1, 0.5)),
    ("backward", [1, 0], [2, -1], (1,), (1, 1)),
]  # fmt: skip


@pytest.mark.parametrize(("method", "num", "den", "num_s", "den_s"), BY_HAND)
def test_matches_hand_worked_plants(method, num, den, num_s, den_s):
    plant = undiscretise(Sampled(num=num, den=den, dt=1.0), method)
    scale = den_s[0] / plant.den[0]
    assert [scale * c for c in plant.num] == pytest.approx(num_s, rel=1e-14)
    assert [scale * c for c in plant.den] == pytest.approx(den_s, rel=1e-14, abs=1e-15)


@pytest.mark.parametrize("method", ["zoh", "foh", "matched"])
@pytest.mark.parametrize("m", [0, 1, 3])
def test_poles_at_zero_behind_everything_else_are_dead_time(method, m):
    plain = undiscretise(Sampled(num=[1], den=[1, -0.5], dt=0.5), method)
    late = undiscretise(Sampled(num=[1], den=[1, -0.5] + [0] * m, dt=0.5), method)
    assert late.dead_time == 0.5 * m
    assert (late.num, late.den) == (plain.num, plain.den)


PLANTS = {
    "arm": Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180),
    "double integrator": Plant(num=[1], den=[1, 0, 0]),
    "four equal lags": Plant(num=[1], den=[1, 4, 6, 4, 1]),
    "unstable": Plant(num=[1, 3], den=[1, 1, -2]),
    "resonance": Plant(num=[25], den=[1, 0.1, 25]),
    "differentiator": Plant(num=[1, 0], den=[1, 3, 2]),
    "repeated pairs": Plant.zpk(zeros=[-3], poles=[-0.5 + 2j, -0.5 - 2j] * 2 + [-1, -1], gain=2),
    "zero on the right": Plant(num=[-1, 2], den=[1, 3, 3, 1]),
    "stiff": Plant.zpk(zeros=[], poles=[-0.01, -100], gain=1),
    "late": Plant(num=[1], den=[1, 1], dead_time=0.003),
}
TIMES = [0.1, 1e-3, 1e-6]


def gap(got, plant, frequencies):
    """Return the largest error of the gain, relative, over frequencies in rad/s."""
    return np.abs(got.at(frequencies) / plant.at(frequencies) - 1).max()


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("dt", TIMES)
def test_there_and_back(name, method, dt):
    plant = PLANTS[name]
    if dt > plant.dead_time > 0:
        plant = Plant(num=plant.num, den=plant.den, dead_time=3 * dt)
    wp = 1.3 if method == "prewarp" else None
    got = undiscretise(discretise(plant, dt, method, wp), method, wp)
    # 1e-12: a gain near a resonance, or far below the plant's zeros, magnifies the last digits
    assert gap(got, plant, np.geomspace(0.01, 10, 40)) < 1e-12
    assert got.dead_time == pytest.approx(plant.dead_time, rel=1e-14)
    assert len(got.num) == len(plant.num)
    assert len(got.den) == len(plant.den)


# impulse is not among them: there a zero at s = 0 is no zero at z = 1
@pytest.mark.parametrize("method", ["zoh", "foh", "matched"])
def test_zeros_at_the_origin_and_integrators_come_back_as_such(method):
    plant = Plant(num=[1, 2, 0], den=[1, 3, 3, 1])
    assert undiscretise(discretise(plant, 0.1, method), method).num[-1] == 0.0
    plant = Plant(num=[1, 2], den=[1, 3, 0, 0])
    assert undiscretise(discretise(plant, 0.1, method), method).den[-2:] == (0.0, 0.0)


@pytest.mark.parametrize("method", ["zoh", "foh", "matched"])
def test_feedthrough_comes_back(method):
    plant = Plant(num=[1, 2], den=[1, 1])
    got = undiscretise(discretise(plant, 0.3, method), method)
    assert got.num == pytest.approx(plant.num, rel=1e-14)


@pytest.mark.parametrize("method", LOGARITHMIC)
@pytest.mark.parametrize("dt", [0.1, 1e-4])
def test_order_ten_comes_back(method, dt):
    poles = [-0.2, -0.7, -1.1, -1.9, -0.3 + 1j, -0.3 - 1j, -0.8 + 2j, -0.8 - 2j, -2, -2]
    plant = Plant.zpk(zeros=[-0.5, -1.5, 0.9], poles=poles, gain=3)
    got = undiscretise(discretise(plant, dt, method), method)
    # 1e-10: ten poles within a decade magnify the last digits of the sampled coefficients
    assert gap(got, plant, np.geomspace(0.01, 10, 40)) < 1e-10
    assert len(got.num) == 4


def test_a_coefficient_that_is_zero_in_the_middle_comes_back_as_zero():
    # zeros that add up to 0: their rounding must not become a zero at 1e120 rad/s
    plant = Plant(num=[-3, 0, -0.1753, -3], den=[-0.79, 0.007, -3, 2])
    got = undiscretise(discretise(plant, 1e-4, "matched"), "matched")
    lead = plant.den[0]
    assert [c * lead for c in got.num] == pytest.approx(plant.num, rel=1e-12, abs=1e-12)
    assert [c * lead for c in got.den] == pytest.approx(plant.den, rel=1e-12)


@pytest.mark.parametrize("pole", [25, 30, 40, 300])
@pytest.mark.parametrize("slow", [[], [-1]])
def test_a_fast_pole_that_w_has_lost_is_found_in_z(pole, slow):
    # exp(-40) = 4e-18: in w the pole is at -2/dt to the last bit, in z it is in den
    plant = Plant.zpk(zeros=[], poles=[-pole, *slow], gain=1)
    got = undiscretise(discretise(plant, 1.0, "zoh"), "zoh")
    assert got.den == pytest.approx(plant.den, rel=1e-15)


@pytest.mark.parametrize("zeros", [[], [-0.5]])
def test_a_fast_matched_pole_is_found_in_z(zeros):
    plant = Plant.zpk(zeros=zeros, poles=[-40, -1], gain=1)
    got = undiscretise(discretise(plant, 1.0, "matched"), "matched")
    assert got.num == pytest.approx(plant.num, rel=1e-14)
    assert got.den == pytest.approx(plant.den, rel=1e-15)


@pytest.mark.parametrize(
    ("poles", "dt"),
    [
        ([-1, -5, -5, -5], 2.0),
        ([-1, -5, -5, -5], 5.0),
        ([-1] * 5, 1.0),
        ([-1] * 4, 1.5),
        ([0, 0, -1, -2, -5], 2.0),
        (range(-10, 0), 0.3),
    ],
)
@pytest.mark.parametrize("zeros", [[], [-2.5]])
def test_matched_zeros_at_minus_one_are_none_of_the_plant_however_fast_its_poles(poles, dt, zeros):
    # fast poles keep their digits in z alone, where (z + 1)^k is rounded: no s^2 + (pi/dt)^2
    plant = Plant.zpk(zeros=zeros, poles=poles, gain=1)
    made = discretise(plant, dt, "matched")
    typed = Sampled(num=made.num, den=made.den, dt=dt)  # in w, too, (z + 1)^k is rounded then
    for system in (made, typed):
        got = undiscretise(system, "matched")
        assert got.num == pytest.approx(plant.num, rel=1e-12)


def test_typed_zeros_at_minus_one_beside_a_zero_of_the_plant_are_none_of_it():
    # rounding moves (z + 1)^3 to a zero on the negative axis and a pair, none of which has a log
    plant = Plant.zpk(zeros=[-0.7], poles=[-1, -2, -3, -4], gain=1)
    made = discretise(plant, 0.1, "matched")
    got = undiscretise(Sampled(num=made.num, den=made.den, dt=0.1), "matched")
    assert got.num == pytest.approx((1, 0.7), rel=1e-10)  # z-coefficients hold slow poles to that


def test_a_zero_that_is_not_at_minus_one_is_not_taken_for_one():
    # s^2 + w^2 with w 1e-4 below Nyquist's: z = -exp(+-1e-4 j dt), which z + 1 does not divide
    plant = Plant(num=[1, 0, (pi - 1e-4) ** 2], den=[1, 3, 3, 1])
    made = discretise(plant, 1.0, "matched")
    got = undiscretise(Sampled(num=made.num, den=made.den, dt=1.0), "matched")
    # 1e-8: (z + 1)^2 + 1e-8 keeps eight digits of that in floats, and so 1e-12 of w^2
    assert got.num == pytest.approx(plant.num, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("method", LOGARITHMIC)
def test_an_integrator_beside_poles_that_only_z_holds_comes_back_as_one(method):
    # exp(-42) is in z alone, and there (z - 1)(z - exp(-2))... has its root beside 1 when rounded
    plant = Plant.zpk(zeros=[], poles=[0, -1, -20, -21], gain=1)
    got = undiscretise(discretise(plant, 2.0, method), method)
    assert got.den[-1] == 0.0
    assert got.num == pytest.approx(plant.num, rel=1e-13)
    assert got.den == pytest.approx(plant.den, rel=1e-13)


@pytest.mark.parametrize("method", ["zoh", "foh"])
def test_a_zero_at_the_origin_beside_poles_that_only_z_holds_comes_back_as_one(method):
    plant = Plant.zpk(zeros=[0], poles=[-2, -1, -20, -21], gain=1)
    got = undiscretise(discretise(plant, 2.0, method), method)
    assert got.num == pytest.approx((1, 0), rel=1e-13, abs=0)


def test_a_slow_pole_that_z_has_lost_is_found_in_w():
    # 1 - 1e-17 is 1 in floats
    plant = Plant(num=[1], den=[1, 1e-10])
    got = undiscretise(discretise(plant, 1e-7, "zoh"), "zoh")
    assert got.den == pytest.approx((1, 1e-10), rel=1e-15)


def test_a_fraction_of_dead_time_comes_back_as_a_plant_that_samples_the_same():
    late = discretise(Plant(num=[1], den=[1, 1], dead_time=0.37), 0.5, "zoh")
    got = undiscretise(late, "zoh")
    assert got.dead_time == 0.5
    # the response to a step, seen at multiples of dt: the first sample at t = 0.13
    assert got.num[0] == pytest.approx(-np.expm1(-0.13), rel=1e-14)
    again = discretise(got, 0.5, "zoh")
    assert again.num == pytest.approx(late.num, rel=1e-15)
    assert again.den == pytest.approx(late.den, rel=1e-15)


def test_poles_above_nyquist_come_back_as_those_below_that_look_the_same():
    # 5 rad/s seen every second is 2 pi - 5
    got = undiscretise(discretise(Plant(num=[1], den=[1, 0.2, 25.01]), 1.0, "zoh"), "zoh")
    assert sorted(abs(got.poles().imag)) == pytest.approx([2 * pi - 5] * 2, rel=1e-12)
    assert got.poles().real == pytest.approx([-0.1, -0.1], rel=1e-12)


coefficient = st.floats(-5, 5).map(lambda x: round(x, 3))
lists = st.lists(coefficient, min_size=1, max_size=4)
times = st.floats(1e-4, 2)


@given(lists, lists, times, st.integers(0, 3))
def test_tustin_backwards_is_the_same_to_the_bit(num, den, dt, m):
    plant = Plant(num=[0.5, *num][: len(den)], den=[1.0, *den[1:]], dead_time=m * dt)
    try:
        there = discretise(plant, dt, "tustin")
    except SpecError:  # a pole at 2/dt
        return
    back = undiscretise(there, "tustin")
    assert (back.num, back.den, back.dead_time) == (plant.num, plant.den, plant.dead_time)


@given(lists, lists, times, st.sampled_from(["forward", "backward"]))
def test_differences_backwards_are_the_same_to_the_last_digits(num, den, dt, method):
    den = [1.0, *den[1:]]
    plant = Plant(num=[0.5, *num][: len(den)], den=den)
    try:
        there = discretise(plant, dt, method)
    except SpecError:
        return
    back = undiscretise(there, method)
    scale = sum(abs(c) for c in plant.den) * 10  # of what the last digits of w add up from
    lead = back.den[0]
    assert [c / lead for c in back.den] == pytest.approx(plant.den, abs=1e-13 * scale)
    assert len(back.num) == len(plant.num)
    scale = sum(abs(c) for c in plant.num) * 10
    assert [c / lead for c in back.num] == pytest.approx(plant.num, abs=1e-13 * scale)


inside = st.lists(st.floats(0.05, 0.98), min_size=1, max_size=3)


@given(inside, st.lists(coefficient, min_size=3, max_size=3), st.sampled_from(["zoh", "foh"]))
def test_any_system_with_poles_right_of_zero_is_the_hold_of_a_plant(poles, num, method):
    system = Sampled(num=[1.0, *num[: len(poles)]], den=np.poly(poles).tolist(), dt=0.25)
    again = discretise(undiscretise(system, method), 0.25, method)
    assert distance(system, again) <= 1e-9  # the promise of undiscretise
    w = np.array([0.3, 2.0, 9.0])
    size = max(abs(system.at(w)))
    assert again.at(w) == pytest.approx(system.at(w), abs=1e-9 * size)  # and so are the gains


@pytest.mark.parametrize("method", LOGARITHMIC)
@pytest.mark.parametrize(
    "den",
    [[1, 0.5], [1, 1], [1, 1, 0.25], [1, 0, -0.25], [1, 2, 1], [1, -0.5, -0.5]],
    ids=str,
)
def test_refuses_poles_on_the_negative_real_axis(method, den):
    num = [1, 0] if method == "impulse" else [1]
    with pytest.raises(SpecError, match="negative real axis"):
        undiscretise(Sampled(num=num, den=den, dt=0.1), method)


@pytest.mark.parametrize("method", LOGARITHMIC)
def test_refuses_poles_at_zero_that_are_no_delay(method):
    with pytest.raises(SpecError, match="no pole at z = 0 but those of a pure delay"):
        undiscretise(Sampled(num=[1, 0.5], den=[1, 0], dt=0.1), method)


def test_refuses_matched_zeros_on_the_negative_real_axis():
    with pytest.raises(SpecError, match="negative real axis"):
        undiscretise(Sampled(num=[1, 0.5], den=[1, -0.5], dt=0.1), "matched")


@pytest.mark.parametrize(
    ("method", "num", "den"),
    [
        ("impulse", [1, -0.2], [1, -0.5]),  # g(0+) and feedthrough cannot be told apart
        ("matched", [1, -0.2], [1, -1.5, 0.56, -0.06]),  # two missing zeros should be at -1
    ],
)
def test_refuses_what_the_method_does_not_make_and_says_how_far_off_it_is(method, num, den):
    with pytest.raises(SpecError, match="must come back within 1e-09") as error:
        undiscretise(Sampled(num=num, den=den, dt=0.1), method)
    assert float(error.value.value) > 1e-9


def test_refuses_a_pure_gain_as_an_impulse_response():
    with pytest.raises(SpecError, match="must have a pole for method 'impulse'"):
        undiscretise(Sampled(num=[2], den=[1, 0], dt=0.1), "impulse")
    assert undiscretise(Sampled(num=[2], den=[1], dt=0.1), "matched").num == (2.0,)


def test_refuses_poles_whose_plant_is_improper():
    with pytest.raises(SpecError, match="no pole at z = -1"):
        undiscretise(Sampled(num=[1], den=[1, 1], dt=0.1), "tustin")
    with pytest.raises(SpecError, match="no pole at z = -1"):
        undiscretise(Sampled(num=[1], den=[1, 1], dt=0.1), "prewarp", 3.0)
    with pytest.raises(SpecError, match="no pole at z = 0"):
        undiscretise(Sampled(num=[1, 1], den=[1, 0], dt=0.1), "backward")
    # the forward difference sends only infinity to infinity
    assert undiscretise(Sampled(num=[1, 1], den=[1, 0], dt=0.1), "forward").den == (0.1, 1)


@pytest.mark.parametrize("method", ["tustin", "forward", "backward", "zoh"])
def test_a_typed_delay_comes_back_as_dead_time(method):
    late = Sampled(num=[0.5], den=[1, -0.5, 0, 0], dt=0.1)
    plant = undiscretise(late, method)
    assert plant.dead_time == pytest.approx(0.2, rel=1e-15)
    assert discretise(plant, 0.1, method).den == pytest.approx((1, -0.5, 0, 0), rel=1e-14)


def test_a_pole_that_has_vanished_within_a_sample_is_a_delay():
    # 1/(s + 1000) at dt = 1: 1 - exp(-1000) is 1 in floats, and its hold 0.001/z
    held = discretise(Plant(num=[1], den=[1, 1000.0]), 1.0, "zoh")
    assert (held.num, held.den) == ((0.001,), (1.0, 0.0))
    back = undiscretise(held, "zoh")
    assert (back.num, back.den, back.dead_time) == ((0.001,), (1.0,), 1.0)


def test_refuses_what_is_no_sampled_system_and_no_method():
    with pytest.raises(SpecError, match=r"system must be a zoh\.Sampled"):
        undiscretise(Plant(num=[1], den=[1, 1]), "zoh")
    with pytest.raises(SpecError, match="method must be a known method") as error:
        undiscretise(Sampled(num=[1], den=[1, 1], dt=0.1), "bilinear")
    assert all(name in str(error.value) for name in METHODS)
    with pytest.raises(SpecError, match="prewarp must be"):
        undiscretise(Sampled(num=[1], den=[1, 1], dt=0.1), "prewarp")


def test_artanh_of_roots_in_digits():
    # (p - 1/2)^3 (p^2 + 1/4): artanh(1/2) three times, artanh(+-j/2) = +-j atan(1/2)
    with mp.workdps(60):
        cube = [mpf(c) for c in ("1", "-1.5", "0.75", "-0.125")]
        monic = [mpf(0)] * 6
        for i, c in enumerate(cube):
            monic[i] += c
            monic[i + 2] += c / 4
        real, imaginary = mp.atanh(mpf(1) / 2), mp.atan(mpf(1) / 2)
        truth = [mpf(1)]
        for r in (real, real, real, mp.mpc(0, imaginary), mp.mpc(0, -imaginary)):
            truth = [a - r * b for a, b in zip([*truth, 0], [0, *truth], strict=True)]
        with precision(120):
            got = artanh_of_roots([Decimal(mp.nstr(c, 30)) for c in monic])
        for g, t in zip(got, truth, strict=True):
            assert abs(mpf(str(g)) - mp.re(t)) < mpf(10) ** -50


@pytest.mark.parametrize("root", [1.0, -1.0, 3.0, -1.0001])
def test_artanh_does_not_exist_beyond_one(root):
    with precision(80), pytest.raises(NoLogarithm):
        artanh_of_roots(exact([1.0, -root]))


def test_the_distance_sees_each_root_and_forgives_what_cancels():
    # roots 1, 1e3 and 1e6: every coefficient counts on its own scale
    wide = [1.0, 1e6, 1e9, 1e9]
    assert newton_sizes(wide) == pytest.approx(wide, rel=1e-12)
    # a light resonance: its middle coefficient is small by cancelling, its size is that of 1
    assert newton_sizes([1.0, 1e-9, 1.0]) == [1.0, 1.0, 1.0]
    light = Sampled(num=[1], den=[1, 1e-9, 1 - 1e-9], dt=1.0)
    near = Sampled(num=[1], den=[1, 2e-9, 1 - 1e-9], dt=1.0)
    assert distance(light, near) == pytest.approx(1e-9, rel=1e-5)  # first order in 1e-9


def test_the_distance_of_different_orders_is_infinite():
    one = Sampled(num=[1], den=[1, -0.5], dt=1.0)
    assert distance(one, Sampled(num=[1], den=[1, 0, -0.25], dt=1.0)) == np.inf
    assert distance(one, one) == 0.0


def test_messages_name_the_poles_and_the_way_out():
    with pytest.raises(SpecError, match=re.escape("use method 'tustin' or 'forward'")) as error:
        undiscretise(Sampled(num=[1], den=[1, 0.5], dt=0.1), "zoh")
    assert error.value.value == [pytest.approx(-0.5)]
