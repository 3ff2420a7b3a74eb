"""A stretch of a held plant's output as a function of time, and its extremes.

Between two fractions of a sample the output is a short Taylor series; where the fastest mode
turns too far for that, an exponential.
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
_CHUNK = 65_536  # samples bounded at once
WIDE = 0.6  # radians of the fastest mode beyond which the series is left for the exponential


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """The output over [t, t + span] samples: ``value`` and ``slope`` of the time after t."""

    t: float
    span: float
    value: Callable[[float], float]
    slope: Callable[[float], float]


def taylor_rows(held: Held | None) -> tuple[Array, Array]:
    """Return (rows on the state, row on the input) of y's Taylor coefficients, (n, T) and (T,)."""
    if held is None:
        return np.zeros((0, _TERMS)), np.zeros(_TERMS)
    row, rows, inputs = held.c, [held.c], [held.d]
    for j in range(1, _TERMS):
        inputs.append(row[-1] / j if len(row) else 0.0)
        row = row @ held.a / j
        rows.append(row)
    return np.array(rows).T, np.array(inputs)


def series_piece(series: list[float], t: float, span: float) -> Piece:
    """Return the piece of a Taylor series, ascending powers of the time after t."""
    slope = [j * c for j, c in enumerate(series)][:0:-1]
    return Piece(t=t, span=span, value=_horner(series[::-1]), slope=_horner(slope))


def stiff_piece(held: Held, x: Array, u: float, t: float, span: float) -> Piece:
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


def crest(piece: Piece, sign: float) -> float | None:
    """Return when sign * y peaks inside the piece, None where it does not."""
    if sign * piece.slope(0.0) > 0 > sign * piece.slope(piece.span):
        return bracketed(piece.slope, 0.0, piece.span)
    return None


def enters(piece: Piece, sign: float, level: float) -> float | None:
    """Return when sign * y first is ``level`` or more in the piece."""
    if sign * piece.value(0.0) >= level:
        return 0.0
    top = crest(piece, sign)
    for end in (top, piece.span):
        if end is not None and sign * piece.value(end) >= level:
            return bracketed(lambda s: sign * piece.value(s) - level, 0.0, end)
    return None


def exits(piece: Piece, sign: float, level: float) -> float | None:
    """Return when sign * y last is above ``level`` in the piece."""
    end = piece.span
    if sign * piece.value(end) > level:
        return end
    top = crest(piece, sign)
    for begin in (top, 0.0):
        if begin is not None and sign * piece.value(begin) > level:
            return bracketed(lambda s: sign * piece.value(s) - level, begin, end)
    return None


def bounds(motion: Motion, k: Indices, states: Array, y: Array) -> tuple[Array, Array]:
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
    near = np.where(fastest * h > WIDE, tangents, ends + 1.1 * np.maximum(cubic - ends, 0.0))
    return np.where(turns, np.minimum(near, tangents), -np.inf)


def _maps(held: Held, segment: Segment) -> tuple[Array, Array]:
    """Return the output and its slope at the segment's times, as rows on Z: two (K, N)."""
    value = held.c @ segment.states + held.d * segment.input
    slope = (held.c @ held.a) @ segment.states
    if len(held.c):
        slope = slope + held.c[-1] * segment.input
    return value, slope
