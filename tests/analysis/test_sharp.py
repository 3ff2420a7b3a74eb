"""Crossings and peaks where a float of v is not enough: each truth is exact or has 50 digits."""

from fractions import Fraction
from math import inf, pi, sqrt

import pytest
from mpmath import mp, mpf

from zoh.analysis import newton
from zoh.analysis.close import Close
from zoh.analysis.loop import Loop
from zoh.analysis.margins import margins, measure_loop
from zoh.analysis.needles import ratio_at_end
from zoh.analysis.proof import Found, Peak, proved
from zoh.analysis.sharp import EXACT, ROUNDED, apart, as_v, closed_in, is_nothing, sharpened
from zoh.analysis.squares import ON_DEN, ON_OPPOSITE, Squares, squared
from zoh.lti import whole
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

DIGITS = 60


def unities_of_a_mode(k, a, b):
    """Return v where |k/(s^2 + a s + b)| = 1: (b - q)^2 + a^2 q = k^2, from the floats."""
    with mp.workdps(DIGITS):
        half = mpf(b) - mpf(a) ** 2 / 2
        off = mp.sqrt(half**2 - mpf(b) ** 2 + mpf(k) ** 2)
        return [mp.sqrt(half - off), mp.sqrt(half + off)]


# one of two gain crossings lies on a point of the grid, q = 2^(i/2): the other was lost
@pytest.mark.parametrize("octave", range(-8, 9))
@pytest.mark.parametrize("apart_by", [0.72, 0.9, 0.995, 1.01, 1.21, 1.4])
@pytest.mark.parametrize("damping", [1e-3, 0.05, 0.16])
def test_a_crossing_on_a_point_of_the_grid_hides_no_other(octave, apart_by, damping):
    w = 2.0 ** (octave / 4)
    a = damping * w
    b = (w * w * (1 + apart_by) + a * a) / 2
    k = sqrt((b - w * w) ** 2 + (a * w) ** 2)
    true = unities_of_a_mode(k, a, b)
    for loop, frequency in (
        (Plant(num=[k], den=[1, a, b]), lambda v: v),
        (Sampled.from_w(num_w=[k], den_w=[1, a, b], dt=0.1), lambda v: 20 * mp.atan(v / 20)),
    ):
        found = margins(loop)
        assert found.certificate.holds
        # 1e-11: two crossings half a percent apart move by a hundred times a coefficient's rounding
        expected = [float(frequency(v)) for v in true]
        assert [w for w, _ in found.gain_crossings] == pytest.approx(expected, rel=1e-11)
        for (_, pm), v in zip(found.gain_crossings, true, strict=True):
            with mp.workdps(DIGITS):
                angle = mp.degrees(mp.arg(-mpf(k) / mp.mpc(b - v * v, a * v)))
            assert pm == pytest.approx(float(angle), abs=1e-9)


def test_the_crossing_beside_one_at_a_whole_number():
    """0.2/(s^2 + 0.16 s + 1.12) is 1 at 1 rad/s but for rounding, and at 1.102."""
    found = margins(Plant(num=[0.2], den=[1, 0.16, 1.12]))
    first, second = unities_of_a_mode(0.2, 0.16, 1.12)
    assert found.gain_crossings == (
        (pytest.approx(float(first), rel=1e-12), pytest.approx(126.8698976458, abs=1e-9)),
        (pytest.approx(float(second), rel=1e-12), pytest.approx(61.8358006304, abs=1e-9)),
    )
    assert found.delay_margin == pytest.approx(0.979346727775, rel=1e-9)


