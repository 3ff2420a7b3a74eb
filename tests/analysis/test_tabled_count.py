"""What a tabled loop does outside its table, and the count of its unstable poles, by hand."""

from math import atan2, degrees, hypot, inf, log, pi, radians, sqrt, tan

import numpy as np
import pytest
from spirals import near, spiral

from zoh import FrequencyResponse, Plant, Sampled
from zoh.analysis.tabled.beyond import beyond
from zoh.analysis.tabled.count import _refined, agreed, count
from zoh.analysis.tabled.path import (
    Path,
)


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


def test_beyond_a_positive_constant_there_is_no_factor():
    found = beyond(Path.of(spiral([1, 2, 4], k=0.5, slope=0.0, start=0.0, dt=pi / 4)))
    assert (found.gain_margin, found.ms, found.mt) == (inf, 1.0, near(1 / 3))


def test_beyond_a_crossing_it_is_the_crossing_that_counts():
    # 0.01 s ((10 - s)/(10 + s))^2 in w: -180 deg where 4 atan(v/10) = 270 deg, with |L| = 0.01 w;
    # further up to 40 rad/s |L| comes nearer to 1 and crosses nothing
    dt = pi / 80
    law = Sampled.from_w(num_w=[1.0, -20.0, 100.0], den_w=[1.0, 20.0, 100.0], dt=dt)
    found = beyond(Path.of(law * spiral([40, 60, 80], k=0.01, slope=1.0, start=90.0, dt=dt)))
    w = 2 / dt * atan2(10 * tan(radians(67.5)) * dt, 2)
    step = 10 ** (1 / 40)
    assert 100 / w / step < found.gain_margin < 100 / w


def test_beyond_two_factors_the_one_nearer_to_1_in_decibels_counts():
    # -4/(1 + 0.4 s) ((10 - s)/(10 + s))^2: 1/4 at rest, and 2.6 where it crosses -180 deg
    dt = pi / 80
    law = Sampled.from_w(num_w=[1.0, -20, 100], den_w=[0.4, 9.0, 60.0, 100.0], dt=dt)
    found = beyond(Path.of(law * spiral([60, 70, 80], k=4.0, slope=0.0, start=180.0, dt=dt)))
    v = 26.0
    for _ in range(100):  # v = 10 tan((360 deg - atan 0.4 v)/4)
        v = 10 * tan((2 * pi - atan2(0.4 * v, 1)) / 4)
    truth = hypot(1, 0.4 * v) / 4
    assert truth / 1.1 < found.gain_margin < truth * 1.1  # the nearer end of 1/40 decade, 6 %
    assert 2 < truth < 3


def test_where_the_doubt_is():
    # 0.5 from -1 all along: 3 sigma of 0.5 reach that where sigma passes 1/3. Over ln w it goes
    # from 0.01 at 1 to 0.5 at 2, so at 0.66 of the way: the step of 6/8 is the first beyond
    loop = spiral([1, 2, 4], k=0.5, slope=0.0, start=180.0, uncertainty=[0.01, 0.5, 0.5])
    assert count(Path.of(loop)).why.endswith("the loop may be -1 at 1.68179 rad/s")
    # the other path leaves from 2 rad/s on; the first step beyond is 2 2^(1/8)
    path = Path.of(spiral([1, 2, 4], k=0.5, slope=0.0, start=180.0))
    other = FrequencyResponse(
        w=[1, 2, 2.0001, 4], magnitude=[0.5, 0.5, 1.1, 1.1], phase_deg=[180] * 4
    )
    assert "at 2.18102 rad/s" in agreed(path, [Path.of(other)]).why


def test_a_cell_may_turn_by_sixty_degrees():
    for turn, decided in ((59.5, True), (60.5, False)):
        w, size = [0.25, 0.5, 1, 2, 4], [4, 2, 1, 0.5, 0.25]
        loop = FrequencyResponse(w=w, magnitude=size, phase_deg=[-90] * 2 + [-90 - turn] * 3)
        assert (count(Path.of(loop)).unstable is not None) is decided


def test_an_integrator_too_quiet_for_its_asymptote_is_left_open():
    # 1e-4/(j w) is followed down to 1e-4 rad/s, where it is -j: 1 + L turns by 45 deg of the 90
    assert count(Path.of(spiral([1, 2, 4], k=1e-4))).unstable is None
    assert count(Path.of(spiral([1, 2, 4], k=1e-4))).why == (
        "the turns of 1 + L around 0 do not add up to a whole number"
    )


def test_unstable_poles_of_the_controller_count():
    law = Plant(num=[4], den=[1, -1])  # 1 + 4/(s - 1) is 0 at s = -3
    constant = spiral([1, 2, 4, 8], slope=0.0, start=0.0)
    assert count(Path.of(law * constant)).unstable == 0


def test_a_loop_that_ends_beyond_minus_1_at_nyquist():
    # from -90 deg to -180 deg at Nyquist's frequency, where |L| = 2: it passes -1 on the left
    loop = spiral([1, 1.5, 2, 3, 4], k=8.0, start=-90.0, turn=-90 / log(4), dt=pi / 4)
    assert count(Path.of(loop)).unstable == 1


def test_the_step_from_the_asymptote_to_the_table_is_an_arc():
    # -165.5 deg of the controller and a plant of 0 deg below and -29 deg from its first point on:
    # at |L| = 1.016 the arc from -165.5 to -194.5 deg passes -1 on the left, its chord (0.984) not
    a = tan(radians(90 - 75.5))
    law = Plant(num=[1.016 * hypot(1, a)], den=[1, a, 0])
    plant = spiral([1, 1.5, 2, 4], slope=0.0, start=-29.0)
    assert count(Path.of(law * plant)).unstable == 2


def test_how_near_to_minus_180_deg_it_begins_is_read_off_the_first_point():
    # 1.1 deg of noise, three times, or 0.9 deg, at the first point alone, which is 3 deg away
    for sigma, undecided in ((1.1, True), (0.9, False)):
        only = [radians(sigma), 0, 0, 0, 0]
        loop = spiral([0.25, 0.5, 1, 2, 4], slope=-2.0, start=-177.0, uncertainty=only)
        found = count(Path.of(loop))
        assert (found.unstable is None) is undecided
        assert ("so near to -180 deg" in found.why) is undecided
    # 1.02 and 0.2 deg away, and neither from the next step on
    loop = spiral([1, 2, 4], k=1.02, slope=-2.0, start=-180.2, turn=-10.0)
    assert "it begins at 1 rad/s so near to -180 deg" in count(Path.of(loop)).why
