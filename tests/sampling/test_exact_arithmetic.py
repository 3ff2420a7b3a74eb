"""The arithmetic behind the ways from s to z, in all of its digits and by hand."""

from decimal import Decimal, getcontext
from math import inf, sqrt

import pytest
from mpmath import mp, mpf

from zoh.errors import SpecError
from zoh.lti.digits import KEPT, exact, precision
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.algebra import Ring, from_power_sums, power_sums, solve
from zoh.sampling.convert import discretise, undiscretise
from zoh.sampling.differences import replaced, stretch, to_plant, trimmed
from zoh.sampling.distance import distance, newton_sizes
from zoh.sampling.logarithm import artanh_of_roots


def lag(num, pole, dt=1.0):
    return Sampled(num=num, den=[1, -pole], dt=dt)


# distance: errors over the size of what is wrong


@pytest.mark.parametrize(
    ("one", "other", "gap"),
    [
        (lag([4], 0.5), lag([5], 0.5), 0.25),
        # z - 4 and z - 8: with the first coefficient the same, the last is off by 4/4. In w they
        # are (5 w - 6)/2 and (9 w - 14)/2, off by |14 5/9 - 6|/6 = 8/27, and the gain by 4/9
        (lag([1], 4), lag([1], 8), 1.0),
        # a pole at z = -1 has no leading coefficient in w, one at z = 1 no last one
        (lag([1], -1), lag([1], -1), 0.0),
        (lag([1], -1), lag([1.5], -1), 0.5),
        (lag([1], 1), lag([1], -1), inf),
        (lag([1], -1), lag([1], 1), inf),
    ],
)
def test_the_distance_by_hand(one, other, gap):
    assert distance(one, other) == pytest.approx(gap, rel=1e-15)


@pytest.mark.parametrize("gain", [1, 4, 0.25])
def test_beside_a_zero_by_structure_only_rounding_is_allowed(gain):
    # z - 1 is w (1 + ...), without a last coefficient; z - 1 + e has e, beside the 1 of w
    at_rest = lag([gain, -gain], 0.5)

    def moved(e):
        return distance(at_rest, lag([gain, gain * (e - 1)], 0.5))

    assert moved(2.0**-46) == inf
    assert moved(2.0**-48) < 1e-14
    assert moved(2.0**-50) < 1e-14


@pytest.mark.parametrize(
    ("a", "sizes"),
    [
        ([0, 1, 2, 8], [0, 1, sqrt(8), 8]),  # 2 is below the line from 1 to 8
        ([0, 1, 4, 8], [0, 1, 4, 8]),  # 4 is above it
        ([1, 0, 2, 4], [1, 4 ** (1 / 3), 4 ** (2 / 3), 4]),
        ([1, 0, 4, 2], [1, 2, 4, 2]),
        ([4, 1, -4, 0], [4, 4, 4, 0]),
        ([0, 3, 0], [0, 3, 0]),
        ([16, 2, 1, 2, 1], [16, 8, 4, 2, 1]),
    ],
)
def test_newtons_polygon_by_hand(a, sizes):
    assert newton_sizes(a) == pytest.approx(sizes, rel=1e-15)


# differences


@pytest.mark.parametrize(("prewarp", "dt"), [(1.3, 0.1), (3.0, 1.0), (1e-9, 1e-3), (31.0, 0.1)])
def test_the_stretch_has_all_the_digits_that_are_kept(prewarp, dt):
    got = stretch(prewarp, dt)
    with mp.workdps(KEPT + 60):
        x = mpf(prewarp) * mpf(dt) / 2
        assert abs(mpf(str(got)) / (x * mp.cot(x)) - 1) < mpf(10) ** (1 - KEPT)
    assert len(got.as_tuple().digits) <= KEPT


def test_a_difference_rule_that_leaves_the_floats_says_so():
    # 1e300/(s + 1) forward: in w the numerator is 1e300 (1 - w dt/2), 5e309 at dt = 1e10
    with pytest.raises(SpecError) as refused:
        discretise(Plant(num=[1e300], den=[1, 1]), 1e10, "forward")
    assert str(refused.value) == (
        "dt must keep the sampled system within a float's range, got 10000000000.0: "
        "sample faster: a coefficient outgrows 1e308"
    )