@pytest.mark.parametrize("w", [0.25, 0.5, 1.0, 2.0, 4.0])
@pytest.mark.parametrize("lag", [0.0625, 0.125, 0.2, 0.5, 1.0])
def test_a_zero_on_a_point_of_the_grid_hides_no_phase_crossing(w, lag):
    """(s^2 + w^2)/(s (T s + 1)(s^2 + w s + w^2)) is real where q = w^2/(1 + T w), and at the zero.

    The factor is that of a complex division in 60 digits there.
    """
    t = lag / w
    den = [t, 1 + t * w, w + t * w * w, w * w, 0.0]
    found = margins(Plant(num=[1, 0, w * w], den=den))
    with mp.workdps(DIGITS):
        s = 1j * mp.sqrt(mpf(w) ** 2 / (1 + mpf(t) * w))
        gain = (s**2 + mpf(w) ** 2) / (s * (mpf(t) * s + 1) * (s**2 + w * s + mpf(w) ** 2))
    assert found.certificate.holds
    assert found.phase_crossings == (
        (
            pytest.approx(float(abs(s)), rel=1e-12),
            pytest.approx(float(-1 / gain.real), rel=1e-12),
        ),
    )


def horner(a, s):
    value = mpf(0)
    for c in a:
        value = value * s + mpf(c)
    return value


def notch_on_an_integrator(top, bottom, dt):
    """Return (the loop, 1/s behind its hold times top/bottom in w, and L(jv) with any digits)."""
    notch = Sampled.from_w(num_w=top, den_w=bottom, dt=dt)

    def gain(v):
        s = mp.mpc(0, v)
        held = (1 - s * mpf(dt) / 2) / s  # the hold of 1/s: dt/(z - 1)
        return held * horner(top, s) / horner(bottom, s)

    return notch * sample(Plant(num=[1], den=[1, 0]), dt), gain


@pytest.mark.parametrize(
    ("top", "bottom", "dt", "near"),
    [
        (
            [17.28233463299769, 0.0, 5.777149045227309],
            [1.0, 0.5781700369208331, 0.3342805915930375], 2.420029263702622e-05, "0.5781680145",
        ),
        (
            [29.168414385332174, 0.0, 179.03738082827465],
            [1.0, 2.4775101780298323, 6.1380566822414115], 1.5648767737332766e-06, "2.4775077767",
        ),
        ([1.0, 0.0, 1.0], [1.0, 1.0, 1.0], 1e-4, "0.999975000"),
    ],
)  # fmt: skip
def test_beside_an_undamped_zero_a_gain_margin_has_its_digits(top, bottom, dt, near):
    """And at the zero itself, where L is 0 but for rounding, is no crossing."""
    loop, gain = notch_on_an_integrator(top, bottom, dt)
    with mp.workdps(DIGITS):
        v = mp.findroot(lambda v: mp.im(gain(v)) / abs(gain(v)), mpf(near))
        at_last = 1 / mp.mpf(dt) * 2 / top[0]  # at Nyquist's frequency: L = -dt/2 top[0]
        w, factor = 2 / mpf(dt) * mp.atan(v * dt / 2), -1 / mp.re(gain(v))
    found = measure_loop(Loop.of(loop))  # what is said of rounding is an upper bound
    assert found.certificate.holds
    assert found.phase_crossings[0] == (
        pytest.approx(float(w), rel=1e-12), pytest.approx(float(factor), rel=1e-9)
    )  # fmt: skip
    others = found.phase_crossings[1:]
    assert all(w > 1e3 for w, _ in others)  # the last one is where the hold has turned L
    assert others[-1][1] == pytest.approx(float(at_last), rel=1e-6)  # or just before it


@pytest.mark.parametrize("dead_time", [0.0, 20.0])
@pytest.mark.parametrize("loud", [1.25, 1.5, 40.0])
def test_beside_an_undamped_pole_a_phase_margin_has_its_digits(dead_time, loud):
    """A last digit of w turns L there by 1e-5 deg."""
    a, b = 2.0**-34, 1.44
    k = loud * a
    loop = Plant(num=[k], den=[1, a, b], dead_time=dead_time)
    found = measure_loop(Loop.of(loop))
    true = unities_of_a_mode(k, a, b)
    assert len(found.gain_crossings) == len(true) == 2
    for (w, pm), v in zip(found.gain_crossings, true, strict=True):
        with mp.workdps(DIGITS):
            turned = mp.mpc(b - v * v, a * v) * mp.expj(v * dead_time)
            angle = mp.degrees(mp.arg(-1 / turned))
        assert w == pytest.approx(float(v), rel=1e-15)
        assert pm == pytest.approx(float(angle), abs=1e-9)


