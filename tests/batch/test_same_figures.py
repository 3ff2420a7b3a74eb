"""Arrays and the compiled arithmetic say what the single design says, loop by loop.

The single design measures by other code, in exact arithmetic where it counts; its figures are
held to 50 digits by its own tests.
"""

from dataclasses import fields

import numpy as np
import pytest
from benchmarks.sweep import equal

import zoh
from zoh.batch import single
from zoh.batch.arrays import run as arrays
from zoh.batch.arrays.asked import batch
from zoh.batch.blocks import computed
from zoh.batch.job import Job
from zoh.batch.reason import Reason

LOOPS = 24
PLANTS = {
    "arm": zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180),
    "first order": zoh.Plant(num=[3], den=[1, 2]),
    "integrator": zoh.Plant(num=[2], den=[1, 0]),
    "swinging": zoh.Plant(num=[0.2, 4], den=[1, 0.8, 4]),
    "swinging, integrating": zoh.Plant(num=[4], den=[1, 0.8, 4, 0]),
    "order 5, a zero": zoh.Plant(num=[1, 30], den=np.poly([0, -0.5, -2, -3, -8]).tolist()),
    "unstable": zoh.Plant(num=[1], den=[1, 1, -2]),
}
CASES = [
    (plant, law, late)
    for i, plant in enumerate(PLANTS)
    for j, law in enumerate(("pi", "pid", "pd", "lag", "lead", "given"))
    for late in ((0.0, 0.3, 0.5, 1.0, 1.5, 2.7)[(i + j) % 6],)
]


def spread(plant, law, late, loops=LOOPS):
    """Return a job and columns: dt over four decades, crossovers over two, any margin."""
    rng = np.random.default_rng([list(PLANTS).index(plant), len(law), round(10 * late)])
    return equal.spread(PLANTS[plant], law, late, loops, rng)


def assert_same(found, truth, columns):
    told = [
        (line, {k: float(v[int(line.split(" of ")[1].split(":")[0])]) for k, v in columns.items()})
        for line in equal.differences(found, truth, columns.get("dt", 0.0))
    ]
    assert told == []


@pytest.mark.parametrize(("plant", "law", "late"), CASES)
def test_arrays(plant, law, late):
    job, columns = spread(plant, law, late)
    assert not arrays.lacks(job)
    assert_same(arrays.run(job, columns), single.run(job, columns), columns)


@pytest.mark.parametrize(("plant", "law", "late"), CASES)
def test_compiled(plant, law, late):
    pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")
    from zoh.batch.compiled import run as compiled

    job, columns = spread(plant, law, late, 4 * LOOPS)
    assert_same(compiled.run(job, columns, threads=2), arrays.run(job, columns), columns)


@pytest.mark.parametrize("seed", [23, 55])
def test_a_controller_that_places_poles_and_a_plant_that_turns_twice_in_a_sample(seed):
    job, columns, _ = equal.placed(LOOPS, np.random.default_rng([seed, 5]))
    truth = single.run(job, columns)
    assert (truth["reason"] == Reason.OK).sum() > LOOPS // 2
    assert_same(arrays.run(job, columns), truth, columns)
    pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")
    from zoh.batch.compiled import run as compiled

    assert_same(compiled.run(job, columns, threads=1), truth, columns)


@pytest.mark.parametrize("seed", [26, 41, 48, 57])
def test_two_crests_that_are_nearly_as_high_and_one_that_leaves_the_band(seed):
    """A long stride shows the lower of two, and steps over one that ends the settling."""
    pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")
    counts, _, told = equal.family(seed)
    assert counts["OK"] > 5
    assert told == []


def test_a_plant_that_answers_at_once_is_not_covered():
    through = zoh.Plant(num=[0.5, 1, 2], den=[1, 3, 2])
    asked = {"wc": 0.5, "pm_deg": 60}
    assert arrays.lacks(Job(plant=through, law="pi", asked=asked, dt=0.1, varying=("dt",)))


