"""Every law hits its crossover exactly, over random plants, or says by how much it cannot.

Worked cases are at z = j, where every quantity is a surd: the integrator 1/(z - 1) has
G = 1/(j - 1), |G| = 1/sqrt(2), arg G = -135 deg, and v = 2 tan(45 deg) = 2 at dt = 1.
"""

from cmath import exp, phase
from math import acos, atan, cos, degrees, inf, nan, pi, radians, remainder, sin, sqrt, tau

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from mpmath import mp

from zoh.design import first_order, p, pid
from zoh.design import pi as pi_law
from zoh.design.target import Target
from zoh.errors import Infeasible, SpecError
from zoh.lti.systems import Sampled
from zoh.spec import Crossover

INTEGRATOR = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)
LAG = Sampled(num=(0.5,), den=(1.0, -0.5), dt=1.0)  # at z = j: |G| = 1/sqrt(5), arg atan 2 - 180

plants = st.builds(
    lambda k, a, b, d, dt: Sampled(
        num=(k * (1 - a), k * b * (1 - a)), den=(1.0, -1.0 - a, a) + (0.0,) * d, dt=dt
    ),
    st.floats(0.01, 100),
    st.floats(0.05, 0.98),
    st.floats(-0.9, 0.95),
    st.integers(0, 2),
    st.floats(1e-4, 10),
)
shares = st.floats(0.01, 0.95)  # of the Nyquist frequency
margins = st.floats(5, 150)


def asked(plant, share, pm_deg):
    return Crossover(wc=share * pi / plant.dt, pm_deg=pm_deg)


def in_powers(c, z):
    return sum(x * z ** (len(c) - 1 - i) for i, x in enumerate(c))


def needed(plant, spec):
    """Return (size, theta) in z, by a road that shares nothing with the w-plane."""
    z = exp(1j * spec.wc * plant.dt)
    g = in_powers(plant.num, z) / in_powers(plant.den, z)
    return abs(g), remainder(radians(spec.pm_deg - 180) - phase(g), tau)


def gain_in_z(system, wc):
    z = exp(1j * wc * system.dt)
    return in_powers(system.num, z) / in_powers(system.den, z)


def rounded(system, wc):
    """Return by which part of itself rounding of its z-coefficients moves the gain."""
    z = exp(1j * wc * system.dt)
    return 2.0**-53 * sum(
        sum(abs(c * z**k) for k, c in enumerate(reversed(a))) / abs(in_powers(a, z))
        for a in (system.num, system.den)
    )


def assert_on_target(law, plant, spec):
    controller = law.controller()
    loop = gain_in_z(controller, spec.wc) * gain_in_z(plant, spec.wc)
    lost = rounded(controller, spec.wc) + rounded(plant, spec.wc)
    # a coefficient is rounded once, a term of Horner's scheme twice a degree; no more than 1e-10
    assert abs(loop + exp(1j * radians(spec.pm_deg))) < min(1e-13 + 8 * lost, 1e-10)  # -1, turned
    in_w = controller.at(spec.wc) * plant.at(spec.wc)
    assert abs(in_w + exp(1j * radians(spec.pm_deg))) < 1e-12
    assert all(value > 0 for name, value in law.gains.items() if name != "ki" or value)


# P ---------------------------------------------------------------------------------------------


def test_p_by_hand():
    assert p.solve(INTEGRATOR, Crossover(wc=pi / 2, pm_deg=45)).kp == pytest.approx(
        sqrt(2), rel=1e-15
    )


def test_p_refuses_any_other_margin():
    with pytest.raises(Infeasible) as refused:
        p.solve(INTEGRATOR, Crossover(wc=pi / 2, pm_deg=60))
    assert refused.value.needed_deg == pytest.approx(15, abs=1e-12)
    assert refused.value.best_pm_deg == pytest.approx(45, abs=1e-9)


