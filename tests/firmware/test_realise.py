"""A controller taken apart, against itself put together again by hand or in fractions."""

from fractions import Fraction as F

import pytest
from designs import LAWS, design

import zoh
from zoh.firmware.factors import product
from zoh.firmware.levels import levelled
from zoh.firmware.realise import Filter, from_d, in_d, parallel, sections
from zoh.lti.systems import Sampled


def together(parts):
    num, den = (F(1),), (F(1),)
    for part in parts:
        num = product(num, part.b[: part.order + 1])
        den = product(den, (F(1), *part.a[: part.order]))
    return num, den


def at(num, den, d):
    def value(a):
        total = F(0)
        for c in a:
            total = total * d + c
        return total

    return value(num) / value(den)


def test_a_pid_by_hand():
    # 2 + 0.5/(z-1) + 3 (z-1)/(z-0.75): over (z-1)(z-0.75) it is
    # 2 (z-1)(z-0.75) + 0.5 (z-0.75) + 3 (z-1)^2 = 5 z^2 - 9 z + 4.125
    law = parallel(Sampled(num=[5.0, -9.0, 4.125], den=[1.0, -1.75, 0.75], dt=1.0))
    assert law.kp == 2
    assert law.ki == F(1, 2)
    assert law.filters == (Filter(kd=F(3), alpha=F(1, 4)),)


def test_two_filters_by_hand():
    # 1 + 2 (z-1)/(z-0.5) - 0.5 (z-1)/(z-0.75) over (z-0.5)(z-0.75) = z^2 - 1.25 z + 0.375
    # z^2 - 1.25 z + 0.375 + 2 (z^2 - 1.75 z + 0.75) - 0.5 (z^2 - 1.5 z + 0.5)
    law = parallel(Sampled(num=[2.5, -4.0, 1.625], den=[1.0, -1.25, 0.375], dt=1.0))
    assert law.kp == 1
    assert law.ki == 0
    assert {(f.kd, f.alpha) for f in law.filters} == {(F(2), F(1, 2)), (F(-1, 2), F(1, 4))}


@pytest.mark.parametrize(
    "den",
    [
        [1.0, -1.0, 0.5],  # complex poles
        [1.0, -2.0, 1.0],  # two integrators
        [1.0, 1.5],  # outside the unit circle
        [1.0, -1.2, 0.36],  # a double pole
        [1.0, -1.5, 0.6, -0.05],  # three poles
    ],
)
def test_what_is_no_sum_of_parts_is_none(den):
    assert parallel(Sampled(num=[1.0, 0.1], den=den, dt=1.0)) is None


@pytest.mark.parametrize("law", LAWS)
def test_sections_multiply_to_the_controller(law):
    controller = design(law).controller
    num, den = in_d(controller)
    made = together(sections(controller))
    for d in (F(1, 3), F(-1, 7), F(5, 2), F(-9, 4)):
        # roots of a cubic or more are floats; a parabola and a line are their own factors
        tolerance = 1e-12 if len(den) > 4 else 0
        assert abs(at(*made, d) / at(num, den, d) - 1) <= tolerance


def test_an_integrator_is_in_the_last_section_exactly():
    made = sections(design("notched").controller)
    assert len(made) == 2
    assert made[-1].a[1] == 0
    assert made[0].a[1] != 0


def test_one_more_zero_goes_to_the_section_that_can_take_it():
    # three poles, three zeros: a pair for the pair, a single one for the single one
    law = Sampled(num=[1.0, 0.2, 0.3, 0.1], den=[1.0, -0.9, 0.5, -0.1], dt=1.0)
    made = sections(law)
    assert sorted(s.order for s in made) == [1, 2]
    num, den = together(made)
    assert abs(at(num, den, F(1, 3)) / at(*in_d(law), F(1, 3)) - 1) < 1e-12


def test_in_d_is_exact_and_comes_back():
    # (z - 0.5)/(z - 1) = (d + 0.5)/d
    controller = Sampled(num=[1.0, -0.5], den=[1.0, -1.0], dt=0.25)
    assert in_d(controller) == ((F(1), F(1, 2)), (F(1), F(0)))
    back = from_d((F(1), F(1, 2)), (F(1), F(0)), 0.25)
    assert back.num == controller.num
    assert back.den == controller.den


def test_a_delay_is_poles_at_the_origin():
    # 1/(z^2 (z - 0.5)): in d = z - 1 the poles are at -1, -1 and -0.5
    _, den = in_d(Sampled(num=[1.0], den=[1.0, -0.5, 0.0, 0.0], dt=1.0))
    assert den == product(product((F(1), F(1)), (F(1), F(1))), (F(1), F(1, 2)))


@pytest.mark.parametrize(
    "den",
    [
        [1.0, -0.5, 0.0, 0.0, 0.0],  # a lag and three samples of delay
        [1.0, -1.5, 0.5, 0.0, 0.0],  # an integral, a lag and two of delay
        [1.0, 0.0, -1.0, 0.0],  # Tustin's integral twice over its zero, and a delay
        [1.0, -0.25, -1.25, 0.5, 0.0],  # z = -1 beside two others that no float holds
    ],
)
def test_poles_at_the_origin_and_at_nyquist_are_exact(den):
    law = Sampled(num=[1.0, 0.25], den=den, dt=1.0)
    made, truth = together(sections(law)), in_d(law)
    for d in (F(1, 3), F(-3, 7), F(5, 2)):
        assert at(*made, d) == at(*truth, d)


def test_levelled_sections_are_the_same_controller_and_do_not_amplify():
    controller = zoh.Sampled(
        num=[4.0, -6.0, 2.5, 0.1], den=[1.0, -2.4, 2.0, -0.58], dt=1.0
    )  # a slow pair of poles before the last section
    made = sections(controller)
    level = levelled(made)
    assert at(*together(level), F(2, 3)) == at(*together(made), F(2, 3))
    first = from_d(*together(level[:1]), 1.0)
    peak = max(abs(first.at(w)) for w in (1e-6, *(k * 0.01 for k in range(1, 315))))
    assert 0.1 < peak <= 0.5


def test_too_many_sections_are_refused():
    many = Sampled(num=[1.0], den=[1.0, *[0.01] * 26], dt=0.1)
    with pytest.raises(zoh.SpecError, match="order must be 24 or lower, got 26"):
        sections(many)
