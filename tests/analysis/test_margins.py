"""margins finds every crossing, and puts each number where exact arithmetic puts it."""

import json
from fractions import Fraction
from math import asin, degrees, inf, pi, radians, remainder, sqrt, tau
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from mpmath import mp, mpc, mpf

from zoh.analysis.loop import Loop
from zoh.analysis.margins import margins, measure_loop
from zoh.analysis.nyquist import nearest_crossing
from zoh.errors import AccuracyWarning, SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

CASES = json.loads((Path(__file__).parents[1] / "oracles" / "margins.json").read_text())
REL, DEG = 1e-9, 1e-9


def loop_of(case):
    if case["form"] == "s":
        return Plant(num=case["num"], den=case["den"], dead_time=case.get("dead_time", 0.0))
    if case["form"] == "z":
        return Sampled(num=case["num"], den=case["den"], dt=case["dt"])
    if case["form"] == "w":
        return Sampled.from_w(
            num_w=case["num_w"], den_w=case["den_w"], dt=case["dt"], delay=case["delay"]
        )
    num, den, dead_time, sensor = case["plant"]
    plant = Plant(num=num, den=den, dead_time=dead_time, sensor=sensor)
    num_w, den_w = case["controller_w"]
    controller = Sampled.from_w(num_w=num_w, den_w=den_w, dt=case["dt"])
    return controller * sample(plant, case["dt"])


@pytest.fixture(scope="module", params=CASES, ids=lambda c: f"{c['form']}: {c['name']}")
def measured(request):
    """Return (margins, truth)."""
    return measure_loop(Loop.of(loop_of(request.param))), request.param["truth"]


def number(text, absent):
    return absent if text is None else float(text)


def pairs(found):
    return [(float(w), float(x)) for w, x in found]


def test_stability_is_that_of_the_poles(measured):
    got, truth = measured
    assert got.stable is truth["stable"]


def test_every_gain_crossing_is_found(measured):
    got, truth = measured
    wanted = pairs(truth["gain_crossings"])
    assert len(got.gain_crossings) == len(wanted)
    for (w, pm), (w0, pm0) in zip(got.gain_crossings, wanted, strict=True):
        assert w == pytest.approx(w0, rel=REL)
        assert pm == pytest.approx(pm0, abs=DEG)


def test_every_phase_crossing_is_found(measured):
    got, truth = measured
    wanted, found = pairs(truth["phase_crossings"]), got.phase_crossings
    if "limit" in truth:  # a dead time crosses without end; beyond a factor of 1000 nobody asks
        found = [c for c in found if c[0] < truth["limit"] and c[1] < 1000]
        wanted = [c for c in wanted if c[1] < 1000]
    assert len(found) == len(wanted)
    for (w, k), (w0, k0) in zip(found, wanted, strict=True):
        assert w == pytest.approx(w0, rel=REL)
        assert k == pytest.approx(k0, rel=REL)


def test_the_margins_are_the_nearest_crossings(measured):
    got, truth = measured
    assert got.gain_margin == pytest.approx(number(truth["gain_margin"], inf), rel=REL)
    assert got.phase_margin_deg == pytest.approx(number(truth["phase_margin_deg"], inf), abs=DEG)
    wanted = number(truth["crossover"], None)
    assert got.crossover == (None if wanted is None else pytest.approx(wanted, rel=REL))
    factors = [k for w, k in got.phase_crossings if w == got.phase_crossover]  # a tie may fall
    assert factors == ([] if truth["gain_margin"] is None else [got.gain_margin])  # either way


