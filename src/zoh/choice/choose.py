"""What was left open of a request, closed: the fastest crossover, the margin, the law.

Where a law alone is named, its fastest crossover that meets every requirement is taken; where wc
is given, the margin with the most slack. Of ``auto`` the laws are tried from the simplest up,
and the first that can meet everything is taken. A lag or lead with a pole that rings from sample
to sample is taken only where nothing else does.
"""

from cmath import phase
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from math import degrees, inf, log, radians, remainder, tau

from zoh.analysis.results import Choice
from zoh.certificate import backwards, least_turn
from zoh.choice.before import why_never
from zoh.choice.fastest import Edge, Search, Trial, least_ms
from zoh.choice.judge import Judge
from zoh.design.p import crossovers
from zoh.design.target import INWARDS, in_digits, in_more_digits
from zoh.errors import Infeasible
from zoh.lti.systems import Sampled
from zoh.request import AUTO, NEGATIVE_GAINS, Progress
from zoh.spec import Requirements

FROM_THE_SIMPLEST = ("p", "pi", "pd", "lead", "lag", "pid", "leadlag")
MAY_RING = ("lead", "lag", "leadlag")  # the laws whose fastest pole is chosen
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
    tried: dict[str, _Tried] = {}
    for name, calm in _in_turn(law):
        why = why_never(judge, name, given)
        if why:
            tried[name] = _Tried(law=name, why=why)
            continue
        edge = _edge(replace(judge, calm=calm), name, given, progress)
        if edge.best.met and edge.best.parameters is not None:
            choice = Choice(
                open=_open(law, given, edge.best.parameters),
                assumed=told,
                limits=_limits(edge, calm) or _at_the_end(edge, name, given),
                tried=tuple((one.law, one.why) for one in tried.values() if one.law != name),
            )
            return Chosen(
                law=name, parameters=edge.best.parameters, requirements=assumed, choice=choice
            )
        tried[name] = _Tried(law=name, why=_nearest(edge), best=edge.best)
    raise _refusal(judge, law, given, list(tried.values()), told, progress)


def _in_turn(law: str) -> list[tuple[str, bool]]:
    """Return the laws to be tried, and whether none of its poles may ring: calm ones first."""
    laws = FROM_THE_SIMPLEST if law == AUTO else (law,)
    ringing = [(name, False) for name in laws if name in MAY_RING]
    return [*((name, name in MAY_RING) for name in laws), *ringing]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Tried:
    """A law that does not do, why, and where it came nearest; None where nothing was tried."""

    law: str
    why: str
    best: Trial | None = None

    @property
    def height(self) -> float:
        return -inf if self.best is None else self.best.judgement.height


def signs(
    sampled: Sampled, parameters: Mapping[str, float], words: frozenset[str]
) -> tuple[bool, ...]:
    """Return whether laws of negative gains are tried, one after the other, the likelier first.

    A gain that is given has its sign; else both are where ``words`` allow negative ones.
    """
    if NEGATIVE_GAINS not in words:
        return (False,)
    given = [parameters[name] < 0 for name in ("ki", "dc_gain") if name in parameters]
    back = bool(backwards(sampled))
    return (given[0],) if given else (back, not back)


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
    found = [search.at(wc) for wc in crossovers(search.judge.facing, pm_deg)]
    if not found:
        return search.fastest()
    met = next((i for i, trial in enumerate(found) if trial.met), None)
    if met is not None:
        return Edge(best=found[met], above=found[met - 1] if met else None, is_first=not met)
    ends = found[-1].wc, found[0].wc
    return Edge(best=max(found, key=lambda t: t.judgement.height), above=None, tried=ends)


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


def _limits(edge: Edge, calm: bool) -> tuple[str, ...]:
    """Return what stands against a faster crossover: its name, and what it is there."""
    if edge.above is None:
        return ()
    above, rows = edge.above, edge.above.judgement.rows
    missed = [row.sentence for row in rows if not row.met]
    at = f"above {edge.best.wc:.6g} rad/s" + (", with no pole that rings," if calm else "")
    if missed:
        return tuple(f"{at} {sentence}" for sentence in missed)
    return (f"{at} {above.judgement.failed}",)


