"""The hold's whole numbers and their bounds, worked by hand in so few bits that a hand can.

Four bits are sixteenths: 7 is 7/16, and every product is rounded down to the next sixteenth.
"""

import random
from decimal import Decimal

import pytest
from mpmath import mp, mpf

from zoh.errors import SpecError
from zoh.lti.systems import Plant
from zoh.sampling.delta import Forms, InDelta, from_power_sums, product
from zoh.sampling.fixed import FixedRing
from zoh.sampling.hold import _lead, sample, whole_samples
from zoh.sampling.response import FixedResponse, Scaled

# sigma^2 = -3/16 + 5/16 sigma, in sixteenths
RING = FixedRing(modulus=(3, -5), bits=4)


def test_products_in_the_ring():
    # sigma (7 + 10 sigma) = 7 sigma - (10 3 >> 4) - (10 (-5) >> 4) sigma
    assert RING.times_sigma([7, 10]) == [-1, 11]
    assert FixedRing(modulus=(), bits=4).times_sigma([]) == []
    assert RING.norm([7, -40]) == 3  # 47/16, and one for what was cut
    assert RING.rows([7, 10]) == [(7, -1), (10, 11)]
    assert RING.applied([(7, -1), (10, 11)], [16, 32]) == [5, 32]  # 80 >> 4, 512 >> 4


def test_the_error_of_a_product():
    # a column is off by 5 + 2 2 (1 + 3) = 21: 2 21 + 3 40 + (21 40 >> 4) + 2 + 1
    assert RING.product_error(3, 5, 2, 40) == 217


def test_a_doubling():
    # sigma a = -1 + 11 sigma, times a: -2 + 6 sigma; a (2 + sigma a) = 2 a + that. |a| <= 2, and
    # sigma a is off by 5 + 2 (1 + 2) = 11, a column by 11 + 4 3 = 23:
    # 2 23 + 2 5 + (23 5 >> 4) + 3 = 66, and twice the 5 of a
    assert RING._doubled([7, 10], 5) == ([12, 26], 76)


def test_a_doubling_that_outgrows_every_use():
    assert RING._doubled([1 << 4111 + 4, 0], 0)[0][0] == 2 << 4115  # |a| has 4 4 + 4096 bits
    with pytest.raises(OverflowError):
        RING._doubled([1 << 4112 + 4, 0], 0)


def test_powers_and_the_largest_of_them():
    assert RING.powers([7, 10], 5) == ([[7, 10], [-2, 6]], 2, 66)
    # sigma a = -1 + 44 sigma, its column -8 + 13 sigma; |a| <= 4, |a sigma a| <= 8
    # off by 5 + 2 (1 + 4) = 15, a column by 15 + 4 5 = 35: 4 35 + 4 5 + (35 5 >> 4) + 3
    assert RING.powers([40, 10], 5) == ([[40, 10], [-8, 118]], 8, 173)
    assert FixedRing(modulus=(), bits=4).powers([], 5) == ([], 1, 5)


def test_powers_of_three():
    # sigma^3 = 0: a = 16 + ..., E = sigma a moves everything up by one
    ring = FixedRing(modulus=(0, 0, 0), bits=4)
    found, size, error = ring.powers([16, 0, 0], 0)
    assert found == [[16, 0, 0], [0, 16, 0], [0, 0, 16]]
    # |a| <= 2; E is off by 3 3 = 9, its column by 9 + 9 3 = 36: 2 36 + 4 = 76, then
    # 72 + 2 76 + (36 76 >> 4) + 4
    assert (size, error) == (2, 399)
    # 2.5, 2.5^2 and 2.5^3: |a| <= 3, |a E| <= 7, |a E^2| <= 16. E is off by 12, its column by 48;
    # 3 48 + 4 = 148, then 7 48 + 3 148 + (48 148 >> 4) + 4
    found = [[40, 0, 0], [0, 100, 0], [0, 0, 250]]
    assert ring.powers([40, 0, 0], 0) == (found, 16, 1228)


