"""Discs hold what they should, are no larger than their law says, and prove only what is so."""

import itertools
from dataclasses import replace
from math import atan, hypot, inf, pi, sqrt, tan

import numpy as np
import pytest
from mpmath import mp, mpc, mpf

from zoh.analysis import discs
from zoh.analysis.discs import _changes, _counted, _keeps_off
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.squares import ON_DEN, ON_NUM, ON_OPPOSITE
from zoh.analysis.stretches import decided, product, stretches, taylor
from zoh.lti.systems import Plant, Sampled

BLUR = 1e-14  # of the sum of a polynomial's terms and for each of them


def late(num, den, dead_time):
    return Loop.of(Plant(num=num, den=den, dead_time=dead_time))


def samples_late(num_w, den_w, delay, dt=2.0):
    return Loop.of(Sampled.from_w(num_w=num_w, den_w=den_w, dt=dt, delay=delay))


LOOPS = {
    "continuous": late([1.0, 0.3], [1.0, 1.0, 2.0], 0.7),
    "sampled": samples_late((0.2, 0.3), (1.0, 1.5, 2.0), 15),
    "an integrator": late([2.0], [1.0, 1.0, 0.0], 0.4),
}


# By hand: x^2 + 2 x + 3 at 1 is 6, its slopes 4 and 2; on 1 +- 1/2 it moves by 4/2 + 1/4 at most.
# x^3 - 2 x^2 + 5j at 2 is 5j, its slopes 4, 2 (4) and 6 (1); on 2 +- 1/4 by 1 + 1/4 + 1/64.
@pytest.mark.parametrize(
    ("a", "c", "h", "value", "radius", "slope", "slope_radius", "terms"),
    [
        ([1, 2, 3], 1.0, 0.5, 6, 2.25, 4, 1.0, 8.25),
        ([1, -2, 0, 5j], 2.0, 0.25, 5j, 1.265625, 4, 2.1875, 2.25**3 + 2 * 2.25**2 + 5),
        ([1, -2, 0, 5j], -2.0, 0.25, -16 + 5j, 5.515625, 20, 4.1875, 2.25**3 + 2 * 2.25**2 + 5),
        ([2j, 1], 3.0, 0.5, 1 + 6j, 1.0, 2j, 0.0, 8.0),
        ([3 + 4j], 3.0, 0.5, 3 + 4j, 0.0, 0, 0.0, 5.0),
    ],
)
def test_a_polynomial_stays_in_its_disc(a, c, h, value, radius, slope, slope_radius, terms):
    a = np.array(a, complex)
    found = [x.item() for x in taylor(a, np.array([c]), np.array([h]))]
    blur, n = BLUR * len(a) * terms, len(a) - 1
    assert (found[0], found[2]) == (value, slope)
    # 0.05: what is left after the subtraction has two digits
    assert found[1] - radius == pytest.approx(blur, rel=0.05, abs=0)
    assert found[4] == pytest.approx(blur, rel=1e-12, abs=0)
    sloped = sum(abs(x) * (n - i) * (abs(c) + h) ** (n - 1 - i) for i, x in enumerate(a[:-1]))
    assert found[3] - slope_radius == pytest.approx(BLUR * len(a) * sloped, rel=0.05, abs=0)


def test_products_of_discs():
    one = product(np.array([3 + 4j]), np.array([0.5]), np.array([2j]), np.array([0.25]))
    assert one == pytest.approx([5 * 0.25 + 2 * 0.5 + 0.125])


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_both_stretches_are_the_loop(loop):
    upto, beyond = stretches(loop, np.array([1.0, 4.0]))
    assert upto.ends.tolist() == [0.0, 1.0, 4.0]
    assert beyond.ends.tolist() == [0.0, 0.25]
    assert (upto.beyond, beyond.beyond) == (False, True)
    n = len(loop.den) - 1
    for v in (0.5, 3.0, 7.0):
        top, bottom = loop.point(v)
        assert np.ravel(upto.at(np.array([v]))) == pytest.approx([top, bottom], rel=1e-13)
        far = (1j * v) ** n
        found = np.ravel(beyond.at(np.array([1 / v])))
        assert found == pytest.approx([top / far, bottom / far], rel=1e-13)


