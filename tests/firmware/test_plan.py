"""Plans: what is chosen, what is refused in which words, and the loop verified again."""

from dataclasses import replace

import numpy as np
import pytest
from designs import ARM, LAWS, design, made

import zoh
from zoh.firmware.c import emit
from zoh.firmware.linear import transfer
from zoh.firmware.lines import NUMBERS
from zoh.firmware.plan import plan


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("realisation", ["auto", "cascade", "delta"])
def test_the_lines_are_the_controller(law, number, realisation):
    """The transfer function read from the lines, at frequencies all over the band."""
    try:
        found = made(law, number, realisation=realisation)
    except zoh.SpecError:  # test_word_lengths_are_said_where_they_do_not_suffice
        assert (law, number) == ("leadlag", "q15")
        assert realisation != "auto"
        return
    controller = found.design.controller
    # of the gain: what the longest rounded coefficients move it by; q15 words hold some 10 bits
    tolerance = {"f64": 1e-11, "f32": 1e-4, "q31": 1e-4, "q15": 0.05}[number]
    for wc in (0.3, 1.0, 3.0, 10.0, 30.0):
        assert abs(found.quantised.controller.at(wc) / controller.at(wc) - 1) < tolerance


@pytest.mark.parametrize("law", ["pi", "pid", "pid_filtered", "notched"])
@pytest.mark.parametrize("realisation", ["auto", "cascade", "delta"])
@pytest.mark.parametrize("number", NUMBERS)
def test_an_integrator_stays_one_exactly(law, realisation, number):
    _, den = transfer(made(law, number, realisation=realisation).program)
    assert den[-1] == 0


def test_the_paper_in_every_number_keeps_its_margin():
    """The robot arm's four controllers lose less than 0.1 deg in 16 bits, less than 1e-5 in 32."""
    for law in ("lag", "lead", "pi", "pid"):
        assert made(law, "q15").pm_loss_deg < 0.1
        assert made(law, "q31").pm_loss_deg < 1e-5
        assert made(law, "f32").pm_loss_deg < 1e-5
        assert made(law, "f64").pm_loss_deg < 1e-10
        step = made(law, "q15").quantised.step
        assert step.overshoot_pct == pytest.approx(design(law).step.overshoot_pct, abs=0.1)


