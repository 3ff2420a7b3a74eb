"""The command line: what scripts rely on, and what a person reads in 80 columns."""

import json
import os
import subprocess
import sys
import tomllib
from math import asin, degrees, pi
from pathlib import Path

import numpy as np
import pytest

import zoh
import zoh.app.cli as cli
from zoh.app.kinds import kinds
from zoh.errors import ZohError
from zoh.lti.systems import Sampled

EXAMPLES = Path(__file__).parents[2] / "examples"
DESIGNS = ["robot_arm", "dc_motor_speed", "buck_converter"]
PAPER = str(EXAMPLES / "robot_arm_as_printed.toml")

IMPOSSIBLE = """
[[controller]]
name = "their lag"
law = "lag"
wc = 3.29
pm_deg = 40
dc_gain = 10
"""
# G(z) = 0.1/(z - 1) behind a gain of 30: the pole 1 - 3 lies outside the unit circle
UNSTABLE = """\
plant.model = "1/s"
sampling.dt = 0.1
[[controller]]
name = "hot"
law = "given"
num = [30]
den = [1]
"""


@pytest.mark.parametrize("name", DESIGNS)
def test_every_example_designs_and_meets_its_requirements(name, zoh_main):
    code, out, err = zoh_main("design", EXAMPLES / f"{name}.toml", "--json")
    assert (code, err) == (0, "")
    result = json.loads(out)
    asked = tomllib.loads((EXAMPLES / f"{name}.toml").read_text())
    assert [d["name"] for d in result["designs"]] == [c["name"] for c in asked["controller"]]
    for design, request in zip(result["designs"], asked["controller"], strict=True):
        assert design["met"]
        assert design["misses"] == []
        # the loop, rebuilt from the printed coefficients alone, is where it was asked to be
        dt = asked["sampling"]["dt"]
        z = np.exp(1j * request["wc"] * dt)
        parts = [design["controller"], result["plant"]]
        loop = np.prod([np.polyval(p["num"], z) / np.polyval(p["den"], z) for p in parts])
        # z-coefficients are rounded in their 16th digit, and wc dt is 0.07 or more here: two
        # poles and a zero near z = 1 leave differences of 1e-4, so 12 digits; 1e-9 is ample
        assert abs(loop) == pytest.approx(1, rel=1e-9)
        assert degrees(np.angle(-loop)) == pytest.approx(request["pm_deg"], abs=1e-7)  # as above


def test_json_has_the_forms_of_the_contract(good, run):
    code, out, err = run(good, "--json")
    assert (code, err) == (0, "")
    result = json.loads(out)
    assert result["zoh"] == zoh.__version__
    assert {"num", "den", "dt"} <= result["plant"].keys()
    (design,) = result["designs"]
    assert (design["name"], design["law"]) == ("PI", "pi")
    assert (design["feasible"], design["reason"]) == (True, None)
    assert design["gains"].keys() == {"kp", "ki"}
    assert {"num", "den", "dt"} <= design["controller"].keys()
    margins = ["stable", "gain_margin", "gain_margin_db", "phase_crossover", "phase_margin_deg"]
    margins += ["crossover", "delay_margin", "modulus_margin", "ms", "mt"]
    assert set(margins) <= design["margins"].keys()
    step = ["overshoot_pct", "rise_time", "settling_time", "peak_time", "steady_state_error"]
    assert {*step, "between_samples", "peak_effort"} <= design["step"].keys()
    assert {"overshoot_pct", "peak_time"} <= design["step"]["between_samples"].keys()
    # 1e-9 deg is what the library promises of an exact design
    assert design["margins"]["phase_margin_deg"] == pytest.approx(40, abs=1e-9)


