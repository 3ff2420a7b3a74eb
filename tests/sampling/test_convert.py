"""discretise gives what each method says, to the last digits, at any sample time."""

import json
import re
from itertools import zip_longest
from math import exp, inf, nan, pi, tan
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from mpmath import mp, mpf

from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.convert import METHODS, discretise
from zoh.sampling.hold import sample

CASES = json.loads((Path(__file__).parents[1] / "oracles" / "convert.json").read_text())
UNDERFLOW = 1e-300  # a coefficient such as exp(-780) is a zero in floats


def case_id(case):
    late = case["dead_time"] / case["dt"]
    return f"{case['method']}-{case['plant']}-{case['dt']:g}-{late:.3g}"


@pytest.fixture(params=CASES, ids=case_id)
def case(request):
    return request.param


def made(case):
    plant = Plant(
        num=case["num"], den=case["den"], dead_time=case["dead_time"], sensor=case["sensor"]
    )
    return discretise(plant, case["dt"], case["method"], case.get("prewarp"))


def assert_same(got, truth, rel):
    pairs = list(zip_longest(reversed(got), reversed(truth), fillvalue=0))
    wrong = [(g, t) for g, t in pairs if abs(mpf(g) - mpf(t)) > rel * abs(mpf(t)) + UNDERFLOW]
    assert not wrong


def test_z_coefficients_are_those_of_thirty_digits(case):
    got = made(case)
    assert got.dt == case["dt"]
    assert got.delay == case["delay"]
    assert_same(got.num, case["num_z"], 1e-15)
    assert_same(got.den, case["den_z"] + ["0"] * case["delay"], 1e-15)


def test_w_coefficients_are_those_of_thirty_digits(case):
    got = made(case)
    with mp.workdps(40):
        at = next(i for i, c in enumerate(case["den_w"]) if mpf(c))
        scale = mpf(got.den_w[at]) / mpf(case["den_w"][at])
        assert_same(got.den_w, [mpf(c) * scale for c in case["den_w"]], 1e-15)
        assert_same(got.num_w, [mpf(c) * scale for c in case["num_w"]], 1e-15)


def test_every_method_is_in_the_table_of_references():
    assert {case["method"] for case in CASES} | {"zoh"} == set(METHODS)


