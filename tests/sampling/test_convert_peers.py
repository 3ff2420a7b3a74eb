"""SciPy and python-control agree on sampling by every method, where they are right."""

import warnings
from math import pi

import control
import numpy as np
import pytest
from scipy import signal

from zoh.lti.systems import Plant
from zoh.sampling.convert import discretise

PLANTS = {
    "lag": ([3.0], [1.0, 2.0]),
    "two lags and a zero": ([2.0, 1.0], [1.0, 3.0, 2.0]),
    "resonance": ([4.0], [1.0, 0.4, 4.0]),
    "three lags": ([1.0, 0.5], [1.0, 6.0, 11.0, 6.0]),
    "integrator": ([1.0, 3.0], [1.0, 1.0, 0.0]),
    "unstable": ([1.0], [1.0, 0.5, -1.0]),
}
SCIPY = {"zoh": {}, "foh": {}, "impulse": {}, "tustin": {"method": "bilinear"}}
SCIPY |= {"forward": {"method": "euler"}, "backward": {"method": "backward_diff"}}


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("method", SCIPY)
@pytest.mark.parametrize("dt", [0.1, 0.4])
def test_scipy_samples_the_same(name, method, dt):
    num, den = PLANTS[name]
    options = {"method": method} | SCIPY[method]
    top, bottom, _ = signal.cont2discrete((num, den), dt, **options)
    got = discretise(Plant(num=num, den=den), dt, method)
    w = np.geomspace(0.05, 0.95 * pi / dt, 25)
    z = np.exp(1j * w * dt)
    theirs = np.polyval(np.ravel(top), z) / np.polyval(bottom, z)
    # 1e-11: expanded z-coefficients lose a few digits near z = 1
    assert got.at(w) == pytest.approx(theirs, rel=1e-11)


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("wp", [0.5, 3.0])
def test_control_prewarps_the_same(name, wp):
    num, den = PLANTS[name]
    theirs = control.sample_system(
        control.tf(num, den), 0.2, method="bilinear", prewarp_frequency=wp
    )
    got = discretise(Plant(num=num, den=den), 0.2, "prewarp", wp)
    w = np.geomspace(0.05, 0.95 * pi / 0.2, 25)
    # 1e-11: as above
    assert got.at(w) == pytest.approx(theirs(np.exp(1j * w * 0.2)), rel=1e-11)


@pytest.mark.parametrize("name", sorted(set(PLANTS) - {"integrator"}))
def test_control_matches_the_same_poles_zeros_and_gain(name):
    num, den = PLANTS[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        theirs = control.sample_system(control.tf(num, den), 0.2, method="matched")
    got = discretise(Plant(num=num, den=den), 0.2, "matched")
    # 1e-10: their roots and ours are of expanded polynomials
    assert np.sort_complex(got.poles()) == pytest.approx(np.sort_complex(theirs.poles()), rel=1e-10)
    assert got.at(0.0) == pytest.approx(theirs(1.0), rel=1e-10)
    ours, finite = got.zeros(), np.exp(np.roots(num) * 0.2)
    kept = [z for z in ours if abs(z + 1) > 1e-6]  # the others stand for zeros at infinity
    assert np.sort(np.real(kept)) == pytest.approx(np.sort(np.real(finite)), rel=1e-10)
    assert len(ours) == max(len(den) - 2, 0)
