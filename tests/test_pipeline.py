"""Every law, asked of random plants at any sample time, keeps its word or refuses with the truth.

The check is made in z with fifty digits from the plant's own parameters: it shares nothing with
the design, which is solved in w, nor with the hold.
"""

from math import pi

import mpmath
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import zoh

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)

gains, corners = st.floats(0.05, 20), st.floats(0.05, 20)
clocks = st.sampled_from([1e-6, 1e-4, 1e-2, 0.1])
speeds = st.floats(0.02, 0.6)  # of the plant's corner
margins_deg = st.floats(25, 75)


def servo(k, a, late=0.0):
    """Return k/(s (s + a)), late by so many seconds."""
    return zoh.Plant(num=[k], den=[1, a, 0], dead_time=late)


def held_servo(k, a, dt, late, wc):
    """Return k/(s (s + a)) behind a hold at z = exp(j wc dt), by the textbook's z-transform.

    For a delay of m dt - e the modified z-transform of the step response
    y(t) = k (t/a - 1/a^2 + exp(-a t)/a^2), sample by sample::

        sum over j of y(j dt + e) z^-j, times (1 - 1/z) z^-m
    """
    k, a, dt, late, wc = (mpmath.mpf(x) for x in (k, a, dt, late, wc))
    z = mpmath.expj(wc * dt)
    m = mpmath.ceil(late / dt)
    e = m * dt - late
    ramp = (e / a - 1 / a**2) * z / (z - 1) + dt / a * z / (z - 1) ** 2
    decay = mpmath.exp(-a * e) / a**2 * z / (z - mpmath.exp(-a * dt))
    return k * (ramp + decay) * (1 - 1 / z) * z ** (-m)


def law_at(d, wc):
    """Return D at z = exp(j wc dt) from the gains, as the textbook writes each law in z."""
    g = {name: mpmath.mpf(value) for name, value in d.gains.items()}
    dt = mpmath.mpf(d.dt)
    z = mpmath.expj(mpmath.mpf(wc) * dt)
    w = 2 / dt * (z - 1) / (z + 1)
    if d.law in ("lag", "lead"):
        return g["dc_gain"] * (1 + w / g["w0"]) / (1 + w / g["wp"])
    integral = g.get("ki", 0) * dt / 2 * (z + 1) / (z - 1)
    return g["kp"] + integral + g.get("kd", 0) * (z - 1) / (dt * z)


def assert_kept(d, k, a, dt, late, wc, pm_deg):
    with mpmath.workdps(50):
        loop = law_at(d, wc) * held_servo(k, a, dt, late, wc)
        assert abs(abs(loop) - 1) < 1e-12
        assert abs(mpmath.degrees(mpmath.arg(-loop)) - pm_deg) < 1e-9
    assert d.margins.stable
    assert d.margins.crossover == pytest.approx(wc, rel=1e-9)
    assert d.margins.phase_margin_deg == pytest.approx(pm_deg, abs=1e-9)
    assert d.met
    assert d.misses == ()


ASKED = {
    "pi": {},
    "pd": {},
    "pid": {"ki": 0.05},
    "lead": {"dc_gain": 0.3},
    "lag": {"dc_gain": 3.0},
}


FASTER = {"pi": 1, "pd": 4, "pid": 2, "lead": 4, "lag": 1}  # where each law has work to do


def _outcome(plant, law, asked, dt):
    try:
        return zoh.design(plant, law, asked, dt=dt)
    except (zoh.NotMet, zoh.Infeasible) as refused:
        return refused


@pytest.mark.parametrize("law", ASKED)
def test_every_law_keeps_its_word_or_refuses(law):
    met = []

    @given(gains, corners, clocks, speeds, margins_deg, st.floats(0, 2.5))
    @settings(max_examples=25, phases=[Phase.explicit, Phase.generate])  # a refusal takes long
    def one(k, a, clock, speed, pm_deg, late):
        dt, wc = clock / a, FASTER[law] * speed * a
        late = late * dt
        with mpmath.workdps(50):
            size = float(abs(held_servo(k, a, dt, late, wc)))
        given_too = {
            "ki": ASKED[law].get("ki", 0) * wc / size,
            "dc_gain": ASKED[law].get("dc_gain", 0) / size,
        }
        asked = {"wc": wc, "pm_deg": pm_deg}
        asked |= {name: given_too[name] for name in ASKED[law]}
        outcome = _outcome(servo(k, a, late), law, asked, dt)
        if isinstance(outcome, zoh.NotMet):
            # solved, but another crossover counts or the loop is unstable: it must say which
            unstable = not outcome.measured.margins.stable
            assert unstable or "another crossover" in outcome.misses[-1]
        elif isinstance(outcome, zoh.Infeasible):
            with mpmath.workdps(50):
                turned = -mpmath.expj(mpmath.radians(mpmath.mpf(pm_deg)))
                turn = mpmath.arg(turned / held_servo(k, a, dt, late, wc))
                assert abs(outcome.needed_deg - mpmath.degrees(turn)) < 1e-9
        else:
            assert_kept(outcome, k, a, dt, late, wc, pm_deg)
            met.append(outcome)

    one()
    assert len(met) >= 3  # the examples are the same every time: some of them can be met


