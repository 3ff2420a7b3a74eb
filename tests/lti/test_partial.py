"""Plant.residues is the sum of its partial fractions, exactly."""

from fractions import Fraction
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpc, mpf
from scipy import signal

from zoh.errors import SpecError
from zoh.lti.systems import Plant

sizes = st.floats(-3, 3).map(lambda x: 10.0**x)
signs = st.sampled_from([-1.0, 1.0])
reals = st.builds(lambda s, x: complex(s * x), signs, sizes)
complexes = st.builds(lambda s, x, y: complex(s * x, y), signs, sizes, sizes)


@st.composite
def expansions(draw):
    """Return (residues, poles), each pole once to three times, pairs listed pair by pair."""
    residues, poles = [], []
    for p in draw(st.lists(st.one_of(reals, complexes), min_size=1, max_size=4, unique=True)):
        for _ in range(draw(st.integers(1, 3))):
            r = draw(complexes if p.imag else reals)
            if p.imag:
                residues += [r, r.conjugate()]
                poles += [p, p.conjugate()]
            else:
                residues.append(r)
                poles.append(p)
    return residues, poles


def summed(residues, poles, direct, s):
    """Return the sum by its definition: the k-th mention of a pole has power k."""
    total = mpc(direct)
    for i, (r, p) in enumerate(zip(residues, poles, strict=True)):
        total += mpc(r) / (s - mpc(p)) ** (poles[: i + 1].count(p))
    return total


def value(a, s):
    return mp.polyval([mpf(str(c)) for c in reversed(a)], s, asc=True)


@given(expansions(), st.sampled_from([0.0, 2.5]), st.floats(0.01, 100))
def test_it_is_the_sum(expansion, direct, w):
    residues, poles = expansion
    plant = Plant.residues(residues=residues, poles=poles, direct=direct)
    num, den = plant.exact
    assert len(den) == len(poles) + 1
    with mp.workdps(130):
        s = mpc(0.7, w)
        bottom = value(den, s)
        truth = summed(residues, poles, direct, s) * bottom
        size = sum(abs(mpf(str(c))) * abs(s) ** k for k, c in enumerate(reversed(num)))
        assert abs(value(num, s) - truth) <= size * mpf(10) ** -100


def test_by_hand():
    # 1/s - 1/(s + 2) + 3/(s + 2)^2 = (5 s + 4)/(s (s + 2)^2)
    plant = Plant.residues(residues=[1, -1, 3], poles=[0, -2, -2])
    assert (plant.num, plant.den) == ((5.0, 4.0), (1.0, 4.0, 4.0, 0.0))
    # (1 - j)/(s - j) + (1 + j)/(s + j) = (2 s + 2)/(s^2 + 1), and 1 added
    plant = Plant.residues(residues=[1 - 1j, 1 + 1j], poles=[1j, -1j], direct=1)
    assert (plant.num, plant.den) == ((1.0, 2.0, 3.0), (1.0, 0.0, 1.0))


def test_what_cancels_leaves_no_dust():
    """1/3 - 1/3 is 0; 0.1 + 0.2 - 0.30000000000000004 is 0 in floats, but not in truth."""
    third = 1 / 3
    plant = Plant.residues(residues=[third, -third], poles=[-0.1, -0.7])
    assert len(plant.num) == 1
    assert plant.num == (pytest.approx(third * 0.6, rel=1e-15),)
    off = Plant.residues(residues=[0.1, 0.2, -(0.1 + 0.2)], poles=[-0.1, -0.7, -3])
    assert off.num[0] == float(Fraction(0.1) + Fraction(0.2) - Fraction(0.1 + 0.2)) != 0


