"""responses: every figure of loops that halve their distance, and every word of the refusals.

1/s under P 1/2 at dt 1: y goes straight from sample to sample, and what is left halves.
"""

from math import exp, inf, sqrt

import numpy as np
import pytest

import zoh
from zoh.analysis import responses
from zoh.analysis.closed import closed_loop
from zoh.analysis.responses import Response

INTEGRATOR = zoh.Plant(num=[1], den=[1, 0])
HALF = zoh.Sampled(num=[0.5], den=[1], dt=1.0)

# step         y = 1 - 2^-k                     2 % of 1 between 5 and 6: 5.72
# impulse      y = 0, 1/2, 1/4, ...             2 % of 1/2 between 6 and 7: 6.72; u(0) = 1/2
# disturbance  y = 2 (1 - 2^-k), u = -y/2       as the step, twice as large
# ramp         k - y = 0, 1, 3/2, 7/4, ... 2    0.04 of 2 between 6 and 7, u -> 1
FIGURES = [
    ("step", 1.0, None, 1.0, 5.72, 0.5),
    ("impulse", 0.5, 1.0, 0.0, 6.72, 0.5),
    ("disturbance", 2.0, None, 2.0, 5.72, 1.0),
    ("ramp", 2.0, None, 2.0, 5.72, 1.0),
]


@pytest.mark.parametrize(("by", "peak", "when", "final", "settled", "effort"), FIGURES)
def test_all_figures_by_hand(by, peak, when, final, settled, effort):
    got = zoh.response(INTEGRATOR, HALF, by=by)
    assert got == Response(
        excitation=by,
        peak=pytest.approx(peak, rel=1e-13),
        peak_time=when,
        final_value=final,
        settling_time=pytest.approx(settled, rel=1e-13),
        peak_effort=pytest.approx(effort, rel=1e-13),
        horizon=got.horizon,
    )
    assert got.horizon in range(27, 60)  # 2^-27 is below 1e-8


def test_half_a_clock_halves_the_times_alone():
    half = zoh.response(
        zoh.Plant(num=[2], den=[1, 0]), zoh.Sampled(num=[0.5], den=[1], dt=0.5), by="step"
    )
    one = zoh.response(INTEGRATOR, HALF, by="step")
    assert half.horizon == one.horizon / 2
    assert half.settling_time == one.settling_time / 2


def test_a_controller_that_is_none_is_refused_in_words():
    with pytest.raises(zoh.SpecError) as err:
        zoh.response(INTEGRATOR, 7, by="step")
    assert str(err.value) == ("controller must be a zoh.Sampled, got 7: give num, den and dt")


def test_what_grows_without_end():
    lag = zoh.Plant(num=[1], den=[1, 1])
    assert zoh.response(lag, HALF, by="ramp") == Response(
        excitation="ramp", peak=inf, peak_time=None, final_value=inf, settling_time=None,
        peak_effort=inf, horizon=None,
    )  # fmt: skip


# P(0) = 5 (1/2)/2 = 5/4 with a third coefficient, C(1) = (2 - 1)/(1 - 0.6) = 5/2; 1 + C P = 33/8
PLANT = zoh.Plant(num=[0.25, 5], den=[1, 3, 2], sensor=0.5)
FILTER = zoh.Sampled(num=[2, -1], den=[1, -0.6], dt=0.125)


def test_what_a_loop_without_an_integrator_comes_to():
    step = zoh.response(PLANT, FILTER, by="step")
    assert step.final_value == pytest.approx(25 / 33, rel=1e-13)
    disturbed = zoh.response(PLANT, FILTER, by="disturbance")
    assert disturbed.final_value == pytest.approx(10 / 33, rel=1e-13)
    assert zoh.response(PLANT, FILTER, by="impulse").final_value == 0.0
    assert zoh.response(PLANT, FILTER, by="ramp").final_value == inf
    # an effort that is approached: nothing overshoots under a small gain on a slow clock
    slow = zoh.Sampled(num=[0.5], den=[1], dt=40.0)  # C P = 5/8
    # u = 0.5 (1 - y): 0.5 first, then 0.5 (1 - 5/16), ... around 0.5/(1 + 5/8)
    assert zoh.response(PLANT, slow, by="step").peak_effort == 0.5
    # u = -y/2: of all -u the first answer, P(0)/2 = 5/8, is the largest
    assert zoh.response(PLANT, slow, by="disturbance").peak_effort == pytest.approx(
        5 / 8, rel=1e-12
    )


