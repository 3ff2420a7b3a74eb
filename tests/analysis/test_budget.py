"""The budget of the phase: by hand at z = j, in 30 digits, and added up on random loops."""

from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from mpmath import mp

import zoh
from zoh.analysis.sections import sections
from zoh.app.commands import design_all
from zoh.app.files import beside, read_text
from zoh.app.project import read

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))
INTEGRATOR = zoh.Plant(num=[1], den=[1, 0])
ADDS_UP = 1e-9  # deg, what a budget promises
PROMISED = [
    "plant",
    "dead time",
    "sensor",
    "hold, wc dt/2",
    "compute delay",
    "sampling's remainder (images)",
]


def constant(k, dt=1.0):
    return zoh.Sampled(num=[k], den=[1], dt=dt)


def degs(b):
    return {item.name: item.deg for item in b.items}


def test_every_part_of_an_integrator_by_hand():
    # 1/(z - 1) at z = j is 1/sqrt(2) at -135 deg: -90 of 1/s, -45 of half a sample, no image
    b = zoh.budget(INTEGRATOR, constant(sqrt(2)))
    assert b.wc == pytest.approx(pi / 2, rel=1e-15)
    assert [item.name for item in b.items[:6]] == PROMISED
    assert [item.deg for item in b.items[:6]] == pytest.approx([-90, 0, 0, -45, 0, 0], abs=1e-12)
    assert b.phase_margin_deg == pytest.approx(45, abs=1e-12)


def test_the_images_of_a_lag_by_hand():
    # 1/(s + a), a = log 2, dt = 1 is (0.5/a)/(z - 0.5): at z = j the phase is atan2(1, -0.5) - ...
    b = zoh.budget(zoh.Plant(num=[1], den=[1, np.log(2)]), constant(np.log(2) * sqrt(5)))
    mp.dps = 30
    plant = -mp.degrees(mp.atan(mp.pi / 2 / mp.log(2)))
    exact = -mp.degrees(mp.atan2(1, mp.mpf("-0.5")))  # 1/(j - 0.5)
    assert degs(b)["plant"] == pytest.approx(float(plant), abs=1e-12)
    remainder = degs(b)["sampling's remainder (images)"]
    assert remainder == pytest.approx(float(exact - plant + 45), abs=1e-12)
    assert b.phase_margin_deg == pytest.approx(float(180 + exact), abs=1e-12)


def test_delays_turn_by_wc_times_their_length():
    plant = zoh.Plant(num=[1], den=[1, 0], dead_time=0.3)
    b = zoh.budget(plant, constant(0.5), compute_delay=0.45)
    assert degs(b)["dead time"] == pytest.approx(-np.degrees(0.3 * b.wc), rel=1e-14)
    assert degs(b)["compute delay"] == pytest.approx(-np.degrees(0.45 * b.wc), rel=1e-14)


def test_a_negative_sensor_and_a_negative_controller_turn_by_half_a_turn_each():
    plant = zoh.Plant(num=[1], den=[1, 0], sensor=-1.0)
    b = zoh.budget(plant, constant(-sqrt(2)))
    assert degs(b)["sensor"] == -180
    assert degs(b)["controller: negative gain"] == -180
    assert degs(b)["whole turns"] == 360
    assert b.total_deg == pytest.approx(45, abs=1e-12)


def test_the_sections_of_a_controller_have_the_names_of_the_book():
    # w-plane, dt = 2: (w + 1)/w is a PI; z^-1 more is a delay of one sample
    pi_law = zoh.Sampled.from_w(num_w=[0.1, 0.1], den_w=[1, 0], dt=2.0, delay=1)
    b = zoh.budget(zoh.Plant(num=[1], den=[1, 1]), pi_law)
    names = [item.name for item in b.items[6:]]
    assert names == [
        "controller: zero at -1 rad/s",
        "controller: integrator",
        "controller: delay of 1 samples",
    ]
    assert degs(b)["controller: integrator"] == -90
    assert degs(b)["controller: delay of 1 samples"] == pytest.approx(-np.degrees(2 * b.wc))