def test_the_end_of_the_axis():
    _, beyond = stretches(LOOPS["continuous"], np.array([1.0]))
    assert np.ravel(beyond.at(np.array([0.0]))).tolist() == [0.0, 1.0]  # turns for ever: 0
    assert beyond.psi(np.array([0.5, 0.1])).tolist() == [inf, inf]
    _, beyond = stretches(samples_late((2.0, 3.0), (4.0, 5.0), 3), np.array([1.0]))
    top, bottom = beyond.at(np.array([0.0]))
    assert (top[0], bottom[0]) == (pytest.approx(-2), 4)  # z^-3 at z = -1


def test_a_power_of_x_turns_by_no_angle():
    upto, _ = stretches(late([2.0, 0.0], [1.0, 1.0, 0.0, 0.0], 1.0), np.array([1.0]))
    bare = upto.over_powers()
    assert bare.num.tolist() == [0, 0, 2j]
    assert bare.den.tolist() == [-1j, -1]
    assert bare.ends is upto.ends


def value_and_slope(part, x):
    """Return top, bottom and their derivatives at x, by the product rule."""
    x = np.asarray(x)
    turned = np.exp(-1j * part.psi(x))
    top, bottom = np.polyval(part.num, x), np.polyval(part.den, x)
    moved = np.polyval(np.polyder(part.num), x) - 1j * part.psi_slope(x) * top
    return top * turned, bottom, moved * turned, np.polyval(np.polyder(part.den), x)


PARTS = [
    (name, i, a, b)
    for name in LOOPS
    for i, a, b in ((0, 0.0, 0.5), (0, 1.0, 1.25), (0, 3.0, 3.01), (1, 0.0, 0.2), (1, 0.2, 0.21))
    if name == "sampled" or not i
]


@pytest.mark.parametrize(("name", "i", "a", "b"), PARTS)
def test_the_loop_stays_in_its_discs(name, i, a, b):
    part = stretches(LOOPS[name], np.array([1.0]))[i]
    d = part.discs(np.array([a]), np.array([b]))
    centres = [d.top, d.bottom, d.top_slope, d.bottom_slope]
    radii = [d.top_radius, d.bottom_radius, d.top_slope_radius, d.bottom_slope_radius]
    inside = value_and_slope(part, np.linspace(a, b, 41))
    middle = value_and_slope(part, [(a + b) / 2])
    swing = max(abs(part.psi(np.array([x])) - part.psi(np.array([(a + b) / 2]))) for x in (a, b))
    for k, (centre, radius, values, value) in enumerate(
        zip(centres, radii, inside, middle, strict=True)
    ):
        if k == 0 and swing >= 1:
            value = [0.0]  # any phase: a disc around 0 is the smaller one
        assert centre == pytest.approx(value, rel=1e-12, abs=1e-15)
        assert np.abs(values - centre).max() <= radius


def test_a_pure_delay_by_hand():
    """exp(-0.7 j v) on 2 +- 1/4."""
    part, beyond = stretches(late([1.0], [1.0], 0.7), np.array([8.0]))
    d = part.discs(np.array([1.75]), np.array([2.25]))
    assert d.top == pytest.approx(np.exp([-1.4j]))
    assert d.top_slope == pytest.approx(-0.7j * np.exp([-1.4j]))
    assert d.top_radius == pytest.approx([0.175], rel=1e-12)
    assert d.top_slope_radius == pytest.approx([0.175 * 0.7], rel=1e-12)
    assert (d.bottom.item(), d.bottom_slope.item()) == (1, 0)
    d = beyond.discs(np.array([0.0]), np.array([0.125]))  # any phase
    assert (d.top.item(), d.bottom.item(), d.bottom_slope.item()) == (0, 1, 0)
    assert d.top_radius == pytest.approx([1.0], rel=1e-12)
    assert d.top_slope_radius.item() == inf
    assert d.bottom_radius.item() == pytest.approx(BLUR)