GROWN = [
    # 1/2: the series 16, 16 8/16/2, 0 ... in units of 1/32, 5 terms; 8 (5 + 1)
    (RING, (1, 2), 0, 1, ([16, 4], 48)),
    # modulo sigma + 1/4 in 2^-8: 128, 32, 5 and seven terms; 32 - (5/4) = 31, 128 - (31/4) = 121
    (FixedRing(modulus=(64,), bits=8), (1, 2), 0, 0, ([121], 48)),
    # doubled: sigma a = -30, 2 121 - (30 121 >> 8). Off by 48 + 2, a column by 50 + 2:
    # 52 + 48 + (52 48 >> 8) + 2 = 111, and 2 48
    (FixedRing(modulus=(64,), bits=8), (1, 1), 1, 0, ([227], 207)),
    # as many terms as the ring has powers, even if fewer were enough; 10 (3 + 1)
    (FixedRing(modulus=(0, 0, 0), bits=4), (1, 16), 0, 0, ([1, 0, 0], 40)),
]


@pytest.mark.parametrize(("ring", "t", "halvings", "scale", "grown"), GROWN)
def test_the_growth_by_hand(ring, t, halvings, scale, grown):
    assert ring.growth(t, halvings, scale) == grown


# The response --------------------------------------------------------------------------------


def scaled(num, den, sensor=1.0, dt=0.1):
    return Scaled.of(*Plant(num=num, den=den).exact, sensor, dt)


def ratios(pairs):
    return [mpf(a) / b for a, b in pairs]


def test_the_units_of_a_plant():
    # 3 2/(4 s^2 + 8 s) = 1.5/(s^2 + 2 s): 2 2^-3 is below 1/2, 1.5 2^-6 below 2^-5
    got = scaled([2], [4, 8, 0], sensor=3.0)
    assert ratios(got.num) == [0, 0, 1.5]
    assert ratios(got.den) == [1, 2, 0]
    assert (got.rate, got.gain, got.dt) == (3, -5, 0.1)
    assert (got.late, got.moving, got.zeros_at_one) == (2, 1, 0)
    # the same with every sign turned
    turned = scaled([-2], [-4, -8, 0], sensor=3.0)
    assert (ratios(turned.num), ratios(turned.den)) == ([0, 0, 1.5], [1, 2, 0])
    assert all(b > 0 for _, b in (*turned.num, *turned.den))
    # s^2 (s + 0.25)/(s^3 (s + 8)): three zeros' worth of structure, one integrator left
    got = scaled([1, 0.25, 0, 0], [1, 8, 0, 0, 0])
    assert (got.late, got.moving) == (1, 1)
    assert got.zeros_at_one == 2
    assert scaled([1, 0, 0], [1, 8, 4]).zeros_at_one == 1  # of two at s = 0, the input takes one
    # 2^6/(s^2 + 2^10): 2^10 is below 2^11, whose root is below 2^6; and 2^6 below 2^7, 2^-14 of it
    got = scaled([64], [1, 0, 1024])
    assert (got.rate, got.gain) == (7, -7)
    # a gain has no mode: T is dt; and an integrator neither
    assert (scaled([3], [2], dt=0.1).rate, scaled([3], [2], dt=0.1).gain) == (3, 1)
    assert scaled([1], [1, 0], dt=8.0).rate == -4


def test_times_in_its_units():
    assert scaled([2], [4, 8, 0]).in_units((3, 4)) == (24, 4)  # rate 3
    assert scaled([1], [1, 0], dt=8.0).in_units((3, 4)) == (3, 64)  # rate -4


def test_how_often_dt_is_halved():
    # dt = 0.1 is below 2^-3; at a rate of 3 it is below 1, and one halving makes it 1/2 at most
    assert scaled([2], [4, 8, 0]).halvings() == 1
    assert scaled([2], [4, 8, 0], dt=0.8).halvings() == 4
    assert scaled([2], [4, 8, 0], dt=2.0**-9).halvings() == -4
    assert scaled([2], [4, 8, 0], dt=2.0**55).halvings() == 60
    with pytest.raises(SpecError) as refused:
        scaled([2], [4, 8, 0], dt=2.0**56).halvings()
    assert str(refused.value) == (
        "dt must not be as long against the plant's fastest mode, got '2^60 times its time "
        "constant': sample faster, or leave the fast mode out of the model"
    )


