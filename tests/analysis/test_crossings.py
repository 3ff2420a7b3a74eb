"""Roots between grid points and least values, of functions whose own are known."""

from math import cos, inf, pi, sin

import numpy as np
import pytest

from zoh.analysis import crossings
from zoh.analysis.crossings import (
    _inverse_quadratic,
    _valleys,
    bracketed,
    least,
    merged,
    sign_changes,
)


class Counted:
    """A function that counts how often it is asked, and where last."""

    def __init__(self, f):
        self.f, self.times = f, 0

    def __call__(self, x):
        self.times += 1
        return self.f(x)


ROOTS = [
    (lambda x: x * x - 2, 0.0, 2.0, 2**0.5, 12),
    (lambda x: 2 - x * x, 0.0, 2.0, 2**0.5, 12),
    (lambda x: x * x - 2, 2.0, 0.0, 2**0.5, 12),
    (lambda x: cos(x) - x, 0.0, 1.0, 0.7390851332151607, 10),
    (lambda x: x**9 - 1e-9, 0.0, 1.0, 0.1, 30),
    (lambda x: (x - 1) ** 3, 0.0, 3.0, 1.0, 200),
    (lambda x: x - 1e-30, 0.0, 1.0, 1e-30, 130),
    (lambda x: x**3 - 2 * x - 5, 2.0, 3.0, 2.0945514815423265, 12),
    (lambda x: 1e-12 - x, 1e-300, 1e3, 1e-12, 110),
    (lambda x: -1.0 if x < 0.3 else 1.0, 0.0, 1.0, 0.3, 60),
]


@pytest.mark.parametrize(("f", "a", "b", "root", "most"), ROOTS)
def test_a_bracket_closes_in_on_its_root(f, a, b, root, most):
    f = Counted(f)
    assert bracketed(f, a, b) == pytest.approx(root, rel=4e-16)
    assert f.times <= most


def test_a_wide_bracket_is_enough_where_little_is_asked():
    f = Counted(lambda x: x**3 - 2 * x - 5)
    assert bracketed(f, 2.0, 3.0, 1e-3) == pytest.approx(2.0945514815423265, rel=1e-3)
    assert f.times <= 7


def test_a_sign_lost_to_rounding_leaves_an_end():
    assert bracketed(lambda x: x, 0.0, 1.0) == 0.0
    assert bracketed(lambda x: x - 1, 0.0, 1.0) == 1.0
    assert bracketed(lambda x: x + 1, 1.0, 2.0) == 1.0
    assert bracketed(lambda x: x - 3, 1.0, 2.0) == 2.0
    assert bracketed(lambda x: 3.0, 1.0, 2.0) == 1.0
    assert bracketed(lambda x: x - 0.5, 0.0, 1.0) == 0.5


def test_a_step_is_interpolated_where_that_is_safe():
    # x - 1.25 known at 1, 2 and 3: from 2 on, three quarters of the way to 1
    assert _inverse_quadratic(2.0, 0.75, 1.0, -0.25, 3.0, 1.75) == pytest.approx(0.75)
    # x = (y + 2)^2 through y = -1, 1 and 2 (x = 1, 9, 16) is 4 at y = 0: 5/8 of the way from 9
    assert _inverse_quadratic(9.0, 1.0, 1.0, -1.0, 16.0, 2.0) == pytest.approx(5 / 8)
    # the same values at x = 0, 1, 10 and at 0, 9, 10 bend too much
    assert _inverse_quadratic(1.0, 1.0, 0.0, -1.0, 10.0, 3.0) == 0.5
    assert _inverse_quadratic(9.0, 1.0, 0.0, -1.0, 10.0, 3.0) == 0.5


def test_sign_changes_between_points_of_unlike_sign():
    v = np.array([1.0, 2.0, 4.0, 5.0, 7.0, 8.0])
    found = sign_changes(sin, v, np.sign(np.sin(v)))
    assert found == pytest.approx([pi, 2 * pi], rel=1e-15)
    # points at which nothing is known are passed over
    assert sign_changes(sin, v, np.array([1.0, 0, 0, -1, -1, 0])) == pytest.approx([pi], rel=1e-15)
    assert sign_changes(sin, v, np.ones(6)) == []


