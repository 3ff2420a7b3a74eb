"""A continuous dead time turns a loop for ever: which turn decides, and that none beyond does."""

from itertools import pairwise
from math import inf, pi, sqrt

import numpy as np
import pytest
from mpmath import mp

import zoh
from zoh.analysis.close import Close
from zoh.analysis.endless import (
    _dip,
    _next_positive,
    _turning_back,
    around_the_fall,
    followed,
    keeps_above,
    none_decides,
)
from zoh.analysis.loop import Loop
from zoh.analysis.squares import DROP, ON_DEN, ON_NUM, ON_OPPOSITE, Squares
from zoh.errors import AccuracyWarning
from zoh.lti.systems import Plant


def late(num, den, dead_time):
    return Loop.of(Plant(num=num, den=den, dead_time=dead_time))


def exact(loop, w):
    """Return L(jw) in 50 digits."""
    s = mp.mpc(0, w)
    num, den = (mp.polyval(a[::-1], s, asc=True) for a in (list(loop.num), list(loop.den)))
    return num / den * mp.exp(-s * loop.dead_time)


def floats(loop, w):
    s = 1j * w
    return np.polyval(loop.num, s) / np.polyval(loop.den, s) * np.exp(-s * loop.dead_time)


def truth(loop, low, high):
    """Return (gain margin, Ms, Mt, disk margin) from what is between two frequencies.

    From 200 points a turn; the crossing nearest to 1 and the 20 deepest valleys, in 50 digits.
    """
    w = np.arange(low, high, 2 * pi / 200 / loop.dead_time)
    gain = floats(loop, w)
    crossed = np.flatnonzero((np.diff(np.sign(gain.imag)) != 0) & (gain.real[1:] < 0))
    with mp.workdps(50):
        turns = [_root(lambda x: exact(loop, x).imag, w[i], w[i + 1]) for i in crossed.tolist()]
        factors = [-1 / exact(loop, x).real for x in turns]
        margin = min(factors, key=lambda f: abs(mp.log(f)))
        measures = (
            lambda g: abs(1 + g), lambda g: abs(1 + 1 / g), lambda g: abs((1 + g) / (1 - g)),
        )  # fmt: skip
        least = [_least(loop, w, gain, f) for f in measures]
        return float(margin), float(1 / least[0]), float(1 / least[1]), float(2 * least[2])


def _root(f, a, b):
    a, b = mp.mpf(a), mp.mpf(b)
    rising = f(b) > 0
    for _ in range(120):
        middle = (a + b) / 2
        a, b = (a, middle) if (f(middle) > 0) == rising else (middle, b)
    return a


def _least(loop, w, gain, f):
    y = f(gain)
    valleys = np.flatnonzero((y[1:-1] <= y[:-2]) & (y[1:-1] <= y[2:])) + 1
    found = []
    for i in valleys[np.argsort(y[valleys])][:20].tolist():
        a, b = mp.mpf(w[i - 1]), mp.mpf(w[i + 1])
        for _ in range(90):  # the third that is higher is left out: 2/3 to the 90th is 1e-16 of it
            c, d = a + (b - a) / 3, b - (b - a) / 3
            a, b = (a, d) if f(exact(loop, c)) < f(exact(loop, d)) else (c, b)
        found.append(f(exact(loop, a)))
    return min(found)


NEUTRAL = {
    "falls through 1 at 38.7": ([0.999, 1.998], [1, 1], 1.0, 0.01, 100.0),
    "falls through 1 at 27.3": ([0.998, 1.996], [1, 1], 1.0, 0.01, 100.0),
    "falls through 1 at 35.3": ([0.9995, 1.49925], [1, 1], 1.0, 0.01, 100.0),
    "negative": ([-0.999, -1.998], [1, 1], 1.0, 0.01, 100.0),
    "rises through 1 at 1.18": ([1.5, 1.5], [1, 2], 10.0, 0.01, 20.0),
    "never 1, its most at 3": ([0.9, 0.27, 8.1], [1, 0.28, 9], 5.0, 0.01, 30.0),
}


