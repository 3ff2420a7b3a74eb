"""The pages: REPORT.md and its figures, in the paper's order."""

from typing import Any

from zoh.app.paper.gallery import Drawing, drawings
from zoh.app.paper.printed import LAWS, METRICS
from zoh.app.paper.recipe import ARM, DT
from zoh.app.paper.study import NAMES, Study
from zoh.app.paper.terminal import WAYS, WORDS, counted, lag_sentence, printed_text, text_of
from zoh.report.document import Files, drawn, picture
from zoh.report.figures import render
from zoh.report.text import design_table, in_w, in_z, number, table

NOTE = (
    "A number is reproduced when it agrees within half a unit of its last printed digit. What "
    "the paper chose rather than computed (sample time, crossovers, the PID's KI) is solved back "
    "from another printed number that depends on it."
)


def pages(result: dict[str, Any], found: Study) -> Files:
    """Return {file name: content} for the whole report."""
    papers, ours = drawings(found)
    files: Files = {"REPORT.md": ""}
    for name, _, figure in (*papers, *ours):
        files.update(drawn(name, render(figure)))
    parts = [
        _head(result),
        _plant(found),
        _laws(result, found),
        _checked(result),
        _table_1(result),
        _pictures("The paper's figures", papers),
        _pictures("The exact designs", ours),
    ]
    return {**files, "REPORT.md": "\n".join(parts)}


def _head(result: dict[str, Any]) -> str:
    lines = ["# The robot arm of the paper\n"]
    lines.append(
        "D. Chowdhury and M. Sarkar, *Digital Controllers in Discrete and Continuous Time Domains "
        "for a Robot Arm Manipulator*: every printed number, recomputed from the plant.\n"
    )
    lines.append(f"{counted(result)}\n")
    if result["unexplained"]:
        lines.append(f"**Not explained: {', '.join(result['unexplained'])}.**\n")
    lines.append("## What does not agree\n")
    lines += [f"{i}. **{f['name']}.** {f['sentence']}" for i, f in enumerate(result["findings"], 1)]
    return "\n".join(lines) + "\n"


def _plant(found: Study) -> str:
    sampled, (typed, rounded) = found.as_printed["none"].sampled, found.printed_plant
    alone = found.as_printed["none"].margins
    rows = [
        ["exact", in_z(sampled, 10), number(alone.phase_margin_deg)],
        ["four digits, as printed", in_z(typed, 6), number(rounded.phase_margin_deg)],
    ]
    return (
        "## The plant\n\n"
        f"Motor and gear {number(ARM.num[0])}/(s² + {ARM.den[1]:g} s) in deg/V, potentiometer "
        f"12/180 V/deg, zero-order hold, {DT:g} s.\n\n"
        + table(["G(z)", "", "phase margin with D = 1, deg"], rows)
        + f"\n\nIn the w-plane, w = (2/T)(z - 1)/(z + 1): G(w) = {in_w(sampled)}.\n"
    )


def _laws(result: dict[str, Any], found: Study) -> str:
    return (
        "## The four laws\n\n### As printed: the paper's recipe, unrounded\n\n"
        + design_table(list(found.as_printed.values()))
        + "\n\n### As typed in: the digits on the page, misprint included\n\n"
        + design_table(list(found.as_typed.values()))
        + "\n\n### Exact: the library's designs, each with 40 deg where it was asked\n\n"
        + design_table(list(found.exact.values()))
        + f"\n\n{lag_sentence(result)}\n"
    )


def _checked(result: dict[str, Any]) -> str:
    rows = []
    for check in result["checks"]:
        printed = printed_text(check)
        good = check["verdict"] == "reproduced"
        verdict = check["verdict"] if good else f"**{check['verdict']}**"
        again = text_of(check["recomputed"])
        rows.append([f"`{check['id']}`", check["place"], printed, again, verdict])
    head = ["number", "place", "printed", "recomputed", "verdict"]
    return f"## Every printed number\n\n{NOTE}\n\n{table(head, rows)}\n"


def _table_1(result: dict[str, Any]) -> str:
    rows = []
    for metric in METRICS:
        for way, words in WAYS.items():
            row = [number(result["table_1"][way][law][metric], 4) for law in LAWS]
            rows.append([WORDS[metric], words, *row])
    head = ["", "", *(NAMES[law] for law in LAWS)]
    return (
        "## Table I three ways\n\nSamples at kT only, unit step, 10 to 90 % rise, 2 % band.\n\n"
        f"{table(head, rows)}\n"
    )


def _pictures(title: str, shown: list[Drawing]) -> str:
    return "\n".join([f"## {title}\n", *(picture(name, caption) for name, caption, _ in shown)])
