"""A law solved by name."""

from cmath import phase
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import degrees
from typing import Protocol

from zoh.analysis.on_target import surely_on_target
from zoh.analysis.results import Gains
from zoh.design import first_order, leadlag
from zoh.design import p as p_law
from zoh.design import pi as pi_law
from zoh.design import pid as pid_law
from zoh.design.target import Opposite, Response, Target
from zoh.errors import Infeasible, SpecError
from zoh.lti.systems import Sampled
from zoh.request import NEGATIVE_GAINS, SPARE, UNDER_MS, UNSTABLE_CONTROLLERS
from zoh.spare import Cost, Line, largest_ki, least_iae, some_ki
from zoh.spec import Crossover

_SIGNED = ("kp", "ki", "kd", "dc_gain")  # what changes its sign with the controller


class Law(Protocol):
    """A solved law, whichever it is."""

    @property
    def gains(self) -> Mapping[str, float]:
        """Return the gains by name."""

    def controller(self) -> Sampled:
        """Return the law in z and in w."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SolvedLaw:
    """The controller of a solved law and its gains by name."""

    controller: Sampled
    gains: Mapping[str, float]

    def opposite(self) -> "SolvedLaw":
        """Return the same with all gains of the other sign."""
        return SolvedLaw(controller=negated(self.controller), gains=opposite(self.gains))


@dataclass(slots=True, kw_only=True)
class Asked:
    """What a law is solved for: a plant, a crossover, the law's own parameters.

    iae    what ``least_iae_ms`` makes least; without it a PID under that Ms is any such
    allow  what of ``zoh.request.ALLOWABLE`` is allowed
    """

    plant: Response
    spec: Crossover
    parameters: Mapping[str, float]
    iae: Cost | None = None
    allow: frozenset[str] = field(default=frozenset())

    @property
    def any_sign(self) -> bool:
        """Return whether gains may be negative."""
        return NEGATIVE_GAINS in self.allow

    @property
    def any_pole(self) -> bool:
        """Return whether the controller may be unstable."""
        return UNSTABLE_CONTROLLERS in self.allow

    def opposite(self) -> "Asked":
        """Return what a law of the other sign has to solve: all of it for the plant's opposite."""
        iae, plant = self.iae, self.plant
        back = negated(plant) if isinstance(plant, Sampled) else Opposite(plant)
        parameters = opposite(self.parameters)
        turned = None if iae is None else lambda controller: iae(negated(controller))
        return Asked(plant=back, spec=self.spec, parameters=parameters, iae=turned)


def solved(
    law: str, sampled: Response, spec: Crossover, parameters: Mapping[str, float],
    iae: Cost | None = None, allow: frozenset[str] = frozenset(),
) -> SolvedLaw:  # fmt: skip
    """Return the law of this name solved at the crossover; raise Infeasible where it cannot be.

    ``iae`` and ``allow`` as in ``Asked``. Raises SpecError where the gains it would need are
    beyond a float.
    """
    asked = Asked(plant=sampled, spec=spec, parameters=parameters, iae=iae, allow=allow)
    try:
        return _solved(law, asked)
    except (OverflowError, ZeroDivisionError):
        raise SpecError(
            "wc", "must be where a float can hold the gains", spec.wc, "use other units"
        ) from None


def _solved(law: str, asked: Asked) -> SolvedLaw:
    if asked.parameters.get("dc_gain", 1.0) < 0:
        return _named(law, asked.opposite()).opposite()
    try:
        return _named(law, asked)
    except Infeasible:
        spare = [name for name in SPARE if name in asked.parameters]
        if not asked.any_sign or law != "pid" or spare == ["ki"]:
            raise
        return _named(law, asked.opposite()).opposite()


def _named(law: str, asked: Asked) -> SolvedLaw:
    found = _LAWS[law](asked)
    gains = dict(found.gains)
    if law == "pd":
        del gains["ki"]
    return SolvedLaw(controller=found.controller(), gains=Gains(gains))


def _p(a: Asked) -> Law:
    return p_law.solve(a.plant, a.spec, any_sign=a.any_sign)


def _pi(a: Asked) -> Law:
    return pi_law.solve(a.plant, a.spec, any_sign=a.any_sign)


def _pd(a: Asked) -> Law:
    return pid_law.solve(a.plant, a.spec, 0.0, a.parameters.get("filter_pole"), any_sign=a.any_sign)


def _pid(a: Asked) -> Law:
    """Return the PID with its spare freedom closed as the parameters say."""
    pole = a.parameters.get("filter_pole")
    if "ti_td" in a.parameters:
        return pid_law.solve_ratio(a.plant, a.spec, a.parameters["ti_td"], pole)
    for how in UNDER_MS:
        if how in a.parameters:
            line = Line.of(
                a.plant, a.spec, a.parameters[how], pole, lambda m: surely_on_target(m, a.spec)
            )
            if how == "largest_ki_ms":
                return largest_ki(line)
            return least_iae(line, a.iae) if a.iae else some_ki(line)
    return pid_law.solve(a.plant, a.spec, a.parameters["ki"], pole, any_sign=a.any_sign)


def _lag(a: Asked) -> Law:
    gain = a.parameters["dc_gain"]
    return first_order.lag(a.plant, a.spec, gain, any_sign=a.any_sign, any_pole=a.any_pole)


def _lead(a: Asked) -> Law:
    gain = a.parameters["dc_gain"]
    return first_order.lead(a.plant, a.spec, gain, any_sign=a.any_sign, any_pole=a.any_pole)


def _textbook_lag(a: Asked) -> Law:
    return first_order.textbook_lag(a.plant, a.spec.wc, a.parameters["dc_gain"])


def _leadlag(a: Asked) -> Law:
    corner, ratio = a.parameters.get("lag_corner"), a.parameters.get("lag_ratio")
    return leadlag.solve(a.plant, a.spec, a.parameters["dc_gain"], corner, ratio)


_LAWS: Mapping[str, Callable[[Asked], Law]] = {
    "p": _p,
    "pi": _pi,
    "pd": _pd,
    "pid": _pid,
    "lag": _lag,
    "textbook_lag": _textbook_lag,
    "lead": _lead,
    "leadlag": _leadlag,
}


def by_gain_alone(plant: Response, wc: float) -> SolvedLaw:
    """Return the P that crosses over at wc in rad/s, with whatever margin the plant has there."""
    law = p_law.P(kp=1 / Target.of(plant, Crossover(wc=wc, pm_deg=90.0)).size, dt=plant.dt)
    return SolvedLaw(controller=law.controller(), gains=law.gains)


def own_margin(plant: Response, wc: float) -> Crossover | None:
    """Return wc and the margin that the plant alone has there; None if that is no margin.

    >>> own_margin(Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0), 1.0).pm_deg  # 90 deg - wc/2
    61.35211...
    """
    pm_deg = (degrees(phase(plant.at(wc))) + 180.0) % 360.0
    return Crossover(wc=wc, pm_deg=pm_deg) if 0 < pm_deg < 180 else None


def opposite(values: Mapping[str, float]) -> dict[str, float]:
    """Return gains or parameters with those of the other sign that have one.

    >>> opposite({"ki": 2.0, "wc": 3.0})
    {'ki': -2.0, 'wc': 3.0}
    """
    return {k: -v if k in _SIGNED else v for k, v in values.items()}


def negated(system: Sampled) -> Sampled:
    """Return what answers the other way round."""
    return Sampled(num=(-1.0,), den=(1.0,), dt=system.dt) * system
