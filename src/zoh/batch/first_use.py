"""The compiled arithmetic compiled in a process of its own, where nothing of it is kept yet.

Compiling takes three times the memory of what is compiled, and a process does not give that back:
so another one compiles, writes to numba's folder, leaves a mark there, and ends.
"""

import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any, cast

import numba
import numpy as np

from zoh.batch.compiled import kernel, run
from zoh.batch.compiled.jit import stamp
from zoh.batch.job import Job
from zoh.lti.systems import Plant

_COMMAND = "from zoh.batch import first_use; first_use.compile_and_mark()"


@cache
def ready() -> None:
    """Return once the arithmetic is compiled, and say that it is; or leave it to its first call."""
    if _mark().exists():
        return
    sys.stderr.write("zoh: compiling the fast arithmetic, once: some three minutes ...\n")
    done = subprocess.run([sys.executable, "-c", _COMMAND], check=False, stderr=subprocess.DEVNULL)
    sys.stderr.write("zoh: compiled\n" if done.returncode == 0 else "zoh: compiling here instead\n")


def compile_and_mark() -> None:
    """Compile, and leave the mark."""
    job = Job(plant=Plant(num=(1.0,), den=(1.0, 1.0)), law="pi", asked={"pm_deg": 60}, dt=0.1,
              varying=("wc",))  # fmt: skip
    run.run(job, {"wc": np.array([0.5])}, threads=1)
    _mark().touch()


def _mark() -> Path:
    """Return the file that says that this arithmetic is kept by this numba."""
    folder = Path(cast(Any, kernel.stretch).stats.cache_path)
    return folder / f"zoh-{stamp():x}-{numba.__version__}.compiled"
