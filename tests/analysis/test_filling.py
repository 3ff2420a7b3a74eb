"""filling: which samples are put in again, worked by hand on short lists."""

import numpy as np
import pytest

import zoh
from zoh.analysis import filling
from zoh.analysis.closed import closed_loop
from zoh.analysis.filling import filled, wanted
from zoh.analysis.motion import Motion, Track

STATE = np.array([1.0])


def growing(rate):
    """Return the motion z(k) = (1 + rate)^k."""
    return Motion(
        dt=1.0, delta=np.array([[rate]]), start=STATE, own=1, output=STATE, effort=None,
        stretches=(),
    )  # fmt: skip


def track_of(motion, k):
    states = (1 + motion.delta[0, 0]) ** np.array(k, float)[None, :]
    return Track(k=np.array(k), states=states, horizon=int(k[-1]), rests=True)


@pytest.mark.parametrize(
    ("gap", "stride"),
    [(2, 1), (10, 1), (31, 1), (32, 2), (33, 2), (63, 2), (64, 4), (100, 4), (1000, 32)],
)
def test_a_gap_is_filled_with_all_or_with_15_to_31(gap, stride):
    motion = growing(1e-3)
    begin = 7
    track = filled(motion, track_of(motion, [0, begin, begin + gap, begin + gap + 5]), [1])
    inside = list(range(begin + stride, begin + gap, stride))
    assert track.k.tolist() == [0, begin, *inside, begin + gap, begin + gap + 5]
    assert stride == 1 or 15 <= len(inside) <= 31
    assert track.states[0] == pytest.approx(1.001 ** track.k.astype(float), rel=1e-13)
    assert track.rests


def test_several_gaps_are_filled_at_once_and_the_others_left():
    motion = growing(-1e-3)
    track = filled(motion, track_of(motion, [0, 4, 8, 12, 13, 20]), [0, 2, 4])
    assert track.k.tolist() == [0, 1, 2, 3, 4, 8, 9, 10, 11, 12, *range(13, 21)]
    assert track.states[0] == pytest.approx(0.999 ** track.k.astype(float), rel=1e-13)


def test_whether_it_rests_is_kept():
    motion = growing(1e-3)
    moving = Track(k=np.array([0, 9]), states=np.array([[1.0, 1.001**9]]), horizon=9, rests=False)
    assert not filled(motion, moving, [0]).rests


# Samples 0 ... 4, then every tenth: row 4 is the last before which nothing was left out.
K = np.array([0, 1, 2, 3, 4, 14, 24, 34, 44, 54, 64, 74])
STILL = np.zeros(12)


def rows(y, u=STILL, final=1.0, k=K, band=None):
    return wanted(k, np.array([y, u], float), final, 0.02 * abs(final) if band is None else band)


def test_nothing_is_missing_where_nothing_was_left_out():
    y = np.array([0.0, 2.0, 0.0, 2.0])
    assert rows(y, np.zeros(4), k=np.arange(4)) == []
    assert rows(y, np.zeros(4), k=np.arange(5, 9)) == []
    # one left out, and both crossings of 10 and 90 % in it
    assert rows([0.0, 0.0, 0.0, 1.0], np.zeros(4), k=np.array([0, 1, 2, 4])) == [2]


