"""Responses other than the step's: by hand, by the plain recursion, against 50 digits."""

import json
from math import inf, sqrt
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

import zoh

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
PID = zoh.Sampled(num=[81.51, -139.5, 58.07], den=[1, -1, 0], dt=0.1)
LEAD = zoh.Sampled(num=[49.927, -48.1396], den=[1, -0.8215], dt=0.1)


CASES = json.loads((Path(__file__).parents[1] / "oracles" / "step.json").read_text())
PEAKS = [
    pytest.param(case, by, found, id=f"{by}: {case['name']}")
    for case in CASES
    for by, found in case.get("others", {}).items()
    if found is not None
]


@pytest.mark.parametrize(("case", "by", "truth"), PEAKS)
def test_peaks_between_the_samples(case, by, truth):
    plant = zoh.Plant(
        num=case["num"], den=case["den"], dead_time=case["dead_time"], sensor=case["sensor"]
    )
    controller = zoh.Sampled(num=case["controller"][0], den=case["controller"][1], dt=case["dt"])
    found = zoh.response(plant, controller, by=by, compute_delay=case["compute_delay"])
    assert found.peak == pytest.approx(float(truth["peak"]), rel=1e-9)
    # the time of a flat top: its height to 1e-15 is its time to the root of that
    assert found.peak_time == pytest.approx(float(truth["peak_time"]), rel=1e-7)


def test_there_are_two_hundred_peaks():
    assert len(PEAKS) >= 200


def recursion(num, den, e):
    """Return the output of num/den in z for the samples e, the textbook's difference equation."""
    n, u = len(den) - 1, np.zeros(len(e))
    num = [0.0] * (n + 1 - len(num)) + list(num)
    for k in range(len(e)):
        u[k] = sum(num[i] * e[k - i] for i in range(n + 1) if k >= i)
        u[k] -= sum(den[i] * u[k - i] for i in range(1, n + 1) if k >= i)
    return u


def sampled_loop(controller, r, count, d=0.0):
    """Return (y, u) at the samples of the arm under a reference r and an input disturbance d."""
    plant = zoh.sample(ARM, 0.1)
    open_loop = np.convolve(controller.num, plant.num), np.convolve(controller.den, plant.den)
    closed = np.polyadd(open_loop[0], open_loop[1])
    by_r = recursion(open_loop[0], closed, r)
    by_d = recursion(np.convolve(plant.num, controller.den), closed, np.full(count, d))
    y = by_r + by_d
    return y, recursion(controller.num, controller.den, r - y)


@pytest.mark.parametrize("controller", [PID, LEAD], ids=["PID", "lead"])
@pytest.mark.parametrize("by", zoh.EXCITATIONS)
def test_the_samples_are_those_of_the_recursion(controller, by):
    count = 200
    t = 0.1 * np.arange(count)
    r = {"step": np.ones(count), "impulse": np.eye(1, count)[0], "ramp": t}.get(by, 0 * t)
    y, u = sampled_loop(controller, r, count, 1.0 if by == "disturbance" else 0.0)
    curve = zoh.response_trace(ARM, controller, by=by, t_end=t[-1])
    scale = max(1.0, np.abs(y).max())
    # 1e-8: the recursion in expanded coefficients is the less exact of the two
    assert curve.y == pytest.approx(y, abs=1e-8 * scale)
    assert curve.u == pytest.approx(u, abs=1e-8 * np.abs(u).max())


def test_a_disturbance_on_a_loop_with_gain_leaves_its_share():
    plant, controller = zoh.Plant(num=[2], den=[1, 1]), zoh.Sampled(num=[4.5], den=[1], dt=0.01)
    found = zoh.response(plant, controller, by="disturbance")
    assert found.final_value == pytest.approx(0.2, rel=1e-12)  # 2/(1 + 9)
    assert found.peak_effort == pytest.approx(0.9, rel=1e-12)  # 9/(1 + 9)


