"""What ``import zoh`` costs beside ``import numpy``, and what it must not import.

Fresh interpreters, the two taking turns, so that a busy machine slows both; the figure is the
ratio of the medians. ``--limit R`` exits with 1 where the ratio is above R.
"""

import argparse
import statistics
import subprocess
import sys
import time

NEVER = ("scipy", "matplotlib", "control", "rich", "numba", "xarray")


def seconds(code: str) -> float:
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True)
    return time.perf_counter() - start


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=21)
    parser.add_argument("--limit", type=float)
    args = parser.parse_args()
    watch = (
        f"import sys, zoh; bad = [m for m in {NEVER!r} if m in sys.modules];"
        "sys.exit(str(bad) if bad else 0)"
    )
    subprocess.run([sys.executable, "-c", watch], check=True)
    print(f"import zoh imports none of: {', '.join(NEVER)}")
    numpy, zoh = [], []
    for _ in range(args.rounds):
        numpy.append(seconds("import numpy"))
        zoh.append(seconds("import zoh"))
    ratio = statistics.median(zoh) / statistics.median(numpy)
    print(f"import numpy  {statistics.median(numpy) * 1e3:7.1f} ms (median of {args.rounds})")
    print(f"import zoh    {statistics.median(zoh) * 1e3:7.1f} ms")
    print(f"ratio         {ratio:7.2f}" + (f" (limit {args.limit})" if args.limit else ""))
    return 1 if args.limit and ratio > args.limit else 0


if __name__ == "__main__":
    sys.exit(main())