SETTLED = [0.0, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_response_that_has_arrived_needs_nothing_more(sign):
    assert rows(sign * np.array(SETTLED), final=sign) == []


# up through 0.1 between rows 5 and 6, through 0.9 between 8 and 9: the rows on both sides
RISING = np.array([0, 0, 0.01, 0.02, 0.03, 0.05, 0.2, 0.4, 0.85, 0.95, 0.99, 1.0])


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("size", [1.0, 1e-6, 1e5])
def test_where_it_rises_and_where_it_enters_the_band(sign, size):
    # outside 2 % last at row 9
    found = rows(sign * size * RISING, final=sign * size)
    assert set(found) >= {5, 6, 8, 9}
    assert 7 not in found
    assert not {0, 1, 2, 3, 11} & set(found)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_band_around_nothing_is_that_which_is_given(sign):
    y = sign * np.array([0, 1.0, 0.9, 0.8, 0.7, 0.5, 0.3, 0.1, 0.03, 0.01, 0.001, 0])
    # outside 0.02 last at row 8, outside 0.2 at row 6
    assert rows(y, final=0.0, band=0.02) == [7, 8]
    assert rows(y, final=0.0, band=0.2) == [5, 6]
    assert rows(y, final=0.0, band=np.inf) == []


def test_a_rise_that_is_seen_is_not_looked_for():
    y = [0.0, 0.5, 0.95, 0.96, 0.97, 0.972, 0.974, 0.976, 0.978, 0.985, 0.99, 0.995]
    # only the band: outside last at row 8
    assert rows(y) == [7, 8]


def test_inside_the_band_from_the_start_of_what_was_left_out():
    y = [0.0, 0.5, 0.95, 0.975, 0.985, 0.99, 0.995, 0.996, 0.997, 0.998, 0.999, 1.0]
    assert rows(y) == []


def with_crest(row, height, base=0.0):
    a = np.full(12, base)
    a[row - 1 : row + 2] = height / 2, height, height / 2
    return a


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_crest_of_the_effort_higher_than_what_is_known(sign):
    u = with_crest(7, 3.0)
    u[0] = -10.0  # no dip of what was left out goes there
    # beside the crest at row 7 what is highest may be on either side
    assert rows(SETTLED, sign * u) == [6, 7]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_crest_far_below_what_is_known_is_left(sign):
    u = with_crest(7, 1.0)
    u[:2] = -10.0, 1.05  # a crest rises by less than a tenth
    assert rows(SETTLED, sign * u) == [6, 7]
    u[1] = 1.15
    assert rows(SETTLED, sign * u) == []


def test_a_crest_of_the_output_that_overshoots():
    y = np.array(SETTLED)
    y[6:9] = 1.005, 1.01, 1.005
    assert rows(y) == [6, 7]
    y[6:9] = 1.01, 1.019, 1.01  # it may leave the band between two samples
    assert rows(y) == [6, 7]


def test_a_dip_of_the_output_below_all_that_is_known():
    y = np.array(SETTLED)
    y[1] = 3.0  # nothing that was left out goes there
    y[6:9] = 0.0, -1.0, 0.0
    assert set(rows(y)) == {6, 7, 8}  # row 8 is the last outside of the band


def tops(k, a, begin, level):
    return filling._tops(np.array(k), np.array(a, float), begin, level)


def test_a_crest_is_a_row_no_lower_than_its_neighbours():
    k = [0, 1, 2, 3, 4, 5]
    assert tops(k, [0, 2, 0, 0, 2, 0], 0, 1.0) == {1, 4}
    assert tops(k, [0, 2, 2, 0, 1, 0], 0, 1.9) == {1, 2, 4}  # row 4 may reach 2
    assert tops(k, [0, 2, 2, 0, 1, 0], 0, 2.1) == {1, 2}  # row 4 reaches 2 and no more
    assert tops(k, [0, 2, 0, 0, 2, 0], 3, 1.0) == {4}
    assert tops(k, [0, 2, 0, 0, 2, 0], 4, 1.0) == {4}
    assert tops(k, [0, 2, 0, 0, 2, 0], 1, 1.0) == {1, 4}
    assert tops(k, [3, 2, 1, 0, 1, 2], 0, 0.0) == set()  # no crest at the ends


def test_between_two_chords_a_crest_reaches_as_far_as_the_steeper_goes():
    # gaps 1 and 10: up by 1 in one sample could be 10 in the next ten
    assert tops([0, 1, 11], [0, 1, 1], 0, 10.9) == {1}
    assert tops([0, 1, 11], [0, 1, 1], 0, 11.1) == set()
    # down by 10 over ten, seen from the left: 1 in one sample, and 10 at once
    assert tops([0, 1, 11], [1, 1, -9], 0, 10.9) == {1}
    assert tops([0, 1, 11], [1, 1, -9], 0, 11.1) == set()
    assert tops([0, 10, 11], [1, 1, 0], 0, 10.9) == {1}
    assert tops([0, 10, 11], [1, 1, 0], 0, 11.1) == set()
    assert tops([0, 10, 11], [0, 5, 5], 0, 9.9) == {1}
    assert tops([0, 10, 11], [0, 5, 5], 0, 10.1) == set()


def test_rounding_is_no_crest():
    flat = np.ones(6)
    assert tops(range(6), flat, 0, 1.0) == set()
    flat[3] += 4e-14
    assert tops(range(6), flat, 0, 1.0) == set()
    flat[3] = 1 + 1e-12
    assert tops(range(6), flat, 0, 1.0) == {3}


def test_of_many_crests_the_first_and_the_highest_forty():
    a = np.zeros(2 * 100 + 1)
    a[1::2] = 10 + np.arange(100)  # crests at the odd rows, each higher than the one before
    first, highest = set(range(1, 80, 2)), set(range(121, 200, 2))
    assert tops(range(len(a)), a, 0, 1.0) == first | highest
    assert tops(range(len(a)), a[::-1], 0, 1.0) == first


@pytest.mark.parametrize("final", [1.0, -1.0, 1e-6, -1e-6, 1e5])
@pytest.mark.parametrize("effort", [5.0, -5.0, 0.0])
def test_a_rise_seen_just_in_time_is_not_looked_for(final, effort):
    # 0.9 is reached by the last sample before which nothing was left out
    y = final * np.array([0, 0.2, 0.5, 0.8, *np.linspace(0.99, 1.0, 8)])
    assert rows(y, effort * final * np.ones(12), final=final) == []


@pytest.mark.parametrize("final", [1.0, -1.0])
@pytest.mark.parametrize("effort", [5.0, -5.0, 0.0])
def test_a_crest_well_inside_the_band_is_left(final, effort):
    y = np.array([0, 1.5, 1.0, 1.004, *[1.004] * 8])
    y[7] = 1.016
    assert rows(final * y, effort * np.ones(12), final=final) == []
    y[7] = 1.0195  # from there it may leave it
    assert rows(final * y, effort * np.ones(12), final=final) == [6, 7]
    y[7] = 0.981  # and so it may below
    assert rows(final * y, effort * np.ones(12), final=final) == [6, 7]


def test_a_response_inside_the_band_from_its_start():
    y = np.ones(12)
    y[6:9] = 1.01, 1.019, 1.01
    # beside the crest, and where its feet may have dipped
    assert rows(y) == [4, 5, 6, 7, 8, 9]
    # where samples are left out from the first on, the first interval counts as well
    assert rows(y, k=10 * np.arange(12)) == [0, 4, 5, 6, 7, 8, 9]


def test_each_crest_has_its_own_gaps():
    # gaps 1, 1, 10, 100: up by 1 in ten samples could be 10 in the next hundred
    assert tops([0, 1, 2, 12, 112], [0, 0, 0, 1, 1], 0, 10.9) == {3}
    assert tops([0, 1, 2, 12, 112], [0, 0, 0, 1, 1], 0, 11.1) == set()


def test_before_the_second_sample_shown_a_crest_reaches_as_far_as_the_next_chord_goes_on():
    # down by 1 in ten samples from the second on, so up by no more than 1 in the ten before
    for k, a in (([0, 10, 20], [0, 1, 0]), ([0, 10, 20, 60], [0, 1, 0, -9])):
        for level, may in ((1.9, True), (2.1, False)):
            assert filling._first_may(np.array(k), np.array(a, float), level) is may
    # 1 in five samples is 4 in twenty
    for level, may in ((4.9, True), (5.1, False)):
        assert filling._first_may(np.array([0, 20, 25, 26]), np.array([0, 1.0, 0, 0]), level) is may
    assert filling._first_may(np.array([0, 10]), np.array([0, 1.0]), 9.0)  # no chord says so


def test_of_many_equal_crests_the_first():
    a = np.zeros(201)
    a[1::2] = 1.0
    assert tops(range(201), a, 0, 0.5) == set(range(1, 80, 2))


def test_of_a_hundred_thousand_samples_the_first_and_the_highest_hundred():
    a = np.zeros(100_001)
    a[1::2] = 10 + np.arange(50_000)
    first, highest = set(range(1, 200, 2)), set(range(99_801, 100_000, 2))
    assert tops(range(len(a)), a, 0, 1.0) == first | highest


def test_the_effort_is_largest_before_the_second_sample_shown():
    """A lag whose effort rises for 31 samples, and whose track begins with a stride of 64."""
    arm = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    d = zoh.lag(arm, dt=0.0023, wc=1.4447, pm_deg=22.1, dc_gain=23.9)
    motion = closed_loop(arm, d.controller, 0.0)
    state, efforts = motion.start, []
    for _ in range(2000):  # one after the other, nothing left out
        efforts.append(motion.effort @ state)
        state = state + motion.delta @ state
    assert np.argmax(efforts) in range(20, 40)
    assert d.step.peak_effort == pytest.approx(max(efforts), rel=1e-12)
