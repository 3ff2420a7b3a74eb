"""pieces: every crossing of a polynomial on [0, 1], and no other."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from zoh.analysis.pieces import Piece, bernstein

ROOTS = st.lists(st.floats(-0.5, 1.5), min_size=1, max_size=6)


def of_roots(roots):
    return Piece.of(np.poly(roots)[::-1].tolist())


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
    piece, t = Piece.of(a), np.linspace(0, 1, 201)
    y = np.polynomial.polynomial.polyval(t, a)
    slack = 1e-13 * (1 + np.abs(a).sum())
    assert min(piece.b) <= y.min() + slack
    assert max(piece.b) >= y.max() - slack
    assert (piece.b[0], piece.b[-1]) == pytest.approx((y[0], y[-1]), abs=slack)


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=9))
def test_the_highest_is_no_lower_than_a_grid_and_is_reached(a):
    piece = Piece.of(a)
    t, value = piece.highest()
    slack = 1e-13 * (1 + np.abs(a).sum())
    grid = np.polynomial.polynomial.polyval(np.linspace(0, 1, 1001), a)
    assert 0 <= t <= 1
    assert value == piece.at(t)
    assert value >= grid.max() - slack


@given(st.lists(st.floats(-10, 10), min_size=2, max_size=9), st.floats(0, 1))
def test_the_slope_is_the_derivative(a, t):
    slope = Piece.of(a).slope()
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
    piece = Piece.of([1.0001, -4.0, 4.0])
    low, high = piece.crossings(1e-3)
    assert (low + high) / 2 == pytest.approx(0.5, rel=1e-12)
    assert high - low == pytest.approx((1e-3 - 1e-4) ** 0.5, rel=1e-9)
