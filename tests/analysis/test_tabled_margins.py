"""Margins of tables against loops whose margins are known by hand or in fifty digits.

Tolerances are the error of the curve between the points. Over x = ln w, with points h apart,
ln|L| and arg L of loops with real corners have third derivatives of at most about 0.5 for each,
and the curve is off by e <= 0.0963 h^3 f'''/6 + h^4 f''''(1/48 + 1/384) (test_frequency_response).
"""

from math import degrees, inf, log, log10, pi, sqrt

import mpmath as mp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import zoh
from zoh import FrequencyResponse
from zoh.analysis.tabled.path import boundary_poles
from zoh.errors import SpecError


def between(h, corners):
    """Return the bound e for a loop of so many corners."""
    return corners * (0.0963 * h**3 * 0.5 / 6 + h**4 * (1 / 48 + 1 / 384))


def table(gain, low, high, count, **more):
    w = np.geomspace(low, high, count)
    return FrequencyResponse.from_complex(w=w, gain=[complex(gain(x)) for x in w], **more)


def third_order(w):
    """2/(s (s + 1)(s + 2)): phase crossover sqrt(2), gain margin 1*2*(1 + 2)/2 = 3, by hand."""
    s = 1j * w
    return 2 / (s * (s + 1) * (s + 2))


def least(f, a, b):
    """Return the least value of f, which has one valley in [a, b], to some forty digits."""
    a, b = mp.mpf(a), mp.mpf(b)
    for _ in range(120):  # thirds: the place to 1e-21, the value to 1e-42
        c, d = a + (b - a) / 3, b - (b - a) / 3
        a, b = (a, d) if f(c) < f(d) else (c, b)
    return f(a)


def third_order_truth():
    """Return (wc, pm in deg, Ms, Mt, disk margin) with fifty digits."""
    with mp.workdps(50):

        def loop(w):
            return 2 / (1j * w * (1j * w + 1) * (1j * w + 2))

        wc = mp.findroot(lambda w: w**2 * (w**2 + 1) * (w**2 + 4) - 4, mp.mpf("0.75"))
        pm = 90 - mp.degrees(mp.atan(wc)) - mp.degrees(mp.atan(wc / 2))
        ms = 1 / least(lambda w: abs(1 + loop(w)), "0.5", "2")
        mt = 1 / least(lambda w: abs(1 + 1 / loop(w)), "0.3", "1.5")
        disk = 2 * least(lambda w: abs(1 + loop(w)) / abs(1 - loop(w)), "0.4", "2")
        return tuple(float(x) for x in (wc, pm, ms, mt, disk))


@pytest.mark.parametrize("per_decade", [10, 30, 100])
def test_a_third_order_loop_by_hand(per_decade):
    m = zoh.margins(table(third_order, 0.02, 50, round(per_decade * log10(2500)) + 1))
    wc, pm, ms, mt, disk = third_order_truth()
    e = between(log(10) / per_decade, corners=2)
    assert m.stable is True
    assert m.crossover == pytest.approx(wc, rel=e)  # its slope there is beyond -1: shift below e
    assert m.phase_margin_deg == pytest.approx(pm, abs=degrees(2 * e))  # phi'/u' below 1
    # at the phase crossover u' = -2 and phi' = -0.94: ln GM is off by e (1 + 2/0.94)
    assert log(m.gain_margin) == pytest.approx(log(3.0), abs=3.2 * e)
    assert m.phase_crossover == pytest.approx(sqrt(2), rel=1.1 * e)
    assert m.ms == pytest.approx(ms, abs=ms**2 * 2 * e)  # |L| below 1 there, e in each part
    assert m.mt == pytest.approx(mt, abs=ms * mt * 2 * e)  # dT/T = S dL/L
    assert m.disk_margin == pytest.approx(disk, abs=4 * e)  # d = 2|1 + L|/|1 - L|, |1 - L| > 1
    assert m.delay_margin == pytest.approx(np.radians(pm) / wc, abs=3 * e / wc)
    assert abs(m.phase_margin_deg - pm) <= m.interpolation.phase_margin_deg
    assert abs(m.gain_margin_db - 20 * log10(3)) <= m.interpolation.gain_margin_db
    assert abs(m.ms - ms) <= m.interpolation.ms


