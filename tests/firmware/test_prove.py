"""Real controllers proved on emulated cores; what is broken in the emulated copy is caught."""

import json
import re

import numpy as np
import pytest
from designs import design, made

import zoh
from zoh.firmware import toolchain
from zoh.firmware.cores import CORES
from zoh.firmware.emulated import Emulated
from zoh.firmware.prove import prove

for needed in ("ziglang", "unicorn", "elftools", "capstone"):
    pytest.importorskip(needed)

M4 = ["cortex-m4f"]


@pytest.mark.parametrize(
    ("law", "number"), [("pid", "f32"), ("leadlag", "f64"), ("lead", "q31"), ("pi", "q15")]
)
def test_a_controller_is_its_model_on_all_seven_cores(law, number):
    seen = []
    found = prove(made(law, number), levels=["O2"], progress=lambda *told: seen.append(told))
    assert found.holds
    assert found.samples >= 20_000
    assert found.loop_samples >= 1000
    assert [b.target for b in found.builds] == ["this machine", *(c.title for c in CORES)]
    assert [(done, total) for done, total, _ in seen] == [(k, 8) for k in range(1, 9)]
    for build in found.builds[1:]:
        least, mean, most = build.instructions
        assert 0 < least <= mean <= most
        assert 0 < build.step_bytes < build.code_bytes
        assert build.stack_bytes >= 0
    assert json.loads(json.dumps(found.to_dict()))["equal"] is True
    assert "0 bits differ" in found.report()


@pytest.mark.parametrize("anti_windup", ["conditional", "back_calculation", "tracking"])
@pytest.mark.parametrize("weight", [0.0, 0.3, 1.0])
def test_what_a_step_with_all_features_may_cost(weight, anti_windup):
    # the bounds asked of it, with limits that no immediate operand holds
    features = {
        "u_min": -11.3, "u_max": 11.7, "rate": 53.0, "setpoint_weight": 0.7,
        "derivative_weight": weight, "anti_windup": anti_windup,
    }  # fmt: skip
    float32 = prove(made("pid_filtered", "f32", **features), targets=M4)
    assert max(b.instructions[2] for b in float32.builds[1::2]) <= 64
    q15 = prove(made("pid_filtered", "q15", **features), targets=["cortex-m4f", "cortex-m0+"])
    most = {b.target: b.instructions[2] for b in q15.builds if b.instructions is not None}
    assert most["Cortex-M4F"] <= 110
    assert most["Cortex-M0+"] <= 200


def test_what_two_sections_may_cost():
    # CMSIS' cascade of two sections takes 78 without limit, guard or hold
    two = prove(made("notched", "f32", realisation="cascade"), targets=M4)
    assert max(b.instructions[2] for b in two.builds[1::2]) <= 60


def _next_float(text):
    """Move the first coefficient by its last bit."""
    found = re.search(r"static const float ctl_\w+ = (\S+)f;", text)
    moved = np.nextafter(np.float32(found[1]), np.float32(np.inf))
    return text.replace(f"= {found[1]}f;", f"= {moved}f;", 1)


def _next_whole(text):
    found = re.search(r"static const int32_t ctl_k\w+ = (-?\d+);", text)
    return text.replace(found[0], found[0].replace(found[1], str(int(found[1]) + 1)), 1)


def _towards_zero(text):
    return text.replace("return a >> k;", "return a / (1 << k);", 1)


def _rounded_once(text):
    """Compute one product and the sum it goes into in double."""
    found = re.search(r"const float sum_1 = (\w+) \+ (\w+);", text)
    return text.replace(found[0], f"const float sum_1 = __builtin_fmaf(ctl_kp, e, {found[2]});", 1)


@pytest.mark.parametrize(
    ("law", "number", "broken"),
    [
        ("pid", "f32", _next_float), ("pid", "f32", _rounded_once),
        ("pid", "q15", _next_whole), ("pid", "q15", _towards_zero),
    ],
)  # fmt: skip
def test_a_bit_or_a_rounding_that_differs_in_the_emulated_copy_is_caught(
    monkeypatch, law, number, broken
):
    honest = toolchain.for_core

    def altered(core, level, name, sources, folder):
        changed = {**sources, "ctl.c": broken(sources["ctl.c"])}
        assert changed != sources
        return honest(core, level, name, changed, folder)

    monkeypatch.setattr(toolchain, "for_core", altered)
    with pytest.raises(zoh.Unequal, match="the firmware is not the design: Cortex-M4F -O2") as e:
        prove(made(law, number), targets=M4, levels=["O2"])
    assert not e.value.found.holds
    assert e.value.found.builds[0].differences == ()  # this machine ran the honest copy


def test_a_byte_of_the_state_that_differs_in_the_emulated_copy_is_caught(monkeypatch):
    honest = Emulated.run

    def disturbed(self, trial):
        found = honest(self, trial)
        self.state = bytes([self.state[0] ^ 1, *self.state[1:]])
        return type(found)(outputs=found.outputs, state=self.state)

    monkeypatch.setattr(Emulated, "run", disturbed)
    with pytest.raises(zoh.Unequal, match="the state at the end, from byte 0 on"):
        prove(made("pid", "q31"), targets=M4, levels=["O2"])


def test_a_request_that_is_malformed_is_named():
    with pytest.raises(zoh.SpecError, match="targets must be of cortex-m0"):
        prove(made("p", "f32"), targets=["z80"])
    with pytest.raises(zoh.SpecError, match="targets must be a list"):
        prove(made("p", "f32"), targets="cortex-m3")
    with pytest.raises(zoh.SpecError, match="levels must be of O2, Os"):
        prove(made("p", "f32"), levels=["O3"])
    with pytest.raises(zoh.SpecError, match="levels must be of O2, Os"):
        prove(made("p", "f32"), levels=[])  # nothing built is nothing proved
    with pytest.raises(zoh.SpecError, match="samples must be"):
        prove(made("p", "f32"), samples=100)
    with pytest.raises(zoh.SpecError, match="number must be the plan's, f32"):
        prove(made("p", "f32"), number="q15")
    with pytest.raises(zoh.SpecError, match="verified must be a verified design"):
        prove(design("p").controller)


@pytest.mark.parametrize("absent", ["ziglang", "unicorn", "elftools", "capstone"])
def test_a_package_that_is_missing_is_one_line_that_names_what_brings_it(monkeypatch, absent):
    def without(name):
        if name.split(".")[0] == absent:
            raise ModuleNotFoundError(name=absent)
        return honest(name)

    honest = toolchain.import_module
    monkeypatch.setattr(toolchain, "import_module", without)
    with pytest.raises(zoh.SpecError, match=r"pip install 'zoh\[firmware\]' brings it") as e:
        prove(made("p", "f32"), targets=M4, levels=["O2"])
    assert "\n" not in str(e.value)
    assert {"elftools": "pyelftools"}.get(absent, absent) in str(e.value)