# Worked by hand.
# foh, 1/s: the integral of straight lines is the trapezoid, h/2 (z+1)/(z-1), h = dt = 1/2.
#   1/(s+1): r(t) = t - 1 + E^.; r_1 = h - 1 + E, r_2 - 2 r_1 = 1 - E - h E; over h
#   1/s^2: r = t^3/6: h^2/6 (z^2 + 4 z + 1)/(z-1)^2
#   1/s late by h/2: r(t) = t^2/2 at h/2, 3h/2, 5h/2: bends h^2 (1, 6, 1)/8, over h
# impulse, 1/(s+1): h z/(z - E);  1/s^2: h t = h^2 z/(z-1)^2
#   1/(s+1) late by 0.7 h: first sample at 0.3 h
# matched: 1/(s+1): (1-E)/(z-E);  1/s^2: h^2 (z+1)/2/(z-1)^2
#   s/(s+1): K (z-1)/(z-E), (z-1)/h for s, so K/(1-E) = 1/h
#   (s+2)/(s+1): K (z - E^2)/(z - E) with K (1 - E^2)/(1 - E) = 2
#   1/((s+1)(s+2)(s+3)): two of three zeros at infinity come to -1
# tustin: s = 4 (z-1)/(z+1);  1/(s+1): (z+1)/(5 z - 3)
# forward: s = 2 (z-1): 1/(2 z - 1);  backward: s = 2 (z-1)/z: z/(3 z - 2)
H = 0.5
E = exp(-H)
THREE = (1 - E) * (1 - E**2) * (1 - E**3) / 24  # over (z+1)^2, which is 4 at z = 1
LAG, INTEGRATOR, TWICE = ([1], [1, 1]), ([1], [1, 0]), ([1], [1, 0, 0])
BY_HAND = [
    ("foh", INTEGRATOR, 0.0, (0.25, 0.25), (1, -1)),
    ("foh", INTEGRATOR, 0.25, (0.0625, 0.375, 0.0625), (1, -1, 0)),
    ("foh", LAG, 0.0, ((H - 1 + E) / H, (1 - E - H * E) / H), (1, -E)),
    ("foh", TWICE, 0.0, (1 / 24, 4 / 24, 1 / 24), (1, -2, 1)),
    ("foh", ([3], [2]), 0.0, (1.5,), (1,)),
    ("impulse", LAG, 0.0, (H, 0), (1, -E)),
    ("impulse", LAG, 0.35, (H * exp(-0.15), 0), (1, -E, 0)),
    ("impulse", TWICE, 0.0, (0.25, 0), (1, -2, 1)),
    ("impulse", TWICE, 1.0, (0.25, 0), (1, -2, 1, 0, 0)),
    ("matched", LAG, 0.0, (1 - E,), (1, -E)),
    ("matched", TWICE, 0.0, (0.125, 0.125), (1, -2, 1)),
    ("matched", ([1, 0], [1, 1]), 0.0, ((1 - E) / H, -(1 - E) / H), (1, -E)),
    ("matched", ([1, 2], [1, 1]), 0.0, (2 / (1 + E), -2 * E**2 / (1 + E)), (1, -E)),
    ("matched", ([1], [1, 6, 11, 6]), 0.0, (THREE, 2 * THREE, THREE),
     (1, -(E + E**2 + E**3), E**3 + E**4 + E**5, -(E**6))),
    ("matched", ([3], [2]), 0.5, (1.5,), (1, 0)),
    ("tustin", LAG, 0.0, (0.2, 0.2), (1, -0.6)),
    ("tustin", LAG, 1.5, (0.2, 0.2), (1, -0.6, 0, 0, 0)),
    ("forward", LAG, 0.0, (0.5,), (1, -0.5)),
    ("backward", LAG, 0.0, (1 / 3, 0), (1, -2 / 3)),
    ("zoh", LAG, 0.0, (1 - E,), (1, -E)),
]  # fmt: skip


@pytest.mark.parametrize(("method", "plant", "dead_time", "num", "den"), BY_HAND)
def test_matches_hand_worked_coefficients(method, plant, dead_time, num, den):
    got = discretise(Plant(num=plant[0], den=plant[1], dead_time=dead_time), H, method)
    assert got.num == pytest.approx(num, rel=1e-14)
    assert got.den == pytest.approx(den, rel=1e-14)


def test_prewarp_by_hand():
    # at dt = 1 and pi/2 rad/s tan is 1, so s = (pi/2)(z-1)/(z+1): 1/s = (2/pi)(z+1)/(z-1)
    got = discretise(Plant(num=[1], den=[1, 0]), 1.0, "prewarp", prewarp=pi / 2)
    assert got.num == pytest.approx((2 / pi, 2 / pi), rel=1e-15)
    assert got.den == (1.0, -1.0)


def test_zoh_is_sample():
    arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180, dead_time=0.037)
    assert discretise(arm, 0.1, "zoh") == sample(arm, 0.1)


def test_a_method_of_its_own_or_an_argument_prewarping_is_the_same():
    arm = Plant(num=[2.3], den=[1, 0.7809, 0])
    assert discretise(arm, 0.1, "tustin", 2.0) == discretise(arm, 0.1, "prewarp", 2.0)


def test_matched_integrators_do_not_come_out_as_nan():
    # the arm of the paper: python-control 0.10.2 answers nan; by hand b (z+1)/((z-1)(z-E)),
    # 2.3/0.7809 the gain of 1/s, so 2 b/(1-E) = dt 2.3/0.7809
    got = discretise(Plant(num=[2.3], den=[1, 0.7809, 0]), 0.1, "matched")
    b = 0.1 * 2.3 / 0.7809 * (1 - exp(-0.07809)) / 2
    assert got.num == pytest.approx((b, b), rel=1e-13)