def test_samples_of_delay_by_hand():
    """With dt = 2 and a delay of 2 s psi is 2 arctan v and 2 arctan(1/x), even in the slopes."""
    upto, beyond = stretches(samples_late((1.0,), (1.0,), 1), np.array([1.0]))
    zero, one = np.array([0.0]), np.array([1.0])
    swing, rate = 2 * atan(0.5), 0.6  # slope 2/(1 + v^2): 2, 1.6, 1
    for part, turn in ((upto, 2 * atan(0.5)), (beyond, 2 * atan(2.0))):
        sign = -1 if part.beyond else 1
        d = part.discs(zero, one)
        assert d.top == pytest.approx(np.exp([-1j * turn]))
        assert d.top_radius == pytest.approx([swing], rel=1e-12)
        assert d.top_slope == pytest.approx(sign * -1.6j * np.exp([-1j * turn]))
        assert d.top_slope_radius == pytest.approx([rate + swing * (1.6 + rate)], rel=1e-12)
    d = part.discs(one, 3 * one)  # on [1, 3] the slope falls from 1 by 3/5 to 2/5 and 1/5
    swing = 2 * (atan(2) - atan(1))
    assert d.top_radius == pytest.approx([swing], rel=1e-12)
    assert d.top_slope_radius == pytest.approx([0.6 + swing * (0.4 + 0.6)], rel=1e-12)


def test_a_polynomial_with_a_delay_by_hand():
    """(jv + 3) exp(-0.7 j v) on 2 +- 1/4: |3 + 2j| and 1/4 more, turned by 0.175 either way."""
    part, _ = stretches(late([1.0, 3.0], [1.0, 1.0], 0.7), np.array([8.0]))
    d = part.discs(np.array([1.75]), np.array([2.25]))
    size, swing, slope = sqrt(13) + 0.25, 0.175, abs(1j - 0.7j * (3 + 2j))
    moved = 0.7 * 0.25
    assert d.top == pytest.approx((3 + 2j) * np.exp([-1.4j]))
    assert d.top_radius == pytest.approx([0.25 + swing * size], rel=1e-12)
    assert d.top_slope == pytest.approx((1j - 0.7j * (3 + 2j)) * np.exp([-1.4j]))
    assert d.top_slope_radius == pytest.approx([moved + swing * (slope + moved)], rel=1e-12)


# g exp(-0.3 s): |1 + L| goes down to 1 - g, over |L| to (1 - g)/g, over |1 - L| to (1 - g)/(1 + g).
@pytest.mark.parametrize(("below", "true"), [(ON_DEN, 0.5), (ON_NUM, 1.0), (ON_OPPOSITE, 1 / 3)])
def test_a_least_ratio_is_proved_to_a_millionth(below, true):
    loop = late([0.5], [1.0], 0.3)
    for factor, holds in ((0.9, True), (1 + 0.9e-6, True), (1 + 1.2e-6, False), (1.5, False)):
        told = discs.least(loop, np.array([1.0]), true * factor, below)
        assert (told.holds, told.method) == (holds, "discs")
    assert told.detail == f"nowhere below {true * 1.5:.9g} by more than 1e-06 of it"


def grid_least(loop, below):
    v = np.concatenate([np.linspace(0.01, 30, 3001), np.geomspace(30, 1e4, 100)])
    top, bottom = loop.parts(v)
    return float((np.abs(top + bottom) / np.abs(below[0] * bottom + below[1] * top)).min())


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("below", [ON_DEN, ON_NUM, ON_OPPOSITE])
def test_a_least_ratio_from_a_coarse_grid(name, below):
    """2 % above what a fine grid shows is not so, 2 % below it is."""
    loop = LOOPS[name]
    true = grid_least(loop, below)
    assert discs.least(loop, np.array([0.3, 12.0]), true * (1 - 0.02), below).holds
    assert not discs.least(loop, np.array([0.3, 12.0]), true * (1 + 0.02), below).holds