@pytest.mark.parametrize("case", CASES, ids=lambda c: f"{c['form']}: {c['name']}")
def test_the_delay_margin_is_the_least_over_the_crossings(case):
    loop = loop_of(case)
    got = measure_loop(Loop.of(loop)).delay_margin
    truth = number(case["truth"]["delay_margin"], inf)
    num, den = case.get("num", [0]), case.get("den", [1])
    if case["form"] == "s" and len(num) == len(den) and abs(num[0]) >= abs(den[0]):
        assert got == 0.0  # |L| ends above 1: there any delay is too much
    elif case["form"] != "s" and abs(loop_of(case).at(pi / case["dt"])) >= 1:
        assert got == pytest.approx(min(truth, case["dt"]), rel=REL)  # there one sample is
    else:
        assert got == pytest.approx(truth, rel=REL)


def test_the_peaks_are_the_peaks(measured):
    got, truth = measured
    assert got.modulus_margin == pytest.approx(float(truth["modulus_margin"]), rel=REL)
    assert got.ms == pytest.approx(1 / float(truth["modulus_margin"]), rel=REL)
    assert got.mt == pytest.approx(float(truth["mt"]), rel=REL)
    assert got.disk_margin == pytest.approx(float(truth["disk_margin"]), rel=REL)


# Worked by hand.
#   0.125/(z-0.875): real at z = -1, -0.125/1.875; one may multiply it by 15
#   1/(z-0.5):   -1/1.5 at z = -1.  |z - 0.5|^2 = 1.25 - cos = 1 at cos(w) = 1/4
#   1/(z-1):     at cos(w) = 1/2, w = pi/3, 1/(exp(jw)-1) = 1/exp(j 2pi/3): margin 60 deg
#   1/(s(s+1)(s+2)): phase -180 at w = sqrt(2), gain 1/6
#   10/(s+1)^3:  -180 deg at w = sqrt(3), gain 10/8; |L| = 1 at w^2 = 10^(2/3) - 1
#   exp(-0.1 s)/s: crosses at 1 with 90 deg - 0.1 rad; -180 deg at w 0.1 = pi/2
W = sqrt(10 ** (2 / 3) - 1)
BY_HAND = [
    # loop, stable, gain margin, at, phase margin in deg, at
    (Sampled(num=[0.125], den=[1, -0.875], dt=0.1), True, 15, pi / 0.1, inf, None),
    (Sampled(num=[1], den=[1, -0.5], dt=1.0), True, 1.5, pi, None, np.arccos(0.25)),
    (Sampled(num=[2], den=[1, -0.5], dt=1.0), False, 0.75, pi, None, None),
    (Sampled(num=[1], den=[1, -1], dt=1.0), True, 2, pi, 60, pi / 3),
    (Sampled(num=[-0.5], den=[1, 0.0], dt=1.0), True, 2, 0.0, inf, None),
    (Plant(num=[1], den=[1, 3, 2, 0]), True, 6, sqrt(2), None, None),
    (Plant(num=[10], den=[1, 3, 3, 1]), False, 0.8, sqrt(3), 180 - 3 * degrees(np.arctan(W)), W),
    (Plant(num=[1], den=[1, 0], dead_time=0.1), True, 5 * pi, 5 * pi, 90 - degrees(0.1), 1),
    (Plant(num=[1], den=[1, 0]), True, inf, None, 90, 1),
    (Plant(num=[2], den=[1, -1]), True, 0.5, 0.0, 60, sqrt(3)),
    (Plant(num=[0.5], den=[1]), True, inf, None, inf, None),
]


@pytest.mark.parametrize(("loop", "stable", "gm", "wpc", "pm_deg", "wc"), BY_HAND)
def test_matches_hand_worked_margins(loop, stable, gm, wpc, pm_deg, wc):
    got = margins(loop)
    assert got.stable is stable
    assert got.gain_margin == pytest.approx(gm, rel=1e-14)
    assert got.phase_crossover == (None if wpc is None else pytest.approx(wpc, rel=1e-14))
    if pm_deg is not None:
        assert got.phase_margin_deg == pytest.approx(pm_deg, abs=1e-12)
        assert got.crossover == (None if wc is None else pytest.approx(wc, rel=1e-14))


