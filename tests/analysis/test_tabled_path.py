"""The parts of the tabled margins by hand: the path, its ends, its crossings and its errors.

A gain k w^a at a phase p + b ln w is a line over ln w in both, and the curve between the points
meets it exactly. So every figure here is arithmetic, and holds to rounding.
"""

from math import atan2, cos, degrees, exp, hypot, inf, log, pi, radians, sqrt

import numpy as np
import pytest

from zoh import FrequencyResponse, Plant, Sampled
from zoh.analysis.tabled import margins, spread
from zoh.analysis.tabled.beyond import beyond
from zoh.analysis.tabled.count import _refined, agreed, count
from zoh.analysis.tabled.path import (
    LowEnd,
    Path,
    _between,
    _corners,
    _most_above,
    _turns,
    boundary_poles,
    low_end,
    low_slope,
    quiet_below,
)
from zoh.errors import SpecError

AROUND = [0.2, 0.5, 1, 2, 4, 10, 30]  # of a real corner: a pole -a has these times a


def spiral(w, k=1.0, slope=-1.0, start=-90.0, turn=0.0, **more):
    """Return k w^slope at the phase ``start`` + ``turn`` ln w, in deg."""
    magnitude = [k * x**slope for x in w]
    phase_deg = [start + turn * log(x) for x in w]
    return FrequencyResponse(w=w, magnitude=magnitude, phase_deg=phase_deg, **more)


def near(truth, rel=1e-12):
    return pytest.approx(truth, rel=rel, abs=1e-300)


# The path ------------------------------------------------------------------------------------


def test_between_two_points_there_are_even_steps_of_ln_w():
    w = np.array([1.0, 256.0, 512.0])
    found = _between(w)
    assert found[:8] == near([2.0**k for k in range(8)])
    assert found[8:] == near([256 * 2 ** (k / 8) for k in range(9)])
    assert {1.0, 256.0, 512.0} <= set(found.tolist())  # the points themselves, to the bit
    dense = np.linspace(1, 2, 10_000)
    assert len(_between(dense)) == 4 * 9_999 + 1  # 40 000 in all
    denser = np.linspace(1, 2, 30_000)
    assert len(_between(denser)) == 2 * 29_999 + 1  # a middle each, however many there are


def test_around_a_real_corner_and_a_mode():
    assert _corners(None).size == 0
    assert _corners(Plant(num=[1], den=[1, 3])) == near([3 * a for a in AROUND])
    # -1 +- 2 j: from its frequency, 2, by multiples of its damping, and its size
    around = [2 + a for a in (-1, -0.5, -0.2, 0, 0.2, 0.5, 1, 2, 4, 10, 30)]
    assert _corners(Plant(num=[1], den=[1, 2, 5])) == near(sorted([*around, sqrt(5)]))
    # a zero counts as a pole does; one at the origin has no frequency
    assert _corners(Plant(num=[1, 7], den=[1, 0])) == near([7 * a for a in AROUND])
    # in w = (2/dt) tan(w dt/2): a corner at v is found at (2/dt) atan(v dt/2)
    law = Sampled.from_w(num_w=[1.0], den_w=[1.0, 3.0], dt=0.5)
    assert _corners(law) == near([4 * atan2(3 * a, 4) for a in AROUND])


def test_a_delay_is_followed_in_steps_of_a_fifth():
    assert _turns(None, 1.0, 2.0).size == 0
    assert _turns(Plant(num=[1], den=[1]), 1.0, 2.0).size == 0
    late = Plant(num=[1], den=[1], dead_time=1.0)
    assert _turns(late, 1.0, 2.5) == near(np.linspace(1, 2.5, 9))  # 1.5 rad: 7 steps and one more
    twice = Sampled.from_w(num_w=[1.0], den_w=[1.0], dt=0.25, delay=8)  # 2 s
    assert _turns(twice, 1.0, 1.5) == near(np.linspace(1, 1.5, 7))
    assert len(_turns(late, 1.0, 1e6)) == 40_000


