"""The count of encirclements from where |L| is 1: poles by NumPy, limits by hand."""

from math import atan, pi, sin, sqrt

import numpy as np
import pytest

from zoh.analysis import nyquist
from zoh.analysis.loop import Loop
from zoh.analysis.nyquist import (
    _is_hard_to_prove,
    closed_loop_stable,
    nearest_crossing,
    none_encircled,
)
from zoh.lti.systems import Plant, Sampled


def drawn(seed):
    """Return num, den and m of num/den z^-m, poles outside the circle and on it among them."""
    rng = np.random.default_rng([seed, 3])
    poles = [1.0] * int(rng.integers(0, 3))
    while len(poles) < 4:
        pole = rng.uniform(0.3, 1.05 if rng.random() < 0.5 else 0.98)
        if len(poles) < 3 and rng.random() < 0.5:
            pole = pole * np.exp(1j * rng.uniform(0.05, 3.0))
            poles.append(pole.conjugate())
        poles.append(pole)
    den = np.poly(poles).real
    num = np.atleast_1d(np.poly(rng.uniform(-0.5, 1.2, int(rng.integers(0, 4))))).real
    m = int(rng.integers(11, 41))
    at = np.exp(1j * rng.uniform(0.3, 2.5) / m)
    gain = rng.uniform(0.2, 1.5) * rng.choice([1, 1, 1, -1])
    return num * gain * abs(np.polyval(den, at) / np.polyval(num, at)), den, m


def test_as_many_are_stable_as_have_their_poles_in_the_circle():
    stable = told = 0
    for seed in range(400):
        num, den, m = drawn(seed)
        most = np.abs(np.roots(np.polyadd(np.append(den, np.zeros(m)), num))).max()
        if abs(most - 1) < 1e-6:  # roots of a double pole at 1 are off by 1e-8
            continue
        loop = Loop.of(Sampled(num=num.tolist(), den=[*den, *[0.0] * m], dt=1.0))
        found = none_encircled(loop)
        assert found in (None, most < 1)
        told += found is not None
        stable += most < 1
    assert told > 390
    assert 50 < stable < 350


@pytest.mark.parametrize("m", [11, 24, 59, 200])
def test_the_limit_of_a_late_integrator(m):
    """k z^-m/(z - 1): a pair leaves the circle at k = 2 sin(pi/(4 m + 2))."""
    limit = 2 * sin(pi / (4 * m + 2))
    for share, stable in ((1 - 1e-12, True), (1 + 1e-12, False), (-0.1, False)):
        k = share * limit
        late = Sampled.from_w(num_w=[-k / 2, k], den_w=[1.0, 0.0], dt=1.0, delay=m)
        assert none_encircled(Loop.of(late)) is stable


@pytest.mark.parametrize("late", [0.02, 0.3, 0.9])
def test_an_unstable_plant_with_dead_time_is_held_between_two_gains(late):
    """k exp(-s T)/(s - 1): from k = 1 to sqrt(1 + w^2), where arctan w is w T."""
    low, high = 1e-6, pi / 2 / late
    for _ in range(200):
        w = (low + high) / 2
        low, high = (w, high) if atan(w) > w * late else (low, w)
    for gain, stable in (
        (1 - 1e-9, False), (1 + 1e-9, True), (sqrt(1 + w * w) * (1 - 1e-9), True),
        (sqrt(1 + w * w) * (1 + 1e-9), False),
    ):  # fmt: skip
        loop = Loop.of(Plant(num=[gain], den=[1.0, -1.0], dead_time=late))
        assert none_encircled(loop) is stable


@pytest.mark.parametrize("m", [12, 13])
@pytest.mark.parametrize("gain", [0.3, -0.3])
def test_what_is_on_the_limit_but_for_rounding_is_not_stable(m, gain):
    """(a z + b) z^-m is real at z = 1 and -1: 1 + L is 0 there where it is -1."""
    first = [gain, -1 - gain]  # L(1) = -1
    last = [gain, gain - (-1) ** m]  # L(-1) (-1)^m = b - a
    for num in (first, last):
        loop = Loop.of(Sampled(num=num, den=[1.0, *[0.0] * m], dt=1.0))
        assert none_encircled(loop) is False
    integrator = Sampled(num=[2 * sin(pi / (4 * m + 2))], den=[1.0, -1.0, *[0.0] * m], dt=1.0)
    assert none_encircled(Loop.of(integrator)) is False


