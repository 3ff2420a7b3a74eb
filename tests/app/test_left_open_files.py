"""A project file that leaves things open, the actuator's ends among what is asked."""

import json

import pytest

from zoh.app.cli import main

FILE = """
[plant]
model = "2.3/(s^2 + 0.7809 s)"
[sensor]
gain = {gain}
[actuator]
min = -8.0
max = 12.0
[sampling]
dt = 0.1
[[controller]]
law = "{law}"
{more}
[requirements]
pm_deg = 45
ms = 1.7
[reference]
step = 30.0
"""


def designed(tmp_path, capsys, **fields):
    file = tmp_path / "loop.toml"
    file.write_text(FILE.format(**{"gain": 0.05, "law": "pd", "more": "", **fields}))
    code = main(["design", str(file), "--json"])
    said = capsys.readouterr()
    return code, json.loads(said.out) if said.out else said.err


def test_the_actuator_limits_what_is_chosen(tmp_path, capsys):
    code, out = designed(tmp_path, capsys)
    design = out["designs"][0]
    low, high = (0.05 * u for u in design["step"]["effort_range"])
    # 2e-4: the edge is closed in on to 1e-4 of the crossover
    assert (low >= -8.0, high <= 12 * (1 + 1e-9)) == (True, True)
    assert high == pytest.approx(12.0, rel=1e-3) or low == pytest.approx(-8.0, rel=1e-3)
    assert code == 0
    assert design["choice"]["open"] == ["wc", "pm_deg"]
    assert any("effort" in sentence for sentence in design["choice"]["limits"])
    assert out["warnings"] == []  # nothing saturates


def test_a_sensor_that_counts_backwards_turns_the_ends(tmp_path, capsys):
    code, out = designed(tmp_path, capsys, gain=-0.05)
    assert code == 1  # no law of positive gains closes this loop
    assert out["designs"][0]["feasible"] is False
    assert "no pd meets everything asked" in out["designs"][0]["reason"]


def test_what_is_given_is_not_bent_by_the_actuator(tmp_path, capsys):
    code, out = designed(tmp_path, capsys, more="wc = 3.0\npm_deg = 60")
    assert code == 0
    assert out["designs"][0]["choice"] is None
    assert "saturates" in out["warnings"][0]


def test_auto_in_a_file(tmp_path, capsys):
    code, out = designed(tmp_path, capsys, law="auto")
    assert (code, out["designs"][0]["law"]) == (0, "p")
    code, err = designed(tmp_path, capsys, law="auto", more="ki = 1")
    assert code == 2
    assert "ki" in err


def test_explain_writes_the_maps(tmp_path, capsys):
    file, out = tmp_path / "loop.toml", tmp_path / "out"
    file.write_text(FILE.format(gain=0.05, law="pd", more="wc = 3.0\npm_deg = 60"))
    assert main(["explain", str(file), "--out", str(out)]) == 0
    capsys.readouterr()
    names = ["explain.json", "map-pd.json", "map-pd.png", "map-pd.svg"]
    assert sorted(p.name for p in out.iterdir()) == names
    assert json.loads((out / "map-pd.json").read_text())["law"] == "pd"
    assert json.loads((out / "explain.json").read_text())["designs"][0]["law"] == "pd"
    assert main(["explain", str(file), "--out", str(out)]) == 2  # nothing is replaced unasked
