"""The motion of one closed loop and its modes; see ``zoh.batch.arrays.motion``."""

from math import cos, hypot, inf, log, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.plant import ORDER, Plant
from zoh.batch.compiled.polynomials import MOST
from zoh.batch.tolerances import APART

_ROOTS = 60  # Aberth's steps at most
SIZE = 15  # of Z: a plant of order 6, four inputs under way, a controller of order 3, a one
_WIDE = 16  # a whole number of lanes


class Law(NamedTuple):
    """A controller: num, den in p; x moves by moves x + enters e, u = residues x + direct e.

    numbers  direct, room, and the gains
    """

    num: Array
    den: Array
    moves: Array
    enters: Array
    residues: Array
    numbers: Array


def law() -> Law:
    """Return the arrays."""
    return Law(
        num=np.zeros(MOST), den=np.zeros(MOST), moves=np.zeros((4, 4)), enters=np.zeros(4),
        residues=np.zeros(4), numbers=np.zeros(8),
    )  # fmt: skip


class Motion(NamedTuple):
    """delta, and rows on Z: output, effort, what they move by; then the modes.

    numbers   final, at_rest;  re, im  z of each mode
    wr, wi    the weights of its share, a mode a column;  shares  its share of output and effort
    turn      |log z|;  creeping  1.0 for the slowest mode, if it does not swing
    """

    delta: Array
    output: Array
    effort: Array
    output_moves: Array
    effort_moves: Array
    numbers: Array
    re: Array
    im: Array
    wr: Array
    wi: Array
    shares: Array
    turn: Array
    creeping: Array


def motion() -> Motion:
    """Return the arrays."""
    n = SIZE
    return Motion(
        delta=np.zeros((n, n)), output=np.zeros(n), effort=np.zeros(n), output_moves=np.zeros(n),
        effort_moves=np.zeros(n), numbers=np.zeros(3), re=np.zeros(n), im=np.zeros(n),
        wr=np.zeros((_WIDE, _WIDE)), wi=np.zeros((_WIDE, _WIDE)), shares=np.zeros((4, _WIDE)),
        turn=np.zeros(n), creeping=np.zeros(n),
    )  # fmt: skip


@compiled
def closed(m: Motion, p: Plant, law: Law, n: int, c: int, delay: int) -> int:
    """Write the motion after a reference step of 1; return the size of Z."""
    own, one = n + delay, n + delay + c
    size = one + 1
    direct, through = law.numbers[0], p.numbers[0]
    for i in range(size):
        m.output[i], m.effort[i] = 0.0, 0.0
        for j in range(size):
            m.delta[i, j] = 0.0
    if n:
        m.output[0] = 1.0
    if delay:
        m.output[own - 1] += through
    for j in range(c):
        m.effort[own + j] = law.residues[j]
    m.effort[one] = direct
    for j in range(size):
        m.effort[j] -= direct * m.output[j]
    if not delay and through != 0.0:
        for j in range(size):
            m.effort[j] /= 1.0 + direct * through
            m.output[j] += through * m.effort[j]
    for i in range(n):
        for j in range(n):
            m.delta[i, j] = p.delta[i, j]
        late, early = p.before[i] - p.after[i], p.after[i]
        if delay:
            m.delta[i, own - 1] += late
            if delay > 1:
                m.delta[i, own - 2] += early
            else:
                for j in range(size):
                    m.delta[i, j] += early * m.effort[j]
        else:
            for j in range(size):
                m.delta[i, j] += late * m.effort[j]
    for j in range(delay):
        if j:
            m.delta[n + j, n + j - 1] += 1.0
        else:
            for i in range(size):
                m.delta[n, i] += m.effort[i]
        m.delta[n + j, n + j] -= 1.0
    for j in range(c):
        for i in range(size):
            m.delta[own + j, i] -= law.enters[j] * m.output[i]
        m.delta[own + j, one] += law.enters[j]
        for i in range(c):
            m.delta[own + j, own + i] += law.moves[j, i]
    moved_row(m.output, m.delta, size, m.output_moves)
    moved_row(m.effort, m.delta, size, m.effort_moves)
    top, bottom = law.num[0] * p.top[0], law.den[0] * p.bottom[0]
    m.numbers[0] = top / (top + bottom)
    m.numbers[1] = law.num[0] * p.bottom[0] / (top + bottom)
    return size


