"""between: the state of a held plant inside a sample, against closed forms and 50 digits."""

from math import exp, expm1, factorial, log

import numpy as np
import pytest
from mpmath import mp, mpf

from zoh.lti.systems import Plant
from zoh.sampling.between import Held
from zoh.sampling.moves import Moves

REL = 1e-13


# 2/(s + 3) with a sensor of 1/4 at dt 1/2: x' = -1.5 x + u, y = 0.25 x, time in samples
LAG = Held.of(Plant(num=[2], den=[1, 3], sensor=0.25), 0.5)


def test_a_lag_in_units_of_its_sample():
    assert (LAG.low, LAG.c, LAG.d) == ((1.5,), (0.25,), 0.0)
    assert LAG.size == 1.5
    doubled = Held.of(Plant(num=[4], den=[2, 6], sensor=0.25), 0.5)
    assert (doubled.low, doubled.c, doubled.d, doubled.size) == ((1.5,), (0.25,), 0.0, 1.5)


@pytest.mark.parametrize("t", [1e-9, 0.25, 1 / 3, 0.34, 1.0])
def test_a_lag_moves_as_an_exponential(t):
    ((phi, gamma),), _ = LAG.over(t)
    assert phi == pytest.approx(expm1(-1.5 * t), rel=REL)
    assert gamma == pytest.approx(-expm1(-1.5 * t) / 1.5, rel=REL)


@pytest.mark.parametrize("t", [0.0, 0.4])
@pytest.mark.parametrize("span", [0.1, 0.6])
@pytest.mark.parametrize("direct", [0.0, 2.0])
def test_a_lags_series(t, span, direct):
    # y = direct u + 0.25 x; den (s + 3) direct/sensor is added to num
    plant = Plant(num=[8, 26] if direct else [2], den=[1, 3], sensor=0.25)
    on_state, on_input = Held.of(plant, 0.5)._taylor(t, span, Moves.of(plant, 0.5)).T
    fall = exp(-1.5 * t)
    powers = np.array([(-1.5 * span) ** j / factorial(j) for j in range(len(on_input))])
    assert on_state == pytest.approx(0.25 * fall * powers, rel=REL)
    wanted = -0.25 / 1.5 * fall * powers
    wanted[0] += 0.25 / 1.5 + direct
    assert on_input == pytest.approx(wanted, rel=REL, abs=1e-16)


def test_a_gain_has_no_state():
    held = Held.of(Plant(num=[3], den=[2], sensor=0.5), 0.1)
    assert (held.low, held.c, held.d, held.size) == ((), (), 0.75, 0)
    moved, ((begin, span, rows),) = held.over(1.0)
    assert moved.shape == (0, 1)
    assert (begin, span, rows.tolist()) == (0.0, 1.0, [[0.75]])


def test_the_poles_are_no_larger_than_the_two_largest_terms_together():
    # s^3 + 6 s^2 + 4 s + 27 at dt 1/2: 3, 1 and 1.5
    held = Held.of(Plant(num=[1], den=[1, 6, 4, 27]), 0.5)
    assert held.low == (27 / 8, 1.0, 3.0)
    assert held.size == pytest.approx(4.5, rel=1e-15)
    # numbers over the monic denominator: [0.5 s + 2] dt^2 and dt^3
    held = Held.of(Plant(num=[1, 4], den=[2, 12, 8, 54]), 0.5)
    assert held.c == pytest.approx((2 / 8, 0.5 / 4, 0.0), rel=1e-15)


def test_a_lag_beside_a_gain_is_told_over_its_leading_coefficient():
    # (2 s + 5)/(4 s + 8) = 1/2 + (1/4)/(s + 2), at dt 1/2
    held = Held.of(Plant(num=[2, 5], den=[4, 8]), 0.5)
    assert (held.low, held.c, held.d) == ((1.0,), (0.125,), 0.5)
    # (3 s + 1 + 2^-52)/(3 s + 1): what is left beside the gain is 2^-52/3 in every digit
    held = Held.of(Plant(num=[3, 1 + 2.0**-52], den=[3, 1]), 1.0)
    assert held.c == pytest.approx((2.0**-52 / 3,), rel=1e-15, abs=0)