def test_what_a_ramp_leaves_behind():
    # the integral in the controller: C ~ (1/8)/(dt s) = 1/s, P(0) = 5/4, Kv = 5/4
    integral = zoh.Sampled(num=[0.125], den=[1, -1], dt=0.125)
    got = zoh.response(PLANT, integral, by="ramp")
    assert (got.final_value, got.peak_effort) == (pytest.approx(0.8, rel=1e-12), inf)
    assert got.settling_time is not None
    # in the plant: s P -> 5 (1/2)/2, Kv = C(1) 5/4 = 25/8; u comes to 4/5
    plant = zoh.Plant(num=[5], den=[1, 2, 0], sensor=0.5)
    got = zoh.response(plant, FILTER, by="ramp")
    assert got.final_value == pytest.approx(8 / 25, rel=1e-12)
    assert 0.8 <= got.peak_effort < inf
    # in both: nothing is left
    both = zoh.Sampled(num=[0.5, -0.49], den=[1, -1], dt=0.125)
    assert zoh.response(plant, both, by="ramp").final_value == 0.0
    # a double integrator in the plant: nothing is left, and nothing needed to keep going
    double = zoh.Plant(num=[1], den=[1, 0, 0])
    lead = zoh.Sampled(num=[10.0, -9.9], den=[1, 0], dt=0.125)
    got = zoh.response(double, lead, by="ramp")
    assert got.final_value == 0.0
    assert got.peak_effort < inf


def test_the_error_under_a_ramp_peaks_between_the_samples_of_a_late_loop():
    """1/s, a quarter of a sample late, under P 3/4: straight between k and k + 1/4."""
    plant = zoh.Plant(num=[1], den=[1, 0], dead_time=0.25)
    got = zoh.response(plant, zoh.Sampled(num=[0.75], den=[1], dt=1.0), by="ramp")
    e, t, y, u_old = [(0.0, 0.0)], 0, 0.0, 0.0
    for k in range(200):
        u = 0.75 * (k - y)
        y += 0.25 * u_old
        e.append((k + 0.25 - y, k + 0.25))
        y += 0.75 * u
        e.append((k + 1 - y, float(k + 1)))
        u_old = u
    peak, t = max(e)
    assert t % 1 == 0.25
    assert (got.peak, got.peak_time) == (
        pytest.approx(peak, rel=1e-13),
        pytest.approx(t, rel=1e-13),
    )
    assert got.final_value == pytest.approx(4 / 3, rel=1e-13)


@pytest.mark.parametrize("by", zoh.EXCITATIONS)
def test_a_delay_is_the_same_wherever_it_is(by):
    plant = zoh.Plant(num=[1], den=[1, 0], dead_time=0.375)
    late = zoh.response(plant, HALF, by=by)
    computed = zoh.response(INTEGRATOR, HALF, by=by, compute_delay=0.375)
    if by == "disturbance":  # it acts behind the dead time, whatever the delay
        assert late.final_value == computed.final_value
    else:
        assert late == computed
    assert zoh.noise_gains(plant, HALF) == zoh.noise_gains(INTEGRATOR, HALF, compute_delay=0.375)
    curve = zoh.response_trace(INTEGRATOR, HALF, by=by, t_end=3.0, compute_delay=0.375)
    assert len(curve.t_between) == 4 * 22  # two stretches of 11 points


LATE, GAIN = 70, 2.0**-8


def late_loop(by, count):
    """Return (y or the ramp's error, u) of 1/s, 70 samples late, under P 1/256."""
    y, u, out = 0.0, [], []
    for k in range(count):
        r = {"step": 1.0, "impulse": float(k == 0), "ramp": float(k)}.get(by, 0.0)
        u.append(GAIN * (r - y))
        out.append(k - y if by == "ramp" else y)
        y += (u[k - LATE] if k >= LATE else 0.0) + (by == "disturbance")
    return out, u


