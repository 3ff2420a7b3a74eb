"""The metrics of one step response; see ``zoh.batch.steps``, the arithmetic of which this is.

What a long stride meets is closed in on at once, from the sample before.
"""

from math import ceil, inf, log, nan

import numpy as np

from zoh.batch.compiled.between import Pieces, crest, estimate
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.motion import SIZE, Motion
from zoh.batch.compiled.plant import Plant
from zoh.batch.rows import Array

_LOST = 2e-9
_TURN = 0.25
_BAND, _NEAR, _CREST = 0.02, 0.9, 0.98
_BLOCK = 32
_QUIET = log(1e8)
_NOTHING = 1e-10
_LEVELS, _MOST = 40, 4096

# places of what is seen
(
    TOP, K_TOP, BOTTOM, MOST_U, LEAST_U, K_10, K_90, K_OUT, HIGHEST, WHEN, CREST, K_CREST, PIECE,
    Y1, Y2, U1, U2, K1, K2,
) = range(19)  # fmt: skip
SEEN = 19
# places of the figures
(
    OVERSHOOT, RISE, SETTLING, PEAK, PEAK_TIME, ERROR, EFFORT, BETWEEN_OVERSHOOT, BETWEEN_TIME,
) = range(9)  # fmt: skip
FIGURES = 9

# places of the states that are kept
_Z, _NEXT, _LAST, _BEFORE, _AT_CREST, _FOUND, _THERE = range(7)


def ladder() -> Array:
    """Return the array of the doublings of delta."""
    return np.zeros((_LEVELS + 1, SIZE, SIZE))


def states() -> Array:
    """Return the array of the states that are kept."""
    return np.zeros((8, SIZE))


@compiled
def along(row: Array, z: Array, size: int) -> float:
    """Return row z."""
    total = 0.0
    for j in range(size):
        total += row[j] * z[j]
    return total


@compiled
def move(s: Array, z: Array, size: int, out: Array) -> None:
    """Write z + s z; the one at the end of z stays."""
    for i in range(size - 1):
        total = z[i]
        for j in range(size):
            total += s[i, j] * z[j]
        out[i] = total
    out[size - 1] = z[size - 1]


@compiled
def twice(s: Array, size: int, out: Array) -> None:
    """Write 2 s + s s."""
    for i in range(size):
        for k in range(size):
            total = 2.0 * s[i, k]
            for j in range(size):
                total += s[i, j] * s[j, k]
            out[i, k] = total


@compiled
def last(
    row: Array, factor: float, above: float, ladder: Array, level: int, zs: Array, start: int,
    k: float, end: float, size: int,
) -> float:  # fmt: skip
    """Return the last sample before ``end`` up to which factor row z > above; z into _FOUND."""
    found, there = zs[_FOUND], zs[_THERE]
    for j in range(size):
        found[j] = zs[start, j]
    for step in range(level, -1, -1):
        length = 2.0**step
        if k + length < end:
            move(ladder[step], found, size, there)
            if factor * along(row, there, size) > above:
                k += length
                for j in range(size):
                    found[j] = there[j]
    return k


