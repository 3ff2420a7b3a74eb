"""Which look margins takes, and what becomes of crossings at the ends of the axis."""

from math import inf, pi, sqrt

import numpy as np
import pytest
from mpmath import mp, mpc, mpf

from zoh.analysis import margins as room
from zoh.analysis import stretches
from zoh.analysis.loop import Loop
from zoh.analysis.margin_crossings import margin_deg
from zoh.analysis.margins import glance, margins, measure_loop
from zoh.analysis.nyquist import nearest_crossing
from zoh.analysis.tabled.margins import table_margins
from zoh.errors import SpecError
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample


class _Never:
    def __init__(self, *_, **__):
        raise AssertionError("this look is not needed")


def late_integrator(m, part):
    """Return part k/(z^m (z - 1)), k = 2 sin(pi/(4 m + 2)) closing onto -1 at w = pi/(2 m + 1)."""
    k = part * 2 * float(mp.sin(mp.pi / (4 * m + 2)))
    return Loop.of(Sampled.from_w(num_w=(-k / 2, k), den_w=(1.0, 0.0), dt=1.0, delay=m))


def test_a_sparse_look_that_is_proved_is_all(monkeypatch):
    monkeypatch.setattr(room, "Isolated", _Never)
    found = measure_loop(Loop.of(Plant(num=[1], den=[1, 3, 2, 0])))
    assert (found.gain_margin, found.certificate.holds) == (pytest.approx(6, rel=1e-14), True)


def test_what_a_close_look_proves_is_not_multiplied_out(monkeypatch):
    taken = []
    plain = room.Squares.of

    def seen(loop, *most):
        taken.append(most)
        return plain(loop, *most)

    monkeypatch.setattr(room.Squares, "of", seen)
    for m in (8, 20):
        assert measure_loop(late_integrator(m, 0.5)).certificate.holds
    assert taken == [(), ()]


def least_distance(m, k):
    """Return the least |1 + L| beside w = pi/(2 m + 1), in 50 digits."""
    with mp.workdps(50):

        def square(w):
            z = mp.expj(w)
            return abs(1 + mpf(k) / (z**m * (z - 1))) ** 2

        return float(
            mp.sqrt(square(mp.findroot(lambda w: mp.diff(square, w), mp.pi / (2 * m + 1))))
        )


@pytest.mark.parametrize(("m", "proved"), [(7, True), (12, True), (13, False)])
def test_few_samples_are_multiplied_in_where_the_grid_proves_too_little(monkeypatch, m, proved):
    monkeypatch.setattr(stretches, "_MOST", 200)  # intervals: fewer are sooner too little
    loop = late_integrator(m, 1 - 1e-7)
    found = measure_loop(loop)
    assert found.stable
    assert found.certificate.holds is proved
    assert bool(found.warnings) is not proved
    if proved:
        k = loop.num[1]
        assert found.modulus_margin == pytest.approx(least_distance(m, k), rel=1e-9)
        assert found.certificate.modulus_margin.method in ("Descartes", "halving")
        assert found.certificate.stable.holds


@pytest.mark.parametrize("m", [3, 8, 30])
def test_a_glance_proves_nothing_of_a_long_delay_and_sees_the_same(monkeypatch, m):
    loop = late_integrator(m, 0.5)
    wanted = measure_loop(loop)
    monkeypatch.setattr(room, "proved", _Never)
    found = glance(loop)
    assert found.certificate is None
    assert (found.stable, found.warnings) == (True, ())
    # L leaves -180 deg at w = pi/(2 m + 1), with half of what it may have
    assert found.gain_margin == pytest.approx(2.0, rel=1e-12)
    assert found.phase_crossover == pytest.approx(pi / (2 * m + 1), rel=1e-12)
    for name in ("phase_margin_deg", "crossover", "delay_margin", "bandwidth"):
        assert getattr(found, name) == pytest.approx(getattr(wanted, name), rel=1e-12)
    for name in ("modulus_margin", "mt", "disk_margin"):
        assert getattr(found, name) == pytest.approx(getattr(wanted, name), rel=1e-9)


@pytest.mark.parametrize(
    "loop",
    [
        Loop.of(Plant(num=[1], den=[1, 3, 2, 0])),
        Loop.of(Sampled(num=[0.5], den=[1, -0.5], dt=0.1)),
        late_integrator(2, 0.5),
    ],
)
def test_a_glance_without_a_long_delay_is_the_whole_thing(loop):
    assert glance(loop) == measure_loop(loop)


