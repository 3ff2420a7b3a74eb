"""Lead-lags: on target in z, their corners as said, and refused only where none is."""

from cmath import exp, phase
from itertools import pairwise
from math import atan, cos, degrees, inf, pi, radians, remainder, sin, sqrt, tan, tau

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from zoh.design import first_order, leadlag
from zoh.errors import Infeasible
from zoh.lti.systems import Sampled
from zoh.spec import Crossover

INTEGRATOR = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)  # at z = j: |G| = 1/sqrt 2, -135 deg
margins = st.floats(5, 150)


def at_z(law, wc, dt):
    """Return D at z = exp(j wc dt) from the gains."""
    g, z = law.gains, exp(1j * wc * dt)
    w = 2 / dt * (z - 1) / (z + 1)
    lag = (1 + w / g["lag_zero"]) / (1 + w / g["lag_pole"])
    return g["dc_gain"] * lag * (1 + w / g["lead_zero"]) / (1 + w / g["lead_pole"])


def test_a_given_ratio_by_hand():
    # v = 2, wz = 2, r = 2: the lag is (1 + j)/(1 + 2 j) = (3 - j)/5, |.| = sqrt(2/5); the lead
    # turns by 30 deg at 75 deg + atan(1/3) less, its ratio a0 |G lag| = a0/sqrt 5 = 1/2
    pm_deg = 75 - degrees(atan(1 / 3))
    spec = Crossover(wc=pi / 2, pm_deg=pm_deg)
    law = leadlag.solve(INTEGRATOR, spec, sqrt(5) / 2, lag_corner=2.0, lag_ratio=2.0)
    assert (law.lag.w0, law.lag.wp) == (2.0, 1.0)
    # 1/w0 = (2 - cos 30)/(2 sin 30), 1/w1 = (cos 30 - 1/2)/(2 sin 30)
    assert law.lead.w0 == pytest.approx(1 / (2 - sqrt(3) / 2), rel=1e-13)
    assert law.lead.wp == pytest.approx(1 / (sqrt(3) / 2 - 0.5), rel=1e-13)


@given(st.floats(0.01, 0.9), margins, st.floats(0.05, 200), st.floats(1.1, 50), st.booleans())
@settings(max_examples=200)
def test_a_lead_lag_is_where_it_was_asked_to_be_or_there_is_none(share, pm, m, ratio, free):
    plant = Sampled(num=(0.3, 0.2), den=(1.0, -1.5, 0.5), dt=0.1)
    spec, z = Crossover(wc=share * pi / 0.1, pm_deg=pm), exp(1j * share * pi)
    g = (0.3 * z + 0.2) / (z * z - 1.5 * z + 0.5)
    theta = remainder(radians(pm - 180) - phase(g), tau)
    given_ratio = None if free else ratio
    try:
        law = leadlag.solve(plant, spec, m / abs(g), lag_ratio=given_ratio)
    except Infeasible:
        assert not _some(theta, m, given_ratio)
        return
    v = law.gains["lag_zero"] * 10
    assert v == pytest.approx(20 * sin(share * pi / 2) / cos(share * pi / 2), rel=1e-12)
    assume(law.gains["lag_zero"] / law.gains["lag_pole"] < 1e6)  # digits of the check in z
    # 1e-9: corners of a lag far below wc lose digits in z, as a lead near its edge does
    assert abs(at_z(law, spec.wc, 0.1) * g + exp(1j * radians(pm))) < 1e-9
    controller = law.controller()
    assert abs(controller.at(spec.wc) * plant.at(spec.wc) + exp(1j * radians(pm))) < 1e-9
    assert 0 < law.gains["lag_pole"] < law.gains["lag_zero"]
    assert 0 < law.gains["lead_zero"] < law.gains["lead_pole"]
    if free:
        centre = sqrt(law.gains["lead_zero"] * law.gains["lead_pole"])
        assert centre == pytest.approx(v, rel=1e-6)  # the search's ratio to the last bit, m/1e6
    else:
        assert law.gains["lag_zero"] / law.gains["lag_pole"] == pytest.approx(ratio, rel=1e-12)


def _some(theta, m, ratio):
    """Return whether a lag from a decade below and a lead meet the target, by looking.

    In units of v: the lag is (1 + 10 j)/(1 + 10 r j), the lead must give the rest. It can where
    the rest's phase f is above 0 and its size s has s cos f > 1, and is centred at sin f =
    (s^2 - 1)/(s^2 + 1).
    """
    off = []
    for r in [ratio] if ratio else [10 ** (k / 40) for k in range(1, 400)]:
        lag = (1 + 10j) / (1 + 10j * r)
        rest = exp(1j * theta) / (m * lag)
        f, s = phase(rest), abs(rest)
        if ratio:
            return f > 1e-9 and s * cos(f) > 1 + 1e-9
        off.append(sin(f) - (s * s - 1) / (s * s + 1) if 0 < f < pi / 2 and s > 1 else inf)
    return any(a * b < 0 for a, b in pairwise(off) if inf not in (a, b))


@pytest.mark.parametrize(("off_deg", "k"), [(30, 2 * tan(radians(5))), (40, 0.6)])
def test_a_free_ratio_beyond_the_lags_own_turn_by_hand(off_deg, k):
    # v = 2 = wz: a lag of r = 1/tan(off) lacks off of 90 deg at v and has k sin(off) there, k =
    # a0 |G| sqrt 2 = a0; the centred lead of that gain turns by 90 deg - 2 atan(k sin(off)). With
    # k = 0.6 another ratio does the same, at off = 11.7 deg: the smaller one is taken
    off = radians(off_deg)
    lag_and_lead = 45 + off_deg - 2 * degrees(atan(k * sin(off)))
    spec = Crossover(wc=pi / 2, pm_deg=45 + lag_and_lead)
    law = leadlag.solve(INTEGRATOR, spec, k, lag_corner=2.0)
    assert law.lag.w0 / law.lag.wp == pytest.approx(1 / tan(off), rel=1e-12)
    assert law.lead.w0 * law.lead.wp == pytest.approx(4.0, rel=1e-12)
    assert abs(at_z(law, pi / 2, 1.0) / (1j - 1) + exp(1j * radians(spec.pm_deg))) < 1e-13


def test_where_no_lag_is_needed_the_phases_start_at_the_centred_lead():
    # m = 1/2: a centred lead of ratio 4 gives asin(3/5) = 36.87 deg; less is not to be had
    plant = Sampled(num=(0.5,), den=(1.0, -1.0), dt=1.0)
    with pytest.raises(Infeasible, match=r"turns the phase by \+36\.87 to \+84\.29 deg"):
        leadlag.solve(plant, Crossover(wc=pi / 2, pm_deg=60), dc_gain=sqrt(2))


def test_the_textbooks_lag_misses_by_what_its_own_phase_is():
    # at z = j, v = 2 and a0 |G| = 10: D(2 j) = a0 (1 + 10 j)/(1 + 100 j)
    law = first_order.textbook_lag(INTEGRATOR, wc=pi / 2, dc_gain=10 * sqrt(2))
    turned = law.controller().at(pi / 2)
    assert turned == pytest.approx(10 * sqrt(2) * (1 + 10j) / (1 + 100j), rel=1e-13)
    assert degrees(phase(turned)) == pytest.approx(-5.138, abs=1e-3)  # as printed to 1e-3


def test_the_textbooks_lag_needs_a_gain_above_what_there_is():
    with pytest.raises(Infeasible, match=r"the textbook's rule needs more than 1\.414"):
        first_order.textbook_lag(INTEGRATOR, wc=pi / 2, dc_gain=1.0)
