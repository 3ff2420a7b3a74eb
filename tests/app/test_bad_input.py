"""Bad input: one line that names the key, the bound and the value, exit code 2, no traceback."""

import re

import numpy as np
import pytest

import zoh.app.cli as cli
from zoh.analysis.margins import margins
from zoh.analysis.verify import verify
from zoh.app.project import read
from zoh.errors import Infeasible, NotMet, SpecError, ZohError
from zoh.lti.systems import Plant, Sampled
from zoh.pipeline import design
from zoh.sampling.hold import sample

MODEL = 'model = "2.3/(s^2 + 0.7809 s)"'

# (what to replace, by what, what the line must say: key, bound, value)
CHANGES = [
    # the plant's model
    (MODEL, 'model = ""', ["plant.model", "must not be empty", "''"]),
    (MODEL, "model = 3", ["plant.model", "must be a formula in quotes", "got 3"]),
    (MODEL, 'model = "1/(s-s)"', ["plant.model", "must not divide by zero", "'1/(s-s)'"]),
    (MODEL, 'model = "s^2/(s+1)"', ["plant.num", "degree in s than den (1)", "got 2"]),
    (MODEL, 'model = "0/(s+1)"', ["plant.num", "must not be all zeros", "[0.0]"]),
    (MODEL, 'model = "1/(s+1)^51"', ["plant.model", "exponents of 50", "'1/(s+1)^51'"]),
    (MODEL, 'model = "1/s^99999999999"', ["plant.model", "exponents of 50", "99999999999"]),
    (MODEL, 'model = "1e9999/s"', ["plant.model", "64-bit float", "1e9999"]),
    (MODEL, 'model = "1/2s"', ["plant.model", "(1/2)*s or 1/(2*s)", "'1/2s'"]),
    (MODEL, 'model = "K/(s+1)"', ["plant.model", "not 'K'", "position 1"]),
    (MODEL, 'model = "1/(s+1"', ["plant.model", "')' for every '('", "position 7"]),
    (MODEL, 'model = "exp(0.1 s)/s"', ["plant.model", "exp() of -T*s", "exp(0.1 s)/s"]),
    (MODEL, 'model = "exp(-0.1 s)/s"\ndead_time = 0.2', ["plant.dead_time", "one place", "0.2"]),
    # other forms of the plant
    (MODEL, "", ["plant.model", "must be given", "nothing", "num, den"]),
    (MODEL, MODEL + "\nnum = [1]", ["plant.num", "must not stand beside model", "[1]"]),
    (MODEL, "num = [1]", ["plant.den", "must be given", "nothing"]),
    (MODEL, "num = []\nden = [1, 1]", ["plant.num", "at least one coefficient", "[]"]),
    (MODEL, "num = [1]\nden = [0, 0]", ["plant.den", "must not be all zeros", "[0.0"]),
    (MODEL, "num = [0]\nden = [1, 1]", ["plant.num", "must not be all zeros", "[0.0]"]),
    (MODEL, "num = [1, 0, 0]\nden = [1, 1]", ["plant.num", "higher degree", "got 2"]),
    (MODEL, "num = 1\nden = [1, 1]", ["plant.num", "must be a list of numbers", "got 1"]),
    (MODEL, 'num = ["a"]\nden = [1]', ["plant.num[0]", "must be a real number", "'a'"]),
    (MODEL, "num = [true]\nden = [1]", ["plant.num[0]", "must be a real number", "True"]),
    (MODEL, "num = [nan]\nden = [1, 1]", ["plant.num[0]", "must be finite", "nan"]),
    (MODEL, "num = [1]\nden = [inf, 1]", ["plant.den[0]", "must be finite", "inf"]),
    (MODEL, f"num = [1]\nden = {[1] * 60}", ["plant.den", "order 50 or less", "got 59"]),
    (MODEL, f"num = [1]\nden = [1{'0' * 400}]", ["plant.den[0]", "64-bit float", "1000"]),
    (MODEL, "poles = [-1]", ["plant.gain", "must be given", "nothing"]),
    (MODEL, "poles = [[-1, 2]]\ngain = 1", ["plant.poles", "conjugate pairs", "(-1+2j)"]),
    (MODEL, 'poles = ["x"]\ngain = 1', ["plant.poles[0]", "must be a number", "'x'"]),
    (MODEL, 'poles = ["nan"]\ngain = 1', ["plant.poles", "must be finite", "nan"]),
    (MODEL, "poles = [[1, 2, 3]]\ngain = 1", ["plant.poles[0]", "pair [re, im]", "[1, 2, 3]"]),
    (MODEL, "poles = -1\ngain = 1", ["plant.poles", "must be a list of roots", "got -1"]),
    (MODEL, "poles = []\nzeros = [1]\ngain = 1", ["plant.num", "higher degree", "got 1"]),
    (MODEL, "poles = [-1]\ngain = true", ["plant.gain", "must be a real number", "True"]),
    (MODEL, "A = [[1, 2]]\nB = [1]\nC = [1]", ["plant.A", "must be square", "[1, 2]"]),
    (MODEL, "A = [[1, 2], [3]]\nB = [1]\nC = [1]", ["plant.A", "rows of one length"]),
    (MODEL, "A = [[-1]]\nB = [1, 2]\nC = [1]", ["plant.B", "must have 1 entries", "got 2"]),
    (MODEL, "A = [[true]]\nB = [1]\nC = [1]", ["plant.A[0][0]", "real number", "True"]),
    (MODEL, "A = [[nan]]\nB = [1]\nC = [1]", ["plant.A[0][0]", "must be finite", "nan"]),
    (MODEL, "A = [[-1]]\nC = [1]", ["plant.B", "must be given", "nothing"]),
    (MODEL, "joint = 3", ["plant.joint", "must be a table", "got 3"]),
    (MODEL, "joint = {}", ["plant.joint.torque_constant", "must be given", "nothing"]),
    (
        MODEL,
        "joint = {torque_constant = 1, resistance = 0, motor_inertia = 1}",
        ["plant.joint.resistance", "must be above 0", "got 0"],
    ),
    (
        MODEL,
        "joint = {torque_constant = 1, resistance = 1, motor_inertia = 1, inductanse = 1}",
        ["plant.joint.inductanse", "a key that zoh knows", "did you mean inductance?"],
    ),
    (
        MODEL,
        'output_unit = "deg"\njoint = {torque_constant = 1, resistance = 1, motor_inertia = 1}',
        ["plant.output_unit", "that of the joint, 'rad'", "'deg'"],
    ),
    (MODEL, MODEL + "\ndead_time = -0.1", ["plant.dead_time", "must be 0 or more", "-0.1"]),
    (MODEL, MODEL + "\ndead_time = nan", ["plant.dead_time", "must be finite", "nan"]),
    (MODEL, MODEL + "\ndead_time = 1e9", ["dead_time", "at most 10000 samples", "1000000000.0"]),
    (MODEL, MODEL + "\ninput_unit = 3", ["plant.input_unit", "must be a text", "got 3"]),
    (MODEL, "modle = '1/s'", ["plant.modle", "that zoh knows", "did you mean model?"]),
    # sections
    ("[plant]\n" + MODEL, "", ["plant", "must be given", "nothing"]),
    ("[plant]\n" + MODEL, "plant = 1", ["plant", "must be a table", "got 1"]),
    ("[sampling]\ndt = 0.1", "", ["sampling.dt", "must be given", "nothing"]),
    ("[sampling]", "[samplin]", ["samplin", "did you mean sampling?"]),
    ("[sampling]", "[plant]", ["file", "must be TOML", "line"]),
    # sampling
    ("dt = 0.1", "dt = 0", ["sampling.dt", "must be above 0", "got 0"]),
    ("dt = 0.1", "dt = -0.1", ["sampling.dt", "must be above 0", "-0.1"]),
    ("dt = 0.1", "dt = nan", ["sampling.dt", "must be finite", "nan"]),
    ("dt = 0.1", "dt = inf", ["sampling.dt", "must be finite", "inf"]),
    ("dt = 0.1", 'dt = "0.1"', ["sampling.dt", "must be a real number", "'0.1'"]),
    ("dt = 0.1", "dt = true", ["sampling.dt", "must be a real number", "True"]),
    ("dt = 0.1", "dt = [0.1]", ["sampling.dt", "must be a real number", "[0.1]"]),
    ("dt = 0.1", "dt = 0.1\ndelay = 1", ["sampling.delay", "that zoh knows", "got 1"]),
    ("dt = 0.1", "dt = 0.1\ncompute_delay = -1", ["sampling.compute_delay", "0 or more", "-1"]),
    ("dt = 0.1", "dt = 0.1\ncompute_delay = 1e9", ["compute_delay", "10000 samples", "1000000000"]),
    # sensor, actuator, reference
    ('gain = "12/180"', "gain = 0", ["sensor.gain", "must not be 0", "got 0.0"]),
    ('gain = "12/180"', 'gain = "12/0"', ["sensor.gain", "divide by zero", "'12/0'"]),
    ('gain = "12/180"', 'gain = "s"', ["sensor.gain", "must be a plain number", "'s'"]),
    ('gain = "12/180"', "gain = inf", ["sensor.gain", "must be finite", "inf"]),
    ('gain = "12/180"', "gain = [1]", ["sensor.gain", "must be a real number", "[1]"]),
    ('gain = "12/180"', "bits = 10", ["sensor.range", "must be given", "nothing"]),
    ('gain = "12/180"', "bits = 99\nrange = [0, 1]", ["sensor.bits", "1 to 32", "got 99"]),
    ('gain = "12/180"', "bits = true\nrange = [0, 1]", ["sensor.bits", "1 to 32", "True"]),
    ('gain = "12/180"', "range = [1, 0]", ["sensor.range", "lo < hi", "[1.0, 0.0]"]),
    ('gain = "12/180"', "range = [1]", ["sensor.range", "lo < hi", "[1.0]"]),
    ("[sensor]", "[actuator]\nmin = 3\nmax = 2\n[sensor]", ["actuator.max", "min = 3.0", "2.0"]),
    ("[sensor]", "[actuator]\nmin = nan\n[sensor]", ["actuator.min", "must be finite", "nan"]),
    ("[sensor]", "[reference]\nstep = 0\n[sensor]", ["reference.step", "must not be 0", "0"]),
    ("[sensor]", "[reference]\nstep = inf\n[sensor]", ["reference.step", "be finite", "inf"]),
    # requirements
    ("[sensor]", "[requirements]\npm = 40\n[sensor]", ["requirements.pm", "did you mean pm_deg?"]),
    ("[sensor]", "[requirements]\nms = 0.5\n[sensor]", ["requirements.ms", "1 or more", "0.5"]),
    (
        "[sensor]",
        "[requirements]\npm_deg = 200\n[sensor]",
        ["requirements.pm_deg", "[0, 180)", "200"],
    ),
    (
        "[sensor]",
        '[requirements]\nms = "2"\n[sensor]',
        ["requirements.ms", "must be a real number", "'2'"],
    ),
    # controllers
    ('law = "pi"', 'law = "pj"', ["controller[0].law", "must be a law", "'pj'", "pid"]),
    ('law = "pi"', "law = 7", ["controller[0].law", "must be a law", "got 7"]),
    ('law = "pi"', "", ["controller[0].law", "must be given", "nothing"]),
    ('name = "PI"', 'name = ""', ["controller[0].name", "1 to 60", "''"]),
    ('name = "PI"', r'name = "a\nb"', ["controller[0].name", "printable", r"'a\nb'"]),
    ('name = "PI"', "name = 1", ["controller[0].name", "must be a text", "got 1"]),
    ("wc = 0.8", "wc = 0", ['controller "PI": wc', "must be above 0", "got 0"]),
    ("wc = 0.8", "wc = -1", ['controller "PI": wc', "must be above 0", "-1"]),
    ("wc = 0.8", "wc = nan", ['controller "PI": wc', "must be finite", "nan"]),
    ("wc = 0.8", "wc = 31.41592653589793", ['"PI": wc', "below the Nyquist", "31.4159"]),
    ("wc = 0.8", "wc = 500", ['controller "PI": wc', "pi/dt = 31.4159 rad/s", "got 500"]),
    ("wc = 0.8", 'wc = "fast"', ['controller "PI": wc', "must be a real number", "'fast'"]),
    ("pm_deg = 40", "pm_deg = 0", ['controller "PI": pm_deg', "inside (0, 180)", "got 0"]),
    ("pm_deg = 40", "pm_deg = 180", ['controller "PI": pm_deg', "inside (0, 180)", "180"]),
    ("pm_deg = 40", "pm_deg = -40", ['controller "PI": pm_deg', "inside (0, 180)", "-40"]),
    ("pm_deg = 40", "pm = 40", ['controller "PI": pm', "did you mean pm_deg?", "got 40"]),
    ("pm_deg = 40", "pm_deg = 40\nki = 1", ['controller "PI": ki', "that zoh knows", "got 1"]),
    ('law = "pi"', 'law = "given"\nnum = [1]', ['"PI": wc', "that zoh knows", "0.8"]),
    ("[[controller]]", "[controller]", ["controller", "must be a list of tables"]),
]


