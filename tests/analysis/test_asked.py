"""Every requirement, word for word, against a measurement written down by hand."""

from dataclasses import replace
from math import inf

import pytest

from zoh.analysis.asked import Compared, missed
from zoh.analysis.results import Margins, StepInfo
from zoh.spec import Requirements

MARGINS = Margins(
    stable=True,
    gain_margin=0.1,  # -20 dB
    phase_crossover=2.0,
    phase_margin_deg=40.0,
    crossover=1.0,
    delay_margin=0.25,
    modulus_margin=0.5,  # Ms = 2
    ms_frequency=1.5,
    mt=1.5,
    mt_frequency=1.2,
    disk_margin=0.6,
    disk_frequency=1.4,
    bandwidth=1.8,
    gain_crossings=((1.0, 40.0),),
    phase_crossings=((2.0, 0.1),),
)
BETWEEN = StepInfo(
    overshoot_pct=30.0,
    undershoot_pct=0.0,
    rise_time=0.9,
    settling_time=4.0,
    peak=1.3,
    peak_time=2.0,
    final_value=1.0,
    steady_state_error=0.0,
)
STEP = replace(
    BETWEEN,
    overshoot_pct=20.0,
    rise_time=1.0,
    settling_time=5.0,
    steady_state_error=-0.5,
    between_samples=BETWEEN,
    peak_effort=80.0,
    effort_range=(-20.0, 80.0),
)

CASES = [
    ("pm_deg", 40.0, 41.0, "pm_deg must be at least 41, measured 40"),
    ("gain_margin_db", 20.0, 20.5, "gain_margin_db must be at least 20.5, measured 20"),
    ("delay_margin", 0.25, 0.3, "delay_margin must be at least 0.3, measured 0.25"),
    ("ms", 2.0, 1.9, "ms must be at most 1.9, measured 2"),
    ("mt", 1.5, 1.25, "mt must be at most 1.25, measured 1.5"),
    ("bandwidth", 1.8, 1.9, "bandwidth must be at least 1.9, measured 1.8"),
    ("overshoot_pct", 30.0, 25.0, "overshoot_pct must be at most 25, measured 30"),
    ("rise_time", 1.0, 0.95, "rise_time must be at most 0.95, measured 1"),
    ("settling_time", 5.0, 4.5, "settling_time must be at most 4.5, measured 5"),
    ("steady_state_error", 0.5, 0.1, "steady_state_error must be at most 0.1, measured 0.5"),
    ("peak_effort", 80.0, 79.9999, "peak_effort must be at most 79.9999, measured 80"),
    ("effort_min", -20.0, -19.0, "effort_min must be at least -19, measured -20"),
    ("effort_max", 80.0, 75.0, "effort_max must be at most 75, measured 80"),
    ("noise_gain", 3.0, 2.5, "noise_gain must be at most 2.5, measured 3"),
]
LEAST = ("pm_deg", "gain_margin_db", "delay_margin", "bandwidth", "effort_min")


@pytest.mark.parametrize(("name", "met", "asked", "sentence"), CASES)
def test_a_miss_is_said_in_one_sentence_and_an_equal_is_no_miss(name, met, asked, sentence):
    assert missed(Requirements(**{name: met}), MARGINS, STEP, 3.0) == []
    assert missed(Requirements(**{name: asked}), MARGINS, STEP, 3.0) == [sentence]


@pytest.mark.parametrize(("name", "met"), [case[:2] for case in CASES])
def test_equal_is_to_nine_digits(name, met):
    tighter = abs(met) if name in LEAST else -abs(met)
    assert missed(Requirements(**{name: met + tighter * 0.9e-9}), MARGINS, STEP, 3.0) == []
    assert missed(Requirements(**{name: met + tighter * 1.1e-9}), MARGINS, STEP, 3.0) != []


def test_the_edge_of_the_slack_itself_is_met():
    asked = Requirements(mt=1.0)
    assert missed(asked, replace(MARGINS, mt=1.0 + 1e-9 * 1.0), STEP) == []
    asked = Requirements(delay_margin=1.0)
    assert missed(asked, replace(MARGINS, delay_margin=1.0 - 1e-9 * 1.0), STEP) == []


def test_all_misses_are_said_in_the_order_of_the_requirements():
    asked = Requirements(**{name: value for name, _, value, _ in CASES})
    assert missed(asked, MARGINS, STEP, 3.0) == [sentence for *_, sentence in CASES]
    assert missed(Requirements(), MARGINS, STEP) == []


def test_without_a_step_response_only_margins_are_compared():
    asked = Requirements(pm_deg=41.0, overshoot_pct=1.0, peak_effort=1.0)
    assert missed(asked, MARGINS, None) == ["pm_deg must be at least 41, measured 40"]


def test_an_unstable_loop_has_nothing_else_to_answer_for():
    asked = Requirements(pm_deg=50.0)
    assert missed(asked, replace(MARGINS, stable=False), STEP) == ["the closed loop is unstable"]


def test_a_loop_not_proved_to_be_stable_is_missed_and_not_called_unstable():
    found = missed(Requirements(), replace(MARGINS, stable=None), STEP)
    assert found == ["the closed loop is not proved to be stable"]


def test_what_could_not_be_measured_is_missed():
    never = replace(STEP, settling_time=None)
    asked = Requirements(settling_time=1e9)
    assert missed(asked, MARGINS, never) == ["settling_time must be at most 1e+09, measured none"]


def test_overshoot_is_that_at_the_samples_where_there_is_no_other():
    alone = replace(STEP, between_samples=None)
    assert missed(Requirements(overshoot_pct=20.0), MARGINS, alone) == []
    assert missed(Requirements(overshoot_pct=19.0), MARGINS, alone) == [
        "overshoot_pct must be at most 19, measured 20"
    ]


def test_an_infinite_margin_meets_every_bound():
    free = replace(MARGINS, gain_margin=inf, phase_margin_deg=inf, delay_margin=inf)
    asked = Requirements(gain_margin_db=1e6, pm_deg=179.0, delay_margin=1e6)
    assert missed(asked, free, STEP) == []


def test_what_equals_its_bound_is_said_in_the_digits_of_the_bound():
    equal = Compared(name="peak_effort", bound=80.0, value=80.0, at_least=False)
    assert equal.sentence == "peak_effort must be at most 80, measured 80"
    equal = Compared(name="effort_min", bound=-1e9, value=-1e9, at_least=True)
    assert equal.sentence == "effort_min must be at least -1e+09, measured -1e+09"


@pytest.mark.parametrize(
    ("bound", "measured", "said"),
    [
        (1.25, 1.5, "mt must be at most 1.25, measured 1.5"),
        (1.2345678, 1.2345699, "mt must be at most 1.2345678, measured 1.23457"),
        (1.2345678, 1.2345682, "mt must be at most 1.2345678, measured 1.23457"),
        (1.6, 1.6000000021, "mt must be at most 1.6, measured 1.600000002"),
    ],
)
def test_figures_are_said_in_six_digits_or_in_those_that_show_the_miss(bound, measured, said):
    assert missed(Requirements(mt=bound), replace(MARGINS, mt=measured), STEP) == [said]
