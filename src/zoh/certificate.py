"""What could be had where a law cannot: all of it tried, none guessed."""

from collections.abc import Callable, Iterable, Mapping
from math import ceil, cos, inf

import numpy as np

from zoh.analysis.loop import Loop
from zoh.analysis.margins import glance
from zoh.analysis.nyquist import closed_loop_stable, nearest_crossing
from zoh.analysis.on_target import ELSEWHERE, UNSTABLE, surely_at
from zoh.design import p as p_law
from zoh.design import pid as pid_law
from zoh.design.target import ABOVE, BELOW, Response, Target, nearest
from zoh.errors import Infeasible, SpecError
from zoh.lti.forms import time_constant
from zoh.lti.systems import Sampled
from zoh.request import (
    LAWS,
    NEGATIVE_GAINS,
    SPARE,
    UNDER_MS,
    UNSTABLE_CONTROLLERS,
    Progress,
    bounded_ms,
)
from zoh.solving import solved
from zoh.spec import Crossover

_AS_WELL = {"largest_ki_ms": "least_iae_ms"}  # there is one where there is the other
_APPROACHED_DEG = 1e-6  # from an open interval's end: how near to it a margin is offered
_STEP_DEG, _SEARCHED_STEP_DEG = 0.5, 5.0  # of the margins looked at; a search takes longer
_NARROW_DEG = 25.0  # an interval of phases below which fewer degrees are stepped over
_EDGE_DEG = 1e-7  # what is offered is had within ten times that
_WORDS = (NEGATIVE_GAINS, UNSTABLE_CONTROLLERS)
_TURNED = "a negative sensor gain turns it round"
_OF_THE_ROOM = (1e-3, 0.03, 0.3)  # that a PID's ki has where it has to turn the phase back
_SMALL_KI = 1e-3  # times wc/|G|: an integral that is there and turns next to nothing


def least_turn(sampled: Sampled, pm_deg: float) -> float:
    """Return the smallest phase in deg, over all frequencies, that would make up the margin."""
    phase = np.degrees(np.angle(sampled.at(p_law.looked_at(sampled))))
    turns = (pm_deg - phase) % 360.0 - 180.0
    return float(turns[np.argmin(np.abs(turns))])


def certified(
    refused: Infeasible, law: str, sampled: Sampled, spec: Crossover,
    parameters: Mapping[str, float], allow: frozenset[str] = frozenset(),
    progress: Progress | None = None,
) -> Infeasible:  # fmt: skip
    """Return the refusal with where this law can, and which laws can here; all of it tried."""
    most = bounded_ms(parameters)

    def fails(controller: Sampled, at: Crossover) -> str:
        loop = Loop.of(controller, sampled)
        if not closed_loop_stable(loop):
            return UNSTABLE
        crossover, pm_deg = nearest_crossing(loop)
        if not surely_at(crossover, pm_deg, at):
            return f"{ELSEWHERE}, {'early' if pm_deg < 0 else 'late'}"  # as its phase is
        return "" if most == inf or glance(loop).ms <= most else "its Ms is above the bound"

    told = advised(refused, law, sampled, spec, parameters, fails, allow, progress)
    if told.nearest_wc is not None or NEGATIVE_GAINS in allow:
        return told
    return told.because(backwards(sampled))


def backwards(sampled: Sampled) -> str:
    """Return a hint where the gains had better be of the other sign, nothing where they are right.

    The last coefficient of the closed loop's polynomial in w is the plant's own, which an odd
    number of unstable poles makes negative, plus one of the gain's sign: it has to become
    positive, as the first one is. Of a stable plant weak gains may do, and drive it away; of an
    unstable one without a gain at rest no sign does.

    >>> backwards(Sampled(num=[-1.0], den=[1.0, -0.5], dt=0.1))
    'the plant answers backwards at low frequencies: a negative sensor gain turns it round'
    >>> backwards(Sampled(num=[1.0], den=[1.0, -2.0], dt=0.1))  # one unstable pole: as it should
    ''
    """
    first = next(c for c in sampled.den_w if c)
    top, bottom = (next(c for c in reversed(a) if c) for a in (sampled.num_w, sampled.den_w))
    if top * first > 0:
        return ""
    if bottom * first > 0:
        return f"the plant answers backwards at low frequencies: {_TURNED}"
    if sampled.num_w[-1] == 0:
        return ""
    return f"an unstable plant of this sign asks for negative gains: {_TURNED}"


