"""The short look: its grid, its polynomials in floats, and the roots it follows."""

from fractions import Fraction
from math import inf, sqrt

import numpy as np
import pytest
from mpmath import mp, mpf

from zoh.analysis import newton
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.sparse import Sparse, _by_secant, _grid, _polished
from zoh.analysis.squares import DROP, ON_DEN, ON_NUM, ON_OPPOSITE, Squares
from zoh.lti.systems import Plant, Sampled

LOOPS = {
    "lag": Plant(num=[1.0], den=[1.0, 1.0]),
    "three": Plant(num=[10.0], den=[1.0, 3.0, 3.0, 1.0]),
    "fast": Plant(num=[3e9, 1e17], den=[1.0, 2e8, 5e15, 0.0]),
    "slow and fast": Plant(num=[7.0, 3e-7], den=[1e-6, 1.0, 1e-6]),
    "sampled": Sampled(num=[0.02, 0.017], den=[1.0, -1.7, 0.72], dt=0.1),
}


def look(loop):
    loop = Loop.of(loop)
    squares = Squares.of(loop)
    return squares, Sparse.of(loop, squares)


def grid(seen):
    """Return q in units of ``seen.unit``."""
    return np.exp2(seen.octaves)


def value(a, q):
    return float(sum(c * Fraction(q) ** k for k, c in enumerate(reversed(a))))


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_the_values_are_those_of_the_exact_polynomials(loop):
    s, seen = look(loop)
    exact = [s.bottom, s.top, s.opposite, s.closed, s.gain, s.turn, s.drop]
    assert seen.values.shape == (7, len(seen.octaves))
    assert len({len(a) for a in seen.polynomials}) == 1
    for row, a in enumerate(exact):
        true = np.array([value(a, Fraction(q) * Fraction(seen.unit)) for q in grid(seen).tolist()])
        own = np.array([np.polyval(seen.polynomials[row], q) for q in grid(seen).tolist()])
        size = np.array([np.polyval(np.abs(seen.polynomials[row]), q) for q in grid(seen).tolist()])
        assert np.abs(seen.values[row] - own).max() <= 1e-14 * size.max()
        if row < 5:  # one factor for those of which ratios are taken
            factor = seen.values[0, 0] / value(
                exact[0], Fraction(grid(seen)[0]) * Fraction(seen.unit)
            )
        else:
            factor = seen.values[row, -1] / true[-1]
            assert factor > 0
        assert (np.abs(seen.values[row] - factor * true) <= 1e-13 * size).all()
    for row, under in enumerate((s.bottom, s.top, s.opposite)):
        q = Fraction(grid(seen)[5]) * Fraction(seen.unit)
        assert seen.ratios[row, 5] == pytest.approx(value(s.closed, q) / value(under, q), rel=1e-9)
        assert seen.lowest_at[row] == int(seen.ratios[row].argmin())
    assert seen.squares is s
    assert seen.reach == inf


def test_the_largest_coefficients_are_near_one():
    """So that a float holds the squares of gains that are beyond one."""
    for loop in LOOPS.values():
        _, seen = look(loop)
        rows = np.abs(seen.polynomials).max(axis=1)
        assert 0.5 <= max(rows[0], rows[1]) < 1
        assert 0.5 <= rows[5] < 1
        assert 0.5 <= rows[6] < 1


def test_the_grid_reaches_seven_octaves_beyond_the_corners():
    """1/(s + 1): corners at q = 1 (|D|^2 = q + 1) and 4 (|D + N|^2 = q + 4; 3 dB at q near 4)."""
    _, seen = look(LOOPS["lag"])
    q = grid(seen) * seen.unit
    assert q[1:] / q[:-1] == pytest.approx(np.full(len(q) - 1, sqrt(2)), rel=1e-13)
    assert (q[0], q[-1]) == (2.0**-7, pytest.approx(2.0**9))
    assert seen.unit == 2.0


def test_a_gain_without_corners_is_looked_at_all_the_same():
    _s, seen = look(Plant(num=[0.5], den=[1.0]))
    assert seen.unit == 1.0
    assert (grid(seen)[0], grid(seen)[-1]) == (2.0**-7, 2.0**7)
    assert seen.values.shape[0] == 7
    assert (seen.unities(), seen.turns(), seen.drops()) == ([], [], [])
    assert seen.ratios[:, 0] == pytest.approx([2.25, 9.0, 9.0])
    assert grid(seen)[0] <= seen.lowest(ON_DEN) ** 2 <= grid(seen)[-1]


def test_what_polynomials_do_not_tell_or_floats_do_not_hold_is_left():
    assert look(Plant(num=[1.0], den=[1.0, 1.0], dead_time=1.0))[1] is None
    assert look(Sampled.from_w(num_w=(1.0,), den_w=(1.0, 1.0), dt=1.0, delay=40))[1] is None
    far = Plant(num=[1.0], den=[1e-200, 1.0, 1e-100, 0.0, 1e-190, 0.0, 1e-250])
    with np.errstate(over="ignore", invalid="ignore"):
        assert look(far)[1] is None


