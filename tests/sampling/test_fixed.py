"""The hold's whole numbers are off by no more than the bound that comes with them."""

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpc, mpf

from zoh.errors import SpecError
from zoh.lti.digits import from_roots
from zoh.lti.systems import Plant
from zoh.sampling.fixed import FixedRing, fixed, log2_above
from zoh.sampling.hold import sample
from zoh.sampling.response import FixedResponse, Scaled

sizes = st.floats(-3, 3).map(lambda x: 10.0**x)
reals = st.lists(st.sampled_from([0.0, 1.0, -1.0]), max_size=2)
pairs = st.lists(st.tuples(sizes, st.floats(-1, 1)), min_size=1, max_size=3)


def roots(signs, pairs, fastest):
    """Return real roots and conjugate pairs, none faster than ``fastest``."""
    found = [complex(fastest * s * 0.3) for s in signs]
    for size, turn in pairs:
        r = mp.expj(mp.pi * turn) * min(size, fastest)
        found += [complex(r), complex(r).conjugate()] if complex(r).imag else [complex(r)]
    return found


def truth_in_delta(zeros, poles, gain, dt, lead):
    """Return (num, den) in powers of z - 1, by the matrix exponential of the companion form."""
    num, den = ([mpf(str(c)) for c in from_roots(r)] for r in (zeros, poles))  # exact, 120 digits
    n = len(den) - 1
    num = [mpf(0)] * (n + 1 - len(num)) + [gain * c for c in num]
    a = mp.zeros(n + 1)  # the input is a state that never moves
    for i in range(n - 1):
        a[i, i + 1] = 1
    for i in range(n):
        a[n - 1, i] = -den[n - i]
    a[n - 1, n] = 1
    c = [num[n - i] - num[0] * den[n - i] for i in range(n)]

    def y(t):
        phi = mp.expm(a * t)
        return num[0] + sum(c[i] * phi[i, n] for i in range(n))

    h = [y(j * mpf(dt) + lead) for j in range(n + 1)]
    bottom = [mpf(1)]
    for p in poles:
        e = mp.exp(mpc(p) * mpf(dt)) - 1
        bottom = [x - e * w for x, w in zip([*bottom, 0], [0, *bottom], strict=True)]
    bottom = [mp.re(c) for c in bottom]
    differences = []
    while h:
        differences.append(h[0])
        h = [b - a for a, b in pairwise(h)]
    return [sum(bottom[j - i] * differences[i] for i in range(j + 1)) for j in range(n + 1)], bottom


@settings(max_examples=50)
@given(reals, pairs, pairs, sizes, st.sampled_from([0.0, 0.3, 0.99]), st.sampled_from([90, 300]))
def test_no_number_is_further_off_than_its_error(signs, pairs, zeros, dt, share, bits):
    poles = roots(signs, pairs, 5 / dt)
    zeros = roots([], zeros, 5 / dt)[: len(poles)]
    if sum(z.imag for z in zeros):
        zeros = zeros[:-1]
    plant = Plant.zpk(zeros=zeros, poles=poles, gain=2.0)
    lead = share * dt
    got = FixedResponse.of(Scaled.of(*plant.exact, 1.0, dt), bits).sampled(lead.as_integer_ratio())
    with mp.workdps(160):
        num, den = truth_in_delta(zeros, poles, mpf(2), dt, mpf(lead))
        n, unit = len(den) - 1, mpf(2) ** bits
        for j in range(n + 1):
            step = mpf(2) ** (got.scale * j)  # powers of delta 2^scale, monic
            assert abs(got.den[j] - den[j] * step * unit) <= got.den_error
            scaled = num[j] * step * unit / mpf(2) ** got.gain
            assert abs(got.num[j] - scaled) <= got.num_error


def test_the_errors_leave_most_bits():
    plant = Plant(num=[2.3], den=[1, 0.7809, 0])
    forms = FixedResponse.of(Scaled.of(*plant.exact, 1.0, 0.1), 100).sampled((0, 1)).forms()
    assert forms.lost_bits() < 30  # of 100, where 60 are asked to be sure
    assert forms.missing_bits() == 0


def test_missing_bits_are_counted():
    plant = Plant(num=[2.3], den=[1, 0.7809, 0])
    scaled = Scaled.of(*plant.exact, 1.0, 0.1)
    missing = FixedResponse.of(scaled, 60).sampled((0, 1)).forms().missing_bits()
    assert 0 < missing < 30
    assert FixedResponse.of(scaled, 60 + missing).sampled((0, 1)).forms().missing_bits() == 0


def test_a_double_integrator_has_a_zero_that_no_bits_show():
    plant = Plant(num=[1], den=[1, 0, 0])  # (z + 1) h^2/2 has a root at z = -1: w^2 falls out
    forms = FixedResponse.of(Scaled.of(*plant.exact, 1.0, 0.1), 200).sampled((0, 1)).forms()
    assert forms.missing_bits() is None
    assert sample(plant, 0.1).num_w[0] == 0.0


@given(st.integers(-(10**9), 10**9), st.integers(1, 10**9), st.integers(-40, 40))
def test_fixed_rounds_down(top, bottom, shift):
    value = fixed((top, bottom), shift)
    # in whole numbers: value <= top 2^shift/bottom < value + 1
    up, down = max(shift, 0), max(-shift, 0)
    assert value * bottom << down <= top << up < (value + 1) * bottom << down


@given(st.integers(1, 10**30), st.integers(1, 10**30))
def test_log2_above_is_above_by_two_at_most(top, bottom):
    above = log2_above((-top, bottom))
    with mp.workdps(40):
        assert above - 2 <= mp.log(mpf(top) / mpf(bottom), 2) <= above


def test_growth_of_a_first_order_mode():
    """Modulo sigma + 1/2 sigma is -1/2: (exp(-t/2) - 1)/(-1/2)."""
    ring = FixedRing(modulus=(1 << 79,), bits=80)
    for t, halvings, scale in (((1, 4), 0, 1), ((40, 1), 7, 0)):
        (value,), error = ring.growth(t, halvings, scale)
        with mp.workdps(40):
            truth = -2 * mp.expm1(-mpf(t[0]) / t[1] / 2) * 2**scale
            assert abs(value - truth * mpf(2) ** 80) <= error < 2**30


def test_refuses_a_mode_that_no_sample_time_can_follow():
    with pytest.raises(SpecError, match="fastest mode"):
        sample(Plant(num=[1], den=[1e-19, 1]), 1.0)
    fast = sample(Plant(num=[1], den=[1e-12, 1]), 1.0)
    assert fast.num == (1.0,)
    assert fast.den == (1.0, 0.0)


def test_the_same_question_is_answered_once():
    plant = Plant.parse("1/(s + 1/3)")
    first = sample(plant, 0.5)
    assert sample(Plant.parse("1/(s + 1/3)"), 0.5) is first


def test_plants_with_the_same_floats_are_not_taken_for_one():
    thirds = Plant.parse("1/(s + 1/3)")
    floats = Plant(num=thirds.num, den=thirds.den)
    assert thirds == floats  # by their floats
    dt = 40.0  # exp(-40/3): the third of 1/3 that a float lacks is multiplied by 40
    with mp.workdps(40):
        exact, near = mp.exp(-mpf(dt) / 3), mp.exp(-mpf(dt) * mpf(floats.den[1]))
    assert -sample(thirds, dt).den[1] == pytest.approx(float(exact), rel=1e-16)
    assert -sample(floats, dt).den[1] == pytest.approx(float(near), rel=1e-16)
    assert float(exact) != float(near)
