"""A loop on its frequency axis says what its coefficients say, worked by hand.

The loop of most tests is (s + 3)/(s^2 + 2 s + 5); at v = 2 its num is 3 + 2j and its den 1 + 4j.
"""

from math import atan, inf, pi, sqrt

import numpy as np
import pytest

from zoh.analysis.axis import scalar
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.series import These, out_of_range
from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled

NUM, DEN = [1.0, 3.0], [1.0, 2.0, 5.0]
PLAIN = Loop.of(Plant(num=NUM, den=DEN))
QUARTER = pi / 4  # s of dead time: at v = 2 it turns by 90 degrees
LATE = Loop.of(Plant(num=NUM, den=DEN, dead_time=QUARTER))
SAMPLED = Loop.of(Sampled.from_w(num_w=(1.0, 3.0), den_w=(1.0, 2.0, 5.0), dt=0.5, delay=3))


def test_the_very_same_systems_have_the_very_same_loop_and_equal_ones_their_own():
    one, twin = (Sampled(num=[0.5], den=[1.0, -0.5], dt=0.5) for _ in range(2))
    other = Sampled.made(num=(0.5,), den=(1.0, -0.5), dt=0.5, num_w=(1.0, 3.0), den_w=(1.0, 5.0))
    assert Loop.of(one) is Loop.of(one)
    assert Loop.of(one, one) is not Loop.of(one)
    assert one == twin == other
    assert Loop.of(twin) is not Loop.of(one)
    assert Loop.of(other).num == (1.0, 3.0)


def test_systems_in_series_multiply_and_add_their_delays():
    one = Plant(num=[2.0], den=[1.0, 1.0], dead_time=0.25, sensor=0.5)
    other = Plant(num=[1.0, 3.0], den=[1.0, 2.0], dead_time=0.5)
    loop = Loop.of(one, other)
    assert loop.num == (0.0, 1.0, 3.0)
    assert loop.den == (1.0, 3.0, 2.0)
    assert loop.dead_time == 0.75
    assert loop.dt is None
    assert loop.rounded == ()
    num, den = loop.exact
    unit = den[0]
    assert (list(num), list(den)) == ([0, unit, 3 * unit], [unit, 3 * unit, 2 * unit])


def test_an_empty_product_is_one():
    loop = Loop.of()
    assert (loop.num, loop.den, loop.exact) == ((1.0,), (1.0,), ([1], (1,)))
    assert (loop.dt, loop.dead_time, loop.rounded) == (None, 0.0, ())


def test_sampled_systems_keep_their_dt_and_count_their_delays_in_seconds():
    late = Sampled.from_w(num_w=(1.0,), den_w=(1.0, 4.0), dt=0.5, delay=3)
    typed = Sampled(num=[1.0], den=[1.0, -0.5], dt=0.5)
    loop = Loop.of(late, typed)
    assert (loop.dt, loop.dead_time, loop.rounded) == (0.5, 1.5, (typed,))


@pytest.mark.parametrize("other", [Plant(num=[1], den=[1, 1]), Sampled(num=[1], den=[1], dt=0.2)])
def test_a_mixture_is_refused(other):
    with pytest.raises(SpecError) as told:
        Loop.of(Sampled(num=[1], den=[1], dt=0.1), other)
    assert (told.value.argument, told.value.value) == ("dt", getattr(other, "dt", None))
    assert told.value.bound == "must be the same throughout a loop (0.1 first)"
    assert told.value.way_out == "zoh.sample the plant with the controller's dt"


def test_what_is_no_system_is_refused():
    with pytest.raises(SpecError) as told:
        Loop.of("1/s")
    assert (told.value.argument, told.value.value) == ("loop", "1/s")
    assert told.value.bound == "must be a zoh.Plant or zoh.Sampled"
    assert told.value.way_out == "make one first"


def test_a_gain_beyond_floats_is_refused():
    loud = Plant(num=[1e300], den=[1.0, 1.0])
    with pytest.raises(SpecError) as told:
        Loop.of(loud, loud)
    assert (told.value.argument, told.value.value) == ("loop", [loud, loud])
    assert str(out_of_range(7)) == (
        "loop must have gains that a 64-bit float can hold, got 7: "
        "use other units for the signals or for time"
    )


