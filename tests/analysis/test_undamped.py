"""Margins of held plants beside modes with next to no damping, against 60-digit arithmetic.

The truth is the hold as a sum over the plant's poles, asked with 60 digits on a grid that is dense
around every mode and around whatever was found, so that it sees what was missed and what was
invented.
"""

from fractions import Fraction
from itertools import pairwise
from math import cos, pi, tan

import pytest
from mpmath import mp, mpc, mpf

from zoh.analysis.loop import Loop
from zoh.analysis.margins import margins, measure_loop
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

DIGITS = 60
CLOSEST = 26  # decades from a mode at which the truth looks last


class Truth:
    """k/((s - p_1) ... (s - p_n)), no pole at 0 and none repeated, behind its hold, times c(w)."""

    def __init__(self, poles, k, dt, delay, controller):
        self.dt, self.controller = mpf(dt), controller
        self.m = int(mp.ceil(mpf(delay) / self.dt))
        lead = self.m * self.dt - mpf(delay)
        self.poles = [mpc(p) for p in poles]
        self.final = mpf(k)
        for p in self.poles:
            self.final /= -p
        self.terms = []
        for p in self.poles:
            residue = mpf(k) / p
            for q in self.poles:
                residue /= p - q if q != p else 1
            self.terms.append((residue * mp.exp(p * lead), mp.exp(p * self.dt)))

    def at(self, w):
        back = mp.expj(-w * self.dt)
        held = self.final + sum(r * (1 - back) / (1 - e * back) for r, e in self.terms)
        v = mpc(0, 2 / self.dt * mp.tan(w * self.dt / 2))
        num, den = (mpf(a) * v + mpf(b) for a, b in self.controller)
        return held * back**self.m * num / den

    def grid(self, found):
        top = mp.pi / self.dt
        points = {top * mpf(10) ** (-mpf(i) / 20) for i in range(1, 120)}
        for w in [abs(mp.im(p)) for p in self.poles] + [mpf(w) for w in found]:
            for i in range(4, 8 * CLOSEST):
                away = w * mpf(10) ** (-mpf(i) / 8)
                points |= {w - away, w + away}
        return sorted(w for w in points if 0 < w < top)

    def crossings(self, found):
        """Return [(w, phase margin)] and [(w, factor)] between the ends of the axis."""
        by_gain, by_phase = [], []
        values = [(w, self.at(w)) for w in self.grid(found)]
        for (a, here), (b, there) in pairwise(values):
            if (abs(here) > 1) != (abs(there) > 1):
                w = close_in(lambda w: mp.log(abs(self.at(w))), a, b)
                by_gain.append((w, mp.degrees(mp.arg(-self.at(w)))))
            turned = mp.arg(there / here)  # passes -180 deg between the two, the short way
            if (
                abs(turned) < 2
                and mp.arg(-here) * mp.arg(-there) < 0
                and here.real + there.real < 0
            ):
                w = close_in(lambda w: mp.arg(-self.at(w)), a, b)
                by_phase.append((w, -1 / self.at(w).real))
        return by_gain, by_phase

    def ms(self, near):
        """Return 1/min |1 + L| beside a place where it seems to be."""
        width = min(abs(near - abs(mp.im(p))) for p in self.poles) / 8
        low, high = mpf(near) - width, mpf(near) + width
        golden = (mp.sqrt(5) - 1) / 2
        for _ in range(120):
            c, d = high - golden * (high - low), low + golden * (high - low)
            if abs(1 + self.at(c)) < abs(1 + self.at(d)):
                high = d
            else:
                low = c
        return 1 / abs(1 + self.at(low))


def close_in(f, a, b):
    return mp.findroot(f, (a, b), solver="anderson", tol=mpf(10) ** -80, maxsteps=400, verify=False)


def check(found, truth, dt):
    """Compare every crossing between the ends, and Ms."""
    top = pi / dt * (1 - 1e-12)
    by_gain, by_phase = (
        [c for c in crossings if 0 < c[0] < top]
        for crossings in (found.gain_crossings, found.phase_crossings)
    )
    assert found.certificate.holds
    assert found.warnings == ()
    with mp.workdps(DIGITS):
        true_gain, true_phase = truth.crossings([w for w, _ in by_gain + by_phase])
        assert (len(by_gain), len(by_phase)) == (len(true_gain), len(true_phase))
        for (w, pm), (true, angle) in zip(by_gain, true_gain, strict=True):
            assert w == pytest.approx(float(true), rel=1e-12)
            assert pm == pytest.approx(float(angle), abs=1e-9)
        for (w, factor), (true, beyond) in zip(by_phase, true_phase, strict=True):
            assert w == pytest.approx(float(true), rel=1e-12)
            assert factor == pytest.approx(float(beyond), rel=1e-9)
        if 0 < found.ms_frequency < top:
            assert found.ms == pytest.approx(float(truth.ms(found.ms_frequency)), rel=1e-9)