def test_an_integrator_with_dead_time():
    # K exp(-s)/s: wc = K, PM = 90 deg - K, GM = pi/(2 K) at pi/2, delay margin PM/K; over ln w the
    # gain is a line, met exactly, and the phase -w has third derivative w: e of f''' = f'''' = w
    k = 0.5
    m = zoh.margins(table(lambda w: k * np.exp(-1j * w) / (1j * w), 0.01, 20, 400))
    e = 2 * pi * between(log(2000) / 399, corners=1)
    assert m.stable is True
    assert m.crossover == pytest.approx(k, rel=1e-12)
    assert m.phase_margin_deg == pytest.approx(90 - degrees(k), abs=degrees(e))
    assert m.delay_margin == pytest.approx((pi / 2 - k) / k, abs=e / k)
    assert m.gain_margin == pytest.approx(pi / (2 * k), rel=e)
    # crossings at pi/2 + 2 pi n, n = 0, 1, 2 up to 20 rad/s; the factors are w/k
    assert [w for w, _ in m.phase_crossings] == pytest.approx(
        [pi / 2, 5 * pi / 2, 9 * pi / 2], rel=e
    )
    assert [f for _, f in m.phase_crossings] == pytest.approx([pi, 5 * pi, 9 * pi], rel=e)


def test_a_point_of_the_table_is_met_exactly():
    loop = FrequencyResponse(w=[0.5, 1, 2], magnitude=[4, 1, 0.25], phase_deg=[-120, -135, -150])
    m = zoh.margins(loop)
    assert (m.crossover, m.phase_margin_deg) == (1.0, pytest.approx(45.0, abs=1e-12))


def test_a_crossing_is_neither_invented_nor_lost():
    # |L| dips to 1.01 between larger points and rises again: a curve that overshoots would cross
    size = [3.0, 1.01, 1.01, 3.0, 0.5]
    loop = FrequencyResponse(w=[1, 2, 3, 4, 8], magnitude=size, phase_deg=[-90] * 5)
    assert len(zoh.margins(loop).gain_crossings) == 1
    # the phase passes -180 deg and comes back within the table: two crossings, no third
    turned = FrequencyResponse(
        w=[1, 2, 3, 4, 5], magnitude=[3, 2, 0.4, 0.3, 0.2], phase_deg=[-100, -170, -190, -170, -175]
    )
    assert len(zoh.margins(turned).phase_crossings) == 2


def test_no_crossing_comes_from_the_wrapping_of_the_phase():
    # a positive real part whose phase jumps from -359 to -1 deg as analysers print it
    loop = FrequencyResponse(
        w=[1, 2, 3, 4], magnitude=[2, 1.5, 0.7, 0.3], phase_deg=[-10, -359, -2, -358]
    )
    m = zoh.margins(loop)
    assert m.phase_crossings == ()
    assert len(m.gain_crossings) == 1


def test_what_ends_the_table_bounds_the_gain_margin():
    m = zoh.margins(table(lambda w: 1 / (1j * w), 0.1, 8, 50))
    assert m.stable is True
    assert m.phase_crossings == ()
    assert m.phase_crossover is None
    assert m.gain_margin == pytest.approx(8.0, rel=1e-12)  # 1/|L| at the end, not infinity
    assert m.beyond.ms == pytest.approx(1 / (1 - 1 / 8), rel=1e-12)
    assert m.beyond.mt == pytest.approx(1.0, rel=1e-9)  # T = 1/(1 + jw), from 1e-5 rad/s on
    assert any("the gain margin given, 18.06 dB, is a bound" in w for w in m.warnings)
    assert any("crossings below 0.1 and above 8 rad/s are not seen" in w for w in m.warnings)


