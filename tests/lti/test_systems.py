"""Plant and Sampled: made once, checked, and never mixed."""

import dataclasses
from fractions import Fraction
from math import cos, inf, nan, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from mpmath import mp

from zoh.errors import SpecError
from zoh.lti import whole
from zoh.lti.given import MAX_ORDER
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample


def value(a, x):
    """Return a(x) by Horner's rule in mpmath's present precision."""
    total = mp.mpc(0)
    for c in a:
        total = total * x + mp.mpf(c)
    return total


ARM = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)


def test_a_plant_at_a_frequency_by_hand():
    # 1/(j(j+1)) = 1/(j-1) = -(1+j)/2; sensor 2; dead time 0.5 s turns by -0.5 rad
    plant = Plant(num=[1], den=[1, 1, 0], dead_time=0.5, sensor=2.0)
    wanted = -(1 + 1j) * complex(cos(0.5), -sin(0.5))
    assert plant.at(1.0) == pytest.approx(wanted, rel=1e-14)
    assert isinstance(plant.at(1.0), complex)
    assert plant.at([1.0, 1.0]) == pytest.approx([wanted, wanted], rel=1e-14)


def test_infinite_at_a_pole():
    assert abs(ARM.at(0.0)) == inf
    assert abs(Sampled(num=[1], den=[1, -1], dt=0.1).at(0.0)) == inf


def test_poles_and_zeros_of_a_plant():
    plant = Plant(num=[2, 6], den=[1, 3, 2])
    assert np.sort(plant.poles().real) == pytest.approx([-2, -1], rel=1e-12)
    assert plant.zeros().real == pytest.approx([-3], rel=1e-14)


def test_a_formula_a_table_of_roots_and_a_state_space_are_one_plant():
    made = [
        Plant.parse("2.3/(s^2 + 0.7809 s)", sensor=12 / 180),
        Plant.zpk(zeros=[], poles=[0, -0.7809], gain=2.3, sensor=12 / 180),
        Plant.ss([[0, 1], [0, -0.7809]], [[0], [2.3]], [[1, 0]], [[0]], sensor=12 / 180),
    ]
    for plant in made:
        assert (plant.num, plant.den, plant.sensor) == (ARM.num, ARM.den, ARM.sensor)


def test_dead_time_stands_in_one_place():
    assert Plant.parse("1/(s+1)", dead_time=0.2).dead_time == 0.2
    with pytest.raises(SpecError, match="dead_time"):
        Plant.parse("exp(-0.1 s)/(s+1)", dead_time=0.2)


@given(st.lists(st.floats(-2, 2), min_size=1, max_size=5), st.floats(0.01, 3), st.floats(1e-5, 10))
def test_a_sampled_system_at_a_frequency_is_its_fraction_in_z(poles, gain, dt):
    den = [float(c) for c in np.poly(poles)]
    system = Sampled(num=[gain, 0.3], den=den, dt=dt)
    for share in (0.01, 0.5, 0.99, 1.0):
        w = share * pi / dt
        with mp.workdps(40):
            z = mp.expj(mp.mpf(w) * mp.mpf(dt))
            bottom = value(den, z)
            scale = sum(map(abs, den))
            assume(abs(bottom) > 1e-3 * scale)
            truth = complex((mp.mpf(gain) * z + mp.mpf(0.3)) / bottom)
        # 1e-11: the denominator is down to a thousandth of its terms, and so may the numerator be
        assert system.at(w) == pytest.approx(truth, rel=1e-11, abs=1e-11)


@given(
    st.lists(st.floats(-2, 2), min_size=1, max_size=5),
    st.integers(0, 3),
    st.floats(1e-3, 1),
    st.floats(0, 40),
)
def test_one_frequency_and_an_array_are_one_answer(poles, delay, dt, wc):
    den = [float(c) for c in np.poly(poles)]
    system = Sampled.from_w(num_w=[0.7, 1.3], den_w=den, dt=dt, delay=delay)
    one, many = system.at(wc), system.at([wc])[0]
    assert one == many or one == pytest.approx(many, rel=1e-12)


def test_nyquist_is_a_frequency_like_any_other():
    assert Sampled(num=[0.1], den=[1, -0.9], dt=0.1).at(pi / 0.1) == pytest.approx(-0.1 / 1.9)


