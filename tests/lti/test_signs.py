"""Signs and counts decide what floats cannot: against hand-made roots and mpmath."""

from collections import Counter
from fractions import Fraction
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, polyroots

from zoh.lti import divisors, signs, whole

SMALL = st.integers(-9, 9)
COEFFICIENTS = st.lists(SMALL, min_size=1, max_size=7).filter(lambda a: a[0] != 0)
ROOTS = st.lists(st.fractions(-4, 4, max_denominator=6).filter(bool), min_size=1, max_size=6)


def from_roots(roots):
    a = [1]
    for r in roots:
        a = whole.times(a, [r.denominator, -r.numerator])
    return a


@given(ROOTS)
def test_counts_are_those_of_the_roots_it_was_made_of(roots):
    a = from_roots(roots)
    positive = [r for r in roots if r > 0]
    assert signs.positive_roots(a) == len(set(positive))
    odd = sum(positive.count(r) % 2 for r in set(positive))
    assert signs.crossings(a) == odd
    most = signs.variations(a)
    assert most >= len(positive)
    assert (most - len(positive)) % 2 == 0


@given(COEFFICIENTS)
def test_counts_agree_with_roots_in_fifty_digits(a):
    if len(a) < 2:
        assert signs.positive_roots(a) == 0
        return
    with mp.workdps(50):
        square_free = divisors.repeated(whole.trim(a)) in ([1], [])
        if not square_free:
            return  # repeated roots: the test above, where they are known
        found = polyroots(whole.trim(a)[::-1], maxsteps=500, extraprec=400, asc=True)
        # 1e-20: real roots of small whole numbers are that real in 50 digits
        real = [r for r in found if abs(mp.im(r)) < mp.mpf(10) ** -20 and mp.re(r) > 0]
    assert signs.positive_roots(a) == len(real) == signs.crossings(a)


def test_counts_tell_two_roots_from_none_where_no_float_does():
    """(x - 1)^2 -+ 10^-40: roots at 1 +- 10^-20, or none."""
    tiny = 10**40
    two, none = [tiny, -2 * tiny, tiny - 1], [tiny, -2 * tiny, tiny + 1]
    assert (signs.positive_roots(two), signs.positive_roots(none)) == (2, 0)
    assert signs.positive(two, 1.0) is None
    assert signs.positive(none, 1.0) == "Descartes"
    assert signs.positive(none) == "halving"


@given(ROOTS, st.floats(0.0, 5.0))
def test_positive_is_said_of_what_has_no_positive_root_alone(roots, near):
    proved = signs.positive(from_roots(roots), near) is not None
    assert proved is all(r < 0 for r in roots)


@given(COEFFICIENTS, st.floats(0.01, 100))
def test_what_is_called_positive_is(a, near):
    if signs.positive(a, near):
        assert all(whole.at(a, x) > 0 for x in (0.001, 0.1, 0.5, near, 1.0, 2.0, 10.0, 1e3))


@pytest.mark.parametrize("near", [0.0, inf, 1e-300, 1e300])
def test_positive_takes_any_place_to_look_from(near):
    assert signs.positive((1, 2, 3), near) == "Descartes"
    assert signs.positive((3, -1, 3), near) in ("Descartes", "halving")


def test_positive_refuses_what_ends_below_zero():
    assert signs.positive((-1, 2, 3)) is None
    assert signs.positive((1, 2, -3)) is None
    assert signs.positive((0, 0)) is None


PARTS = st.lists(
    st.tuples(st.fractions(-3, 3, max_denominator=4), st.fractions(0, 3, max_denominator=4)),
    min_size=1, max_size=4,
)  # fmt: skip


@given(PARTS)
def test_hurwitz_is_a_matter_of_the_real_parts(parts):
    a = [Fraction(1)]
    for re, im in parts:  # s - re, or s^2 - 2 re s + re^2 + im^2
        factor = [1, -2 * re, re * re + im * im] if im else [1, -re]
        a = [
            sum(a[i] * factor[k - i] for i in range(len(a)) if 0 <= k - i < len(factor))
            for k in range(len(a) + len(factor) - 1)
        ]
    common = 1
    for c in a:
        common *= Fraction(c).denominator
    for sign in (1, -1):
        ints = [sign * int(c * common) for c in a]
        assert signs.hurwitz(ints) is all(re < 0 for re, _ in parts)


def test_hurwitz_of_constants_and_of_a_missing_power():
    assert signs.hurwitz([5])
    assert not signs.hurwitz([0])
    assert not signs.hurwitz([0, 1, 1])  # a root at infinity: z = -1
    assert not signs.hurwitz([1, 1, 0])


def test_repeated_is_what_the_derivative_shares():
    a = from_roots([Fraction(2)] * 3 + [Fraction(1)] + [Fraction(-1)] * 2)
    shared = divisors.repeated(a)
    assert shared == from_roots([Fraction(2)] * 2 + [Fraction(-1)])
    assert divisors.repeated([-c for c in a]) == shared
    assert divisors.repeated([-3 * c for c in from_roots([Fraction(1)] * 2)]) == [1, -1]
    assert divisors.repeated([1, -1]) == divisors.repeated([-1, 1]) == [1]