def test_what_a_controller_may_do_beyond_the_table():
    lead = Plant(num=[0.3, 0.1], den=[0.1, 1.0])  # from 0.1 up to 3
    assert _most_above(None, np.empty(0), 2.0) == 1.0
    assert _most_above(lead, _corners(lead), 2.0) == near(3.0, rel=1e-9)  # at 2e6 rad/s
    lag = Plant(num=[1.0], den=[1.0, 1.0])  # largest where it begins
    assert _most_above(lag, _corners(lag), 2.0) == near(1 / sqrt(5))
    # a notch turned round: |(s^2 + 2 s + 1e4)/(s^2 + 0.002 s + 1e4)| is 1000 at 100 rad/s alone
    peak = Plant(num=[1, 2, 1e4], den=[1, 0.002, 1e4])
    assert _most_above(peak, _corners(peak), 2.0) == near(1000.0, rel=1e-9)
    assert _most_above(peak, _corners(peak), 150.0) < 1.01
    # z + 1 over 2 falls to 0 at Nyquist; (3 - z)/2 rises to 2
    assert _most_above(Sampled(num=[0.5, 0.5], den=[1, 0], dt=1.0), np.empty(0), 2.0) == near(
        cos(1)
    )
    rising = Sampled(num=[-0.5, 1.5], den=[1.0, 0.0], dt=0.5)
    assert _most_above(rising, _corners(rising), 2.0) == near(2.0)


def test_the_path_of_a_table_and_of_a_loop():
    table = spiral([1, 2, 4], k=0.5)
    alone = Path.of(table)
    assert (alone.table, alone.controller) == (table, None)
    assert alone.w == near([2 ** (k / 8) for k in range(17)])
    assert alone.gain == near(0.5 / (1j * alone.w))
    assert alone.above == 0.125
    assert alone.low == LowEnd(integrators=1, gain=0.5)
    assert alone.at(3.0) == near(-1j / 6)
    late = Plant(num=[3, 0], den=[1, 3], dead_time=0.5)
    both = Path.of(late * table)
    assert both.controller is late
    added = set(both.w.tolist()) - set(alone.w.tolist())
    # the corners inside, 1.5 and 3, and 1.5 rad of delay in 7 steps and one
    assert {1.5, 3.0} <= added
    assert len(added) == 2 + 7
    assert both.gain == near(late.at(both.w) * 0.5 / (1j * both.w))
    assert both.at(3.0) == near(late.at(3.0) / 6j)
    assert both.above == near(0.125 * 3, rel=1e-9)  # 3 s/(s + 3) goes to 3
    assert Path.of(spiral([1, 2, 4], dt=pi / 4)).above == 0.0  # nothing above Nyquist's


def test_the_coarser_paths_leave_out_one_half_of_the_points_each():
    table = spiral([1, 2, 3, 4, 5, 6])
    for loop in (table, Plant(num=[2], den=[1]) * table):
        first, second = Path.of(loop).coarser()
        assert first.table.w.tolist() == [1, 3, 5, 6]
        assert second.table.w.tolist() == [1, 2, 4, 6]
        assert first.controller is second.controller is Path.of(loop).controller


def test_below_the_table_the_loop_follows_its_asymptote():
    path = Path.of(Plant(num=[2], den=[1, 0.1]) * spiral([1, 2, 4], k=3.0))
    w, gain = path.below()
    assert w[0] == near(1e-4 * 0.02)  # of the lowest corner looked at, 0.2 of 0.1
    assert w[-1] == 1.0
    assert {0.1, 0.2} <= set(np.round(w, 15).tolist())  # corners of the controller
    assert gain == near(2 / (1j * w + 0.1) * 3 / (1j * w))
    even = Path.of(spiral([1, 2, 4], k=3.0)).below()[0]
    assert len(even) == 162  # 40 a decade
    assert even == near(np.geomspace(1e-4, 1, 162))
    # a table that does not say how it goes on
    w, gain = Path.of(spiral([1, 2, 4], slope=-1.5)).below()
    assert (w.size, gain.size) == (0, 0)


