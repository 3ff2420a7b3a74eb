"""A table is what was measured, between its points and nowhere else."""

import pickle
from math import inf, nan, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoh
from zoh.errors import SpecError
from zoh.lti.curve import Curve
from zoh.lti.frequency_response import FrequencyResponse

W = [1.0, 2.0, 4.0, 8.0]
SERVO = {"w": W, "magnitude": [1, 0.5, 0.25, 0.125], "phase_deg": [-90, -90, -90, -90]}

rises = st.lists(st.floats(0.01, 10), min_size=2, max_size=12)
values = st.floats(-100, 100)


@given(rises, st.data())
def test_the_curve_stays_between_its_neighbours(steps, data):
    x = np.concatenate([[0.0], np.cumsum(steps)])
    y = np.array(data.draw(st.lists(values, min_size=len(x), max_size=len(x))))
    curve = Curve(x=x, y=y)
    assert curve.at(x).tolist() == y.tolist()
    for i in range(len(x) - 1):
        inside = curve.at(np.linspace(x[i], x[i + 1], 50))
        slack = 1e-12 * np.abs(y).max()  # rounding of values up to 100
        assert inside.min() >= min(y[i], y[i + 1]) - slack
        assert inside.max() <= max(y[i], y[i + 1]) + slack
        assert (np.diff(inside) * (y[i + 1] - y[i]) >= -slack * 100).all()  # one way only


def test_the_curve_of_three_points_by_hand():
    # chords 1 and 3, inner slope 2 (the mean), first 1 - 1 = 0, last 4; Hermite's cubic on [1, 2]
    # at 1.5: (1 + 4)/2 + (2 - 4)/8 = 2.25, the parabola x^2
    assert Curve(x=np.array([0.0, 1, 2]), y=np.array([0.0, 1, 4])).at(1.5) == 2.25


def test_the_curve_lowers_a_slope_to_three_times_the_flatter_chord():
    # chords 1 and 99: the parabola's slope 50 becomes 3, the first -48 becomes 0;
    # Hermite at 0.5: 0.5 + (0 - 3)/8
    assert Curve(x=np.array([0.0, 1, 2]), y=np.array([0.0, 1, 100])).at(0.5) == 0.125


@pytest.mark.parametrize("x", [0.3, 1.7, 2.5])
def test_weights_rebuild_the_value_of_a_curve_whose_slopes_are_not_lowered(x):
    points = np.array([0.0, 1, 2, 3, 4])
    y = 2 * points + 0.01 * points**2
    curve = Curve(x=points, y=y)
    # linear in y there; 1e-9 is what differences of 1e-6 leave of a float's digits
    assert curve.weights(x) @ y == pytest.approx(curve.at(x), rel=1e-9)
    assert curve.weights(x).sum() == pytest.approx(1.0, abs=1e-9)


def test_the_error_between_points_falls_with_the_cube_of_the_spacing():
    # 1/(1 + jw): u = -ln(1 + e^2x)/2 and phi = -atan(e^x) have |f'''| <= 0.5 and |f''''| <= 1
    # in x = ln w. Slopes of the parabola are off by h^2 |f'''|/6, which shifts Hermite's cubic
    # by h max(t(1-t)|1-2t|) = 0.0963 h of that, and as the two slopes of a cell are not off by
    # the same by h/8 of h^3 |f''''|/6 more; the cubic itself is off by h^4 |f''''|/384.
    for count in (21, 81, 321):
        w = np.geomspace(0.01, 100, count)
        h = np.log(w[1] / w[0])
        table = FrequencyResponse.from_complex(w=w, gain=1 / (1 + 1j * w))
        inner = np.geomspace(w[1], w[-2], 3000)
        off = np.log(table.at(inner) * (1 + 1j * inner))
        bound = 0.0963 * h**3 * 0.5 / 6 + h**4 * (1 / 48 + 1 / 384)
        assert np.abs(off.real).max() <= bound + 1e-14
        assert np.abs(off.imag).max() <= bound + 1e-14


def test_every_way_in_is_the_same_table():
    plain = FrequencyResponse(**SERVO)
    db = FrequencyResponse.from_bode(
        hz=np.array(W) / (2 * pi), db=20 * np.log10([1, 0.5, 0.25, 0.125]), phase_deg=[-90] * 4
    )
    by_gain = FrequencyResponse.from_complex(w=W, gain=[-1j / w for w in W])
    for other in (db, by_gain):
        assert other.w == pytest.approx(plain.w, rel=1e-15)
        assert other.magnitude == pytest.approx(plain.magnitude, rel=1e-14)
        assert other.phase_deg == pytest.approx(plain.phase_deg, rel=1e-14)