FIRST = [
    # 1.5/(s^2 + 2 s) at 0.1 s, one halving: 14 + 74; what is of order 1 is 3 - 1 = 2: slow
    # 2 0 - 1 = -1 (1) and 2 - 2 = 0; weak 4 - 1 = 3, and the gain -5; fast 3 1 + 2 max(0 - 1,
    # 0 - 1) + 3 (2 2^-4, rounded down) = 1
    (([2], [4, 8, 0]), {"sensor": 3.0}, 88 + 0 + 0 + 1),
    # the same at 2^-9 s: nothing is halved, and two lost to each of the four doublings; 3 - 0 = 3:
    # slow 3 - 2 = 1; weak 6 - 1 - 5 = 0
    (([2], [4, 8, 0]), {"sensor": 3.0, "dt": 2.0**-9}, 88 + 1 + 0 + 8),
    # 1/((s + 16)(s + 1/16)) at 4 s, 16.0625 below 2^5, so 2^6; ten halvings of 2^9; of
    # order 1 is 6 - 10 = -4. Slow max(-1, -4 - 6, -8 - 1) = -1; weak -8 - 1 - 11; fast
    # 3 10 + 2 max(0 - 1, 9 - 1) + 3 (16.0625 4, rounded down)
    (([1], [1, 16.0625, 1]), {"dt": 4.0}, 88 + 0 + 0 + 30 + 16 + 192),
    # (s + 2^-20)/(s^2 + 8 s + 4) at 0.1 s, 8 below 2^4: a rate of 5, three halvings, 5 - 3 = 2;
    # slow 4 - 3; weak 4 + 19 and the gain 1 - 5; fast 3 3 + 2 (2 - 1) + 3 (8 2^-4, rounded down)
    (([1, 2.0**-20], [1, 8, 4]), {}, 88 + 1 + 19 + 11),
    # 1/((s - 100)(s + 1)) at 1 s: a rate of 8, ten halvings; 8 - 10 = -2, so nothing is slow or
    # weak; fast 3 10 + 2 (9 - 1); it grows by 144 bits: (2 + 2)(144 + 5 2) + 2 144 + 10 10
    (([1], [1, -99, -100]), {"dt": 1.0}, 88 + 0 + 0 + 46 + 1004),
    # a gain: 74
    (([3], [2]), {}, 74),
]


@pytest.mark.parametrize(("plant", "more", "bits"), FIRST)
def test_the_bits_to_begin_with(plant, more, bits):
    assert scaled(*plant, **more).first_bits() == bits


def test_the_derivatives_and_the_sums_of_powers():
    # 1/((s + 1)(s + 2)) in sigma = s/8: poles -1/8 and -1/4, num 2^-6 in units of 2^-5
    got = FixedResponse.of(scaled([1], [1, 3, 2]), 10)
    assert got.ring == FixedRing(modulus=(32, 384), bits=10)
    assert (got.start, got.slopes) == (0, [0, 512])
    assert got.sums == [-384, 80]  # -3/8, 1/64 + 1/16
    assert got.error == 3 * (4 + 4 + 3)
    # (s^2 + s + 1)/((s + 1)(s + 2)): y(0+) = 1, y' = 1 - 3 = -2, y'' = 1 - 3 (-2) - 2 = 5
    got = FixedResponse.of(scaled([1, 1, 1], [1, 3, 2]), 10)
    assert got.plant.gain == 1  # above 1 by the bits of 1 itself
    assert (got.start, got.slopes) == (512, [-128, 40])  # over 2, 2 8 and 2 64


def test_the_response_later_by_hand():
    # in sixteenths: y = 3 + (8 7 - 4 10)/16, sigma (7 + 10 sigma) + 1 = 15 + 11 sigma for y', and
    # once more -2 + 19 sigma. That is off by 5 + 3 2 (2 + 2) = 29: 29 + 4 9 + (9 29 >> 4) + 2
    response = FixedResponse(plant=None, ring=RING, start=3, slopes=[8, -4], sums=[], error=9)
    assert response._at([7, 10], 5) == (4, [4, -6], 83)


