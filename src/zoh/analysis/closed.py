"""The motions there are: a closed loop under each excitation, and a system by itself.

Z = (plant state, inputs still under way, controller state, feedforward state, signal, 1), the
signal only where it is no constant. The controller compares a reference r with the output y at the
samples, the feedforward adds its answer to r; a disturbance d is added to what the plant's input is
after its dead time.
Source: K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed., ch. 2 and 3.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Literal

import numpy as np

from zoh import checks
from zoh.analysis.loop import Array
from zoh.analysis.motion import Motion, Stretch
from zoh.analysis.realised import Chain
from zoh.errors import SpecError
from zoh.lti.frequency_response import FrequencyResponse
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.between import Held, Series
from zoh.sampling.hold import KEPT, MAX_DELAY, whole_samples

Excitation = Literal["step", "impulse", "ramp", "disturbance"]
EXCITATIONS: tuple[Excitation, ...] = ("step", "impulse", "ramp", "disturbance")

_NO_CHAIN = Chain((), (), 0.0)
CARRIED = 64  # samples of delay carried in the state; more stand in a queue


def closed_loop(
    plant: Plant, controller: Sampled, compute_delay: float = 0.0, by: Excitation = "step",
    feedforward: Sampled | None = None,
) -> Motion:  # fmt: skip
    """Return the motion of u = controller (r - y) + feedforward r and the plant, excited ``by``

    step         the reference is 1 from k = 0 on
    impulse      the reference is 1 at k = 0 alone
    ramp         the reference is k dt
    disturbance  1 is added to the plant's input from t = 0 on

    Raises SpecError where the loop has no solution (an algebraic loop of gain -1), or carries
    more samples of delay than can be followed.
    """
    if not isinstance(by, str) or by not in EXCITATIONS:
        raise SpecError("by", f"must be one of {', '.join(EXCITATIONS)}", by, "choose one of these")
    if not isinstance(controller, Sampled):
        raise SpecError("controller", "must be a zoh.Sampled", controller, "give num, den and dt")
    dt = controller.dt
    m, lead = followable(plant, dt, compute_delay, controller.delay)
    held, ahead = Held.of(plant, dt), _ahead(feedforward, by)
    at_once = not m and held.d != 0.0  # e moves by u: the chain cannot be written by its step
    feedback = (Chain.of if at_once else Chain.followed)(controller)
    at = _Places.of(len(held.c), m, (len(feedback.a), len(ahead.a)), by)
    size = at.size
    y, u = _signals(held, feedback, ahead, at)
    stretches, moved = _between(held, *_inputs(u, at), lead)
    delta, start = np.zeros((size, size)), np.zeros(size)
    delta[: at.n] = moved
    if at.kept:
        delta[at.n, at.n] = -1.0
        for i in range(at.n + 1, at.first):
            delta[i, i - 1], delta[i, i] = 1.0, -1.0
        delta[at.n] += u
    start[at.one] = 1.0
    if by == "ramp":
        delta[at.own, at.one] = dt
    elif by == "impulse":
        delta[at.own, at.own], start[at.own] = -1.0, 1.0
    if feedback.a:
        error = [-part for part in y]
        if at.r is not None:
            error[at.r] += 1.0
        feedback.write(delta, at.first, error)
        if feedback.steps:  # from nothing to e at once
            start[at.first] = error[at.one] + (error[at.own] if by == "impulse" else 0.0)
    if ahead.a:
        ahead.write(delta, at.ahead, _unit(size, at.own))
    return Motion(
        dt=dt, delta=delta, start=start, own=at.own, output=np.array(y), effort=np.array(u),
        stretches=stretches,
        wait=m - 1 if m > CARRIED else 0, fed=at.n, swings=feedback.swings,
    )  # fmt: skip


Row = list[float]  # on Z


def _ahead(feedforward: Sampled | None, by: Excitation) -> Chain:
    """Return the feedforward as a chain of sums, nothing where no reference acts."""
    return Chain.of(feedforward) if feedforward and by != "disturbance" else _NO_CHAIN


@dataclass(slots=True, kw_only=True)
class _Places:
    """Where things stand in Z: n plant states, ``kept`` inputs, the controller's states from
    ``first`` on, the feedforward's from ``ahead`` on.

    r  which one is the reference, None where it is 0;  d  whether a disturbance of 1 acts
    """

    n: int
    kept: int
    first: int
    ahead: int
    own: int
    one: int
    r: int | None
    d: bool

    @classmethod
    def of(cls, n: int, m: int, states: tuple[int, int], by: Excitation) -> "_Places":
        kept = m if m <= CARRIED else 2  # of a queue the two that act in a sample
        ahead = n + kept + states[0]
        own = ahead + states[1]
        one = own + 1 if by in ("impulse", "ramp") else own
        r = None if by == "disturbance" else own
        return cls(
            n=n, kept=kept, first=n + kept, ahead=ahead, own=own, one=one, r=r,
            d=by == "disturbance",
        )  # fmt: skip

    @property
    def size(self) -> int:
        return self.one + 1


def _signals(held: Held, feedback: Chain, ahead: Chain, at: _Places) -> tuple[Row, Row]:
    """Return output and effort at a sample as rows on Z."""
    direct = feedback.d
    y = [*held.c, *[0.0] * (at.size - at.n)]
    if at.kept:
        y[at.first - 1] = held.d
    if at.d:
        y[at.one] = held.d
    u = [-direct * part for part in y]
    for i, part in enumerate((*feedback.c, *ahead.c), at.first):
        u[i] += part
    if at.r is not None:
        u[at.r] += direct + ahead.d
    if held.d and not at.kept:  # the plant answers at once
        if 1 + direct * held.d == 0:
            raise SpecError(
                "controller", "must not close an algebraic loop of gain -1", direct, "add delay"
            )
        u = [part / (1 + direct * held.d) for part in u]
        y = [part + held.d * of_u for part, of_u in zip(y, u, strict=True)]
    return y, u


def _inputs(u: Row, at: _Places) -> tuple[Row, Row]:
    """Return the plant's input at the start of a sample and at its end, as rows on Z."""
    before = _unit(at.size, at.first - 1) if at.kept else u
    after = _unit(at.size, at.first - 2) if at.kept > 1 else u
    if at.d:
        before, after = [*before], [*after]
        before[at.one] += 1.0
        after[at.one] += 1.0
    return before, after


