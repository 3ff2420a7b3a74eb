"""A batch by the single design is the single design: figures, refusals and their reasons."""

from math import isnan, nan

import numpy as np
import pytest

import zoh
from zoh.batch import single
from zoh.batch.columns import column, length
from zoh.batch.figures import BY_NAME, column_names
from zoh.batch.job import Job
from zoh.batch.reason import Reason
from zoh.batch.sources import Geared, Roots, coefficients, nominal, plant_of
from zoh.lti.joint import Joint

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
PI = Job(plant=ARM, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc",))


def reasons(job, **columns):
    found = single.run(job, {k: np.array(v, float) for k, v in columns.items()})
    return [Reason(code).name for code in found["reason"]]


@pytest.mark.parametrize(
    ("law", "asked"),
    [
        ("p", {"pm_deg": 50}),
        ("pi", {"wc": 0.8, "pm_deg": 40}),
        ("pd", {"wc": 2.0, "pm_deg": 60}),
        ("pid", {"wc": 1.95, "pm_deg": 40, "ki": 0.85}),
        ("lag", {"wc": 0.6, "pm_deg": 40, "dc_gain": 10}),
        ("lead", {"wc": 2.5, "pm_deg": 40, "dc_gain": 10}),
        ("leadlag", {"wc": 1.95, "pm_deg": 40, "dc_gain": 100}),
    ],
)
def test_every_law_has_the_figures_of_its_design(law, asked):
    job = Job(plant=ARM, law=law, asked=asked, dt=0.1, reference=3.0, varying=("plant.gain",))
    found = single.run(job, {"plant.gain": np.array([2.3, 2.0])})
    assert tuple(found) == column_names(law)
    for i, gain in enumerate((2.3, 2.0)):
        plant = zoh.Plant(num=[gain], den=[1, 0.7809, 0], sensor=12 / 180)
        d = zoh.design(plant, law, asked, dt=0.1, reference=3.0)
        said = d.to_dict()
        for name in BY_NAME:
            place = said["step"] if name in said["step"] else said["margins"]
            part, _, rest = name.rpartition(".")
            value = said["step"]["between_samples"][rest] if part else place[name]
            value = {None: nan, "inf": np.inf}.get(value, value)
            assert found[name][i] == value or (isnan(value) and isnan(found[name][i])), name
        assert {k: found[f"gains.{k}"][i] for k in d.gains} == dict(d.gains)
    assert found["stable"].all()
    assert not found["reason"].any()


def test_each_way_to_have_no_figures_has_its_reason():
    assert reasons(PI, wc=[0.8, 3.0, 31.5, -1.0]) == [
        "OK", "INFEASIBLE", "BEYOND_NYQUIST", "MALFORMED",
    ]  # fmt: skip
    stiff = zoh.Plant(num=[1], den=[1, 1])
    given = Job(
        plant=stiff, law="given", controller=zoh.Sampled(num=[2.0], den=[1.0], dt=0.1), dt=0.1,
        varying=("plant.gain",),
    )  # fmt: skip
    # a hold of 1/(s + 1) has its pole at p = exp(-0.1): with k it is at p - k (1 - p), inside
    # the circle up to k = (1 + p)/(1 - p) = 20.02
    assert reasons(given, **{"plant.gain": [1.0, 10.0, 10.1]}) == ["OK", "OK", "UNSTABLE"]
    found = single.run(given, {"plant.gain": np.array([10.1])})
    assert not found["stable"][0]
    assert all(np.isnan(found[name][0]) for name in BY_NAME)


def test_a_margin_at_another_crossover_is_off_target_and_has_figures():
    # a resonance at 10 rad/s that the loop crosses again, with 0.3 s behind it a stable loop
    ringing = zoh.Plant(num=[100.0], den=[1, 0.05, 100, 0], dead_time=0.3)
    job = Job(plant=ringing, law="pd", asked={"pm_deg": 80}, dt=0.01, varying=("wc",))
    found = single.run(job, {"wc": np.array([0.6])})
    assert found["reason"].tolist() == [Reason.OFF_TARGET]
    assert found["stable"][0]
    with pytest.raises(zoh.NotMet, match="another crossover") as missed:
        zoh.pd(ringing, dt=0.01, wc=0.6, pm_deg=80)
    seen = missed.value.measured
    assert found["phase_margin_deg"][0] == seen.margins.phase_margin_deg < 80
    assert found["gains.kp"][0] == seen.gains["kp"]


def test_a_loop_without_a_reason_has_every_figure_it_says():
    found = single.run(PI, {"wc": np.linspace(0.1, 5, 25)})
    ok = found["reason"] == Reason.OK
    assert ok.any()
    assert not ok.all()
    for name in ("phase_margin_deg", "crossover", "ms", "mt", "overshoot_pct", "peak_effort"):
        assert np.isfinite(found[name][ok]).all()
        assert np.isnan(found[name][~ok]).all()


def test_numbers_are_replaced_where_they_stand():
    roots = Roots(zeros=[], poles=[0, -0.7809], gain=2.3, sensor=12 / 180)
    motor = Geared(joint=Joint(torque_constant=0.5, resistance=2.0, motor_inertia=0.25))
    for job, key, plant in (
        (Job(plant=roots, law="pi", asked={"pm_deg": 40, "wc": 0.4}, dt=0.1,
             varying=("plant.pole.1",)),
         -0.5, zoh.Plant.zpk(zeros=[], poles=[0, -0.5], gain=2.3, sensor=12 / 180)),
        (Job(plant=motor, law="pd", asked={"pm_deg": 60, "wc": 2.0}, dt=0.1,
             varying=("plant.joint.load_inertia",)),
         0.5, zoh.Plant(num=[0.5], den=[2.0 * 0.75, 0.25, 0])),
    ):  # fmt: skip
        found = single.run(job, {job.varying[0]: np.array([key])})
        d = zoh.design(plant, job.law, job.asked, dt=0.1)
        assert found["ms"][0] == pytest.approx(d.margins.ms, rel=1e-12)


def test_what_does_not_vary_stands_in_every_loop():
    columns = {"wc": np.array([0.8, 0.9])}
    assert length(PI, columns) == 2
    assert column(PI, columns, "plant.den.1", 2).tolist() == [0.7809, 0.7809]
    assert column(PI, columns, "wc", 2) is columns["wc"]


def test_a_malformed_batch_is_refused_in_one_line():
    for columns in ({}, {"dt": np.ones(2)}, {"wc": np.array([np.nan])}, {"wc": np.ones((2, 2))}):
        with pytest.raises(zoh.SpecError, match="columns"):
            single.run(PI, columns)


@pytest.mark.parametrize(
    ("changes", "argument"),
    [
        ({"varying": ("wx",)}, "over"),
        ({"varying": ("wc", "wc")}, "over"),
        ({"varying": ("ki",)}, "over"),
        ({"asked": {"wc": 1.0}, "varying": ()}, "pm_deg"),
        ({"law": "auto"}, "law"),
        ({"law": "given"}, "controller"),
        ({"asked": {"pm_deg": 40, "gain": 1}}, "gain"),
        ({"reference": 0}, "reference"),
        ({"dt": 0}, "dt"),
        ({"plant": "1/s"}, "plant"),
    ],
)
def test_a_job_that_is_no_loop_is_refused(changes, argument):
    given = {"plant": ARM, "law": "pi", "asked": {"pm_deg": 40}, "dt": 0.1, "varying": ("wc",)}
    with pytest.raises(zoh.SpecError) as refused:
        Job(**{**given, **changes})
    assert refused.value.argument == argument


SOURCES = [
    (zoh.Plant(num=[2.0, 3.0], den=[1.5, 0.7809, 0.2, 0]),
     {"plant.num.1": 3.3, "plant.den.0": 1.25, "plant.den.2": 0.1}),
    (zoh.Plant(num=[2.0, 3.0], den=[1.5, 0.7809, 0]), {"plant.gain": 0.7}),
    (zoh.Plant(num=[2.3], den=[1.0, 0.7809, 0]), {"plant.gain": 2.5, "plant.den.1": 0.6}),
    (Roots(zeros=[-3.0], poles=[0, -0.7, -2 + 3j, -2 - 3j], gain=2.3),
     {"plant.zero.0": -2.5, "plant.pole.1": -0.9, "plant.gain": 2.0}),
    (Geared(joint=Joint(torque_constant=0.5, resistance=2.0, motor_inertia=0.25, gear_ratio=3.0,
                        load_damping=0.1, output="deg/s")),
     {"plant.joint.torque_constant": 0.6, "plant.joint.load_inertia": 0.5}),
    (Geared(joint=Joint(torque_constant=0.5, resistance=2.0, motor_inertia=0.25, inductance=0.01,
                        back_emf=0.4)),
     {"plant.joint.torque_constant": 0.6, "plant.joint.gear_ratio": 5.0}),
]  # fmt: skip


@pytest.mark.parametrize(("source", "changes"), SOURCES)
def test_coefficients_of_a_batch_are_those_of_each_plant(source, changes):
    standing = {key: nominal(source)[key] for key in changes}
    columns = {key: np.array([changes[key], standing[key]]) for key in changes}
    num, den = coefficients(source, columns, 2)
    for i, values in enumerate((changes, standing)):
        plant = plant_of(source, values, source.dead_time)
        # a few roundings of products of floats; no differences of large numbers among them
        for found, exact in ((num, plant.num), (den, plant.den)):
            assert found[:, i] == pytest.approx(exact, rel=2e-15, abs=1e-15)


def test_numbers_that_stand_keep_all_their_digits():
    third = zoh.Plant.parse("1/3/(s^2 + 0.7809 s)")
    varied = plant_of(third, {"plant.den.1": 0.5}, 0.1)
    assert varied.exact[0] == third.exact[0]
    assert (varied.den, varied.dead_time) == ((1.0, 0.5, 0.0), 0.1)
    assert plant_of(third, {}, 0.0).exact == third.exact


def test_a_complex_root_is_no_single_number():
    ringing = Roots(zeros=[], poles=[-1 + 2j, -1 - 2j, -3], gain=1.0)
    assert sorted(nominal(ringing)) == ["plant.gain", "plant.pole.2"]