@pytest.mark.parametrize("part", [2.0**-30, -(2.0**-30), 2.0**-20])
@pytest.mark.parametrize("a", [(0.5, 0.25), (-0.75, 0.5), (0.25, -0.125)])
def test_an_all_pass_that_misses_minus_one_by_a_hair(part, a):
    """|L| is g everywhere, and L = -g somewhere inside: nearest to -1 there."""
    g = 1 + part
    found = margins(Sampled(num=[g * a[1], g * a[0], g], den=[1, *a], dt=0.1))
    near = abs(part)
    assert found.modulus_margin == pytest.approx(near, rel=1e-9)
    assert found.mt == pytest.approx(g / near, rel=1e-9)
    assert found.disk_margin == pytest.approx(2 * near / (2 + part), rel=1e-9)
    assert not {"modulus_margin", "mt", "disk_margin"} & {*found.certificate.open()}


def test_what_touches_minus_one_touches_it():
    """den + num = z^2 - z/4 + 1 has its roots on the circle."""
    found = margins(Sampled(num=[0.4375, 0.125], den=[1, -0.6875, 0.875], dt=1))
    assert (found.modulus_margin, found.mt, found.disk_margin) == (0.0, inf, 0.0)
    assert found.ms_frequency == pytest.approx(float(mp.acos(0.125)), rel=1e-12)
    near = margins(Sampled(num=[0.4375, 0.125 - 2**-40], den=[1, -0.6875, 0.875], dt=1))
    assert 1e-14 < near.modulus_margin < 1e-11
    hidden = measure_loop(Loop.of(Plant(num=[0.5, 0, 2], den=[1, 1, 4, 4])))  # 0.5/(s + 1)
    assert hidden.modulus_margin == pytest.approx(1.0)


@pytest.mark.parametrize("num", [-0.999999999, -1.000000001])
def test_the_end_of_the_axis_is_a_difference_in_whole_numbers(num):
    """1 + L is 1 + num at z = 1, exactly, and num z/(z - 0.5) there is 2 num."""
    found = margins(Sampled(num=[num / 2, 0.0], den=[1, -0.5], dt=1.0))
    true = abs(1 + Fraction(num))
    assert found.modulus_margin == float(true)
    assert found.disk_margin == pytest.approx(float(2 * true / (1 - Fraction(num))), rel=1e-15)
    loop = Loop.of(Sampled(num=[-num], den=[1, 0, 0], dt=1.0))
    assert ratio_at_end(loop, 0.0, ON_OPPOSITE) == float((1 - Fraction(num)) / abs(1 + num))
    late = Loop.of(Sampled.from_w(num_w=[num], den_w=[1.0], dt=1.0, delay=3))
    assert ratio_at_end(late, inf, ON_DEN) == float(1 - Fraction(num))


def test_closing_in_on_a_root():
    with mp.workdps(80):
        top, bottom = closed_in((1, 0, -2), 1.18921)
        assert abs(mpf(top) / bottom / mp.sqrt(2) - 1) < mpf(2) ** -140
    cube = whole.times((1, -2), whole.times((1, -2), (1, -2)))
    top, bottom = closed_in(cube, sqrt(2) * (1 + 1e-5))
    assert abs(Fraction(top, bottom) - 2) < Fraction(1, 2**100)
    for none in ((1, 0, 2), (1, 2), (0,), (1, -3)):  # of the last one: far from q = 2
        assert Fraction(*closed_in(none, sqrt(2))) == Fraction(*squared(sqrt(2)))
    assert as_v((9, 4)) == 1.5
    near = 2 * (1 + 1e-9)
    assert sharpened((1, -4), near) == 2.0
    assert sharpened((1, 4), near) == near
    assert sharpened((1, -4), 2 * (1 + 4e-16)) == 2 * (1 + 4e-16)


def test_a_root_a_thousandth_away_is_the_one_that_was_seen():
    for part, found in ((7e-4, True), (-7e-4, True), (1.1e-3, False), (-1.1e-3, False)):
        seen = closed_in((1, -3), sqrt(3 * (1 + part)))
        assert (Fraction(*seen) == 3) is found