@pytest.mark.parametrize("other", [1.95, 1.9999, 2.0001, 2.05])
def test_a_root_on_a_point_hides_no_other(other):
    def f(x):
        return (x - 2.0) * (x - other)

    v = np.array([1.0, 2.0, 3.0])
    found = sign_changes(f, v, np.sign(f(v)))
    assert found == pytest.approx(sorted([2.0, other]), rel=1e-12)
    turned = sign_changes(lambda x: -f(x), v, -np.sign(f(v)))
    assert turned == pytest.approx(sorted([2.0, other]), rel=1e-12)
    touched = sign_changes(lambda x: (x - 2.0) ** 2, v, np.array([1.0, 0.0, 1.0]))
    assert touched == []
    left_out = sign_changes(f, v, np.array([1.0, 0.0, 0.0]))  # points beyond which none is asked
    assert left_out == []


def test_roots_that_rounding_cannot_tell_apart_are_one():
    assert merged([2.0, 1.0, 1.0 + 5e-13, 3.0]) == [1.0, 2.0, 3.0]
    assert merged([1.0, 1.0 + 2e-12]) == [1.0, 1.0 + 2e-12]
    assert merged([]) == []


def test_valleys_are_found_the_deepest_first():
    y = np.array([1.0, 2.0, 0.5, 3.0, 0.25, 4.0, inf, inf, 0.75])
    assert _valleys(y) == [4, 2, 8, 0]
    assert _valleys(np.array([2.0, 1.0, 1.0, 2.0])) == [1, 2]
    assert _valleys(np.array([inf, inf])) == []


def valley(x):
    """(x - 1)^2 + 1 and, deeper between its points, 20 |x - 3|."""
    return min((x - 1) ** 2 + 1, 20 * (x - 3.1) ** 2 + 0.5)


def slope(x):
    return 2 * (x - 1) if (x - 1) ** 2 + 1 < 20 * (x - 3.1) ** 2 + 0.5 else 40 * (x - 3.1)


@pytest.mark.parametrize("ends", [(0.4, 3.4), (0.1, 4.0)])
def test_the_least_value_is_between_the_points(ends):
    v = np.linspace(*ends, 7)
    y = np.array([valley(x) for x in v.tolist()])
    assert least(valley, slope, v, y) == pytest.approx(3.1, rel=1e-10)  # flat: fewer digits


def test_a_least_value_at_an_end_stays_there():
    v = np.array([1.0, 2.0, 3.0])
    assert least(lambda x: x, lambda x: 1.0, v, v) == 1.0
    assert least(lambda x: -x, lambda x: -1.0, v, 4 - v) == 3.0


def test_what_is_no_number_is_no_valley():
    v = np.array([1.0, 2.0, 3.0, 4.0])
    y = np.array([np.nan, 3.0, 1.0, 2.0])
    found = least(lambda x: (x - 2.9) ** 2, lambda x: 2 * (x - 2.9), v, y)
    assert found == pytest.approx(2.9, rel=1e-10)


def test_twins_are_no_valley_of_their_own():
    """Two points a rounding apart: the bottom lies beyond the nearer neighbour."""
    for v in ([1.0, 2.0, 2.0 + 1e-12, 4.0], [1.0, 3.0, 3.0 + 1e-12, 4.0]):
        v = np.array(v)
        y = (v - 2.5) ** 2 + 1
        found = least(lambda x: (x - 2.5) ** 2, lambda x: 2 * (x - 2.5), v, y)
        assert found == pytest.approx(2.5, rel=1e-10)
    v = np.array([2.0, 2.0 + 1e-12])  # nothing beyond
    assert least(lambda x: x, lambda x: -1.0, v, v) == 2.0


def test_a_valley_that_is_no_deeper_changes_nothing():
    v = np.array([1.0, 2.0, 3.0])
    # y says 0 at 2, the function itself is never below 5
    assert least(lambda x: 5.0, lambda x: x - 2.5, v, np.array([1.0, 0.0, 1.0])) == 2.0


def test_a_valley_is_closed_in_on():
    for place in (1.0, 1.3, 1.999, 2.0):
        at, value = crossings.valley(lambda w, p=place: (w - p) ** 2 + 3, 1.0, 2.0)
        assert at == pytest.approx(place, abs=2e-8)  # golden sections to 1e-8
        assert value == pytest.approx(3.0, rel=1e-15)