@pytest.mark.parametrize(
    ("a", "plainly"),
    [
        ((1, 2, 3), True),
        ((1, 0, 1, -1, 1), True),  # x^4 + x^2, and x^2 - x + 1 without roots: 1 < 4
        ((3, -3, 1), True),  # 9 < 12
        ((9, -6, 1), False),  # (3 x - 1)^2: 36 is not below 36
        ((1, -3, 3, -1, 1), False),  # -3 x^3 is below 0
        ((1, -3, 1), False),
        ((1, 0, 1), True),
        ((0, 1), True),
        ((5,), True),
        ((1, 0), False),
        ((1, 1, -1), False),
        ((1, -1), False),
        ((-1, 1), False),
        ((-1, 1, 1), False),
    ],
)
def test_what_is_seen_to_be_positive_at_a_glance(a, plainly):
    def turned(a):
        return [-c if (len(a) - i) % 2 == 0 else c for i, c in enumerate(a)]

    in_x = turned(whole.shifted(turned(a)))  # a(x - 1)
    assert whole.shifted(in_x) == list(a)
    assert signs._positive_beyond_one(in_x) is plainly


def test_a_pole_at_infinity_is_on_the_boundary_whatever_the_rest():
    assert not signs.hurwitz([0, -1, -2])  # -(w + 2), one root in the left half, one at infinity
    assert not signs.hurwitz([0, 1, 2])
    assert signs.hurwitz([-1, -2])


@pytest.mark.parametrize("a", [(-1, 3, 1), (1, 3, -1), (-1, 3, -1)])
def test_one_end_below_zero_is_enough_to_be_refused(a):
    assert signs.positive(a) is None
    assert signs.positive(a, 1.0) is None


@pytest.mark.parametrize("power", [0, 20, 31, 32, 33, 40, 300])
def test_positive_seen_from_near_and_from_far(power):
    """(100 (x - r)^2 + r^2)^2, and the same of 1/x: plain from x = r, not from far away."""
    r = 2**power
    one, other = (100, -200 * r, 101 * r * r), (100 * r * r, -200 * r, 101)
    assert signs.positive(whole.times(one, one), float(r)) == "Descartes"
    assert signs.positive(whole.times(other, other), 1 / r) == "Descartes"
    assert signs.positive(whole.times(one, one), 0.01 * r) == "halving"


@given(ROOTS, ROOTS, ROOTS)
def test_common_is_what_both_are_made_of(mine, its, shared):
    a, b = from_roots(mine + shared), from_roots(its + shared)
    both = sorted((Counter(mine + shared) & Counter(its + shared)).elements())
    assert divisors.common(a, b) == divisors.common([0, *b], [-c for c in a]) == from_roots(both)
    assert not divisors.share_nothing(a, b)  # it never says so of what shares something
    nothing = not set(mine) & set(its)
    assert divisors.share_nothing(from_roots(mine), from_roots(its)) is nothing


def test_nothing_is_shared_with_nothing():
    assert not divisors.share_nothing([0, 0], [1, 2])
    assert not divisors.share_nothing([1, 2], [0])
    prime = 2**61 - 1  # both leads are 0 modulo it: the look cannot tell
    assert not divisors.share_nothing([prime, 1], [2 * prime, 1])
    assert divisors.share_nothing([prime, 1], [2, 1])
    assert divisors.share_nothing([2], [3])


@given(ROOTS)
def test_roots_are_isolated_where_they_are(roots):
    found = signs.odd_roots(from_roots(roots))
    times = Counter(roots)
    true = sorted(r for r in times if r > 0 and times[r] % 2)
    assert len(found) == len(true)
    for q, r in zip(found, true, strict=True):
        assert abs(Fraction(*q) - r) <= r / 2**71


@pytest.mark.parametrize("apart", [20, 100, 700])
@pytest.mark.parametrize("high", [-300, 0, 300])
def test_roots_are_isolated_however_close_they_lie(apart, high):
    """Three single roots 2^-apart of themselves away, a double one and a pair between them."""
    unit, near = Fraction(2) ** high, Fraction(1, 2**apart)
    singles = [unit * (1 + i * near) for i in (-1, 0, 1)]
    a = from_roots([*singles, *[unit * (1 + near / 2)] * 2])
    middle = unit * (1 - near / 2)  # and (x - middle)^2 + (middle near/64)^2
    pair = [1, -2 * middle, middle**2 * (1 + near**2 / 4096)]
    common = pair[2].denominator
    a = whole.times(a, [int(c * common) for c in pair])
    assert (signs.positive_roots(a), signs.crossings(a)) == (4, 3)
    found = [Fraction(*q) for q in signs.odd_roots(a)]
    assert found == sorted(found)
    for q, r in zip(found, singles, strict=True):
        assert abs(q - r) <= r / 2**71
    if apart > 71:
        return  # the fractions have fewer digits than tell the roots apart
    assert len(set(found)) == 3


def test_bits_that_cancel_in_a_pivot_by_hand():
    """w^3 + a w^2 + b w + c has the pivot a b - c beside the terms a b."""
    lost: list[int] = []
    assert signs.hurwitz((1, 1 << 10, 1 << 10, (1 << 20) - 4), lost)  # 4 of 2^20: 3 bits of 21
    assert lost == [18, 0]
    lost.clear()
    assert not signs.hurwitz((1, 1 << 10, 1 << 10, (1 << 20) + 4), lost)
    assert lost == [18]
    lost.clear()
    assert signs.hurwitz((1, 3, 2), lost)  # nothing is a difference
    assert lost == [0]
