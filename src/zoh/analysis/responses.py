"""What a loop does under a ramp, an impulse, a disturbance and noise, as figures.

Every figure is that of all times, not only of the samples: extremes are true ones to rounding; a
response that has not come to rest by the horizon has no settling time.
Source: K. J. Astrom and R. M. Murray, Feedback Systems, 2nd ed., ch. 12 (the gang of four);
K. J. Astrom, Introduction to Stochastic Control Theory, ch. 4 (variance by the sum of squares
of the impulse response).
"""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from zoh.analysis import queue
from zoh.analysis.closed import Excitation, check_plant, closed_loop
from zoh.analysis.curves import Trace, trace_of
from zoh.analysis.loop import Loop
from zoh.analysis.motion import BAND, NEAR, Motion
from zoh.analysis.rest import gains_at_rest, under_a_load
from zoh.analysis.stability import surely_stable
from zoh.analysis.waveform import Waveform
from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

_NOTHING = 1e-10  # what stands out by less does not


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """One output under one excitation of size 1, between the samples too.

    peak, peak_time  its largest size and when in s, None where it is only approached; for a ramp
                     the output is the error, time minus y
    final_value      what it comes to; inf where it grows without end. Under a ramp its limit at the
                     samples: a plant that does not integrate follows a u that climbs in steps, so
                     between the samples the error ripples for ever, a biproper plant's by jumps
    settling_time    s, from which on it stays within 2 % of the peak around the final value;
                     None where it may not by the horizon
    peak_effort      the largest |u|, in input units; inf where it grows without end
    horizon          s, to which the response was followed; None where it grows without end
    """

    excitation: Excitation
    peak: float
    peak_time: float | None
    final_value: float
    settling_time: float | None
    peak_effort: float
    horizon: float | None


def response(
    plant: Plant, controller: Sampled, *, by: Excitation, compute_delay: float = 0.0
) -> Response:
    """Return the figures of a stable loop excited ``by`` a step, impulse, ramp or disturbance.

    A disturbance acts behind the plant's dead time: it is added from t = 0, a sample, on to what
    has come through. One that comes before it is the same, later by the dead time.

    Raises SpecError for an unstable loop, an unknown excitation and a table, which has no response
    in time.

    >>> plant = Plant(num=[1], den=[1, 1])
    >>> d = response(plant, Sampled(num=[4.0], den=[1.0], dt=0.1), by="disturbance")
    >>> round(d.final_value, 12)  # P/(1 + C P) = 1/(1 + 4)
    0.2
    """
    _check_stable(plant, controller, compute_delay)
    motion = closed_loop(plant, controller, compute_delay, by)
    final, effort_at_rest = _at_rest(plant, controller, by)
    if final == inf:
        return Response(
            excitation=by, peak=inf, peak_time=None, final_value=inf, settling_time=None,
            peak_effort=inf, horizon=None,
        )  # fmt: skip
    if by == "ramp":
        motion = _error(motion)
    limit = effort_at_rest if abs(effort_at_rest) < inf else None
    ripples = limit is None  # for ever between the samples: followed until it is the same in each
    goal = 0.0 if ripples else final
    track = queue.track(motion, (final, limit)) if motion.wait else motion.track(goal)
    wave = Waveform.of(motion, track, final, inf)
    t, peak = max(wave.highest_between(1.0), wave.highest_between(-1.0), key=_second)
    reached = peak > abs(final) * (1 + _NOTHING) and not (ripples and t >= wave.k[-1] * motion.dt)
    band = BAND * max(peak, abs(final))  # of the true peak, which had to be found first
    settled = wave.closer(final, band).settles_between(final, band)
    rests = track.rests or motion.farthest(track.states[:, -1]) < NEAR * band
    return Response(
        excitation=by,
        peak=max(peak, abs(final)),
        peak_time=t if reached else None,
        final_value=final,
        settling_time=settled if rests else None,
        peak_effort=inf if limit is None else max(abs(limit), float(np.abs(wave.u).max())),
        horizon=track.horizon * motion.dt,
    )


def _second(spot: tuple[float, float]) -> float:
    return spot[1]


