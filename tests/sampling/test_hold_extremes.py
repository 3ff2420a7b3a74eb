"""The hold at the ends: order 20, stiff, fast and slow clocks, against closed forms.

Each step response is written down by hand, with its poles; the fraction in z follows from its
samples h_j and from the poles exp(p dt): num = den (h_0, h_1 - h_0, h_2 - h_1 ...).
"""

from itertools import pairwise
from math import comb

import pytest
from mpmath import mp, mpf

from zoh.errors import SpecError
from zoh.lti.systems import Plant
from zoh.lti.wplane import bilinear_weights
from zoh.sampling.hold import sample

DIGITS = 1500  # exp(-1e6 * 1e-3) and what cancels around it
ALMOST = [0.0, 0.3, 1.0, 2.7, 2.7 + 1e-9, 1e-9, 1 - 1e-9]  # samples of dead time


def fraction(step, poles, dt, dead_time):
    """Return (num, den, m) in z, descending."""
    m = next(m for m in range(10) if m * mpf(dt) >= mpf(dead_time))
    lead, n = m * mpf(dt) - mpf(dead_time), len(poles)
    den = [mpf(1)]
    for p in poles:
        e = mp.exp(p * mpf(dt))
        den = [a - e * b for a, b in zip([*den, 0], [0, *den], strict=True)]
    h = [step(j * mpf(dt) + lead) for j in range(n + 1)]
    pulse = [h[0], *(b - a for a, b in pairwise(h))]
    num = [sum(den[i] * pulse[j - i] for i in range(j + 1)) for j in range(n + 1)]
    return num, den, m


def in_w(a, dt):
    n = len(a) - 1
    columns = zip(*bilinear_weights(n), strict=True)
    return [
        sum(c * w for c, w in zip(a, column, strict=True)) * (mpf(dt) / 2) ** (n - k)
        for k, column in enumerate(columns)
    ]


def assert_nearest(got, truth):
    """Each is the float next to the truth, or the other neighbour at a tie of 2^-59."""
    got = [0.0] * (len(truth) - len(got)) + list(got)
    for g, t in zip(got, truth, strict=True):
        if abs(t) > mpf(10) ** -1000:
            assert abs(mpf(g) - t) <= abs(t) * mpf(2) ** -53 * (1 + mpf(2) ** -5) + mpf(2) ** -1074
        else:
            assert g == 0


def assert_held(plant, step, poles, dt, dead_time=0.0):
    held = sample(plant, dt)
    with mp.workdps(DIGITS):
        num, den, m = fraction(step, [mpf(p) for p in poles], dt, dead_time)
        assert held.delay == m
        assert_nearest(held.num, num)
        assert_nearest(held.den, den + [mpf(0)] * m)
        num_w, den_w = in_w(num, dt), in_w(den, dt)
        unit = next(c for c in den_w if abs(c) > mpf(10) ** -1000)
        assert_nearest(held.num_w, [c / unit for c in num_w])
        assert_nearest(held.den_w, [c / unit for c in den_w])


@pytest.mark.parametrize("dt", [1e-6, 1e-3, 0.1, 1.0])
@pytest.mark.parametrize("dead_time", [0.0, 0.3])
def test_twenty_poles_at_one_place(dt, dead_time):
    """1/(s + 1)^20: y = 1 - exp(-t) sum t^k/k!, k < 20."""
    plant = Plant(num=[1], den=[comb(20, k) for k in range(21)], dead_time=dead_time * dt)

    def step(t):
        return 1 - mp.exp(-t) * sum(t**k / mp.factorial(k) for k in range(20))

    assert_held(plant, step, [-1] * 20, dt, dead_time * dt)


