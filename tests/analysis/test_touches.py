"""|L| touches 1, or L the negative real axis, and turns back: margins by hand."""

from math import acos, degrees, inf, nextafter, pi

import numpy as np
import pytest

from zoh.analysis.loop import Loop
from zoh.analysis.margins import glance, margins, measure_loop
from zoh.analysis.nyquist import closed_loop_stable, nearest_crossing
from zoh.analysis.verify import measure, verify
from zoh.errors import AccuracyWarning, NotMet
from zoh.lti.systems import Plant, Sampled
from zoh.spec import Requirements


def comb(m):
    """0.5 (1 - z^-2) z^-m: |L| = |sin w|, 1 at w = pi/2 alone, where L = (-j)^m."""
    return Sampled(num=[0.5, 0.0, -0.5], den=[1.0, 0.0, 0.0, *[0.0] * m], dt=1.0)


@pytest.mark.parametrize("m", [1, 5, 13])
def test_a_comb_has_a_margin_of_a_quarter_turn(m):
    """-j: 90 deg, one sample. 1 - z^-2 is 2 sin w at 90 deg - w."""
    found = margins(comb(m))
    assert found.stable
    assert found.crossover == pytest.approx(pi / 2, rel=1e-15)
    assert found.phase_margin_deg == pytest.approx(90, rel=1e-14)
    assert found.delay_margin == pytest.approx(1.0, rel=1e-14)
    assert nearest_crossing(Loop.of(comb(m))) == pytest.approx((pi / 2, 90))
    assert glance(Loop.of(comb(m))).phase_margin_deg == pytest.approx(90, rel=1e-14)


@pytest.mark.parametrize("m", [2, 6, 14])
def test_a_comb_that_touches_minus_one_is_not_stable(m):
    """z^(m+2) + (z^2 - 1)/2 is 0 at z = j."""
    assert abs(np.polyval([1, *[0] * (m - 1), 0.5, 0, -0.5], 1j)) == 0
    found = margins(comb(m))
    assert found.stable is False
    assert found.phase_margin_deg == pytest.approx(0, abs=1e-12)
    assert (found.gain_margin, found.delay_margin) == (pytest.approx(1, rel=1e-15), 0.0)
    assert not closed_loop_stable(Loop.of(comb(m)))


def test_a_plant_of_gain_one_behind_a_comb_is_not_verified_for_more():
    loop = (Plant(num=[1.0], den=[1.0]), comb(1))
    assert verify(*loop).margins.phase_margin_deg == pytest.approx(90, rel=1e-14)
    with pytest.raises(NotMet, match="delay_margin"):
        verify(*loop, requirements=Requirements(delay_margin=100.0, pm_deg=60.0))


def test_a_resonance_that_just_reaches_one():
    """0.2 s exp(-3.1 s)/(s^2 + 0.2 s + 1) at w = 1: 1 exp(-3.1 j)."""
    found = margins(Plant(num=[0.2, 0.0], den=[1.0, 0.2, 1.0], dead_time=3.1))
    assert found.phase_margin_deg == pytest.approx(180 - degrees(3.1), rel=1e-12)
    assert found.delay_margin == pytest.approx(pi - 3.1, rel=1e-12)
    assert margins(Plant(num=[0.1, 0], den=[1, 0.1, 1])).phase_margin_deg == 180
    through = margins(Plant(num=[-2.0, 0.0], den=[1.0, 2.0, 1.0]))  # -1 at w = 1
    assert (through.phase_margin_deg, through.gain_margin, through.delay_margin) == (0, 1, 0)


def test_the_negative_axis_touched_from_one_side_is_a_phase_crossing():
    """-(s^2 + s/2 + 1/2)/(s + 1)^3: Im(N conj D) = v (q - 1)^2, and L is -1/2 at 0, -1/4 at w = 1.

    Four times L is -1 at w = 1: -4 (s^2 + s/2 + 1/2) + (s + 1)^3 = (s^2 + 1)(s - 1).
    """
    assert np.polyadd(-4 * np.array([1, 0.5, 0.5]), [1, 3, 3, 1]).tolist() == [1, -1, 1, -1]
    found = margins(Plant(num=[-1.0, -0.5, -0.5], den=[1.0, 3.0, 3.0, 1.0]))
    assert found.phase_crossings == ((0.0, 2.0), (1.0, 4.0))
    assert found.gain_margin == 2


@pytest.mark.parametrize("towards", [0.0, 1.0])
def test_what_all_but_touches_is_said_to_be_in_doubt(towards):
    near = Plant(num=[nextafter(0.1, towards), 0.0], den=[1.0, 0.1, 1.0])
    with pytest.warns(AccuracyWarning, match="may pass through 1 beside 1 rad/s or not"):
        margins(near)
    far = Plant(num=[0.1 * (1 - 1e-13), 0.0], den=[1.0, 0.1, 1.0])
    found = measure_loop(Loop.of(far))
    assert (found.phase_margin_deg, found.warnings) == (inf, ())


def test_rounded_coefficients_that_touch_are_in_doubt():
    """0.3 (z^2 - 1)/(z^2 + 0.4) is 1 at z = j; 0.3 and 0.4 are rounded."""
    with pytest.warns(AccuracyWarning, match="the phase margin may be off by"):
        found = margins(Sampled(num=[0.3, 0.0, -0.3], den=[1.0, 0.0, 0.4], dt=1.0))
    assert found.phase_margin_deg == pytest.approx(180)
    assert found.crossover == pytest.approx(acos(0.0), rel=1e-12)


def test_a_rounded_gain_that_touches_is_in_doubt():
    """1.5 times a third is 1/2 but for a rounding."""
    third = Plant(num=[1.0], den=[3.0])
    comb_of_3 = Sampled(num=[1.5, 0.0, -1.5], den=[1.0, 0.0, 0.0, 0.0], dt=1.0)
    with pytest.warns(AccuracyWarning, match="may pass through 1 beside 1.5708 rad/s or not"):
        measure(third, comb_of_3)
