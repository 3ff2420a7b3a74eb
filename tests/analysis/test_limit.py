"""On the limit of stability and one rounding beside it: truth by hand, in fractions."""

from fractions import Fraction
from math import inf, nextafter

import numpy as np
import pytest

from zoh.analysis.limit import _beyond_doubt, late, says_on_the_limit, settled
from zoh.analysis.loop import Loop
from zoh.analysis.margins import margins, measure_loop
from zoh.analysis.nyquist import closed_loop_stable
from zoh.analysis.responses import noise_gains, response
from zoh.analysis.rest import gains_at_rest
from zoh.analysis.stability import decided, surely, surely_stable
from zoh.analysis.verify import measure, verify
from zoh.batch.reason import Reason
from zoh.batch.sweep import sweep
from zoh.errors import AccuracyWarning, NotMet, SpecError
from zoh.lti import whole
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

pytestmark = pytest.mark.filterwarnings("ignore::zoh.errors.AccuracyWarning")


def p(gain, dt):
    return Sampled(num=[gain], den=[1.0], dt=dt)


AT_ONE = [  # C P(0) = -1
    ([-1.0], [1.0, 5.0], 5.0),
    ([1.0], [1.0, -3.0], 3.0),
    ([1.0], [1.0, -7.0], 7.0),
    ([1.0, 2.0], [1.0, -3.0], 1.5),
    ([1.0], [1.0, 0.0, -25.0], 25.0),
    ([-1.0], [1.0, 6.0, 11.0, 6.0], 6.0),
]


@pytest.mark.parametrize(("num", "den", "gain"), AT_ONE)
@pytest.mark.parametrize("dt", [0.001, 0.01, 0.3])
@pytest.mark.parametrize("samples", [0.0, 0.3, 2.0, 12.0])
def test_a_pole_at_one_is_proved(num, den, gain, dt, samples):
    assert Fraction(gain) * Fraction(num[-1]) == -Fraction(den[-1])
    plant, controller, delay = Plant(num=num, den=den), p(gain, dt), samples * dt
    found = measure(plant, controller, compute_delay=delay)
    assert found.margins.stable is False
    assert found.margins.certificate.stable.holds
    assert found.step is None
    assert gains_at_rest(plant, controller)[:2] == (inf, inf)
    with pytest.raises(NotMet, match="the closed loop is unstable"):
        verify(plant, controller, compute_delay=delay)
    with pytest.raises(SpecError, match="must make the closed loop stable"):
        noise_gains(plant, controller, compute_delay=delay)


@pytest.mark.parametrize(("num", "den", "gain"), AT_ONE[:4])
@pytest.mark.parametrize("dt", [0.001, 0.01, 0.1])
def test_one_unit_of_the_gain_from_a_pole_at_one(num, den, gain, dt):
    """First order, so that one pole passes z = 1: from inside where the gain grows, if P < 0."""
    plant = Plant(num=num, den=den)
    for other in (nextafter(gain, 0.0), nextafter(gain, inf)):
        stable = (other < gain) == (den[-1] > 0)
        found = margins(p(other, dt) * sample(plant, dt))
        assert found.stable is stable
        assert found.certificate.stable.holds
        assert surely_stable(Loop.of(p(other, dt), sample(plant, dt))) is stable


def pair(gain, a=2.0, dt=0.2):
    """k s/(s + a) one sample late: chi = z^2 - (e + k) z + k, e = exp(-a dt): |z|^2 = k."""
    return Plant(num=[1.0, 0.0], den=[1.0, a]), p(-gain, dt), dt


@pytest.mark.parametrize("a", [0.1, 1.0, 2.0, 7.7])
@pytest.mark.parametrize("dt", [0.001, 0.1, 0.2])
def test_a_pair_on_the_circle_is_not_proved(a, dt):
    plant, controller, delay = pair(1.0, a, dt)
    with pytest.warns(AccuracyWarning, match="on the limit of stability to 7. digits: a pole is"):
        found = measure(plant, controller, compute_delay=delay)
    assert found.margins.stable is None
    assert says_on_the_limit(found.margins.certificate.stable)
    assert found.step is None
    assert found.margins.warnings[1] == "not proved to be complete: stable"
    with pytest.raises(NotMet, match="not proved to be stable"):
        verify(plant, controller, compute_delay=delay)
    with pytest.raises(SpecError, match="must make the closed loop stable"):
        noise_gains(plant, controller, compute_delay=delay)
    swept = sweep(plant, "given", controller=controller, over={"compute_delay": [delay]})
    assert int(swept["reason"][0]) == Reason.NOT_PROVED