def test_every_kind_of_root_by_hand():
    # 10/(s+1)^3: |L| = 1 at w^2 = 10^(2/3) - 1, real where 3 arctan w = pi
    _, seen = look(LOOPS["three"])
    assert seen.unities() == pytest.approx([sqrt(10 ** (2 / 3) - 1)], rel=4e-16)
    assert seen.turns() == pytest.approx([sqrt(3)], rel=4e-16)
    # 5/s: |T|^2 = 25/(w^2 + 25)
    _, seen = look(Plant(num=[5.0], den=[1.0, 0.0]))
    assert seen.drops() == pytest.approx([5 * sqrt(1 / DROP - 1)], rel=1e-15)
    assert seen.unities() == pytest.approx([5.0], rel=4e-16)
    _, seen = look(LOOPS["fast"])
    assert len(seen.unities()) == 1


def test_the_least_ratios_by_hand():
    # 1/(s (s + 1)): |1 + L|^2 = (q^2 - q + 1)/(q^2 + q), least where 2 q^2 - 2 q - 1 = 0
    _, seen = look(Plant(num=[1.0], den=[1.0, 1.0, 0.0]))
    assert seen.lowest(ON_DEN) ** 2 == pytest.approx((1 + sqrt(3)) / 2, rel=1e-10)  # it is flat
    # over |N|^2 = 1 at q = 1/2; over |D - N|^2 = q^2 + 3 q + 1 where 4 q^2 = 4
    assert seen.lowest(ON_NUM) ** 2 == pytest.approx(0.5, rel=1e-10)
    assert seen.lowest(ON_OPPOSITE) ** 2 == pytest.approx(1.0, rel=1e-10)
    # 1/(s + 1): |1 + L|^2 = (q + 4)/(q + 1) falls for ever, |1 + 1/L|^2 = q + 4 rises
    _, seen = look(LOOPS["lag"])
    assert seen.lowest(ON_DEN) ** 2 == pytest.approx(2.0**9)
    assert seen.lowest(ON_NUM) ** 2 == pytest.approx(2.0**-7)


@pytest.mark.parametrize(
    ("a", "low", "high", "root"),
    [
        ([1.0, 0.0, -2.0], 1.0, 2.0, sqrt(2)),
        ([-1.0, 0.0, 2.0], 1.0, 2.0, sqrt(2)),
        ([1.0, 0.0, 0.0, 0.0, 0.0, -1.0], 0.01, 3.0, 1.0),
        ([-1.0, 0.0, 0.0, 0.0, 0.0, 1.0], 0.01, 3.0, 1.0),
        ([1.0, -3.0, 3.0, -1.0], 0.2, 3.0, 1.0),  # three times the same
        ([1.0, -1e-9], 1e-12, 1.0, 1e-9),
        # Newton leaves the bracket at first: x^3 - 2 x + 2 - 1.9
        ([1.0, 0.0, -2.0, 0.1], -1.6, 0.03, None),
        ([1.0, 0.0, -1.0, 0.0], 0.5, 4.0, 1.0),
        ([1.0, -6.0, 11.0, -6.0], 2.4, 10.0, 3.0),
        ([1.0, -6.0, 11.0, -6.0], 1.5, 2.6, 2.0),
    ],
)
def test_a_root_between_two_points(a, low, high, root):
    at_low, at_high = np.polyval(a, low), np.polyval(a, high)
    found = newton.root(a, low, high, at_low, at_high)
    if root is None:
        root = min(np.roots(a).real)
    if a == [1.0, -3.0, 3.0, -1.0]:
        assert found == pytest.approx(root, rel=1e-5)  # a third of a float's digits
    else:
        assert found == pytest.approx(root, rel=4e-16)


@pytest.mark.parametrize(
    ("p", "q", "x", "low", "high", "least"),
    [
        ([1.0, 0.0, 1.0], [0.0, 1.0, 0.0], 1.1, 0.5, 2.0, 1.0),  # x + 1/x
        ([4.0, 0.0, 9.0], [0.0, 1.0, 0.0], 0.6, 0.5, 4.0, 1.5),
        ([1.0, -2.0, 2.0], [0.0, 0.0, 1.0], 3.9, 0.1, 4.0, 1.0),
        ([1.0, -2.0, 2.0], [0.0, 0.0, 1.0], 0.2, 0.1, 4.0, 1.0),
        ([1.0, -4.0, 6.0, -4.0, 1.5], [0.0] * 4 + [1.0], 0.4, 0.3, 3.0, 1.0),  # (x - 1)^4 + 1/2
        # x^2/(x^2 + 1)... of (x - 2)^2/((x - 2)^2 + 1): slopes far out fall again
        ([1.0, -4.0, 4.0], [1.0, -4.0, 5.0], 5.0, 1.0, 6.0, 2.0),
        ([1.0, -4.0, 4.0], [1.0, -4.0, 5.0], 0.2, 0.1, 3.0, 2.0),
    ],
)
def test_a_least_ratio_between_two_points(p, q, x, low, high, least):
    tolerance = 1e-4 if len(p) == 5 else 1e-10  # flat; flatter where the bend is 0 as well
    assert newton.stationary(p, q, x, low, high) == pytest.approx(least, rel=tolerance)