@given(gains, corners, clocks, margins_deg)
@settings(max_examples=30)
def test_a_p_for_a_margin_has_it(k, a, clock, pm_deg):
    dt = clock / a
    d = zoh.p(servo(k, a), dt=dt, pm_deg=pm_deg)
    assert_kept(d, k, a, dt, 0.0, d.margins.crossover, pm_deg)


def test_a_p_for_a_crossover_has_it():
    d = zoh.p(ARM, dt=0.1, wc=0.5)
    assert d.margins.crossover == pytest.approx(0.5, rel=1e-12)
    with pytest.raises(zoh.Infeasible, match="at no frequency") as refused:
        zoh.p(ARM, dt=0.1, pm_deg=95)
    # the arm comes near to a margin of 90 deg where it is slow
    assert refused.value.needed_deg == pytest.approx(5, abs=0.1)  # 0.1: as slow as is looked at


REQUESTS = [
    ("lag", {"wc": 3.29, "pm_deg": 40, "dc_gain": 10}),
    ("lag", {"wc": 1.2, "pm_deg": 60, "dc_gain": 100}),
    ("pi", {"wc": 1.2, "pm_deg": 40}),
    ("pi", {"wc": 5.0, "pm_deg": 60}),
    ("pd", {"wc": 0.1, "pm_deg": 40}),
    ("lead", {"wc": 0.5, "pm_deg": 40, "dc_gain": 10}),
    ("pid", {"wc": 12.0, "pm_deg": 60, "ki": 0.5}),
]


@pytest.mark.parametrize(("law", "asked"), REQUESTS)
@pytest.mark.parametrize("late", [0.0, 0.04])
def test_what_a_refusal_offers_can_be_had(law, asked, late):
    plant = zoh.Plant(num=ARM.num, den=ARM.den, sensor=ARM.sensor, dead_time=late)
    with pytest.raises(zoh.Infeasible) as caught:
        zoh.design(plant, law, asked, dt=0.1)
    refused = caught.value
    if refused.nearest_wc is not None:
        for wc in (refused.nearest_wc, float(f"{refused.nearest_wc:.7g}")):  # as printed
            assert zoh.design(plant, law, asked | {"wc": wc}, dt=0.1).met
        nearer = asked["wc"] + 0.999 * (refused.nearest_wc - asked["wc"])
        with pytest.raises((zoh.Infeasible, zoh.NotMet)):
            zoh.design(plant, law, asked | {"wc": nearer}, dt=0.1)
    request = {"wc": asked["wc"], "pm_deg": asked["pm_deg"]}
    assert "textbook_lag" not in refused.laws_that_can
    for other in refused.laws_that_can:
        free = set(zoh.LAWS[other]) - set(request)
        values = [asked[name] for name in free if name in asked]
        tries = values or [10.0**e for e in range(-6, 4)]
        assert any(_designed(plant, other, request | dict.fromkeys(free, v)) for v in tries)
    if refused.best_pm_deg is not None:
        # attained or approached within a millionth of a degree, and no more is to be had
        just = {"pm_deg": refused.best_pm_deg - 1e-6}
        d = zoh.design(plant, law, asked | just, dt=0.1)
        assert d.margins.phase_margin_deg == pytest.approx(just["pm_deg"], abs=1e-9)
        with pytest.raises((zoh.Infeasible, zoh.NotMet)):
            zoh.design(plant, law, asked | {"pm_deg": refused.best_pm_deg + 0.01}, dt=0.1)


def _designed(plant, law, asked):
    return isinstance(_outcome(plant, law, asked, 0.1), zoh.Verified)


def test_every_refusal_above_offers_something():
    for law, asked in REQUESTS:
        with pytest.raises(zoh.Infeasible) as caught:
            zoh.design(ARM, law, asked, dt=0.1)
        assert caught.value.nearest_wc or caught.value.laws_that_can