@pytest.mark.parametrize("dt", [0.1, 1e-2, 1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize("law", ["pi", "pid", "lag", "leadlag"])
def test_sixteen_bits_do_at_any_clock(law, dt):
    """What states move by in a sample shrinks with dt; the binary points of their gains follow."""
    found = plan(
        {
            "pi": lambda: zoh.pi(ARM, dt=dt, wc=0.8, pm_deg=40),
            "pid": lambda: zoh.pid(ARM, dt=dt, wc=1.95, pm_deg=40, ki=0.85, filter_pole=15.0),
            "lag": lambda: zoh.lag(ARM, dt=dt, wc=0.7, pm_deg=40, dc_gain=10),
            "leadlag": lambda: zoh.leadlag(ARM, dt=dt, wc=1.95, pm_deg=40, dc_gain=100),
        }[law](),
        number="q15", u_min=-12, u_max=12, y_range=(-12, 12), realisation="pid",
    )  # fmt: skip
    assert found.pm_loss_deg < 0.03
    names = {s.name for s in found.program.states}
    waits = {"pi": "x_rest", "pid": "x_rest", "lag": "f_rest", "leadlag": "f_rest_2"}[law]
    assert waits in names or dt == 0.1


def test_an_integrator_beside_a_pole_at_nothing_is_still_one_in_a_cascade():
    """The pole of the filter is at z = -1e-17 then, which a float beside 1 does not hold."""
    d = zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ki=0.85, sections=[zoh.notch(w0=20, depth=0.1)])
    found = plan(d, number="f32", u_min=-12, u_max=12, realisation="cascade")
    assert found.pm_loss_deg < 1e-4  # 24 bits of coefficients of some 100


def test_auto_takes_the_shortest_number_that_keeps_the_margin():
    assert made("pid", "auto").number == "q15"
    longer = made("pid", "auto", pm_loss_deg=1e-6)
    assert longer.number == "q31"
    assert longer.said[0] == (
        "not q15: rounded to q15 the phase margin moves by 0.00374 deg, above 1e-06"
    )
    assert made("pid", "auto", pm_loss_deg=1e-9).number == "f64"


def test_auto_without_ranges_goes_on_to_floats():
    found = plan(design("pid"), number="auto")
    assert found.number == "f32"
    assert "not q15: y_range must be given" in found.said[0]


def test_auto_that_nothing_satisfies_says_why():
    with pytest.raises(zoh.SpecError, match=r"pm_loss_deg must be what some format keeps.*f64"):
        plan(zoh.verify(ARM, design("leadlag").controller), number="auto", pm_loss_deg=1e-300)


def test_the_choice_of_realisation_is_by_what_it_costs_and_said():
    """In floats sections in 1/z lose the margin at a fast clock; in z - 1 they do not."""
    notch = zoh.notch(w0=12.0)
    found, cascade = (
        plan(
            zoh.pid(ARM, dt=1e-3, wc=1.95, pm_deg=40, ki=0.85, filter_pole=60.0, sections=[notch]),
            realisation=r,
            pm_loss_deg=1.0,
        )
        for r in ("auto", "cascade")
    )
    assert found.realisation == "delta"
    assert cascade.pm_loss_deg > 0.1 > 1e-6 > found.pm_loss_deg
    assert found.said[0].startswith("phase margin lost by rounding: cascade 0.3 deg, delta ")
    assert found.said[0].endswith("built: delta")


def test_among_equals_the_parallel_form_is_built():
    found = made("pid", "f64")
    assert found.realisation == "pid"
    assert made("notched", "f64").realisation == "cascade"


def test_word_lengths_are_said_where_they_do_not_suffice():
    for realisation in ("cascade", "delta"):
        with pytest.raises(zoh.SpecError, match=r"number must hold a2_1 .*got 'q15 with steps"):
            made("leadlag", "q15", realisation=realisation)


def test_a_gain_that_does_not_fit_names_signal_and_range():
    with pytest.raises(
        zoh.SpecError, match=r"u_range must leave room for '\w+' \(.*\), which needs .* times what"
    ):
        made("pid", "q15", y_range=(-1e6, 1e6))
    wide = made("pid", "q15", y_range=(-1e4, 1e4), u_range=(-1e4, 1e4))
    assert wide.pm_loss_deg < 0.1


def test_a_gain_that_vanishes_is_named():
    slow = zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ki=1e-6)
    with pytest.raises(zoh.SpecError, match=r"number must hold \w+ \(.*\), which needs steps of"):
        plan(slow, number="q15", y_range=(-1, 1), u_range=(-1000, 1000), realisation="pid")


def test_a_loop_that_rounding_takes_too_far_is_not_built():
    asked = zoh.Requirements(pm_deg=49.9999)
    tight = zoh.pd(ARM, dt=0.1, wc=2.5, pm_deg=50, filter_pole=40.0, requirements=asked)
    with pytest.raises(zoh.NotMet, match=r"rounded to q15: pm_deg must be at least 49.99"):
        plan(tight, number="q15", y_range=(-12, 12), u_range=(-12, 12), realisation="pid")
    assert plan(tight, number="q31", y_range=(-12, 12), u_range=(-12, 12)).quantised.met


def test_a_margin_that_moves_too_far_is_not_met():
    with pytest.raises(zoh.NotMet, match=r"rounded to q15 the phase margin moves by 0.0576 deg"):
        made("pid", "q15", realisation="cascade", pm_loss_deg=0.05)


def test_a_bound_met_with_nothing_to_spare_survives_rounding():
    edge = zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, largest_ki_ms=1.7)
    assert edge.margins.ms == pytest.approx(1.7, abs=1e-6)  # what its search stops at
    assert plan(edge, number="f32").quantised.met


def test_quantised_margins_are_those_of_the_quantised_controller():
    found = made("pid", "q15")
    again = zoh.margins(found.quantised.controller * found.design.sampled)
    assert again.phase_margin_deg == found.quantised.margins.phase_margin_deg
    assert found.pm_loss_deg == abs(again.phase_margin_deg - design("pid").margins.phase_margin_deg)


def test_what_is_asked_and_not_built_is_said():
    slow = made("pid", "q15", u_max=5.0001, rate=0.0054)  # 1.47 steps of 12/2^15 a sample
    assert "rate: 1 steps a sample, 32 % less than asked" in slow.said
    assert not any("rate" in line for line in made("pid", "q15", rate=50.0).said)
    free = plan(design("pid"), number="f32", anti_windup="tracking")
    assert "anti-windup: none, for nothing limits u" in free.said


