"""The metrics of one step response; see ``zoh.batch.arrays.steps``, its arithmetic.

What a long stride meets is closed in on at once, from the sample before.
"""

from math import ceil, inf, nan, sqrt

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
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
from zoh.batch.compiled.room import BLOCK, LANES, PAST, ROOM, WIDE
from zoh.batch.compiled.samples import every_sample
from zoh.batch.compiled.strides import long_stride
from zoh.batch.compiled.track import (
    FOUND,
    HIGHEST,
    K_10,
    K_90,
    K_OUT,
    K_TOP,
    LEAST_U,
    MOST_U,
    NEXT,
    OTHER,
    THERE,
    TOP,
    UNKNOWN,
    WHEN,
    ahead,
    along,
    first_ones,
    go_on,
    product,
    start,
)
from zoh.batch.compiled.turns import suspected
from zoh.batch.tolerances import BAND, FAINT, FAR, LEVELS, LOST, NEAR, NOTHING, QUIET, ROUGH, TURN

_NEXT = PAST + BLOCK  # the column of the sample after a block
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
    rough = n > 1 and work.plant(w).markov[0] != 0.0  # any sample may have a crest: all are seen
    while level < LEVELS:
        first_ones(w, level, size)
        for _ in range(FAR // BLOCK):
            ahead(w, level, size)
            if level == 0:
                every_sample(w, count, n, sign, full, k, size)
                if n > 2 and suspected(w, count, n, sign, full, k, size):
                    return True
            elif long_stride(w, count, n, level, sign, full, k, size):
                return True
            k += BLOCK * stride
            if k < _CLOSE and too_early(w, sign, full):
                go_on(work.track(w).block, size)
                continue
            done, turning = look(w, sign, full, at_rest, order, size)
            if done or k > end:
                lost = False
                break
            go_on(work.track(w).block, size)
            if rough:
                if k >= ROUGH:
                    return True
            elif turning * 2.0 * stride <= TURN and k >= _CLOSE:
                lost = False
                break
        if lost or done or k > end:
            break
        level, stride, lost = level + 1, 2.0 * stride, True
    if lost:
        return True
    seen = work.track(w).seen
    unknown = closing(seen)
    figures(seen, full, final, at_rest, sign, dt, reference, out)
    return unknown


@compiled
def begin(w: int, size: int) -> None:
    """Write Z before the step."""
    t = work.track(w)
    start(t.seen)
    for j in range(size):
        t.block[j, PAST] = work.motion(w).start[j]
    for i in range(ROOM):
        t.block[size - 1, i] = 1.0


@compiled
def too_early(w: int, sign: float, full: float) -> bool:
    """Return whether no look can end well: at one of the next samples the modes add up to as much.

    They are as large now at least, for each of them only falls.
    """
    y, out = work.track(w).block[0], 0
    for i in range(_NEXT, _NEXT + LANES):
        out |= int(abs(sign * y[i] - full) >= NEAR * BAND * full)
    return out != 0


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
    m, seen = work.motion(w), work.track(w).seen
    parted(w, sign, full, at_rest, order, size)
    zs, shares = work.track(w).states, m.shares
    sizes_y, sizes_u = zs[FOUND], zs[THERE]
    for i in range(order):
        sizes_y[i] = sqrt(shares[0, i] * shares[0, i] + shares[1, i] * shares[1, i])
        sizes_u[i] = sqrt(shares[2, i] * shares[2, i] + shares[3, i] * shares[3, i])
    reach = LOST * max(abs(seen[MOST_U]), abs(seen[LEAST_U]))
    of_y = of_u = slow_y = slow_u = fast_y = fast_u = turning = 0.0
    for i in range(order):
        size_y, size_u = sizes_y[i], sizes_u[i]
        creeping, lost = m.creeping[i], size_y <= LOST * full and size_u <= reach
        of_y, of_u = of_y + size_y, of_u + size_u
        slow_y, slow_u = slow_y + creeping * shares[0, i], slow_u + creeping * shares[2, i]
        fast_y, fast_u = fast_y + (1.0 - creeping) * size_y, fast_u + (1.0 - creeping) * size_u
        turning = max(turning, 0.0 if lost else m.turn[i])
    still = of_y < NEAR * BAND * full
    higher = 0.0 if fast_y <= -slow_y else fast_y + max(slow_y, 0.0)
    still = still and (higher <= seen[TOP] - full or of_y <= NOTHING * full)
    higher = 0.0 if fast_u <= -slow_u else fast_u + max(slow_u, 0.0)
    lower = 0.0 if fast_u <= slow_u else fast_u + max(-slow_u, 0.0)
    fits = at_rest + higher <= seen[MOST_U] and at_rest - lower >= seen[LEAST_U]
    return still and (of_u <= reach or fits), turning


@compiled
def parted(w: int, sign: float, full: float, at_rest: float, order: int, size: int) -> None:
    """Write each mode's share of what is left of output and effort.

    They come from as many numbers as there are modes: what is left, what that moves by in a sample,
    what that moves by, ... The last one is had from the rows of what y and u move by.
    """
    m, t = work.motion(w), work.track(w)
    a, b, dy, du = t.states[FOUND], t.states[THERE], t.states[NEXT], t.states[OTHER]
    z, s, wide = t.block[:, _NEXT], t.ladder[0], LANES if size <= LANES else WIDE
    dy[0], du[0] = sign * z[0] - full, along(m.effort, z, size) - at_rest
    if order == 2:
        dy[1], du[1] = sign * along(m.output_moves, z, size), along(m.effort_moves, z, size)
    elif order > 2:
        product(z, 1.0, s, 0, wide, size, a)
    for i in range(1, order - 1):
        dy[i], du[i] = sign * a[0], along(m.effort, a, size)
        if i + 2 == order:
            row_y, row_u = m.output_moves, m.effort_moves
            dy[i + 1], du[i + 1] = sign * along(row_y, a, size), along(row_u, a, size)
        else:
            product(a, 1.0, s, 0, wide, size, b)
            a, b = b, a
    shares, ends = m.shares, LANES if order <= LANES else WIDE
    product(dy, 1.0, m.wr, 0, ends, order, shares[0])
    product(dy, 1.0, m.wi, 0, ends, order, shares[1])
    product(du, 1.0, m.wr, 0, ends, order, shares[2])
    product(du, 1.0, m.wi, 0, ends, order, shares[3])


@compiled
def closing(seen: Array) -> bool:
    """Close the account between samples; return whether a crest is not known."""
    if seen[TOP] >= seen[HIGHEST]:
        seen[HIGHEST], seen[WHEN] = seen[TOP], seen[K_TOP]
    return bool(seen[UNKNOWN] > 0.0)


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
