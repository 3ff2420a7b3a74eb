"""The results as tables: for the terminal, and as Markdown for the docs."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from benchmarks.torture.holds import Row
from benchmarks.torture.loops import Spec
from benchmarks.torture.score import FAULTS, GENEROUS, ONLY_STRICT, STRICT, Answer, faults
from rich.table import Table

COLUMNS = ("PM > 0.1 deg", "PM > 1e-9 deg", "GM > 1 %", "GM > 1e-9", "missed", "invented",
           "Ms > 1 %", "Ms > 1e-9", "stable", "any", "any, strict")  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Tally:
    """One tool on one class: how many loops, how many tried, and how many wrong in what."""

    tool: str
    label: str
    loops: int
    tried: int
    counts: dict[str, int]

    def cells(self) -> list[str]:
        return [str(self.counts[c]) if self.tried else "-" for c in COLUMNS]


Scored = tuple[Spec, frozenset[str], frozenset[str], Answer]


def scored(
    specs: Sequence[Spec], truths: Sequence[Spec], answers: Sequence[Answer]
) -> list[Scored]:
    """Return each loop with its generous and its strict faults."""
    return [
        (spec, faults(spec, truth, said, GENEROUS), faults(spec, truth, said, STRICT), said)
        for spec, truth, said in zip(specs, truths, answers, strict=True)
    ]


def tallies(tool: str, results: Sequence[Scored]) -> list[Tally]:
    """Return one tally a class, in the order of the suite, and one of everything."""
    labels = list(dict.fromkeys(spec["class"] for spec, *_ in results))
    groups = [(label, [r for r in results if r[0]["class"] == label]) for label in labels]
    return [_tally(tool, label, group) for label, group in [*groups, ("all", list(results))]]


def _tally(tool: str, label: str, group: list[Scored]) -> Tally:
    counts: Counter[str] = Counter()
    for _, generous, strict, _ in group:
        for fault, loose, tight in (("PM", "PM > 0.1 deg", "PM > 1e-9 deg"),
                                    ("GM", "GM > 1 %", "GM > 1e-9"),
                                    ("Ms", "Ms > 1 %", "Ms > 1e-9")):  # fmt: skip
            counts[loose] += fault in generous
            counts[tight] += fault in strict
        for fault in ("missed", "invented", "stable"):
            counts[fault] += fault in generous
        counts["any"] += bool(generous & {*FAULTS})
        counts["any, strict"] += bool(strict & {*FAULTS, *ONLY_STRICT})
    tried = sum(not said.cannot for *_, said in group)
    return Tally(tool=tool, label=label, loops=len(group), tried=tried, counts=dict(counts))


def for_terminal(found: Iterable[Tally]) -> Table:
    table = Table(title="Loops that a tool gets wrong")
    for name in ("tool", "class", "loops", "tried", *COLUMNS):
        table.add_column(name, justify="left" if name in ("tool", "class") else "right")
    for t in found:
        table.add_row(t.tool, t.label, str(t.loops), str(t.tried), *t.cells(),
                      end_section=t.label == "all")  # fmt: skip
    return table


def markdown(found: Iterable[Tally]) -> str:
    """Return the tallies as Markdown, one table a tool."""
    lines: list[str] = []
    tool = None
    for t in found:
        if t.tool != tool:
            tool = t.tool
            lines += ["", f"### {tool}", "", _row(["class", "loops", "tried", *COLUMNS]),
                      _row(["---", *["--:"] * (2 + len(COLUMNS))])]  # fmt: skip
        strong = "**" if t.label == "all" else ""
        cells = [t.label, str(t.loops), str(t.tried), *t.cells()]
        lines.append(_row([f"{strong}{c}{strong}" for c in cells]))
    return "\n".join(lines[1:]) + "\n"


def hold_markdown(rows: Iterable[Row]) -> str:
    """Return the hold's errors as Markdown, one table a plant."""
    rows = list(rows)
    lines: list[str] = []
    for plant in dict.fromkeys(r.plant for r in rows):
        mine = [r for r in rows if r.plant == plant]
        delays = list(dict.fromkeys(r.delay for r in mine))
        peers = [t for t in mine[0].errors if t != "zoh"]
        heads = [f"zoh, dead time {d:g} dt" if d else "zoh" for d in delays]
        lines += ["", f"### {plant}", "", _row(["dt, s", *heads, *peers]),
                  _row(["--:"] * (1 + len(heads) + len(peers)))]  # fmt: skip
        for dt in dict.fromkeys(r.dt for r in mine):
            here = {r.delay: r for r in mine if r.dt == dt}
            cells = [_error(here[d].errors["zoh"]) for d in delays]
            cells += [_error(here[0.0].errors[t]) for t in peers]
            lines.append(_row([f"{dt:g}", *cells]))
    return "\n".join(lines[1:]) + "\n"


def _error(value: float | None) -> str:
    if value is None:
        return "raises"
    return f"{value:.1e}" if value else "0"


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cells) + " |"