def _at_the_end(edge: Edge, law: str, given: Mapping[str, float]) -> tuple[str, ...]:
    """Return that nothing stands against a faster crossover, where the first one tried is met."""
    if not edge.is_first:
        return ()
    if law == "p" and "pm_deg" in given:
        return (f"the plant has a margin of {given['pm_deg']:g} deg at no faster crossover",)
    return ("nothing limits it below the Nyquist frequency: it is the fastest that is tried",)


def _nearest(edge: Edge) -> str:
    """Return why nothing was met, and where the law comes nearest."""
    best, failed = edge.best, edge.best.judgement.failed
    if edge.tried is None:
        return f"{failed} at {best.wc:.6g} rad/s"
    low, high = edge.tried
    tried = f"tried from {high:.4g} down to {low:.4g} rad/s"
    if best.parameters is None:
        return f"{failed} anywhere ({tried})"
    return f"it comes nearest at {best.wc:.6g} rad/s, where {failed} ({tried})"


def _refusal(
    judge: Judge, law: str, given: Mapping[str, float], tried: list[_Tried],
    assumed: tuple[str, ...], progress: Progress | None,
) -> Infeasible:  # fmt: skip
    """Return why no crossover, or no law, meets everything, and where it can if not here."""
    last = max(tried, key=lambda one: one.height)
    where = f" at {given['wc']:.6g} rad/s" if "wc" in given else ""
    told = f" (assumed: {', '.join(assumed)})" if assumed else ""
    what = "no law" if law == AUTO else f"no {law}"
    reason = f"{what} meets everything asked{where}{told}; of a {last.law}, {last.why}"
    if last.best is None:
        pm_deg = given.get("pm_deg", judge.requirements.pm_deg or 45.0)
        return Infeasible(reason, needed_deg=least_turn(judge.facing, pm_deg))
    pm_deg = (last.best.parameters or given).get("pm_deg", judge.requirements.pm_deg or 45.0)
    response = judge.facing.at(last.best.wc)
    refusal = Infeasible(
        f"{reason}{_another_law(law)}",
        needed_deg=degrees(remainder(radians(pm_deg - 180) - phase(response), tau)),
        needed_gain=1 / abs(response) if "wc" in given else None,
        nearest_wc=_elsewhere(judge, tried, given, progress) if "wc" in given else None,
    )
    turned = backwards(judge.facing)
    return refusal.because(f'{turned}, or allow=["{NEGATIVE_GAINS}"] does' if turned else "")


def _another_law(law: str) -> str:
    return "" if law == AUTO else f'; law="{AUTO}" looks for one that can'


def _elsewhere(
    judge: Judge, tried: list[_Tried], given: Mapping[str, float], progress: Progress | None
) -> float | None:
    """Return the crossover nearest to the one given at which a law that was tried meets everything.

    Of each law its fastest where that is below; else, if what is met is one interval, its slow end.
    """
    fixed = {name: value for name, value in given.items() if name != "wc"}
    found: list[tuple[float, Search]] = []
    for one in tried:
        if one.best is None:
            continue
        best = _edge(judge, one.law, fixed, progress).best
        if not best.met:
            continue
        search = Search(judge, one.law, fixed, progress)
        if best.wc > given["wc"] and (one.law != "p" or "pm_deg" not in fixed):
            best = search.closed_in(best, one.best)[0]
        found.append((best.wc, search))
    nearest = min(found, key=lambda spot: abs(log(spot[0] / given["wc"])), default=None)
    return None if nearest is None else _printed(*nearest, given["wc"])


def _printed(wc: float, search: Search, given: float) -> float:
    """Return a crossover as it is printed, in the digits with which all is met there, too."""
    away = 1 if wc > given else -1
    for units in INWARDS:
        printed = in_digits(wc, away, units)
        if search.at(printed).met:
            return printed
    return in_more_digits(lambda w: search.at(w).met, wc, away)