@given(plants, margins)
@example(
    Sampled(num=(0.7867844780746157, 0.0), den=(1, -1.2132155219253843, 0.2132155219253843), dt=1),
    90.0,
)
@settings(max_examples=60)
def test_p_finds_every_crossover_of_a_margin(plant, pm_deg):
    found = p.crossovers(plant, pm_deg)
    assert found == sorted(found, reverse=True)
    with mp.workdps(50):  # a crossover may be 1e-8 from z = 1, where floats in z say nothing
        for wc in found:
            z = mp.expj(mp.mpf(wc) * plant.dt)
            g = in_powers(plant.num, z) / in_powers(plant.den, z)
            assert float(mp.arg(-g * mp.expj(-mp.radians(pm_deg)))) == pytest.approx(0, abs=1e-9)


# PI --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("plant", "pm_deg", "kp", "ki"),
    [
        (INTEGRATOR, 30, (sqrt(3) + 1) / 2, sqrt(3) - 1),
        (LAG, 45, 3 / sqrt(2), sqrt(2)),
    ],
)
def test_pi_by_hand(plant, pm_deg, kp, ki):
    got = pi_law.solve(plant, Crossover(wc=pi / 2, pm_deg=pm_deg))
    assert (got.kp, got.ki) == pytest.approx((kp, ki), rel=1e-14)


@given(plants, shares, margins)
def test_pi_is_where_it_was_asked_to_be_or_says_why_not(plant, share, pm_deg):
    spec = asked(plant, share, pm_deg)
    _, theta = needed(plant, spec)
    assume(min(abs(theta), abs(theta + pi / 2)) > 1e-9)  # on the edge rounding decides
    if -pi / 2 < theta < 0:
        assert_on_target(pi_law.solve(plant, spec), plant, spec)
    else:
        with pytest.raises(Infeasible) as refused:
            pi_law.solve(plant, spec)
        assert refused.value.needed_deg == pytest.approx(degrees(theta), abs=1e-9)


@given(plants, shares, margins, st.floats(1e-3, 1e3))
def test_pi_undoes_a_gain_of_the_plant(plant, share, pm_deg, k):
    spec = asked(plant, share, pm_deg)
    try:
        base = pi_law.solve(plant, spec)
    except Infeasible:
        assume(False)
    louder = Sampled(num=tuple(k * c for c in plant.num), den=plant.den, dt=plant.dt)
    got = pi_law.solve(louder, spec)
    assert (got.kp * k, got.ki * k) == pytest.approx((base.kp, base.ki), rel=1e-10)


@given(plants, shares, margins, st.floats(1e-3, 1e3))
def test_a_slower_clock_slows_the_integral_and_nothing_else(plant, share, pm_deg, c):
    spec = asked(plant, share, pm_deg)
    try:
        base = pi_law.solve(plant, spec)
    except Infeasible:
        assume(False)
    slow = Sampled(num=plant.num, den=plant.den, dt=plant.dt * c)
    got = pi_law.solve(slow, Crossover(wc=spec.wc / c, pm_deg=pm_deg))
    # 1e-9, not 1e-12: near Nyquist tan() magnifies the rounding of wc * dt
    assert (got.kp, got.ki * c) == pytest.approx((base.kp, base.ki), rel=1e-9)


# PID and PD ------------------------------------------------------------------------------------


def test_pid_by_hand():
    # theta = 0, 1/|G| = sqrt 2, v = 2, x = 1: kd = (0 + 1/2) 2/2, kp = sqrt 2 - 1/2
    got = pid.solve(INTEGRATOR, Crossover(wc=pi / 2, pm_deg=45), ki=1.0)
    assert (got.kp, got.ki, got.kd) == pytest.approx((sqrt(2) - 0.5, 1.0, 0.5), rel=1e-14)


def test_pd_by_hand():
    # theta = 30 deg: sin/|G| = 1/sqrt 2; kd = (1/sqrt 2) 2/2, kp = sqrt 2 cos 30 - 1/sqrt 2
    got = pid.solve(INTEGRATOR, Crossover(wc=pi / 2, pm_deg=75), ki=0.0)
    assert (got.kp, got.kd) == pytest.approx((sqrt(1.5) - sqrt(0.5), sqrt(0.5)), rel=1e-14)
    assert got.controller().den == (1.0, 0.0)  # no integrator


