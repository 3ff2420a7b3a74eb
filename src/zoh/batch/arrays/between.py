"""The highest that many step responses go between their samples.

Over a piece of a sample, in which the input is held, the output is one Taylor series. Where it
rises at the beginning of a piece and falls at the end there is a crest; a cubic through both ends
and both slopes tells about how high it is and so which ones may be the highest, and the series how
high those are. A plant of three poles or more can turn twice in a piece: see ``turns`` for where
that is looked for.
"""

from dataclasses import dataclass
from functools import cache
from math import comb, factorial

import numpy as np

from zoh.batch.arrays import rows as polynomials
from zoh.batch.arrays.held import Held, advanced
from zoh.batch.arrays.motion import Motion
from zoh.batch.arrays.rows import Array, Mask
from zoh.batch.tolerances import BERNSTEIN, CUBIC, FLAT, REACH, TAYLOR

_LAST = 1e-15  # of the piece: a step this small is rounding


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """A part of every sample: rows on Z, shape (N, B), and its ends as parts of a sample.

    y, slope at the begin and at the end (per sample);  state, shape (n, N, B), and the input
    reach  |s| of the plant's poles, at most, times the piece
    """

    begin: Array
    end: Array
    y0: Array
    y1: Array
    slope0: Array
    slope1: Array
    state: Array
    input: Array
    reach: Array


def pieces(plant: Held, motion: Motion, delay: int) -> list[Piece]:
    """Return the parts of every sample over which the plant's input is held."""
    n, size = len(plant.before), motion.output.shape
    at = np.zeros((n, *size))
    at[:, :n] = np.eye(n)[:, :, None]
    here = np.broadcast_to(motion.effort, size) if not delay else _one(n + delay - 1, size)
    ends = [np.zeros(size[1]), np.ones(size[1])]
    inputs = [here]
    if delay and plant.lead.any():
        ends.insert(1, 1 - plant.lead)
        inputs.append(motion.effort if delay == 1 else _one(n + delay - 2, size))
    halvings = np.log2(plant.samples).astype(np.int64)
    found = []
    for begin, end, u in zip(ends[:-1], ends[1:], inputs, strict=True):
        delta, b = advanced(plant.rows, plant.markov, halvings, end - begin)
        after = at + np.einsum("ijb,jkb->ikb", delta, at) + b[:, None] * u
        found.append(
            Piece(
                begin=begin, end=end, y0=at[0] + plant.direct * u, y1=after[0] + plant.direct * u,
                slope0=_slope(plant, at, u), slope1=_slope(plant, after, u), state=at, input=u,
                reach=_reach(plant) * (end - begin) * plant.samples,
            )
        )  # fmt: skip
        at = after
    return found


def _one(place: int, size: tuple[int, ...]) -> Array:
    row = np.zeros(size)
    row[place] = 1.0
    return row


def _slope(plant: Held, at: Array, u: Array) -> Array:
    """Return dy/dt per sample as rows on Z."""
    of_state = at[1] if len(at) > 1 else plant.rows[1, 0] * at[0]
    slope: Array = (of_state + plant.markov[0] * u) * plant.samples
    return slope


def estimate(y0: Array, y1: Array, slope0: Array, slope1: Array) -> Array:
    """Return the height of the crest between, about; -inf where there is none.

    The cubic through both ends with both slopes, where the slope's straight line is 0.
    """
    with np.errstate(all="ignore"):
        t = slope0 / (slope0 - slope1)
        s = 1 - t
        cubic = (
            y0 * (1 + 2 * t) * s * s + slope0 * t * s * s + y1 * t * t * (3 - 2 * t)
            - slope1 * t * t * s
        )  # fmt: skip
    return np.where((slope0 > 0) & (slope1 < 0), np.maximum(cubic, np.maximum(y0, y1)), -np.inf)


def doubtful(reach: Array, slope0: Array, slope1: Array) -> Array:
    """Return by how much a crest of a plant of one or two poles may differ from ``estimate``.

    reach  |s| of the poles, at most, times the piece

    The cubic is off by max |y''''|/384 at most, and y is a sum of the slope's bends times the
    poles' s: below reach^2 (slope0 - slope1)/64, which is 6 times the most that two million pieces
    had. What a fast pole does in a piece no cubic tells.
    Source: P. J. Davis, Interpolation and Approximation, sec. 3.1 (the error of Hermite's cubic).
    """
    return np.where(reach <= CUBIC, reach * reach * (slope0 - slope1) / 64, np.inf)


