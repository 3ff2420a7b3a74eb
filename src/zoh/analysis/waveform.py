"""One output of a motion as a function of time, with its true extremes and crossings.

The motion is known at a list of samples; where few are kept because nothing fast is left, the
stretches that matter are filled in again. Inside a sample the output and its slope are known at
fixed fractions, and between two of those it is a short Taylor series of the held plant.
"""

from dataclasses import dataclass

import numpy as np

from zoh.analysis.loop import Array
from zoh.analysis.motion import Indices, Motion
from zoh.analysis.pieces import (
    WIDE,
    Piece,
    bounds,
    crest,
    enters,
    exits,
    series_piece,
    stiff_piece,
    taylor_rows,
)

_CRESTS = 200  # the first ones and the likeliest ones that are followed to their top


@dataclass(frozen=True, slots=True, kw_only=True)
class Waveform:
    """y along a motion.

    k, states  the samples at which the state is known, shape (K,) and (K, N)
    y          the output there, shape (K,)
    low, high  bounds of the output from each sample to the next, shape (K,)
    taylor     the output's series inside a sample, as rows on the plant's state and input
    """

    motion: Motion
    k: Indices
    states: Array
    y: Array
    low: Array
    high: Array
    taylor: tuple[Array, Array]

    @classmethod
    def of(
        cls, motion: Motion, row: Array, track: tuple[Indices, Array], final: float
    ) -> "Waveform":
        """Return ``row`` times the state along a track, filled in where its metrics need it."""
        k, states = track
        while wanted := _stretches(k, states @ row, final):
            k, states = _filled(motion, k, states, wanted)
        y = states @ row
        low, high = bounds(motion, k, states, y)
        taylor = taylor_rows(motion.held)
        return cls(motion=motion, k=k, states=states, y=y, low=low, high=high, taylor=taylor)

    def furthest(self, sign: float, *, between: bool) -> tuple[float, float]:
        """Return (time in s, sign * y) where sign * y is largest."""
        i = int(np.argmax(sign * self.y))
        best = float(self.k[i]), float(sign * self.y[i])
        if between:
            bound = self.high if sign > 0 else -self.low
            rows = np.flatnonzero(bound > best[1])
            by_bound = rows[np.argsort(-bound[rows])][:_CRESTS]
            for i in np.unique(np.concatenate([rows[:_CRESTS], by_bound])):
                if bound[i] <= best[1]:
                    continue
                for piece in self._pieces(int(i)):
                    for t in (0.0, piece.span, crest(piece, sign)):
                        if t is not None and sign * piece.value(t) > best[1]:
                            best = piece.t + t, sign * piece.value(t)
        return best[0] * self.motion.dt, best[1]

    def first_reaches(self, sign: float, level: float, *, between: bool) -> float | None:
        """Return the first time in s at which sign * y is ``level`` or more; None if never."""
        reached = np.flatnonzero(sign * self.y >= level)
        at_sample = int(reached[0]) if reached.size else len(self.k)
        if between:
            bound = self.high if sign > 0 else -self.low
            for i in np.flatnonzero(bound[:at_sample] >= level):
                for piece in self._pieces(int(i)):
                    found = enters(piece, sign, level)
                    if found is not None:
                        return (piece.t + found) * self.motion.dt
        return float(self.k[at_sample]) * self.motion.dt if reached.size else None

    def last_outside(self, final: float, band: float, *, between: bool) -> float | None:
        """Return the time in s from which on |y - final| <= band; None if not by the horizon."""
        outside = np.flatnonzero(np.abs(self.y - final) > band)
        first_in = int(outside[-1]) + 1 if outside.size else 0
        if first_in >= len(self.k):
            return None
        if between:
            off = np.maximum(self.high - final, final - self.low)
            for i in np.flatnonzero(off > band)[::-1]:
                last = self._leaves(final, band, int(i))
                if last is not None:
                    return last * self.motion.dt
        return float(self.k[first_in]) * self.motion.dt

    def _leaves(self, final: float, band: float, row: int) -> float | None:
        """Return the last instant of the row's sample outside the band, in samples."""
        for piece in reversed(self._pieces(row)):
            ends = [exits(piece, sign, sign * final + band) for sign in (1.0, -1.0)]
            found = [t for t in ends if t is not None]
            if found:
                return piece.t + max(found)
        return None

    def _pieces(self, i: int) -> list[Piece]:
        """Return the pieces of row i's sample in order of time; none where it is not known."""
        held = self.motion.held
        if held is None or (i + 1 < len(self.k) and self.k[i + 1] != self.k[i] + 1):
            return []
        pieces = []
        for segment in self.motion.segments:
            u = float(segment.input @ self.states[i])
            x = segment.states[:-1] @ self.states[i]
            series = x @ self.taylor[0] + u * self.taylor[1]
            begins = float(self.k[i]) + segment.start + segment.times
            for j, h in enumerate(np.diff(segment.times).tolist()):
                if held.fastest * h > WIDE:
                    pieces.append(stiff_piece(held, x[j], u, float(begins[j]), h))
                else:
                    pieces.append(series_piece(series[j].tolist(), float(begins[j]), h))
        return pieces


def _stretches(k: Indices, y: Array, final: float) -> list[int]:
    """Return the rows before which samples were left out that a metric may need."""
    coarse = np.flatnonzero(np.diff(k) > 1)
    if not coarse.size:
        return []
    off = np.abs(y - final)
    size = abs(final)
    marks = {int(np.argmax(y)), int(np.argmin(y))}
    for level in (0.1, 0.9):
        reached = np.flatnonzero(np.sign(final) * y >= level * size)
        marks.add(int(reached[0]) if reached.size else 0)
    outside = np.flatnonzero(off > 0.02 * size)
    after = int(outside[-1]) if outside.size else 0
    marks.add(after)
    near = np.flatnonzero((off > 0.019 * size) & (off <= 0.02 * size))
    marks |= {int(i) for i in near[near >= after][:200]}
    wanted = {j for i in marks for j in (i - 1, i) if j >= 0}
    return sorted(wanted & set(coarse.tolist()))


def _filled(motion: Motion, k: Indices, states: Array, rows: list[int]) -> tuple[Indices, Array]:
    """Return (k, states) with up to 64 samples more after each of these rows.

    What is left in a wide stretch is slow, so a few points show where in it to look next.
    """
    ks, zs, at = [], [], 0
    for i in rows:
        ks.append(k[at : i + 1])
        zs.append(states[at : i + 1])
        gap = int(k[i + 1] - k[i])
        stride = max(1, gap // 64)
        count = -(-gap // stride)  # rounded up, so that the row itself and these fill the gap
        ks.append(k[i] + stride * np.arange(1, count))
        zs.append(motion.run(states[i], count, stride)[1:])
        at = i + 1
    ks.append(k[at:])
    zs.append(states[at:])
    return np.concatenate(ks), np.concatenate(zs)