@pytest.mark.parametrize("name", NEUTRAL)
def test_the_turns_that_decide_are_found_and_proved(name):
    num, den, dead_time, low, high = NEUTRAL[name]
    loop = late(num, den, dead_time)
    found = zoh.margins(Plant(num=num, den=den, dead_time=dead_time))
    margin, ms, mt, disk = truth(loop, low, high)
    assert found.gain_margin == pytest.approx(margin, rel=1e-12)
    assert (found.ms, found.mt) == pytest.approx((ms, mt), rel=1e-9)
    assert found.disk_margin == pytest.approx(disk, rel=1e-9)
    assert found.certificate.holds
    assert found.certificate.phase_crossings.detail.endswith("found, no gain nearer to 1 beyond")
    assert found.warnings == ()


def test_what_decides_too_far_off_is_found_but_not_proved_and_that_is_said():
    """|L| is 1 at 118 321.6 rad/s, 18 831 turns away."""
    num, den = [1.5, 1.5e5], [1, 2e5]
    with pytest.warns(AccuracyWarning, match="not proved to be complete: phase_crossings"):
        found = zoh.margins(Plant(num=num, den=den, dead_time=1.0))
    margin, ms, mt, disk = truth(late(num, den, 1.0), 118_308.0, 118_335.0)
    assert found.gain_margin == pytest.approx(margin, rel=1e-12)
    # 118 322 rad of phase have a rounding of 1e-11, the distance from -1 is 1.5e-6
    assert (found.ms, found.mt) == pytest.approx((ms, mt), rel=1e-5)
    assert found.disk_margin == pytest.approx(disk, rel=1e-5)
    proof = found.certificate.phase_crossings
    assert not proof.holds
    assert proof.detail.endswith("4 found, beyond that the gain may be nearer to 1")


@pytest.mark.parametrize(("gain", "lag"), [(0.9, 1e-6), (0.5, 1e-6), (0.2, 3e-7), (1.0, 1e-6)])
def test_a_loop_that_is_never_1_needs_no_count_of_its_turns(gain, lag):
    """The first turn decides: w + arctan(lag w) = pi."""
    plant = Plant(num=[gain], den=[lag, 1], dead_time=1.0)
    found = zoh.margins(plant) if gain < 1 else _warned(plant)
    with mp.workdps(50):
        first = mp.findroot(lambda w: w + mp.atan(mp.mpf(lag) * w) - mp.pi, 3.1)
        wanted = mp.sqrt(1 + (mp.mpf(lag) * first) ** 2) / mp.mpf(gain)
    assert found.stable
    assert found.phase_margin_deg == inf
    assert found.gain_margin == pytest.approx(float(wanted), rel=1e-15)
    assert found.phase_crossover == pytest.approx(float(first), rel=1e-14)
    if gain < 1:
        assert found.certificate.holds
        _, ms, mt, disk = truth(late([gain], [lag, 1], 1.0), 0.1, 40.0)
        assert (found.ms, found.mt) == pytest.approx((ms, mt), rel=1e-9)
        assert found.disk_margin == pytest.approx(disk, rel=1e-9)


def _warned(plant):
    """|L| all but touches 1 at w = 0: what Ms is is not proved, and said to be so."""
    with pytest.warns(AccuracyWarning, match="modulus_margin"):
        return zoh.margins(plant)


FALLING = [([0.9], [1e-6, 1], 1.0), ([0.45], [3e-6, 1], 1.0), ([3.0], [1.0, 1.0], 20.0)]


@pytest.mark.parametrize(("num", "den", "dead_time"), FALLING)
def test_t_falls_to_its_level_in_a_dip_narrower_than_the_grid(num, den, dead_time):
    """Up to where |L|/(1 + |L|) is the level |T| is above it; from there on it is searched."""
    loop = late(num, den, dead_time)
    found = zoh.margins(Plant(num=num, den=den, dead_time=dead_time))
    with mp.workdps(50):
        gain, lag = mp.mpf(num[0]), mp.mpf(den[0])
        level = mp.sqrt(mp.mpf(DROP)) * gain / (1 + gain)
        start = mp.sqrt((gain * (1 - level) / level) ** 2 - 1) / lag

        def above(x):
            here = exact(loop, start + x)
            return abs(here / (1 + here)) - level

        step = mp.mpf(2 * pi / dead_time / 20_000)
        first = next(k for k in range(20_001) if above(k * step) < 0)
        wanted = start + _root(above, (first - 1) * step, first * step) if first else start
    assert found.bandwidth == pytest.approx(float(wanted), rel=1e-13)
    assert found.certificate.bandwidth.holds


