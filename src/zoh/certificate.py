"""A law solved by name, and what could be had where it cannot: all of it tried, none guessed."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import cos

import numpy as np

from zoh.analysis.loop import Loop
from zoh.analysis.margins import glance
from zoh.analysis.results import Margins
from zoh.analysis.stability import closed_loop_stable
from zoh.analysis.tabled.margins import Seen
from zoh.design import first_order
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
    "lead": ("wc", "pm_deg", "dc_gain"),
}
"""Every law and the parameters it takes."""

OPTIONS: Mapping[str, tuple[str, ...]] = {
    "pd": ("filter_pole",),
    "pid": ("filter_pole", "ti_td", "largest_ki_ms", "least_iae_ms"),
}
"""What a law takes besides; one of the PID's ``SPARE`` stands for its ki."""

SPARE = ("ki", "ti_td", "largest_ki_ms", "least_iae_ms")

_MARGIN_TOL_DEG = 1e-9  # the promise of this library; the closed forms reach some 1e-13
_CROSSOVER_TOL = 1e-9  # relative
_AS_WELL = {"largest_ki_ms": "least_iae_ms"}  # there is one where there is the other
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
    found: p_law.P | pi_law.PI | pid_law.PID | first_order.FirstOrder
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
    under = {k: parameters[k] for k in ("largest_ki_ms", "least_iae_ms") if k in parameters}
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

    def holds(controller: Sampled, at: Crossover) -> bool:
        loop = Loop.of(controller, sampled)
        return closed_loop_stable(loop) and not off_target(glance(loop), at)

    return advised(refused, law, sampled, spec, parameters, holds)


def advised(
    refused: Infeasible, law: str, sampled: Response, spec: Crossover,
    parameters: Mapping[str, float], holds: Callable[[Sampled, Crossover], bool],
) -> Infeasible:  # fmt: skip
    """Return the refusal with all that could be had instead, tried by ``holds``."""

    def works(name: str, at: Crossover) -> bool:
        wanted = {_AS_WELL.get(k, k): v for k, v in parameters.items()}
        try:
            found = solved(name, sampled, at, {**_free(sampled, at), **wanted})
        except (Infeasible, SpecError, OverflowError):  # the last one in what is tried
            return False
        return holds(found.controller, at)

    return Infeasible(
        refused.reason,
        needed_deg=refused.needed_deg,
        best_pm_deg=refused.best_pm_deg,
        nearest_wc=nearest(
            lambda wc: works(law, Crossover(wc=wc, pm_deg=spec.pm_deg)), spec.wc, sampled.dt
        ),
        laws_that_can=tuple(name for name in LAWS if name != law and works(name, spec)),
    )


def _free(sampled: Response, spec: Crossover) -> dict[str, float]:
    """Return values to try for gains that were not given: modest ones that leave room.

    A small integral; a gain at w = 0 from which a lead has to rise, or a lag to fall, to twice
    or half of it along the way.
    """
    target = Target.of(sampled, spec)
    needed = max(cos(target.theta), 0.1) / target.size
    return {
        "ki": _SMALL_KI * spec.wc / target.size,
        "dc_gain": needed / 2 if target.theta > 0 else 2 / (needed * target.size**2),
    }
