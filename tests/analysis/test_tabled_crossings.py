"""The crossings and peaks of tabled loops, and what an error of the points does to them."""

from dataclasses import replace
from math import cos, degrees, exp, hypot, inf, log, pi, radians

import numpy as np
import pytest
from spirals import near, spiral

from zoh import FrequencyResponse
from zoh.analysis.squares import DROP
from zoh.analysis.tabled import margins, spread
from zoh.analysis.tabled.path import (
    Path,
)
from zoh.lti.systems import Plant
from zoh.sampling.hold import sample


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


def test_the_last_of_three_crossings_may_have_the_smallest_margin():
    loop = FrequencyResponse(
        w=[1, 2, 3, 4, 5, 6, 7],
        magnitude=[4, 0.5, 0.5, 2, 2, 0.5, 0.5],
        phase_deg=[-90, -90, -90, -120, -120, -150, -150],
    )
    seen = margins.Seen.of(Path.of(loop))
    assert len(seen.gain_crossings) == 3
    assert (seen.crossover, seen.phase_margin_deg) == seen.gain_crossings[2]


def test_peaks_of_a_positive_loop_by_hand():
    # L = 1/w: T = 1/(1 + w), largest at 0.5; |1 + L|/|1 - L| is 3 there and 9/7 at 8, least
    loop = spiral([0.5, 1, 2, 4, 8], start=0.0, neglected=0.01)
    m = margins.table_margins(loop)
    assert (m.mt, m.mt_frequency) == (near(2 / 3), 0.5)
    assert m.disk_margin == near(18 / 7, rel=1e-7)
    assert m.bandwidth == near(1 / (DROP**0.5 * 2 / 3) - 1)
    assert m.neglected.phase_margin_deg == near(degrees(0.01))


def test_noise_beside_the_axis_at_nyquist_is_no_crossing():
    # it crosses once between 2 and 3 rad/s; -178 deg at Nyquist's frequency stands for -180
    size, phase_deg = [4, 2, 0.5, 0.25], [-90, -150, -185, -178]
    loop = FrequencyResponse(w=[1, 2, 3, 4], magnitude=size, phase_deg=phase_deg, dt=pi / 4)
    found = margins.Seen.of(Path.of(loop)).phase_crossings
    assert len(found) == 2
    assert 2 < found[0][0] < 3
    assert found[1] == (4.0, near(4.0 / cos(radians(2))))
    # and where it comes to the axis from below there is none but that of Nyquist's frequency
    phase_deg = [-90, -150, -175, -178]
    loop = FrequencyResponse(w=[1, 2, 3, 4], magnitude=size, phase_deg=phase_deg, dt=pi / 4)
    assert len(margins.Seen.of(Path.of(loop)).phase_crossings) == 1


def test_gain_margins_move_in_decibels():
    loop = FrequencyResponse(
        w=[1, 2, 3, 4, 5],
        magnitude=[2, 1.5, 0.5, 0.4, 0.3],
        phase_deg=[-170, -175, -180, -185, -190],
    )
    path = Path.of(loop)
    seen = margins.Seen.of(path)
    assert seen.gain_margin == near(2.0)
    others = [margins.Seen.of(c).gain_margin for c in path.coarser()]
    moved = max(abs(20 * log(f / 2) / log(10)) for f in others)
    assert moved > 0.1
    assert margins._left_out(path.coarser(), seen).gain_margin_db == near(moved, rel=1e-9)


def test_a_loop_on_minus_1_has_no_bound_on_its_peak():
    path = Path.of(spiral([1, 2, 4], k=0.5))
    seen = margins.Seen.of(path)
    on = spread.spread(path, replace(seen, modulus_margin=0.0), lambda w: 0.01)
    assert on.ms == inf
    level = spread.spread(path, replace(seen, modulus_margin=1.0), lambda w: 0.01)
    assert level.ms == near(0.01 * 0.5 / seen.ms_frequency)


def test_slopes_are_those_at_the_place_and_not_around_it():
    # 1/(1 + j w): d ln|L|/d ln w = -w^2/(1 + w^2), d arg L/d ln w = -w/(1 + w^2), both -1/2 at 1
    w = np.geomspace(0.1, 10, 201)
    path = Path.of(FrequencyResponse.from_complex(w=w, gain=1 / (1 + 1j * w)))
    # 1e-3: cubics over steps of 2.3 % of w, whose slope is off by the square of that
    assert spread._slopes(path, 1.0) == (near(-0.5, rel=1e-3), near(-0.5, rel=1e-3))


@pytest.mark.parametrize("lowest", [0.05, 0.2])
def test_the_bandwidth_of_a_loop_that_integrates_is_counted_from_1(lowest):
    """2/(s (s + 1)) held for 0.1 s, whose |T| above the lowest point is not 1 there already."""
    plant = sample(Plant(num=[2], den=[1, 1, 0]), 0.1)
    w = np.geomspace(lowest, 31.4, 400)
    m = margins.table_margins(FrequencyResponse.from_complex(w=w, gain=plant.at(w), dt=0.1))
    # |G/(1 + G)|^2 falls to 10^-0.3 there by mpmath's findroot, G = 2 ((dt - 1 + a) z + 1 - a -
    # a dt)/((z - 1)(z - a)), a = exp(-dt); 1e-8: a cubic over 1.6 % of w
    assert m.bandwidth == pytest.approx(2.032718300395038, rel=1e-8)
    assert not any("the bandwidth is counted" in line for line in m.warnings)


def test_where_the_low_end_does_not_say_the_bandwidth_says_where_it_is_counted_from():
    plant = sample(Plant(num=[2], den=[1, 1, 0]), 0.1)
    w = np.geomspace(0.5, 31.4, 400)
    m = margins.table_margins(FrequencyResponse.from_complex(w=w, gain=plant.at(w), dt=0.1))
    assert m.bandwidth < 2.0
    assert m.warnings[-1] == (
        "the low end does not say |T| at 0: the bandwidth is counted from it at 0.5 rad/s"
    )
