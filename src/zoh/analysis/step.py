"""The response to a reference step, its metrics at the samples and exactly between them.

Between samples the output is a sum of exponentials that is known in closed form, so its
extremes are roots of its derivative and its crossing times roots of itself: a time is the true
instant, a peak the true extreme.
"""

from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from zoh.analysis import queue
from zoh.analysis.closed import autonomous, closed_loop, continuous
from zoh.analysis.filling import leaves_out
from zoh.analysis.loop import Loop
from zoh.analysis.motion import BAND, NEAR, Motion, Track
from zoh.analysis.rest import gains_at_rest, short_of_1
from zoh.analysis.results import StepInfo
from zoh.analysis.stability import hurwitz_floats
from zoh.analysis.waveform import Waveform
from zoh.errors import SpecError
from zoh.lti import poly
from zoh.lti.poly import Poly
from zoh.lti.systems import Plant, Sampled

RISE = (0.1, 0.9)
_NOTHING = 1e-10  # an overshoot below this part of the final value is rounding
_ROUNDING = 1e-12  # of an effort: what it comes to rest at, nearer than this, it has reached


def step_info(system: Plant | Sampled) -> StepInfo:
    """Return the metrics of the step response of ``system``, a closed loop; reference step 1.

    It is not closed here: of a loop gain num/den it is num/(den + num), in w, and ``zoh.measure``
    closes a plant and a controller itself. A Sampled is known at its samples; a Plant at all times.
    Of an unstable one nothing exists but ``stable``, which is False. Raises SpecError for what is
    no system, and for one whose poles or gains 64-bit floats do not hold.

    >>> info = step_info(Sampled(num=[0.5], den=[1, -0.5], dt=1.0))  # 1 - 0.5^k
    >>> info.rise_time, info.settling_time, info.overshoot_pct
    (3.0, 6.0, 0.0)
    >>> step_info(Sampled(num=[0.5], den=[1, -1], dt=1.0)).stable
    False
    """
    if not isinstance(system, Plant | Sampled):
        way_out = "a table shows no step; of coefficients make one first"
        raise SpecError("system", "must be a zoh.Plant or zoh.Sampled", system, way_out)
    loop = Loop.of(system)
    if not hurwitz_floats(loop.den):
        return StepInfo(stable=False)
    final = loop.num[-1] / loop.den[-1]
    error = short_of_1(system, final)
    if isinstance(system, Sampled):
        motion, late = autonomous(system), system.delay * system.dt
        return _Seen.of(motion, motion.track(final), final, error, 1.0, late).at_samples()
    try:
        with np.errstate(over="raise", invalid="raise"):
            motion = continuous(system, _interval(loop.den))
            if not np.isfinite(motion.output).all():
                raise OverflowError
            late = system.dead_time
            return _Seen.of(motion, motion.track(final), final, error, 1.0, late).between()
    except (ArithmeticError, np.linalg.LinAlgError):
        raise SpecError(
            "system",
            "must have rates and gains that 64-bit floats can hold",
            str(system),
            "count time or the output in another unit",
        ) from None


def _interval(den: Poly) -> float:
    """Return the time constant in s of the fastest pole; raise OverflowError if it is no float."""
    rates = np.abs(poly.roots(den))
    fastest = float(rates.max()) if rates.size else 1.0
    if not 0 < 1 / fastest < inf:
        raise OverflowError
    return 1 / fastest