def test_a_glance_at_a_dead_time_proves_nothing():
    found = glance(Loop.of(Plant(num=[1], den=[1, 0], dead_time=0.1)))
    assert found.certificate is None
    assert found.gain_margin == pytest.approx(5 * pi, rel=1e-12)


@pytest.mark.parametrize("delay", [0, 20])
def test_beyond_floats_it_is_one_clear_line(delay):
    loop = Loop.of(
        Sampled.from_w(num_w=(0.0, 0.0, 1e200), den_w=(1e-200, 1, 1e200), dt=1.0, delay=delay)
    )
    for look in (glance, measure_loop):
        with pytest.raises(SpecError, match=r"gains that a 64-bit float can hold, got \[0\.0, 0"):
            look(loop)


def test_a_crossing_beyond_floats_is_one_clear_line_too():
    far = Loop.of(Sampled.from_w(num_w=(0.0, 1e300), den_w=(1e-300, 1e300), dt=1.0, delay=20))
    with pytest.raises(SpecError) as told:
        nearest_crossing(far)
    assert told.value.argument == "loop"
    assert told.value.value == [*far.num, *far.den]
    assert told.value.way_out


def test_a_loop_that_is_real_everywhere():
    """-2/(1 - s^2) is -2/(1 + w^2): a gain of 1/2 closes it onto -1 at rest, none needs be at 1."""
    found = measure_loop(Loop.of(Plant(num=[2], den=[1, 0, -1])))
    assert found.phase_crossings == ((0.0, 0.5), (pytest.approx(1.0, rel=1e-14), 1.0))
    assert found.gain_crossings == ((pytest.approx(1.0, rel=1e-14), 0.0),)
    assert not found.stable
    # 2/(1 - s^2): +1 is passed there, and that is no phase crossing
    turned = measure_loop(Loop.of(Plant(num=[-2], den=[1, 0, -1])))
    assert turned.phase_crossings == ()
    assert turned.gain_crossings == ((pytest.approx(1.0, rel=1e-14), 180.0),)


def test_a_factor_that_no_float_holds_is_no_margin():
    # k/(c s (s + 1) (s + 2)) bears a factor of 6 c/k at sqrt(2)
    for k, c, held in ((1e-300, 1.0, True), (1e-300, 1e10, False), (1e300, 1e-30, False)):
        found = measure_loop(Loop.of(Plant(num=[k], den=[c, 3 * c, 2 * c, 0])))
        assert found.gain_margin == (pytest.approx(6 * c / k, rel=1e-12) if held else inf)
        assert found.phase_crossover == (pytest.approx(sqrt(2), rel=1e-12) if held else None)


def held(k, plant):
    """Return k times a plant behind its hold, the two put together from their parameters."""
    return Sampled.from_w(num_w=(k,), den_w=(1.0,), dt=0.5), sample(plant, 0.5)


@pytest.mark.parametrize("a", [1.0, 0.7, 0.3])
@pytest.mark.parametrize("k", [3.0, 7.0, 10.0, 0.1, 49.0])
def test_a_held_loop_that_starts_at_one_but_for_rounding(k, a):
    """k (a/k)/(s + a): the last bits say whether |L| passes 1 at 1e-8 rad/s, and mean nothing."""
    lag = Plant(num=[a], den=[k, k * a])
    assert measure_loop(Loop.of(*held(k, lag))).gain_crossings == ()
    turned = Plant(num=[a], den=[k, k * a], sensor=-1.0)  # there it is -1
    assert measure_loop(Loop.of(*held(k, turned))).gain_crossings == ((0.0, 0.0),)


@pytest.mark.parametrize("zeta", [0.1, 0.6])
@pytest.mark.parametrize("a", [1.0, 0.7, 0.3, 1e-3])
@pytest.mark.parametrize("k", [3.0, 7.0, 10.0, 0.1, 49.0])
def test_a_crossing_further_on_is_none_of_rounding(k, a, zeta):
    """A resonance that starts at 1 passes it once more, near a sqrt(2 - 4 zeta^2)."""
    plant = Plant(num=[a * a], den=[k, 2 * zeta * a * k, a * a * k])
    law, sampled = held(k, plant)
    ((w, _),) = measure_loop(Loop.of(law, sampled)).gain_crossings
    assert w == pytest.approx(a * sqrt(2 - 4 * zeta**2), rel=0.05)  # what the hold adds
    assert abs(law.at(w) * sampled.at(w)) == pytest.approx(1.0, rel=1e-12)