@given(expansions())
def test_invres_is_of_the_same_mind(expansion):
    residues, poles = expansion
    plant = Plant.residues(residues=residues, poles=poles)
    order = sorted(range(len(poles)), key=lambda i: (poles[i].real, poles[i].imag, i))
    num, den = signal.invres([residues[i] for i in order], [poles[i] for i in order], [], tol=0)
    bottom = np.polyval(np.abs(plant.den), 1.3)
    # 1e-9: invres multiplies rounded polynomials of up to 24 factors
    assert np.polyval(den, 1.3j) == pytest.approx(np.polyval(plant.den, 1.3j), abs=1e-9 * bottom)
    top = sum(abs(r) for r in residues) * bottom * max(1, max(1 / abs(p) for p in poles)) ** 3
    assert np.polyval(num, 1.3j) == pytest.approx(np.polyval(plant.num, 1.3j), abs=1e-9 * top)


@pytest.mark.parametrize(
    ("num", "den"),
    [
        ([1.0, 3.0], [1.0, 3.0, 2.0]),
        ([2.3], [1.0, 0.7809, 0.0]),
        ([1.0], [1.0, 2.0, 5.0]),
        ([4.0, 1.0], np.poly([-1, -1, -3]).tolist()),
        ([1.0, 2.0, 3.0, 7.0], [1.0, 2.0, 2.0, 5.0]),
    ],
)
def test_what_residue_prints_is_the_plant_again(num, den):
    residues, poles, direct = signal.residue(num, den)
    plant = Plant.residues(residues=residues, poles=poles, direct=sum(direct))
    # 1e-7: residue finds a double pole to half the digits of a float
    assert plant.at(0.7) == pytest.approx(Plant(num=num, den=den).at(0.7), rel=1e-7)


def test_residues_that_are_conjugate_but_for_a_rounding_are_taken_for_such():
    near = Plant.residues(residues=[1 + 1j, 1 - 1.0000000000000002j], poles=[1j, -1j])
    assert near.num == pytest.approx((2.0, -2.0), rel=1e-15)


def test_dead_time_and_sensor_go_along():
    plant = Plant.residues(residues=[1], poles=[-1], dead_time=0.2, sensor=3.0)
    assert (plant.dead_time, plant.sensor) == (0.2, 3.0)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"residues": [1], "poles": [1j]}, "poles must come in conjugate pairs"),
        ({"residues": [1j, 1j], "poles": [1j, -1j]}, "residues must be conjugate"),
        ({"residues": [1j], "poles": [-1]}, "residues must be conjugate where the poles are"),
        ({"residues": [1, 2], "poles": [-1]}, r"residues must be as many as the poles \(1\)"),
        ({"residues": ["x"], "poles": [-1]}, r"residues\[0\] must be a number"),
        ({"residues": 1, "poles": [-1]}, "residues must be a list of numbers"),
        ({"residues": [nan], "poles": [-1]}, r"residues\[0\] must be finite"),
        ({"residues": [1], "poles": [inf]}, r"poles\[0\] must be finite"),
        ({"residues": [1], "poles": [-1], "direct": 1j}, "direct must be a real number"),
        ({"residues": [0], "poles": [-1]}, "num must not be all zeros"),
        ({"residues": [], "poles": []}, "num must not be all zeros"),
    ],
)
def test_what_is_no_expansion_is_refused(arguments, sentence):
    with pytest.raises(SpecError, match=sentence):
        Plant.residues(**arguments)


def test_symmetric_roots_leave_no_dust_either():
    """(s^2 - 0.01)(s^2 - 0.49)(s^2 - 9.61) has no odd power; 17 digits a root, 100 in a product."""
    poles = [0.1, 0.7, 3.1, -0.1, -0.7, -3.1]
    den = Plant.zpk(zeros=[], poles=poles, gain=1).den
    assert den[1::2] == (0.0, 0.0, 0.0)


def test_a_state_space_leaves_no_dust_either():
    # d + c b/(s + a) with c b = -d a: the numerator is d s
    plant = Plant.ss([[-0.3]], [0.3], [-1.0], 1.0)
    assert plant.num == (1.0, 0.0)
