"""The zero-order hold of plants of order 2 side by side; see ``zoh.batch.compiled.plant``."""

from math import inf, pi, sqrt

from zoh.batch.compiled import work
from zoh.batch.compiled.abreast.angles import tangent
from zoh.batch.compiled.abreast.room import (
    A0,
    A1,
    AT_REST,
    B0,
    B1,
    BOTTOM,
    DELTA,
    DT,
    ENTERS,
    FIRST,
    HALVINGS,
    LOOPS,
    OFF,
    REACH,
    SECOND,
    TERMS,
    TOP,
    UNIT,
    X,
)
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.plant import EULER, NOTHING, RECIPROCAL
from zoh.batch.tolerances import EULERS, SERIES, SLOW, SMALL

_HALVINGS = 6  # of the unit at most: |A| dt up to 32
# rows of the room: two of Markov's parameters, one after the other, then two rows of the powers of
# A; a term's weight; how large it is, the sum at z = -1, and 1.0 where that sum is short enough
_H, _H_NEXT, _P0, _P1, _Q0, _Q1, _WEIGHT, _SIZE, _NYQUIST, _LIVE = range(10)


@compiled
def hold(w: int) -> None:
    """Hold every lane's (b1 s + b0)/(s^2 + a1 s + a0); OFF is inf where |A| dt is above 32.

    X comes as rad/s of the crossover that is asked for, and is left as its p.
    """
    scaled(w)
    at_nyquist(w)
    exponential(w)
    doubled(w)
    transfer(w)


@compiled
def scaled(w: int) -> None:
    """Write the plant in samples, the unit in which the series is short, and what it needs."""
    p, s = work.abreast(w).plant, work.abreast(w).room
    for i in range(LOOPS):
        dt = p[DT, i]
        p[X, i] = tangent(0.5 * p[X, i] * dt)
        a0, a1, b0, b1 = p[A0, i] * (dt * dt), p[A1, i] * dt, p[B0, i] * (dt * dt), p[B1, i] * dt
        reach, other = 2.0 * sqrt(abs(a0)), 2.0 * abs(a1)
        reach = reach if reach > other else other
        at_rest = 4.0 / b0
        at_rest = 2.0 * a1 / b0 if a1 != 0.0 else at_rest
        at_rest = a0 / b0 if a0 != 0.0 else at_rest
        p[AT_REST, i] = at_rest if b0 != 0.0 else 0.0
        unit, halvings = 1.0, 0.0
        for _ in range(_HALVINGS):
            far = reach * unit > SMALL
            halvings += 1.0 if far else 0.0
            unit *= 0.5 if far else 1.0
        size, needed, small = 1.0, 0.0, reach * unit
        for m in range(1, SERIES + 1):
            needed += 1.0 if size > NOTHING else 0.0
            size *= small * RECIPROCAL[m]
        needed += 2.0  # the first two may be 0
        p[TERMS, i] = needed if needed < SERIES else float(SERIES)
        p[REACH, i], p[UNIT, i], p[HALVINGS, i] = reach, unit, halvings
        first, second = b1, b0 - a1 * b1
        s[_H, i], s[_H_NEXT, i], s[_SIZE, i], s[_NYQUIST, i] = first, second, 1.0, 0.0
        s[_LIVE, i] = 1.0 if reach <= SLOW else 0.0
        p[A0, i], p[A1, i] = a0, a1


@compiled
def at_nyquist(w: int) -> None:
    """Write the gain at z = -1: the sum of E_k(0)/k! times each of Markov's parameters."""
    p, s = work.abreast(w).plant, work.abreast(w).room
    for k in range(1, EULERS + 1):
        far, factor, always, shrinks = 0, EULER[k], int(k <= 4), int(k > 2)
        for i in range(LOOPS):
            h, after, size, sum_ = s[_H, i], s[_H_NEXT, i], s[_SIZE, i], s[_NYQUIST, i]
            live = (always | int(size > NOTHING)) & int(s[_LIVE, i] > 0.0)
            s[_NYQUIST, i] = sum_ + factor * h if live else sum_
            s[_SIZE, i] = size * (p[REACH, i] / pi) if shrinks else size
            s[_H, i], s[_H_NEXT, i] = after, -p[A1, i] * after - p[A0, i] * h
            far |= live
        if far == 0:
            break