@pytest.mark.parametrize(
    ("slope", "start", "low"),
    [
        (-1, -90, (1, 5.0)),
        (-1, 90, (1, -5.0)),
        (-1, 270, (1, 5.0)),
        (-1, -119, (1, 5.0)),
        (-1, -61, (1, 5.0)),
        (-1, -121, None),
        (-1, -59, None),
        (-1, 119, (1, -5.0)),
        (0, 0, (0, 5.0)),
        (0, 180, (0, -5.0)),
        (0, -180, (0, -5.0)),
        (0, 360, (0, 5.0)),
        (-2, -180, (2, 5.0)),
        (-2, 0, (2, -5.0)),
        (1, 90, (-1, 5.0)),
        (1, -90, (-1, -5.0)),
        (-1.19, -90, (1, 5.0)),
        (-0.81, -90, (1, 5.0)),
        (-1.21, -90, None),
        (-0.79, -90, None),
    ],
)
def test_the_low_end_by_its_slope_and_its_phase(slope, start, low):
    found = low_end(spiral([1, 1.5, 2, 4], k=5.0, slope=slope, start=start))
    assert found == (None if low is None else LowEnd(integrators=low[0], gain=low[1]))


def test_the_gain_of_the_low_end_is_that_of_its_first_point():
    found = low_end(spiral([2, 3, 4], k=5.0, slope=-2, start=-180))
    assert found.gain == near(5.0)  # k = |G| w^2
    assert found.at(np.array([2.0, 4.0])) == near(np.array([-5 / 4, -5 / 16]))


def test_the_slope_of_the_first_octave():
    # over ln w = 0, ln 1.5, ln 2: a fourth point beyond the octave does not count
    table = FrequencyResponse(w=[1, 2, 4], magnitude=[8, 4, 4], phase_deg=[0, 0, 0])
    assert low_slope(table) == near(-1.0)
    wide = FrequencyResponse(w=[1, 3, 9], magnitude=[9, 1, 1], phase_deg=[0, 0, 0])
    assert low_slope(wide) == near(-2.0)
    # three at 0, a and 2 a: by least squares the slope between the outer ones
    a = sqrt(2)
    three = FrequencyResponse(
        w=[1, a, a * a * (1 - 1e-15), 8], magnitude=[4, 3, 1, 1], phase_deg=[0] * 4
    )
    assert low_slope(three) == near(-2.0, rel=1e-9)


def test_a_quiet_loop_is_below_1_and_level_or_rising():
    level = spiral([1, 2, 4], k=0.5, slope=0.0, start=0.0)
    assert quiet_below(Path.of(level))
    assert not quiet_below(Path.of(level.scaled(2.0)))  # 1 is not below 1
    assert quiet_below(Path.of(spiral([1, 2, 4], k=0.5, slope=-0.19)))
    assert not quiet_below(Path.of(spiral([1, 2, 4], k=0.5, slope=-0.21)))
    assert quiet_below(Path.of(spiral([1, 2, 4], k=0.5, slope=0.5)))
    assert not quiet_below(Path.of(Plant(num=[0.1], den=[1, 0]) * level))
    assert quiet_below(Path.of(Plant(num=[0.1, 0], den=[1, 1]) * level))


@pytest.mark.parametrize(
    ("num", "den", "found"),
    [
        ([1], [1], (0, 0)),
        ([1], [1, 0], (1, 0)),
        ([1, 0], [1, 2, 0, 0], (1, 0)),
        ([1, 0], [1, 1], (-1, 0)),
        ([1], [1, -2], (0, 1)),
        ([1], [1, -2, 5], (0, 2)),
        ([1], [1, 2, 5], (0, 0)),
        ([1], [1, -1, -2, 0], (1, 1)),
        ([1], [1, 2e-8, 1], (0, 0)),  # damped by 1e-8: next to the boundary, not on it
    ],
)
def test_poles_of_a_controller_on_and_beyond_the_boundary(num, den, found):
    assert boundary_poles(Plant(num=num, den=den)) == found


