"""step: metrics at the samples and, exactly, between them."""

import json
from math import exp, log, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from zoh.analysis.curves import trace
from zoh.analysis.step import step_info
from zoh.analysis.verify import measure
from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

CASES = json.loads((Path(__file__).parents[1] / "oracles" / "step.json").read_text())
REL = 1e-9


def parts(case):
    plant = Plant(
        num=case["num"], den=case["den"], dead_time=case["dead_time"], sensor=case["sensor"]
    )
    num, den = case["controller"]
    return plant, Sampled(num=num, den=den, dt=case["dt"])


@pytest.fixture(scope="module", params=CASES, ids=lambda c: c["name"])
def measured(request):
    """Return (step metrics of the loop, the case)."""
    case = request.param
    plant, controller = parts(case)
    found = measure(
        plant,
        controller,
        compute_delay=case["compute_delay"],
        reference=case["reference"],
    )
    assert found.margins.stable
    return found.step, case


def assert_metrics(got, truth):
    for name in ("rise_time", "settling_time"):
        assert getattr(got, name) == pytest.approx(float(truth[name]), rel=REL), name
    for name in ("overshoot_pct", "undershoot_pct"):
        # below 1e-3 % the truth was not run long enough to say more than that it is small
        wanted = float(truth[name])
        tolerance = {"rel": REL, "abs": 1e-7} if wanted > 1e-3 else {"abs": 1e-3}
        assert getattr(got, name) == pytest.approx(wanted, **tolerance), name
    if float(truth["overshoot_pct"]) > 1e-3:
        assert got.peak == pytest.approx(float(truth["peak"]), rel=REL)
        # the time of a flat top: its height to 1e-15 is its time to the root of that
        assert got.peak_time == pytest.approx(float(truth["peak_time"]), rel=1e-7)


def test_metrics_at_the_samples(measured):
    got, case = measured
    assert_metrics(got, case["at_samples"])


def test_metrics_between_the_samples(measured):
    got, case = measured
    assert_metrics(got.between_samples, case["between_samples"])


def test_final_value_error_and_effort(measured):
    got, case = measured
    final = float(case["final_value"])
    assert got.final_value == pytest.approx(final, rel=REL)
    error = case["reference"] - final
    assert got.steady_state_error == pytest.approx(error, rel=REL, abs=1e-12)
    assert got.peak_effort == pytest.approx(float(case["peak_effort"]), rel=REL)


@pytest.mark.parametrize("case", CASES, ids=lambda c: c["name"])
def test_trace_runs_through_the_exact_points(case):
    plant, controller = parts(case)
    curve = trace(
        plant,
        controller,
        compute_delay=case["compute_delay"],
        reference=case["reference"],
        t_end=11 * case["dt"],
    )
    y, u, half = (np.array(case[k], float) for k in ("y", "u", "y_half_way"))
    size, effort = np.abs(y).max(), np.abs(u).max()
    assert curve.t[:12] == pytest.approx(np.arange(12) * case["dt"], rel=1e-15)
    assert curve.y[:12] == pytest.approx(y, rel=REL, abs=1e-12 * size)
    assert curve.u[:12] == pytest.approx(u, rel=REL, abs=1e-12 * effort)
    for k in range(11):
        t = (k + 0.5) * case["dt"]
        i = int(np.argmin(np.abs(curve.t_between - t)))
        if abs(curve.t_between[i] - t) < 1e-12 * t:
            assert curve.y_between[i] == pytest.approx(half[k], rel=REL, abs=1e-12 * size)


def test_the_trace_is_dense_ordered_and_read_only():
    curve = trace(Plant(num=[1], den=[1, 1]), Sampled(num=[1], den=[1], dt=0.1), t_end=2.0)
    assert len(curve.t) == 21
    assert np.all(np.diff(curve.t_between) >= 0)
    assert len(curve.t_between) >= 20 * 20
    for signal in (curve.t, curve.y, curve.u, curve.t_between, curve.y_between):
        with pytest.raises(ValueError, match="read-only"):
            signal[0] = 1.0


# Worked by hand.
#   0.5/(z-0.5): y = 1 - 2^-k. 10 % at k=1, 90 % at k=4 (0.9375), 2 % at k=6 (1/64)
#   1/z: one sample of delay, then there
#   -0.5/(z-0.5): the same, upside down
#   (1.25 z - 1)/(z (z-0.75)): y = 1.25, 1.1875, ... down to 1
def test_a_sampled_lag_by_hand():
    got = step_info(Sampled(num=[0.5], den=[1, -0.5], dt=0.2))
    assert got.rise_time == pytest.approx(0.6, rel=1e-14)
    assert got.settling_time == pytest.approx(1.2, rel=1e-14)
    assert (got.overshoot_pct, got.undershoot_pct) == (0.0, 0.0)
    assert got.final_value == pytest.approx(1.0, rel=1e-15)
    assert got.steady_state_error == pytest.approx(0.0, abs=1e-15)
    assert got.between_samples is None
    assert got.peak_effort is None


def test_a_pure_delay_by_hand():
    got = step_info(Sampled(num=[1], den=[1, 0], dt=0.2))
    assert got.rise_time == 0.0
    assert got.settling_time == pytest.approx(0.2, rel=1e-15)
    assert got.peak == 1.0


