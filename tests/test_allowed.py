"""What is refused unless it is asked for by name, and that each refusal says the name."""

from cmath import exp
from math import cos, degrees, pi, radians, sin, sqrt

import pytest

import zoh
from zoh.lti import poly

BACKWARDS = zoh.Plant(num=[-1], den=[1, 0])  # its loop needs negative gains
INTEGRATOR = zoh.Sampled(num=[1], den=[1, -1], dt=1.0)
HIDDEN = zoh.Plant.parse("(s-1)/((s-1)(s+2))")
NEGATIVE, UNSTABLE, CANCELLED = zoh.ALLOWABLE


def on_target(d, wc, pm_deg):
    """Check the loop at wc in z, and its poles, by plain arithmetic."""
    z = exp(1j * wc * d.dt)
    at = [poly.at(a, z) for a in (d.controller.num, d.controller.den)]
    g = [poly.at(a, z) for a in (d.sampled.num, d.sampled.den)]
    assert abs(at[0] / at[1] * g[0] / g[1] + exp(1j * radians(pm_deg))) < 1e-9
    assert d.margins.stable
    assert d.margins.phase_margin_deg == pytest.approx(pm_deg, abs=1e-9)


@pytest.mark.parametrize(
    ("law", "more"),
    [
        ("p", {}),
        ("pi", {}),
        ("pd", {}),
        ("pid", {"ki": -0.02}),
        ("pid", {"ti_td": 6.0}),
        ("pid", {"largest_ki_ms": 1.8}),
        ("lag", {"dc_gain": -3.0}),
        ("lead", {"dc_gain": -0.3}),
        ("leadlag", {"dc_gain": -2.0}),
    ],
)
def test_the_laws_of_a_plant_that_answers_backwards_are_the_other_ones_turned_round(law, more):
    # -1/s at dt = 0.5: a loop with D(z) is that of 1/s with -D(z)
    pm_deg = {"p": 90 - degrees(0.25), "pi": 60, "lag": 60}.get(law, 78)
    request = {"wc": 1.0, "pm_deg": pm_deg}
    turned = {k: abs(v) for k, v in more.items()}
    forwards = zoh.Plant(num=[1], den=[1, 0])
    other = zoh.design(forwards, law, {**request, **turned}, dt=0.5)
    with pytest.raises(zoh.ZohError, match=r'allow=\["negative_gains"\] permits'):
        zoh.design(BACKWARDS, law, {**request, **more}, dt=0.5)
    d = zoh.design(BACKWARDS, law, {**request, **more}, dt=0.5, allow=[NEGATIVE])
    on_target(d, 1.0, pm_deg)
    assert d.controller.num == pytest.approx([-c for c in other.controller.num], rel=1e-9)
    assert d.allowed == (NEGATIVE,)


@pytest.mark.parametrize("sign", [1, -1])
def test_what_a_p_of_any_sign_has_by_hand(sign):
    # sign/s behind its hold at dt = 0.5 is sign/(2 (z - 1)): |G| = 1/(4 sin(wc/4)), and with kp of
    # that sign a margin of 90 - wc/4 (rad) at each wc, 90 deg at most, and no other
    plant = zoh.Plant(num=[sign], den=[1, 0])
    margin = 90 - degrees(0.25)
    with pytest.raises(zoh.Infeasible) as refused:
        zoh.p(plant, dt=0.5, wc=1.0, pm_deg=50, allow=[NEGATIVE])
    assert refused.value.best_pm_deg == pytest.approx(margin, abs=1e-9)
    wc = radians(40) * 4
    # 1e-6: rounded to seven digits on its working side, or where the phase is passed
    assert refused.value.nearest_wc == pytest.approx(wc, rel=1e-6)
    assert "sensor" not in str(refused.value)  # its sign is no matter here
    for asked in ({"wc": wc}, {"pm_deg": 50.0}, {"wc": wc, "pm_deg": 50.0}):
        d = zoh.p(plant, dt=0.5, allow=[NEGATIVE], **asked)
        on_target(d, wc, 50)
        assert d.gains["kp"] == pytest.approx(sign * 4 * sin(wc / 4), rel=1e-9)