@pytest.mark.parametrize("dt", [1e-5, 0.1, 10.0])
def test_poles_and_zeros_in_z(dt):
    system = Sampled(num=[1, 0.5], den=[1, -0.7, -0.6], dt=dt)  # (z + 0.5)/((z - 1.2)(z + 0.5))
    assert np.sort(system.poles().real) == pytest.approx([-0.5, 1.2], rel=1e-12)
    assert system.zeros().real == pytest.approx([-0.5], rel=1e-12)


def test_a_pole_at_minus_one_and_one_at_zero():
    system = Sampled(num=[1], den=[1, 1, 0], dt=0.1)
    assert np.sort(system.poles().real) == pytest.approx([-1, 0], abs=1e-12)


@given(
    st.lists(st.floats(-0.9, 0.9), min_size=1, max_size=4),
    st.lists(st.floats(-0.9, 0.9), min_size=1, max_size=4),
    st.floats(0.01, 0.99),
)
def test_series_multiplies_responses(one, two, share):
    a = Sampled(num=[0.5], den=np.poly(one), dt=0.1)
    b = Sampled(num=[1.0, 0.2], den=np.poly(two), dt=0.1)
    w = share * pi / 0.1
    assert (a * b).at(w) == pytest.approx(a.at(w) * b.at(w), rel=1e-12)
    assert (a * b).den == pytest.approx(np.convolve(a.den, b.den), rel=1e-12, abs=1e-13)


def test_the_whole_w_form_is_what_was_given_and_not_the_floats_of_it():
    """0.1/(z - 0.9) at z = (1 + w/2)/(1 - w/2), in fractions; from w its own floats."""
    given_in_z = Sampled(num=[0.1], den=[1.0, -0.9], dt=1.0)
    num, den, unit = given_in_z.whole_w
    half, top, pole = Fraction(1, 2), Fraction(0.1), Fraction(0.9)
    assert [Fraction(c, unit) for c in num] == [-half * top, top]
    assert [Fraction(c, unit) for c in den] == [half * (1 + pole), 1 - pole]
    in_w = Sampled.from_w(num_w=(3.0,), den_w=(1.0, 0.1), dt=0.5)
    num, den, unit = in_w.whole_w
    assert [Fraction(c, unit) for c in num] == [0, 3]
    assert [Fraction(c, unit) for c in den] == [1, Fraction(0.1)]
    assert in_w.whole_w == (num, den, unit)


def test_series_refuses_two_clocks_and_two_kinds():
    fast, slow = (Sampled(num=[1], den=[1, 0], dt=dt) for dt in (0.1, 0.2))
    with pytest.raises(SpecError, match=r"dt must be the same.*0\.2"):
        fast * slow
    with pytest.raises(TypeError):
        fast * ARM
    with pytest.raises(TypeError):
        fast * 2.0


@given(
    st.lists(st.floats(-5, 5), min_size=1, max_size=4),
    st.lists(st.floats(-5, 5), min_size=1, max_size=4),
    st.integers(0, 3),
)
def test_from_w_is_the_fraction_in_w(num, den, delay):
    assume(abs(den[0]) > 1e-6 and any(num) and len(num) <= len(den))
    dt = 0.2
    # z has a pole at infinity where den(w = 2/dt) = 0
    assume(abs(np.polyval(den, 2 / dt)) > 1e-2 * np.polyval(np.abs(den), 2 / dt))
    system = Sampled.from_w(num_w=num, den_w=den, dt=dt, delay=delay)
    assert system.den[0] == 1.0
    z = np.exp(0.7j)
    w = 2 / dt * (z - 1) / (z + 1)
    assume(abs(np.polyval(den, w)) > 1e-2 * np.polyval(np.abs(den), abs(w)))
    truth = np.polyval(num, w) / np.polyval(den, w) / z**delay
    scale = np.polyval(np.abs(num), abs(w)) / np.polyval(np.abs(den), abs(w))
    in_z = np.polyval(system.num, z) / np.polyval(system.den, z)
    # 1e-10: the two guards above let a factor of 1e4 of the roundings through
    assert in_z == pytest.approx(truth, rel=1e-10, abs=1e-10 * scale)
    assert system.at(0.7 / dt) == pytest.approx(truth, rel=1e-10, abs=1e-10 * scale)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Sampled.from_w(num_w=[1e300, 0, 0], den_w=[1e-300, 1e-300, 1.0], dt=1e-5),
        lambda: Sampled(num=[1], den=[1, 0.5, 0.25], dt=1e200),
    ],
)
def test_coefficients_that_no_float_holds_are_refused(make):
    with pytest.raises(SpecError, match=r"range in z and in w"):
        make()


