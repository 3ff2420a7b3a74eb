"""digits: a float enters exactly, and leaves as the nearest float."""

from decimal import Decimal, getcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp

from zoh.lti import digits

floats = st.floats(allow_nan=False, allow_infinity=False)
modest = st.floats(-1e3, 1e3)


@given(st.lists(floats, max_size=6))
def test_floats_go_in_and_out_unchanged(values):
    assert digits.rounded(digits.exact(values)) == tuple(values)


@given(floats)
def test_exact_is_exact(x):
    assert Fraction(digits.exact([x])[0]) == Fraction(x)


def test_fractions_keep_many_digits():
    (third,) = digits.exact([Fraction(1, 3)])
    assert abs(Fraction(third) - Fraction(1, 3)) < Fraction(1, 10 ** (digits.KEPT - 1))


def test_precision_is_given_back():
    before = getcontext().prec
    with digits.precision(300):
        assert getcontext().prec == 300
        assert Decimal(10) ** 100000 > 0  # no overflow in here
    assert getcontext().prec == before


@given(st.lists(modest, min_size=1, max_size=5), st.lists(modest, min_size=1, max_size=5))
def test_products_and_sums_are_those_of_fractions(a, b):
    # 3000 digits hold any product of two of these floats without rounding
    with digits.precision(3000):
        product = digits.times(digits.exact(a), digits.exact(b))
        total = digits.plus(digits.exact(a), digits.exact(b))
    wanted = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            wanted[i + j] += Fraction(x) * Fraction(y)
    assert [Fraction(c) for c in product] == wanted
    n = max(len(a), len(b))
    a, b = [0.0] * (n - len(a)) + a, [0.0] * (n - len(b)) + b
    pairs = zip(a, b, strict=True)
    assert [Fraction(c) for c in total] == [Fraction(x) + Fraction(y) for x, y in pairs]


@pytest.mark.parametrize(
    ("values", "wanted"),
    [(["1"], 1), (["100", "1"], 3), (["1", "0.001"], 4), (["0"], 1), (["12.5", "3"], 3)],
)
def test_span_counts_from_the_first_digit_to_the_last(values, wanted):
    assert digits.span([Decimal(v) for v in values]) == wanted


def test_pairs_of_roots_make_real_polynomials():
    a = digits.from_roots([-0.1 + 3j, -0.1 - 3j, 2.0])
    exact = (1, -2 - 2 * Fraction(-0.1), None, None)
    assert all(isinstance(c, Decimal) for c in a)
    assert Fraction(a[1]) == exact[1]
    assert digits.rounded(a) == pytest.approx(np.poly([-0.1 + 3j, -0.1 - 3j, 2.0]).real, rel=1e-14)


@given(st.integers(1, 5), st.integers(0, 10_000))
def test_state_space_is_the_transfer_function(n, seed):
    rng = np.random.default_rng(seed)
    a, b, c = rng.normal(size=(n, n)), rng.normal(size=n), rng.normal(size=n)
    d = float(rng.normal())
    num, den = digits.state_space(a.tolist(), b.tolist(), c.tolist(), d)
    with mp.workdps(60):
        s = mp.mpc("0.3", "1.7")
        matrix = s * mp.eye(n) - mp.matrix(a.tolist())
        solved = mp.lu_solve(matrix, mp.matrix(b.tolist()))
        truth = mp.mpf(d) + sum(mp.mpf(float(c[i])) * solved[i] for i in range(n))
        top, bottom = ([mp.mpf(str(x)) for x in p] for p in (num, den))
        got = value(top, s) / value(bottom, s)
        assert abs(got - truth) < mp.mpf(10) ** -40 * abs(truth)
        assert abs(value(bottom, s) - mp.det(matrix)) < mp.mpf(10) ** -40


def value(a, x):
    """Return a(x) by Horner's rule in mpmath's present precision."""
    total = mp.mpc(0)
    for c in a:
        total = total * x + c
    return total


def test_a_static_state_space_is_its_gain():
    assert digits.state_space([], [], [], 2.5) == ((Decimal("2.5"),), (Decimal(1),))