def closed_loop_step(
    plant: Plant, controller: Sampled, *, compute_delay: float = 0.0, reference: float = 1.0,
    feedforward: Sampled | None = None,
) -> StepInfo:  # fmt: skip
    """Return the metrics of plant and controller in unity feedback, a stable loop.

    ``feedforward`` adds its answer to the reference to u. The top level is at the samples,
    ``between_samples`` at all times, ``peak_effort`` the largest |u|.
    """
    motion = closed_loop(plant, controller, compute_delay, feedforward=feedforward)
    final, at_rest, error = gains_at_rest(plant, controller, feedforward)
    track = queue.track(motion, (final, at_rest)) if motion.wait else motion.track(final)
    seen = _Seen.of(motion, track, final, error, reference)
    wave = seen.wave
    top, bottom = int(wave.u.argmax()), int(wave.u.argmin())
    most, least = float(wave.u[top]), float(wave.u[bottom])
    ends = sorted((reference * min(at_rest, least), reference * max(at_rest, most)))
    peak = max(-ends[0], ends[1])
    last = top if (most, bottom) > (-least, top) else bottom  # the first of both
    reached = abs(reference) * max(most, -least) >= peak * (1 - _ROUNDING)
    return seen.at_samples(
        between_samples=seen.between() if motion.stretches else None,
        peak_effort=peak,
        peak_effort_time=float(wave.k[last]) * motion.dt if reached else None,
        effort_range=(ends[0], ends[1]),
    )


@dataclass(slots=True, kw_only=True)
class _Seen:
    """A waveform that settles to ``final``.

    error      1 less that, with its own digits
    reference  the size of the step;  late  s, when the response begins
    horizon    s, to which it is known;  rests  whether it stays in its band from then on
    """

    wave: Waveform
    final: float
    error: float
    reference: float
    late: float
    horizon: float
    rests: bool

    @classmethod
    def of(
        cls, motion: Motion, track: Track, final: float, error: float, reference: float,
        late: float = 0.0,
    ) -> "_Seen":  # fmt: skip
        band = BAND * abs(final)
        wave = Waveform.of(motion, track, final, band)
        rests = track.rests or motion.farthest(track.states[:, -1]) < NEAR * band
        return cls(
            wave=wave, final=final, error=error, reference=reference, late=late,
            horizon=track.horizon * motion.dt + late, rests=rests,
        )  # fmt: skip

    def at_samples(self, **more: Any) -> StepInfo:
        """Return the metrics at the samples, ``more`` beside them."""
        wave, size, sign = self.wave, abs(self.final), -1.0 if self.final < 0 else 1.0
        ends = wave.highest(sign), wave.highest(-sign)
        times = [wave.reaches(level * size, sign) for level in RISE]
        return self._info(ends, times, wave.settles(self.final, BAND * size), more)

    def between(self) -> StepInfo:
        """Return the metrics at all times."""
        wave, size, sign = self.wave, abs(self.final), -1.0 if self.final < 0 else 1.0
        ends = wave.highest_between(sign), wave.highest_between(-sign)
        times = [wave.reaches_between(level * size, sign) for level in RISE]
        if leaves_out(wave.k):
            wave = wave.closer(self.final, BAND * size)
        return self._info(ends, times, wave.settles_between(self.final, BAND * size), {})

    def _info(
        self,
        ends: tuple[tuple[float, float], tuple[float, float]],
        times: list[float | None],
        settled: float | None,
        more: dict[str, Any],
    ) -> StepInfo:
        (t, peak), (t_low, low) = ends
        size, final = abs(self.final), self.final * self.reference
        if size == 0:
            if low > peak:
                t, peak = t_low, low
            return StepInfo(
                peak=max(peak, 0.0) * abs(self.reference), peak_time=t + self.late,
                final_value=0.0, steady_state_error=self.reference, horizon=self.horizon, **more,
            )  # fmt: skip
        over, under = peak / size - 1, low / size
        first, last = times
        return StepInfo(
            overshoot_pct=100 * over if over > _NOTHING else 0.0,
            undershoot_pct=100 * under if under > _NOTHING else 0.0,
            rise_time=None if first is None or last is None else last - first,
            settling_time=None if settled is None or not self.rests else settled + self.late,
            peak=max(peak, size) * abs(self.reference),
            peak_time=t + self.late if over > _NOTHING else None,
            final_value=final,
            steady_state_error=self.error * self.reference + 0.0,  # no -0
            horizon=self.horizon,
            **more,
        )


__all__ = ["closed_loop_step", "step_info"]
