"""``zoh explain``: what a person reads, what a script parses, and the exit codes of the others."""

import json
from pathlib import Path

import pytest

import zoh

EXAMPLES = Path(__file__).parents[2] / "examples"

IMPOSSIBLE = """
[[controller]]
name = "their lag"
law = "lag"
wc = 3.29
pm_deg = 40
dc_gain = 10
"""


def explained(run, text, *more):
    code, out, err = run(text, *more, verb="explain")
    return code, out, err


def test_people_read_the_budget_the_prices_and_the_reasons(good, run):
    code, out, err = explained(run, good)
    assert (code, err) == (0, "")
    for line in ("where the degrees went", "hold, wc dt/2", "controller: integrator"):
        assert line in out
    assert "what the same request would be worth, designed otherwise" in out
    assert "what another sample time would cost" in out
    assert "the longest that does is" in out
    assert "most is taken by plant (-135.7 deg) and controller: integrator (-90 deg)" in out
    assert max(len(line) for line in out.splitlines()) <= 100
    arm = zoh.Plant.parse("2.3/(s^2 + 0.7809 s)", sensor=12 / 180)
    law = zoh.pi(arm, dt=0.1, wc=0.8, pm_deg=40).controller
    assert zoh.budget(arm, law).report() in out  # as it is, a line for each part


def test_scripts_get_one_object(good, run):
    code, out, err = explained(run, good, "--json")
    assert (code, err) == (0, "")
    result = json.loads(out)
    assert (result["zoh"], result["dt"], result["compute_delay"]) == (zoh.__version__, 0.1, 0.0)
    (design,) = result["designs"]
    assert (design["name"], design["law"], design["met"]) == ("PI", "pi", True)
    total = 180 + sum(item["deg"] for item in design["budget"]["items"])
    assert total == pytest.approx(design["budget"]["phase_margin_deg"], abs=1e-9)
    assert total == pytest.approx(40, abs=1e-9)
    assert [row["method"] for row in design["prices"]][:3] == [None, "tustin", "prewarp"]
    assert design["prices"][0]["margins"]["phase_margin_deg"] == pytest.approx(40, abs=1e-9)


def test_a_refusal_is_its_own_reason(good, run):
    code, out, err = explained(run, good + IMPOSSIBLE, "--json")
    assert code == 1
    assert "1 of 2 controllers fail: their lag" in err
    refused = json.loads(out)["designs"][1]
    assert refused["budget"] is None
    assert not refused["met"]
    assert "needs +36.07 deg" in refused["reasons"][0]
    assert "their lag: lag" in explained(run, good + IMPOSSIBLE)[1]


def test_what_is_missed_is_said_first(good, run):
    code, out, _ = explained(run, good + "[requirements]\nms = 1.2\n", "--json")
    assert code == 1
    assert json.loads(out)["designs"][0]["reasons"][0].startswith("missed: ms must be at most 1.2")


def test_what_is_missed_is_followed_by_what_would_do(good, run):
    """2 sin(pm/2) Ms is 1 or more: Ms of 1.2 takes 49.25 deg at least, and 40 were asked."""
    found = json.loads(explained(run, good + "[requirements]\nms = 1.2\n", "--json")[1])
    said = found["designs"][0]["reasons"][-1]
    assert said.startswith("with wc and pm_deg left open everything is met: by the fastest pi at ")
    wc = float(said.split(" at ")[1].split(" rad/s")[0])
    arm = zoh.Plant.parse("2.3/(s^2 + 0.7809 s)", sensor=12 / 180)
    chosen = zoh.pi(arm, dt=0.1, requirements=zoh.Requirements(ms=1.2))
    assert chosen.margins.crossover == pytest.approx(wc, rel=1e-5)  # six digits are said
    kept = json.loads(explained(run, good + "[requirements]\nms = 1.6\n", "--json")[1])
    assert kept["designs"][0]["reasons"][-1].startswith("with wc left open everything is met")
    never = explained(run, good + "[requirements]\nbandwidth = 40\n", "--json")[1]
    assert json.loads(never)["designs"][0]["reasons"][-1].startswith(
        "with wc and pm_deg left open nothing would do: no pi meets everything asked; of a pi, band"
    )