def test_an_integral_takes_a_disturbance_away():
    found = zoh.response(ARM, PID, by="disturbance")
    assert found.final_value == 0.0
    assert found.peak > 0.05
    assert found.settling_time is not None


def test_a_ramp_is_followed_at_a_distance_of_one_over_the_velocity_constant():
    # lead: Kv = D(1) K/a with D(1) = 1.7874/0.1785 and K/a = 2.3 (12/180)/0.7809
    kv = (49.927 - 48.1396) / (1 - 0.8215) * 2.3 * (12 / 180) / 0.7809
    found = zoh.response(ARM, LEAD, by="ramp")
    assert found.final_value == pytest.approx(1 / kv, rel=1e-9)
    # the arm at 1 unit a second needs a voltage of a/K
    assert found.peak_effort >= 0.7809 / (2.3 * 12 / 180) * (1 - 1e-9)
    assert zoh.response(ARM, PID, by="ramp").final_value == 0.0
    gain = zoh.Sampled(num=[2], den=[1], dt=0.1)
    static = zoh.response(zoh.Plant(num=[1], den=[1, 1]), gain, by="ramp")
    assert static.final_value == inf
    assert static.settling_time is None


def test_noise_by_hand():
    # y(k+1) = (1 - g) y(k) - g n(k): var y = g^2/(1 - (1-g)^2) = g/(2-g); u = -g (y + n)
    g = 0.4
    y, u = zoh.noise_gains(zoh.Plant(num=[1], den=[1, 0]), zoh.Sampled(num=[g], den=[1], dt=1.0))
    assert y == pytest.approx(sqrt(g / (2 - g)), rel=1e-12)
    assert u == pytest.approx(g * sqrt(g / (2 - g) + 1), rel=1e-12)


def test_noise_is_the_sum_of_squares_of_the_impulse_response():
    y, u = sampled_loop(LEAD, -np.eye(1, 4000)[0], 4000)
    found = zoh.noise_gains(ARM, LEAD)
    # 1e-7: what is left of the slowest mode after 4000 samples, and the recursion's rounding
    assert found == pytest.approx((sqrt(y @ y), sqrt(u @ u)), rel=1e-7)


def test_a_ramps_error_between_the_samples_by_hand():
    # 1/s behind P g, dt 1: y(1) = 0, then e(k) = r - y: e(1) = 1, y(2) = g, and in (1, 2) the
    # error t - y(t) = t - g (t - 1) grows on; with g < 1 it creeps up to 1/g at the samples, and
    # between two of them it is never above the higher
    found = zoh.response(
        zoh.Plant(num=[1], den=[1, 0]), zoh.Sampled(num=[0.5], den=[1], dt=1.0), by="ramp"
    )
    assert found.final_value == pytest.approx(2.0, rel=1e-12)
    assert found.peak == pytest.approx(2.0, rel=1e-7)
    assert found.peak_time is None  # it creeps up to its end
    # with g = 1.5: e = 0, 1, 0.5, 0.75, ... at the samples, 1/1.5 at the end
    found = zoh.response(
        zoh.Plant(num=[1], den=[1, 0]), zoh.Sampled(num=[1.5], den=[1], dt=1.0), by="ramp"
    )
    assert (found.peak, found.peak_time) == (pytest.approx(1.0, rel=1e-14), 1.0)


def test_noise_through_a_long_delay_by_hand():
    # y(k+1) = y(k) - g (y + n)(k - m): for a small g it is the delay-free filter, but exactly it
    # is the sum of squares of the recursion's impulse response
    g, m, count = 0.004, 100, 20_000
    y, u = [0.0], []
    for k in range(count):
        u.append(-g * (y[k] + (1.0 if k == 0 else 0.0)))
        y.append(y[k] + (u[k - m] if k >= m else 0.0))
    plant = zoh.Plant(num=[1], den=[1, 0], dead_time=float(m))
    found = zoh.noise_gains(plant, zoh.Sampled(num=[g], den=[1], dt=1.0))
    truth = sqrt(sum(v * v for v in y)), sqrt(sum(v * v for v in u))
    assert found == pytest.approx(truth, rel=1e-9)