@compiled
def step_metrics(
    m: Motion, p: Plant, pieces: Pieces, count: int, n: int, order: int, size: int, slowest: float,
    dt: float, reference: float, ladder: Array, zs: Array, seen: Array, out: Array,
) -> bool:  # fmt: skip
    """Write the metrics; return whether the loop had better be measured by itself."""
    final, at_rest = m.numbers[0], m.numbers[1]
    sign = -1.0 if final < 0.0 else 1.0
    full = abs(final)
    if not 0.0 < full < inf:
        return True
    start(seen)
    for j in range(size):
        zs[_Z, j] = 0.0
    zs[_Z, size - 1] = 1.0
    for i in range(size):
        for j in range(size):
            ladder[0, i, j] = m.delta[i, j]
    slowest = max(slowest, 1e-14)
    end = max(8.0, ceil(_QUIET / slowest) + 4.0 * size)
    k, level, done, lost = 0.0, 0, False, True
    while level < _LEVELS:
        twice(ladder[level], size, ladder[level + 1])
        for _ in range(_MOST // _BLOCK):
            if level == 0:
                every_sample(m, pieces, count, ladder, zs, seen, sign, full, k, size)
            else:
                lost_crest = long_stride(
                    m, p, pieces, count, n, ladder, level, zs, seen, sign, full, k, size
                )
                if lost_crest:
                    return True
            k += _BLOCK * 2.0**level
            done, turning = look(m, zs, seen, sign, full, at_rest, order, size)
            if done or k > end:
                lost = False
                break
            if turning * 2.0 * 2.0**level <= _TURN:
                lost = False
                break
        if lost or done or k > end:
            break
        level, lost = level + 1, True
    if lost:
        return True
    unknown = closing(p, pieces, count, n, zs, seen, sign, size)
    figures(seen, full, final, at_rest, sign, dt, reference, out)
    return unknown


@compiled
def start(seen: Array) -> None:
    """Forget what was seen."""
    for i in range(SEEN):
        seen[i] = -1.0
    seen[TOP], seen[BOTTOM], seen[MOST_U], seen[LEAST_U] = -inf, inf, -inf, inf
    seen[HIGHEST], seen[CREST] = -inf, -inf


@compiled
def every_sample(
    m: Motion, pieces: Pieces, count: int, ladder: Array, zs: Array, seen: Array, sign: float,
    full: float, k: float, size: int,
) -> None:  # fmt: skip
    """Look at a block of samples, one by one."""
    z, following, s = zs[_Z], zs[_NEXT], ladder[0]
    top, bottom, most, least = seen[TOP], seen[BOTTOM], seen[MOST_U], seen[LEAST_U]
    for i in range(_BLOCK):
        y = sign * along(m.output, z, size)
        u = along(m.effort, z, size)
        if y > top:
            if top < 0.9 * full:
                if top < 0.1 * full <= y:
                    seen[K_10] = k + i
                if y >= 0.9 * full:
                    seen[K_90] = k + i
            top, seen[K_TOP] = y, k + i
        bottom = min(bottom, y)
        most, least = max(most, u), min(least, u)
        if abs(y - full) > _BAND * full:
            seen[K_OUT] = k + i
        for piece in range(count):
            slope0 = sign * along(pieces.slope0[piece], z, size)
            slope1 = sign * along(pieces.slope1[piece], z, size)
            if slope0 > 0.0 > slope1:
                note_crest(pieces, piece, zs, seen, sign, k + i, slope0, slope1, size)
            if piece + 1 < count:
                corner = sign * along(pieces.y1[piece], z, size)
                if corner > seen[CREST]:
                    keep_crest(zs, seen, corner, k + i, piece + 0.5, size)
        if i >= _BLOCK - 2:
            pass_on(zs, seen, y, u, k + i, size)
        move(s, z, size, following)
        for j in range(size):
            z[j] = following[j]
    seen[TOP], seen[BOTTOM], seen[MOST_U], seen[LEAST_U] = top, bottom, most, least


@compiled
def pass_on(zs: Array, seen: Array, y: float, u: float, k: float, size: int) -> None:
    """Make the sample looked at the last one, and the last one the one before."""
    seen[Y1], seen[Y2], seen[U1], seen[U2], seen[K1], seen[K2] = y, seen[Y1], u, seen[U1], k, seen[K1]
    for j in range(size):
        zs[_BEFORE, j], zs[_LAST, j] = zs[_LAST, j], zs[_Z, j]


@compiled
def note_crest(
    pieces: Pieces, piece: int, zs: Array, seen: Array, sign: float, k: float, slope0: float,
    slope1: float, size: int,
) -> None:  # fmt: skip
    """Keep a crest that is about the highest."""
    span = pieces.ends[piece + 1] - pieces.ends[piece]
    y0 = sign * along(pieces.y0[piece], zs[_Z], size)
    y1 = sign * along(pieces.y1[piece], zs[_Z], size)
    height = estimate(y0, y1, slope0 * span, slope1 * span)
    if height > seen[CREST]:
        keep_crest(zs, seen, height, k, float(piece), size)


@compiled
def keep_crest(
    zs: Array, seen: Array, height: float, k: float, piece: float, size: int
) -> None:
    """Keep where a crest is, and Z before it."""
    seen[CREST], seen[K_CREST], seen[PIECE] = height, k, piece
    for j in range(size):
        zs[_AT_CREST, j] = zs[_Z, j]


@compiled
def long_stride(
    m: Motion, p: Plant, pieces: Pieces, count: int, n: int, ladder: Array, level: int, zs: Array,
    seen: Array, sign: float, full: float, k: float, size: int,
) -> bool:  # fmt: skip
    """Look at a block at a stride of 2^level; return whether a crest between is not known."""
    stride, unknown = 2.0**level, False
    z = zs[_Z]
    for i in range(_BLOCK):
        here = k + i * stride
        y, u = sign * along(m.output, z, size), along(m.effort, z, size)
        y1, y2, u1, u2 = seen[Y1], seen[Y2], seen[U1], seen[U2]
        before, start = seen[K1], seen[K2]
        if seen[TOP] < 0.1 * full <= y:
            seen[K_10] = 1.0 + last(m.output, -sign, -0.1 * full, ladder, level, zs, _LAST, before,
                                    here, size)  # fmt: skip
        if seen[TOP] < 0.9 * full <= y:
            seen[K_90] = 1.0 + last(m.output, -sign, -0.9 * full, ladder, level, zs, _LAST, before,
                                    here, size)  # fmt: skip
        side = 1.0 if y1 > full else -1.0
        off1, off2 = side * (y1 - full), side * (y2 - full)
        if off1 > _BAND * full >= abs(y - full):
            seen[K_OUT] = last(m.output, side * sign, (_BAND + side) * full, ladder, level, zs,
                               _LAST, before, here, size)  # fmt: skip
        if y1 >= y2 and y1 > y and y1 > seen[TOP] - 0.02 * full:
            lost = crest_of_y(
                m, p, pieces, count, n, ladder, level, zs, seen, sign, start, here, size
            )
            unknown = unknown or lost
        if off1 >= off2 and off1 > side * (y - full) and off1 > _CREST * _BAND * full:
            crest_of_band(m, ladder, level, zs, seen, sign, full, side, start, here, size)
        for way in (1.0, -1.0):
            place = MOST_U if way > 0.0 else LEAST_U
            if way * (u1 - u2) >= 0.0 and way * (u1 - u) > 0.0 and (
                way * u1 > way * seen[place] - 0.02 * abs(u1)
            ):
                last(m.effort_moves, way, 0.0, ladder, level + 1, zs, _BEFORE, start, here, size)
                move(ladder[0], zs[_FOUND], size, zs[_THERE])
                seen[place] = way * max(way * seen[place], way * along(m.effort, zs[_THERE], size))
        if y > seen[TOP]:
            seen[TOP], seen[K_TOP] = y, here
        seen[BOTTOM] = min(seen[BOTTOM], y)
        seen[MOST_U], seen[LEAST_U] = max(seen[MOST_U], u), min(seen[LEAST_U], u)
        if abs(y - full) > _BAND * full:
            seen[K_OUT] = here
        pass_on(zs, seen, y, u, here, size)
        move(ladder[level], z, size, zs[_NEXT])
        for j in range(size):
            z[j] = zs[_NEXT, j]
    return unknown


@compiled
def crest_of_y(
    m: Motion, p: Plant, pieces: Pieces, count: int, n: int, ladder: Array, level: int, zs: Array,
    seen: Array, sign: float, k: float, end: float, size: int,
) -> bool:  # fmt: skip
    """Close in on a crest, also between the samples; return whether that is not known."""
    k = last(m.output_moves, sign, 0.0, ladder, level + 1, zs, _BEFORE, k, end, size)
    unknown = False
    for shift in range(2):
        for piece in range(count):
            height, after, known = crest(p, pieces, piece, n, zs[_FOUND], sign, size)
            unknown = unknown or not known
            if piece + 1 < count:
                corner = sign * along(pieces.y1[piece], zs[_FOUND], size)
                if corner > height:
                    height, after = corner, pieces.ends[piece + 1]
            if height > seen[HIGHEST]:
                seen[HIGHEST], seen[WHEN] = height, k + shift + after
        if shift == 0:
            move(ladder[0], zs[_FOUND], size, zs[_THERE])
            y = sign * along(m.output, zs[_THERE], size)
            if y > seen[TOP]:
                seen[TOP], seen[K_TOP] = y, k + 1.0
            for j in range(size):
                zs[_FOUND, j] = zs[_THERE, j]
    return unknown


@compiled
def crest_of_band(
    m: Motion, ladder: Array, level: int, zs: Array, seen: Array, sign: float, full: float,
    side: float, k: float, end: float, size: int,
) -> None:  # fmt: skip
    """Note where the band is left for less than a stride."""
    k = last(m.output_moves, side * sign, 0.0, ladder, level + 1, zs, _BEFORE, k, end, size)
    move(ladder[0], zs[_FOUND], size, zs[_THERE])
    if side * (sign * along(m.output, zs[_THERE], size) - full) > _BAND * full:
        for j in range(size):
            zs[7, j] = zs[_THERE, j]
        seen[K_OUT] = last(m.output, side * sign, (_BAND + side) * full, ladder, level + 1, zs, 7,
                           k + 1.0, end, size)  # fmt: skip


@compiled
def look(
    m: Motion, zs: Array, seen: Array, sign: float, full: float, at_rest: float, order: int,
    size: int,
) -> tuple[bool, float]:  # fmt: skip
    """Return (whether nothing new can be seen, how fast what is left still turns)."""
    a, b = zs[_FOUND], zs[_THERE]
    for j in range(size):
        a[j] = zs[_Z, j]
    dy, du = zs[_NEXT], zs[7]
    for i in range(order):
        dy[i] = sign * along(m.output, a, size) - (0.0 if i else full)
        du[i] = along(m.effort, a, size) - (0.0 if i else at_rest)
        if i + 1 < order:
            for r in range(size - 1):
                total = 0.0
                for j in range(size):
                    total += m.delta[r, j] * a[j]
                b[r] = total
            b[size - 1] = 0.0
            for j in range(size):
                a[j] = b[j]
    reach = _LOST * max(abs(seen[MOST_U]), abs(seen[LEAST_U]))
    of_y = of_u = slow_y = slow_u = fast_y = fast_u = turning = 0.0
    for i in range(order):
        yr = yi = ur = ui = 0.0
        for k in range(order):
            yr += m.wr[i, k] * dy[k]
            yi += m.wi[i, k] * dy[k]
            ur += m.wr[i, k] * du[k]
            ui += m.wi[i, k] * du[k]
        size_y, size_u = (yr * yr + yi * yi) ** 0.5, (ur * ur + ui * ui) ** 0.5
        of_y, of_u = of_y + size_y, of_u + size_u
        if m.creeping[i] > 0.0:
            slow_y, slow_u = slow_y + yr, slow_u + ur
        else:
            fast_y, fast_u = fast_y + size_y, fast_u + size_u
        if not (size_y <= _LOST * full and size_u <= reach):
            turning = max(turning, m.turn[i])
    still = of_y < _NEAR * _BAND * full
    higher = 0.0 if fast_y <= -slow_y else fast_y + max(slow_y, 0.0)
    still = still and (higher <= seen[TOP] - full or of_y <= _LOST * full)
    higher = 0.0 if fast_u <= -slow_u else fast_u + max(slow_u, 0.0)
    lower = 0.0 if fast_u <= slow_u else fast_u + max(-slow_u, 0.0)
    fits = at_rest + higher <= seen[MOST_U] and at_rest - lower >= seen[LEAST_U]
    return still and (of_u <= reach or fits), turning


@compiled
def closing(
    p: Plant, pieces: Pieces, count: int, n: int, zs: Array, seen: Array, sign: float, size: int
) -> bool:
    """Close the account between samples; return whether a crest is not known."""
    unknown = False
    if seen[PIECE] >= 0.0:
        piece = int(seen[PIECE])
        if seen[PIECE] == piece:
            height, after, known = crest(p, pieces, piece, n, zs[_AT_CREST], sign, size)
            unknown = not known
        else:
            height, after = seen[CREST], pieces.ends[piece + 1]
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
    out[OVERSHOOT] = 100.0 * over if over > _NOTHING else 0.0
    out[RISE] = (seen[K_90] - seen[K_10]) * dt
    out[SETTLING] = (seen[K_OUT] + 1.0) * dt
    out[PEAK] = max(seen[TOP], full) * abs(reference)
    out[PEAK_TIME] = seen[K_TOP] * dt if over > _NOTHING else nan
    out[ERROR] = (1.0 - final) * reference
    out[EFFORT] = max(max(seen[MOST_U], at_rest), -min(seen[LEAST_U], at_rest)) * abs(reference)
    out[BETWEEN_OVERSHOOT] = 100.0 * beyond if beyond > _NOTHING else 0.0
    out[BETWEEN_TIME] = seen[WHEN] * dt if beyond > _NOTHING else nan