def pair(w, damping):
    return [complex(-damping * w, w), complex(-damping * w, -w)]


@pytest.mark.parametrize("delay", [0.0, 0.3, 2.0])
@pytest.mark.parametrize("dt", [1e-4, 0.5])
@pytest.mark.parametrize("damping", [0.0, 1e-14, 1e-10, 1e-6])
def test_a_lag_and_a_mode_with_next_to_no_damping(damping, dt, delay):
    """The hold's coefficients, rounded to floats, turned L at these crossings by 1e-8 deg."""
    w = 0.3 / dt
    poles = [*pair(w, damping), -0.4 * w]
    for part in (1e-7, 1e-3):  # of the gain that the lag and the mode would bear
        k = part * w**3
        plant = Plant.zpk(zeros=[], poles=poles, gain=k, dead_time=delay * dt)
        controller = (1.0, 0.5 * w), (1.0, 3 * w)
        law = Sampled.from_w(num_w=controller[0], den_w=controller[1], dt=dt)
        with mp.workdps(DIGITS):
            truth = Truth(poles, k, dt, delay * dt, controller)
        found = margins(law * sample(plant, dt))
        check(found, truth, dt)
        assert measure_loop(Loop.of(law, sample(plant, dt))) == found


@pytest.mark.parametrize("delay", [0.0, 1.6])
@pytest.mark.parametrize("apart", [1e-12, 1e-8, 1e-5])
@pytest.mark.parametrize("damping", [1e-8, 1e-6, 1e-5])
def test_three_modes_at_nearly_one_frequency(damping, apart, delay):
    """Crossings were invented here, up to 76 for 1, and some were lost."""
    dt, w = 0.1, 6.0
    poles = [p for i in (-1, 0, 1) for p in pair(w * (1 + i * apart), damping * (1 + i / 4))]
    k = w**6 * 1e-6
    with mp.workdps(DIGITS):
        truth = Truth(poles, k, dt, delay * dt, ((0.0, 1.0), (0.0, 1.0)))
    plant = Plant.zpk(zeros=[], poles=poles, gain=k, dead_time=delay * dt)
    check(margins(sample(plant, dt)), truth, dt)


def test_a_hidden_undamped_mode_keeps_its_digits_and_is_hidden():
    """s^2 + 1 above and below the line, and a mode that is not hidden: never stable."""
    mode = pair(1.0, 0.0)
    seen = [*pair(3.0, 1e-12), -1.0]
    hidden = Plant.zpk(zeros=mode, poles=[*mode, *seen], gain=1e-4)
    plain = Plant.zpk(zeros=[], poles=seen, gain=1e-4)
    found, wanted = (measure_loop(Loop.of(sample(plant, 0.1))) for plant in (hidden, plain))
    assert not found.stable
    assert len(wanted.gain_crossings) == 2
    for name in ("gain_crossings", "phase_crossings"):
        for here, there in zip(getattr(found, name), getattr(wanted, name), strict=True):
            assert here == pytest.approx(there, rel=1e-10)


@pytest.mark.parametrize("order", [3, 8, 20])
@pytest.mark.parametrize("away", [2.0**-14, 2.0**-30])
def test_next_to_marginal_by_hand(order, away):
    """g/(s + 1)^n beside -1, |1 + L| to first order.

    L is -g cos(pi/n)^n at tan(pi/n): |1 + L| is 1 - g' times the sine of the angle at which L
    passes the real axis, where d ln L = -n (tan + j) dv/(1 + tan^2).
    """
    v = tan(pi / order)
    g = (1 - away) / cos(pi / order) ** order
    den = [1.0]
    for _ in range(order):
        den = [a + b for a, b in zip([*den, 0.0], [0.0, *den], strict=True)]
    found = measure_loop(Loop.of(Plant(num=[g], den=den)))
    assert found.certificate.holds
    exact = Fraction(g)  # the floats' own distance from -1
    with mp.workdps(DIGITS):
        true = 1 - mpf(exact.numerator) / exact.denominator * mp.cos(mp.pi / order) ** order
        sine = 1 / mp.sqrt(1 + mp.tan(mp.pi / order) ** 2)
        # away^2: second order
        assert found.modulus_margin == pytest.approx(float(true * sine), rel=4 * order * away)
        assert found.gain_margin == pytest.approx(float(1 / (1 - true)), rel=1e-14)
    assert found.phase_crossover == pytest.approx(v, rel=1e-14)
