"""The result for people who read a terminal."""

from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from zoh.app.paper.printed import LAWS, METRICS, NUMBERS
from zoh.app.paper.study import NAMES
from zoh.report.text import number

WORDS = {"overshoot_pct": "overshoot, %", "rise_s": "rise, s", "settling_s": "settling, s"}
WAYS = {
    "printed": "printed",
    "sensor_counted_twice": "sensor counted twice",
    "loop_as_designed": "loop as designed",
}


def shown(result: dict[str, Any]) -> Group:
    """Return every check, the findings as sentences, the designs, and Table I three ways."""
    parts: list[Table | Text] = [_checks(result), Text()]
    for i, finding in enumerate(result["findings"], 1):
        parts += [Text(f"{i}. {finding['sentence']}"), Text()]
    if result["unexplained"]:
        parts.append(Text(f"Not explained: {', '.join(result['unexplained'])}.", "bold red"))
    parts += [Text(lag_sentence(result)), Text(), _designs(result), Text(), _table_1(result)]
    parts.append(Text(counted(result), "bold"))
    return Group(*parts)


def counted(result: dict[str, Any]) -> str:
    """Return how many of the printed numbers have which verdict, in one line."""
    verdicts = [check["verdict"] for check in result["checks"]]
    counts = ", ".join(f"{verdicts.count(v)} {v}" for v in dict.fromkeys(verdicts))
    return f"{len(verdicts)} printed numbers: {counts}."


def lag_sentence(result: dict[str, Any]) -> str:
    """Return what became of the paper's request for a lag."""
    refused = result["lag_refused"]
    (lag,) = (d for d in result["designs_exact"] if d["law"] == "lag")
    return (
        f"Asked for the paper's phase-lag, the library refuses: {refused['reason']}; laws that "
        f"can: {', '.join(refused['laws_that_can'])}. With the paper's gain a true lag reaches "
        f"crossovers up to {refused['nearest_wc']:.3g} rad/s; the one shown here stands at "
        f"{lag['margins']['crossover']:.3g} rad/s, where the plant is at about the -135 deg "
        "that the paper's own section III asks for."
    )


def _checks(result: dict[str, Any]) -> Table:
    table = Table(title="The paper's numbers", title_justify="left", box=None, pad_edge=False)
    for column in ("number", "printed", "recomputed", "verdict"):
        table.add_column(column, overflow="fold")
    for check in result["checks"]:
        good = check["verdict"] == "reproduced"
        table.add_row(
            check["id"],
            printed_text(check),
            text_of(check["recomputed"]),
            Text(check["verdict"], "green" if good else "bold yellow"),
        )
    return table


def printed_text(check: dict[str, Any]) -> str:
    """Return a printed number as it stands on the page, last zeros included."""
    entry = NUMBERS.get(check["id"])
    return entry.text if entry else str(check["printed"])


def text_of(value: float | str | None) -> str:
    """Return a recomputed value with the digits that the paper gives, and more."""
    return value if isinstance(value, str) else number(value, 7)


def _designs(result: dict[str, Any]) -> Table:
    table = Table(title="The four laws, as printed and exact", title_justify="left")
    for column in ("design", "wc, rad/s", "PM, deg", "GM, dB", "Ms", "overshoot, %", "settling, s"):
        table.add_column(column, justify="left" if column == "design" else "right")
    for d in (*result["designs_as_printed"], *result["designs_exact"]):
        m, s = d["margins"], d["step"] or {}
        cells = [m["crossover"], m["phase_margin_deg"], m["gain_margin_db"], m["ms"]]
        cells += [s.get("overshoot_pct"), s.get("settling_time")]
        table.add_row(d["name"], *(c if isinstance(c, str) else number(c) for c in cells))
    return table


def _table_1(result: dict[str, Any]) -> Table:
    table = Table(title="Table I, three ways", title_justify="left")
    table.add_column("")
    for law in LAWS:
        table.add_column(NAMES[law], justify="right")
    for metric in METRICS:
        for way, words in WAYS.items():
            row = [number(result["table_1"][way][law][metric], 4) for law in LAWS]
            last = way == "loop_as_designed"
            table.add_row(f"{WORDS[metric]}, {words}", *row, end_section=last)
    return table