BODE = {"hz": [1, 10], "db": [20, 0], "phase_deg": [0, -90]}
GAINS = {"w": [1, 2], "gain": [1, 1j]}


@pytest.mark.parametrize(
    ("way_in", "given", "told"),
    [
        ("bode", {"db": [nan, 0]}, "db must be finite, got nan: give one number for each row"),
        ("bode", {"db": ["a", 0]}, "db must be numbers, got ['a', 0]: give one"),
        ("bode", {"db": [1]}, "db must be 2 numbers, one per w, got (1,): complete"),
        ("bode", {"db": [0, -1e5]}, "db[1] must be a gain in dB within +-6160, got -100000.0"),
        ("bode", {"hz": [10, 1]}, "hz[1] must be above hz[0], got 1.0: sort"),
        ("bode", {"hz": [-1, 10]}, "hz[0] must be above 0, got -1.0: mend"),
        ("bode", {"hz": [1, inf]}, "hz must be finite, got inf: give one"),
        ("bode", {"hz": [1, 1e308]}, "hz[1] must be at most 1e+307 Hz, got 1e+308: leave"),
        ("bode", {"hz": [1]}, "hz must have two points or more, got [1.0]: measure"),
        ("bode", {"phase_deg": ["a", 0]}, "phase_deg must be numbers, got ['a', 0]: give one"),
        ("bode", {"dt": 0.1}, "hz must not go beyond the Nyquist frequency 1/(2 dt) = 5 Hz"),
        ("complex", {"gain": [1]}, "gain must be 2 numbers, one per w, got (1,): complete"),
        ("complex", {"gain": [1, 0]}, "gain[1] must have a size above 0 that a 64-bit float can"),
        ("complex", {"w": [2, 1]}, "w[1] must be above w[0], got 1.0: sort"),
    ],
)  # fmt: skip
def test_a_column_is_spoken_of_as_it_was_given(way_in, given, told):
    ways = {"bode": FrequencyResponse.from_bode, "complex": FrequencyResponse.from_complex}
    columns = {**(BODE if way_in == "bode" else GAINS), **given}
    with pytest.raises(SpecError) as refused:
        ways[way_in](**columns)
    assert str(refused.value).startswith(told)


def test_a_bode_table_may_end_at_nyquists_frequency():
    """10 Hz at dt = 0.05 s is 1/(2 dt)."""
    assert FrequencyResponse.from_bode(**BODE, dt=0.05).reaches_nyquist


def test_phase_may_be_wrapped_in_any_way():
    straight = [-100.0, -170.0, -240.0, -310.0]
    for turns in ([0, 0, 1, 1], [0, 1, -1, 2], [0, 0, 0, 0]):
        given_deg = [p + 360 * k for p, k in zip(straight, turns, strict=True)]
        table = FrequencyResponse(w=W, magnitude=[1] * 4, phase_deg=given_deg)
        assert table.phase_deg.tolist() == straight
        assert table.ambiguous == ()
    turned = FrequencyResponse(w=W, magnitude=[1] * 4, phase_deg=[0, -130, -140, -150])
    assert turned.ambiguous == (0,)


def test_it_is_frozen_and_survives_a_pickle():
    table = FrequencyResponse(**SERVO, dt=0.1, uncertainty=0.01)
    for column in (table.w, table.magnitude, table.phase_deg, table.uncertainty):
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 3.0
    with pytest.raises(AttributeError):
        table.dt = 1.0
    again = pickle.loads(pickle.dumps(table))
    assert again.at(3.0) == table.at(3.0)


def test_what_the_caller_keeps_does_not_change_it():
    mine = np.array(W)
    table = FrequencyResponse(**{**SERVO, "w": mine})
    mine[0] = 0.5
    assert table.w[0] == 1.0


