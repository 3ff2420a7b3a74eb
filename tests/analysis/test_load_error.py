"""The absolute error after a load step: against 1/ki, and against the difference equation."""

from math import inf

import numpy as np
import pytest

import zoh
from zoh.analysis.load_error import load_iae

LAG = zoh.Plant(num=[1], den=[1, 1])


def pi(kp, ki, dt):
    return zoh.Sampled.from_w(num_w=[kp, ki], den_w=[1, 0], dt=dt)


def by_difference_equation(plant, controller, count):
    """Return dt sum |y|, y the answer of G/(1 + D G) to a step, from z-coefficients; all count."""
    g = zoh.sample(plant, controller.dt)
    num = np.polymul(controller.den, g.num)
    den = np.polyadd(np.polymul(controller.den, g.den), np.polymul(controller.num, g.num))
    num = np.concatenate([np.zeros(len(den) - len(num)), num]) / den[0]
    den, y = den / den[0], np.zeros(count)
    fed = np.cumsum(np.concatenate([num, np.zeros(count)]))
    for k in range(count):
        past = y[max(0, k - len(den) + 1) : k][::-1]
        y[k] = fed[k] - den[1 : len(past) + 1] @ past
    return controller.dt * np.abs(y).sum()


@pytest.mark.parametrize("ki", [1e-3, 1e-6])
def test_a_mode_that_takes_millions_of_samples_is_not_waited_for(ki):
    # y does not change its sign: all of it is 1/ki, 1e9 samples of it at the smaller ki
    assert load_iae(LAG, pi(1.0, ki, 0.01)) == pytest.approx(1 / ki, rel=1e-11)


def test_what_starts_backwards_before_its_slow_mode_is_left():
    plant = zoh.Plant.parse("(1-2*s)/(s^2+2*s+1)")
    controller = pi(0.1, 0.02, 0.1)
    found = load_iae(plant, controller)
    assert found > 1.02 / 0.02  # y does change its sign
    # 1e-8: z-coefficients at dt = 0.1 lose that much over 30 000 samples
    assert found == pytest.approx(by_difference_equation(plant, controller, 30_000), rel=1e-8)


def test_a_hundred_samples_of_delay_are_followed():
    plant = zoh.Plant(num=[1], den=[1, 1], dead_time=1.0)
    controller = pi(0.9, 0.8, 0.01)
    # 1e-7: the answer is followed until 1e-8 of it is left
    assert load_iae(plant, controller) == pytest.approx(
        by_difference_equation(plant, controller, 6_000), rel=1e-7
    )


def test_without_an_integrator_there_is_no_end():
    assert load_iae(LAG, zoh.Sampled(num=[1.0], den=[1.0], dt=0.1)) == inf