@pytest.mark.parametrize("law", ["p", "pi", "pd", "pid", "lag", "lead", "leadlag", "textbook_lag"])
def test_the_function_of_a_law_is_its_design(law):
    more = {"ki": 0.85, "dc_gain": 10.0}
    wc = {"pi": 0.8, "lag": 0.7, "textbook_lag": 0.7, "leadlag": 1.2}.get(law, 2.0)
    asked = {"wc": wc, "pm_deg": 40.0} | {k: v for k, v in more.items() if k in zoh.LAWS[law]}
    if law in ("p", "textbook_lag"):
        del asked["pm_deg"]
    direct = getattr(zoh, law)(ARM, dt=0.1, **asked)
    assert direct.controller == zoh.design(ARM, law, asked, dt=0.1).controller
    assert direct.law == law


def test_requirements_that_are_missed_are_named():
    with pytest.raises(zoh.NotMet, match=r"ms must be at most 1\.5, measured 1\.57") as missed:
        zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ki=0.85, requirements=zoh.Requirements(ms=1.5))
    assert missed.value.measured.margins.phase_margin_deg == pytest.approx(40, abs=1e-9)


def test_a_design_of_another_loop_is_no_evidence():
    from dataclasses import replace

    d = zoh.pi(ARM, dt=0.1, wc=0.8, pm_deg=40)
    with pytest.raises(zoh.NotMet, match="not this loop's"):
        replace(d, controller=zoh.Sampled(num=[1e9], den=[1], dt=0.1))
    with pytest.raises(zoh.NotMet, match="not this loop's"):
        replace(d, plant=servo(1.0, 1.0))
    with pytest.raises(zoh.NotMet, match="not this loop's"):
        replace(d, step=None)


def test_a_design_can_be_copied_and_sent():
    import copy
    import pickle

    d = zoh.pi(ARM, dt=0.1, wc=0.8, pm_deg=40)
    assert pickle.loads(pickle.dumps(d)).to_dict() == d.to_dict()
    assert copy.deepcopy(d).gains == d.gains


def test_the_callers_decimal_context_is_nobodys_business():
    import decimal

    before = zoh.pi(ARM, dt=0.1, wc=0.8, pm_deg=40)
    with decimal.localcontext() as context:
        context.prec = 5
        context.traps[decimal.Inexact] = True
        after = zoh.pi(ARM, dt=0.1, wc=0.8, pm_deg=40)
    assert after.controller.num == before.controller.num
    assert after.to_dict() == before.to_dict()


def test_crossover_near_nyquist_is_refused_by_name():
    with pytest.raises(zoh.SpecError, match="wc must be below the Nyquist"):
        zoh.pid(ARM, dt=0.1, wc=pi / 0.1, pm_deg=40, ki=1.0)


def test_the_textbooks_lag_is_held_to_a_margin_only_where_one_is_asked_for():
    d = zoh.textbook_lag(ARM, dt=0.1, wc=0.7, dc_gain=10)
    with pytest.raises(zoh.NotMet, match="the loop does not cross over there") as missed:
        zoh.textbook_lag(ARM, dt=0.1, wc=0.7, dc_gain=10, pm_deg=40)
    assert missed.value.measured.margins.to_dict() == d.margins.to_dict()
    assert d.margins.crossover != pytest.approx(0.7, rel=1e-4)


def test_an_unstable_mode_that_is_cancelled_is_not_stabilised():
    # (s - 1)/((s - 1)(s + 1)): the margins are those of 1/(s + 1), the mode at 1 is hidden
    hidden = zoh.Plant(num=[1, -1], den=[1, 0, -1])
    for law, more in (("pi", {}), ("pid", {"ki": 0.5}), ("lag", {"dc_gain": 20.0})):
        with pytest.raises((zoh.NotMet, zoh.Infeasible)):
            zoh.design(hidden, law, {"wc": 1.0, "pm_deg": 80} | more, dt=0.05)
    # an integrator on a plant's zero at s = 0: the constant it holds is seen by nobody
    washed = zoh.Plant(num=[1, 0], den=[1, 3, 2])
    with pytest.raises((zoh.NotMet, zoh.Infeasible)):
        zoh.pi(washed, dt=0.05, wc=1.0, pm_deg=120)


def test_gains_are_positive_or_refused():
    backwards = zoh.Plant(num=[-2.3], den=[1, 0.7809, 0])
    for law in ("p", "pi", "pd", "lead", "leadlag"):
        asked = {"wc": 0.8, "pm_deg": 40} | ({"dc_gain": 0.5} if law.startswith("lead") else {})
        with pytest.raises((zoh.NotMet, zoh.Infeasible)):
            zoh.design(backwards, law, asked, dt=0.1)