def test_a_given_controller_has_a_budget_and_no_price(run):
    given = (EXAMPLES / "robot_arm_as_printed.toml").read_text()
    _, out, _ = explained(run, given, "--json")
    for design in json.loads(out)["designs"]:
        assert design["budget"]["items"]
        assert design["prices"] == []
        assert design["sample_times"] is None


def test_a_loop_without_a_crossover_says_so(run):
    text = "plant.model = '1/(s + 1)'\nsampling.dt = 0.1\n[[controller]]\nlaw = 'given'\n"
    code, out, _ = explained(run, text + "num = [0.5]\nden = [1]\n", "--json")
    assert code == 0
    (design,) = json.loads(out)["designs"]
    assert design["budget"] is None
    assert "the gain of the loop is never 1" in design["reasons"][0]


def test_bad_input_is_one_line(run):
    code, out, err = explained(run, "plant.model = '1/s'")
    assert (code, out) == (2, "")
    assert err.startswith("zoh: error: sampling.dt must be given")


def test_a_request_that_leaves_its_crossover_open_has_a_budget_and_no_price(good, run):
    code, out, _ = explained(run, good.replace('"pi"', '"p"').replace("wc = 0.8\n", ""), "--json")
    assert code == 0
    (design,) = json.loads(out)["designs"]
    assert design["budget"]["phase_margin_deg"] == pytest.approx(40, abs=1e-9)
    assert design["prices"] == []


LEFT_OPEN = """\
sections = [{w0 = 9.0, depth = 0.3}]
[requirements]
ms = 1.6
pm_deg = 50
"""


def test_what_was_chosen_is_priced_and_clocked_too(good):
    from zoh.app.explain import explain_all
    from zoh.app.project import read

    (found,) = explain_all(read(good.replace("wc = 0.8\npm_deg = 40\n", LEFT_OPEN)))
    m = found.entry.measured.margins
    exact = found.prices[0].margins
    assert exact.crossover == pytest.approx(m.crossover, rel=1e-9)
    assert exact.phase_margin_deg == pytest.approx(m.phase_margin_deg, abs=1e-9)
    assert any(row.dt == 0.1 and row.failure is None for row in found.clocks.rows)


def test_the_clocks_of_a_p_that_was_chosen_ask_for_no_margin_but_the_required_one(good):
    """K/(s (s + a)) behind a hold loses wc dt/2 and hardly more: a faster clock gives more."""
    from zoh.app.explain import explain_all
    from zoh.app.project import read

    asked = good.replace('law = "pi"\nwc = 0.8\npm_deg = 40\n', 'law = "p"\nwc = 0.8\n')
    asked += "[requirements]\npm_deg = 30\n"
    (found,) = explain_all(read(asked))
    rows = [row for row in found.clocks.rows if row.pm_deg is not None]
    assert any(row.dt < 0.1 and row.failure is None for row in rows)
    turned = [row.pm_deg - row.hold_deg for row in rows if row.dt <= 0.2]
    assert max(turned) - min(turned) < 0.01  # deg: the images' share at wc dt = 0.16


def test_what_a_choice_assumed_is_asked_of_every_clock(good):
    from zoh.app.explain import explain_all
    from zoh.app.project import read

    chosen = good.replace("wc = 0.8\npm_deg = 40\n", "")
    (silent,) = explain_all(read(chosen))
    (asking,) = explain_all(read(chosen + "[requirements]\npm_deg = 45\nms = 1.7\n"))
    assert silent.entry.measured.choice.assumed
    assert silent.clocks.largest == asking.clocks.largest


ARM = """\
plant.model = "2.3/(s^2 + 0.7809 s)"
sensor.gain = 0.0666666666666666667
sampling.dt = 0.1
"""


