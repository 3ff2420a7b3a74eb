"""step, closed, waveform: edges and refusals, worked by hand."""

import warnings
from math import cos, exp, log, pi, sin, sqrt

import numpy as np
import pytest
import scipy.linalg
import scipy.signal
from mpmath import mp, mpf

import zoh
from zoh.analysis import motion
from zoh.analysis.closed import closed_loop, followable
from zoh.analysis.curves import trace
from zoh.analysis.rest import gains_at_rest
from zoh.analysis.step import closed_loop_step, step_info
from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import MAX_DELAY

INTEGRATOR = Plant(num=[1], den=[1, 0])
HALF = Sampled(num=[0.5], den=[1], dt=0.5)


def refusal(ask):
    with pytest.raises(SpecError) as err:
        ask()
    return str(err.value)


def test_refusals_in_words():
    assert refusal(lambda: closed_loop(INTEGRATOR, HALF, by="sine")) == (
        "by must be one of step, impulse, ramp, disturbance, got 'sine': choose one of these"
    )
    assert refusal(lambda: closed_loop(3, HALF)) == (
        "plant must be a zoh.Plant, got 3: give num and den, or a formula"
    )
    assert refusal(lambda: closed_loop(INTEGRATOR, 3)) == (
        "controller must be a zoh.Sampled, got 3: give num, den and dt"
    )
    far, late = (
        Plant(num=[1], den=[1, 0], dead_time=4999.5),
        Sampled(num=[1], den=[1, 0, 0], dt=0.5),
    )
    assert refusal(lambda: closed_loop(far, late)) == (
        "dead_time + compute_delay must be at most 10000 samples (5000 s) in a loop, got 10001: "
        "sample more slowly"
    )
    assert refusal(lambda: step_info([1.0, 2.0])) == (
        "system must be a zoh.Plant or zoh.Sampled, got [1.0, 2.0]: "
        "a table shows no step; of coefficients make one first"
    )
    table = zoh.FrequencyResponse.from_bode(hz=[1, 2], db=[0, -6], phase_deg=[-90, -120])
    assert refusal(lambda: step_info(table)).startswith("system must be a zoh.Plant or zoh.Sampled")


def test_an_algebraic_loop_of_gain_minus_one():
    # (s + 2)/(2 s + 1) answers at once with 1/2; a P of -2 closes a loop of gain -1
    plant = Plant(num=[1, 2], den=[2, 1])
    words = "controller must not close an algebraic loop of gain -1, got -2.0: add delay"
    assert refusal(lambda: closed_loop(plant, Sampled(num=[-2.0], den=[1], dt=0.1))) == words
    closed_loop(plant, Sampled(num=[2.0], den=[1], dt=0.1))
    closed_loop(plant, Sampled(num=[-0.5], den=[1], dt=0.1))
    late = Plant(num=[1, 2], den=[2, 1], dead_time=0.01)
    closed_loop(late, Sampled(num=[-2.0], den=[1], dt=0.1))


def test_delays_that_can_be_followed():
    assert followable(INTEGRATOR, 0.5, 0.0) == (0, 0)
    assert followable(Plant(num=[1], den=[1, 0], dead_time=1.25), 0.5, 0.5) == (4, 0.5)
    assert followable(INTEGRATOR, 0.5, 0.25, 2) == (3, 0.5)
    assert followable(INTEGRATOR, 0.5, MAX_DELAY * 0.5)[0] == MAX_DELAY
    assert followable(INTEGRATOR, 0.5, (MAX_DELAY - 7) * 0.5, 7)[0] == MAX_DELAY
    with pytest.raises(SpecError):
        followable(INTEGRATOR, 0.5, (MAX_DELAY - 7) * 0.5, 8)


@pytest.mark.parametrize("late", [64, 65])
def test_a_delay_at_the_edge_of_what_is_carried(late):
    """1/s under P 1/512, dt 1/2: nothing moves for ``late`` samples, then dt/512 a sample."""
    slow = Sampled(num=[1 / 512], den=[1], dt=0.5)
    plant = Plant(num=[1], den=[1, 0], dead_time=late * 0.5)
    curve = zoh.trace(plant, slow, t_end=0.5 * (2 * late + 1), per_sample=1)
    assert curve.y[: late + 1].tolist() == [0.0] * (late + 1)
    assert curve.y[late : 2 * late + 1] == pytest.approx(
        [k / 1024 for k in range(late + 1)], rel=1e-13
    )
    got = closed_loop_step(plant, slow)
    assert (got.peak_effort, got.peak_effort_time) == (1 / 512, 0.0)
    assert got.final_value == 1.0


