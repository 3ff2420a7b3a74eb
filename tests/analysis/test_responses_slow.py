"""responses: slow modes left behind by fast ones, where most samples are left out."""

import json
from math import exp, log
from pathlib import Path

import numpy as np
import pytest
from mpmath import mp, mpf

import zoh

CASES = json.loads((Path(__file__).parents[1] / "oracles" / "response.json").read_text())
FIGURES = [
    pytest.param(case, by, truth, id=f"{by}: {case['name']} {i}")
    for i, case in enumerate(CASES)
    for by, truth in case["responses"].items()
    if truth is not None
]


def loop(case):
    """Return (plant, controller) of a case."""
    plant = zoh.Plant(
        num=case["num"], den=case["den"], dead_time=case["dead_time"], sensor=case["sensor"]
    )
    num, den = case["controller"]
    return plant, zoh.Sampled(num=num, den=den, dt=case["dt"])


@pytest.mark.parametrize(("case", "by", "truth"), FIGURES)
def test_every_figure_of_forty_loops(case, by, truth):
    got = zoh.response(*loop(case), by=by, compute_delay=case["compute_delay"])
    for name in ("peak", "final_value", "settling_time", "peak_effort"):
        assert getattr(got, name) == pytest.approx(float(truth[name]), rel=1e-11), name
    if truth["peak_time"] is None:
        assert got.peak_time is None
    else:  # the time of a flat top: its height to 1e-15 is its time to the root of that
        assert got.peak_time == pytest.approx(float(truth["peak_time"]), rel=1e-7)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_the_noise_of_forty_loops(case):
    found = zoh.noise_gains(*loop(case), compute_delay=case["compute_delay"])
    assert found == pytest.approx([float(x) for x in case["noise"]], rel=1e-12)


def test_there_are_a_hundred_and_twenty():
    assert len(CASES) == 40
    assert len(FIGURES) >= 120
    slow = [t for c in CASES for t in [c["responses"]["disturbance"]] if t["final_value"] == "0.0"]
    assert len(slow) >= 12


@pytest.mark.parametrize("left", [1e-2, 1e-3, 1e-6, 1e-9, 1e-11])
def test_a_disturbance_that_a_slow_integral_takes_away(left):
    """1/(s + 1) under 1 + left/(z - 1): two modes in closed form, each a root of a square."""
    zero = 1 - left
    got = zoh.response(
        zoh.Plant(num=[1], den=[1, 1]), zoh.Sampled(num=[1, -zero], den=[1, -1], dt=0.1),
        by="disturbance",
    )  # fmt: skip
    with mp.workdps(50):
        dt = mpf(0.1)
        a = mp.exp(-dt)
        b = 1 - a
        # (z - 1)(z - a) + b (z - zero) = z^2 + p z + q, y(k) = b (slow^k - fast^k)/root
        p, q = b - 1 - a, a - b * mpf(zero)
        root = mp.sqrt(p * p - 4 * q)
        slow, fast = (root - p) / 2, (-root - p) / 2
        peak = max(b * (slow**k - fast**k) / root for k in range(1, 200))
        band = peak / 50
        # the fast mode is gone; y goes from the last sample outside for what it is held at
        k = int(mp.log(band * root / b) / mp.log(slow))
        y, after = (b * slow**i / root for i in (k, k + 1))
        held = (after - a * y) / b
        settled = k * dt - mp.log((band - held) / (y - held))
    assert got.peak == pytest.approx(float(peak), rel=1e-13)
    assert got.settling_time == pytest.approx(float(settled), rel=1e-12)
    assert got.settling_time > 7.8 / left * 0.1


def test_a_late_impulse_on_an_integrator_piece_by_piece():
    """1/s behind half a sample under P 1/2: y goes straight from corner to corner."""
    dt, y, u_old, corners = 0.1, 0.0, 0.0, [(0.0, 0.0)]
    for k in range(400):
        u = 0.5 * ((k == 0) - y)
        y += dt / 2 * u_old
        corners.append(((k + 0.5) * dt, y))
        y += dt / 2 * u
        corners.append(((k + 1) * dt, y))
        u_old = u
    peak = max(y for _, y in corners)
    i = max(i for i, (_, y) in enumerate(corners) if y > peak / 50)
    (t, above), (t_next, below) = corners[i], corners[i + 1]
    settled = t + (t_next - t) * (above - peak / 50) / (above - below)
    got = zoh.response(
        zoh.Plant(num=[1], den=[1, 0]), zoh.Sampled(num=[0.5], den=[1], dt=dt), by="impulse",
        compute_delay=0.05,
    )  # fmt: skip
    assert got.peak == pytest.approx(peak, rel=1e-13)
    assert got.settling_time == pytest.approx(settled, rel=1e-12)