def test_a_sampled_table_up_to_nyquist_has_its_crossing_there():
    # 0.1/(z - 0.9): leaves at z = -1 with gain margin 19, by hand
    loop = zoh.Sampled(num=[0.1], den=[1, -0.9], dt=1.0)
    w = np.append(np.geomspace(0.01, 3, 100), pi)
    m = zoh.margins(FrequencyResponse.from_complex(w=w, gain=loop.at(w), dt=1.0))
    assert m.stable is True
    assert m.gain_margin == pytest.approx(19.0, rel=1e-12)
    assert m.phase_crossover == pi
    assert "above" not in m.warnings[1]


def test_a_controller_is_known_between_the_points():
    # a notch at 0.9 rad/s, far narrower than the spacing and on no even step of it: there the
    # loop is 0.5 * 0.9e-3/0.9, by hand, and |1 + L| is least
    flat = FrequencyResponse(w=[0.5, 2.0], magnitude=[0.5, 0.5], phase_deg=[0, 0])
    notch = zoh.Plant(num=[1, 0.9e-3, 0.81], den=[1, 0.9, 0.81])
    m = zoh.margins(notch * flat)
    assert m.ms == pytest.approx(1 / (1 + 0.5e-3), rel=1e-6)  # L is not real all around: 1e-7
    assert m.ms_frequency == pytest.approx(0.9, rel=1e-3)  # it is flat there


def test_the_delay_of_a_controller_turns_between_the_points():
    # 0.5/(jw) known at 0.1, 1, 3 rad/s alone, behind 20 samples of 0.5 s: the phase crossings are
    # where 10 w = pi/2 + 2 pi n, by hand, five of them below 3 rad/s, with factors 2 w
    plant = FrequencyResponse(
        w=[0.1, 1, 3], magnitude=[5, 0.5, 0.5 / 3], phase_deg=[-90] * 3, dt=0.5
    )
    late = zoh.Sampled.from_w(num_w=[1.0], den_w=[1.0], dt=0.5, delay=20)
    places = [(pi / 2 + 2 * pi * n) / 10 for n in range(5)]
    found = zoh.margins(late * plant).phase_crossings
    assert [w for w, _ in found] == pytest.approx(places, rel=1e-12)
    assert [f for _, f in found] == pytest.approx([2 * w for w in places], rel=1e-12)


def test_a_controller_that_rises_beyond_the_table_is_not_lost():
    # |P| is 0.5 where the table ends. A lead that rises to 0.05/0.1 leaves |L| <= 0.25 beyond; one
    # that rises to 0.3/0.1 may make it 1.5
    plant = FrequencyResponse(w=[0.5, 1, 2], magnitude=[2, 1, 0.5], phase_deg=[-90] * 3)
    m = zoh.margins(zoh.Plant(num=[0.05, 0.1], den=[0.1, 1.0]) * plant)
    assert m.beyond.ms == pytest.approx(1 / (1 - 0.25), rel=1e-6)  # to 0.5 * 0.5 at infinity
    m = zoh.margins(zoh.Plant(num=[0.3, 0.1], den=[0.1, 1.0]) * plant)
    assert m.stable is None
    assert "|L| may be as large as 1.5 beyond 2 rad/s" in m.warnings[0]


def test_slope_and_phase_must_agree_on_what_lies_below():
    # |P| falls as an integrator does, with 60 deg more lag than one has
    m = zoh.margins(FrequencyResponse(w=[1, 2, 4], magnitude=[4, 2, 0.4], phase_deg=[-150] * 3))
    assert m.stable is None
    assert "neither slope nor phase show" in m.warnings[0]


