"""budget and sections: names, sentences and forms to the letter, angles by hand."""

from math import atan2, degrees, pi, sqrt

import pytest

import zoh
from zoh.analysis.budget import Budget, _wrapped
from zoh.analysis.sections import Section, sections

INTEGRATOR = zoh.Plant(num=[1], den=[1, 0])


def constant(k, dt=1.0):
    return zoh.Sampled(num=[k], den=[1], dt=dt)


def refusal(*given, **more):
    with pytest.raises(zoh.SpecError) as err:
        zoh.budget(*given, **more)
    return str(err.value)


def test_refusals_in_words():
    assert refusal(INTEGRATOR, 3) == "controller must be a zoh.Sampled, got 3: give num, den and dt"
    assert refusal(3, constant(1.0)) == (
        "plant must be a plant, a sampled one or a table, got 3: zoh.Plant"
    )
    assert refusal(INTEGRATOR, constant(1.0), compute_delay=-1) == (
        "compute_delay must be 0 or more, got -1: give seconds, 0 or more"
    )
    sampled = zoh.sample(INTEGRATOR, 1.0)
    assert refusal(sampled, constant(1.0, dt=0.5)) == (
        "dt must be the plant's 1.0 s, got 0.5: use one clock"
    )
    assert refusal(sampled, constant(1.0), compute_delay=0.25) == (
        "compute_delay must be 0: a sampled plant has its delay, got 0.25: leave it out"
    )
    quiet = zoh.Plant(num=[1], den=[1, 1])
    assert refusal(quiet, constant(0.5)) == (
        "controller must make the loop's gain 1 somewhere, got "
        "Sampled(num=(0.5,), den=(1.0,), dt=1.0): a loop without a crossover has no phase margin "
        "to account for"
    )


def test_the_lines_of_a_report():
    b = Budget(
        wc=1.25, phase_margin_deg=44.99996,
        items=(Section(name="plant", deg=-90.0), Section(name="hold", deg=-45.00004),
               Section(name="nothing", deg=-0.0)),
    )  # fmt: skip
    assert b.report().splitlines() == [
        "at -180 deg the margin would be 0   +180.0000 deg",
        "plant                                -90.0000 deg",
        "hold                                 -45.0000 deg",
        "nothing                               +0.0000 deg",
        "-" * 49,  # as wide as the lines
        "phase margin at 1.25 rad/s           +45.0000 deg",
    ]
    assert b.total_deg == 180 - 90 - 45.00004
    assert b.to_dict() == {
        "wc": 1.25,
        "phase_margin_deg": 44.99996,
        "items": [
            {"name": "plant", "deg": -90.0},
            {"name": "hold", "deg": -45.00004},
            {"name": "nothing", "deg": 0.0},
        ],
    }


def test_the_names_of_all_parts():
    plant = zoh.Plant(num=[1], den=[1, 0], dead_time=0.25, sensor=-1.0)
    b = zoh.budget(plant, constant(-0.5), compute_delay=0.25)
    assert [item.name for item in b.items] == [
        "plant", "dead time", "sensor", "hold, wc dt/2", "compute delay",
        "sampling's remainder (images)", "controller: negative gain", "whole turns",
    ]  # fmt: skip
    b = zoh.budget(zoh.sample(INTEGRATOR, 1.0), constant(sqrt(2)))
    assert [item.name for item in b.items] == ["plant, hold and delays, as sampled"]


def test_a_plant_that_has_turned_by_more_than_half_a_turn():
    # (0.01/(s + 0.01))^3 at 100 rad/s and more: -90 deg three times but for 3 a/w rad
    a = 0.01
    plant = zoh.Plant(num=[a**3], den=[1, 3 * a, 3 * a * a, a**3], sensor=0.5, dead_time=0.1)
    law = zoh.Sampled.from_w(num_w=[2e3], den_w=[1.0], dt=0.1, delay=3)
    b = zoh.budget(plant, law)
    found = {item.name: item.deg for item in b.items}
    assert found["plant"] == pytest.approx(-3 * degrees(atan2(b.wc, a)), rel=1e-12)
    assert found["plant"] < -200
    assert found["sensor"] == 0.0
    late = -degrees(0.3 * b.wc)
    assert found["controller: delay of 3 samples"] == pytest.approx(late, rel=1e-14)
    assert b.total_deg == pytest.approx(b.phase_margin_deg, abs=1e-9)  # what a budget promises


def test_a_table_that_comes_sampled_is_one_item():
    sampled = zoh.sample(INTEGRATOR, 1.0)
    w = [0.1 * k for k in range(1, 32)]
    table = zoh.FrequencyResponse.from_complex(w=w, gain=[sampled.at(x) for x in w], dt=1.0)
    b = zoh.budget(table, constant(sqrt(2)))
    assert [item.name for item in b.items] == ["plant, hold and delays, as sampled"]
    # 1e-3: the curve between the points of the table
    assert (b.wc, b.items[0].deg) == pytest.approx((pi / 2, -135.0), rel=1e-3)


@pytest.mark.parametrize(
    ("deg", "wrapped"), [(0, 0), (170, 170), (190, -170), (-190, 170), (725, 5), (-540.5, 179.5)]
)
def test_an_angle_is_brought_within_half_a_turn(deg, wrapped):
    assert _wrapped(deg) == wrapped


def named(num, den, v):
    return [(s.name, pytest.approx(s.deg, abs=1e-12)) for s in sections(num, den, v)]


def test_sections_in_their_order_with_their_angles():
    # -(s + 3)(s - 1)/(s (s^2 + 2 s + 5)): the gain at 0 is -(3)(-1)/5
    found = named((-1, -2, 3), (1, 2, 5, 0), 2.0)
    pair = degrees(atan2(-2 * (-1) * 2, 5 - 4))
    assert found == [
        ("zero at 1 rad/s", -degrees(atan2(2, 1))),
        ("zero at -3 rad/s", degrees(atan2(2, 3))),
        ("integrator", -90.0),
        ("pole pair at -1 +- 2j rad/s", -pair),
    ]
    assert [name for name, _ in named((1, 0), (-1, -2), 1.0)] == [
        "negative gain", "differentiator", "pole at -2 rad/s"
    ]  # fmt: skip
    assert named((-2.0,), (-1.0,), 1.0) == []
    assert named((2.0,), (-1.0,), 1.0) == [("negative gain", -180.0)]
    assert named((0.5,), (2.0,), 1.0) == []
    assert named((2.0,), (0.5,), 1.0) == []
    assert named((-0.5,), (0.5,), 1.0) == [("negative gain", -180.0)]


def test_of_two_roots_of_one_size_the_left_one_comes_first():
    assert [name for name, _ in named((1, 0, -4), (1.0,), 1.0)] == [
        "negative gain", "zero at -2 rad/s", "zero at 2 rad/s"
    ]  # fmt: skip


def test_a_pair_turns_by_its_angle_at_any_frequency():
    for a, b in ((-0.5, 2.0), (0.5, 2.0), (-3.0, 0.25), (0.0, 2.0)):
        c = a * a + b * b
        for v in (0.1, 1.0, 2.5, 40.0):
            ((name, turn),) = named((1, -2 * a, c), (1.0,), v)
            assert name == f"zero pair at {a:.4g} +- {b:.4g}j rad/s"
            # an undamped pair is passed on the side of a damped one
            assert turn == degrees(atan2(-2 * a * v + 0.0, c - v * v))
