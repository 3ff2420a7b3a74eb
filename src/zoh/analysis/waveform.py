"""One output of a motion as a function of time, with its true extremes and crossings.

The motion is known at a list of samples; where few are kept because nothing fast is left, the
stretches that matter are filled in again. Inside a sample the output and its slope are known at
fixed fractions, and between two of those it is a short Taylor series of the held plant.
"""

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from math import factorial

import numpy as np
import numpy.typing as npt

from zoh.analysis.crossings import bracketed
from zoh.analysis.motion import Array, Motion, Segment

Indices = npt.NDArray[np.int64]

_TERMS = 24  # of the Taylor series over half a radian: the last is below 1e-25 of the first
_INVERSE = np.array([1 / factorial(j) for j in range(_TERMS)])
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
    """

    motion: Motion
    row: Array
    k: Indices
    states: Array
    y: Array

    @classmethod
    def of(cls, motion: Motion, row: Array) -> "Waveform":
        """Return the waveform of ``row`` times the state, filled in where it matters."""
        k, states = motion.track()
        y = states @ row
        wanted = _stretches(k, y)
        if wanted:
            k, states = _filled(motion, k, states, wanted)
            y = states @ row
        return cls(motion=motion, row=row, k=k, states=states, y=y)

    def furthest(self, sign: float, *, between: bool) -> tuple[float, float]:
        """Return (time in s, sign * y) where sign * y is largest."""
        i = int(np.argmax(sign * self.y))
        best = float(self.k[i]), float(sign * self.y[i])
        if between:
            for t, value in self._extremes(sign, best[1]):
                if value > best[1]:
                    best = t, value
        return best[0] * self.motion.dt, best[1]

    def first_reaches(self, sign: float, level: float, *, between: bool) -> float | None:
        """Return the first time in s at which sign * y is ``level`` or more; None if never."""
        reached = np.flatnonzero(sign * self.y >= level)
        last = int(reached[0]) if reached.size else len(self.k) - 1
        if between:
            for piece in self._pieces(range(last + 1)):
                found = _enters(piece, sign, level)
                if found is not None:
                    return (piece.t + found) * self.motion.dt
        return float(self.k[last]) * self.motion.dt if reached.size else None

    def last_outside(self, final: float, band: float, *, between: bool) -> float | None:
        """Return the time in s from which on |y - final| <= band."""
        off = np.abs(self.y - final)
        outside = np.flatnonzero(off > band)
        first_in = int(outside[-1]) + 1 if outside.size else 0
        if first_in >= len(self.k):
            return None
        if not between:
            return float(self.k[first_in]) * self.motion.dt
        return self._leaves(final, band, max(first_in - 1, 0)) * self.motion.dt

    def _leaves(self, final: float, band: float, known: int) -> float:
        """Return the last instant outside the band, in samples; ``known`` is a row before it."""
        last = 0.0
        ahead = np.flatnonzero(np.abs(self.y[known:] - final) > 0.5 * band) + known
        until = int(ahead[-1]) + 2 if ahead.size else known + 2
        for piece in self._pieces(range(known, min(until, len(self.k)))):
            for sign in (1.0, -1.0):
                t = _exits(piece, sign, sign * final + band)
                if t is not None:
                    last = max(last, piece.t + t)
        return last

    def _extremes(self, sign: float, above: float) -> list[tuple[float, float]]:
        """Return (t, sign * y) at the crests between samples that could exceed ``above``."""
        found = []
        for i in self._rows_near(sign, above):
            for piece in self._pieces([i]):
                for t in (0.0, piece.span, _crest(piece, sign)):
                    if t is not None:
                        found.append((piece.t + t, sign * piece.value(t)))
        return found

    def _rows_near(self, sign: float, above: float) -> Indices:
        """Return the rows whose sample could hold a value above ``above`` by its tangents."""
        fine = self._resolved()
        if not fine.size:
            return fine
        bound = np.full(len(fine), -np.inf)
        for segment in self.motion.segments:
            value, slope = _rows(self.motion, segment)
            v, s = sign * self.states[fine] @ value.T, sign * self.states[fine] @ slope.T
            h = np.diff(segment.times)
            # a crest between two points lies below both tangents where the curve is concave
            left, right = v[:, :-1] + np.maximum(s[:, :-1], 0) * h, v[:, 1:] - np.minimum(s[:, 1:], 0) * h
            rising = (s[:, :-1] > 0) & (s[:, 1:] < 0)
            crest = np.where(rising, np.maximum(left, right), -np.inf)
            bound = np.maximum(bound, np.maximum(crest.max(axis=1), v.max(axis=1)))
        rows = fine[bound > above]
        order = np.argsort(-bound[bound > above])
        return rows[order[:40]]

    def _resolved(self) -> Indices:
        """Return the rows whose next sample is known too."""
        return np.flatnonzero(np.diff(self.k, append=self.k[-1] + 1) == 1)

    def _pieces(self, rows: "range | list[int] | Indices") -> "list[Piece]":
        """Return the pieces of these rows' samples in order of time, those resolved."""
        pieces = []
        held = self.motion.held
        if held is None:
            return []
        fastest = float(np.abs(np.linalg.eigvals(held.a)).max(initial=0.0))
        for i in rows:
            if i + 1 < len(self.k) and self.k[i + 1] != self.k[i] + 1:
                continue
            for segment in self.motion.segments:
                u = float(segment.input @ self.states[i])
                for j, h in enumerate(np.diff(segment.times)):
                    x = segment.states[j] @ self.states[i]
                    t = float(self.k[i]) + segment.start + float(segment.times[j])
                    pieces.append(_piece(self.motion, x, u, t, float(h), fastest * h > _WIDE))
        return pieces


