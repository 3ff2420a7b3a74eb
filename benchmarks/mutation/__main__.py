"""Mutation score of modules: ``python -m benchmarks.mutation src/zoh/design``.

Prints every survivor that ``survivors.txt`` does not explain, as a difference of lines, and the
score of each module. The exit code is 1 where one is unexplained.
"""

import os
import random
import sys
import time
from argparse import ArgumentParser, Namespace
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"  # a forked copy has no threads but its own

from benchmarks.mutation import survivors  # noqa: E402
from benchmarks.mutation.mutants import Mutant, mutants  # noqa: E402
from benchmarks.mutation.tests import KILLED, SURVIVED, TIMEOUT, Recorded, Tests  # noqa: E402

# The tests that are asked about a room, or about one of its files: its own, and those of what is
# built on it.
TESTS = {
    "design": ["tests/design", "src/zoh/design", "tests/test_pipeline.py"],
    "sampling": ["tests/sampling", "src/zoh/sampling"],
    "sampling/between": ["tests/sampling/test_between.py", "tests/analysis", "src/zoh/sampling"],
    "sampling/images": [*map(str, Path("tests/sampling").glob("test_images*.py"))],
    "sampling/pathological": ["tests/analysis/test_pathological_sampling.py", "src/zoh/sampling"],
    "sampling/ring": ["tests/sampling/test_ring.py", "tests/sampling/test_exact_arithmetic.py"],
    "tabled": [
        *map(str, Path("tests/analysis").glob("test_tabled_*.py")),
        "src/zoh/analysis/tabled",
        "tests/test_table_design.py",
    ],
    "analysis": [
        "tests/analysis",
        "src/zoh/analysis",
        "tests/test_pipeline.py",
        "tests/torture/test_torture.py::test_zoh_has_nothing_wrong",
    ],
}
TESTS["lti"] = ["tests/lti", "src/zoh/lti", *TESTS["analysis"]]
HOLD = ["tests/sampling/test_hold.py", "src/zoh/sampling"]
HOLD += [
    f"tests/sampling/test_{name}.py"
    for name in ("fixed", "fixed_bounds", "images", "hold_extremes")
]
TESTS |= {f"sampling/{name}": HOLD for name in ("hold", "fixed", "response", "delta")}


def _named(*starts: str) -> list[str]:
    """Return the tests of analysis whose files' names begin so, and its doctests."""
    found = (Path("tests/analysis").glob(f"test_{start}*.py") for start in starts)
    return [*(str(path) for paths in found for path in sorted(paths)), "src/zoh/analysis"]


# parts of analysis that have tests enough of their own: with fewer asked, more survive
TESTS |= {
    "analysis/rounding": _named("rounding", "margins"),
    "analysis/margins": _named("margins", "proof"),
    "analysis/nyquist": _named("nyquist", "stability", "touches", "margins_looks"),
    "analysis/margin_crossings": _named("margins"),
    "analysis/discs": _named("discs", "proof"),
    "analysis/proof": _named("proof", "discs", "sharp"),
    "analysis/certificates": _named("proof", "results"),
    "analysis/motion": _named("motion", "step", "filling"),
    "analysis/filling": _named("filling", "step"),
    "analysis/budget": _named("budget"),
    "analysis/sections": _named("budget"),
    "analysis/word_length": _named("word_length"),
    "analysis/load_error": _named("load_error"),
    "analysis/record": _named("record", "verify", "tabled_sentences"),
    "analysis/verify": _named("verify"),
    "analysis/sharp": _named("sharp", "close", "squares"),
    "analysis/newton": _named("newton", "sharp", "sparse"),
    "analysis/blurred": _named("blurred"),
    "analysis/responses": _named("responses", "step"),
    "analysis/step": _named("step", "motion", "waveform"),
    "analysis/waveform": _named("waveform", "step", "motion", "pieces", "realised"),
    "design/sections": ["tests/test_sections.py", "src/zoh/design"],
    "lti/given": [
        *(f"tests/lti/test_{name}.py" for name in ("given", "systems", "forms", "partial")),
        "src/zoh/lti",
    ],
    "lti/hidden": [
        "tests/lti/test_hidden.py",
        "--deselect=tests/lti/test_hidden.py::test_nor_in_a_sweep",  # compiles for minutes
        "src/zoh/lti",
    ],
    "lti/whole": ["tests/lti/test_whole.py", "src/zoh/lti", *_named("squares", "sparse", "loop")],
    "lti/signs": ["tests/lti/test_signs.py", "src/zoh/lti", *_named("proof", "stability")],
}
UNTESTED, EXPLAINED = -1, -2
WORDS = {
    KILLED: "killed",
    TIMEOUT: "timed out",
    EXPLAINED: "explained",
    SURVIVED: "survived",
    UNTESTED: "untested",
}