def test_a_loop_that_starts_at_one_does_not_lose_its_margin():
    got = margins(Sampled(num=[0.5], den=[1, -0.5], dt=1.0))  # L(z = 1) = 1 exactly, then below
    assert got.delay_margin == inf
    assert got.gain_margin == pytest.approx(3, rel=1e-14)


# b/(z - a), of the floats b and a: |L| = 1 at 4 a sin^2(w/2) = b^2 - (1 - a)^2.
BY_A_LAST_BIT = [
    (0.1, 0.9, True, None),  # L(1) = 1 + 3e-16, far from -1: a margin of 180 deg or none
    (0.7, 0.3, True, None),  # L(1) = 1 - 8e-17: none, but for the last bit
    (0.75, 0.25, True, None),  # L(1) = 1
    (-1.9, 0.9, False, None),  # L(-1) = 1 - 6e-17
    (-0.1, 0.9, False, "beside 0 rad/s"),  # L(1) = -1 - 3e-16, a pole at 1 + 3e-17
    (1.9, 0.9, True, "stability may be lost"),  # a pole at -(1 - 1.1e-16)
]


@pytest.mark.parametrize(("b", "a", "stable", "doubt"), BY_A_LAST_BIT)
def test_floats_are_exact_at_the_ends_and_their_rounding_is_said(b, a, stable, doubt):
    top, pole = Fraction(b), Fraction(a)
    sine = (top**2 - (1 - pole) ** 2) / (4 * pole)  # exact; its square root and arcsine are not
    with mp.workdps(50):
        w = float(2 * mp.asin(mp.sqrt(mpf(sine.numerator) / sine.denominator))) if sine > 0 else 0
    found = measure_loop(Loop.of(Sampled(num=[b], den=[1, -a], dt=1.0)))
    assert found.stable is (abs(pole - top) < 1) is stable
    assert [w for w, _ in found.gain_crossings] == ([pytest.approx(w, rel=1e-12)] if w else [])
    assert found.certificate.holds
    assert any(doubt in sentence for sentence in found.warnings) if doubt else not found.warnings


@pytest.mark.parametrize("dead_time", [0.0, 0.25])
def test_floats_are_exact_at_the_ends_in_s_too(dead_time):
    b, a = 0.1 + 0.2, 0.3  # b/(s + a): w^2 = b^2 - a^2 of the floats, a hair above 0
    w = float(Fraction(b) ** 2 - Fraction(a) ** 2) ** 0.5
    found = measure_loop(Loop.of(Plant(num=[b], den=[1, a], dead_time=dead_time)))
    assert (found.crossover, found.warnings) == (pytest.approx(w, rel=1e-12), ())
    found = measure_loop(Loop.of(Plant(num=[a], den=[1, b], dead_time=dead_time)))
    assert (found.crossover, found.warnings) == (None, ())
    turned = measure_loop(Loop.of(Plant(num=[-a], den=[1, b], dead_time=dead_time)))
    assert "beside 0 rad/s" in turned.warnings[-1]  # there it is stability that a bit decides
    found = measure_loop(Loop.of(Plant(num=[a], den=[1, a], dead_time=dead_time)))
    assert (found.crossover, found.warnings) == (None, ())


def test_a_loop_that_starts_at_minus_one_has_no_margin():
    got = margins(Sampled(num=[-0.5], den=[1, -0.5], dt=1.0))  # L(z = 1) = -1 exactly
    assert (got.stable, got.gain_margin, got.phase_crossover) == (False, 1.0, 0.0)
    assert got.modulus_margin == pytest.approx(0, abs=1e-15)


def test_on_the_boundary_is_not_stable():
    assert not margins(Sampled(num=[1.5], den=[1, -0.5], dt=1.0)).stable  # pole at z = -1
    assert not margins(Plant(num=[6], den=[1, 3, 2, 0])).stable  # poles at +- j sqrt(2)
    assert not margins(Sampled(num=[-0.5], den=[1, -0.5], dt=1.0)).stable  # pole at z = +1


