"""Mutation score of modules: ``python -m benchmarks.mutation src/zoh/design``.

Prints the score of each module and every survivor as a difference of lines.
"""

import os
import random
import sys
import time
from argparse import ArgumentParser
from collections import Counter, defaultdict
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"  # a forked copy has no threads but its own

from benchmarks.mutation.mutants import Mutant, mutants  # noqa: E402
from benchmarks.mutation.tests import KILLED, SURVIVED, TIMEOUT, Recorded, Tests  # noqa: E402

# Who is asked first: the room's own tests, then those who use it.
TESTS = {
    "design": ["tests/design", "src/zoh/design", "tests/test_pipeline.py"],
    "sampling": ["tests/sampling", "src/zoh/sampling"],
    "analysis": ["tests/analysis", "src/zoh/analysis", "tests/test_pipeline.py"],
}
UNTESTED = -1
WORDS = {KILLED: "killed", TIMEOUT: "timed out", SURVIVED: "survived", UNTESTED: "untested"}


def main() -> int:
    options = _options()
    files = [f for p in options.paths for f in (sorted(p.rglob("*.py")) if p.is_dir() else [p])]
    chosen = [m for file in files for m in mutants(file)]
    if options.only:
        names = set(options.only.read_text().split("\n"))
        chosen = [m for m in chosen if m.name in names]
    if options.sample < 1:
        chosen = random.Random(options.seed).sample(chosen, round(options.sample * len(chosen)))
    rooms = {file.parent.name for file in files}
    tests = Tests(dict.fromkeys(path for room in sorted(rooms) for path in TESTS[room]))
    done: dict[Mutant, int] = {}

    def serve() -> None:
        recorded = tests.record(files)
        if recorded.failed:
            sys.exit("the unchanged code fails " + ", ".join(recorded.failed))
        _say(f"{len(recorded.seconds)} tests pass in {sum(recorded.seconds.values()):.0f} s")
        for mutant, verdict in _verdicts(tests, recorded, chosen, options.most):
            done[mutant] = verdict

    code = tests.serve(serve)
    if done:
        _report(done)
    return code


def _options():
    parser = ArgumentParser(prog="python -m benchmarks.mutation", description=__doc__)
    parser.add_argument("paths", nargs="+", type=Path, help="modules or folders of src/zoh")
    parser.add_argument("--sample", type=float, default=1.0, help="share of the mutants to run")
    parser.add_argument("--seed", type=int, default=1, help="of the sample")
    parser.add_argument("--most", type=float, default=60.0, help="s of tests for one mutant")
    parser.add_argument("--only", type=Path, help="a file with the names of mutants")
    return parser.parse_args()


def _verdicts(tests: Tests, recorded: Recorded, chosen: list[Mutant], most: float):
    killers: dict[tuple[Path, str], Counter[str]] = defaultdict(Counter)
    start = time.monotonic()
    for i, mutant in enumerate(chosen, 1):
        names, needed = _within(recorded, recorded.of(mutant), most)
        known = killers[mutant.file, mutant.owner]
        names.sort(key=lambda name: -known[name])  # stable: then the fastest first
        if names:
            verdict, killer = tests.verdict(mutant, names, 5 + 4 * needed)
            known[killer] += verdict == KILLED
        else:
            verdict, killer = UNTESTED, ""
        _say(f"{i}/{len(chosen)} {time.monotonic() - start:.0f} s {mutant.name}: "
             f"{WORDS[verdict]} {killer}")  # fmt: skip
        if verdict in (SURVIVED, UNTESTED):
            print(f"\n{mutant.name}: {WORDS[verdict]}\n{mutant.diff()}", flush=True)
        yield mutant, verdict


def _within(recorded: Recorded, names: list[str], most: float) -> tuple[list[str], float]:
    """Return as many of the tests as take that long, and how long they take."""
    taken, needed = [], 0.0
    for name in names:
        needed += recorded.seconds[name]
        if needed > most:
            break
        taken.append(name)
    return taken, min(needed, most)


def _report(done: dict[Mutant, int]) -> None:
    counts: dict[Path, Counter[int]] = defaultdict(Counter)
    for mutant, verdict in done.items():
        counts[mutant.file][verdict] += 1
    print(f"\n{'module':30}  mutants  killed  timed out  survived  untested   score")
    total = sum(counts.values(), Counter())
    for file, count in [*counts.items(), (Path("all"), total)]:
        dead, number = count[KILLED] + count[TIMEOUT], count.total()
        print(f"{'/'.join(file.parts[-2:]):30}{number:9}{count[KILLED]:8}{count[TIMEOUT]:11}"
              f"{count[SURVIVED]:10}{count[UNTESTED]:10}{dead / number:8.1%}")  # fmt: skip


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
