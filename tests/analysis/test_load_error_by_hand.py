"""load_iae: by hand where the error keeps its sign, sample after sample where it does not."""

from math import inf

import pytest

from zoh.analysis.load_error import load_iae
from zoh.lti.systems import Plant, Sampled

LAG = Plant(num=[1], den=[1, 1])
INTEGRATOR = Plant(num=[1], den=[1, 0])


def pi_law(kp, ki, dt):
    """Return kp + ki/w."""
    return Sampled.from_w(num_w=[kp, ki], den_w=[1, 0], dt=dt)


def summed(kp, ki, dt, late, count):
    """Return dt sum |y| of 1/s under kp + ki/w, ``late`` samples late, one sample at a time."""
    y, x, total = 0.0, 0.0, 0.0
    under_way = [0.0] * late
    for _ in range(count):
        total += abs(y)
        e = -y
        u = kp * e + x + ki * dt / 2 * e  # 1/w = (dt/2)(z + 1)/(z - 1)
        x += ki * dt * e
        under_way.append(u)
        y += dt * (under_way.pop(0) + 1.0)
    return dt * total


@pytest.mark.parametrize("dt", [0.1, 0.01])
@pytest.mark.parametrize("ki", [1.0, 0.2])
def test_an_error_that_keeps_its_sign_is_one_over_ki(ki, dt):
    assert load_iae(LAG, pi_law(1.0, ki, dt)) == pytest.approx(1 / ki, rel=1e-11)


@pytest.mark.parametrize(
    ("kp", "ki", "dt", "late"),
    [(0.5, 1.0, 0.1, 0), (0.5, 1.0, 0.1, 2), (2.0, 3.0, 0.25, 0), (0.3, 1.0, 0.002, 0)],
)
def test_an_error_that_swings_sample_after_sample(kp, ki, dt, late):
    found = load_iae(INTEGRATOR, pi_law(kp, ki, dt), compute_delay=late * dt)
    assert found == pytest.approx(summed(kp, ki, dt, late, int(400 / dt)), rel=1e-10)
    assert found > 1.05 / ki  # it does swing


def test_without_an_integrator_there_is_no_end():
    assert load_iae(LAG, Sampled(num=[2.0], den=[1.0], dt=0.1)) == inf
    assert load_iae(INTEGRATOR, Sampled(num=[0.5], den=[1.0], dt=0.1)) == inf