@pytest.mark.parametrize("rising", [1, -1])
@pytest.mark.parametrize("share", [1 - 4e-15, 1 + 4e-15])
def test_a_root_at_the_end_of_what_is_looked_at_is_not_a_rounding_away(rising, share):
    away = next(v for i in range(-40, 40) if (v := 2.0 + i * 2.0**-52) * share == 2.0)
    assert away != 2.0
    assert sharpened((rising, -4 * rising), away) == 2.0


def test_what_is_nothing_and_what_is_little():
    assert is_nothing((1, -2), (2, 1))
    little = (2**92, -(2**92) + 1)  # 1 where its terms are 2^93
    assert not is_nothing(little, (1, 1), ROUNDED)
    assert is_nothing(little, (1, 1), ROUNDED - 1)
    assert not is_nothing((2**120, -(2**120) + 1), (1, 1), EXACT)


def test_sign_changes_of_their_own():
    def f(v):
        return (v - 1) * (v - 2) * (v - 3)

    assert apart(f, [1.0, 2.0, 3.0])
    assert apart(f, [])
    for wrong in ([1.0, 1.0, 3.0], [1.0, 2.0, 2.0], [1.5], [2.0, 3.1], [1.0, 1.0 + 1e-13]):
        assert not apart(f, wrong)
    for off, inside in ((0.75, True), (-0.75, True), (1.5, False), (-1.5, False)):
        root = 1 + off * 2.0**-40
        assert apart(lambda v, root=root: v - root, [1.0]) is inside
        assert apart(lambda v, root=root: root - v, [1.0]) is inside
    for sign in (1.0, -1.0):  # 0 on one side is no change of sign
        assert not apart(lambda v, sign=sign: sign if v > 1 else 0.0, [1.0])
        assert not apart(lambda v, sign=sign: sign if v < 1 else 0.0, [1.0])
    assert apart(f, [2.2], within=0.2)
    assert not apart(f, [2.2, 2.3], within=0.2)


def test_a_point_that_two_brackets_share_is_moved_off_the_root():
    for roots in ((1.0, 1.2), (0.9, 1.0), (1.0, 1.0 + 1e-6)):
        a = [1.0, -sum(roots), roots[0] * roots[1]]
        ends = [(x, (x - roots[0]) * (x - roots[1])) for x in (0.75, 1.4)]
        left, right = [0.75, 1.0, ends[0][1], -1e-18], [1.0, 1.4, -1e-18, ends[1][1]]
        newton.part(a, left, right)
        assert left[1] == right[0]
        assert roots[0] < left[1] < roots[1]
        assert left[3] == right[2] < 0
    left, right = [0.75, 1.0, 1.0, -1e-18], [1.0, 1.4, -1e-18, 1.0]
    newton.part([1.0, -2.0, 1.0], left, right)  # nowhere below 0
    assert (left[1], right[0]) == (1.0, 1.0)


def test_under_a_delay_a_crossing_said_twice_for_its_neighbour_is_no_proof():
    """exp(-s) of a lag: real at many frequencies, as many as are said."""
    loop = Loop.of(Plant(num=[2], den=[1, 1], dead_time=0.5))
    squares = Squares.of(loop)
    look = Close.of(loop, squares)
    turns, measured = look.turns(), measure_loop(loop)
    factor, stable = measured.gain_margin, measured.certificate.stable
    assert turns[0] == pytest.approx(float(mp.findroot(lambda w: w / 2 + mp.atan(w) - pi, 4)))
    for said, holds in ((turns, True), ([turns[0], *turns[:1], *turns[2:]], False)):
        found = Found(look.unities(), said, look.drops(), [], factor)
        told = phases_of(loop, squares, look, found, stable)
        assert told.holds is holds
        assert told.detail.endswith("sign change of its own") is not holds


def phases_of(loop, squares, look, found, stable):
    """Return the proof of the phase crossings alone: peaks of 0 have nothing to be proved."""
    nothing = [Peak(v=1.0, least=0.0, below=ON_DEN)] * 3
    return proved(loop, squares, look, found._replace(peaks=nothing), stable=stable).phase_crossings
