"""One output of a motion as a function of time, with its true extremes and crossings.

The motion is known at a list of samples; where few are kept because nothing fast is left, the
stretches that matter are filled in again: which ones, ``filling`` judges by the samples shown.
Inside a sample the output is one or more polynomials whose Bernstein coefficients bound it, so
that of the samples shown only those that can hold an extreme or a crossing are looked into, and
none that can, but for rounding, is left out.
"""

from dataclasses import dataclass

import numpy as np

from zoh.analysis.filling import filled, leaves_out, wanted
from zoh.analysis.loop import Array
from zoh.analysis.motion import Indices, Motion, Track
from zoh.analysis.pieces import Piece, bernstein, highest_bounds

_ROUNDING = 1e-14  # of the largest output: what exceeds by less does not exceed
_MANY = 64  # samples to look into one by one; of more the bounds are first made tighter
_AT_ONCE = 1 << 16  # samples
_CELLS = 4_000_000  # numbers bounded at once


@dataclass(slots=True, kw_only=True)
class Waveform:
    """y along a motion, and the effort u with it.

    track        the K samples at which the state is known;  k, states  of it
    y, u         the output and the effort there, shape (K,)
    low, high    bounds of the output over the sample interval that begins there, shape (K,)
    top, bottom  (time in s, y) where y is largest and least
    """

    motion: Motion
    track: Track
    k: Indices
    states: Array
    y: Array
    u: Array
    low: Array
    high: Array
    top: tuple[float, float]
    bottom: tuple[float, float]

    @classmethod
    def of(cls, motion: Motion, track: Track, final: float, band: float) -> "Waveform":
        """Return the output along a track, filled in where its metrics need it.

        Those are the extremes, the rise to ``final`` and the last entry into ``band`` around it.
        """
        both = motion.powers.seen
        seen, (low, high) = both.dot(track.states), bounds(motion, track.states)
        while leaves_out(track.k):
            # where the slope leaps at each sample the highest between may be far from that at one
            if not (rows := wanted(track.k, np.array([*seen, low, high]), final, band)):
                break
            track = filled(motion, track, rows)
            seen, (low, high) = both.dot(track.states), bounds(motion, track.states)
        k, y, u = track.k, seen[0], seen[1]  # an array is slow to unpack
        i, j = int(y.argmax()), int(y.argmin())
        return cls(
            motion=motion, track=track, k=k, states=track.states, y=y, u=u, low=low, high=high,
            top=(float(k[i]) * motion.dt, float(y[i])),
            bottom=(float(k[j]) * motion.dt, float(y[j])),
        )  # fmt: skip

    def closer(self, final: float, band: float) -> "Waveform":
        """Return the same, filled in where the output is last outside ``band`` around ``final``.

        Between the samples it may be outside for longer than at them.
        """
        wave = self
        if wanted(self.k, np.array([self.y, self.u]), final, band):
            wave = Waveform.of(self.motion, self.track, final, band)
        while (left := wave._last_outside(final, band)) and wave._leaves_out(left[0]):
            track = filled(wave.motion, wave.track, [left[0]])
            wave = Waveform.of(wave.motion, track, final, band)
        return wave

    def highest(self, sign: float) -> tuple[float, float]:
        """Return (time in s, sign * y) where that is largest at the samples."""
        t, y = self.top if sign > 0 else self.bottom
        return t, sign * y

    def highest_between(self, sign: float) -> tuple[float, float]:
        """Return (time in s, sign * y) where that is largest at all times."""
        t, value = self.highest(sign)
        rounding = _ROUNDING * max(self.top[1], -self.bottom[1])
        bound = self._bound(sign)
        rows = (bound > value + rounding).nonzero()[0]
        if len(rows) > _MANY:
            bound = self._tightened(bound, rows, sign)
            rows = (bound > value + rounding).nonzero()[0]
        if len(rows) > 1:
            rows = rows[(-bound[rows]).argsort(kind="stable")]
        for i in rows.tolist():
            if bound[i] <= value + rounding:
                break
            for begin, span, piece in self._pieces(i, sign):
                at, high = piece.highest()
                if high > value:
                    t, value = (float(self.k[i]) + begin + span * at) * self.motion.dt, high
        return t, value

    def reaches(self, level: float, sign: float) -> float | None:
        """Return the first sample's time in s at which sign * y >= level; None if never."""
        reached = self.y >= level if sign > 0 else self.y <= -level
        i = int(reached.argmax())
        return float(self.k[i]) * self.motion.dt if reached[i] else None

    def reaches_between(self, level: float, sign: float) -> float | None:
        """Return the first instant in s at which sign * y >= level; None if never."""
        can = self._bound(sign) >= level
        i = int(can.argmax())
        while can[i]:
            if sign * self.y[i] >= level:
                return float(self.k[i]) * self.motion.dt
            for begin, span, piece in self._pieces(i, sign):
                t = 0.0 if piece.a[0] >= level else next(piece.crossings(level), None)
                if t is not None:
                    return (float(self.k[i]) + begin + span * t) * self.motion.dt
            can[i] = False
            i = int(can.argmax())
        return None

    def settles(self, final: float, band: float) -> float | None:
        """Return the first sample's time in s from which on |y - final| <= band at the samples."""
        outside = (np.abs(self.y - final) > band).nonzero()[0]
        first_in = int(outside[-1]) + 1 if len(outside) else 0
        return float(self.k[first_in]) * self.motion.dt if first_in < len(self.k) else None

    def settles_between(self, final: float, band: float) -> float | None:
        """Return the instant in s from which on |y - final| <= band; None if not by the horizon."""
        last = self._last_outside(final, band)
        if last is None:
            return 0.0
        return last[1] if last[0] + 1 < len(self.k) else None

    def _last_outside(self, final: float, band: float) -> tuple[int, float] | None:
        """Return (row, instant in s) where |y - final| > band for the last time, None if never."""
        outside = ((self.high > final + band) | (self.low < final - band)).nonzero()[0]
        for i in outside[::-1].tolist():
            for begin, span, piece in reversed(self._pieces(i, 1.0)):
                left = _last_outside(piece, final, band)
                if left is not None:
                    return i, (float(self.k[i]) + begin + span * left) * self.motion.dt
        return None

    def _leaves_out(self, i: int) -> bool:
        """Return whether samples are left out after row i."""
        return bool(i + 1 < len(self.k) and self.k[i + 1] - self.k[i] > 1)

    def _bound(self, sign: float) -> Array:
        """Return the upper bound of sign * y from each sample to the next."""
        return self.high if sign > 0 else -self.low

    def _tightened(self, bound: Array, rows: Indices, sign: float) -> Array:
        """Return the bounds with those of some rows nearer to what they bound."""
        out = bound.copy()
        for some in np.array_split(rows, -(-len(rows) // _AT_ONCE)):
            states = sign * self.states[:, some]
            of_each = [highest_bounds(part.rows.dot(states)) for part in self.motion.stretches]
            out[some] = np.max(of_each, axis=0)
        return out

    def _pieces(self, i: int, sign: float) -> list[tuple[float, float, Piece]]:
        """Return (begin, span, polynomial) of the stretches of row i's sample, times ``sign``."""
        z, out = self.states[:, i] if sign > 0 else -self.states[:, i], []
        for part in self.motion.stretches:
            out.append((part.begin, part.span, Piece.of(part.rows.dot(z))))
        return out


def _last_outside(piece: Piece, final: float, band: float) -> float | None:
    """Return the last time at which the polynomial is outside the band, None where it never is."""
    end = sum(piece.a)
    if abs(end - final) > band:
        return 1.0
    leaves = [t for edge in (final + band, final - band) for t in piece.crossings(edge)]
    return max(leaves, default=0.0 if abs(piece.a[0] - final) > band else None)


def bounds(motion: Motion, states: Array) -> tuple[Array, Array]:
    """Return (low, high), bounds of the output between each sample and the next."""
    parts = [bernstein(len(part.rows)).dot(part.rows) for part in motion.stretches]
    # the first of a stretch's is the output at its begin
    rows = parts[0] if len(parts) == 1 else np.concatenate(parts or [motion.output[None]])
    count, wide = states.shape[1], max(1, _CELLS // len(rows))
    if count > wide:
        some = [bounds(motion, states[:, i : i + wide]) for i in range(0, count, wide)]
        low, high = zip(*some, strict=True)
        return np.concatenate(low), np.concatenate(high)
    values = rows.dot(states)
    return np.minimum.reduce(values), np.maximum.reduce(values)
