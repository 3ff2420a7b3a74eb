"""The kernel's machine code: kept in a file, made by a process of its own where there is none yet.

Compiling takes three times the memory of what is compiled, and a process does not give that back:
so another one compiles, tries what it made, writes the file, and ends.
"""

import os
import subprocess
import sys
from contextlib import suppress
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from threading import Lock

import numpy as np

from zoh.batch.compiled import machine
from zoh.batch.job import Job
from zoh.lti.systems import Plant

_STEM = "kernel-"
_SEASON = 90 * 86400.0  # s: code that no start has loaded for so long is removed
_COMMAND = "from zoh.batch import first_use; first_use.{}"
_ONE = Lock()  # of threads that ask at once the first one compiles


def kernel() -> machine.Kernel:
    """Return ``compiled.kernel.stretch``, compiled; say so on standard error where that is new."""
    with _ONE:
        return _kernel()


@cache
def _kernel() -> machine.Kernel:
    if found := _kept():
        return found
    sys.stderr.write("zoh: compiling the fast arithmetic, once: some two minutes ...\n")
    if _in_another_process("compile_and_keep()") and (found := _kept()):
        sys.stderr.write("zoh: compiled\n")
        return found
    sys.stderr.write("zoh: compiling here instead\n")
    from zoh.batch.compiled.kernel import machine_code

    return machine.loaded(*machine_code())


def compile_and_keep() -> None:
    """Compile, and keep what was made if another process can run it."""
    from zoh.batch.compiled.kernel import machine_code

    wanted = next(file for file in _files() if _may_write(file.parent))  # of the sources as they
    made = wanted.with_suffix(f".{os.getpid()}")  # are now; others may compile beside this one
    name, code = machine_code()
    made.parent.mkdir(parents=True, exist_ok=True)
    try:
        rest = name.encode() + b"\n" + code
        made.write_bytes(_digest(rest) + b"\n" + rest)
        if not _in_another_process(f"try_it({str(made)!r})"):
            raise OSError(f"{made} does not run")
        made.replace(wanted)
    finally:
        made.unlink(missing_ok=True)
    _forget_older(wanted)


def _forget_older(new: Path) -> None:
    """Remove the code beside a new file that nobody has loaded for a season.

    Each start that loads a file dates it anew, so what other versions, numbas or processors that
    share the folder still use stays. Where one is removed after all (whoever loads it may not write
    it), a process that has loaded it has it in memory, and the next start compiles it again. An age
    is that against the new file: no clock is read.
    """
    for old in new.parent.glob(f"{_STEM}*"):
        with suppress(OSError):  # another process may remove it, too, or own it
            if new.stat().st_mtime - old.stat().st_mtime > _SEASON:
                old.unlink()


def try_it(made: str) -> None:
    """Run what was made, kept in a file."""
    from zoh.batch.compiled.run import run

    found = _read(Path(made))
    if found is None:
        raise OSError(f"{made} is damaged")
    job = Job(plant=Plant(num=(1.0,), den=(1.0, 1.0)), law="pi", asked={"pm_deg": 60}, dt=0.1,
              varying=("wc",))  # fmt: skip
    run(job, {"wc": np.array([0.5])}, 1, machine.loaded(*found))


def _in_another_process(call: str) -> bool:
    done = subprocess.run(
        [sys.executable, "-c", _COMMAND.format(call)], check=False, stderr=subprocess.DEVNULL
    )
    return done.returncode == 0


def _kept() -> machine.Kernel | None:
    """Return the function of a file that is there and whole, and date the file anew."""
    for file in _files():
        with suppress(LookupError):  # its code is another's: made again
            if found := _read(file):
                loaded = machine.loaded(*found)
                with suppress(OSError):
                    os.utime(file)
                return loaded
    return None


def _read(file: Path) -> tuple[str, bytes] | None:
    """Return (name, code); None where the file is not there, or not what was written."""
    try:
        digest, _, rest = file.read_bytes().partition(b"\n")
    except OSError:
        return None
    if digest != _digest(rest):
        return None
    name, _, code = rest.partition(b"\n")
    return name.decode(), code


def _digest(rest: bytes) -> bytes:
    return sha256(rest).hexdigest().encode()


@cache
def _files() -> tuple[Path, ...]:
    """Return where the code of these sources may be, made by this numba for this processor.

    In the folder beside them where Python keeps what it compiles, and in the user's, if there is
    one.
    """
    here = Path(__file__).with_name("compiled")
    read = [(f.name, f.read_bytes()) for f in sorted(here.rglob("*.py"))]
    read.append(("tolerances", Path(__file__).with_name("tolerances.py").read_bytes()))
    of = sha256(repr((read, version("numba"), machine.processor())).encode()).hexdigest()[:16]
    folders = [here / "__pycache__"]
    with suppress(RuntimeError):
        folders.append(Path.home() / ".cache" / "zoh")
    return tuple([folder / f"{_STEM}{of}.o" for folder in folders])


def _may_write(folder: Path) -> bool:
    """Return whether a file may be made in a folder, or the folder itself."""
    while not folder.exists():
        folder = folder.parent
    return os.access(folder, os.W_OK)


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
