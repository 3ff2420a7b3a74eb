"""Polynomials against NumPy, mpmath and pencil."""

from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf

from zoh.lti import poly

coefficients = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=8)
points = st.floats(-100, 100)


def in_digits(a, x):
    """Return a(x) by Horner's rule in mpmath's present precision."""
    value = mp.mpc(0)
    for c in a:
        value = value * x + mp.mpf(c)
    return value


def size(a, x):
    """Return sum |a_k| |x|^k: what rounding is measured against."""
    return np.polyval(np.abs(a), abs(x)) + 1e-300


@given(coefficients, points)
def test_at_is_polyval(a, x):
    with mp.workdps(60):
        truth = in_digits(a, mp.mpf(x))
        assert abs(poly.at(a, x) - truth) <= 1e-15 * len(a) * size(a, x)


@given(coefficients, st.floats(-10, 10), st.floats(-10, 10))
def test_at_takes_complex_numbers_and_arrays(a, re, im):
    z = complex(re, im)
    with mp.workdps(60):
        truth = complex(in_digits(a, mp.mpc(z)))
    assert abs(poly.at(a, z) - truth) <= 4e-15 * len(a) * size(a, z)
    assert poly.at(a, np.array([z, z])) == pytest.approx(np.array([poly.at(a, z)] * 2))


@given(coefficients, coefficients, points)
def test_product_and_sum_are_pointwise(a, b, x):
    scale = size(a, x) * size(b, x)
    assert abs(poly.at(poly.times(a, b), x) - poly.at(a, x) * poly.at(b, x)) <= 1e-13 * scale
    both = size(a, x) + size(b, x)
    assert abs(poly.at(poly.plus(a, b), x) - poly.at(a, x) - poly.at(b, x)) <= 1e-13 * both
    assert abs(poly.at(poly.plus(a, b, -1.0), x) - poly.at(a, x) + poly.at(b, x)) <= 1e-13 * both


@pytest.mark.parametrize(
    ("a", "trimmed"),
    [((0.0, 0.0), (0.0,)), ((0.0, 1.0, 0.0), (1.0, 0.0)), ((), (0.0,)), ((-0.0, 2.0), (2.0,))],
)
def test_trim(a, trimmed):
    assert poly.trim(a) == trimmed


def test_padded():
    assert poly.padded((1.0, 2.0), 4) == (0.0, 0.0, 1.0, 2.0)
    assert poly.padded((1.0, 2.0), 2) == (1.0, 2.0)


@given(st.lists(st.sampled_from([-3.0, -2.0, -0.5, 0.0, 1.0, 4.0]), unique=True, max_size=6))
def test_roots_come_back(given_roots):
    found = np.sort_complex(poly.roots(np.atleast_1d(np.poly(given_roots)).tolist()))
    assert len(found) == len(given_roots)
    # 1e-9 is the default; six simple roots half a unit apart cost at most 1e5 roundings
    assert found.real == pytest.approx(sorted(given_roots), rel=1e-9, abs=1e-9)
    assert found.imag == pytest.approx(np.zeros(len(found)), abs=1e-9)


def test_roots_at_zero_are_exactly_zero():
    found = poly.roots((2.0, -2.0, 0.0, 0.0))
    assert np.sum(found == 0) == 2
    assert 1.0 in found


@pytest.mark.parametrize("scale", [1e-30, 1e-5, 1.0, 1e5, 1e30])
def test_roots_of_a_scaled_variable_scale(scale):
    """(s+1)(s+2)(s+3), each root times scale: relative error stays small at any scale."""
    a = [1.0, 6.0 * scale, 11.0 * scale**2, 6.0 * scale**3]
    found = np.sort(poly.roots(a).real) / scale
    assert found == pytest.approx([-3.0, -2.0, -1.0], rel=1e-12)


def test_roots_far_apart_keep_their_digits():
    """(s + 1e-2)(s + 1e4)."""
    found = np.sort(poly.roots((1.0, 1e4 + 1e-2, 1e2)).real)
    assert found[0] == pytest.approx(-1e4, rel=1e-12)
    # 1e-9: a root 1e6 below the largest may cost six digits of sixteen
    assert found[1] == pytest.approx(-1e-2, rel=1e-9)


def of_parabola(a):
    """Return the roots in sixty digits."""
    with mp.workdps(60):
        a0, a1, a2 = map(mpf, a)
        root = mp.sqrt(a1 * a1 - 4 * a0 * a2)
        far = -(a1 + (root if a1 > 0 else -root)) / 2
        return sorted([far / a0, a2 / far], key=lambda r: (r.real, r.imag)) if root.real else [
            (-a1 - s * root) / (2 * a0) for s in (1, -1)
        ]  # fmt: skip


@pytest.mark.parametrize(
    "a",
    [
        (1.0, 1e4 + 1e-2, 1e2),  # twelve decades apart
        (1.0, -1e8, 1.0),
        (1.0, 2.0, 1.0),  # twice -1
        (1.0, 2.0, 1.0 - 2**-52),  # 3e-8 apart
        (1.0, 2.0, 1.0 + 2**-52),
        (0.1, 0.2, 0.1),
        (1.0, 1e-9, 1.0),
        (-3.0, 0.0, 5.0),
        (1e-200, 1.0, 1e-200),
        (1e150, 3e150, 1e150),
    ],
)
def test_roots_of_a_parabola_are_the_floats_next_to_them(a):
    found = sorted(poly.roots(a).tolist(), key=lambda r: (r.real, r.imag))
    for got, truth in zip(found, of_parabola(a), strict=True):
        assert abs(got.real - mp.re(truth)) <= 1.2e-16 * abs(mp.re(truth))
        assert abs(got.imag - mp.im(truth)) <= 1.2e-16 * abs(mp.im(truth))


def test_constants_have_no_roots():
    assert poly.roots((3.0,)).size == 0
    assert poly.roots((0.0,)).size == 0
    assert poly.roots((0.0, 0.0, 3.0)).size == 0


def test_binomial_power():
    a = (1.0,)
    for _ in range(10):
        a = poly.times(a, (1.0, 1.0))
    assert a == tuple(float(comb(10, k)) for k in range(11))
