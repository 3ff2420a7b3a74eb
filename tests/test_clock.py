"""What a sample time costs: the hold's degrees by hand, the edge by a road of its own, the bits."""

from fractions import Fraction
from itertools import product
from math import degrees, pi, sqrt

import numpy as np
import pytest

import zoh
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.word_length import rounded, sure_bits, word_length

PLANT = zoh.Plant(num=[1], den=[1, 0])
ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
PID = {"wc": 1.95, "pm_deg": 40, "ki": 0.85}


def test_the_hold_and_the_delay_cost_wc_times_their_length():
    found = zoh.sample_times(
        ARM, "pid", PID, dts=[0.02, 0.1], compute_delay=0.01, delay_samples=0.5
    )
    hold, delay = ([getattr(r, k) for r in found.rows] for k in ("hold_deg", "delay_deg"))
    assert hold == pytest.approx([-degrees(1.95 * dt / 2) for dt in (0.02, 0.1)], rel=1e-14)
    assert delay == pytest.approx([-degrees(1.95 * x) for x in (0.02, 0.06)], rel=1e-14)
    assert [r.pm_deg for r in found.rows] == pytest.approx([40, 40], abs=1e-9)
    assert found.largest == 0.1
    assert found.limited_by is None
    assert found.fineness == pytest.approx(5)


def test_the_largest_sample_time_by_hand():
    # kp dt/(z - 1), kp = 2 sin(wc dt/2)/dt: L(-1) = -sin(wc dt/2) bounds the gain margin from
    # above, 1/sin(wc dt/2) >= 2 as long as wc dt <= pi/3
    asked = zoh.Requirements(gain_margin_db=20 * np.log10(2))
    found = zoh.sample_times(PLANT, "p", {"wc": 2.0}, requirements=asked)
    assert found.largest == pytest.approx(pi / 6, rel=1e-9)
    assert "gain_margin_db must be at least" in found.limited_by
    assert found.gaps == ()
    assert found.fineness == pytest.approx(990 ** (1 / 30))


def test_a_delay_in_samples_moves_the_edge_as_by_hand():
    # 1/s with one sample of delay and P: PM = 90 - wc dt (1/2 + 1), 45 deg at wc dt = pi/6
    asked = zoh.Requirements(pm_deg=45)
    found = zoh.sample_times(PLANT, "p", {"wc": 1.0}, requirements=asked, delay_samples=1.0)
    assert found.largest == pytest.approx(pi / 6, rel=1e-9)


def test_what_no_clock_meets_has_no_largest():
    found = zoh.sample_times(
        ARM, "pid", PID, dts=[0.05, 0.1], requirements=zoh.Requirements(ms=1.1)
    )
    assert found.largest is None
    assert "ms must be at most 1.1" in found.limited_by
    assert found.to_dict()["rows"][0]["failure"] == found.rows[0].failure


def test_gaps_below_the_largest_are_listed():
    # a resonance at 10 rad/s and its images: some slow clocks hold, some fast ones fail
    resonant = zoh.Plant(num=[100], den=[1, 0.2, 100, 0])
    asked = zoh.Requirements(ms=1.1)
    dts = np.linspace(0.02, 1.5, 30)
    found = zoh.sample_times(resonant, "p", {"wc": 0.1}, dts=dts, requirements=asked)

    def ms(dt):
        sampled = zoh.sample(resonant, dt)
        law = zoh.Sampled(num=[1 / abs(sampled.at(0.1))], den=[1], dt=dt)
        w = np.linspace(1e-3, pi / dt, 200_001)
        return np.max(1 / np.abs(1 + law.at(w) * sampled.at(w)))

    high = [dt for dt in dts if ms(float(dt)) > 1.1]
    assert list(found.gaps) == [dt for dt in high if dt < found.largest]
    assert len(found.gaps) > 3
    assert any(r.failure is None and r.dt < max(found.gaps) for r in found.rows)


def test_rounding_to_words_is_what_fractions_say():
    law = zoh.Sampled(num=[81.51, -139.5, 58.07], den=[1, -1, 0], dt=0.1)
    for bits in (4, 9, 16):
        # 139.5 needs 8 bits above the point and one for the sign
        quantum = Fraction(2) ** (8 - bits + 1)
        exact = [round(Fraction(c) / quantum) * quantum for c in law.num]
        assert [Fraction(c) for c in rounded(law, bits).num] == exact
        assert rounded(law, bits).den == law.den


@pytest.mark.parametrize("dt", [0.005, 0.03, 0.1])
def test_the_bits_are_enough_wherever_the_coefficients_lie(dt):
    d = zoh.pid(ARM, dt=dt, **PID)
    bits = word_length(d.sampled, d.controller, d.margins, 0.1)
    assert bits >= sure_bits(d.sampled, d.controller, d.margins, 0.1)
    half = 2.0 ** (np.frexp(max(map(abs, d.controller.num)))[1] - bits)  # half a quantum of num

    def moved(signs):  # every coefficient of num as far off its place as rounding can put it
        num = [c + sign * half for c, sign in zip(d.controller.num, signs, strict=True)]
        law = zoh.Sampled(num=num, den=d.controller.den, dt=dt)
        return abs(measure_loop(Loop.of(law, d.sampled)).phase_margin_deg - 40)

    assert max(moved(signs) for signs in product((-1, 1), repeat=3)) < 0.1
    law = rounded(d.controller, bits)
    assert abs(measure_loop(Loop.of(law, d.sampled)).phase_margin_deg - 40) < 0.1


