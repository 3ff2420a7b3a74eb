"""pieces: every crossing of a polynomial on [0, 1], and no other."""

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import zoh
from zoh.analysis import pieces
from zoh.analysis.pieces import Piece, bernstein, highest_bounds

ROOTS = st.lists(st.floats(-0.5, 1.5), min_size=1, max_size=6)


def curve(a):
    return Piece.of(np.array(a, float))


def of_roots(roots):
    return curve(np.poly(roots)[::-1].tolist())


@given(ROOTS)
def test_finds_every_root_inside_and_none_outside(roots):
    spaced = sorted([*roots, 0.0, 1.0])
    assume(min(b - a for a, b in pairwise(spaced)) > 0.02)
    found = list(of_roots(roots).crossings(0.0))
    wanted = sorted(r for r in roots if 0 < r < 1)
    # 1e-9: six roots 0.02 apart move by 1e7 times the rounding of their coefficients
    assert found == pytest.approx(wanted, abs=1e-9)


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=9))
def test_the_bounds_hold_and_meet_the_ends(a):
    piece, t = curve(a), np.linspace(0, 1, 201)
    y = np.polynomial.polynomial.polyval(t, a)
    slack = 1e-13 * (1 + np.abs(a).sum())
    assert min(piece.b) <= y.min() + slack
    assert max(piece.b) >= y.max() - slack
    assert (piece.b[0], piece.b[-1]) == pytest.approx((y[0], y[-1]), abs=slack)


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=9))
def test_the_highest_is_no_lower_than_a_grid_and_is_reached(a):
    piece = curve(a)
    t, value = piece.highest()
    slack = 1e-13 * (1 + np.abs(a).sum())
    grid = np.polynomial.polynomial.polyval(np.linspace(0, 1, 1001), a)
    assert 0 <= t <= 1
    assert value == piece.at(t)
    assert value >= grid.max() - slack


@given(st.lists(st.floats(-10, 10), min_size=2, max_size=9), st.floats(0, 1))
def test_the_slope_is_the_derivative(a, t):
    slope = curve(a).slope()
    wanted = np.polynomial.polynomial.polyval(t, np.polynomial.polynomial.polyder(a))
    assert slope.at(t) == pytest.approx(wanted, abs=1e-12 * np.abs(a).sum() * len(a))
    assert slope.b == pytest.approx(bernstein(len(slope.a)) @ slope.a, abs=1e-11)


def test_a_level_that_is_touched_is_not_crossed():
    # (t - 1/3)^2 touches 0 and crosses 1/36 at 1/6 and 1/2
    piece = of_roots([1 / 3, 1 / 3])
    assert len(list(piece.crossings(-1e-9))) == 0
    assert list(piece.crossings(1 / 36)) == pytest.approx([1 / 6, 1 / 2], rel=1e-12)


def test_two_crossings_between_neighbours_of_one_sign():
    """Both ends and both end slopes say nothing; 1.0001 - 4 t (1 - t) dips below 1e-3 inside."""
    piece = curve([1.0001, -4.0, 4.0])
    low, high = piece.crossings(1e-3)
    assert (low + high) / 2 == pytest.approx(0.5, rel=1e-12)
    assert high - low == pytest.approx((1e-3 - 1e-4) ** 0.5, rel=1e-9)


def test_crossings_to_the_last_digits():
    assert list(curve([-0.3, 0.0, 1.0]).crossings(0.0)) == pytest.approx([0.3**0.5], rel=1e-15)
    assert list(curve([0.0, 0.0, 0.0, 8.0]).crossings(0.125)) == pytest.approx([0.25], rel=1e-15)
    assert list(curve([1.0, -1.0]).crossings(0.875)) == pytest.approx([0.125], rel=1e-15)
    # 7/8 - (1 - t)^3 with its flat end inside: at 1/2 the slope is 3/4, beyond 1 it is 0
    flat = curve([1.0, -3.0, 3.0, -1.0])
    assert list(flat.crossings(1 / 8)) == pytest.approx([0.5], rel=1e-15)
    # a saddle: (t - 1/2)^3 crosses where its slope is 0
    saddle = of_roots([0.5, 0.5, 0.5])
    assert list(saddle.crossings(0.0)) == pytest.approx([0.5], abs=1e-5)  # the cube root of 1e-16
    assert list(saddle.crossings(-1 / 64)) == pytest.approx([0.25], rel=1e-14)
    assert list(saddle.crossings(1 / 64)) == pytest.approx([0.75], rel=1e-14)


def test_a_crossing_at_an_end_counts_where_the_sign_changes_inside():
    line = curve([0.0, 1.0])
    assert list(line.crossings(0.0)) == []  # from 0 upwards: no change
    assert list(line.crossings(1.0)) == [1.0]  # below before it, not below at it
    assert list(curve([0.0, -1.0]).crossings(0.0)) == pytest.approx([0.0], abs=1e-12)
    assert list(curve([2.0]).crossings(2.0)) == []


def test_steep_and_far_apart_scales():
    # 1 - exp(-40 t) to 60 terms is no polynomial for floats; a ninth power is steep enough
    steep = curve([0.0] * 9 + [1.0])
    (t,) = steep.crossings(1e-9)
    assert t == pytest.approx(0.1, rel=1e-14)
    (t,) = steep.crossings(0.5)
    assert t == pytest.approx(0.5 ** (1 / 9), rel=1e-15)