def test_integrators_and_zeros_at_the_origin_are_told_apart():
    twice = zoh.Sampled.from_w(num_w=[1.0, 2.0], den_w=[1.0, 0.0, 0.0], dt=0.1)
    washout = zoh.Sampled(num=[1, -1], den=[1, -0.5], dt=0.1)
    unstable = zoh.Sampled(num=[1], den=[1, -1.5], dt=0.1)
    assert boundary_poles(twice) == (2, 0)
    assert boundary_poles(washout) == (-1, 0)
    assert boundary_poles(unstable) == (0, 1)
    assert boundary_poles(None) == (0, 0)


def test_a_negative_margin_bears_a_delay_of_nearly_a_turn():
    # at w = 1 the phase is -210 deg, a margin of -30 deg: another 330 deg bring it back to -1
    late = FrequencyResponse(w=[0.5, 1, 2], magnitude=[2, 1, 0.5], phase_deg=[-190, -210, -230])
    m = zoh.margins(late)
    assert m.phase_margin_deg == pytest.approx(-30, abs=1e-12)
    assert m.delay_margin == pytest.approx(np.radians(330), rel=1e-12)


def test_a_resonance_as_wide_as_the_spacing_shows_in_the_error_estimate():
    # 0.2/s with a resonance at 10 rad/s of damping 0.05 seen by points 5 % apart
    def gain(w):
        s = 1j * w
        return 0.2 / s * 100 / (s * s + 1.0 * s + 100)

    exact = 1 / np.abs(1 + gain(np.linspace(9, 11, 200_001))).min()
    m = zoh.margins(table(gain, 0.01, 100, 190))
    assert m.interpolation.ms > 0.01
    assert abs(m.ms - exact) <= m.interpolation.ms


def test_a_resonance_between_the_points_is_not_seen():
    """What a table cannot show, it cannot: the warning says so, and a denser table sees it."""

    def gain(w):
        s = 1j * w
        return 0.2 / s * (1 + 0.02 * 10 * s / (s * s + 0.002 * s + 103))

    sparse, dense = table(gain, 0.1, 1000, 41), table(gain, 0.1, 1000, 400_001)
    assert zoh.margins(sparse).ms < 1.1
    assert zoh.margins(dense).ms > 2
    assert any("narrower than the spacing is not seen" in w for w in zoh.margins(sparse).warnings)


def test_noise_goes_through_to_the_margins_as_drawing_it_does():
    w = np.geomspace(0.05, 20, 60)
    exact, sigma = third_order(w), 0.01
    rng = np.random.default_rng(7)
    said = zoh.margins(FrequencyResponse.from_complex(w=w, gain=exact, uncertainty=sigma))
    found = []
    for _ in range(300):
        e = rng.normal(size=(2, len(w))) * sigma
        m = zoh.margins(FrequencyResponse.from_complex(w=w, gain=exact * np.exp(e[0] + 1j * e[1])))
        found.append((m.phase_margin_deg, m.gain_margin_db))
    # the standard deviation of 300 draws is within 4/sqrt(600) = 16 % of the true one
    pm, gm = np.std(found, axis=0)
    assert pm == pytest.approx(said.noise.phase_margin_deg, rel=0.16)
    assert gm == pytest.approx(said.noise.gain_margin_db, rel=0.16)


def test_noise_of_ms_is_that_of_the_point_where_it_is():
    # L = -0.5 everywhere: |1 + L| = 0.5, Ms = 2, and an error e of L moves Ms by 4 * 0.5 e
    flat = FrequencyResponse(
        w=[1, 2, 3, 4, 5], magnitude=[0.5] * 5, phase_deg=[-180] * 5, uncertainty=0.01
    )
    m = zoh.margins(flat)
    assert m.ms == pytest.approx(2.0)
    # at a point the weight is 1, between points 0.65 to 1: the least may lie anywhere
    assert 0.6 * 0.02 <= m.noise.ms <= 0.02 * 1.001


# Verdicts ------------------------------------------------------------------------------------


corner = st.floats(0.05, 20)
side = st.sampled_from([-1, -1, -1, 1])  # one pole in four is unstable


