"""The C: built strictly as C99 and C++17, equal to the model to the last bit, and unforgiving."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from designs import ARM, LAWS, made
from host import STRICT, Host, compiled, compilers

import zoh
from zoh.firmware.c import emit
from zoh.firmware.head import Cost
from zoh.firmware.lines import NUMBERS
from zoh.firmware.model import Model
from zoh.firmware.vectors import hostile, ordinary

SAMPLES = 20_000
FEATURES = {
    "plain": {},
    "rate": {"rate": 100.0},
    "weights": {"setpoint_weight": 0.7, "derivative_weight": 0.3, "rate": 50.0},
    "back": {"anti_windup": "back_calculation", "derivative_weight": 0.0},
    "tracking": {"anti_windup": "tracking", "setpoint_weight": 0.0},
    "none": {"anti_windup": "none"},
    "cascade": {"realisation": "cascade", "rate": 100.0},
    "delta": {"realisation": "delta"},
}
CASES = [(law, "plain", SAMPLES) for law in LAWS]
CASES += [("pid_filtered", name, 4000) for name in FEATURES if name != "plain"]
CASES += [("lead", "cascade", 4000), ("notched", "delta", 4000), ("notched", "none", 4000)]
SHAPES = [("pid_filtered", name) for name in FEATURES]
SHAPES += [("p", "plain"), ("leadlag", "plain"), ("notched", "plain"), ("notched", "delta")]


def called(command):
    return "zig" if "ziglang" in command else command[0]


def written(plan, folder: Path) -> Path:
    for name, text in emit(plan).items():
        (folder / name).write_text(text)
    return folder / f"{plan.name}.c"


def differing(model, host, samples):
    """Return how many outputs differ in a bit; track and reset come in between."""
    count = 0
    for k, sample in enumerate(samples):
        if k % 997 == 500:
            model.track(*sample, sample[1])
            host.track(*sample, sample[1])
        if k % 4999 == 4000:
            model.reset(sample[0])
            host.reset(sample[0])
        count += host.bits(model.step(*sample)) != host.bits(host.step(*sample))
    return count


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize(("law", "feature", "count"), CASES)
def test_the_c_is_the_model_bit_for_bit(law, feature, count, number):
    plan = made(law, number, **FEATURES[feature])
    model, host = Model(plan), Host(plan)
    assert differing(model, host, hostile(plan, count)) == 0
    assert model.state_bytes() == host.state_bytes()
    assert host.selftest() == 0
    if number in ("f32", "f64"):
        assert model.faults > 20


@pytest.mark.parametrize("number", NUMBERS)
def test_without_limits_too(number):
    options = {} if number in ("f32", "f64") else {"u_range": (-12, 12)}
    plan = made("pid_filtered", number, u_min=None, u_max=None, **options)
    model, host = Model(plan), Host(plan)
    assert differing(model, host, hostile(plan, 4000)) == 0
    assert model.state_bytes() == host.state_bytes()


@pytest.mark.parametrize("number", ["q15", "q31"])
@pytest.mark.parametrize("options", [{}, {"derivative_weight": 0.0, "rate": 5.0}])
def test_at_a_fast_clock_too(number, options):
    design = zoh.pid(ARM, dt=1e-4, wc=1.95, pm_deg=40, ki=0.85, filter_pole=15.0)
    found = zoh.plan(design, number=number, u_min=-12, u_max=12, y_range=(-12, 12), **options)
    waiting = {"x_rest", "f_rest"} if number == "q15" else {"x_rest"}  # 32 bits hold this alpha
    assert waiting <= {s.name for s in found.program.states}
    model, host = Model(found), Host(found)
    assert differing(model, host, hostile(found, SAMPLES)) == 0
    assert model.state_bytes() == host.state_bytes()
    assert host.selftest() == 0


@pytest.mark.parametrize("options", [["-O0"], ["-O3"], ["-Os", "-std=gnu99"]])
@pytest.mark.parametrize("command", compilers(), ids=called)
@pytest.mark.parametrize("law", ["pid_filtered", "notched"])
def test_no_compiler_and_no_option_changes_a_bit(law, command, options):
    for number in ("f32", "q31"):
        plan = made(law, number)
        model, host = Model(plan), Host(plan, command, options)
        assert differing(model, host, hostile(plan, 3000)) == 0
        assert model.state_bytes() == host.state_bytes()


@pytest.mark.parametrize("command", compilers(), ids=called)
@pytest.mark.parametrize("law", ["pid_filtered", "notched"])
def test_nothing_is_contracted_where_the_processor_could(law, command, tmp_path):
    source = written(made(law, "f32"), tmp_path)
    text = source.read_text()
    machine = ["-O3", "-std=gnu99", "-S", "-o", str(tmp_path / "made.s")]
    machine += ["-march=haswell"] if "zig" not in " ".join(command) else ["-mcpu=haswell"]
    compiled(command, source, *machine)
    assert "vfm" not in (tmp_path / "made.s").read_text()
    # the same without its own protection is contracted: the check can fail
    source.write_text(re.sub(r"#if defined\(__clang__\)\n.*?#endif\n", "", text, flags=re.DOTALL))
    compiled(command, source, *machine, "-ffp-contract=fast")
    assert "vfm" in (tmp_path / "made.s").read_text()


@pytest.mark.parametrize("command", compilers(), ids=called)
def test_fast_arithmetic_is_refused(command, tmp_path):
    source = written(made("pid", "f32"), tmp_path)
    with pytest.raises(AssertionError, match="without -ffast-math"):
        compiled(command, source, "-ffast-math", "-c", "-o", str(tmp_path / "made.o"))


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize(("law", "feature"), SHAPES)
def test_it_builds_strictly_as_c99_and_as_cpp17(law, feature, number, tmp_path):
    source = written(made(law, number, **FEATURES[feature]), tmp_path)
    out = ["-c", "-o", str(tmp_path / "made.o")]
    # one shape with every compiler: the others are of the same words
    for command in compilers() if feature == "weights" else compilers()[:1]:
        compiled(
            command, source, "-std=c99", "-ffreestanding", "-Wstrict-prototypes", *STRICT, *out
        )
        compiled(command, source, "-x", "c++", "-std=c++17", *STRICT, *out)


@pytest.mark.parametrize("number", NUMBERS)
def test_the_sanitizers_find_nothing(number):
    plan = made("pid_filtered", number, **FEATURES["weights"])
    host = Host(plan, options=["-O1", "-fsanitize=undefined", "-fno-sanitize-recover=all"])
    assert differing(Model(plan), host, hostile(plan, 2000)) == 0


@pytest.mark.parametrize("number", NUMBERS)
def test_a_last_bit_of_any_coefficient_is_noticed(number):
    plan = made("pid_filtered", number, **FEATURES["weights"])
    samples = ordinary(plan, 400) + hostile(plan, 3000)
    for c in plan.coefficients:
        if c.name in ("x_max", "x_min", "i_max", "i_min", "half"):
            # ends that the integral does not come to within these samples; and half a step, whose
            # last bit decides one output in as many as a step has parts
            continue
        if isinstance(c.value, float):
            near = np.nextafter(np.float32(c.value), np.float32(9e9)) if number == "f32" else None
            other = repr(float(np.nextafter(c.value, 9e9))) if near is None else f"{near}f"
        else:
            other = str(c.value + 1)
        defined = re.compile(rf"(const \w+ ctl_{c.name} = )[^;]+;")
        assert defined.search(emit(plan)["ctl.c"])
        host = Host(plan, edit=lambda text, d=defined, o=other: d.sub(rf"\g<1>{o};", text))
        model = Model(plan)
        same = differing(model, host, samples) == 0 and model.state_bytes() == host.state_bytes()
        assert not same, c.name


def test_the_selftest_finds_a_wrong_rounding():
    plan = made("pid_filtered", "f32")
    wrong = Host(plan, edit=lambda text: text.replace("sum_1 + s->x", "s->x + p; (void)sum_1"))
    assert wrong.selftest() > 0
    plan = made("pid_filtered", "q15")
    assert Host(plan, edit=lambda t: t.replace("return a >> k;", "return a / (1 << k);")).selftest()


def test_the_same_bytes_on_a_second_run():
    first = emit(made("pid_filtered", "q15", rate=100.0))
    assert emit(made("pid_filtered", "q15", rate=100.0)) == first


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("law", LAWS)
def test_every_literal_reads_back_as_its_coefficient(law, number):
    plan = made(law, number)
    text = emit(plan)["ctl.c"]
    for c in plan.coefficients:
        kind, literal, exact = re.search(
            rf"static const (\w+) ctl_{c.name} = (.+); /\* (\S+)", text
        ).groups()
        if kind == "float":
            assert literal.endswith("f")
            assert float(np.float32(literal[:-1])) == c.value == float.fromhex(exact.rstrip(":"))
        elif kind == "double":
            assert float(literal) == c.value == float.fromhex(exact.rstrip(":"))
        else:
            assert eval(literal.replace("LL", "")) == c.value  # a number, or (-2147483647 - 1)


@pytest.mark.parametrize("number", NUMBERS)
def test_no_library_no_heap_no_global_that_changes(number):
    text = "".join(emit(made("notched", number)).values())
    assert re.findall(r"#include (\S+)", text) == ["<stdint.h>", '"ctl.h"']
    outside = re.sub(r"\{.*?\n\}", "", text, flags=re.DOTALL)
    for line in outside.splitlines():
        if re.match(r"(static )?(?!const)\w+ \w+ ?(=|;)", line):
            assert line.startswith("static const")
    for body in re.findall(r"\n\{\n(.*?)\n\}\n", text, flags=re.DOTALL):
        assert body.count("return") <= 1  # one exit


def test_the_header_says_what_was_verified():
    plan = made("pid", "q15")
    header = emit(plan)["ctl.h"]
    assert plan.sha256 in header
    assert re.fullmatch("[0-9a-f]{64}", plan.sha256)
    for said in (
        "2.3/(s^2 + 0.7809 s)", "sensor 0.0666", "dt = 0.1 s", "phase margin 40 deg at 1.95 rad/s",
        "kp = 23.39", "as built phase margin 40.0037", "no value overflows", "dead band",
        "not measured", "r and y count 0.000366",
    ):  # fmt: skip
        assert said in header


def test_the_header_takes_what_a_proof_measured():
    cost = Cost(target="Cortex-M0+ -Os", instructions=(40, 41.26, 45), code_bytes=120)
    header = emit(made("pid", "q15"), [cost])["ctl.h"]
    assert "Cortex-M0+ -Os: 40, 41.3, 45; 120; -" in header
    assert "not measured" not in header


def test_the_hash_follows_every_part_of_a_design():
    plans = [
        made("pid", "f32"), made("pid", "f64"), made("pi", "f32"), made("pid", "f32", u_max=11.0),
        made("pid", "f32", rate=1.0), made("pid", "f32", realisation="delta"),
        made("pid", "f32", setpoint_weight=0.5),
    ]  # fmt: skip
    assert len({p.sha256 for p in plans}) == len(plans)


@pytest.mark.parametrize(
    "name", ["", "9x", "a b", "int", "class", "x" * 32, "é", 3, "main", "Arduino"]
)
def test_a_name_that_c_does_not_take_is_refused(name):
    with pytest.raises(zoh.SpecError, match="name must be"):
        made("p", "f32", name=name)


def test_a_compiler_is_here():
    assert compilers(), "these tests need gcc, cc or ziglang"
    assert shutil.which("gcc") or shutil.which("cc")
