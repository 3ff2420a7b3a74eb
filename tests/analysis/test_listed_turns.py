"""The turns of a continuous dead time that are listed: all that are promised, by their phase.

The phase of k/(s^p (s + a_1) ... (s + a_n)) exp(-T s) falls all the way, p pi/2 + T w + sum of
arctan(w/a) below 0. So L is negative real once wherever that is an odd multiple of pi, and how
often up to where |L| is 1/1000, the phase there says.
"""

from itertools import pairwise
from math import inf, pi

import pytest
from mpmath import mp

import zoh
from zoh.analysis.close import Close
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.squares import Squares
from zoh.analysis.undamped import without_undamped
from zoh.lti.systems import Plant, Sampled

LISTED = 1000  # the factor up to which a crossing is listed
CLOSE = 1e-12  # relative, of a frequency: a phase of 1e4 rad has lost four of a float's digits

# k, the powers of 1/s, the lags' corners, T
FALLING = [
    (2.0, 0, [1], 10.0), (0.5, 1, [], 1.0), (30.0, 0, [1, 2], 3.0), (0.1, 0, [1], 10.0),
    (40.0, 1, [5], 0.7), (300.0, 0, [1, 1, 1], 2.0), (7.0, 2, [], 1.0),
]  # fmt: skip


def plant(k, powers, corners, dead_time):
    den = [1]
    for a in corners:
        den = [x + a * y for x, y in zip([*den, 0], [0, *den], strict=True)]
    return Plant(num=[k], den=[*den, *[0] * powers], dead_time=dead_time)


def turned(w, powers, corners, dead_time):
    """Return how far behind the phase is, in rad."""
    return powers * mp.pi / 2 + dead_time * w + sum(mp.atan(w / a) for a in corners)


def size(w, k, powers, corners):
    return k / (w**powers * mp.fprod(mp.hypot(w, a) for a in corners))


def solved(f, low, high):
    return mp.findroot(f, (low, high), solver="anderson", tol=1e-30)


@pytest.mark.parametrize(("k", "powers", "corners", "dead_time"), FALLING)
def test_all_turns_with_a_factor_up_to_1000_are_listed(k, powers, corners, dead_time):
    told = zoh.margins(plant(k, powers, corners, dead_time))
    listed = [(w, g) for w, g in told.phase_crossings if g <= LISTED]
    with mp.workdps(30):
        last = solved(lambda w: mp.log(size(w, k, powers, corners) * LISTED), 1e-9, 1e9)
        phase = turned(last, powers, corners, dead_time)
        # at w = 0 behind two powers of s L is negative at once: no crossing, an end
        number = int(mp.floor((phase / mp.pi + 1) / 2)) - (powers == 2)
        assert 0.02 < (phase / mp.pi + 1) / 2 % 1 < 0.98  # the count hangs on no rounding
        assert len(listed) == number
        for i, (w, factor) in enumerate(listed, 1 if powers == 2 else 0):
            assert abs(turned(w, powers, corners, dead_time) / ((2 * i + 1) * mp.pi) - 1) < CLOSE
            # 1e-9: the size falls by 6 times what the frequency is off by, at most
            assert factor == pytest.approx(float(1 / size(mp.mpf(w), k, powers, corners)), rel=1e-9)


@pytest.mark.parametrize(("k", "powers", "corners", "dead_time"), FALLING)
def test_the_certificate_counts_every_half_turn(k, powers, corners, dead_time):
    loop = Loop.of(plant(k, powers, corners, dead_time))
    reach = Close.of(loop, Squares.of(loop)).reach
    half_turns = turned(mp.mpf(reach), powers, corners, dead_time) / mp.pi
    assert 0.001 < half_turns % 1 < 0.999
    # where the phase begins at a multiple of pi it is there at w = 0, not beyond
    number = int(mp.floor(half_turns)) - (powers == 2)
    told = zoh.margins(plant(k, powers, corners, dead_time)).certificate.phase_crossings
    assert told.holds
    assert told.detail == (
        f"{number} sign changes on the axis up to {reach:.6g} rad/s, {number} found,"
        " no gain nearer to 1 beyond"
    )


def test_a_loop_weaker_than_1_is_followed_to_a_thousandth_of_its_largest_value():
    # 0.1/(s + 1): a thousandth of 0.1 at sqrt(1e6 - 1), a factor of 1e4
    told = zoh.margins(plant(0.1, 0, [1], 10.0))
    number = int(mp.floor((turned(mp.sqrt(10**6 - 1), 0, [1], 10.0) / mp.pi + 1) / 2))
    assert len([g for _, g in told.phase_crossings if g <= 1e4]) == number


def test_where_the_loop_ends_above_a_thousandth_all_are_listed_up_to_near_its_end():
    # (s/10 + 2)/(s + 1): |L| is 0.101 where w^2 (0.101^2 - 0.01) = 4 - 0.101^2
    told = zoh.margins(Plant(num=[0.1, 2], den=[1, 1], dead_time=1.5))
    last = mp.sqrt((4 - mp.mpf("0.101") ** 2) / (mp.mpf("0.101") ** 2 - mp.mpf("0.01")))
    behind = 1.5 * last + mp.atan(last) - mp.atan(last / 20)
    number = int(mp.floor((behind / mp.pi + 1) / 2))
    assert len([w for w, _ in told.phase_crossings if w <= last]) == number


