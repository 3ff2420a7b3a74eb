"""Samples in which a crest may hide: of plants that can turn twice while their input is held.

With three poles or more neither the slopes at a piece's ends nor a cubic through them show every
crest. But nowhere is y above the higher end of a piece by more than an eighth of its largest
curvature, and the curvature is a sum over what the plant's state and input are from rest. So only
samples that come near the highest value may hide one; they are noted and looked at closely.
"""

from dataclasses import dataclass, field
from math import factorial

import numpy as np

from zoh.batch.arrays.between import Piece
from zoh.batch.arrays.held import Held
from zoh.batch.arrays.look import Suspects
from zoh.batch.arrays.motion import Motion
from zoh.batch.arrays.rows import Array, Index


@dataclass(slots=True, kw_only=True)
class Turns:
    """What bounds the bends of many loops, and the samples that are suspected.

    size     of Z
    places   of the plant's states and of the inputs within a sample, on Z; -1 is the effort
    weights  of how far each of them is from rest, shape (n + 1 or 2, B): y is above the ends of
             every piece by no more than the sum
    """

    size: int
    places: list[int]
    weights: Array
    rest: Array
    found: list[Suspects] = field(default_factory=list)

    @classmethod
    def of(cls, plant: Held, motion: Motion, parts: list[Piece], delay: int) -> "Turns":
        """Return what suspects no sample yet."""
        n = len(plant.before)
        inputs = [n + delay - 1 - i if delay > i else -1 for i in range(len(parts))]
        weights = np.zeros((n + len(parts), len(motion.final)))
        for i, part in enumerate(parts):
            span = (part.end - part.begin) * plant.samples
            of_state, of_input = _curvature(plant, span)
            own = np.zeros_like(weights)
            own[:n] = np.einsum("jb,jib->ib", of_state, np.abs(part.state[:, :n]))
            if i:  # what the input before has left of itself
                own[n] = np.sum(of_state * np.abs(part.state[:, inputs[0]]), axis=0)
            own[n + i] = of_input
            weights = np.maximum(weights, own)
        rest = np.concatenate(
            [motion.final[None], -plant.markov[: n - 1] * motion.at_rest]
            + [motion.at_rest[None]] * len(parts)
        )
        return cls(size=len(motion.output), places=[*range(n), *inputs], weights=weights, rest=rest)

    def note(
        self, who: Index, zs: Array, us: Array, ends: Array, corners: Array | None, k: Array,
        top: Array,
    ) -> None:  # fmt: skip
        """Note the samples of a block that may go above ``top``; k is its first sample.

        ends, corners  y at the samples and at the one after them; where the input changes
        """
        highest = ends.max(axis=0)
        if corners is not None:
            highest = np.maximum(highest, corners.max(axis=0))
        parts = [
            (us if at < 0 else zs[:, at], weight[who], rest[who])
            for at, weight, rest in zip(self.places, self.weights, self.rest, strict=True)
        ]
        reach = np.zeros_like(highest)
        for signal, weight, rest in parts:
            reach += weight * np.maximum(signal.max(axis=0) - rest, rest - signal.min(axis=0))
        (hot,) = np.nonzero(highest + reach > top)
        if not len(hot):
            return
        heights = np.maximum(ends[:-1, hot], ends[1:, hot])
        if corners is not None:
            heights = np.maximum(heights, corners[:, hot])
        bound = heights.copy()
        for signal, weight, rest in parts:
            bound += weight[hot] * np.abs(signal[:, hot] - rest[hot])
        row, lane = np.nonzero(bound > np.maximum(heights, top[hot]))
        self.found.append(
            Suspects(
                who=who[hot[lane]], k=k[hot[lane]] + row, z=zs[row, :, hot[lane]].T,
                bound=bound[row, lane],
            )
        )  # fmt: skip

    def above(self, top: Array) -> Suspects:
        """Return those that may go above what is known to be reached."""
        return Suspects.above(self.found, self.size, top)


def _curvature(plant: Held, span: Array) -> tuple[Array, Array]:
    """Return an eighth of the largest |y''| over a span, for each state (n, B) and the input (B).

    y'' is the sum over m of C A^m x and C A^(m-1) B u by t^(m-2)/(m-2)!. The poles' |s| dt is 1.2
    at most: what follows the rows is below 1e-12 of them.
    """
    of_state, of_input = np.zeros_like(plant.rows[0]), np.zeros_like(span)
    for m in range(2, len(plant.rows)):
        weight = span**m / (8 * factorial(m - 2))
        of_state += weight * np.abs(plant.rows[m])
        of_input += weight * np.abs(plant.markov[m - 1])
    return of_state, of_input
