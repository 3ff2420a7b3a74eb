"""The highest that one step response goes between its samples; see ``zoh.batch.arrays.between``."""

from math import inf, sqrt

import numpy as np

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.plant import advanced
from zoh.batch.compiled.room import PART, WHOLE, Pieces, Plant
from zoh.batch.tolerances import BERNSTEIN, FLAT, REACH, TAYLOR

_LAST = 1e-6  # of the piece: the error after a Newton's step as small as this is its square
_NOTHING = 1e-18
PARTS = 1.0 / np.maximum(np.arange(TAYLOR + 2.0), 1.0)


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


@shared
def crest(
    w: int, piece: int, n: int, z: Array, sign: float, size: int
) -> tuple[float, float, bool]:
    """Return (the height of the crest in a piece at Z, its time in samples, whether known)."""
    if n == 2:  # of the usual order the compiler knows every place beforehand
        return crest_of(w, piece, 2, z, sign, size)
    return crest_of(w, piece, n, z, sign, size)


@compiled
def crest_of(
    w: int, piece: int, n: int, z: Array, sign: float, size: int
) -> tuple[float, float, bool]:
    """Do what ``crest`` does."""
    p, q = work.plant(w), work.pieces(w)
    g, h, span = q.series, q.slopes, (q.ends[piece + 1] - q.ends[piece]) * p.numbers[0]
    reach = p.numbers[1] * (q.ends[piece + 1] - q.ends[piece])
    u = 0.0
    for j in range(size):
        u += sign * q.input[piece, j] * z[j]
    last = 0.0
    for i in range(n):
        x = 0.0
        for j in range(size):
            x += sign * q.state[piece, i, j] * z[j]
        last += p.rows[n, i] * x
        g[i] = x + p.markov[i - 1] * u if i else x
    g[n] = last + p.markov[n - 1] * u
    terms, bulk = n, 1.0
    while terms < TAYLOR and (terms < n + 2 or terms <= reach or bulk > _NOTHING):
        terms += 1
        bulk *= reach * PARTS[terms - n]
        total = 0.0
        for i in range(n):
            total += p.rows[n, i] * g[terms - n + i]
        g[terms] = total
    weight, falls, bends = 1.0, 0.0, 0.0
    for k in range(1, terms + 1):
        weight *= span * PARTS[k]
        g[k] *= weight
        h[k] = k * g[k]
        falls += h[k]
        bends += (k - 1) * abs(h[k])
    height, when = -inf, 0.0
    if g[1] > 0.0 > falls:
        t = turning(h, terms, near(g, g[1] / (g[1] - falls)))
        value = g[terms]
        for k in range(terms - 1, -1, -1):
            value = value * t + g[k]
        height = value
        when = q.ends[piece] + t * (q.ends[piece + 1] - q.ends[piece])
    known = reach <= REACH
    if n > 2 and 2.0 * abs(h[2]) <= bends:  # else the slope only falls, or only rises
        known = known and turns(h, terms, FLAT * abs(g[0]), q.bernstein) <= 1
    return height, when, known


@compiled
def turns(h: Array, terms: int, flat: float, c: Array) -> int:
    """Return how often the slope changes its sign at most; see ``zoh.batch.arrays.between``."""
    count, part = min(terms, BERNSTEIN + 1), 1.0
    for k in range(count):
        c[k] = h[k + 1] * part
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
    """Return where the slope's first three terms are 0; t where that is not in (0, 1)."""
    square = g[2] * g[2] - 3.0 * g[1] * g[3]
    there = g[1] / (sqrt(max(square, 0.0)) - g[2])
    return there if 0.0 < there < 1.0 else t


@compiled
def turning(h: Array, terms: int, t: float) -> float:
    """Return where the slope, the sum of h_k t^(k-1), changes from rising to falling in (0, 1)."""
    low, high = 0.0, 1.0
    for _ in range(60):
        f, df = h[terms], 0.0
        for k in range(terms - 1, 0, -1):
            df = df * t + f
            f = f * t + h[k]
        if f == 0.0:
            return t
        if f > 0.0:
            low = t
        else:
            high = t
        new = t - float(f / df)
        if abs(new - t) <= _LAST:  # be it that rounding puts it on an end of the bracket, or behind
            return new
        if not low < new < high:
            new = (low + high) / 2.0
        t = new
    return t