def test_a_lead_starts_high_and_never_goes_below():
    # (1.25 z - 1)/(z - 0.75): 1.25, then down to 1
    got = step_info(Sampled(num=[1.25, -1.0], den=[1, -0.75], dt=0.5))
    assert got.undershoot_pct == 0.0
    assert (got.rise_time, got.settling_time) == (0.0, 4.5)
    assert got.horizon % 0.5 == 0.0


def test_a_dead_time_is_late_with_everything_but_the_rise():
    # s/(s + 1)^2: t exp(-t), 1/e at 1
    got = step_info(Plant(num=[1, 0], den=[1, 2, 1], dead_time=2.0))
    assert got.peak_time == pytest.approx(3.0, rel=1e-7)  # a flat top
    prompt = step_info(Plant(num=[1, 0], den=[1, 2, 1]))
    assert got.horizon == pytest.approx(prompt.horizon + 2.0, rel=1e-15)
    assert (got.peak, got.final_value, got.steady_state_error) == (prompt.peak, 0.0, 1.0)
    # -s/(s + 1)^2: the same, upside down
    down = step_info(Plant(num=[-1, 0], den=[1, 2, 1], dead_time=2.0))
    assert (down.peak, down.peak_time) == (got.peak, got.peak_time)
    # a resonance: pi/w, later
    swings = step_info(Plant(num=[1.01], den=[1, 0.2, 1.01], dead_time=2.0))
    assert swings.peak_time == pytest.approx(2.0 + 3.141592653589793, rel=1e-7)  # a flat top


def test_delays_of_a_sampled_system_count():
    late = step_info(Sampled(num=[1.25, -1.0], den=[1, -0.75, 0, 0, 0], dt=0.5))
    assert (late.peak_time, late.settling_time, late.rise_time) == (1.5, 6.0, 0.0)


def test_the_first_sample_is_high_enough_at_once():
    # (2 s + 1)/(s + 1) = 1 + s/(s + 1): jumps to 2, falls to 1 by exp(-t), within 2 % at ln 50
    got = step_info(Plant(num=[2, 1], den=[1, 1]))
    assert (got.peak, got.peak_time, got.rise_time) == (2.0, 0.0, 0.0)
    assert got.overshoot_pct == pytest.approx(100.0, rel=1e-14)
    assert got.settling_time == pytest.approx(log(50), rel=1e-12)
    assert got.undershoot_pct == 0.0


def test_jumps_between_the_samples_of_a_loop_in_their_units():
    """1 + 1/(s + 1) under 0.25/(z - 1), dt 1/2: y = u + x jumps at every sample."""
    plant, controller = Plant(num=[1, 2], den=[1, 1]), Sampled(num=[0.25], den=[1, -1], dt=0.5)
    got = closed_loop_step(plant, controller)
    fall, x, u, y, limits = exp(-0.5), 0.0, 0.0, [], []
    for _ in range(100):
        y.append(x + u)
        x, u_old = fall * x + (1 - fall) * u, u
        limits.append(x + u_old)  # just before the next sample
        u += 0.25 * (1 - y[-1])
    assert got.between_samples.peak == pytest.approx(max(*y, *limits), rel=1e-12)
    # y(1) = 0.25 at once: 10 % is reached by the jump at 0.5 s
    ninety = next(k for k in range(100) if y[k] >= 0.9 or limits[k] >= 0.9)
    assert got.rise_time == pytest.approx(0.5 * next(
        k for k in range(100) if y[k] >= 0.9) - 0.5, rel=1e-14)  # fmt: skip
    inside = y[ninety] < 0.9
    low = got.between_samples.rise_time + 0.5
    assert 0.5 * ninety - 1e-12 <= low <= 0.5 * (ninety + inside) + 1e-12


