"""The response to a reference step, its metrics at the samples and exactly between them.

Between samples the output is a sum of exponentials that is known in closed form, so its
extremes are roots of its derivative and its crossing times roots of itself. A grid of half a
radian of the plant's fastest mode says where to look; a time is the true instant, a peak the true
extreme.
"""

from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np

from zoh import checks
from zoh.analysis.closed import autonomous, closed_loop, continuous
from zoh.analysis.loop import Array, Loop
from zoh.analysis.motion import Motion
from zoh.analysis.results import StepInfo
from zoh.analysis.stability import hurwitz_floats
from zoh.analysis.waveform import Waveform
from zoh.errors import SpecError
from zoh.lti import poly
from zoh.lti.systems import Plant, Sampled

RISE = (0.1, 0.9)
BAND = 0.02
MOST_DRAWN = 1_000_000  # samples of a curve
_NOTHING = 1e-10  # an overshoot below this part of the final value is rounding


@dataclass(frozen=True, slots=True, kw_only=True)
class Trace:
    """A closed loop's step response as curves.

    t, y, u             at the samples: time in s, output, input held from then on
    t_between, y_between  the output between the samples too
    """

    t: Array
    y: Array
    u: Array
    t_between: Array
    y_between: Array


def step_info(system: Plant | Sampled) -> StepInfo:
    """Return the metrics of the step response of ``system``, a closed loop; reference step 1.

    A Sampled is known at its samples; a Plant at all times. Raises SpecError unless it is
    stable.

    >>> info = step_info(Sampled(num=[0.5], den=[1, -0.5], dt=1.0))  # 1 - 0.5^k
    >>> info.rise_time, info.settling_time, info.overshoot_pct
    (3.0, 6.0, 0.0)
    """
    loop = Loop.of(system)
    if not hurwitz_floats(loop.den):
        raise SpecError("T", "must be stable", "a pole outside", "close a loop that is stable")
    final = loop.num[-1] / loop.den[-1]
    if isinstance(system, Sampled):
        motion = autonomous(system)
        return _metrics(
            Waveform.of(motion, motion.output, motion.track(), final), final, between=False
        )
    rates = np.abs(poly.roots(loop.den))
    dt = 1.0 / float(rates.max()) if rates.size else 1.0
    motion = continuous(system, dt)
    late = system.dead_time
    info = _metrics(Waveform.of(motion, motion.output, motion.track(), final), final, between=True)
    return replace(
        info,
        peak_time=None if info.peak_time is None else info.peak_time + late,
        settling_time=None if info.settling_time is None else info.settling_time + late,
    )


def closed_loop_step(
    plant: Plant, controller: Sampled, *, compute_delay: float = 0.0, reference: float = 1.0
) -> StepInfo:
    """Return the metrics of plant and controller in unity feedback, a stable loop.

    The top level is at the samples, ``between_samples`` at all times, ``peak_effort`` the
    largest |u|.
    """
    motion = closed_loop(plant, controller, compute_delay)
    final = _gain_at_rest(plant, controller, effort=False)
    track = motion.track()
    wave = Waveform.of(motion, motion.output, track, final)
    at_samples = _metrics(wave, final, between=False)
    between = _metrics(wave, final, between=True)
    at_rest = _gain_at_rest(plant, controller, effort=True)  # approached, if not passed
    low, high = min(0.0, at_rest), max(0.0, at_rest)
    if motion.effort is not None:
        asked = Waveform.of(replace(motion, held=None), motion.effort, track, at_rest)
        low, high = min(at_rest, float(asked.y.min())), max(at_rest, float(asked.y.max()))
    ends = sorted((reference * low, reference * high))
    return replace(
        _scaled(at_samples, reference),
        between_samples=_scaled(between, reference),
        peak_effort=max(abs(end) for end in ends),
        effort_range=(ends[0], ends[1]),
    )


def trace(
    plant: Plant,
    controller: Sampled,
    *,
    compute_delay: float = 0.0,
    reference: float = 1.0,
    t_end: float,
    per_sample: int = 20,
) -> Trace:
    """Return the closed loop's step response up to t_end seconds as curves to draw.

    ``per_sample`` is the least number of points of the curve between two samples.
    """
    motion = closed_loop(plant, controller, compute_delay)
    return trace_of(motion, t_end, per_sample, reference)


