"""motion: modes by hand, how far they are followed and how densely they are shown."""

import warnings
from math import atan2, cos, hypot, log, pi, sin

import numpy as np
import pytest
from mpmath import mp, mpf

import zoh
from zoh.analysis import motion as room
from zoh.analysis.closed import autonomous, continuous
from zoh.analysis.motion import Motion


def of(*modes):
    """Return a motion of modes z side by side, pairs for complex ones, each starting at 1."""
    size = sum(2 if isinstance(z, complex) else 1 for z in modes)
    delta, i = np.zeros((size, size)), 0
    for z in modes:
        if isinstance(z, complex):
            x, y = z.real - 1, z.imag
            delta[i : i + 2, i : i + 2] = [[x, -y], [y, x]]
            i += 2
        else:
            delta[i, i] = z - 1
            i += 1
    ones = np.ones(size)
    return Motion(
        dt=1.0, delta=delta, start=ones, own=size, output=ones, effort=None, stretches=()
    )  # fmt: skip


def turning(size, angle):
    return complex(size * cos(angle), size * sin(angle))


def test_powers_are_not_shown():
    assert "power" not in repr(of(1.5))


@pytest.mark.parametrize("count", [1, 2, 3, 8, 13])
@pytest.mark.parametrize("doublings", [0, 2])
def test_a_run_is_every_so_many_samples(count, doublings):
    states = of(1.5, 0.5).run(np.array([2.0, 4.0]), count, doublings)
    k = np.arange(count) * 2**doublings
    assert states == pytest.approx(np.array([2 * 1.5**k, 4 * 0.5**k]), rel=1e-14)


def test_rates_are_the_logarithms_fastest_last():
    swing = turning(0.9, 0.25)
    found = of(0.5, swing, 0.0, -0.5, 0.99).rates()
    wanted = [
        (-log(0.99), -log(0.99)),
        (-log(0.9), hypot(log(0.9), 0.25)),
        (-log(0.9), hypot(log(0.9), 0.25)),
        (log(2), log(2)),
        (log(2), hypot(log(2), pi)),
        (1e6, 1e6),
    ]
    assert np.array(found) == pytest.approx(np.array(wanted), rel=1e-14)


def test_a_swing_that_hardly_dies_is_faster_than_a_lag_that_does():
    found = of(turning(0.99, 3.0), 0.5).rates()
    assert [turn for _, turn in found] == pytest.approx(
        [log(2), *[hypot(log(0.99), 3.0)] * 2], rel=1e-13
    )


def test_a_rate_close_to_one_keeps_its_digits():
    assert of(1 - 2.0**-40).rates()[0] == pytest.approx((2.0**-40, 2.0**-40), rel=1e-11)
    ((decay, turn), _) = of(complex(1 - 2.0**-40, 2.0**-30)).rates()
    # log |z| = log(1 - 2^-39 + 2^-80 + 2^-60)/2, the angle 2^-30
    assert decay == pytest.approx(2.0**-40 - 2.0**-61, rel=1e-11)
    assert turn == pytest.approx(hypot(2.0**-40, atan2(2.0**-30, 1)), rel=1e-11)


def test_only_what_is_the_systems_own_is_a_mode():
    driven = of(0.5, 1.0)
    own = Motion(
        dt=1.0, delta=driven.delta, start=driven.start, own=1, output=driven.output, effort=None,
        stretches=(),
    )  # fmt: skip
    assert own.rates() == [(log(2), log(2))]
    assert 34 <= own.track().k[-1] <= 34 + 9  # 2^-34 is below 1e-10


