"""Where quotients of two polynomials are least, of one loop; see ``zoh.batch.arrays.peaks``."""

from math import inf, nan, sqrt

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.polynomials import at, changes, on_grid, positive_roots, without
from zoh.batch.compiled.quotients import begin, minimised, vertex
from zoh.batch.compiled.room import SIDES
from zoh.batch.tolerances import DOUBLE, GRID


@compiled
def valleys(w: int, n: int) -> None:
    """Write where aa/dd, aa/nn and aa/bb are least, and the proof."""
    lines, bulk = work.lines(w), 0.0
    for k in range(n + 1):
        bulk += abs(lines.dd[k])
    scale = 1.0 / bulk  # at q = 1 all are about as large: their products stay numbers
    for k in range(n + 1):
        lines.under[k, 0], lines.under[k, 1] = lines.dd[k] * scale, lines.nn[k] * scale
        lines.under[k, 2] = lines.bb[k] * scale
        for side in range(SIDES):
            lines.over[k, side] = lines.aa[k]
    on_grid(lines.aa, n, lines.grid[1])
    about(w, lines.dd, n, 0)
    about(w, lines.nn, n, 1)
    about(w, lines.bb, n, 2)
    minimised(lines.sides, lines.over, lines.under, n, SIDES)


@compiled
def about(w: int, b: Array, n: int, side: int) -> None:
    """Begin at the inner place of the grid where aa/b is least, or where a parabola there is.

    Row 1 of ``grid`` has aa on the grid.
    """
    lines = work.lines(w)
    over, values = lines.grid[1], lines.grid[0]
    on_grid(b, n, values)
    for j in range(len(GRID)):
        values[j] = over[j] / values[j]
    best, least = 0, inf
    for j in range(len(GRID)):
        best, least = (j, values[j]) if values[j] < least else (best, least)
    best = min(max(best, 1), len(GRID) - 2)
    top, bottom = vertex(values[best - 1], values[best], values[best + 1])
    begin(lines.sides, side, GRID[best] * top / bottom, GRID[best - 1], GRID[best + 1])


@shared
def lowest(w: int, a: Array, b: Array, n: int, q: float, inside: bool) -> tuple[float, bool]:
    """Return (v where a/b is least over q = v^2, whether in doubt), inside: if it may be at q."""
    rest = work.lines(w).rest
    value = firm(a, n, q) / firm(b, n, q)
    v = sqrt(q)
    end = a[0] / b[0]
    if end <= value * (1.0 + 1e-14):
        v, value = 0.0, end
    end = a[n] / b[n]
    if end <= value * (1.0 + 1e-14):
        v, value = inf, end
    if inside or v == 0.0 or v == inf:
        for k in range(n + 1):
            rest[k] = a[k] - value * b[k]
        degree = n
        if v == 0.0:
            rest[0] = 0.0
        elif v == inf:
            rest[n] = 0.0
        else:
            without(rest, n, q, rest)
            without(rest, n - 1, q, rest)
            degree = n - 2
        count = changes(rest, degree)
        above = at(rest, degree, 1.0) > 0.0  # with no root it is so everywhere
        if above and count == 0:
            return v, False
        if above and count % 2 == 0:
            found, doubt = positive_roots(w, rest, degree)
            if found == 0 and not doubt:
                return v, False
    return by_slopes(w, a, b, n)


@compiled
def with_bulk(a: Array, n: int, x: float) -> tuple[float, float]:
    """Return the value at x > 0, and the sum of the sizes of its terms."""
    value, bulk = a[n], abs(a[n])
    for k in range(n - 1, -1, -1):
        value, bulk = value * x + a[k], bulk * x + abs(a[k])
    return value, bulk


@compiled
def firm(a: Array, n: int, x: float) -> float:
    """Return the value at x of a square, nan where rounding may have made its first digits."""
    value, bulk = with_bulk(a, n, x)
    return value if value > DOUBLE * bulk else nan


@shared
def by_slopes(w: int, a: Array, b: Array, n: int) -> tuple[float, bool]:
    """Return (v where a/b is least, whether in doubt), every place where its slope is 0 tried."""
    rest, roots = work.lines(w).rest, work.lines(w).roots
    size = 0.0
    for k in range(2 * n):
        total = 0.0
        for i in range(max(0, k + 1 - n), min(n, k + 1) + 1):
            total += (2 * i - k - 1) * a[i] * b[k + 1 - i]
        rest[k] = total
        size = max(size, abs(total))
    degree = max(2 * n - 1, 0)
    for k in range(degree + 1):
        rest[k] /= size
    while degree > 0 and rest[degree] == 0.0:
        degree -= 1
    count, doubt = positive_roots(w, rest, degree)
    v, least = 0.0, a[0] / b[0]
    if not least >= 0.0:
        least = inf
    unsure = False
    for k in range(count):
        over, most = with_bulk(a, n, roots[k])
        under, bulk = with_bulk(b, n, roots[k])
        rounded = not (over > DOUBLE * most and under > DOUBLE * bulk)
        value = (over if over > DOUBLE * most else 0.0) / max(under, DOUBLE * bulk)
        if value < least:
            v, least, unsure = sqrt(roots[k]), value, rounded
    if a[n] / b[n] < least:
        return inf, doubt
    return v, doubt or unsure
