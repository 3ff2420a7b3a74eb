"""sample is the exact zero-order hold, at any sample time and any dead time."""

import json
from fractions import Fraction
from itertools import zip_longest
from math import ceil, exp, inf, nan
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf

from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

CASES = json.loads((Path(__file__).parents[1] / "oracles" / "hold.json").read_text())
UNDERFLOW = 1e-300  # a coefficient such as exp(-780) is a zero in floats


def case_id(case):
    return f"{case['plant']}-{case['dt']:g}-{case['dead_time'] / case['dt']:.3g}"


@pytest.fixture(params=CASES, ids=case_id)
def case(request):
    return request.param


def plant_of(case, dead_time):
    return Plant(num=case["num"], den=case["den"], dead_time=dead_time, sensor=case["sensor"])


def assert_same(got, truth, rel):
    pairs = list(zip_longest(reversed(got), reversed(truth), fillvalue=0))
    wrong = [(g, t) for g, t in pairs if abs(mpf(g) - mpf(t)) > rel * abs(mpf(t)) + UNDERFLOW]
    assert not wrong


def test_z_coefficients_are_those_of_fifty_digits(case):
    held = sample(plant_of(case, case["dead_time"]), case["dt"])
    assert held.dt == case["dt"]
    assert_same(held.num, case["num_z"], 1e-15)
    assert_same(held.den, case["den_z"] + ["0"] * case["m"], 1e-15)


def test_w_coefficients_are_those_of_fifty_digits(case):
    held = sample(plant_of(case, case["dead_time"]), case["dt"])
    assert held.delay == case["m"]
    with mp.workdps(50):
        at = next(i for i, c in enumerate(case["den_w"]) if mpf(c))
        scale = mpf(held.den_w[at]) / mpf(case["den_w"][at])
        assert_same(held.den_w, [mpf(c) * scale for c in case["den_w"]], 1e-15)
        assert_same(held.num_w, [mpf(c) * scale for c in case["num_w"]], 1e-15)


def test_dead_time_and_compute_delay_are_one_delay(case):
    one = sample(plant_of(case, case["dead_time"]), case["dt"])
    other = sample(plant_of(case, 0.0), case["dt"], compute_delay=case["dead_time"])
    assert one == other


# Worked by hand, h = dt:
#   1/s^2 held is h^2/2 (z+1)/(z-1)^2; late by e = 0.3 h, with r = 1 - 0.3, the modified
#   z-transform is h^2/2 (r^2 z^2 + (1 + 2r - 2r^2) z + (1-r)^2)/(z (z-1)^2)
#   1/(s+1) held is (1-E)/(z-E), E = exp(-h); late by 0.3 h its first sample is 1 - exp(-r h)
#   (s+2)/(s+1) = 1 + 1/(s+1)
E = exp(-0.5)
BY_HAND = [
    ([1], [1, 0], 0.0, (0.5,), (1, -1)),
    ([1], [1, 0, 0], 0.0, (0.125, 0.125), (1, -2, 1)),
    ([1], [1, 0, 0], 0.15, (0.06125, 0.1775, 0.01125), (1, -2, 1, 0)),
    ([1], [1, 0, 0], 0.5, (0.125, 0.125), (1, -2, 1, 0)),
    ([1], [1, 1], 0.0, (1 - E,), (1, -E)),
    ([1], [1, 1], 0.15, (1 - exp(-0.35), exp(-0.35) - E), (1, -E, 0)),
    ([1, 2], [1, 1], 0.0, (1, 1 - 2 * E), (1, -E)),
    ([3], [2], 0.0, (1.5,), (1,)),
    ([3], [2], 0.15, (1.5,), (1, 0)),
]


@pytest.mark.parametrize(("num", "den", "dead_time", "num_z", "den_z"), BY_HAND)
def test_matches_hand_worked_coefficients(num, den, dead_time, num_z, den_z):
    held = sample(Plant(num=num, den=den, dead_time=dead_time), 0.5)
    assert held.num == pytest.approx(num_z, rel=1e-14)
    assert held.den == pytest.approx(den_z, rel=1e-14)


def test_three_tenths_is_three_samples_of_a_tenth():
    whole = sample(Plant(num=[1], den=[1, 1], dead_time=0.1 * 3), 0.1)
    assert whole.num == sample(Plant(num=[1], den=[1, 1]), 0.1).num
    assert whole.den[2:] == (0.0, 0.0, 0.0)