def test_a_lag_held_in_twenty_bits():
    # 1/(s + 1) at 1/16 s: sigma = s/4, y in halves, delta in halves. The growth has 8 terms, 6 9
    # off; y and its sums 12; 54 + 12 + 2 = 68, the pole one more, and (1 + 2) 69 + 2
    response = FixedResponse.of(scaled([1], [1, 1], dt=1 / 16), 20)
    got = response.sampled((0, 1))
    assert (got.den_error, got.num_error) == (69, 209)
    assert (got.first, got.last, got.at_one) == (1, 1, 0)
    assert (got.scale, got.gain, got.bits) == (1, -1, 20)
    with mp.workdps(30):
        unit, e = mpf(2) ** 20, mp.exp(-mpf(1) / 16)
        assert abs(got.den[1] - 2 * (1 - e) * unit) <= 70
        assert abs(got.num[1] - 2 * (1 - e) * 2 * unit) <= 212
        assert (got.den[0], got.num[0]) == (1 << 20, 0)
    # 1/32 s later: 7 terms, 6 8 off; 48 + 2 (2 + 1) + 3 12 + 2 = 92; 54 + 92 + 2; 3 148 + 2
    late = response.sampled((1, 32))
    assert (late.den_error, late.num_error) == (69, 446)
    assert (late.first, late.last) == (0, 1)
    with mp.workdps(30):
        half = mp.exp(-mpf(1) / 32)
        assert abs(late.num[0] - 2 * (1 - half) * unit) <= 446
        assert abs(late.num[1] - 2 * ((half - e * half) + (1 - e) * (1 - half)) * 2 * unit) <= 446


def test_what_is_zero_by_structure():
    # s/(s (s + 2)^2) ... the zero at s = 0 stays at z = 1, the integrator's pole too; h_0 is 0,
    # but h_1 is not, however many poles there are more than zeros
    got = FixedResponse.of(scaled([1, 0], [1, 4, 4, 0]), 100).sampled((0, 1))
    assert got.den[3] == got.num[3] == 0
    assert (got.first, got.last, got.at_one) == (1, 2, 1)
    assert got.num[1] != 0
    assert len(got.num) == len(got.den) == 4


# Fractions in delta --------------------------------------------------------------------------


def test_a_polynomial_by_its_power_sums_and_its_error():
    # roots 1 and 2 in sixteenths, each sum off by 100: 100 + 2 = 102, 7 units at most, so that
    # 102 7 for each unit of the coefficients before the last, 1 and 3 and one for what was cut
    assert from_power_sums([3 << 4, 5 << 4], 100, 4) == ([16, -48, 32], 102 * 7 * 5)
    assert from_power_sums([3 << 4, 5 << 4], 1, 4) == ([16, -48, 32], 3 * 5)
    # 1, 2 and 3, off by 1: 1 + 3 for each of 1, 6 + 1 and 11 + 1
    sums = [6 << 4, 14 << 4, 36 << 4]
    assert from_power_sums(sums, 1, 4) == ([16, -96, 176, -96], 4 * 20)
    assert from_power_sums([], 7, 4) == ([16], 0)


@pytest.mark.parametrize("error", [0, 1, 40, 1 << 12])
def test_the_error_of_a_polynomial_holds_for_sums_off_by_as_much(error):
    """Roots -3 ... 5 in 4096ths, each sum off by ``error`` one way or the other; exact products."""
    rng, worst = random.Random(error), 0.0
    for _ in range(40):
        roots = [rng.randint(-3, 5) for _ in range(rng.randint(1, 6))]
        true = [1]
        for root in roots:
            true = [a - root * b for a, b in zip([*true, 0], [0, *true], strict=True)]
        sums = [
            (sum(r**k for r in roots) << 12) + rng.choice([-error, error])
            for k in range(1, len(roots) + 1)
        ]
        got, bound = from_power_sums(sums, error, 12)
        off = max(abs(a - (b << 12)) for a, b in zip(got, true, strict=True))
        assert off <= bound
        worst = max(worst, off / bound)
    assert worst > 1e-3 or not error  # a bound, and no more than one