def test_a_p_of_either_sign_that_holds_nowhere_is_refused_as_without_the_word():
    # 1/(s - 1)^2: the coefficient of z in (z - e^dt)^2 + kp (...) cannot make both poles small
    plant = zoh.Plant.zpk(zeros=[], poles=[1, 1], gain=1)
    for asked in ({"wc": 1.0}, {"pm_deg": 50.0}):
        failures = []
        for allow in ([], [NEGATIVE]):
            with pytest.raises(zoh.ZohError) as failure:
                zoh.p(plant, dt=0.1, allow=allow, **asked)
            failures.append(str(failure.value))
        assert failures[0] == failures[1]


def test_mixed_signs_by_hand():
    # (1/(z - 1))^2... at z = j the integrator has 1/sqrt 2 and -135 deg: a margin of 75 deg needs
    # +30 deg of a PI, kp = sqrt 2 cos 30, ki = -2 sqrt 2 sin 30: it lags by a negative ki
    from zoh.design import pi as pi_law
    from zoh.spec import Crossover

    spec = Crossover(wc=pi / 2, pm_deg=75)
    with pytest.raises(zoh.Infeasible, match="needs \\+30 deg"):
        pi_law.solve(INTEGRATOR, spec)
    law = pi_law.solve(INTEGRATOR, spec, any_sign=True)
    assert law.kp == pytest.approx(sqrt(2) * cos(pi / 6), rel=1e-14)
    assert law.ki == pytest.approx(-sqrt(2), rel=1e-14)


@pytest.mark.parametrize(
    ("law", "model", "wc", "pm_deg", "dc_gain"),
    [
        ("lead", "-2.66*(s-0.373)/((s-3.94)*(s+2.67))", 15.0, 27.0, 5.35),
        ("lag", "-3.08*(s-0.2654)/((s-3.2746)*(s+1.6236))", 3.25, 21.7, 5.08),
    ],
)
def test_what_only_an_unstable_controller_stabilises_needs_its_word(
    law, model, wc, pm_deg, dc_gain
):
    # one pole on the right between a zero there and infinity: no stable controller exists
    # (D. C. Youla, J. J. Bongiorno, C. N. Lu, Automatica 10, 1974, parity interlacing)
    plant, request = zoh.Plant.parse(model), {"wc": wc, "pm_deg": pm_deg, "dc_gain": dc_gain}
    with pytest.raises(zoh.Infeasible, match=r'allow=\["unstable_controllers"\] permits one here'):
        zoh.design(plant, law, request, dt=0.02)
    d = zoh.design(plant, law, request, dt=0.02, allow=[UNSTABLE])
    on_target(d, wc, pm_deg)
    assert d.gains["wp"] < 0 < d.gains["w0"]
    assert max(abs(d.controller.poles())) > 1


def test_a_filter_pole_on_the_right_needs_its_word():
    plant = zoh.Plant(num=[1], den=[1, 1, 0])
    asked = {"wc": 1.0, "pm_deg": 40.0, "filter_pole": -300.0}
    with pytest.raises(zoh.SpecError, match=r'filter_pole must be above 0.*"unstable_controllers"'):
        zoh.design(plant, "pd", asked, dt=0.1)


def test_a_hidden_unstable_mode_is_cancelled_by_its_word_alone():
    asked = {"wc": 1.0, "pm_deg": 80}
    with pytest.raises(zoh.NotMet, match=r'allow=\["cancelled_unstable_modes"\] takes it out'):
        zoh.p(HIDDEN, wc=1.0, dt=0.1)
    d = zoh.pi(HIDDEN, dt=0.1, allow=[CANCELLED], **asked)
    plain = zoh.pi(zoh.Plant.parse("1/(s+2)"), dt=0.1, **asked)
    assert d.plant == plain.plant
    assert d.margins == plain.margins
    assert d.allowed == ("cancelled_unstable_modes (s = 1)",)
    assert "allowed: cancelled_unstable_modes (s = 1)" in d.report()
    assert d.to_dict()["allowed"] == list(d.allowed)