poles = st.lists(st.floats(0.05, 5), min_size=1, max_size=4)
gains = st.floats(0.01, 100)
times = st.floats(1e-4, 2)
shares = st.sampled_from([0.0, 0.25, 0.7, 1.0, 2.6])


def lags(poles, gain=1.0, dead_time=0.0):
    return Plant.zpk(zeros=[], poles=[-p for p in poles], gain=gain, dead_time=dead_time)


@given(poles, times, shares, gains)
def test_gain_goes_through(poles, dt, share, k):
    plain = sample(lags(poles, 1.0, share * dt), dt)
    louder = sample(lags(poles, k, share * dt), dt)
    assert louder.den == plain.den
    assert louder.num == pytest.approx([k * c for c in plain.num], rel=1e-14)


@given(poles, times, shares, st.integers(-8, 8))
def test_only_the_product_of_pole_and_sample_time_matters(poles, dt, share, power):
    c = 2.0**power  # a power of two, so that the scaled floats are the scaled plant
    gain = 1.0
    slow = sample(lags(poles, gain, share * dt), dt)
    slower = sample(lags([p / c for p in poles], gain / c ** len(poles), share * dt * c), dt * c)
    assert slower.num == pytest.approx(slow.num, rel=1e-14)
    assert slower.den == pytest.approx(slow.den, rel=1e-14)


@given(poles, times, shares)
def test_a_constant_input_comes_out_as_from_the_plant(poles, dt, share):
    plant = lags(poles, 1.0, share * dt)
    assert sample(plant, dt).at(0.0) == pytest.approx(plant.at(0.0), rel=1e-13)


@given(poles, times)
def test_poles_go_to_exp_of_themselves(poles, dt):
    held = sample(lags(poles), dt)
    truth = [mpf(1)]
    with mp.workdps(50):
        for p in poles:
            e = mp.exp(-mpf(p) * mpf(dt))
            truth = [a - e * b for a, b in zip([*truth, 0], [0, *truth], strict=True)]
    assert_same(held.den, truth, 1e-14)


@given(poles, poles, times, shares)
def test_the_hold_of_a_sum_is_the_sum_of_the_holds(one, two, dt, share):
    first, second = lags(one, 1.0), lags(two, 1.0)
    with mp.workdps(40):
        top = [mpf(0)] * 9
        for a, b in ((first.num, second.den), (second.num, first.den)):
            flat = [mpf(0)] * 9
            for i, x in enumerate(a):
                for j, y in enumerate(b):
                    flat[9 - len(a) - len(b) + 1 + i + j] += mpf(x) * mpf(y)
            top = [x + y for x, y in zip(top, flat, strict=True)]
    both = lags([*one, *two])
    parallel = Plant(num=[float(c) for c in top], den=both.den, dead_time=share * dt)
    w = 0.4 / dt
    parts = [sample(lags(p, 1.0, share * dt), dt).at(w) for p in (one, two)]
    # 1e-9: the rounded coefficients of the parallel plant are not the two plants to the last bit,
    # and eight lags that are slow against 1/dt magnify that by far less than 1e7
    largest = max(map(abs, parts))
    assert sample(parallel, dt).at(w) == pytest.approx(sum(parts), rel=1e-9, abs=1e-9 * largest)


@given(poles, st.floats(1e-3, 1), shares)
def test_far_below_nyquist_it_is_the_plant_half_a_sample_late(poles, dt, share):
    plant = lags(poles, 1.0, share * dt)
    w = 1e-3 / dt
    held = sample(plant, dt).at(w)
    hold = (1 - exp_j(-w * dt)) / (1j * w * dt)
    # 1e-3: the alias at w - 2 pi/dt is let through by the ratio 1e-3/(2 pi), times a first-order
    # lag's fall from w to there, at most 1e-3/(2 pi) again but for a plant flat over both: 1e-3
    assert held == pytest.approx(plant.at(w) * hold, rel=1e-3)


def exp_j(x):
    return complex(mp.expj(x))


@pytest.mark.parametrize("dt", [0.0, -1.0, nan, inf, "0.1", True, None])
def test_refuses_a_sample_time_that_is_none(dt):
    with pytest.raises(SpecError, match="dt must be"):
        sample(Plant(num=[1], den=[1, 1]), dt)