@pytest.mark.parametrize(
    ("old", "new", "said"), CHANGES, ids=[f"{i}-{c[1][:40]!r}" for i, c in enumerate(CHANGES)]
)
def test_one_line_that_names_key_bound_and_value(old, new, said, good, run):
    assert good.count(old) == 1, "the case must change the file"
    _refused(run(good.replace(old, new)), said)


def test_there_are_enough_cases():
    assert len(CHANGES) >= 60


def _refused(outcome, said, code=2):
    got, out, err = outcome
    assert got == code
    assert out == ""
    assert err.startswith("zoh: error: ")
    assert err.count("\n") == 1
    assert err.endswith("\n")
    assert "Traceback" not in err
    assert "defect" not in err
    for part in said:
        assert part in err


GIVEN = """\
plant.model = "1/(s+1)"
sampling.dt = 0.1
[[controller]]
law = "given"
"""

GIVEN_BAD = [
    ("", ['"given": num', "must be given", "nothing"]),
    ("num = [1]", ['"given": den', "must be given", "nothing"]),
    ("num = []\nden = [1]", ['"given": num', "at least one", "[]"]),
    ("num = [1]\nden = [0]", ['"given": den', "all zeros", "[0.0]"]),
    ("num = [0]\nden = [1]", ['"given": num', "all zeros", "[0.0]"]),
    ("num = [1, 2]\nden = [1]", ['"given": num', "degree in z than den (0)", "got 1"]),
    ("num = [nan]\nden = [1]", ['"given": num[0]', "must be finite", "nan"]),
    ("num = [1]\nden = [1]\nclaims = 3", ['"given": claims', "must be a table", "got 3"]),
    ("num = [1]\nden = [1]\nclaims = {pm = 40}", ["claims.pm", "did you mean pm_deg?", "40"]),
    ("num = [1]\nden = [1]\nclaims = {kind = 'x'}", ["claims.kind", "a kind", "'x'", "lag"]),
    ("num = [1]\nden = [1]\nclaims = {kind = 1}", ["claims.kind", "must be a text", "got 1"]),
    ("num = [1]\nden = [1]\nclaims = {ms = nan}", ["claims.ms", "must be finite", "nan"]),
    ("num = [1]\nden = [1]\nclaims = {ms = 'a'}", ["claims.ms", "real number", "'a'"]),
    ("num = [1]\nden = [1]\nwc = 3", ['"given": wc', "that zoh knows", "got 3"]),
]


