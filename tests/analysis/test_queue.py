"""queue: a delay of many samples, against the plain recursion."""

from dataclasses import replace

import numpy as np
import pytest

from zoh.analysis import queue
from zoh.analysis.closed import closed_loop
from zoh.lti.systems import Plant, Sampled


def loop(late, gain=2.0**-8):
    """Return an integrator under a P whose input is ``late`` samples under way, dt 1."""
    plant = Plant(num=[1], den=[1, 0], dead_time=float(late))
    return closed_loop(plant, Sampled(num=[gain], den=[1], dt=1.0))


def recursion(late, count, gain=2.0**-8):
    """Return (y, u): y(k+1) = y(k) + u(k - late), u = gain (1 - y)."""
    y, u = [0.0], []
    for k in range(count):
        u.append(gain * (1 - y[k]))
        y.append(y[k] + (u[k - late] if k >= late else 0.0))
    return np.array(y[:count]), np.array(u)


@pytest.mark.parametrize("late", [65, 95, 96, 97, 130])
@pytest.mark.parametrize("count", [1, 31, 64, 65, 500])
def test_the_samples_are_those_of_the_recursion(late, count):
    motion = loop(late)
    assert motion.wait
    states = queue.run(motion, count)
    y, u = recursion(late, count)
    assert states.shape == (len(motion.delta), count)
    assert motion.output @ states == pytest.approx(y, rel=1e-13, abs=1e-15)
    assert motion.effort @ states == pytest.approx(u, rel=1e-13, abs=1e-15)


def test_what_leaves_the_queue_stands_in_its_place():
    late, count = 70, 300
    motion = loop(late)
    left = queue.run(motion, count)[motion.fed]
    u = recursion(late, count)[1]
    assert left[: motion.wait].tolist() == [0.0] * motion.wait
    assert left[motion.wait :] == pytest.approx(u[: count - motion.wait], rel=1e-13)


# of 77 samples four delays, the state's four samples with each, are five blocks of 64 exactly
@pytest.mark.parametrize("late", [66, 70, 77])
def test_it_is_followed_until_it_has_been_quiet_for_four_delays(late):
    gain = 2.0**-8
    motion = loop(late, gain)
    track = queue.track(motion, (1.0, 0.0))
    assert track.rests
    assert track.k.tolist() == list(range(len(track.k)))
    y, u = recursion(late, len(track.k), gain)
    assert motion.output @ track.states == pytest.approx(y, rel=1e-13, abs=1e-15)
    # in parts of the largest: y peaks at its top, u at its first value
    off = np.maximum(np.abs(y - 1) / y.max(), np.abs(u) / u[0])
    block, patience = 64, 4 * (motion.wait + len(motion.delta))
    quiet = off.reshape(-1, block).max(axis=1) <= 1e-10
    needed = -(-patience // block)
    assert not quiet[:-needed].all()
    assert quiet[-needed:].all()
    assert not quiet[-needed - 1]  # and no longer


def test_an_effort_that_grows_is_not_waited_for():
    # under a ramp u comes to 1, y grows: only what has an end is waited for
    motion = loop(70)
    still = queue.track(motion, (1.0, None))
    assert still.rests
    assert len(still.k) <= len(queue.track(motion, (1.0, 0.0)).k)


def test_what_never_rests_is_followed_to_the_limit_and_said(monkeypatch):
    monkeypatch.setattr(queue, "_MOST", 2000)
    track = queue.track(loop(70), (5.0, 0.0))  # it comes to 1, not to 5
    assert not track.rests
    assert 2000 <= len(track.k) < 2000 + 64


def test_rest_is_a_ten_thousandth_and_quiet_a_ten_billionth(monkeypatch):
    motion = loop(77)
    whole = queue.track(motion, (1.0, 0.0))
    y = motion.output @ whole.states
    u = motion.effort @ whole.states
    off = np.maximum(np.abs(y - 1) / y.max(), np.abs(u) / u[0])
    patience = 4 * (motion.wait + len(motion.delta))
    assert patience == 5 * 64
    at_rest = (int(np.nonzero(off > 1e-4)[0][-1]) // 64 + 1) * 64  # from this block on
    for most, rests in ((at_rest + patience, True), (at_rest + patience - 64, False)):
        monkeypatch.setattr(queue, "_MOST", most)
        track = queue.track(motion, (1.0, 0.0))
        assert len(track.k) == most
        assert track.rests is rests


@pytest.mark.parametrize("seen", ["output", "effort"])
def test_each_signal_is_measured_by_its_own_size(seen):
    """An impulse of 1 makes both y and u 1/256 at most; the other one is not looked at here."""
    plant = Plant(num=[1], den=[1, 0], dead_time=70.0)
    motion = closed_loop(plant, Sampled(num=[2.0**-8], den=[1], dt=1.0), by="impulse")
    if seen == "effort":
        motion = replace(motion, output=0 * motion.output)
    track = queue.track(motion, (0.0, 0.0) if seen == "effort" else (0.0, None))
    signal = getattr(motion, seen) @ track.states
    quiet = (np.abs(signal).reshape(-1, 64) <= 1e-10 * np.abs(signal).max()).all(axis=1)
    needed = -(-4 * (motion.wait + len(motion.delta)) // 64)
    assert quiet[-needed:].all()
    assert not quiet[-needed - 1]


def test_how_far_off_is_in_parts_of_the_largest_so_far():
    sizes = [0.0, 0.0]
    signals = np.array([1.0, -3.0]), np.array([4.0, 4.0])
    assert queue._off(signals, (1.0, None), sizes) == 4 / 3
    assert sizes == [3.0, 0.0]
    assert queue._off(signals, (1.0, 2.0), sizes) == 4 / 3
    assert sizes == [3.0, 4.0]
    assert queue._off((np.array([1.0]), np.array([1.0])), (1.0, 2.0), sizes) == 1 / 4
    assert sizes == [3.0, 4.0]
    assert queue._off((np.array([1.0]), np.array([1.0])), (1.0, -8.0), sizes) == 9 / 8
    assert queue._off((np.zeros(2), np.zeros(2)), (0.0, 0.0), [0.0, 0.0]) == 0.0


def test_a_queue_without_efforts_is_refused():
    with pytest.raises(ValueError, match=r"^a queue holds efforts$"):
        queue.run(replace(loop(70), effort=None), 10)