def test_upside_down_is_the_same_story():
    up = step_info(Sampled(num=[0.5], den=[1, -0.5], dt=0.2))
    down = step_info(Sampled(num=[-0.5], den=[1, -0.5], dt=0.2))
    assert (down.rise_time, down.settling_time) == (up.rise_time, up.settling_time)
    assert down.overshoot_pct == 0.0
    assert down.final_value == -up.final_value


def test_overshoot_of_a_lead_by_hand():
    # (1.25 z - 1)/(z - 0.75): y_0 = 1.25, then down to 1 by 0.75 each time
    got = step_info(Sampled(num=[1.25, -1.0], den=[1, -0.75], dt=1.0))
    assert got.overshoot_pct == pytest.approx(25, rel=1e-13)
    assert (got.peak, got.peak_time) == (1.25, 0.0)
    assert got.settling_time == 9.0  # 0.25 * 0.75^9 = 0.0188 is the first below 0.02


@pytest.mark.parametrize("zeta", [0.05, 0.3, 0.5, 0.9])
@pytest.mark.parametrize("wn", [1e-3, 1.0, 1e4])
def test_second_order_has_closed_forms(zeta, wn):
    """wn^2/(s^2 + 2 zeta wn s + wn^2): e^(-pi zeta/sqrt(1-zeta^2)) at pi/(wn sqrt(1-zeta^2))."""
    got = step_info(Plant(num=[wn * wn], den=[1, 2 * zeta * wn, wn * wn]))
    root = sqrt(1 - zeta * zeta)
    assert got.overshoot_pct == pytest.approx(100 * exp(-pi * zeta / root), rel=REL)
    assert got.peak_time == pytest.approx(pi / (wn * root), rel=1e-7)  # a flat top
    assert got.undershoot_pct == 0.0


@pytest.mark.parametrize("tau", [1e-4, 1.0, 100.0])
@pytest.mark.parametrize("late", [0.0, 0.7])
def test_a_lag_has_closed_forms(tau, late):
    """1 - exp(-t/tau): rise tau ln 9, settling tau ln 50; a dead time shifts the second."""
    got = step_info(Plant(num=[3.0], den=[tau, 1.0], dead_time=late * tau))
    assert got.rise_time == pytest.approx(tau * log(9), rel=REL)
    assert got.settling_time == pytest.approx(tau * (log(50) + late), rel=REL)
    assert (got.overshoot_pct, got.final_value) == (0.0, 3.0)
    assert got.steady_state_error == -2.0


def test_undershoot_of_a_zero_on_the_right_by_hand():
    """(1-s)/(s+1)^2: y = 1 - e^-t - 2 t e^-t, least at t = 1/2: 1 - 2/sqrt(e)."""
    got = step_info(Plant(num=[-1, 1], den=[1, 2, 1]))
    assert got.undershoot_pct == pytest.approx(100 * (2 / sqrt(exp(1)) - 1), rel=REL)
    assert got.overshoot_pct == 0.0


@pytest.mark.parametrize(
    "system",
    [
        Sampled(num=[1], den=[1, -1], dt=0.1),
        Sampled(num=[1], den=[1, -1.1], dt=0.1),
        Sampled(num=[1], den=[1, 1], dt=0.1),
        Plant(num=[1], den=[1, 0]),
        Plant(num=[1], den=[1, 0, 1]),
        Plant(num=[1], den=[1, -1]),
    ],
)
def test_refuses_what_never_comes_to_rest(system):
    with pytest.raises(SpecError, match="must be stable"):
        step_info(system)


@pytest.mark.parametrize("case", [c for c in CASES if c["dt"] > 5e-3][::4], ids=lambda c: c["name"])
def test_the_closed_loop_as_one_system_says_the_same(case):
    plant, controller = parts(case)
    loop = controller * sample(plant, case["dt"], case["compute_delay"])
    n = len(loop.den)
    top = np.pad(loop.num, (n - len(loop.num), 0))
    closed = Sampled(num=top, den=np.array(loop.den) + top, dt=case["dt"])
    got, truth = step_info(closed), case["at_samples"]
    for name in ("rise_time", "settling_time"):
        assert getattr(got, name) == pytest.approx(float(truth[name]), rel=REL)
    # 1e-6: T's rounded z-coefficients cost what expanded coefficients cost
    assert got.overshoot_pct == pytest.approx(float(truth["overshoot_pct"]), rel=1e-6, abs=1e-3)


@given(st.floats(0.1, 3), st.floats(0.05, 1.2), st.integers(-6, 6))
def test_a_slower_clock_slows_the_times_and_nothing_else(a, kp, power):
    c = 2.0**power
    one = measure(Plant(num=[a], den=[1, a]), Sampled(num=[kp], den=[1], dt=0.3)).step
    slow = measure(Plant(num=[a / c], den=[1, a / c]), Sampled(num=[kp], den=[1], dt=0.3 * c)).step
    assert slow.rise_time == pytest.approx(one.rise_time * c, rel=REL)
    assert slow.settling_time == pytest.approx(one.settling_time * c, rel=REL)
    assert slow.overshoot_pct == pytest.approx(one.overshoot_pct, rel=REL, abs=1e-9)
    assert slow.peak_effort == pytest.approx(one.peak_effort, rel=REL)