def test_a_disturbance_on_a_loop_that_waits_a_thousand_samples():
    # until the first answer arrives after 10 s the lag does what it does alone: 2 (1 - e^-(t/30))
    plant = zoh.Plant(num=[2], den=[30, 1], dead_time=10.0)
    kp = 0.4 * 30 / (2 * 10)
    controller = zoh.Sampled(num=[kp + kp / 30 * 0.01, -kp], den=[1, -1], dt=0.01)
    found = zoh.response(plant, controller, by="disturbance")
    assert found.final_value == 0.0
    assert found.peak >= 2 * (1 - np.exp(-10 / 30))
    curve = zoh.response_trace(plant, controller, by="disturbance", t_end=10.0, per_sample=1)
    assert curve.y == pytest.approx(2 * (1 - np.exp(-curve.t / 30)), rel=1e-11)
    assert found.settling_time is not None


def test_unstable_and_unknown_are_refused():
    with pytest.raises(zoh.SpecError, match="must make the closed loop stable"):
        zoh.response(ARM, zoh.Sampled(num=[1e6], den=[1], dt=0.1), by="step")
    with pytest.raises(zoh.SpecError, match="by must be one of step, impulse"):
        zoh.response(ARM, LEAD, by="sine")
    with pytest.raises(zoh.SpecError, match="must make the closed loop stable"):
        zoh.noise_gains(ARM, zoh.Sampled(num=[1e6], den=[1], dt=0.1))


def test_a_deadbeat_is_still_at_the_samples_and_rings_between_them():
    # one-step deadbeat: D = (z - exp(-a dt))/(b (z + 0.974)) leaves 90 deg at every sample, while
    # the zero it cancels rings on between them: 68.5 deg from peak to peak after a second, at
    # 12 kV (an independent simulation of the same loop; 0.1 deg is its last digit)
    sampled = zoh.sample(ARM, 0.1)
    deadbeat = zoh.Sampled(num=[1, -sampled.den[2]], den=sampled.num, dt=0.1)
    curve = zoh.trace(ARM, deadbeat, reference=90.0, t_end=10.0)
    assert curve.y[1:] == pytest.approx(90.0, abs=1e-9)
    assert np.ptp(curve.y_between[curve.t_between >= 1.0]) == pytest.approx(68.5, abs=0.1)
    volts = np.abs(curve.u[curve.t >= 1.0 - 1e-9]).max() * ARM.sensor
    assert volts == pytest.approx(12e3, rel=0.01)  # 1 %: the source says 12 kV
    found = zoh.verify(ARM, deadbeat, requirements=zoh.Requirements(), reference=90.0).step
    assert found.overshoot_pct == 0.0
    assert found.between_samples.overshoot_pct > 48


@pytest.mark.parametrize("gain", [0.5, 1e-3, 1e-8, 1e-9, 1e-12, 1e-100])
def test_the_noise_of_a_weak_loop_keeps_its_digits(gain):
    """x+ = a x - b (n + x), a = exp(-dt), b = K (1 - a): its variance is b^2/(1 - (a - b)^2)."""
    plant, controller = zoh.Plant(num=[1], den=[1, 1]), zoh.Sampled(num=[gain], den=[1], dt=0.1)
    with mp.workdps(50):
        a = mp.exp(-mp.mpf(0.1))
        b = gain * (1 - a)
        y = mp.sqrt(b * b / (1 - (a - b) ** 2))
        u = gain * mp.sqrt(1 + b * b / (1 - (a - b) ** 2))
    assert zoh.noise_gains(plant, controller) == pytest.approx((float(y), float(u)), rel=1e-13)
