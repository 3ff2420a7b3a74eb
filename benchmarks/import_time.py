"""What ``import zoh`` costs beside ``import numpy``, and what it must not import.

Names are loaded when first used, so both are measured: the import alone and all names. Fresh
interpreters take turns, so that a busy machine slows all; the figure is the ratio of the medians.
``--limit R`` exits with 1 where the ratio of the import is above R.
"""

import argparse
import statistics
import subprocess
import sys
import time

EVERYTHING = "import zoh\nfor name in zoh.__all__: getattr(zoh, name)"
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
        f"{EVERYTHING}\nimport sys\nbad = [m for m in {NEVER!r} if m in sys.modules]\n"
        "sys.exit(str(bad) if bad else 0)"
    )
    subprocess.run([sys.executable, "-c", watch], check=True)
    print(f"zoh with all its names imports none of: {', '.join(NEVER)}")
    numpy, zoh, whole = [], [], []
    for _ in range(args.rounds):
        numpy.append(seconds("import numpy"))
        zoh.append(seconds("import zoh"))
        whole.append(seconds(EVERYTHING))
    base = statistics.median(numpy)
    ratio = statistics.median(zoh) / base
    print(f"import numpy            {base * 1e3:7.1f} ms (median of {args.rounds})")
    print(
        f"import zoh              {statistics.median(zoh) * 1e3:7.1f} ms, ratio {ratio:.2f}", end=""
    )
    print(f" (limit {args.limit})" if args.limit else "")
    every = statistics.median(whole)
    print(f"... and all its names   {every * 1e3:7.1f} ms, ratio {every / base:.2f}")
    return 1 if args.limit and ratio > args.limit else 0


if __name__ == "__main__":
    sys.exit(main())
