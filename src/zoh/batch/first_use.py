"""The kernel's machine code: kept in a file, made by a process of its own where there is none yet.

Compiling takes three times the memory of what is compiled, and a process does not give that back:
so another one compiles, tries what it made, writes the file, and ends.
"""

import os
import subprocess
import sys
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

import numpy as np

from zoh.batch.compiled import machine
from zoh.batch.job import Job
from zoh.lti.systems import Plant

_COMMAND = "from zoh.batch import first_use; first_use.{}"


@cache
def kernel() -> machine.Kernel:
    """Return ``compiled.kernel.stretch``, compiled; say so on standard error where that is new."""
    if not _file().exists():
        sys.stderr.write("zoh: compiling the fast arithmetic, once: some two minutes ...\n")
        made = _in_another_process("compile_and_keep()")
        sys.stderr.write("zoh: compiled\n" if made else "zoh: compiling here instead\n")
        if not made:
            from zoh.batch.compiled.kernel import machine_code

            return machine.loaded(*machine_code())
    return _kept(_file())


def compile_and_keep() -> None:
    """Compile, and keep what was made if another process can run it."""
    from zoh.batch.compiled.kernel import machine_code

    wanted = _file()  # the sources' as they are before they are compiled
    made = wanted.with_suffix(f".{os.getpid()}")  # others may compile beside this one
    name, code = machine_code()
    made.parent.mkdir(parents=True, exist_ok=True)
    try:
        made.write_bytes(name.encode() + b"\n" + code)
        if not _in_another_process(f"try_it({str(made)!r})"):
            raise OSError(f"{made} does not run")
        made.replace(wanted)
    finally:
        made.unlink(missing_ok=True)


def try_it(made: str) -> None:
    """Run what was made, kept in a file."""
    from zoh.batch.compiled.run import run

    job = Job(plant=Plant(num=(1.0,), den=(1.0, 1.0)), law="pi", asked={"pm_deg": 60}, dt=0.1,
              varying=("wc",))  # fmt: skip
    run(job, {"wc": np.array([0.5])}, 1, _kept(Path(made)))


def _in_another_process(call: str) -> bool:
    done = subprocess.run(
        [sys.executable, "-c", _COMMAND.format(call)], check=False, stderr=subprocess.DEVNULL
    )
    return done.returncode == 0


def _kept(file: Path) -> machine.Kernel:
    name, _, code = file.read_bytes().partition(b"\n")
    return machine.loaded(name.decode(), code)


@cache
def _file() -> Path:
    """Return where the code of these sources is kept, by this numba for this processor.

    In the folder beside them where Python keeps what it compiles, or, where that is not to be
    written to, in the user's.
    """
    here = Path(__file__).with_name("compiled")
    read = [(f.name, f.read_bytes()) for f in sorted(here.glob("*.py"))]
    read.append(("tolerances", Path(__file__).with_name("tolerances.py").read_bytes()))
    of = sha256(repr((read, version("numba"), machine.processor())).encode()).hexdigest()[:16]
    beside = here / "__pycache__"
    mine = os.access(beside if beside.exists() else here, os.W_OK)
    return (beside if mine else Path.home() / ".cache" / "zoh") / f"kernel-{of}.o"


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
