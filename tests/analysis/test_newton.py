"""newton: hard starts, and answers that are known."""

from math import nan

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
        # of slope 4 (x - 1)(x - 4)(x - 10), which falls at 3: the least one in the bracket
        ([1.0, -20.0, 108.0, -160.0, 1000.0], [0.0] * 4 + [1.0], 3.0, 0.5, 3.5, 1.0),
    ],
)
@pytest.mark.parametrize("unit", [2.0**-30, 1.0, 2.0**30])
def test_a_least_ratio_from_where_newtons_step_is_none(p, q, x, low, high, least, unit):
    p, q = ([c * unit**i for i, c in enumerate(a)] for a in (p, q))
    found = newton.stationary(p, q, x * unit, low * unit, high * unit)
    assert found == pytest.approx(least * unit, rel=1e-11)  # a last step of 1e-6 leaves its square


def test_of_three_roots_the_one_between_whatever_the_unit():
    """(x - 2)(x - 5)(x - 20): -76 at 1 and 34 at 3."""
    for unit in (1e-6, 1.0, 1e3, -1e9):
        a = [unit * c for c in (1.0, -27.0, 150.0, -200.0)]
        assert newton.root(a, 1.0, 3.0, unit * -76.0, unit * 34.0) == pytest.approx(2.0, rel=4e-16)


def test_a_narrow_bracket_is_not_left():
    """Beside (x - 2)(x - 5)(x - 20) = 0, a secant's step is a part of the bracket."""
    a = [1.0, -27.0, 150.0, -200.0]
    ends = [(x - 2) * (x - 5) * (x - 20) for x in (1.99, 2.02)]
    assert newton.root(a, 1.99, 2.02, *ends) == pytest.approx(2.0, rel=1e-15)


def test_where_the_secant_ends_on_a_flat_place_the_bracket_is_halved():
    """x^2 - 2 x - 3 is -3 at 0 and 12 at 5: the secant passes 0 at 1, where it is least."""
    assert newton.root([1.0, -2.0, -3.0], 0.0, 5.0, -3.0, 12.0) == pytest.approx(3.0, rel=4e-16)


@pytest.mark.parametrize("root", [1e-9, 1e9])
def test_a_root_of_any_size_has_its_digits(root):
    ends = -(root**2) * (1 - 1e-6), root**2 * 99
    found = newton.root([1.0, 0.0, -(root**2)], 1e-3 * root, 10 * root, *ends)
    assert found == pytest.approx(root, rel=4e-16)


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_step_longer_than_the_last_is_not_the_last(unit):
    """2 x^3 - 9 x^2 + 14 x - 8 is -1 at 1, of slope 2, and -1/2 at 3/2, of slope 1/2; 0 at 2."""
    a = [2.0, -9 * unit, 14 * unit**2, -8 * unit**3]
    ends = [unit**3 * (((2 * x - 9) * x + 14) * x - 8) for x in (0.994, 11.0)]
    found = newton.root(a, 0.994 * unit, 11 * unit, *ends)
    assert found == pytest.approx(2 * unit, rel=1e-15)


@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e12])
def test_a_parabola_has_no_unit(unit):
    """(x - 1/6)^2 at -1, 0 and 1: 49, 1 and 25 of 36."""
    assert newton.parabola(49 * unit, unit, 25 * unit) == pytest.approx(1 / 6, rel=1e-14)


class Counted(float):
    """A second coefficient that counts how often it is added: once a step."""

    steps = 0

    def __radd__(self, other):
        self.steps += 1
        return other + float(self)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_digits_double_with_every_step(unit):
    """From the secant's 1.4 to sqrt 2 in 1e-2, 1e-4, 1e-9 and 1e-18; halving takes fifty."""
    a = [unit, Counted(0.0), -2 * unit]
    assert newton.root(a, 1.0, 2.0, -unit, 2 * unit) == pytest.approx(2**0.5, rel=4e-16)
    assert 2 <= a[1].steps <= 4
    p = [unit, Counted(0.0), 0.0, 0.0, 27 * unit]
    q = [0.0, unit, 0.0, 0.0, 0.0]
    assert newton.stationary(p, q, 2.9, 2.0, 5.0) == pytest.approx(3.0, rel=1e-11)
    assert 2 <= p[1].steps <= 4  # from 3e-2 as well


def test_what_has_no_sign_ends_after_a_hundred_steps():
    a = [nan, Counted(1.0)]
    newton.root(a, 1.0, 2.0, -1.0, 1.0)
    assert a[1].steps == 100
    p = [nan, Counted(1.0)]
    newton.stationary(p, [0.0, 1.0], 1.5, 1.0, 2.0)
    assert p[1].steps == 100
