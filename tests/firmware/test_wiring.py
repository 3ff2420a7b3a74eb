"""The examples compile as they stand, for a board's processor, and convert as they say."""

import ctypes
import re
from dataclasses import replace

import numpy as np
import pytest
from boards import ARDUINO, HAL
from designs import design, made
from host import STRICT, compiled, compilers

import zoh
from zoh.firmware import toolchain
from zoh.firmware.equality import Build, Equality
from zoh.firmware.export import export, texts
from zoh.firmware.lines import NUMBERS
from zoh.firmware.model import Model

pytest.importorskip("ziglang")

UNO = ("-target", "avr-freestanding", "-mcpu=atmega328p", "-mmcu=atmega328p")
M4 = ("-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m4+vfp4d16sp")
PLAIN = ("-ffreestanding", "-fno-sanitize=all", "-O2", "-c", "-o", "made.o")


@pytest.mark.parametrize("number", NUMBERS)
def test_the_arduino_sketch_compiles_for_an_uno(number, tmp_path):
    files = export(made("pid", number))
    toolchain.written(tmp_path, {**files, "Arduino.h": ARDUINO})
    sketch = ("-x", "c++", "-std=c++17", "-include", "Arduino.h", "ctl_arduino.ino")
    toolchain.run_zig((*UNO, *PLAIN, "-Wall", "-Wextra", "-Werror", *sketch), tmp_path)
    toolchain.run_zig((*UNO, *PLAIN, "-std=c99", "ctl.c"), tmp_path)


@pytest.mark.parametrize("number", NUMBERS)
def test_the_stm32_example_compiles_with_strict_warnings(number, tmp_path):
    files = export(made("pid", number))
    toolchain.written(tmp_path, {**files, "main.h": HAL})
    toolchain.run_zig((*M4, *PLAIN, "-std=c11", *STRICT, "ctl_stm32.c"), tmp_path)


@pytest.mark.parametrize("number", NUMBERS)
def test_the_controller_is_valid_cpp_17_with_strict_warnings(number, tmp_path):
    toolchain.written(tmp_path, export(made("notched", number)))
    cpp = [w for w in STRICT if w not in ("-Wundef",)]
    toolchain.run_zig((*M4, *PLAIN, "-std=c++17", *cpp, "-x", "c++", "ctl.c"), tmp_path)


def _converted(tmp_path, number, what, argument, result, **options):
    """Return a conversion of the STM32 example, compiled for this machine."""
    text = export(made("pid", number, **options))["ctl_stm32.c"]
    start = text.index("/* YOURS: ", text.index("static ctl_state"))
    functions = text[start : text.index("/* Call this once")]
    for name in ("measured", "driven"):
        functions = re.sub(rf"static (\w+ {name}\()", r"\1", functions)
    toolchain.written(tmp_path, {})
    library = toolchain.for_host("O2", {"made.c": f"#include <stdint.h>\n{functions}"}, tmp_path)
    found = getattr(ctypes.CDLL(str(library)), what)
    found.argtypes, found.restype = [argument], result
    return found


def test_the_ends_of_a_converter_are_the_ends_of_the_range(tmp_path):
    # 12 bits over +-12 V in 16: count 2048 is 0 V, a count 16 steps
    y = _converted(tmp_path / "y", "q15", "measured", ctypes.c_int32, ctypes.c_int16)
    assert [y(c) for c in (0, 2048, 2049, 4095)] == [-32768, 0, 16, 32752]
    u = _converted(tmp_path / "u", "q15", "driven", ctypes.c_int16, ctypes.c_int32)
    assert [u(c) for c in (-32768, 0, 16, 32767)] == [0, 2048, 2049, 4095]
    volts = _converted(tmp_path / "v", "f32", "driven", ctypes.c_float, ctypes.c_int32)
    assert [volts(c) for c in (-12.0, -13.0, 12.0, 13.0, 0.0)] == [0, 0, 4095, 4095, 2048]
    read = _converted(tmp_path / "r", "f32", "measured", ctypes.c_int32, ctypes.c_float)
    assert [read(c) for c in (0, 1024, 2048, 4096)] == [-12.0, -6.0, 0.0, 12.0]