@settings(max_examples=150)
@given(
    st.lists(st.tuples(corner, side), min_size=1, max_size=3),
    st.integers(0, 2),
    st.lists(corner, max_size=1),
    st.floats(0.01, 100),
    st.sampled_from([1, -1]),
)
def test_a_verdict_is_never_wrong(poles, integrators, zeros, size, sign):
    roots = [s * p for p, s in poles] + [0.0] * integrators
    den = np.poly(roots)
    num = sign * size * np.atleast_1d(np.poly([-z for z in zeros]))
    assume(len(num) < len(den))
    closed = np.roots(np.polyadd(den, num))
    scale = np.abs(closed)
    assume((np.abs(closed.real) > 0.01 * scale).all())  # not on the edge of stability
    unstable = sum(r > 0 for r in roots)
    w = np.geomspace(1e-4, 1e5, 1000)
    loop = FrequencyResponse.from_complex(
        w=w, gain=np.polyval(num, 1j * w) / np.polyval(den, 1j * w), unstable_poles=unstable
    )
    m = zoh.margins(loop)
    assert m.stable in (None, bool((closed.real < 0).all()))
    # undecided only where the loop begins on the negative real axis above 1, or ends above 1
    if m.stable is None:
        starts_at_minus_180 = abs(abs(np.angle(loop.at(1e-4))) - pi) < np.radians(0.5)
        assert starts_at_minus_180 or abs(loop.at(1e5)) >= 1


def test_most_verdicts_are_given():
    decided = 0
    rng = np.random.default_rng(3)
    for _ in range(60):
        roots = -np.exp(rng.uniform(-2, 2, 3))
        w = np.geomspace(1e-3, 1e4, 300)
        k = np.exp(rng.uniform(-1, 4)) * np.abs(np.prod(roots))
        gain = k / np.polyval(np.poly(roots), 1j * w)
        m = zoh.margins(FrequencyResponse.from_complex(w=w, gain=gain))
        truth = bool((np.roots(np.polyadd(np.poly(roots), [k])).real < 0).all())
        assert m.stable == truth
        decided += 1
    assert decided == 60


def sampled_loops(count):
    """Yield (controller, num, den of the plant in z, closed-loop poles) away from the circle."""
    rng = np.random.default_rng(11)
    while count:
        kind = rng.integers(0, 4)
        r, angle = rng.uniform(0.5, 0.98), rng.uniform(0.05, 2.8)
        poles = [
            [1.0, rng.uniform(-0.5, 0.9)],
            [r * np.exp(1j * angle), r * np.exp(-1j * angle)],
            [rng.uniform(1.02, 1.4), rng.uniform(-0.5, 0.9)],
            [rng.uniform(-0.5, 0.9), rng.uniform(0.5, 0.99)],
        ][kind]
        num = (
            np.array([1.0, rng.uniform(-1.5, 1.5)]) * rng.choice([-1, 1, 1]) * np.exp(rng.normal())
        )
        den = np.poly(poles).real
        law = zoh.Sampled(
            num=[1.0, -rng.uniform(0.5, 0.99)], den=[1.0, -rng.choice([0.3, 1.0, 1.2])], dt=1.0
        )
        closed = np.roots(np.polyadd(np.polymul(den, law.den), np.polymul(num, law.num)))
        if np.abs(np.abs(closed) - 1).min() > 0.01:
            count -= 1
            yield law, num, den, closed


def test_verdicts_of_sampled_loops_with_their_controllers_are_right():
    decided = 0
    w = np.append(np.geomspace(1e-3, 3.1, 300), pi)
    z = np.exp(1j * w)
    for law, num, den, closed in sampled_loops(150):
        unstable = int((np.abs(np.roots(den)) > 1 + 1e-9).sum())
        gain = np.polyval(num, z) / np.polyval(den, z)
        plant = FrequencyResponse.from_complex(w=w, gain=gain, dt=1.0, unstable_poles=unstable)
        m = zoh.margins(law * plant)
        assert m.stable in (None, bool((np.abs(closed) < 1).all()))
        decided += m.stable is not None
    assert decided > 120  # the others start at -180 deg, two integrators or one and a sign