def test_a_refusal_has_its_numbers_and_the_others_are_still_designed(good, run):
    code, out, err = run(good + IMPOSSIBLE, "--json")
    assert code == 1
    assert "1 of 2 controllers fail: their lag: a lag" in err
    pi_design, lag = json.loads(out)["designs"]
    assert pi_design["met"]
    assert (lag["feasible"], lag["met"], lag["gains"], lag["step"]) == (False, False, None, None)
    assert "lag" in lag["reason"]
    # the paper's plant has a margin of 3.09 deg at 3.29 rad/s: 40 takes some 37 deg of lead
    plant = Sampled(**json.loads(out)["plant"])
    needed = 40 - degrees(np.angle(-plant.at(3.29)))
    assert lag["needed_deg"] == pytest.approx(needed, abs=1e-9)
    assert 30 < lag["needed_deg"] < 45
    assert "lead" in lag["laws_that_can"]
    assert lag.keys() >= {"best_pm_deg", "nearest_wc"}


def test_a_requirement_that_is_missed_exits_1_with_the_measurement(good, run):
    code, out, err = run(good + "[requirements]\nms = 1.2\n", "--json")
    assert code == 1
    (design,) = json.loads(out)["designs"]
    assert (design["feasible"], design["met"]) == (True, False)
    assert design["margins"]["ms"] > 1.2
    assert any("ms" in miss for miss in design["misses"])
    assert "PI: ms must be at most 1.2" in err


def test_an_unstable_loop_is_measured_and_fails(run):
    code, out, err = run(UNSTABLE, "--json", verb="check")
    (found,) = json.loads(out)["designs"]
    assert code == 1
    assert (found["margins"]["stable"], found["step"], found["met"]) == (False, None, False)
    assert "hot: the closed loop is unstable" in err


@pytest.mark.parametrize("arguments", [["design", EXAMPLES / "robot_arm.toml"], ["check", PAPER]])
def test_the_table_is_readable_in_80_columns(arguments, zoh_main):
    _, out, _ = zoh_main(*arguments)
    assert max(len(line) for line in out.splitlines()) <= 80
    for row in ("law", "crossover", "phase margin", "gain margin", "delay margin", "Ms"):
        assert row in out
    for row in ("overshoot", "rise", "settling", "steady-state error", "peak effort"):
        assert row in out
    assert out.count("D(z) =") == out.count("D(w) =") == 4


def test_many_controllers_come_in_blocks(good, run):
    more = "".join(
        f'[[controller]]\nname = "P at {w}"\nlaw = "p"\nwc = {w}\n' for w in (0.2, 0.3, 0.4, 0.5, 1)
    )
    code, out, _ = run(good + more)
    assert code == 0
    assert max(len(line) for line in out.splitlines()) <= 80
    assert out.count("peak effort") == 2


def test_a_refusal_stands_below_the_table(good, run):
    code, out, err = run(good + IMPOSSIBLE)
    assert code == 1
    assert out.index("their lag (lag) refused:") > out.index("peak effort")
    assert err.count("\n") == 1


def test_names_are_never_markup(good, run):
    _, out, _ = run(good.replace('"PI"', '"[red]PI[/x]"'))
    assert "[red]PI[/x]" in out


def test_check_finds_what_the_paper_got_wrong(zoh_main):
    code, out, err = zoh_main("check", PAPER, "--json")
    assert code == 1
    assert "2 of 4 controllers fail: phase-lag, phase-lead" in err
    designs = {d["name"]: d for d in json.loads(out)["designs"]}
    found = {n: {f["key"]: f for f in d["findings"]} for n, d in designs.items()}
    lag = found["phase-lag"]
    assert (lag["kind"]["holds"], lag["kind"]["measured"]) == (False, "lead")
    assert "+30.2 deg at 3.29 rad/s" in lag["kind"]["sentence"]
    assert not lag["wc"]["holds"]
    # independently recomputed from the paper's plant, to the four digits given there
    assert lag["wc"]["measured"] == pytest.approx(2.8896, abs=2e-4)  # from four-digit D(z)
    assert lag["wc"]["claimed"] == "3.29"
    assert lag["wc"]["off_by"] == pytest.approx(lag["wc"]["measured"] - 3.29, abs=1e-12)
    assert lag["pm_deg"]["holds"]
    assert lag["gain_margin_db"]["holds"]
    # the misprinted pole: 15.2 dB and 39.0 deg instead of 15.3 and 40
    lead = found["phase-lead"]
    assert lead["kind"]["holds"]
    assert not lead["gain_margin_db"]["holds"]
    assert round(lead["gain_margin_db"]["measured"], 1) == 15.2
    assert round(lead["pm_deg"]["measured"], 1) == 39.0
    assert all(f["holds"] for name in ("PI", "PID") for f in found[name].values())


