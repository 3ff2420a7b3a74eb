"""Where a plant has a margin by itself: every crossover a P can use, the fastest first."""

from math import acos, atan, nextafter, pi, radians, sqrt, tan

import numpy as np
import pytest

from zoh.design import p
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

INTEGRATOR = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)


def test_a_plant_with_delay_by_hand():
    # z^-2/(z - 1), dt = 1: arg G = -90 deg - wc/2 - 2 wc, which is -170 deg at 2.5 wc = 80 deg,
    # and at 2.5 wc = 440 deg once more, just below Nyquist
    plant = Sampled(num=(1.0,), den=(1.0, -1.0, 0.0, 0.0), dt=1.0)
    assert p.crossovers(plant, 10.0) == pytest.approx([radians(176), radians(32)], rel=1e-14)


def test_the_clock_scales_the_crossovers():
    plant = Sampled(num=(1.0,), den=(1.0, -1.0, 0.0, 0.0), dt=1e-3)
    assert p.crossovers(plant, 10.0) == pytest.approx([radians(176e3), radians(32e3)], rel=1e-14)


def test_a_jump_of_the_wrapped_phase_is_no_crossover():
    # z^-1/(z - 1/2) falls from 0 to -360 deg; at -270 deg the angle off the one asked for jumps.
    # At -90 deg: w + arg(e^jw - 1/2) = 90 deg, Re e^jw (e^jw - 1/2) = 0: 2 c^2 - c/2 - 1 = 0
    plant = Sampled(num=(1.0,), den=(1.0, -0.5, 0.0), dt=1.0)
    cosine = (0.5 + sqrt(0.25 + 8)) / 4
    assert p.crossovers(plant, 90.0) == pytest.approx([acos(cosine)], rel=1e-13)


def test_a_rising_phase_is_crossed_as_well():
    # a zero nearer to z = 1 than the pole: the phase of (z - 0.9)/(z - 0.5) rises from 0 and falls
    # back to it, so each margin below its peak is there twice
    plant = Sampled(num=(-1.0, 0.9), den=(1.0, -0.5), dt=1.0)  # turned by 180 deg
    for pm_deg in (10.0, 30.0):
        got = p.crossovers(plant, pm_deg)
        assert len(got) == 2
        # Im and Re of -G e^-j pm: (e^jw - 0.9)(e^-jw - 0.5) = 1.45 - 1.4 c + 0.4 j s
        for wc in got:
            real, imaginary = 1.45 - 1.4 * np.cos(wc), 0.4 * np.sin(wc)
            assert imaginary / real == pytest.approx(tan(radians(pm_deg)), rel=1e-12)


def test_a_resonance_that_turns_the_phase_in_a_hair_is_seen():
    # poles at radius 1 - 1e-7 and 1 rad: the phase falls by 180 deg within 1e-6 rad/s of it
    r, c = 1 - 1e-7, 0.5403023058681398  # cos 1
    plant = Sampled(num=(1.0, 0.0), den=(1.0, -2 * r * c, r * r), dt=1.0)
    got = p.crossovers(plant, 90.0)
    assert len(got) == 1
    assert got[0] == pytest.approx(1.0, abs=1e-6)  # within the width of the resonance


def test_the_last_interval_before_nyquist_is_searched_too():
    # -90 deg - wc/2 is -180 deg + pm at wc = 180 deg - 2 pm; the last two frequencies have
    # margins of atan(1e-3) = 0.05730 deg and 4 % more
    assert p.crossovers(INTEGRATOR, 0.0585) == pytest.approx([radians(180 - 0.117)], rel=1e-14)


def test_a_root_at_an_end_or_in_the_middle_is_that_float():
    assert p._root(lambda x: x - 1, 0.5, 1.0) == 1.0
    assert p._root(lambda x: x - 1, 0.0, 2.0) == 1.0
    assert p._root(lambda x: 1 - x, 1.0, 2.0) == nextafter(1.0, 2.0)


# looked_at: sixty a decade, a thousandth below the least corner and a thousand times the largest


@pytest.mark.parametrize("dt", [1.0, 1e-3])
def test_the_corners_are_surrounded(dt):
    # the integrator's w-form (1 - w dt/2)/w has the corner 2/dt, and 2/dt is one anyway
    wc = p.looked_at(Sampled(num=(1.0,), den=(1.0, -1.0), dt=dt))
    assert (np.diff(wc) > 0).all()
    assert wc[0] == pytest.approx(2 / dt * atan(1e-3), rel=1e-12)
    assert wc[-1] == pytest.approx(2 / dt * atan(1e3), rel=1e-12)
    v = np.tan(wc * dt / 2)
    assert (v[1:] / v[:-1]).max() == pytest.approx(10 ** (6 / 359), rel=1e-9)  # 360 points


def test_all_lies_between_zero_and_nyquist():
    # a corner at w = 4e15: a thousand times that is Nyquist itself in floats
    plant = Sampled(num=(1.0, 1.0 - 1e-15), den=(1.0, -1.0), dt=1.0)
    wc = p.looked_at(plant)
    assert 0 < wc[0]
    assert wc[-1] < pi


def test_a_resonance_is_surrounded_by_quarters_of_its_width():
    # w^2 + 2 a w + a^2 + b^2 with a = 1e-6, b = 1
    a, b = 1e-6, 1.0
    plant = Sampled.from_w(num_w=(1.0,), den_w=(1.0, 2 * a, a * a + b * b), dt=0.1)
    v = 20 * np.tan(p.looked_at(plant) * 0.05)
    near = v[abs(v - b) < 4.5 * a]
    # 33 points; 1e-3: 1e-6 has ten digits less than 1
    assert near == pytest.approx(b + a * np.linspace(-4, 4, 33), abs=1e-3 * a)


def test_the_turns_of_a_delay_are_followed():
    # z^-49 turns the phase 49 times by 180 deg up to Nyquist; with the plant's one, a tenth of a
    # radian a step
    late = sample(Plant(num=[1], den=[1, 1], dead_time=0.49), dt=0.01)
    widest = np.diff(p.looked_at(late)).max() * 0.01 * 50
    assert widest == pytest.approx(pi / 32, rel=1e-12)


def test_a_crossover_at_a_point_that_is_looked_at_is_found_once():
    # the integrator has 45 deg at pi/2, 16 of the 32 steps to Nyquist
    (wc,) = p.crossovers(INTEGRATOR, 45.0)
    assert wc == pytest.approx(pi / 2, rel=4e-16)