def response_trace(
    plant: Plant, controller: Sampled, *, by: Excitation, t_end: float,
    compute_delay: float = 0.0, per_sample: int = 20,
) -> Trace:  # fmt: skip
    """Return the response as curves, up to t_end seconds."""
    return trace_of(closed_loop(plant, controller, compute_delay, by), t_end, per_sample)


def noise_gains(
    plant: Plant, controller: Sampled, *, compute_delay: float = 0.0
) -> tuple[float, float]:
    """Return (output, effort): standard deviations at the samples per unit of white noise.

    The noise is added to the measurement, one independent value a sample. A variance is the sum
    of the squares of an impulse response.

    >>> plant = Plant(num=[1], den=[1, 0])
    >>> y, u = noise_gains(plant, Sampled(num=[0.5], den=[1.0], dt=1.0))
    >>> round(y * y, 12)  # y(k+1) = 0.5 y(k) - 0.5 n(k): 0.25/(1 - 0.25)
    0.333333333333
    """
    _check_stable(plant, controller, compute_delay)
    motion = closed_loop(plant, controller, compute_delay, "impulse")
    effort = motion.output * 0 if motion.effort is None else motion.effort
    if motion.wait:
        track = queue.track(motion, (0.0, 0.0))
        if not track.rests:
            raise SpecError(
                "controller",
                "must bring a loop with so long a delay to rest in a million samples",
                f"{float(track.k[-1]) * motion.dt:.4g} s",
                "sample more slowly",
            )
        rows = np.stack([motion.output, effort]) @ track.states
        output, effort_size = np.sqrt((rows * rows).sum(axis=1)).tolist()
        return output, effort_size
    start = motion.start.copy()
    start[-1] = 0.0  # the constant is no part of an impulse's answer
    squares = motion.powers.sum_of_squares(start)
    output, effort_size = np.sqrt(np.maximum(squares, 0.0)).tolist()
    return output, effort_size


def _error(motion: Motion) -> Motion:
    """Return the motion whose output is the error under a ramp, time minus y, at all times."""
    unit = np.eye(len(motion.start))
    r, one = unit[-2], unit[-1]
    stretches = []
    for part in motion.stretches:
        rows = np.concatenate([-part.rows, np.zeros((max(0, 2 - len(part.rows)), len(r)))])
        rows[0] += r + part.begin * motion.dt * one
        rows[1] += part.span * motion.dt * one
        stretches.append(replace(part, rows=rows))
    return replace(motion, output=r - motion.output, stretches=stretches)


def _check_stable(plant: Plant, controller: Sampled, compute_delay: float) -> None:
    check_plant(plant)
    if not isinstance(controller, Sampled):
        raise SpecError("controller", "must be a zoh.Sampled", controller, "give num, den and dt")
    loop = Loop.of(controller, sample(plant, controller.dt, compute_delay))
    if not surely_stable(loop):
        raise SpecError(
            "controller", "must make the closed loop stable", "an unstable loop", "change its gains"
        )


def _at_rest(plant: Plant, controller: Sampled, by: Excitation) -> tuple[float, float]:
    """Return what the output (the error for a ramp) and u come to, from the gains at w = 0."""
    if by == "impulse":
        return 0.0, 0.0
    if by == "disturbance":
        return under_a_load(plant, controller)
    if by == "step":
        return gains_at_rest(plant, controller)[:2]
    c_num, c_den, p_den = controller.num_w, controller.den_w, plant.den
    p_num = plant.sensor * plant.num[-1]
    # the ramp: S/w at w = 0, where S = den/(den + num)
    den_0 = c_den[-1] * p_den[-1]
    den_1 = _next(c_den) * p_den[-1] + c_den[-1] * _next(p_den)
    error = inf if den_0 else den_1 / (c_num[-1] * p_num)
    # u must keep y growing by 1 a second: a ramp of its own unless the plant integrates
    return error, inf if p_den[-1] else _next(p_den) / p_num


def _next(a: "tuple[float, ...] | list[float]") -> float:
    return a[-2] if len(a) > 1 else 0.0
