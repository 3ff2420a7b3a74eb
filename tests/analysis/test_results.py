"""What was measured says so in words and in JSON, every key of it."""

import pickle
from dataclasses import replace
from math import inf

import pytest

from zoh.analysis.certificates import Certificate, Proof
from zoh.analysis.margins import margins
from zoh.analysis.results import Choice, Gains, Margins, StepInfo, jsonable
from zoh.lti.systems import Plant, Sampled

YES = Proof(holds=True, method="Descartes", detail="2 sign changes, 2 found")
NO = Proof(holds=False, method="halving", detail="1 sign changes on the axis, 2 found")
NAMES = [
    "stable",
    "gain_crossings",
    "phase_crossings",
    "modulus_margin",
    "mt",
    "disk_margin",
    "bandwidth",
]
COMPLETE = Certificate(**dict.fromkeys(NAMES, YES))
MARGINS = Margins(
    stable=True, gain_margin=10.0, phase_crossover=2.0, phase_margin_deg=40.0, crossover=1.5,
    delay_margin=0.25, modulus_margin=0.5, ms_frequency=1.75, mt=1.25, mt_frequency=1.375,
    disk_margin=0.75, disk_frequency=1.625, bandwidth=2.5,
    gain_crossings=((1.5, 40.0), (inf, 90.0)), phase_crossings=((2.0, 10.0),),
)  # fmt: skip
IN_JSON = {
    "stable": True, "gain_margin": 10.0, "gain_margin_db": 20.0, "phase_crossover": 2.0,
    "phase_margin_deg": 40.0, "crossover": 1.5, "delay_margin": 0.25,
    "delay_margin_samples": None, "modulus_margin": 0.5,
    "ms": 2.0, "ms_frequency": 1.75, "mt": 1.25, "mt_frequency": 1.375, "disk_margin": 0.75,
    "disk_frequency": 1.625, "bandwidth": 2.5, "gain_crossings": [[1.5, 40.0], ["inf", 90.0]],
    "phase_crossings": [[2.0, 10.0]], "certificate": None, "warnings": [],
}  # fmt: skip


def test_margins_in_json():
    assert MARGINS.to_dict() == IN_JSON
    proved = replace(MARGINS, certificate=COMPLETE, warnings=("doubt",))
    assert proved.to_dict() == IN_JSON | {
        "certificate": COMPLETE.to_dict(), "warnings": ["doubt"]
    }  # fmt: skip


def test_the_delay_margin_in_samples():
    # the integrator 1/(z - 1): |L| is 1 at pi/3 rad a sample, a sample's turn short of -1
    found = margins(Sampled(num=[1], den=[1, -1], dt=0.25))
    assert found.delay_margin_samples == pytest.approx(1.0, rel=1e-12)
    assert found.to_dict()["delay_margin_samples"] == found.delay_margin_samples
    assert margins(Plant(num=[1], den=[1, 0])).delay_margin_samples is None
    assert replace(MARGINS, delay_margin=inf, dt=0.5).to_dict()["delay_margin_samples"] == "inf"


@pytest.mark.parametrize(
    ("name", "key"),
    [
        (n, n)
        for n in (
            "gain_margin", "phase_crossover", "phase_margin_deg", "crossover", "delay_margin",
            "modulus_margin", "ms_frequency", "mt", "mt_frequency", "disk_margin",
            "disk_frequency", "bandwidth",
        )
    ],
)  # fmt: skip
def test_infinity_is_a_word_in_json(name, key):
    assert replace(MARGINS, **{name: inf}).to_dict()[key] == "inf"


def test_infinity_in_what_is_made_of_a_figure():
    assert replace(MARGINS, gain_margin=inf).to_dict()["gain_margin_db"] == "inf"
    assert replace(MARGINS, modulus_margin=0.0).to_dict()["ms"] == "inf"
    far = replace(MARGINS, phase_crossings=((1.0, inf), (2.0, -inf)))
    assert far.to_dict()["phase_crossings"] == [[1.0, "inf"], [2.0, "-inf"]]
    assert (jsonable(-inf), jsonable(0.0)) == ("-inf", 0.0)