@pytest.mark.parametrize("delay", [-1e-9, nan, inf, "x"])
def test_refuses_a_compute_delay_that_is_none(delay):
    with pytest.raises(SpecError, match="compute_delay must be"):
        sample(Plant(num=[1], den=[1, 1]), 0.1, compute_delay=delay)


def test_refuses_to_sample_what_is_sampled():
    with pytest.raises(SpecError, match=r"plant must be a zoh\.Plant"):
        sample(Sampled(num=[1], den=[1, 1], dt=0.1), 0.1)


def test_refuses_a_plant_that_leaves_the_floats_within_a_sample():
    with pytest.raises(SpecError, match="sample faster"):
        sample(Plant(num=[1], den=[1, -1]), 1e3)


def test_refuses_a_plant_whose_gain_is_lost_within_a_sample():
    with pytest.raises(SpecError, match="a gain that a float can hold"):
        sample(Plant(num=[1], den=[1, 0, 0]), 1e-200)  # dt^2/2


@pytest.mark.parametrize("delay", [0.0, 0.35, 2.0])
@pytest.mark.parametrize("dt", [1e-5, 0.3, 2.0])
def test_finer_coefficients_have_two_hundred_and_fifty_bits(dt, delay):
    """k/((s + a)(s + b)) and behind it a hidden mode, at three points w, in 100 digits."""
    k, a, b = 1.25, 0.7, 3.0
    plain = Plant.zpk(zeros=[], poles=[-a, -b], gain=k, dead_time=delay * dt)
    mode = [complex(-0.1, 5.0), complex(-0.1, -5.0)]
    hiding = Plant.zpk(zeros=mode, poles=[-a, -b, *mode], gain=k, dead_time=delay * dt)
    with mp.workdps(100):
        step = mpf(dt)
        lead = ceil(delay) * step - mpf(delay * dt)
        p = (-mpf(a), -mpf(b))
        residues = [k / p[0] / (p[0] - p[1]), k / p[1] / (p[1] - p[0])]
        for system in (sample(plain, dt), sample(hiding, dt)):
            assert system.off == 2.0**-53
            finer = system.finer
            assert (finer.num, finer.den, finer.num_w) == (system.num, system.den, system.num_w)
            assert finer.off < 2.0**-250
            num, den, _ = finer.whole_w
            for w in (mp.mpc(0.1, 0.2), mp.mpc(0, 1), mp.mpc(-3, 0.5)):
                back = (1 - w * step / 2) / (1 + w * step / 2)
                held = k / (p[0] * p[1])
                for r, q in zip(residues, p, strict=True):
                    held += r * mp.exp(q * lead) * (1 - back) / (1 - mp.exp(q * step) * back)
                top, bottom = (sum(c * w**i for i, c in enumerate(x[::-1])) for x in (num, den))
                # 1e-65: powers of a small dt cancel in the truth, which began with 100 digits
                assert abs(top / bottom / held - 1) < mpf(10) ** -65


@pytest.mark.parametrize("delay", [0.0, 0.35])
def test_with_more_digits_an_integrator_stays_one(delay):
    """1/(s (s^2 + 1)): its denominator in w is w (w^2 + q), q = (tan(dt/2) 2/dt)^2, and no more."""
    dt = 0.5
    plant = Plant.zpk(zeros=[], poles=[0, 1j, -1j], gain=1.0, dead_time=delay * dt)
    _, den, _ = sample(plant, dt).finer.whole_w
    assert (den[1], den[3]) == (0, 0)
    with mp.workdps(100):
        q = (2 / mpf(dt) * mp.tan(mpf(dt) / 2)) ** 2
        assert abs(mpf(den[2]) / den[0] / q - 1) < mpf(2) ** -250


@pytest.mark.parametrize("delay", [0.0, 0.35, 2.0])
@pytest.mark.parametrize("dt", [1e-5, 0.3])
@pytest.mark.parametrize("hidden", ["", "(s+0.5)"])
def test_finer_coefficients_have_the_plants_own_gain_at_rest(dt, delay, hidden):
    plant = Plant.parse(
        f"{hidden}(0.7 s + 0.3)/({hidden}(s^2 + 1.1 s - 7))"
        if hidden
        else "(0.7 s + 0.3)/(s^2 + 1.1 s - 7)"
    )
    num, den, _ = sample(plant, dt, delay * dt).finer.whole_w
    gain = Fraction(plant.exact[0][-1]) / Fraction(plant.exact[1][-1])
    assert Fraction(num[-1], den[-1]) == gain