@pytest.mark.parametrize(
    ("method", "integrators", "kept"),
    [
        ("zoh", 0, 1),
        ("zoh", 1, 2),
        ("foh", 0, 2),
        ("foh", 1, 3),
        ("foh", 2, 3),
        ("impulse", 0, 0),
        ("impulse", 1, 1),
        ("matched", 0, 3),
        ("tustin", 1, 3),
    ],
)
def test_zeros_at_the_origin_stay_at_one_as_far_as_the_method_keeps_them(method, integrators, kept):
    # s^3 P0/(s^k) sampled for an input 1/s^i has min(3, k + i) factors z - 1, i = 0, 1, 2
    den = [1.0, 6.0, 11.0, 6.0, 0.5] + [0.0] * integrators
    got = discretise(Plant(num=[1, 0, 0, 0], den=den), 0.3, method)
    assert got.num_w[len(got.num_w) - kept :] == (0.0,) * kept
    assert got.num_w[len(got.num_w) - kept - 1] != 0.0


roots = st.lists(
    st.one_of(
        st.floats(-3, -0.05).map(lambda x: (x,)),
        st.tuples(st.floats(-2, -0.05), st.floats(0.1, 3)).map(
            lambda x: (complex(*x), complex(*x).conjugate())
        ),
    ),
    min_size=1,
    max_size=3,
).map(lambda parts: [r for part in parts for r in part])
zeros = st.lists(st.floats(-3, 3).filter(lambda z: abs(z) > 0.05), max_size=2)
times = st.floats(1e-4, 2)
gains = st.floats(0.01, 100)
rational = st.sampled_from(["tustin", "forward", "backward"])
proper = st.sampled_from(sorted(set(METHODS) - {"prewarp", "impulse"}))


def build(zeros, poles, gain=1.0, dead_time=0.0):
    return Plant.zpk(zeros=zeros[: len(poles)], poles=poles, gain=gain, dead_time=dead_time)


@given(zeros, roots, gains, times)
def test_in_tustin_w_is_s_to_the_bit(zeros, poles, gain, dt):
    plant = build(zeros, poles, gain)
    got = discretise(plant, dt, "tustin")
    assert got.den_w == plant.den
    assert got.num_w[len(got.num_w) - len(plant.num) :] == plant.num
    assert not any(got.num_w[: len(got.num_w) - len(plant.num)])


@given(zeros, roots, times, st.floats(0.01, 0.99))
def test_tustin_has_every_gain_at_the_warped_frequency(zeros, poles, dt, share):
    plant, w = build(zeros, poles), share * pi / dt
    got, truth = discretise(plant, dt, "tustin").at(w), plant.at(2 / dt * tan(w * dt / 2))
    assume(abs(truth) > 1e-6)  # on a zero neither has digits
    assert got == pytest.approx(truth, rel=1e-10)


@given(zeros, roots, times, st.floats(0.01, 0.99))
def test_prewarp_is_exact_where_it_says(zeros, poles, dt, share):
    plant, wp = build(zeros, poles), share * pi / dt
    truth = plant.at(wp)
    scale = abs(build([], poles).at(wp)) * (1 + wp) ** len(zeros)  # of the terms that cancel
    assert abs(discretise(plant, dt, "prewarp", wp).at(wp) - truth) <= 1e-11 * scale


@given(roots, times)
def test_backward_takes_the_left_half_plane_inside(poles, dt):
    found = discretise(build([], poles), dt, "backward").poles()
    assert (np.abs(found) < 1).all()
    # into a smaller circle even: centre 1/2, radius 1/2
    assert (np.abs(found - 0.5) < 0.5 + 1e-4).all()  # 1e-4: equal poles in floats


@given(roots, times)
def test_forward_puts_each_pole_on_a_straight_line(poles, dt):
    found = np.sort_complex(discretise(build([], poles), dt, "forward").poles())
    truth = np.sort_complex(1 + np.array(poles) * dt)
    # equal poles leave each other by the sixth root of rounding in floats
    assert np.poly(found) == pytest.approx(np.poly(truth), rel=1e-6, abs=1e-9)