@pytest.mark.parametrize(
    ("by", "final", "limit"),
    [("step", 1.0, 0.0), ("impulse", 0.0, 0.0), ("disturbance", 256.0, -1.0), ("ramp", 256.0, 1.0)],
)
def test_a_loop_that_waits_long_by_recursion(by, final, limit):
    plant = zoh.Plant(num=[1], den=[1, 0], dead_time=float(LATE))
    got = zoh.response(plant, zoh.Sampled(num=[GAIN], den=[1], dt=1.0), by=by)
    out, u = late_loop(by, 4000)
    assert got.final_value == final
    assert got.peak == pytest.approx(max(*map(abs, out), abs(final)), rel=1e-11)
    assert got.peak_effort == pytest.approx(max(*map(abs, u), abs(limit)), rel=1e-11)
    band = 0.02 * got.peak
    last = max(k for k, y in enumerate(out) if abs(y - final) > band)
    edge = final + (band if out[last] > final else -band)
    part = (edge - out[last]) / (out[last + 1] - out[last])  # straight in between
    assert got.settling_time == pytest.approx(last + part, rel=1e-11)


def test_noise_through_a_long_delay_that_never_rests(monkeypatch):
    plant = zoh.Plant(num=[1], den=[1, 0], dead_time=float(LATE) / 4)
    monkeypatch.setattr(responses.queue, "_MOST", 640)
    with pytest.raises(zoh.SpecError) as err:
        zoh.noise_gains(plant, zoh.Sampled(num=[GAIN], den=[1], dt=0.25))
    assert str(err.value) == (
        "controller must bring a loop with so long a delay to rest in a million samples, "
        "got '159.8 s': sample more slowly"
    )


@pytest.mark.parametrize("ask", ["response", "noise"])
def test_an_unstable_loop_is_refused_in_words(ask):
    loud = zoh.Sampled(num=[2.5], den=[1], dt=1.0)
    with pytest.raises(zoh.SpecError) as err:
        zoh.response(INTEGRATOR, loud, by="step") if ask == "response" else zoh.noise_gains(
            INTEGRATOR, loud
        )
    assert str(err.value) == (
        "controller must make the closed loop stable, got 'an unstable loop': change its gains"
    )
    assert zoh.noise_gains(INTEGRATOR, HALF) == pytest.approx((sqrt(1 / 3), sqrt(1 / 3)), rel=1e-13)


def test_the_sum_of_squares_of_output_and_effort_by_hand():
    # x(k+1) = x/2 + r/2, r 1 at k = 0 alone: y = x, u = (r - x)/2; 1/3, and 1/4 + (1/4)(1/3)
    motion = closed_loop(INTEGRATOR, HALF, by="impulse")
    start = np.array([0.0, 1.0, 0.0])  # (x, r, 1), the 1 left out
    assert motion.powers.sum_of_squares(start) == pytest.approx([1 / 3, 1 / 3], rel=1e-14)


def test_a_late_loop_whose_effort_grows_is_waited_for_all_the_same():
    # 1/(s + 1), 70 samples late, under (1/512)/(z - 1): Kv = 1/512, and u must grow with the ramp
    plant = zoh.Plant(num=[1], den=[1, 1], dead_time=float(LATE))
    got = zoh.response(plant, zoh.Sampled(num=[1 / 512], den=[1, -1], dt=1.0), by="ramp")
    assert got.final_value == pytest.approx(512.0, rel=1e-12)
    assert got.peak_effort == inf
    assert 0 < got.settling_time < got.horizon < 20_000


def test_what_was_not_followed_to_its_rest_has_not_settled(monkeypatch):
    # it is within 2 % for good after 1200 samples, and at rest after 2600
    plant = zoh.Plant(num=[1], den=[1, 0], dead_time=float(LATE))
    controller = zoh.Sampled(num=[GAIN], den=[1], dt=1.0)
    assert zoh.response(plant, controller, by="step").settling_time < 1500
    monkeypatch.setattr(responses.queue, "_MOST", 1600)
    assert zoh.response(plant, controller, by="step").settling_time is None


def test_below_zero_is_a_peak_as_well():
    down = zoh.Plant(num=[-1], den=[1, 0])
    got = zoh.response(down, zoh.Sampled(num=[-0.5], den=[1], dt=1.0), by="disturbance")
    assert (got.final_value, got.peak) == (-2.0, 2.0)
    assert zoh.response(INTEGRATOR, HALF, by="step").peak == 1.0


