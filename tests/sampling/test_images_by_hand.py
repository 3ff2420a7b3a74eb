"""The images of a table by their sum, term by term, and what is left out by zeta functions.

A gain k w^-r at one phase is met exactly between the points, so each image is a power by hand.
"""

from cmath import exp, phase
from math import degrees, log, pi, sqrt

import mpmath as mp
import numpy as np
import pytest

from zoh import FrequencyResponse
from zoh.errors import SpecError
from zoh.sampling.images import _high_slope, _inside, _outside, _up_to_nyquist, sampled_table


def falling(w, r=2.0, start=-180.0, **more):
    """Return w^-r at the phase ``start``."""
    return FrequencyResponse(w=w, magnitude=[x**-r for x in w], phase_deg=[start] * len(w), **more)


def images(w, low, high, dt):
    """Return the frequencies inside the table that look like w, with their signs."""
    every = [w + n * 2 * pi / dt for n in range(-100, 101)]
    return [at for at in every if low <= abs(at) <= high]


def held(at, r, start, delay):
    """Return one image: the plant, the delay and 1/(j w); the mirror of it for negative w."""
    size = abs(at)
    gain = size**-r * exp(1j * (start - size * delay)) / (1j * size)
    return gain if at > 0 else gain.conjugate()


@pytest.mark.parametrize("delay", [0.0, 0.3])
@pytest.mark.parametrize(("high", "many"), [(3.0, 1), (5.0, 2), (9.0, 3), (20.0, 6), (50.0, 16)])
def test_the_sum_over_the_images_inside(high, many, delay):
    # at 2 rad/s and dt = 1: 2, -4.28, 8.28, -10.6, 14.6 ...
    table = falling([0.5, 1.5, 2.5, high], start=-120.0)
    w = np.array([0.6, 2.0, 2.9])
    total, square = _inside(table, w, 1.0, delay)
    for x, found in zip(w.tolist(), total.tolist(), strict=True):
        truth = sum(held(at, 2.0, -pi * 2 / 3, delay) for at in images(x, 0.5, high, 1.0))
        assert abs(found / truth - 1) < 1e-12
    assert (square == 0).all()  # nothing is known of the noise
    assert len(images(2.0, 0.5, high, 1.0)) == many


def test_the_noise_of_the_images_inside():
    # 1 % at every point: sqrt of the sum of (0.01 |gain|)^2; interpolated over ln w where it varies
    table = falling([0.5, 1.5, 2.5, 20.0], uncertainty=0.01)
    square = _inside(table, np.array([2.0]), 1.0, 0.0)[1]
    truth = sum((0.01 * abs(at) ** -3) ** 2 for at in images(2.0, 0.5, 20.0, 1.0))
    assert square[0] == pytest.approx(truth, rel=1e-12)
    table = falling([0.5, 1.0, 4.0], uncertainty=[0.01, 0.02, 0.06])
    square = _inside(table, np.array([2.0]), 1.0, 0.0)[1]  # 2 alone, in the middle of ln 1 and ln 4
    assert square[0] == pytest.approx((0.04 * 2.0**-3) ** 2, rel=1e-12)


def test_an_image_at_the_end_of_the_table_counts():
    dt, high = 1.0, 2.0 + 2 * pi
    table = falling([2.0, 4.0, high])
    total, _ = _inside(table, np.array([2.0]), dt, 0.0)
    truth = sum(held(at, 2.0, -pi, 0.0) for at in (2.0, 2 - 2 * pi, high))
    assert abs(total[0] / truth - 1) < 1e-12


@pytest.mark.parametrize(("fall", "high"), [(2.0, 5.0), (1.0, 20.0), (0.5, 47.0)])
def test_what_is_left_out_is_bounded_by_its_sum(fall, high):
    # the sum of (high/x)^r/x over x = n ws + w and n ws - w above high is a Hurwitz zeta function;
    # from the 200th term on an integral stands for it, larger by about half of a term
    table = falling([0.5, 1.0, 2.0, high], r=fall)
    dt, ws = 1.0, 2 * pi
    w = np.array([0.5, 2.0, pi])
    found = _outside(table, w, dt, fall)
    for x, bound in zip(w.tolist(), found.tolist(), strict=True):
        truth, half = 0.0, 0.0
        for sign in (1, -1):
            first = next(n for n in range(100) if n * ws + sign * x > high)
            here = high**-fall * high**fall / ws ** (fall + 1)
            truth += float(here * mp.zeta(fall + 1, first + sign * x / ws))
            half += float(here / (first + 199 + sign * x / ws) ** (fall + 1)) / 2
        # Euler and Maclaurin: next to half of the last term there is its slope over 12
        assert bound == pytest.approx(truth + half, rel=1e-6)
        assert bound > truth


def test_every_image_above_the_table_is_bounded_once():
    # the table ends at an image: that one is inside it; 2 pi - w lies outside only
    table = falling([0.5, 1.0, 2.0], r=1.0)
    w = np.array([2.0])
    found = float(_outside(table, w, 1.0, 1.0)[0])
    ws = 2 * pi
    truth = mp.zeta(2, 1 + 2 / ws) + mp.zeta(2, 1 - 2 / ws)
    assert found == pytest.approx(float(truth) / ws**2, rel=1e-4)  # half of the 200th of 2 terms


