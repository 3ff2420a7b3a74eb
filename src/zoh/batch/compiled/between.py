"""The highest that one step response goes between its samples; see ``zoh.batch.arrays.between``."""

from math import inf

import numpy as np

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.plant import advanced
from zoh.batch.compiled.room import PART, WHOLE, Pieces, Plant
from zoh.batch.tolerances import BERNSTEIN, CUBIC, FLAT, REACH, TAYLOR

_LAST = 1e-4  # of the piece: the error after a step of Halley's as small as this is its cube
_AT_ONCE = 4  # terms: so many loops have equally many, which a processor foresees
_NOTHING = 1e-18
PARTS = 1.0 / np.maximum(np.arange(TAYLOR + _AT_ONCE + 1.0), 1.0)


@compiled
def cut(w: int, n: int, delay: int, lead: float, size: int) -> int:
    """Write the parts of every sample over which the input is held; return how many."""
    if n == 2 and delay == 0 and size == 5:  # of the usual ones the compiler knows every place
        return parts(w, 2, 0, lead, 5)
    return parts(w, n, delay, lead, size)


@compiled
def parts(w: int, n: int, delay: int, lead: float, size: int) -> int:
    """Do what ``cut`` does."""
    q, m, p = work.pieces(w), work.motion(w), work.plant(w)
    count = 2 if delay and lead > 0.0 else 1
    q.ends[0], q.ends[count] = 0.0, 1.0
    if count == 2:
        q.ends[1] = 1.0 - lead
    halvings, terms = 0, int(p.numbers[3])
    while 2.0**halvings < p.numbers[0]:
        halvings += 1
    for i in range(n):
        for j in range(size):
            q.state[0, i, j] = 1.0 if i == j else 0.0
    for piece in range(count):
        for j in range(size):
            if delay - piece > 0:
                q.input[piece, j] = 1.0 if j == n + delay - piece - 1 else 0.0
            else:
                q.input[piece, j] = m.effort[j]
        if count == 2:
            span = q.ends[piece + 1] - q.ends[piece]
            advanced(w, n, terms, halvings, span, PART)
        which = PART if count == 2 else WHOLE
        moved(q, piece, n, size, p.delta[which], p.enters[which])
        for j in range(size):
            q.y0[piece, j], q.y1[piece, j] = q.state[piece, 0, j], q.state[piece + 1, 0, j]
            q.slope0[piece, j] = slope(q, p, piece, piece, n, j)
            q.slope1[piece, j] = slope(q, p, piece + 1, piece, n, j)
    return count


@compiled
def moved(q: Pieces, piece: int, n: int, size: int, delta: Array, b: Array) -> None:
    """Write the state after a piece as rows on Z."""
    for i in range(n):
        for j in range(size):
            total = q.state[piece, i, j] + b[i] * q.input[piece, j]
            for k in range(n):
                total += delta[i, k] * q.state[piece, k, j]
            q.state[piece + 1, i, j] = total


@compiled
def slope(q: Pieces, p: Plant, state: int, piece: int, n: int, j: int) -> float:
    """Return an element of dy/dt per sample as a row on Z."""
    of_state = q.state[state, 1, j] if n > 1 else p.rows[1, 0] * q.state[state, 0, j]
    whole: float = (of_state + p.markov[0] * q.input[piece, j]) * p.numbers[0]
    return whole


@compiled
def estimate(y0: float, y1: float, slope0: float, slope1: float) -> float:
    """Return about the height of a crest between, from a cubic."""
    t = slope0 / (slope0 - slope1)
    s = 1.0 - t
    cubic = (
        y0 * (1.0 + 2.0 * t) * s * s + slope0 * t * s * s + y1 * t * t * (3.0 - 2.0 * t)
        - slope1 * t * t * s
    )  # fmt: skip
    return max(cubic, max(y0, y1))


@compiled
def doubtful(reach: float, bend: float) -> float:
    """Return by how much a crest may differ from ``estimate``; see ``zoh.batch.arrays.between``.

    reach  |s| of the poles, at most, times the piece;  bend  by how much the slope falls in it
    """
    return reach * reach * bend / 64.0 if reach <= CUBIC else inf


@shared
def crest(
    w: int, piece: int, n: int, z: Array, sign: float, size: int
) -> tuple[float, float, bool]:
    """Return (the height of the crest in a piece at Z, its time in samples, whether known)."""
    if n == 2 and size == 5:  # of the usual ones the compiler knows every place beforehand
        return crest_of(w, piece, 2, z, sign, 5)
    return crest_of(w, piece, n, z, sign, size)


