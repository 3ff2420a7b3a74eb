"""A long sweep that is killed at random moments, and what it comes to in the end.

The sweep of ``benchmarks.sweep.memory`` is written to a store in one go. Another process writes
it to a second store and is killed (SIGKILL) at a random moment after its start, again and again,
and then left alone. The files of the two stores are compared by their digests.

    python -m benchmarks.sweep.killed --loops 200000 --arithmetic arrays --kills 10

exits 1 where a byte differs.
"""

import argparse
import hashlib
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from benchmarks.sweep.memory import JOB, SPREADS

import zoh


def written(path: str, loops: int, block: int, arithmetic: str) -> zoh.Summary:
    space = zoh.Random(spreads=SPREADS, count=loops, seed=1)
    return zoh.sweep_to(path, JOB, space, block=block, arithmetic=arithmetic)


def contents(folder: str) -> dict[str, str]:
    files = sorted(f for f in Path(folder).rglob("*") if f.is_file())
    return {str(f.relative_to(folder)): hashlib.sha256(f.read_bytes()).hexdigest() for f in files}


def started(path: str, asked: argparse.Namespace) -> subprocess.Popen[bytes]:
    told = ["--write", path, "--loops", str(asked.loops), "--block", str(asked.block)]
    command = [sys.executable, "-m", "benchmarks.sweep.killed", *told]
    return subprocess.Popen([*command, "--arithmetic", asked.arithmetic])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--loops", type=int, default=4000)
    parser.add_argument("--block", type=int, default=64)
    parser.add_argument("--arithmetic", default="single")
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.write:
        written(asked.write, asked.loops, asked.block, asked.arithmetic)
        return 0
    moments = np.random.default_rng(asked.seed)
    with tempfile.TemporaryDirectory() as folder:
        whole, cut = str(Path(folder) / "whole.zarr"), str(Path(folder) / "cut.zarr")
        begun = time.perf_counter()
        expected = written(whole, asked.loops, asked.block, asked.arithmetic)
        seconds = time.perf_counter() - begun
        for k in range(asked.kills):
            child = started(cut, asked)
            time.sleep(moments.uniform(0.2, 2 + 2 * seconds / asked.kills))
            child.kill()
            child.wait()
            done = len(list((Path(cut) / "blocks" / "c").glob("*")))
            print(f"kill {k + 1:>2}: {done} of {-(-asked.loops // asked.block)} blocks", flush=True)
        found = written(cut, asked.loops, asked.block, asked.arithmetic)
        same = found == expected and contents(cut) == contents(whole)
    print(f"{asked.loops} loops, {asked.kills} kills: {'the same bytes' if same else 'DIFFERENT'}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
