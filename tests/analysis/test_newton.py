"""newton: hard starts, and answers that are known."""

import pytest

from zoh.analysis import newton


@pytest.mark.parametrize(
    ("p", "q", "x", "low", "high", "least"),
    [
        # x + 27/x^3
        ([1.0, 0.0, 0.0, 0.0, 27.0], [0.0, 1.0, 0.0, 0.0, 0.0], 2.9, 2.0, 5.0, 3.0),
        # (x - 1)^3 - 12 (x - 1) + 20 is straight at 1, where Newton's step is infinite
        ([1.0, -3.0, -9.0, 31.0], [0.0, 0.0, 0.0, 1.0], 1.0, 0.5, 5.0, 3.0),
        # and bends down at 0.9: the step leads to its highest point
        ([1.0, -3.0, -9.0, 31.0], [0.0, 0.0, 0.0, 1.0], 0.9, 0.5, 5.0, 3.0),
        # halved to 2 and to 2.525, from where Newton's step is longer than the last and too long
        ([1.0, -3.0, -9.0, 31.0], [0.0, 0.0, 0.0, 1.0], 0.95, 0.5, 3.05, 3.0),
    ],
)
def test_a_least_ratio_from_where_newtons_step_is_none(p, q, x, low, high, least):
    # a last step of 1e-6 leaves its square
    assert newton.stationary(p, q, x, low, high) == pytest.approx(least, rel=1e-11)


def test_of_three_roots_the_one_between_whatever_the_unit():
    """(x - 2)(x - 5)(x - 20): -76 at 1 and 34 at 3."""
    for unit in (1e-6, 1.0, 1e3, -1e9):
        a = [unit * c for c in (1.0, -27.0, 150.0, -200.0)]
        assert newton.root(a, 1.0, 3.0, unit * -76.0, unit * 34.0) == pytest.approx(2.0, rel=4e-16)