@compiled
def crest_of(
    w: int, piece: int, n: int, z: Array, sign: float, size: int
) -> tuple[float, float, bool]:
    """Do what ``crest`` does."""
    p, q = work.plant(w), work.pieces(w)
    begin, part, g = q.ends[piece], q.ends[piece + 1] - q.ends[piece], q.series
    reach = p.numbers[1] * part
    derivatives(w, piece, n, z, sign, size)
    terms = extended(q.derivatives, p.rows[n], n, reach)
    falls, bends = taylor(q.derivatives, terms, part * p.numbers[0], g)
    height, when = -inf, 0.0
    if g[1] > 0.0 > falls:
        t, height = summit(g, terms, near(g, g[1] / (g[1] - falls)))
        when = begin + t * part
    known = reach <= REACH
    if n > 2 and 4.0 * abs(g[2]) <= bends:  # else the slope only falls, or only rises
        known = known and turns(g, terms, FLAT * abs(g[0]), q.bernstein) <= 1
    return height, when, known


@compiled
def derivatives(w: int, piece: int, n: int, z: Array, sign: float, size: int) -> None:
    """Write y's first n derivatives at the beginning of a piece, from Z."""
    p, q, u, last = work.plant(w), work.pieces(w), 0.0, 0.0
    for j in range(size):
        u += sign * q.input[piece, j] * z[j]
    for i in range(n):
        x = 0.0
        for j in range(size):
            x += sign * q.state[piece, i, j] * z[j]
        last += p.rows[n, i] * x
        q.derivatives[i] = x + p.markov[i - 1] * u if i else x
    q.derivatives[n] = last + p.markov[n - 1] * u


@compiled
def extended(g: Array, row: Array, n: int, reach: float) -> int:
    """Write the derivatives after the first n, some at once, as many as count; return how many."""
    terms, bulk = n, 1.0
    while terms < TAYLOR and (terms <= reach or bulk > _NOTHING):
        for _ in range(_AT_ONCE):
            terms += 1
            bulk *= reach * PARTS[terms - n]
            total = 0.0
            for i in range(n):
                total += row[i] * g[terms - n + i]
            g[terms] = total
    return terms


@compiled
def taylor(f: Array, terms: int, span: float, g: Array) -> tuple[float, float]:
    """Write Taylor's coefficients over a piece; return its slope at the end, and all its bends."""
    weight, falls, bends = 1.0, 0.0, 0.0
    g[0] = f[0]
    for k in range(1, terms + 1):
        weight *= span * PARTS[k]
        g[k] = f[k] * weight
        falls += k * g[k]
        bends += (k - 1) * k * abs(g[k])
    return falls, bends


@compiled
def turns(g: Array, terms: int, flat: float, c: Array) -> int:
    """Return how often the slope changes its sign at most; see ``zoh.batch.arrays.between``."""
    count, part = min(terms, BERNSTEIN + 1), 1.0
    for k in range(count):
        c[k] = (k + 1) * g[k + 1] * part
        part *= (k + 1.0) / (count - 1.0 - k)
    for i in range(1, count):
        for j in range(count - 1, i - 1, -1):
            c[j] += c[j - 1]
    found, last = 0, 0.0
    for k in range(count):
        if abs(c[k]) > flat:
            if (c[k] > 0.0 > last) or (c[k] < 0.0 < last):
                found += 1
            last = c[k]
    return found


@compiled
def near(g: Array, t: float) -> float:
    """Return about where the slope is 0; t where that is not in (0, 1).

    From its first five terms, by the first four of their inverse.
    Source: M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 3.6.25.
    """
    part = 0.5 / g[2]
    b, c, d, r = 3.0 * g[3] * part, 4.0 * g[4] * part, 5.0 * g[5] * part, -g[1] * part
    there = r * (1.0 - r * (b - r * (2.0 * b * b - c - r * (5.0 * b * (b * b - c) + d))))
    return there if 0.0 < there < 1.0 else t


@compiled
def summit(g: Array, terms: int, t: float) -> tuple[float, float]:
    """Return (where the slope of the sum of g_k t^k changes from rising to falling, the sum there).

    That is in (0, 1). Source: E. Halley's steps, with Taylor's polynomial at the last one.
    """
    low, high, y = 0.0, 1.0, 0.0
    for _ in range(60):
        y, slope, bend, third = g[terms], 0.0, 0.0, 0.0
        for k in range(terms - 1, -1, -1):
            third = third * t + bend
            bend = bend * t + slope
            slope = slope * t + y
            y = y * t + g[k]
        if slope > 0.0:
            low = t
        else:
            high = t
        step = -2.0 * slope * bend / (4.0 * bend * bend - 3.0 * slope * third)
        if abs(step) <= _LAST:  # be it that rounding puts it on an end of the bracket, or behind
            return t + step, y + step * (slope + step * (bend + step * third))
        new = t + step
        t = new if low < new < high else (low + high) / 2.0
    return t, y
