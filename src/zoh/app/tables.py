"""The comparison on a terminal: one column per controller, one row per figure, 80 columns."""

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from zoh.analysis.tabled.verify import Evidence
from zoh.app.claims import UNITS
from zoh.app.commands import Entry
from zoh.report.text import facts, in_w, in_z, number

_LABEL = 28  # columns for the name of a figure: "overshoot at the samples, %"
_COLUMN = 12  # columns for one controller, of which 2 are space
_BELOW = ("gains", "D(z)", "D(w)")  # too long for a column: listed below the table


def show(console: Console, entries: Sequence[Entry], warnings: Sequence[str] = ()) -> None:
    """Print the table, the controllers themselves, and what is wrong with any of them."""
    measured = [e.measured for e in entries if e.measured is not None]
    per_block = max(1, (console.width - _LABEL) // _COLUMN)
    for start in range(0, len(measured), per_block):
        console.print(_block(measured[start : start + per_block]))
        console.print()
    for d in measured:
        gains = ", ".join(f"{k} = {number(v, 6)}" for k, v in d.gains.items())
        console.print(Text.assemble((d.name, "bold"), f"  {gains}"))
        _line(console, "  D(z) =", in_z(d.controller))
        _line(console, "  D(w) =", in_w(d.controller))
    if any(entry.findings for entry in entries):
        console.print()
        console.print(_claims(entries))
    console.print()
    for entry in entries:
        _failures(console, entry)
    for warning in warnings:
        _line(console, "note:", warning)


def _claims(entries: Sequence[Entry]) -> Table:
    """Return every claim beside what was measured."""
    table = Table(box=None, padding=(0, 2, 0, 0), show_edge=False, pad_edge=False)
    for name in ("controller", "claim", "claimed", "measured", "verdict"):
        table.add_column(name, overflow="fold", max_width=24)
    for entry in entries:
        for i, finding in enumerate(entry.findings):
            unit = f", {UNITS[finding.key]}" if finding.key in UNITS else ""
            value = finding.measured
            table.add_row(
                Text(entry.name if i == 0 else ""),
                finding.key + unit,
                finding.claimed,
                value if isinstance(value, str) else number(value, 6),
                Text("holds") if finding.holds else Text("WRONG", style="bold red"),
            )
    return table


def _block(measured: Sequence[Evidence]) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), show_edge=False, pad_edge=False)
    table.add_column("", min_width=_LABEL - 2, no_wrap=True)
    for d in measured:
        table.add_column(Text(d.name), justify="right", overflow="fold", max_width=20)
    rows = [facts(d) for d in measured]
    for label in rows[0]:
        if label not in _BELOW:
            table.add_row(label, *(_cell(row[label]) for row in rows))
    return table


def _cell(text: str) -> Text:
    """Return a fact without its Markdown; what fails is red where there are colours."""
    plain = text.replace("**", "").replace("\\|", "|")
    return Text(plain, style="bold red" if plain != text and "**" in text else "")


def _failures(console: Console, entry: Entry) -> None:
    """Print why a controller fails, one reason on each line."""
    if entry.refusal is not None:
        _line(console, f"{entry.name} ({entry.law}) refused:", str(entry.refusal), style="red")
    if entry.measured is not None:
        for miss in entry.measured.misses:
            _line(console, f"{entry.name} misses:", miss, style="red")
    for finding in entry.findings:
        if not finding.holds:
            _line(console, f"{entry.name}:", finding.sentence, style="red")


def _line(console: Console, head: str, rest: str, style: str = "bold") -> None:
    """Print a line as it is, what wraps indented: names are the user's, not markup."""
    text = Text.assemble((head, style), " ", rest)
    lines = text.wrap(console, console.width - 4)
    for i, line in enumerate(lines):
        console.print(line if i == 0 else Text.assemble("    ", line))