# 0.9504/s sampled at 0.1 s is L = 0.09504/(z - 1), and |z - 1| = 2 sin(wc dt/2), so it crosses 1
# at 2 asin(0.04752)/0.1 = 0.950758 rad/s
DIGITS = [
    ("1", True), ("2", False), ("1.0", True), ("0.9", False), ("1.00", False), ("0.95", True),
    ("0.950", False), ("0.951", True), ("0.952", False), ("0.9508", True), ("0.9507", False),
]  # fmt: skip


@pytest.mark.parametrize(("text", "holds"), DIGITS)
def test_a_claim_is_as_sharp_as_its_digits(text, holds, run):
    given = UNSTABLE.replace("1/s", "0.9504/s").replace("num = [30]", "num = [1]")
    code, out, _ = run(given + f"claims = {{wc = {text}}}", "--json", verb="check")
    (finding,) = json.loads(out)["designs"][0]["findings"]
    assert finding["measured"] == pytest.approx(2 * asin(0.04752) / 0.1, rel=1e-12)
    assert finding["holds"] is holds
    assert code == (0 if holds else 1)


W = 0.1  # s; D(w) = k (1 + w/a)/(1 + w/b) by its corners a, b in rad/s
KINDS = [
    ([1.0], [1.0], ("p",)),
    ([1.0, 1.0], [1.0, 10.0], ("lead",)),
    ([1.0, 10.0], [1.0, 1.0], ("lag",)),
    ([1.0], [1.0, 1.0], ("lag",)),
    ([1.0, 1.0], [1.0, 0.0], ("pi",)),
    ([1.0, 1.0], [1.0, 20.0], ("pd", "lead")),
    ([1.0, 2.0, 5.0], [1.0, 20.0, 0.0], ("pid",)),
    ([1.0, 3.0, 2.0], [1.0, 10.1, 1.0], ("leadlag",)),
    ([1.0, -1.0], [1.0, 10.0], ()),
    ([1.0, 1.0], [1.0, -10.0], ()),
    ([1.0, 1.0, 1.0], [1.0, 0.0, 0.0], ()),
]


@pytest.mark.parametrize(("num_w", "den_w", "kind"), KINDS)
def test_kinds_by_poles_and_zeros(num_w, den_w, kind):
    controller = Sampled.from_w(num_w=num_w, den_w=den_w, dt=W)
    assert kinds(controller) == kind
    if kind in (("lead",), ("lag",)):  # the phase says the same
        phase = np.angle(controller.at(np.linspace(0.1, 0.9, 9) * pi / W))
        assert np.all(phase > 0 if kind == ("lead",) else phase < 0)


def test_an_actuator_that_cannot_is_said(good, run):
    # the step is one of the output, 1/15 as much where the controller compares
    _, out, _ = run(good + "[actuator]\nmin = -2\nmax = 0.25\n", "--json")
    result = json.loads(out)
    assert result["designs"][0]["step"]["peak_effort"] == pytest.approx(5.8389, abs=1e-4)  # printed
    assert "asks for 0.3893" in result["warnings"][0]
    assert "the actuator ends at 0.25: it saturates" in result["warnings"][0]
    _, out, _ = run(good + "[actuator]\nmin = -2\nmax = 0.4\n", "--json")
    assert json.loads(out)["warnings"] == []
    _, out, _ = run(good + "[actuator]\nmin = -2\nmax = 5\n[reference]\nstep = -6\n", "--json")
    assert "asks for -2.336" in json.loads(out)["warnings"][0]
    _, out, _ = run(good + "[actuator]\nmin = -2\nmax = 500\n", "--json")
    assert json.loads(out)["warnings"] == []