def test_values_are_frozen_hashable_and_equal():
    assert ARM == Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    assert len({ARM, ARM}) == 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        ARM.sensor = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        Sampled(num=[1], den=[1], dt=0.1).dt = 0.2


def test_repr_makes_it_again():
    assert eval(repr(ARM)) == ARM
    system = Sampled(num=[0.1], den=[1, -0.9], dt=0.1)
    assert eval(repr(system)) == system


@pytest.mark.parametrize("dead_time", [6.0, 60.03, 900.0])
def test_a_delay_is_no_order_and_is_read_back(dead_time):
    """1/(10 s + 1) at 0.1 s: p = exp(-0.01), and D samples of delay, f of one less than ceil.

    By hand, with m the whole samples and f what is left of one: g(k) = 1 - p^(k - m - f) from
    k = m + 1 on, so that G = z^-m ((1 - p^(1-f)) z + p^(1-f) - p)/(z (z - p)).
    """
    system = sample(Plant(num=[1], den=[10, 1], dead_time=dead_time), 0.1)
    again = eval(repr(system), {"Sampled": Sampled})
    assert again == system
    with mp.workdps(40):
        late = mp.mpf(dead_time) / mp.mpf(0.1)  # of the floats; 1e-9: 0.1 is no decimal in them
        m = int(mp.floor(late + mp.mpf("1e-9")))
        f = mp.mpf(0) if abs(late - m) < mp.mpf("1e-9") else late - m
        p, z = mp.exp(mp.mpf(-0.1) / 10), mp.exp(mp.mpc(0, 0.3) * mp.mpf(0.1))
        q = p ** (1 - f)
        truth = ((1 - q) * z + q - p) / (z * (z - p)) / z**m
    # z^-9000 at 0.3 rad/s turns by 270 rad, rounded to 1e-13
    assert abs(again.at(0.3) - complex(truth)) < 1e-9 * abs(truth)
    assert again.delay == m + (f > 0)


def test_a_long_average_says_what_to_do_and_that_does():
    """64 taps: refused as one fraction, and sum z^-k = (1 + 1/z)(1 + 1/z^2) ... (1 + 1/z^32)."""
    with pytest.raises(SpecError, match=r"besides its delay .* got 63: .* multiply systems"):
        Sampled(num=[1 / 64] * 64, den=[1] + [0] * 63, dt=1)
    average = Sampled(num=[0.5, 0.5], den=[1, 0], dt=1)
    for k in (2, 4, 8, 16, 32):
        part = Sampled(num=[0.5] + [0] * (k - 1) + [0.5], den=[1] + [0] * k, dt=1)
        average = average * part
    wanted = sum(mp.exp(mp.mpc(0, -0.3) * k) for k in range(64)) / 64
    # 1e-11: a polynomial of order 63 in floats, which is why there is a bound
    assert abs(average.at(0.3) - complex(wanted)) < 1e-11


def test_a_delay_beyond_its_bound_is_refused():
    with pytest.raises(SpecError, match="1000000 samples of delay or fewer, got 1000001: sample"):
        Sampled(num=[1], den=[1] + [0] * 1_000_001, dt=1)
    with pytest.raises(SpecError, match=r"besides its delay .* got 51: reduce"):
        Sampled(num=[1], den=[1.0] * (MAX_ORDER + 2) + [0.0] * 9, dt=1)