def test_a_sensor_over_a_leading_coefficient_may_be_no_float():
    # 1e200/1e-200 is none; 1e200 (1e-300 s + 3e-300)/(1e-200 (s^2 + s + 2)) is 1e100 (s + 3)/...
    held = Held.of(Plant(num=[1e-300, 3e-300], den=[1e-200, 1e-200, 2e-200], sensor=1e200), 1.0)
    assert held.low == pytest.approx((2, 1), rel=1e-15)
    assert held.c == pytest.approx((3e100, 1e100), rel=1e-15)
    assert held.d == 0


PLANTS = {
    "two lags and a gain": Plant(num=[1, 5, 7], den=[1, 3, 2], sensor=0.5),
    "arm": Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180),
    "resonance": Plant(num=[2, 1], den=[2, 0.5, 8]),
    "three, with a gain": Plant(num=[1, 0.5, -2, 3], den=[1, 6, 4, 27]),
    "zero on the right": Plant(num=[-1, 1], den=[1, 2, 1]),
}


def exact(plant, dt, t):
    """Return exp(A t) of (state, input), its generator and y's row, in 50 digits, t in samples."""
    den = [mpf(c) / mpf(plant.den[0]) for c in plant.den]
    n = len(den) - 1
    num = [mpf(0)] * (n + 1 - len(plant.num)) + [mpf(c) / mpf(plant.den[0]) for c in plant.num]
    a = mp.zeros(n + 1)
    for i in range(n - 1):
        a[i, i + 1] = mpf(1)
    for i in range(n):
        a[n - 1, i] = -den[n - i] * mpf(dt) ** (n - i)
    a[n - 1, n] = mpf(1)
    row = mp.zeros(1, n + 1)
    for i in range(n):
        row[i] = (num[n - i] - num[0] * den[n - i]) * mpf(dt) ** (n - i) * mpf(plant.sensor)
    row[n] = num[0] * mpf(plant.sensor)
    return mp.expm(a * mpf(t), method="taylor"), a, row


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS.keys())
@pytest.mark.parametrize("dt", [1e-3, 0.1, 1.5])
@pytest.mark.parametrize("t", [0.1, 0.75, 1.0])
def test_moves_in_fifty_digits(plant, dt, t):
    n = len(plant.den) - 1
    moved, _ = Held.of(plant, dt).over(t)
    phi, gamma = moved[:, :n], moved[:, n]
    with mp.workdps(50):
        whole, _, _ = exact(plant, dt, t)
        wanted = np.array((whole - mp.eye(n + 1)).tolist(), float)
    assert phi == pytest.approx(wanted[:n, :n], rel=REL, abs=1e-18)
    assert gamma == pytest.approx(wanted[:n, n], rel=REL)


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS.keys())
@pytest.mark.parametrize("dt", [1e-3, 0.1, 1.5])
@pytest.mark.parametrize("t", [0.0, 0.3])
def test_series_in_fifty_digits(plant, dt, t):
    n, span = len(plant.den) - 1, 0.25
    found = Held.of(plant, dt)._taylor(t, span, Moves.of(plant, dt))
    on_state, on_input = found[:, :n], found[:, n]
    rows = []
    with mp.workdps(50):
        whole, a, row = exact(plant, dt, t)
        for j in range(len(on_input)):
            rows.append([float(x * mpf(span) ** j / mp.factorial(j)) for x in row * whole])
            row = row * a
    wanted = np.array(rows)
    size = np.abs(wanted).max()
    assert on_state == pytest.approx(wanted[:, :n], rel=REL, abs=1e-16 * size)
    assert on_input == pytest.approx(wanted[:, n], rel=REL, abs=1e-16 * size)
    # what is left out would not be seen
    with mp.workdps(50):
        rest = [abs(x) * mpf(span) ** len(rows) / mp.factorial(len(rows)) for x in row * whole]
    assert float(max(rest)) < 1e-14 * size


@pytest.mark.parametrize("span", [0.01, 0.05, 0.25, 1.0])
def test_as_many_terms_as_count(span):
    terms = LAG.terms(span) - 1  # beside one for the state
    turn = 1.5 * span
    assert turn**terms / factorial(terms) <= 1e-17 < turn ** (terms - 1) / factorial(terms - 1)
    assert LAG.terms(10.0) == LAG.terms(2 / 1.5)  # no stretch is longer


