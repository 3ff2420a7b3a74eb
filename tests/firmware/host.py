"""A plan's C, built for this machine and called from Python."""

import ctypes
import shutil
import struct
import subprocess
import sys
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from zoh.firmware.c import emit

STRICT = (
    "-Wall -Wextra -pedantic -Werror -Wconversion -Wsign-conversion -Wdouble-promotion -Wshadow "
    "-Wfloat-equal -Wcast-qual -Wundef -Wswitch-default -Wwrite-strings"
).split()
_KINDS = {
    "f32": (ctypes.c_float, "<f"),
    "f64": (ctypes.c_double, "<d"),
    "q31": (ctypes.c_int32, "<i"),
    "q15": (ctypes.c_int16, "<h"),
}


@lru_cache(maxsize=1)
def compilers():
    """Return the commands of the C compilers that are here: gcc or cc, and zig's clang."""
    found = [(name,) for name in ("gcc", "cc") if shutil.which(name)][:1]
    if find_spec("ziglang"):
        found.append((sys.executable, "-m", "ziglang", "cc", "-fno-sanitize=all"))
    return found


def compiled(command, source: Path, *options):
    made = subprocess.run([*command, *options, str(source)], capture_output=True, text=True)
    assert made.returncode == 0, made.stderr[:2000]


class Host:
    """The C of a plan as a shared library, with one state; calls have the model's names."""

    def __init__(self, plan, command=None, options=("-O2",), edit=None):
        self.plan = plan
        with TemporaryDirectory() as folder:  # what is loaded stays
            self._library = self._built(Path(folder), command or compilers()[0], options, edit)
        self._kind, self._code = _KINDS[plan.number]
        self.size = len(plan.program.states) * {"f32": 4, "f64": 8, "q31": 8, "q15": 4}[plan.number]
        self.size += {"f32": 4, "f64": 8}.get(plan.number, 0)
        self._state = ctypes.create_string_buffer(self.size + 16)
        self._state[self.size] = b"\xa5"  # what lies behind the state is not touched
        self._step = self._function("step", self._kind, 3)
        self._track = self._function("track", None, 4)
        self._reset = self._function("reset", None, 1)
        self._function("init", None, 0)(self._state)

    def _built(self, folder, command, options, edit):
        for name, text in emit(self.plan).items():
            (folder / name).write_text(edit(text) if edit else text)
        source, library = folder / f"{self.plan.name}.c", str(folder / "made.so")
        compiled(command, source, "-std=c99", "-shared", "-fPIC", *options, "-o", library)
        return ctypes.CDLL(library)

    def _function(self, name, result, inputs):
        found = getattr(self._library, f"{self.plan.name}_{name}")
        found.restype, found.argtypes = result, [ctypes.c_void_p, *[self._kind] * inputs]
        return found

    def step(self, r, y, ff=0):
        return self._step(self._state, r, y, ff)

    def track(self, r, y, ff, u):
        self._track(self._state, r, y, ff, u)

    def reset(self, u0):
        self._reset(self._state, u0)

    def selftest(self):
        found = getattr(self._library, f"{self.plan.name}_selftest")
        found.restype = ctypes.c_int32
        return found()

    def state_bytes(self):
        assert self._state[self.size] == b"\xa5"
        return self._state.raw[: self.size]

    def bits(self, value):
        """Return a number's own bytes."""
        return struct.pack(self._code, value)
