"""Stable or not, on both sides of boundaries worked by hand."""

from math import atan, pi, sin, sqrt

import numpy as np
import pytest

from zoh.analysis import stability
from zoh.analysis.certificates import Proof
from zoh.analysis.loop import Loop
from zoh.analysis.nyquist import closed_loop_stable
from zoh.analysis.stability import (
    _none_encircled,
    _slow_crossover,
    _turns,
    decided,
)
from zoh.lti.systems import Plant, Sampled

ROUTH = Proof(holds=True, method="Routh", detail="in whole numbers")


def z_late(num, den, m, dt=0.5):
    """Return num_w/den_w z^-m."""
    return Loop.of(Sampled.from_w(num_w=num, den_w=den, dt=dt, delay=m))


def integrator(gain, m, dt=0.5):
    """gain z^-m/(z - 1), whose poles leave the circle at gain = 2 sin(pi/(4 m + 2))."""
    return z_late((-gain / 2, gain / dt), (1.0, 0.0), m, dt)


@pytest.mark.parametrize("m", [0, 1, 2, 7, 59, 60, 61, 75])
@pytest.mark.parametrize("dt", [0.5, 3.0])
def test_an_integrator_some_samples_late(m, dt):
    limit = 2 * sin(pi / (4 * m + 2))
    assert closed_loop_stable(integrator(0.999 * limit, m, dt))
    assert not closed_loop_stable(integrator(1.001 * limit, m, dt))
    assert not closed_loop_stable(integrator(-0.001, m, dt))


def test_who_decides_by_the_samples_of_delay(monkeypatch):
    asked = []

    def winding(answer):
        monkeypatch.setattr(stability, "_none_encircled", lambda loop: asked.append(loop) or answer)

    winding(True)
    assert decided(integrator(5.0, 10)) == (False, ROUTH)
    assert decided(Loop.of(Plant(num=[1.0], den=[1.0, 1.0]))) == (True, ROUTH)
    assert asked == []
    found, why = decided(integrator(5.0, 11))  # which believes the answer put into its mouth
    assert (found, why.method, why.holds, len(asked)) == (True, "discs", True, 1)
    winding(None)
    assert decided(integrator(5.0, 60)) == (False, ROUTH)
    found, why = decided(integrator(5.0, 61))
    assert (found, why.method, why.holds) == (None, "discs", False)
    assert not closed_loop_stable(integrator(5.0, 61))


def late_lag(turn):
    """Return the gain at which K exp(-s)/(s + 1) has a pair where w + arctan w is that."""
    low, high = 0.0, turn
    for _ in range(100):
        w = (low + high) / 2
        low, high = (w, high) if w + atan(w) < turn else (low, w)
    return sqrt(1 + w * w)


@pytest.mark.parametrize("gain", [1e-5, 1e-12, 1e-30, 1e-100])
def test_a_quiet_integrator_some_time_late(gain):
    """Its slow pole is at -gain, and a hair right of 0 where the gain has the other sign."""
    assert closed_loop_stable(Loop.of(Plant(num=[gain], den=[1.0, 1.0, 0.0], dead_time=0.1)))
    assert not closed_loop_stable(Loop.of(Plant(num=[-gain], den=[1.0, 1.0, 0.0], dead_time=0.1)))
    assert closed_loop_stable(integrator(gain, 100))
    assert not closed_loop_stable(integrator(-gain, 100))


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e5])
def test_a_late_lag_in_any_unit_of_time(scale):
    limit = late_lag(pi)
    for gain, stable in ((0.999 * limit, True), (1.001 * limit, False), (30.0, False), (0.5, True)):
        plant = Plant(num=[gain / scale], den=[1.0, 1 / scale], dead_time=scale)
        assert closed_loop_stable(Loop.of(plant)) is stable
    assert not closed_loop_stable(Loop.of(Plant(num=[-1.001], den=[1.0, 1.0], dead_time=1.0)))
    assert closed_loop_stable(Loop.of(Plant(num=[-0.999], den=[1.0, 1.0], dead_time=1.0)))


@pytest.mark.parametrize(("gain", "stable"), [(0.99, True), (1.0, False), (1.01, False)])
def test_a_gain_with_dead_time_is_stable_below_one(gain, stable):
    for sign in (1, -1):
        assert _none_encircled(Loop.of(Plant(num=[sign * gain], den=[1], dead_time=0.1))) is stable
        lead = Plant(num=[sign * gain, 0.5], den=[1.0, 1.0], dead_time=0.1)
        assert _none_encircled(Loop.of(lead)) is stable


