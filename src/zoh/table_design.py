"""Laws designed on a table: the same closed forms, measured on the same table.

A law asks a plant for one complex gain; where that comes from a table the margin at wc is exact
for the curve between its points. What the table does not show is not designed for, and refused.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import radians, remainder, tau

import numpy as np

from zoh.analysis.crossings import sign_changes
from zoh.analysis.on_target import ELSEWHERE, UNSTABLE, not_as_asked, surely_on_target
from zoh.analysis.tabled.count import count
from zoh.analysis.tabled.margins import Seen
from zoh.analysis.tabled.path import Path
from zoh.analysis.tabled.verify import (
    TableMeasured,
    TableVerified,
    in_clock,
    measure_table,
    table_verified,
)
from zoh.certificate import advised
from zoh.design.target import Opposite
from zoh.errors import Infeasible, NotMet, SpecError
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.systems import Sampled
from zoh.lti.weights import WEIGHTS
from zoh.request import CANCELLED_UNSTABLE_MODES, LAWS, NEGATIVE_GAINS, Progress
from zoh.solving import (
    SolvedLaw,
    by_gain_alone,
    own_margin,
    solved,
)
from zoh.spec import Crossover, Requirements


@dataclass(frozen=True, slots=True, kw_only=True)
class Clocked:
    """A sampled table as a law sees it: dt in s, and a gain at a frequency.

    fixed  what stands in series with the law, None where nothing does
    """

    table: FrequencyResponse
    dt: float
    fixed: Sampled | None = None

    def at(self, wc: float) -> complex:
        """Return the gain at wc in rad/s; SpecError outside the table."""
        gain = self.table.at(wc)
        return gain * self.fixed.at(wc) if self.fixed else gain

    def whole(self, law: Sampled) -> Sampled:
        """Return the controller: the law with what is fixed."""
        return law * self.fixed if self.fixed else law


def design_on_table(
    plant: FrequencyResponse, law: str, parameters: Mapping[str, float], *, dt: float,
    compute_delay: float, requirements: Requirements, fixed: Sampled | None = None,
    name: str | None = None, allow: frozenset[str] = frozenset(), progress: Progress | None = None,
) -> TableVerified:  # fmt: skip
    """Return the verified design of ``law`` on a table; its parameters are checked already.

    Raises SpecError where wc is outside the table, Infeasible where the law cannot, with what
    could in the table's band, NotMet where the table does not show what was asked.
    """
    plant_seen = Clocked(table=in_clock(plant, dt, compute_delay), dt=dt, fixed=fixed)

    def measured(found: SolvedLaw) -> TableMeasured:
        return measure_table(
            plant, plant_seen.whole(found.controller), compute_delay=compute_delay,
            requirements=requirements, law=law, gains=found.gains, name=name,
        )  # fmt: skip

    def checked(found: SolvedLaw, spec: Crossover | None) -> TableVerified:
        evidence = measured(found)
        off = not_as_asked(evidence.margins, spec, lambda wc: evidence.loop.at(wc))
        if off:
            raise NotMet((*evidence.misses, *off), evidence)
        return table_verified(evidence)

    if law == "p" and len(parameters) == 1:
        if fixed and "pm_deg" in parameters:
            raise SpecError("wc", "must be given beside sections on a table", None, "choose one")
        return _free_p(plant_seen, parameters, checked, allow)
    spec = Crossover(wc=parameters["wc"], pm_deg=parameters.get("pm_deg", 90.0))
    asked = spec if "pm_deg" in parameters else None  # the textbook's rule takes no margin
    try:
        return checked(solved(law, plant_seen, spec, parameters, None, allow), asked)
    except Infeasible as refused:
        if asked is None:
            raise
        raise _advised(refused, law, plant_seen, spec, parameters, allow, progress) from None


def _advised(
    refused: Infeasible, law: str, plant: Clocked, spec: Crossover,
    parameters: Mapping[str, float], allow: frozenset[str], progress: Progress | None,
) -> Infeasible:  # fmt: skip
    def fails(controller: Sampled, at: Crossover) -> str:
        path = Path.of(plant.whole(controller) * plant.table)
        if count(path).unstable != 0:
            return UNSTABLE
        return "" if surely_on_target(Seen.of(path), at) else ELSEWHERE

    return advised(refused, law, plant, spec, parameters, fails, allow, progress)


def _free_p(
    plant: Clocked,
    parameters: Mapping[str, float],
    checked: Callable[[SolvedLaw, Crossover | None], TableVerified],
    allow: frozenset[str],
) -> TableVerified:
    """Return the P of a crossover alone, or of a margin alone: there the fastest that holds.

    One of a negative gain, where that is allowed, if none of a positive one holds.
    """
    try:
        return _p_of_one(plant, parameters, checked, 1)
    except (Infeasible, NotMet):
        if NEGATIVE_GAINS in allow:
            with suppress(Infeasible, NotMet):
                return _p_of_one(plant, parameters, checked, -1)
        raise


def _p_of_one(
    plant: Clocked,
    parameters: Mapping[str, float],
    checked: Callable[[SolvedLaw, Crossover | None], TableVerified],
    sign: int,
) -> TableVerified:
    """Return the P of one sign."""

    def law(wc: float) -> SolvedLaw:
        found = by_gain_alone(plant, wc)
        return found if sign > 0 else found.opposite()

    if "wc" in parameters:
        wc = parameters["wc"]
        return checked(law(wc), own_margin(plant if sign > 0 else Opposite(plant), wc))
    pm_deg = Crossover(wc=1.0, pm_deg=parameters["pm_deg"]).pm_deg
    failure: NotMet | None = None
    turned = 0.0 if sign > 0 else 180.0  # the opposite of a plant is a half turn behind it
    for wc in reversed(_crossovers(plant.table, pm_deg - turned)):
        try:
            return checked(law(wc), Crossover(wc=wc, pm_deg=pm_deg))
        except NotMet as missed:
            failure = failure or missed
    if failure is not None:
        raise failure
    turns = (pm_deg - plant.table.phase_deg) % 360.0 - 180.0
    raise Infeasible(
        f"a P turns the phase by nothing, and the plant alone has a margin of {pm_deg:g} deg "
        "at no frequency of its table",
        needed_deg=float(turns[np.argmin(np.abs(turns))]),
    )


def _crossovers(table: FrequencyResponse, pm_deg: float) -> list[float]:
    """Return every wc in rad/s below Nyquist's at which the plant alone has this margin."""
    asked = radians(pm_deg - 180)

    def off(w: float) -> float:
        return float(np.sin(table.turn.at(np.log(w)) - asked))

    signs = np.sign(np.sin(table.turn.y - asked))
    found = sign_changes(off, table.w, signs)
    exact = [float(w) for w, s in zip(table.w, signs, strict=True) if s == 0]
    return sorted(w for w in {*found, *exact} if abs(remainder(_angle(table, w) - asked, tau)) < 1)


def _angle(table: FrequencyResponse, w: float) -> float:
    return float(table.turn.at(np.log(w)))


def check_for_a_table(
    law: str, parameters: Mapping[str, float], missing: Sequence[str], allow: frozenset[str]
) -> None:
    """Refuse what a table cannot show, or cannot be searched for."""
    if missing:
        takes = ", ".join(LAWS.get(law, ())) or "a plant's model"
        bound = f"must be given for {law} on a table"
        raise SpecError(missing[0], bound, None, f"{law} takes {takes}")
    weight = next((k for k in WEIGHTS if k in parameters), None)
    if weight:
        bound = "must be left out on a table, which shows no step response"
        raise SpecError(weight, bound, parameters[weight], "give the plant's model")
    if CANCELLED_UNSTABLE_MODES in allow:
        bound = f"must not have {CANCELLED_UNSTABLE_MODES} on a table"
        raise SpecError("allow", bound, sorted(allow), "a table shows no hidden modes")