def test_a_word_that_is_not_needed_changes_nothing():
    plant = zoh.Plant(num=[1], den=[1, 1, 0])
    plain = zoh.pd(plant, dt=0.1, wc=1.0, pm_deg=60)
    free = zoh.pd(plant, dt=0.1, wc=1.0, pm_deg=60, allow=list(zoh.ALLOWABLE))
    assert free.controller == plain.controller


@pytest.mark.parametrize(
    ("allow", "line"),
    [
        ("negative_gains", "allow must be a list of words, got 'negative_gains'"),
        (["anything"], "allow must hold words that are known, got 'anything'"),
        (3, "allow must be a list of words, got 3"),
        ([["negative_gains"]], "allow must hold words that are known"),
    ],
)
def test_malformed_permissions_are_refused_by_name(allow, line):
    with pytest.raises(zoh.SpecError) as refused:
        zoh.pi(BACKWARDS, dt=0.5, wc=1.0, pm_deg=60, allow=allow)
    assert str(refused.value).startswith(line)
    assert "negative_gains" in str(refused.value)


@pytest.mark.parametrize(("law", "given"), [("pi", {"pm_deg": 60.0}), ("pid", {}), ("lag", {})])
def test_what_is_left_open_of_a_plant_that_answers_backwards_is_the_opposite_of_its_opposite(
    law, given
):
    # -P under -C is the loop of P under C, and u is the other way round
    forwards = zoh.Plant(num=[-c for c in BACKWARDS.num], den=BACKWARDS.den)
    asked = zoh.Requirements(ms=1.6, effort_min=-1.0, effort_max=9.0)
    turned = zoh.Requirements(ms=1.6, effort_min=-9.0, effort_max=1.0)
    plain = zoh.design(forwards, law, given, dt=0.5, requirements=asked)
    found = zoh.design(BACKWARDS, law, given, dt=0.5, requirements=turned, allow=[NEGATIVE])
    assert found.allowed == (NEGATIVE,)
    assert found.margins.crossover == pytest.approx(plain.margins.crossover, rel=1e-12)
    signed = {k: -v if k in ("kp", "ki", "kd", "dc_gain") else v for k, v in plain.gains.items()}
    assert dict(found.gains) == pytest.approx(signed, rel=1e-9)
    assert found.step.effort_range == pytest.approx([-e for e in plain.step.effort_range[::-1]])
    with pytest.raises(zoh.Infeasible, match=r'turns it round, or allow=\["negative_gains"\] does'):
        zoh.design(BACKWARDS, law, given, dt=0.5, requirements=turned)


def test_what_answers_forwards_is_chosen_with_positive_gains_though_others_are_allowed():
    arm = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    plain = zoh.pi(arm, dt=0.1, pm_deg=50)
    assert zoh.pi(arm, dt=0.1, pm_deg=50, allow=[NEGATIVE]).gains == plain.gains


def test_a_project_file_allows_by_the_same_words():
    from zoh.app.commands import design_all
    from zoh.app.project import read

    text = """
    [plant]
    model = "-1/s"
    [sampling]
    dt = 0.5
    [[controller]]
    law = "pi"
    wc = 1.0
    pm_deg = 60
    {}
    """
    (entry,) = design_all(read(text.format("")))
    assert 'allow=["negative_gains"] permits one here' in entry.failure
    (entry,) = design_all(read(text.format('allow = ["negative_gains"]\nsetpoint_weight = 0.5')))
    assert entry.failure is None
    assert entry.to_dict()["allowed"] == ["negative_gains"]
    assert entry.to_dict()["setpoint_weight"] == 0.5
    with pytest.raises(zoh.SpecError, match=r'^controller "pi": allow must hold words'):
        read(text.format('allow = ["negative"]'))