def test_what_is_refused_says_a_dead_time_that_is_followed():
    loop = late([1.1], [1e-6, 1], 1.0)
    with pytest.raises(zoh.SpecError, match=r"dead_time must be at most 0\.0872 s") as told:
        followed(loop, Squares.of(loop), np.geomspace(1.0, 1e8, 200))
    assert told.value.way_out == "what turns that often is no control loop"
    loop = late([1.1], [1e-6, 1], 0.0872)
    (grid,) = followed(loop, Squares.of(loop), np.geomspace(1.0, 1e8, 200))
    unity = sqrt(1.1**2 - 1) * 1e6
    assert unity + 4 * pi / 0.0872 <= grid[-1] <= unity + 4 * pi / 0.0872 + 0.4 / 0.0872


def test_a_peak_too_far_off_is_looked_at_and_the_turns_up_to_the_last_unity():
    """2/(s + 1) and a mode at 1e5 rad/s, where |L| is about 0.6 again."""
    num, den = np.polyadd([2.0, 6e3, 2e10], [0.6e3, 0.6e3, 0.0]), np.polymul([1, 1], [1, 1e3, 1e10])
    loop = late(num.tolist(), den.tolist(), 1.0)
    grid, around = followed(loop, Squares.of(loop), np.geomspace(0.01, 1e7, 400))
    assert grid[-1] == pytest.approx(sqrt(3) + 4 * pi, abs=0.3)
    w = np.linspace(0.9e5, 1.1e5, 200_001)
    peak = w[np.abs(floats(loop, w)).argmax()]
    assert (around[0], around[-1]) == pytest.approx((peak - 4 * pi, peak + 4 * pi), abs=0.4)


def test_a_turning_back_counts_where_it_is_nearer_to_1_than_the_end():
    """(s^2 + a s + 1)/(s^2 + b s + 1) has its most or its least, a/b, at 1."""

    def asked(gain, a, b):
        loop = late([gain, gain * a, gain], [1.0, b, 1.0], 1.0)
        size = np.abs(floats(loop, np.geomspace(0.01, 100, 50)))
        return _turning_back(Squares.of(loop), size, gain)

    assert asked(0.5, 0.3, 0.2) == pytest.approx([1.0], rel=1e-15)
    assert asked(2.0, 0.2, 0.3) == pytest.approx([1.0], rel=1e-15)
    assert asked(0.5, 0.2, 0.3) == []
    assert asked(2.0, 0.3, 0.2) == []
    # s/(s^2 + s + 1) k ends at 0; it counts as what is nearest to 1, and so within a factor of 2
    loop = late([0.4, 0.0], [1.0, 1.0, 1.0], 1.0)
    for nearest, counts in ((0.4, [1.0]), (0.79, [1.0]), (0.81, [])):
        assert _turning_back(Squares.of(loop), np.array([nearest]), 0.0) == counts


def test_turns_are_looked_for_up_to_the_reach_and_around_what_decides_beyond():
    loop = late([1.5, 1.5e5], [1, 2e5], 1.0)
    look = Close.of(loop, Squares.of(loop))
    ((low, high),) = look.further
    unity = sqrt((4e10 - 2.25e10) / 1.25)
    assert (low, high) == pytest.approx((unity - 4 * pi, unity + 4 * pi), abs=0.2)
    assert look.reach == pytest.approx(4 * pi, abs=0.2)
    turns = np.array(look.turns())
    assert np.count_nonzero(turns <= look.reach) == 4
    far = turns[turns > look.reach]
    assert ((far >= low) & (far <= high)).all()
    assert len(far) == 8
    for a, b in pairwise(far.tolist()):
        assert b - a == pytest.approx(pi, abs=1e-4)  # num/den turns by 1e-5 more