def test_a_pole_on_the_boundary_is_refused_to_the_word():
    says = (
        "controller must have no pole on the stability boundary but integrators, got {}: its loop "
        "has an infinite gain there, which no table shows"
    )
    for law, den in (
        (Plant(num=[1], den=[1, 0, 4]), "[1.0, 0.0, 4.0]"),
        (Plant(num=[1], den=[1, 1e-10, 1]), "[1.0, 1e-10, 1.0]"),  # too near to tell
        (Sampled(num=[1], den=[1, 1], dt=0.1), "[1.0, 1.0]"),  # z = -1
    ):
        with pytest.raises(SpecError) as refused:
            boundary_poles(law)
        assert str(refused.value) == says.format(den)


# Outside -------------------------------------------------------------------------------------


def test_beyond_a_loop_that_reaches_its_size_on_both_sides():
    # -0.5 below the table and +-0.5 above it: 1/0.5, 1/(1 - 0.5), 0.5/(1 - 0.5)
    found = beyond(Path.of(spiral([1, 2, 4], k=0.5, slope=0.0, start=180.0)))
    assert (found.gain_margin, found.phase_margin_deg) == (near(2.0), inf)
    assert (found.ms, found.mt) == (near(2.0), near(1.0))


def test_beyond_a_loop_below_which_only_its_size_is_known():
    # it rises as w^0.5 from 0.25 to 0.5, of no asymptote: below |L| <= 0.25, above 0.5
    found = beyond(Path.of(spiral([1, 2, 4], k=0.25, slope=0.5, start=0.0)))
    assert (found.gain_margin, found.ms, found.mt) == (near(2.0), near(2.0), near(1.0))
    # up to Nyquist's frequency only what is below counts
    found = beyond(Path.of(spiral([1, 2, 4], k=0.25, slope=0.5, start=0.0, dt=pi / 4)))
    assert (found.gain_margin, found.ms, found.mt) == (near(4.0), near(4 / 3), near(1 / 3))
    assert found.phase_margin_deg == inf
    # and where it is not quiet below, nothing does
    found = beyond(Path.of(spiral([1, 2, 4], k=0.25, slope=-0.5, start=0.0, dt=pi / 4)))
    assert (found.gain_margin, found.phase_margin_deg) == (1.0, 0.0)
    assert (found.ms, found.mt) == (inf, inf)


def test_beyond_a_crossing_below_the_table_both_ends_of_its_step_count():
    # 0.2/(j w) begins at 0.4: its crossing at 0.2 rad/s has 90 deg on both sides
    found = beyond(Path.of(spiral([0.5, 1, 2], k=0.2)))
    assert found.phase_margin_deg == near(90.0)
    assert found.gain_margin == near(10.0)  # of 0.1 above
    assert found.mt == near(1 / sqrt(1 + (1e-4 * 0.5 / 0.2) ** 2))  # T = 1/(1 + j w/0.2)
    # with a lag of 10 s it is 0.2/(j w (1 + 10 j w)): |L| = 1 where w^2 (1 + 100 w^2) = 0.04
    w = sqrt((sqrt(1 + 16) - 1) / 200)
    margin = 90 - degrees(atan2(10 * w, 1))
    found = beyond(Path.of(Plant(num=[1], den=[10, 1]) * spiral([0.5, 1, 2], k=0.2)))
    # the smaller end of a step of 1/40 decade, whose phase moves by 0.45 ln 10/40 rad at most
    assert margin - degrees(0.45 * log(10) / 40) * 1.1 <= found.phase_margin_deg < margin