def test_a_point_and_what_is_made_of_it():
    assert PLAIN.point(2.0) == (3 + 2j, 1 + 4j)
    assert PLAIN.excess(2.0) == pytest.approx(sqrt(13) - sqrt(17), rel=1e-14)
    assert PLAIN.side(2.0) == -10  # Im (3 + 2j)(1 - 4j)
    assert PLAIN.above(2.0, 0.25) == pytest.approx(sqrt(13) / 2, rel=1e-14)  # |4 + 6j| = 2 sqrt 13
    assert PLAIN.ratio(2.0, (1.0, 0.0)) == pytest.approx(sqrt(52 / 17), rel=1e-14)
    assert PLAIN.ratio(2.0, (0.0, 1.0)) == pytest.approx(2, rel=1e-14)
    assert PLAIN.ratio(2.0, (1.0, -1.0)) == pytest.approx(sqrt(52 / 8), rel=1e-14)
    assert PLAIN.ratio(2.0, (0.0, 0.0)) == inf
    assert scalar((1.0, 2.0, 5.0), 2.0) == 1 + 4j


def test_a_dead_time_turns_num_alone():
    top, bottom = LATE.point(2.0)
    assert top == pytest.approx(2 - 3j, rel=1e-14)  # (3 + 2j) (-j)
    assert bottom == 1 + 4j
    assert LATE.side(2.0) == pytest.approx(-11, rel=1e-14)  # Im (2 - 3j)(1 - 4j)
    assert LATE.excess(2.0) == PLAIN.excess(2.0)
    assert LATE.above(2.0, 1.0) == pytest.approx(sqrt(13) - sqrt(10), rel=1e-14)  # |3 + j|
    assert LATE.ratio(2.0, (1.0, 0.0)) == pytest.approx(sqrt(10 / 17), rel=1e-14)


def test_slopes_are_the_derivatives():
    # num' = j, den' = j (2 j v + 2)
    assert PLAIN.slopes(2.0) == (3 + 2j, 1 + 4j, 1j, -4 + 2j)
    top, bottom, dtop, dbottom = LATE.slopes(2.0)
    assert (top, dtop) == pytest.approx((2 - 3j, 1 - QUARTER * (3 + 2j)), rel=1e-14)
    assert (bottom, dbottom) == (1 + 4j, -4 + 2j)


def test_at_an_array_of_points_all_is_over_a_power_of_the_distance():
    top, bottom = LATE.parts(np.array([2.0, 0.0]))
    assert top == pytest.approx(np.array([(2 - 3j) / 5, 3.0]), rel=1e-14)
    assert bottom == pytest.approx(np.array([(1 + 4j) / 5, 5.0]), rel=1e-14)
    top, bottom = PLAIN.parts(np.array([2.0]))
    assert top == pytest.approx(np.array([(3 + 2j) / 5]), rel=1e-14)


def test_frequency_and_phase_lag_of_a_sampled_loop():
    # v = 4 tan(w/4): at v = 4 w is pi
    assert SAMPLED.frequency(4.0) == pytest.approx(pi, rel=1e-15)
    assert SAMPLED.frequency(inf) == pytest.approx(2 * pi, rel=1e-15)
    assert SAMPLED.psi(4.0) == pytest.approx(1.5 * pi, rel=1e-15)
    assert SAMPLED.psi_slope(4.0) == pytest.approx(0.75, rel=1e-15)
    assert SAMPLED.psi_slope(2.0) == pytest.approx(1.5 / 1.25, rel=1e-15)
    top, _ = SAMPLED.point(2.0)
    turned = (3 + 2j) * np.exp(-1.5j * 4 * atan(0.5))
    assert top == pytest.approx(turned, rel=1e-14)


def test_frequency_and_phase_lag_of_a_continuous_loop():
    assert (LATE.frequency(3.0), PLAIN.psi(3.0), PLAIN.psi_slope(3.0)) == (3.0, 0.0, 0.0)
    assert (LATE.psi(3.0), LATE.psi_slope(3.0)) == (3 * QUARTER, QUARTER)
    assert SAMPLED.closed() == (1.0, 3.0, 8.0)
    assert SAMPLED.closed(-1.0) == (1.0, 1.0, 2.0)


def late(num, den, samples):
    return Loop.of(Sampled.from_w(num_w=num, den_w=den, dt=0.5, delay=samples))


