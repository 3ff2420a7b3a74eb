"""word_length: what half a quantum costs, by hand and by moving coefficients in 50 digits."""

from dataclasses import replace
from math import asin, degrees, inf, tan

import pytest
from mpmath import mp, mpf

from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.word_length import _holds, _point, rounded, sure_bits, word_length
from zoh.lti.systems import Sampled

INTEGRATOR = Sampled(num=[1.0], den=[1.0, -1.0], dt=1.0)


def law_of(num, den=(1.0,), dt=1.0):
    return Sampled(num=num, den=den, dt=dt)


def margins_of(law, plant=INTEGRATOR):
    return measure_loop(Loop.of(law, plant))


@pytest.mark.parametrize(
    ("part", "point"),
    [((1.0,), 1), ((0.5,), 0), ((0.75, -3.0, 0.0), 2), ((-4.0, 0.1), 3), ((0.2,), -2)],
)
def test_the_point_leaves_room_for_the_largest(part, point):
    assert _point(part) == point
    assert 2.0 ** (point - 1) <= max(abs(c) for c in part) < 2.0**point


def test_rounding_to_a_word():
    law = law_of([0.7, -0.3], [1.0, -0.9])
    # num below 1, den below 2: with 4 bits the quanta are 1/8 and 1/4, with 6 1/32 and 1/16
    assert (rounded(law, 4).num, rounded(law, 4).den) == ((0.75, -0.25), (1.0, -1.0))
    assert (rounded(law, 6).num, rounded(law, 6).den) == ((0.6875, -0.3125), (1.0, -0.875))
    assert rounded(law, 4).dt == law.dt


@pytest.mark.parametrize("k", [0.75, 0.3, 1.2])
@pytest.mark.parametrize("n", [2, 3, 10, 20])
def test_a_gain_around_an_integrator_by_hand(k, n):
    """k/(z - 1) crosses at 2 asin(k/2) and has L'/L on the way there at tan(wc/2).

    So the gain costs tan(wc/2)/k, and the 1 below it tan(wc/2); half of each quantum is added.
    """
    slope, point = tan(asin(k / 2)), 0 if k < 1 else 1
    point -= k < 0.5
    worst = degrees(slope * (2.0**point / k + 2.0))
    law = law_of([k])
    # 1e-5: the slope of L is taken by differences, to 1e-9 of itself
    for tol, bits in ((worst / 2**n * (1 + 1e-5), n), (worst / 2**n * (1 - 1e-5), n + 1)):
        assert sure_bits(INTEGRATOR, law, margins_of(law), tol) == bits


def test_no_word_is_shorter_than_a_sign_and_a_bit_nor_longer_than_a_float():
    law = law_of([0.75])
    assert sure_bits(INTEGRATOR, law, margins_of(law), 1e3) == 2
    assert sure_bits(INTEGRATOR, law, margins_of(law), 1e-300) > 53  # a bound, not a word
    assert sure_bits(INTEGRATOR, law, margins_of(law), 1e-320) == 53  # no number
    assert sure_bits(INTEGRATOR, law, margins_of(law), inf) == 2


def test_where_the_gain_is_flat_no_word_is_sure():
    one = law_of([1.0])
    anywhere = replace(margins_of(law_of([0.75])), crossover=1.0)
    assert sure_bits(one, one, anywhere, 0.1) == 53


def test_the_search_begins_above_the_bound():
    """3/4 and 0.98 of half a quantum of 12 bits: these cost all but as much as they can.

    The bound, which would have the 1 of den rounded as well, is 14 bits; that 13 would do, k lying
    near their grid, is luck.
    """
    k = 0.75 + 0.98 * 2.0**-12
    law = law_of([k])
    tol = degrees(tan(asin(k / 2)) / k) * 0.97 * 2.0**-12
    assert sure_bits(INTEGRATOR, law, margins_of(law), tol) == 14
    assert word_length(INTEGRATOR, law, margins_of(law), tol) == 14
    assert _holds(INTEGRATOR, law, margins_of(law), tol, 13)


