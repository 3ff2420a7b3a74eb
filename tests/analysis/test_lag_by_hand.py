"""closed, motion, between, waveform, step, responses: small loops with known answers.

The truth comes from ``lag_by_hand``. Times are multiples of 1/64 s, so that they are exact.
"""

from math import inf

import numpy as np
import pytest
from lag_by_hand import COUNT, loop

import zoh
from zoh.analysis.step import closed_loop_step

REL = 1e-11  # the truth is a recursion in floats over 400 samples

LOOPS = {
    "lag, P": loop(1.0, 2.0, "0", "1/8", [1.5], [1.0]),
    "lag, P, slow clock": loop(1.0, 1.0, "0", "3", [0.75], [1.0]),
    "lag, PI": loop(0.5, 1.0, "0", "1/4", [2.0, -1.75], [1.0, -1.0]),
    "lag, PI, part of a sample": loop(0.5, 1.0, "3/32", "1/4", [1.5, -1.25], [1.0, -1.0]),
    "lag, PI, one sample": loop(0.5, 1.0, "1/4", "1/4", [1.0, -0.875], [1.0, -1.0]),
    "lag, PI, two samples and a half": loop(0.5, 1.0, "5/8", "1/4", [1.0, -0.875], [1.0, -1.0]),
    "lag, I": loop(2.0, 3.0, "1/64", "1/16", [0.0625], [1.0, -1.0]),
    "lag, I, fast for its clock": loop(4.0, 4.0, "1/2", "1", [0.25], [1.0, -1.0]),
    "lag, lead filter": loop(1.0, 4.0, "1/16", "1/8", [2.0, -1.5], [1.0, -0.25]),
    "unstable lag, P": loop(-0.5, 1.0, "1/32", "1/8", [2.0], [1.0]),
    "upside down, PI": loop(0.5, -1.0, "1/16", "1/4", [-1.5, 1.25], [1.0, -1.0]),
    "integrator, P": loop(0.0, 1.0, "0", "1/2", [0.75], [1.0]),
    "integrator, P, late": loop(0.0, 1.0, "5/16", "1/2", [0.75], [1.0]),
    "integrator, lag filter": loop(0.0, 2.0, "9/8", "1/4", [0.125, 0.0625], [1.0, -0.5]),
    "integrator, second order": loop(0.0, 1.0, "1/8", "1/2", [0.5, -0.11], [1.0, -0.5, 0.125]),
    "integrator, controller late": loop(0.0, 1.0, "1/8", "1/2", [0.25], [1.0, -0.25, 0.125]),
    "integrator, four samples": loop(0.0, 1.0, "2", "1/2", [0.25], [1.0]),
}
EACH = pytest.mark.parametrize("case", LOOPS.values(), ids=LOOPS.keys())


def parts(case):
    """Return (plant, controller); a third of the gain in the sensor, a quarter of the delay apart.

    The rest of the delay is the computer's.
    """
    plant = zoh.Plant(
        num=[case.b * 4], den=[1, case.a], dead_time=float(case.delay) / 4, sensor=0.25
    )
    return plant, zoh.Sampled(num=case.num, den=case.den, dt=float(case.dt))


def later(case):
    return float(case.delay) * 0.75


def at_rest(case):
    """Return what y and u settle to under a step."""
    if sum(case.den) == 0:
        return 1.0, case.a / case.b
    gain = sum(case.num) / sum(case.den)
    if not case.a:
        return 1.0, 0.0
    return gain * case.b / (case.a + gain * case.b), gain * case.a / (case.a + gain * case.b)


def near(value, scale=0.0):
    return pytest.approx(value, rel=REL, abs=REL * scale)


@EACH
def test_a_step_at_the_samples(case):
    plant, controller = parts(case)
    got = closed_loop_step(plant, controller, compute_delay=later(case))
    _, y, _ = case.knots()
    final, _ = at_rest(case)
    dt, y = float(case.dt), np.array(y)
    assert got.stable
    assert (got.final_value, got.steady_state_error) == (near(final), near(1 - final, 1.0))
    over = max(0.0, y.max() / final - 1)
    assert got.overshoot_pct == near(100 * over, 100.0)
    assert got.undershoot_pct == near(100 * max(0.0, -y.min() / final), 100.0)
    assert got.peak == near(max(y.max(), final))
    # a loop that only creeps up has no time of its peak
    assert got.peak_time == (near(dt * int(y.argmax())) if over > 1e-9 else None)
    ten, ninety = (dt * int(np.argmax(y >= level * final)) for level in (0.1, 0.9))
    assert got.rise_time == near(ninety - ten)
    outside = np.nonzero(np.abs(y - final) > 0.02 * final)[0]
    assert got.settling_time == near(dt * (int(outside[-1]) + 1))


@EACH
def test_a_step_between_the_samples(case):
    plant, controller = parts(case)
    got = closed_loop_step(plant, controller, compute_delay=later(case)).between_samples
    knots, _, _ = case.knots()
    final, _ = at_rest(case)
    x = np.array([x for _, x, _ in knots])
    over = max(0.0, x.max() / final - 1)
    assert got.overshoot_pct == near(100 * over, 100.0)
    assert got.undershoot_pct == near(100 * max(0.0, -x.min() / final), 100.0)
    assert got.peak == near(max(x.max(), final))
    assert got.peak_time == (near(knots[int(x.argmax())][0]) if over > 1e-9 else None)
    ten, ninety = (case.reaches(knots, level * final) for level in (0.1, 0.9))
    assert got.rise_time == near(ninety - ten)
    assert got.settling_time == near(case.settles(knots, final, 0.02 * final))


