"""Plant and specification in, verified controller out: sample, solve, measure, verify."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from math import inf
from typing import overload

from zoh.analysis.asked import NOTHING_ASKED
from zoh.analysis.tabled.verify import TableVerified
from zoh.analysis.verify import Verified
from zoh.certificate import certified
from zoh.choice.before import contradicted
from zoh.choice.choose import choose, nothing_asked, signs
from zoh.choice.judge import Judge
from zoh.choice.notes import notes
from zoh.design.sections import SecondOrder, in_series
from zoh.errors import Infeasible, NotMet
from zoh.gain_alone import by_one
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.hidden import unstable_hidden
from zoh.lti.systems import Plant
from zoh.lti.weights import WEIGHTS
from zoh.request import (
    CANCELLED_UNSTABLE_MODES,
    UNDER_MS,
    Progress,
    allowed,
    bounded_ms,
    check_choosable,
    checked,
    left_open,
)
from zoh.sampling.hold import sample
from zoh.sampling.pathological import hidden_by_hold
from zoh.solving import opposite, solved
from zoh.spec import Crossover, Requirements
from zoh.table_design import check_for_a_table, design_on_table
from zoh.workbench import HIDES, Bench, without_cancelled

_WITH_IT = "the ki is then chosen with the rest, under ms among the requirements"
_OPEN_IT = "leave wc out, and the fastest that meets everything is looked for"
_BELOW_THE_EDGE, _LAST = (1.0, 0.9999, 0.999), 0.99  # of the fastest crossover

Known = Plant | FrequencyResponse  # a plant as a model, or as the table of its response
Design = Verified | TableVerified  # verified on the one, or on the other


@overload
def design(
    plant: Plant, law: str, given: Mapping[str, float | None], *, dt: float,
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
    requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0, name: str | None = None, progress: Progress | None = None,
) -> Verified: ...  # fmt: skip
@overload
def design(
    plant: FrequencyResponse, law: str, given: Mapping[str, float | None], *, dt: float,
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
    requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0, name: str | None = None, progress: Progress | None = None,
) -> TableVerified: ...  # fmt: skip
def design(
    plant: Known, law: str, given: Mapping[str, float | None], *, dt: float,
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
    requirements: Requirements = NOTHING_ASKED,
    reference: float = 1.0, name: str | None = None, progress: Progress | None = None,
) -> Design:  # fmt: skip
    """Return the verified design of ``law``; ``given`` are its parameters, named in ``LAWS``.

    sections  fixed, in series with the law, which is solved on their product with the plant
    allow     what is refused otherwise, words of ``zoh.request.ALLOWABLE``
    progress  called with a sentence now and then while something that was left open is searched,
              or what could be had instead of what is refused

    Raises SpecError for an unknown law or parameter, one that is missing or out of range;
    Infeasible where the law cannot, with what could; NotMet where the loop is unstable, has a
    smaller margin at another crossover, or misses a requirement. On a table it is a
    ``TableVerified``, which has no step response and so no use for the reference.
    """
    words = allowed(allow)
    parameters = checked(law, given, words)
    fixed = in_series(sections, dt)
    missing = left_open(law, parameters)
    if isinstance(plant, FrequencyResponse):
        check_for_a_table(law, parameters, missing, words)
        return design_on_table(
            plant, law, parameters, dt=dt, compute_delay=compute_delay, fixed=fixed,
            requirements=requirements, name=name, allow=words, progress=progress,
        )  # fmt: skip
    plant, cancelled = without_cancelled(plant, words)
    sampled = sample(plant, dt, compute_delay)
    weights = {k: parameters.pop(k) for k in WEIGHTS if k in parameters}
    bench = Bench(
        plant=plant, sampled=fixed * sampled if fixed else sampled, fixed=fixed,
        compute_delay=compute_delay, requirements=_bounded(requirements, parameters),
        reference=reference, law=law, name=name, weights=weights,
        allowed=(*cancelled, *sorted(words - {CANCELLED_UNSTABLE_MODES})),
    )  # fmt: skip
    if missing and not _is_alone(law, parameters):
        check_choosable(law, missing[0])
    try:
        if _is_alone(law, parameters):
            return by_one(bench, parameters, words)
        if missing:
            return _chosen(bench, parameters, words, sections, progress)
        return _solved(bench, parameters, words, progress)
    except Infeasible as refused:
        hidden = [x for x in hidden_by_hold(plant, dt) if x not in refused.reason]
        raise refused.because("; ".join(hidden)) from None


def _is_alone(law: str, parameters: Mapping[str, float]) -> bool:
    """Return whether one number closes all that is open: of a P, the one that is given."""
    return law == "p" and len(parameters) == 1


def _solved(
    bench: Bench, parameters: Mapping[str, float], allow: frozenset[str],
    progress: Progress | None,
) -> Verified:  # fmt: skip
    """Return the design of a request that leaves nothing open."""
    rule = "pm_deg" not in parameters  # the textbook's rule takes no margin
    spec = Crossover(wc=parameters["wc"], pm_deg=parameters.get("pm_deg", 90.0))
    try:
        found = solved(bench.law, bench.sampled, spec, parameters, bench.iae, allow)
        return bench.verified(found, None if rule else spec)
    except NotMet as short:
        raise short.advising("" if rule else _OPEN_IT) from None
    except Infeasible as refused:
        if rule:
            raise
        if unstable_hidden(bench.plant):  # nothing can be had instead, no other margin either
            raise Infeasible(
                f"{refused.reason}; {HIDES}", needed_deg=refused.needed_deg,
                needed_gain=refused.needed_gain, gives_deg=refused.gives_deg,
            ) from None  # fmt: skip
        told = certified(refused, bench.law, bench.sampled, spec, parameters, allow, progress)
        raise told.because(contradicted(bench.requirements, parameters)) from None


def _chosen(
    bench: Bench, parameters: Mapping[str, float], words: frozenset[str],
    sections: Sequence[SecondOrder], progress: Progress | None,
) -> Verified:  # fmt: skip
    """Return the design whose open parameters were chosen, measured anew.

    Where negative gains are allowed both signs are tried, first the one that the plant needs.
    """
    dt = bench.sampled.dt
    Crossover(
        wc=parameters.get("wc", 1e-9 / dt), pm_deg=parameters.get("pm_deg", 45.0)
    ).below_nyquist(dt)
    first, *rest = signs(bench.sampled, parameters, words)
    try:
        return _chosen_of(bench, parameters, words, sections, progress, first)
    except Infeasible:
        for back in rest:
            with suppress(Infeasible):
                return _chosen_of(bench, parameters, words, sections, progress, back)
        raise


def _chosen_of(
    bench: Bench, parameters: Mapping[str, float], words: frozenset[str],
    sections: Sequence[SecondOrder], progress: Progress | None, back: bool,
) -> Verified:  # fmt: skip
    """Return what is chosen among laws of one sign, negative ones where it is ``back``."""
    dt = bench.sampled.dt
    judge = Judge(**bench.setting(), back=back)
    under = {k: v for k, v in parameters.items() if k in UNDER_MS}
    known = {k: v for k, v in parameters.items() if k not in under}
    chosen = choose(judge, bench.law, opposite(known) if back else known, progress)
    found_for = opposite(chosen.parameters) if back else chosen.parameters
    asked_for = chosen.requirements if nothing_asked(bench.requirements) else bench.requirements

    def made(wc: float) -> Verified:
        asked = {**found_for, **bench.weights, **under, "wc": wc}
        if under:
            del asked["ki"]
        found = design(
            bench.plant, chosen.law, asked, dt=dt, compute_delay=bench.compute_delay,
            requirements=asked_for, sections=sections, reference=bench.reference,
            name=bench.name, allow=sorted(words),
        )  # fmt: skip
        return replace(found, allowed=bench.allowed)

    open_keys = tuple(k for k in chosen.choice.open if k != "ki" or not under)
    try:
        found = _at_the_edge(made, chosen.parameters["wc"], bool(under) and "wc" not in parameters)
    except NotMet as short:
        way_out = "".join(f"leave {name} out: {_WITH_IT}" for name in under)
        raise short.advising(way_out) from None
    choice = replace(chosen.choice, open=open_keys, notes=notes(found, parameters, bench.fixed))
    return replace(found, choice=choice)


def _at_the_edge(made: Callable[[float], Verified], wc: float, may_be_none: bool) -> Verified:
    """Return what is made at wc, or as close below as the ki that will do are more than none."""
    for share in _BELOW_THE_EDGE if may_be_none else ():
        with suppress(Infeasible):
            return made(share * wc)
    return made(_LAST * wc if may_be_none else wc)


def _bounded(asked: Requirements, parameters: Mapping[str, float]) -> Requirements:
    """Return the requirements with the bound on Ms that a search was made under."""
    bound = bounded_ms(parameters)
    if bound == inf or not isinstance(asked, Requirements):
        return asked
    return replace(asked, ms=bound if asked.ms is None else min(bound, asked.ms))