def test_the_count_takes_the_unstable_poles_that_it_is_told():
    # 2/(s - 1) closes at s = -1: stable, with one unstable open-loop pole, and not with none
    def gain(w):
        return 2 / (1j * w - 1)

    assert zoh.margins(table(gain, 0.01, 100, 100, unstable_poles=1)).stable is True
    m = zoh.margins(table(gain, 0.01, 100, 100))
    assert m.stable is None
    assert "as only a loop with 1 more unstable poles does" in m.warnings[0]
    # its low gain margin, 1/2 at w = 0, lies outside the table, and the asymptote gives it
    assert m.gain_margin == pytest.approx(0.5, rel=1e-4)  # |L(0.01)| is 2/sqrt(1 + 1e-4)


@pytest.mark.parametrize(
    ("loop", "why"),
    [
        (
            FrequencyResponse(w=[1, 2, 3], magnitude=[8, 4, 2.7], phase_deg=[-90] * 3),
            "|L| may be as large as 2.7 beyond 3 rad/s",
        ),
        (
            FrequencyResponse(w=[1, 2, 3], magnitude=[3, 1, 0.5], phase_deg=[-50, -90, -120]),
            "below 1 rad/s, where the table begins, neither slope nor phase show",
        ),
        (
            FrequencyResponse(w=[1, 2, 4], magnitude=[4, 1, 0.25], phase_deg=[-179.7] * 3),
            "so near to -180 deg with |L| above 1 that the side cannot be told",
        ),
        (
            FrequencyResponse(w=[1, 2, 4], magnitude=[4, 2, 0.4], phase_deg=[-90, -90, -250]),
            "the phase turns by 160 deg, where |L| is above 0.5",
        ),
        (
            FrequencyResponse(
                w=[1, 2, 4], magnitude=[2, 1, 0.5], phase_deg=[-90, -170, -175], uncertainty=0.1
            ),
            "within its uncertainty (3 sigma) the loop may be -1 at",
        ),
        (  # the point at 4 rad/s alone takes the loop around -1
            FrequencyResponse(
                w=[1, 2, 4, 8, 16],
                magnitude=[4, 2, 1.2, 0.5, 0.2],
                phase_deg=[-95, -130, -178, -140, -120],
            ),
            "without every second point it may pass -1 on the other side at",
        ),
    ],
)
def test_undecided_is_said_and_not_guessed(loop, why):
    m = zoh.margins(loop)
    assert m.stable is None
    assert m.warnings[0].startswith("the table does not decide stability: ")
    assert why in m.warnings[0]
    assert m.to_dict()["stable"] is None


def test_a_loop_that_passes_minus_one_closely_is_followed_around_it():
    # from 2 to 4 rad/s |L| is 1.001, the same at both points, and so all the way; the phase passes
    # -180 deg there, so the loop passes -1 on the left, by 0.001: unstable. A chord of 7.5 deg,
    # an eighth of the cell, would pass at 1.001 cos(3.75 deg) = 0.999, on the right
    loop = FrequencyResponse(
        w=[1, 2, 4, 8],
        magnitude=[2.002, 1.001, 1.001, 0.3],
        phase_deg=[-100, -146.25, -206.25, -230],
    )
    m = zoh.margins(loop)
    assert m.stable is False
    assert m.gain_margin == pytest.approx(1 / 1.001, rel=1e-12)


def test_a_double_integrator_is_judged_by_the_side_it_comes_from():
    # (1 + s)/s^2 closes at s^2 + s + 1, (1 - s)/s^2 at s^2 - s + 1
    assert zoh.margins(table(lambda w: (1 + 1j * w) / -(w**2), 0.1, 50, 80)).stable is True
    late = table(lambda w: (1 - 0.5j * w) / -(w**2), 0.1, 50, 80)
    assert zoh.margins(late).stable is False