@EACH
@pytest.mark.parametrize("reference", [1.0, -2.5])
def test_the_effort_of_a_step(case, reference):
    plant, controller = parts(case)
    got = closed_loop_step(
        plant, controller, compute_delay=later(case), reference=reference
    )  # fmt: skip
    _, _, u = case.knots()
    limit = at_rest(case)[1]
    u = np.array([*u, limit])
    ends = sorted((reference * u.min(), reference * u.max()))
    size = abs(reference) * np.abs(u).max()
    assert got.effort_range == near(tuple(ends), size)
    assert got.peak_effort == near(size)
    first = int(np.abs(u).argmax())
    reached = np.abs(u[:-1]).max() >= abs(limit) * (1 - 1e-10)
    assert got.peak_effort_time == (near(float(case.dt) * first) if reached else None)
    assert got.final_value == near(reference * at_rest(case)[0])
    assert got.steady_state_error == near(reference * (1 - at_rest(case)[0]), 1.0)
    assert got.peak >= abs(got.final_value) * (1 - 1e-12)


@EACH
@pytest.mark.parametrize("by", zoh.EXCITATIONS)
def test_the_curves_run_through_the_knots(case, by):
    plant, controller = parts(case)
    knots, y, u = case.knots(by, 24)
    curve = zoh.response_trace(
        plant, controller, by=by, t_end=23 * float(case.dt), compute_delay=later(case), per_sample=2
    )
    scale = max(map(abs, y))
    assert curve.t == near(float(case.dt) * np.arange(24))
    assert curve.y == near(np.array(y), scale)
    assert curve.u == near(np.array(u), max(map(abs, u)))
    for t, x, _ in knots:
        i = int(np.abs(curve.t_between - t).argmin())
        assert curve.t_between[i] == pytest.approx(t, rel=1e-14, abs=1e-14)
        assert curve.y_between[i] == near(x, scale)


@EACH
@pytest.mark.parametrize("by", ["step", "impulse", "disturbance"])
def test_the_figures_of_a_response(case, by):
    plant, controller = parts(case)
    got = zoh.response(plant, controller, by=by, compute_delay=later(case))
    knots, _, u = case.knots(by)
    final, limit = at_rest(case)
    if by == "impulse":
        final = limit = 0.0
    elif by == "disturbance":
        # the integral takes all of it; otherwise P/(1 + C P) and -C P/(1 + C P)
        integral = sum(case.den) == 0
        gain = 1.0 if integral else sum(case.num) / sum(case.den)
        final, limit = (0.0, -1.0) if integral else (final / gain, -final)
    x = np.array([x for _, x, _ in knots])
    peak, size = np.abs(x).max(), max(np.abs(x).max(), abs(final))
    assert got.excitation == by
    assert got.final_value == near(final, 1.0)
    assert got.peak == near(size)
    reached = peak > abs(final) * (1 + 1e-9)
    assert got.peak_time == (near(knots[int(np.abs(x).argmax())][0]) if reached else None)
    assert got.settling_time == near(case.settles(knots, final, 0.02 * size))
    assert got.peak_effort == near(max(np.abs(u).max(), abs(limit)))
    assert got.horizon % float(case.dt) == pytest.approx(0.0, abs=1e-9)
    assert got.horizon > got.settling_time


@EACH
def test_the_error_under_a_ramp(case):
    plant, controller = parts(case)
    got = zoh.response(plant, controller, by="ramp", compute_delay=later(case))
    assert got.excitation == "ramp"
    if case.a and sum(case.den):
        assert (got.final_value, got.peak, got.peak_time) == (inf, inf, None)
        assert (got.settling_time, got.peak_effort, got.horizon) == (None, inf, None)
        return
    knots, _, u = case.knots("ramp")
    error = np.array([t - x for t, x, _ in knots])
    if case.a:
        # D ~ num(1)/(slope of den at 1) (1/(dt s)) at low frequencies
        velocity = sum(case.num) / float(case.dt) * case.b / case.a
        assert got.peak_effort == inf
        assert got.peak >= np.abs(error).max() * (1 - REL)  # may be inside, where v is constant
    else:
        velocity = sum(case.num) / sum(case.den) * case.b
        assert got.peak_effort == near(max(np.abs(u).max(), 1 / case.b))
        size = max(np.abs(error).max(), 1 / velocity)
        assert got.peak == near(size)
        last = int(np.nonzero(np.abs(error - 1 / velocity) > 0.02 * size)[0][-1])
        t, _, v = knots[last]
        edge = 1 / velocity + (0.02 if error[last] > 1 / velocity else -0.02) * size
        assert got.settling_time == near(t + (edge - error[last]) / (1 - case.b * v))
    assert got.final_value == near(1 / velocity)


@EACH
def test_noise_is_the_sum_of_squares(case):
    plant, controller = parts(case)
    found = zoh.noise_gains(plant, controller, compute_delay=later(case))
    _, y, u = case.knots("impulse", COUNT)
    assert found == near((np.sqrt(np.square(y).sum()), np.sqrt(np.square(u).sum())))
