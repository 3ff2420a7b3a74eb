"""The look from close by: where its points lie, and what it asks between them."""

from math import atan, inf, pi, sqrt, tan

import numpy as np
import pytest

from zoh.analysis import close
from zoh.analysis.close import _AROUND, Close, _landmarks, _middle, _suspects
from zoh.analysis.loop import Loop
from zoh.analysis.squares import DROP, ON_DEN, ON_NUM, ON_OPPOSITE, Squares
from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled


def look(plant):
    loop = Loop.of(plant)
    return Close.of(loop, Squares.of(loop))


def late(num, den, dead_time):
    return Loop.of(Plant(num=num, den=den, dead_time=dead_time))


def _delay_grid(loop, v):
    return close._delay_grid(loop, Squares.of(loop), v)[0]


def near(v, wanted, rel=1e-9):
    """Return whether each wanted value is among v."""
    return all(np.abs(v / x - 1).min() < rel for x in wanted)


def test_the_middle_brings_the_ends_together():
    assert _middle((1, 0, 0, 8)) == 1  # 4 bits against 1, over 3 powers
    assert _middle((0, 1, 3, 64, 0)) == 3
    assert _middle((64, 0, 1)) == -3
    assert (_middle((7,)), _middle((0, 0)), _middle((0, 5, 0))) == (0, 0, 0)


def test_suspects_are_the_roots_and_their_sides():
    found = _suspects((1, -5, 4))  # q = 1 and 4
    assert len(found) == 12
    wanted = [v * s for v in (1.0, 2.0) for s in (1, 1 - 1e-7, 1 + 1e-7)]
    assert near(found, wanted, 1e-14)
    assert near(np.array(wanted), found.tolist(), 1e-14)
    # (q - 4)^2 + 9: |q| = 5; (q - 10)(q + 10): one; q + 1: none, nor q itself
    assert near(_suspects((1, -8, 25)), [sqrt(5), sqrt(4)], 1e-14)
    assert near(np.array([10.0]), (_suspects((1, 0, -100)) ** 2).tolist(), 1e-6)
    assert _suspects((1, 1)).size == 0
    assert _suspects((1, 0)).size == 0
    assert _suspects((2**200, -(2**190))) == pytest.approx([2.0**-5] * 6, rel=1e-6)
    # a root is asked too where its real part is just below 0, by up to a tenth of its size
    assert _suspects((100, 18, 100)).size == 12  # cos = -0.09; -0.11 is too far
    assert _suspects((100, 22, 100)).size == 0


def test_landmarks_by_hand():
    """(s + 2)/(s^2 + 0.2 s + 9), closed s^2 + 1.2 s + 11 and s^2 - 0.8 s + 7."""
    found = _landmarks(Loop.of(Plant(num=[1.0, 2.0], den=[1.0, 0.2, 9.0])))
    assert (np.diff(found) > 0).all()
    wanted = [2.0, 3.0, sqrt(11), sqrt(7)]
    for re, im in ((2.0, 0.0), (0.1, sqrt(8.99)), (0.6, sqrt(10.64)), (0.4, sqrt(6.84))):
        wanted += [im + re * k for k in _AROUND.tolist() if im + re * k > 1e-3]
    assert near(found, wanted)
    # a hundredth of the least to a hundred times the largest, twelve a decade
    decades = np.geomspace(0.02, 100 * sqrt(11), int(12 * np.log10(5000 * sqrt(11))) + 2)
    assert near(found, decades.tolist())
    assert near(np.array([*wanted, *decades]), found.tolist())


def test_landmarks_of_clocks_and_of_nothing():
    plain = _landmarks(Loop.of(Plant(num=[0.5], den=[1.0])))
    assert (plain[0], plain[-1]) == pytest.approx((0.01, 100.0))
    assert len(plain) == 12 * 4 + 2
    clock = _landmarks(Loop.of(Sampled(num=[0.5], den=[1.0], dt=0.1)))
    assert (clock[0], clock[-1]) == pytest.approx((0.2, 2000.0))
    waits = _landmarks(late([0.5], [1.0], 4.0))
    assert (waits[0], waits[-1]) == pytest.approx((0.0025, 25.0))
    # what is a hundred thousand times above the rest is left out: no mode is that far from its size
    assert _landmarks(Loop.of(Plant(num=[1.0], den=[1.0, 0.0, 1.0])))[0] >= 1e-5


def test_a_dead_time_is_followed_while_the_loop_is_loud():
    """100/s: above a thousandth up to about 1e5, and two turns further; every 0.2 rad."""
    loop = late([100.0], [1.0, 0.0], 0.1)
    v = _delay_grid(loop, np.geomspace(1.0, 1e5 * 0.999, 5))
    assert v[0] == pytest.approx(2.0)
    assert np.abs(np.diff(v) - 2.0).max() < 1e-9
    reach = v[-1]
    assert 1e5 * 0.999 + 4 * pi / 0.1 <= reach + 1e-6
    assert reach <= 1.1 * 1e5 + 4 * pi / 0.1 + 2.0
    # 0.001/(s + 1): a thousandth of its largest value, not of 1
    v = _delay_grid(late([0.001], [1.0, 1.0], 1.0), np.geomspace(0.01, 999.0, 300))
    assert 999.0 + 4 * pi - 0.2 <= v[-1] <= 1100.0 + 4 * pi + 0.2
    # a gain is like its end everywhere: two turns
    v = _delay_grid(late([0.5], [1.0], 1.0), np.geomspace(0.01, 100.0, 300))
    assert v[-1] == pytest.approx(0.2 * (int(4 * pi / 0.2) + 1))
    assert _delay_grid(Loop.of(Plant(num=[1.0], den=[1.0, 1.0])), np.ones(1)).size == 0


