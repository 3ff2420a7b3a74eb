"""What else may be left open: lead-lags, a PID under a bound on Ms, beside fixed sections."""

import pickle

import pytest

import zoh
from zoh.choice.choose import FROM_THE_SIMPLEST

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
ASKED = zoh.Requirements(pm_deg=50, ms=1.6)


def test_a_plant_without_a_gain_at_rest_is_refused_before_any_search():
    asked = []
    with pytest.raises(zoh.Infeasible, match="the plant has no gain at rest"):
        zoh.design(zoh.Plant.parse("s/(s+1)^2"), "auto", {}, dt=0.05, progress=asked.append)
    assert asked == []
    # where no error at rest is asked for it is a plant like any other
    loose = zoh.Requirements(ms=1.7)
    d = zoh.pd(zoh.Plant.parse("s/(s+1)^2"), dt=0.05, requirements=loose)
    assert d.step.final_value == 0.0


def test_what_cannot_come_to_no_error_is_not_searched():
    said = []
    asked = zoh.Requirements(ms=1.7, steady_state_error=0.0)
    with pytest.raises(zoh.Infeasible, match="neither the law nor the plant integrates"):
        zoh.design(
            zoh.Plant(num=[1], den=[1, 1]), "lead", {}, dt=0.1, requirements=asked,
            progress=said.append,
        )  # fmt: skip
    assert said == []


def test_a_search_says_where_it_is():
    said = []
    zoh.design(ARM, "pi", {}, dt=0.1, requirements=ASKED, progress=said.append)
    asked = [s for s in said if s.startswith("pi: is everything met at ")]
    assert len(asked) > 10
    assert len(set(asked)) == len(asked)
    # crossovers at which many designs are looked at say how many
    assert all(" measured at " in s for s in said if s not in asked)


@pytest.mark.parametrize("how", ["largest_ki_ms", "least_iae_ms"])
@pytest.mark.parametrize("given", [{}, {"pm_deg": 50}, {"wc": 2.0}])
def test_a_bound_on_ms_closes_the_ki_of_what_is_chosen(how, given):
    d = zoh.pid(ARM, dt=0.1, **given, **{how: 1.6})
    assert d.margins.ms <= 1.6 * (1 + 1e-9)
    assert "ki" not in d.choice.open
    for name in ("wc", "pm_deg"):
        assert (name in d.choice.open) == (name not in given)
    at = {"wc": d.margins.crossover, "pm_deg": d.margins.phase_margin_deg}
    named = zoh.pid(ARM, dt=0.1, **at, **{how: 1.6})
    # 1e-6: the crossover measured is the one asked for to 1e-12, and least_iae is flat
    assert named.gains["ki"] == pytest.approx(d.gains["ki"], rel=1e-6)
    if how == "largest_ki_ms" and "wc" not in given:
        free = zoh.pid(ARM, dt=0.1, **given, requirements=zoh.Requirements(ms=1.6))
        assert d.margins.crossover == pytest.approx(free.margins.crossover, rel=2e-3)  # 0.1 %


def test_a_lead_lag_is_as_fast_as_a_grid_over_its_parameters_says():
    d = zoh.leadlag(ARM, dt=0.1, requirements=ASKED, lag_ratio=4.0)
    wc = d.margins.crossover
    assert d.margins.ms <= 1.6 * (1 + 1e-9)
    assert d.gains["lag_zero"] / d.gains["lag_pole"] == pytest.approx(4.0, rel=1e-12)
    faster = []
    for k in range(1, 12):
        for pm_deg in (50.0, 53.0, 57.0, 62.0):
            for dc_gain in (0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0, 13.0):
                given = {"wc": wc * 1.005**k, "pm_deg": pm_deg, "dc_gain": dc_gain}
                try:
                    other = zoh.leadlag(ARM, dt=0.1, lag_ratio=4.0, requirements=ASKED, **given)
                except zoh.ZohError:
                    continue
                if other.gains["lead_zero"] > other.gains["lag_zero"]:  # v/10: no slower zero
                    faster.append(given)
    assert faster == []


def test_a_choice_counts_with_what_stands_in_series():
    notch = zoh.notch(w0=8.0, depth=0.1)
    asked = zoh.Requirements(pm_deg=50, ms=1.6, overshoot_pct=30.0)
    d = zoh.pd(ARM, dt=0.1, requirements=asked, sections=[notch])
    plain = zoh.pd(ARM, dt=0.1, requirements=asked)
    assert d.margins.crossover < 0.9 * plain.margins.crossover  # a notch takes phase
    assert abs(d.controller.at(8.0) / (d.controller.at(8.0 * 1.5))) < 0.2
    again = zoh.measure(ARM, d.controller, requirements=asked)
    assert again.misses == ()
    for faster in (1.002, 1.01):
        with pytest.raises(zoh.ZohError):
            zoh.pd(
                ARM, dt=0.1, wc=faster * d.margins.crossover, pm_deg=d.margins.phase_margin_deg,
                requirements=asked, sections=[notch],
            )  # fmt: skip


