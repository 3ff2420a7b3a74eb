"""What was left open of a request, closed: the fastest crossover, the margin, the law.

Where a law alone is named, its fastest crossover that meets every requirement is taken; where wc
is given, the margin with the most slack. Of ``auto`` the laws are tried from the simplest up,
and the first that can meet everything is taken.
"""

from cmath import phase
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from math import degrees, inf, radians, remainder, tau

from zoh.analysis.results import Choice
from zoh.certificate import backwards, least_turn
from zoh.choice.fastest import Edge, Search, Trial, least_ms
from zoh.choice.judge import Judge
from zoh.design.p import crossovers
from zoh.errors import Infeasible
from zoh.request import AUTO, Progress
from zoh.spec import Requirements

FROM_THE_SIMPLEST = ("p", "pi", "pd", "lead", "lag", "pid", "leadlag")
_INTEGRATES = ("pi", "pid")
ASSUMED = Requirements(pm_deg=45.0, ms=1.7)
_LEAST_PEAK = 1.25  # times the least Ms that a margin allows: what is assumed where that is more


@dataclass(frozen=True, slots=True, kw_only=True)
class Chosen:
    """A law with all its parameters, the requirements they were chosen for, and why these."""

    law: str
    parameters: Mapping[str, float]
    requirements: Requirements
    choice: Choice


def choose(
    judge: Judge, law: str, given: Mapping[str, float], progress: Progress | None = None
) -> Chosen:
    """Return the law, all its parameters set; raise Infeasible where nothing meets everything."""
    nothing = nothing_asked(judge.requirements)
    assumed = _assumed(law, given) if nothing else judge.requirements
    judge = replace(judge, requirements=assumed)
    told = _said(assumed) if nothing else ()
    tried: list[_Tried] = []
    for name in FROM_THE_SIMPLEST if law == AUTO else (law,):
        why = peaks_by_itself(judge, given) or never_at_rest(judge, name)
        if why:
            tried.append(_Tried(law=name, why=why))
            continue
        edge = _edge(judge, name, given, progress)
        if edge.best.met and edge.best.parameters is not None:
            choice = Choice(
                open=_open(law, given, edge.best.parameters),
                assumed=told,
                limits=_limits(edge) if edge.above or "wc" in given else _at_the_end(edge),
                tried=tuple((simpler.law, simpler.why) for simpler in tried),
            )
            return Chosen(
                law=name, parameters=edge.best.parameters, requirements=assumed, choice=choice
            )
        tried.append(_Tried(law=name, why=_nearest(edge.best), best=edge.best))
    raise _refusal(judge, law, given, tried, told)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Tried:
    """A law that does not do, why, and where it came nearest; None where nothing was tried."""

    law: str
    why: str
    best: Trial | None = None

    @property
    def height(self) -> float:
        return -inf if self.best is None else self.best.judgement.height


def peaks_by_itself(judge: Judge, given: Mapping[str, float]) -> str:
    """Return why no loop of the margin given is under the peak allowed; "" if one may be."""
    most = judge.requirements.ms
    if most is None or "pm_deg" not in given:
        return ""
    least = least_ms(given["pm_deg"])
    if least <= most * (1 + 1e-9):  # what misses by rounding alone is met
        return ""
    margin = f"a margin of {given['pm_deg']:g} deg"
    return f"ms must be at most {most:g}, and {margin} alone makes it {least:.5g}"


def never_at_rest(judge: Judge, law: str) -> str:
    """Return why no loop of this law comes to the error at rest that is allowed; "" if one may."""
    allowed = judge.requirements.steady_state_error
    if allowed is None:
        return ""
    if judge.plant.num[-1] == 0:
        if allowed >= abs(judge.reference):
            return ""
        return "the plant has no gain at rest, so no loop follows a constant reference"
    integrates = law in _INTEGRATES or judge.plant.den[-1] == 0
    if integrates or allowed > 0 or judge.weights:
        return ""
    return "an error remains at rest, for neither the law nor the plant integrates"