def crest(plant: Held, piece: Piece, z: Array, sign: Array) -> tuple[Array, Array, Mask]:
    """Return (the height of the crest in a piece at Z, its time in samples, whether it is known).

    -inf where there is none; y is counted in the direction of ``sign``.
    """
    x, u = np.sum(piece.state * z, axis=1) * sign, np.sum(piece.input * z, axis=0) * sign
    span, reach = (piece.end - piece.begin) * plant.samples, piece.reach
    series = _series(plant, x, u, span, _needed(float(reach.max(initial=0.0)), len(x)))
    slope = polynomials.derivative(series)
    rises = (slope[0] > 0) & (np.sum(slope, axis=0) < 0)
    top, when = np.full(len(u), -np.inf), np.zeros(len(u))
    (who,) = np.nonzero(rises)
    if len(who):
        t = _root(polynomials.taken(slope, who))
        top[who] = polynomials.at(polynomials.taken(series, who), t) + (plant.direct * u)[who]
        when[who] = piece.begin[who] + t * (piece.end - piece.begin)[who]
    known = reach <= REACH
    if len(x) > 2:
        known &= _turns_once(slope, x[0])
    return top, when, known


def _turns_once(slope: Array, y: Array) -> Mask:
    """Return whether the slope surely changes its sign once at most in (0, 1).

    So it is where it only falls or only rises, and where its Bernstein coefficients change theirs
    once at most; those that are within rounding of 0 are left out, for no figure shows them.
    Source: G. Farin, Curves and Surfaces for CAGD, 5th ed., sec. 6.9 (variation diminishing).
    """
    bend = np.abs(polynomials.derivative(slope))
    once: Mask = bend[0] > np.sum(bend[1:], axis=0)
    (rest,) = np.nonzero(~once)
    if len(rest):
        count = min(len(slope), BERNSTEIN + 1)
        coefficients = _to_bernstein(count) @ slope[:count, rest]
        flat = np.abs(coefficients) <= FLAT * np.abs(y[rest])
        once[rest] = polynomials.changes(np.where(flat, 0.0, coefficients)) <= 1
    return once


@cache
def _to_bernstein(count: int) -> Array:
    """Return the matrix that makes Bernstein coefficients of as many ascending ones."""
    return np.array([[comb(j, k) / comb(count - 1, k) for k in range(count)] for j in range(count)])


def _reach(plant: Held) -> Array:
    """Return Fujiwara's bound on the poles, from the last row of the companion matrix."""
    n = plant.rows.shape[1]
    last = plant.rows[n]
    bound: Array = 2 * np.max([np.abs(last[j]) ** (1 / (n - j)) for j in range(n)], axis=0)
    return bound


def _series(plant: Held, x: Array, u: Array, span: Array, terms: int) -> Array:
    """Return the output's Taylor coefficients over the span, ascending powers of t/span.

    The derivatives follow each other by the plant's own differential equation.
    """
    n = len(x)
    last = plant.rows[n]  # C A^n, the last row of A
    g = [x[j] + plant.markov[j - 1] * u if j else x[0] for j in range(n)]
    g.append(np.sum(last * x, axis=0) + plant.markov[n - 1] * u)
    while len(g) < terms:
        m = len(g) - n
        g.append(np.sum([last[j] * g[m + j] for j in range(n)], axis=0))
    return np.array([value * span**m / factorial(m) for m, value in enumerate(g)])


def _needed(reach: float, n: int) -> int:
    count, size = n + 2, 1.0
    for m in range(1, TAYLOR):
        size *= reach / m
        if m > reach and size < 1e-18:
            return max(count, m + n)
    return TAYLOR


def _root(slope: Array) -> Array:
    """Return where the slope changes from rising to falling in (0, 1)."""
    low, high = np.zeros(slope.shape[1]), np.ones(slope.shape[1])
    t: Array = slope[0] / (slope[0] - np.sum(slope, axis=0))
    new = t
    for _ in range(60):
        f, df = polynomials.with_slope(slope, t)
        low, high = np.where(f > 0, t, low), np.where(f > 0, high, t)
        with np.errstate(all="ignore"):
            new = t - f / df
        new = np.where((new > low) & (new < high), new, (low + high) / 2)
        new = np.where(f == 0, t, new)
        if np.all(np.abs(new - t) <= _LAST):
            break
        t = new
    return new