def _piece(motion: Motion, x: Array, u: float, t: float, span: float, wide: bool) -> Piece:
    held = motion.held
    if held is None:
        raise ValueError("a motion without a plant has no pieces")
    c, d, a = held.c, held.d, held.a

    def force(state: Array) -> Array:
        rate = a @ state
        if len(rate):
            rate[-1] += u
        return np.asarray(rate)

    if wide:

        def state(s: float) -> Array:
            delta, gamma = held.move(Decimal(s))
            return np.asarray(x + delta @ x + gamma * u)

        return Piece(
            t=t, span=span,
            value=lambda s: float(c @ state(s) + d * u),
            slope=lambda s: float(c @ force(state(s))),
        )  # fmt: skip
    series = np.empty(_TERMS)
    series[0], rate = c @ x + d * u, force(x)
    for j in range(1, _TERMS):
        series[j] = c @ rate
        rate = a @ rate
    value = (series * _INVERSE)[::-1].tolist()
    slope = (series[1:] * _INVERSE[:-1])[::-1].tolist()
    return Piece(t=t, span=span, value=_horner(value), slope=_horner(slope))


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


def _rows(motion: Motion, segment: Segment) -> tuple[Array, Array]:
    """Return the output and its slope at the segment's times, as rows on Z: two (K, N)."""
    held = motion.held
    if held is None:
        raise ValueError("a motion without a plant has no rows")
    value = held.c @ segment.states + held.d * segment.input
    slope = (held.c @ held.a) @ segment.states
    if len(held.c):
        slope = slope + held.c[-1] * segment.input
    return value, slope


def _stretches(k: Indices, y: Array) -> list[int]:
    """Return the rows before which samples were left out that a metric may need."""
    coarse = np.flatnonzero(np.diff(k) > 1)
    if not coarse.size:
        return []
    final = y[-1]
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


def _filled(
    motion: Motion, k: Indices, states: Array, rows: list[int]
) -> tuple[Indices, Array]:
    """Return (k, states) with every sample present after each of these rows."""
    ks, zs, at = [], [], 0
    for i in rows:
        ks.append(k[at : i + 1])
        zs.append(states[at : i + 1])
        count = int(k[i + 1] - k[i])
        ks.append(k[i] + np.arange(1, count))
        zs.append(motion.run(states[i], count)[1:])
        at = i + 1
    ks.append(k[at:])
    zs.append(states[at:])
    return np.concatenate(ks), np.concatenate(zs)