@pytest.mark.parametrize(
    ("num", "den", "v", "expected"),
    [
        ([1], [1, 0.2, 1], 2.0, -180 + np.degrees(np.arctan2(0.4, 3))),  # past the resonance
        ([1], [1, -0.2, 1], 2.0, 180 - np.degrees(np.arctan2(0.4, 3))),  # a growing one turns up
        ([1], [1, 0, 1], 2.0, -180),  # undamped: as the damped one in the limit
        ([1, 0, 1], [1, 2, 1], 2.0, 180 - 2 * np.degrees(np.arctan(2))),  # a notch, above it
        ([-1, 1], [1, 1], 1.0, -90),  # an all-pass: -45 of its zero, -45 of its pole
        ([1, 0, 0], [1], 3.0, 180),
        ([1], [1, -1], 1.0, -180 + 45),
    ],
)
def test_phases_run_on_from_zero_frequency(num, den, v, expected):
    assert sum(s.deg for s in sections(num, den, v)) == pytest.approx(expected, abs=1e-12)


corner = st.floats(0.02, 50)
side = st.sampled_from([1.0, 1.0, 1.0, -1.0])


@given(
    st.lists(st.tuples(corner, side), max_size=3), st.integers(0, 2), st.floats(0.01, 2),
    st.floats(0, 3), st.floats(0, 2), st.floats(0.01, 30),
    st.lists(st.floats(-1.2, 1.2), max_size=3),
)  # fmt: skip
def test_it_adds_up_to_the_measured_margin(corners, at_origin, dt, dead, wait, gain, roots):
    poles = [-c * s for c, s in corners] + [0] * at_origin
    plant = zoh.Plant.zpk(zeros=[], poles=poles, gain=gain, dead_time=dead * dt)
    num = gain * np.poly(roots) if roots else [gain]
    law = zoh.Sampled(num=num, den=[1, -0.5, *[0] * (len(roots))], dt=dt)
    try:
        b = zoh.budget(plant, law, compute_delay=wait * dt)
    except zoh.SpecError:
        assume(False)
    assert abs(b.total_deg - b.phase_margin_deg) <= ADDS_UP
    # the whole, by a road in z alone that knows no part
    z = np.exp(1j * b.wc * dt)
    sampled = zoh.sample(plant, dt, wait * dt)
    loop = np.polyval(law.num, z) / np.polyval(law.den, z) * sampled.at(b.wc)
    off = np.angle(loop * np.exp(1j * np.radians(180 - b.total_deg)))
    assert abs(off) < 1e-8  # rad: polyval at a small dt loses digits that the w-plane keeps


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda p: p.stem)
def test_it_adds_up_on_every_example(file):
    project = read(read_text(str(file)), beside(str(file)))
    measured = [e.measured for e in design_all(project) if e.measured is not None]
    crossing = [d for d in measured if d.margins.crossover is not None]  # a P of 1 has none
    assert crossing
    for d in crossing:
        b = zoh.budget(project.plant, d.controller, compute_delay=project.compute_delay)
        assert b.phase_margin_deg == d.margins.phase_margin_deg
        assert abs(b.total_deg - d.margins.phase_margin_deg) <= ADDS_UP


def test_a_sampled_plant_is_one_item():
    sampled = zoh.sample(INTEGRATOR, 1.0)
    b = zoh.budget(sampled, constant(sqrt(2)))
    assert b.items[0].name == "plant, hold and delays, as sampled"
    assert b.items[0].deg == pytest.approx(-135, abs=1e-12)
    assert b.total_deg == pytest.approx(45, abs=1e-12)
    with pytest.raises(zoh.SpecError, match="compute_delay must be 0"):
        zoh.budget(sampled, constant(1.0), compute_delay=0.1)
    with pytest.raises(zoh.SpecError, match="dt must be the plant's"):
        zoh.budget(sampled, constant(1.0, dt=0.5))


