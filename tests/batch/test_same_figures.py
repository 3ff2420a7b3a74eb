"""Arrays and the compiled arithmetic say what the single design says, loop by loop.

The single design measures by other code, in exact arithmetic where it counts; its figures are
held to 50 digits by its own tests.
"""

import numpy as np
import pytest

import zoh
from zoh.batch import single
from zoh.batch.arrays import run as arrays
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
    model = PLANTS[plant]
    fastest = np.abs(model.poles()).max()
    dt = 10 ** rng.uniform(-4, 0, loops) / max(fastest, 0.5)
    wc = np.minimum(10 ** rng.uniform(-1.3, 0.6, loops) * max(fastest, 0.5), 3.3 / dt)
    gain = np.abs(model.at(wc))
    columns = {"dt": dt, "compute_delay": late * dt}
    if law == "given":
        controller = zoh.Sampled(num=[1.2 / gain[0], -1.05 / gain[0]], den=[1, -0.7], dt=0.1)
        columns["plant.gain"] = model.num[0] / model.den[0] * 10 ** rng.uniform(-1, 1, loops)
        job = Job(
            plant=model, law=law, controller=controller, dt=0.1, reference=-2.0,
            varying=tuple(columns),
        )  # fmt: skip
        return job, columns
    columns |= {"wc": wc, "pm_deg": rng.uniform(15, 85, loops)}
    if law == "pid":
        columns["ki"] = wc / gain * 10 ** rng.uniform(-3, -0.5, loops)
    elif law in ("lag", "lead"):
        low, high = (0.02, 1.5) if law == "lag" else (-1.5, -0.02)
        columns["dc_gain"] = 10 ** rng.uniform(low, high, loops) / gain
    return Job(plant=model, law=law, dt=0.1, reference=-2.0, varying=tuple(columns)), columns


def assert_same(found, truth, columns):
    assert [Reason(r).name for r in found["reason"]] == [Reason(r).name for r in truth["reason"]]
    assert found["stable"].tolist() == truth["stable"].tolist()
    for name in set(truth) - {"stable", "reason"}:
        x, y = found[name], truth[name]
        assert np.isnan(x).tolist() == np.isnan(y).tolist(), name
        tolerance = 1e-9 * np.abs(y)
        if name.endswith("overshoot_pct"):
            tolerance += 1e-10  # % of the final value: a few hundred roundings of it
        elif name == "steady_state_error":
            tolerance += 1e-12  # of the reference: it is the difference of two numbers near 1
        elif name.endswith("peak_time"):
            # a crest is flat: an error of 1e-13 of it moves its time by sqrt(2e-13)/wn, and
            # wn is about the crossover
            tolerance += 5e-7 / truth["crossover"] + 1e-9 * np.abs(y)
        same = (x == y) | (np.isnan(x) & np.isnan(y))
        with np.errstate(invalid="ignore"):  # inf - inf, where they are the same
            off = np.where(same, 0.0, np.abs(x - y) - tolerance)
        i = int(np.nanargmax(off)) if len(off) else 0
        assert not off[i] > 0, (name, x[i], y[i], {k: float(v[i]) for k, v in columns.items()})


@pytest.mark.parametrize(("plant", "law", "late"), CASES)
def test_arrays(plant, law, late):
    job, columns = spread(plant, law, late)
    assert arrays.covers(job)
    assert_same(arrays.run(job, columns), single.run(job, columns), columns)


@pytest.mark.parametrize(("plant", "law", "late"), CASES)
def test_compiled(plant, law, late):
    pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")
    from zoh.batch.compiled import run as compiled

    job, columns = spread(plant, law, late, 4 * LOOPS)
    assert_same(compiled.run(job, columns, threads=2), arrays.run(job, columns), columns)


def test_a_plant_that_answers_at_once_is_not_covered():
    through = zoh.Plant(num=[0.5, 1, 2], den=[1, 3, 2])
    asked = {"wc": 0.5, "pm_deg": 60}
    assert not arrays.covers(Job(plant=through, law="pi", asked=asked, dt=0.1, varying=("dt",)))


def test_most_loops_are_not_left_to_the_single_design():
    """What is left costs a thousand times as much."""
    left = 0
    for plant, law, late in CASES:
        job, columns = spread(plant, law, late)
        regular = arrays.batch(job, columns, LOOPS).regular
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
