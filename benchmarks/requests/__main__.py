"""Every law, asked of random plants, keeps its word or refuses rightly.

    python -m benchmarks.requests --count 10000 --law pid

prints how often it did what, and each request that is wrong with its seed; exits 1 where one is.
"""

import argparse
import sys
import warnings
from collections import Counter

from benchmarks.requests.drawn import LAWS, drawn
from benchmarks.requests.judged import judge

import zoh


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--law", choices=LAWS, action="append")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", zoh.AccuracyWarning)  # this counts what is right
    wrong = 0
    for law in arguments.law or LAWS:
        counts: Counter[str] = Counter()
        for seed in range(arguments.first, arguments.first + arguments.count):
            verdict = judge(drawn(law, seed))
            counts[verdict.partition(":")[0]] += 1
            if verdict.startswith("WRONG"):
                wrong += 1
                print(f"{law} {seed}: {verdict}", flush=True)
            if sys.stderr.isatty() or seed % 100 == 99:
                print(f"\r{law} {seed + 1} {dict(counts)}", end="", file=sys.stderr, flush=True)
        print(f"\n{law}: {dict(counts)}", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