def test_modes_far_apart_and_a_dead_time():
    """1/(s (1e-3 s + 1)) and 100 s of dead time: K 100 must stay below about pi/2."""
    for gain, stable in ((0.015, True), (0.0157, True), (0.01572, False), (0.05, False)):
        plant = Plant(num=[gain], den=[1e-3, 1.0, 0.0], dead_time=100.0)
        assert closed_loop_stable(Loop.of(plant)) is stable


@pytest.mark.parametrize("gain", [1e-8, 1e-30, 1e-100])
def test_a_weak_loop_around_an_integrator_is_proved(gain):
    """K exp(-0.1 s)/(s (s + 1)): |L| = 1 at w = K, all but 90 deg from -1, and only there."""
    found, why = decided(Loop.of(Plant(num=[gain], den=[1.0, 1.0, 0.0], dead_time=0.1)))
    assert (found, why.holds) == (True, True)
    found, why = decided(Loop.of(Plant(num=[-gain], den=[1.0, 1.0, 0.0], dead_time=0.1)))
    assert (found, why.holds) == (False, True)  # a pole near s = K


def test_the_points_on_the_turns_of_a_delay():
    late = Loop.of(Plant(num=[1.0], den=[1.0, 1.0], dead_time=2.0))
    for scale, last in ((3.0, 30.0), (100.0, 300.0)):  # ten times the loop, 600 rad at most
        v = _turns(late, scale)
        assert (len(v), v[0], v[-1]) == (2000, 0.0, last)
    v = _turns(integrator(1.0, 70), 1.0)  # 1400 points up to, not at, z = -1
    w = 2 / 0.5 * np.arctan(v * 0.25)
    assert w == pytest.approx(np.arange(1400) * pi / 1400 / 0.5, rel=1e-12)


def test_where_integrators_alone_would_bring_the_loop_to_one():
    """Near 0 L is gain/s^n, which is 1 at gain^(1/n); a differentiator takes one away."""
    one = Loop.of(Plant(num=[1.0, 2.0], den=[1.0, 3.0, 5.0, 0.0]))
    assert _slow_crossover(one) == pytest.approx([2 / 5], rel=1e-14)
    two = Loop.of(Plant(num=[7.0, -2.0], den=[1.0, 3.0, 8.0, 0.0, 0.0]))
    assert _slow_crossover(two) == pytest.approx([0.5], rel=1e-14)
    less = Loop.of(Plant(num=[1.0, 4.0, 0.0], den=[1.0, 3.0, 8.0, 0.0, 0.0]))
    assert _slow_crossover(less) == pytest.approx([0.5], rel=1e-14)
    for num, den in (([1.0, 2.0], [1.0, 3.0]), ([1.0, 0.0], [1.0, 3.0]), ([1.0, 0.0], [1.0, 0.0])):
        assert _slow_crossover(Loop.of(Plant(num=num, den=den))) == []


@pytest.mark.parametrize("end", [0.9999, 0.99999, 0.999999])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("dead_time", [0.01, 1.0])
def test_a_loop_that_turns_for_ever_just_below_1_is_decided(end, sign, dead_time):
    """(s + 1)/(s + 2) grows to its end: |L| < 1 everywhere, and by the small gain it is stable."""
    k = sign * end
    quiet = Loop.of(Plant(num=[k, k], den=[1, 2], dead_time=dead_time))
    stable, proof = decided(quiet)
    assert stable is True
    assert proof.holds
    # (s + 2)/(s + 1) is 2 at s = 0 and falls: with the minus 1 + L(s) has a zero for a real s > 0;
    # with the plus L goes around -1 unless |L| < 1 where it first is negative
    loud = Loop.of(Plant(num=[k, 2 * k], den=[1, 1], dead_time=dead_time))
    stable, proof = decided(loud)
    assert stable is (sign > 0 and _first_turn(loud) < 1)
    assert proof.holds


def _first_turn(loop):
    """Return |L| where (jw + 2)/(jw + 1) exp(-jw T) first is negative, to 1e-9 of w by halving."""
    low, high = 0.0, pi / loop.dead_time
    for _ in range(60):
        w = (low + high) / 2
        lag = w * loop.dead_time + atan(w) - atan(w / 2)
        low, high = (w, high) if lag < pi else (low, w)
    return loop.num[0] * sqrt((w * w + 4) / (w * w + 1))
