"""waveform: extremes, crossings and the last entry of curves drawn by hand."""

from math import factorial, sqrt

import numpy as np
import pytest

from zoh.analysis import waveform
from zoh.analysis.motion import Motion, Stretch, Track
from zoh.analysis.pieces import Piece
from zoh.analysis.waveform import Waveform, bounds

DT = 0.5
WHOLE = (Stretch(begin=0.0, span=1.0, rows=np.eye(3)),)
# the same curve in two parts: a + b t + c t^2 from t = 1/4 on, in steps of 3/4 of a sample
HALVES = (
    Stretch(begin=0.0, span=0.25, rows=np.diag([1, 0.25, 0.0625])),
    Stretch(begin=0.25, span=0.75, rows=np.array([[1, 0.25, 0.0625], [0, 0.75, 0.375],
                                                  [0, 0, 0.5625]])),
)  # fmt: skip
EVERY = pytest.mark.parametrize("stretches", [WHOLE, HALVES], ids=["whole", "halves"])


def wave_of(curves, stretches=WHOLE, final=0.0, band=np.inf, effort=(0.0, 0.0, 1.0)):
    """Return y = a + b t + c t^2 in each sample's share t, with u = c; samples 3, 4, 5 ..."""
    states = np.array(curves, float).T
    motion = Motion(
        dt=DT, delta=np.zeros((3, 3)), start=states[:, 0], own=3,
        output=np.array([1.0, 0.0, 0.0]), stretches=stretches,
        effort=None if effort is None else np.array(effort),
    )  # fmt: skip
    k = np.arange(3, 3 + len(curves))
    return Waveform.of(motion, Track(k=k, states=states, horizon=9, rests=True), final, band)


def curve(a):
    return Piece.of(np.array(a, float))


# up to 1, from 1/2 over 9/8 back to it, along it, and down
BUMP = [(0, 1, 0), (0.5, 2.5, -2.5), (0.5, 0, 0), (0.5, -1, 0), (-0.5, 0, 0)]


@EVERY
def test_what_is_seen_at_the_samples(stretches):
    wave = wave_of(BUMP, stretches)
    assert wave.k.tolist() == [3, 4, 5, 6, 7]
    assert wave.states.T.tolist() == [[*map(float, c)] for c in BUMP]
    assert wave.y.tolist() == [0.0, 0.5, 0.5, 0.5, -0.5]
    assert wave.u.tolist() == [0.0, -2.5, 0.0, 0.0, 0.0]
    assert (wave.top, wave.bottom) == ((4 * DT, 0.5), (7 * DT, -0.5))
    assert wave.highest(1.0) == (4 * DT, 0.5)
    assert wave.highest(-1.0) == (7 * DT, 0.5)
    assert wave_of(BUMP, stretches, effort=None).u.tolist() == [0.0] * 5


@EVERY
def test_an_extreme_between_the_samples(stretches):
    """1/2 + (5/2)(t - t^2) is 9/8 at t = 1/2."""
    upright = wave_of(BUMP, stretches)
    assert upright.highest_between(1.0) == pytest.approx((4.5 * DT, 1.125), rel=1e-12)
    assert upright.highest_between(-1.0) == pytest.approx((7 * DT, 0.5), rel=1e-12)
    over = wave_of(-np.array(BUMP, float), stretches)
    assert over.highest_between(-1.0) == pytest.approx((4.5 * DT, 1.125), rel=1e-12)
    assert over.highest_between(1.0) == pytest.approx((7 * DT, 0.5), rel=1e-12)


@EVERY
def test_of_many_crests_the_highest(stretches):
    """Crests c/4 of c (t - t^2) in samples 3 ... 8: the fourth is the highest."""
    crests = [(0, c, -c) for c in (1.0, 3.0, 2.0, 4.0, 0.5, 3.9)]
    wave = wave_of(crests, stretches)
    assert wave.highest_between(1.0) == pytest.approx((6.5 * DT, 1.0), rel=1e-12)
    assert wave.highest_between(-1.0) == (3 * DT, 0.0)