@pytest.mark.parametrize("ki", [0.0, 3.0])
def test_a_pid_with_a_pole_of_its_own_is_built_with_it(ki):
    # dt = 2: w = (z - 1)/(z + 1); at z = 3, 5/3 and -3 that is 1/2, 1/4 and 2
    law = pid.PID(kp=2.0, ki=ki, kd=0.75, filter_pole=0.5, dt=2.0)
    made = law.controller()
    for z, w in ((3, 0.5), (5 / 3, 0.25), (-3, 2)):
        told = 2 + ki / w + 0.75 * w / (1 + 2 * w)
        assert in_powers(made.num, z) / in_powers(made.den, z) == pytest.approx(told, rel=1e-14)
    assert len(made.den) == (3 if ki else 2)


@pytest.mark.parametrize(
    ("theta", "tau", "low", "high"),
    [
        # v = 2, |G| = 1/2, v/|G| = 4; x = 2 tau
        (30, 0.5, 0, 2 * sqrt(3) - 2),
        (-30, 0.5, 2, 2 * sqrt(3) + 2),
        (-60, 0.25, 2 * sqrt(3), 4 + 2 * sqrt(3)),
        (-30, 0.0, 2, inf),
    ],
)
def test_the_room_of_an_integral_by_hand(theta, tau, low, high):
    target = Target(v=2.0, size=0.5, theta=radians(theta), dt=1.0)
    assert pid.room(target, tau) == pytest.approx((low, high), rel=1e-14)


def test_a_room_that_holds_no_float_is_none():
    # at x = 1e17 and -45 deg: sqrt(1/2) to sqrt(1/2) + 7e-18, where floats are 1e-16 apart
    assert pid.room(Target(v=1.0, size=1.0, theta=-pi / 4, dt=1.0), 1e17) is None
    assert pid.room(Target(v=1.0, size=1.0, theta=-pi / 2, dt=1.0), 1.0) is None  # an end
    assert pid.room(Target(v=1.0, size=1.0, theta=pi / 4, dt=1.0), 1.0) is None  # the other


def with_a_pole(plant, spec, pole):
    """Return (v, x, filter_pole): the derivative's pole at ``pole`` v, the usual one for None."""
    v = 2 / plant.dt * sin(spec.wc * plant.dt / 2) / cos(spec.wc * plant.dt / 2)
    return (v, v * plant.dt / 2, None) if pole is None else (v, 1 / pole, pole * v)


@given(plants, shares, margins, st.floats(0, 3), st.none() | st.floats(0.1, 10))
def test_pid_is_where_it_was_asked_to_be_or_says_why_not(plant, share, pm_deg, k, pole):
    spec = asked(plant, share, pm_deg)
    size, theta = needed(plant, spec)
    v, x, filter_pole = with_a_pole(plant, spec, pole)
    ki = k * v / size
    # the two equations, solved here as they stand: real and imaginary part of D(jv)
    kd = (sin(theta) / size + ki / v) * (1 + x * x) / v
    kp = cos(theta) / size - kd * v * x / (1 + x * x)
    assume(min(abs(kp * size), abs(kd * v * size)) > 1e-9)  # on the edge rounding decides
    got = pid.solve(plant, spec, ki, filter_pole, any_sign=True)
    assert (got.kp, got.kd) == pytest.approx((kp, kd), rel=1e-6)  # 1e-9 from the edge
    assert got.filter_pole == (filter_pole or 2 / plant.dt)
    if kp > 0 and kd > 0:
        assert pid.solve(plant, spec, ki, filter_pole) == got
        assert_on_target(got, plant, spec)
    else:
        with pytest.raises(Infeasible) as refused:
            pid.solve(plant, spec, ki, filter_pole)
        assert refused.value.needed_deg == pytest.approx(degrees(theta), abs=1e-9)