def test_the_nyquist_frequency_is_the_last_that_a_sampled_table_has():
    dt = pi / 8
    assert FrequencyResponse(**SERVO, dt=dt).reaches_nyquist
    assert not FrequencyResponse(**SERVO, dt=0.9 * dt).reaches_nyquist
    assert not FrequencyResponse(**SERVO).reaches_nyquist
    with pytest.raises(SpecError, match=r"w must not go beyond the Nyquist .* 7.2\d+ rad/s"):
        FrequencyResponse(**SERVO, dt=dt * 1.1)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"w": [1, 2, 4]}, r"magnitude must be 3 numbers, one per w, got \(4,\)"),
        ({"w": [1, 2, 2, 3]}, r"w\[2\] must be above w\[1\], got 2"),
        ({"w": [1, 4, 2, 8]}, r"w\[2\] must be above w\[1\], got 2"),
        ({"w": [0, 1, 2, 3]}, r"w\[0\] must be above 0, got 0"),
        ({"w": [1, 2, 3, np.nan]}, "w must be finite"),
        ({"w": "fast"}, "w must be numbers, got 'fast'"),
        ({"w": [[1, 2], [3, 4]]}, "w must be one column"),
        ({"magnitude": [1, 1, 0, 1]}, r"magnitude\[2\] must be above 0, got 0"),
        ({"magnitude": [1, 1, -3, 1]}, r"magnitude\[2\] must be above 0, got -3"),
        ({"magnitude": [1, 1, 1j, 1]}, "magnitude must be numbers"),
        ({"phase_deg": [0, 0, np.inf, 0]}, "phase_deg must be finite"),
        ({"phase_deg": None}, "phase_deg must be numbers, got None"),
        ({"dt": 0.0}, "dt must be above 0"),
        ({"dt": "1 ms"}, "dt must be a real number"),
        ({"uncertainty": [0.1, 0.1]}, "uncertainty must be 4 numbers"),
        ({"uncertainty": -0.1}, r"uncertainty\[0\] must be 0 or more, got -0.1"),
        ({"neglected": [0, 0, 0, -1]}, r"neglected\[3\] must be 0 or more, got -1"),
        ({"unstable_poles": -1}, "unstable_poles must be a whole number of 0 or more, got -1"),
        ({"unstable_poles": 0.5}, "unstable_poles must be a whole number of 0 or more, got 0.5"),
    ],
)
def test_bad_columns_are_named(change, says):
    with pytest.raises(SpecError, match=says):
        FrequencyResponse(**{**SERVO, **change})


def test_one_point_is_no_table():
    with pytest.raises(SpecError, match="w must have two points or more"):
        FrequencyResponse(w=[1], magnitude=[1], phase_deg=[0])


@pytest.mark.parametrize("wc", [0.999, 8.001, -1.0, [2.0, 9.0]])
def test_outside_the_table_nothing_is_known(wc):
    with pytest.raises(SpecError, match="wc must be inside the table, 1 to 8 rad/s"):
        FrequencyResponse(**SERVO).at(wc)


def test_a_controller_times_a_table_is_exact_between_its_points():
    table = FrequencyResponse(**SERVO, dt=0.1)
    pi_law = zoh.Sampled(num=[2.0, -1.9], den=[1, -1], dt=0.1)
    gain = zoh.Sampled(num=[3.0], den=[1], dt=0.1)
    loop = gain * (pi_law * table)
    z = np.exp(0.33j)  # at 3.3 rad/s
    assert loop.at(3.3) == pytest.approx(3 * (2 * z - 1.9) / (z - 1) / 3.3j, rel=1e-13)
    assert loop.dt == 0.1


def test_two_clocks_make_no_loop():
    with pytest.raises(SpecError, match=r"dt must be the same throughout .* got None"):
        _ = zoh.Sampled(num=[1], den=[1], dt=0.1) * FrequencyResponse(**SERVO)
    with pytest.raises(SpecError, match=r"dt must be the same throughout .* got 0.1"):
        _ = zoh.Sampled(num=[1], den=[1], dt=0.2) * FrequencyResponse(**SERVO, dt=0.1)
    with pytest.raises(TypeError):
        _ = "gain" * FrequencyResponse(**SERVO)


def test_noise_between_points_is_what_the_weights_make_of_it():
    table = FrequencyResponse(**SERVO, uncertainty=[0.1, 0.1, 0.1, 0.1])
    assert table.spread_at(2.0) == pytest.approx(0.1, rel=1e-6)  # at a point: that point's own
    # halfway in ln w by Hermite with central slopes: weights -1/16, 9/16, 9/16, -1/16
    middle = 0.1 * sqrt(2 * (81 + 1)) / 16
    assert table.spread_at(sqrt(8.0)) == pytest.approx(middle, rel=1e-6)
    assert FrequencyResponse(**SERVO).spread_at(2.0) == 0.0


def test_random_error_of_a_coherence():
    # gamma^2 = 0.8 and 10 averages: sqrt(0.2/(2 10 0.8)) = sqrt(1/80)
    assert zoh.random_error([0.8, 1.0], averages=10) == pytest.approx([sqrt(1 / 80), 0.0])
    with pytest.raises(SpecError, match=r"coherence must be inside \(0, 1\], got 1.2"):
        zoh.random_error([0.5, 1.2], averages=10)
    with pytest.raises(SpecError, match="averages must be a whole number of 1 or more"):
        zoh.random_error([0.5], averages=0)


def test_a_sensor_scales_and_may_turn_round():
    table = FrequencyResponse(**SERVO).scaled(-2.0)
    assert table.at(2.0) == pytest.approx(1j, abs=1e-15)
    with pytest.raises(SpecError, match="gain must not be 0"):
        table.scaled(0.0)
