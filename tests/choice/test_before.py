"""What is refused before any search: each reason by hand, and what is said of what is chosen."""

from dataclasses import replace
from math import log

import pytest

import zoh
from zoh.choice.before import pushed_the_wrong_way
from zoh.choice.judge import Judge

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)  # an integrator
LAG = zoh.Plant(num=[2.0], den=[1, 1])


@pytest.mark.parametrize(
    ("plant", "law", "given", "asked", "why"),
    [
        (ARM, "pd", {"pm_deg": 60.0}, {"pm_deg": 70}, "a margin of 60 deg is asked"),
        (ARM, "pi", {"pm_deg": 20.0}, {"ms": 2}, "a margin of 20 deg alone makes it 2.8794"),
        (ARM, "pi", {}, {"bandwidth": 40}, "the Nyquist frequency is 31.4159 rad/s"),
        (ARM, "pi", {}, {"overshoot_pct": 0}, "add up to 0: it overshoots; a setpoint_weight"),
        (ARM, "pd", {}, {"effort_max": -1}, "the first effort of a step is not below 0"),
        (ARM, "pd", {}, {"effort_min": 1, "effort_max": 9}, "at rest it is 0"),
        # at rest u = r/G(0) = 1/2
        (LAG, "pi", {}, {"effort_max": 0.4}, "at rest it is 0.5"),
        (LAG, "pid", {}, {"effort_min": 0.6}, "at rest it is 0.5"),
        (LAG, "pid", {}, {"peak_effort": 0.4}, "peak_effort must be at most 0.4, and at rest"),
    ],
)
def test_what_no_loop_can_do_is_refused_at_once(plant, law, given, asked, why):
    searched = []
    with pytest.raises(zoh.Infeasible, match=why):
        zoh.design(
            plant, law, given, dt=0.1, requirements=zoh.Requirements(**asked),
            progress=searched.append,
        )  # fmt: skip
    assert not searched


@pytest.mark.parametrize(
    ("plant", "law", "given", "asked", "options"),
    [
        (ARM, "pd", {"pm_deg": 70.0}, {"pm_deg": 70}, {}),
        (ARM, "pi", {"setpoint_weight": 0.0}, {"overshoot_pct": 0, "pm_deg": 60}, {}),
        (LAG, "pi", {}, {"effort_max": 0.6, "overshoot_pct": 30}, {}),
        (LAG, "pi", {}, {"effort_max": 1, "effort_min": -3, "pm_deg": 60}, {"reference": -1.0}),
        (ARM, "pd", {}, {"bandwidth": 3, "pm_deg": 30}, {}),
    ],
)
def test_what_a_loop_can_do_is_not(plant, law, given, asked, options):
    asked = zoh.Requirements(**asked)
    found = zoh.design(plant, law, given, dt=0.1, requirements=asked, **options)
    assert found.choice is not None


def test_a_plant_that_answers_at_once_and_backwards_may_need_the_other_sign_first():
    # G = -1 - (z - 0.5)/(z - 2): under kp = 1 the loop's pole is 0.5, and u0 = r/(1 + G(inf)) = -r
    pole = log(2) / 0.1
    plant = zoh.Plant(num=[-2.0, 0.5 * pole], den=[1.0, -pole])
    at_once = zoh.sample(plant, 0.1)
    assert at_once.num == pytest.approx([-2.0, 2.5], rel=1e-12)
    assert at_once.den == pytest.approx([1.0, -2.0], rel=1e-12)
    asked = zoh.Requirements(effort_max=-0.1)
    judge = Judge(
        plant=plant, sampled=at_once, compute_delay=0.0, requirements=asked, reference=1.0
    )  # fmt: skip
    assert pushed_the_wrong_way(judge, "p") == ""
    later = replace(judge, plant=LAG, sampled=zoh.sample(LAG, 0.1))
    assert "the first effort of a step is not below 0" in pushed_the_wrong_way(later, "p")


def test_an_integral_that_is_given_may_be_next_to_none():
    plant, asked = zoh.Plant(num=[1], den=[1, 0]), zoh.Requirements(overshoot_pct=0)
    found = zoh.pid(plant, dt=0.1, ki=1e-9, pm_deg=89.9, requirements=asked)
    assert found.step.overshoot_pct == 0


def test_the_zeros_of_a_notch_are_not_said_to_creep():
    notch = zoh.notch(w0=20, depth=0.02)
    found = zoh.pi(zoh.Plant(num=[1], den=[1, 0]), dt=0.01, pm_deg=60, sections=[notch])
    assert found.choice.notes == ()


def test_a_jump_from_one_sample_to_the_next_takes_the_time_that_it_takes():
    # 1/s, 0.1 s, a P of 1/dt: y runs from 0 to 1 in one sample, 80 % of it from 10 to 90 %
    plant = zoh.Plant(num=[1], den=[1, 0])
    found = zoh.verify(plant, zoh.Sampled(num=[10.0], den=[1.0], dt=0.1))
    assert found.step.rise_time == 0
    assert found.step.between_samples.rise_time == pytest.approx(0.08)
    within = zoh.Requirements(rise_time=0.0801)
    assert zoh.verify(plant, found.controller, requirements=within).misses == ()
    with pytest.raises(zoh.NotMet, match=r"rise_time must be at most 0.05, measured 0.08"):
        zoh.verify(plant, found.controller, requirements=zoh.Requirements(rise_time=0.05))
    with pytest.raises(zoh.NotMet, match=r"settling_time must be at most 0.05, measured 0.1"):
        zoh.verify(plant, found.controller, requirements=zoh.Requirements(settling_time=0.05))


def test_what_is_said_of_a_slow_zero_and_of_a_robustness_that_nothing_bounds():
    # a lag of gain 10 at rest, as fast as its margin lets it be, has its corners far below
    slow = zoh.lag(ARM, dt=0.1, pm_deg=50, dc_gain=10.0)
    (note,) = slow.choice.notes
    assert "a zero of the controller, which what was given brings, is at 2.18e-05 rad/s" in note
    assert "zero slower" not in " ".join(slow.choice.limits)
    bare = zoh.pd(ARM, dt=0.1, requirements=zoh.Requirements(rise_time=0.5))
    (note,) = bare.choice.notes
    assert note.startswith("nothing that was asked bounds the robustness: the phase margin is 1 ")
    assert zoh.pi(ARM, dt=0.1).choice.notes == ()


def test_a_lag_corner_that_is_given_is_not_held_to_the_rule_of_slow_zeros():
    found = zoh.leadlag(ARM, dt=0.1, pm_deg=40, lag_corner=0.1)
    assert found.margins.crossover > 1.95  # at which all is met, too
    assert "at 0.1 rad/s" in found.choice.notes[0]


def test_where_a_given_crossover_is_too_fast_the_nearest_one_is_named():
    asked = zoh.Requirements(ms=1.6)
    with pytest.raises(zoh.Infeasible) as refused:
        zoh.pi(ARM, dt=0.1, wc=3.0, requirements=asked)
    nearest = refused.value.nearest_wc
    assert zoh.pi(ARM, dt=0.1, wc=nearest, requirements=asked).margins.ms <= 1.6 * (1 + 1e-9)
    assert refused.value.needed_gain == pytest.approx(1 / abs(zoh.sample(ARM, 0.1).at(3.0)))
    # 1.001: the edge is closed in on to 1e-4 of wc, and what is met is not had far above it
    with pytest.raises(zoh.Infeasible):
        zoh.pi(ARM, dt=0.1, wc=nearest * 1.001, requirements=asked)
