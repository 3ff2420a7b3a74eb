"""What an emulated controller is, by hand, and what its loop has, measured in z alone."""

from cmath import exp, phase
from math import cos, degrees, pi, radians, sin, sqrt

import numpy as np
import pytest

import zoh
from zoh.emulation import ALONE, CARRIED_BY, EXACT, HOLD_COUNTED

PLANT = zoh.Plant(num=[1], den=[1, 1, 0])
ASKED = {"wc": 1.0, "pm_deg": 30.0}  # P(j) = 1/(j (1 + j)): 1/sqrt(2) at -135 deg


def rows(law="pi", asked=ASKED, dt=0.2, **more):
    return zoh.emulate(PLANT, law, asked, dt=dt, **more)


def found(designed, method, *more, **others):
    (row,) = (r for r in rows(*more, **others) if (r.designed, r.method) == (designed, method))
    return row


def test_the_continuous_pi_by_hand_carried_over_by_tustin():
    # theta = 30 - 180 + 135 = -15 deg; kp = sqrt(2) cos(15), ki = 1 sqrt(2) sin(15)
    kp, ki = sqrt(2) * cos(radians(15)), sqrt(2) * sin(radians(15))
    law = found(ALONE, "tustin").controller
    assert law.num == pytest.approx((kp + ki * 0.1, -kp + ki * 0.1), rel=1e-14)
    assert law.den == (1.0, -1.0)
    assert found(ALONE, "forward").controller.num == pytest.approx((kp, -kp + ki * 0.2), rel=1e-14)
    assert found(ALONE, "backward").controller.num == pytest.approx((kp + ki * 0.2, -kp), rel=1e-14)


def test_counting_the_hold_turns_by_half_a_sample_and_the_compute_delay_more():
    late = 0.1 + 0.05  # s, dt/2 and the compute delay, at 1 rad/s
    theta = radians(30 - 180 + 135) + late
    law = found(HOLD_COUNTED, "tustin", compute_delay=0.05).controller
    kp, ki = sqrt(2) * cos(theta), -sqrt(2) * sin(theta)
    assert law.num == pytest.approx((kp + ki * 0.1, -kp + ki * 0.1), rel=1e-13)


@pytest.mark.parametrize(
    ("law", "asked"),
    [
        ("pi", ASKED),
        ("pd", {"wc": 1.5, "pm_deg": 60.0}),
        ("pid", {"wc": 1.5, "pm_deg": 60.0, "ki": 0.1}),
        ("lead", {"wc": 1.5, "pm_deg": 60.0, "dc_gain": 1.0}),
        ("lag", {"wc": 0.5, "pm_deg": 50.0, "dc_gain": 5.0}),
    ],
)
def test_every_continuous_design_has_its_margin_in_s(law, asked):
    emulated = found(ALONE, "tustin", law, asked)
    continuous = zoh.undiscretise(emulated.controller, "tustin")
    gain = continuous.at(asked["wc"]) * PLANT.at(asked["wc"])
    assert abs(gain) == pytest.approx(1, abs=1e-12)
    assert degrees(phase(-gain)) == pytest.approx(asked["pm_deg"], abs=1e-9)


def test_the_margins_are_those_of_the_sampled_loop_and_only_the_exact_design_has_what_was_asked():
    every = rows()
    assert [r.designed for r in every] == [EXACT, *[ALONE] * 6, *[HOLD_COUNTED] * 6]
    assert tuple(r.method for r in every[1:7]) == CARRIED_BY
    assert every[0].margins.phase_margin_deg == pytest.approx(30, abs=1e-9)
    sampled = zoh.sample(PLANT, 0.2)
    for row in every[1:]:
        wc = row.margins.crossover
        z = exp(1j * wc * 0.2)
        loop = np.polyval(row.controller.num, z) / np.polyval(row.controller.den, z)
        loop *= np.polyval(sampled.num, z) / np.polyval(sampled.den, z)
        # z-coefficients, 16 digits, against terms that cancel by wc dt = 0.2 thrice: 1e-13
        assert degrees(phase(-loop)) == pytest.approx(row.margins.phase_margin_deg, abs=1e-9)
        assert abs(row.margins.phase_margin_deg - 30) > 1e-3  # off, every one of them


def test_the_price_of_the_hold_is_half_a_sample():
    # Tustin at wc dt/2 = 0.1 rad is 0.3 % off in frequency: the 5.7 deg of the hold are the price
    lost = 30 - found(ALONE, "prewarp").margins.phase_margin_deg
    assert lost == pytest.approx(degrees(0.1), abs=0.5)  # deg: |L| moved by images, wc with it