def test_a_crest_that_stands_out_by_rounding_alone_is_none():
    flat = [(1, 0, 0), (1, 4e-15, -4e-15), (1, 0, 0)]  # 1e-15 at its middle
    assert wave_of(flat).highest_between(1.0) == (3 * DT, 1.0)
    # the size of the output, and not of what is asked for, says what rounding is
    deep = [(0, 0, 0), (1e-3, 4e-12, -4e-12), (-1e3, 0, 0)]
    assert wave_of(deep).highest_between(1.0) == (4 * DT, 1e-3)
    seen = [(0, 0, 0), (1e-3, 4e-12, -4e-12), (-0.1, 0, 0)]
    t, value = wave_of(seen).highest_between(1.0)
    assert t == pytest.approx(4.5 * DT, rel=1e-3)  # flat: the slope is 1e-12 of terms of rounding
    assert value - 1e-3 == pytest.approx(1e-12, rel=1e-5)  # half an ulp of 1e-3 in 1e-12


def test_the_first_of_equal_extremes():
    wave = wave_of([(1, -1, 0), (0, 1, 0), (1, -2, 0), (-1, 1, 0), (0, -1, 0), (-1, 0, 0)])
    assert wave.highest(1.0) == wave.highest_between(1.0) == (3 * DT, 1.0)
    assert wave.highest(-1.0) == wave.highest_between(-1.0) == (6 * DT, 1.0)
    inside = wave_of([(1, -1, 0), (0, 4, -4), (0, 0, 0)])  # 1 again half way
    assert inside.highest_between(1.0) == (3 * DT, 1.0)


@EVERY
def test_when_a_level_is_reached(stretches):
    """1/2 + (5/2)(t - t^2) = 1.05 where (t - 1/2)^2 = 0.03."""
    for sign in (1.0, -1.0):
        wave = wave_of(sign * np.array(BUMP, float), stretches)
        assert wave.reaches(0.5, sign) == 4 * DT
        assert wave.reaches(0.0, sign) == 3 * DT
        assert wave.reaches(0.51, sign) is None
        assert wave.reaches(0.5, -sign) == 7 * DT
        assert wave.reaches_between(1.05, sign) == pytest.approx((4.5 - sqrt(0.03)) * DT, rel=1e-12)
        assert wave.reaches_between(0.25, sign) == pytest.approx(3.25 * DT, rel=1e-12)
        assert wave.reaches_between(0.0, sign) == 3 * DT
        assert wave.reaches_between(1.1251, sign) is None
        assert wave.reaches_between(0.25, -sign) == pytest.approx(6.75 * DT, rel=1e-12)


def test_a_level_reached_by_a_jump():
    """From one part of a sample to the next the output may jump: to 2 at 1/4 of the fifth."""
    jump = (
        Stretch(begin=0.0, span=0.25, rows=np.array([[1.0, 0, 0]])),
        Stretch(begin=0.25, span=0.75, rows=np.array([[1.0, 1.0, 0]])),
    )
    wave = wave_of([(0, 0, 0), (0, 0.5, 0), (0, 2, 0), (0, 0, 0)], jump)
    assert wave.reaches_between(1.0, 1.0) == 5.25 * DT
    assert wave.reaches_between(0.5, 1.0) == 4.25 * DT
    assert wave.highest_between(1.0) == (5.25 * DT, 2.0)
    assert wave.settles_between(0.0, 0.6) == 6 * DT  # what jumped stays until then
    # a bound above a level that the curve does not reach: 4 (t - t^2) has coefficients to 2
    crest = [(0, 4, -4), (0, 4, -4), (0, 8, -8)]
    assert wave_of(crest).reaches_between(1.5, 1.0) == pytest.approx(5.25 * DT, rel=1e-12)


# down from 2 to 1, over 5/4 back to it, and along it
ENTRY = [(2, -1, 0), (1, 1, -1), (1, 0, 0), (1, 0, 0)]


@EVERY
def test_from_when_on_a_band_is_kept(stretches):
    """1 + t - t^2 is 1.09 at t = 0.9, 2 - t is 1.3 at t = 0.7."""
    for sign in (1.0, -1.0):
        wave = wave_of(sign * np.array(ENTRY, float), stretches)
        assert wave.settles(sign, 0.2) == 4 * DT
        assert wave.settles(sign, 1.0) == 3 * DT
        assert wave.settles(0.0, 0.5) is None
        assert wave.settles_between(sign, 0.3) == pytest.approx(3.7 * DT, rel=1e-12)
        assert wave.settles_between(sign, 0.09) == pytest.approx(4.9 * DT, rel=1e-12)
        assert wave.settles_between(sign, 1.0) == 0.0
        assert wave.settles_between(sign * 1.5, 0.3) is None  # outside at the end
        assert wave.closer(sign * 1.5, 0.3) is wave  # after which nothing was left out
        # only the last sample is outside
        last = wave_of(sign * np.array([*ENTRY[:3], (1, 1, 0)], float), stretches)
        assert last.settles_between(sign, 0.5) is None
        assert last.settles(sign, 0.5) == 4 * DT
    below = wave_of([(0, 1, 0), (1, -1, 1), (1, 0, 0)], stretches)  # 1 - t + t^2: 0.91 at 0.9
    assert below.settles_between(1.0, 0.09) == pytest.approx(4.9 * DT, rel=1e-12)


