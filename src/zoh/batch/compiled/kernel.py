"""A stretch of loops, one after the other: hold, law, stability, margins, step."""

from collections.abc import Callable
from math import inf, log, tan
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import between, laws, margins, plant, polynomials, steps, track
from zoh.batch.compiled import motion as motions
from zoh.batch.compiled.bare import bare
from zoh.batch.compiled.between import Pieces
from zoh.batch.compiled.jit import compiled, kept, stamp
from zoh.batch.compiled.margins import measured, stable
from zoh.batch.compiled.motion import Law, Motion
from zoh.batch.compiled.plant import Plant, held
from zoh.batch.compiled.polynomials import on_axis, times
from zoh.batch.tolerances import HELD, ON_TARGET, ROOM

GAINS = 4  # at most, of a law
GIVEN = 6
_GRID = np.geomspace(1e-7, 1e4, 45)  # of |p|

OK, INFEASIBLE, UNSTABLE, OFF_TARGET = 0, 1, 2, 4  # of ``Reason``


class Work(NamedTuple):
    """Every array that a loop needs, made once for a stretch of them."""

    plant: Plant
    law: Law
    motion: Motion
    pieces: Pieces
    num: Array
    den: Array
    more: Array
    roots: Array
    work: Array
    parts: Array
    ladder: Array
    block: Array
    zs: Array
    seen: Array


def made() -> Work:
    """Return the arrays."""
    line = polynomials.MOST
    return Work(
        plant=plant.plant(), law=motions.law(), motion=motions.motion(), pieces=between.pieces(),
        num=np.zeros(line), den=np.zeros(line), more=np.zeros(line), roots=np.zeros(line),
        work=polynomials.work(), parts=np.zeros((12, line)), ladder=track.ladder(),
        block=track.block(), zs=track.states(), seen=np.zeros(track.SEEN),
    )  # fmt: skip


@compiled
def one(
    w: Work, code: int, n: int, reference: float, num: Array, den: Array, dt: float, delay: int,
    lead: float, wc: float, pm_deg: float, spare: float, pole: float, i: int, gains: Array,
    margin: Array, step: Array, reason: npt.NDArray[np.int8],
) -> bool:  # fmt: skip
    """Write what becomes of one loop; return whether it is left to the single design."""
    p, law = w.plant, w.law
    for k in range(n + 1):
        p.b[k], p.a[k] = num[k, i], den[k, i]
    held(p, n, dt, lead)
    if not abs(p.numbers[3]) <= HELD:
        return True
    x = tan(wc * dt / 2.0)
    if code == GIVEN:
        c = int(pole)
        x = crossover(w, n, c)
    else:
        lag = 2.0 / (pole * dt) if pole > 0.0 else 1.0
        c = laws.solve(law, p, n, delay, code, x, dt, pm_deg, spare, lag)
    room = law.numbers[1]
    if not abs(room) > ROOM:
        return True
    if room < 0.0:
        reason[i] = INFEASIBLE
        return False
    for k in range(gains.size):
        gains[k] = law.numbers[2 + k]
    degree = closed(w, n, c, delay, x)
    good, doubt = stable(w.num, w.den, degree, w.more, w.roots)
    if doubt:
        return True
    if not good:
        reason[i] = UNSTABLE
        return False
    if measured(w.num, w.den, degree, x, dt, margin, w.roots, w.work, w.parts):
        return True
    size = motions.closed(w.motion, p, law, n, c, delay)
    motions.poles(w.motion, w.num, w.den, degree, x)
    slowest = motions.modes(w.motion, degree)
    count = between.cut(w.pieces, w.motion, p, n, delay, lead, size)
    if steps.step_metrics(w.motion, p, w.pieces, count, n, degree, size, slowest, dt, reference,
                          w.ladder, w.block, w.zs, w.seen, step):  # fmt: skip
        return True
    reason[i] = OK
    if code != GIVEN:
        off = (
            abs(margin[margins.PM] - pm_deg) > ON_TARGET
            or abs(margin[margins.CROSSOVER] / wc - 1.0) > ON_TARGET
        )
        if off:
            reason[i] = OFF_TARGET
    return False


@compiled
def crossover(w: Work, n: int, c: int) -> float:
    """Return about the highest |p| at which the gain is 1, or where it is nearest to 1."""
    last, nearest, least = 0.0, 1.0, inf
    for x in _GRID:
        a, b, _, _ = on_axis(w.plant.top, n, x)
        e, f, _, _ = on_axis(w.law.num, c, x)
        over = (a * a + b * b) * (e * e + f * f)
        a, b, _, _ = on_axis(w.plant.bottom, n, x)
        e, f, _, _ = on_axis(w.law.den, c, x)
        size = over / ((a * a + b * b) * (e * e + f * f))
        if size >= 1.0:
            last = x
        if abs(log(size)) < least:
            nearest, least = x, abs(log(size))
    return last if last > 0.0 else nearest


@compiled
def closed(w: Work, n: int, c: int, delay: int, x: float) -> int:
    """Write the loop in u = p/x; return its degree."""
    degree = times(w.plant.top, n, w.law.num, c, w.num)
    times(w.plant.bottom, n, w.law.den, c, w.den)
    for _ in range(delay):
        for k in range(degree + 1, 0, -1):
            w.num[k] = (w.num[k] if k <= degree else 0.0) - w.num[k - 1]
            w.den[k] = (w.den[k] if k <= degree else 0.0) + w.den[k - 1]
        degree += 1
    power = 1.0
    for k in range(1, degree + 1):
        power *= x
        w.num[k] *= power
        w.den[k] *= power
    return degree


def _stretch(of: int) -> Callable[..., None]:
    """Return the function that is kept on disk, ``of`` this state of the folder."""

    @kept
    def stretch(
        w: Work, code: int, order: int, reference: float, num: Array, den: Array, dt: Array,
        delay: npt.NDArray[np.int64], lead: Array, wc: Array, pm_deg: Array, spare: Array,
        pole: Array, first: int, end: int, gains: Array, margin: Array, step: Array,
        reason: npt.NDArray[np.int8], left: npt.NDArray[np.bool_],
    ) -> None:  # fmt: skip
        """Write gains, figures and reasons of the loops from first to end, a row a loop.

        left  what is not regular comes in True; what floats cannot decide goes out True
        """
        if of < 0:
            return
        own, plants, out, why = (
            bare(w),
            bare((num, den)),
            bare((gains, margin, step)),
            bare((reason,)),
        )
        for i in range(first, end):
            if not left[i]:
                left[i] = one(own, code, order, reference, plants[0], plants[1], dt[i], delay[i],
                              lead[i], wc[i], pm_deg[i], spare[i], pole[i], i, out[0][i],
                              out[1][i], out[2][i], why[0])  # fmt: skip

    return stretch


stretch = _stretch(stamp())

__all__ = ["GAINS", "made", "stretch"]
