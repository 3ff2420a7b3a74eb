"""The arithmetic is chosen by one rule, and said."""

import numpy as np
import pytest

import zoh
from zoh.batch import backend, single
from zoh.batch.backend import SINGLE, Way, choose
from zoh.batch.blocks import computed
from zoh.batch.job import Job

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0])
JOB = Job(plant=ARM, law="p", dt=0.1, varying=("wc",))
FAST = Way(name="fast", module=__name__, least=1000, starts="compiled at its first use, some 10 s")
ABSENT = Way(name="absent", module=__name__, needs="no_such_package")


def lacks(job):
    return "" if job.law == "p" else f"the law {job.law}"


def run(job, columns):
    return single.run(job, columns)


@pytest.fixture
def ways(monkeypatch):
    monkeypatch.setattr(backend, "WAYS", (FAST, ABSENT, SINGLE))


@pytest.mark.usefixtures("ways")
def test_a_large_batch_is_worth_a_start():
    choice = choose(JOB, 1000)
    assert choice.way is FAST
    assert choice.why == "computed by fast; compiled at its first use, some 10 s"


@pytest.mark.usefixtures("ways")
def test_what_was_passed_over_is_said():
    choice = choose(JOB, 999)
    assert choice.way is SINGLE
    assert choice.why == (
        "computed by single; fast pays from 1000 loops on; "
        "absent needs no_such_package: pip install 'zoh[fast]' brings it"
    )
    other = Job(plant=ARM, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc",))
    assert "fast has no arithmetic for the law pi" in choose(other, 10**6).why


@pytest.mark.usefixtures("ways")
def test_what_is_asked_for_by_name_is_taken_or_refused():
    assert choose(JOB, 1, "fast").way is FAST
    other = Job(plant=ARM, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc",))
    for job, name in ((JOB, "absent"), (other, "fast"), (JOB, "abacus")):
        with pytest.raises(zoh.SpecError, match="arithmetic"):
            choose(job, 10**6, name)


@pytest.mark.parametrize(
    ("changes", "lacking"),
    [
        ({"plant": zoh.Plant(num=[1, 2], den=[1, 1])}, "a plant that is not strictly proper"),
        ({"plant": zoh.Plant.zpk(zeros=[], poles=[-1] * 7, gain=1)}, "a plant of order 7, above 6"),
        ({"sections": [zoh.notch(w0=9)]}, "sections"),
        ({"law": "leadlag", "asked": {"pm_deg": 50, "dc_gain": 9}}, "the law leadlag"),
        ({"law": "p", "asked": {}}, "a p without pm_deg"),
        ({"asked": {"pm_deg": 40, "setpoint_weight": 0.5}}, "setpoint_weight"),
        ({"law": "given", "asked": {}, "varying": ("plant.gain",),
          "controller": zoh.Sampled(num=[1], den=[1, -0.1, 0, 0, 0.01], dt=0.1)},
         "a controller of order 4, above 3"),
    ],
)  # fmt: skip
def test_an_arithmetic_that_cannot_says_why(changes, lacking):
    job = Job(**{"plant": ARM, "law": "pi", "asked": {"pm_deg": 40}, "dt": 0.1, "varying": ("wc",),
                 **changes})  # fmt: skip
    with pytest.raises(zoh.SpecError) as refused:
        choose(job, 10**6, "arrays")
    assert str(refused.value) == (
        f"arithmetic must be one that has an arithmetic for {lacking}, got 'arrays': "
        "leave it out, or take single"
    )
    assert f"arrays has no arithmetic for {lacking}" in choose(job, 10**6).why
    assert choose(job, 10**6, "single").way is SINGLE


def test_chunks_are_put_together_in_their_order(monkeypatch):
    sizes = []

    def noted(job, columns):
        sizes.append(len(columns["wc"]))
        return single.run(job, columns)

    monkeypatch.setattr(Way, "run", lambda self, job, columns: noted(job, columns))
    columns = {"wc": np.linspace(0.1, 2.0, SINGLE.chunk + 3)}
    found = computed(JOB, columns, "single")
    assert sizes == [SINGLE.chunk, 3]
    whole = single.run(JOB, columns)
    assert all(np.array_equal(found[k], whole[k], equal_nan=k != "stable") for k in whole)
