"""A part of the torture suite on every commit, and the suite itself put to the test."""

import random
from dataclasses import replace
from fractions import Fraction
from math import isclose

import pytest
from benchmarks.torture import exact, generate, held, loops, measure, named, run_zoh, score
from mpmath import mp

import zoh
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop

LOOPS = {spec["name"]: spec for spec in loops.read(loops.LOOPS)}
TRUTH = {truth["name"]: truth for truth in loops.read(loops.TRUTH)}
ONCE_WRONG = ["robot PID, 0.03-0.3 s #82", "continuous, dead time #34", "continuous, dead time #46"]
PART = [name for i, (name, s) in enumerate(LOOPS.items()) if s["class"] == "named" or i % 8 == 0]
AGAIN = [*list(LOOPS)[:4], *random.Random(1).sample(list(LOOPS), 16)]


@pytest.mark.parametrize("name", [*PART, *ONCE_WRONG])
def test_zoh_has_nothing_wrong(name):
    said = run_zoh.answer(LOOPS[name])
    assert said.error is None
    assert score.faults(LOOPS[name], TRUTH[name], said, score.STRICT) == frozenset()


PARAMETERS = [name for name, spec in LOOPS.items() if spec["form"] == "params"]


def test_no_loop_is_lost_to_rounding_in_silence():
    """Each loop from parameters, typed in as z-coefficients: what moved far is warned of."""
    lost = warned = 0
    for name in PARAMETERS:
        true = zoh.margins(run_zoh.loop(LOOPS[name]))
        z = loops.in_z(LOOPS[name])
        typed = measure_loop(Loop.of(zoh.Sampled(num=z["num"], den=z["den"], dt=z["dt"])))
        moved = (
            typed.stable is not true.stable
            or not isclose(typed.phase_margin_deg, true.phase_margin_deg, rel_tol=0, abs_tol=0.1)
            or not isclose(typed.gain_margin, true.gain_margin, rel_tol=0.01)
            or not isclose(typed.ms, true.ms, rel_tol=0.01)
        )
        lost, warned = lost + moved, warned + bool(typed.warnings)
        assert typed.warnings or not moved, name
    assert lost > 40
    assert warned < 1.5 * lost  # a bound, but no false alarm as a rule


@pytest.mark.parametrize("name", PART)
def test_every_margin_is_proved(name):
    assert measure_loop(Loop.of(run_zoh.loop(LOOPS[name]))).certificate.holds


@pytest.mark.parametrize("name", AGAIN)
def test_the_truth_that_is_written_down_is_what_the_script_finds(name):
    assert measure.measured(LOOPS[name]) == TRUTH[name]


@pytest.mark.parametrize("label", generate.CLASSES)
def test_every_machine_draws_the_same_loops(label):
    count, draw = generate.CLASSES[label]
    for i in range(0, count, count // 6):
        name = f"{label} #{i}"
        drawn = draw(random.Random(f"{label}/{i}"))
        assert LOOPS[name] == {"name": name, "class": label, **drawn}


def test_there_are_as_many_loops_as_promised_and_a_truth_for_each():
    assert len(LOOPS) >= 1000 + len(list(named.named()))
    assert LOOPS.keys() == TRUTH.keys()


# The scorer must see a wrong answer: one that is right, moved by more than is allowed.
RIGHT = "leaves at z = -1: gain margin 1.5"


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"gm": 1.5 * (1 + 3e-9)}, "GM"),
        ({"gm": float("inf")}, "GM"),
        ({"pm_deg": 75.52248781407008 + 3e-9}, "PM"),
        ({"stable": False}, "stable"),
        ({"ms": 3.0 * (1 + 3e-9)}, "Ms"),
        ({"gains": ()}, "missed"),
        ({"phases": ((1.0, 2.0), (3.141592653589793, 1.5))}, "invented"),
        ({"phases": ((3.141592653589793 * (1 - 1e-8), 1.5),)}, "off"),
        ({"delay": 1.0 + 3e-9}, "delay"),
        ({"error": "ValueError"}, "PM"),
    ],
)
def test_a_wrong_answer_is_seen(change, fault):
    spec, truth = LOOPS[RIGHT], TRUTH[RIGHT]
    said = run_zoh.answer(spec)
    assert score.faults(spec, truth, said, score.STRICT) == frozenset()
    assert fault in score.faults(spec, truth, replace(said, **change), score.STRICT)


def test_a_gain_margin_without_the_ends_is_accepted_by_the_generous_measure_alone():
    spec, truth = LOOPS[RIGHT], TRUTH[RIGHT]
    said = replace(run_zoh.answer(spec), gm=float("inf"), phases=())
    assert score.faults(spec, truth, said, score.GENEROUS) == frozenset()
    assert score.faults(spec, truth, said, score.STRICT) >= {"GM", "missed"}


def polynomial(roots):
    out = [Fraction(1)]
    for r in roots:
        out = [(out[i - 1] if i else 0) - (r * out[i] if i < len(out) else 0)
               for i in range(len(out) + 1)]  # fmt: skip
    scale = Fraction(1)
    for c in out:
        scale *= Fraction(c).denominator
    return [int(c * scale) for c in out]


@pytest.mark.parametrize(
    ("roots", "expected"),
    [
        ([Fraction(1, 3)], [(1 / 3, True)]),
        ([Fraction(1, 2), Fraction(1, 4)], [(0.25, True), (0.5, True)]),
        ([Fraction(1, 3)] * 2, [(1 / 3, False)]),  # touches
        ([Fraction(1, 7)] * 3, [(1 / 7, True)]),
        ([0, 1, Fraction(2, 5), 2, -1], [(0.4, True)]),  # ends and outside left out
        ([Fraction(1, 10**12), Fraction(2, 10**12)], [(1e-12, True), (2e-12, True)]),
        ([Fraction(1, 3), Fraction(1, 3) + Fraction(1, 10**30)], [(1 / 3, True)] * 2),
    ],
)
def test_roots_are_isolated_and_none_is_missed(roots, expected):
    with mp.workdps(60):
        found = [(float(exact.number(at)), flips) for at, flips in exact.roots(polynomial(roots))]
    assert len(found) == len(expected)
    for (x, flips), (y, wanted) in zip(found, expected, strict=True):
        assert isclose(x, y, rel_tol=1e-15)
        assert flips == wanted


def test_two_complex_roots_beside_the_axis_are_no_roots():
    assert exact.roots([10**24 + 4, -4 * 10**24, 4 * 10**24]) == []  # (1 - 2y)^2 + 4e-24


@pytest.mark.parametrize("delay", [0.0, 0.3, 1.0, 2.7])
def test_a_held_double_integrator_by_hand(delay):
    # 1/s^2 with dt = 1 and e = m - delay: ((e^2) z^2 + (1 + 2e - 2e^2) z + (1-e)^2)/(2 (z-1)^2)
    num, den, m = held.held([1.0], [1.0, 0.0, 0.0], 1.0, delay)
    e = m - Fraction(delay)
    expected = [(1 - e) ** 2 / 2, (1 + 2 * e - 2 * e * e) / 2, e * e / 2]
    assert [float(c) for c in den] == [1.0, -2.0, 1.0]
    assert [float(c) for c in num] == pytest.approx([float(c) for c in expected], rel=1e-15)