def test_a_gain_alone_is_there_at_once():
    got = step_info(Plant(num=[3], den=[2]))
    assert (got.peak, got.rise_time, got.settling_time) == (1.5, 0.0, 0.0)
    assert (got.overshoot_pct, got.undershoot_pct, got.final_value) == (0.0, 0.0, 1.5)
    got = step_info(Sampled(num=[3], den=[2], dt=0.1))
    assert (got.peak, got.rise_time, got.settling_time) == (1.5, 0.0, 0.0)


def test_the_reference_is_one_unless_asked():
    got = closed_loop_step(INTEGRATOR, HALF)
    assert (got.final_value, got.peak, got.peak_effort) == (1.0, 1.0, 0.5)
    assert got.horizon % 0.5 == 0.0
    assert got.effort_range == (0.0, 0.5)
    # u falls monotonously: asked for at once
    assert got.peak_effort_time == 0.0


def test_an_effort_that_is_only_approached_has_no_time():
    # 1/(s + 1) is over in a sample of 8 s: u(k+1) = 31/32 u(k) + (1 - u(k-1))/64 creeps up to 1/3
    creeping = closed_loop_step(
        Plant(num=[1], den=[1, 1]), Sampled(num=[1 / 64], den=[1, -31 / 32], dt=8.0)
    )
    assert creeping.peak_effort == pytest.approx(1 / 3, rel=1e-12)
    assert creeping.peak_effort_time is None
    assert creeping.peak_time is None


def test_an_effort_that_is_largest_later():
    # one sample of 1/2, then 1: u(k) = e(k) + e(k-1), over 2 of 1/s at dt 1/4
    fir = Sampled(num=[0.5, 0.5], den=[1, 0], dt=0.25)
    got = closed_loop_step(INTEGRATOR, fir, reference=-4.0)
    # y(1) = 1/8, so u(1) = (7/8 + 1)/2, and less ever after
    assert got.peak_effort == pytest.approx(4 * 15 / 16, rel=1e-14)
    assert got.peak_effort_time == 0.25
    assert got.effort_range == pytest.approx((-3.75, 0.0), rel=1e-14)


def test_a_loop_that_comes_back_to_nothing_in_the_size_of_its_reference():
    # s/(s + 1) under 1/2, dt ln 2: y answers u = (r - y)/2 at once, y(0) = 1/3 r
    got = closed_loop_step(
        Plant(num=[1, 0], den=[1, 1]), Sampled(num=[0.5], den=[1], dt=log(2)), reference=-3.0
    )
    assert (got.peak, got.peak_time) == (pytest.approx(1.0, rel=1e-14), 0.0)
    assert (got.final_value, got.steady_state_error) == (0.0, -3.0)
    assert (got.between_samples.peak, got.between_samples.peak_time) == (got.peak, 0.0)
    assert got.settling == "settles to 0"


def test_a_bump_that_stays_just_below_a_tenth_is_no_rise():
    """0.178 t exp(-2 t/3), 0.09995 at its top with all else, beside 1 - exp(-t/1000).

    Its bound between samples is above a tenth, and only the second goes on. A thousandth of
    exp(-t) sets the clock.
    """
    bump, slow, quick = [1, 4 / 3, 4 / 9], [1000, 1], [1, 1]
    terms = [
        np.polymul([0.178, 0], np.polymul(slow, quick)),
        np.polymul(bump, quick),
        np.polymul([0.001, 0], np.polymul(bump, slow)),
    ]
    num = np.polyadd(np.polyadd(terms[0], terms[1]), terms[2])
    got = step_info(Plant(num=num, den=np.polymul(np.polymul(bump, slow), quick)))
    assert got.rise_time == pytest.approx(1000 * log(9), rel=1e-12)
    assert got.settling_time == pytest.approx(1000 * log(50), rel=1e-12)
    assert (got.overshoot_pct, got.undershoot_pct, got.peak_time) == (0.0, 0.0, None)


@pytest.mark.parametrize("zeta", [0.3, 1.5])
def test_upside_down_between_the_samples(zeta):
    up = step_info(Plant(num=[3], den=[1, 2 * zeta, 1]))
    down = step_info(Plant(num=[-3], den=[1, 2 * zeta, 1]))
    for name in ("rise_time", "settling_time", "overshoot_pct", "undershoot_pct", "peak"):
        assert getattr(down, name) == getattr(up, name)
    assert (down.peak_time, down.final_value) == (up.peak_time, -3.0)
    assert down.steady_state_error == 4.0


