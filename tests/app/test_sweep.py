"""``zoh sweep``: what a person reads, what a script parses, what is written, and the exit codes."""

import json
from io import StringIO

import pytest

import zoh
from zoh.app.over import read_over
from zoh.app.project import read
from zoh.app.sweep import job_of
from zoh.batch.reason import Reason
from zoh.batch.space import Random

ARM = zoh.Plant.parse("2.3/(s^2 + 0.7809 s)", sensor=12 / 180)
PD = """
[[controller]]
name = "PD"
law = "pd"
wc = 2
pm_deg = 60
"""
GIVEN = """
[[controller]]
name = "hot"
law = "given"
num = [300]
den = [1]
"""


def over(*texts, sample=None, ends=False, latin=False):
    return read_over(
        texts, sample=sample, seed=None if sample is None else 7, latin=latin, ends=ends
    )


def swept(run, text, *more):
    code, out, err = run(text, *more, "--json", verb="sweep")
    return code, json.loads(out) if out else None, err


def test_scripts_get_counts_extremes_and_the_yield(good, run):
    code, found, err = swept(run, good, "--over", "wc=0.4:4:10")
    assert (code, err) == (0, "")
    assert (found["zoh"], found["loops"]) == (zoh.__version__, 10)
    held = zoh.sweep(
        ARM, "pi", {"pm_deg": 40}, dt=0.1, over={"wc": [0.4 * k for k in range(1, 11)]}
    )
    ok = int((held["reason"] == Reason.OK).sum())
    assert found["reasons"]["ok"] == found["met"] == ok
    assert sum(found["reasons"].values()) == 10
    assert found["yield"] == ok / 10
    (one,) = found["sweeps"]
    assert (one["name"], one["law"]) == ("PI", "pi")
    assert one["computed_by"].startswith("computed by single; ")  # ten loops pay for no start
    worst = held.worst("ms")
    assert one["extremes"]["ms"]["most"] == pytest.approx(worst.value, rel=1e-9)
    assert one["extremes"]["ms"]["most_over"] == {"wc": pytest.approx(worst.at["wc"])}
    assert found["extremes"]["ms"]["most"] == one["extremes"]["ms"]["most"]
    assert "yield_interval_95" not in one


def test_people_read_the_yield_the_reasons_and_the_worst(good, run):
    code, out, err = run(good, "--over", "wc=0.4:4:10", verb="sweep")
    assert (code, err) == (0, "")
    # the plant alone has a margin of 40 deg at 0.854 rad/s, above which a PI would have to lead
    assert "PI: 20 % of 10 loops are as asked and keep every requirement" in out
    assert "8 loops: the law cannot do what is asked at this crossover" in out
    assert "worst peak of the sensitivity, Ms: " in out
    assert "worst crossover frequency: 0.4 rad/s at wc = 0.4" in out


def test_a_sample_has_a_seed_and_an_interval(good, run):
    asked = ("--over", "plant.gain=2.3~0.1", "plant.den.1=0.7:0.9", "--sample", "20")
    first, again, other = (
        swept(run, good, *asked, "--seed", seed)[1]["sweeps"][0] for seed in ("1", "1", "2")
    )
    assert first == again != other
    low, high = first["yield_interval_95"]
    assert low < first["yield"] <= high


def test_a_controller_that_is_fixed_is_designed_once(good, run):
    code, found, _ = swept(run, good, "--over", "plant.gain=2:3", "--corners", "--fixed")
    assert code == 0
    d = zoh.pi(ARM, dt=0.1, wc=0.8, pm_deg=40)
    worst = max(
        zoh.verify(zoh.Plant(num=[k], den=[1, 0.7809, 0], sensor=12 / 180), d.controller).margins.ms
        for k in (2, 3)
    )
    ends = found["sweeps"][0]["extremes"]
    # 0.7809 is a decimal in the file and a float here
    assert ends["ms"]["most"] == pytest.approx(worst, rel=1e-12)
    assert ends["phase_margin_deg"]["least"] != ends["phase_margin_deg"]["most"]


def test_several_controllers_are_swept_one_by_one_and_counted_together(good, run):
    code, found, _ = swept(run, good + PD, "--over", "wc=0.8:2:2")
    assert code == 0
    assert [one["name"] for one in found["sweeps"]] == ["PI", "PD"]
    assert found["loops"] == sum(one["loops"] for one in found["sweeps"]) == 4
    code, found, _ = swept(run, good + PD, "--over", "wc=0.8:2:2", "--controller", "PD")
    assert [one["name"] for one in found["sweeps"]] == ["PD"]


