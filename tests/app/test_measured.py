"""Project files whose plant is a table beside them."""

import json
from math import pi
from pathlib import Path

import numpy as np
import pytest

import zoh.app.cli as cli
from zoh.app.project import read
from zoh.errors import SpecError

EXAMPLES = Path(__file__).parents[2] / "examples"
PROJECT = """\
[plant]
frequency_response = "plant.csv"
response_of = "sampled"
[sampling]
dt = 0.1
[[controller]]
name = "P"
law = "p"
wc = 1.0
pm_deg = 87.0
[[controller]]
law = "given"
num = [0.5]
den = [1]
"""
ROWS = "".join(f"{w},{1 / w:.17g},{-90 - w * 3}\n" for w in (0.1, 0.3, 1.0, 3.0, 10.0))
TABLE = "w,magnitude,phase_deg\n" + ROWS


@pytest.fixture
def go(tmp_path, capsys):
    """Return a function: a project and its table in, (code, stdout, stderr) out."""

    def command(project, table, *more, verb="design"):
        (tmp_path / "project.toml").write_text(project)
        (tmp_path / "plant.csv").write_text(table)
        code = cli.main([verb, str(tmp_path / "project.toml"), *more])
        out, err = capsys.readouterr()
        return code, out, err

    return command


def test_design_and_check_work_on_a_table(go):
    code, out, _ = go(PROJECT, TABLE, "--json")
    result = json.loads(out)
    assert code == 0
    one, given = result["designs"]
    assert one["gains"]["kp"] == pytest.approx(1.0, rel=1e-12)
    assert one["margins"]["phase_margin_deg"] == pytest.approx(87.0, abs=1e-9)
    assert one["margins"]["band"] == [0.1, 10.0]
    assert one["step"] is None
    assert given["margins"]["stable"] is True
    assert result["plant"] == {
        "num": None,
        "den": None,
        "dt": 0.1,
        "frequency_response": {"band": [0.1, 10.0], "points": 5},
    }
    assert any(
        "crossings below 0.1 and above 10 rad/s are not seen" in w for w in result["warnings"]
    )
    code, out, _ = go(PROJECT, TABLE, verb="check")
    assert code == 0
    assert "phase margin, deg" in out


def test_the_table_for_people_says_stable_or_not_decided(go):
    code, out, _ = go(PROJECT, TABLE)
    assert code == 0
    assert "closed loop" in out
    assert "stable" in out
    short = TABLE.replace("3.0,", "3.0,9").replace("10.0,", "10.0,9")
    code, out, err = go(PROJECT, short, verb="check")
    assert code == 1
    assert "not decided" in out
    assert "the table does not decide stability" in err


def test_requirements_on_a_step_are_misses(go):
    code, _, err = go(PROJECT + "[requirements]\novershoot_pct = 10\n", TABLE, verb="check")
    assert code == 1
    assert "overshoot_pct is asked, and a table of margins does not show it" in err


def test_a_report_without_figures_of_responses(go, tmp_path):
    code, _, _ = go(PROJECT, TABLE, "--out", str(tmp_path / "report"))
    assert code == 0
    text = (tmp_path / "report" / "REPORT.md").read_text()
    assert "taken for granted: the plant has no unstable pole" in text
    assert "| closed loop | stable | stable |" in text


SAME = {
    "header, comments, semicolons": "# from the bench\nW;Magnitude;Phase_deg;remarks\n"
    + ROWS.replace(",", ";").replace("\n", ";fine\n"),
    "another order": "phase_deg,w,magnitude\n"
    + "".join(f"{p},{w},{m}\n" for w, m, p in (r.split(",") for r in ROWS.split())),
    "Hz and dB": "Hz,dB,deg\n"
    + "".join(
        f"{float(w) / (2 * pi):.17g}\t{20 * np.log10(float(m)):.17g}\t{p}\n"
        for w, m, p in (r.split(",") for r in ROWS.split())
    ),
}


@pytest.mark.parametrize("how", SAME)
def test_every_way_to_write_the_table_is_the_same(how):
    plant = read(PROJECT, lambda name: SAME[how]).plant
    exact = read(PROJECT, lambda name: TABLE).plant
    assert plant.w == pytest.approx(exact.w, rel=1e-14)
    assert plant.magnitude == pytest.approx(exact.magnitude, rel=1e-14)
    assert plant.phase_deg == pytest.approx(exact.phase_deg, rel=1e-14)
    assert plant.dt == 0.1


def test_columns_and_coherence_and_unstable_poles():
    project = PROJECT.replace(
        'response_of = "sampled"',
        'response_of = "sampled"\ncolumns = ["w", "ratio", "deg", "coherence"]\naverages = 50\n'
        "unstable_poles = 2",
    )
    rows = "".join(f"{row},0.5\n" for row in ROWS.split())
    plant = read(project, lambda name: rows).plant
    assert plant.uncertainty == pytest.approx([0.1] * 5)  # sqrt(0.5/(2 50 0.5))
    assert plant.unstable_poles == 2


def test_a_continuous_table_takes_the_sensor_and_the_delay():
    project = PROJECT.replace("sampled", "continuous").replace(
        "dt = 0.1", 'dt = 0.1\ncompute_delay = 0.02\n[sensor]\ngain = "1/2"'
    )
    made = read(project, lambda name: TABLE)
    assert made.plant.dt is None
    assert made.plant.magnitude[2] == pytest.approx(0.5)
    assert made.compute_delay == 0.02


