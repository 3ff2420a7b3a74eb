"""The closed loop's motion after a reference step, at the samples and between them.

The state at a sample is Z = (plant state, inputs still under way, controller state, 1); the
last entry is the reference, 1 from k = 0 on. Everything is linear in Z::

    Z(k+1) = Z(k) + delta Z(k),    y(k, t) = (a row that depends on t) Z(k)

with delta instead of delta + I, so that a small dt costs no digits.
Source: K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed., sec. 2.3 and 3.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from math import ceil, log

import numpy as np
import numpy.typing as npt

from zoh.errors import SpecError
from zoh.lti import digits, poly
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.between import Held
from zoh.sampling.hold import whole_samples

Array = npt.NDArray[np.float64]

LONGEST_DELAY = 400  # samples carried in the state
_QUIET = 1e-8  # the slowest mode has fallen to this at the horizon
_BLOCK = 256
_MOST = 400_000  # samples followed; a loop that needs more has thousands of swings


@dataclass(frozen=True, slots=True, kw_only=True)
class Segment:
    """A stretch of every sample interval during which the plant's input is constant.

    start   fraction of the sample at which it begins
    times   fractions after start at which maps are known, shape (K,), from 0 to its end
    states  shape (K, n, N): the plant's state there, times Z
    input   shape (N,): the input during it, times Z
    """

    start: float
    times: Array
    states: Array
    input: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """A stable linear motion sampled every dt.

    delta     shape (N, N)
    output    shape (N,): y at the samples; effort likewise for u, None where there is no u
    held      the plant between the samples, None where nothing is known there
    segments  the one or two stretches of a sample interval
    """

    dt: float
    delta: Array
    output: Array
    effort: Array | None
    held: Held | None
    segments: tuple[Segment, ...]

    @property
    def start(self) -> Array:
        """Return Z at k = 0: at rest, reference 1."""
        z = np.zeros(len(self.delta))
        z[-1] = 1.0
        return z

    def rates(self) -> Array:
        """Return log |z| and |log z| per sample of each mode z, shape (N - 1, 2)."""
        moved = np.linalg.eigvals(self.delta[:-1, :-1])
        with np.errstate(divide="ignore"):
            logs = np.log1p(moved.astype(complex))
        decay = np.maximum(
            logs.real, -1e6
        )  # a mode at z = 0 is gone at once, not at minus infinity
        return np.stack([decay, np.where(np.isfinite(logs), np.abs(logs), 1e6)], axis=1)

    def jump(self, steps: int) -> Array:
        """Return S with Z(k + steps) = Z(k) + S Z(k), by doubling."""
        total, power = np.zeros_like(self.delta), self.delta
        while steps:
            if steps & 1:
                total = total + power + total @ power
            power = 2 * power + power @ power
            steps >>= 1
        return total

    def run(self, first: Array, count: int, stride: int = 1) -> Array:
        """Return Z at k = 0, stride, ... (count - 1) stride after ``first``, shape (count, N)."""
        one = self.jump(stride)
        maps, leap = np.zeros((1, *one.shape)), one
        while len(maps) < min(_BLOCK, count):
            maps = np.concatenate([maps, maps + leap + maps @ leap])
            leap = 2 * leap + leap @ leap
        block = len(maps)
        out, z = np.empty((count, len(one))), first
        for k in range(0, count, block):
            out[k : k + block] = (z + maps @ z)[: count - k]
            z = z + leap @ z
        return out

    def horizon(self) -> int:
        """Return the samples after which the slowest mode is gone."""
        slowest = float(self.rates()[:, 0].max(initial=-np.inf))
        if slowest >= 0:
            raise SpecError("T", "must be stable", "a mode that does not decay", "change the loop")
        return max(8, ceil(log(_QUIET) / slowest) + 4 * len(self.delta))

    def track(self) -> tuple[npt.NDArray[np.int64], Array]:
        """Return (k, Z(k)) from the step to the horizon.

        Every sample while fast modes live, then as few as show the slow ones.
        """
        rates, end = self.rates(), self.horizon()
        ks, zs, k, z, total = [], [], 0, self.start, 0
        while k <= end and total < _MOST:
            alive = rates[rates[:, 0] * k > -30.0, 1]  # exp(-30) of what it was is nothing
            stride = int(
                2.0 ** np.floor(np.log2(max(1.0, 0.05 / max(alive.max(initial=0.0), 1e-300))))
            )
            stride = min(stride, max(1, (end - k) // 64))
            count = min(max(1, (end - k) // stride + 1), 4 * _BLOCK)
            states = self.run(z, count + 1, stride)
            ks.append(k + stride * np.arange(count))
            zs.append(states[:-1])
            k, z, total = k + stride * count, states[-1], total + count
        return np.concatenate(ks), np.concatenate(zs)


def closed_loop(plant: Plant, controller: Sampled, compute_delay: float = 0.0) -> Motion:
    """Return the motion of plant and controller in unity feedback after a reference step of 1.

    Raises SpecError where the loop has no solution (an algebraic loop of gain -1), or carries
    more samples of delay than can be followed.
    """
    dt = controller.dt
    m, lead = whole_samples(plant.dead_time, compute_delay, dt)
    m += controller.delay
    if m > LONGEST_DELAY:
        raise SpecError(
            "dead_time + compute_delay",
            f"must be at most {LONGEST_DELAY} samples for a step response",
            m,
            "sample more slowly",
        )
    held = Held.of(plant, dt)
    ac, bc, cc, dc = realised(controller)
    n, nc = len(held.c), len(cc)
    size = n + m + nc + 1
    unit = np.eye(size)
    x, past, xc, r = unit[:n], unit[n : n + m], unit[n + m : n + m + nc], unit[-1]
    seen = held.c @ x
    direct = dc * held.d if not m else 0.0
    if 1 + direct == 0:
        raise SpecError(
            "controller", "must not close an algebraic loop of gain -1", dc, "add delay"
        )
    if m:
        seen = seen + held.d * past[-1]
    u = (cc @ xc + dc * (r - seen)) / (1 + direct)
    output = seen if m else seen + held.d * u
    before = past[-1] if m else u
    after = (past[-2] if m > 1 else u) if m else u
    segments = _segments(held, x, before, after, lead)
    delta = np.zeros((size, size))
    delta[:n] = segments[-1].states[-1] - x if n else 0.0
    for i in range(m):
        delta[n + i] = (past[i - 1] if i else u) - past[i]
    delta[n + m : n + m + nc] = ac @ xc + np.outer(bc, r - output)
    return Motion(dt=dt, delta=delta, output=output, effort=u, held=held, segments=segments)


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
    return Motion(dt=system.dt, delta=delta, output=output, effort=None, held=None, segments=())


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
    return Motion(dt=dt, delta=delta, output=output, effort=None, held=held, segments=segments)


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


def realised(system: Sampled) -> tuple[Array, Array, Array, float]:
    """Return (delta, b, c, d) with x(k+1) = x(k) + delta x(k) + b e(k), u = c x + d e.

    From the w-form: with w = (2/dt)(z-1)/(z+1), (A, B, C, D) in w gives, h = dt/2 and
    M = (I - h A)^-1, the matrices 2 h M A, 2 h M B, C M, D + h C M B. A pole at z = -1 has no
    w-form: there the z-form serves. The delay is not in it.
    """
    if system.den_w[0] == 0:
        a, b, c, d = _companion(
            _without_delay(system.num, system), _without_delay(system.den, system)
        )
        return a - np.eye(len(c)), b, c, d
    h = system.dt / 2
    n = len(system.den_w) - 1
    scale = _scale(system.den_w)
    num = [x * scale ** (k - n) for k, x in zip(range(n, -1, -1), system.num_w, strict=True)]
    den = [x * scale ** (k - n) for k, x in zip(range(n, -1, -1), system.den_w, strict=True)]
    a, b, c, d = _companion(num, den)
    a, b = a * scale, b * scale
    m = np.linalg.inv(np.eye(n) - h * a) if n else a
    return 2 * h * m @ a, 2 * h * m @ b, c @ m, d + h * float(c @ m @ b)


def _scale(den: Sequence[float]) -> float:
    """Return the typical size of the roots, by which the companion form is balanced."""
    sizes = np.abs(poly.roots(den))
    sizes = sizes[sizes > 0]
    return float(np.exp(np.log(sizes).mean())) if sizes.size else 1.0


def _companion(num: Sequence[float], den: Sequence[float]) -> tuple[Array, Array, Array, float]:
    n = len(den) - 1
    monic = np.array(den[1:]) / den[0]
    top = np.array(poly.padded(num, n + 1)) / den[0]
    a = np.eye(n, k=-1)
    if n:
        a[0] = -monic
    return a, np.eye(n, 1).ravel(), top[1:] - top[0] * monic, float(top[0])


def _without_delay(a: Sequence[float], system: Sampled) -> Sequence[float]:
    if a is system.den and system.delay:
        return a[: -system.delay]
    return a