def test_auto_tries_the_laws_from_the_simplest_up():
    """No error at rest behind a lag: of the simple laws a PI alone, and its bandwidth is small."""
    plant = zoh.Plant(num=[1], den=[1, 1.2, 0.2])
    asked = zoh.Requirements(ms=1.6, pm_deg=50, steady_state_error=0.0, bandwidth=2.0)
    d = zoh.design(plant, "auto", {}, dt=0.05, requirements=asked)
    assert d.law == "pid"
    assert [law for law, _ in d.choice.tried] == list(FROM_THE_SIMPLEST[:5])
    whys = dict(d.choice.tried)
    assert "bandwidth must be at least 2" in whys["pi"]
    assert all("neither the law nor the plant integrates" in whys[n] for n in ("p", "pd", "lead"))


@pytest.mark.parametrize(
    ("plant", "dt", "law", "asked", "meets"),
    [
        # pure integrators have no corner below Nyquist's frequency, and a dead time is none
        (zoh.Plant(num=[1], den=[1, 0], dead_time=2), 0.01, "p", {}, {"wc": 0.2}),
        (zoh.Plant(num=[1], den=[1, 0]), 1e-3, "p", {"peak_effort": 1, "ms": 2}, {"wc": 0.99}),
        (zoh.Plant(num=[1], den=[1, 0]), 1e-3, "p", {"delay_margin": 1, "ms": 2}, {"wc": 1.5}),
        (
            zoh.Plant(num=[1], den=[1, 0, 0]), 1e-3, "pd", {"peak_effort": 1, "ms": 2},
            {"wc": 1e-3, "pm_deg": 40},
        ),
        (ARM, 0.1, "p", {"peak_effort": 1e-3, "ms": 2}, {"wc": 1e-4}),
    ],
)  # fmt: skip
def test_what_is_met_far_below_every_corner_is_found(plant, dt, law, asked, meets):
    asked = zoh.Requirements(**asked) if asked else zoh.Requirements(pm_deg=45, ms=1.7)
    known = zoh.design(plant, law, meets, dt=dt, requirements=asked)
    found = zoh.design(plant, law, {}, dt=dt, requirements=asked)
    assert found.margins.crossover >= known.margins.crossover
    assert found.met


def test_what_was_tried_is_said_where_nothing_is_met():
    asked = zoh.Requirements(gain_margin_db=500.0)
    with pytest.raises(zoh.Infeasible, match=r"\(tried from 31.38 down to 8.0\d\de-09 rad/s\)"):
        zoh.p(ARM, dt=0.1, requirements=asked)


@pytest.mark.parametrize("given", [{"wc": 20.0}, {"wc": 20.0, "pm_deg": 50.0}])
def test_the_nearest_crossover_of_auto_is_that_of_the_best_law(given):
    with pytest.raises(zoh.Infeasible) as refused:
        zoh.design(ARM, "auto", given, dt=0.1)
    nearest = refused.value.nearest_wc
    asked = zoh.Requirements(ms=1.7, pm_deg=45)
    for law in ("pd", "lead"):
        known = {k: v for k, v in given.items() if k != "wc"}
        fastest = zoh.design(ARM, law, known, dt=0.1, requirements=asked).margins.crossover
        assert nearest >= fastest * (1 - 2e-4)  # to which the edge is closed in on, twice


def test_a_plant_that_answers_backwards_is_spoken_of_as_it_is():
    plant, words = zoh.Plant(num=[-2], den=[1, 1]), ["negative_gains"]
    asked = zoh.Requirements(effort_min=-3.0, ms=1.8)
    d = zoh.pi(plant, dt=0.1, requirements=asked, allow=words)
    assert d.met
    assert any("effort_min must be at least -3, measured -3.0" in s for s in d.choice.limits)
    with pytest.raises(zoh.Infeasible, match=r"at least -0\.4, and at rest it is -0\.5"):
        zoh.pi(plant, dt=0.1, requirements=zoh.Requirements(effort_min=-0.4), allow=words)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("plant", ["{}/(s - 1)", "{}*10/(s^2 - 25)", "{}*2/(s + 1)"])
