"""What could be asked for instead of a request that misses something: found by leaving it open."""

from collections.abc import Iterator
from dataclasses import replace

from zoh.analysis.verify import Measured
from zoh.app.commands import Entry, designed
from zoh.app.project import Project, Request
from zoh.lti.systems import Plant
from zoh.request import OF_AUTO, Progress, left_open

_RULE = "textbook_lag"  # which has nothing to choose by


def instead(
    project: Project, request: Request, entry: Entry, progress: Progress | None = None
) -> str | None:
    """Return the fastest design of the same law that misses nothing, in words.

    The margin is kept first, then left open, too. None where nothing is missed, or the request
    has left something open already.
    """
    found = entry.measured
    whole = "wc" in request.parameters and not left_open(request.law, request.parameters)
    if not isinstance(project.plant, Plant) or not isinstance(found, Measured):
        return None
    if not entry.failure or not whole or request.law == _RULE:
        return None
    why = ""
    for tried in _opened(request):
        other = designed(project, tried, progress)
        why = other.failure or ""
        if not why and isinstance(other.measured, Measured):
            m = other.measured.margins
            left = " and ".join(name for name in OF_AUTO if name not in tried.parameters)
            return (
                f"with {left} left open everything is met: by the fastest {request.law} at "
                f"{m.crossover:.6g} rad/s, with a margin of {m.phase_margin_deg:.4g} deg"
            )
    return f"no crossover and no margin would do: {why}"


def _opened(request: Request) -> Iterator[Request]:
    """Yield the request with its crossover left open, and with its margin as well."""
    for dropped in (("wc",), OF_AUTO):
        known = {k: v for k, v in request.parameters.items() if k not in dropped}
        if dropped == ("wc",) and "pm_deg" not in known:
            continue
        yield replace(request, parameters=known)
