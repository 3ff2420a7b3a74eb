"""Many poles far from z = 1: moving averages and Smith predictors, beside their recursions."""

import mpmath
import numpy as np
import pytest
from scipy import signal

import zoh
from zoh.analysis.closed import closed_loop
from zoh.analysis.realised import Chain

DT = 0.1
LAG = zoh.Plant(num=[1], den=[1, 1])


def figures(num, den, late, samples=600):
    """Return (largest output, largest |effort|) of num/den on 1/(s + 1), ``late`` samples late.

    By the difference equations: y(k+1) = a y(k) + (1 - a) u(k - late), a = exp(-dt), in 30 digits.
    """
    with mpmath.workdps(30):
        a = mpmath.exp(-mpmath.mpf(DT))
        num = [mpmath.mpf(c) / den[0] for c in [0] * (len(den) - len(num)) + list(num)]
        den = [mpmath.mpf(c) / den[0] for c in den]
        y, most, e, u = mpmath.mpf(0), mpmath.mpf(0), [], []
        for k in range(samples):
            most = max(most, y)
            e.append(1 - y)
            now = sum(c * e[k - i] for i, c in enumerate(num) if c and i <= k)
            now -= sum(c * u[k - i] for i, c in enumerate(den) if c and 0 < i <= k)
            u.append(now)
            y = a * y + (1 - a) * (u[k - late] if k >= late else 0)
        return float(most), float(max(map(abs, u)))


def predictor(late):
    """Return the Smith predictor that makes the loop 0.3/(z - 0.7) z^-late of a late lag.

    With P = b/(z - a) z^-d it is C = 0.3 (z - a)/b/(z - 0.7 - 0.3 z^-d).
    """
    a = float(mpmath.exp(-mpmath.mpf(DT)))
    num = [0.3 / (1 - a), -0.3 * a / (1 - a)] + [0.0] * late
    return num, [1.0, -0.7] + [0.0] * (late - 1) + [-0.3]


@pytest.mark.parametrize("taps", [5, 7, 15, 20, 30])
def test_a_moving_average_beside_its_recursion(taps):
    num, den = [1.0] * taps, [100.0] + [0.0] * taps
    step = zoh.verify(LAG, zoh.Sampled(num=num, den=den, dt=DT)).step
    assert step.peak_effort == pytest.approx(figures(num, den, 0)[1], rel=1e-13)


@pytest.mark.parametrize("late", [4, 12, 20, 33, 36, 40])
def test_a_smith_predictor_beside_its_recursion(late):
    """Its characteristic polynomial is (z - a)(z - 0.7) z^(2 late) and no other: stable."""
    num, den = predictor(late)
    plant = zoh.Plant(num=[1], den=[1, 1], dead_time=late * DT)
    found = zoh.verify(plant, zoh.Sampled(num=num, den=den, dt=DT))
    most, effort = figures(num, den, late)
    assert found.margins.stable is True
    assert most < 1
    assert found.step.overshoot_pct == 0.0
    assert found.step.peak_effort == pytest.approx(effort, rel=1e-12)


def test_an_average_of_thirty_with_an_integrator_is_followed():
    num, den = [0.02 / 30] * 30 + [0.0], [1.0, -1.0] + [0.0] * 29
    plant = zoh.Plant(num=[1], den=[1, 1], dead_time=2.0)
    found = zoh.verify(plant, zoh.Sampled(num=num, den=den, dt=DT))
    most, effort = figures(num, den, 20)
    assert found.step.peak == pytest.approx(most, rel=1e-11)  # an integrator sums the roundings
    assert found.step.peak_effort == pytest.approx(effort, rel=1e-11)  # of thirty coefficients


def in_z(a_w, dt):
    """Return a(w) (dt (z + 1)/2)^n in z, descending, w = 2/dt (z - 1)/(z + 1)."""
    z, n = mpmath.mpf(1), len(a_w) - 1
    out = [mpmath.mpf(0)] * (n + 1)
    for i, c in enumerate(a_w):
        row = [z]
        for factor in [-1] * (n - i) + [1] * i:
            row = [x + factor * y for x, y in zip([*row, 0], [0, *row], strict=True)]
        out = [x + c * (mpmath.mpf(dt) / 2) ** i * y for x, y in zip(out, row, strict=True)]
    return out