def test_what_the_module_gives_out():
    given = {}
    exec("from zoh.analysis.step import *", given)
    assert {"closed_loop_step", "step_info"} <= set(given)
    assert given["closed_loop_step"](INTEGRATOR, HALF).peak_effort == 0.5


@pytest.mark.parametrize("zeta", [1e-4, 1e-6])
def test_the_first_of_very_many_crests_is_the_highest(zeta):
    """1/(s^2 + 2 zeta s + 1): at pi/sqrt(1 - zeta^2) = 3141.59 samples the highest one."""
    found = step_info(zoh.sample(Plant(num=[1], den=[1, 2 * zeta, 1]), 1e-3))
    w, t = sqrt(1 - zeta**2), 3.142
    wanted = -100 * exp(-zeta * t) * (cos(w * t) + zeta / w * sin(w * t))
    assert found.overshoot_pct == pytest.approx(wanted, rel=1e-9)
    assert found.peak_time == pytest.approx(round(pi / 1e-3) * 1e-3, rel=1e-12)


@pytest.mark.parametrize(
    ("num", "den"),
    [
        ([1], [1e-320, 1]),  # a pole at -1e320 rad/s
        ([1], [1, 1e-320]),  # one whose time constant is no float
        ([1e300], [1e-320, 1e-320]),  # a gain of 1e620
        ([1.7e308], [1, 0.01, 1]),  # one that floats hold, but not its first crest
    ],
)
def test_a_plant_beyond_floats_is_refused_in_one_line_and_without_a_warning(num, den):
    with (
        warnings.catch_warnings(action="error"),
        pytest.raises(SpecError, match=r"^system must have rates and gains that 64-bit") as told,
    ):
        step_info(Plant(num=num, den=den))
    assert all(repr(float(c)) in str(told.value.value) for c in (*num, *den))
    assert told.value.way_out.startswith("count time")
    assert told.value.way_out.endswith("unit")


def test_the_least_floats_are_a_plant_as_any_other():
    """5e-324/(5e-324 s + 5e-324) = 1/(s + 1): ln 9 from 10 to 90 %, ln 50 to 2 %."""
    with warnings.catch_warnings(action="error"):
        got = step_info(Plant(num=[5e-324], den=[5e-324, 5e-324]))
    assert got.rise_time == pytest.approx(log(9), rel=1e-13)
    assert got.settling_time == pytest.approx(log(50), rel=1e-13)


def test_the_peak_of_a_plant_upside_down_is_a_size():
    """-1/(s^2 + 0.4 s + 1) under P 1/2 ends at -1 and goes to 1.37 on that side."""
    plant, half = Plant(num=[-1], den=[1, 0.4, 1]), Sampled(num=[0.5], den=[1], dt=0.1)
    got = closed_loop_step(plant, half)
    lowest = float(np.min(trace(plant, half, t_end=40.0).y))
    assert got.final_value == pytest.approx(-1.0, rel=1e-13)
    assert lowest < -1.37
    assert got.peak == pytest.approx(-lowest, rel=1e-12)
    twice = closed_loop_step(plant, half, reference=-2.0)
    assert twice.peak == pytest.approx(2 * got.peak, rel=1e-15)


@pytest.mark.parametrize("late", [-0.5, "0.1", None])
def test_a_delay_that_is_none_is_refused_by_its_name(late):
    for ask in (closed_loop_step, closed_loop):
        with pytest.raises(SpecError) as told:
            ask(INTEGRATOR, HALF, compute_delay=late)
        assert told.value.argument == "compute_delay"
        assert told.value.value == late
        assert "0 or more" in told.value.way_out


