"""The metrics of one step response; see ``zoh.batch.arrays.steps``, its arithmetic.

What a long stride meets is closed in on at once, from the sample before.
"""

from math import ceil, inf, nan, sqrt

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.between import crest
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.modes import restless
from zoh.batch.compiled.places import (
    BETWEEN_OVERSHOOT,
    BETWEEN_TIME,
    EFFORT,
    ERROR,
    OVERSHOOT,
    PEAK,
    PEAK_TIME,
    RISE,
    SETTLING,
)
from zoh.batch.compiled.room import BLOCK, DOUBLINGS, LANES, PAST, ROOM, WIDE
from zoh.batch.compiled.samples import every_sample
from zoh.batch.compiled.strides import long_stride
from zoh.batch.compiled.track import (
    AT_CREST,
    CREST,
    FOUND,
    HIGHEST,
    K_10,
    K_90,
    K_CREST,
    K_OUT,
    K_TOP,
    LEAST_U,
    MOST_U,
    NEXT,
    OTHER,
    PIECE,
    THERE,
    TOP,
    WHEN,
    ahead,
    along,
    first_four,
    go_on,
    product,
    start,
    take,
    twice,
)
from zoh.batch.compiled.turns import suspected
from zoh.batch.tolerances import BAND, FAINT, FAR, LEVELS, LOST, NEAR, NOTHING, QUIET, TURN

_CLOSE = 4.0 * BLOCK  # samples looked at one by one at least: what is met there costs the least