def test_a_loop_that_nobody_can_have_is_exit_1(good, run):
    code, _, err = swept(run, good, "--over", "wc=3:4:2")
    assert code == 1
    assert err == "zoh: error: no loop is as asked and keeps every requirement: PI\n"
    code, found, _ = swept(run, good + GIVEN, "--over", "dt=0.1", "--controller", "hot")
    assert code == 1
    assert found["reasons"]["unstable"] == 1


def test_loops_are_written_to_the_file_that_is_named(good, run, tmp_path):
    xarray = pytest.importorskip("xarray")
    asked = ("--over", "plant.gain=2:3:4")
    for name, opened in (
        ("a.nc", lambda p: xarray.open_dataset(p, engine="h5netcdf")),
        ("a.zarr", zoh.open_sweep),
    ):
        path = str(tmp_path / name)
        code, found, err = swept(run, good, *asked, "--out", path)
        assert (code, err) == (0, f"zoh: wrote {path}\n")
        with opened(path) as stored:
            assert float(stored["ms"].max()) == found["extremes"]["ms"]["most"]
            assert stored["plant.gain"].values.tolist() == pytest.approx(
                [2, 2 + 1 / 3, 2 + 2 / 3, 3]
            )
    code, _, err = swept(run, good, *asked, "--out", str(tmp_path / "a.nc"))
    assert code == 2
    assert "must not be there already" in err
    assert swept(run, good, *asked, "--out", str(tmp_path / "a.zarr"))[0] == 0  # it is all there


def test_a_file_that_cannot_be_written_is_refused_before_the_work(run, good, tmp_path, monkeypatch):
    monkeypatch.setattr("zoh.app.sweep.sweep_of", lambda *_, **__: pytest.fail("worked"))
    for old in ("old.nc", "old.zarr"):
        (tmp_path / old).write_text("")
    figures = ("--figures", str(tmp_path / "figures"))
    for name, sentence in (
        ("old.nc", "must not be there already"),
        ("old.zarr", "must not be there already"),
        ("no/a.nc", "in a folder that"),
    ):
        out = str(tmp_path / name)
        code, _, err = swept(run, good, "--over", "wc=1:2:3", "--out", out, *figures)
        assert code == 2
        assert sentence in err


def test_figures_are_drawn_in_the_folder_that_is_named(good, run, tmp_path):
    pytest.importorskip("matplotlib")
    folder = tmp_path / "figures"
    asked = ("--over", "wc=0.4:0.8:3", "--figures", str(folder))
    code, found, err = swept(run, good, *asked)
    assert code == 0
    names = {file.name for file in folder.iterdir()}
    assert {"pi-ms.svg", "pi-peak-effort.png", "sweep.json"} <= names
    assert err == f"zoh: wrote {len(names)} files to {folder}\n"
    assert json.loads((folder / "sweep.json").read_text()) == found
    code, _, err = swept(run, good, *asked)
    assert code == 2
    assert "must not hold a file of that name already" in err