@pytest.mark.parametrize("verb", ["design", "check"])
@pytest.mark.parametrize(("lines", "said"), GIVEN_BAD, ids=[c[0] for c in GIVEN_BAD])
def test_given_controllers(lines, said, verb, run):
    _refused(run(GIVEN + lines, verb=verb), said)


WHOLE_FILES = [
    (b"", ["plant", "must be given", "nothing"]),
    (b"plant", ["file", "must be TOML", "end of document"]),
    (b'plant.model = "1/s"\x00', ["file", "must be TOML"]),
    (b"\x00\x01\x02", ["file", "must be TOML"]),
    (b"\xff\xfe\x00", ["FILE", "must be UTF-8 text", "project.toml"]),
    (b"a = 1\na = 2", ["file", "must be TOML", "overwrite"]),
    (b"a = " + b"[" * 100_000, ["file", "must"]),
    (b"a = " + b"9" * 5000, ["file", "must be TOML"]),
    (b"#" * 1_000_001, ["file", "characters or fewer", "1000001"]),
    (b'plant.model = "1/s"\nsampling.dt = 1', ["controller", "must be given", "nothing"]),
    (b"controller = []\nplant.model='1/s'\nsampling.dt=1", ["controller", "must be given"]),
    (b"controller = [1]\nplant.model='1/s'\nsampling.dt=1", ["controller", "tables", "[1]"]),
]


