"""verify: every word and number of the report and of the refusals, on loops known by hand."""

from dataclasses import replace

import pytest

import zoh
from zoh.analysis import verify as room
from zoh.analysis.results import Choice
from zoh.analysis.verify import Measured, Verified, measure, verified, verify
from zoh.errors import NotMet, SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.spec import Requirements

INTEGRATOR = Plant(num=[1], den=[1, 0])
HALF = Sampled(num=[0.5], den=[1], dt=1.0)


def fields(found):
    return {name: getattr(found, name) for name in Measured.__dataclass_fields__}


# L = 0.5/(z - 1). |L| = 1 at 2 asin(1/4) = 0.505361 rad/s, where its phase is 14.4775 deg short
# of -90 deg: 75.5225 deg, or 75.5225 pi/180/0.505361 = 2.608 s. At z = -1 L = -1/4: 12.04 dB and
# Ms = 4/3. T = 0.5/(z - 0.5) falls to 10^(-3/20) where cos w = (1.25 - 0.25 10^0.3) = 0.751184.
# y = 1 - 2^-k at the samples: 10 % at 1, 90 % at 4, 2 % at 6.
REPORT = """\
half: p with kp = 0.5, ki = 1
  standard form: kp = 0.5, ti = 0.5
  series form: k = 0.5, ti = 0.5
  D(z) = 0.5, dt = 1 s
  closed loop stable
  phase margin 75.5225 deg at 0.505361 rad/s, gain margin 12.04 dB at 3.14159 rad/s
  delay margin 2.608 s, Ms 1.333, Mt 1, bandwidth 0.720942 rad/s
  step: overshoot 0 %, rise 3 s, settling 6 s, peak effort 0.5
  proved: stability, every crossing, every peak"""


def test_a_report_by_hand():
    found = measure(INTEGRATOR, HALF, law="p", name="half", gains={"kp": 0.5, "ki": 1.0})
    assert found.report() == REPORT


def test_what_is_not_proved_is_not_called_so():
    found = measure(INTEGRATOR, HALF, law="p", name="half", gains={"kp": 0.5, "ki": 1.0})
    *wanted, _ = REPORT.splitlines()
    one = found.margins.certificate
    doubtful = replace(one, mt=replace(one.mt, holds=False))
    for certificate in (None, doubtful):
        margins = replace(found.margins, certificate=certificate)
        assert replace(found, margins=margins).report().splitlines() == wanted


def test_a_report_of_an_unstable_loop():
    # 3/(z - 1): |L| is 1.5 at least, at z = -1; the pole of the closed loop is z = -2, and
    # T = 3/(z + 2) is 3 at z = -1, S = (z - 1)/(z + 2) is 2 there
    assert measure(INTEGRATOR, Sampled(num=[3.0], den=[1], dt=1.0)).report() == (
        "given: given\n"
        "  D(z) = 3, dt = 1 s\n"
        "  closed loop UNSTABLE\n"
        "  phase margin inf deg at no rad/s, gain margin -3.522 dB at 3.14159 rad/s\n"
        "  delay margin 1 s, Ms 2, Mt 3, bandwidth no rad/s\n"
        "  proved: stability, every crossing, every peak\n"
        "  MISSED: the closed loop is unstable"
    )


def test_a_report_of_a_step_that_comes_back_to_nothing():
    found = measure(Plant(num=[1, 0], den=[1, 1]), HALF)
    assert "  step: no overshoot defined, never rises, settles to 0, peak effort 0.5" in (
        found.report().splitlines()
    )


def test_a_report_without_an_effort():
    found = measure(INTEGRATOR, HALF)
    silent = replace(found, step=replace(found.step, peak_effort=None))
    assert silent.report() == found.report().replace(", peak effort 0.5", "")
    assert silent.to_dict()["step"] is None


def test_the_overshoot_told_is_that_between_the_samples():
    found = measure(INTEGRATOR, HALF)
    inside = replace(found.step.between_samples, overshoot_pct=12.345678)
    at_samples = replace(found.step, overshoot_pct=2.0)
    told = replace(found, step=replace(at_samples, between_samples=inside)).report()
    assert "  step: overshoot 12.35 %, rise 3 s" in told
    told = replace(found, step=replace(at_samples, between_samples=None)).report()
    assert "  step: overshoot 2 %, rise 3 s" in told


