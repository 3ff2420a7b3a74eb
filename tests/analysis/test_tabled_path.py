"""A tabled loop along its frequencies and its low end, by hand: arithmetic, to rounding."""

from math import atan2, cos, exp, pi, sqrt

import numpy as np
import pytest
from spirals import near, spiral

from zoh import FrequencyResponse, Plant, Sampled
from zoh.analysis.tabled import margins
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


def test_every_distance_from_a_mode_is_looked_at():
    # -1 +- 40 j: 40 and all multiples of its damping 1, and its size
    multiples = [-30, -10, -4, -2, -1, -0.5, -0.2, 0, 0.2, 0.5, 1, 2, 4, 10, 30]
    truth = sorted([*(40 + a for a in multiples), sqrt(1601)])
    assert _corners(Plant(num=[1], den=[1, 2, 1601])) == near(truth)


def test_a_cell_has_a_whole_number_of_steps():
    assert len(_between(np.linspace(1, 2, 9_000))) == 4 * 8_999 + 1  # 40 000/9 000, rounded down


def test_the_low_end_after_many_turns_and_by_its_first_point_alone():
    for off in (-25, 25):
        far = spiral([1, 1.5, 2, 4], k=5.0, start=-90 - 3600 + off)
        assert low_end(far) == LowEnd(integrators=1, gain=5.0)
    turned = FrequencyResponse(w=[1, 1.5, 2], magnitude=[6, 4, 3], phase_deg=[-90, -300, -310])
    assert low_end(turned) == LowEnd(integrators=1, gain=6.0)


def test_the_first_octave_ends_with_the_point_at_twice_the_first():
    def by_hand(w, size):
        x, y = np.log(w), np.log(size)
        return np.polyfit(x, y, 1)[0]

    four = FrequencyResponse(w=[1, 1.5, 2, 4], magnitude=[4, 4, 1, 1], phase_deg=[0] * 4)
    assert low_slope(four) == near(by_hand([1, 1.5, 2], [4, 4, 1]), rel=1e-9)
    beyond_it = FrequencyResponse(w=[1, 1.5, 2.5, 4], magnitude=[4, 3, 9, 1], phase_deg=[0] * 4)
    assert low_slope(beyond_it) == near(by_hand([1, 1.5], [4, 3]), rel=1e-9)


def test_a_loop_is_quiet_where_the_table_begins_whatever_comes_then():
    assert quiet_below(Path.of(spiral([1, 2, 4], k=0.99, slope=0.5)))


def test_a_valley_between_the_points_is_met():
    # 0.5 at -150 deg - 20 ln w: nearest to -1 at ln w = 1.5, on no step of the path
    path = Path.of(spiral([1, 3, 9], k=0.5, slope=0.0, start=-150.0, turn=-20.0))
    at, value = margins._least(lambda g: abs(1 + g), path)
    assert at == near(exp(1.5), rel=1e-7)  # flat there
    assert value == near(0.5)
