"""A law solved by name, and what could be had where it cannot: all of it tried, none guessed."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil, cos, inf

import numpy as np

from zoh.analysis.loop import Loop
from zoh.analysis.margins import glance
from zoh.analysis.results import Margins
from zoh.analysis.stability import closed_loop_stable
from zoh.analysis.tabled.margins import Seen
from zoh.design import first_order, leadlag
from zoh.design import p as p_law
from zoh.design import pi as pi_law
from zoh.design import pid as pid_law
from zoh.design.target import Response, Target, nearest
from zoh.errors import Infeasible, SpecError
from zoh.lti.systems import Sampled
from zoh.spare import Cost, Line, largest_ki, least_iae, some_ki
from zoh.spec import Crossover

LAWS: Mapping[str, tuple[str, ...]] = {
    "p": ("wc", "pm_deg"),
    "pi": ("wc", "pm_deg"),
    "pd": ("wc", "pm_deg"),
    "pid": ("wc", "pm_deg", "ki"),
    "lag": ("wc", "pm_deg", "dc_gain"),
    "textbook_lag": ("wc", "dc_gain"),
    "lead": ("wc", "pm_deg", "dc_gain"),
    "leadlag": ("wc", "pm_deg", "dc_gain"),
}
"""Every law and the parameters it takes."""

OPTIONS: Mapping[str, tuple[str, ...]] = {
    "pd": ("filter_pole",),
    "pid": ("filter_pole", "ti_td", "largest_ki_ms", "least_iae_ms"),
    "textbook_lag": ("pm_deg",),
    "leadlag": ("lag_corner", "lag_ratio"),
}
"""What a law takes besides; one of the PID's ``SPARE`` stands for its ki."""

UNDER_MS = ("largest_ki_ms", "least_iae_ms")
SPARE = ("ki", "ti_td", *UNDER_MS)

_MARGIN_TOL_DEG = 1e-9  # the promise of this library; the closed forms reach some 1e-13
_CROSSOVER_TOL = 1e-9  # relative
_AS_WELL = {"largest_ki_ms": "least_iae_ms"}  # there is one where there is the other
_APPROACHED_DEG = 1e-6  # an open interval's end is had this near to it
_STEP_DEG, _SEARCHED_STEP_DEG = 0.5, 5.0  # of the margins looked at; a search takes longer
_EDGE_DEG = 1e-9
_SMALL_KI = 1e-3  # times wc/|G|: an integral that is there and turns next to nothing


@dataclass(frozen=True, slots=True, kw_only=True)
class SolvedLaw:
    """A solved law, whichever it is."""

    controller: Sampled
    gains: Mapping[str, float]


def solved(
    law: str, sampled: Response, spec: Crossover, parameters: Mapping[str, float],
    iae: Cost | None = None,
) -> SolvedLaw:  # fmt: skip
    """Return the law of this name solved at the crossover; raise Infeasible where it cannot be.

    ``iae`` is what ``least_iae_ms`` makes least; without it a PID under that Ms is any such.
    Raises SpecError where the gains it would need are beyond a float.
    """
    try:
        return _solved(law, sampled, spec, parameters, iae)
    except (OverflowError, ZeroDivisionError):
        raise SpecError(
            "wc", "must be where a float can hold the gains", spec.wc, "use other units"
        ) from None


def _solved(
    law: str, sampled: Response, spec: Crossover, parameters: Mapping[str, float],
    iae: Cost | None,
) -> SolvedLaw:  # fmt: skip
    found: p_law.P | pi_law.PI | pid_law.PID | first_order.FirstOrder | leadlag.LeadLag
    if law == "p":
        found = p_law.solve(sampled, spec)
    elif law == "pi":
        found = pi_law.solve(sampled, spec)
    elif law == "pd":
        found = pid_law.solve(sampled, spec, 0.0, parameters.get("filter_pole"))
    elif law == "pid":
        found = _pid(sampled, spec, parameters, iae)
    elif law == "lag":
        found = first_order.lag(sampled, spec, parameters["dc_gain"])
    elif law == "textbook_lag":
        found = first_order.textbook_lag(sampled, spec.wc, parameters["dc_gain"])
    elif law == "leadlag":
        corner, ratio = parameters.get("lag_corner"), parameters.get("lag_ratio")
        found = leadlag.solve(sampled, spec, parameters["dc_gain"], corner, ratio)
    else:
        found = first_order.lead(sampled, spec, parameters["dc_gain"])
    gains = {k: v for k, v in found.gains.items() if law != "pd" or k != "ki"}
    return SolvedLaw(controller=found.controller(), gains=gains)


def _pid(
    sampled: Response, spec: Crossover, parameters: Mapping[str, float], iae: Cost | None
) -> pid_law.PID:
    """Return the PID with its spare freedom closed as the parameters say."""
    pole = parameters.get("filter_pole")
    if "ti_td" in parameters:
        return pid_law.solve_ratio(sampled, spec, parameters["ti_td"], pole)
    under = {k: parameters[k] for k in UNDER_MS if k in parameters}
    for how, ms in under.items():
        line = Line.of(sampled, spec, ms, pole, lambda m: not off_target(m, spec))
        if how == "largest_ki_ms":
            return largest_ki(line)
        return least_iae(line, iae) if iae else some_ki(line)
    return pid_law.solve(sampled, spec, parameters["ki"], pole)