def test_a_continuous_table_is_split_into_hold_delay_and_images():
    w = np.geomspace(1e-3, 300, 400)
    table = zoh.FrequencyResponse.from_complex(w=w, gain=1 / (1j * w))
    b = zoh.budget(table, constant(5.0, dt=0.1), compute_delay=0.05)
    names = [item.name for item in b.items[:4]]
    assert names == ["plant, as tabled", *PROMISED[3:]]
    assert degs(b)["hold, wc dt/2"] == pytest.approx(-np.degrees(b.wc * 0.05))
    assert abs(b.total_deg - b.phase_margin_deg) <= ADDS_UP


def test_what_has_no_crossover_has_no_budget():
    with pytest.raises(zoh.SpecError, match="controller must make the loop's gain 1 somewhere"):
        zoh.budget(zoh.Plant(num=[1], den=[1, 1]), constant(0.5))
    with pytest.raises(zoh.SpecError, match=r"controller must be a zoh\.Sampled"):
        zoh.budget(INTEGRATOR, INTEGRATOR)
    with pytest.raises(zoh.SpecError, match="plant must be a plant"):
        zoh.budget(3, constant(0.5))


def test_roots_that_floats_cannot_tell_apart_are_one_piece():
    # 40 poles in a row: their coefficients hold 16 digits, their angles add up to fewer
    law = zoh.Sampled(num=[3], den=np.poly(np.linspace(-0.95, 0.95, 40)), dt=1.0)
    w = np.linspace(0.01, 3, 600)
    lag = zoh.sample(zoh.Plant(num=[1], den=[1, 1]), 1.0)
    table = zoh.FrequencyResponse.from_complex(w=w, gain=lag.at(w), dt=1.0)  # quicker to measure
    b = zoh.budget(table, law)
    assert b.items[1].name == "controller: in one piece"
    assert abs(b.total_deg - b.phase_margin_deg) <= ADDS_UP


def test_as_text_and_as_json():
    b = zoh.budget(INTEGRATOR, constant(sqrt(2)))
    assert "hold, wc dt/2" in b.report()
    assert "-45.0000 deg" in b.report()
    assert b.report().splitlines()[-1].endswith("+45.0000 deg")
    assert b.to_dict()["items"][0] == {"name": "plant", "deg": -90.0}
    assert {"wc", "phase_margin_deg"} < b.to_dict().keys()


@pytest.mark.parametrize(("dt", "kp"), [(0.1, 1.0), (0.5, 2.0), (0.05, 30.0)])
def test_hold_and_images_are_those_of_the_sum_over_all_images(dt, kp):
    # G(exp(j wc dt)) = 1/dt sum over k of P(s) (1 - exp(-s dt))/s, s = j (wc + 2 pi k/dt): the term
    # k = 0 turns by P and by the hold, what the rest adds is the remainder
    b = zoh.budget(zoh.Plant(num=[1], den=[1, 1, 0]), zoh.Sampled(num=[kp], den=[1], dt=dt))
    s = 1j * (b.wc + 2 * np.pi / dt * np.arange(-200_000, 200_001))
    terms = (1 - np.exp(-s * dt)) / s / (s * (s + 1))
    middle = terms[200_000]
    hold = (1 - np.exp(-1j * b.wc * dt)) / (1j * b.wc)
    assert degs(b)["hold, wc dt/2"] == pytest.approx(np.degrees(np.angle(hold)), abs=1e-12)
    # 1e-8: 400 000 terms that fall as 1/k^3 leave 1e-11 of the largest, on a small angle
    rest = np.degrees(np.angle(terms.sum() / middle))
    assert degs(b)["sampling's remainder (images)"] == pytest.approx(rest, abs=1e-8)