# exp(-s)/(s + 1) is real where w + arctan w = k pi: up to w = 10 that is 11.47, three times.
# z^-15/2 is real at w = k pi/15, k = 1 ... 14.
TURNS = [
    (late([1.0], [1.0, 1.0], 1.0), 10.0, 3),
    (late([1.0], [1.0, 1.0], 1.0), 20.0, 6),
    (late([2.0], [1.0, 0.0], 0.5), 8.0, 1),  # pi/2 + w/2 = k pi: at pi and 3 pi
    (late([2.0], [1.0, 0.0], 0.5), 10.0, 2),
    (samples_late((0.5,), (1.0,), 15), 1.0, 14),
    (samples_late((0.5,), (1.0,), 15), 30.0, 14),
    (samples_late((0.5, 1.0), (1.0, 2.0), 15), 3.0, 14),  # the same phase
]


@pytest.mark.parametrize(("loop", "last", "count"), TURNS)
@pytest.mark.parametrize("points", [1, 2, 7])
def test_real_points_are_counted_on_any_grid(loop, last, count, points):
    v = np.linspace(0, last, points + 1)[1:]
    for found in (count - 1, count, count + 1, 0):
        told = discs.turns(loop, v, found)
        assert (told.holds, told.method) == (found == count, "discs")
        upto = f" up to {last:g} rad/s" if loop.dt is None else ""
        assert told.detail == f"{count} sign changes on the axis{upto}, {found} found"


def test_nothing_has_no_real_points():
    nothing = replace(LOOPS["continuous"], num=(0.0, 0.0, 0.0))
    told = discs.turns(nothing, np.array([1.0]), 0)
    assert (told.holds, told.method, told.detail) == (True, "bound", "L is 0")


def drop_of(loop, level):
    """Return every v up to 40 at which |T| passes the level, by halving on a fine grid."""

    def above(v):
        top, bottom = loop.point(v)
        return abs(top) - level * abs(top + bottom)

    v = np.linspace(1e-3, 40, 801).tolist()
    found = []
    for a, b in itertools.pairwise(v):
        if above(a) * above(b) < 0:
            for _ in range(60):
                middle = (a + b) / 2
                a, b = (middle, b) if above(a) * above(middle) > 0 else (a, middle)
            found.append((a + b) / 2)
    return found


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("level", [0.06, 0.1, 0.3])
@pytest.mark.parametrize("points", [[0.05], [1.0, 3.0], [0.5, 50.0]])
def test_the_first_passage_is_proved_from_a_coarse_grid(name, level, points):
    loop, v = LOOPS[name], np.array(points)
    there = drop_of(loop, level)
    if there:
        told = discs.passages(loop, v, level, there)
        assert (told.holds, told.method) == (True, "discs")
        assert told.detail == "1 sign changes on the axis, 1 found"
        assert discs.passages(loop, v, level, there[:1]).holds
        for wrong in (there[1:], [0.9 * there[0]], [1.1 * there[0]] if len(there) > 1 else []):
            if wrong and wrong != there:
                told = discs.passages(loop, v, level, wrong)
                even = sum(x < wrong[0] * (1 + 1e-7) for x in there)
                assert told.holds is (even == 1)
        assert not discs.passages(loop, v, level, []).holds
    else:
        assert discs.passages(loop, v, level, []).holds


def test_passages_without_a_level_are_none():
    loop, v = LOOPS["continuous"], np.array([1.0])
    told = discs.passages(loop, v, 0.0, [])
    assert (told.holds, told.method) == (True, "bound")
    assert told.detail == "T is 0 or infinite at w = 0"
    assert not discs.passages(loop, v, 0.0, [1.0]).holds