# num, den, T, and the places where the phase jumps; above one with den = 0 it is pi further behind,
# above one with num = 0 too, as 1 - w^2 is then negative.
UNDAMPED = [
    ([0.1], [1, 0, 1], 4.0, [1.0]),
    ([0.1, 0.1], [1, 0, 1], 4.0, [1.0]),
    ([0.1, 0.1], [1, 0, 1], 1.3, [1.0]),
    ([0.1], [1, 0, 2], 4.0, [2**0.5]),
    ([0.1], [1, 0, 2, 0], 4.0, [2**0.5]),
    ([0.1], [1, 0, 0.7], 4.0, [0.7**0.5]),
    ([1, 0, 25], [1, 6, 11, 6], 0.5, [5.0]),
    ([0.5, 0, 12.5], [1, 10, 25], 0.3, [5.0]),
    ([0.1, 0, 0.1], [1, 0, 4, 0], 4.0, [1.0, 2.0]),
    ([0.1], [1, 0, 5, 0, 4], 3.0, [1.0, 2.0]),
    ([0.1], [1, 0, 2, 0, 1], 4.0, []),  # twice: no jump
    ([1, 0, 2, 0, 1], [1, 6, 15, 20, 15], 0.5, []),
    ([0.1], [1, 0, 0, 0, -1], 2.0, [1.0]),  # (s^2 + 1)(s^2 - 1)
    ([0.126], [1, 3.65, 10, 36.5], 0.78, [10**0.5]),  # damped by the rounding of 3.65 alone
    ([0.358], [1, 1.34, 13, 17.42], 1.38, [13**0.5]),
]


def exact(num, den, dead_time, w):
    s = mp.mpc(0, w)
    top, bottom = (mp.polyval(a[::-1], s, asc=True) for a in (num, den))
    return top / bottom * mp.exp(-dead_time * s)


@pytest.mark.parametrize(("num", "den", "dead_time", "jumps"), UNDAMPED)
def test_turns_beside_undamped_poles_and_zeros_are_proved(num, den, dead_time, jumps):
    told = zoh.margins(Plant(num=num, den=den, dead_time=dead_time))
    assert told.certificate.phase_crossings.holds
    assert told.warnings == ()
    found = [c for c in told.phase_crossings if 0 < c[0] < inf]  # the ends are none
    last = found[-1][0] + 0.1 / dead_time
    with mp.workdps(30):
        # 400 points a turn, cut at the jumps: a sign change in a piece is a crossing
        cuts, truth = [1e-6, *jumps, last], []
        for low, high in pairwise(cuts):
            low, high = low * (1 + 1e-9), high * (1 - 1e-9)
            n = int(400 * (high - low) * dead_time / (2 * pi)) + 100
            grid = [low + (high - low) * mp.mpf(i) / n for i in range(n + 1)]
            seen = [(w, exact(num, den, dead_time, w)) for w in grid]
            for (a, x), (b, y) in pairwise(seen):
                if x.imag * y.imag < 0 and x.real < 0:
                    w = solved(lambda w: exact(num, den, dead_time, w).imag, a, b)
                    truth.append((w, -1 / exact(num, den, dead_time, w).real))
        assert [w for w, _ in found] == pytest.approx([float(w) for w, _ in truth], rel=1e-12)
        assert [g for _, g in found] == pytest.approx([float(g) for _, g in truth], rel=1e-9)


def test_an_undamped_pole_by_hand():
    """0.1/(s^2 + 1) exp(-4 s): negative real where 4 w = pi, below 1, and w = n pi/2 above."""
    told = zoh.margins(Plant(num=[0.1], den=[1, 0, 1], dead_time=4.0))
    w = [pi / 4, *(n * pi / 2 for n in range(1, 9))]
    assert [x for x, _ in told.phase_crossings] == pytest.approx(w, rel=1e-12)
    factors = [abs(1 - x * x) / 0.1 for x in w]
    assert [g for _, g in told.phase_crossings] == pytest.approx(factors, rel=1e-9)
    # 16 half turns up to 13.2 rad/s, the end of 0.2 rad steps: sin(4 w) = 0 at k pi/4, k = 1 ... 16
    assert told.certificate.phase_crossings.detail == (
        "16 sign changes on the axis up to 13.2 rad/s, 16 found, no gain nearer to 1 beyond"
    )


def test_a_loop_that_is_real_where_its_pole_is_stays_unproved():
    # exp(-pi s) is -1 at the pole, but for the rounding of pi: is it before, or behind?
    told = measure_loop(Loop.of(Plant(num=[0.1], den=[1, 0, 1], dead_time=pi)))
    assert not told.certificate.phase_crossings.holds
    assert told.warnings == ("not proved to be complete: phase_crossings",)


def test_what_is_left_out_and_where_it_jumps():
    # (s^2 - 4)(s^2 + 9) s/((s + 1)^2 (s^2 + 1)^2): real poles of both signs turn L by nothing
    loop = Loop.of(
        Plant(num=[1, 0, 5, 0, -36, 0], den=[1, 2, 3, 4, 3, 2, 1]),
    )
    left, jumps = without_undamped(loop)
    assert jumps == (3.0,)  # an even number of poles jumps by a full turn
    assert left.exact == ([0, 1, 0], [1, 2, 1])
    assert (left.num, left.den) == ((0.0, 1.0, 0.0), (0.5, 1.0, 0.5))
    plain = Loop.of(Plant(num=[3], den=[1, 2, 1], dead_time=1.0))
    assert without_undamped(plain) == (plain, ())
    nothing = Loop.of(Sampled(num=[0.0, 1.0], den=[1.0, 0.5], dt=1.0))
    assert without_undamped(nothing) == (nothing, ())
    assert without_undamped(plain)[0].dead_time == 1.0