def test_four_digits_cost_what_they_cost():
    """The paper's printed PID, its coefficients cut to four digits, beside ours in 16 bits."""
    exact = design("pid")
    num = [float(f"{c:.4g}") for c in exact.controller.num]
    den = [float(f"{c:.4g}") for c in exact.controller.den]
    cut = zoh.margins(zoh.Sampled(num=num, den=den, dt=0.1) * exact.sampled)
    lost = abs(cut.phase_margin_deg - exact.margins.phase_margin_deg)
    assert lost > 3 * made("pid", "q15").pm_loss_deg


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"number": "q7"}, "number must be one of auto, q15, q31, f32, f64, got 'q7'"),
        ({"realisation": "pi"}, "realisation must be one of"),
        ({"anti_windup": "yes"}, "anti_windup must be one of"),
        ({"u_min": 2.0, "u_max": 1.0}, "u_max must be above u_min = 2"),
        ({"rate": 0}, "rate must be above 0"),
        ({"setpoint_weight": 1.5}, "setpoint_weight must be in"),
        ({"derivative_weight": -0.1}, "derivative_weight must be in"),
        ({"y_range": (1, -1)}, "y_range must rise"),
        ({"y_range": 5}, "y_range must be a list"),
        ({"u_range": (1, 2, 3)}, "u_range must have two ends"),
        ({"number": "q15"}, "y_range must be given for q15"),
        ({"number": "q31", "y_range": (-1, 1)}, "u_range must be given for q31"),
        ({"pm_loss_deg": 0}, "pm_loss_deg must be above 0"),
        ({"u_min": float("nan")}, "u_min must be finite"),
        ({"u_min": -1e39, "u_max": 1e39}, r"number must hold every constant, 1e\+39 among them"),
        ({"u_min": -1e-50, "u_max": 1e-50}, "u_max must not vanish in this format, got 1e-50"),
        (
            {"u_min": -1, "u_max": 1, "realisation": "delta", "anti_windup": "conditional"},
            "anti_windup must be tracking or none for a controller in sections, got 'conditional'",
        ),
        (
            {"realisation": "cascade", "setpoint_weight": 0.5},
            "setpoint_weight must be 1 for a controller in sections, got 0.5",
        ),
        ({"name": "stdint"}, "name must be a C identifier of 31 characters or fewer, no word or"),
        ({"number": "q15", "y_range": (-1, 1), "u_range": (-12, 12), "rate": 1e-5}, "rate must"),
    ],
)
def test_a_malformed_request_is_refused(options, words):
    with pytest.raises(zoh.SpecError, match=words):
        plan(design("pid"), **options)


def test_a_plan_with_a_coefficient_changed_is_none():
    made_ = made("pid", "q15")
    other = tuple(
        replace(c, value=c.value + 1) if c.name == "kp" else c for c in made_.coefficients
    )
    with pytest.raises(zoh.SpecError, match="program must be the controller verified"):
        replace(made_, program=replace(made_.program, coefficients=other))


LAG = zoh.Plant(num=[1.0], den=[1.0, 1.0])


def test_limits_that_the_format_cannot_tell_apart_or_hold_are_refused():
    pi = zoh.verify(LAG, zoh.Sampled(num=[2.0, -1.5], den=[1.0, -1.0], dt=0.1))
    whole = {"number": "q15", "y_range": (-1, 1)}
    with pytest.raises(zoh.SpecError, match=r"u_min must be within the range of u, .* 0.999969"):
        plan(pi, u_min=2.0, u_max=3.0, u_range=(-1, 1), **whole)
    with pytest.raises(zoh.SpecError, match=r"u_max must be within the range of u, .* -1"):
        plan(pi, u_min=-3.0, u_max=-2.0, u_range=(-1, 1), **whole)
    with pytest.raises(zoh.SpecError, match=r"u_max must be above u_min = 0.001 in this format"):
        plan(pi, u_min=0.001, u_max=0.04, u_range=(-1000, 1000), **whole)
    with pytest.raises(zoh.SpecError, match=r"u_max must be above u_min = 0.1 in this format"):
        plan(pi, u_min=0.1, u_max=0.1 + 1e-10)