@pytest.mark.parametrize(("share", "settled"), [(0.01, 7.0), (0.0118, None)])
def test_in_its_band_but_not_at_rest_is_settled_where_it_stays_there(monkeypatch, share, settled):
    """1 - 2^-k beside a swing that lives for a million samples: in 2 % from k = 7.

    The swing is share sin(0.7 (k + 1))/sin(0.7): of 0.0155, which stays in 2 %, or of 0.0183, so
    near to it that it might not. It is followed for 500 samples alone.
    """
    size, angle = 1 - 1e-6, 0.7
    swing = np.array([1.0, -2 * size * cos(angle), size * size])
    num = np.polyadd(np.polymul([0.5], swing), share * np.polymul([1.0, -1.0, 0.0], [1.0, -0.5]))
    system = Sampled(num=num, den=np.polymul(swing, [1.0, -0.5]), dt=1.0)
    monkeypatch.setattr(motion, "_MOST", 500)
    got = step_info(system)
    assert got.horizon < 1000
    assert got.settling_time == settled
    if settled is None:
        assert got.settling == f"not at rest by {got.horizon:.4g} s"


def test_what_is_at_rest_but_for_less_than_a_float_tells_is_not_in_its_band():
    """(s + 1e-15)/(s + 1)^2: t exp(-t) beside 1e-15, and within 2e-17 of it after 42 s alone."""
    got = step_info(Plant(num=[1.0, 1e-15], den=[1.0, 2.0, 1.0]))
    assert got.horizon < 42
    assert got.final_value == pytest.approx(1e-15, rel=1e-12, abs=0)
    assert got.settling_time is None


def test_a_mode_alone_that_starts_on_the_other_side_is_followed():
    """(1.5 - z)/(z - 0.5): 1 - 2 2^-k, so -1, 0, 1/2, 3/4, 7/8, 15/16, 31/32, 63/64."""
    got = step_info(Sampled(num=[-1.0, 1.5], den=[1.0, -0.5], dt=1.0))
    assert (got.rise_time, got.settling_time) == (3.0, 7.0)
    assert got.undershoot_pct == pytest.approx(100.0, rel=1e-14)


def test_a_fast_lag_is_followed_in_its_own_time():
    """1000/(s + 1000): a ten billionth is left after 23 ms."""
    got = step_info(Plant(num=[1000], den=[1, 1000]))
    assert log(1e10) <= 1000 * got.horizon <= 3 * log(1e10)
    assert got.rise_time == pytest.approx(log(9) / 1000, rel=1e-12)


def test_a_feedforward_adds_its_answer():
    """1/(s + 1) at dt = ln 2 under u = (r - y)/2 + r: y(k+1) = 3/4 + y(k)/4, so 1 - 4^-k."""
    plant, dt = Plant(num=[1], den=[1, 1]), log(2)
    half, ahead = (Sampled(num=[gain], den=[1], dt=dt) for gain in (0.5, 1.0))
    got = closed_loop_step(plant, half, feedforward=ahead)
    assert got.final_value == pytest.approx(1.0, rel=1e-14)
    assert (got.rise_time, got.settling_time) == pytest.approx((dt, 3 * dt), rel=1e-14)
    assert (got.peak_effort, got.peak_effort_time) == (pytest.approx(1.5, rel=1e-14), 0.0)
    assert got.effort_range == pytest.approx((1.0, 1.5), rel=1e-14)


def test_the_largest_effort_may_be_below_zero():
    """-1/(s + 1) under -1/2, dt = ln 2: u begins at -1/2 and ends at -1/3."""
    got = closed_loop_step(Plant(num=[-1], den=[1, 1]), Sampled(num=[-0.5], den=[1], dt=log(2)))
    assert (got.peak_effort, got.peak_effort_time) == (0.5, 0.0)
    assert got.final_value == pytest.approx(1 / 3, rel=1e-14)


def test_a_feedforward_of_its_own_poles_counts_with_its_gain_at_rest():
    """(z^2 + 1)/(z^2 - z + 1/2) is 4 at z = 1: y = u = (1/2 + 4)/(1 + 1/2) of 1/(s + 1), 2 off."""
    half = Sampled(num=[0.5], den=[1], dt=0.25)
    ahead = Sampled(num=[1, 0, 1], den=[1, -1, 0.5], dt=0.25)
    found = gains_at_rest(Plant(num=[1], den=[1, 1]), half, ahead)
    assert found == pytest.approx((3.0, 3.0, -2.0), rel=1e-14)


@pytest.mark.parametrize("most", [1, 4])
def test_what_is_not_followed_to_nine_tenths_has_no_rise(monkeypatch, most):
    """1 - 2^-k is 0, 1/2, 3/4 and 7/8 in the first four samples."""
    monkeypatch.setattr(motion, "_MOST", most)
    got = step_info(Sampled(num=[0.5], den=[1, -0.5], dt=1.0))
    assert (got.rise_time, got.settling_time) == (None, None)