@pytest.mark.parametrize(
    ("level", "keeps"),
    [(0.3, True), (0.333, True), (0.334, False), (0.9, False), (0.999, False), (1.001, True)],
)
def test_t_of_a_gain_turned_any_way_lies_between_two_numbers(level, keeps):
    """exp(-j psi)/2: |T| is between (1/2)/(3/2) and (1/2)/(1/2)."""
    _, beyond = stretches(late([0.5], [1.0], 1.0), np.array([2.0]))
    assert _keeps_off(beyond, level) is keeps


def test_t_turned_any_way_by_hand():
    """(1 + 3 y)/(4 + 20 y), y = -j x and x <= 1/10: discs around x = 1/20."""
    _, beyond = stretches(late([1.0, 3.0], [4.0, 20.0], 1.0), np.array([10.0]))
    top, bottom = hypot(1, 0.15), hypot(4, 1.0)
    low, high, least, most = top - 0.15, top + 0.15, bottom - 1, bottom + 1
    for level, keeps in ((low / (most + low), True), (high / (least - high), False)):
        assert _keeps_off(beyond, level * (1 - 1e-9)) is keeps
        assert _keeps_off(beyond, level * (1 + 1e-9)) is not keeps


# exp(-s) k/(s+1)^3: w + 3 arctan w = pi and 3 pi, where k = (1 + w^2)^(3/2)
def _lag3(turn):
    low, high = 0.0, turn
    for _ in range(200):
        w = (low + high) / 2
        low, high = (w, high) if w + 3 * atan(w) < turn else (low, w)
    return (1 + w * w) ** 1.5


@pytest.mark.parametrize("v", [[10.0], [60.0], [0.1, 1.0, 10.0]])
@pytest.mark.parametrize(
    ("k", "zeros"),
    [
        (0.999 * _lag3(pi), 0),
        (1.001 * _lag3(pi), 2),
        (0.999 * _lag3(3 * pi), 2),
        (1.001 * _lag3(3 * pi), 4),
        (-0.99, 0),
        (-1.01, 1),
    ],
)
def test_zeros_on_the_right_from_a_coarse_grid(k, zeros, v):
    assert discs.unstable_zeros(late([k], [1, 3, 3, 1], 1.0), np.array(v)) == zeros


@pytest.mark.parametrize(("factor", "zeros"), [(0.999, 0), (1.001, 2)])
def test_zeros_of_a_loop_in_units_whose_products_no_float_holds(factor, zeros):
    """The same in a time of 1e-60 s: den is 1e180 and more."""
    unit, k = 1e60, factor * _lag3(pi)
    den = [1, 3 * unit, 3 * unit**2, unit**3]
    fast = late([k * unit**3], den, 1 / unit)
    assert discs.unstable_zeros(fast, np.array([10 * unit])) == zeros


@pytest.mark.parametrize("v", [[0.5], [3.0], [200.0], [0.1, 1.0, 10.0]])
def test_zeros_of_a_sampled_loop_from_a_coarse_grid(v):
    """z^-m k/(z-1) leaves at k = 2 sin(pi/(4m+2)), as in test_proof."""
    for m in (1, 4, 15):
        k = 2 * np.sin(pi / (4 * m + 2))
        for factor, zeros in ((0.99, 0), (1.01, 2)):
            loop = samples_late((-factor * k / 2, factor * k / 2), (1.0, 0.0), m)
            assert discs.unstable_zeros(loop, np.array(v)) == zeros


@pytest.mark.parametrize(("off", "zeros"), [(0.09, 0), (0.11, None), (0.5, None), (0.95, 1)])
def test_a_path_that_does_not_close_counts_nothing(monkeypatch, off, zeros):
    """(s + 1)^3, all but alone, followed to v only, turns by 3 arctan v instead of 3 pi/2."""
    whole = discs.stretches
    monkeypatch.setattr(discs, "stretches", lambda loop, v: whole(loop, v)[:1])
    v = tan((1.5 - off) * pi / 3)
    assert discs.unstable_zeros(late([1e-9], [1, 3, 3, 1], 1.0), np.array([v])) == zeros


def part_of(ends):
    upto, _ = stretches(late([1.0], [1.0], 1.0), np.array([1.0]))
    return replace(upto, ends=np.asarray(ends))