def test_a_mode_that_grows_by_far_is_held_at_once_and_right():
    """Fifteen poles, one at +100/dt: what grows by e^100 and its powers, by partial fractions."""
    poles = [100.0] + [-(i + 1) * 100 / 15 for i in range(14)]
    plant = Plant.zpk(zeros=[], poles=poles, gain=1)
    unit = Scaled.of(*plant.exact, plant.sensor, 1.0)
    first = FixedResponse.of(unit, unit.first_bits()).sampled((0, 1)).forms()
    assert first.missing_bits() == 0
    got = sample(plant, 1.0)
    with mp.workdps(1500):
        at = [mpf(0), *map(mpf, poles)]
        shares = [1 / mp.fprod(p - q for q in at if q != p) for p in at]
        y = [sum(c * mp.exp(p * j) for c, p in zip(shares, at, strict=True)) for j in range(16)]
        den = [mpf(1)]
        for p in poles:
            den = [a - mp.exp(p) * b for a, b in zip([*den, 0], [0, *den], strict=True)]
        pulses = [b - a for a, b in zip([mpf(0), *y], y, strict=False)]
        num = [sum(den[i] * pulses[j - i] for i in range(j + 1)) for j in range(16)]
    assert got.den == pytest.approx([float(c) for c in den], rel=1e-15)
    assert got.num == pytest.approx([float(c) for c in num[1:]], rel=1e-15)


def test_only_what_grows_asks_for_more_bits_to_begin_with():
    unit = Scaled.of(*Plant.zpk(zeros=[], poles=[-1000, -3], gain=1).exact, 1.0, 1.0)
    assert unit._grown(unit.halvings()) == 0
    swings = Scaled.of(*Plant(num=[1], den=[1, -2e-3, 1000.0]).exact, 1.0, 1.0)
    assert swings._grown(swings.halvings()) == 0  # by e^0.001, which is no bit
    grows = Scaled.of(*Plant.zpk(zeros=[], poles=[100, -1], gain=1).exact, 1.0, 1.0)
    # 144.3 bits: (2 + 2)(144 + 5 2) + 2 144, and 10 for each halving
    assert grows._grown(9) == 4 * 154 + 2 * 144 + 90


def test_a_product_and_its_error():
    # (16 - 8 x)(4 + 16 x)/16 up to x; sizes 24 + 20 = 2 and some: (2 + 2) 40 + (3 40 2 >> 4) + 2
    assert product([16, -8], 3, [4, 16], 40, 4) == ([4, 14], 177)
    assert product([16, -8], 40, [4, 16], 3, 4) == ([4, 14], 177)


def test_a_fraction_in_z_and_in_p():
    # (3 + 5/d)/(1 + 7/d) in sixteenths with d = 2 (z - 1): 2 (z - 1) and 4 p/(1 - p)
    got = InDelta(
        num=[3, 5], den=[16, 7], num_error=2, den_error=3, first=1, last=1, at_one=0,
        scale=1, gain=9, bits=4,
    ).forms()  # fmt: skip
    # 2 z - 2 and 1; 4 p and 1 - p, in descending powers
    assert got.values == [[6, -1], [7, 5], [32, -25], [57, 7]]
    # of num only the last number is off: 0 1, -1 1; of den both: 2, 2 + 1; 4 + 1, 1
    assert got.errors == [[0, 2], [2, 2], [6, 9], [15, 3]]
    assert (got.bits, got.gain) == (5, 9)
    poles_at_one = InDelta(
        num=[3, 5], den=[16, 0], num_error=2, den_error=3, first=0, last=1, at_one=1,
        scale=0, gain=0, bits=4,
    ).forms()  # fmt: skip
    assert poles_at_one.errors[2] == [3, 3]  # z - 1 of the first alone