def test_the_highest_between_samples_of_a_long_response_whose_slope_leaps():
    """Of 5349 samples few are shown; each has a crest of its own, the highest is that of 324.

    y = b0 x1 + b1 x2 by exact motion in 30 digits, the crest by halving its slope.
    """
    b1, b0, a1, a0 = map(mpf, (1.2782983136859838, 0.005649449024469331, 1.2806217912250752,
                               0.006687310339926369))  # fmt: skip
    law = Sampled(
        num=[0.6390686584931605, -0.5985520755907452], den=[1.0, -0.9953759112473269], dt=1.0
    )
    plant = Plant(num=[float(b1), float(b0)], den=[1.0, float(a1), float(a0)])
    (n1, n0), (_, d0) = [map(mpf, c) for c in (law.num, law.den)]
    with mp.workdps(30):
        a, out = mp.matrix([[0, 1, 0], [-a0, -a1, 1], [0, 0, 0]]), mp.matrix([[b0, b1, 0]])
        step, x, error, before = mp.expm(a), mp.matrix([0, 0, 0]), mpf(0), mpf(0)
        best = (mpf(0), mpf(0))
        for k in range(330):
            last, error = error, 1 - (out * x)[0]
            x[2] = before = n1 * error + n0 * last - d0 * before
            if k >= 320:
                low, high = mpf(0), mpf(1)
                for _ in range(60):
                    middle = (low + high) / 2
                    rises = (out * a * mp.expm(a * middle) * x)[0] > 0
                    low, high = (middle, high) if rises else (low, middle)
                best = max(best, ((out * mp.expm(a * low) * x)[0], k + low))
            x = step * x
        final = b0 * (n1 + n0) / (b0 * (n1 + n0) + a0 * (1 + d0))
        over, when = float(100 * (best[0] / final - 1)), float(best[1])
    found = zoh.measure(plant, law).step.between_samples
    # 1e-8: of the 14 digits of y the overshoot, 2.6e-4 of it, has ten
    assert found.overshoot_pct == pytest.approx(over, rel=1e-8)
    assert found.peak_time == pytest.approx(when, rel=1e-6)  # the top is flat
    assert int(when) == 324


@pytest.mark.filterwarnings("ignore::zoh.AccuracyWarning")  # the hold all but hides the modes
@pytest.mark.parametrize(
    ("num", "den", "controller", "dt"),
    [
        ((1.0, 197.3176, 4141.032), (1.0, 1.1256, 3943.9656, 3943.84), ([0.05, 0.0], [1, -1]), 0.1),
        (
            (1.0, -753.7912918821552, 10145.044516362279),
            (0.2810861446500331, 1.032856712221787, 3605.656526222515, 12827.169545283123),
            ([1.004350886403702], [1.0]),
            0.055477182674623385,
        ),
    ],
)
def test_a_swing_between_the_samples_settles_last(num, den, controller, dt):
    """A mode that turns by nearly 2 pi a sample: few samples show it, and it is 1 % between them.

    The truth is a matrix exponential for each of 400 points of a sample, one step after the other.
    """
    plant, law = Plant(num=num, den=den), Sampled(num=controller[0], den=controller[1], dt=dt)
    found = zoh.measure(plant, law).step
    a, b, c, _ = scipy.signal.tf2ss(num, den)
    n, fine = len(a), 400
    step = scipy.linalg.expm(np.block([[a, b], [np.zeros((1, n + 1))]]) * dt / fine)
    x, u, ys = np.zeros(n), 0.0, []
    for _ in range(int(1.5 * found.between_samples.settling_time / dt)):
        moved = controller[0][0] * (1 - float((c @ x)[0]))
        u = u + moved if len(controller[1]) == 2 else moved
        for _ in range(fine):
            ys.append(float((c @ x)[0]))
            x = step[:n, :n] @ x + step[:n, n] * u
    off = np.abs(np.array(ys) - found.final_value) > 0.02 * abs(found.final_value)
    last = np.flatnonzero(off)[-1] * dt / fine
    assert last <= found.between_samples.settling_time <= last + 1.01 * dt / fine