def test_a_permission_takes_nothing_away(plant, sign):
    """An unstable pole turns the sign at rest; the gains that a loop needs are those of G(inf)."""
    plant = zoh.Plant.parse(plant.format(sign))
    law = "pd" if len(plant.den) == 3 else "pi"
    d = zoh.design(plant, law, {}, dt=0.02, allow=["negative_gains"])
    assert d.met
    assert d.gains["kp"] * sign > 0
    if sign > 0:
        plain = zoh.design(plant, law, {}, dt=0.02)
        assert plain.margins.crossover == d.margins.crossover
        return
    with pytest.raises(zoh.Infeasible, match="a negative sensor gain turns it round, or allow="):
        zoh.design(plant, law, {}, dt=0.02)
    turned = zoh.Plant(num=plant.num, den=plant.den, sensor=-1)
    assert zoh.design(turned, law, {}, dt=0.02).met  # as it says


def test_a_plant_that_needs_no_turning_is_not_told_to_turn():
    with pytest.raises(zoh.Infeasible) as refused:
        zoh.pi(zoh.Plant.parse("10/(s^2-25)"), dt=0.01, wc=30, pm_deg=50)
    assert "turns it round" not in str(refused.value)
    assert "pd" in refused.value.laws_that_can


def test_a_pid_that_can_turn_the_phase_back_is_among_the_laws_that_can():
    plant = zoh.Plant.parse("2/(s+1)")
    with pytest.raises(zoh.Infeasible) as refused:
        zoh.p(plant, dt=0.1, wc=1.0, pm_deg=60)
    assert "pid" in refused.value.laws_that_can
    assert zoh.pid(plant, dt=0.1, wc=1.0, pm_deg=60, ki=0.7).met


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        ({"settling_time": 0.0}, "no response begins before 0.1 s"),
        ({"settling_time": 0.34}, "no response begins before 0.35 s"),
        ({"noise_gain": 0.0}, "every controller passes some noise on"),
    ],
)
def test_what_no_step_and_no_controller_can_do_is_not_searched(asked, why):
    said, late = [], 0.35 if "0.35" in why else 0.0
    plant = zoh.Plant(num=[2], den=[1, 1], dead_time=late)
    with pytest.raises(zoh.Infeasible, match=why):
        zoh.design(
            plant, "pi", {}, dt=0.1, requirements=zoh.Requirements(**asked), progress=said.append
        )
    assert said == []


@pytest.mark.parametrize("given", [{"wc": 5.0}, {}, {"wc": 1.0, "pm_deg": 60}])
def test_a_hidden_unstable_mode_is_named_before_any_search(given):
    plant = zoh.Plant(num=[1, -1], den=[1, 1, -2])
    word = r'allow=\["cancelled_unstable_modes"\] takes it out of the model'
    with pytest.raises(zoh.Infeasible, match=word) as refused:
        zoh.pi(plant, dt=0.1, **given)
    assert "turns it round" not in str(refused.value)
    # no loop is stable: there is no margin of one, nor a crossover, nor a law
    assert refused.value.best_pm_deg is refused.value.nearest_wc is None
    assert refused.value.laws_that_can == ()
    assert zoh.pi(plant, dt=0.1, wc=5.0, allow=["cancelled_unstable_modes"]).met


def test_a_margin_that_contradicts_a_requirement_is_said_with_the_refusal():
    with pytest.raises(zoh.Infeasible, match=r"must be at least 57\.5, and a margin of 40 deg is"):
        zoh.pi(ARM, dt=0.1, wc=2.0, pm_deg=40, requirements=zoh.Requirements(pm_deg=57.5))


def test_a_p_that_crosses_over_elsewhere_with_less_is_refused_at_every_clock():
    plant, dt = zoh.Plant.parse("1.8697/(s^4 + 3.4493 s^3 + 144.38 s^2 + 354.75 s)"), 0.0151
    elsewhere = r"at 10\.8\d+ rad/s, another crossover of this loop"
    with pytest.raises(zoh.NotMet, match=elsewhere):
        zoh.p(plant, dt=dt, wc=4.963)
    clocks = zoh.sample_times(plant, "p", {"wc": 4.963}, dts=[dt / 2, dt])
    assert all("another crossover of this loop" in row.failure for row in clocks.rows)
    words = ["negative_gains"]
    clocks = zoh.sample_times(plant, "p", {"wc": 4.963}, dts=[dt / 2, dt], allow=words)
    assert clocks.largest is None


def test_a_gain_that_is_given_says_which_sign_is_tried():
    plant, words = zoh.Plant(num=[-2], den=[1, 1]), ["negative_gains"]
    asked = zoh.Requirements(ms=1.8)
    d = zoh.pid(plant, dt=0.1, ki=-1.0, requirements=asked, allow=words)
    assert d.gains["kp"] < 0
    met = [
        zoh.law_map(
            plant, "pid", dt=0.1, requirements=asked, given={"ki": ki}, allow=words, points=(7, 5)
        ).met.any()
        for ki in (-1.0, 1.0)
    ]
    assert met == [True, False]


