"""What is said of a loop that is not as it was asked for: which crossover it is, and why."""

from cmath import exp, rect
from math import pi, radians

import mpmath
import pytest

import zoh
from zoh.analysis.on_target import not_as_asked, surely_at, surely_on_target
from zoh.spec import Crossover

# 2/(s (s + 1)) behind no clock: |L| = 1 where w^4 + w^2 = 4, at w^2 = (sqrt 17 - 1)/2, once
W = ((17**0.5 - 1) / 2) ** 0.5
LOOP = zoh.Plant(num=[2], den=[1, 1, 0])
SEEN = zoh.margins(LOOP)
PM = SEEN.phase_margin_deg


def said(wc, pm_deg, there):
    (sentence,) = not_as_asked(SEEN, Crossover(wc=wc, pm_deg=pm_deg), lambda _: there)
    return sentence


def on_circle(pm_deg):
    return rect(1.0, radians(pm_deg - 180))


def test_the_loop_is_the_one_worked_by_hand():
    assert pytest.approx(W, rel=1e-12) == SEEN.crossover
    assert len(SEEN.gain_crossings) == 1


def test_what_is_asked_for_is_had_within_the_promise():
    for off, surely, as_asked in ((5e-11, True, True), (5e-10, False, True), (2e-9, False, False)):
        for spec in (
            Crossover(wc=SEEN.crossover, pm_deg=PM + off),
            Crossover(wc=SEEN.crossover * (1 + off), pm_deg=PM),
        ):
            assert surely_on_target(SEEN, spec) is surely
            assert surely_at(SEEN.crossover, PM, spec) is surely
            assert (not_as_asked(SEEN, spec, lambda _: 0j) == []) is as_asked
    assert not surely_at(None, PM, Crossover(wc=1.0, pm_deg=PM))


def test_the_only_crossover_is_never_called_another():
    """|L| as asked, and the crossover next to it: what moved it is rounding."""
    for wc, pm_deg in ((SEEN.crossover, PM + 1e-8), (SEEN.crossover * (1 + 1e-8), PM)):
        flat = said(wc, pm_deg, on_circle(pm_deg))
        assert flat.endswith("|L| is so flat there that rounded gains move its crossover")
        assert "another" not in flat
    # a law that was not solved for this margin crosses over there with its own
    plain = said(SEEN.crossover, PM + 1, on_circle(PM))
    assert plain.endswith(f"not {PM + 1:.6g} deg at {W:.6g} rad/s")


def test_a_gain_of_one_that_is_no_crossover_is_told_from_none():
    assert said(2.0, 45.0, on_circle(45)).endswith(": |L| is 1 there, and does not pass it")
    assert said(2.0, 45.0, 0.45j).endswith(": the loop does not cross over there")


def test_nothing_is_asked_of_a_loop_without_a_target():
    assert not_as_asked(SEEN, None, lambda _: 0j) == []


def test_a_crossover_with_a_smaller_margin_is_another():
    # a resonance at 10 rad/s that the loop crosses again, with 0.3 s behind it a stable loop
    ringing = zoh.Plant(num=[100.0], den=[1, 0.05, 100, 0], dead_time=0.3)
    with pytest.raises(zoh.NotMet, match=r"rad/s, another crossover of this loop, not 80 deg"):
        zoh.pd(ringing, dt=0.01, wc=0.6, pm_deg=80)


def test_a_loop_that_is_a_delay_alone_has_a_gain_of_one_that_it_does_not_pass():
    # (1 - E)/(z - E) of 1/(s + 1), and a PD that cancels it: L is 1/z, of size 1 at all frequencies
    dt, lag = 0.02, zoh.Plant(num=[1], den=[1, 1])
    wc = pi / dt / 2
    assert abs(exp(-1j * wc * dt) + 1j) < 1e-15  # a quarter turn: 90 deg of margin
    with pytest.raises(zoh.NotMet) as missed:
        zoh.pd(lag, dt=dt, wc=wc, pm_deg=90)
    assert "not 90 deg at 78.5398 rad/s: |L| is 1 there, and does not pass it" in str(missed.value)
    gains = missed.value.measured.gains
    assert gains["kd"] == pytest.approx(dt * mpmath.exp(-dt) / (1 - mpmath.exp(-dt)), rel=1e-12)
    assert gains["kp"] == pytest.approx(1, rel=1e-12)