def with_notches(many, samples=400):
    """Return (the design of a PID with notches, overshoot in %, largest effort).

    By the arm's own motion, y'' + a y' = k u, and the difference equation, in 60 digits.
    """
    gain, pole = 2.3 * 12 / 180, 0.7809
    arm = zoh.Plant(num=[2.3], den=[1, pole, 0], sensor=12 / 180)
    notches = [zoh.notch(w0=20 + 0.3 * i, depth=0.05, width=0.3) for i in range(many)]
    d = zoh.pid(arm, dt=DT, wc=1.0, pm_deg=40, ki=0.3, sections=notches)
    with mpmath.workdps(60):
        num, den = (in_z(a, DT) for a in d.controller.whole_w[:2])
        a, dt = mpmath.mpf(pole), mpmath.mpf(DT)
        fall = mpmath.exp(-a * dt)
        rise = (1 - fall) / a
        y, v, top, most = (mpmath.mpf(0) for _ in range(4))
        e, u = [mpmath.mpf(0)] * len(num), [mpmath.mpf(0)] * len(num)
        for _ in range(samples):
            top, e = max(top, y), [1 - y, *e[:-1]]
            now = (mpmath.fdot(num, e) - mpmath.fdot(den[1:], u[:-1])) / den[0]
            most, u = max(most, abs(now)), [now, *u[:-1]]
            y += v * rise + gain * now * (dt - rise) / a
            v = v * fall + gain * now * rise
        return d, float(100 * (top - 1)), float(most)


@pytest.mark.parametrize(
    ("many", "rel"), [(2, 1e-11), (4, 1e-11), (6, 1e-11), (8, 1e-9), (10, 1e-9)]
)
def test_notches_beside_each_other(many, rel):
    """``rel``: many poles near one pair are moved by each rounding of a coefficient."""
    d, overshoot, effort = with_notches(many)
    assert d.step.overshoot_pct == pytest.approx(overshoot, rel=rel)
    assert d.step.peak_effort == pytest.approx(effort, rel=rel)


def slow_and_far(slow, far):
    """Return poles beside z = 1 and beside z = 0, in one fraction."""
    system = zoh.Sampled(num=[1], den=[1], dt=DT)
    for pole, many in ((1 - 2.0**-20, slow), (0.01, far)):
        for _ in range(many):
            system = system * zoh.Sampled(num=[1, 0.5], den=[1, -pole], dt=DT)
    return system


@pytest.mark.parametrize("far", [4, 12, 14])
def test_slow_poles_beside_many_far_ones(far):
    """The far ones end within samples: the rise of three lags is that of 1/(s + 1)^3, in theirs.

    1 - exp(-t)(1 + t + t^2/2) is 0.1 and 0.9 at 1.1020653 and 5.3223203.
    """
    rise = zoh.step_info(slow_and_far(3, far)).rise_time
    lag = -DT / mpmath.log1p(-(mpmath.mpf(2) ** -20))
    # 1e-6: of a million samples the first at or above is meant
    assert rise == pytest.approx(float((5.3223203 - 1.1020653) * lag), rel=1e-6)


def test_what_grows_beyond_floats_is_refused():
    """Thirty taps of 3 around a lag: unstable, its swing doubles within samples."""
    grown = zoh.Sampled(num=[3.0] * 30, den=[1.0] + [0.0] * 30, dt=DT)
    motion = closed_loop(LAG, grown)
    assert np.abs(motion.run(motion.start, 400)).max() > 1e3
    with pytest.raises(zoh.SpecError, match=r"controller must have a response that can be"):
        motion.run(motion.start, 3, 16)


FILTERS = [  # overshoot in % of butter(6, 0.95), butter(20, 0.3), butter(12, 0.8) of SciPy
    (6, 0.95, 18.576244859242383),  # by their difference equations in 60 digits
    (20, 0.3, 23.001399524338872),
    (12, 0.8, 18.145296904523867),
]


@pytest.mark.parametrize(("order", "corner", "overshoot"), FILTERS)
def test_filters_of_high_order(order, corner, overshoot):
    num, den = signal.butter(order, corner)
    system = zoh.Sampled(num=num.tolist(), den=den.tolist(), dt=1.0)
    assert zoh.step_info(system).overshoot_pct == pytest.approx(overshoot, rel=1e-11)


@pytest.mark.parametrize(("order", "corner"), [(8, 0.95), (14, 0.95)])
def test_a_filter_beyond_floats_is_refused(order, corner):
    """A state is made of 1e9 times its own size and more, which floats hold to no digits."""
    num, den = signal.cheby1(order, 1, corner) if order > 8 else signal.butter(order, corner)
    system = zoh.Sampled(num=num.tolist(), den=den.tolist(), dt=1.0)
    with pytest.raises(zoh.SpecError, match=r"system must .*, got '\d+ states that swing"):
        zoh.step_info(system)


@pytest.mark.parametrize(("slow", "far"), [(1, 5), (3, 5), (9, 0)])
def test_sums_where_they_cost_no_digits(slow, far):
    """A pole near z = 1 is a small number in delta; in z its last digits are lost."""
    assert not Chain.of(slow_and_far(slow, far)).registers
