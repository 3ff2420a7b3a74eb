"""The proofs of no overflow: by hand, against runs, and broken on purpose."""

from dataclasses import replace

import pytest
from designs import ARM, LAWS, made

import zoh
from zoh.firmware import solver
from zoh.firmware.lines import Coefficient, Program, Routine, State, Writer
from zoh.firmware.model import Model
from zoh.firmware.ranges import Overflow, Ranges, proved
from zoh.firmware.vectors import hostile

FEATURES = [
    {"rate": 100.0, "setpoint_weight": 0.7, "derivative_weight": 0.3},
    {"anti_windup": "back_calculation", "derivative_weight": 0.0},
    {"anti_windup": "tracking", "setpoint_weight": 0.0},
]
REST = Routine(name="reset", inputs=(), lines=(), stores=())


def program(write, *, states=(), coefficients=(), stores=(), result=None, inputs=("r", "y")):
    w = Writer()
    write(w)
    step = Routine(
        name="step", inputs=inputs, lines=tuple(w.lines), stores=stores, result=result
    )  # fmt: skip
    return Program(
        number="q15", states=states, coefficients=coefficients, step=step, track=REST, reset=REST
    )


def gain(name, value):
    return Coefficient(name=name, value=value, says="")


def test_a_product_by_hand():
    found = proved(
        program(
            lambda w: w.mul("p", "k", w.sub("e", "r", "y")),
            coefficients=(gain("k", -3),),
        )
    )
    assert found.lines["step", "e"] == (-65535, 65535)
    assert found.lines["step", "p"] == (-3 * 65535, 3 * 65535)


def test_what_is_subtracted_from_itself_is_nothing():
    found = proved(program(lambda w: w.sub("none", w.add("s", "r", "y"), w.add("t", "y", "r"))))
    assert found.lines["step", "none"] == (0, 0)


def test_a_floor_and_its_rest_are_one_number():
    def write(w):
        whole = w.down("whole", "r", 4)
        back = w.mul("back", "k", whole)
        w.sub("zero", w.add("again", back, w.low("rest", "r", 4)), "r")

    found = proved(program(write, coefficients=(gain("k", 16),)))
    assert found.lines["step", "whole"] == (-2048, 2047)
    assert found.lines["step", "rest"] == (0, 15)
    assert found.lines["step", "zero"] == (0, 0)


def test_a_filter_stays_within_its_input():
    # f + alpha (r - floor(f/2^8)), alpha = 100/256: from +-32768 in steps of 2^-8 it never leaves
    def write(w):
        d = w.sub("d", "r", w.down("now", "f", 8))
        w.add("f_new", "f", w.mul("move", "alpha", d))

    ends = (-(1 << 23), (1 << 23) - 1)
    state = State(name="f", says="", least=ends[0], most=ends[1])
    stores = (("f", "f_new"),)
    found = proved(
        program(write, states=(state,), coefficients=(gain("alpha", 100),), stores=stores)
    )
    assert found.states == {"f": ends}
    # a bound that is too tight by one step of r does not hold: it is found to grow
    tight = replace(state, most=ends[1] - 256)
    found = proved(
        program(write, states=(tight,), coefficients=(gain("alpha", 100),), stores=stores)
    )
    assert found.states["f"][1] > tight.most


def test_a_sum_without_a_limit_is_found_out():
    state = State(name="x", says="the sum", group="integral")

    def endless(w):
        w.add("x_new", "x", w.mul("move", "k", "r"))

    found = proved(
        program(
            endless, states=(state,), coefficients=(gain("k", 1 << 12),), stores=(("x", "x_new"),)
        )
    )
    assert isinstance(found, Overflow)
    assert found.name == "x_new"
    slow = program(endless, states=(state,), coefficients=(gain("k", 1),), stores=(("x", "x_new"),))
    found = proved(slow)  # by 2^15 a round it would take 2^16 of them: it is gone ahead of
    assert isinstance(found, Overflow)
    assert found.name == "x_new"


