"""Only what was measured stable and within its requirements becomes Verified."""

import dataclasses
import json
from dataclasses import fields

import pytest

from zoh.analysis.margins import margins
from zoh.analysis.responses import noise_gains
from zoh.analysis.verify import Measured, Verified, measure, verify
from zoh.errors import NotMet, SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample
from zoh.spec import Requirements

ARM = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
P = Sampled(num=[4.0], den=[1], dt=0.1)
TOO_LOUD = Sampled(num=[4000.0], den=[1], dt=0.1)


def test_measures_what_the_margin_routine_measures_of_the_loop():
    found = measure(ARM, P)
    wanted = margins(P * sample(ARM, 0.1))
    assert found.margins.gain_margin == pytest.approx(wanted.gain_margin, rel=1e-12)
    assert found.margins.phase_margin_deg == pytest.approx(wanted.phase_margin_deg, abs=1e-10)
    assert found.margins.crossover == pytest.approx(wanted.crossover, rel=1e-12)
    assert found.dt == 0.1
    assert found.loop.at(1.0) == pytest.approx(P.at(1.0) * sample(ARM, 0.1).at(1.0), rel=1e-13)
    assert found.misses == ()
    assert found.met


def test_compute_delay_is_in_the_loop():
    late = measure(ARM, P, compute_delay=0.04)
    prompt = measure(dataclasses.replace(ARM, dead_time=0.04), P)
    assert late.margins == prompt.margins
    assert late.step == prompt.step
    assert late.margins.phase_margin_deg < measure(ARM, P).margins.phase_margin_deg


def test_an_unstable_loop_has_no_step_and_is_never_verified():
    found = measure(ARM, TOO_LOUD)
    assert not found.margins.stable
    assert found.step is None
    assert not found.met
    assert any("stable" in miss for miss in found.misses)
    with pytest.raises(NotMet) as err:
        verify(ARM, TOO_LOUD)
    assert err.value.misses == found.misses
    assert isinstance(err.value.measured, Measured)
    assert not isinstance(err.value.measured, Verified)


# each requirement just missed and just met by what was measured
BOUNDS = [
    ("pm_deg", lambda m: m.margins.phase_margin_deg, +1),
    ("gain_margin_db", lambda m: m.margins.gain_margin_db, +1),
    ("delay_margin", lambda m: m.margins.delay_margin, +1),
    ("ms", lambda m: m.margins.ms, -1),
    ("mt", lambda m: m.margins.mt, -1),
    ("overshoot_pct", lambda m: m.step.between_samples.overshoot_pct, -1),
    ("rise_time", lambda m: m.step.rise_time, -1),
    ("settling_time", lambda m: m.step.settling_time, -1),
    ("peak_effort", lambda m: m.step.peak_effort, -1),
    ("bandwidth", lambda m: m.margins.bandwidth, +1),
    ("effort_min", lambda m: m.step.effort_range[0], +1),
    ("effort_max", lambda m: m.step.effort_range[1], -1),
    ("noise_gain", lambda m: noise_gains(m.plant, m.controller)[1], -1),
]


def test_the_table_names_every_requirement_but_the_error():
    assert {b[0] for b in BOUNDS} | {"steady_state_error"} == {f.name for f in fields(Requirements)}


@pytest.mark.parametrize(("name", "value", "side"), BOUNDS, ids=[b[0] for b in BOUNDS])
def test_each_requirement_is_asked(name, value, side):
    controller = Sampled(num=[12.0], den=[1], dt=0.1)  # overshoots
    here = value(measure(ARM, controller))
    missed = Requirements(**{name: here + side * abs(here) * 1e-6})
    met = Requirements(**{name: here - side * abs(here) * 1e-6})
    assert verify(ARM, controller, requirements=met).met
    with pytest.raises(NotMet) as err:
        verify(ARM, controller, requirements=missed)
    assert len(err.value.misses) == 1


def test_the_error_at_rest_is_asked():
    lag, p = Plant(num=[1], den=[1, 1]), Sampled(num=[1.0], den=[1], dt=0.1)  # rests at 1/2
    assert verify(lag, p, requirements=Requirements(steady_state_error=0.5000001)).met
    with pytest.raises(NotMet):
        verify(lag, p, requirements=Requirements(steady_state_error=0.4999999))


def test_several_misses_are_all_told():
    with pytest.raises(NotMet) as err:
        verify(ARM, P, requirements=Requirements(pm_deg=179, settling_time=1e-3, peak_effort=1e-3))
    assert len(err.value.misses) == 3
    assert str(err.value).count(";") >= 2


def test_verified_cannot_be_made_of_evidence_that_misses():
    good = measure(ARM, P)
    bad = measure(ARM, TOO_LOUD)
    values = {f.name: getattr(bad, f.name) for f in fields(Measured)}
    with pytest.raises((NotMet, SpecError)):
        Verified(**values)
    picky = {f.name: getattr(good, f.name) for f in fields(Measured)}
    picky["misses"] = ("something",)
    with pytest.raises((NotMet, SpecError)):
        Verified(**picky)


def test_verified_looks_at_the_evidence_and_not_at_the_label():
    """An unstable loop whose list of misses was emptied is still unstable."""
    bad = measure(ARM, TOO_LOUD)
    values = {f.name: getattr(bad, f.name) for f in fields(Measured)} | {"misses": ()}
    with pytest.raises((NotMet, SpecError)):
        Verified(**values)
    demanding = Requirements(pm_deg=179)
    good = measure(ARM, P)
    values = {f.name: getattr(good, f.name) for f in fields(Measured)}
    with pytest.raises((NotMet, SpecError)):
        Verified(**values | {"requirements": demanding})


def test_it_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        verify(ARM, P).name = "other"


def test_dict_is_the_contract_form():
    found = verify(ARM, P, law="p", gains={"kp": 4.0}, name="mine").to_dict()
    assert (found["name"], found["law"]) == ("mine", "p")
    assert (found["feasible"], found["reason"]) == (True, None)
    assert found["gains"] == {"kp": 4.0}
    assert found["controller"].items() >= {"num": [4.0], "den": [1.0], "dt": 0.1}.items()
    assert found["margins"]["stable"] is True
    assert {"gain_margin_db", "phase_margin_deg", "crossover", "ms", "mt"} <= set(found["margins"])
    assert {"overshoot_pct", "between_samples", "peak_effort"} <= set(found["step"])
    assert found["met"] is True
    assert found["misses"] == []
    json.dumps(found, allow_nan=False)
    json.dumps(measure(ARM, TOO_LOUD).to_dict(), allow_nan=False)


def test_report_is_text_with_the_numbers():
    found = verify(ARM, P)
    text = found.report()
    assert f"{found.margins.phase_margin_deg:.1f}" in text


def test_same_input_same_result():
    assert measure(ARM, P) == measure(ARM, P)


def test_refuses_a_controller_that_is_not_sampled():
    with pytest.raises(SpecError):
        measure(ARM, Plant(num=[1], den=[1, 1]))


def test_refuses_a_plant_that_is_not_continuous():
    with pytest.raises(SpecError):
        measure(P, P)
