"""Motions with a delay of many samples: the inputs under way stand in a queue, not in the state.

What leaves the queue over the next ``wait`` samples is already in it, so a block of that many
samples is the plain response of a small system to a known input. Inside the block, chunks of a
few samples are one matrix product.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from zoh.analysis.loop import Array
from zoh.analysis.motion import QUIET, STILL, Motion, Track

_CHUNK = 32  # samples in one product; a queue is longer
_DELAYS = 4  # for so many delays the loop is still when it is called at rest
_MOST = 1_000_000  # samples followed


@dataclass(frozen=True, slots=True, kw_only=True)
class _Chunk:
    """Z(k + j) = Z(k) + free[j] Z(k) + forced[j] (v(k), v(k + 1), ...) for j = 0 ... _CHUNK.

    free    shape (_CHUNK + 1, N, N);  forced  shape (_CHUNK + 1, N, _CHUNK)
    """

    free: Array
    forced: Array

    @classmethod
    def of(cls, motion: Motion) -> "_Chunk":
        step, n = motion.delta.copy(), len(motion.delta)
        enters = step[:, motion.fed].copy()
        step[:, motion.fed] = step[motion.fed] = enters[motion.fed] = 0.0
        free, forced = np.zeros((_CHUNK + 1, n, n)), np.zeros((_CHUNK + 1, n, _CHUNK))
        for j in range(_CHUNK):
            free[j + 1] = free[j] + step + step @ free[j]
            forced[j + 1] = forced[j] + step @ forced[j]
            forced[j + 1][:, j] += enters
        return cls(free=free, forced=forced)

    def over(self, first: Array, inputs: Array) -> tuple[Array, Array]:
        """Return (Z at every sample of ``inputs``, shape (N, K), Z after them)."""
        n = len(first)
        by_chunk = inputs.reshape(-1, _CHUNK).T  # (_CHUNK, chunks)
        pushed = (self.forced.reshape(-1, _CHUNK) @ by_chunk).reshape(_CHUNK + 1, n, -1)
        starts, z = np.empty((n, by_chunk.shape[1])), first
        for i in range(by_chunk.shape[1]):
            starts[:, i] = z
            z = z + (self.free[-1] @ z + pushed[-1][:, i])
        moved = (self.free.reshape(-1, n) @ starts).reshape(_CHUNK + 1, n, -1)
        states = starts + (moved + pushed)[:-1]
        return states.transpose(1, 2, 0).reshape(n, -1), z


def run(motion: Motion, count: int) -> Array:
    """Return Z at the samples 0 ... count - 1, what has just left the queue in its place."""
    states = [block for block, _ in _blocks(motion, count)]
    return np.concatenate(states, axis=1)[:, :count]


def track(motion: Motion, at_rest: tuple[float, float | None]) -> Track:
    """Return the motion until output and effort have been at ``at_rest`` for several delays.

    None for an effort that comes to no rest.
    """
    patience, sizes = _DELAYS * (motion.wait + len(motion.delta)), [0.0, 0.0]
    blocks, quiet, still = [], 0, 0
    for states, u in _blocks(motion, _MOST):
        blocks.append(states)
        off = _off((motion.output @ states, u), at_rest, sizes)
        quiet = quiet + len(u) if off <= QUIET else 0
        still = still + len(u) if off <= STILL else 0
        if quiet >= patience:
            break
    every = np.concatenate(blocks, axis=1)
    return Track(
        k=np.arange(every.shape[1]),
        states=every,
        horizon=every.shape[1] - 1,
        rests=still >= patience,
    )


def _blocks(motion: Motion, count: int) -> Iterator[tuple[Array, Array]]:
    """Yield (Z, effort) of one block after the other, ``count`` samples or more."""
    if motion.effort is None:
        raise ValueError("a queue holds efforts")
    chunk, block = _Chunk.of(motion), motion.wait // _CHUNK * _CHUNK
    under_way, z = np.zeros(motion.wait), motion.start  # put in over the last wait samples
    for _ in range(0, count, block):
        v = under_way[:block]
        states, z = chunk.over(z, v)
        states[motion.fed] = v
        u = motion.effort @ states
        under_way = np.concatenate([under_way[block:], u])
        yield states, u


def _off(
    signals: tuple[Array, Array], at_rest: tuple[float, float | None], sizes: list[float]
) -> float:
    """Return how far a block is from rest, in parts of the largest so far, kept in ``sizes``."""
    off = 0.0
    for i, (signal, end) in enumerate(zip(signals, at_rest, strict=True)):
        if end is not None:
            sizes[i] = max(sizes[i], float(np.abs(signal).max()), abs(end))
            off = max(off, float(np.abs(signal - end).max()) / (sizes[i] or 1.0))
    return off
