"""Anything at all as any argument: a ZohError of one line, or an answer that means it."""

import signal
from contextlib import contextmanager, suppress
from decimal import Decimal
from fractions import Fraction
from inspect import signature

import numpy as np
import pytest

import zoh

PLANT = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
LAW = zoh.Sampled(num=[0.5, -0.4], den=[1, -0.1], dt=0.1)
ASKED = {"dt": 0.1, "wc": 1.95, "pm_deg": 40}
LOOP = {"plant": PLANT, "controller": LAW, "compute_delay": 0.0}
ROWS = {"w": [0.5, 1, 2], "magnitude": [2, 1, 0.5], "phase_deg": [-90, -90, -90]}
SERVO = zoh.FrequencyResponse(**ROWS)  # 1/s
TABLE = zoh.FrequencyResponse(**ROWS, dt=0.1, uncertainty=0.01, neglected=0.01)
HELD = {"plant": TABLE, "controller": zoh.Sampled(num=[1], den=[1], dt=0.1), "compute_delay": 0.0}
LABELS = {"requirements": zoh.Requirements(), "law": "p", "gains": {"kp": 1.0}, "name": "a"}
SURE = {"dt": 0.1, "uncertainty": [0.1, 0.1, 0.1], "unstable_poles": 0}
CALLS = {
    "Plant": (zoh.Plant, {"num": [1], "den": [1, 1], "dead_time": 0.0, "sensor": 1.0}),
    "Plant.parse": (zoh.Plant.parse, {"text": "1/(s+1)", "dead_time": 0.0, "sensor": 1.0}),
    "Plant.zpk": (zoh.Plant.zpk, {"zeros": [], "poles": [-1.0], "gain": 1.0}),
    "Plant.ss": (zoh.Plant.ss, {"a": [[-1.0]], "b": [[1.0]], "c": [[1.0]], "d": [[0.0]]}),
    "Plant.residues": (zoh.Plant.residues, {"residues": [1.0], "poles": [-1.0], "direct": 0.0}),
    "Plant.from_exact": (zoh.Plant.from_exact, {"num": (Decimal(1),), "den": (Decimal(2),)}),
    "Sampled": (zoh.Sampled, {"num": [1.0], "den": [1, -0.5], "dt": 0.1}),
    "Sampled.from_w": (
        zoh.Sampled.from_w, {"num_w": [1.0], "den_w": [1.0, 0.0], "dt": 0.1, "delay": 0},
    ),
    "Plant.at": (PLANT.at, {"wc": 1.0}),
    "Sampled.at": (LAW.at, {"wc": 1.0}),
    "sample": (zoh.sample, {"plant": PLANT, "dt": 0.1, "compute_delay": 0.0}),
    "discretise": (zoh.discretise, {"system": PLANT, "dt": 0.1, "method": "tustin"}),
    "undiscretise": (zoh.undiscretise, {"system": LAW, "method": "tustin"}),
    "margins": (zoh.margins, {"loop": LAW}),
    "step_info": (zoh.step_info, {"system": LAW}),
    "p": (zoh.p, {"plant": PLANT, "dt": 0.1, "wc": 0.5}),
    "pid": (zoh.pid, {"plant": PLANT, "ki": 0.85, "compute_delay": 0.0, **ASKED}),
    "lead": (zoh.lead, {"plant": PLANT, "dc_gain": 10, **ASKED}),
    "design": (
        zoh.design,
        {"plant": PLANT, "law": "p", "given": {"wc": 0.5}, "dt": 0.1, "reference": 1.0,
         "name": "a"},
    ),
    "measure": (
        zoh.measure,
        {**LOOP, **LABELS, "dt": 0.1, "reference": 1.0},
    ),
    "FrequencyResponse": (zoh.FrequencyResponse, {**ROWS, **SURE, "neglected": [0.1, 0.1, 0.1]}),
    "FrequencyResponse.from_complex": (
        zoh.FrequencyResponse.from_complex, {"w": [0.5, 1, 2], "gain": [1, 1j, -1.0], **SURE},
    ),
    "FrequencyResponse.from_bode": (
        zoh.FrequencyResponse.from_bode,
        {"hz": [0.1, 0.2, 0.3], "db": [1, 2, 3], "phase_deg": [-90, -90, -90], **SURE},
    ),
    "FrequencyResponse.at": (TABLE.at, {"wc": 1.0}),
    "FrequencyResponse.spread_at": (TABLE.spread_at, {"wc": 1.0}),
    "FrequencyResponse.neglected_at": (SERVO.neglected_at, {"wc": 1.0}),
    "FrequencyResponse.scaled": (TABLE.scaled, {"gain": 2.0}),
    "TabledLoop": (zoh.TabledLoop, {"controller": LAW, "table": TABLE}),
    "random_error": (zoh.random_error, {"coherence": [0.5, 0.6], "averages": 50}),
    "measure_table": (zoh.measure_table, {**HELD, **LABELS}),
    "verify_table": (zoh.verify_table, {**HELD, **LABELS}),
    "sample a table": (zoh.sample, {"plant": SERVO, "dt": 0.1, "compute_delay": 0.0}),
    "design on a table": (
        zoh.design,
        {"plant": TABLE, "law": "p", "given": {"wc": 1.0}, "dt": 0.1, "compute_delay": 0.0,
         "requirements": zoh.Requirements(), "name": "a"},
    ),
    "trace": (zoh.trace, {**LOOP, "reference": 1.0, "t_end": 1.0, "per_sample": 5}),
    "response": (zoh.response, {**LOOP, "by": "ramp"}),
    "response_trace": (zoh.response_trace, {**LOOP, "by": "ramp", "t_end": 1.0, "per_sample": 5}),
    "noise_gains": (zoh.noise_gains, LOOP),
    "Crossover": (zoh.Crossover, {"wc": 1.0, "pm_deg": 50}),
    "below_nyquist": (zoh.Crossover(wc=1.0, pm_deg=50).below_nyquist, {"dt": 0.1}),
    "Requirements": (zoh.Requirements, {"ms": 1.8, "effort_min": -1.0, "noise_gain": 3.0}),
}  # fmt: skip
NESTED: list[list[float]] = [[]]  # no frequencies at all, in two dimensions
NONSENSE = [
    "1", b"1", True, np.nan, np.inf, -np.inf, 1 + 2j, Decimal("0.1"), 10**400, NESTED, [1, [2, 3]],
    {"a": None}, {1.0}, object(), len, type, [None], ["1"], [True], [np.nan], [1j],
    np.ma.masked_array([1.0, 2.0], [0, 1]), np.array([True]), np.array(["1"]),
]  # fmt: skip
ODD = [None, Fraction(1, 10), -1, 0, 1e-320, 1e308, 1e-308, [], (), {}, range(3), np.array([]),
       np.zeros((2, 2)), np.float32(0.1), np.int64(1), PLANT, LAW, SERVO, TABLE]  # fmt: skip