@given(plants, shares, margins, st.floats(-20, 20), st.none() | st.floats(0.1, 10))
def test_a_pid_of_a_ratio_of_times_has_it_on_target_or_says_why_not(
    plant, share, pm_deg, decades, pole
):
    ratio = 10**decades
    spec = asked(plant, share, pm_deg)
    _, theta = needed(plant, spec)
    _, x, filter_pole = with_a_pole(plant, spec, pole)
    ends = (-pi / 2, pi / 2 - atan(x))
    assume(min(abs(theta - end) for end in ends) > 0.01)
    if ends[0] < theta < ends[1]:
        got = pid.solve_ratio(plant, spec, ratio, filter_pole)
        assert got.filter_pole == (filter_pole or 2 / plant.dt)
        assert got.kp**2 / (got.ki * got.kd) == pytest.approx(ratio, rel=1e-13)
        assert_on_target(got, plant, spec)
    else:
        with pytest.raises(Infeasible) as refused:
            pid.solve_ratio(plant, spec, ratio, filter_pole)
        assert refused.value.needed_deg == pytest.approx(degrees(theta), abs=1e-9)


def test_a_pid_of_a_ratio_that_hardly_integrates_has_it_all_the_same():
    # theta = 90 deg - 1e-3 rad, a pole far above: kp = sqrt(2)/1000, ki = 7e-7 beside kd = 0.7
    spec = Crossover(wc=pi / 2, pm_deg=135 - degrees(1e-3))
    got = pid.solve_ratio(INTEGRATOR, spec, 4.0, 1e9)
    assert got.kp == pytest.approx(sqrt(2) * sin(1e-3), rel=1e-5)  # x = 2e-9 takes 2e-6 of it
    assert got.kp**2 / (got.ki * got.kd) == pytest.approx(4.0, rel=1e-14)


# lag and lead ----------------------------------------------------------------------------------


def test_lead_by_hand():
    # theta = 30 deg, v = 2, a0 |G| = 1/sqrt 2: v sin = 1; 1/w0 = sqrt 2 - sqrt(3)/2 and
    # 1/wp = sqrt(3)/2 - 1/sqrt 2
    got = first_order.lead(INTEGRATOR, Crossover(wc=pi / 2, pm_deg=75), dc_gain=1.0)
    assert got.w0 == pytest.approx(1 / (sqrt(2) - sqrt(3) / 2), rel=1e-14)
    assert got.wp == pytest.approx(1 / (sqrt(3) / 2 - sqrt(0.5)), rel=1e-14)


def test_lag_by_hand():
    # theta = -30 deg, v sin = -1, a0 |G| = 2: 1/w0 = sqrt(3)/2 - 1/2, 1/wp = 2 - sqrt(3)/2
    got = first_order.lag(INTEGRATOR, Crossover(wc=pi / 2, pm_deg=15), dc_gain=2 * sqrt(2))
    assert got.w0 == pytest.approx(1 / (sqrt(3) / 2 - 0.5), rel=1e-14)
    assert got.wp == pytest.approx(1 / (2 - sqrt(3) / 2), rel=1e-14)
    assert got.wp < got.w0  # a lag


def test_a_lead_with_its_pole_and_a_lag_with_its_zero_on_the_right_by_hand():
    # theta = 60 deg, v sin = sqrt 3, a0 |G| = 1/sqrt 2: more than the 45 deg of a stable pole
    spec = Crossover(wc=pi / 2, pm_deg=105)
    got = first_order.lead(INTEGRATOR, spec, dc_gain=1.0, any_pole=True)
    assert got.w0 == pytest.approx(sqrt(3) / (sqrt(2) - 0.5), rel=1e-14)
    assert got.wp == pytest.approx(sqrt(3) / (0.5 - sqrt(0.5)), rel=1e-14)
    with pytest.raises(Infeasible):
        first_order.lead(INTEGRATOR, spec, dc_gain=1.0, any_sign=True)
    # theta = -30 deg, v sin = -1, a0 |G| = 1.1: more than the 24.6 deg of a zero on the left
    spec = Crossover(wc=pi / 2, pm_deg=15)
    got = first_order.lag(INTEGRATOR, spec, dc_gain=1.1 * sqrt(2), any_sign=True)
    assert got.w0 == pytest.approx(1 / (sqrt(3) / 2 - 1 / 1.1), rel=1e-14)
    assert got.wp == pytest.approx(1 / (1.1 - sqrt(3) / 2), rel=1e-14)
    with pytest.raises(Infeasible):
        first_order.lag(INTEGRATOR, spec, dc_gain=1.1 * sqrt(2), any_pole=True)


