"""A pair that is left alone to swing for millions of samples: all of its figures, in no time.

The truth is the loop by hand: 1/(s (s^2 + 1)) = 1/s - s/(s^2 + 1), and with u held the states are

    a' = u,    m' = r,    r' = u - m,    y = a - r,    r(t) = r cos t - (m - u) sin t

so that the highest y between two samples is where 0 = u + r sin t + (m - u) cos t.
"""

from math import acos, atan2, cos, hypot, sin
from time import process_time

import pytest

import zoh

SAMPLES = 50_000  # the crests only get lower from the first turn of the beat on, which is shorter
PLANT = zoh.Plant(num=[1], den=[1, 0, 1, 0])


def by_hand(kp: float, dt: float) -> tuple[float, float, float, float]:
    """Return (highest y at the samples, at all times, rise time, settling time), at samples."""
    a = m = r = 0.0
    sampled = between = 0.0
    low = high = last = 0.0
    for k in range(SAMPLES):
        y = a - r
        u = kp * (1 - y)
        sampled = max(sampled, y)
        for t in extremes(u, m - u, r, dt):
            between = max(between, a + u * t - r * cos(t) + (m - u) * sin(t))
        if abs(y - 1) > 0.02:
            last = (k + 1) * dt
        low = low or (k * dt if y >= 0.1 else 0.0)
        high = high or (k * dt if y >= 0.9 else 0.0)
        p = m - u
        m, r = u + p * cos(dt) + r * sin(dt), r * cos(dt) - p * sin(dt)
        a += u * dt
    return sampled, between, high - low, last


def extremes(u: float, p: float, r: float, dt: float) -> list[float]:
    """Return where u + r sin t + p cos t = 0 within a sample."""
    size = hypot(p, r)
    if size <= abs(u):
        return []
    middle, off = atan2(r, p), acos(-u / size)
    turn = 2 * acos(-1.0)
    found = [(middle + sign * off) % turn for sign in (1, -1)]
    return [t for t in found if t <= dt]


# at 6.283 s, 0.0002 rad from 2 pi, the mode is named
@pytest.mark.filterwarnings("ignore:the hold at dt = 6.283 s all but hides")
@pytest.mark.parametrize("dt", [6.2, 6.28, 6.283])
def test_the_crests_of_a_mode_that_rings_for_ever_are_those_by_hand(dt: float) -> None:
    kp = 0.05 / dt
    sampled, between, rise, settling = by_hand(kp, dt)
    began = process_time()
    step = zoh.verify(PLANT, zoh.Sampled(num=[kp], den=[1], dt=dt)).step
    took = process_time() - began
    assert step is not None
    assert step.between_samples is not None
    assert step.peak == pytest.approx(sampled, abs=1e-11)
    assert step.between_samples.peak == pytest.approx(between, abs=1e-11)
    assert step.settling_time == pytest.approx(settling, abs=1e-9)
    assert step.rise_time == pytest.approx(rise, abs=1e-9)
    assert took < 5  # s; it took 10 to 40, and takes less than a tenth of one


def test_a_slower_integrator_that_is_gone_in_time_leaves_a_pair_alone_too() -> None:
    sampled, _, rise, settling = by_hand(1e-3, 6.28)
    began = process_time()
    step = zoh.verify(PLANT, zoh.Sampled(num=[1e-3], den=[1], dt=6.28)).step
    took = process_time() - began
    assert step is not None
    assert step.peak == pytest.approx(sampled, abs=1e-11)
    assert step.settling_time == pytest.approx(settling, abs=1e-9)
    assert step.rise_time == pytest.approx(rise, abs=1e-9)
    assert took < 5  # s; it took 20