def least_turn(sampled: Sampled, pm_deg: float) -> float:
    """Return the smallest phase in deg, over all frequencies, that would make up the margin."""
    phase = np.degrees(np.angle(sampled.at(p_law.looked_at(sampled))))
    turns = (pm_deg - phase) % 360.0 - 180.0
    return float(turns[np.argmin(np.abs(turns))])


def off_target(m: Margins | Seen, spec: Crossover) -> bool:
    """Return whether the margin nearest to zero is another one than was asked for."""
    return (
        m.crossover is None
        or abs(m.phase_margin_deg - spec.pm_deg) > _MARGIN_TOL_DEG
        or abs(m.crossover / spec.wc - 1) > _CROSSOVER_TOL
    )


def not_as_asked(m: Margins, spec: Crossover | None) -> list[str]:
    """Return what is not as the crossover was asked for; instability speaks for itself."""
    if spec is None or not m.stable or not off_target(m, spec):
        return []
    at = "no frequency" if m.crossover is None else f"{m.crossover:.6g} rad/s"
    return [
        f"the phase margin is {m.phase_margin_deg:.6g} deg at {at}, another crossover "
        f"of this loop, not {spec.pm_deg:g} deg at {spec.wc:g} rad/s"
    ]


def certified(
    refused: Infeasible, law: str, sampled: Sampled, spec: Crossover,
    parameters: Mapping[str, float],
) -> Infeasible:  # fmt: skip
    """Return the refusal with where this law can, and which laws can here; all of it tried."""
    most = min((parameters[k] for k in UNDER_MS if k in parameters), default=inf)

    def holds(controller: Sampled, at: Crossover) -> bool:
        loop = Loop.of(controller, sampled)
        if not closed_loop_stable(loop):
            return False
        found = glance(loop)
        return not off_target(found, at) and found.ms <= most

    told = advised(refused, law, sampled, spec, parameters, holds)
    return told if told.nearest_wc is not None else told.because(backwards(sampled))


def backwards(sampled: Sampled) -> str:
    """Return a hint where the plant answers backwards at rest, nothing where it does not.

    >>> backwards(Sampled(num=[-1.0], den=[1.0, -0.5], dt=0.1))
    'the plant answers backwards at low frequencies: a negative sensor gain turns it round'
    >>> backwards(Sampled(num=[1.0], den=[1.0, -0.5], dt=0.1))
    ''
    """
    top, bottom = (next(c for c in reversed(a) if c) for a in (sampled.num_w, sampled.den_w))
    if top * bottom > 0:
        return ""
    return "the plant answers backwards at low frequencies: a negative sensor gain turns it round"


def advised(
    refused: Infeasible, law: str, sampled: Response, spec: Crossover,
    parameters: Mapping[str, float], holds: Callable[[Sampled, Crossover], bool],
) -> Infeasible:  # fmt: skip
    """Return the refusal with all that could be had instead, tried by ``holds``."""

    def works(name: str, at: Crossover) -> bool:
        wanted = {_AS_WELL.get(k, k): v for k, v in parameters.items()}
        try:
            found = solved(name, sampled, at, {**_free(name, sampled, at), **wanted})
        except (Infeasible, SpecError, OverflowError):  # the last one in what is tried
            return False
        return holds(found.controller, at)

    def has(pm_deg: float) -> bool:
        return 0 < pm_deg < 180 and works(law, Crossover(wc=spec.wc, pm_deg=pm_deg))

    searched = any(k in parameters for k in UNDER_MS)
    return Infeasible(
        refused.reason,
        needed_deg=refused.needed_deg,
        needed_gain=refused.needed_gain,
        gives_deg=refused.gives_deg,
        best_pm_deg=best_margin(has, refused, _SEARCHED_STEP_DEG if searched else _STEP_DEG),
        nearest_wc=nearest(
            lambda wc: works(law, Crossover(wc=wc, pm_deg=spec.pm_deg)), spec.wc, sampled.dt
        ),
        laws_that_can=tuple(name for name in LAWS if name != law and works(name, spec)),
    )


def best_margin(has: Callable[[float], bool], refused: Infeasible, step: float) -> float | None:
    """Return the largest margin in deg that ``has`` says can be had, None if none.

    The end of the phases, where a margin just below it can be had; else looked for from there
    down, ``step`` deg at a time, the edge then halved to 1e-9 deg, and its good side returned.
    """
    end = refused.best_pm_deg
    if end is None:
        return None
    low, high = refused.gives_deg or (0.0, 0.0)
    if has(end - _APPROACHED_DEG) and has(end - _APPROACHED_DEG / 2):
        return end
    if high - low < _APPROACHED_DEG:  # a P: its interval is one margin, but for rounding
        return end - (high - low) / 2 if has(end - (high - low) / 2) else None

    def surely(pm_deg: float) -> bool:  # where |L| is flat, one margin may be had by luck
        return has(pm_deg) and has(pm_deg - _APPROACHED_DEG)

    for k in range(1, ceil(end / step)):
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


def _free(law: str, sampled: Response, spec: Crossover) -> dict[str, float]:
    """Return values to try for gains that were not given: modest ones that leave room.

    A small integral; a gain at w = 0 from which a lead has to rise, or a lag to fall, to twice
    or half of it along the way; for a lead-lag twice what is needed at the crossover.
    """
    target = Target.of(sampled, spec)
    needed = max(cos(target.theta), 0.1) / target.size
    modest = needed / 2 if target.theta > 0 else 2 / (needed * target.size**2)
    return {
        "ki": _SMALL_KI * spec.wc / target.size,
        "dc_gain": 2 / target.size if law == "leadlag" else modest,
    }