def test_a_margin_is_in_the_half_turn_above():
    assert margin_deg(-1 + 0j) == 0.0
    assert margin_deg(1 + 0j) == 180.0
    assert margin_deg(complex(1.0, -0.0)) == 180.0
    assert margin_deg(complex(1.0, 0.0)) == 180.0
    assert margin_deg(-1j) == pytest.approx(90.0, rel=1e-15)
    assert margin_deg(1j) == pytest.approx(-90.0, rel=1e-15)


@pytest.mark.parametrize("dt", [0.1, 0.3, 0.7, 0.9, 1.1, 1.3, 1.7, 0.013])
def test_a_held_loop_that_ends_at_minus_one_but_for_rounding(dt):
    """(2/dt) dt/(z - 1): |L| falls to 1 at z = -1, where L is -1, and is flat there."""
    law = Sampled.from_w(num_w=(2 / dt,), den_w=(1.0,), dt=dt)
    loop = Loop.of(law, sample(Plant(num=[1], den=[1, 0]), dt))
    assert measure_loop(loop).gain_crossings == ((pytest.approx(pi / dt, rel=1e-15), 0.0),)


@pytest.mark.parametrize("unit", [1e-200, 1e-150, 1.0, 1e150, 1e200])
def test_what_num_and_den_share_moves_no_crossing(unit):
    found = measure_loop(Loop.of(Plant(num=[unit], den=[unit, 3 * unit, 2 * unit, 0])))
    ((w, factor),) = found.phase_crossings
    assert (w, factor) == (pytest.approx(sqrt(2), rel=1e-12), pytest.approx(6.0, rel=1e-12))


@pytest.mark.parametrize("near", [1e-9, 7e-10, 3e-10, 1e-10])
def test_a_loop_that_all_but_runs_through_minus_one(near):
    """k/(s (s + 1) (s + 2)), k = 6 (1 - near): |1 + L| has few digits in floats, all in whole."""
    k = 6 * (1 - near)
    with mp.workdps(50):

        def square(w):
            s = mp.mpc(0, w)
            return abs(1 + mpf(k) / (s * (s + 1) * (s + 2))) ** 2

        wanted = mp.sqrt(square(mp.findroot(lambda w: mp.diff(square, w), mp.sqrt(2))))
    found = measure_loop(Loop.of(Plant(num=[k], den=[1, 3, 2, 0])))
    assert found.modulus_margin == pytest.approx(float(wanted), rel=1e-9)
    assert found.certificate.modulus_margin.holds


@pytest.mark.parametrize(("top", "bears"), [(1.0, False), (0.5, False), (0.25, True), (0.0, True)])
def test_a_loop_as_loud_as_one_at_infinity_bears_no_delay(top, bears):
    assert (measure_loop(Loop.of(Plant(num=[top, 3], den=[0.5, 1]))).delay_margin > 0) is bears


def test_the_margins_of_a_table_are_those_of_tables():
    w = [0.25, 0.5, 1.0, 2.0, 4.0]
    table = FrequencyResponse(w=w, magnitude=[1 / x for x in w], phase_deg=[-90.0] * 5)
    assert margins(table) == table_margins(table)
    assert margins(table).crossover == pytest.approx(1.0, rel=1e-12)