BAD_PLANTS = [
    ({"num": [], "den": [1]}, "num must have at least one"),
    ({"num": [1], "den": []}, "den must have at least one"),
    ({"num": [1], "den": [0, 0]}, "den must not be all zeros"),
    ({"num": [0], "den": [1, 1]}, "num must not be all zeros"),
    ({"num": [1, 0, 0], "den": [1, 1]}, "num must not have a higher degree"),
    ({"num": [nan], "den": [1, 1]}, r"num\[0\] must be finite"),
    ({"num": [1], "den": [1, inf]}, r"den\[1\] must be finite"),
    ({"num": "1", "den": [1, 1]}, "num must be a list"),
    ({"num": ["1"], "den": [1, 1]}, r"num\[0\] must be a real number"),
    ({"num": [1j], "den": [1, 1]}, r"num\[0\] must be a real number"),
    ({"num": [True], "den": [1, 1]}, r"num\[0\] must be a real number"),
    ({"num": [10**400], "den": [1, 1]}, r"num\[0\] must fit"),
    ({"num": [1], "den": [1.0] * (MAX_ORDER + 2)}, "den must have order"),
    ({"num": [1], "den": [1, 1], "dead_time": -0.1}, "dead_time must be 0 or more"),
    ({"num": [1], "den": [1, 1], "dead_time": nan}, "dead_time must be finite"),
    ({"num": [1], "den": [1, 1], "sensor": 0}, "sensor must not be 0"),
    ({"num": [1], "den": [1, 1], "sensor": inf}, "sensor must be finite"),
]


@pytest.mark.parametrize(("arguments", "sentence"), BAD_PLANTS)
def test_a_plant_that_is_none_is_refused(arguments, sentence):
    with pytest.raises(SpecError, match=sentence) as err:
        Plant(**arguments)
    assert "\n" not in str(err.value)


@pytest.mark.parametrize("dt", [0, -0.1, nan, inf, "0.1", None, True])
def test_a_clock_that_is_none_is_refused(dt):
    with pytest.raises(SpecError, match="dt must be"):
        Sampled(num=[1], den=[1, 0], dt=dt)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"num": [1, 0], "den": [1]}, "num must not have a higher degree"),
        ({"num": [1], "den": [0]}, "den must not be all zeros"),
        ({"num": [0.0], "den": [1]}, "num must not be all zeros"),
    ],
)
def test_a_sampled_system_that_is_none_is_refused(arguments, sentence):
    with pytest.raises(SpecError, match=sentence):
        Sampled(**arguments, dt=0.1)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"zeros": [], "poles": [1j], "gain": 1}, "conjugate pairs"),
        ({"zeros": [], "poles": ["x"], "gain": 1}, "list of numbers"),
        ({"zeros": [], "poles": [inf], "gain": 1}, "must be finite"),
        ({"zeros": [-1], "poles": [], "gain": 1}, "higher degree"),
        ({"zeros": [], "poles": [-1], "gain": 0}, "not be all zeros"),
    ],
)
def test_roots_that_make_no_plant_are_refused(arguments, sentence):
    with pytest.raises(SpecError, match=sentence):
        Plant.zpk(**arguments)


@pytest.mark.parametrize(
    ("matrices", "sentence"),
    [
        (([[1, 2]], [1], [1]), "A must be square"),
        (([[1, 2], [3, 4]], [1], [1, 0]), "B must have 2 entries"),
        (([[1, 2], [3, 4]], [1, 0], [1]), "C must have 2 entries"),
        (([[1]], [1], [1], [1, 2]), "D must have 1 entries"),
        (([["x"]], [1], [1]), "A must be a matrix"),
        (([[nan]], [1], [1]), "A must be finite"),
        (([[-1]], [0], [1]), "not be all zeros"),
    ],
)
def test_matrices_that_make_no_plant_are_refused(matrices, sentence):
    with pytest.raises(SpecError, match=sentence):
        Plant.ss(*matrices)


def test_a_hidden_mode_stays_in_the_plant():
    plant = Plant.ss([[-1, 0], [0, 1]], [1, 0], [1, 1])  # the unstable mode is never excited
    assert len(plant.den) == 3
    assert max(plant.poles().real) == pytest.approx(1.0, rel=1e-12)


def test_a_product_is_that_of_the_whole_numbers():
    one = Sampled.from_w(num_w=[0.1, 0.3], den_w=[1.0, 0.7], dt=0.1)
    other = Sampled.from_w(num_w=[0.7, 0.9], den_w=[1.0, 0.1, 0.2], dt=0.1, delay=2)
    num, den, unit = (one * other).whole_w
    (a, b, u), (c, d, v) = one.whole_w, other.whole_w
    assert (num, den, unit) == (whole.times(a, c), whole.times(b, d), u * v)
    assert (one * other).num_w == tuple(x / unit for x in num)
    assert (one * other).delay == 2
    # the product of the floats in z, to a rounding of each
    assert (one * other).den == pytest.approx(np.polymul(one.den, other.den), rel=1e-14, abs=1e-15)
