"""Whole-number polynomials decide what floats cannot: against hand-made roots and mpmath."""

from fractions import Fraction
from math import comb, inf

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, polyroots

from zoh.lti import whole

SMALL = st.integers(-9, 9)
COEFFICIENTS = st.lists(SMALL, min_size=1, max_size=7).filter(lambda a: a[0] != 0)
ROOTS = st.lists(st.fractions(-4, 4, max_denominator=6).filter(bool), min_size=1, max_size=6)


def from_roots(roots):
    a = [1]
    for r in roots:
        a = whole.times(a, [r.denominator, -r.numerator])
    return a


@given(st.lists(st.floats(-1e300, 1e300, allow_subnormal=True), min_size=1, max_size=5))
def test_floats_are_taken_exactly(values):
    (a,), unit = whole.of(values)
    assert [Fraction(c, unit) for c in a] == [Fraction(v) for v in values]
    assert unit & (unit - 1) == 0


@given(COEFFICIENTS, COEFFICIENTS, st.integers(-7, 7))
def test_products_and_sums_are_those_of_their_values(a, b, factor):
    for x in (-2, 0, 1, 3):
        value = sum(c * x**k for k, c in enumerate(reversed(whole.times(a, b))))
        one = sum(c * x**k for k, c in enumerate(reversed(a)))
        other = sum(c * x**k for k, c in enumerate(reversed(b)))
        assert value == one * other
        total = sum(c * x**k for k, c in enumerate(reversed(whole.plus(a, b, factor))))
        assert total == one + factor * other


def test_a_power_has_the_binomial_coefficients():
    assert whole.power((1, 1), 5) == [comb(5, k) for k in range(6)]
    assert whole.power((1, 1), 0) == [1]


@given(COEFFICIENTS, st.fractions(-4, 4, max_denominator=64))
def test_at_is_the_value_times_a_power_of_the_denominator(a, x):
    x = float(x)
    exact = sum(Fraction(c) * Fraction(x) ** k for k, c in enumerate(reversed(a)))
    assert Fraction(whole.at(a, x), Fraction(x).denominator ** (len(a) - 1)) == exact


@given(COEFFICIENTS, st.integers(-3, 3), st.integers(-3, 3))
def test_floats_are_the_scaled_coefficients(a, octaves, bits):
    n = len(a) - 1
    wanted = [Fraction(c) * Fraction(2) ** (octaves * (n - i) - bits) for i, c in enumerate(a)]
    assert [Fraction(x) for x in whole.floats(a, octaves, bits)] == wanted


def test_floats_of_long_numbers_are_near():
    long = 3**200
    (value,) = whole.floats([long], 0, 300)
    assert abs(Fraction(value) / Fraction(long, 2**300) - 1) < Fraction(1, 2**52)
    (value,) = whole.floats([-long], 0, 300)
    assert abs(Fraction(value) / Fraction(-long, 2**300) - 1) < Fraction(1, 2**52)


@pytest.mark.parametrize(("a", "octaves", "bits"), [((5,), 0, 3), ((1, 0, 9), 2, 5), ((0,), 3, 0)])
def test_size_is_the_length_of_the_longest(a, octaves, bits):
    assert whole.size(a, octaves) == bits


@given(ROOTS)
def test_counts_are_those_of_the_roots_it_was_made_of(roots):
    a = from_roots(roots)
    positive = [r for r in roots if r > 0]
    assert whole.positive_roots(a) == len(set(positive))
    odd = sum(positive.count(r) % 2 for r in set(positive))
    assert whole.crossings(a) == odd
    most = whole.variations(a)
    assert most >= len(positive)
    assert (most - len(positive)) % 2 == 0


@given(COEFFICIENTS)
def test_counts_agree_with_roots_in_fifty_digits(a):
    if len(a) < 2:
        assert whole.positive_roots(a) == 0
        return
    with mp.workdps(50):
        square_free = whole.repeated(whole.trim(a)) in ([1], [])
        if not square_free:
            return  # repeated roots: the test above, where they are known
        found = polyroots(whole.trim(a)[::-1], maxsteps=500, extraprec=400, asc=True)
        # 1e-20: real roots of small whole numbers are that real in 50 digits
        real = [r for r in found if abs(mp.im(r)) < mp.mpf(10) ** -20 and mp.re(r) > 0]
    assert whole.positive_roots(a) == len(real) == whole.crossings(a)


def test_counts_tell_two_roots_from_none_where_no_float_does():
    """(x - 1)^2 -+ 10^-40: roots at 1 +- 10^-20, or none."""
    tiny = 10**40
    two, none = [tiny, -2 * tiny, tiny - 1], [tiny, -2 * tiny, tiny + 1]
    assert (whole.positive_roots(two), whole.positive_roots(none)) == (2, 0)
    assert whole.positive(two, 1.0) is None
    assert whole.positive(none, 1.0) == "Descartes"
    assert whole.positive(none) == "Sturm"


