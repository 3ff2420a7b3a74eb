"""What is asked of the discs on an interval, each claim with numbers worked by hand."""

import numpy as np
import pytest

from zoh.analysis import discs
from zoh.analysis.discs import DISC_TOL, _off_at_any_phase, _stays_above, floor_of
from zoh.analysis.loop import Loop
from zoh.analysis.squares import ON_DEN, ON_NUM, ON_OPPOSITE
from zoh.analysis.stretches import Discs
from zoh.lti.systems import Plant

LOOP = Loop.of(Plant(num=[1.0], den=[1.0, 1.0], dead_time=1.0))
V = np.array([1.0])
FREE = np.inf  # a slope of which nothing is known


def discs_of(top, top_radius, bottom, bottom_radius, top_least=0.0, **more):
    """Return the discs of one interval."""
    given = {
        "top": top, "top_radius": top_radius, "bottom": bottom, "bottom_radius": bottom_radius,
        "top_least": top_least, "top_slope": 0j, "bottom_slope": 0j, "top_slope_radius": FREE,
        "bottom_slope_radius": FREE, "half": 1.0, "top_blur": 0.0, "bottom_blur": 0.0,
    } | more  # fmt: skip
    parts = {"top", "bottom", "top_slope", "bottom_slope"}
    return Discs(**{k: np.array([x], complex if k in parts else float) for k, x in given.items()})


@pytest.fixture
def asked(monkeypatch):
    """Return the claims that discs makes of intervals, instead of asking them."""
    claims = []

    def catch(_, holds):
        claims.append(holds)
        return V, V

    def count(_, value, slope, at, sure=None):
        claims.append((value, slope, at))
        if sure:
            claims.append(sure)
        return 0

    monkeypatch.setattr(discs, "decided", catch)
    monkeypatch.setattr(discs, "_changes", count)
    return claims


# By hand, how large |den + num|/|below| is at least.
#   den = 4 +- 1, num = 2 +- 1/2: L = 1/2 +- (1/2 + 1/2)/3, and |den + num| = 6 +- 3/2
#   den = 1 +- 1/2, num = 0 +- 5 but no less than 4: |den + num| >= 4 - 3/2
#   den = 1/2 +- 1, which may be 0, num = 4 +- 1: |den + num| = 9/2 +- 2
APART = (2.0, 0.5, 4.0, 1.0)
LOUD = (0.0, 5.0, 1.0, 0.5, 4.0)
THROUGH = (4.0, 1.0, 0.5, 1.0, 3.0)
ACROSS = (-2j, 0.5, 4.0, 1.0)  # L = -j/2 +- 1/3, |1 + L| = |1 - L| = sqrt(5)/2
BOUNDS = [
    (APART, ON_DEN, 7 / 6),  # (3/2 - 1/3)/1, by both apart 4.5/5
    (APART, ON_NUM, 9 / 5),  # 4.5/2.5, by L (7/6)/(5/6)
    (APART, ON_OPPOSITE, 7 / 5),  # (7/6)/(1/2 + 1/3), by both apart 4.5/3.5
    (LOUD, ON_DEN, 5 / 3),  # 2.5/1.5
    (LOUD, ON_NUM, 1 / 2),  # 2.5/5
    (LOUD, ON_OPPOSITE, 5 / 13),  # 2.5/6.5
    (THROUGH, ON_DEN, 5 / 3),  # 2.5/1.5
    (THROUGH, ON_NUM, 1 / 2),  # 2.5/5
    (THROUGH, ON_OPPOSITE, 5 / 11),  # 2.5/(3.5 + 2)
    (ACROSS, ON_DEN, 5**0.5 / 2 - 1 / 3),
    (ACROSS, ON_OPPOSITE, (5**0.5 / 2 - 1 / 3) / (5**0.5 / 2 + 1 / 3)),
]


@pytest.mark.parametrize(("numbers", "below", "bound"), BOUNDS)
def test_the_least_ratio_that_is_proved(asked, numbers, below, bound):
    for factor, proved in ((1 - 1e-9, True), (1 + 1e-9, False)):
        value = bound * factor / (1 - DISC_TOL)
        told = discs.least(LOOP, V, value, below)
        assert (told.holds, told.method) == (True, "discs")
        assert told.detail == f"nowhere below {value:.9g} by more than 1e-06 of it"
        for holds in asked[-2:]:  # both stretches are asked the same
            assert holds(discs_of(*numbers)).tolist() == [proved]