def test_beside_a_mode_without_damping_a_margin_has_its_digits():
    """g/((s^2 + 1) (s + 2)) behind its hold of 1/2 s, beside j: floats in w turn L by 1e-8 deg."""
    gain, dt = 1e-7, 0.5
    plant = Plant.zpk(zeros=[], poles=[1j, -1j, -2.0], gain=gain)
    found = measure_loop(Loop.of(sample(plant, dt)))
    assert len(found.gain_crossings) == 2
    with mp.workdps(50):
        poles = [mpc(0, 1), mpc(0, -1), mpc(-2)]
        parts = [
            (mpf(gain) / (p * mp.fprod(p - q for q in poles if q != p)), mp.exp(p * dt))
            for p in poles
        ]

        def held_at(w):
            back = mp.expj(-w * dt)
            return mpf(gain) / 2 + sum(r * (1 - back) / (1 - e * back) for r, e in parts)

        for w, pm in found.gain_crossings:
            away = mpf(w) - 1
            true = 1 + mp.findroot(
                lambda x: mp.log(abs(held_at(1 + x))), (away * 0.999, away * 1.001),
                solver="anderson", tol=1e-60,
            )  # fmt: skip
            assert w == pytest.approx(float(true), rel=1e-12)
            assert pm == pytest.approx(float(mp.degrees(mp.arg(-held_at(true)))), abs=1e-9)


@pytest.mark.parametrize("m", [3, 5, 20])
def test_where_the_gain_is_one_everywhere_the_nearest_crossing_is_where_it_is_minus_one(m):
    """z^-m is -1 at w = pi/m first."""
    late = Loop.of(Sampled(num=[1], den=[1, *[0] * m], dt=1.0))
    assert nearest_crossing(late) == (pytest.approx(pi / m, rel=1e-14), 0.0)


def test_so_it_is_beside_a_mode_that_turns_it():
    """z^-3 (w^2 - a w + 1)/(w^2 + a w + 1): -1 where 3 W and twice the mode's angle are pi."""
    a = 1e-6
    passing = Sampled.from_w(num_w=(1, -a, 1), den_w=(1, a, 1), dt=1.0, delay=3)
    with mp.workdps(40):

        def left(w):
            v = 2 * mp.tan(w / 2)
            return 3 * w + 2 * mp.atan2(a * v, 1 - v * v) - mp.pi

        wanted = float(mp.findroot(left, (mpf("0.9272"), mpf("0.9273")), solver="anderson"))
    assert nearest_crossing(Loop.of(passing)) == (pytest.approx(wanted, rel=1e-12), 0.0)


@pytest.mark.parametrize("m", [3, 12])
def test_the_nearest_crossing_beside_a_mode_has_its_digits(m):
    """2 a/(w^2 + a w + 1), m samples late: |L| = 1 where (1 - q)^2 = a^2 (4 - q)."""
    a = 1e-9
    loop = Loop.of(Sampled.from_w(num_w=(2 * a,), den_w=(1, a, 1), dt=1.0, delay=m))
    with mp.workdps(50):
        linear = 2 - mpf(a) ** 2
        root = mp.sqrt(linear * linear / 4 - 1 + 4 * mpf(a) ** 2)
        crossings = []
        for q in (linear / 2 - root, linear / 2 + root):
            v = mp.sqrt(q)
            w = 2 * mp.atan(v / 2)
            pm = mp.degrees(mp.arg(-2 * a / mpc(1 - q, a * v) * mp.expj(-m * w)))
            crossings.append((float(w), float(pm)))
    w, pm = min(crossings, key=lambda c: abs(c[1]))
    assert nearest_crossing(loop) == (pytest.approx(w, rel=1e-14), pytest.approx(pm, abs=1e-9))


def test_what_rounding_in_w_may_have_moved_is_said_with_the_margins():
    """2 a/(w^2 + a w + 1): |L| = 1 where 1 - q is a sqrt(3), and den has 9 digits there."""
    loop = Loop.of(Sampled.from_w(num_w=[2e-9], den_w=[1, 1e-9, 1], dt=0.5))
    (said,) = measure_loop(loop).warnings
    assert "next to the axis" in said


@pytest.mark.parametrize("m", [3, 7])
def test_what_is_shared_on_the_circle_is_seen_past_some_samples_late(m):
    """(z^2 - z/2 + 1) shared, by z^-m/2 over z - 1/2."""
    late = [0] * m
    shared = Sampled(num=[0.5, -0.25, 0.5], den=[1, -1, 1.25, -0.5, *late], dt=1)
    seen = measure_loop(Loop.of(shared))
    plain = measure_loop(Loop.of(Sampled(num=[0.5], den=[1, -0.5, *late], dt=1)))
    assert (seen.stable, plain.stable) == (False, True)
    assert seen.certificate.holds
    for name in ("gain_margin", "modulus_margin", "mt", "disk_margin"):
        assert getattr(seen, name) == pytest.approx(getattr(plain, name), rel=1e-9)
    for one, other in zip(seen.phase_crossings, plain.phase_crossings, strict=True):
        assert one == pytest.approx(other, rel=1e-9)