def test_what_was_asked_for_and_is_not_built_is_said():
    for wanted in ("tracking", "conditional", "back_calculation"):
        said = made("lag", "f32", realisation="pid", anti_windup=wanted).said
        assert f"anti-windup: none, for no state of this form hears of a limit ({wanted} was " in (
            " ".join(said)
        )
    assert "hears of a limit" in " ".join(made("lag", "f32", realisation="pid").said)
    assert "was asked" not in " ".join(made("pid", "f32", anti_windup="none").said)
    held = made("pid", "q15", u_max=0.001, u_range=(-12, 12))
    assert "u_max: 2 steps, 0.000732422, 27 % inside what was asked" in held.said
    text = emit(held)["ctl.h"]
    assert "u_min -12 (where its numbers end), u_max 0.000732421875\n" in text
    assert "inside" not in " ".join(made("pid", "q15").said)


def test_a_form_that_cannot_hold_an_output_says_so():
    jumps, holds = made("lag", "f32", realisation="pid"), made("lag", "f32", realisation="cascade")
    assert not jumps.holds_u
    assert "track: has no integral that could hold u_manual" in " ".join(jumps.said)
    assert "the step after it may jump" in emit(jumps)["ctl.h"]
    assert holds.holds_u
    assert made("pid", "f32").holds_u
    assert "may jump" not in " ".join(holds.said) + emit(holds)["ctl.h"]


def test_weights_of_an_integral_alone_and_of_two_filters():
    integral = zoh.verify(LAG, zoh.Sampled(num=[0.1, 0.1], den=[1.0, -1.0], dt=0.1))  # kp = ki/2
    assert plan(integral, setpoint_weight=0.5).quantised.setpoint_weight == 1.0
    two = zoh.verify(LAG, zoh.Sampled(num=[2.0, -3.2, 1.275], den=[1.0, -1.2, 0.35], dt=0.1))
    with pytest.raises(zoh.SpecError, match="setpoint_weight must be 1 where there are two"):
        plan(two, setpoint_weight=0.5)


def test_what_no_format_takes_for_another_reason_is_not_said_to_be_the_loss():
    rings = zoh.verify(LAG, zoh.Sampled(num=[0.5], den=[1.0, -1.0, 0.5], dt=0.1))
    ranges = {"y_range": (-1, 1), "u_range": (-4, 4)}
    with pytest.raises(zoh.SpecError, match=r"number must be one that takes .* realisation must"):
        plan(rings, number="auto", realisation="pid", **ranges)


def test_what_is_not_verified_is_refused():
    for thing in (design("pid").controller, zoh.measure(ARM, design("pid").controller), None):
        with pytest.raises(zoh.SpecError, match="verified must be a verified design"):
            plan(thing)


@pytest.mark.parametrize(
    "options",
    [{"setpoint_weight": 0.5}, {"derivative_weight": 0}, {"anti_windup": "conditional"}],
)
def test_sections_have_no_part_that_could_be_weighted(options):
    with pytest.raises(zoh.SpecError, match=f"{next(iter(options))} must be (1|tracking)"):
        made("notched", "f32", **options)
    with pytest.raises(zoh.SpecError, match=r"must be (1|tracking)"):
        made("pid", "f32", realisation="cascade", **options)


def test_pid_form_of_what_has_none_is_refused():
    with pytest.raises(zoh.SpecError, match="realisation must fit the controller"):
        made("notched", "f32", realisation="pid")


def test_three_integrators_have_no_sections():
    plant = zoh.Plant(num=[1.0], den=[1.0, 1.0])
    # 8 (z - 0.8)^3/(z - 1)^3: three zeros inside the circle draw in what three integrators push out
    triple = zoh.Sampled(num=[8.0, -19.2, 15.36, -4.096], den=[1.0, -3.0, 3.0, -1.0], dt=0.1)
    with pytest.raises(zoh.SpecError, match="two integrators at most"):
        plan(zoh.verify(plant, triple))


def test_a_design_on_a_table_is_verified_again_on_the_table():
    w = np.geomspace(0.05, 31.0, 400)
    table = zoh.FrequencyResponse.from_complex(w=w, gain=zoh.sample(ARM, 0.1).at(w), dt=0.1)
    d = zoh.pid(table, dt=0.1, wc=1.95, pm_deg=40, ki=0.85)
    found = plan(d, number="q15", u_min=-12, u_max=12, y_range=(-12, 12))
    assert isinstance(found.quantised, zoh.TableVerified)
    # the table's curve between its points is near the model's
    assert found.pm_loss_deg == pytest.approx(made("pid", "q15").pm_loss_deg, rel=0.01)
    header = emit(found)["controller.h"]
    assert "a table of 400 measured points, 0.05 to 31 rad/s" in header
    assert "rounding not bounded: plan must rest on a model" in header
    assert found.sha256 != made("pid", "q15", name="controller").sha256