def asked(part, holds):
    """Return ``decided`` for a test that is given the intervals themselves."""
    ends = []

    class Told(type(part)):
        def discs(self, a, b):
            ends.append((a, b))
            return None

    told = Told(loop=part.loop, num=part.num, den=part.den, ends=part.ends, beyond=False)
    return decided(told, lambda _: holds(*ends[-1]))


def test_what_is_not_decided_is_halved():
    found = asked(part_of([0.0, 1.0, 3.0]), lambda a, b: b - a < 1)
    assert sorted(zip(*map(np.ndarray.tolist, found), strict=True)) == [
        (0, 0.5), (0.5, 1), (1, 1.5), (1.5, 2), (2, 2.5), (2.5, 3),
    ]  # fmt: skip
    assert [x.tolist() for x in asked(part_of([0.0, 1.0]), lambda a, b: b > a)] == [[0.0], [1.0]]


@pytest.mark.parametrize(("halvings", "decided"), [(58, True), (59, True), (60, False)])
def test_sixty_rounds_are_the_end(halvings, decided):
    found = asked(part_of([0.0, 1.0]), lambda a, b: (a > 0) | (b <= 2.0**-halvings))
    assert (found is not None) is decided


@pytest.mark.parametrize(("count", "decided"), [(400_000, True), (400_001, False)])
def test_so_many_intervals_are_the_end(count, decided):
    found = asked(part_of(np.arange(count + 1.0)), lambda a, b: (a > 0.5) | (b - a < 1))
    assert (found is not None) is decided


@pytest.mark.parametrize(("count", "decided"), [(133_333, True), (133_334, False)])
def test_intervals_of_all_rounds_count(count, decided):
    """None is proved at first, then all halves but one: 3 count, and 2 more where there is room."""
    found = asked(part_of(np.arange(count + 1.0)), lambda a, b: (b - a < 1) & ((a > 0) | (b < 0.5)))
    assert (found is not None) is decided


def test_numbers_of_stretches_add_up():
    told = _counted([2, 1], 3)
    assert (told.holds, told.method) == (True, "discs")
    assert told.detail == "3 sign changes on the axis, 3 found"
    assert not _counted([2, 1], 2).holds
    told = _counted([2, None], 2)
    assert (told.holds, told.method) == (False, "discs")
    assert told.detail == "two crossings, or none, nearer than discs tell"


def test_signs_that_rounding_makes_beside_a_root_do_not_count():
    """x - 2 has a slope of 1, and is clear of 0 by 0.3 or more on all but (1.8, 2.2)."""
    part = part_of([1.0, 1.6, 1.8, 1.9, 2.0, 2.1, 2.2, 2.4, 3.0])

    def told(d):
        return next(values), np.full(d.top.shape, 0.25)

    def noisy(_, x):
        return np.where(abs(x - 2) < 0.15, np.cos(31.4 * x), x - 2)

    assert (np.sign(noisy(None, part.ends)) == [-1, -1, -1, -1, 1, -1, 1, 1, 1]).all()
    middles = (part.ends[1:] + part.ends[:-1]) / 2
    values = iter([middles - 2, np.ones(8)])
    assert _changes(part, told, told, noisy) == 1


def test_a_root_between_two_intervals_is_one_change_of_sign_and_at_an_end_none():
    part = part_of([1.0, 2.0, 3.0])

    def told(d):
        return np.ones(d.top.shape), np.zeros(d.top.shape)

    assert _changes(part, told, told, lambda _, x: x - 1.0) == 0
    assert _changes(part, told, told, lambda _, x: x - 2.0) == 1
    assert _changes(part, told, told, lambda _, x: x - 3.0) == 0
    assert _changes(part, told, told, lambda _, x: x - 2.5) == 1
    assert _changes(part, told, told, lambda _, x: (x - 1.5) * (x - 2.5)) == 2