@pytest.mark.parametrize("verb", ["design", "check"])
@pytest.mark.parametrize(("text", "said"), WHOLE_FILES, ids=[repr(c[0][:30]) for c in WHOLE_FILES])
def test_files_that_are_no_projects(text, said, verb, run):
    _refused(run(text, verb=verb), said)


def test_a_name_twice(good, run):
    again = good + '[[controller]]\nname = "PI"\nlaw = "p"\npm_deg = 30\n'
    _refused(run(again), ["controller[1].name", "must not be used twice", "'PI'"])


def test_too_many_controllers(good, run):
    many = "".join(f'[[controller]]\nname = "{i}"\nlaw = "p"\nwc = 1\n' for i in range(101))
    _refused(run(good + many), ["controller", "100 entries", "102"])


def test_check_without_a_given_controller(good, run):
    _refused(run(good, verb="check"), ["controller", 'law = "given"', "'pi'", "zoh design"])


@pytest.mark.parametrize("name", ["", "missing.toml", ".", "a\0b"])
def test_a_file_that_cannot_be_read(name, tmp_path, capsys):
    path = str(tmp_path / name) if name else ""
    code = cli.main(["design", path])
    _refused((code, *capsys.readouterr()), ["FILE", "must be a project file", "got '"])


@pytest.mark.parametrize("arguments", [[], ["design"], ["dezign", "x"], ["design", "x", "--jsn"]])
def test_arguments_that_are_wrong(arguments, capsys):
    with pytest.raises(SystemExit) as e:
        cli.main(arguments)
    _refused((e.value.code, *capsys.readouterr()), ["--help"])


