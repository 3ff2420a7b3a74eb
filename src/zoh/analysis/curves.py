"""Responses as curves to draw, at the samples and as densely as asked between them."""

from dataclasses import dataclass
from math import ceil

import numpy as np

from zoh import checks
from zoh.analysis import queue
from zoh.analysis.closed import closed_loop
from zoh.analysis.loop import Array
from zoh.analysis.motion import Motion
from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled

MOST_DRAWN = 1_000_000  # samples of a curve
MOST_POINTS = 50_000_000  # of a curve between its samples


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


def trace(
    plant: Plant,
    controller: Sampled,
    *,
    compute_delay: float = 0.0,
    reference: float = 1.0,
    t_end: float,
    per_sample: int = 20,
    feedforward: Sampled | None = None,
) -> Trace:
    """Return the closed loop's step response up to t_end seconds as curves to draw.

    ``per_sample`` is the least number of points of the curve between two samples; ``feedforward``
    adds its answer to the reference to the controller's.
    """
    motion = closed_loop(plant, controller, compute_delay, feedforward=feedforward)
    return trace_of(motion, t_end, per_sample, reference)


def trace_of(motion: Motion, t_end: float, per_sample: int = 20, reference: float = 1.0) -> Trace:
    """Return a motion's output and effort as curves, times ``reference``."""
    t_end = checks.positive("t_end", t_end, "give the last time in seconds")
    reference = checks.number("reference", reference, "give the size of the step")
    per_sample = checks.whole("per_sample", per_sample, 1, "give the points between two samples")
    if not t_end / motion.dt < MOST_DRAWN:
        raise SpecError(
            "t_end",
            f"must be at most {MOST_DRAWN} samples ({MOST_DRAWN * motion.dt:.4g} s)",
            t_end,
            "draw a shorter time",
        )
    count = ceil(t_end / motion.dt * (1 - 1e-12)) + 1
    if count * per_sample > MOST_POINTS:
        bound = f"must give {MOST_POINTS} points or fewer, {MOST_POINTS // count} a sample here"
        raise SpecError("per_sample", bound, per_sample, "draw fewer points")
    states = queue.run(motion, count) if motion.wait else motion.from_start(count)
    times, rows = _between(motion, per_sample)
    dense = (np.arange(count)[:, None] + times[None, :]) * motion.dt
    effort = motion.output * 0 if motion.effort is None else motion.effort
    return Trace(
        t=_frozen(dense[:, 0].copy()),
        y=_frozen(reference * (motion.output @ states)),
        u=_frozen(reference * (effort @ states)),
        t_between=_frozen(dense.ravel()),
        y_between=_frozen(reference * (rows @ states).T.ravel()),
    )


def _between(motion: Motion, per_sample: int) -> tuple[Array, Array]:
    """Return (fractions of a sample, rows on Z that give y there), per_sample or more."""
    if not motion.stretches:
        return np.zeros(1), motion.output[None, :]
    split = max(1, ceil(per_sample / len(motion.stretches)))
    at = np.arange(split + 1) / split
    times = [part.begin + part.span * at for part in motion.stretches]
    rows = [at[:, None] ** np.arange(len(part.rows)) @ part.rows for part in motion.stretches]
    return np.concatenate(times), np.concatenate(rows)


def _frozen(a: Array) -> Array:
    a.flags.writeable = False
    return a


__all__ = ["Trace", "trace", "trace_of"]