def test_notes_and_misses_stand_at_the_end():
    found = measure(INTEGRATOR, HALF)
    margins = replace(found.margins, warnings=("digits are lost", "and more"))
    lines = replace(found, margins=margins, misses=("too slow",)).report().splitlines()
    assert lines[-3:] == ["  NOTE: digits are lost", "  NOTE: and more", "  MISSED: too slow"]


def test_the_dictionary_by_hand():
    sensor = replace(INTEGRATOR, sensor=-0.25)
    backwards = Sampled(num=[-2.0], den=[1], dt=1.0)
    found = measure(sensor, backwards, law="p", gains={"kp": -2.0}).to_dict()
    step = found.pop("step")
    assert step["peak_effort"] == pytest.approx(2.0, rel=1e-15)
    # a step of 1 of the plant's output is one of 1/4 of the sensor's
    assert step["peak_effort_output_step"] == pytest.approx(0.5, rel=1e-15)
    assert found.pop("margins")["gain_margin"] == pytest.approx(4.0, rel=1e-12)
    controller = {"num": [-2.0], "den": [1.0], "dt": 1.0, "num_w": [-2.0], "den_w": [1.0]}
    assert found == {
        "name": "p", "law": "p", "feasible": True, "reason": None, "gains": {"kp": -2.0},
        "controller": controller, "met": True, "misses": [], "noise_gain": None,
        "choice": None, "allowed": [], "setpoint_weight": 1.0, "derivative_weight": 1.0,
        "reference_path": None,
        "forms": {
            "parallel": {"kp": -2.0}, "standard": {"kp": -2.0}, "series": {"k": -2.0},
            "refused": {},
        },
    }  # fmt: skip
    unstable = measure(INTEGRATOR, backwards).to_dict()
    assert unstable["step"] is None
    assert (unstable["met"], unstable["misses"]) == (False, ["the closed loop is unstable"])


def test_the_dictionary_of_a_weighted_reference_has_its_path():
    # u = 0.5 (0.75 r - y): -0.125 r beside the law, and 0.375 r in all
    found = measure(INTEGRATOR, HALF, gains={"kp": 0.5}, setpoint_weight=0.75)
    assert (found.feedforward.num, found.feedforward.den) == ((-0.125,), (1.0,))
    told = found.to_dict()
    assert (told["setpoint_weight"], told["derivative_weight"]) == (0.75, 1.0)
    assert told["reference_path"] == {
        "num": [0.375], "den": [1.0], "dt": 1.0, "num_w": [0.375], "den_w": [1.0]
    }  # fmt: skip


REFUSED = [
    ({"dt": 2.0}, "dt must be the controller's 1.0 s, got 2.0: use one clock"),
    ({"reference": 0}, "reference must not be 0, got 0.0: a step of 0 shows nothing"),
    (
        {"reference": "a"},
        "reference must be a real number, got 'a': give the size of the step",
    ),
    (
        {"requirements": 3},
        "requirements must be zoh.Requirements, got 3: zoh.Requirements(ms=1.8)",
    ),
    (
        {"controller": 3},
        "controller must be a zoh.Sampled, got 3: give num, den and dt",
    ),
    *(
        ({name: -1.0}, f"{name} must be 0 or more, got -1.0: give zero or more")
        for name in ("setpoint_weight", "derivative_weight")
    ),
    (
        {"gains": {"kp": 0.25}, "setpoint_weight": 0.5},
        "gains must be those of the controller where its reference is weighted, "
        "got {'kp': 0.25}: give kp, ki, kd and filter_pole",
    ),
]


@pytest.mark.parametrize(("wrong", "sentence"), REFUSED, ids=[next(iter(w)) for w, _ in REFUSED])
@pytest.mark.parametrize("ask", [measure, verify])
def test_refusals_name_what_is_wrong_and_the_way_out(ask, wrong, sentence):
    with pytest.raises(SpecError) as err:
        ask(**({"plant": INTEGRATOR, "controller": HALF} | wrong))
    assert str(err.value) == sentence


def test_a_weighted_filter_of_the_derivative_must_be_stable():
    # 0.5 + w/(1 - w/3) in w = 2 (z - 1)/(z + 1): the derivative's pole is on the right, at w = 3
    gains = {"kp": 0.5, "kd": 1.0, "filter_pole": -3.0}
    d = Sampled.from_w(num_w=[0.5 / -3 + 1, 0.5], den_w=[1 / -3, 1.0], dt=1.0)
    with pytest.raises(SpecError) as err:
        measure(INTEGRATOR, d, gains=gains, derivative_weight=0.5)
    assert str(err.value) == (
        "controller must be stable where the reference is weighted, "
        "got 'an unstable filter': leave the weights out"
    )