@pytest.mark.parametrize("away", [2.0**-53, 1e-12, 1e-6])
@pytest.mark.parametrize("dt", [0.001, 0.1, 0.2])
def test_a_pair_next_to_the_circle_is_decided(away, dt):
    for gain in (1 - away, 1 + max(away, 2.0**-52)):
        plant, controller, delay = pair(gain, 2.0, dt)
        found = margins(controller * sample(plant, dt, delay))
        assert found.stable is (gain < 1)
        assert found.certificate.stable.holds


def test_next_to_the_limit_a_loop_is_verified():
    plant, controller, delay = pair(1 - 1e-9)
    assert verify(plant, controller, compute_delay=delay).margins.stable
    with pytest.raises(NotMet, match="the closed loop is unstable"):
        verify(plant, p(-(1 + 1e-9), 0.2), compute_delay=delay)


@pytest.mark.parametrize("dt", [0.5, 0.25])
def test_a_pole_at_minus_one(dt):
    """K/s: z - 1 + K dt is 0 at z = -1 where K = 2/dt."""
    plant, limit = sample(Plant(num=[1.0], den=[1.0, 0.0]), dt), 2 / dt
    assert margins(p(limit, dt) * plant).stable is not True
    assert margins(p(nextafter(limit, 0), dt) * plant).stable is True
    assert margins(p(nextafter(limit, inf), dt) * plant).stable is False


def test_what_is_given_is_meant_and_what_a_loop_hides_decides():
    given = Loop.of(Sampled(num=[-1.0], den=[1.0, 0.0], dt=1.0))  # z - 1
    assert settled(given) == surely(given) == decided(given)
    assert settled(given)[0] is False
    hiding = sample(Plant.parse("(s^2+4)/((s^2+4)(s+3))"), 0.01)
    for gain in (3.0, -3.0):  # a hidden pair on the circle, beside it a pole inside or at z = 1
        assert settled(Loop.of(p(gain, 0.01), hiding))[0] is False
    damped = sample(Plant.parse("(s+1)/((s+1)(s-3))"), 0.01)
    assert settled(Loop.of(p(3.0, 0.01), damped))[0] is False
    assert settled(Loop.of(p(nextafter(3.0, 4.0), 0.01), damped))[0] is True
    both = Sampled.from_w(num_w=[1.0, 0.0], den_w=[1.0, 2.0], dt=0.1)  # a zero at z = 1
    held = sample(Plant(num=[1.0], den=[1.0, 0.0]), 0.1)  # and a pole
    assert settled(Loop.of(both, held))[0] is False


def test_several_factors_of_a_loop_are_off_at_once():
    dt = 0.001
    one, two = sample(Plant(num=[-1.0], den=[1.0, 5.0]), dt), sample(Plant(num=[3], den=[1, 3]), dt)
    for loop in (p(5.0, dt) * one * two, two * p(5.0, dt) * one):
        assert margins(loop).stable is False
    assert margins(p(nextafter(5.0, 0), dt) * one * two).stable is True


def test_a_search_takes_floats_as_they_stand_and_evidence_does_not():
    plant, controller, delay = pair(1.0)
    loop = Loop.of(controller, sample(plant, 0.2, delay))
    assert closed_loop_stable(loop) is decided(loop)[0]
    assert not surely_stable(loop)
    assert not surely_stable(loop, 1e-17)
    assert measure_loop(loop).stable is None


def test_at_rest_one_unit_from_a_pole():
    """y = C P/(1 + C P) with C P = -C/5, of fractions; u = C/(1 + C P)."""
    plant, gain = Plant(num=[-1.0], den=[1.0, 5.0]), nextafter(5.0, 0)
    c = Fraction(gain)
    loop = -c / 5
    expected = float(loop / (1 + loop)), float(c / (1 + loop))
    assert gains_at_rest(plant, p(gain, 0.1))[:2] == pytest.approx(expected, rel=1e-15)
    assert response(plant, p(gain, 0.1), by="step").final_value == pytest.approx(expected[0])


def test_a_pole_at_minus_one_is_moved_by_the_loop():
    """C = 0.1/(z + 1), P = (1 - e)/(z - e): z^2 + (1 - e) z - e + 0.1 (1 - e), both |z| below 1."""
    held = sample(Plant(num=[1.0], den=[1.0, 1.0]), 0.1)
    controller = Sampled(num=[0.1], den=[1.0, 1.0], dt=0.1)
    e = np.exp(-0.1)
    assert np.abs(np.roots([1, 1 - e, -e + 0.1 * (1 - e)])).max() < 0.996
    assert settled(Loop.of(controller, held))[0] is True
    hidden = Sampled(num=[0.1, 0.1], den=[1.0, 1.0], dt=0.1)  # what it shares with num stays
    assert settled(Loop.of(hidden, held))[0] is False


