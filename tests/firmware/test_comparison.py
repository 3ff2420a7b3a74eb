"""The harness, on controllers written by hand: it agrees where it must, and sees what it must."""

from dataclasses import replace

import numpy as np
import pytest
from known import float_pi, whole_pi

import zoh
from zoh.firmware import comparison, elf, harness, toolchain
from zoh.firmware.book import Format
from zoh.firmware.closed_loop import Loop
from zoh.firmware.cores import CORES, named
from zoh.firmware.emulated import Emulated
from zoh.firmware.harness import INIT, STEP
from zoh.firmware.host import Host
from zoh.firmware.trials import Outcome, Trial, trials
from zoh.lti.systems import Sampled

for needed in ("ziglang", "unicorn", "elftools", "capstone"):
    pytest.importorskip(needed)

M4 = named(["cortex-m4f"])
FEW = [(0.5 * (k % 9), 0.25 * (k % 7), 0.0) for k in range(300)]
FEW_WHOLE = [(100 * (k % 90), 333 * (k % 7), k) for k in range(300)]
PLANT = Sampled(num=[0.2], den=[1, -0.9], dt=0.1)


def compared(subject, cores=M4, levels=("O2",), loop=None):
    few = FEW if subject.number == "f32" else FEW_WHOLE
    put_through = trials(subject.number, few)
    return comparison.compared(subject, put_through, cores=cores, levels=levels, loop=loop)


def looped(number, y_unit=1):
    form = Format(number=number, y_unit=y_unit, u_unit=y_unit)
    return Loop(plant=PLANT, format=form, reference=1.0 if y_unit == 1 else 0.25, samples=200)


@pytest.mark.parametrize("subject", [float_pi(), whole_pi()], ids=["f32", "q15"])
def test_hand_written_controllers_are_their_models_on_every_core(subject):
    found = compared(subject, CORES, ("O2", "Os"), looped(subject.number))
    assert found.holds, found.report()
    assert len(found.builds) == 2 * (1 + len(CORES))
    assert found.samples > 3000
    assert found.loop_samples == 200


def test_the_loop_with_the_plant_has_no_delay_of_its_own():
    # 1/s, 1 s, kp = 1: deadbeat. y follows r one sample later; the disturbance, a tenth of the
    # largest u there was (2), stays
    sampled = zoh.sample(zoh.Plant(num=[1], den=[1, 0]), 1.0)
    loop = Loop(plant=sampled, format=Format(number="f64"), reference=1.0, samples=12)
    found = loop.trajectory(lambda given: given[0] - given[1])
    assert found[:9].tolist() == [1, 0, 0, 0, 0, 0, -2, 0, 0]
    assert found[9:].tolist() == pytest.approx([0, -0.2, -0.2], abs=1e-15)
    late = zoh.sample(zoh.Plant(num=[1], den=[1, 0]), 1.0, compute_delay=1.0)
    found = Loop(plant=late, format=Format(number="f64"), reference=1.0, samples=12).trajectory(
        lambda given: given[0] - given[1]
    )
    # y(k+1) = y(k) + u(k-1): u = 1, 1, 0, -1, -1, 0
    assert found[:6].tolist() == [1, 1, 0, -1, -1, 0]