def test_twenty_points_a_sample_unless_asked():
    assert len(zoh.response_trace(INTEGRATOR, HALF, by="step", t_end=1.0).t_between) == 2 * 21
    few = zoh.response_trace(INTEGRATOR, HALF, by="step", t_end=1.0, per_sample=3)
    assert len(few.t_between) == 2 * 4


def test_a_delay_of_the_computer_can_make_a_loop_unstable():
    # 1.5/(z - 1) has its pole at -1/2; 1.5/(z (z - 1)) has two of size sqrt(1.5)
    loud = zoh.Sampled(num=[1.5], den=[1], dt=1.0)
    assert zoh.response(INTEGRATOR, loud, by="step").final_value == 1.0
    with pytest.raises(zoh.SpecError, match="must make the closed loop stable"):
        zoh.response(INTEGRATOR, loud, by="step", compute_delay=1.0)


def test_an_effort_that_creeps_up_to_its_end():
    # 2/(s^2 + 3 s + 2) is over in a sample of 20 s: u(k+1) = 31/32 u(k) + (1 - u(k-1))/64 -> 1/3
    plant = zoh.Plant(num=[2], den=[1, 3, 2])
    slow = zoh.Sampled(num=[1 / 64], den=[1, -31 / 32], dt=20.0)
    got = zoh.response(plant, slow, by="step")
    assert got.peak_effort == pytest.approx(1 / 3, rel=1e-13)
    assert got.final_value == pytest.approx(1 / 3, rel=1e-13)


def test_a_table_has_no_response_in_time():
    table = zoh.FrequencyResponse(w=[1, 2, 4], magnitude=[1, 0.5, 0.25], phase_deg=[-90] * 3)
    for ask in (
        lambda: zoh.response(table, HALF, by="step"),
        lambda: zoh.noise_gains(table, HALF),
        lambda: zoh.trace(table, HALF, t_end=1.0),
    ):
        with pytest.raises(zoh.SpecError) as said:
            ask()
        assert str(said.value).startswith(
            "plant must be a zoh.Plant, for a table has no response in time, got FrequencyResponse("
        )
        assert str(said.value).endswith(
            "a table has margins, peaks and bandwidth: zoh.margins; fit a plant to it for the rest"
        )
    with pytest.raises(zoh.SpecError, match=r"^plant must be a zoh\.Plant, got 3: "):
        zoh.response(3, HALF, by="step")


def test_a_ripple_that_is_approached_rises_above_the_error_at_the_samples():
    """1/(s + 1), half a sample late, under an integral of 1/10: y goes in arcs from k + 1/2 on.

    At rest y(k + 1/2 + t) = y(k + 1/2) + (1 - exp(-t))/(1 - exp(-1)): the error is 10 at the
    samples, and where an arc begins more, by what the arc half way is above its chord.
    """
    late = zoh.Plant(num=[1], den=[1, 1], dead_time=0.5)
    got = zoh.response(late, zoh.Sampled(num=[0.1], den=[1, -1], dt=1.0), by="ramp")
    height = (1 - exp(-0.5)) / (1 - exp(-1)) - 0.5
    assert got.final_value == pytest.approx(10.0, rel=1e-12)
    # 1e-7: followed until a hundred millionth of the slowest mode is left
    assert got.peak == pytest.approx(10 + height, rel=1e-7)
    assert got.peak_time is None


def test_the_final_error_of_a_biproper_plant_under_a_ramp_is_that_at_the_samples():
    # Kv = 0.6/0.1 times P(0) = 0.4: 1/2.4 at each sample; u climbs by 0.1/0.4 there, which comes
    # through at once, so that just before it the error is larger by 0.25, for ever
    plant = zoh.Plant(num=[1, 2], den=[1, 5])
    r = zoh.response(plant, zoh.Sampled(num=[0.5, 0.1], den=[1, -1], dt=0.1), by="ramp")
    assert r.final_value == pytest.approx(1 / 2.4, rel=1e-12)
    assert r.peak == pytest.approx(1 / 2.4 + 0.25, rel=1e-9)
    assert r.peak_time is None  # approached
    assert r.settling_time is None