def test_what_is_not_proved_to_be_stable_is_not_called_unstable():
    on_the_edge = Plant(num=[1], den=[1, 0], dead_time=pi / 2)  # but for the digits of pi
    with pytest.warns(AccuracyWarning, match="not proved to be complete: stable"):
        found = margins(on_the_edge)
    assert found.stable is None


def test_a_hidden_unstable_mode_is_unstable():
    assert not margins(Sampled(num=[0.125, -0.15], den=[1, -2.1, 1.08], dt=0.1)).stable
    assert not margins(Plant(num=[1, -1], den=[1, 1, -2])).stable


@pytest.mark.parametrize("samples", [0.0, 2.0, 3.0, 7.0, 40.0])
@pytest.mark.parametrize("gain", [0.01, 0.3])
def test_the_nearest_crossing_by_itself_is_where_the_gain_is_one(samples, gain):
    # |K/(z - 1)| = 1: 2 sin(w/2) = K; its phase there is -90 deg - w/2, the delay's turn apart
    loop = Sampled(num=[gain], den=[1, -1] + [0] * int(samples), dt=1.0)
    w = 2 * asin(gain / 2)
    crossover, margin = nearest_crossing(Loop.of(loop))
    assert crossover == pytest.approx(w, rel=REL)
    assert margin == pytest.approx(remainder(90 - degrees(w * (samples + 0.5)), 360), abs=DEG)


def test_no_crossing_is_infinitely_far_away():
    late = [0] * 5
    assert nearest_crossing(Loop.of(Sampled(num=[0.1], den=[1, -0.5, *late], dt=1.0))) == (
        None,
        inf,
    )


@pytest.mark.parametrize("dt", [1.0, 1e-6])
@pytest.mark.parametrize(
    ("num", "den", "plain_num", "plain_den"),
    [
        # (z^2 - z/2 + 1), (z^2 - z + 1) and (z^2 + 1/2 z + 1) shared: 0/0 on the circle
        ([0.5, -0.25, 0.5], [1, -1, 1.25, -0.5], [0.5], [1, -0.5]),
        ([0.5, -0.5, 0.5], [1, -1.5, 1.75, -0.75, 0.25], [0.5], [1, -0.5, 0.25]),
        ([0.5, 0.5, 0.625, 0.25], [1, 0, 0.75, -1, -0.25, -0.5], [0.5, 0.25],
         [1, -0.5, 0, -0.5]),
    ],
)  # fmt: skip
def test_what_is_shared_on_the_circle_is_seen_past(num, den, plain_num, plain_den, dt):
    seen = margins(Sampled(num=num, den=den, dt=dt))
    plain = margins(Sampled(num=plain_num, den=plain_den, dt=dt))
    assert seen.stable is False
    assert seen.certificate.holds
    for name in ("gain_margin", "phase_margin_deg", "modulus_margin", "mt", "disk_margin"):
        assert getattr(seen, name) == pytest.approx(getattr(plain, name), rel=1e-9)
    assert len(seen.gain_crossings) == len(plain.gain_crossings)
    assert len(seen.phase_crossings) == len(plain.phase_crossings)


def test_two_crossings_on_a_needle_are_two():
    """A resonance that reaches over 1 by a hair, on a band a millionth of w wide."""
    zeta, wn = 1e-6, 7.0
    for gain, count in ((1.0 + 1e-3, 2), (1.0 - 1e-3, 0)):
        loop = Plant(num=[2 * zeta * wn * gain, 0.0], den=[1.0, 2 * zeta * wn, wn**2])
        crossings = margins(loop).gain_crossings
        assert len(crossings) == count
        # |L|^2 = g^2 b^2/(x^2 + b^2), b = 2 zeta wn, x = w - wn^2/w: x = +- b sqrt(g^2 - 1)
        for (w, _), sign in zip(crossings, (-1, 1), strict=False):
            x = sign * 2 * zeta * wn * sqrt(gain**2 - 1)
            # 1e-9: w itself to REL; x is a 1e-8 part of it
            assert w == pytest.approx(x / 2 + sqrt(x * x / 4 + wn * wn), rel=REL)