@pytest.mark.parametrize("dt", [1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize("dead_time", ALMOST)
def test_a_slow_pole_beside_a_fast_one(dt, dead_time):
    """1e6/((s + 1/2^20)(s + 2^20)), poles that are floats, twelve decades apart."""
    slow, fast = 2.0**-20, 2.0**20
    plant = Plant.zpk(zeros=[], poles=[-slow, -fast], gain=1e6, dead_time=dead_time * dt)

    def step(t):
        parts = (1 - mp.exp(-slow * t)) / mpf(slow), (1 - mp.exp(-fast * t)) / mpf(fast)
        return mpf(1e6) * (parts[0] - parts[1]) / (mpf(fast) - mpf(slow))

    assert_held(plant, step, [-slow, -fast], dt, dead_time * dt)


@pytest.mark.parametrize("dt", [1e-9, 1e-4, 0.1, 50.0])
@pytest.mark.parametrize("dead_time", ALMOST)
def test_a_zero_at_the_origin_and_a_double_pole(dt, dead_time):
    """s/(s + 2)^2: y = t exp(-2 t); its zero stays at z = 1 to the last bit."""
    plant = Plant(num=[1, 0], den=[1, 4, 4], dead_time=dead_time * dt)
    assert_held(plant, lambda t: t * mp.exp(-2 * t), [-2, -2], dt, dead_time * dt)
    assert sample(plant, dt).num_w[-1] == 0.0


@pytest.mark.parametrize("dt", [1e-5, 0.1, 7.0])
def test_an_unstable_pole_and_integrators(dt):
    """1/(s^2 (s - 1)): y = exp(t) - 1 - t - t^2/2."""
    plant = Plant(num=[1], den=[1, -1, 0, 0])
    assert_held(plant, lambda t: mp.exp(t) - 1 - t - t * t / 2, [1, 0, 0], dt)
    assert sample(plant, dt).den_w[-2:] == (0.0, 0.0)


@pytest.mark.parametrize("dt", [1e-7, 1e-3, 1.0, 1e4])
def test_six_integrators(dt):
    """1/s^6: y = t^6/720, whose zeros in z mirror each other; w loses its highest power."""
    plant = Plant(num=[1], den=[1, 0, 0, 0, 0, 0, 0])
    assert_held(plant, lambda t: t**6 / 720, [0] * 6, dt)
    assert sample(plant, dt).num_w[0] == 0.0


@pytest.mark.parametrize("unit", [1e-300, 1e-150, 1e150, 1e300])
def test_units_do_not_matter(unit):
    """unit/(unit s + unit) is 1/(s + 1); a gain of ``unit`` is a gain."""
    plain = sample(Plant(num=[1], den=[1, 1]), 0.1)
    assert sample(Plant(num=[unit], den=[unit, unit]), 0.1) == plain
    assert sample(Plant(num=[unit], den=[1, 1]), 0.1).num == pytest.approx(
        [unit * c for c in plain.num], rel=1e-15
    )


def test_a_mode_that_outgrows_every_float_is_refused_before_it_is_followed():
    # -1e-6 s^3 + 3 s^2 + 2 s grows by exp(3e6 dt): a million bits would be needed to say so
    with pytest.raises(SpecError, match=r"within a float's range, got 0\.1: sample faster"):
        sample(Plant(num=[1], den=[-1e-6, 3, 2, 0]), 0.1)


@pytest.mark.parametrize("den", [[1.0, 1e-300, 0.0], [1e100, 1e-200, 0.0], [1.0, 1e-30, 0.0]])
def test_a_pole_all_but_at_zero_leaves_its_trace(den):
    """K/(s (s + a)), a dt next to nothing: b = K (dt^2/2 - a dt^3/6, dt^2/2 - a dt^3/3) in z.

    Of w^2 that leaves (b_2 - b_1)/4 = -K a dt^3/24, to first order in a dt.
    """
    dt, a = 0.125, den[1] / den[0]
    held = sample(Plant(num=[3.0 * den[0]], den=den), dt)
    assert held.num == pytest.approx((3 * dt**2 / 2, 3 * dt**2 / 2), rel=1e-15)
    assert held.num_w[0] == pytest.approx(-3 * a * dt**3 / 24, rel=1e-14)


def test_a_pole_that_is_no_float_is_at_zero():
    """1e-300/1e100 is below every float: what is held is 1/s^2."""
    dt = 0.125
    held = sample(Plant(num=[1e100], den=[1e100, 1e-300, 0.0]), dt)
    assert (held.num, held.den) == ((dt**2 / 2, dt**2 / 2), (1.0, -2.0, 1.0))
    assert held.num_w == (0.0, -dt / 2, 1.0)