@pytest.mark.parametrize("how", ["largest_ki_ms", "least_iae_ms"])
def test_a_ki_under_a_bound_is_priced_as_it_came_out(run, how):
    text = f"{ARM}[[controller]]\nlaw = 'pid'\nwc = 1.95\npm_deg = 50\n{how} = 1.6\n"
    code, out, err = explained(run, text, "--json")
    assert (code, err) == (0, "")
    (design,) = json.loads(out)["designs"]
    assert len(design["prices"]) == 13  # the exact one, and two in s by six methods
    plant = zoh.Plant.parse("2.3/(s^2 + 0.7809 s)", sensor=0.0666666666666666667)
    found = zoh.pid(plant, dt=0.1, wc=1.95, pm_deg=50, **{how: 1.6})
    again = {"wc": 1.95, "pm_deg": 50, "ki": found.gains["ki"]}
    by_hand = [row.to_dict() for row in zoh.emulate(plant, "pid", again, dt=0.1)]
    told = [row["controller"]["num"] for row in design["prices"]]
    assert told == [pytest.approx(row["controller"]["num"], rel=1e-9) for row in by_hand]
    with pytest.raises(zoh.SpecError, match="ki must be given"):
        zoh.emulate(plant, "pid", {"wc": 1.95, "pm_deg": 50}, dt=0.1)


@pytest.mark.parametrize(
    ("model", "request_"),
    [
        ("-2/(s + 1)", "law = 'pi'\nwc = 1.5\npm_deg = 60\nallow = ['negative_gains']\n"),
        ("-2/(s + 1)", "law = 'pid'\nwc = 1.5\npm_deg = 60\nki = -1\nallow = ['negative_gains']\n"),
        (
            "(s - 1)/((s - 1)(s + 2))",
            "law = 'pi'\nwc = 1.5\npm_deg = 60\nallow = ['cancelled_unstable_modes']\n",
        ),
    ],
)
def test_what_is_allowed_is_allowed_at_every_clock_and_price(run, tmp_path, model, request_):
    text = f"plant.model = '{model}'\nsampling.dt = 0.1\n[[controller]]\n{request_}"
    text += "[requirements]\nms = 1.9\n"
    code, out, err = explained(run, text, "--json", "--out", str(tmp_path / "out"))
    assert code == 0, err
    (design,) = json.loads(out)["designs"]
    assert design["met"]
    assert design["prices"][0]["margins"]["phase_margin_deg"] == pytest.approx(60, abs=1e-9)
    assert all(row["margins"]["stable"] for row in design["prices"][1:3])  # by Tustin, prewarped
    (own,) = (r for r in design["sample_times"]["rows"] if r["dt"] == pytest.approx(0.1))
    assert own["failure"] is None
    assert design["sample_times"]["largest"] >= 0.1


def test_a_gain_that_is_given_is_left_open_last(run):
    text = "plant.model = '1/(s^2 + 2 s)'\nsampling.dt = 0.05\nsampling.compute_delay = 0.02\n"
    text += "[requirements]\novershoot_pct = 3\nsettling_time = 3\npm_deg = 60\npeak_effort = 5\n"
    text += "[[controller]]\nlaw = 'lead'\nwc = 2\npm_deg = 60\ndc_gain = 3\n"
    _, out, _ = explained(run, text, "--json")
    said = json.loads(out)["designs"][0]["reasons"][-1]
    assert said.startswith("with wc and pm_deg and dc_gain left open everything is met: by the f")
    plant = zoh.Plant(num=[1], den=[1, 2, 0])
    asked = zoh.Requirements(overshoot_pct=3, settling_time=3, pm_deg=60, peak_effort=5)
    by_hand = zoh.lead(
        plant, dt=0.05, compute_delay=0.02, wc=1.3, pm_deg=68, dc_gain=2.5, requirements=asked
    )
    assert float(said.split(" at ")[1].split(" rad/s")[0]) >= by_hand.margins.crossover


def test_what_would_do_asks_for_no_more_than_was_asked(run):
    text = f"{ARM}actuator.min = -1\nactuator.max = 1\n[requirements]\nms = 1.6\n"
    text += "[[controller]]\nlaw = 'pi'\nwc = 0.8\npm_deg = 40\n"
    _, out, _ = explained(run, text, "--json")
    said = json.loads(out)["designs"][0]["reasons"][-1]
    plant = zoh.Plant.parse("2.3/(s^2 + 0.7809 s)", sensor=0.0666666666666666667)
    fastest = zoh.pi(plant, dt=0.1, pm_deg=40, requirements=zoh.Requirements(ms=1.6))
    assert f"at {fastest.margins.crossover:.6g} rad/s" in said
    assert max(map(abs, fastest.step.effort_range)) > 1  # beyond the ends, which nobody asked about
