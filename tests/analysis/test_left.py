"""What is left of a motion, by hand; and settling times of what is followed to no rest.

The truth of 1/(s^2 + b s + 1) has fifty digits: its distance from 1 is
exp(-b t/2) (cos w t + b/(2 w) sin w t), with crests of exp(-b t/2) at every half turn.
"""

from dataclasses import replace
from math import cos, inf, sin, sqrt

import numpy as np
import pytest
from mpmath import mp, mpf

from zoh import Plant, Sampled, response, step_info
from zoh.analysis.motion import Motion, Stretch


def driven(own, drive, output, stretches=(), more=0.0):
    """Return a motion of states moved by ``own``, and by a one whose share is ``drive``."""
    n = len(own)
    delta = np.zeros((n + 1, n + 1))
    delta[:n, :n], delta[:n, n], delta[n, n] = own, drive, more
    start = np.array([0.0] * n + [1.0])
    return Motion(
        dt=1.0, delta=delta, start=start, own=n, output=np.array(output), effort=None,
        stretches=stretches,
    )  # fmt: skip


def test_a_lag_is_as_far_from_its_rest_as_it_is():
    lag = driven([[-0.5]], [0.5], [3.0, 1.0])  # 3 (1 - 2^-k) + 1, from 1 to 4
    assert lag.farthest(lag.start) == pytest.approx(3.0, rel=1e-14)
    assert lag.farthest(np.array([0.875, 1.0])) == pytest.approx(0.375, rel=1e-14)
    assert lag.farthest(np.array([1.125, 1.0])) == pytest.approx(0.375, rel=1e-14)


def test_lags_add_up_whatever_their_signs():
    # 2 and -3 away from rest: at least 1 now, and 3 at most when the first is gone
    two = driven([[-0.5, 0.0], [0.0, -0.25]], [0.0, 0.0], [1.0, 1.0, 0.0])
    assert two.farthest(np.array([2.0, -3.0, 1.0])) == pytest.approx(5.0, rel=1e-14)


def test_a_swing_reaches_its_envelope():
    # the state turns by 0.7 and shrinks by 0.9: its first entry is at most its length
    x, y = 0.9 * cos(0.7), 0.9 * sin(0.7)
    swing = driven([[x - 1, -y], [y, x - 1]], [0.0, 0.0], [1.0, 0.0, 0.0])
    assert swing.farthest(np.array([3.0, 4.0, 1.0])) == pytest.approx(5.0, rel=1e-13)


def test_between_the_samples_it_may_be_farther():
    # 8 t (1 - t) times what is left: Bernstein's coefficients 0, 4, 0
    rows = np.array([[0.0, 0.0], [8.0, 0.0], [-8.0, 0.0]])
    humps = driven([[-0.5]], [0.0], [1.0, 0.0], [Stretch(begin=0.0, span=1.0, rows=rows)])
    assert humps.farthest(np.array([-0.25, 1.0])) == pytest.approx(1.0, rel=1e-14)


def test_of_some_motions_nothing_is_known():
    lag = driven([[-0.5]], [0.5], [1.0, 0.0])
    assert lag.farthest(lag.start) == 1.0
    assert replace(lag, wait=70).farthest(lag.start) == inf
    assert driven([[-0.5]], [0.5], [1.0, 0.0], more=-0.5).farthest(lag.start) == inf
    assert driven([[0.5]], [0.5], [1.0, 0.0]).farthest(lag.start) == inf
    assert driven([[-2.0]], [0.5], [1.0, 0.0]).farthest(lag.start) == inf  # 1, -1, 1, ...
    twice = driven([[-0.5, 1.0], [0.0, -0.5]], [0.0, 0.0], [1.0, 0.0, 0.0])
    assert twice.farthest(np.array([1.0, 1.0, 1.0])) == inf  # k 2^-k has no eigenvector


def last_crossing(b, band):
    """Return the last instant in s at which 1/(s^2 + b s + 1) is as far as ``band`` from 1."""
    with mp.workdps(50):
        decay = mpf(b) / 2
        w = mp.sqrt(1 - decay**2)

        def off(t):
            return mp.exp(-decay * t) * (mp.cos(w * t) + decay / w * mp.sin(w * t))

        half = mp.pi / w
        last = int(mp.floor(-mp.log(band) / (decay * half)))  # the last crest outside
        assert abs(off(last * half)) > band > abs(off((last + 1) * half))
        ends = last * half, (last + mpf(1) / 2) * half
        return float(mp.findroot(lambda t: abs(off(t)) - band, ends, solver="anderson", tol=1e-60))


@pytest.mark.parametrize("b", [1e-4, 1.6e-5, 1e-5])
def test_a_swing_settles_where_its_envelope_enters_the_band(b):
    got = step_info(Plant(num=[1], den=[1, b, 1]))
    assert got.settling_time == pytest.approx(last_crossing(b, mpf(1) / 50), rel=1e-9)
    assert got.settling_time < got.horizon


def test_what_is_left_in_the_outer_tenth_of_the_band_may_leave_it():
    # exp(-4e-6 * 999999) = 0.0183 of 0.02
    got = step_info(Plant(num=[1], den=[1, 8e-6, 1]))
    assert got.settling_time is None
    assert got.settling == f"not at rest by {got.horizon:.4g} s"


def test_what_a_disturbance_leaves_settles_by_the_same_bound():
    # next to no controller, so the plant's own step; the band is 2 % of the peak. The controller
    # takes some 1e-12 of the damping's 1.6e-5, which is 0.04 s of all that time
    b = 1.6e-5
    plant, law = Plant(num=[1], den=[1, b, 1]), Sampled(num=[1e-12], den=[1], dt=1.0)
    got = response(plant, law, by="disturbance")
    peak = 1 + mp.exp(-mpf(b) / 2 * mp.pi / sqrt(1 - b * b / 4))
    assert got.settling_time == pytest.approx(last_crossing(b, peak / 50), abs=0.05)