def trace_of(motion: Motion, t_end: float, per_sample: int = 20, reference: float = 1.0) -> Trace:
    """Return a motion's output and effort as curves, times ``reference``."""
    checks.positive("t_end", t_end, "give the last time in seconds")
    checks.whole("per_sample", per_sample, 1, "give the points between two samples")
    count = ceil(t_end / motion.dt * (1 - 1e-12)) + 1
    if count > MOST_DRAWN:
        raise SpecError(
            "t_end",
            f"must be at most {MOST_DRAWN} samples ({MOST_DRAWN * motion.dt:.4g} s)",
            t_end,
            "draw a shorter time",
        )
    states = motion.run(motion.start, count)
    times, rows = _between(motion, per_sample)
    dense = (np.arange(count)[:, None] + times[None, :]) * motion.dt
    effort = motion.output * 0 if motion.effort is None else motion.effort
    return Trace(
        t=_frozen(motion.dt * np.arange(count)),
        y=_frozen(reference * (states @ motion.output)),
        u=_frozen(reference * (states @ effort)),
        t_between=_frozen(dense.ravel()),
        y_between=_frozen(reference * (states @ rows.T).ravel()),
    )


def _between(motion: Motion, per_sample: int) -> tuple[Array, Array]:
    """Return (fractions of a sample, rows on Z that give y there), per_sample or more."""
    held = motion.held
    if held is None:
        return np.zeros(1), motion.output[None, :]
    times, rows = [], []
    for segment in motion.segments:
        split = max(1, ceil(per_sample / (len(segment.times) - 1)))
        for j, h in enumerate(np.diff(segment.times)):
            for part in range(split):
                delta, gamma = held.move(float(h) * part / split)
                x = segment.states[j] + delta @ segment.states[j] + np.outer(gamma, segment.input)
                times.append(segment.start + float(segment.times[j]) + float(h) * part / split)
                rows.append(held.c @ x + held.d * segment.input)
        times.append(segment.start + float(segment.times[-1]))
        rows.append(held.c @ segment.states[-1] + held.d * segment.input)
    return np.array(times), np.array(rows)


def _gain_at_rest(plant: Plant, controller: Sampled, *, effort: bool) -> float:
    """Return what y, or u, settles to: C P/(1 + C P) or C/(1 + C P) at w = 0.

    At rest a held plant has the plant's own gain.
    """
    top = controller.num_w[-1] * plant.sensor * plant.num[-1]
    bottom = controller.den_w[-1] * plant.den[-1]
    return (controller.num_w[-1] * plant.den[-1] if effort else top) / (top + bottom)


def _metrics(wave: Waveform, final: float, *, between: bool) -> StepInfo:
    """Return the metrics of a waveform that settles to ``final``."""
    size = abs(final)
    sign = -1.0 if final < 0 else 1.0
    if size == 0:
        t, peak = wave.furthest(1.0, between=between)
        low_t, low = wave.furthest(-1.0, between=between)
        if -low > peak:
            t, peak = low_t, -low
        return StepInfo(
            overshoot_pct=None, undershoot_pct=None, rise_time=None, settling_time=None,
            peak=max(peak, 0.0), peak_time=t, final_value=0.0, steady_state_error=1.0,
        )  # fmt: skip
    t, peak = wave.furthest(sign, between=between)
    _, lowest = wave.furthest(-sign, between=between)
    over, under = peak / size - 1, lowest / size
    begins = wave.first_reaches(sign, RISE[0] * size, between=between)
    ends = wave.first_reaches(sign, RISE[1] * size, between=between)
    return StepInfo(
        overshoot_pct=100 * over if over > _NOTHING else 0.0,
        undershoot_pct=100 * under if under > _NOTHING else 0.0,
        rise_time=None if begins is None or ends is None else ends - begins,
        settling_time=wave.last_outside(final, BAND * size, between=between),
        peak=max(peak, size),
        peak_time=t if over > _NOTHING else None,
        final_value=final,
        steady_state_error=1 - final,
    )


def _scaled(info: StepInfo, reference: float) -> StepInfo:
    return replace(
        info,
        peak=info.peak * abs(reference),
        final_value=info.final_value * reference,
        steady_state_error=info.steady_state_error * reference,
    )


def _frozen(values: Any) -> Array:
    a = np.asarray(values, float)
    a.flags.writeable = False
    return a


__all__ = ["Trace", "closed_loop_step", "step_info", "trace"]
