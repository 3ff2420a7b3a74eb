"""Margins of held plants beside modes with next to no damping, against 60-digit arithmetic.

The truth is the hold as a sum over the plant's poles, asked with 60 digits on a grid that is dense
around every mode and around whatever was found, so that it sees what was missed and what was
invented.
"""

from decimal import Decimal
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
    """k (s - z_1) ... (s - z_m)/((s - p_1) ... (s - p_n)) behind its hold, times c(w).

    No pole is at 0 and none is repeated.
    """

    def __init__(self, poles, k, dt, delay=0.0, controller=((0.0, 1.0), (0.0, 1.0)), zeros=()):
        self.dt, self.controller = mpf(dt), controller
        self.m = int(mp.ceil(mpf(delay) / self.dt))
        lead = self.m * self.dt - mpf(delay)
        self.poles = [mpc(p) for p in poles]
        above = [mpc(z) for z in zeros]
        self.final = mpf(k) * mp.fprod(-z for z in above) / mp.fprod(-p for p in self.poles)
        self.terms = []
        for p in self.poles:
            residue = mpf(k) * mp.fprod(p - z for z in above) / p
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
            assert factor == pytest.approx(float(beyond), rel=1e-9, abs=0)
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
        truth = Truth(poles, k, dt, delay * dt)
    plant = Plant.zpk(zeros=[], poles=poles, gain=k, dead_time=delay * dt)
    check(margins(sample(plant, dt)), truth, dt)


def test_a_crossing_between_two_modes_at_nearly_one_frequency_and_gain_crossings_elsewhere():
    """It was lost, and the gain margin was inf: nothing found asked for more digits."""
    dt, zeros = 0.1, [-0.15 + 2.9j, -0.15 - 2.9j]
    poles = [complex(-3e-9, sign * w) for w in (3.0, 3.00000001) for sign in (1, -1)]
    with mp.workdps(DIGITS):
        truth = Truth(poles, 1.0, dt, zeros=zeros)
    found = margins(sample(Plant.zpk(zeros=zeros, poles=poles, gain=1.0), dt))
    assert len(found.phase_crossings) == 1
    check(found, truth, dt)


def both(b, c):
    """Return the complex roots of s^2 + b s + c."""
    b, c = mpf(b), mpf(c)
    im = mp.sqrt(c - b * b / 4)
    return [mpc(-b / 2, im), mpc(-b / 2, -im)]


@pytest.mark.parametrize("fast", [(), (400.0,), (400.0, 500.0)])  # order 4, 5 and 6
def test_the_same_of_a_plant_of_decimals(fast):
    """(s^2 + 0.3 s + 8.5)/((s^2 + 9)(s^2 + 6e-9 s + 9)), and lags of one at rest."""
    dt, num = 0.1, [Decimal(a) for a in ("1", "0.3", "8.5")]
    den = [Decimal(a) for a in ("1", "6e-9", "18", "5.4e-8", "81")]
    for pole in map(Decimal, fast):
        num = [pole * a for a in num]
        den = [a + pole * b for a, b in zip([*den, 0], [0, *den], strict=True)]
    with mp.workdps(DIGITS):
        modes = [*both("0", "9"), *both("6e-9", "9")]
        poles = [*modes, *[-p for p in fast]]
        truth = Truth(poles, mp.fprod(fast), dt, zeros=both("0.3", "8.5"))
    found = margins(sample(Plant.from_exact(num, den), dt))
    assert found.phase_crossings
    check(found, truth, dt)


def least(ratio, near, loop):
    """Return the least of a ratio of |1 + L| beside the closed loop's pole next to the axis."""
    pole = mp.findroot(lambda w: 1 + loop(w), (mpf(near), near * (1 + mpf(10) ** -20)))
    low, high = pole.real - 4 * abs(pole.imag), pole.real + 4 * abs(pole.imag)
    golden = (mp.sqrt(5) - 1) / 2
    for _ in range(100):
        c, d = high - golden * (high - low), low + golden * (high - low)
        if ratio(loop(c)) < ratio(loop(d)):
            high = d
        else:
            low = c
    return float(ratio(loop(low)))


def check_distances(found, loop):
    """Compare all that says how near L comes to -1."""
    assert found.certificate.holds
    with mp.workdps(DIGITS):
        distances = {
            found.modulus_margin: lambda x: abs(1 + x),
            1 / found.mt: lambda x: abs(1 + x) / abs(x),
            found.disk_margin: lambda x: 2 * abs(1 + x) / abs(1 - x),
        }
        for figure, ratio in distances.items():
            true = least(ratio, found.ms_frequency, loop)
            assert figure == pytest.approx(true, rel=1e-9, abs=0)


@pytest.mark.parametrize("away", [1e-5, 1e-7, 1e-9, 1e-11])
def test_the_distance_from_minus_one_of_a_motor_next_to_its_gain_margin(away):
    """Rounding of the hold's coefficients was a millionth of it, and nothing asked for more."""
    dt, k, a, sensor = 0.1, 2.3, 0.7809, 12 / 180
    held = sample(Plant(num=[k], den=[1, a, 0], sensor=sensor), dt)
    gain = margins(held).gain_margin * (1 - away)

    def loop(w):
        z, decay = mp.expj(w * mpf(dt)), mp.exp(-a * mpf(dt))
        return mpf(gain) * k * sensor / a * (mpf(dt) / (z - 1) - (1 - decay) / a / (z - decay))

    found = measure_loop(Loop.of(Sampled(num=[gain], den=[1], dt=dt), held))
    assert found.warnings == ()
    check_distances(found, loop)


def test_a_needle_narrower_than_its_roots_were_found():
    """A PI beside a mode of damping 1e-13: within 1e-16 of a frequency L passes -1."""
    dt, k, num = (
        0.00016049158503112513,
        324415.05129597813,
        (7.349183878024246e-13, -6.76925459698707e-13),
    )
    den = (1.0, 1.7345146626549038e-10, 752135.2787412136)
    with mp.workdps(DIGITS):
        truth = Truth(both(*den[1:]), k, dt)

    def loop(w):
        z = mp.expj(w * mpf(dt))
        return truth.at(w) * (mpf(num[0]) * z + mpf(num[1])) / (z - 1)

    law = Sampled(num=num, den=[1, -1], dt=dt)
    check_distances(measure_loop(Loop.of(law, sample(Plant(num=[k], den=den), dt))), loop)


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