def test_numbers_worked_out_by_hand(tmp_path):
    # e = 256, 0, -2: u = (90 e + i)/256 rounded down, + ff, then i grows by 13 e
    subject = whole_pi()
    given = np.array([[0, 0, 0, 0], [256, 0, 5, 0], [7, 7, 0, 0], [1, 3, -1, 0]], "<i2")
    trial = Trial(title="hand", what=np.array([INIT, STEP, STEP, STEP], np.uint8), given=given)
    wanted = [0, 90 + 5, 3328 // 256, (3328 - 180) // 256 - 1]
    sources = {**subject.sources, "driver.c": harness.driver("pi", "q15")}
    host = Host(toolchain.for_host("O2", sources, tmp_path / "host"), 4)
    core = M4[0]
    image = elf.read(toolchain.for_core(core, "O2", "pi", sources, tmp_path / "core"))
    for machine in (host, Emulated(core, image, "pi", 4)):
        outcome = machine.run(trial)
        assert outcome.outputs.tolist() == wanted
        assert outcome.state == (3328 - 26).to_bytes(4, "little")
        assert machine.call("pi_selftest") == 0


def test_instructions_and_stack_of_a_step_that_was_counted_by_hand(tmp_path):
    by_hand = (
        "__attribute__((naked)) int16_t pi_step(pi_state *s, int16_t r, int16_t y, int16_t ff)\n"
        '{ __asm volatile("push {r4, lr}; mov r0, r1; nop; pop {r4, pc}"); }\n'
    )

    def naked(text):
        start, end = text.index("int16_t pi_step"), text.index("void pi_track")
        own = f"#ifdef __thumb__\n{by_hand}#else\n{text[start:end]}#endif\n"
        return text[:start] + own + text[end:]

    build = compared(whole_pi(naked)).builds[1]
    assert build.instructions == (4, 4.0, 4)
    assert build.stack_bytes == 8
    assert build.step_bytes == 8


@pytest.mark.parametrize(
    ("subject", "old", "new"),
    [
        (float_pi, "0.7f", "0.70000005f"),  # the next float
        (float_pi, "ki = 0.1f", "ki = 0.099999994f"),
        (float_pi, "kp * e + s->i;", "(float)((double)kp * (double)e + (double)s->i);"),
        (whole_pi, "kp = 90", "kp = 91"),
        (whole_pi, ">> 8", "/ 256"),  # towards zero, not down
        (whole_pi, ">> 8", "+ 1 >> 8"),
    ],
)
def test_a_last_bit_or_a_rounding_that_differs_on_a_core_is_seen(subject, old, new):
    altered = subject(lambda text: text.replace(old, new, 1))
    assert altered.sources["pi.c"] != subject().sources["pi.c"]
    found = compared(altered)
    assert not found.holds
    assert any("Cortex-M4F -O2: " in d for d in found.differences), found.report()


# in the middle the last output, bytes 4 to 7, is written anew before anybody reads it
@pytest.mark.parametrize(
    ("byte", "share"), [*((b, 1.0) for b in range(12)), *((b, 0.5) for b in (0, 1, 2, 3, 8, 11))]
)
def test_one_byte_of_the_state_that_differs_on_a_core_is_seen(monkeypatch, byte, share):
    honest = Emulated.run

    def disturbed(self, trial):
        middle = int(trial.samples * share)
        first, rest = (
            Trial(title=trial.title, what=trial.what[part], given=trial.given[part])
            for part in (slice(0, middle), slice(middle, None))
        )
        begun = honest(self, first)
        state = bytearray(self.state)
        state[byte] ^= 1
        self.state = bytes(state)
        ended = honest(self, rest)
        outputs = np.concatenate([begun.outputs, ended.outputs])
        return Outcome(outputs=outputs, state=ended.state)

    monkeypatch.setattr(Emulated, "run", disturbed)
    assert not compared(float_pi()).holds


def test_a_loop_that_differs_is_seen(monkeypatch):
    honest = Loop.trajectory
    calls = []

    def late(self, answer):
        calls.append(1)
        out = honest(self, answer)
        out[-1] += 1 if len(calls) > 2 else 0  # model and this machine as they are
        return out

    monkeypatch.setattr(Loop, "trajectory", late)
    found = compared(float_pi(), loop=looped("f32"))
    assert [d for d in found.differences if "in the loop" in d]


def test_a_fused_multiply_add_is_seen_on_the_core_and_on_a_machine_that_has_one():
    def unprotected(text):
        pragma = "#pragma STDC FP_CONTRACT OFF"
        return text.replace(pragma, "#pragma STDC FP_CONTRACT ON")

    found = compared(float_pi(unprotected), named(["cortex-m4f", "rv32imafc"]))
    said = [d for d in found.differences if "rounds once where the model rounds twice" in d]
    assert any("vfma" in d or "vfms" in d or "vmla" in d for d in said), found.differences
    assert any("fmadd.s" in d for d in said)


def test_floats_in_software_on_a_core_that_has_them_in_hardware_are_seen():
    # what a compiler does that is told "cortex_m4" and hard floats, and is told of no unit
    found = compared(float_pi(), (replace(M4[0], cpu="cortex_m4"),))
    assert any("computes floats in software" in d for d in found.differences)


def test_a_routine_that_is_lost_is_seen():
    found = compared(whole_pi(lambda text: text.replace("pi_selftest", "pi_other")))
    assert any("pi_selftest is not in the image" in d for d in found.differences)


def test_a_core_that_stops_is_a_difference():
    def wild(text):
        return text.replace("s->i = held(s->i + ki * e);", "*(volatile int32_t *)0x90000000 = e;")

    def on_the_core(text):
        own = wild(text)
        return f"#ifdef __arm__\n{own}\n#else\n{text}\n#endif\n"

    found = compared(whole_pi(on_the_core))
    assert any("the core stops: " in d for d in found.differences)
    assert found.builds[0].differences == ()