def test_the_weights_of_a_reference_are_told_where_they_count():
    p = measure(INTEGRATOR, HALF, gains={"kp": 0.5}, setpoint_weight=0.75)
    lines = p.report().splitlines()
    assert lines[lines.index("  reference weighted by b = 0.75") - 1] == (
        "  phase margin 75.5225 deg at 0.505361 rad/s, gain margin 12.04 dB at 3.14159 rad/s"
    )
    gains = {"kp": 0.5, "kd": 0.25, "filter_pole": 2.0}  # at dt = 1: 0.5 + 0.25 (z - 1)/z
    pd = Sampled(num=[0.75, -0.25], den=[1, 0], dt=1.0)
    told = measure(INTEGRATOR, pd, gains=gains, setpoint_weight=0.75, derivative_weight=0)
    assert "  reference weighted by b = 0.75, c = 0" in told.report().splitlines()
    assert "weighted" not in measure(INTEGRATOR, pd, gains=gains).report()


def test_a_table_is_no_model():
    table = zoh.FrequencyResponse(w=[1.0, 2.0], magnitude=[1.0, 0.5], phase_deg=[-90.0, -90.0])
    with pytest.raises(SpecError) as err:
        measure(table, HALF)
    assert (err.value.argument, err.value.bound) == ("plant", "must be a model")
    assert err.value.value is table
    assert err.value.way_out == "zoh.measure_table is for tables"


def test_everything_given_is_kept():
    asked = Requirements(ms=3.0)
    found = verify(
        INTEGRATOR, HALF, dt=1.0, compute_delay=0.25, requirements=asked, reference=-3.0,
        law="p", gains={"kp": 0.5}, name="mine",
    )  # fmt: skip
    assert type(found) is Verified
    assert (found.plant, found.controller, found.requirements) == (INTEGRATOR, HALF, asked)
    assert (found.compute_delay, found.reference) == (0.25, -3.0)
    assert (found.law, dict(found.gains), found.name) == ("p", {"kp": 0.5}, "mine")
    assert found.sampled == zoh.sample(INTEGRATOR, 1.0, 0.25)
    # 1/s whose input comes a quarter of a sample late: L = (0.375 z + 0.125)/(z (z - 1)),
    # y = 0, -3 (0.375), ...; the largest effort is the first
    assert found.step.peak_effort == pytest.approx(1.5, rel=1e-15)
    assert found.step.final_value == pytest.approx(-3.0, rel=1e-15)
    plain = measure(INTEGRATOR, HALF)
    assert (plain.law, plain.name, dict(plain.gains)) == ("given", "given", {})
    assert (plain.reference, plain.compute_delay) == (1.0, 0.0)
    assert plain.requirements == Requirements()
    assert fields(verify(INTEGRATOR, HALF)) == fields(plain)
    assert measure(INTEGRATOR, HALF, law="pd").name == "pd"


def test_what_is_missed_carries_its_evidence():
    asked = Requirements(peak_effort=0.25)
    sentence = "peak_effort must be at most 0.25, measured 0.5"
    evidence = measure(INTEGRATOR, HALF, requirements=asked)
    assert evidence.misses == (sentence,)
    for make in (
        lambda: verified(evidence),
        lambda: Verified(**fields(evidence)),
        lambda: Verified(**fields(replace(evidence, misses=()))),
    ):
        with pytest.raises(NotMet) as err:
            make()
        assert err.value.misses == (sentence,)
        assert isinstance(err.value.measured, Measured)


def test_evidence_of_another_loop_is_none():
    found = measure(INTEGRATOR, HALF)
    other = Sampled(num=[0.5 * (1 + 2e-6)], den=[1], dt=1.0)
    nearly = Sampled(num=[0.5 * (1 + 1e-7)], den=[1], dt=1.0)
    late = {"compute_delay": 1e-5}
    for change in ({"controller": other}, late, {"step": None}):
        with pytest.raises(NotMet) as err:
            Verified(**fields(found) | change)
        assert err.value.misses == ("the evidence is not this loop's",)
        assert type(err.value.measured) is Verified
    assert Verified(**fields(found) | {"controller": nearly}).met  # rounding is forgiven
    # a loop without a crossing says nothing but that it is stable; another that is not is refused
    quiet = measure(Plant(num=[1], den=[1, 1]), HALF)
    loud = Sampled(num=[30.0], den=[1], dt=1.0)
    with pytest.raises(NotMet, match="the evidence is not this loop's"):
        Verified(**fields(quiet) | {"controller": loud})