def test_an_unstable_plant_without_a_gain_at_rest_is_not_told_to_turn():
    """s/(s - 1) in the loop: the last coefficient is the plant's own, whatever the gain."""
    with pytest.raises(zoh.Infeasible) as refused:
        zoh.design(
            zoh.Plant.parse("-s/((s - 1)(s + 2))"), "pd", {}, dt=0.1,
            requirements=zoh.Requirements(ms=2),
        )  # fmt: skip
    assert "turns it round" not in str(refused.value)


def test_a_zero_beside_its_pole_is_not_said_to_creep():
    asked = zoh.Requirements(pm_deg=50, steady_state_error=0)
    assert zoh.leadlag(ARM, dt=0.1, lag_corner=0.01, requirements=asked).choice.notes == ()


def test_a_p_of_a_margin_says_why_no_faster_one():
    d = zoh.design(ARM, "auto", {"pm_deg": 60}, dt=0.1, requirements=zoh.Requirements(ms=1.5))
    assert d.law == "p"
    assert d.choice.limits == ("the plant has a margin of 60 deg at no faster crossover",)


def test_a_ki_under_a_bound_that_misses_something_else_says_what_to_leave_out():
    asked = zoh.Requirements(overshoot_pct=10)
    with pytest.raises(zoh.NotMet, match="leave largest_ki_ms out: the ki is then chosen with"):
        zoh.pid(ARM, dt=0.1, largest_ki_ms=1.6, requirements=asked)
    free = zoh.pid(ARM, dt=0.1, requirements=zoh.Requirements(overshoot_pct=10, ms=1.6))
    assert free.met


def test_an_improper_controller_is_judged_without_its_first_effort():
    asked = zoh.Requirements(peak_effort=5)
    with pytest.raises(zoh.Infeasible, match="no pd meets everything"):
        zoh.pd(ARM, dt=0.1, filter_pole=-20, allow=["unstable_controllers"], requirements=asked)


def test_a_margin_that_alone_makes_the_peak_too_high_is_not_searched():
    said = []
    # |1 + L| is 2 sin(pm/2) at the crossover: 1/(2 sin 20 deg) = 1.4619
    with pytest.raises(zoh.Infeasible, match=r"ms must be at most 1\.4, .* alone makes it 1\.4619"):
        zoh.design(
            ARM, "auto", {"pm_deg": 40.0}, dt=0.1, requirements=zoh.Requirements(ms=1.4),
            progress=said.append,
        )  # fmt: skip
    assert said == []


def test_a_crossover_that_is_too_slow_is_sent_to_the_nearest_above():
    """A PD's bandwidth grows with its crossover: the slow end of what will do is the nearest."""
    asked = zoh.Requirements(pm_deg=50, bandwidth=3.0)
    with pytest.raises(zoh.Infeasible, match="the nearest crossover where it can is") as refused:
        zoh.pd(ARM, dt=0.1, wc=0.5, requirements=asked)
    nearest = refused.value.nearest_wc
    assert zoh.pd(ARM, dt=0.1, wc=nearest, requirements=asked).met
    fastest = zoh.pd(ARM, dt=0.1, requirements=asked).margins.crossover
    assert 0.5 < nearest < 0.9 * fastest
    with pytest.raises(zoh.Infeasible):
        zoh.pd(ARM, dt=0.1, wc=nearest * (1 - 1e-3), requirements=asked)


def test_a_refusal_that_takes_its_time_says_what_it_tries():
    said = []
    with pytest.raises(zoh.Infeasible):
        zoh.design(ARM, "lag", {"wc": 3.29, "pm_deg": 40, "dc_gain": 10}, dt=0.1,
                   progress=said.append)  # fmt: skip
    assert len(said) > 10
    assert all(s.startswith("lag cannot; is there a ") for s in said)
    assert "lag cannot; is there a lead of 40 deg at 3.29 rad/s?" in said


def test_what_is_missed_says_what_to_leave_open():
    asked = zoh.Requirements(ms=1.5)
    with pytest.raises(zoh.NotMet, match="leave wc out, and the fastest that meets") as missed:
        zoh.pi(ARM, dt=0.1, wc=0.8, pm_deg=40, requirements=asked)
    back = pickle.loads(pickle.dumps(missed.value))
    assert (str(back), back.way_out) == (str(missed.value), missed.value.way_out)
    with pytest.raises(zoh.NotMet) as missed:  # the rule has nothing to choose by
        zoh.textbook_lag(ARM, dt=0.1, wc=0.7, dc_gain=10, requirements=zoh.Requirements(ms=1.01))
    assert missed.value.way_out == ""
