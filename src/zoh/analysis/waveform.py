"""One output of a motion as a function of time, with its true extremes and crossings.

The motion is known at a list of samples; where few are kept because nothing fast is left, the
stretches that matter are filled in again. Inside a sample the output and its slope are known at
fixed fractions, and between two of those it is a short Taylor series of the held plant.
"""

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from zoh.analysis.crossings import bracketed
from zoh.analysis.loop import Array
from zoh.analysis.motion import Indices, Motion, Segment
from zoh.sampling.between import Held

_TERMS = 24  # of the Taylor series over half a radian: the last is below 1e-25 of the first
_CRESTS = 200  # the first ones and the likeliest ones that are followed to their top
_CHUNK = 65_536  # samples bounded at once
_WIDE = 0.6  # radians of the fastest mode beyond which the series is left for the exponential


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """The output over [t, t + span] samples: ``value`` and ``slope`` of the time after t."""

    t: float
    span: float
    value: Callable[[float], float]
    slope: Callable[[float], float]


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
        low, high = _bounds(motion, k, states, y)
        taylor = _taylor(motion.held)
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
                    for t in (0.0, piece.span, _crest(piece, sign)):
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
                    found = _enters(piece, sign, level)
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
            exits = [_exits(piece, sign, sign * final + band) for sign in (1.0, -1.0)]
            found = [t for t in exits if t is not None]
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
                if held.fastest * h > _WIDE:
                    pieces.append(_stiff_piece(held, x[j], u, float(begins[j]), h))
                else:
                    pieces.append(_piece(series[j].tolist(), float(begins[j]), h))
        return pieces


def _taylor(held: Held | None) -> tuple[Array, Array]:
    """Return (rows on the state, row on the input) of y's Taylor coefficients, (n, T) and (T,)."""
    if held is None:
        return np.zeros((0, _TERMS)), np.zeros(_TERMS)
    row, rows, inputs = held.c, [held.c], [held.d]
    for j in range(1, _TERMS):
        inputs.append(row[-1] / j if len(row) else 0.0)
        row = row @ held.a / j
        rows.append(row)
    return np.array(rows).T, np.array(inputs)


def _piece(series: list[float], t: float, span: float) -> Piece:
    slope = [j * c for j, c in enumerate(series)][:0:-1]
    return Piece(t=t, span=span, value=_horner(series[::-1]), slope=_horner(slope))


def _stiff_piece(held: Held, x: Array, u: float, t: float, span: float) -> Piece:
    """Return a piece too long for the series: an exponential for every value asked."""

    def state(s: float) -> Array:
        delta, gamma = held.move(Decimal(s))
        return np.asarray(x + delta @ x + gamma * u)

    def slope(s: float) -> float:
        rate = held.a @ state(s)
        rate[-1] += u
        return float(held.c @ rate)

    return Piece(t=t, span=span, value=lambda s: float(held.c @ state(s) + held.d * u), slope=slope)


def _horner(a: list[float]) -> Callable[[float], float]:
    def at(s: float) -> float:
        total = 0.0
        for c in a:
            total = total * s + c
        return total

    return at


def _crest(piece: Piece, sign: float) -> float | None:
    """Return when sign * y peaks inside the piece, None where it does not."""
    if sign * piece.slope(0.0) > 0 > sign * piece.slope(piece.span):
        return bracketed(piece.slope, 0.0, piece.span)
    return None


def _enters(piece: Piece, sign: float, level: float) -> float | None:
    """Return when sign * y first is ``level`` or more in the piece."""
    if sign * piece.value(0.0) >= level:
        return 0.0
    crest = _crest(piece, sign)
    for end in (crest, piece.span):
        if end is not None and sign * piece.value(end) >= level:
            return bracketed(lambda s: sign * piece.value(s) - level, 0.0, end)
    return None


def _exits(piece: Piece, sign: float, level: float) -> float | None:
    """Return when sign * y last is above ``level`` in the piece."""
    end = piece.span
    if sign * piece.value(end) > level:
        return end
    crest = _crest(piece, sign)
    for begin in (crest, 0.0):
        if begin is not None and sign * piece.value(begin) > level:
            return bracketed(lambda s: sign * piece.value(s) - level, begin, end)
    return None


def _bounds(motion: Motion, k: Indices, states: Array, y: Array) -> tuple[Array, Array]:
    """Return (low, high), bounds of y between each sample and the next.

    Where the next sample was left out, only the sample itself is known.
    """
    low, high = y.copy(), y.copy()
    held = motion.held
    if held is None:
        return low, high
    fine = np.flatnonzero(np.diff(k, append=k[-1] + 1) == 1)
    for begin in range(0, len(fine), _CHUNK):
        rows = fine[begin : begin + _CHUNK]
        for segment in motion.segments:
            value, slope = _maps(held, segment)
            v, s, h = states[rows] @ value.T, states[rows] @ slope.T, np.diff(segment.times)
            for sign, bound in ((1.0, high), (-1.0, low)):
                top, rate = sign * v, sign * s
                best = np.maximum(top[:, 1:], _crests(top, rate, h, held.fastest)).max(axis=1)
                best = np.maximum(best, top[:, 0])
                bound[rows] = sign * np.maximum(sign * bound[rows], best)
    return low, high


def _crests(y: Array, rate: Array, h: Array, fastest: float) -> Array:
    """Return bounds of the crests between neighbouring columns, -inf where there is none.

    A crest lies below both tangents. Over half a radian of the fastest mode the cubic through
    both values and slopes is nearer: it misses a few parts in a hundred of the crest's height
    above its ends, and a tenth is added.
    """
    y0, y1, s0, s1 = y[:, :-1], y[:, 1:], rate[:, :-1], rate[:, 1:]
    turns = (s0 > 0) & (s1 < 0)
    tangents = np.maximum(y0 + s0 * h, y1 - s1 * h)
    part = np.where(turns, s0, 0.0) / np.where(turns, s0 - s1, 1.0)
    rest = 1 - part
    cubic = (
        (1 + 2 * part) * rest**2 * y0
        + part * rest**2 * h * s0
        + part**2 * (3 - 2 * part) * y1
        - part**2 * rest * h * s1
    )
    ends = np.maximum(y0, y1)
    near = np.where(fastest * h > _WIDE, tangents, ends + 1.1 * np.maximum(cubic - ends, 0.0))
    return np.where(turns, np.minimum(near, tangents), -np.inf)


def _maps(held: Held, segment: Segment) -> tuple[Array, Array]:
    """Return the output and its slope at the segment's times, as rows on Z: two (K, N)."""
    value = held.c @ segment.states + held.d * segment.input
    slope = (held.c @ held.a) @ segment.states
    if len(held.c):
        slope = slope + held.c[-1] * segment.input
    return value, slope


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