@pytest.mark.parametrize("m", [1, 2, 3])
@pytest.mark.parametrize("v", [0, 1, 3])
@pytest.mark.parametrize(("off", "bits"), [(2.0**-20, 18), (0.75, -1), (8.0, -5)])
@pytest.mark.parametrize("at_rest", [False, True])
def test_what_may_be_off_by_hand(m, v, off, bits, at_rest):
    """Of terms t: (|den + num| 2^bits)^2 - (t |1 + p|^m)^2 at p = jv, which is w for dt = 2.

    off is below 2^-(bits + 1), the 1 for a polynomial of degree 1, whose terms may cancel.
    """
    loop = Loop.of(Sampled.from_w(num_w=[1.0, 4.0], den_w=[3.0, 2.0], dt=2.0, delay=m))
    closed = whole.plus(*late(loop, loop.exact))
    first, last = (abs(a) + abs(b) for a, b in zip(*loop.exact, strict=True))
    value = sum(c * (1j * v) ** i for i, c in enumerate(reversed(closed)))
    square = int(value.real) ** 2 + int(value.imag) ** 2
    terms = first * v + (0 if at_rest else last)
    wanted = Fraction(4) ** bits * square - terms**2 * (1 + v * v) ** m
    found = _beyond_doubt(loop, loop.exact, closed, off, at_rest=at_rest)
    assert sum(c * v**i for i, c in enumerate(reversed(found))) == wanted * 4 ** max(-bits, 0)


def closed_late(num, den, m):
    """Return what late makes of num/den in w, dt = 1, added up."""
    loop = Loop.of(Sampled.from_w(num_w=num, den_w=den, dt=1.0, delay=m))
    return whole.plus(*late(loop, loop.exact))


def test_the_polynomial_of_some_samples_by_hand():
    """(w + 4)/(w + 2) with dt = 1: p = w/2, so (2p + 4)(1 - p)^2 + (2p + 2)(1 + p)^2."""
    found = closed_late((1.0, 4.0), (1.0, 2.0), 2)
    wanted = np.polymul([2, 4], [1, -2, 1]) + np.polymul([2, 2], [1, 2, 1])
    factor = found[0] / wanted[0]
    assert factor > 0
    assert found == [int(factor * c) for c in wanted]
    found = closed_late((1.0, 4.0), (1.0, 2.0), 1)
    wanted = np.polymul([2, 4], [-1, 1]) + np.polymul([2, 2], [1, 1])
    unit = found[2] / wanted[2]
    assert found == [int(unit * c) for c in wanted]


@pytest.mark.parametrize("dt", [0.01, 0.1, 0.3, 0.5])
def test_an_undamped_mode_that_is_hidden_is_not_stable(dt):
    """(s^2 + 4)(s + 1) is in num and den: |1 + L| is 0.75, and a pole stays at +-2j."""
    plant = Plant.parse("((s^2+4)*(s+1))/((s^2+4)*(s+1)*(s+3))")
    loop = Loop.of(p(1.0, dt), sample(plant, dt))
    assert surely(loop)[0] is not True
    assert margins(p(1.0, dt) * sample(plant, dt)).stable is not True
    with pytest.raises(NotMet, match="the closed loop is"):
        verify(plant, p(1.0, dt))


def test_what_floats_share_by_chance_is_asked_again():
    """A controller whose zeros are the rounded poles of a held 1/(s^2 + 1): 1 + L is L's own."""
    held = sample(Plant(num=[1.0], den=[1.0, 0.0, 1.0]), 0.1)
    controller = Sampled.from_w(num_w=held.den_w, den_w=[1.0, 10.0, 25.0], dt=0.1)
    loop = Loop.of(controller, held)
    assert surely(loop)[0] is settled(loop)[0]
    assert settled(loop)[0] is True  # the poles of the controller's own den, and next to the circle


@pytest.mark.parametrize(("gain", "stable"), [(-1e-17, True), (1e-17, False)])
def test_a_loop_beside_an_undamped_mode_is_next_to_the_limit_with_a_large_modulus(gain, stable):
    """The pole at j moves by -gain/(2j (j + 1)), to the left where the gain is below 0."""
    plant = Plant.parse("1/((s^2+1)*(s+1))")
    found = measure(plant, p(gain, 0.1)).margins
    assert found.modulus_margin > 0.7
    assert found.stable is stable