@given(proper, zeros, roots, times)
def test_gain_at_rest_is_kept(method, zeros, poles, dt):
    plant = build(zeros, poles)
    truth = plant.num[-1] / plant.den[-1]
    assume(abs(1 + max(abs(p) for p in poles) * dt) < 50)
    got = discretise(plant, dt, method)
    assert got.num_w[-1] / got.den_w[-1] == pytest.approx(truth, rel=1e-13)


@given(roots, times, st.integers(1, 3))
def test_matched_integrators_keep_their_limit(poles, dt, k):
    plant = build([], [*poles, *[0.0] * k])
    got = discretise(plant, dt, "matched")
    truth = 1 / np.prod([-p for p in poles]).real
    assert got.den_w[-k:] == (0.0,) * k
    assert got.num_w[-1] / got.den_w[-1 - k] == pytest.approx(truth, rel=1e-12)


@given(st.sampled_from(sorted(METHODS)), roots, times, gains)
def test_gain_and_sensor_go_through(method, poles, dt, k):
    wp = 1 / dt if method == "prewarp" else None
    plain = discretise(build([], poles), dt, method, wp)
    loud = Plant.from_exact(*build([], poles).exact, sensor=k)
    assert discretise(loud, dt, method, wp).num == pytest.approx(
        [k * c for c in plain.num], rel=1e-14
    )


@given(st.sampled_from(sorted(METHODS)), roots, times, st.integers(0, 4))
def test_whole_samples_of_dead_time_are_powers_of_z(method, poles, dt, m):
    wp = 1 / dt if method == "prewarp" else None
    plain = discretise(build([], poles), dt, method, wp)
    late = discretise(build([], poles, dead_time=m * dt), dt, method, wp)
    assert late.num == plain.num
    assert late.den == plain.den + (0.0,) * m
    assert (late.num_w, late.den_w, late.delay) == (plain.num_w, plain.den_w, m)


@given(st.sampled_from(["impulse", "foh"]), roots, st.floats(0.05, 0.95))
def test_a_fraction_of_dead_time_is_the_response_itself(method, poles, share):
    # a lag's responses are known: g = e^(-a t), r = (t - (1 - e^(-a t))/a)/a
    a, dt = abs(poles[0].real), 0.7
    plant = Plant(num=[1], den=[1, a], dead_time=share * dt)
    t = np.arange(1, 6) * dt - share * dt
    if method == "impulse":
        truth, shift = dt * np.exp(-a * t), 1
    else:
        r = np.where(t > 0, (t + np.expm1(-a * t) / a) / a, 0)
        truth, shift = np.diff(np.diff(r, prepend=0), prepend=0) / dt, 0
    got = pulses(discretise(plant, dt, method), 6)
    # 1e-9: the second difference of r takes some digits from the reference
    assert got[shift : shift + 5] == pytest.approx(truth, rel=1e-9, abs=1e-12)


def pulses(system, count):
    num = [0.0] * (len(system.den) - len(system.num)) + list(system.num) + [0.0] * count
    out = []
    for j in range(count):
        past = sum(system.den[i] * out[j - i] for i in range(1, min(j, len(system.den) - 1) + 1))
        out.append(num[j] - past)
    return out


@pytest.mark.parametrize("method", sorted(METHODS))
def test_refuses_a_sample_time_that_is_none(method):
    for dt in (0.0, -1.0, nan, inf, "0.1", None):
        with pytest.raises(SpecError, match="dt must be"):
            discretise(Plant(num=[1], den=[1, 1]), dt, method)


@pytest.mark.parametrize("method", ["bilinear", "", None, 3, ["zoh"]])
def test_refuses_an_unknown_method_with_the_list(method):
    with pytest.raises(SpecError, match="method must be a known method") as error:
        discretise(Plant(num=[1], den=[1, 1]), 0.1, method)
    assert error.value.way_out == f"one of {', '.join(METHODS)}"