HIDDEN = """\
plant.model = "(s-1)/((s-1)(s+2))"
sampling.dt = 0.1
[[controller]]
name = "one"
"""


@pytest.mark.parametrize(
    "controller",
    [
        'law = "given"\nnum = [1]\nden = [1]',
        'law = "pi"\nwc = 1\npm_deg = 100',
        'law = "p"\nwc = 1',
    ],
)
def test_an_unstable_hidden_mode_is_refused_and_named(controller, run):
    code, _, err = run(HIDDEN + controller)
    assert code == 1
    assert "1 of 1 controllers fail: one:" in err
    assert "hides an unstable mode at s = 1 " in err


PLANT = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
PI_ASKED = {"wc": 0.8, "pm_deg": 40.0}

PYTHON = [
    (lambda: Plant(num=[], den=[1]), "num must have at least one"),
    (lambda: Plant(num=[1], den=[]), "den must have at least one"),
    (lambda: Plant(num=[1], den=[0.0]), "den must not be all zeros"),
    (lambda: Plant(num=[1, 0], den=[1]), "num must not have a higher degree"),
    (lambda: Plant(num=[1], den=[1, np.nan]), "den[1] must be finite, got nan"),
    (lambda: Plant(num="12", den=[1]), "num must be a list of numbers, got '12'"),
    (lambda: Plant(num=[1], den=[1] * 53), "den must have order 50 or less, got 52"),
    (lambda: Plant(num=[1], den=[1], dead_time=-1), "dead_time must be 0 or more, got -1"),
    (lambda: Plant(num=[1], den=[1], sensor=0), "sensor must not be 0, got 0"),
    (lambda: Plant.parse("1/2s"), "model must not imply a multiplication"),
    (lambda: Plant.parse(None), "model must be a formula in quotes, got None"),
    (lambda: Plant.zpk(zeros=[], poles=[1j], gain=1), "poles must come in conjugate pairs"),
    (lambda: Plant.ss([[1, 2]], [1], [1]), "A must be square"),
    (lambda: Sampled(num=[1], den=[1], dt=0), "dt must be above 0, got 0"),
    (lambda: Sampled(num=[1, 0], den=[1], dt=1), "num must not have a higher degree in z"),
    (lambda: sample(PLANT, dt=-1), "dt must be above 0, got -1"),
    (lambda: sample(PLANT, dt=float("nan")), "dt must be finite, got nan"),
    (lambda: sample(PLANT, dt="0.1"), "dt must be a real number, got '0.1'"),
    (lambda: sample(PLANT, dt=0.1, compute_delay=-1), "compute_delay must be 0 or more"),
    (lambda: sample("1/s", dt=0.1), "plant must be a zoh.Plant, got '1/s'"),
    (lambda: verify(PLANT, [1.0]), "controller must be a zoh.Sampled, got [1.0]"),
    (lambda: design(PLANT, "pj", PI_ASKED, dt=0.1), "law must be one of"),
    (lambda: design(PLANT, "pi", {"wc": 31.5}, dt=0.1), "wc must be below the Nyq"),
    (lambda: design(PLANT, "pi", {"pm_deg": 180}, dt=0.1), "pm_deg must be inside"),
    (lambda: design(PLANT, "auto", {"ki": 1}, dt=0.1), "ki is no parameter of auto"),
    (lambda: design(PLANT, "pi", PI_ASKED | {"ki": 1}, dt=0.1), "ki is no parameter of pi"),
    (lambda: design(PLANT, "pi", PI_ASKED | {"wc": 31.5}, dt=0.1), "wc must be below the Nyq"),
    (lambda: design(PLANT, "pi", PI_ASKED | {"wc": np.inf}, dt=0.1), "wc must be finite, got inf"),
    (lambda: design(PLANT, "pi", PI_ASKED | {"pm_deg": 180}, dt=0.1), "pm_deg must be inside"),
    (lambda: design(PLANT, "pi", PI_ASKED, dt=0), "dt must be above 0, got 0"),
    (lambda: read(b"x"), "file must be a text"),
]


@pytest.mark.parametrize(("call", "line"), PYTHON, ids=[c[1] for c in PYTHON])
def test_the_python_interface(call, line):
    with pytest.raises(SpecError, match=f"^{re.escape(line)}") as e:
        call()
    assert "\n" not in str(e.value)


def test_a_hidden_unstable_mode_in_python():
    with pytest.raises((Infeasible, NotMet)):
        design(Plant.parse("(s-1)/((s-1)(s+2))"), "p", {"wc": 1.0}, dt=0.1)


def test_margins_of_nothing():
    with pytest.raises((ZohError, TypeError)):
        margins("L")
