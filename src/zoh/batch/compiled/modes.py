"""The modes of one closed loop, side by side; see ``zoh.batch.arrays.modes``.

The same is done to all of them at once, in as many lanes as there are modes or a few more; what
is in the lanes behind the last mode is of no use.
"""

from math import inf, log1p, sqrt

import numpy as np

from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.room import LANES, WIDE, Motion
from zoh.batch.tolerances import APART, GONE, REST, SHOWN, TURN

ROOTS = 60  # Aberth's steps at most
_GONE = 345.0  # the decay of a mode that is gone in one sample
_VALUE, _VALUE_I, _SLOPE, _SLOPE_I, _OTHERS, _OTHERS_I = range(6)  # rows of the room, for roots
_REAL, _IMAG, _ROOT, _ROOT_I, _OTHER = range(5)  # and for weights


def _starts() -> "np.ndarray[tuple[int, int, int], np.dtype[np.float64]]":
    """Return (cos, sin) of where each of n roots is looked for first: [n, i]."""
    found = np.ones((2, WIDE + 1, WIDE))
    for n in range(1, WIDE + 1):
        angle = np.pi + 1.08 * np.cos(np.pi * (np.arange(n) + 0.5) / n)
        found[0, n, :n], found[1, n, :n] = np.cos(angle), np.sin(angle)
    return found


STARTS = _starts()


@compiled
def modes(w: int, n: int, x: float) -> float:
    """Write the modes' z, turn, weights and what creeps; return the decay of the slowest mode."""
    if n == 3:  # of the usual numbers the compiler knows every place beforehand
        return side_by_side(w, 3, x, 4)
    if n == 4:
        return side_by_side(w, 4, x, 4)
    if n <= LANES:
        return side_by_side(w, n, x, LANES)
    return side_by_side(w, n, x, WIDE)


@compiled
def side_by_side(w: int, n: int, x: float, wide: int) -> float:
    """Do what ``modes`` does in so many lanes."""
    start(w, n)
    for _ in range(ROOTS):
        values(w, n, wide)
        if not approach(w, n, wide):
            break
    slowest = decays(w, n, x)
    weights(w, n, wide)
    return slowest


@compiled
def start(w: int, n: int) -> None:
    """Write the polynomial whose roots the modes are, and where they may be."""
    m, lines = work.motion(w), work.lines(w)
    for k in range(n + 1):
        m.turn[k] = lines.num[k] + lines.den[k]
    for i in range(n):
        radius = abs(m.turn[i] / m.turn[i + 1])
        if not 0.0 < radius < inf:
            radius = 1.0
        m.re[i], m.im[i] = radius * STARTS[0, n, i], radius * STARTS[1, n, i]


@compiled
def values(w: int, n: int, wide: int) -> None:
    """Write the polynomial and its slope at each root, and the sum of 1/(root - another)."""
    m = work.motion(w)
    c, re, im, room = m.turn, m.re, m.im, m.room
    for i in range(wide):
        room[_VALUE, i], room[_VALUE_I, i] = c[n], 0.0
        room[_SLOPE, i], room[_SLOPE_I, i] = 0.0, 0.0
        room[_OTHERS, i], room[_OTHERS_I, i] = 0.0, 0.0
    for k in range(n - 1, -1, -1):
        next_one = c[k]
        for i in range(wide):
            a, b = re[i], im[i]
            fr, fi, sr, si = room[_VALUE, i], room[_VALUE_I, i], room[_SLOPE, i], room[_SLOPE_I, i]
            room[_SLOPE, i] = sr * a - si * b + fr
            room[_SLOPE_I, i] = sr * b + si * a + fi
            room[_VALUE, i] = fr * a - fi * b + next_one
            room[_VALUE_I, i] = fr * b + fi * a
    for j in range(n):
        r, q = re[j], im[j]
        for i in range(wide):
            dr, di = re[i] - r, im[i] - q
            square = dr * dr + di * di
            part = 1.0 / square if square > 0.0 else 0.0
            room[_OTHERS, i] += dr * part
            room[_OTHERS_I, i] -= di * part


