"""How much memory a sweep takes that is longer than memory, and how fast it goes to disk.

Loops of the robot arm's PID with a gain, a pole and a sample time that vary are streamed to a
Zarr store in a folder of its own, which is removed. Printed at every tenth of the way: the loops
done, the rate, and the largest resident memory so far, which must not grow with the loops.

    python -m benchmarks.sweep.memory --loops 10000000 --arithmetic arrays --limit-mb 600

exits 1 where more was resident.
"""

import argparse
import resource
import sys
import tempfile
import time
from pathlib import Path

import zoh

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
SPREADS = {
    "plant.gain": zoh.Uniform(low=1.8, high=2.8),
    "plant.den.1": zoh.Uniform(low=0.6, high=1.0),
    "dt": zoh.LogUniform(low=0.03, high=0.15),
}
JOB = zoh.Job(
    plant=ARM,
    law="pid",
    asked={"wc": 1.95, "pm_deg": 40, "ki": 0.85},
    dt=0.1,
    varying=tuple(SPREADS),
)


def resident_mb() -> float:
    """Return the largest resident memory of this process so far, in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--loops", type=int, default=20_000)
    parser.add_argument("--block", type=int)
    parser.add_argument("--arithmetic")
    parser.add_argument("--keep", nargs="*", help="columns to write; all where left out")
    parser.add_argument("--limit-mb", type=float, default=600.0)
    asked = parser.parse_args()
    begun, tenths = time.perf_counter(), [0]

    def told(done: int, loops: int) -> None:
        if done * 10 // loops > tenths[0]:
            tenths[0] = done * 10 // loops
            rate = done / (time.perf_counter() - begun)
            print(f"{done:>12} loops {rate:>10.0f} loops/s {resident_mb():>8.0f} MB", flush=True)

    space = zoh.Random(spreads=SPREADS, count=asked.loops, seed=1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.zarr"
        found = zoh.sweep_to(
            str(path), JOB, space, block=asked.block, arithmetic=asked.arithmetic, keep=asked.keep,
            progress=told,
        )  # fmt: skip
        on_disk = sum(f.stat().st_size for f in path.rglob("*") if f.is_file()) / 2**20
    print(f"{found.met} of {found.loops} as asked; {on_disk:.0f} MB on disk")
    return 0 if resident_mb() <= asked.limit_mb else 1


if __name__ == "__main__":
    sys.exit(main())