@pytest.mark.parametrize("gain", [1e-305, 1e-200, 1e-162, 1e-150, 1e-80, 1e80, 1e150, 1e300])
@pytest.mark.parametrize("lags", [1, 2])
def test_gains_whose_squares_no_float_holds(gain, lags):
    """K/(s (s + 1)^n) in 700 digits: w^2 (1 + w^2)^n = K^2, margin 90 deg - n arctan w.

    |T| is 10^-0.15 where w^2 (1 + w^2)^n and the like of it are passed: K^2 = 10^-0.3 |D + K|^2.
    """
    with mp.workdps(700):
        k = mpf(gain)
        scale = k if gain < 1 else mp.root(k, lags + 1)
        w = scale * mp.findroot(
            lambda x: mp.log(x) + lags * mp.log1p((scale * x) ** 2) / 2 - mp.log(k / scale), 1
        )
        pm = mp.degrees(mp.pi / 2 - lags * mp.atan(w))

        def loud(x):
            s = mpc(0, scale * x)
            return mp.log(abs(1 + s * (1 + s) ** lags / k)) - mpf("0.15") * mp.log(10)

        bandwidth = scale * mp.findroot(loud, 1.5)
        expected = float(w), float(pm), float(bandwidth)
    found = margins(Plant(num=[gain], den=np.polymul([1.0, 0.0], [[1, 1], [1, 2, 1]][lags - 1])))
    assert found.crossover == pytest.approx(expected[0], rel=REL, abs=0)
    assert found.phase_margin_deg == pytest.approx(expected[1], abs=DEG)
    assert found.bandwidth == pytest.approx(expected[2], rel=REL, abs=0)
    assert found.certificate.holds


def test_json_has_no_infinity_and_no_nan():
    found = margins(Plant(num=[0.5], den=[1])).to_dict()
    assert found["gain_margin"] == "inf"
    assert found["gain_margin_db"] == "inf"
    assert found["phase_crossover"] is None
    assert found["phase_margin_deg"] == "inf"
    assert found["delay_margin"] == "inf"
    json.dumps(found, allow_nan=False)


def test_json_of_a_crossing_at_infinity_is_json():
    found = margins(Plant(num=[-1, 2], den=[2, 5]))  # L(infinity) = -1/2: a gain of 2 undoes it
    assert found.gain_margin == 2
    assert found.phase_crossover == inf
    json.dumps(found.to_dict(), allow_nan=False)


@pytest.mark.parametrize("bad", [None, 1.0, [1, 2], "1/s"])
def test_refuses_what_is_no_loop(bad):
    with pytest.raises(SpecError, match="must be a"):
        margins(bad)


ROOTS = st.lists(st.floats(-0.95, 0.95), min_size=1, max_size=4)
KINDS = st.builds(
    lambda poles, zeros, k: Sampled(
        num=[k * c for c in np.poly(zeros[: len(poles)])], den=np.poly(poles), dt=0.1
    ),
    ROOTS, ROOTS, st.floats(0.05, 5),
)  # fmt: skip


def measured_quietly(loop):
    """Return the margins of a loop whose last bits may decide about an end of the axis."""
    return measure_loop(Loop.of(loop))


def steep(m, loop):
    """Skip a loop with a crossing so flat that rounding decides about it."""
    for w, _ in m.gain_crossings:
        assume(0 < w < pi / loop.dt)
        assume(abs(np.log(abs(loop.at(w * (1 + 1e-6)))) * 1e6) > 1e-2)
    for w, k in m.phase_crossings:
        if 0 < w < 0.999 * pi / loop.dt:
            turned = -loop.at(w * (1 + 1e-6)) * k
            assume(abs(np.angle(turned)) * 1e6 > 1e-2)