@compiled
def approach(w: int, n: int, wide: int) -> bool:
    """Move the roots by one step; return whether any of them has moved far.

    newton = f/s, step = newton/(1 - newton sum 1/(z - z_j)) = f/(s - f sum)
    """
    m = work.motion(w)
    re, im, room, far = m.re, m.im, m.room, 0
    for i in range(wide):
        fr, fi, tr, ti = room[_VALUE, i], room[_VALUE_I, i], room[_OTHERS, i], room[_OTHERS_I, i]
        qr = room[_SLOPE, i] - (fr * tr - fi * ti)
        qi = room[_SLOPE_I, i] - (fr * ti + fi * tr)
        square = qr * qr + qi * qi
        part = 1.0 / square if square > 0.0 else 0.0
        dr, di = (fr * qr + fi * qi) * part, (fi * qr - fr * qi) * part
        small = APART * (abs(re[i]) + abs(im[i]))
        far |= int(abs(dr) + abs(di) > small) & int(i < n)
        re[i] -= dr
        im[i] -= di
    return far != 0


@compiled
def decays(w: int, n: int, x: float) -> float:
    """Turn u = p/x into z; write |log z| and which mode creeps; return the least decay.

    log z is 2 p + 2 p^3/3 + ..., and its size asked for where it is small alone.
    """
    m, nearest = work.motion(w), -1.0
    for i in range(n):
        a, b = m.re[i] * x, m.im[i] * x
        part = 1.0 / ((1.0 - a) ** 2 + b * b)
        m.re[i], m.im[i] = ((1.0 + a) * (1.0 - a) - b * b) * part, 2.0 * b * part
        m.turn[i], m.creeping[i] = 2.0 * sqrt(a * a + b * b), 4.0 * a * part  # |z|^2 - 1
        nearest = max(nearest, m.creeping[i])
    return alone(m, n, nearest)


@compiled
def alone(m: Motion, n: int, nearest: float) -> float:
    """Return the least decay, and turn |z|^2 - 1 of each mode into whether it is that one's."""
    slowest = min(-0.5 * log1p(nearest), _GONE)
    for i in range(n):
        creeps = m.creeping[i] == nearest and abs(m.im[i]) <= 1e-9 * slowest * m.re[i]
        m.creeping[i] = 1.0 if creeps else 0.0
    return slowest


@shared
def restless(w: int, n: int, slowest: float) -> bool:
    """Return whether the single design may not follow the motion to its rest; see the arrays.

    slowest  the decay of the slowest mode
    """
    m, rest, shown = work.motion(w), REST / slowest, 0.0
    if n * rest <= SHOWN:
        return False
    for i in range(n):
        over = m.im[i] * m.im[i] - (1.0 - m.re[i]) * (1.0 + m.re[i])  # |z|^2 - 1
        decay = max(-0.5 * log1p(over), 1e-14) if over > -1.0 else _GONE
        share = 0.5 if abs(m.im[i]) > decay else 1.0
        shown += share * min(GONE / decay, rest) * min(1.0, m.turn[i] * (8.0 / TURN))
    return shown > SHOWN


@compiled
def weights(w: int, n: int, wide: int) -> None:
    """Write the weights of each mode's share: the product of (S - mu_j + 1)/(mu_i - mu_j)."""
    m = work.motion(w)
    re, im, wr, wi, room = m.re, m.im, m.wr, m.wi, m.room
    for k in range(n + 1):
        for i in range(wide):
            wr[k, i], wi[k, i] = 0.0 if k else 1.0, 0.0
    for j in range(n):
        r, q = re[j], im[j]
        for i in range(wide):
            dr, di = re[i] - r, im[i] - q
            other = 1.0 if i != j else 0.0  # a mode's own lane stays as it is: times 1 0 - (-1)
            part = other / (dr * dr + di * di if i != j else 1.0)
            room[_REAL, i], room[_IMAG, i] = dr * part + (1.0 - other), -di * part
            room[_ROOT, i], room[_ROOT_I, i] = r * other - 1.0, q * other
            room[_OTHER, i] = other
        for k in range(n - 1, -1, -1):
            last = k - 1 if k else n
            for i in range(wide):
                one, two, other = wr[k, i], wi[k, i], room[_OTHER, i]
                r, q = room[_ROOT, i], room[_ROOT_I, i]
                a, b = (
                    wr[last, i] * other + q * two - r * one,
                    wi[last, i] * other - r * two - q * one,
                )
                dr, di = room[_REAL, i], room[_IMAG, i]
                wr[k, i], wi[k, i] = a * dr - b * di, a * di + b * dr