@pytest.mark.parametrize(
    ("loop", "ends"),
    [
        (Loop.of(Plant(num=[2.0, 3.0], den=[4.0, 5.0])), ((0.0, 3.0, 5.0), (inf, 2.0, 4.0))),
        # s (s + 3)/(s (s + 5)): what both share at 0 is left out; so is 0 s^2 of both
        (Loop.of(Plant(num=[2.0, 3.0, 0.0], den=[4.0, 5.0, 0.0])),
         ((0.0, 3.0, 5.0), (inf, 2.0, 4.0))),
        (Loop.of(Plant(num=[3.0], den=[4.0, 5.0, 0.0])), ((0.0, 3.0, 0.0), (inf, 0.0, 4.0))),
        (Loop.of(Plant(num=[3.0, 0.0], den=[4.0, 5.0])), ((0.0, 0.0, 5.0), (inf, 3.0, 4.0))),
        # a dead time turns what is left at infinity through -1 too
        (Loop.of(Plant(num=[2.0, 3.0], den=[-4.0, 5.0], dead_time=1.0)),
         ((0.0, 3.0, 5.0), (inf, -2.0, 4.0))),
        (Loop.of(Plant(num=[-2.0, 3.0], den=[4.0, 5.0], dead_time=1.0)),
         ((0.0, 3.0, 5.0), (inf, -2.0, 4.0))),
        (Loop.of(Plant(num=[3.0], den=[4.0, 5.0], dead_time=1.0)),
         ((0.0, 3.0, 5.0), (inf, 0.0, 4.0))),
        # z^-m is (-1)^m at z = -1
        (late((2.0, 3.0), (4.0, 5.0), 0), ((0.0, 3.0, 5.0), (inf, 2.0, 4.0))),
        (late((2.0, 3.0), (4.0, 5.0), 1), ((0.0, 3.0, 5.0), (inf, -2.0, 4.0))),
        (late((2.0, 3.0), (4.0, 5.0), 2), ((0.0, 3.0, 5.0), (inf, 2.0, 4.0))),
        (late((2.0, 3.0), (4.0, 5.0), 3), ((0.0, 3.0, 5.0), (inf, -2.0, 4.0))),
    ],
)  # fmt: skip
def test_the_ends_of_the_axis(loop, ends):
    found = loop.ends()
    assert [v for v, _, _ in found] == [0.0, inf]
    for (_, num, den), (_, wanted_num, wanted_den) in zip(found, ends, strict=True):
        assert (num, den) == pytest.approx((wanted_num, wanted_den), rel=1e-14)


def test_powers_that_neither_has_are_left_out_at_infinity():
    loop = Loop.of(Sampled.from_w(num_w=(0.0, 2.0, 3.0), den_w=(0.0, 4.0, 5.0), dt=0.5))
    assert loop.ends() == ((0.0, 3.0, 5.0), (inf, 2.0, 4.0))


def test_a_product_of_given_systems_is_given():
    """1.5 (1 + 2^-52)/(z - 0.5) leaves at -(1 + 2^-52), above 1: |L| is 1 nowhere, times 1, too."""
    above = Sampled(num=[1.5 * (1 + 2.0**-52)], den=[1, -0.5], dt=0.1)
    one, made = (Sampled(num=[1], den=[1], dt=0.1), Sampled.from_w(num_w=[1], den_w=[1], dt=0.1))
    found = measure_loop(Loop.of(above))
    assert found.gain_crossings == ()
    assert found.gain_margin == 1 / (1 + 2.0**-52)
    for loop in (Loop.of(above * one), Loop.of(one * above * one), Loop.of(above, one)):
        assert loop.given
        assert measure_loop(loop) == found
    assert not Loop.of(above * made).given
    assert (one * (above * made)).factors == (one, above, made)


def test_what_is_given_next_to_undamped_is_not_doubted():
    """A mode in z that has all its digits: no rounding is behind it, alone or in a product."""
    mode = Sampled(num=[2.0**-30], den=[1, -1.5, 1 - 2.0**-31], dt=0.1)
    one = Sampled(num=[1], den=[1], dt=0.1)
    for loop in (mode, mode * one):
        assert not [said for said in measure_loop(Loop.of(loop)).warnings if "in w" in said]


def test_systems_are_told_apart_by_how_many_they_are():
    one = Sampled(num=[0.5], den=[1.0, -0.5], dt=0.5)
    twin = Sampled(num=[0.5], den=[1.0, -0.5], dt=0.5)
    assert These((one,)) == These((one,))
    for other in (These(()), These((one, one)), These((twin,)), (one,)):
        assert These((one,)) != other
        assert other != These((one,))


@pytest.mark.parametrize("k", [1.0, 1e-150])
def test_what_is_shared_is_left_out_and_what_is_left_are_floats(k):
    """k (s^2 + 1)/((s + 1)(s^2 + 1)): k/(1 + 2j) at v = 2."""
    plain = Loop.of(Plant(num=[k, 0, k], den=[1, 1, 1, 1])).without_shared()
    top, bottom = plain.point(2.0)
    assert top / bottom == pytest.approx(k / (1 + 2j), rel=1e-15, abs=0)
    assert len(plain.den) == 2
    assert plain.without_shared() is None