@given(KINDS, st.floats(0.2, 5))
def test_gain_moves_the_gain_margins_and_nothing_else(loop, k):
    louder = Sampled(num=[k * c for c in loop.num], den=loop.den, dt=loop.dt)
    one, other = measured_quietly(loop), measured_quietly(louder)
    steep(one, loop)
    steep(other, louder)
    assert len(one.phase_crossings) == len(other.phase_crossings)
    for (w, a), (w2, b) in zip(one.phase_crossings, other.phase_crossings, strict=True):
        assert (w2, b * k) == pytest.approx((w, a), rel=REL)


@given(KINDS, st.integers(-10, 10))
def test_a_slower_clock_slows_the_frequencies_and_nothing_else(loop, power):
    c = 2.0**power
    one, slow = (
        measured_quietly(x) for x in (loop, Sampled(num=loop.num, den=loop.den, dt=loop.dt * c))
    )
    steep(one, loop)
    assert slow.stable is one.stable
    assert len(slow.gain_crossings) == len(one.gain_crossings)
    for (w, pm), (w2, pm2) in zip(one.gain_crossings, slow.gain_crossings, strict=True):
        assert w2 * c == pytest.approx(w, rel=REL)
        assert pm2 == pytest.approx(pm, abs=DEG)
    assert slow.gain_margin == pytest.approx(one.gain_margin, rel=REL)
    assert slow.delay_margin == pytest.approx(one.delay_margin * c, rel=REL)
    assert (slow.modulus_margin, slow.mt, slow.disk_margin) == pytest.approx(
        (one.modulus_margin, one.mt, one.disk_margin), rel=REL
    )


@given(KINDS)
def test_z_and_w_tell_the_same_loop(loop):
    """But for the rounding of the w-coefficients, which the z-coefficients do not go through."""
    twin = Sampled.from_w(num_w=loop.num_w, den_w=loop.den_w, dt=loop.dt, delay=loop.delay)
    one, other = measured_quietly(loop), measured_quietly(twin)
    steep(one, loop)
    steep(other, loop)
    assert other.stable is one.stable
    assert np.ravel(other.gain_crossings) == pytest.approx(np.ravel(one.gain_crossings), rel=REL)
    assert np.ravel(other.phase_crossings) == pytest.approx(np.ravel(one.phase_crossings), rel=REL)
    assert (other.modulus_margin, other.mt) == pytest.approx((one.modulus_margin, one.mt), rel=REL)


@given(KINDS)
def test_the_loop_is_on_the_circle_and_on_the_ray_where_it_says(loop):
    found = measured_quietly(loop)
    steep(found, loop)
    for w, pm in found.gain_crossings:
        value = loop.at(w)
        # 1e-8: a root of a polynomial whose crossing may be as flat as ``steep`` lets it be
        assert abs(value) == pytest.approx(1, abs=1e-8)
        assert value / abs(value) == pytest.approx(-np.exp(1j * radians(pm)), abs=1e-9)
    for w, k in found.phase_crossings:
        assert loop.at(w) * k == pytest.approx(-1, abs=1e-8)  # as above


@given(KINDS)
def test_extra_delay_up_to_the_delay_margin_keeps_it_stable(loop):
    found = measured_quietly(loop)
    assume(found.stable)
    steep(found, loop)
    samples = int(min(found.delay_margin / loop.dt * (1 - 1e-9), 25))
    late = Sampled(num=loop.num, den=[*loop.den, *[0.0] * samples], dt=loop.dt)
    assert measure_loop(Loop.of(late)).stable


# L(-1) is 2.2/0.9, 3/1.6, 2 and 2.2/1.1; the last has an unstable pole, and is -0.5/0.3 there.
LOUD = [
    ([1.2, -1], [1, 0.1]), ([2, -1], [1, -0.6]), ([2], [1]), ([1.2, -1], [1, -0.1]),
    ([1, 0.5], [1, 1.3]),
]  # fmt: skip


