"""A P of a crossover alone, or of a margin alone: a gain has one freedom, and either closes it."""

from collections.abc import Mapping
from contextlib import suppress

from zoh.analysis.verify import Verified
from zoh.certificate import least_turn
from zoh.design.p import crossovers
from zoh.errors import Infeasible, NotMet
from zoh.lti.systems import Sampled
from zoh.request import NEGATIVE_GAINS
from zoh.solving import SolvedLaw, by_gain_alone, negated, own_margin
from zoh.spec import Crossover
from zoh.workbench import Bench


def by_one(bench: Bench, parameters: Mapping[str, float], allow: frozenset[str]) -> Verified:
    """Return the P of a crossover alone, or of a margin alone: there the fastest that holds.

    One of a negative gain, where that is allowed, if none of a positive one holds.
    """
    try:
        return _p_of_one(bench, bench.sampled, parameters)
    except (Infeasible, NotMet):
        if NEGATIVE_GAINS not in allow:
            raise
        with suppress(Infeasible, NotMet):
            return _p_of_one(bench, negated(bench.sampled), parameters)
        raise


def _p_of_one(bench: Bench, plant: Sampled, parameters: Mapping[str, float]) -> Verified:
    """Return the P of one sign: the bench's own, or where ``plant`` is its opposite the other."""

    def law(wc: float) -> SolvedLaw:
        found = by_gain_alone(plant, wc)
        return found if plant is bench.sampled else found.opposite()

    if "wc" in parameters:
        wc = parameters["wc"]
        return bench.verified(law(wc), own_margin(plant, wc))
    pm_deg = Crossover(wc=1.0, pm_deg=parameters["pm_deg"]).pm_deg
    failure: NotMet | None = None
    for wc in crossovers(plant, pm_deg):
        try:
            return bench.verified(law(wc), Crossover(wc=wc, pm_deg=pm_deg))
        except NotMet as missed:
            failure = failure or missed
    if failure is not None:
        raise failure
    raise Infeasible(
        f"a P turns the phase by nothing, and the plant alone has a margin of {pm_deg:g} deg "
        "at no frequency below Nyquist's",
        needed_deg=least_turn(plant, pm_deg),
    )