@pytest.mark.parametrize("dt", [1.0, 0.1])
def test_the_cost_of_every_coefficient_is_what_moving_it_does(dt):
    """(0.7 z - 0.5)/(z - 0.2) before 1/(z - 1): each coefficient moved by 1e-20."""
    parts = ((0.7, -0.5), (1.0, -0.2))
    law, plant = law_of(*parts, dt), Sampled(num=[1.0], den=[1.0, -1.0], dt=dt)
    found = margins_of(law, plant)

    def margin(num, den):
        def gain(w):
            z = mp.expj(w * dt)
            return (num[0] * z + num[1]) / (den[0] * z + den[1]) / (z - 1)

        w = mp.findroot(lambda x: mp.log(abs(gain(x))), found.crossover)
        return mp.degrees(mp.arg(-gain(w)))

    with mp.workdps(50):
        exact = [[mpf(c) for c in part] for part in parts]
        start, step, worst = margin(*exact), mpf(10) ** -20, mpf(0)
        for which, point in ((0, 0), (1, 1)):  # num is below 1, den below 2
            for i in range(2):
                moved = [list(part) for part in exact]
                moved[which][i] += step
                worst += abs(margin(*moved) - start) / step * mpf(2) ** point
    for n in (5, 15):
        tol = float(worst) / 2**n
        # 1e-5: as above
        assert sure_bits(plant, law, found, tol * (1 + 1e-5)) == n
        assert sure_bits(plant, law, found, tol * (1 - 1e-5)) == n + 1


def test_a_coefficient_that_needs_few_bits_is_given_what_any_would_need():
    """0.5 is one bit and the sign; its neighbours are not, and a trimmed gain is one of them."""
    law = law_of([0.5])
    found = margins_of(law)
    assert word_length(INTEGRATOR, law, found, 0.125) == sure_bits(INTEGRATOR, law, found, 0.125)


def test_where_no_float_is_long_enough():
    """k (z - c)/(z (z - 1)^2), c = 1 - 2^-20 - 2^-53: in words that hold k the last bit is lost.

    That turns z - c, which is as long as 1 - c at the crossover, by 2^-53 2^20/2 or so.
    """
    k, c = 2.0**-20, 1 - 2.0**-20 - 2.0**-53
    law = law_of([k, -k * c], [1.0, 0.0])
    plant = Sampled(num=[1.0], den=[1.0, -2.0, 1.0], dt=1.0)
    found = margins_of(law, plant)
    turn = degrees(2.0**-34)
    assert word_length(plant, law, found, turn / 10) is None


def test_a_word_holds_where_the_loop_is_stable_and_its_margin_moves_by_less():
    law = law_of([0.5])
    found = margins_of(law)
    assert _holds(INTEGRATOR, law, found, 1e-9, 8)
    assert not _holds(INTEGRATOR, law, found, 0.0, 8)  # it moves by 0, and that is not less
    away = replace(found, phase_margin_deg=found.phase_margin_deg + 1.0)
    for tol, holds in ((1.001, True), (0.999, False)):
        assert _holds(INTEGRATOR, law, away, tol, 8) is holds
        away = replace(found, phase_margin_deg=found.phase_margin_deg - 1.0)
    too_much = law_of([2.5])  # its pole is at z = -1.5
    assert not _holds(INTEGRATOR, too_much, margins_of(too_much), 1e-9, 8)


def test_the_word_given_is_the_first_sure_one_that_holds():
    law = law_of([0.3, -0.29], [1.0, -0.98])
    found = margins_of(law)
    bits = word_length(INTEGRATOR, law, found, 0.5)
    sure = sure_bits(INTEGRATOR, law, found, 0.5)
    assert bits >= sure
    assert _holds(INTEGRATOR, law, found, 0.5, bits)
    assert not any(_holds(INTEGRATOR, law, found, 0.5, b) for b in range(sure, bits))