# ---- files ----------------------------------------------------------------------------------


@pytest.fixture
def quick_report(monkeypatch):
    """Drawing takes seconds; what is written where does not depend on the picture."""
    monkeypatch.setattr(cli, "_comparison", lambda _: {"REPORT.md": "# größer\n", "a.png": b"\x89"})


def test_out_writes_the_report_for_real(good, run, tmp_path):
    folder = tmp_path / "new" / "report"
    code, _, err = run(good, "--json", "--out", str(folder))
    names = {p.name for p in folder.iterdir()}
    assert code == 0
    assert {"design.json", "REPORT.md"} < names
    assert any(name.endswith(".svg") for name in names)
    assert err == f"zoh: wrote {len(names)} files to {folder}\n"


@pytest.mark.usefixtures("quick_report")
def test_out_writes_all_and_says_so(good, run, tmp_path):
    code, out, err = run(good, "--json", "--out", str(tmp_path / "r"))
    assert code == 0
    assert json.loads((tmp_path / "r" / "design.json").read_text()) == json.loads(out)
    assert (tmp_path / "r" / "REPORT.md").read_text("utf-8") == "# größer\n"
    assert (tmp_path / "r" / "a.png").read_bytes() == b"\x89"
    assert sorted(p.name for p in (tmp_path / "r").iterdir()) == [
        "REPORT.md",
        "a.png",
        "design.json",
    ]
    assert "wrote 3 files" in err


@pytest.mark.usefixtures("quick_report")
@pytest.mark.parametrize("there", ["design.json", "a.png"])
def test_out_never_overwrites_without_force(there, good, run, tmp_path):
    folder = tmp_path / "r"
    folder.mkdir()
    (folder / there).write_text("precious")
    (folder / "other").write_text("mine")
    code, out, err = run(good, "--out", str(folder))
    assert (code, out) == (2, "")
    assert err.startswith("zoh: error: --out must not hold a file of that name already, got '")
    assert err.endswith("add --force, or name another folder\n")
    assert (folder / there).read_text() == "precious"
    assert sorted(p.name for p in folder.iterdir()) == sorted([there, "other"])
    assert run(good, "--out", str(folder), "--force")[0] == 0
    assert (folder / there).read_bytes() != b"precious"
    assert (folder / "other").read_text() == "mine"


@pytest.mark.usefixtures("quick_report")
def test_force_never_replaces_a_folder(good, run, tmp_path):
    (tmp_path / "r" / "a.png").mkdir(parents=True)
    code, _, err = run(good, "--out", str(tmp_path / "r"), "--force")
    assert code == 2
    assert "folder of that name" in err


@pytest.mark.usefixtures("quick_report")
@pytest.mark.parametrize("name", ["project.toml", "project.toml/below", "", "a\0b"])
def test_out_that_cannot_be_a_folder(name, good, run, tmp_path):
    code, out, err = run(good, "--out", str(tmp_path / name) if name else "")
    assert (code, out) == (2, "")
    assert err.startswith("zoh: error: --out must be ")
    assert err.count("\n") == 1


