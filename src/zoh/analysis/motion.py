"""A linear motion, known at the samples and at fractions of them.

The state Z at a sample ends with what drives it: a one, and before it a signal where the drive
is no constant. Everything is linear in Z::

    Z(k+1) = Z(k) + delta Z(k),    y(k, t) = (a row that depends on t) Z(k)

with delta instead of delta + I, so that a small dt costs no digits.
"""

from dataclasses import dataclass
from math import ceil, inf, log

import numpy as np
import numpy.typing as npt

from zoh.analysis.loop import Array
from zoh.sampling.between import Held

Indices = npt.NDArray[np.int64]

_QUIET = 1e-8  # the slowest mode has fallen to this at the horizon
_BLOCK = 256
_SLOWEST = 1e-14
_CELLS = 200_000  # numbers in the maps of a block
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
    start     shape (N,): Z at k = 0, at rest but for what drives it
    own       how many of the N states are the system's; the others are what drives it
    output    shape (N,): y at the samples; effort likewise for u, None where there is no u
    held      the plant between the samples, None where nothing is known there
    segments  the one or two stretches of a sample interval
    """

    dt: float
    delta: Array
    start: Array
    own: int
    output: Array
    effort: Array | None
    held: Held | None
    segments: tuple[Segment, ...]

    def rates(self) -> Array:
        """Return log |z| and |log z| per sample of each own mode z, shape (own, 2)."""
        moved = np.linalg.eigvals(self.delta[: self.own, : self.own])
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
        while len(maps) < min(_BLOCK, count, max(1, _CELLS // one.size)):
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
        # a mode too slow for its eigenvalue to have a sign is followed as far as floats count
        slowest = min(float(self.rates()[:, 0].max(initial=-inf)), -_SLOWEST)
        return max(8, ceil(log(_QUIET) / slowest) + 4 * len(self.delta))

    def track(self) -> tuple[Indices, Array]:
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