def given(zeros, poles):
    """Return a job with a controller of these zeros and poles."""
    num, den = (np.atleast_1d(np.poly(roots)).real.tolist() for roots in (zeros, poles))
    controller = zoh.Sampled(num=num, den=den, dt=0.1)
    return Job(plant=PLANTS["arm"], law="given", controller=controller, dt=0.1, varying=("dt",))


@pytest.mark.parametrize(
    ("zeros", "poles", "falls"),
    [
        ([0.99], [0.2], False),  # by 1.25 % to z = 1
        ([0.99, 0.99], [0.2, 0.2], False),  # 1.6e-4
        ([0.999, 0.999], [0.2, 0.2], True),  # 1.6e-6
        ([0.999, 0.999, 0.999], [0.2, 0.2, 1.0], True),  # far below the leads' corner it rises
        ([np.exp(0.1j), np.exp(-0.1j)], [0.9, 0.9], False),  # a notch
        ([-1.0], [0.2], False),  # a mean of two samples is 0 at Nyquist's frequency alone
        ([0.5], [1.0], False),
    ],
)
def test_a_row_of_leads_takes_back_most_of_what_it_gives(zeros, poles, falls):
    assert bool(arrays.lacks(given(zeros, poles))) is falls


def test_three_leads_on_four_lags_are_left_to_the_single_design():
    # by the chains of the fast arithmetics the overshoot was off by 1e-7 of itself
    lag, lead = np.poly([-0.04] * 4), np.poly([0.9999] * 3)
    plant = zoh.Plant(num=[1.0], den=lag.tolist())
    controller = zoh.Sampled(num=lead.tolist(), den=np.poly([0.6] * 3).tolist(), dt=0.02)
    over = {"plant.gain": np.linspace(2e3, 5e3, 20).tolist()}
    found = zoh.sweep(plant, "given", controller=controller, over=over)
    assert "takes back most of its direct gain" in found.computed_by


def test_most_loops_are_not_left_to_the_single_design():
    """What is left costs a thousand times as much."""
    left = 0
    for plant, law, late in CASES:
        job, columns = spread(plant, law, late)
        regular = batch(job, columns, LOOPS).regular
        left += int((arrays.some(job, columns, LOOPS)[1] & regular).sum())
    assert left < 0.1 * LOOPS * len(CASES)