def nothing_asked(asked: Requirements) -> bool:
    """Return whether no requirement is given."""
    return all(getattr(asked, f.name) is None for f in fields(Requirements))


def _edge(judge: Judge, law: str, given: Mapping[str, float], progress: Progress | None) -> Edge:
    search = Search(judge, law, given, progress)
    if law == "p" and "pm_deg" in given and "wc" not in given:
        return _where_the_plant_has(search, given["pm_deg"])
    if "wc" not in given:
        return search.fastest()
    return Edge(best=search.at(given["wc"], enough=inf), above=None)


def _where_the_plant_has(search: Search, pm_deg: float) -> Edge:
    """Return the fastest P with a margin that is given: the plant has it at a few crossovers."""
    found = [search.at(wc) for wc in crossovers(search.judge.sampled, pm_deg)]
    met = next((trial for trial in found if trial.met), None)
    nearest = max(found, key=lambda trial: trial.judgement.height, default=None)
    return Edge(best=met or nearest or search.fastest().best, above=None)


def _assumed(law: str, given: Mapping[str, float]) -> Requirements:
    """Return what is asked of a loop of which nothing is asked."""
    asked = ASSUMED
    if "pm_deg" in given:
        least = _LEAST_PEAK * least_ms(given["pm_deg"])
        asked = Requirements(ms=max(ASSUMED.ms or 0.0, least))
    return replace(asked, steady_state_error=0.0) if law == AUTO else asked


def _open(law: str, given: Mapping[str, float], found: Mapping[str, float]) -> tuple[str, ...]:
    left = tuple(key for key in found if key not in given)
    return ("law", *left) if law == AUTO else left


def _said(asked: Requirements) -> tuple[str, ...]:
    found = ((f.name, getattr(asked, f.name)) for f in fields(Requirements))
    return tuple(f"{name} = {value:.6g}" for name, value in found if value is not None)


def _limits(edge: Edge) -> tuple[str, ...]:
    """Return what stands against a faster crossover: its name, and what it is there."""
    if edge.above is None:
        return ()
    above, rows = edge.above, edge.above.judgement.rows
    missed = [row.sentence for row in rows if not row.met]
    at = f"above {edge.best.wc:.6g} rad/s"
    if missed:
        return tuple(f"{at} {sentence}" for sentence in missed)
    return (f"{at} {above.judgement.failed}",)


def _at_the_end(edge: Edge) -> tuple[str, ...]:
    """Return that nothing stands against a faster crossover, where the first one tried is met."""
    if not edge.is_first:
        return ()
    return ("nothing limits it below the Nyquist frequency: it is the fastest that is tried",)


def _nearest(best: Trial) -> str:
    if best.parameters is None:
        return f"it can nowhere give the margin asked, not even at {best.wc:.6g} rad/s"
    return f"it comes nearest at {best.wc:.6g} rad/s, where {best.judgement.failed}"


def _refusal(
    judge: Judge, law: str, given: Mapping[str, float], tried: list[_Tried],
    assumed: tuple[str, ...],
) -> Infeasible:  # fmt: skip
    """Return why no crossover, or no law, meets everything."""
    last = max(tried, key=lambda one: one.height)
    where = f" at {given['wc']:.6g} rad/s" if "wc" in given else ""
    told = f" (assumed: {', '.join(assumed)})" if assumed else ""
    what = "no law" if law == AUTO else f"no {law}"
    reason = f"{what} meets everything asked{where}{told}; of a {last.law}, {last.why}"
    if last.best is None:
        pm_deg = given.get("pm_deg", judge.requirements.pm_deg or 45.0)
        return Infeasible(reason, needed_deg=least_turn(judge.sampled, pm_deg))
    pm_deg = (last.best.parameters or given).get("pm_deg", judge.requirements.pm_deg or 45.0)
    turn = radians(pm_deg - 180) - phase(judge.sampled.at(last.best.wc))
    refusal = Infeasible(reason, needed_deg=degrees(remainder(turn, tau)))
    return refusal.because(backwards(judge.sampled))
