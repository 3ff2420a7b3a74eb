"""realised: a chain of sums whose transfer function is the system's, in fractions."""

from fractions import Fraction
from math import inf

import pytest

from zoh.analysis.realised import _spoilt, realised
from zoh.lti.systems import Sampled


# z = 1 + delta, worked by hand: num and den in delta, then num less its direct part times den
@pytest.mark.parametrize(
    ("num", "den", "wanted"),
    [
        # delta^2 + delta/2 + 1/4 under delta^2 + 5/2 delta + 7/4
        ([1.0, 0.5, 0.25], [1.0, -1.5, 0.75], ([0.5, 0.25], [2.0, 1.5], 1.0)),
        # twice the denominator, three times the numerator of that
        ([3.0, 1.5, 0.75], [2.0, -3.0, 1.5], ([0.5, 0.25], [3.0, 2.25], 1.5)),
        # delta^2 + delta/2 + 1/4 under 1/2 alone: what z says is nothing is exactly nothing
        ([0.5], [1.0, -1.5, 0.75], ([0.5, 0.25], [0.0, 0.5], 0.0)),
        # (1 + delta)^3 - 1/2 (1 + delta)^2 under 2 (1 + delta) + 1
        ([2.0, 1.0], [1.0, -0.5, 0.0, 0.25], ([2.5, 2.0, 0.75], [0.0, 2.0, 3.0], 0.0)),
        # double integrator, double pole at z = -1
        ([1.0], [1.0, -2.0, 1.0], ([0.0, 0.0], [0.0, 1.0], 0.0)),
        ([1.0], [1.0, 2.0, 1.0], ([4.0, 4.0], [0.0, 1.0], 0.0)),
        ([-2.5], [2.0], ([], [], -1.25)),
    ],
)
@pytest.mark.parametrize("dt", [2.0, 0.5, 0.125])
def test_in_delta_by_hand(num, den, wanted, dt):
    a, c, d = realised(Sampled(num=num, den=den, dt=dt))
    for got, truth in zip((a, c, [d]), (*wanted[:2], [wanted[2]]), strict=True):
        assert got == pytest.approx(truth, rel=1e-15, abs=0)


def test_a_delay_of_whole_samples_is_left_out():
    late = Sampled(num=[0.5], den=[1.0, -0.5, 0.0, 0.0], dt=1.0)
    assert realised(late) == ([0.5], [0.5], 0.0)


def transfer(parts, delta):
    """Return the chain's transfer function at a rational delta = z - 1, in fractions."""
    a, c, d = parts
    # x_0 = (e - a x)/delta, x_i = x_0/delta^i
    powers = [1 / Fraction(delta) ** (i + 1) for i in range(len(a))]
    e = 1 + sum(Fraction(x) * p for x, p in zip(a, powers, strict=True))
    return (sum(Fraction(x) * p for x, p in zip(c, powers, strict=True))) / e + Fraction(d)


@pytest.mark.parametrize("dt", [1e-5, 0.1, 3.0])
def test_the_transfer_function_is_that_of_the_w_form(dt):
    system = Sampled(num=[0.3, -0.1, 0.7], den=[1.1, -0.9, 0.2], dt=dt)
    for delta in (Fraction(1, 3), Fraction(-5, 7), Fraction(11)):
        w = 2 / Fraction(dt) * delta / (2 + delta)
        top, bottom = (
            sum(Fraction(x) * w**i for i, x in enumerate(reversed(part)))
            for part in (system.num_w, system.den_w)
        )
        got = transfer(realised(system), delta)
        assert float(got / (top / bottom)) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize(
    ("a", "wanted"),
    [
        # (z - 1)(z - 1/2): (1 + 3/2 + 1/2)/(1/2) = 6 at 1; at 1/2, as far from 1 as that, 12
        ([-1.5, 0.5], 12.0),
        # (z - 1)(z + 1): 2/2 at 1; 1/2 at -1, of a distance of 2
        ([0.0, -1.0], 1.0),
        # (z - 1/2)(z - 1/4): 15/8 over 1/4 over 1/2; what is nearer to 0 is not asked
        ([-0.75, 0.125], 15.0),
        ([0.25, 0.0], 0.0),
        ([1.0, 0.25], inf),  # twice -1/2: a double root moves by more than any number of them
    ],
)
def test_how_many_roundings_a_pole_is_moved_by_in_a_register(a, wanted):
    assert _spoilt(a) == pytest.approx(wanted, rel=1e-12)


def test_the_smallest_of_all_numbers():
    assert realised(Sampled(num=[5e-324], den=[1.0, -0.5], dt=2.0)) == ([0.5], [5e-324], 0.0)