@compiled
def exponential(w: int) -> None:
    """Write by what the state moves, and the input moves it, in a unit: Taylor's series."""
    p, s = work.abreast(w).plant, work.abreast(w).room
    for i in range(LOOPS):
        unit, dt = p[UNIT, i], p[DT, i]
        a0, a1 = p[A0, i] * (unit * unit), p[A1, i] * unit
        b1 = p[B1, i] * dt * unit
        p[A0, i], p[A1, i] = a0, a1
        first, second = b1, p[B0, i] * (dt * dt) * (unit * unit) - a1 * b1
        p[FIRST, i], p[SECOND, i] = first, second
        s[_H, i], s[_H_NEXT, i], s[_WEIGHT, i] = first, second, 1.0
        s[_P0, i], s[_P1, i], s[_Q0, i], s[_Q1, i] = 0.0, 1.0, -a0, -a1
        for k in range(4):
            p[DELTA + k, i] = 0.0
        p[ENTERS, i], p[ENTERS + 1, i] = 0.0, 0.0
    for m in range(1, SERIES + 1):
        far, place = 0, float(m)
        for i in range(LOOPS):
            on = int(place <= p[TERMS, i])
            weight = s[_WEIGHT, i] * RECIPROCAL[m]
            weight = weight if on else 0.0
            h, after, p0, p1, q0, q1 = (
                s[_H, i], s[_H_NEXT, i], s[_P0, i], s[_P1, i], s[_Q0, i], s[_Q1, i]
            )  # fmt: skip
            p[ENTERS, i] += weight * h
            p[ENTERS + 1, i] += weight * after
            p[DELTA, i] += weight * p0
            p[DELTA + 1, i] += weight * p1
            p[DELTA + 2, i] += weight * q0
            p[DELTA + 3, i] += weight * q1
            a0, a1 = p[A0, i], p[A1, i]
            s[_WEIGHT, i], s[_H, i], s[_H_NEXT, i] = weight, after, -a1 * after - a0 * h
            s[_P0, i], s[_P1, i], s[_Q0, i], s[_Q1, i] = q0, q1, -q1 * a0, q0 - q1 * a1
            far |= on
        if far == 0:
            break


@compiled
def doubled(w: int) -> None:
    """Double the unit until it is a sample: e^2x - 1 = 2 (e^x - 1) + (e^x - 1)^2."""
    p = work.abreast(w).plant
    for k in range(_HALVINGS):
        far, place = 0, float(k)
        for i in range(LOOPS):
            on = int(place < p[HALVINGS, i])
            a, b, c, d = p[DELTA, i], p[DELTA + 1, i], p[DELTA + 2, i], p[DELTA + 3, i]
            e, f = p[ENTERS, i], p[ENTERS + 1, i]
            p[ENTERS, i] = 2.0 * e + a * e + b * f if on else e
            p[ENTERS + 1, i] = 2.0 * f + c * e + d * f if on else f
            p[DELTA, i] = 2.0 * a + a * a + b * c if on else a
            p[DELTA + 1, i] = 2.0 * b + a * b + b * d if on else b
            p[DELTA + 2, i] = 2.0 * c + c * a + d * c if on else c
            p[DELTA + 3, i] = 2.0 * d + c * b + d * d if on else d
            far |= on
        if far == 0:
            break


@compiled
def transfer(w: int) -> None:
    """Write top and bottom in p (Faddeev-LeVerrier), and by how much the gain at rest is off."""
    p, s = work.abreast(w).plant, work.abreast(w).room
    for i in range(LOOPS):
        a, b, c, d = p[DELTA, i], p[DELTA + 1, i], p[DELTA + 2, i], p[DELTA + 3, i]
        no_rest = p[A0, i] == 0.0
        twice = int(no_rest) & int(p[A1, i] == 0.0)
        char1 = 0.0 if twice else -(a + d)
        row0, row1 = a + char1, b
        char0 = -0.5 * (a * row0 + b * c + c * row1 + d * (d + char1))
        char0 = 0.0 if no_rest else char0
        top0, top1 = row0 * p[ENTERS, i] + row1 * p[ENTERS + 1, i], p[ENTERS, i]
        bottom1, bottom2 = 2.0 * char1 - 2.0 * char0, 4.0 - 2.0 * char1 + char0
        at_end = s[_NYQUIST, i] * bottom2
        p[TOP, i], p[TOP + 1, i] = top0, 2.0 * top1 - 2.0 * top0
        p[TOP + 2, i] = at_end if s[_LIVE, i] > 0.0 else top0 - 2.0 * top1
        p[BOTTOM, i], p[BOTTOM + 1, i], p[BOTTOM + 2, i] = char0, bottom1, bottom2
        rest = bottom2 if twice else bottom1
        rest = rest if no_rest else char0
        at_rest = p[AT_REST, i]
        off = at_rest * top0 / rest - 1.0
        off = off if at_rest != 0.0 else 0.0
        p[OFF, i] = off if p[REACH, i] * p[UNIT, i] <= SMALL else inf