@pytest.mark.parametrize("end", [0.25, 3.0])
@pytest.mark.parametrize("v", [0.5, 3.0, 20.0])
def test_none_decides_beyond_where_the_size_is_that_of_the_factor(end, v):
    """|end (jw + 2)/(jw + 1)|^2 = end^2 (q + 4)/(q + 1), which falls to end^2.

    Below 1 it is nearest where it is seen from, above 1 at its end.
    """
    squares = Squares.of(late([end, 2 * end], [1.0, 1.0], 1.0))
    size = end * sqrt((v * v + 4) / (v * v + 1)) if end < 1 else end
    for factor in (1 / size, size):
        assert none_decides(squares, factor ** (1 - 1e-7), v)
        assert not none_decides(squares, factor ** (1 + 1e-7), v)


def test_a_factor_of_1_to_within_the_tolerance_is_decided_by_nobody():
    squares = Squares.of(late([1.0, 2.0], [1.0, 1.0], 1.0))
    for factor, decided in ((1.0, True), (1 + 9e-10, True), (1 / (1 + 9e-10), True), (1.1, False)):
        assert none_decides(squares, factor, 1.0) is decided


GAINS = [
    (0.5, ON_DEN, 0.5), (0.5, ON_NUM, 1.0), (0.5, ON_OPPOSITE, 1 / 3),
    (2.0, ON_DEN, 1.0), (2.0, ON_NUM, 0.5), (2.0, ON_OPPOSITE, 1 / 3),
    (0.25, ON_NUM, 3.0), (4.0, ON_DEN, 3.0),
]  # fmt: skip


@pytest.mark.parametrize(("gain", "below", "least"), GAINS)
def test_how_near_a_gain_comes_turned_any_way(gain, below, least):
    """|1 - r|, |1 - r|/r and |1 - r|/(1 + r)."""
    squares = Squares.of(late([gain], [1.0], 1.0))
    assert keeps_above(squares, least * (1 - 1e-12), below, 7.0)
    assert not keeps_above(squares, least * (1 + 1e-12), below, 7.0)


def test_the_level_is_reached_beside_the_positive_axis():
    """9/10 exp(-jw)/(jw/1e6 + 1) is positive where w + arctan(w/1e6) = 2 pi k."""
    loop = late([0.9], [1e-6, 1.0], 1.0)
    for start in (3.0, 1e6):
        found = _next_positive(loop, start)
        turns = (found + np.arctan(found / 1e6)) / (2 * pi)
        assert turns == pytest.approx(round(turns), abs=1e-9)
        assert start < found < start + 2 * pi
    dip = _dip(loop, found)
    least = abs(floats(loop, dip) / (1 + floats(loop, dip)))
    for x in np.linspace(-0.5, 0.5, 101):  # a phase of 1e6 rad is rounded to 1e-10
        assert abs(floats(loop, dip + x) / (1 + floats(loop, dip + x))) >= least - 1e-10
    places = around_the_fall(loop, Squares.of(loop), 12.0)
    level = sqrt(DROP) * 9 / 19
    fall = sqrt((0.9 * (1 - level) / level) ** 2 - 1) * 1e6
    assert places[0] == pytest.approx(fall - 2 * pi, abs=1e-6)
    assert places[-3] == pytest.approx(fall + 4 * pi, abs=0.2)
    assert len(around_the_fall(loop, Squares.of(loop), 2e6)) == 2
    # T(0) = 11: the level is above 1, and no size of L alone keeps |T| above that
    loud = late([-1.1], [1e-6, 1.0], 1.0)
    assert around_the_fall(loud, Squares.of(loud), 12.0).size == 0
    # |L| never falls to it
    flat = late([0.999, 1.998], [1.0, 1.0], 1.0)
    assert around_the_fall(flat, Squares.of(flat), 12.0).size == 0
