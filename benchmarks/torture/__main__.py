"""Who gets which loop wrong: ``python -m benchmarks.torture --help``.

The truth is in truth.json.gz; nothing is measured here but the tools.
"""

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from benchmarks.torture import (
    figures,
    holds,
    loops,
    page,
    run_control,
    run_octave,
    run_scipy,
    run_zoh,
    table,
)
from benchmarks.torture.loops import Spec
from benchmarks.torture.score import Answer
from rich.console import Console
from rich.progress import track

TOOLS = ("zoh", "control", "scipy", "octave")
Runner = Callable[[Spec], Answer]
RUNNERS: dict[str, list[tuple[str, Runner]]] = {
    "zoh": [(run_zoh.VERSION, run_zoh.answer)],
    "control": [
        (f"{run_control.VERSION}, default", run_control.answer),
        (f"{run_control.VERSION}, method='poly'", run_control.by_polynomials),
    ],
    "scipy": [(f"{run_scipy.VERSION}, a grid and brentq", run_scipy.answer)],
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the tools, print the table; return 1 where zoh has a loop wrong."""
    args = _arguments(argv)
    console = Console(stderr=True)
    specs = loops.read(loops.LOOPS)[:: args.every][: args.limit]
    by_name = {truth["name"]: truth for truth in loops.read(loops.TRUTH)}
    truths = [by_name[spec["name"]] for spec in specs]
    found, wrong = [], []
    for label, answers in _answers(args.tools, specs, console):
        results = table.scored(specs, truths, answers)
        found += table.tallies(label, results)
        if label == run_zoh.VERSION:
            wrong = [(spec["name"], sorted(strict), said.error or "")
                     for spec, _, strict, said in results if strict]  # fmt: skip
    out = Console(width=max(200, console.width))
    out.print(table.for_terminal(found))
    for name, faults, error in wrong:
        out.print(f"zoh has {name!r} wrong in {', '.join(faults)} {error}", markup=False)
    undecided = sum(bool(truth["doubt"]) for truth in truths)
    out.print(f"{len(specs)} loops; in {undecided} a last bit of the input decides something")
    if args.holds or args.write:
        rows = list(track(holds.rows(), "holds", console=console))
        out.print(table.hold_markdown(rows), markup=False)
        named = list(figures.figures())
    if args.write:
        Path(args.write).write_text(page.text(found, rows, named, specs, truths, wrong))
    return 1 if wrong else 0


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="benchmarks.torture", description=__doc__)
    parser.add_argument("--tools", nargs="+", choices=TOOLS, default=list(TOOLS))
    parser.add_argument("--limit", type=int, help="only so many loops")
    parser.add_argument("--every", type=int, default=1, help="only every so many-th loop")
    parser.add_argument("--holds", action="store_true", help="the errors of the hold, too")
    parser.add_argument("--write", metavar="FILE", help="write the published page")
    return parser.parse_args(argv)


def _answers(
    tools: Sequence[str], specs: list[Spec], console: Console
) -> Iterator[tuple[str, list[Answer]]]:
    for tool in tools:
        if tool == "octave":
            if not run_octave.installed():
                console.print("octave is not installed: left out")
                continue
            console.print("octave")
            yield run_octave.answers(specs)
            continue
        for label, run in RUNNERS[tool]:
            with ProcessPoolExecutor() as pool:
                answers = pool.map(run, specs, chunksize=4)
                yield label, list(track(answers, label, total=len(specs), console=console))


if __name__ == "__main__":
    sys.exit(main())