def forms(num_z=(1 << 70,), num_p=(1 << 70,), den_z=(1 << 70,), den_p=(1 << 70,), bits=70, gain=0,
          errors=(1, 1, 1, 1)):  # fmt: skip
    values = [list(v) for v in (num_z, num_p, den_z, den_p)]
    return Forms(
        values=values,
        errors=[[e] * len(v) for v, e in zip(values, errors, strict=True)],
        bits=bits,
        gain=gain,
    )


MISSING = [
    (forms(), 0),
    (forms(num_z=[1 << 60]), 0),  # sixty bits above an error of 1
    (forms(num_z=[(1 << 60) - 1]), 3),  # 60 + 2 + 1 - 60
    (forms(num_z=[-(1 << 60)], errors=(2, 1, 1, 1)), 3),  # 60 + 2 + 2 - 61
    (forms(den_p=[1 << 70, 9], errors=(1, 1, 1, 8)), 62),  # 60 + 2 + 4 - 4
    (forms(num_p=[9], den_p=[1 << 70, 16], errors=(1, 8, 1, 8)), 62),  # the larger of 62 and 61
    (forms(num_p=[16], den_p=[1 << 70, 9], errors=(1, 8, 1, 8)), 62),
    (forms(num_p=[8], errors=(1, 8, 1, 1)), None),
    (forms(num_p=[-9], errors=(1, 8, 1, 1)), 62),
    (forms(num_p=[0], errors=(1, 0, 1, 1)), 0),  # 0, and not a doubt
    (forms(num_p=[0]), None),
    (forms(den_p=[1 << 70, 0]), None),
    # 2^-1076 is 4 bits of 1080, with its error: 15 and 16; in p nothing is too small
    (forms(num_z=[7], errors=(8, 1, 1, 1), bits=1080), 0),
    (forms(num_z=[8], errors=(8, 1, 1, 1), bits=1080), None),
    (forms(den_z=[7], errors=(1, 1, 8, 1), bits=1080), 0),
    (forms(den_z=[8], errors=(1, 1, 8, 1), bits=1080), None),
    (forms(num_p=[7], errors=(1, 8, 1, 1), bits=1080), None),
    (forms(den_p=[7], errors=(1, 1, 1, 8), bits=1080), None),
    # the numerator is to be doubled: 3 bits; the denominator is not
    (forms(num_z=[7], errors=(8, 1, 1, 1), bits=1080, gain=1), None),
    (forms(num_z=[3], errors=(4, 1, 1, 1), bits=1080, gain=1), 0),
    (forms(den_z=[7], errors=(1, 1, 8, 1), bits=1080, gain=1), 0),
]


@pytest.mark.parametrize(("of", "missing"), MISSING)
def test_the_bits_that_are_missing(of, missing):
    assert of.missing_bits() == missing


def test_what_is_lost_and_what_is_cleared():
    of = forms(num_z=[3, -4, 5], num_p=[-5], errors=(4, 4, 9, 2))
    assert of.lost_bits() == 4
    cleared = of.cleared()
    assert cleared.values == [[0, 0, 5], [-5], [1 << 70], [1 << 70]]
    assert (cleared.errors, cleared.bits, cleared.gain) == (of.errors, of.bits, of.gain)


@pytest.mark.parametrize("gain", [-3, 0, 2])
def test_rounding_into_z_and_w(gain):
    # in sixteenths, (1/2 z + 1)/(z - 1/4), and in p (3/8 + 5/8 p)/(1/2 p + 3/16), w = 4 p
    of = forms(num_z=[8, 16], num_p=[10, 6], den_z=[16, -4], den_p=[8, 3], bits=4, gain=gain)
    got = of.rounded(0.5, 2)
    k = 2.0**gain
    assert (got.num, got.den) == ((k / 2, k), (1.0, -0.25, 0.0, 0.0))
    assert (got.num_w, got.den_w) == ((k * 10 / 8, k * 4 * 6 / 8), (1.0, 4 * 3 / 8))
    assert (got.dt, got.delay) == (0.5, 2)
    # a pole at z = -1 takes the first power away: 3/16 is then the first
    of = forms(num_z=[8, 16], num_p=[10, 6], den_z=[16, 16], den_p=[0, 3], bits=4, gain=gain)
    got = of.rounded(0.5, 0)
    assert (got.num_w, got.den_w) == ((k * 10 / 3 / 4, k * 2), (0.0, 1.0))


