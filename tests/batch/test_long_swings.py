"""Loops next to the limit of stability, whose swings live for many thousands of samples."""

from math import ceil, log

import numpy as np
import pytest

import zoh
from zoh.batch import single
from zoh.batch.arrays import modes
from zoh.batch.job import Job

BESIDE = np.array([1e-2, 1e-3, 1e-4, 1e-5])


@pytest.fixture
def compiled():
    pytest.importorskip("numba")
    from zoh.batch.compiled import run

    return run


@pytest.fixture
def swings(compiled, monkeypatch):
    """Return the figures of gains K on 1/s at dt = 1, none of them by the single design.

    y(k) = 1 - (1 - K)^k, from sample to sample a straight line; K = 2 is the limit.
    """
    monkeypatch.setattr(single, "run", None)
    gain = zoh.Sampled(num=[1.0], den=[1.0], dt=1.0)
    plant = zoh.Plant(num=[1], den=[1, 0])
    job = Job(plant=plant, law="given", controller=gain, dt=1.0, varying=("plant.gain",))
    return compiled.run(job, {"plant.gain": 2.0 - BESIDE}, threads=1)


def test_a_swing_settles_when_its_power_says_so(swings):
    by_hand = [ceil(log(50) / -log(abs(1 - (2 - beside)))) for beside in BESIDE]
    assert by_hand[-1] > 390_000
    assert swings["settling_time"].tolist() == by_hand


def test_the_rest_of_its_figures_by_hand(swings):
    # the highest is y(1) = K; |1 + L| is least at z = -1: 1 - K/2
    assert swings["overshoot_pct"] == pytest.approx(100 * (1 - BESIDE), rel=1e-9)
    assert swings["peak_time"].tolist() == [1.0] * 4
    assert swings["peak_effort"] == pytest.approx(np.ones(4), rel=1e-9)
    assert swings["modulus_margin"] == pytest.approx(BESIDE / 2, rel=1e-9)


@pytest.mark.parametrize(
    ("decay", "left"),
    [
        (1.5e-5, False),  # 6.1e5 samples to its rest, seen once though two poles say it
        (8e-6, True),  # 1.2e6
    ],
)
def test_a_pair_is_one_swing(decay, left):
    z = np.exp(np.array([[-decay + 1.0j], [-decay - 1.0j], [-1.0]]))
    assert modes.restless(z).tolist() == [left]
