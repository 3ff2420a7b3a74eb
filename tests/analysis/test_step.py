"""step: metrics at the samples and, exactly, between them."""

import json
from math import exp, log, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf

from zoh.analysis.curves import trace
from zoh.analysis.step import closed_loop_step, step_info
from zoh.analysis.verify import measure
from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

ORACLES = Path(__file__).parents[1] / "oracles"
CASES = json.loads((ORACLES / "step.json").read_text())
DELAYED = json.loads((ORACLES / "delayed.json").read_text())
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


def test_there_are_two_hundred_loops():
    assert len(CASES) >= 200


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
    limit = final * case["den"][-1] / case["num"][-1] / case["sensor"]
    for end, wanted in zip(got.effort_range, map(float, case["effort_range"]), strict=True):
        # 1e-5: the truth was followed to 1e-6 of the slowest mode, and does not see the last dips
        # around the limit
        rel = 1e-5 if wanted == pytest.approx(limit, rel=1e-12) else REL
        assert end == pytest.approx(wanted, rel=rel, abs=1e-12 * got.peak_effort)


@pytest.mark.parametrize("case", DELAYED, ids=lambda c: c["name"])
def test_a_delay_of_many_samples(case):
    plant, controller = parts(case)
    got = closed_loop_step(plant, controller, compute_delay=case["compute_delay"])
    assert_metrics(got, case["at_samples"])
    assert_metrics(got.between_samples, case["between_samples"])
    wanted = [float(end) for end in case["effort_range"]]
    assert got.effort_range == pytest.approx(wanted, rel=REL)
    assert got.peak_effort == pytest.approx(float(case["peak_effort"]), rel=REL)


@pytest.mark.parametrize("case", DELAYED, ids=lambda c: c["name"])
def test_a_trace_through_a_delay_of_many_samples(case):
    plant, controller = parts(case)
    k, y, u = (list(a) for a in zip(*case["samples"], strict=True))
    curve = trace(
        plant, controller, compute_delay=case["compute_delay"],
        t_end=k[-1] * case["dt"], per_sample=1,
    )  # fmt: skip
    assert curve.y[k] == pytest.approx(np.array(y, float), rel=REL, abs=1e-12)
    assert curve.u[k] == pytest.approx(np.array(u, float), rel=REL, abs=1e-12)


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
def test_unstable_is_an_answer(system):
    got = step_info(system)
    assert not got.stable
    assert set(got.to_dict().values()) == {False, None}
    assert got.settling == "unstable"


def test_what_is_no_system_is_refused():
    with pytest.raises(SpecError, match=r"must be a zoh\.Plant or zoh\.Sampled"):
        step_info([1.0, 2.0])


# The horizon: 0.5^k is below 1e-8 from k = 27 on; a lag under P 1, dt 0.1, has one mode
# z = e - (1 - e), e = exp(-0.1)
def test_the_horizon_is_the_slowest_modes_and_said():
    got = step_info(Sampled(num=[0.5], den=[1, -0.5], dt=0.2))
    assert 27 * 0.2 <= got.horizon <= 60 * 0.2
    assert got.to_dict()["horizon"] == got.horizon
    loop = closed_loop_step(Plant(num=[1], den=[1, 1]), Sampled(num=[1], den=[1], dt=0.1))
    slowest = -log(2 * exp(-0.1) - 1) / 0.1
    assert log(1e8) / slowest <= loop.horizon <= 3 * log(1e8) / slowest


def test_a_loop_followed_to_no_rest_says_how_far():
    # a swing that dies over 1e9 rad, at 1 rad a sample: more swings than are followed
    plant = Plant(num=[1], den=[1, 2e-9, 1])
    got = closed_loop_step(plant, Sampled(num=[1e-12], den=[1], dt=1e-2))
    assert got.settling_time is None
    assert got.between_samples.settling_time is None
    assert got.settling == f"not at rest by {got.horizon:.4g} s"
    assert got.horizon > 1e4
    # the first swing of an undamped resonance doubles the final value
    assert got.between_samples.overshoot_pct == pytest.approx(100 * exp(-2e-9 * pi / 2), rel=1e-5)


@pytest.mark.parametrize("slow", [1e3, 1e6, 1e9])
def test_a_mode_slower_than_a_billion_samples_by_hand(slow):
    """1/s under P 1/slow: y(k) = 1 - q^k, q = 1 - 1/slow, straight between the samples."""
    got = closed_loop_step(Plant(num=[1], den=[1, 0]), Sampled(num=[1 / slow], den=[1], dt=1.0))
    with mp.workdps(40):
        rate = mp.log1p(-1 / mpf(1 / slow) ** -1)
        ten, ninety, settled = (int(mp.ceil(mp.log(mpf(x)) / rate)) for x in ("0.9", "0.1", "0.02"))
    assert got.rise_time == ninety - ten
    assert got.settling_time == settled
    assert (got.overshoot_pct, got.peak_time) == (0.0, None)
    # by less than a sample: it goes straight to the next one
    assert settled - 1 < got.between_samples.settling_time <= settled


def test_a_high_pass_comes_back_to_nothing():
    # s/(s+1)^2: t e^-t, at its top 1/e at t = 1
    got = step_info(Plant(num=[1, 0], den=[1, 2, 1]))
    assert (got.final_value, got.overshoot_pct, got.rise_time) == (0.0, None, None)
    assert got.peak == pytest.approx(exp(-1), rel=REL)
    assert got.peak_time == pytest.approx(1.0, rel=1e-7)  # a flat top
    assert got.settling == "settles to 0"


