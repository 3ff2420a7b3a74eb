"""What could be asked for instead of a request that misses something: found by leaving it open."""

from collections.abc import Iterator, Mapping

from zoh.analysis.verify import Measured
from zoh.app.commands import Entry
from zoh.app.project import Project, Request
from zoh.errors import Infeasible, NotMet
from zoh.lti.systems import Plant
from zoh.pipeline import design
from zoh.request import SPARE, Progress, is_closed

_RULE = "textbook_lag"  # which has nothing to choose by


def instead(
    project: Project, request: Request, entry: Entry, progress: Progress | None = None
) -> str | None:
    """Return the fastest design of the same law that misses nothing, in words.

    The margin is kept first, then left open, too, and at last a ki or dc_gain; what is asked is
    what was. None where nothing is missed, or the request has left something open already.
    """
    missed, plant = isinstance(entry.measured, Measured) and entry.failure, project.plant
    closed = is_closed(request.law, request.parameters) and request.law != _RULE
    if not missed or not closed or not isinstance(plant, Plant):
        return None
    why = ""
    for given in _opened(request.parameters):
        left = " and ".join(name for name in request.parameters if name not in given)
        try:
            found = design(
                plant, request.law, given, dt=project.dt, compute_delay=project.compute_delay,
                sections=request.sections, allow=request.allow, reference=project.reference,
                requirements=project.requirements, progress=progress,
            )  # fmt: skip
        except Infeasible as refused:
            why = f"with {left} left open nothing would do: {refused}"
        except NotMet as short:
            why = f"with {left} left open it is not mended: {short}"
        else:
            m = found.margins
            return (
                f"with {left} left open everything is met: by the fastest {request.law} at "
                f"{m.crossover:.6g} rad/s, with a margin of {m.phase_margin_deg:.4g} deg"
            )
    return why


def _opened(parameters: Mapping[str, float]) -> Iterator[dict[str, float]]:
    """Yield the parameters with the crossover left open, the margin, too, and the free gain."""
    given = dict(parameters)
    for names in (("wc",), ("pm_deg",), ("dc_gain", *SPARE)):
        left = [given.pop(name) for name in names if name in given]
        if left:
            yield dict(given)