def test_beyond_a_loop_that_crosses_the_axis_below():
    # 2/s (10 - s)/(10 + s) known from 20 rad/s on: -180 deg where 2 atan(w/10) = 90 deg, at w = 10,
    # which is a corner of the controller, so a step's end, to the bit
    law = Plant(num=[-1, 10], den=[1, 10])
    found = beyond(Path.of(law * spiral([20, 40, 80], k=2.0)))
    step = 10 ** (1 / 40)  # the nearest to 1 of the ends around; |L| = 2/w
    assert 5 / step < found.gain_margin <= 5
    least = min(abs(1 + law.at(w) * 2 / (1j * w)) for w in np.geomspace(1, 20, 401).tolist())
    assert found.ms == near(1 / least, rel=1e-3)  # on its steps of 1/40 decade


def test_beyond_a_constant_that_is_negative():
    # -4 at w = 0: its factor there is 1/4; a controller's integrator takes it away
    loop = spiral([1, 2, 4], k=4.0, slope=0.0, start=180.0, dt=pi / 4)
    found = beyond(Path.of(loop))
    assert found.gain_margin == near(0.25)
    assert (found.ms, found.mt) == (near(1.0), near(4 / 3))
    law = Sampled(num=[1.0], den=[1.0, -1.0], dt=pi / 4)
    assert beyond(Path.of(law * loop)).gain_margin == inf


def test_beyond_a_loop_that_is_real_at_rest():
    # -4/(1 + 2 s): at w = 0 its factor is 1/4; beyond 4 rad/s |L| <= 4/sqrt(65), which is nearer
    constant = spiral([1, 2, 4], k=4.0, slope=0.0, start=180.0)
    found = beyond(Path.of(Plant(num=[1], den=[2, 1]) * constant))
    assert found.gain_margin == near(sqrt(65) / 4)
    # with -4/(1 + 40 s) it is the other way round
    found = beyond(Path.of(Plant(num=[1], den=[40, 1]) * constant))
    assert found.gain_margin == near(0.25, rel=1e-7)  # 1e-4 below the lowest corner, squared
    # -1/s behind a zero at the origin is -1/(s + 2): 1/2 at rest
    once = spiral([1, 2, 4], slope=-1.0, start=90.0)
    found = beyond(Path.of(Plant(num=[1, 0], den=[1, 2]) * once))
    assert found.gain_margin == near(2.0, rel=1e-7)
    # (1 + 0.5/s) -2e-5: an integrator, so no gain at rest, though it is 1 at 1e-5 rad/s
    quiet = spiral([1, 2, 4], k=2e-5, slope=0.0, start=180.0)
    found = beyond(Path.of(Plant(num=[1, 0.5], den=[1, 0]) * quiet))
    assert found.gain_margin == near(5e4 / sqrt(1 + 1 / 64))


def test_beyond_a_loop_that_is_real_and_positive_below():
    # 5000/(j w) ((1 + w)/(100 + w))^2 passes 0 deg at v = 1 with 1 over 2: that is no crossing
    law = Sampled.from_w(num_w=[1.0, 2.0, 1.0], den_w=[1.0, 200.0, 1e4], dt=pi / 80)
    found = beyond(Path.of(law * spiral([20, 40, 80], k=2500.0, dt=pi / 80)))
    assert found.gain_margin == inf


@pytest.mark.parametrize("size", [1.0, 1.5])
def test_beyond_a_loop_that_may_be_1_nothing_is_known(size):
    found = beyond(Path.of(spiral([0.25, 0.5, 1], k=size)))
    assert (found.gain_margin, found.phase_margin_deg) == (1.0, 0.0)
    assert (found.ms, found.mt) == (inf, inf)


# The count -----------------------------------------------------------------------------------