def test_the_rule_backwards_is_the_rule_to_its_last_digit():
    # w = s/(a - (2 theta - 1) s dt/2), by hand at theta = 1, dt = 2: w = s/(a - s), so 1/(w + 3)
    # is (a - s)/((a - s) 3 + s)
    a = Decimal("1." + "0" * 80 + "7")
    one, three = Decimal(1), Decimal(3)
    plant = to_plant((Decimal(0), one), (one, three), 2.0, theta=one, a=a)
    with precision(KEPT):
        assert plant.exact == ((-one, a), (one - three, 3 * a))


def test_leading_zeros_go_and_no_others():
    assert trimmed(exact([0.0, 0.0, 2.0, 0.0])) == exact([2.0, 0.0])
    assert trimmed(exact([1.0, 0.0])) == exact([1.0, 0.0])


def test_a_polynomial_of_higher_degree_than_its_own_gets_the_rest_below():
    # 1 and x - 3 at (x + 1)/(x - 2), times (x - 2)^2
    top, bottom = exact([1.0, 1.0]), exact([1.0, -2.0])
    assert replaced(exact([1.0]), top, bottom, 2) == exact([1.0, -4.0, 4.0])
    assert replaced(exact([1.0, -3.0]), top, bottom, 2) == exact([-2.0, 11.0, -14.0])


# algebra: roots 2, 3 and 5 are those of x^3 - 10 x^2 + 31 x - 30


def test_power_sums_there_and_back():
    monic = exact([1.0, -10.0, 31.0, -30.0])
    sums = power_sums(monic, 6)
    assert [int(s) for s in sums] == [2**k + 3**k + 5**k for k in range(6)]
    assert from_power_sums(sums[1:4]) == monic


def test_elimination_takes_the_largest_pivot():
    # with 1e-40 as the pivot forty digits of the second row would go
    tiny, one, two = Decimal("1e-40"), Decimal(1), Decimal(2)
    with precision(30):
        assert solve([[tiny, one], [one, one]], [one, two]) == [one, one]
    three = solve([exact(r) for r in ([0, 2, 1], [1, 0, 0], [3, 0, -2])], exact([7, 1, -3]))
    assert three == list(exact([1, 2, 3]))


def test_a_singular_matrix_has_no_solution():
    with pytest.raises(ZeroDivisionError):
        solve([exact([1, 2]), exact([2, 4])], exact([1, 2]))


def test_the_ring_is_arithmetic_at_every_root_at_once():
    ring = Ring.of(exact([1.0, -10.0, 31.0, -30.0]))
    u = ring.times_u(ring.constant(Decimal(1)))
    with precision(50):
        square, inverse = ring.product(u, u), ring.inverse(u)
        sums = power_sums(exact([1.0, -10.0, 31.0, -30.0]), 3)
        assert ring.trace(square, sums) == 4 + 9 + 25
        assert float(ring.trace(inverse, sums)) == 31 / 30  # 1/2 + 1/3 + 1/5
        assert getcontext().prec == 50
    assert ring.product(u, square) == list(exact([30.0, -31.0, 10.0]))


# rounding: the forms are scaled to a leading 1


@pytest.mark.parametrize("method", ["foh", "impulse", "matched"])
@pytest.mark.parametrize("den", [[2, 2], [3, 0], [1, 2, 5]])
def test_the_leading_coefficient_in_w_is_one(method, den):
    assert discretise(Plant(num=[1], den=den), 0.3, method).den_w[0] == 1.0


def test_a_plant_that_comes_back_is_the_plainest():
    # the zeros at infinity of 1/(s + 1)^3 come back as zeros, far out, of rounded coefficients
    # whatever the unit of time
    for slow in (1.0, 1e4, 1e8, 1e-4):
        for share in (1.0, 0.3, 1e-2, 1e-4):
            cube = Plant(num=[1], den=[slow**3, 3 * slow**2, 3 * slow, 1])
            assert len(undiscretise(discretise(cube, share * slow, "zoh"), "zoh").num) == 1


def test_a_small_leading_coefficient_that_is_none_of_rounding_is_kept():
    # a zero at -1e8: 1e-8 of the last coefficient, eight digits above rounding
    far = Plant(num=[1e-8, 1], den=[1, 3, 3, 1])
    got = undiscretise(discretise(far, 1.0, "zoh"), "zoh")
    assert got.num == pytest.approx(far.num, rel=1e-6)  # of those eight digits


def test_the_logarithm_of_one_is_zero():
    assert artanh_of_roots(exact([1.0, 0.0, 0.0])) == exact([1.0, 0.0, 0.0])