# The hold ------------------------------------------------------------------------------------


def test_the_time_left_in_the_last_sample():
    assert _lead(3, 0.5, 0.25, 0.375) == (3, 8)  # 1.125 - 0.75 s
    top, bottom = _lead(2, 0.1, 0.03, 0.1)  # of the floats, whose sum is not rounded
    with mp.workdps(40):
        assert mpf(top) / bottom == 2 * mpf(0.1) - mpf(0.1) - mpf(0.03)


def test_whole_samples_and_a_share():
    assert whole_samples(0.5, 0.25, 0.375) == (2, Decimal(0))
    assert whole_samples(0.5, 0.25, 0.5) == (2, Decimal("0.5"))
    assert whole_samples(0.0, 0.0, 0.5) == (0, Decimal(0))
    assert whole_samples(0.1 * 3, 0.0, 0.1) == (3, Decimal(0))
    m, share = whole_samples(0.1, 0.07, 0.125)
    with mp.workdps(60):
        assert m == 2
        assert abs(mpf(str(share)) - (2 - (mpf(0.1) + mpf(0.07)) / mpf(0.125))) < mpf(10) ** -50
    # eight units in the last place are rounding, nine are time
    near, far = 1 + 8 * 2.0**-52, 1 + 9 * 2.0**-52
    assert whole_samples(near, 0.0, 1.0) == (1, Decimal(0))
    assert whole_samples(far, 0.0, 1.0)[0] == 2
    assert whole_samples(10_000.0, 0.0, 1.0) == (10_000, Decimal(0))


REFUSED = [
    (
        lambda: sample(3, 0.1),
        "plant must be a zoh.Plant, got 3: sample a continuous plant",
    ),
    (
        lambda: sample(Plant(num=[1], den=[1, 1]), 0.1, -1.0),
        "compute_delay must be 0 or more, got -1.0: give seconds, 0 or more",
    ),
    (
        lambda: sample(Plant(num=[1], den=[1, 0, 0]), 1e-200),
        "dt must leave the sampled plant a gain that a float can hold, got 1e-200: sample more "
        "slowly, or count the output in a smaller unit",
    ),
    (
        lambda: sample(Plant(num=[1], den=[1, -1]), 1e3),
        "dt must keep the sampled plant within a float's range, got 1000.0: sample faster: an "
        "unstable mode outgrows 1e308 within one sample",
    ),
    (
        lambda: sample(Plant(num=[1], den=[1, 1], dead_time=2500.0), 0.25, 0.125),
        "dead_time + compute_delay must be at most 10000 samples (2500 s), got 2500.125: sample "
        "more slowly",
    ),
]


@pytest.mark.parametrize(("call", "text"), REFUSED)
def test_what_cannot_be_held_is_refused_to_the_word(call, text):
    with pytest.raises(SpecError) as refused:
        call()
    assert str(refused.value) == text


def turns(monkeypatch, plant, dt):
    """Return the bits of each turn that the hold of a plant takes."""
    seen, of = [], FixedResponse.of

    def counted(plant, bits):
        seen.append(bits)
        return of(plant, bits)

    monkeypatch.setattr(FixedResponse, "of", counted)
    sample(plant, dt)
    return seen


def test_the_first_bits_are_enough_for_an_everyday_plant(monkeypatch):
    assert len(turns(monkeypatch, Plant(num=[2.3], den=[1, 0.7809, 0]), 0.0917)) == 1


def test_a_zero_at_minus_1_takes_two_turns_more(monkeypatch):
    # 1/s^2: its w^2 falls out. One turn shows that nothing is known, one, with 256 bits and those
    # lost, that nothing is there
    first, second, *others = turns(monkeypatch, Plant(num=[1], den=[1, 0, 0]), 0.0917)
    assert others == []
    assert 256 < second - first < 256 + 60