def test_the_refined_path_turns_by_little():
    # past -1 at 0.999, by points a quarter turn apart
    loop = spiral([1, 2, 4, 8], k=1.001, slope=0.0, start=-120.0, turn=-40.0)
    path = Path.of(loop)
    gain = _refined(path)
    steps = np.abs(np.angle((1 + gain[1:]) / (1 + gain[:-1])))
    assert steps.max() <= 0.5
    assert len(gain) > len(path.gain)
    assert np.abs(gain) == near(1.001)
    assert (np.diff(np.unwrap(np.angle(gain))) < 0).all()  # in the order of the frequencies


@pytest.mark.parametrize(
    ("loop", "unstable"),
    [
        # k/s^n closes with roots of s^n = -k: 0, 0 on the edge, 2 of 3, 2 of 4
        (spiral([0.25, 0.5, 1, 2, 4], slope=-1.0, start=-90.0), 0),
        (spiral([0.25, 0.5, 1, 2, 4], slope=-3.0, start=-270.0), 2),
        (spiral([0.25, 0.5, 1, 2, 4], slope=-3.0, start=90.0), 2),
        # -k/s: s = k
        (spiral([0.25, 0.5, 1, 2, 4], slope=-1.0, start=90.0), 1),
        # -k/s^3: s^3 = k, one of three
        (spiral([0.25, 0.5, 1, 2, 4], slope=-3.0, start=-90.0), 1),
        # j omega never below 1: nothing encircled, so the two it was told
        (spiral([1, 2, 4], k=0.5, slope=0.0, start=0.0, unstable_poles=2), 2),
    ],
)
def test_unstable_poles_of_powers_by_hand(loop, unstable):
    assert count(Path.of(loop)).unstable == unstable
    assert agreed(Path.of(loop), ()).unstable == unstable


def test_a_path_moved_as_far_as_minus_1_leaves_the_count_open():
    path = Path.of(spiral([1, 2, 4], k=0.5, slope=0.0, start=180.0))

    def other(factor):
        return Path.of(spiral([1, 2, 4], k=0.5 * factor, slope=0.0, start=180.0))

    assert agreed(path, [other(1.9)]).unstable == 0  # moved by 0.45, 0.5 from -1
    assert agreed(path, [other(1.9), other(0.2)]).unstable == 0
    found = agreed(path, [other(1.9), other(2.1)])
    assert found.unstable is None
    assert found.why == (
        "without every second point it may pass -1 on the other side at 1 rad/s: measure more "
        "points there"
    )


def test_noise_that_reaches_minus_1():
    # L = -0.5: 0.5 away, and three sigma of 0.5 reach it from sigma = 1/3 on
    for column, edge in (("uncertainty", 1 / 3), ("neglected", 1.0)):
        for share, unstable in ((0.99, 0), (1.01, None)):
            loop = spiral([1, 2, 4], k=0.5, slope=0.0, start=180.0, **{column: edge * share})
            assert count(Path.of(loop)).unstable == unstable
    both = spiral([1, 2, 4], k=0.5, slope=0.0, start=180.0, uncertainty=0.2, neglected=0.41)
    assert count(Path.of(both)).unstable is None  # 0.6 + 0.41


def test_the_side_of_minus_180_deg_is_told_from_half_a_degree_on():
    w = [0.25, 0.5, 1, 2, 4]
    for off, sigma, decided in (
        (0.6, None, True),
        (0.4, None, False),
        (-0.4, None, False),
        (3.0, radians(0.9), True),
        (3.0, radians(1.1), False),
    ):
        loop = spiral(w, slope=-2.0, start=-180.0 + off, uncertainty=sigma)
        found = count(Path.of(loop))
        if decided:
            assert found.unstable is not None
        else:
            assert found.unstable is None
    quiet = spiral(w, k=0.01, slope=-2.0, start=-180.2)  # 0.16 at 0.25 rad/s: it may be either
    assert count(Path.of(quiet)).unstable == 2  # -180.2 deg: it came round -1 on the left


# The crossings -------------------------------------------------------------------------------