@pytest.mark.parametrize(
    ("space", "names"),
    [
        ({"wc": [0.4, 0.8], "pm_deg": [40, 50]}, ["ms", "settling_time"]),
        ({"wc": [0.4, 0.8], "plant.gain": [2.3]}, ["ms", "peak_effort"]),
        (
            zoh.Random(spreads={"wc": zoh.Uniform(low=0.4, high=0.8)}, count=5),
            ["ms over wc", "between.overshoot_pct over wc"],
        ),
    ],
)
def test_a_grid_is_a_map_or_a_line_and_a_sample_is_bands(space, names):
    pytest.importorskip("matplotlib")
    from zoh.app.sweep_figures import drawn_of

    held = zoh.sweep(ARM, "pi", {"pm_deg": 40, "wc": 0.5}, dt=0.1, over=space)
    assert set(names) <= {name for name, _ in drawn_of(held, "PI")}


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--over", "wcc=1:2:3"), "over must name what this loop has, got 'wcc': dt,"),
        (("--over", "wc"), "--over must be KEY="),
        (("--over", "wc=1:2"), "--over wc must be FROM:TO:N"),
        (("--over", "wc=a:2:3"), "--over wc must be FROM:TO:N"),
        (("--over", "wc=1:2:0"), "--over wc must be a whole number of 1 or more"),
        (("--over", "wc=0:2:3:log"), "--over wc must be above 0"),
        (("--over", "wc=1", "wc=2"), "--over must name a key once"),
        (("--over", "wc=1:2:3", "--sample", "5"), "--over wc must be FROM:TO, FROM:TO:log or"),
        (("--over", "wc=1:2", "--sample", "0"), "count must be a whole number of 1 or more"),
        (("--over", "wc=1:2", "--sample", "5", "--corners"), "--corners must not stand beside"),
        (("--over", "wc=1:2:3", "--latin"), "--latin must stand beside --sample"),
        (("--over", "wc=1:2:3", "--seed", "0"), "--seed must stand beside --sample, got 0"),
        (("--over", "wc=1:2", "--corners", "--seed", "3"), "--seed must stand beside --sample"),
        (("--over", "wc=1:2:3", "--controller", "PX"), "--controller must be in the file"),
        (("--over", "wc=1:2:3", "--out", "a.csv"), "--out must end in .nc or .zarr"),
        (("--over", "wc=1:2:3", "--arithmetic", "abacus"), "arithmetic must be one of"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(good, run, more, said):
    code, found, err = swept(run, good, *more)
    assert (code, found) == (2, None)
    assert said in err
    assert err.count("\n") == 1


def test_one_file_is_of_one_controller(good, run):
    code, _, err = swept(run, good + PD, "--over", "wc=1", "--out", "a.nc")
    assert code == 2
    assert "--out must be of one controller, got 'PI, PD': add --controller NAME" in err


def test_what_varies_is_read_as_it_is_written():
    assert over("wc=1:2:3", "ki=5,7").columns(0, 6) == {
        "wc": pytest.approx([1, 1, 1.5, 1.5, 2, 2]),
        "ki": pytest.approx([5, 7, 5, 7, 5, 7]),
    }
    assert over("dt=0.01:1:3:log").columns(0, 3)["dt"] == pytest.approx([0.01, 0.1, 1])
    assert over("wc=1:2", ends=True).columns(0, 2)["wc"].tolist() == [1, 2]
    drawn = over("wc=1:2", "dt=0.01:1:log", "ki=5~0.5", sample=9, latin=True)
    assert isinstance(drawn, Random)
    assert (drawn.count, drawn.seed, drawn.latin) == (9, 7, True)
    assert drawn.spreads == {
        "wc": zoh.Uniform(low=1, high=2),
        "dt": zoh.LogUniform(low=0.01, high=1),
        "ki": zoh.Normal(mean=5, sd=0.5),
    }


ROOTS = """\
plant.zeros = []
plant.poles = [0, -0.7809]
plant.gain = 2.3
sampling.dt = 0.1
"""
JOINT = """\
sampling.dt = 0.1
[plant.joint]
torque_constant = 0.5
resistance = 2.0
motor_inertia = 0.25
"""


@pytest.mark.parametrize(
    ("text", "key"),
    [(ROOTS, "plant.pole.1=-0.9:-0.5:3"), (JOINT, "plant.joint.load_inertia=0:0.5:3")],
)
def test_roots_and_joints_vary_by_their_own_names(run, text, key):
    code, found, err = swept(run, text + PD, "--over", key)
    assert (code, err) == (0, "")
    assert found["met"] == 3


def test_a_terminal_shows_the_progress(good, run, monkeypatch):
    class Terminal(StringIO):
        def isatty(self):
            return True

    shown = Terminal()
    monkeypatch.setattr("sys.stderr", shown)
    monkeypatch.setenv("TERM", "xterm")
    code, out, _ = run(
        good, "--over", "wc=0.4:0.8:600", "--arithmetic", "single", "--json", verb="sweep"
    )
    assert code == 0
    assert json.loads(out)["loops"] == 600
    assert "PI" in shown.getvalue()
    assert "loops/s" in shown.getvalue()


def test_a_table_does_not_vary(run):
    text = """
        plant.frequency_response = "a.csv"
        plant.response_of = "sampled"
        sampling.dt = 1e-5
    """
    table = "hz,db,deg\n100,20,-60\n1000,0,-90\n10000,-20,-120\n"
    project = read(text + PD, attached=lambda name: table)
    with pytest.raises(zoh.SpecError, match="plant must be a model"):
        job_of(project, project.controllers[0], zoh.Grid(axes={"wc": [1.0]}))


def test_a_controller_alone_has_no_weights_of_the_reference(good, run):
    """Swept as it stands, its step would be that of another reference path."""
    weighted = good.replace('law = "pi"', 'law = "pi"\nsetpoint_weight = 0.5')
    assert weighted != good
    assert swept(run, weighted, "--over", "plant.gain=2,2.3")[0] == 0  # each loop has its own
    code, out, err = swept(run, weighted, "--over", "plant.gain=2,2.3", "--fixed")
    assert (code, out) == (2, None)
    assert "setpoint_weight must be 1 for --fixed" in err


def test_permissions_of_the_file_are_not_passed_over(good, run):
    allowing = good.replace('law = "pi"', 'law = "pi"\nallow = ["negative_gains"]')
    code, _, err = swept(run, allowing, "--over", "plant.gain=2,2.3")
    assert code == 2
    assert "allow must be empty in a sweep" in err