def test_refuses_what_is_no_plant():
    with pytest.raises(SpecError, match=r"system must be a zoh\.Plant"):
        discretise(Sampled(num=[1], den=[1, 1], dt=0.1), 0.1, "tustin")


def test_an_improper_plant_does_not_exist():
    with pytest.raises(SpecError, match="must not have a higher degree"):
        discretise(Plant(num=[1, 0, 0], den=[1, 1]), 0.1, "tustin")


def test_refuses_the_impulse_response_of_feedthrough():
    with pytest.raises(SpecError, match="must have no feedthrough"):
        discretise(Plant(num=[1, 2], den=[1, 1]), 0.1, "impulse")


@pytest.mark.parametrize("method", ["tustin", "prewarp", "matched", "forward", "backward"])
def test_refuses_a_fraction_of_dead_time_and_names_the_way_out(method):
    wp = 1.0 if method == "prewarp" else None
    with pytest.raises(SpecError, match=r"dead_time must be a whole number.*method 'zoh'"):
        discretise(Plant(num=[1], den=[1, 1], dead_time=0.05), 0.1, method, wp)


@pytest.mark.parametrize("wp", [None, 0.0, -1.0, nan, inf, "1"])
def test_refuses_a_prewarp_frequency_that_is_none(wp):
    with pytest.raises(SpecError, match="prewarp must be"):
        discretise(Plant(num=[1], den=[1, 1]), 0.1, "prewarp", wp)


@pytest.mark.parametrize("wp", [pi / 0.1, 40.0])
def test_refuses_to_prewarp_at_nyquist_and_above(wp):
    with pytest.raises(SpecError, match=re.escape("pi/dt = 31.4159 rad/s")):
        discretise(Plant(num=[1], den=[1, 1]), 0.1, "tustin", wp)


@pytest.mark.parametrize("method", sorted(set(METHODS) - {"tustin", "prewarp"}))
def test_refuses_a_prewarp_frequency_that_nothing_uses(method):
    with pytest.raises(SpecError, match="prewarp must be left out"):
        discretise(Plant(num=[1], den=[1, 1]), 0.1, method, 1.0)


@pytest.mark.parametrize(("method", "pole"), [("tustin", 4.0), ("backward", 2.0)])
def test_refuses_a_pole_that_would_come_before_its_input(method, pole):
    with pytest.raises(SpecError, match=re.escape(f"s = {pole:g} rad/s to z = infinity")):
        discretise(Plant(num=[1], den=[1, -pole]), 0.5, method)
    assert discretise(Plant(num=[1], den=[1, -pole]), 0.5, "forward").den == (1, -1 - pole / 2)


@pytest.mark.parametrize("method", ["zoh", "foh", "impulse", "matched"])
@pytest.mark.parametrize("pole", [1.0, 1e20])  # exp(1e23) is beyond decimals too
def test_refuses_a_plant_that_leaves_the_floats_within_a_sample(method, pole):
    with pytest.raises(SpecError, match="sample faster"):
        discretise(Plant(num=[1], den=[1, -pole]), 1e3, method)


def test_order_twenty_with_repeated_poles_is_right_at_any_sample_time():
    plant = Plant.zpk(
        zeros=[-0.5], poles=[-1.0] * 12 + [-0.3, 0.2] + [-1 + 2j, -1 - 2j] * 3, gain=1
    )
    for dt in (1.0, 1e-3, 1e-7):
        got = discretise(plant, dt, "matched")
        with mp.workdps(60):
            truth = [mpf(1)]
            for p in [-1.0] * 12 + [-0.3, 0.2] + [-1 + 2j, -1 - 2j] * 3:
                e = mp.exp(mp.mpc(p) * mpf(dt))
                truth = [a - e * b for a, b in zip([*truth, 0], [0, *truth], strict=True)]
            assert_same(got.den, [mp.re(c) for c in truth], 1e-14)
