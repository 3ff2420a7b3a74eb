"""The polynomials in q = v^2 are those of the loop, in exact fractions."""

from fractions import Fraction
from math import inf, sqrt

import pytest

from zoh.analysis.loop import Loop
from zoh.analysis.squares import DROP, ON_DEN, ON_NUM, ON_OPPOSITE, SHORT, Squares, corners
from zoh.lti.systems import Plant, Sampled

PLAIN = Plant(num=[1.0, 3.0], den=[1.0, 2.0, 5.0])
DELAYS = [0, 1, 2, 3, SHORT]


def late(samples):
    return Sampled.from_w(num_w=(1.0, 3.0), den_w=(1.0, 2.0, 5.0), dt=0.5, delay=samples)


def times(x, y):
    """Return the product of two complex numbers as pairs of fractions."""
    return x[0] * y[0] - x[1] * y[1], x[0] * y[1] + x[1] * y[0]


def on_axis(a, v):
    """Return a(jv) as a pair of fractions."""
    value = (Fraction(0), Fraction(0))
    for c in a:
        re, im = times(value, (Fraction(0), Fraction(v)))
        value = (re + Fraction(c), im)
    return value


def parts(loop, v, m):
    """Return num and den at jv, m times (1 -+ jv dt/2) multiplied in."""
    top, bottom = on_axis(loop.num, v), on_axis(loop.den, v)
    for _ in range(m):
        half = Fraction(loop.dt) / 2
        top, bottom = times(top, (1, -v * half)), times(bottom, (1, v * half))
    return top, bottom


def square(x):
    return x[0] ** 2 + x[1] ** 2


def value(a, q):
    return sum(c * Fraction(q) ** k for k, c in enumerate(reversed(a)))


@pytest.mark.parametrize("loop", [PLAIN, *map(late, DELAYS)], ids=["plant", *map(str, DELAYS)])
def test_every_polynomial_is_what_it_says_times_one_number(loop):
    m = getattr(loop, "delay", 0)
    loop = Loop.of(loop)
    s = Squares.of(loop)
    assert s.whole
    unit = None
    for v in (Fraction(1, 3), Fraction(2), Fraction(7)):
        (a, b), (c, d) = top, bottom = parts(loop, v, m)
        q = v * v
        unit = unit or value(s.bottom, q) / square(bottom)
        closed, opposite = square((c + a, d + b)), square((c - a, d - b))
        assert value(s.bottom, q) == unit * square(bottom)
        assert value(s.top, q) == unit * square(top)
        assert value(s.closed, q) == unit * closed
        assert value(s.opposite, q) == unit * opposite
        assert value(s.gain, q) == unit * (square(top) - square(bottom))
        assert value(s.turn, q) * v == unit * times(top, (c, -d))[1]
        # T(0) = 3/8; drop has a positive factor of its own
        drop = square(top) - Fraction(DROP) * Fraction(9, 64) * closed
        at_rest = 9 - Fraction(DROP) * 9
        assert value(s.drop, q) * at_rest == value(s.drop, 0) * drop
        assert value(s.drop, 0) > 0
        assert s.ratio(float(v), ON_DEN) == pytest.approx(sqrt(closed / square(bottom)))
    assert s.level == pytest.approx(sqrt(DROP) * 3 / 8, rel=1e-15)


def test_a_long_or_a_continuous_delay_stays_out_of_them():
    for loop, whole in (
        (late(SHORT), True),
        (late(SHORT + 1), False),
        (Plant(num=[1.0, 3.0], den=[1.0, 2.0, 5.0], dead_time=0.5), False),
    ):
        assert Squares.of(Loop.of(loop)).whole is whole
    s, plain = Squares.of(Loop.of(late(SHORT + 1))), Squares.of(Loop.of(PLAIN))
    assert (s.bottom, s.top, s.gain) == (plain.bottom, plain.top, plain.gain)


def test_the_ratios_are_of_the_exact_values():
    s = Squares.of(Loop.of(PLAIN))  # at v = 2: num 3 + 2j, den 1 + 4j
    assert s.ratio(2.0, ON_DEN) == pytest.approx(sqrt(52 / 17), rel=1e-15)
    assert s.ratio(2.0, ON_NUM) == 2
    assert s.ratio(2.0, ON_OPPOSITE) == pytest.approx(sqrt(52 / 8), rel=1e-15)
    assert (s.below(ON_DEN), s.below(ON_NUM), s.below(ON_OPPOSITE)) == (s.bottom, s.top, s.opposite)
    notch = Squares.of(Loop.of(Plant(num=[1.0, 0.0, 4.0], den=[1.0, 1.0, 1.0])))
    assert notch.ratio(2.0, ON_NUM) == inf


def test_the_level_is_that_of_t_at_rest_where_it_is_a_number():
    assert DROP == pytest.approx(0.5011872336272722, rel=1e-15)  # 10^-0.3
    for num, den, level in (
        ([1.0, 0.0], [1.0, 2.0], 0.0),  # T(0) = 0
        ([-2.0], [1.0, 2.0], 0.0),  # infinite
        ([2.0], [1.0, 0.0], sqrt(DROP)),  # 1
        ([2.0, 0.0], [1.0, 1.0, 0.0], 2 / 3 * sqrt(DROP)),  # s/s cancels
    ):
        s = Squares.of(Loop.of(Plant(num=num, den=den)))
        assert s.level == pytest.approx(level, rel=1e-15)
        assert any(s.drop) is (level > 0)


@pytest.mark.parametrize(
    ("polynomials", "logs"),
    [
        ([(1, 0, 4)], [1.0]),
        ([(1, 0, 0, 8)], [1.0]),
        ([(8, 8, 1)], [0.0, -3.0]),  # 8 x^2 + 8 x + 1: roots near 1 and 1/8
        ([(1, 8, 8)], [3.0, 0.0]),
        ([(4, 2, 1)], [-1.0]),  # three points on one line
        ([(4, 1, 4, 0)], [0.0]),  # the middle lies below
        ([(1, 16, 1, 16)], [4.0, 0.0]),
        ([(1, 1, 16, 1)], [2.0, -4.0]),
        ([(1, 2), (1, 4)], [1.0, 2.0]),
        ([(0, 5), (0,)], []),
        ([(0, 1, 0, 4, 0)], [1.0]),
    ],
)
def test_corners_are_the_slopes_of_newtons_polygon(polynomials, logs):
    assert corners(polynomials) == logs


def test_corners_lie_near_the_roots():
    roots = (3, 50, 7000)
    a = (1, -sum(roots), 3 * 50 + 3 * 7000 + 50 * 7000, -3 * 50 * 7000)
    for log, root in zip(corners([a]), reversed(roots), strict=True):
        assert root / 4 < 2**log < root * 4  # a bit length is a logarithm to within 1