@pytest.mark.usefixtures("quick_report")
def test_nothing_is_half_written(good, run, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    code, _, err = run(good, "--out", str(tmp_path / "r"))
    assert code == 2
    assert "no space left on device" in err
    assert list((tmp_path / "r").iterdir()) == []


def test_without_matplotlib_it_says_what_brings_it(good, run, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    for name in [n for n in sys.modules if n.startswith(("matplotlib.", "zoh.report."))]:
        monkeypatch.delitem(sys.modules, name)
    code, _, err = run(good, "--out", str(tmp_path / "r"))
    assert code == 2
    assert "pip install 'zoh[plot]'" in err
    assert not (tmp_path / "r").exists()


# ---- what else can happen -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (KeyboardInterrupt(), 130, ""),
        (BrokenPipeError(), 141, ""),
        (
            FloatingPointError("overflow"),
            2,
            "zoh: error: the file must stay within a float's range",
        ),
        (MemoryError(), 2, "zoh: error: this needs more memory"),
        (PermissionError(13, "Permission denied", "x"), 2, "zoh: error: x: permission denied\n"),
        (ZohError("two\nlines"), 2, "zoh: error: two lines\n"),
        (RuntimeError("oops"), 70, "zoh: error: a defect of zoh, RuntimeError: oops"),
    ],
)
def test_no_traceback_whatever_happens(error, code, said, good, run, monkeypatch):
    def fail(*_):
        raise error

    monkeypatch.setattr(cli, "design_all", fail)
    monkeypatch.setattr(cli, "_abandon_stdout", lambda: None)  # pytest's stdout stays
    got, out, err = run(good)
    assert (got, out) == (code, "")
    assert err.startswith(said)
    assert err.count("\n") == (1 if said else 0)


def test_a_defect_shows_its_place_on_request(good, run, monkeypatch):
    monkeypatch.setattr(cli, "design_all", lambda *_: 1 / 0)
    monkeypatch.setenv("ZOH_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        run(good)


def _process(*arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", "zoh.app.cli", *map(str, arguments)],
        capture_output=True,
        check=False,
        timeout=120,
        **options,
    )


def test_a_reader_that_leaves_costs_no_traceback():
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "wb") as pipe:
        done = subprocess.run(
            [sys.executable, "-m", "zoh.app.cli", "design", EXAMPLES / "robot_arm.toml"],
            stdout=pipe,
            stderr=subprocess.PIPE,
            check=False,
            timeout=120,
        )
    assert (done.returncode, done.stderr) == (141, b"")


@pytest.mark.parametrize("more", [[], ["--json"]])
def test_a_terminal_without_unicode_is_no_obstacle(more, tmp_path, good):
    file = tmp_path / "p.toml"
    file.write_text(good.replace('"PI"', '"régulateur ∞"'), "utf-8")
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    done = _process("design", file, *more, env=environment)
    assert (done.returncode, done.stderr) == (0, b"")
    done.stdout.decode("ascii")


def test_the_process_exits_with_the_code():
    assert _process("design", "no such file").returncode == 2
    assert _process("check", PAPER).returncode == 1
    version = _process("--version")
    assert (version.returncode, version.stdout) == (0, f"zoh {zoh.__version__}\n".encode())


def test_json_needs_neither_rich_nor_matplotlib():
    code = (
        "import sys, zoh.app.cli as c; c.main(['design', sys.argv[1], '--json']);"
        "bad = {'rich', 'matplotlib', 'scipy', 'control'} & set(sys.modules);"
        "sys.exit(','.join(bad) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(EXAMPLES / "robot_arm.toml")],
        capture_output=True,
        check=False,
        timeout=120,
    )
    assert (done.returncode, done.stderr) == (0, b"")


def test_the_package_itself_runs_as_a_module():
    found = subprocess.run(
        [sys.executable, "-m", "zoh", "--version"], capture_output=True, text=True, check=True
    )
    assert zoh.__version__ in found.stdout


@pytest.mark.parametrize("verb", ["design", "check"])
@pytest.mark.parametrize(
    ("model", "dt", "gain", "said"),
    [
        ("-1/(s+5)", 0.001, 5.0, "unstable"),  # 1 + C P is 0 at rest
        ("s/(s+2)", 0.2, -1.0, "not proved to be stable"),  # z^2 - (1 + exp(-2 dt)) z + 1
    ],
)
def test_a_loop_on_the_limit_of_stability_is_refused(model, dt, gain, said, verb, run):
    late = dt if "2" in model else 0.0
    code, out, err = run(
        f'plant.model = "{model}"\nsampling.dt = {dt}\nsampling.compute_delay = {late}\n'
        f'[[controller]]\nlaw = "given"\nnum = [{gain}]\nden = [1]\n',
        verb=verb,
    )
    assert code == 1
    assert said in out + err