def test_a_parabola_is_least_between():
    # (x - 0.25)^2 at -1, 0, 1
    assert newton.parabola(1.5625, 0.0625, 0.5625) == pytest.approx(0.25)
    assert newton.parabola(3.0, 1.0, 2.0) == pytest.approx(1 / 6)
    assert newton.parabola(1.0, 1.0, 1.0) == 0.0
    assert newton.parabola(1.0, 2.0, 1.0) == 0.0
    assert newton.parabola(inf, 2.0, 3.0) == 0.0


def test_a_ratio_of_polynomials_is_least_where_its_derivative_says():
    """Of (x^3 + 16)/(2 x^2) it is (1 - 32/x^3)/2, of (3 x^3 + 6 x + 4)/x^2 3 - 6/x^2 - 8/x^3."""
    cube = newton.stationary([1.0, 0.0, 0.0, 16.0], [0.0, 2.0, 0.0, 0.0], 3.0, 2.0, 5.0)
    assert cube == pytest.approx(32 ** (1 / 3), rel=1e-12)  # a last step of 1e-6 leaves its square
    x = newton.stationary([3.0, 0.0, 6.0, 4.0], [0.0, 1.0, 0.0, 0.0], 1.9, 1.0, 4.0)
    assert 3 * x**3 - 6 * x - 8 == pytest.approx(0.0, abs=1e-10)  # of terms of 20: as above


def test_the_grid_is_that_of_powers_of_two():
    octaves, powers = _grid(5, 3)  # 5 between the corners: 2 below the middle, 7 beyond them
    assert list(octaves) == [-9 + i / 2 for i in range(39)]
    assert powers.shape == (3, 39)
    assert powers[2].tolist() == [1.0] * 39
    assert powers[:2, 0].tolist() == [2.0**-18, 2.0**-9]
    assert powers[:2, -1].tolist() == [2.0**20, 2.0**10]


def test_a_root_is_moved_onto_the_function_itself():
    assert _by_secant(lambda v: v - 2.0, 2.0 * (1 + 1e-9)) == pytest.approx(2.0, rel=1e-15)
    assert _by_secant(lambda v: v * v - 4.0, 2.0 * (1 - 1e-9)) == pytest.approx(2.0, rel=3e-16)
    assert _by_secant(lambda v: 1.0, 2.0) == 2.0  # no slope
    assert _by_secant(lambda v: v - 2.0, 2.1) == 2.1  # too far for a secant
    assert _by_secant(lambda v: v - 2.0, 2.001) == pytest.approx(2.0, rel=1e-9)
    assert _by_secant(lambda v: v - 2.0, 2.0021) == 2.0021


def test_where_loop_and_polynomial_do_not_agree_the_exact_one_decides():
    s = Squares.of(Loop.of(Plant(num=[2.0], den=[1.0, 1.0])))  # |L| = 1 at sqrt(3)
    true = sqrt(3)
    assert _polished(lambda v: v - true, true * (1 + 1e-12), s, s.gain) == true
    for wrong in (5e-4, -5e-4, 1e-9, 0.0):  # from there, or where floats say that it is
        found = _polished(lambda v: v - true * 1.0001, true * (1 + wrong), s, s.gain)
        assert found == pytest.approx(true, rel=3e-16)


def test_two_close_crossings_keep_their_digits():
    """k s/(s^2 + s + 1): |L| = 1 where (1 - q)^2 = (k^2 - 1) q; at k - 1 = 2^-46 |L| is flat."""
    k = 1 + 2.0**-46
    plant = Plant(num=[k, 0.0], den=[1.0, 1.0, 1.0])
    _, seen = look(plant)
    with mp.workdps(50):
        e = mpf(k) ** 2 - 1
        half = 1 + e / 2
        root = mp.sqrt(half * half - 1)
        wanted = [float(mp.sqrt(half - root)), float(mp.sqrt(half + root))]
    assert seen.unities() == pytest.approx(wanted, rel=1e-9, abs=0)  # a first look
    found = [w for w, _ in measure_loop(Loop.of(plant)).gain_crossings]
    assert found == pytest.approx(wanted, rel=4e-16, abs=0)


def test_two_close_turns_keep_their_digits():
    """1/den, den = s^5 + s^4 + 2 s^3 + 3 s^2 + (1 - d^2) s + 1: real at q = 1 - d and 1 + d."""
    d = 2.0**-20
    _, seen = look(Plant(num=[1.0], den=[1.0, 1.0, 2.0, 3.0, 1 - d * d, 1.0]))
    assert seen.turns() == pytest.approx([sqrt(1 - d), sqrt(1 + d)], rel=4e-16, abs=0)