def test_a_label_of_a_miss_is_enough_to_be_refused():
    with pytest.raises(NotMet) as err:
        Verified(**fields(measure(INTEGRATOR, HALF)) | {"misses": ("something",)})
    assert err.value.misses == ("something",)


def test_lost_digits_are_warned_of_where_the_caller_stands(monkeypatch):
    measured = room.measure_loop
    sentences = ("digits are lost",)
    monkeypatch.setattr(room, "measure_loop", lambda x: replace(measured(x), warnings=sentences))
    with pytest.warns(zoh.AccuracyWarning, match="^digits are lost$") as caught:
        measure(INTEGRATOR, HALF)
    assert [w.filename for w in caught] == [__file__]


@pytest.mark.parametrize(
    "call",
    [
        lambda: zoh.verify(INTEGRATOR, HALF),
        lambda: zoh.pi(INTEGRATOR, dt=1.0, wc=0.3, pm_deg=50),
        lambda: zoh.design(INTEGRATOR, "p", {"wc": 0.3}, dt=1.0),
    ],
)
def test_a_warning_points_past_every_frame_of_the_package(monkeypatch, call):
    measured = room.measure_loop
    monkeypatch.setattr(room, "measure_loop", lambda x: replace(measured(x), warnings=("lost",)))
    with pytest.warns(zoh.AccuracyWarning, match="^lost$") as caught:
        call()
    assert {w.filename for w in caught} == {__file__}


def test_what_the_module_gives_out():
    given = {}
    exec("from zoh.analysis.verify import *", given)
    assert {"Measured", "Verified", "measure", "verified", "verify"} <= set(given)
    assert isinstance(given["verify"](INTEGRATOR, HALF), given["Verified"])


def test_nothing_is_missed_unless_it_is_said():
    values = fields(measure(INTEGRATOR, HALF))
    del values["misses"]
    assert Measured(**values).misses == ()
    assert Verified(**values).met


def test_a_controller_is_written_in_z():
    lead = Sampled(num=[2.0, -1.0], den=[1, -0.5], dt=0.125)
    told = measure(INTEGRATOR, lead).report()
    assert told.splitlines()[1] == "  D(z) = (2 z - 1)/(z - 0.5), dt = 0.125 s"


def test_a_verdict_that_is_not_proved_in_words():
    found = measure(INTEGRATOR, HALF)
    open_ = replace(found, margins=replace(found.margins, stable=None))
    assert open_.report().splitlines()[2] == "  closed loop NOT PROVED to be stable"


def test_what_was_chosen_is_said_after_the_figures():
    found = measure(INTEGRATOR, HALF, law="p", name="half", gains={"kp": 0.5, "ki": 1.0})
    choice = Choice(open=("wc",), limits=("above 2 rad/s ms must be at most 1.7",))
    chosen = replace(found, choice=choice)
    assert chosen.report().splitlines() == [
        *REPORT.splitlines(), *(f"  {sentence}" for sentence in choice.sentences)
    ]  # fmt: skip
    assert chosen.to_dict()["choice"] == choice.to_dict()
    assert found.to_dict()["choice"] is None


def test_a_sample_time_that_is_no_number():
    with pytest.raises(SpecError, match=r"^dt must be .*got 'x': give seconds$"):
        measure(INTEGRATOR, HALF, dt="x")


def test_a_record_without_noise_or_choice():
    kept = fields(measure(INTEGRATOR, HALF))
    del kept["noise_gain"], kept["choice"], kept["misses"]
    bare = Measured(**kept)
    assert (bare.noise_gain, bare.choice, bare.misses) == (None, None, ())


def test_noise_comes_through_the_delay_that_is_there():
    """0.5/(z (z - 1)): u is -(1/2)(1 - (1/2)/(z^2 - z + 1/2)) of the noise.

    1/(z^2 - z + 1/2) has a sum of squares of (3/2)/((1/2)(9/4 - 1)) = 2.4: 1/4 + 2.4/16 is 0.4.
    """
    asked = Requirements(noise_gain=1.0)
    found = measure(INTEGRATOR, HALF, compute_delay=1.0, requirements=asked)
    assert found.noise_gain == pytest.approx(0.4**0.5, rel=1e-12)