def test_what_is_out_of_range_is_malformed_and_the_rest_is_not_disturbed():
    arm = PLANTS["arm"]
    job = Job(plant=arm, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc", "dt"))
    wc, dt = np.array([0.8, -1.0, 0.8, 40.0]), np.array([0.1, 0.1, 0.0, 0.1])
    found = arrays.run(job, {"wc": wc, "dt": dt})
    names = [Reason(r).name for r in found["reason"]]
    assert names == ["OK", "MALFORMED", "MALFORMED", "BEYOND_NYQUIST"]
    assert found["phase_margin_deg"][0] == pytest.approx(40, abs=1e-9)


SERVO = zoh.Joint(
    torque_constant=0.0302, resistance=0.299, motor_inertia=1.42e-5, load_inertia=1e-3,
    motor_damping=1e-6, load_damping=1e-4, gear_ratio=26.0, inductance=1e-4, back_emf=0.0302,
    output="rad/s",
)  # fmt: skip
BEYOND = [(f.name, -1e-3) for f in fields(zoh.Joint) if f.name != "output"] + [
    (name, 0.0) for name in ("torque_constant", "resistance", "gear_ratio")
]


@pytest.mark.parametrize("way", ["single", "arrays", "compiled"])
def test_a_motor_that_cannot_be_is_malformed(way):
    """Its bounds are those that ``Joint`` tells its users, each here with a number beyond it."""
    if way == "compiled":
        pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")
    standing = {f.name: getattr(SERVO, f.name) for f in fields(zoh.Joint) if f.name != "output"}
    rows = [{}, {"load_damping": 0.0}, {"motor_inertia": 0.0}, *({n: x} for n, x in BEYOND)]
    rows.append({"motor_inertia": 0.0, "load_inertia": 0.0})
    columns = {
        f"plant.joint.{name}": np.array([row.get(name, x) for row in rows])
        for name, x in standing.items()
    }
    job = Job(
        plant=zoh.Geared(joint=SERVO), law="given", dt=1e-3, varying=tuple(columns),
        controller=zoh.Sampled(num=[1.0], den=[1], dt=1e-3),
    )  # fmt: skip
    names = [Reason(code).name for code in computed(job, columns, way)["reason"]]
    assert names == ["OK"] * 3 + ["MALFORMED"] * (len(BEYOND) + 1)


FAR = [5e-324, 1e-200, 1e-60, 1e-25, 1e-12, 1e12, 1e25, 1e60, 1e200, 1.7e308, 0.0, -1.0, -1e200]
ABSURD = {
    "pi": ({"wc": 0.5, "pm_deg": 40}, None),
    "pd": ({"wc": 1.5, "pm_deg": 50, "filter_pole": 30}, None),
    "pid": ({"wc": 1.5, "pm_deg": 50, "ki": 0.5}, None),
    "lag": ({"wc": 0.5, "pm_deg": 40, "dc_gain": 10}, None),
    "given": ({}, zoh.Sampled(num=[3.0, -2.9], den=[1, -0.9], dt=0.1)),
}


@pytest.mark.parametrize("law", ABSURD)
@pytest.mark.parametrize("way", ["arrays", "compiled"])
def test_of_absurd_numbers_all_say_the_same(way, law):
    """A power of them is no float any more; what says so is one and the same verdict."""
    if way == "compiled":
        pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")
    asked, controller = ABSURD[law]
    ordinary = {"dt": 0.1, "compute_delay": 0.0, "plant.gain": 2.3, "plant.den.0": 1.0,
                "plant.den.1": 0.7809, **asked}  # fmt: skip
    # a margin of next to nothing swings for a million samples, which is the single design's to say
    rows = [(key, far) for key in ordinary for far in FAR if key != "pm_deg" or far in (-1.0, 1e12)]
    columns = {key: np.full(len(rows), value, float) for key, value in ordinary.items()}
    for i, (key, far) in enumerate(rows):
        columns[key][i] = far
    job = Job(
        plant=PLANTS["arm"], law=law, asked=asked, controller=controller, varying=tuple(columns)
    )
    found, truth = computed(job, columns, way), single.run(job, columns)
    assert_same(found, truth, columns)
    reasons = {Reason(code).name for code in truth["reason"]}
    assert {"OK", "MALFORMED"} <= reasons
    with_figures = np.array([Reason(code).has_figures for code in found["reason"]])
    assert np.array_equal(~np.isnan(found["ms"]), with_figures)


def test_threads_and_chunks_change_no_bit():
    pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")
    from zoh.batch.compiled import run as compiled

    rng, n = np.random.default_rng(8), 5000
    columns = {
        "dt": 10 ** rng.uniform(-3, -0.5, n), "wc": 10 ** rng.uniform(-1, 1, n),
        "pm_deg": rng.uniform(20, 80, n), "ki": 10 ** rng.uniform(-2, 1, n),
    }  # fmt: skip
    plant = zoh.Plant(num=[1], den=[1, 0.8, 0])
    job = Job(plant=plant, law="pid", dt=0.1, varying=tuple(columns))
    one = compiled.run(job, columns, threads=1)
    parts = [{k: v[i : i + 700] for k, v in columns.items()} for i in range(0, n, 700)]
    alone = [compiled.run(job, part, threads=1) for part in parts]
    assert len({int(code) for code in one["reason"]}) > 2
    for threads in (2, 4):
        both = compiled.run(job, columns, threads=threads)
        for name, values in one.items():
            np.testing.assert_array_equal(both[name], values)
            np.testing.assert_array_equal(np.concatenate([a[name] for a in alone]), values)
