"""Loops that the compiled arithmetic has side by side, sixteen at once, do not see each other."""

import numpy as np
import pytest
from benchmarks.sweep import equal

import zoh
from zoh.batch import single
from zoh.batch.job import Job
from zoh.batch.reason import Reason

pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")

from zoh.batch.compiled import run as compiled
from zoh.batch.compiled.abreast.room import ABREAST, LOOPS
from zoh.batch.first_use import kernel

SECOND_ORDER = zoh.Plant(num=[1, 1], den=[1, 1, 1])
SPARE = {"pid": "ki", "lag": "dc_gain", "lead": "dc_gain"}


def of_every_kind(law, loops, seed):
    """Return a job and columns: plants of order 2 with and without zero, integrators, swings."""
    rng = np.random.default_rng([seed, len(law)])
    dt = 10 ** rng.uniform(-4, 0.3, loops)
    columns = {
        "plant.num.0": rng.normal(size=loops) * rng.integers(0, 2, loops),
        "plant.num.1": 10 ** rng.uniform(-1, 1, loops) * rng.choice([1, 1, 1, -1, 0], loops),
        "plant.den.1": 10 ** rng.uniform(-1, 1.5, loops) * rng.choice([1, 1, 1, 0, -1], loops),
        "plant.den.2": 10 ** rng.uniform(-2, 2, loops) * rng.choice([0, 0, 1, 1, -1], loops),
        "compute_delay": dt * rng.choice([0, 0, 0, 0, 0.3, 1], loops),
        "dt": dt,
        "wc": np.minimum(10 ** rng.uniform(-1, 1, loops), 3 / dt),
        "pm_deg": rng.uniform(20, 80, loops),
    }
    if law in SPARE:
        columns[SPARE[law]] = 10 ** rng.uniform(-2, 1, loops)
    return Job(plant=SECOND_ORDER, law=law, dt=0.1, varying=tuple(columns)), columns


def usual(law, loops, seed):
    """Return a job and columns: plants of two real poles, with and without a zero, that are met."""
    rng = np.random.default_rng([seed, len(law), 7])
    wc, integrates = 10 ** rng.uniform(-0.3, 0.3, loops), rng.integers(0, 2, loops)
    slow, fast = 10 ** rng.uniform(-1, 0, loops) * (1 - integrates), 10 ** rng.uniform(0, 1, loops)
    at = 1j * wc
    size = np.abs(1 / ((at + slow) * (at + fast)))
    columns = {
        "plant.num.0": rng.integers(0, 2, loops) * 0.1 * rng.uniform(0.2, 1, loops),
        "plant.num.1": 10 ** rng.uniform(-1, 1, loops),
        "plant.den.1": slow + fast, "plant.den.2": slow * fast,
        "dt": 10 ** rng.uniform(-2, -1, loops) / wc, "wc": wc,
    }  # fmt: skip
    behind = np.degrees(np.angle(1 / ((at + slow) * (at + fast)))) - np.degrees(
        wc * columns["dt"] / 2
    )
    turn = {"pi": -20, "lag": -20, "pd": 25, "lead": 25, "pid": 5}[law]
    columns["pm_deg"] = 180 + behind + turn
    gain = columns["plant.num.1"] * size
    if law == "pid":
        columns["ki"] = 0.05 * wc / gain
    elif law in SPARE:
        columns["dc_gain"] = (5 if law == "lag" else 0.3) / gain
    return Job(plant=SECOND_ORDER, law=law, dt=0.1, varying=tuple(columns)), columns


def rows(found):
    return np.stack([np.asarray(found[name], float) for name in sorted(found)], axis=1)


def mixed(law, loops, seed):
    """Return loops of every kind and usual ones in turns."""
    job, odd = of_every_kind(law, loops, seed)
    _, even = usual(law, loops, seed)
    even["compute_delay"] = np.zeros(loops)
    odd_one = np.arange(loops) % 2 == 1
    return job, {key: np.where(odd_one, odd[key], even[key]) for key in odd}


@pytest.mark.parametrize(
    ("law", "least"), [("pi", 14), ("pd", 12), ("pid", 4), ("lag", 14), ("lead", 4)]
)
def test_usual_loops_are_measured_in_their_lanes(law, least):
    # a slow pole beside a zero, or gain at rest, may give |T| two peaks, which are looked for alone
    job, columns = usual(law, LOOPS, 3)
    floats, room = compiled._work(job), compiled._rows(LOOPS)
    found, left = compiled._some(kernel(), floats, room, job, columns, LOOPS)
    lanes = ABREAST.of(floats)
    assert not left.any()
    there = set(lanes.loop[(lanes.fine > 0) & (lanes.loop >= 0)].tolist())
    assert len(there) >= least
    assert there <= set(np.flatnonzero(found["reason"] == Reason.OK).tolist())


@pytest.mark.parametrize("law", ["pi", "pd", "pid", "lag", "lead"])
def test_a_loop_has_the_same_bits_whatever_is_beside_it(law):
    job, columns = mixed(law, 11 * LOOPS + 5, 1)
    whole = rows(compiled.run(job, columns, threads=1))
    turned = {key: values[::-1] for key, values in columns.items()}
    assert rows(compiled.run(job, turned, threads=1))[::-1].tobytes() == whole.tobytes()
    for first, last in [(0, 1), (3, 4), (7, 7 + LOOPS - 1), (20, 21 + LOOPS), (5, 3 * LOOPS)]:
        some = {key: values[first:last] for key, values in columns.items()}
        assert rows(compiled.run(job, some, threads=1)).tobytes() == whole[first:last].tobytes()


@pytest.mark.parametrize("law", ["pi", "pd", "pid", "lag", "lead"])
def test_what_is_unusual_among_the_usual_ones_is_as_the_single_design_says(law):
    job, columns = mixed(law, 9 * LOOPS + 1, 2)
    truth = single.run(job, columns)
    met = {Reason(code) for code in truth["reason"].tolist()}
    assert {Reason.OK, Reason.INFEASIBLE} <= met
    found = compiled.run(job, columns, threads=1)
    assert list(equal.differences(found, truth, columns["dt"])) == []


def test_a_sample_of_many_turns_of_the_plant():
    # |A| dt of 4 to 60: the unit in which the exponential's series is short is 1/8 to 1/128 sample
    loops = 3 * LOOPS
    fast = np.geomspace(2.0, 30.0, loops)
    columns = {
        "plant.den.1": fast, "plant.den.2": fast * 0.4, "plant.num.1": fast * 0.4,
        "plant.num.0": np.zeros(loops), "wc": np.full(loops, 0.3), "pm_deg": np.full(loops, 60.0),
    }  # fmt: skip
    job = Job(plant=SECOND_ORDER, law="pi", dt=1.0, varying=tuple(columns))
    truth = single.run(job, columns)
    assert (truth["reason"] == Reason.OK).sum() > loops // 2
    found = compiled.run(job, columns, threads=1)
    assert list(equal.differences(found, truth, 0.0)) == []