def test_a_disc_that_may_hold_nothing_proves_nothing(asked):
    discs.least(LOOP, V, 1e-9, ON_DEN)
    assert asked[0](discs_of(-4.0, 0.5, 4.0, 0.5)).tolist() == [False]


def test_one_stretch_that_is_not_decided_is_enough(monkeypatch):
    for answers, proved in (([V, V], True), ([V, None], False), ([None, V], False)):
        left = iter(answers)
        monkeypatch.setattr(discs, "decided", lambda *_, left=left: next(left))
        assert discs.least(LOOP, V, 1.0, ON_DEN).holds is proved


def test_what_is_known_beyond_the_last_point_is_not_asked_again(asked):
    assert discs.least(LOOP, V, 1.0, ON_DEN, upto_last=True).holds
    assert len(asked) == 1
    assert discs.least(LOOP, V, 1.0, ON_DEN).holds
    assert len(asked) == 3
    assert floor_of(3.0) == 3.0 * (1 - DISC_TOL)


def test_t_keeps_off_a_level_for_the_size_of_l_alone():
    """den = 4 +- 1, num = 2j +- 1/2: |T| is from (3/2)/(5 + 3/2) to (5/2)/(3 - 5/2)."""
    d = discs_of(2j, 0.5, 4.0, 1.0, top_least=1.5)
    for level, off in ((3 / 13, True), (5.0, False)):
        assert _off_at_any_phase(d, level * (1 - 1e-12)).tolist() == [off]
        assert _off_at_any_phase(d, level * (1 + 1e-12)).tolist() == [not off]
    # |L| may be 1: no size of T is too large
    assert not _off_at_any_phase(discs_of(2j, 0.5, 4.0, 1.5, top_least=1.5), 1e9).any()


# den = 2 and num = 1, which grow by 1/2 and 1/4: with x = den + num and level = floor^2
#   x^2 - level den^2 = 9 - 4 level, its slope 2 (3/4) 3 - level 2 (1/2) 2 = 4.5 - 2 level
#   radii 0.2 and 0.1, of the slopes 0.1 and 0.05, blurs 0.02 and 0.01:
#   x^2 is off by 2 (3) 0.03 + 0.03^2, its slope by 2 (0.75 0.3 + 3 0.15 + 0.15 0.3) = 1.44,
#   den^2 by 2 (2) 0.02 + 0.02^2, its slope by 2 (0.5 0.2 + 2 0.1 + 0.1 0.2) = 0.64,
#   (den - num)^2 = 1 by 2 (1) 0.03 + 0.03^2, slope 0.5, by 2 (0.25 0.3 + 1 0.15 + 0.15 0.3) = 0.54
GROWING = (1.0, 0.1, 2.0, 0.2)
SLOPES = {
    "top_slope": 0.25, "bottom_slope": 0.5, "top_slope_radius": 0.05, "bottom_slope_radius": 0.1,
    "top_blur": 0.01, "bottom_blur": 0.02,
}  # fmt: skip
LEVELS = [
    (ON_DEN, 1.0, (8.8191 - 5.94) / (4.0804 - 1.36)),
    (ON_DEN, 0.5, (8.8191 - 2.97) / (4.0804 - 0.68)),
    (ON_OPPOSITE, 1.0, (8.8191 - 5.94) / (1.0609 + 0.04)),
]


@pytest.mark.parametrize(("below", "half", "level"), LEVELS)
def test_a_value_and_its_slope_keep_a_ratio_above(below, half, level):
    d = discs_of(*GROWING, half=half, **SLOPES)
    for factor, proved in ((1 - 1e-9, True), (1 + 1e-9, False)):
        assert _stays_above(d, (level * factor) ** 0.5, below).tolist() == [proved]


# num = 2j +- 0.1 with slope (1 + j)/2 +- 0.05, den = 1 +- 0.2 with slope 1/4 +- 0.1
TURNING = discs_of(
    2j, 0.1, 1.0, 0.2, top_slope=0.5 + 0.5j, bottom_slope=0.25, top_slope_radius=0.05,
    bottom_slope_radius=0.1,
)  # fmt: skip