def test_a_law_that_cannot_leaves_one_row_with_the_reason():
    (row,) = (r for r in rows("pi", {"wc": 1.0, "pm_deg": 44.0}) if r.designed == HOLD_COUNTED)
    assert row.margins is None
    assert row.reason == "pi cannot give the +4.73 deg needed at 1 rad/s"
    assert row.to_dict()["margins"] is None


def test_forward_euler_sends_the_filter_of_a_pid_to_the_edge_of_stability():
    # its pole at s = -2/dt becomes z = 1 + s dt = -1, which never decays
    forward = found(ALONE, "forward", "pid", {"wc": 1.5, "pm_deg": 60.0, "ki": 0.1})
    assert -1.0 in np.round(np.roots(forward.controller.den), 12)
    assert forward.to_dict()["controller"]["den"] == list(forward.controller.den)


@pytest.mark.parametrize(
    ("law", "asked", "message"),
    [
        ("pii", ASKED, "law must be one of"),
        ("pi", {"wc": 1.0}, "pm_deg must be given to emulate pi"),
        ("pid", ASKED, "ki must be given to emulate pid"),
        ("pi", {"wc": 5 * pi, "pm_deg": 30.0}, "wc must be below the Nyquist frequency"),
    ],
)
def test_bad_requests_are_refused(law, asked, message):
    with pytest.raises(zoh.SpecError, match=message):
        rows(law, asked)


def test_a_table_has_no_form_in_s():
    table = zoh.FrequencyResponse.from_complex(w=[1.0, 2.0, 3.0], gain=[1, 0.5, 0.3])
    with pytest.raises(zoh.SpecError, match=r"plant must be a zoh\.Plant"):
        zoh.emulate(table, "pi", ASKED, dt=0.1)


def test_sections_are_carried_over_with_the_law():
    # by Tustin s is w: where w is j wc the controller is what it was at s = j wc, sections included
    plant, notch = zoh.Plant(num=[1], den=[1, 1, 0]), zoh.notch(w0=6.0, depth=0.2)
    asked, dt = {"wc": 1.0, "pm_deg": 50.0}, 0.1
    rows = zoh.emulate(plant, "pd", asked, dt=dt, sections=[notch])
    assert rows[0].margins.phase_margin_deg == pytest.approx(50.0, abs=1e-9)
    (tustin,) = [r for r in rows if (r.designed, r.method) == ("in s, plant alone", "tustin")]
    loop = tustin.controller.at(2 / dt * float(np.arctan(1.0 * dt / 2))) * plant.at(1.0)
    assert loop == pytest.approx(-np.exp(1j * np.radians(50.0)), abs=1e-12)
    # the section in s: its zeros' damping is depth width/2, its poles' width/2, at w0
    s = 1j
    by_hand = (s * s + 2 * 0.1 * 6 * s + 36) / (s * s + 2 * 0.5 * 6 * s + 36)
    assert notch.in_s().at(1.0) == pytest.approx(by_hand, rel=1e-14)
    plain = zoh.emulate(plant, "pd", asked, dt=dt)[1]
    assert len(tustin.controller.den) == len(plain.controller.den) + 2


@pytest.mark.parametrize(
    ("given", "line"),
    [
        (None, "given must name the law's parameters, got None"),
        ({"wc": 1.0, "pm_deg": 50, "ki": -1.0}, "ki must be above 0, got -1.0"),
        ({"wc": 1.0, "pm_deg": 50, "ki": 1.0, "tau": 3}, "tau is no parameter of pid"),
        ({"wc": 1.0, "pm_deg": 50, "largest_ki_ms": 1e308}, "largest_ki_ms must be at most 1e"),
        ({"wc": "1", "pm_deg": 50, "ki": 1.0}, "wc must be a real number"),
    ],
)
def test_what_no_design_function_takes_is_refused_in_the_same_words(given, line):
    plant = zoh.Plant(num=[1], den=[1, 1, 0])
    calls = (
        lambda: zoh.design(plant, "pid", given, dt=0.1),
        lambda: zoh.emulate(plant, "pid", given, dt=0.1),
        lambda: zoh.sample_times(plant, "pid", given, dts=[0.1, 0.2]),
    )
    for call in calls:
        with pytest.raises(zoh.SpecError) as refused:
            call()
        assert str(refused.value).startswith(line)