def test_a_gentle_sample_is_one_stretch():
    assert LAG._stretches(1.0) == [(0.0, 1.0)]
    assert LAG._stretches(0.3) == [(0.0, 0.3)]
    assert Held.of(Plant(num=[1], den=[1, 4]), 0.5)._stretches(1.0) == [(0.0, 1.0)]


def test_a_swing_is_cut_where_it_has_turned_two_rad():
    # w dt = 20, hardly damped: spans of 0.1 sample
    held = Held.of(Plant(num=[1], den=[1, 0.0, 400.0]), 1.0)
    found = held._stretches(1.0)
    assert [begin for begin, _ in found] == pytest.approx([i / 10 for i in range(10)], abs=1e-14)
    assert [span for _, span in found] == pytest.approx([0.1] * 10, rel=1e-12)
    begin, span = held._stretches(0.25)[-1]
    assert (begin, span) == (pytest.approx(0.2), pytest.approx(0.05))


def test_a_mode_that_is_over_is_not_cut():
    # 1/(s + 1000) at dt 1: exp(-40) after 0.04 samples; then longer and longer stretches
    found = Held.of(Plant(num=[1], den=[1, 1000.0]), 1.0)._stretches(1.0)
    assert found[0] == (0.0, 0.002)
    assert sum(span for _, span in found) == pytest.approx(1.0, rel=1e-12)
    spans = np.array([span for _, span in found])
    begins = np.array([begin for begin, _ in found])
    assert spans[begins < 0.042] == pytest.approx(0.002, rel=1e-12)
    # exp(40 - 1000 begin) is left of exp(-40), so 1000 span may be as large; where it outweighs
    # the 28 powers of 1000 of the longest series, the rest is one stretch
    over = 1000 * begins - 40
    middle = (over > 2) & (over < 28 * log(1000))
    assert 1000 * spans[middle] == pytest.approx(over[middle], rel=1e-12)
    assert np.sum(over > 28 * log(1000)) == 1
    assert len(found) < 40
    slow = Held.of(Plant(num=[1], den=[1, 1001.0, 1000.0, 0.0]), 1.0)._stretches(1.0)
    assert len(slow) == len(found)  # slow poles and integrators cut nothing


def test_a_mode_that_is_over_is_not_cut_in_a_part_of_a_sample_either():
    # 1e4 rad a sample, half a sample: over doubles with every stretch from 2 on, 2, 4 ... 256, and
    # 28 log(5e3) = 238 is what the powers of the longest series need: from 256 on there is one
    begins = [a for a, _ in Held.of(Plant(num=[1], den=[1, 1e4]), 1.0)._stretches(0.5)]
    over = 1e4 * np.array(begins) - 40
    assert over[-2:] == pytest.approx([128, 256], rel=1e-9)
    # of 1.5e4 rad the series of 27 powers and one for the state takes 28 log(1.5e4) = 269
    begins = [a for a, _ in Held.of(Plant(num=[1], den=[1, 1.5e4]), 1.0)._stretches(1.0)]
    assert 1.5e4 * begins[-1] - 40 == pytest.approx(512, rel=1e-9)


def test_too_many_stretches_are_none():
    assert len(Held.of(Plant(num=[1], den=[1, 0, 3900.0**2]), 1.0)._stretches(1.0)) == 1950
    assert Held.of(Plant(num=[1], den=[1, 0, 4100.0**2]), 1.0)._stretches(1.0) == []


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS.keys())
@pytest.mark.parametrize("dt", [1e-3, 0.1, 1.5])
def test_the_series_of_a_sample_make_up_its_output(plant, dt):
    n = len(plant.den) - 1
    moved, series = Held.of(plant, dt).over(1.0)
    assert moved.shape == (n, n + 1)
    assert sum(span for _, span, _ in series) == pytest.approx(1.0, rel=1e-12)
    with mp.workdps(50):
        for begin, span, rows in series:
            whole, _, row = exact(plant, dt, begin + 0.75 * span)
            wanted = np.array((row * whole).tolist(), float).ravel()
            powers = 0.75 ** np.arange(len(rows))
            assert powers @ rows == pytest.approx(wanted, rel=1e-12, abs=1e-15)