def main() -> int:
    options = _options()
    files = [f for p in options.paths for f in (sorted(p.rglob("*.py")) if p.is_dir() else [p])]
    chosen = [m for file in files for m in mutants(file)]
    if options.only:
        names = set(options.only.read_text().splitlines())
        chosen = [m for m in chosen if m.name in names]
    if options.sample < 1:
        chosen = random.Random(options.seed).sample(chosen, round(options.sample * len(chosen)))
    tests = Tests(dict.fromkeys(path for file in files for path in _asked(file)))
    counts: dict[Path, Counter[int]] = defaultdict(Counter)

    def serve() -> None:
        recorded = tests.record(files)
        if recorded.failed:
            sys.exit("the unchanged code fails " + ", ".join(recorded.failed))
        _say(f"{len(recorded.seconds)} tests pass in {sum(recorded.seconds.values()):.0f} s")
        for mutant, verdict in _verdicts(tests, recorded, chosen, options.most):
            counts[mutant.file][verdict] += 1

    if code := tests.serve(serve):
        return code
    _print_table(counts)
    return int(any(count[SURVIVED] + count[UNTESTED] for count in counts.values()))


def _asked(file: Path) -> list[str]:
    room = file.parent.name
    return TESTS.get(f"{room}/{file.stem}", TESTS[room])


def _options() -> Namespace:
    parser = ArgumentParser(prog="python -m benchmarks.mutation", description=__doc__)
    parser.add_argument("paths", nargs="+", type=Path, help="modules or folders of src/zoh")
    parser.add_argument("--sample", type=float, default=1.0, help="share of the mutants to run")
    parser.add_argument("--seed", type=int, default=1, help="of the sample")
    parser.add_argument("--most", type=float, default=20.0, help="s of tests for one mutant")
    parser.add_argument("--only", type=Path, help="a file with the names of mutants, one a line")
    return parser.parse_args()


def _verdicts(
    tests: Tests, recorded: Recorded, chosen: list[Mutant], most: float
) -> Iterator[tuple[Mutant, int]]:
    """Run the mutants one after the other, the tests that killed their neighbours first."""
    killers: dict[str, Counter[str]] = defaultdict(Counter)
    known, start = survivors.explained(), time.monotonic()
    for i, mutant in enumerate(chosen, 1):
        names, needed = _within(recorded, recorded.of(mutant), most)
        killed = killers[mutant.place]
        names.sort(key=lambda name: -killed[name])  # stable: then the fastest first
        verdict, killer = UNTESTED, ""
        if names:
            verdict, killer = tests.verdict(mutant, names, 5 + 4 * needed)
            killed[killer] += verdict == KILLED
        if verdict in (SURVIVED, UNTESTED) and survivors.paragraph(mutant) in known:
            verdict = EXPLAINED
        if verdict in (SURVIVED, UNTESTED):
            print(f"\n{survivors.paragraph(mutant)}", flush=True)
        _say(f"{i}/{len(chosen)} {time.monotonic() - start:.0f} s {mutant.name}: "
             f"{WORDS[verdict]} {killer}")  # fmt: skip
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


def _print_table(counts: dict[Path, Counter[int]]) -> None:
    """Print the counts; the score is the share killed or stopped by the limit of time."""
    print(
        f"\n{'module':26}{'mutants':>10}" + "".join(f"{w:>10}" for w in WORDS.values()) + "  score"
    )
    total = sum(counts.values(), Counter())
    for file, count in [*counts.items(), (Path("all"), total)]:
        dead = (count[KILLED] + count[TIMEOUT]) / count.total()
        numbers = "".join(f"{count[verdict]:10}" for verdict in WORDS)
        print(f"{'/'.join(file.parts[-2:]):26}{count.total():10}{numbers}{dead:7.1%}")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