BAD = [
    ({'response_of = "sampled"\n': ""}, TABLE, "plant.response_of must be given"),
    ({'"sampled"': '"analog"'}, TABLE, "plant.response_of must be one of two, got 'analog'"),
    ({"plant.csv": "../plant.csv"}, TABLE, "must be in the folder of the project file or below"),
    ({"plant.csv": "/plant.csv"}, TABLE, "must be in the folder of the project file or below"),
    ({"plant.csv": "none.csv"}, TABLE, "plant.frequency_response must be a file that can be read"),
    ({"[sampling]": 'model = "1/s"\n[sampling]'}, TABLE, "must not stand beside"),
    ({"[sampling]": "dead_time = 0.1\n[sampling]"}, TABLE, "plant.dead_time must be left out"),
    ({"[sampling]": "[sensor]\ngain = 2\n[sampling]"}, TABLE, "sensor.gain must be left out"),
    ({"dt = 0.1": "dt = 0.1\ncompute_delay = 0.1"}, TABLE, "sampling.compute_delay must be left"),
    (
        {"[sampling]": "unstable_poles = -1\n[sampling]"},
        TABLE,
        "error: plant.unstable_poles must be a whole",
    ),
    ({"[sampling]": "columns = 3\n[sampling]"}, TABLE, "plant.columns must be names, got 3"),
    (
        {"[sampling]": 'columns = ["w", "deg"]\n[sampling]'},
        TABLE,
        "plant.columns must name one gain column",
    ),
    ({"[sampling]": "colums = 3\n[sampling]"}, TABLE, "did you mean columns?"),
    ({"dt = 0.1": "dt = 1.0"}, TABLE, "must not go beyond the Nyquist frequency"),
    ({}, "", "must have 2 to 100000 rows, got 0"),
    ({}, "a,b,c\n" + ROWS, "must name one frequency column"),
    ({}, ROWS, "must name one frequency column"),
    ({}, "w,magnitude,dB,deg\n1,1,0,0\n2,1,0,0", "must name one gain column"),
    ({}, TABLE.replace("0.3,", "fast,"), "line 3 must have a number for w, got 'fast'"),
    ({}, TABLE + "20,0.1\n", "line 7 must have a number for phase_deg, got ''"),
    ({}, TABLE + "nan,1,2\n", "w must be finite"),
    ({}, TABLE + "5,1,2\n", "w[5] must be above w[4], got 5.0"),
    ({}, TABLE + "20,0,2\n", "magnitude[5] must be above 0, got 0.0"),
    ({}, "w,ratio,deg,coherence\n1,1,0,0.9\n2,1,0,0.9", "error: plant.averages must be given"),
    ({"[sampling]": "averages = 0\n[sampling]"}, TABLE, "error: plant.averages must be"),
    ({}, "w,ratio,deg\n1,1,0", "w must have two points or more"),
]


@pytest.mark.parametrize(("changes", "table", "says"), BAD)
def test_bad_input_is_one_line_that_names_it(go, changes, table, says):
    project = PROJECT
    for old, new in changes.items():
        assert old in project
        project = project.replace(old, new)
    code, out, err = go(project, table, verb="check")
    assert (code, out) == (2, "")
    assert says in err
    assert err.count("\n") == 1


def test_a_text_without_a_folder_names_no_file():
    with pytest.raises(SpecError, match="must not name a file where there is no folder"):
        read(PROJECT)


def test_the_example_is_met_and_its_file_says_that_it_is_computed(capsys):
    code = cli.main(["design", str(EXAMPLES / "buck_converter_measured.toml"), "--json"])
    result = json.loads(capsys.readouterr().out)
    assert code == 0
    assert [d["met"] for d in result["designs"]] == [True, True]
    text = (EXAMPLES / "buck_converter_measured.csv").read_text()
    assert text.startswith("# COMPUTED, not measured")


def test_the_example_is_the_formula_in_its_header():
    # by the textbook's modified z-transform of the partial fractions, half a period of delay
    inductance, capacitance, load, series, dt = 50e-6, 500e-6, 3.0, 0.02, 1e-5
    den = [inductance * capacitance, inductance / load + series * capacitance, 1.0]
    num = np.array([28 / 3 * series * capacitance, 28 / 3])
    plant = read(
        (EXAMPLES / "buck_converter_measured.toml").read_text(),
        lambda name: (EXAMPLES / name).read_text(),
    ).plant
    z = np.exp(1j * plant.w * dt)
    total = num[-1] * z / (z - 1)
    for p in np.roots(den):
        residue = np.polyval(num, p) / (p * np.polyval(np.polyder(den), p))
        total = total + residue * np.exp(p * dt / 2) * z / (z - np.exp(p * dt))
    exact = total * (1 - 1 / z) / z
    # printed to 0.001 dB and 0.01 deg, so half of that and rounding
    assert 20 * np.log10(np.abs(exact)) == pytest.approx(
        20 * np.log10(plant.magnitude), abs=5.01e-4
    )
    turned = np.degrees(np.angle(exact * np.exp(-1j * np.radians(plant.phase_deg))))
    assert turned == pytest.approx(np.zeros(len(z)), abs=5.01e-3)