def test_a_dead_time_that_turns_too_often_is_followed_to_a_half_or_refused():
    # 1e3/s with 1 s: a thousandth is at 1e6, 5e6 points; a half at 2e3
    v = _delay_grid(late([1e3], [1.0, 0.0], 1.0), np.geomspace(1.0, 1e7, 2000))
    assert 2000 + 4 * pi - 40 <= v[-1] <= 2000 + 4 * pi + 1
    loop = late([1e7], [1.0, 0.0], 1.0)
    with pytest.raises(SpecError) as told:
        _delay_grid(loop, np.geomspace(1.0, 2e7, 100))
    assert (told.value.argument, told.value.value) == ("dead_time", 1.0)
    # |L| is 1 at 1e7: 40 000 rad are 0.004 s of that, and two turns belong to them
    assert told.value.bound == "must be at most 0.003996 s for a loop as fast as this"
    waits = late([1e7], [1.0, 0.0], 0.003996)
    assert _delay_grid(waits, np.geomspace(1.0, 2e7, 100))[-1] == pytest.approx(1e7, rel=1e-3)
    assert told.value.way_out == "what turns that often is no control loop"


def test_samples_of_delay_are_followed_to_nyquist():
    loop = Loop.of(Sampled.from_w(num_w=(1.0,), den_w=(1.0, 1.0), dt=0.5, delay=4))
    v = _delay_grid(loop, np.ones(1))
    lag = loop.psi(v)
    assert lag == pytest.approx(0.2 * np.arange(1, len(v) + 1))
    assert len(v) == int(4 * pi / 0.2)
    assert v[0] == pytest.approx(4 * tan(0.025))


def test_the_look_has_every_point_and_the_loop_there():
    seen = look(Plant(num=[10.0], den=[1.0, 3.0, 3.0, 1.0], dead_time=0.1))
    assert (np.diff(seen.v) > 0).all()
    assert seen.v[0] > 0
    top, bottom = seen.loop.parts(seen.v)
    assert seen.top.tolist() == top.tolist()
    assert seen.bottom.tolist() == bottom.tolist()
    turns = _delay_grid(seen.loop, _landmarks(seen.loop))
    assert seen.reach == turns[-1]
    assert np.isin(turns, seen.v).all()
    assert np.isin(_landmarks(seen.loop), seen.v).all()
    assert np.isin(_suspects(seen.squares.gain), seen.v).all()
    assert look(Plant(num=[10.0], den=[1.0, 3.0, 3.0, 1.0])).reach == inf
    assert look(Sampled.from_w(num_w=(1.0,), den_w=(1.0, 1.0), dt=0.5, delay=4)).reach == inf


def test_every_kind_of_root_by_hand():
    seen = look(Plant(num=[10.0], den=[1.0, 3.0, 3.0, 1.0]))
    assert seen.unities() == pytest.approx([sqrt(10 ** (2 / 3) - 1)], rel=1e-15)
    assert seen.turns() == pytest.approx([sqrt(3)], rel=1e-15)
    seen = look(Plant(num=[5.0], den=[1.0, 0.0]))
    assert seen.drops() == pytest.approx([5 * sqrt(1 / DROP - 1)], rel=1e-14)
    assert look(Plant(num=[1.0, 0.0], den=[1.0, 2.0, 1.0])).drops() == []
    # exp(-s)/(s + 1) is real where w + arctan w = k pi, followed to where |L| is a thousandth
    seen = look(Plant(num=[1.0], den=[1.0, 1.0], dead_time=1.0))
    found = seen.turns()
    assert [w + atan(w) for w in found] == pytest.approx(pi * np.arange(1, len(found) + 1))
    assert found[-1] <= seen.reach < found[-1] + pi + 0.1


def test_the_least_ratios_by_hand():
    seen = look(Plant(num=[1.0], den=[1.0, 1.0, 0.0]))  # as for the short look
    assert seen.lowest(ON_DEN) ** 2 == pytest.approx((1 + sqrt(3)) / 2, rel=1e-8)
    assert seen.lowest(ON_NUM) ** 2 == pytest.approx(0.5, rel=1e-8)
    assert seen.lowest(ON_OPPOSITE) ** 2 == pytest.approx(1.0, rel=1e-8)


@pytest.mark.parametrize("below", [ON_DEN, ON_NUM, ON_OPPOSITE])
@pytest.mark.parametrize("gain", [0.3, 2.0])
def test_the_least_ratio_of_a_late_loop_is_flat_there(below, gain):
    seen = look(Plant(num=[gain, 1.0], den=[1.0, 0.4, 2.0], dead_time=0.7))
    v = seen.lowest(below)
    least = seen.loop.ratio(v, below)
    for step in (1e-4, 1e-2, 0.1, 0.5):  # it rises quadratically
        for other in (v * (1 - step), v * (1 + step)):
            assert seen.loop.ratio(other, below) >= least
    for other in np.geomspace(0.01, 100, 4001).tolist():
        assert seen.loop.ratio(other, below) >= least * (1 - 1e-12)
    h = 1e-5 * v
    rise = seen.loop.ratio(v + h, below) - seen.loop.ratio(v - h, below)
    bend = seen.loop.ratio(v + h, below) + seen.loop.ratio(v - h, below) - 2 * least
    assert abs(rise) <= 1e-3 * abs(bend) + 1e-14