def test_a_glance_sees_a_needle():
    """A resonance that reaches over 1 by a thousandth on a band a millionth of w wide."""
    zeta, wn, gain = 1e-6, 7.0, 1 + 1e-3
    needle = Loop.of(Plant(num=[2 * zeta * wn * gain, 0.0], den=[1.0, 2 * zeta * wn, wn**2]))
    # x = w - wn^2/w = +- 2 zeta wn sqrt(gain^2 - 1)
    x = 2 * zeta * wn * sqrt(gain**2 - 1)
    wanted = [sign * x / 2 + sqrt(x * x / 4 + wn * wn) for sign in (-1, 1)]
    assert [w for w, _ in glance(needle).gain_crossings] == pytest.approx(wanted, rel=1e-12)


def test_whatever_is_not_proved_is_listed():
    loop = Loop.of(Sampled.from_w(num_w=(2e-9,), den_w=(1, 1e-9, 1), dt=1.0, delay=30))
    found = measure_loop(loop)
    left = found.certificate.open()
    assert len(left) > 1
    assert found.warnings[0].split(": ")[1].split(", ") == left


def test_a_peak_that_is_approached_for_ever_is_at_infinity():
    """|1 + L|^2 = (q + (1 + K)^2)/(q + 1) of K/(s + 1) falls to 1, however small K is."""
    for k in (1e-14, 1e-3, 10.0):
        found = measure_loop(Loop.of(Plant(num=[k], den=[1, 1])))
        assert (found.modulus_margin, found.ms_frequency) == (1.0, inf)


def test_a_loop_that_runs_through_minus_one_has_no_distance_to_it():
    """6/(s (s + 1) (s + 2)) at sqrt(2)."""
    found = measure_loop(Loop.of(Plant(num=[6], den=[1, 3, 2, 0])))
    assert (found.modulus_margin, found.disk_margin, found.mt) == (0.0, 0.0, inf)
    assert found.ms_frequency == pytest.approx(sqrt(2), rel=1e-12)


def test_beside_a_needle_it_has_no_distance_either():
    """The same times N/D, D = (s^2 + 2^-20 s + 49) (s + 1), N = D - 2^-10 s (s^2 + 2): 1 there."""
    under = np.polymul([1.0, 2.0**-20, 49.0], [1.0, 1.0])
    over = under - 2.0**-10 * np.array([1.0, 0.0, 2.0, 0.0])
    loop = Plant(num=6 * over, den=np.polymul([1.0, 3.0, 2.0, 0.0], under))
    found = measure_loop(Loop.of(loop))
    assert (found.modulus_margin, found.disk_margin, found.mt) == (0.0, 0.0, inf)
    assert found.ms_frequency == pytest.approx(sqrt(2), rel=1e-12)


def test_a_zero_with_next_to_no_damping_turns_the_loop_through_minus_one():
    """-(s^2 + e s + 1)/(s + 1)^3 at 1 + e/2: (-2 x + j e)/(2 - 2j) is -e/2 where x is e/2."""
    for e in (1e-20, 1e-31):
        found = measure_loop(Loop.of(Plant(num=[-1, -e, -1], den=[1, 3, 3, 1])))
        # at rest L is -1; at sqrt(3) it is 2/(1 + j sqrt 3)^3, -1/4
        wanted = [(0.0, 1.0), (1.0, 2 / e), (sqrt(3), 4.0)]
        for seen, true in zip(found.phase_crossings, wanted, strict=True):
            # 1e-7: of 128 bits of a root those beyond e are left
            assert seen == (pytest.approx(true[0], rel=1e-14), pytest.approx(true[1], rel=1e-7))


def test_rounding_beside_a_pole_without_damping_is_no_crossing():
    """0.1/((w + 1.5)(w^2 + 1.2)): the float next to 1.5 1.2 turns L below the mode, by 1e-16 of it.

    L turns by 90 deg at most on both sides of the pole, where it is infinite.
    """
    held = Sampled.from_w(num_w=(0.1,), den_w=(1.0, 1.5, 1.2, 1.5 * 1.2), dt=1.0)
    assert measure_loop(Loop.of(held)).phase_crossings == ()