def _unit(size: int, place: int) -> Row:
    """Return the row that takes one entry out of Z."""
    row = [0.0] * size
    row[place] = 1.0
    return row


def followable(plant: Plant, dt: float, compute_delay: float, more: int = 0) -> tuple[int, Decimal]:
    """Return the loop's delay as (m, lead), m samples less a fraction, ``more`` samples included.

    Raises SpecError for more samples than a loop may wait.
    """
    check_plant(plant)
    delay = checks.not_negative("compute_delay", compute_delay, "give seconds, 0 or more")
    m, lead = whole_samples(plant.dead_time, delay, dt)
    if m + more > MAX_DELAY:
        raise SpecError(
            "dead_time + compute_delay",
            f"must be at most {MAX_DELAY} samples ({MAX_DELAY * dt:.6g} s) in a loop",
            m + more,
            "sample more slowly",
        )
    return m + more, lead


def check_plant(plant: object) -> None:
    """Raise SpecError for what has no response in time, a table of frequencies included."""
    if isinstance(plant, FrequencyResponse):
        raise SpecError(
            "plant",
            "must be a zoh.Plant, for a table has no response in time",
            plant,
            "a table has margins, peaks and bandwidth: zoh.margins; fit a plant to it for the rest",
        )
    if not isinstance(plant, Plant):
        raise SpecError("plant", "must be a zoh.Plant", plant, "give num and den, or a formula")


def autonomous(system: Sampled) -> Motion:
    """Return the step response of a sampled system, its delay left out, at the samples only."""
    chain = Chain.of(system)
    n = len(chain.a)
    delta, one = np.zeros((n + 1, n + 1)), _unit(n + 1, n)
    if n:
        chain.write(delta, 0, one)
    return Motion(
        dt=system.dt, delta=delta, start=np.array(one), own=n, output=np.array([*chain.c, chain.d]),
        effort=None, stretches=(), swings=chain.swings,
    )  # fmt: skip


def continuous(plant: Plant, dt: float) -> Motion:
    """Return the step response of a continuous system, cut into intervals of dt; no dead time."""
    held = Held.of(plant, dt)
    n = len(held.c)
    one = _unit(n + 1, n)
    stretches, moved = _between(held, one, one, Decimal(0))
    delta = np.zeros((n + 1, n + 1))
    delta[:n] = moved
    return Motion(
        dt=dt, delta=delta, start=np.array(one), own=n, output=np.array([*held.c, held.d]),
        effort=None, stretches=stretches,
    )  # fmt: skip


def _between(held: Held, before: Row, after: Row, lead: Decimal) -> tuple[list[Stretch], Array]:
    """Return (the stretches of a sample, what the plant's state moves by, shape (n, N)).

    The plant's input is ``before`` until 1 - lead, then ``after``.
    """
    n = len(held.c)
    at = np.zeros((n + 1, len(before)))  # state and input on Z
    for i in range(n):
        at[i, i] = 1.0
    at[n] = before
    if not lead:
        weights, series = held.over(1.0)
        return _stretches(series, at, 0.0), weights.dot(at)
    switch = KEPT.subtract(1, lead)
    weights, series = held.over(switch)
    moved, first = weights.dot(at), _stretches(series, at, 0.0)
    at[:n] += moved
    at[n] = after
    weights, series = held.over(lead)
    second = _stretches(series, at, float(switch))
    return (first + second if first and second else []), moved + weights.dot(at)


def _stretches(series: Sequence[Series], at: Array, begin: float) -> list[Stretch]:
    """Return the stretches after ``begin``, state and input there being the rows ``at``."""
    return [Stretch(begin=begin + t, span=span, rows=rows.dot(at)) for t, span, rows in series]