@pytest.mark.parametrize(
    ("number", "held"), [("q15", ctypes.c_int16), ("q31", ctypes.c_int32)], ids=["q15", "q31"]
)
def test_one_sided_ranges_and_limits_are_what_the_converters_span(number, held, tmp_path):
    # y of 0 to 10 and u of 0 to 5: the middle of a converter is the middle of each
    ends = {"y_range": (0, 10), "u_min": 0.0, "u_max": 5.0, "u_range": (-10, 10)}
    one = 1 << (15 if number == "q15" else 31)
    y = _converted(tmp_path / "y", number, "measured", ctypes.c_int32, held, **ends)
    assert [y(c) for c in (0, 2048, 3072)] == [0, one // 2, one * 3 // 4]
    u = _converted(tmp_path / "u", number, "driven", held, ctypes.c_int32, **ends)
    assert [u(c) for c in (0, one // 8, one // 4, one // 2)] == [0, 1024, 2048, 4095]


BOARD = """
#include <stdint.h>
extern "C" {{ {source} }}
static uint32_t now; static int put; static uint32_t at; static int reads;
#define A0 14
#define A1 15
static int analogRead(uint8_t pin) {{
    reads++; return pin == A0 ? 700 : 700 - 9 * (reads / 2 % 4);
}}
static void analogWrite(uint8_t, int value) {{ put = value; at = now; }}
static unsigned long micros(void) {{ return now += 10; }}
{sketch}
extern "C" void run(int periods, int *values, int *times) {{
    setup();
    for (int k = 0; k < periods;) {{
        const int before = reads;
        loop();
        if (reads > before) {{ values[k] = put; times[k] = (int)at; k++; }}
    }}
}}
"""


@pytest.mark.parametrize(
    ("delay", "samples", "wait"),
    [(0.0, 0, 0), (0.03, 0, 30_000), (0.1, 1, 0), (0.25, 2, 50_000), (0.3, 3, 0)],
)
def test_an_example_puts_out_when_the_design_counts_it_to(delay, samples, wait, tmp_path):
    arm = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    verified = zoh.pid(arm, dt=0.1, wc=1.0, pm_deg=40, ki=0.2, compute_delay=delay)
    plan = zoh.plan(verified, name="ctl", u_min=-40, u_max=40, y_range=(0, 12))
    files = export(plan)
    source, sketch = (
        re.sub(r'#include "ctl.h"', "", files[name]) for name in ("ctl.c", "ctl_arduino.ino")
    )
    text = BOARD.format(source=files["ctl.h"] + source, sketch=sketch)
    (tmp_path / "board.cpp").write_text(text)
    library = tmp_path / "board.so"
    compiled(
        compilers()[-1], tmp_path / "board.cpp", "-O1", "-x", "c++", "-std=c++17", "-shared",
        "-fPIC", "-o", str(library),
    )  # fmt: skip
    board, count = ctypes.CDLL(str(library)), 8
    values, times = ((ctypes.c_int * count)() for _ in range(2))
    board.run(count, values, times)
    model, y_step = Model(plan), np.float32(12) / np.float32(1024)
    counts = [(700, 700 - 9 * (k % 4)) for k in range(count)]
    read = [[float(np.float32(c) * y_step) for c in pair] for pair in counts]
    us = [0.0] * samples + [float(model.step(r, y)) for r, y in read]
    wanted = [int(255 * min(1.0, max(0.0, (u + 40) / 80)) + 0.5) for u in us[:count]]
    # 1: where a count is rounded half-way
    assert list(values) == pytest.approx(wanted, abs=1)
    assert len(set(wanted)) > 3
    # 10 us a look at the clock; the first period begins with the first look
    for k, found in enumerate(times):
        assert 0 <= found - wait - 100_000 * k <= 60


def test_a_clock_that_no_counter_of_microseconds_keeps_has_no_examples():
    slow = zoh.p(zoh.Plant(num=[1e-6], den=[1, 0]), dt=5000.0, pm_deg=60)
    assert sorted(export(slow)) == ["README.md", "controller.c", "controller.h"]
    fast = zoh.p(zoh.Plant(num=[1], den=[1, 0]), dt=2.5e-6, pm_deg=60)
    assert len(export(fast)) == 3
    whole = zoh.p(zoh.Plant(num=[1], den=[1, 0]), dt=1 / 3000, pm_deg=60)  # 333.3 us
    assert len(export(whole)) == 5


def test_the_readme_says_what_was_proved_and_of_which_plan():
    one, other = made("pid", "f32"), made("pi", "f32", name="other")
    text = texts([one, other], proofs=[None, None])["README.md"]
    assert re.findall(r"^## (.*)$", text, re.M)[:2] == ["ctl", "other"]
    assert text.count("not proved here") == 2
    assert "| as built | 40 | 1.95 |" in text
    assert "ctl_selftest() != 0" in text
    # the numbers of q15: 32768 steps are 12 V
    assert "32768 is 12 of what" in export(made("pid", "q15"))["README.md"]


def test_the_same_plan_gives_the_same_bytes():
    assert export(made("pid", "q15")) == export(made("pid", "q15"))


def test_what_is_no_target_and_what_is_another_plan_is_refused():
    with pytest.raises(zoh.SpecError, match="target must be c"):
        export(design("pid"), target="rust")
    other = Equality(
        name="ctl", number="f32", sha256="0", samples=0, loop_samples=0, state_bytes=0, builds=()
    )
    with pytest.raises(zoh.SpecError, match="proof must be of this plan"):
        export(made("pid", "f32"), proof=other)
    failed = replace(other, builds=(Build(target="host", level="O2", differences=("bit 3",)),))
    with pytest.raises(zoh.SpecError, match="proof must hold, got 'host -O2: bit 3'"):
        export(made("pid", "f32"), proof=replace(failed, sha256=made("pid", "f32").sha256))
    twice = [made("pid", "f32", name="arm"), made("pi", "f32", name="Arm")]
    with pytest.raises(zoh.SpecError, match="name must differ in more than capitals, got 'Arm'"):
        texts(twice, proofs=[None, None])


def test_a_word_that_ends_a_comment_does_not():
    hostile = zoh.verify(design("p").plant, design("p").controller, law="x */ int evil; /* y")
    header = export(zoh.plan(hostile, name="ctl"))["ctl.h"]
    assert header.count("*/\n#ifndef") == 1
    assert "x * / int evil; / * y" in header