def test_crossings_of_a_spiral():
    # w^-2 at -135 deg - 30 ln w: |L| = 1 at 1 rad/s; -180 deg at ln w = 1.5; T and S by hand
    path = Path.of(spiral([0.25, 1.5, 3, 5, 9, 27], slope=-2.0, start=-135.0, turn=-30.0))
    seen = margins.Seen.of(path)
    assert seen.gain_crossings == ((near(1.0), near(45.0)),)
    assert (seen.crossover, seen.phase_margin_deg) == (near(1.0), near(45.0))
    assert seen.phase_crossings == ((near(exp(1.5)), near(exp(3.0))),)
    assert (seen.phase_crossover, seen.gain_margin) == (near(exp(1.5)), near(exp(3.0)))


def test_the_figures_are_those_of_the_nearest_crossings():
    # two crossings of -180 deg, factors 1/3 and 2: log 3 > log 2; two of |L| = 1
    loop = FrequencyResponse(
        w=[1, 2, 3, 4, 5, 6, 7],
        magnitude=[4, 3, 2, 0.5, 0.5, 2, 0.5],
        phase_deg=[-170, -180, -190, -180, -170, -150, -150],
    )
    seen = margins.Seen.of(Path.of(loop))
    assert [f for _, f in seen.phase_crossings] == near([1 / 3, 2.0])
    assert (seen.phase_crossover, seen.gain_margin) == (near(4.0), near(2.0))
    assert len(seen.gain_crossings) == 3
    assert seen.phase_margin_deg == min((m for _, m in seen.gain_crossings), key=abs)
    assert seen.crossover == min(seen.gain_crossings, key=lambda c: abs(c[1]))[0]
    late = margins.table_margins(loop).delay_margin
    assert late == near(min(radians(m) % (2 * pi) / w for w, m in seen.gain_crossings))


def test_a_margin_is_in_the_half_turn_above():
    assert margins._margin_deg(-1 + 0j) == 0.0
    assert margins._margin_deg(1 + 0j) == 180.0
    assert margins._margin_deg(complex(1.0, -0.0)) == 180.0
    assert margins._margin_deg(complex(1.0, 0.0)) == 180.0
    assert margins._margin_deg(-1j) == near(90.0)
    assert margins._margin_deg(1j) == near(-90.0)


def test_a_valley_is_closed_in_on():
    for place in (1.0, 1.3, 1.999, 2.0):
        at, value = margins._valley(lambda w, p=place: (w - p) ** 2 + 3, 1.0, 2.0)
        assert at == pytest.approx(place, abs=2e-8)  # golden sections to 1e-8
        assert value == near(3.0)


def test_the_lowest_of_all_valleys_is_found():
    # |1 + L| of L = -|L|: the loudest below 1 is nearest to -1; it lies at a point of the table
    size = [0.1, 0.5, 0.1, 0.6, 0.1, 0.8, 0.1, 0.55, 0.1]
    loop = FrequencyResponse(w=list(range(1, 10)), magnitude=size, phase_deg=[-180] * 9)
    path = Path.of(loop)
    at, value = margins._least(lambda g: abs(1 + g), path)
    assert (at, value) == (near(6.0), near(0.2))
    at, value = margins._least(abs, path)
    assert value == near(0.1)
    assert margins._least(lambda g: -abs(g), path)[0] == near(6.0)
    falling = Path.of(spiral([1, 2, 4]))
    assert margins._least(abs, falling) == (near(4.0, rel=1e-7), near(0.25, rel=1e-7))
    rising = Path.of(spiral([1, 2, 4], slope=1.0))
    assert margins._least(abs, rising) == (1.0, near(1.0))


def test_a_loop_on_minus_1_has_no_modulus_margin():
    on = spiral([1, 2, 4, 8, 16], slope=0.0, start=-180.0)
    m = margins.table_margins(on)
    assert m.modulus_margin < 1e-15
    assert (m.beyond.ms, m.beyond.mt, m.beyond.gain_margin) == (inf, inf, 1.0)
    assert margins._inverse(0.0) == inf
    assert margins._inverse(4.0) == 0.25


