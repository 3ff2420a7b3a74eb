"""The motions there are: a closed loop under each excitation, and a system by itself.

Z = (plant state, inputs still under way, controller state, signal, 1). The controller compares
a reference r with the output y at the samples; a disturbance d is added to what the plant's
input is after its dead time.
Source: K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed., ch. 2 and 3.
"""

from decimal import Decimal
from math import ceil
from typing import Literal

import numpy as np

from zoh.analysis.loop import Array
from zoh.analysis.motion import Motion, Segment
from zoh.analysis.realised import realised
from zoh.errors import SpecError
from zoh.lti import digits
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.between import Held
from zoh.sampling.hold import whole_samples

Excitation = Literal["step", "impulse", "ramp", "disturbance"]
EXCITATIONS: tuple[Excitation, ...] = ("step", "impulse", "ramp", "disturbance")

LONGEST_DELAY = 400  # samples carried in the state


def closed_loop(
    plant: Plant, controller: Sampled, compute_delay: float = 0.0, by: Excitation = "step"
) -> Motion:
    """Return the motion of plant and controller in unity feedback, excited ``by`` one of

    step         the reference is 1 from k = 0 on
    impulse      the reference is 1 at k = 0 alone
    ramp         the reference is k dt
    disturbance  1 is added to the plant's input from t = 0 on

    Raises SpecError where the loop has no solution (an algebraic loop of gain -1), or carries
    more samples of delay than can be followed.
    """
    if by not in EXCITATIONS:
        raise SpecError("by", f"must be one of {', '.join(EXCITATIONS)}", by, "choose one of these")
    m, lead = followable(plant, controller.dt, compute_delay, controller.delay)
    held = Held.of(plant, controller.dt)
    ac, bc, cc, dc = realised(controller)
    n, nc = len(held.c), len(cc)
    own = n + m + nc
    unit = np.eye(own + 2)
    x, past, xc, signal, one = unit[:n], unit[n : n + m], unit[n + m : own], unit[-2], unit[-1]
    r = {"step": one, "disturbance": 0 * one}.get(by, signal)
    d = one if by == "disturbance" else 0 * one
    still = held.c @ x + held.d * (d + past[-1] if m else d)  # y but for the input of now
    direct = held.d if not m else 0.0
    if 1 + dc * direct == 0:
        raise SpecError(
            "controller", "must not close an algebraic loop of gain -1", dc, "add delay"
        )
    u = (cc @ xc + dc * (r - still)) / (1 + dc * direct)
    output = still + direct * u
    before = past[-1] if m else u
    after = (past[-2] if m > 1 else u) if m else u
    segments = _segments(held, x, before + d, after + d, lead)
    delta = np.zeros_like(unit)
    delta[:n] = segments[-1].states[-1] - x
    for i in range(m):
        delta[n + i] = (past[i - 1] if i else u) - past[i]
    delta[n + m : own] = ac @ xc + np.outer(bc, r - output)
    delta[-2] = {"ramp": controller.dt * one, "impulse": -signal}.get(by, 0 * one)
    return Motion(
        dt=controller.dt, delta=delta, start=one + signal if by == "impulse" else one, own=own,
        output=output, effort=u, held=held, segments=segments,
    )  # fmt: skip


def followable(plant: Plant, dt: float, compute_delay: float, more: int = 0) -> tuple[int, Decimal]:
    """Return the loop's delay as (m, lead), m samples less a fraction, ``more`` samples included.

    Raises SpecError for more samples than a time response is followed through.
    """
    if not isinstance(plant, Plant):
        raise SpecError("plant", "must be a zoh.Plant", plant, "give num and den, or a formula")
    m, lead = whole_samples(plant.dead_time, compute_delay, dt)
    if m + more > LONGEST_DELAY:
        raise SpecError(
            "dead_time + compute_delay",
            f"must be at most {LONGEST_DELAY} samples ({LONGEST_DELAY * dt:.6g} s) in a loop",
            m + more,
            "sample more slowly",
        )
    return m + more, lead


def autonomous(system: Sampled) -> Motion:
    """Return the step response of a sampled system as a motion known at the samples only."""
    a, b, c, d = realised(system)
    m = system.delay
    size = len(c) + m + 1
    unit = np.eye(size)
    delta = np.zeros((size, size))
    held_back = unit[len(c) : len(c) + m]
    for i in range(m):
        delta[len(c) + i] = (held_back[i - 1] if i else unit[-1]) - held_back[i]
    fed = held_back[-1] if m else unit[-1]
    delta[: len(c)] = a @ unit[: len(c)] + np.outer(b, fed)
    output = c @ unit[: len(c)] + d * fed
    return Motion(
        dt=system.dt, delta=delta, start=unit[-1], own=size - 1, output=output,
        effort=None, held=None, segments=(),
    )  # fmt: skip


def continuous(plant: Plant, dt: float) -> Motion:
    """Return the step response of a continuous system, cut into intervals of dt; no dead time."""
    held = Held.of(plant, dt)
    n = len(held.c)
    unit = np.eye(n + 1)
    segments = _segments(held, unit[:n], unit[-1], unit[-1], Decimal(0))
    delta = np.zeros((n + 1, n + 1))
    if n:
        delta[:n] = segments[-1].states[-1] - unit[:n]
    output = held.c @ unit[:n] + held.d * unit[-1]
    return Motion(
        dt=dt, delta=delta, start=unit[-1], own=n, output=output,
        effort=None, held=held, segments=segments,
    )  # fmt: skip


def _segments(
    held: Held, x: Array, before: Array, after: Array, lead: Decimal
) -> tuple[Segment, ...]:
    """Return the stretches of one sample: input ``before`` until 1 - lead, then ``after``."""
    with digits.precision(digits.KEPT):
        switch = 1 - lead
    first = _segment(held, 0.0, switch, x, before)
    if not lead:
        return (first,)
    return first, _segment(held, float(switch), lead, first.states[-1], after)


def _segment(held: Held, start: float, length: Decimal, x: Array, u: Array) -> Segment:
    times, exact = _fractions(held, length)
    states = np.empty((len(times), *x.shape))
    states[0] = x
    if exact:
        moves = [held.move(Decimal(t)) for t in times[1:-1]] + [held.move(length)]
        for i, (delta, gamma) in enumerate(moves, 1):
            states[i] = x + delta @ x + np.outer(gamma, u)
    else:
        delta, gamma = held.move(Decimal(float(times[1])))
        for i in range(1, len(times) - 1):
            states[i] = states[i - 1] + delta @ states[i - 1] + np.outer(gamma, u)
        delta, gamma = held.move(length)
        states[-1] = x + delta @ x + np.outer(gamma, u)
    return Segment(start=start, times=times, states=states, input=u)


def _fractions(held: Held, length: Decimal) -> tuple[Array, bool]:
    """Return the times in a segment to look at, and whether each needs its own exponential.

    Half a radian of the fastest mode apart; where that mode is over in a fraction of the
    sample, ever wider apart from the start on, where it is excited.
    """
    end = float(length)
    fastest = held.fastest
    count = int(min(64, max(8, 2 ** ceil(np.log2(2 * fastest * end + 1e-300)))))
    even = np.linspace(0.0, end, count + 1)
    if fastest * end <= 32:
        return even, False
    early = np.geomspace(0.02 / fastest, end, 120, endpoint=False)
    return np.unique(np.concatenate([even, early])), True