@pytest.mark.parametrize(("ratio", "db"), [(0.1, -20.0), (1.0, 0.0), (inf, inf), (0.0, 0.0)])
def test_decibels(ratio, db):
    assert replace(MARGINS, gain_margin=ratio).gain_margin_db == pytest.approx(db)


@pytest.mark.parametrize("name", NAMES)
def test_one_open_proof_opens_the_certificate(name):
    assert (COMPLETE.holds, COMPLETE.open()) == (True, [])
    told = replace(COMPLETE, **{name: NO})
    assert (told.holds, told.open()) == (False, [name])
    yes = {"holds": True, "method": "Descartes", "detail": "2 sign changes, 2 found"}
    no = {"holds": False, "method": "halving", "detail": "1 sign changes on the axis, 2 found"}
    assert told.to_dict() == {"holds": False} | dict.fromkeys(NAMES, yes) | {name: no}


STEP = StepInfo(
    overshoot_pct=1.0, undershoot_pct=2.0, rise_time=3.0, settling_time=4.0, peak=5.0,
    peak_time=6.0, final_value=7.0, steady_state_error=8.0, horizon=9.0,
)  # fmt: skip
STEP_IN_JSON = {
    "stable": True, "overshoot_pct": 1.0, "undershoot_pct": 2.0, "rise_time": 3.0,
    "settling_time": 4.0, "peak": 5.0, "peak_time": 6.0, "final_value": 7.0,
    "steady_state_error": 8.0, "horizon": 9.0,
}  # fmt: skip


def test_a_step_in_json():
    absent = ("between_samples", "peak_effort", "peak_effort_time", "effort_range")
    assert STEP.to_dict() == STEP_IN_JSON | dict.fromkeys(absent)
    asked = replace(STEP, between_samples=STEP, peak_effort=1.5, effort_range=(-0.5, 1.5))
    assert asked.to_dict() == STEP_IN_JSON | {
        "between_samples": STEP_IN_JSON, "peak_effort": 1.5, "peak_effort_time": None,
        "effort_range": [-0.5, 1.5],
    }  # fmt: skip
    assert replace(asked, peak_effort_time=0.5).to_dict()["peak_effort_time"] == 0.5
    assert replace(STEP, stable=False).to_dict()["stable"] is False


@pytest.mark.parametrize(
    ("step", "words"),
    [
        (STEP, "4 s"),
        (replace(STEP, settling_time=1.23456), "1.235 s"),
        (replace(STEP, settling_time=0.0), "0 s"),
        (replace(STEP, stable=False), "unstable"),
        (replace(STEP, settling_time=None), "not at rest by 9 s"),
        (replace(STEP, settling_time=None, horizon=1.23456), "not at rest by 1.235 s"),
        (replace(STEP, settling_time=None, final_value=0.0), "settles to 0"),
        (replace(STEP, settling_time=None, final_value=None), "settles to 0"),
    ],
)
def test_settling_in_words(step, words):
    assert step.settling == words


def test_a_choice_in_json():
    bare = {"open": ["ki"], "assumed": [], "limits": [], "tried": [], "notes": []}
    assert Choice(open=("ki",)).to_dict() == bare
    whole = Choice(
        open=("law", "wc"), assumed=("ms",), limits=("a", "b"),
        tried=(("p", "too slow"), ("pi", "not stable")), notes=("c",),
    )  # fmt: skip
    assert whole.to_dict() == {
        "open": ["law", "wc"], "assumed": ["ms"], "limits": ["a", "b"], "notes": ["c"],
        "tried": [
            {"law": "p", "why_not": "too slow"}, {"law": "pi", "why_not": "not stable"},
        ],
    }  # fmt: skip


def test_gains_are_a_mapping_that_can_be_kept():
    gains = Gains({"kp": 1.0, "ki": 2.0})
    assert gains == {"kp": 1.0, "ki": 2.0}
    assert (gains["ki"], list(gains), len(gains)) == (2.0, ["kp", "ki"], 2)
    assert repr(gains) == "{'kp': 1.0, 'ki': 2.0}"
    assert hash(gains) == hash(Gains({"kp": 1.0, "ki": 2.0})) != hash(Gains({"kp": 1.0}))
    assert pickle.loads(pickle.dumps(gains)) == gains
    with pytest.raises(KeyError):
        gains["kd"]
