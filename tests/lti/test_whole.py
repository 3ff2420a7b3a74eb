"""Whole-number polynomials keep what floats cannot: against exact fractions."""

from fractions import Fraction
from math import comb, gcd

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zoh.lti import whole

SMALL = st.integers(-9, 9)
COEFFICIENTS = st.lists(SMALL, min_size=1, max_size=7).filter(lambda a: a[0] != 0)


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


def packed(a, bits):
    return sum(c << bits * k for k, c in enumerate(reversed(a)))


@given(COEFFICIENTS, COEFFICIENTS)
def test_a_packed_product_is_one_of_numbers(a, b):
    # up to 7 products of 81, so 11 bits with the sign
    value = packed(a, 11) * packed(b, 11)
    assert whole.unpacked(value, 11, len(a) + len(b) - 1) == whole.times(a, b)


@pytest.mark.parametrize("a", [[127, -128, 127], [-128, -128], [-1], [0, 0, -1]])
def test_unpacked_to_the_last_bit(a):
    assert whole.unpacked(packed(a, 8), 8, len(a)) == a


@given(COEFFICIENTS)
def test_packed_on_the_axis_are_the_two_polynomials(a):
    assert whole.packed_on_axis(a, 8) == tuple(packed(part, 8) for part in whole.on_axis(a))


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


@pytest.mark.parametrize(
    ("a", "trimmed"),
    [((0, 0), []), ((), []), ((0, 3), [3]), ((3, 0, 0), [3]), ((0, 1, 0, 2, 0), [1, 0, 2])],
)
def test_trimmed_of_zeros_at_both_ends(a, trimmed):
    assert whole.trim(a) == trimmed


@given(COEFFICIENTS)
def test_shifted_is_the_polynomial_of_x_plus_one(a):
    moved = whole.shifted(a)
    for x in (-3, 0, 2):
        there = sum(c * (x + 1) ** k for k, c in enumerate(reversed(a)))
        assert sum(c * x**k for k, c in enumerate(reversed(moved))) == there


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


@given(COEFFICIENTS, COEFFICIENTS)
def test_a_quotient_is_the_other_factor(a, b):
    b = [c // gcd(*b) for c in b]
    assert whole.divided(whole.times(a, b), b) == a
    assert whole.divided([0, *whole.times(a, b)], b) == [0, *a]