def test_an_integrator_of_the_controller_is_counted_below_the_table():
    # PI (1 + 0.001/s) with 1/(s + 1)^2: the PI's corner lies far below the table's 0.05 rad/s
    plant = table(lambda w: 3 / (1j * w + 1) ** 2, 0.05, 100, 100)
    loop = zoh.Plant(num=[1, 0.001], den=[1, 0]) * plant
    assert zoh.margins(loop).stable is True  # s (s + 1)^2 + 3 (s + 0.001), Routh: 2 * 4 > 0.003
    unstable = zoh.Plant(num=[1], den=[1, -2]) * plant
    assert zoh.margins(unstable).stable is False  # (s - 2)(s + 1)^2 + 3 has s^2 coefficient 0


def test_a_pole_of_the_controller_on_the_boundary_is_refused():
    plant = table(lambda w: 1 / (1j * w + 1), 0.05, 100, 100)
    with pytest.raises(SpecError, match="controller must have no pole on the stability boundary"):
        zoh.margins(zoh.Plant(num=[1], den=[1, 0, 4]) * plant)


def test_an_ambiguous_turn_where_the_loop_is_quiet_is_a_warning_only():
    loop = FrequencyResponse(
        w=[0.5, 1, 2, 4], magnitude=[2, 1, 0.4, 0.1], phase_deg=[-90, -90, -230, -240]
    )
    m = zoh.margins(loop)
    assert any("may have gone the other" in w for w in m.warnings)


def test_two_points_are_read_and_their_shortness_is_said():
    m = zoh.margins(FrequencyResponse(w=[0.5, 2], magnitude=[2, 0.5], phase_deg=[-90, -90]))
    assert m.crossover == pytest.approx(1.0, rel=1e-15)
    assert m.interpolation is None
    assert any("too short" in w for w in m.warnings)


def test_the_json_form_is_that_of_margins_and_more():
    m = zoh.margins(table(third_order, 0.02, 50, 60, uncertainty=0.01))
    out = m.to_dict()
    model = zoh.margins(zoh.Plant(num=[2], den=[1, 3, 2, 0])).to_dict()
    assert set(model) <= set(out)
    assert out["band"] == [pytest.approx(0.02), pytest.approx(50)]
    assert out["warnings"] == list(m.warnings)
    assert out["noise"]["phase_margin_deg"] == m.noise.phase_margin_deg
    assert out["neglected"] is None
    assert inf not in out.values()


def test_bandwidth_and_the_disk_margins_place_are_the_models():
    plant = zoh.Plant(num=[2.0], den=[0.1, 1.1, 1, 0])
    w = np.geomspace(1e-3, 50, 1200)
    table = zoh.margins(zoh.FrequencyResponse.from_complex(w=w, gain=plant.at(w)))
    model = zoh.margins(plant)
    # 1e-5: cubics over 0.9 % of w; the reference is |T| at w = 1e-3, 1e-6 beside that at 0
    assert table.bandwidth == pytest.approx(model.bandwidth, rel=1e-5)
    assert table.disk_frequency == pytest.approx(model.disk_frequency, rel=1e-3)  # flat there
    assert table.disk_margin == pytest.approx(model.disk_margin, rel=1e-6)
    assert table.certificate is None
    assert table.to_dict()["certificate"] is None


def test_a_bandwidth_below_the_table_is_not_that_of_a_resonance_above_it():
    # 0.2/s beside a resonance at 5 rad/s: |T| falls by 3 dB at 0.2 rad/s, below the table, and
    # rises over that again on its way to the resonance
    w = np.geomspace(0.5, 30, 600)
    s = 1j * w
    h = 0.2 / s * 25 / (s**2 + 0.3 * s + 25)
    assert abs(h[0] / (1 + h[0])) < 0.5 < max(abs(h / (1 + h)))
    late = zoh.margins(FrequencyResponse.from_complex(w=w, gain=h))
    assert late.bandwidth is None