def assert_follows(track, *modes):
    """Assert that the samples are in order, from 0 on, and the states the modes' powers."""
    assert track.k[0] == 0
    assert (np.diff(track.k) > 0).all()
    for row, z in zip(track.states, modes, strict=False):
        assert row == pytest.approx(z ** track.k.astype(float), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("z", [0.5, -0.5, 0.9, 0.0])
def test_a_quick_mode_is_shown_until_a_ten_billionth(z):
    track = of(z).track()
    assert_follows(track, z)
    needed = log(1e10) / -log(abs(z)) if z else 0
    assert max(8, needed) <= track.k[-1] <= 1.1 * needed + 8
    assert track.rests
    if z == -0.5:
        assert track.k.tolist() == list(range(track.k[-1] + 1))


@pytest.mark.parametrize("far", [1e3, 1e6, 1e9, 1e12])
def test_a_slow_mode_alone_needs_few_samples(far):
    z = 1 - 1 / far
    track = of(z).track()
    assert track.states[0] == pytest.approx(np.exp(track.k * np.log1p(z - 1)), rel=1e-6, abs=1e-8)
    assert log(1e10) * far <= track.k[-1] * (1 + 1e-4) <= 3 * log(1e10) * far
    assert len(track.k) <= 40
    assert track.rests


@pytest.mark.parametrize("angle", [1e-4, 0.01, 0.1, 1.0, 3.0])
def test_a_swing_is_shown_four_times_a_radian(angle):
    z = turning(0.999, angle) if angle > 1e-3 else turning(1 - 1e-5, angle)
    track = of(z).track()
    gaps = np.diff(track.k)
    turn = hypot(angle, log(abs(z)))
    alive = track.k[:-1] * -log(abs(z)) <= 36
    assert gaps[alive].max() <= max(1, 0.25 / turn)
    assert gaps[alive].min() > 0.25 / turn / 4 or gaps[alive].min() == 1
    assert (abs(z) ** track.k[-1]) <= 1e-10
    states = np.exp(track.k * np.log(z)) * (1 + 1j)
    assert track.states[0] == pytest.approx(states.real, abs=1e-9)
    assert track.states[1] == pytest.approx(states.imag, abs=1e-9)


@pytest.mark.parametrize(("angle", "gap"), [(0.3, 1), (0.1, 2), (0.0101, 16), (0.0151, 16)])
def test_a_gap_is_the_largest_power_of_two_within_a_quarter_of_a_radian(angle, gap):
    track = of(turning(1 - 1e-4, angle)).track()  # 184 thousand samples: enough to leave some out
    assert set(np.diff(track.k[track.k < 100_000])) == {gap}


def test_two_swings_are_shown_as_the_faster_needs_while_it_lives():
    fast, slow = turning(0.99, 1.0), turning(1 - 1e-6, 1e-4)
    track = of(fast, slow).track()
    gone = 36 / -log(0.99)  # 3582 samples
    gaps = np.diff(track.k)
    assert (gaps[track.k[:-1] < gone - 1] == 1).all()
    late = gaps[track.k[:-1] > 2 * gone]
    assert (late > 0.25 / 1e-4 / 4).all()
    assert late.max() <= 0.25 / 1e-4
    assert len(track.k) < 2 * gone + log(1e10) * 1e6 / 1000
    states = np.exp(track.k * np.log(slow)) * (1 + 1j)
    assert track.states[2] == pytest.approx(states.real, abs=1e-7)


def test_a_fast_mode_before_a_slow_one():
    track = of(0.5, 1 - 1e-6).track()
    assert_follows(track, 0.5, 1 - 1e-6)
    assert track.k[:28].tolist() == list(range(28))
    assert len(track.k) < 400


def test_what_does_not_rest_is_shown_as_far_as_is_allowed(monkeypatch):
    swing = of(turning(0.99, 1.0))  # a ten thousandth after 917 samples, a ten billionth 2292
    for most, rests in ((900, False), (940, True), (3000, True)):
        monkeypatch.setattr(room, "_MOST", most)
        track = swing.track()
        assert track.rests is rests
        assert len(track.k) == min(most, track.k[-1] + 1)
        assert len(track.k) == (most if most < 2292 else pytest.approx(2301, abs=8))


def test_a_motion_without_modes_is_shown_for_a_while():
    still = Motion(
        dt=1.0, delta=np.zeros((1, 1)), start=np.ones(1), own=0, output=np.ones(1), effort=None,
        stretches=(),
    )  # fmt: skip
    track = still.track()
    assert track.k[0] == 0
    assert track.k[-1] >= 8
    assert (track.states == 1).all()
    assert track.rests


@pytest.mark.parametrize("most", [2500, 4000])
def test_the_limit_is_that_of_all_samples_together(monkeypatch, most):
    # 3582 samples while the fast one lives, then thousands of the slow one's
    monkeypatch.setattr(room, "_MOST", most)
    track = of(turning(0.99, 1.0), turning(1 - 1e-6, 1e-4)).track()
    assert len(track.k) == most
    assert not track.rests


def test_a_motion_that_outgrows_floats_is_refused_in_one_line_and_without_a_warning():
    """Twelve notches beside each other: 24 poles near one pair, in one fraction."""
    arm = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    notches = [zoh.notch(w0=20 + 0.3 * i, depth=0.05, width=0.3) for i in range(12)]
    with (
        warnings.catch_warnings(action="error", category=RuntimeWarning),
        pytest.raises(zoh.SpecError, match=r"followed in 64-bit floats, .*: use fewer sections"),
    ):
        zoh.pid(arm, dt=0.1, wc=1.0, pm_deg=40, ki=0.3, sections=notches)


def coupled(coupling, effort=None):
    """Return two modes 0.9 of which the second drives the first: S^2 holds 1.8 times ``coupling``.

    Both come to rest.
    """
    return Motion(
        dt=1.0, delta=np.array([[-0.1, coupling], [0.0, -0.1]]), start=np.array([0.0, 1.0]), own=2,
        output=np.ones(2), effort=effort, stretches=(),
    )  # fmt: skip


@pytest.mark.parametrize(("effort", "named"), [(None, "system"), (np.ones(2), "controller")])
def test_what_is_refused_is_what_was_given_and_says_how_many_states_it_has(effort, named):
    with (
        warnings.catch_warnings(action="error", category=RuntimeWarning),
        pytest.raises(zoh.SpecError) as told,
    ):
        coupled(1.5e308, effort).track()
    assert told.value.argument == named
    assert str(told.value.value).startswith("2 states")
    assert told.value.way_out


def test_what_floats_hold_is_followed():
    """A chain of two: k z^(k-1) coupling."""
    track = coupled(1e300).track()
    wanted = 1e300 * track.k * 0.9 ** (track.k - 1.0)
    assert track.states[0] == pytest.approx(wanted, rel=1e-11, abs=1e288)


def test_what_has_all_but_died_has_its_digits():
    """0.7^k to the last: beside a slow one 1 + S would be a rounding of what is left."""
    quick = of(0.7)
    states = quick.run(np.array([1.0]), 200, 0, -log(0.7))
    assert states[0] == pytest.approx([0.7**k for k in range(200)], rel=1e-13, abs=0)
    every_fourth = quick.run(np.array([1.0]), 50, 2, -log(0.7))
    assert every_fourth[0] == pytest.approx([0.7 ** (4 * k) for k in range(50)], rel=1e-13, abs=0)


def test_what_hardly_moves_has_its_digits_where_its_rate_is_not_known():
    """(1 + s)^k, s = -1e-9/3: 1 + s itself has lost half of s."""
    s = -1e-9 / 3
    slow = Motion(
        dt=1.0, delta=np.array([[s]]), start=np.ones(1), own=1, output=np.ones(1), effort=None,
        stretches=(),
    )  # fmt: skip
    states = slow.run(slow.start, 4097)
    with mp.workdps(40):
        wanted = float((1 + mpf(s)) ** 4096)
    assert states[0, -1] == pytest.approx(wanted, rel=1e-14, abs=0)


def test_nothing_waits_in_a_system_by_itself():
    late = zoh.Sampled(num=[0.5], den=[1, -0.5, 0, 0], dt=1.0)
    for one in (autonomous(late), continuous(zoh.Plant(num=[1], den=[1, 1], dead_time=9.0), 1.0)):
        assert one.wait == 0
        assert one.track().rests


@pytest.mark.parametrize("z", [0.7, 0.05, -0.9])
def test_what_dies_is_shown_with_its_digits_to_the_last_and_known_no_further(z):
    track = of(z).track()
    assert track.states[0] == pytest.approx(z ** track.k.astype(float), rel=1e-12, abs=0)
    assert track.horizon == track.k[-1]


@pytest.mark.parametrize("quick", [0.5, 8.5e-3])
def test_a_mode_alone_in_its_band_is_known_to_a_ten_billionth_but_not_shown(quick):
    """1 - exp(-k/1000)/100 - exp(-quick k): the last of it is gone when it is exp(-36)."""
    slow = 1e-3
    lone = Motion(
        dt=1.0, delta=np.diag([np.expm1(-slow), np.expm1(-quick), 0.0]), start=np.ones(3), own=2,
        output=np.array([-0.01, -1.0, 1.0]), effort=None, stretches=(),
    )  # fmt: skip
    track = lone.track(1.0)
    assert track.states[0] == pytest.approx(np.exp(-slow * track.k), rel=1e-9)
    assert 36 / quick <= track.k[-1] <= 36 / quick + 100  # what is shown last is the slow one alone
    assert isinstance(track.horizon, int)
    assert log(1e10) <= slow * track.horizon <= 1.2 * log(1e10)  # a stride is a quarter at most
    assert track.rests


def test_a_mode_that_changes_sides_at_every_sample_is_shown_at_every_one():
    track = of(-(1 - 1e-3)).track()
    assert len(track.k) > 20_000
    assert (np.diff(track.k) == 1).all()