def test_outside_at_a_parts_end_is_outside_until_then():
    assert waveform._last_outside(curve([0.0, 2.0]), 0.0, 1.5) == 1.0
    assert waveform._last_outside(curve([2.0, -2.0]), 0.0, 1.5) == pytest.approx(0.25, rel=1e-12)
    assert waveform._last_outside(curve([0.0, 1.0]), 0.0, 1.5) is None
    assert waveform._last_outside(curve([-2.0, 3.0]), 0.0, 1.5) == pytest.approx(1 / 6, rel=1e-12)
    # through both edges: (8 t - 4) - 0 leaves at -1.5, and is above 1.5 from 0.6875 on
    assert waveform._last_outside(curve([-4.0, 5.0]), 0.0, 1.5) == pytest.approx(0.5, rel=1e-12)
    # out and in again above: 8 (t - t^2) = 1.5 at t = 3/4
    assert waveform._last_outside(curve([0.0, 8.0, -8.0]), 0.0, 1.5) == pytest.approx(
        0.75, rel=1e-12
    )
    # at its begin alone, which no crossing shows
    assert waveform._last_outside(Piece([2.0, -2.0], [1.0, 0.0]), 0.0, 1.5) == 0.0


def test_bounds_are_the_least_and_the_largest_of_bernsteins(monkeypatch):
    """Of a + b t + c t^2: a, a + b/2 and a + b + c."""
    curves = np.array([(0, 4, -4), (1, -2, 4), (-1, 0, 0), (5, 1, 1), (0, 0, -7)], float)
    motion = wave_of(curves).motion
    low, high = [0, 0, -1, 5, -7], [2, 3, -1, 7, 0]
    for cells in (1, 3, 6, 7, 4_000_000):  # one sample at a time, one, two, two and all
        monkeypatch.setattr(waveform, "_CELLS", cells)
        found = bounds(motion, curves.T)
        assert found[0].tolist() == low
        assert found[1].tolist() == high
    wave = wave_of(curves)
    assert (wave.low.tolist(), wave.high.tolist()) == (low, high)


def test_where_nothing_is_known_between_the_samples_they_are_all_there_is():
    wave = wave_of(BUMP, ())
    assert wave.low.tolist() == wave.high.tolist() == wave.y.tolist()
    assert wave.highest_between(1.0) == (4 * DT, 0.5)


def swinging(k):
    """Return the motion y = sin(pi k/50) known at a few samples k, and the track."""
    turn = 2 * np.pi / 100
    cos, sin = np.cos(turn), np.sin(turn)
    signs = (1, 0), (0, 1), (-1, 0), (0, -1)
    rows = [turn**j / factorial(j) * np.array(signs[j % 4]) for j in range(10)]  # of Taylor
    motion = Motion(
        dt=DT, delta=np.array([[cos - 1, sin], [-sin, cos - 1]]), start=np.array([0.0, 1.0]),
        own=2, output=np.array([1.0, 0.0]), effort=None,
        stretches=(Stretch(begin=0.0, span=1.0, rows=np.array(rows)),),
    )  # fmt: skip
    states = np.array([np.sin(turn * k), np.cos(turn * k)])
    return motion, Track(k=k, states=states, horizon=int(k[-1]), rests=True)


def test_what_was_left_out_is_filled_in_where_it_is_asked_for():
    """sin is largest at the 25th of a hundred samples, which is not shown."""
    motion, track = swinging(np.array([0, 16, 32, 48, 64]))
    wave = Waveform.of(motion, track, 0.0, np.inf)
    assert wave.highest(1.0) == pytest.approx((25 * DT, 1.0), rel=1e-12)
    assert {*range(16, 33)} <= {*wave.k.tolist()}
    assert wave.y == pytest.approx(np.sin(np.pi * wave.k / 50), abs=1e-12)