@given(ROOTS, st.floats(0.0, 5.0))
def test_positive_is_said_of_what_has_no_positive_root_alone(roots, near):
    proved = whole.positive(from_roots(roots), near) is not None
    assert proved is all(r < 0 for r in roots)


@given(COEFFICIENTS, st.floats(0.01, 100))
def test_what_is_called_positive_is(a, near):
    if whole.positive(a, near):
        assert all(whole.at(a, x) > 0 for x in (0.001, 0.1, 0.5, near, 1.0, 2.0, 10.0, 1e3))


@pytest.mark.parametrize("near", [0.0, inf, 1e-300, 1e300])
def test_positive_takes_any_place_to_look_from(near):
    assert whole.positive((1, 2, 3), near) == "Descartes"
    assert whole.positive((3, -1, 3), near) in ("Descartes", "Sturm")


def test_positive_refuses_what_ends_below_zero():
    assert whole.positive((-1, 2, 3)) is None
    assert whole.positive((1, 2, -3)) is None
    assert whole.positive((0, 0)) is None


@given(COEFFICIENTS)
def test_shifted_is_the_polynomial_of_x_plus_one(a):
    moved = whole.shifted(a)
    for x in (-3, 0, 2):
        there = sum(c * (x + 1) ** k for k, c in enumerate(reversed(a)))
        assert sum(c * x**k for k, c in enumerate(reversed(moved))) == there


PARTS = st.lists(
    st.tuples(st.fractions(-3, 3, max_denominator=4), st.fractions(0, 3, max_denominator=4)),
    min_size=1, max_size=4,
)  # fmt: skip


@given(PARTS)
def test_hurwitz_is_a_matter_of_the_real_parts(parts):
    a = [Fraction(1)]
    for re, im in parts:  # s - re, or s^2 - 2 re s + re^2 + im^2
        factor = [1, -2 * re, re * re + im * im] if im else [1, -re]
        a = [
            sum(a[i] * factor[k - i] for i in range(len(a)) if 0 <= k - i < len(factor))
            for k in range(len(a) + len(factor) - 1)
        ]
    common = 1
    for c in a:
        common *= Fraction(c).denominator
    for sign in (1, -1):
        ints = [sign * int(c * common) for c in a]
        assert whole.hurwitz(ints) is all(re < 0 for re, _ in parts)


def test_hurwitz_of_constants_and_of_a_missing_power():
    assert whole.hurwitz([5])
    assert not whole.hurwitz([0])
    assert not whole.hurwitz([0, 1, 1])  # a root at infinity: z = -1
    assert not whole.hurwitz([1, 1, 0])


@given(COEFFICIENTS)
def test_on_the_axis_it_is_the_polynomial(a):
    even, odd = whole.on_axis(a)
    for v in (1, 2, 5):
        direct = [0, 0]  # real and imaginary part of a(jv), by powers of j
        for k, c in enumerate(reversed(a)):
            direct[k % 2] += c * v**k * (1, 1, -1, -1)[k % 4]
        q = v * v
        assert direct[0] == sum(c * q**k for k, c in enumerate(reversed(even)))
        assert direct[1] == v * sum(c * q**k for k, c in enumerate(reversed(odd)))


def test_repeated_is_what_the_derivative_shares():
    a = from_roots([Fraction(2)] * 3 + [Fraction(1)] + [Fraction(-1)] * 2)
    shared = whole.repeated(a)
    assert shared == from_roots([Fraction(2)] * 2 + [Fraction(-1)])


@pytest.mark.parametrize(
    ("a", "plainly"),
    [
        ((1, 2, 3), True),
        ((1, 0, 1, -1, 1), True),  # x^4 + x^2, and x^2 - x + 1 without roots: 1 < 4
        ((3, -3, 1), True),  # 9 < 12
        ((9, -6, 1), False),  # (3 x - 1)^2: 36 is not below 36
        ((1, -3, 3, -1, 1), False),  # -3 x^3 is below 0
        ((1, -3, 1), False),
        ((1, 0, 1), True),
        ((0, 1), True),
        ((5,), True),
        ((1, 0), False),
        ((1, 1, -1), False),
        ((1, -1), False),
        ((-1, 1, 1), False),
    ],
)
def test_what_is_seen_to_be_positive_at_a_glance(a, plainly):
    assert whole._plainly_positive(a) is plainly


def test_a_pole_at_infinity_is_on_the_boundary_whatever_the_rest():
    assert not whole.hurwitz([0, -1, -2])  # -(w + 2), one root in the left half, one at infinity
    assert not whole.hurwitz([0, 1, 2])
    assert whole.hurwitz([-1, -2])


@pytest.mark.parametrize("a", [(-1, 3, 1), (1, 3, -1), (-1, 3, -1)])
def test_one_end_below_zero_is_enough_to_be_refused(a):
    assert whole.positive(a) is None
    assert whole.positive(a, 1.0) is None