def test_a_pole_or_zero_hidden_at_an_end_is_not_stable():
    late = [0.0] * 12
    for root in (1.0, -1.0):
        hiding = Sampled(num=[0.1, -0.1 * root], den=[1.0, -root, *late], dt=1.0)
        assert none_encircled(Loop.of(hiding)) is False


def test_where_floats_do_not_tell_the_proof_is_asked(monkeypatch):
    asked = []
    monkeypatch.setattr(nyquist, "decided", lambda loop: asked.append(loop) or (True, None))
    silent = [
        Loop.of(Plant(num=[0.5, 1.0], den=[1.0, 1.0], dead_time=1.0)),  # it turns for ever
        Loop.of(Sampled(num=[1.0], den=[1.0, *[0.0] * 12], dt=1.0)),  # |L| is 1 everywhere
    ]
    for loop in silent:
        assert none_encircled(loop) is None
        assert closed_loop_stable(loop) is True
    assert asked == silent
    assert closed_loop_stable(Loop.of(Sampled(num=[0.1], den=[1.0, *[0.0] * 10], dt=1.0)))
    assert len(asked) == 3  # a few samples are a polynomial, and that is quick
    for dt in (1.0, 0.1):
        assert closed_loop_stable(Loop.of(Sampled(num=[0.1], den=[1.0, *[0.0] * 11], dt=dt)))
    assert len(asked) == 3


def test_what_is_hard_to_prove_is_next_to_minus_one_or_has_a_size_next_to_one():
    """k z^-70/(z - 1) is -1 at k = 2 sin(pi/282), and k/2 at z = -1; g z^-70 has the size g."""
    limit = 2 * sin(pi / 282)
    for k, hard in ((limit * (1 - 1e-6), True), (0.5 * limit, False)):
        late = Sampled.from_w(num_w=[-k / 2, k], den_w=[1.0, 0.0], dt=1.0, delay=70)
        assert _is_hard_to_prove(Loop.of(late)) is hard
    for g, hard in ((1 - 1e-5, True), (0.5, False)):
        # the first power of both is small beside the others, as is a fraction of it
        late = Sampled.from_w(num_w=[1e-3 * g, 0.1], den_w=[1e-3, 1.0], dt=1.0, delay=70)
        assert _is_hard_to_prove(Loop.of(late)) is hard


def test_the_crossings_are_those_that_the_gain_has_without_its_delay():
    """0.2 (z - 0.3)/((z - 1)(z - 0.9 e^(+-j))) z^-m: |L|^2 - 1 in x = cos w, by NumPy."""
    num = 0.2 * np.array([1.0, -0.3])
    den = np.poly([1.0, 0.9 * np.exp(1j), 0.9 * np.exp(-1j)]).real
    found = {}
    for m in (0, 5, 30):
        loop = Loop.of(Sampled(num=num.tolist(), den=[*den, *[0.0] * m], dt=1.0))
        w, pm = nearest_crossing(loop)
        at = np.exp(1j * w)
        gain = np.polyval(num, at) / np.polyval(den, at)
        assert abs(gain) == pytest.approx(1, rel=1e-12)
        assert pm == pytest.approx(np.degrees(np.angle(-gain * at ** (-m))), abs=1e-9)
        found[m] = w
    # |a|^2 = sum of its autocorrelation times cos k w, and the first three of those in x
    cosines = [np.array([1.0]), np.array([1.0, 0.0]), np.array([2.0, 0.0, -1.0]),
               np.array([4.0, 0.0, -3.0, 0.0])]  # fmt: skip

    def square(a):
        lags = np.correlate(a, a, "full")[len(a) - 1 :]
        out = np.zeros(1)
        for k, lag in enumerate(lags):
            out = np.polyadd(out, (1 if k == 0 else 2) * lag * cosines[k])
        return out

    roots = np.roots(np.polysub(square(num), square(den)))
    crossings = [np.arccos(x.real) for x in roots if abs(x.imag) < 1e-9 and abs(x) < 1]
    assert crossings
    assert all(min(abs(w - x) for x in crossings) < 1e-9 for w in found.values())