def test_the_side_of_the_loop_and_its_slope(asked):
    discs.turns(LOOP, V, 0)
    value, slope, at = asked[0]
    # Im(2j 1), by 2 0.2 + 1 0.1 + 0.02
    assert np.ravel(value(TURNING)) == pytest.approx([2.0, 0.52], rel=1e-14)
    # Im((1 + j)/2) + Im(2j/4); by sqrt(1/2) 0.2 + 0.05 + 0.01 and 2 0.1 + 0.25 0.1 + 0.01
    assert np.ravel(slope(TURNING)) == pytest.approx([1.0, 0.295 + 0.5**0.5 * 0.2], rel=1e-14)
    # exp(-s)/(s + 1) at w: -(sin w + w cos w)
    for w in (0.0, 0.5, 2.0):
        wanted = -(np.sin(w) + w * np.cos(w))
        assert at(discs.stretches(LOOP, V)[0], np.array([w]))[0] == pytest.approx(wanted, rel=1e-13)


def test_the_side_of_the_loop_where_its_denominator_turns_it(asked):
    discs.turns(LOOP, V, 0)
    value, slope, _ = asked[0]
    d = discs_of(2j, 0.1, 1 + 1j, 0.2, top_slope=1.0, bottom_slope=2j, top_slope_radius=0.05,
                 bottom_slope_radius=0.1)  # fmt: skip
    # Im(2j (1 - j)), by 2 0.2 + sqrt(2) 0.1 + 0.02
    assert np.ravel(value(d)) == pytest.approx([2.0, 0.42 + 0.1 * 2**0.5], rel=1e-14)
    # Im(1 - j) + Im(2j (-2j)); by 0.2 + sqrt(2) 0.05 + 0.01 and 2 0.1 + 2 0.1 + 0.01
    assert np.ravel(slope(d)) == pytest.approx([-1.0, 0.62 + 0.05 * 2**0.5], rel=1e-14)


def test_t_beside_its_level_and_its_slope(asked):
    discs.passages(LOOP, V, 0.5, [])
    value, slope, at = asked[0]
    # |2j|^2 - |1 + 2j|^2/4; by 2 (2) 0.1 + 0.01 and a quarter of 2 sqrt(5) 0.3 + 0.09
    radius = 0.41 + (0.6 * 5**0.5 + 0.09) / 4
    assert np.ravel(value(TURNING)) == pytest.approx([4 - 5 / 4, radius], rel=1e-14)
    # Re((1 + j)/2 conj 2j) - Re((3/4 + j/2)(1 - 2j))/4
    # by sqrt(1/2) 0.1 + 2 0.05 + 0.005 and a quarter of |3/4 + j/2| 0.3 + sqrt(5) 0.15 + 0.045
    radius = 0.105 + 0.5**0.5 * 0.1 + (0.8125**0.5 * 0.3 + 5**0.5 * 0.15 + 0.045) / 4
    assert np.ravel(slope(TURNING)) == pytest.approx([1 - 1.75 / 4, radius], rel=1e-14)
    # 1 - |exp(-jw) + 1 + jw|^2/4
    sure = asked[1]
    assert sure(discs_of(2j, 0.1, 1.0, 0.2, 1.9)).tolist() == [True]  # |T| >= 1.9/3.1
    assert sure(discs_of(2j, 0.1, 1.0, 0.2, 1.1)).tolist() == [False]
    for w in (0.0, 0.5, 2.0):
        wanted = 1 - abs(np.exp(-1j * w) + 1 + 1j * w) ** 2 / 4
        assert at(discs.stretches(LOOP, V)[0], np.array([w]))[0] == pytest.approx(wanted, abs=1e-14)


def test_a_claim_holds_where_the_value_or_the_slope_is_clear_of_zero(monkeypatch):
    claims = []
    monkeypatch.setattr(discs, "decided", lambda _, holds: claims.append(holds))
    numbers = {"value": (0.0, 0.0), "slope": (0.0, 0.0)}

    def told(name):
        return lambda _: tuple(np.array([x]) for x in numbers[name])

    assert discs._changes(None, told("value"), told("slope"), None) is None
    (holds,) = claims
    for value, slope, clear in (
        ((-2.0, 1.0), (0.0, 1.0), True), ((0.0, 1.0), (-2.0, 1.0), True),
        ((1.0, 1.0), (1.0, 1.0), False), ((1.0, 2.0), (-1.0, 2.0), False),
    ):  # fmt: skip
        numbers.update(value=value, slope=slope)
        assert holds(None).tolist() == [clear]