ENTRIES = ["1", b"1", True, None, np.nan, np.inf, 10**400, {}, object(), np.ma.masked]
PLACES = [(call, argument) for call, (_, given) in CALLS.items() for argument in given]
LISTS = [
    (call, argument) for call, argument in PLACES
    if isinstance(CALLS[call][1][argument], list | tuple) and CALLS[call][1][argument]
]  # fmt: skip
EMPTY_IN_EMPTY_OUT = {"Plant.at", "Sampled.at", "FrequencyResponse.at", "random_error"}
TEXTS = {"text", "law", "name"}  # in which "1" is as good as any


@contextmanager
def at_most(seconds):
    def stop(*_):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def answer(call, argument, value):
    function, given = CALLS[call]
    assert argument in signature(function).parameters
    with at_most(20):  # far more than any answer takes
        return function(**{**given, argument: value})


@pytest.mark.filterwarnings("ignore::zoh.AccuracyWarning")
@pytest.mark.parametrize(("call", "argument"), PLACES, ids=["-".join(p) for p in PLACES])
def test_nonsense_is_refused_in_one_line(call, argument):
    for value in NONSENSE:
        if argument in TEXTS and isinstance(value, str):
            continue
        if call in EMPTY_IN_EMPTY_OUT and argument != "averages" and value is NESTED:
            continue
        with pytest.raises(zoh.ZohError) as refused:
            answer(call, argument, value)
        assert len(str(refused.value)) < 330
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("call", "argument"), LISTS, ids=["-".join(p) for p in LISTS])
def test_one_nonsense_among_numbers_is_refused(call, argument):
    for entry in ENTRIES:
        value = [*CALLS[call][1][argument][:-1], entry]
        with pytest.raises(zoh.ZohError) as refused:
            answer(call, argument, value)
        assert len(str(refused.value)) < 330
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize("averages", [1, 50, 1e300, 1.7e308])
def test_any_number_of_averages_has_its_error(averages):
    assert zoh.random_error([0.5], averages) == pytest.approx([0.5**0.5 / averages**0.5], rel=1e-15)


