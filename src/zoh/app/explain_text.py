"""What ``zoh explain`` found, as text: budget, prices, clocks and reasons of each controller."""

from collections.abc import Sequence
from textwrap import fill

from zoh.app.commands import warnings
from zoh.app.explain import Explained
from zoh.app.project import Project
from zoh.clock import SampleTimes
from zoh.emulation import Emulated
from zoh.report.text import number

_WIDTH = 100  # columns; a sentence is folded there


def as_text(project: Project, explained: Sequence[Explained]) -> str:
    """Return the same for people: budget, prices and reasons of each controller."""
    blocks = [_block(e) for e in explained]
    notes = [_wrapped(f"note: {n}") for n in warnings(project, [e.entry for e in explained])]
    return "\n\n".join([*blocks, *notes])


def _block(e: Explained) -> str:
    lines = [f"{e.entry.name}: {e.entry.law}"]
    if e.budget is not None:
        lines += ["where the degrees went", *e.budget.report().splitlines()]
    if e.prices:
        lines += [
            "what the same request would be worth, designed otherwise",
            *_price_table(e.prices),
        ]
    if e.clocks is not None:
        lines += ["what another sample time would cost", *_clock_table(e.clocks)]
    lines += ["why", *(f"  {reason}" for reason in e.reasons)]
    return "\n".join(_wrapped(line) for line in lines)


def _wrapped(line: str) -> str:
    """Return a long sentence in lines that a terminal holds; a table's row is never as long."""
    if len(line) <= _WIDTH:
        return line
    return fill(line, _WIDTH, initial_indent="  ", subsequent_indent="    ")


def _price_table(rows: Sequence[Emulated]) -> list[str]:
    width = max(len(row.designed) for row in rows)
    head = f"{'carried by':<10}  {'PM, deg':>8}  {'at, rad/s':>9}  {'Ms':>6}"
    lines = [f"{row.designed:<{width}}  {row.method or '':<10}  {_worth(row)}" for row in rows]
    return [f"  {line}" for line in (f"{'designed':<{width}}  {head}", *lines)]


def _worth(row: Emulated) -> str:
    m = row.margins
    if m is None:
        return row.reason or ""
    end = "" if m.stable else "  UNSTABLE"
    return f"{number(m.phase_margin_deg):>8}  {number(m.crossover):>9}  {number(m.ms):>6}{end}"


def _clock_table(found: SampleTimes) -> list[str]:
    lines = [f"{'dt, s':>10}  {'hold, deg':>9}  {'delay, deg':>10}  {'Ms':>6}  {'bits':>4}"]
    for row in found.rows:
        cost = f"{number(row.dt):>10}  {number(row.hold_deg):>9}  {number(row.delay_deg):>10}"
        bits = number(row.bits)
        end = "" if row.failure is None else "  not met"
        lines.append(f"{cost}  {number(row.ms):>6}  {bits:>4}{end}")
    if found.largest is None:
        lines.append(f"none of these meets the requirements: {found.limited_by}")
    elif found.limited_by is None:
        lines.append(
            f"the longest that was tried does: {found.largest:.6g} s; longer ones may, too"
        )
    else:
        lines.append(
            f"the longest that does is {found.largest:.6g} s; beyond it: {found.limited_by}"
        )
    return [f"  {line}" for line in lines]