def test_a_plant_that_answers_at_once_jumps_at_the_samples():
    """(s+2)/(s+1) = 1 + 1/(s+1) under 0.3/(z-1): u(0) = 0, u(1) = 0.3, then by recursion."""
    got = closed_loop_step(Plant(num=[1, 2], den=[1, 1]), Sampled(num=[0.3], den=[1, -1], dt=0.1))
    fall, x, u, y = exp(-0.1), 0.0, 0.0, []
    for _ in range(200):
        y.append(x + u)
        x, u = fall * x + (1 - fall) * u, u + 0.3 * (1 - y[-1])
    assert got.peak == pytest.approx(max(y), rel=REL)
    assert got.peak_time == pytest.approx(0.1 * int(np.argmax(y)), rel=1e-14)
    assert got.effort_range[0] == 0.0
    # between the samples it climbs on towards 2 u(k) until the next input
    top, x, u = 0.0, 0.0, 0.0
    for _ in range(200):
        at_sample = x + u
        x, u_old = fall * x + (1 - fall) * u, u
        top = max(top, at_sample, x + u_old)
        u += 0.3 * (1 - at_sample)
    assert got.between_samples.peak == pytest.approx(top, rel=REL)


def test_a_sample_in_which_everything_is_over():
    """1/(s+1) at dt = 1000 under 0.5/(z-1): y(k+1) = u(k), u: 0, 0.5, 1, 1.25, 1.25, ..."""
    got = closed_loop_step(Plant(num=[1], den=[1, 1]), Sampled(num=[0.5], den=[1, -1], dt=1e3))
    assert (got.peak, got.peak_time) == (pytest.approx(1.25, rel=1e-14), 4000.0)
    # at 1000 s the input steps to 0.5, at 2000 to 1: 10 % at 1000 - ln(0.8), 90 % at 2000 + ln 5
    assert got.between_samples.rise_time == pytest.approx(1000 + log(5) + log(0.8), rel=REL)


def test_a_resonance_of_many_swings_a_sample():
    """w^2/(s^2 + 2 z w s + w^2), w dt = 20: in the first sample that moves it swings freely."""
    w, zeta = 200.0, 0.02
    plant = Plant(num=[w * w], den=[1, 2 * zeta * w, w * w])
    got = closed_loop_step(plant, Sampled(num=[0.05], den=[1], dt=0.1))
    root = sqrt(1 - zeta * zeta)
    final = 0.05 / 1.05
    assert got.final_value == pytest.approx(final, rel=1e-14)
    peak = 0.05 * (1 + exp(-pi * zeta / root))
    assert got.between_samples.peak == pytest.approx(peak, rel=REL)
    assert got.between_samples.peak_time == pytest.approx(pi / (w * root), rel=1e-7)  # flat top


def test_too_many_swings_a_sample_are_not_guessed():
    plant = Plant(num=[9e10], den=[1, 0.3, 9e10])
    got = closed_loop_step(plant, Sampled(num=[0.05], den=[1, -1], dt=0.1))
    assert got.between_samples is None
    assert got.settling_time is not None


def test_a_controllers_pole_beside_minus_one():
    """C = 0.2/(z + 0.999) before 1/z (a static plant, one sample late): by recursion."""
    plant = Plant(num=[1], den=[1], dead_time=0.5)
    got = closed_loop_step(plant, Sampled(num=[0.2], den=[1, 0.999], dt=0.5))
    u, y = [0.0], []
    for k in range(4000):
        y.append(u[k - 1] if k else 0.0)
        u.append(-0.999 * u[k] + 0.2 * (1 - y[k]))
    assert got.peak == pytest.approx(max(y), rel=REL)
    assert got.peak_effort == pytest.approx(max(map(abs, u)), rel=REL)
    final = 0.2 / 1.999 / (1 + 0.2 / 1.999)
    out = [k for k, v in enumerate(y) if abs(v - final) > 0.02 * final]
    assert got.settling_time == pytest.approx(0.5 * (out[-1] + 1), rel=1e-14)


# rounded z-coefficients of a higher order, or at a smaller dt, have lost the answer
IN_Z = [c for c in CASES if c["dt"] > (5e-3 if len(c["den"]) <= 4 else 0.1)][::4]


@pytest.mark.parametrize("case", IN_Z, ids=lambda c: c["name"])
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


@pytest.mark.parametrize(
    ("system", "final"),
    [
        (Sampled(num=[5.0], den=[6.0], dt=1.0), 5 / 6),  # a gain of 5 in closed loop
        (Plant(num=[5], den=[6]), 5 / 6),
        (Sampled(num=[0.2, 0.3, 0.5], den=[1.0, 0.0, 0.0, 0.0], dt=1.0), 1.0),  # there from 3 s on
        (Sampled(num=[0.5], den=[1.0, -0.5], dt=1.0), 1.0),  # 1 - 0.5^k, for ever below
    ],
)
def test_what_never_passes_its_final_value_has_no_peak_time(system, final):
    info = step_info(system)
    assert (info.peak_time, info.overshoot_pct) == (None, 0.0)
    assert info.peak == info.final_value == pytest.approx(final, rel=1e-15)


def test_a_loop_is_closed_as_the_readme_says():
    plant, controller = (
        Plant(num=[1], den=[1, 1]),
        Sampled(num=[2.0, -1.5], den=[1.0, -1.0], dt=0.1),
    )
    loop = controller * sample(plant, 0.1)
    closed = Sampled.from_w(num_w=loop.num_w, den_w=np.polyadd(loop.den_w, loop.num_w), dt=loop.dt)
    told, measured = step_info(closed), measure(plant, controller).step
    for name in ("peak", "peak_time", "rise_time", "settling_time", "final_value"):
        assert getattr(told, name) == pytest.approx(getattr(measured, name), rel=1e-12)