def test_the_bound_is_the_sum_of_all_first_order_moves():
    # kp/(z - 1) at z = j, kp = sqrt(2): d ln L = dk/kp; L'/L = -j z/(z - 1) dt = -0.5 + ... by
    # hand: arg L = -90 - w/2, |L| = kp/(2 sin(w/2)): g = -cot(w/2)/2 = -1/2, p = -1/2
    # dPM = -(p/g) dk/kp = -dk/kp rad; den, 1 - z^-0 = 1 alone, is exact but counted: |d| = 1
    plant = zoh.Sampled(num=[1], den=[1, -1], dt=1.0)
    law = zoh.Sampled(num=[sqrt(2)], den=[1], dt=1.0)
    m = measure_loop(Loop.of(law, plant))
    # worst = 2 (num: 2^1 over sqrt(2), den: 2^1 over 1): sqrt(2) + 2 rad
    worst = degrees(2 / sqrt(2) + 2)
    assert sure_bits(plant, law, m, 0.1) == int(np.ceil(np.log2(worst / 0.1)))


def test_the_bits_grow_as_the_clock_gets_faster():
    found = zoh.sample_times(ARM, "pid", PID, dts=[0.001, 0.01, 0.1])
    bits = [r.bits for r in found.rows]
    assert bits == sorted(bits, reverse=True)
    assert bits[0] > bits[2] + 6  # a zero and two poles crowd: about 2 bits for a factor of 2


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"dts": [0.1]}, "dts must have two sample times or more"),
        ({"dts": [0.1, -1.0]}, "dts must be above 0"),
        ({"compute_delay": -1.0}, "compute_delay must be 0 or more"),
        ({"delay_samples": -1.0}, "delay_samples must be 0 or more"),
    ],
)
def test_bad_requests_are_refused(more, message):
    with pytest.raises(zoh.SpecError, match=message):
        zoh.sample_times(ARM, "pid", PID, **more)


def test_a_crossover_must_be_given_and_a_table_has_its_clock():
    with pytest.raises(zoh.SpecError, match="wc must be a real number"):
        zoh.sample_times(ARM, "p", {"pm_deg": 40})
    table = zoh.FrequencyResponse.from_complex(w=[1.0, 2.0, 3.0], gain=[1, 0.5, 0.3])
    with pytest.raises(zoh.SpecError, match=r"plant must be a zoh\.Plant"):
        zoh.sample_times(table, "p", {"wc": 1.5})


def test_both_roads_to_a_verdict_agree():
    # a bound on the step that is always met makes every dt a full design; without it the margins do
    dts = [0.05, 0.2, 0.4, 0.7]
    bare = zoh.Requirements(ms=1.7)
    full = zoh.Requirements(ms=1.7, peak_effort=1e9)
    short, long = (zoh.sample_times(ARM, "pid", PID, dts=dts, requirements=r) for r in (bare, full))
    assert [r.failure for r in short.rows] == [r.failure for r in long.rows]
    assert [r.bits for r in short.rows] == [r.bits for r in long.rows]
    assert short.largest == long.largest


def test_the_longest_that_was_tried_is_said_to_be_no_more():
    found = zoh.sample_times(ARM, "pid", PID, dts=[0.001, 0.01])
    assert (found.largest, found.limited_by) == (0.01, None)


def test_the_step_counts_with_its_reference_and_sections_with_the_loop():
    asked = zoh.Requirements(peak_effort=200.0)
    small, large = (
        zoh.sample_times(ARM, "pid", PID, dts=[0.05, 0.1], requirements=asked, reference=size)
        for size in (1.0, 10.0)
    )
    assert small.rows[1].failure is None
    assert "peak_effort must be at most 200" in large.rows[1].failure
    notch = zoh.notch(w0=50.0)
    rows = zoh.sample_times(ARM, "pid", PID, dts=[0.01, 0.1], sections=[notch]).rows
    assert rows[0].pm_deg == pytest.approx(40, abs=1e-9)
    assert "must be below the Nyquist frequency" in rows[1].failure  # 31.4 rad/s


def test_a_p_of_a_crossover_alone_follows_no_step_that_nobody_asks_about(monkeypatch):
    # near its edge the poles come near z = -1, and their ringing takes seconds at each clock
    monkeypatch.setattr("zoh.analysis.verify.closed_loop_step", None)
    found = zoh.sample_times(PLANT, "p", {"wc": 2.0}, dts=[0.1, 0.3, 1.5])
    assert [row.failure for row in found.rows] == [None, None, None]
    # 1/(z - 1) has 90 deg - wc dt/2 of margin, whatever its gain
    expected = [90 - degrees(2.0 * dt / 2) for dt in (0.1, 0.3, 1.5)]
    assert [row.pm_deg for row in found.rows] == pytest.approx(expected, abs=1e-9)