def test_ranges_that_close_slowly_are_found():
    # poles of 0, -0.3125, -0.3125: |a1| + |a2| = 0.72 a round, 30 bits take more than 64 rounds
    pytest.importorskip("z3")
    controller = zoh.Sampled(num=[1, 0, 0, 0], den=[1, 0.625, 0.09765625, 0], dt=0.1)
    verified = zoh.verify(zoh.Plant(num=[0.01], den=[1, 1]), controller)
    plan = zoh.plan(
        verified, number="q15", y_range=(-2, 2), u_range=(-40, 40), realisation="cascade"
    )
    assert solver.overflow_excluded(plan)


def test_an_unlimited_result_is_found_out():
    with pytest.raises(AssertionError, match="u is limited"):
        proved(program(lambda w: w.add("u", "r", "y"), result="u"))


@pytest.mark.parametrize("number", ["q15", "q31"])
@pytest.mark.parametrize(
    ("law", "options"),
    [(law, {}) for law in LAWS]
    + [("pid_filtered", options) for options in FEATURES]
    + [("notched", {"rate": 100.0}), ("lead", {"realisation": "cascade"})],
)
def test_every_value_of_a_run_is_within_its_range(law, number, options):
    plan = made(law, number, **options)
    model, ranges = Model(plan), plan.ranges
    seen = {}
    for sample in hostile(plan, 1500):
        values = dict(model.state) | {c.name: int(c.value) for c in plan.coefficients}
        values |= dict(zip(("r", "y", "ff"), map(int, sample), strict=True))
        for line, (name, run, args) in zip(
            plan.program.step.lines, model._compiled["step"], strict=True
        ):
            values[name] = run(*[values[a] for a in args])
            low, high = ranges.lines["step", line.name]
            assert low <= values[name] <= high
            seen[name] = max(seen.get(name, 0), abs(values[name]) / max(-low, high, 1))
        model.step(*sample)
        for state, value in model.state.items():
            low, high = ranges.states[state]
            assert low <= value <= high
    assert seen["e"] > 0.99  # the rails were there


@pytest.mark.parametrize("number", ["q15", "q31"])
@pytest.mark.parametrize("law", LAWS)
def test_the_solver_agrees(law, number):
    pytest.importorskip("z3")
    options = {"rate": 100.0} if law in ("pid_filtered", "notched") else {}
    for realisation in ("auto",) if law == "leadlag" else ("auto", "cascade", "delta"):
        assert solver.overflow_excluded(made(law, number, realisation=realisation, **options))


@pytest.mark.parametrize("number", ["q15", "q31"])
@pytest.mark.parametrize("weight", [0.0, 1.0])
def test_the_solver_agrees_where_states_wait(number, weight):
    pytest.importorskip("z3")
    design = zoh.pid(ARM, dt=1e-4, wc=1.95, pm_deg=40, ki=0.85, filter_pole=15.0)
    plan = zoh.plan(
        design, number=number, u_min=-12, u_max=12, y_range=(-12, 12), derivative_weight=weight
    )
    waiting = {"x_rest", "f_rest"} if number == "q15" else {"x_rest"}  # 32 bits hold this alpha
    assert waiting <= {s.name for s in plan.program.states}
    assert solver.overflow_excluded(plan)


def test_the_solver_finds_what_overflows():
    pytest.importorskip("z3")
    plan = made("pid_filtered", "q15")
    assert solver.overflow_excluded(plan)
    large = replace(
        plan.program,
        coefficients=tuple(
            replace(c, value=c.value * 40) if c.name == "kd" else c for c in plan.coefficients
        ),
    )
    assert not solver.excluded(large, plan.ranges, 60.0)
    assert isinstance(proved(large), Overflow)
    narrow = {**plan.ranges.lines, ("step", "p"): (0, 0)}  # the type in C is taken from these
    assert not solver.excluded(plan.program, replace(plan.ranges, lines=narrow), 60.0)
    low, top = plan.ranges.states["x"][0], plan.program.value("x_max")  # where a step ends it
    tight = Ranges(lines=plan.ranges.lines, states={**plan.ranges.states, "x": (low, top - 1)})
    assert not solver.excluded(plan.program, tight, 60.0)


def test_floats_are_not_for_the_solver():
    with pytest.raises(zoh.SpecError, match="plan must be in whole numbers, got 'f32'"):
        solver.overflow_excluded(made("p", "f32"))


def test_without_the_solver_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "z3", None)
    with pytest.raises(zoh.SpecError, match=r"pip install 'zoh\[firmware\]'"):
        solver.overflow_excluded(made("p", "q15"))