@compiled
def step_metrics(
    w: int, count: int, n: int, order: int, size: int, slowest: float, dt: float,
    reference: float, out: Array,
) -> bool:  # fmt: skip
    """Write the metrics; return whether the loop had better be measured by itself."""
    m = work.motion(w)
    final, at_rest = m.numbers[0], m.numbers[1]
    sign = -1.0 if final < 0.0 else 1.0
    full = abs(final)
    if not FAINT <= full < inf:
        return True
    slowest = max(slowest, 1e-14)
    if restless(w, order, slowest):
        return True
    begin(w, size)
    end = max(8.0, ceil(QUIET / slowest) + 4.0 * size)
    k, stride, level, done, lost = 0.0, 1.0, 0, False, True
    while level < LEVELS:
        twice(w, level + DOUBLINGS - 1, size)
        first_four(w, level, size)
        for _ in range(FAR // BLOCK):
            ahead(w, level, size)
            if level == 0:
                every_sample(w, count, n, sign, full, k, size)
                if n > 2 and suspected(w, count, n, sign, full, k, size):
                    return True
            elif long_stride(w, count, n, level, sign, full, k, size):
                return True
            k += BLOCK * stride
            go_on(work.track(w).block, size)
            if k < _CLOSE and outside(w, sign, full):
                continue
            done, turning = look(w, sign, full, at_rest, order, size)
            slow = turning * 2.0 * stride <= TURN and k >= _CLOSE
            if done or k > end or slow:
                lost = False
                break
        if lost or done or k > end:
            break
        level, stride, lost = level + 1, 2.0 * stride, True
    if lost:
        return True
    unknown = closing(w, n, sign, size)
    figures(work.track(w).seen, full, final, at_rest, sign, dt, reference, out)
    return unknown


@compiled
def begin(w: int, size: int) -> None:
    """Write Z before the step, and how it moves by 2, 4, ... samples."""
    t = work.track(w)
    start(t.seen)
    for j in range(size):
        t.block[j, PAST] = work.motion(w).start[j]
    for i in range(ROOM):
        t.block[size - 1, i] = 1.0
    for level in range(DOUBLINGS - 1):
        twice(w, level, size)


@compiled
def outside(w: int, sign: float, full: float) -> bool:
    """Return whether the next sample is where no look can end well: the modes add up to as much."""
    y = sign * work.track(w).block[0, PAST]
    return bool(abs(y - full) >= NEAR * BAND * full)


@shared
def look(
    w: int, sign: float, full: float, at_rest: float, order: int, size: int
) -> tuple[bool, float]:
    """Return (whether nothing new can be seen, how fast what is left still turns)."""
    if order == 3 and size == 4:  # of the usual sizes the compiler knows every place beforehand
        return left(w, sign, full, at_rest, 3, 4)
    if order == 4 and size == 5:
        return left(w, sign, full, at_rest, 4, 5)
    return left(w, sign, full, at_rest, order, size)


@compiled
def left(
    w: int, sign: float, full: float, at_rest: float, order: int, size: int
) -> tuple[bool, float]:
    """Return what ``look`` does, from what is left of every mode."""
    m, t = work.motion(w), work.track(w)
    s, zs, seen = t.ladder[0], t.states, t.seen
    a, b, dy, du = zs[FOUND], zs[THERE], zs[NEXT], zs[OTHER]
    take(t.block, PAST, size, a)
    wide = LANES if size <= LANES else WIDE
    for i in range(order):
        dy[i] = sign * a[0] - (0.0 if i else full)
        du[i] = along(m.effort, a, size) - (0.0 if i else at_rest)
        if i + 1 < order:
            product(a, 1.0, s, 0, wide, size, b)
            a, b = b, a
    shares, ends = m.shares, LANES if order <= LANES else WIDE
    product(dy, 1.0, m.wr, 0, ends, order, shares[0])
    product(dy, 1.0, m.wi, 0, ends, order, shares[1])
    product(du, 1.0, m.wr, 0, ends, order, shares[2])
    product(du, 1.0, m.wi, 0, ends, order, shares[3])
    reach = LOST * max(abs(seen[MOST_U]), abs(seen[LEAST_U]))
    of_y = of_u = slow_y = slow_u = fast_y = fast_u = turning = 0.0
    for i in range(order):
        yr, yi, ur, ui = shares[0, i], shares[1, i], shares[2, i], shares[3, i]
        size_y, size_u = sqrt(yr * yr + yi * yi), sqrt(ur * ur + ui * ui)
        of_y, of_u = of_y + size_y, of_u + size_u
        if m.creeping[i] > 0.0:
            slow_y, slow_u = slow_y + yr, slow_u + ur
        else:
            fast_y, fast_u = fast_y + size_y, fast_u + size_u
        if not (size_y <= LOST * full and size_u <= reach):
            turning = max(turning, m.turn[i])
    still = of_y < NEAR * BAND * full
    higher = 0.0 if fast_y <= -slow_y else fast_y + max(slow_y, 0.0)
    still = still and (higher <= seen[TOP] - full or of_y <= NOTHING * full)
    higher = 0.0 if fast_u <= -slow_u else fast_u + max(slow_u, 0.0)
    lower = 0.0 if fast_u <= slow_u else fast_u + max(-slow_u, 0.0)
    fits = at_rest + higher <= seen[MOST_U] and at_rest - lower >= seen[LEAST_U]
    return still and (of_u <= reach or fits), turning


@compiled
def closing(w: int, n: int, sign: float, size: int) -> bool:
    """Close the account between samples; return whether a crest is not known."""
    zs, seen = work.track(w).states, work.track(w).seen
    unknown = False
    if seen[PIECE] >= 0.0:
        piece = int(seen[PIECE])
        if seen[PIECE] == piece:
            height, after, known = crest(w, piece, n, zs[AT_CREST], sign, size)
            unknown = not known
        else:
            height, after = seen[CREST], work.pieces(w).ends[piece + 1]
        if height > seen[HIGHEST]:
            seen[HIGHEST], seen[WHEN] = height, seen[K_CREST] + after
    if seen[TOP] >= seen[HIGHEST]:
        seen[HIGHEST], seen[WHEN] = seen[TOP], seen[K_TOP]
    return unknown


@compiled
def figures(
    seen: Array, full: float, final: float, at_rest: float, sign: float, dt: float,
    reference: float, out: Array,
) -> None:  # fmt: skip
    """Write the metrics."""
    over, beyond = seen[TOP] / full - 1.0, seen[HIGHEST] / full - 1.0
    out[OVERSHOOT] = 100.0 * over if over > NOTHING else 0.0
    out[RISE] = (seen[K_90] - seen[K_10]) * dt
    out[SETTLING] = (seen[K_OUT] + 1.0) * dt
    out[PEAK] = max(seen[TOP], full) * abs(reference)
    out[PEAK_TIME] = seen[K_TOP] * dt if over > NOTHING else nan
    out[ERROR] = (1.0 - final) * reference
    out[EFFORT] = max(max(seen[MOST_U], at_rest), -min(seen[LEAST_U], at_rest)) * abs(reference)
    out[BETWEEN_OVERSHOOT] = 100.0 * beyond if beyond > NOTHING else 0.0
    out[BETWEEN_TIME] = seen[WHEN] * dt if beyond > NOTHING else nan
