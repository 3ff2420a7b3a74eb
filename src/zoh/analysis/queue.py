"""Motions with a delay of many samples: the inputs under way stand in a queue, not in the state.

What leaves the queue over the next ``wait`` samples is already in it, so a block of that many
samples is the plain response of a small system to a known input. Inside the block, chunks of a
few samples are one matrix product.
"""

from dataclasses import dataclass

import numpy as np

from zoh.analysis.loop import Array
from zoh.analysis.motion import QUIET, Motion, Track

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
    return _blocks(motion, count, None)


def track(motion: Motion, at_rest: tuple[float, float | None]) -> Track:
    """Return the motion until output and effort have been at ``at_rest`` for several delays."""
    states = _blocks(motion, _MOST, at_rest)
    count = states.shape[1]
    return Track(k=np.arange(count), states=states, rests=count < _MOST)


def _blocks(motion: Motion, count: int, at_rest: tuple[float, float | None] | None) -> Array:
    if motion.effort is None:
        raise ValueError("a queue holds efforts")
    chunk, block = _Chunk.of(motion), motion.wait // _CHUNK * _CHUNK
    blocks, effort = [], np.zeros(motion.wait)  # what was put in over the last wait samples
    z, done, still, sizes = motion.start, 0, 0, [0.0, 0.0]
    while done < count:
        v = effort[:block]
        states, z = chunk.over(z, v)
        states[motion.fed] = v
        blocks.append(states)
        u = motion.effort @ states
        effort = np.concatenate([effort[block:], u])
        done += block
        if at_rest is not None:
            rests = _rests((motion.output @ states, u), at_rest, sizes)
            still = still + block if rests else 0
            if still >= _DELAYS * (motion.wait + len(z)):
                break
    return np.concatenate(blocks, axis=1)[:, :count]


def _rests(
    signals: tuple[Array, Array], at_rest: tuple[float, float | None], sizes: list[float]
) -> bool:
    """Return whether a block of each signal is where it ends; ``sizes`` are the largest so far."""
    for i, (signal, end) in enumerate(zip(signals, at_rest, strict=True)):
        if end is not None:
            sizes[i] = max(sizes[i], float(np.abs(signal).max()), abs(end))
            if float(np.abs(signal - end).max()) > QUIET * sizes[i]:
                return False
    return True