# K exp(-s/10)/(s (s + 1)): L is -jK/s at first, where |1 + L| = |1 - L|, and least beside -1 where
# it is real: by 2 K/(w^2 sqrt(1 + w^2)) or so below 1.  (1.1 s + 1)/(s + 1/2) exp(-s): |L| falls
# from 2 to 1.1 for ever, so that the least are |1 - 1.1|, that over 1.1 and 0.1/2.1.
NEARLY_FLAT = [
    (late([1e-8], [1.0, 1.0, 0.0], 0.1), ON_OPPOSITE, 1.0, True),
    (late([1e-30], [1.0, 1.0, 0.0], 0.1), ON_OPPOSITE, 1.0, True),
    (late([1e-8], [1.0, 1.0, 0.0], 0.1), ON_OPPOSITE, 1 + 4e-6, False),
    (late([1.1, 1.0], [1.0, 0.5], 1.0), ON_DEN, 0.1, True),
    (late([1.1, 1.0], [1.0, 0.5], 1.0), ON_NUM, 0.1 / 1.1, True),
    (late([1.1, 1.0], [1.0, 0.5], 1.0), ON_OPPOSITE, 0.1 / 2.1, True),
    (late([1.1, 1.0], [1.0, 0.5], 1.0), ON_DEN, 0.1 * (1 + 4e-6), False),
    (late([1.1, 1.0], [1.0, 0.5], 1.0), ON_NUM, 0.1 / 1.1 * (1 + 4e-6), False),
    (late([1.1, 1.0], [1.0, 0.5], 1.0), ON_OPPOSITE, 0.1 / 2.1 * (1 + 4e-6), False),
]


@pytest.mark.parametrize(("loop", "below", "value", "holds"), NEARLY_FLAT)
def test_ratios_that_are_all_but_constant(loop, below, value, holds):
    told = discs.least(loop, np.geomspace(1e-33, 500.0, 2000), value, below)
    assert told.holds is holds


@pytest.mark.parametrize(
    ("num", "den", "dead_time"),
    [([1e-8], [1, 1, 0], 0.1), ([1e-30], [1, 1, 0], 0.1), ([1.1, 1], [1, 0.5], 1), ([1], [1], 1)],
)
def test_weak_and_loud_loops_with_dead_time_are_certain(num, den, dead_time):
    found = measure_loop(late(num, den, dead_time))
    assert found.certificate.open() == []


@pytest.mark.parametrize("dt", [0.5, 2.0, 3.0])
def test_how_fast_a_delay_turns_beyond_the_last_point(dt):
    """psi = (2 m) arctan(dt/(2 x)): d psi/dx = -m dt/(x^2 + dt^2/4)."""
    _, beyond = stretches(samples_late((1.0,), (1.0, 1.0), 3, dt), np.array([1.0]))
    x = np.array([0.0, 0.1, 0.25, 1.0])
    assert beyond.psi_slope(x) == pytest.approx(-3 * dt / (x * x + dt * dt / 4), rel=1e-14)
    step = 1e-6
    seen = (beyond.psi(x + step) - beyond.psi(x - step)) / (2 * step)
    assert beyond.psi_slope(x) == pytest.approx(seen, rel=1e-8)  # a difference of 1e-6 has so many


def test_a_disc_holds_what_rounding_makes_of_a_long_delay():
    """exp(-j psi) at psi near 1e6 rad: a float's last bit there is 1e-10 rad."""
    part, _ = stretches(late([1.0], [1.0], 1e6 / 3), np.array([8.0]))
    v = np.array([3.0 + i / 97 for i in range(40)])
    d = part.discs(v, v)
    with mp.workdps(40):
        true = [mp.expj(-mpf(1e6 / 3) * mpf(x)) for x in v.tolist()]
        off = [float(abs(t - mpc(c))) for t, c in zip(true, d.top.tolist(), strict=True)]
    assert max(off) > 1e-11  # of what is far above a rounding of the size 1
    assert (np.array(off) <= d.top_radius).all()
    assert (np.array(off) <= d.top_blur).all()