@pytest.mark.parametrize(
    ("at", "others", "moved"),
    [
        (None, [((1.0, 5.0),)], None),
        (2.0, [((1.0, 5.0), (2.5, 7.0)), ((2.0, 6.5),)], 1.0),
        (2.0, [((2.0, 6.5),), ((1.0, 5.0), (2.5, 3.0))], 3.0),
        (2.0, [((2.0, 6.5),), ()], inf),
        (3.0, [((2.0, 6.5), (5.0, 9.0))], 0.5),  # in log: 3/2 is nearer than 5/3
    ],
)
def test_a_crossing_has_moved_by(at, others, moved):
    assert margins._moved(at, 6.0, others, float) == moved


def test_the_larger_move_of_two_counts():
    # without 2 and 4 nothing moves; without 3 the loop is 0.5 w^-1 all along, with it -1/(2 3)
    base = {"phase_deg": [-90, -90, -100, -90, -90], "w": [1, 2, 3, 4, 5]}
    loop = FrequencyResponse(magnitude=[2, 1.5, 1, 0.75, 0.5], **base)
    path = Path.of(loop)
    seen = margins.Seen.of(path)
    coarse = path.coarser()
    found = margins._left_out(coarse, seen)
    others = [margins.Seen.of(c) for c in coarse]
    assert found.phase_margin_deg == near(10.0)  # at 3 rad/s -100 deg; without it -90 all along
    assert found.gain_margin_db is None
    assert found.ms == max(abs(1 / o.modulus_margin - 1 / seen.modulus_margin) for o in others)
    assert margins._left_out((), seen) is None


# What an error of the points does ------------------------------------------------------------


def test_an_error_moves_the_margins_by_the_slopes():
    # u' = -2, phi' = -30 deg: PM e sqrt(1 + (phi'/u')^2), ln GM e sqrt(1 + (u'/phi')^2)
    path = Path.of(spiral([0.25, 1.5, 3, 5, 9, 27], slope=-2.0, start=-135.0, turn=-30.0))
    seen = margins.Seen.of(path)
    found = spread.spread(path, seen, lambda w: 0.01 * w)
    turn = radians(30)
    # 1e-9: differences of 1e-4 in ln w, whose rounding is 1e-16/1e-4 and some
    assert found.phase_margin_deg == near(degrees(0.01 * hypot(1, turn / 2)), rel=1e-9)
    gain = 20 / log(10) * 0.01 * exp(1.5) * hypot(1, 2 / turn)
    assert found.gain_margin_db == near(gain, rel=1e-9)
    ms, at = 1 / seen.modulus_margin, seen.ms_frequency
    assert found.ms == near(ms**2 * at**-2 * 0.01 * at, rel=1e-9)


def test_without_a_crossing_no_margin_moves():
    path = Path.of(spiral([1, 2, 4], k=0.5))
    found = spread.spread(path, margins.Seen.of(path), lambda w: 0.01)
    assert (found.phase_margin_deg, found.gain_margin_db) == (None, None)
    path = Path.of(spiral([1, 2, 4], slope=0.0, start=-180.0))
    on = margins.Seen.of(path)
    assert spread._sheared(1.0, 0.0) == inf
    assert spread._sheared(4.0, 3.0) == near(5 / 3)
    assert on.modulus_margin < 1e-15


def test_slopes_at_the_ends_of_the_table_are_one_sided():
    path = Path.of(spiral([1, 2, 4], k=3.0, slope=-1.5, start=-20.0, turn=-40.0))
    for w in (1.0, 2.0, 4.0):
        along, across = spread._slopes(path, w)
        assert along == near(-1.5, rel=1e-10)
        assert across == near(-radians(40), rel=1e-10)
