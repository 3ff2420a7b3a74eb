"""The w-plane, there and back."""

from fractions import Fraction
from math import comb, inf, pi, tan

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp

from zoh.lti.whole import of
from zoh.lti.wplane import bilinear_weights, unwarp, w_to_z, warp, z_to_w

dts = st.floats(1e-7, 1e3)
coefficients = st.lists(st.floats(-100, 100), min_size=1, max_size=7)


def fractions(values, unit):
    return [Fraction(c, unit) for c in values]


@given(dts, st.floats(1e-6, 0.999))
def test_warp_and_unwarp_undo_each_other(dt, share):
    w = share * pi / dt
    # 1e-9: at 0.999 of Nyquist the tangent magnifies a rounding by 1e3
    assert unwarp(warp(w, dt), dt) == pytest.approx(w, rel=1e-12)


@given(dts, st.floats(1e-6, 0.9))
def test_warp_is_the_tangent(dt, share):
    w = share * pi / dt
    with mp.workdps(40):
        truth = 2 / mp.mpf(dt) * mp.tan(mp.mpf(w) * mp.mpf(dt) / 2)
    assert warp(w, dt) == pytest.approx(float(truth), rel=1e-14)


def test_warp_by_hand():
    assert warp(pi / 2, 1.0) == pytest.approx(2.0, rel=1e-15)
    assert warp(2.0, 0.1) == pytest.approx(20 * tan(0.1), rel=1e-15)
    assert warp(0.0, 0.1) == 0.0
    assert unwarp(inf, 0.1) == pytest.approx(pi / 0.1, rel=1e-15)


@pytest.mark.parametrize("n", range(7))
def test_bilinear_weights_are_the_binomials(n):
    rows = bilinear_weights(n)
    assert rows[0] == tuple(comb(n, k) for k in range(n + 1))  # (1+p)^n
    assert rows[n] == tuple(comb(n, k) * (-1) ** (n - k) for k in range(n + 1))  # (1-p)^n
    p = Fraction(3, 7)
    for i, row in enumerate(rows):
        value = sum(c * p ** (n - k) for k, c in enumerate(row))
        assert value == (1 + p) ** (n - i) * (1 - p) ** i


@given(coefficients, dts, st.integers(0, 2), st.fractions(-3, 3, max_denominator=50))
def test_z_to_w_is_exact(a, dt, more, p):
    """(1 - w dt/2)^n a(z) at w = 2 p/dt, in fractions."""
    n = len(a) - 1 + more
    if p == 1:
        return
    got = fractions(*z_to_w(a, dt, n))
    w, z = 2 * p / Fraction(dt), (1 + p) / (1 - p)
    truth = sum(Fraction(c) * z ** (len(a) - 1 - i) for i, c in enumerate(a)) * (1 - p) ** n
    assert sum(c * w ** (n - k) for k, c in enumerate(got)) == truth
    assert len(got) == n + 1


@given(coefficients, dts, st.integers(0, 2), st.fractions(-3, 3, max_denominator=50))
def test_w_to_z_is_exact(a, dt, more, z):
    """(z + 1)^n a(w), in fractions."""
    n = len(a) - 1 + more
    if z == -1:
        return
    (wholes,), unit = of([0.0] * more + a)
    values, factor = w_to_z(wholes, dt)
    got = fractions(values, unit * factor)
    w = 2 / Fraction(dt) * (z - 1) / (z + 1)
    truth = sum(Fraction(c) * w ** (len(a) - 1 - i) for i, c in enumerate(a)) * (z + 1) ** n
    assert sum(c * z ** (n - k) for k, c in enumerate(got)) == truth
    assert len(got) == n + 1


def test_an_integrator_by_hand():
    # dt/(z-1) = dt (1 - w dt/2)/(w dt) = (1 - w dt/2)/w
    assert fractions(*z_to_w((1.0, -1.0), 0.5, 1)) == [0.5, 0.0]
    assert fractions(*z_to_w((0.5,), 0.5, 1)) == [-0.125, 0.5]


def test_a_pole_at_minus_one_is_a_lost_power():
    assert fractions(*z_to_w((1.0, 1.0), 0.5, 1)) == [0.0, 2.0]


def test_tiny_sample_times_cost_no_digits():
    """(z - exp(-dt))... the float nearest to 1 - 1e-7, at dt = 1e-7: w-root at its true place."""
    dt, pole = 1e-7, 1 - 1e-7
    top, last = fractions(*z_to_w((1.0, -pole), dt, 1))
    truth = Fraction(2) / Fraction(dt) * (Fraction(pole) - 1) / (Fraction(pole) + 1)
    assert -last / top == truth