def test_three_crossings_in_order():
    # T_3 on [0, 1]: 32 t^3 - 48 t^2 + 18 t - 1, zero at (1 + cos(pi (2 i + 1)/6))/2
    found = list(curve([-1.0, 18.0, -48.0, 32.0]).crossings(0.0))
    assert found == pytest.approx([0.5 - 3**0.5 / 4, 0.5, 0.5 + 3**0.5 / 4], rel=1e-14)


def test_the_slope_of_a_constant_is_nothing():
    slope = curve([3.0]).slope()
    assert (slope.a, slope.b) == ([0.0], [0.0])
    assert curve([3.0]).highest() == (0.0, 3.0)
    assert curve([1.0, 2.0]).slope().a == [2.0]
    assert curve([1.0, 2.0]).highest() == (1.0, 3.0)
    assert curve([1.0, -2.0]).highest() == (0.0, 1.0)


def test_bernsteins_coefficients_by_hand():
    assert bernstein(1).tolist() == [[1.0]]
    assert bernstein(2).tolist() == [[1.0, 0.0], [1.0, 1.0]]
    assert bernstein(4)[2].tolist() == pytest.approx([1, 2 / 3, 1 / 3, 0], rel=1e-16)
    with pytest.raises(ValueError, match="read-only"):
        bernstein(3)[0, 0] = 2.0


def test_a_half_by_hand(monkeypatch):
    """De Casteljau on (0, 0, 1), t^2: (t/2)^2 has (0, 0, 1/4), ((1 + t)/2)^2 has 1/4, 1/2, 1."""
    assert pieces._halved([0.0, 0.0, 1.0]) == ([0.0, 0.0, 0.25], [0.25, 0.5, 1.0])
    monkeypatch.setattr(Piece, "_root", lambda piece, level, *bracket: bracket)
    crossings = Piece([], [])._crossings
    assert list(crossings(0.0, [-1.0, 1.0], 0.0, 1.0)) == [(0.0, 1.0, (-1.0, 1.0))]
    assert list(crossings(0.0, [1.0, -1.0], 0.25, 0.5)) == [(0.25, 0.5, (1.0, -1.0))]
    assert list(crossings(0.0, [1.0, 2.0, 0.0], 0.0, 1.0)) == []
    # (1 - 2 t)^2 - 1/4 falls in the left half and rises in the right
    halves = [(0.0, 0.5, (0.75, -0.25)), (0.5, 1.0, (-0.25, 0.75))]
    assert list(crossings(0.0, [0.75, -1.25, 0.75], 0.0, 1.0)) == halves


@pytest.mark.parametrize("root", [1 / 3, 0.3, 0.7, 0.1, 0.6180339887498949])
def test_a_touch_that_rounding_makes_two_crossings_or_none(root):
    for a in ([root, root], [root, root, 2.0], [root] * 4):
        found = list(of_roots(a).crossings(0.0))
        assert len(found) % 2 == 0
        # 1e-3: the fourth root of rounding
        assert found == pytest.approx([root] * len(found), abs=1e-3)


def test_bounds_of_many_hold_and_are_those_of_the_tops_where_they_are_concave():
    rng = np.random.default_rng(2)
    tops = rng.uniform(-0.5, 1.5, 200)  # of -(t - top)^2 + 3 - 0.1 (t - top)^4, some outside [0, 1]
    t = np.linspace(0, 1, 2001)
    columns = [
        np.polynomial.Polynomial([3, 0, -1, 0, -0.1])(np.polynomial.Polynomial([-x, 1])).coef
        for x in tops
    ]
    off = np.clip(tops, 0, 1) - tops  # from the top to the nearest of the interval
    truth = 3 - off**2 - 0.1 * off**4
    assert highest_bounds(np.array(columns).T) == pytest.approx(truth, abs=1e-14)
    wild = rng.normal(size=(7, 500))
    seen = np.polynomial.polynomial.polyval(t, wild).max(axis=1)
    assert (highest_bounds(wild) >= seen - 1e-14).all()


def test_of_a_motion_that_does_not_die_one_crest_is_looked_into(monkeypatch):
    """1 - cos t for a million samples: each of 159000 crests has the height of the first."""
    looked, highest = [], Piece.highest
    monkeypatch.setattr(Piece, "highest", lambda self: looked.append(1) or highest(self))
    found = zoh.step_info(zoh.Plant(num=[1], den=[1, 1e-80, 1]))
    assert len(looked) < 1000
    # crests as high but for the rounding of a million steps: which is the highest it decides
    assert found.peak == pytest.approx(2, rel=1e-9)
    assert found.peak_time % (2 * pi) == pytest.approx(pi, abs=1e-8)  # a million roundings
    assert found.settling_time is None


def test_a_top_beyond_the_end_is_the_value_there():
    """5 t - t^2 - 2 t^3 + t^4 bends down on [0, 1], still rises by 1 at its end, 3, and bends up
    further on: a tangent there would pass below.
    """
    assert highest_bounds(np.array([[0.0], [5.0], [-1.0], [-2.0], [1.0]])).tolist() == [3.0]