@pytest.mark.parametrize(("num", "den"), LOUD)
def test_what_is_loud_at_nyquist_bears_no_extra_sample(num, den):
    """The poles of the closed loop are those of z^k den + num: one is outside for odd k."""
    dt = 0.5

    def largest(k):
        return max(np.abs(np.roots(np.polyadd([*den, *[0.0] * k], num))), default=0)

    assert largest(0) < 0.95
    assert min(largest(k) for k in (1, 3, 5, 7)) > 1.05
    assert margins(Sampled(num=num, den=den, dt=dt)).delay_margin == dt


def test_a_loop_that_starts_at_minus_one_bears_no_delay():
    assert margins(Plant(num=[-1], den=[1, 1])).delay_margin == 0  # a pole at s = 0
    assert margins(Sampled(num=[-0.5], den=[1, -0.5], dt=1.0)).delay_margin == 0  # one at z = 1


@given(KINDS)
def test_the_least_gain_margin_above_one_is_where_stability_ends(loop):
    def scaled(k):
        return measured_quietly(Sampled(num=[k * c for c in loop.num], den=loop.den, dt=loop.dt))

    largest = np.abs(loop.at(np.linspace(0, pi / loop.dt, 300))).max()
    quiet = scaled(0.5 / largest)  # a stable loop of gain below one is stable in feedback
    assert quiet.stable
    if quiet.gain_margin < 1e6:
        quiet_factor = 0.5 / largest
        assert scaled(quiet_factor * quiet.gain_margin * (1 - 1e-6)).stable
        assert not scaled(quiet_factor * quiet.gain_margin * (1 + 1e-6)).stable


@given(KINDS)
def test_peaks_bound_a_fine_grid(loop):
    found = measured_quietly(loop)
    value = loop.at(np.linspace(0, pi / loop.dt, 500))
    finite = value[np.isfinite(value)]
    assert found.modulus_margin <= np.abs(1 + finite).min() * (1 + 1e-12)
    # 1e-9: near an unstable closed loop 1 + L is a small difference
    assert found.mt >= np.abs(finite / (1 + finite)).max() * (1 - 1e-9)
    with np.errstate(divide="ignore"):  # L = 1 is infinitely far from the disk
        assert found.disk_margin <= 2 * np.abs((1 + finite) / (1 - finite)).min() * (1 + 1e-9)
    assert abs(1 + loop.at(found.ms_frequency)) == pytest.approx(found.modulus_margin, rel=1e-9)


def test_delay_margin_is_the_least_over_all_crossings():
    """The smallest phase margin does not always cost the least delay."""
    loop = Plant(num=[1.2, 0.3, 1.2], den=[1.0, 0.05, 4.0, 0.0])
    found = margins(loop)
    assert len(found.gain_crossings) == 3
    by_hand = [radians(pm) % tau / w for w, pm in found.gain_crossings]
    assert found.delay_margin == pytest.approx(min(by_hand), rel=1e-14)
    assert margins(Plant(num=loop.num, den=loop.den, dead_time=found.delay_margin * 0.999)).stable
    assert not margins(
        Plant(num=loop.num, den=loop.den, dead_time=found.delay_margin * 1.001)
    ).stable


@given(st.fractions(Fraction(1, 50), Fraction(49, 50)), st.fractions(Fraction(1, 50), 3))
def test_first_order_loops_have_closed_forms(a, b):
    """b/(z - a): cos wc = (1 + a^2 - b^2)/(2a), and at z = -1 the factor (1 + a)/b."""
    a, b = float(a), float(b)
    found = margins(Sampled(num=[b], den=[1, -a], dt=1.0))
    assert found.phase_crossings == ((pi, pytest.approx((1 + a) / b, rel=1e-14)),)
    assert found.stable is (b < 1 + a)
    cos = (1 + a * a - b * b) / (2 * a)
    if abs(cos) < 0.999:
        assert found.crossover == pytest.approx(np.arccos(cos), rel=REL)
    elif abs(cos) > 1.001:
        assert found.crossover is None