def advised(
    refused: Infeasible, law: str, sampled: Response, spec: Crossover,
    parameters: Mapping[str, float], fails: Callable[[Sampled, Crossover], str],
    allow: frozenset[str] = frozenset(), progress: Progress | None = None,
) -> Infeasible:  # fmt: skip
    """Return the refusal with all that could be had instead.

    fails  how a controller's loop is not what is wanted, "" where it is
    """
    wanted = {_AS_WELL.get(k, k): v for k, v in parameters.items()}

    def reason(
        name: str, at: Crossover, given: Mapping[str, float], also: frozenset[str]
    ) -> str:  # fmt: skip
        try:
            found = solved(name, sampled, at, given, None, also)
        except Infeasible as here:
            return _side(here)
        return fails(found.controller, at)

    def why_not(name: str, at: Crossover, also: frozenset[str] = allow) -> str:
        if progress is not None:
            what = f"{at.pm_deg:.4g} deg at {at.wc:.4g} rad/s"
            progress(f"{law} cannot; is there a {name} of {what}?")
        try:
            return _first_reason(
                reason(name, at, {**free, **wanted}, also)
                for free in _free(name, sampled, at, wanted)
            )
        except (SpecError, ArithmeticError):  # the last one in what is tried
            return "its gains are beyond a float"

    def works(name: str, at: Crossover, also: frozenset[str] = allow) -> bool:
        return not why_not(name, at, also)

    def has(pm_deg: float) -> bool:
        return 0 < pm_deg < 180 and works(law, Crossover(wc=spec.wc, pm_deg=pm_deg))

    searched = any(k in parameters for k in UNDER_MS)
    end = 180.0 if allow and law != "p" else None  # a P has one margin, of whichever sign
    words = [w for w in _WORDS if w not in allow and works(law, spec, allow | {w})]
    return Infeasible(
        "; ".join([refused.reason, *(f'allow=["{word}"] permits one here' for word in words)]),
        needed_deg=refused.needed_deg,
        needed_gain=refused.needed_gain,
        gives_deg=refused.gives_deg,
        best_pm_deg=best_margin(has, refused, _SEARCHED_STEP_DEG if searched else _STEP_DEG, end),
        nearest_wc=nearest(
            lambda wc: why_not(law, Crossover(wc=wc, pm_deg=spec.pm_deg)),
            spec.wc,
            sampled.dt,
            sampled.delay if isinstance(sampled, Sampled) else 0,
        ),
        laws_that_can=tuple(name for name in LAWS if name != law and works(name, spec)),
    )


def _first_reason(reasons: Iterable[str]) -> str:
    """Return the first reason, "" as soon as one is none."""
    first = ""
    for here in reasons:
        if not here:
            return ""
        first = first or here
    return first


def _side(refused: Infeasible) -> str:
    """Return on which side of what the law gives the phase needed is, or that nothing tells."""
    if refused.gives_deg is None or refused.needed_deg is None:
        return "refused"
    low, high = refused.gives_deg
    return (
        BELOW if refused.needed_deg <= low else ABOVE if refused.needed_deg >= high else "refused"
    )


def best_margin(
    has: Callable[[float], bool], refused: Infeasible, step: float, end: float | None = None
) -> float | None:
    """Return the largest margin in deg that ``has`` says can be had, None if none.

    One 1e-6 deg below the end of the phases (``end`` where the law has no such), where that and
    half of it can be had; else looked for from there down, ``step`` deg at a time, a narrow
    interval as closely as one of 25 deg, the edge then halved to 1e-7 deg, and its good side
    returned.
    """
    span = 180.0
    if end is None:
        end = refused.best_pm_deg
        if refused.gives_deg is not None:
            span = min(span, refused.gives_deg[1] - refused.gives_deg[0])
    if end is None:
        return None
    low, high = refused.gives_deg or (0.0, 0.0)
    if has(end - _APPROACHED_DEG) and has(end - _APPROACHED_DEG / 2):
        return end - _APPROACHED_DEG
    if high - low < _APPROACHED_DEG:  # a P: its interval is one margin, but for rounding
        return end - (high - low) / 2 if has(end - (high - low) / 2) else None

    def surely(pm_deg: float) -> bool:  # where |L| is flat, one margin may be had by luck
        return has(pm_deg) and has(pm_deg - _APPROACHED_DEG)

    step *= min(1.0, span / _NARROW_DEG)
    for k in range(1, ceil(min(end, span) / step)):
        if surely(good := end - k * step):
            return _edge(surely, good, good + step)
    return None


def _edge(has: Callable[[float], bool], good: float, bad: float) -> float:
    """Return the good end of the edge between the two."""
    while bad - good > _EDGE_DEG:
        middle = (good + bad) / 2
        if has(middle):
            good = middle
        else:
            bad = middle
    return good


def _free(
    law: str, sampled: Response, spec: Crossover, given: Mapping[str, float]
) -> list[dict[str, float]]:
    """Return values to try for gains that were not given: modest ones that leave room.

    A small integral, then, where it has to turn the phase back, more of it; a gain at w = 0 from
    which a lead has to rise, or a lag to fall, to twice or half of it along the way; for a
    lead-lag twice what is needed at the crossover.
    """
    target = Target.of(sampled, spec)
    needed = max(cos(target.theta), 0.1) / target.size
    modest = needed / 2 if target.theta > 0 else 2 / (needed * target.size**2)
    free = {
        "ki": _SMALL_KI * spec.wc / target.size,
        "dc_gain": 2 / target.size if law == "leadlag" else modest,
    }
    if law != "pid" or any(name in given for name in SPARE):
        return [free]
    room = pid_law.room(target, time_constant(given.get("filter_pole"), sampled.dt))
    if room is None or room[0] < free["ki"]:
        return [free]
    low, high = room
    return [{**free, "ki": low + (high - low) * share} for share in _OF_THE_ROOM]
