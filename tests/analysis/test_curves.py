"""curves: which points are drawn, and what stands there, worked by hand."""

import numpy as np
import pytest

from zoh.analysis.closed import autonomous, closed_loop
from zoh.analysis.curves import trace, trace_of
from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled

INTEGRATOR = Plant(num=[1], den=[1, 0])
HALF = Sampled(num=[0.5], den=[1], dt=0.5)


# 1/s under P 0.5, dt 0.5: y(k) = 1 - 0.75^k, straight from one sample to the next
def test_the_points_by_hand():
    curve = trace(INTEGRATOR, HALF, t_end=1.5, per_sample=4, reference=-2.0)
    y = -2 * (1 - 0.75 ** np.arange(5))
    assert curve.t.tolist() == [0.0, 0.5, 1.0, 1.5]
    assert curve.y == pytest.approx(y[:4], rel=1e-15)
    assert curve.u == pytest.approx(0.5 * (-2 - y[:4]), rel=1e-15)
    part = np.arange(5) / 4
    assert curve.t_between == pytest.approx(
        np.concatenate([0.5 * (k + part) for k in range(4)]), rel=1e-15
    )
    between = [y[k] + part * (y[k + 1] - y[k]) for k in range(4)]
    assert curve.y_between == pytest.approx(np.concatenate(between), rel=1e-14)


def test_a_feedforward_with_a_state_by_hand():
    # f(k+1) = f/2 + r/4: 0, 1/4, 3/8; u = (r - y)/2 + f: 1/2, 5/8, 19/32; y rises by u/2 a sample
    ahead = Sampled(num=[0.25], den=[1, -0.5], dt=0.5)
    curve = trace(INTEGRATOR, HALF, t_end=1.5, feedforward=ahead)
    assert curve.u[:3].tolist() == [1 / 2, 5 / 8, 19 / 32]
    assert curve.y.tolist() == [0, 1 / 4, 9 / 16, 55 / 64]


def test_a_dead_time_cuts_a_sample_in_two():
    # u(k) acts from (k + 0.3) dt on: two stretches, three steps in each for five points or more
    plant = Plant(num=[1], den=[1, 0], dead_time=0.15)
    curve = trace(plant, HALF, t_end=0.5, per_sample=5)
    times = [0, 0.05, 0.1, 0.15, 0.15, 0.15 + 0.35 / 3, 0.15 + 0.7 / 3, 0.5]
    assert curve.t_between[:8] == pytest.approx(times, rel=1e-14)
    # nothing moves before 0.15 s, then y rises by 0.5 a second
    assert curve.y_between[:8] == pytest.approx(
        [max(0.0, 0.5 * (t - 0.15)) for t in times], rel=1e-13, abs=1e-16
    )


def test_twenty_points_a_sample_and_a_reference_of_one_unless_asked():
    motion = closed_loop(INTEGRATOR, HALF)
    for curve in (trace(INTEGRATOR, HALF, t_end=1.0), trace_of(motion, 1.0)):
        assert len(curve.t_between) == 3 * 21
        assert curve.y[1] == 0.25


def test_the_last_sample_is_the_first_that_is_not_before_the_end():
    for t_end, count in ((1.0, 3), (0.9, 3), (1.1, 4), (1.0 + 1e-13, 3), (0.1, 2)):
        assert len(trace(INTEGRATOR, HALF, t_end=t_end).t) == count
    tenth = Sampled(num=[0.5], den=[1], dt=0.1)
    assert len(trace(INTEGRATOR, tenth, t_end=0.3).t) == 4  # 0.3/0.1 is a little below 3
    assert len(trace(INTEGRATOR, tenth, t_end=0.1 * 3).t) == 4  # and this a little above


def test_one_point_a_sample_is_its_ends():
    curve = trace(INTEGRATOR, HALF, t_end=1.0, per_sample=1)
    assert curve.t_between.tolist() == [0.0, 0.5, 0.5, 1.0, 1.0, 1.5]
    assert curve.y_between == pytest.approx(1 - 0.75 ** np.array([0, 1, 1, 2, 2, 3]), rel=1e-14)


def test_curves_cannot_be_written_to():
    curve = trace(INTEGRATOR, HALF, t_end=1.0)
    for name in ("t", "y", "u", "t_between", "y_between"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(curve, name)[0] = 1.0


def test_what_the_module_gives_out():
    given = {}
    exec("from zoh.analysis.curves import *", given)
    assert {"Trace", "trace", "trace_of"} <= set(given)
    assert isinstance(given["trace"](INTEGRATOR, HALF, t_end=1.0), given["Trace"])


def test_a_system_known_at_its_samples_alone():
    curve = trace_of(autonomous(Sampled(num=[0.5], den=[1, -0.5], dt=0.2)), 0.6)
    y = [0.0, 0.5, 0.75, 0.875]
    assert curve.y == pytest.approx(y, rel=1e-15)
    assert curve.u.tolist() == [0.0] * 4
    assert curve.t_between.tolist() == curve.t.tolist()
    assert curve.y_between.tolist() == curve.y.tolist()


def test_a_compute_delay_and_a_queue_are_drawn():
    curve = trace(INTEGRATOR, HALF, compute_delay=50.0, t_end=51.0, per_sample=1)
    # until the first effort arrives after 100 samples nothing moves, then 0.5 a second
    assert curve.y[:101].tolist() == [0.0] * 101
    assert curve.y[101:] == pytest.approx([0.25, 0.5], rel=1e-14)


REFUSED = [
    ({"t_end": -1}, "t_end must be above 0, got -1: give the last time in seconds"),
    (
        {"per_sample": 0},
        "per_sample must be a whole number of 1 or more, got 0: "
        "give the points between two samples",
    ),
    (
        {"t_end": 5e5},
        "t_end must be at most 1000000 samples (5e+05 s), got 500000.0: draw a shorter time",
    ),
    (
        {"per_sample": 16_666_667},  # of three samples
        "per_sample must give 50000000 points or fewer, 16666666 a sample here, got 16666667: "
        "draw fewer points",
    ),
]


@pytest.mark.parametrize(("wrong", "sentence"), REFUSED)
def test_what_cannot_be_drawn_is_refused(wrong, sentence):
    with pytest.raises(SpecError) as err:
        trace(INTEGRATOR, HALF, **({"t_end": 1.0} | wrong))
    assert str(err.value) == sentence


def test_a_million_samples_are_drawn():
    assert len(trace(INTEGRATOR, HALF, t_end=0.5 * 999_999, per_sample=1).t) == 1_000_000