@compiled
def moved_row(row: Array, delta: Array, size: int, out: Array) -> None:
    """Write row delta."""
    for j in range(size):
        total = 0.0
        for i in range(size):
            total += row[i] * delta[i, j]
        out[j] = total


@compiled
def poles(m: Motion, num: Array, den: Array, n: int, x: float) -> None:
    """Write the closed loop's modes to a few digits: Aberth's method, the newest values used."""
    c, re, im = m.turn, m.re, m.im
    for k in range(n + 1):
        c[k] = num[k] + den[k]
    for i in range(n):
        radius = abs(c[i] / c[i + 1])
        if not 0.0 < radius < inf:
            radius = 1.0
        angle = pi + 1.08 * cos(pi * (i + 0.5) / n)
        re[i], im[i] = radius * cos(angle), radius * sin(angle)
    for _ in range(_ROOTS):
        moving = False
        for i in range(n):
            a, b = re[i], im[i]
            fr, fi, sr, si = c[n], 0.0, 0.0, 0.0
            for k in range(n - 1, -1, -1):
                sr, si = sr * a - si * b + fr, sr * b + si * a + fi
                fr, fi = fr * a - fi * b + c[k], fr * b + fi * a
            # newton = f/s, step = newton/(1 - newton sum 1/(z - z_j)) = f/(s - f sum)
            tr, ti = 0.0, 0.0
            for j in range(n):
                if j != i:
                    dr, di = a - re[j], b - im[j]
                    square = dr * dr + di * di
                    if square > 0.0:
                        tr += dr / square
                        ti -= di / square
            qr, qi = sr - (fr * tr - fi * ti), si - (fr * ti + fi * tr)
            square = qr * qr + qi * qi
            if not square > 0.0:
                continue
            dr, di = (fr * qr + fi * qi) / square, (fi * qr - fr * qi) / square
            re[i], im[i] = a - dr, b - di
            if abs(dr) + abs(di) > APART * (abs(a) + abs(b)):
                moving = True
        if not moving:
            break
    for i in range(n):
        a, b = re[i] * x, im[i] * x
        square = (1.0 - a) ** 2 + b * b
        if square > 0.0:
            re[i], im[i] = ((1.0 + a) * (1.0 - a) - b * b) / square, 2.0 * b / square
        if not square > 0.0 or hypot(re[i], im[i]) < 1e-300:
            re[i], im[i] = 1e-300, 0.0


@compiled
def modes(m: Motion, n: int) -> float:
    """Write turn, weights and what creeps; return the decay of the slowest mode."""
    slowest = inf
    for i in range(n):
        decay = -log(hypot(m.re[i], m.im[i]))
        m.creeping[i] = decay
        slowest = min(slowest, decay)
    for i in range(n):
        angle = np.arctan2(m.im[i], m.re[i])
        decay = m.creeping[i]
        m.turn[i] = sqrt(decay * decay + angle * angle)
        m.creeping[i] = 1.0 if decay == slowest and abs(angle) <= 1e-9 * decay else 0.0
    for i in range(n):
        for k in range(n):
            m.wr[k, i], m.wi[k, i] = 0.0, 0.0
        m.wr[0, i] = 1.0
        for j in range(n):
            if j == i:
                continue
            dr, di = m.re[i] - m.re[j], m.im[i] - m.im[j]
            square = dr * dr + di * di
            dr, di = dr / square, -di / square  # 1/(mu_i - mu_j)
            r, q = m.re[j] - 1.0, m.im[j]
            for k in range(n - 1, -1, -1):
                a = (m.wr[k - 1, i] if k else 0.0) - (r * m.wr[k, i] - q * m.wi[k, i])
                b = (m.wi[k - 1, i] if k else 0.0) - (r * m.wi[k, i] + q * m.wr[k, i])
                m.wr[k, i], m.wi[k, i] = a * dr - b * di, a * di + b * dr
    return slowest


__all__ = ["ORDER", "SIZE", "Law", "Motion", "closed", "law", "modes", "motion", "poles"]
