"""The closed loops' motion after a reference step of 1: Z(k+1) = Z(k) + delta Z(k).

Z holds the plant's state, the inputs under way (the last one first), the controller's, and a one.
Source: K. J. Astrom, B. Wittenmark, Computer-Controlled Systems, 3rd ed., sec. 2.3 and 3.2.
"""

from dataclasses import dataclass
from itertools import combinations
from math import pi

import numpy as np

from zoh.batch.arrays.held import Held
from zoh.batch.arrays.laws import Solved
from zoh.batch.arrays.margins import Loops
from zoh.batch.arrays.rows import Array, Complex
from zoh.batch.tolerances import APART

_ROOTS = 40  # Aberth's steps at most: the roots need no more than three digits here


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """delta, shape (N, N, B); output, effort: rows on Z, shape (N, B); final, shape (B,).

    start           Z as the reference steps, shape (N, B)
    final, at_rest  what y and u settle to
    """

    delta: Array
    start: Array
    output: Array
    effort: Array
    final: Array
    at_rest: Array


def motion(plant: Held, law: Solved, delay: int) -> Motion:
    """Return the motion of loops whose plants are all ``delay`` whole samples late.

    What e moves by is taken from what the plant's first state does, never as a difference.
    """
    n, c, count = len(plant.before), len(law.residues), len(law.direct)
    own, one = n + delay, n + delay + c
    output, effort = np.zeros((2, one + 1, count))
    if n:
        output[0] = 1.0
    if delay:
        output[own - 1] += plant.direct
    effort[own:one], effort[one] = law.residues, law.direct
    effort -= law.direct * output
    if not delay:
        effort /= 1 + law.direct * plant.direct
        output += plant.direct * effort
    delta = np.zeros((one + 1, one + 1, count))
    delta[:n, :n] = plant.delta
    late, early = plant.before - plant.after, plant.after
    inputs = [effort, *np.eye(one + 1)[n:own, :, None]]
    for i in range(n):
        delta[i] += late[i] * inputs[delay]
        if delay:
            delta[i] += early[i] * inputs[delay - 1]
    for j in range(delay):
        delta[n + j] += inputs[j]
        delta[n + j, n + j] -= 1.0
    for j in range(c):
        delta[own + j] -= law.enters[j] * output
        delta[own + j, one] += law.enters[j]
        delta[own + j, own:one] += law.moves[j]
        delta[own + j] -= law.leads[j] * delta[0]
    start = np.zeros((one + 1, count))
    start[own:one], start[one] = law.leads, 1.0
    top = law.num[0] * plant.num[0]
    bottom = law.den[0] * plant.den[0]
    return Motion(
        delta=delta, start=start, output=output, effort=effort, final=top / (top + bottom),
        at_rest=law.num[0] * plant.den[0] / (top + bottom),
    )  # fmt: skip


def poles(loops: Loops) -> Complex:
    """Return the closed loops' poles z, shape (n, B), to a few digits.

    The roots of num + den in w by Aberth's method, those at z = 0 as 1e-300.
    Source: O. Aberth, Iteration methods for finding all zeros of a polynomial simultaneously,
    Math. Comp. 27 (1973).
    """
    c = loops.num + loops.den
    p = _roots(c / np.max(np.abs(c), axis=0)) * loops.x
    with np.errstate(all="ignore"):
        z = (1 + p) / (1 - p)
    return np.where(np.isfinite(z) & (z != 0), z, 1e-300)


def _roots(c: Array) -> Complex:
    n = len(c) - 1
    with np.errstate(all="ignore"):
        radius = np.abs(c[:-1] / c[1:])
        radius = np.where(np.isfinite(radius) & (radius > 0), radius, 1.0)
        turn = pi + 0.9 * np.cos(pi * (np.arange(n) + 0.5) / max(n, 1)) * 1.2
        z: Complex = radius * np.exp(1j * turn)[:, None]
        for _ in range(_ROOTS):
            value, slope = c[-1] + 0j, np.zeros_like(z)
            value = np.broadcast_to(value, z.shape).copy()
            for row in c[-2::-1]:
                slope = slope * z + value
                value = value * z + row
            others = np.zeros_like(z)
            for i, j in combinations(range(n), 2):
                part = 1 / (z[i] - z[j])
                others[i] += part
                others[j] -= part
            step = value / (slope - value * others)
            step = np.where(np.isfinite(step), step, 0.0)
            z = z - step
            if np.all(np.abs(step) <= APART * np.abs(z)):
                break
    return z
