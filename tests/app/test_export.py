"""``zoh export``: what scripts rely on, and files that are there whole or not at all."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

import zoh.app.cli as cli
from zoh.firmware import toolchain

EXAMPLES = Path(__file__).parents[2] / "examples"
ARM = EXAMPLES / "robot_arm.toml"
RANGES = """\
plant.model = "2.3/(s^2 + 0.7809 s)"
sampling.dt = 0.1
sensor = {gain = "12/180", range = [-12, 12], bits = 12}
actuator = {min = -12, max = 12}
[[controller]]
name = "PID 1"
law = "pid"
wc = 1.95
pm_deg = 40
ki = 0.85
[[controller]]
name = "pid-1"
law = "given"
num = [20, -18]
den = [1, -0.5]
"""


@pytest.fixture
def project(tmp_path):
    file = tmp_path / "project.toml"
    file.write_text(RANGES)
    return file


@pytest.mark.parametrize(
    ("name", "made"),
    [("int", "c_int"), ("Current (d/q)", "current_d_q"), ("2nd", "c_2nd"), ("_", "design")],
)
def test_any_name_of_a_controller_has_one_in_c(zoh_main, project, tmp_path, name, made):
    project.write_text(RANGES.replace('"PID 1"', f'"{name}"'))
    code, _, err = zoh_main("export", project, "--target", "c", "--out", tmp_path / "firmware")
    assert (code, err) == (0, f"zoh: wrote 9 files to {tmp_path / 'firmware'}\n")
    assert f"{made}_step(" in (tmp_path / "firmware" / f"{made}.h").read_text()


def test_every_controller_is_written_with_its_examples_and_one_readme(zoh_main, project, tmp_path):
    out = tmp_path / "firmware"
    code, said, err = zoh_main("export", project, "--target", "c", "--out", out)
    assert code == 0
    assert err == f"zoh: wrote 9 files to {out}\n"
    names = {"README.md"}
    for name in ("pid_1", "pid_1_2"):
        names |= {f"{name}.c", f"{name}.h", f"{name}_arduino.ino", f"{name}_stm32.c"}
    assert {p.name for p in out.iterdir()} == names
    assert "pid_1_2_step(" in (out / "pid_1_2.h").read_text()
    assert "PID 1: pid_1.h, pid_1.c; f32" in said
    before = {p.name: p.read_bytes() for p in out.iterdir()}
    code, _, err = zoh_main("export", project, "--target", "c", "--out", out)
    assert code == 2
    assert "--force" in err
    assert zoh_main("export", project, "--target", "c", "--out", out, "--force")[0] == 0
    assert before == {p.name: p.read_bytes() for p in out.iterdir()}


def test_json_is_one_object_with_every_text(zoh_main, project):
    code, out, err = zoh_main(
        "export", project, "--target", "c", "--number", "q15", "--controller", "PID 1", "--json"
    )
    assert (code, err) == (0, "")
    result = json.loads(out)
    (entry,) = result["controllers"]
    assert (entry["name"], entry["c_name"], entry["number"]) == ("PID 1", "pid_1", "q15")
    assert entry["exported"] is True
    assert entry["proof"] is None
    loss = abs(entry["margins"]["phase_margin_deg"] - entry["margins_as_built"]["phase_margin_deg"])
    assert entry["pm_loss_deg"] == loss < 0.1
    assert not [s for s in entry["said"] if "spans" in s]  # the file has both ranges
    assert sorted(result["files"]) == [
        "README.md", "pid_1.c", "pid_1.h", "pid_1_arduino.ino", "pid_1_stm32.c",
    ]  # fmt: skip


def test_what_the_file_leaves_open_of_whole_numbers_is_said(zoh_main):
    code, out, _ = zoh_main("export", ARM, "--target", "c", "--number", "q31", "--json")
    assert code == 0
    for entry in json.loads(out)["controllers"]:
        said = " ".join(entry["said"])
        assert "[sensor] has no range" in said
        assert "[actuator] has no two ends" in said


@pytest.mark.parametrize("number", ["q15", "q31", "f32", "f64", "auto"])
def test_the_robot_arm_in_every_number_keeps_its_margin(zoh_main, number):
    code, out, _ = zoh_main("export", ARM, "--target", "c", "--number", number, "--json")
    assert code == 0
    for entry in json.loads(out)["controllers"]:
        # of a degree: the word lengths are asked to keep the margin within this
        assert entry["pm_loss_deg"] <= 0.1
        assert entry["number"] == ("q15" if number == "auto" else number)


def test_a_table_without_ranges_is_no_reason_against_floats(zoh_main):
    # a table has no step that could say what whole numbers must span
    table = EXAMPLES / "buck_converter_measured.toml"
    code, out, _ = zoh_main("export", table, "--target", "c", "--number", "auto", "--json")
    assert code == 0
    for entry in json.loads(out)["controllers"]:
        assert entry["number"] == "f32"
        assert "not q15: y_range must be given" in " ".join(entry["said"])
    code, _, err = zoh_main("export", table, "--target", "c", "--number", "q15")
    assert code == 2
    assert "sensor.range must be given" in err


def test_a_controller_that_fails_is_named_and_the_others_are_exported(zoh_main, tmp_path):
    file = tmp_path / "project.toml"
    bad = '[[controller]]\nname = "hot"\nlaw = "given"\nnum = [9000]\nden = [1]\n'
    file.write_text(RANGES + bad)
    out = tmp_path / "firmware"
    code, _, err = zoh_main("export", file, "--target", "c", "--out", out)
    assert code == 1
    assert "hot: the closed loop is unstable" in err
    assert (out / "pid_1.c").exists()
    assert not (out / "hot.c").exists()


def test_bad_input_is_one_line_and_2(zoh_main, project, tmp_path, capsys):
    code, _, err = zoh_main("export", project, "--target", "c", "--controller", "PIDD")
    assert code == 2
    assert err.count("\n") == 1
    assert "must be one of PID 1, pid-1" in err
    for arguments in (["--target", "rust"], [], ["--target", "c", "--number", "f16"]):
        with pytest.raises(SystemExit) as stopped:
            cli.main(["export", str(project), *arguments])
        assert stopped.value.code == 2
        assert capsys.readouterr().err.count("\n") == 1
    # a gain that 16 bits do not hold beside the others, over a range that is far too wide
    file = tmp_path / "wide.toml"
    file.write_text(RANGES.replace("range = [-12, 12]", "range = [-12e6, 12e6]"))
    code, _, err = zoh_main("export", file, "--target", "c", "--number", "q15")
    assert code == 2
    assert 'controller "PID 1": ' in err


def test_a_missing_package_is_one_line(zoh_main, project, monkeypatch):
    def without(name):
        raise ModuleNotFoundError(name="ziglang")

    monkeypatch.setattr(toolchain, "import_module", without)
    code, _, err = zoh_main("export", project, "--target", "c", "--prove")
    assert code == 2
    assert err.count("\n") == 1
    assert "pip install 'zoh[firmware]' brings it" in err


def test_proved_costs_stand_in_header_readme_and_json(zoh_main, project, tmp_path):
    for needed in ("ziglang", "unicorn", "elftools", "capstone"):
        pytest.importorskip(needed)
    out = tmp_path / "firmware"
    code, text, err = zoh_main(
        "export", project, "--target", "c", "--number", "q15", "--controller", "PID 1",
        "--prove", "--json", "--out", out,
    )  # fmt: skip
    assert code == 0
    assert err == f"zoh: wrote 5 files to {out}\n"  # a bar is for a terminal
    proof = json.loads(text)["controllers"][0]["proof"]
    assert proof["equal"] is True
    assert len(proof["builds"]) == 16
    m0 = next(b for b in proof["builds"] if b["target"] == "Cortex-M0+" and b["level"] == "O2")
    counted = m0["instructions"]
    assert (
        f"Cortex-M0+ -O2: {counted['min']}, {counted['mean']:.1f}, {counted['max']}"
        in (out / "pid_1.h").read_text()
    )
    assert f"| Cortex-M0+ | -O2 | {counted['min']} |" in (out / "README.md").read_text()


def test_what_is_written_runs_with_a_compiler_of_the_users(zoh_main, project, tmp_path):
    gcc = shutil.which("gcc")
    if gcc is None:
        pytest.skip("gcc is not here; CI has it")
    out = tmp_path / "firmware"
    assert zoh_main("export", project, "--target", "c", "--number", "q31", "--out", out)[0] == 0
    main = '#include "pid_1.h"\nint main(void) { return (int)pid_1_selftest(); }\n'
    (out / "main.c").write_text(main)
    built = [gcc, "-std=c99", "-Wall", "-Wextra", "-Werror", "-O3", "main.c", "pid_1.c"]
    subprocess.run([*built, "-o", "main"], cwd=out, check=True)
    assert subprocess.run([out / "main"], check=False).returncode == 0
