"""A sampled table is the true sampled response but for what it says it leaves out.

The truth is the textbook's z-transform, in fifty digits where it cancels.
"""

from math import pi

import mpmath as mp
import numpy as np
import pytest

import zoh
from zoh import FrequencyResponse
from zoh.errors import SpecError


def lag_held(a, dt, w, late=0.0):
    """Return a/(s + a) behind a hold and a delay of less than dt, by the modified z-transform."""
    with mp.workdps(50):
        a, dt, w, late = (mp.mpf(x) for x in (a, dt, w, late))
        z = mp.expj(w * dt)
        e = (dt - late) if late else mp.mpf(0)
        step = z / (z - 1) - mp.exp(-a * e) * z / (z - mp.exp(-a * dt))
        return complex(step * (1 - 1 / z) * (1 / z if late else 1))


def servo_held(dt, w):
    """Return 1/s^2 behind a hold: dt^2 (z + 1)/(2 (z - 1)^2)."""
    z = np.exp(1j * w * dt)
    return dt**2 * (z + 1) / (2 * (z - 1) ** 2)


@pytest.mark.parametrize("late", [0.0, 0.04])
@pytest.mark.parametrize("top", [40.0, 300.0, 5000.0])
def test_it_is_off_by_no_more_than_it_says(top, late):
    w = np.geomspace(0.05, top, 3000)
    table = zoh.sample(
        FrequencyResponse.from_complex(w=w, gain=2 / (1j * w + 2)), 0.1, compute_delay=late
    )
    exact = np.array([lag_held(2, 0.1, x, late) for x in table.w])
    off = np.abs(np.asarray(table.at(table.w)) / exact - 1)
    # images are read between the points: 1e-7 is the curve's error at this spacing, h = 0.004.
    # The bound is relative to the sum that is known, off to the true one: 1/(1 - bound) apart.
    assert (off * (1 - table.neglected) <= table.neglected + 1e-7).all()
    assert table.dt == 0.1
    assert table.reaches_nyquist


def test_what_is_left_out_falls_as_the_table_grows():
    most = []
    for top in (50.0, 500.0, 5000.0):
        w = np.geomspace(0.05, top, 3000)
        table = zoh.sample(FrequencyResponse.from_complex(w=w, gain=-1 / w**2), 0.1)
        low = table.w[table.w < 10]
        exact = servo_held(0.1, low)
        off = np.abs(np.asarray(table.at(low)) / exact - 1)
        most.append(off.max())
        assert (off <= table.neglected[: len(low)] + 1e-7).all()
    assert most[0] > 20 * most[1] > 400 * most[2]  # images of 1/w^3: their sum falls with 1/top^2


def test_noise_of_the_images_adds_up():
    # far below Nyquist one image is all: the sampled point is as noisy as the one it came from
    w = np.geomspace(0.05, 5000.0, 3000)
    plant = FrequencyResponse.from_complex(w=w, gain=-1 / w**2, uncertainty=0.02)
    table = zoh.sample(plant, 0.1)
    assert table.uncertainty[0] == pytest.approx(0.02, rel=1e-6)  # the next image is 1e-7 of it
    # at w = 20 of ws = 20 pi the images 20 and -42.8 weigh 1/20^3 and 1/42.8^3 with opposite
    # signs, 82.8 and -105.7 follow: by hand from those four
    at = [20.0, 20 - 20 * pi, 20 + 20 * pi, 20 - 40 * pi]
    part = np.array([1 / x**3 for x in at])
    by_hand = 0.02 * np.linalg.norm(part) / abs(part.sum())
    i = int(np.argmin(np.abs(table.w - 20)))
    # the grid's nearest point is 0.2 % from 20 rad/s, and two more images weigh 0.1 % each
    assert table.uncertainty[i] == pytest.approx(by_hand, rel=0.01)


def test_the_poles_of_a_plant_stay_as_many_behind_a_hold():
    w = np.geomspace(0.05, 500.0, 200)
    table = FrequencyResponse.from_complex(w=w, gain=1 / (1j * w - 1), unstable_poles=1)
    assert zoh.sample(table, 0.1).unstable_poles == 1


def test_margins_carry_what_was_left_out():
    w = np.geomspace(0.05, 300.0, 2000)
    plant = FrequencyResponse.from_complex(w=w, gain=2 / (1j * w + 2))
    law = zoh.Sampled(num=[4.0], den=[1.0], dt=0.1)
    m = zoh.margins(law * zoh.sample(plant, 0.1))
    exact = zoh.margins(law * zoh.sample(zoh.Plant(num=[2], den=[1, 2]), 0.1))
    assert m.stable is exact.stable is True
    pm_off = abs(m.phase_margin_deg - exact.phase_margin_deg)
    assert 0 < pm_off <= m.neglected.phase_margin_deg
    # to first order; the second is Ms |L| b/(1 - Ms |L| b), here 0.026, of it
    assert abs(m.ms - exact.ms) <= m.neglected.ms * 1.03
    assert any("what the values leave out moves" in w for w in m.warnings)


def test_a_table_of_two_clocks_is_refused():
    sampled = FrequencyResponse(w=[1, 2], magnitude=[1, 0.5], phase_deg=[0, 0], dt=0.1)
    with pytest.raises(SpecError, match=r"dt must not be given twice, got 0.1"):
        zoh.sample(sampled, 0.1)


@pytest.mark.parametrize(
    ("table", "more", "says"),
    [
        ({"magnitude": [1, 1, 1]}, {}, "must fall by w.-0.5 or more at its high end"),
        ({}, {"dt": 4.0}, "dt must leave two points below pi/dt, got 4.0"),
        ({}, {"dt": -1.0}, "dt must be above 0"),
        ({}, {"compute_delay": -1.0}, "compute_delay must be 0 or more"),
    ],
)
def test_what_cannot_be_sampled_is_refused(table, more, says):
    plant = FrequencyResponse(
        **{"w": [1, 2, 4], "magnitude": [1, 0.5, 0.25], "phase_deg": [-90, -90, -90], **table}
    )
    with pytest.raises(SpecError, match=says):
        zoh.sample(plant, **{"dt": pi / 8, **more})


@pytest.mark.parametrize("dt", [1e-3, 1e-6, 1e-9, 1e-12])
def test_a_small_dt_costs_no_digits(dt):
    w = np.geomspace(0.1, 100, 50)
    table = zoh.sample(FrequencyResponse.from_complex(w=w, gain=2 / (1j * w + 2)), dt)
    exact = np.array([lag_held(2, dt, x) for x in w])
    off = np.abs(table.magnitude * np.exp(1j * np.radians(table.phase_deg)) / exact - 1)
    assert off.max() < 1e-13 + float(np.max(table.neglected))


def test_a_table_waits_no_longer_than_a_plant():
    table = FrequencyResponse(w=[1, 10], magnitude=[1, 0.1], phase_deg=[-90, -90])
    with pytest.raises(SpecError, match="must be at most 10000 samples"):
        zoh.sample(table, 0.1, compute_delay=1001.0)
    with pytest.raises(SpecError, match="must be 1e-300 s or more"):
        zoh.sample(table, 1e-301)