def test_the_band_is_that_of_the_peak_not_of_the_end():
    """1/(s^2 + s/10 + 1) under P 1/2: the peak is twice the end, and so is the band."""
    plant, controller = (
        zoh.Plant(num=[1], den=[1, 0.1, 1]), zoh.Sampled(num=[0.5], den=[1], dt=0.01)
    )  # fmt: skip
    got = zoh.response(plant, controller, by="step")
    curve = zoh.trace(plant, controller, t_end=120.0)
    peak = curve.y_between.max()
    outside = np.abs(curve.y_between - 1 / 3) > 0.02 * peak
    last = curve.t_between[outside.nonzero()[0][-1]]
    assert last <= got.settling_time <= last + 0.01  # from one point drawn to the next
    assert got.settling_time > 66.9


@pytest.mark.parametrize(("gain", "settles"), [(0.1, True), (0.5, False)])
def test_the_error_under_a_ramp_of_a_loop_that_ripples(gain, settles):
    """1/(s + 1) under an integral at dt 1: u is a staircase for ever, y goes in arcs.

    At rest y(k + t) = y(k) + (1 - exp(-t))/(1 - exp(-1)), so the error dips between two samples
    by 0.123 below what it is at them, 1/gain.
    """
    got = zoh.response(
        zoh.Plant(num=[1], den=[1, 1]), zoh.Sampled(num=[gain], den=[1, -1], dt=1.0), by="ramp"
    )
    t = -log(1 - exp(-1))
    dip = (1 - exp(-t)) / (1 - exp(-1)) - t
    assert dip == pytest.approx(0.1233, abs=1e-4)  # as far as it is written above
    assert got.final_value == pytest.approx(1 / gain, rel=1e-12)
    assert (dip < 0.02 * got.peak) is settles
    assert (got.settling_time is not None) is settles


def test_the_peak_of_a_ripple_that_is_approached():
    """1/(s + 1)^2 under a weak integral: y goes in S's, and the error rises above its samples."""
    got = zoh.response(
        zoh.Plant(num=[1], den=[1, 2, 1]), zoh.Sampled(num=[0.05], den=[1, -1], dt=1.0), by="ramp"
    )
    with mp.workdps(30):
        flow = mp.matrix([[-1, 0, 1], [1, -1, 0], [0, 0, 0]])  # x' = u - x, y' = x - y, u'= 0
        over = mp.expm(flow)
        # at rest x(1) = x + 1 and y(1) = y + 1 with u = 0 at first: two equations
        own = over[:2, :2] - mp.eye(2)
        x = mp.lu_solve(own, mp.matrix([1, 1]))
        z = mp.matrix([x[0], x[1], 0])

        def error(t):
            return t - ((mp.expm(flow * t) * z)[1] - z[1])

        def slope(t):
            return 1 - (flow * mp.expm(flow * t) * z)[1]

        times = [mpf(i) / 20 for i in range(21)]
        top = max(times, key=error)
        ripple = error(mp.findroot(slope, top))
    assert ripple > 1e-3
    assert got.final_value == pytest.approx(20.0, rel=1e-12)
    # 1e-7: followed until a hundred millionth of the slowest mode is left
    assert got.peak == pytest.approx(20 + float(ripple), rel=1e-7)
    assert got.peak_time is None


def test_a_peak_at_the_start_of_what_only_creeps_has_its_time():
    """(s + 0.99)/(s + 1) under P 1: y is 1/2 at once and creeps to 0.99/1.99."""
    plant = zoh.Plant(num=[1, 0.99], den=[1, 1])
    got = zoh.response(plant, zoh.Sampled(num=[1], den=[1], dt=0.1), by="step")
    assert (got.peak, got.peak_time) == (pytest.approx(0.5, rel=1e-14), 0.0)
    assert got.final_value == pytest.approx(0.99 / 1.99, rel=1e-13)
    assert got.settling_time == 0.0