def test_closer_fills_where_the_band_is_entered():
    """|sin(pi k/50)| is 1/2 at k = 50/6 and, for the last time by k = 48, at 250/6."""
    motion, track = swinging(np.array([0, 16, 32, 48]))
    wave = Waveform.of(motion, track, 0.0, np.inf)
    near = wave.closer(0.0, 0.5)
    assert near.settles(0.0, 0.5) == 42 * DT
    assert near.settles_between(0.0, 0.5) == pytest.approx(250 / 6 * DT, rel=1e-12)
    assert near.closer(0.0, 0.5) is near
    assert wave.closer(0.0, np.inf) is wave


@pytest.mark.parametrize("shown", [[0, 16, 32, 48], [0, 18, 20, 22, 24], [0, 21, 22], [0, 20, 25]])
def test_closer_fills_where_only_a_ripple_leaves_the_band(shown):
    """y = 4 x (t - t^2), 0 at every sample; x falls to 1/2 in 21.5 samples."""
    rate = 0.5 ** (1 / 21.5)
    motion = Motion(
        dt=DT, delta=np.array([[rate - 1]]), start=np.ones(1), own=1, output=np.zeros(1),
        effort=None, stretches=(Stretch(begin=0.0, span=1.0, rows=np.array([[0.0], [4], [-4]])),),
    )  # fmt: skip
    k = np.array(shown)
    track = Track(k=k, states=rate ** k[None, :].astype(float), horizon=shown[-1], rests=True)
    wave = Waveform.of(motion, track, 0.0, 0.5).closer(0.0, 0.5)
    t = 0.5 + sqrt(0.25 - 0.125 / rate**21)
    assert wave.settles_between(0.0, 0.5) == pytest.approx((21 + t) * DT, rel=1e-12)
    assert wave.settles(0.0, 0.5) == 0.0


def test_closer_fills_where_samples_enter_the_band():
    """y = 2^(-k/20.5) has no crest; it is 1/2 at 20.5."""
    slope = -np.log(2) / 20.5
    rows = np.array([[slope**j / factorial(j)] for j in range(10)])
    motion = Motion(
        dt=DT, delta=np.array([[np.expm1(slope)]]), start=np.ones(1), own=1,
        output=np.ones(1), effort=None, stretches=(Stretch(begin=0.0, span=1.0, rows=rows),),
    )  # fmt: skip
    k = np.array([0, 16, 32, 48, 64])
    states = np.exp(slope * k)[None, :]
    wave = Waveform.of(motion, Track(k=k, states=states, horizon=64, rests=True), 0.0, np.inf)
    assert wave.k.tolist() == k.tolist()  # nothing else asks for more
    assert wave.settles(0.0, 0.5) == 32 * DT
    near = wave.closer(0.0, 0.5)
    assert near.k.tolist() == [*range(33), 48, 64]  # outside last at 16: both sides of it
    assert near.settles(0.0, 0.5) == 21 * DT
    assert near.settles_between(0.0, 0.5) == pytest.approx(20.5 * DT, rel=1e-12)


@EVERY
@pytest.mark.parametrize("at_once", [1, 7, 1 << 16])
def test_of_very_many_crests_the_highest(monkeypatch, stretches, at_once):
    """Crests c/4 of c (t - t^2) in 200 samples; the 137th, of 2, is the highest."""
    monkeypatch.setattr(waveform, "_AT_ONCE", at_once)
    heights = [1 + (i * 37 % 200) / 400 for i in range(200)]  # below 3/2
    heights[136] = 2.0
    crests = np.array([(0, 4 * c, -4 * c) for c in heights], float)
    for sign in (1.0, -1.0):
        wave = wave_of(sign * crests, stretches)
        loose = wave._bound(sign).tolist()
        assert wave.highest_between(sign) == pytest.approx((139.5 * DT, 2.0), rel=1e-12)
        assert wave.highest_between(-sign) == (3 * DT, 0.0)
        rows = np.arange(100, 200)
        bound = wave._tightened(wave._bound(sign), rows, sign)
        assert wave._bound(sign).tolist() == loose  # still
        assert bound[:100].tolist() == loose[:100]
        assert bound[100:] == pytest.approx(np.array(heights[100:]), rel=1e-12)  # at their tops