def test_up_to_nyquist_and_no_further():
    w = np.array([1.0, 2.0, 3.0, 4.0])
    assert _up_to_nyquist(w, pi / 3.5).tolist() == pytest.approx([1, 2, 3, 3.5], rel=1e-15)
    assert _up_to_nyquist(w, pi / 4.5).tolist() == [1, 2, 3, 4]
    assert _up_to_nyquist(w, pi / 4.0).tolist() == [1, 2, 3, 4]
    assert _up_to_nyquist(w, pi / 2.5).tolist() == pytest.approx([1, 2, 2.5], rel=1e-15)
    assert _up_to_nyquist(w[:2], pi / 4.0).tolist() == [1, 2]
    with pytest.raises(SpecError):
        _up_to_nyquist(w[:2], pi / 2.0)
    with pytest.raises(SpecError) as refused:
        _up_to_nyquist(w, 2.0)
    assert str(refused.value) == "dt must leave two points below pi/dt, got 2.0: sample faster"


def test_the_slope_of_the_last_octave():
    # a point an octave below the last belongs to it, one below that does not
    steep = FrequencyResponse(w=[1, 2, 4], magnitude=[1, 1, 0.125], phase_deg=[0, 0, 0])
    assert _high_slope(steep) == pytest.approx(-3.0, rel=1e-12)
    wide = FrequencyResponse(w=[1, 3, 27], magnitude=[1, 1, 1 / 81], phase_deg=[0, 0, 0])
    assert _high_slope(wide) == pytest.approx(-2.0, rel=1e-12)
    apart = FrequencyResponse(w=[1, 3, 4.5, 8], magnitude=[9, 9, 2, 1], phase_deg=[0] * 4)
    assert _high_slope(apart) == pytest.approx(-log(2) / log(8 / 4.5), rel=1e-12)
    # ln w = 0, a/2, a with ln|G| = 0, -1, -1: by least squares the slope of the ends
    three = FrequencyResponse(
        w=[1, 4, 4 * sqrt(2), 8], magnitude=[9, 1, exp(-1).real, exp(-1).real], phase_deg=[0] * 4
    )
    assert _high_slope(three) == pytest.approx(-1 / log(2), rel=1e-12)


def test_the_sampled_response_by_its_law():
    # (1 - exp(-j w dt))/dt times the sum, at the table's own points and at pi/dt
    table = falling([0.5, 1.5, 2.5, 20.0], start=-150.0, uncertainty=0.01, unstable_poles=3)
    found = sampled_table(table, 1.0, 0.3)
    assert found.w.tolist() == pytest.approx([0.5, 1.5, 2.5, pi])
    assert (found.dt, found.unstable_poles) == (1.0, 3)
    left_out = _outside(table, found.w, 1.0, 2.0)
    for i, x in enumerate(found.w.tolist()):
        inside = [held(at, 2.0, -pi * 5 / 6, 0.3) for at in images(x, 0.5, 20.0, 1.0)]
        truth = (1 - exp(-1j * x)) * sum(inside)
        assert found.magnitude[i] == pytest.approx(abs(truth), rel=1e-12)
        off = (found.phase_deg[i] - degrees(phase(truth)) + 180) % 360 - 180
        assert abs(off) < 1e-9
        size = abs(sum(inside))
        sigma = 0.01 * sqrt(sum(abs(g) ** 2 for g in inside)) / size
        assert found.uncertainty[i] == pytest.approx(sigma, rel=1e-12)
        assert found.neglected[i] == pytest.approx(float(left_out[i]) / size, rel=1e-12)
    assert sampled_table(falling([0.5, 1.5, 2.5, 20.0]), 1.0).uncertainty is None
    half = sampled_table(falling([0.5, 1.5, 2.5, 20.0]), 0.5)
    at = sum(held(at, 2.0, -pi, 0.0) for at in images(1.5, 0.5, 20.0, 0.5))
    truth = (1 - exp(-0.75j)) / 0.5 * at
    assert abs(half.at(half.w[1].item()) / truth - 1) < 1e-12


REFUSED = [
    (
        lambda: sampled_table(falling([1, 2, 4], dt=0.1), 0.1),
        "dt must not be given twice, got 0.1: it has its hold already; leave this step out",
    ),
    (
        lambda: sampled_table(falling([1, 2, 4]), 0.1, -1.0),
        "compute_delay must be 0 or more, got -1.0: give seconds, 0 or more",
    ),
    (
        lambda: sampled_table(FrequencyResponse(w=[1, 2], magnitude=[1, 1], phase_deg=[0, 0]), 0.1),
        "frequency_response must fall by w^-0.5 or more at its high end, or its images have no "
        "bound, got 0.0: measure further up, or measure from the held input to the samples",
    ),
]


@pytest.mark.parametrize(("call", "text"), REFUSED)
def test_what_has_no_images_is_refused_to_the_word(call, text):
    with pytest.raises(SpecError) as refused:
        call()
    assert str(refused.value) == text


def test_half_a_power_is_enough():
    assert sampled_table(falling([1, 4], r=0.5), 0.1).dt == 0.1