@pytest.mark.parametrize("gain", [1e-300, 1e-160, 1e-100, 1e100, 1e160, 1e250, 1e300])
def test_gains_near_the_ends_of_a_float(gain):
    """g/(s + 1)^3: real at sqrt(3) with |L| = g/8; T is L below 1, and falls where w^3 = g."""
    found = margins(Plant(num=[gain], den=[1, 3, 3, 1]))
    assert found.gain_margin == pytest.approx(8 / gain, rel=1e-12)
    assert found.certificate.holds
    if gain < 1:
        assert (found.modulus_margin, found.disk_margin) == (1.0, 2.0)
        assert found.mt == pytest.approx(gain, rel=1e-12)
        # (1 + q)^3 = 10^0.3
        assert found.bandwidth == pytest.approx(sqrt(10**0.1 - 1), rel=1e-12)
    else:
        # |1 + w^3/(j^3 g)|^2 = 1 + (w^3/g)^2 = 10^0.3 but for 1e-33 of it
        assert found.bandwidth == pytest.approx((gain * sqrt(10**0.3 - 1)) ** (1 / 3), rel=1e-12)


def test_what_no_float_holds_is_one_clear_line():
    with pytest.raises(SpecError, match="must have gains that a 64-bit float can hold"):
        margins(Plant(num=[1e200], den=[1e-200, 1, 1e200]))


def test_a_loop_a_hair_from_its_edge_has_its_bandwidth():
    """L(0) = -1 + 1.5e-7, behind 6 samples: a whole number of thousands of bits is no overflow."""
    plant = Plant(
        num=[0.11344568680814333],
        den=[1.0, 14.111268492899022, 87.81622125627555, 222.94116955987988, 91.74546325262706,
             -23.593075472811037],
        dead_time=0.015706451465325948,
    )  # fmt: skip
    behind = sample(plant, dt := 0.002802832932000033)
    kp, kd, p = 207.9680567128488, 1926.5034136233403, 2.6218089016253017
    law = Sampled.from_w(num_w=[kp / p + kd, kp], den_w=[1 / p, 1.0], dt=dt)
    found = measure_loop(Loop.of(law, behind))
    assert found.certificate.holds
    with mp.workdps(50):
        factors = [
            [mpf(c) for c in a[::-1]] for a in (law.num_w, behind.num_w, law.den_w, behind.den_w)
        ]

        def closed(w):
            v = mpc(0, 2 / mpf(dt) * mp.tan(mpf(w) * dt / 2))
            ours, plants, under, over = (sum(c * v**k for k, c in enumerate(a)) for a in factors)
            late = ((1 - v * dt / 2) / (1 + v * dt / 2)) ** behind.delay
            loop = ours * plants / under / over * late
            return abs(loop / (1 + loop))

        away = closed(found.bandwidth) / closed(0) / mpf(10) ** mpf("-0.15") - 1
        steep = (closed(found.bandwidth * (1 + 1e-6)) / closed(found.bandwidth) - 1) / 1e-6
        assert abs(away / steep) < REL


def test_the_nearest_crossing_in_s_is_where_the_gain_is_one():
    """5/s: |L| = 1 at 5 rad/s, 90 deg from -1 but for what the dead time turns."""
    assert nearest_crossing(Loop.of(Plant(num=[5], den=[1, 0]))) == (
        pytest.approx(5.0, rel=REL),
        pytest.approx(90.0, abs=DEG),
    )
    late = Loop.of(Plant(num=[5], den=[1, 0], dead_time=0.125))
    assert nearest_crossing(late) == (
        pytest.approx(5.0, rel=REL),
        pytest.approx(90 - degrees(0.625), abs=DEG),
    )
