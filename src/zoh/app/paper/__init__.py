"""The robot arm of the paper: every printed number beside the recomputed one.

``run`` gives everything as JSON values, ``summary`` shows it in a terminal and ``report``
as pages and figures. The paper's own recipe lives here and nowhere else in the package.
"""

from typing import TYPE_CHECKING, Any

from zoh.app.paper import checks, findings, study, table
from zoh.app.paper.study import Study
from zoh.errors import Infeasible

if TYPE_CHECKING:
    from rich.console import Group

__all__ = ["report", "run", "summary"]


def run() -> dict[str, Any]:
    """Return the JSON object of ``zoh paper --json``."""
    found = study.study()
    checked = checks.checks(found)
    return {
        "checks": [check.to_dict() for check in checked],
        "unexplained": [check.id for check in checked if check.verdict == checks.UNEXPLAINED],
        "findings": [finding.to_dict() for finding in findings.findings(found)],
        "designs_as_printed": [d.to_dict() for d in found.as_printed.values()],
        "designs_as_typed_in": [d.to_dict() for d in found.as_typed.values()],
        "plant_as_typed_in": _typed_plant(found),
        "designs_exact": [d.to_dict() for d in found.exact.values()],
        "lag_refused": _refusal(found.refused),
        "table_1": table.three_ways(found),
    }


def report(result: dict[str, Any]) -> dict[str, str | bytes]:
    """Return {file name: content}: REPORT.md and every figure as SVG and PNG."""
    from zoh.app.paper.pages import pages

    return pages(result, study.study())


def summary(result: dict[str, Any]) -> "Group":
    """Return the result for a rich console."""
    from zoh.app.paper.terminal import shown

    return shown(result)


def _typed_plant(found: Study) -> dict[str, Any]:
    system, margins = found.printed_plant
    return {
        "plant": {"num": list(system.num), "den": list(system.den), "dt": system.dt},
        "largest_pole": max(abs(complex(pole)) for pole in system.poles()),
        "margins": margins.to_dict(),
    }


def _refusal(refused: Infeasible) -> dict[str, Any]:
    return {
        "reason": refused.reason,
        "needed_deg": refused.needed_deg,
        "needed_gain": refused.needed_gain,
        "gives_deg": refused.gives_deg,
        "best_pm_deg": refused.best_pm_deg,
        "nearest_wc": refused.nearest_wc,
        "laws_that_can": list(refused.laws_that_can),
    }
