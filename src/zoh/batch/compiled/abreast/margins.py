"""All margins of loops side by side; see ``zoh.batch.compiled.margins``."""

from math import degrees, inf, nan, radians, sqrt

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import places, work
from zoh.batch.compiled.abreast.crossings import (
    GM,
    MARGIN,
    W_180,
    W_DROP,
    WC,
    by_drop,
    by_gain,
    by_phase,
)
from zoh.batch.compiled.abreast.room import DT, LOOPS
from zoh.batch.compiled.abreast.rows import on_axis, squared
from zoh.batch.compiled.abreast.valleys import valleys
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.quotients import LEAST, Q
from zoh.batch.tolerances import ON_IT_DEG


@compiled
def margins(w: int, n: int, degree: int) -> None:
    """Find what can be found of all lanes at once; ``fine`` is 0.0 of those that are unusual."""
    squares(w, n)
    by_gain(w, n)
    by_phase(w, n, degree)
    by_drop(w, n)
    valleys(w, n)
    sizes(w, n)


@compiled
def squares(w: int, n: int) -> None:
    """Write the squares of |num|, |den|, |num + den| and |den - num| on the axis."""
    r = work.abreast(w)
    num, den, some = r.num, r.den, r.some
    squared(num, n, r.nn)
    squared(den, n, r.dd)
    for i in range(LOOPS):
        for k in range(n + 1):
            some[k, i] = num[k, i] + den[k, i]
    squared(some, n, r.aa)
    for i in range(LOOPS):
        for k in range(n + 1):
            some[k, i] = den[k, i] - num[k, i]
    squared(some, n, r.bb)


@compiled
def sizes(w: int, n: int) -> None:
    """Write |num|, |den|, |num + den| and |den - num| where each quotient is least."""
    r = work.abreast(w)
    num, den = r.num, r.den
    for side in range(3):
        for i in range(LOOPS):
            q = r.valleys[Q, side * LOOPS + i]
            end = q == inf
            v = sqrt(1.0 if end else q)
            a, b, _, _ = on_axis(num, n, i, v)
            c, d, _, _ = on_axis(den, n, i, v)
            top, bottom = num[n, i], den[n, i]
            a, b = top if end else a, 0.0 if end else b
            c, d = bottom if end else c, 0.0 if end else d
            r.sizes[0, side * LOOPS + i] = sqrt(a * a + b * b)
            r.sizes[1, side * LOOPS + i] = sqrt(c * c + d * d)
            r.sizes[2, side * LOOPS + i] = sqrt((a + c) ** 2 + (b + d) ** 2)
            r.sizes[3, side * LOOPS + i] = sqrt((c - a) ** 2 + (d - b) ** 2)
            proved = int(r.valleys[LEAST, side * LOOPS + i] >= 0.0) & int(r.fine[i] > 0.0)
            r.fine[i] = 1.0 if proved else 0.0


@compiled
def figures(w: int, n: int, i: int, out: Array) -> bool:
    """Write the figures of lane i; return whether it is one of the usual loops."""
    r = work.abreast(w)
    if not r.fine[i] > 0.0:
        return False
    of = r.found
    pm, wc = degrees(of[MARGIN, i]), of[WC, i]
    if pm <= -180.0:
        pm = 180.0
    late = 0.0 if abs(pm) < ON_IT_DEG else radians(pm if pm > 0.0 else pm + 360.0) / wc
    out[places.PM], out[places.CROSSOVER], out[places.DELAY] = pm, wc, late
    if abs(r.num[n, i]) >= abs(r.den[n, i]):
        out[places.DELAY] = min(late, r.plant[DT, i])
    out[places.GM] = of[GM, i]
    out[places.PHASE_CROSSOVER] = of[W_180, i] if of[GM, i] < inf else nan
    den, both = r.sizes[1, i], r.sizes[2, i]
    out[places.MODULUS], out[places.MS] = both / den, den / both
    out[places.MT] = r.sizes[0, LOOPS + i] / r.sizes[2, LOOPS + i]
    out[places.DISK] = 2.0 * r.sizes[2, 2 * LOOPS + i] / r.sizes[3, 2 * LOOPS + i]
    out[places.BANDWIDTH] = of[W_DROP, i]
    return True
