"""Tables against python-control's own, and against the measured loop of a real machine."""

import os
import warnings
from math import pi
from pathlib import Path

import numpy as np
import pytest

import zoh
from zoh import FrequencyResponse

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # what other libraries warn of while importing is theirs
    import control

LOOPS = {
    "third order": lambda s: 2 / (s * (s + 1) * (s + 2)),
    "resonance": lambda s: 3 / (s * (s * s + 0.4 * s + 9)),
    "dead time": lambda s: 0.8 * np.exp(-0.5 * s) / (s * (s + 1)),
    "conditionally stable": lambda s: 40 * (s + 1) ** 2 / (s**3 * (s / 20 + 1) ** 2),
}


@pytest.mark.parametrize("name", LOOPS)
def test_python_control_reads_the_same_off_a_dense_table(name):
    w = np.geomspace(0.05, 100, 1500)
    gain = LOOPS[name](1j * w)
    theirs = control.stability_margins(control.frd(gain, w, smooth=True), returnall=True)
    ours = zoh.margins(FrequencyResponse.from_complex(w=w, gain=gain))
    # both join points h = 0.005 apart by cubics. The sharpest corner, a damping of 0.067, turns
    # 1/0.067 as fast as a real one does, so f''' is 15^3 times as large: our curve is off by
    # 0.0963 h^3 15^3/6 = 7e-6, and theirs, a spline, by less
    near = {"rel": 1e-4, "abs": 1e-6}
    pm = {round(float(x), 3) for x in theirs[1]}
    assert {round(x, 3) for _, x in ours.gain_crossings} == pm
    assert [w for w, _ in ours.gain_crossings] == pytest.approx(sorted(theirs[4]), **near)
    factors = dict(zip(theirs[3], theirs[0], strict=True))
    assert [w for w, _ in ours.phase_crossings] == pytest.approx(sorted(factors), **near)
    assert [x for _, x in ours.phase_crossings] == pytest.approx(
        [factors[w] for w in sorted(factors)], **near
    )
    assert ours.modulus_margin == pytest.approx(min(theirs[2]), **near)


# The rig of A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, Workshop on
# Nonlinear System Identification Benchmarks, 2019. Its open loop, evaluated elsewhere from the two
# published runs, which differ by pulses at the drive alone (S = dU/D, L = 1/S - 1), and rounded to
# 0.1 Hz, about 0.1 dB and 0.1 deg. That evaluation read 22.98 +- 0.03 Hz and 32.4 +- 0.4 deg off
# its full resolution (jackknife over the pulses, with a nominal pulse of 5 V).
EMPS = {
    "hz": [4.9, 9.8, 14.6, 19.5, 22.5, 25.4, 30.3, 40, 59.6],
    "db": [24.0, 12.0, 6.20, 2.05, 0.33, -1.28, -3.35, -6.45, -10.6],
    "phase_deg": [-166.7, -159.8, -154.1, -149.6, -147.9, -146.6, -145.3, -145.0, -149.2],
}


def test_nine_rounded_points_of_a_real_machine():
    m = zoh.margins(FrequencyResponse.from_bode(**EMPS, dt=1e-3))
    assert m.stable is True
    # frequencies rounded to 0.1 Hz, 0.4 % of them
    assert m.crossover / (2 * pi) == pytest.approx(22.98, abs=0.1)
    assert m.phase_margin_deg == pytest.approx(32.4, abs=0.1)
    assert m.interpolation.phase_margin_deg < 0.1
    # nothing beyond 59.6 Hz was measured: the gain margin is what the last point leaves
    assert m.phase_crossover is None
    assert m.gain_margin_db == pytest.approx(10.6, rel=1e-12)


def emps_table():
    """Return L of the rig by averaging over 24 pulses, windows of 1024 samples from the edge on."""
    folder = os.environ.get("ZOH_DATA")
    if not folder or not (Path(folder) / "emps.npz").exists():
        pytest.skip("ZOH_DATA does not hold emps.npz")
    data = np.load(Path(folder) / "emps.npz")
    response = data["vir_p"] - data["vir"]
    pulse = data["pulses"] / 5 * 5.07  # V, as the arrays show and not the nominal 5
    count, fade = 1024, 128
    window = np.ones(count)
    window[-fade:] = 0.5 * (1 + np.cos(pi * np.arange(fade) / fade))
    starts = 324 + 1000 * np.arange(24)
    u, d = (
        np.array([np.fft.rfft(signal[k : k + count] * window) for k in starts])
        for signal in (response, pulse)
    )
    cross, power = (u * d.conj()).mean(0), (abs(d) ** 2).mean(0)
    hz = np.fft.rfftfreq(count, 1e-3)
    coherence = abs(cross) ** 2 / (power * (abs(u) ** 2).mean(0))
    used = (hz > 4) & (hz < 62)
    sensitivity = (cross / power)[used]
    # dL = -dS/S^2, so relative to L it is dS/S times 1/|1 - S|
    error = zoh.random_error(coherence[used], averages=24) / abs(1 - sensitivity)
    return FrequencyResponse.from_complex(
        w=2 * pi * hz[used], gain=1 / sensitivity - 1, dt=1e-3, uncertainty=error
    )


def test_the_measured_loop_of_a_real_machine():
    m = zoh.margins(emps_table())
    assert m.stable is True
    assert len(m.gain_crossings) == 1
    # by another evaluation of the same pulses, jackknifed: 23.01 +- 0.03 Hz, 32.8 +- 0.4 deg
    assert m.crossover / (2 * pi) == pytest.approx(23.01, abs=2 * 0.03)
    assert m.phase_margin_deg == pytest.approx(32.8, abs=0.4)
    # and its jackknife says about what the coherence does: 0.4 deg, within a factor of two
    assert 0.2 < m.noise.phase_margin_deg < 0.8


def test_what_the_rig_bears_more_delay_follows_from_its_table():
    m = zoh.margins(FrequencyResponse.from_bode(**EMPS, dt=1e-3))
    # 32.4 deg at 22.98 Hz are 32.4/360/22.98 s = 3.9 ms
    assert m.delay_margin == pytest.approx(32.4 / 360 / 22.98, rel=0.01)