@pytest.mark.filterwarnings("ignore::zoh.AccuracyWarning")
@pytest.mark.parametrize(("call", "argument"), PLACES, ids=["-".join(p) for p in PLACES])
def test_odd_values_are_taken_as_what_they_are_or_refused(call, argument):
    for value in ODD:
        with suppress(zoh.ZohError):
            assert answer(call, argument, value) is not None


def test_a_warning_points_at_the_line_that_asked():
    loop = zoh.Sampled(num=[1.9], den=[1, -0.9], dt=1.0)
    with pytest.warns(zoh.AccuracyWarning) as said:
        zoh.margins(loop)
    assert [warning.filename for warning in said] == [__file__]
    with pytest.warns(zoh.AccuracyWarning) as said, suppress(zoh.NotMet):
        zoh.verify(zoh.Plant(num=[1], den=[1]), loop)
    assert [warning.filename for warning in said] == [__file__]


NO_DIMENSION = np.array(0.5)
SWEPT = {"plant": PLANT, "law": "pi", "given": {"pm_deg": 50}, "dt": 0.1, "over": {"wc": [1, 2]}}
MAPPED = {"plant": PLANT, "law": "pi", "dt": 0.1, "points": (3, 3)}
CLOCKS = {"plant": PLANT, "law": "pi", "given": {"wc": 0.5, "pm_deg": 40}, "dts": [0.1, 0.2]}
TRIED = {**SWEPT, "given": {"pm_deg": 50, "wc": [1, 2]}, "over": {"plant.gain": [1, 2]}}


@pytest.mark.parametrize(
    ("function", "given", "argument", "wrong"),
    [
        (zoh.margins, {}, "loop", [3, None, "1/s"]),
        (zoh.sweep, SWEPT, "over", [{}, 3, [1]]),
        (zoh.sweep, SWEPT, "given", ["wc", 3, [1], np.zeros(2)]),
        (zoh.sweep, SWEPT, "law", [3, np.zeros(2), "lag-lead"]),
        (zoh.sweep, SWEPT, "controller", ["1/s", 3, PLANT]),
        (zoh.sweep, SWEPT, "arithmetic", ["fast", 3, np.zeros(2)]),
        (zoh.robust, TRIED, "over", [{}, 3]),
        (zoh.robust, TRIED, "sections", [True, 3]),
        (zoh.law_map, MAPPED, "given", ["wc", 3, np.zeros(2)]),
        (zoh.law_map, MAPPED, "allow", [NO_DIMENSION, 3, {"negative_gains": True}]),
        (zoh.law_map, MAPPED, "points", [True, 3, (3,), (3, 3, 3), (1, 3)]),
        (zoh.sample_times, CLOCKS, "dts", [True, 3, NO_DIMENSION, [0.1]]),
        (zoh.notch, {}, "w0", ["1", 0, -1, None]),
        (TABLE.scaled, {}, "gain", [0, "1", 1e308]),
    ],
)
def test_an_argument_is_called_what_the_function_calls_it(function, given, argument, wrong):
    for value in wrong:
        with pytest.raises(zoh.SpecError) as refused:
            function(**{**given, argument: value})
        assert refused.value.argument == argument, value


@pytest.mark.parametrize(
    ("given", "argument"),
    [({"requirements": None}, "requirements"), ({"reference": None}, "reference"),
     ({"reference": [1, "x"]}, "reference")],
)  # fmt: skip
def test_sample_times_are_asked_for_in_words_too(given, argument):
    plant = zoh.Plant(num=[1], den=[1, 1, 0])
    with pytest.raises(zoh.SpecError) as told:
        zoh.sample_times(plant, "pd", {"wc": 2.0, "pm_deg": 60}, dts=[0.01, 0.1], **given)
    assert told.value.argument == argument
