"""One candidate beside everything that is asked, by measurement alone."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, nan

import numpy as np

from zoh import checks
from zoh.analysis.asked import OF_TIME, Compared, checked, of_effort, of_margins, of_time
from zoh.analysis.loop import Loop
from zoh.analysis.margins import glance
from zoh.analysis.nyquist import closed_loop_stable
from zoh.analysis.on_target import surely_on_target
from zoh.analysis.responses import noise_gains
from zoh.analysis.rest import gains_at_rest
from zoh.analysis.results import StepInfo
from zoh.analysis.step import closed_loop_step
from zoh.choice.freedom import SLOWEST
from zoh.errors import Infeasible, SpecError
from zoh.lti import poly
from zoh.lti.forms import ringing
from zoh.lti.systems import Sampled
from zoh.lti.weights import WEIGHTS, feedforward
from zoh.lti.wplane import warp
from zoh.solving import SolvedLaw, negated, solved
from zoh.spec import Crossover
from zoh.workbench import Setting

_WITHOUT_A_STEP = ("steady_state_error", "noise_gain")  # the gains at w = 0, and the poles, tell
_OF_A_STEP = tuple(name for name in OF_TIME if name not in _WITHOUT_A_STEP)


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """How a candidate fares: the least slack of what is asked, and what it is the slack of.

    slack     relative, 0 or more where everything is met; -1 and less where there is nothing to
              compare
    failed    what stands against the candidate, in words; empty where it is met
    compared  whether there is a loop to compare
    """

    slack: float
    rows: tuple[Compared, ...] = ()
    failed: str = ""
    compared: bool = False

    @property
    def height(self) -> float:
        """Return what a search climbs: a loop that misses by much is above none at all.

        >>> Judgement(slack=-3.0).height  # no loop to compare
        -3.0
        """
        return self.slack / (1 - self.slack) if self.compared and self.slack < 0 else self.slack


@dataclass(frozen=True, slots=True, kw_only=True)
class Judge(Setting):
    """A setting in which candidates are compared.

    back  whether the laws are of negative gains: solved on the opposite plant, then turned
    calm  whether a law with a pole that rings from sample to sample is none
    """

    back: bool = False
    calm: bool = False

    def __post_init__(self) -> None:
        checked(self.requirements)
        checks.number("reference", self.reference, "give the size of the step")

    @property
    def through(self) -> float:
        """Return what the plant answers in the very sample of an input of 1, seen by its sensor."""
        plant = self.plant
        if plant.dead_time or self.compute_delay or len(plant.num) < len(plant.den):
            return 0.0
        return plant.sensor * plant.num[0] / plant.den[0]

    @property
    def facing(self) -> Sampled:
        """Return the plant that laws of positive gains are solved on."""
        return negated(self.sampled) if self.back else self.sampled

    @property
    def asks_effort(self) -> bool:
        """Return whether the effort of a step is bounded."""
        asked = self.requirements
        return not asked.peak_effort is asked.effort_min is asked.effort_max is None

    def of(
        self, law: str, parameters: Mapping[str, float], worth: float = -inf
    ) -> Judgement:  # fmt: skip
        """Return the judgement of a law with these parameters, wc and pm_deg among them.

        worth  a slack below which the first effort of a step alone is enough to tell
        """
        spec = Crossover(wc=parameters["wc"], pm_deg=parameters["pm_deg"])
        try:
            found = solved(law, self.facing, spec, parameters)
            loop = Loop.of(found.controller, self.facing)
        except (Infeasible, SpecError) as refused:
            return Judgement(slack=-4.0, failed=str(refused))
        if self.calm and ringing(found.gains, self.sampled.dt):
            return Judgement(slack=-2.0, failed="a pole of the controller rings at every sample")
        if self.effort_slack(found) < worth:
            return self._at_once(found)
        if "ti_td" in parameters and _slow(found.controller, spec.wc):
            return Judgement(slack=-2.0, failed="a zero of the controller is a decade below wc")
        if not closed_loop_stable(loop):
            return Judgement(slack=-3.0, failed="the closed loop is unstable")
        margins = glance(loop)
        if not surely_on_target(margins, spec):
            return Judgement(slack=-2.0, failed="the margin is smaller at another crossover")
        rows = of_margins(self.requirements, margins)
        if any(getattr(self.requirements, name) is not None for name in OF_TIME):
            rows += self._in_time(found)
        return judged(rows)

    def effort_slack(self, found: SolvedLaw) -> float:
        """Return a bound that the slack of the effort is not above: that of its first sample."""
        return min((row.slack for row in self._first_effort(found)), default=inf)

    def _at_once(self, found: SolvedLaw) -> Judgement:
        """Return the judgement of a loop whose first effort is far beyond what is allowed."""
        rows = self._first_effort(found)
        missed = [
            f"{row.demand}, and in the first sample of a step it is {row.value:.6g}"
            for row in rows
            if not row.met
        ]
        slack = min(row.slack for row in rows)
        return Judgement(slack=slack, failed="; ".join(missed), compared=True)

    def _first_effort(self, found: SolvedLaw) -> list[Compared]:
        """Return what is asked of the effort beside its first sample after a step.

        It is r P/(1 + C G), each at z = inf, P what leads from the reference to the effort.
        """
        if not self.asks_effort:
            return []
        controller, ahead = self._paths(found)
        direct = at_once(controller)
        path = direct + (at_once(ahead) if ahead else 0.0)
        back = 1 + direct * self.through
        first = self.reference * path / back if back else nan
        return of_effort(
            self.requirements, StepInfo(peak_effort=abs(first), effort_range=(first, first))
        )

    def _in_time(self, found: SolvedLaw) -> list[Compared]:
        controller, ahead = self._paths(found)
        noise = None
        if self.requirements.noise_gain is not None:
            noise = noise_gains(self.plant, controller, compute_delay=self.compute_delay)[1]
        if any(getattr(self.requirements, name) is not None for name in _OF_A_STEP):
            step = closed_loop_step(
                self.plant, controller, compute_delay=self.compute_delay,
                reference=self.reference, feedforward=ahead,
            )  # fmt: skip
        else:
            error = gains_at_rest(self.plant, controller, ahead).error
            step = StepInfo(steady_state_error=self.reference * error)
        return of_time(self.requirements, step, noise)

    def _paths(self, found: SolvedLaw) -> tuple[Sampled, Sampled | None]:
        """Return the controller with what is fixed, and the feedforward that a weight makes."""
        found = found.opposite() if self.back else found
        setpoint, derivative = (self.weights.get(name, 1.0) for name in WEIGHTS)
        ahead = feedforward(found.gains, setpoint, derivative, self.sampled.dt)
        return self.whole(found.controller), self.whole(ahead) if ahead else None


def at_once(system: Sampled) -> float:
    """Return what a system without delay answers in the very sample of an input of 1: at z = inf.

    nan where it has a pole there.

    >>> at_once(Sampled(num=[2.0, -1.0], den=[1.0, -0.5], dt=0.1))
    2.0
    """
    w = 2 / system.dt
    den = float(poly.at(system.den_w, w))
    return float(poly.at(system.num_w, w)) / den if den else nan


def _slow(controller: Sampled, wc: float) -> bool:
    """Return whether a zero is slower than a choice may have: Ti/Td alone does not say."""
    return slowest_zero(controller) < SLOWEST * warp(wc, controller.dt)


def slowest_zero(controller: Sampled, fixed: Sampled | None = None) -> float:
    """Return the rate in rad/s (w-plane) at which the slowest zero decays, inf where none is.

    Zeros of what is ``fixed`` in series do not count.

    >>> slowest_zero(Sampled.from_w(num_w=(1.0, 3.0, 2.0), den_w=(1.0, 5.0, 6.0), dt=0.1))
    1.0
    """
    zeros = poly.roots(controller.num_w)
    for known in poly.roots(fixed.num_w) if fixed else ():
        zeros = np.delete(zeros, np.argmin(np.abs(zeros - known)))
    return float((-zeros.real).min(initial=inf))


def judged(rows: list[Compared]) -> Judgement:
    """Return the judgement of a stable loop that crosses over where it should."""
    least = min((row.slack for row in rows), default=0.0)
    missed = [row.sentence for row in rows if not row.met]
    if not missed:
        least = max(least, 0.0)  # what is missed by rounding alone is met
    return Judgement(slack=least, rows=tuple(rows), failed="; ".join(missed), compared=True)