@given(plants, shares, margins, st.floats(0.02, 50))
def test_lead_and_lag_are_where_they_were_asked_to_be_or_say_why_not(plant, share, pm_deg, ratio):
    spec = asked(plant, share, pm_deg)
    size, theta = needed(plant, spec)
    assume(abs(theta) > 1e-6)
    assume(abs(ratio - 1) > 1e-6)
    turn = acos(min(ratio, 1 / ratio))
    assume(abs(abs(theta) - turn) > 1e-6)  # on the edge rounding decides
    a0 = ratio / size
    if ratio < 1 and 0 < theta < turn:
        got = first_order.lead(plant, spec, a0)
        assert got.w0 < got.wp
        assert_on_target(got, plant, spec)
    else:
        with pytest.raises(Infeasible) as refused:
            first_order.lead(plant, spec, a0)
        assert refused.value.needed_deg == pytest.approx(degrees(theta), abs=1e-9)
    if ratio > 1 and -turn < theta < 0:
        got = first_order.lag(plant, spec, a0)
        assert got.wp < got.w0
        assert_on_target(got, plant, spec)
    else:
        with pytest.raises(Infeasible) as refused:
            first_order.lag(plant, spec, a0)
        assert refused.value.needed_deg == pytest.approx(degrees(theta), abs=1e-9)


# refusals ---------------------------------------------------------------------------------------


def test_a_refusal_gives_the_best_margin_there_is():
    # at z = j the integrator alone has 45 deg; a PI only takes away
    with pytest.raises(Infeasible, match=r"needs \+15 deg") as refused:
        pi_law.solve(INTEGRATOR, Crossover(wc=pi / 2, pm_deg=60))
    assert refused.value.best_pm_deg == pytest.approx(45, abs=1e-12)
    # a PD adds up to 90 deg - atan(x), x = 1
    with pytest.raises(Infeasible) as refused:
        pid.solve(INTEGRATOR, Crossover(wc=pi / 2, pm_deg=100), ki=0.0)
    assert refused.value.best_pm_deg == pytest.approx(45 + 90 - degrees(atan(1)), abs=1e-12)
    # a lead of a0 |G| = 1/sqrt 2 adds up to 45 deg
    with pytest.raises(Infeasible) as refused:
        first_order.lead(INTEGRATOR, Crossover(wc=pi / 2, pm_deg=100), dc_gain=1.0)
    assert refused.value.best_pm_deg == pytest.approx(90, abs=1e-12)
    # above its dc gain a lag has nothing to give
    with pytest.raises(Infeasible) as refused:
        first_order.lag(INTEGRATOR, Crossover(wc=pi / 2, pm_deg=30), dc_gain=1.0)
    assert refused.value.best_pm_deg is None


@pytest.mark.parametrize("wc", [pi, 4.0])
def test_refuses_a_crossover_at_nyquist_or_above(wc):
    with pytest.raises(SpecError, match="below the Nyquist"):
        pi_law.solve(INTEGRATOR, Crossover(wc=wc, pm_deg=60))


def test_refuses_a_crossover_where_the_plant_is_silent():
    notch = Sampled(num=(1.0, 0.0, 1.0), den=(1.0, -0.5, 0.06), dt=1.0)  # zeros at z = +-j
    with pytest.raises(SpecError, match="wc must be where the plant has a gain"):
        pi_law.solve(notch, Crossover(wc=pi / 2, pm_deg=60))


@pytest.mark.parametrize(
    "bad",
    [{"wc": 0.0}, {"wc": nan}, {"wc": inf}, {"wc": -1}, {"wc": True}, {"pm_deg": 180},
     {"pm_deg": 0}, {"pm_deg": -20}, {"pm_deg": nan}, {"pm_deg": "40"}],
)  # fmt: skip
def test_a_crossover_is_checked_when_it_is_made(bad):
    with pytest.raises(SpecError, match=next(iter(bad))):
        Crossover(**{"wc": 1.0, "pm_deg": 45} | bad)
