"""A block at a stride of many samples; what it meets is closed in on at once by halving."""

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.between import crest
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.masks import (
    above,
    at_least,
    below,
    first_of,
    higher,
    highest,
    lowest,
    outside,
)
from zoh.batch.compiled.room import BLOCK, PAST
from zoh.batch.compiled.samples import note, signals
from zoh.batch.compiled.track import (
    FOUND,
    HIGHEST,
    K1,
    K2,
    K_10,
    K_90,
    K_OUT,
    K_TOP,
    LEAST_U,
    MOST_U,
    THERE,
    TOP,
    WHEN,
    U,
    Y,
    along,
    last,
    move,
    take,
)
from zoh.batch.tolerances import BAND, BELOW, CREST


@shared
def long_stride(
    w: int, count: int, n: int, level: int, sign: float, full: float, k: float, size: int
) -> bool:
    """Look at a block at a stride of 2^level; return whether a crest between is not known."""
    t = work.track(w)
    ys, us, seen = t.block[Y], t.block[U], t.seen
    if size == 5:  # of the usual size the compiler knows every place beforehand
        signals(w, sign, 5)
    else:
        signals(w, sign, size)
    stride, found, unknown = 1.0 * (1 << level), met(ys, us, seen, full), False
    if not found:
        note(ys, us, seen, full, k, stride)
        return False
    past, past_it, noted = seen[K1], seen[K2], PAST
    while found:
        i = PAST + first_of(found)
        found &= found - 1
        passed_by(ys, us, seen, full, k, stride, noted, i)
        noted, here = i, k + (i - PAST) * stride
        before = here - stride if i > PAST else past
        start = before - stride if i > PAST + 1 else past if i > PAST else past_it
        risen(w, i, seen[TOP], ys[i], level, sign, full, before, here, size)
        settled(w, i, level, sign, full, before, here, size)
        lost = output_turns(w, count, n, i, level, sign, full, start, here, size)
        unknown = unknown or lost
        effort_turns(w, i, level, start, here, size)
    passed_by(ys, us, seen, full, k, stride, noted, PAST + BLOCK)
    seen[K1], seen[K2] = k + (BLOCK - 1) * stride, k + (BLOCK - 2) * stride
    return unknown


@compiled
def risen(
    w: int, i: int, top: float, y: float, level: int, sign: float, full: float, before: float,
    here: float, size: int,
) -> None:  # fmt: skip
    """Note where 10 % and 90 % are reached first, if they are above ``top`` and not above y.

    top  the highest sample before;  before, here  the samples between which that is
    """
    seen = work.track(w).seen
    if top < 0.1 * full <= y:
        seen[K_10] = reached(w, i, 0.1 * full, level, sign, before, here, size)
    if top < 0.9 * full <= y:
        seen[K_90] = reached(w, i, 0.9 * full, level, sign, before, here, size)


@compiled
def settled(
    w: int, i: int, level: int, sign: float, full: float, before: float, here: float, size: int
) -> None:  # fmt: skip
    """Note the last sample outside the band, if that is between column i and the one before."""
    t = work.track(w)
    y, y1 = t.block[Y, i], t.block[Y, i - 1]
    side = 1.0 if y1 > full else -1.0
    if side * (y1 - full) > BAND * full >= abs(y - full):
        take(t.block, i - 1, size, t.states[FOUND])
        t.seen[K_OUT] = last(w, work.motion(w).output, side * sign, (BAND + side) * full, level,
                             before, here, size)  # fmt: skip


@compiled
def output_turns(
    w: int, count: int, n: int, i: int, level: int, sign: float, full: float, start: float,
    here: float, size: int,
) -> bool:  # fmt: skip
    """Close in on what y does about the column before i; return whether its crest is not known."""
    t = work.track(w)
    block, found, seen, unknown = t.block, t.states[FOUND], t.seen, False
    y, y1, y2 = block[Y, i], block[Y, i - 1], block[Y, i - 2]
    if y1 >= y2 and y1 > y and y1 > seen[TOP] - BELOW * full:
        top = seen[TOP]
        take(block, i - 2, size, found)
        unknown = crest_of_y(w, count, n, level, sign, start, here, size)
        # for less than a stride, the first time
        risen(w, i - 1, top, seen[TOP], level + 1, sign, full, start, seen[K_TOP], size)
    side = 1.0 if y1 > full else -1.0
    off, off1, off2 = side * (y - full), side * (y1 - full), side * (y2 - full)
    if off1 >= off2 and off1 > off and off1 > CREST * BAND * full:
        take(block, i - 2, size, found)
        crest_of_band(w, level, sign, full, side, start, here, size)
    return unknown


@compiled
def effort_turns(w: int, i: int, level: int, start: float, here: float, size: int) -> None:
    """Close in on a crest, or in a valley, of the effort about the column before i."""
    t = work.track(w)
    block, found, seen = t.block, t.states[FOUND], t.seen
    u, u1, u2 = block[U, i], block[U, i - 1], block[U, i - 2]
    near = BELOW * abs(u1)
    if u1 >= u2 and u1 > u and u1 > seen[MOST_U] - near:
        take(block, i - 2, size, found)
        most = crest_of_u(w, level, 1.0, start, here, size)
        seen[MOST_U] = max(seen[MOST_U], most)
    elif u1 <= u2 and u1 < u and u1 < seen[LEAST_U] + near:
        take(block, i - 2, size, found)
        least = crest_of_u(w, level, -1.0, start, here, size)
        seen[LEAST_U] = min(seen[LEAST_U], least)


@compiled
def passed_by(
    ys: Array, us: Array, seen: Array, full: float, k: float, stride: float, first: int, end: int
) -> None:  # fmt: skip
    """Note what the samples from one to another show by themselves."""
    for i in range(first, end):
        y, u, here = ys[i], us[i], k + (i - PAST) * stride
        if y > seen[TOP]:
            seen[TOP], seen[K_TOP] = y, here
        seen[MOST_U], seen[LEAST_U] = max(seen[MOST_U], u), min(seen[LEAST_U], u)
        if abs(y - full) > BAND * full:
            seen[K_OUT] = here


@compiled
def met(y: Array, u: Array, seen: Array, full: float) -> int:
    """Return a mask of the samples of a block at which there may be something to be closed in on.

    That is 10 % or 90 % that are reached, an end of the band that is passed, or a sample before
    that is higher or lower than those about it, about as far as that has been seen.
    """
    before, first, band = PAST - 1, PAST, BAND * full
    found = outside(y, before, full, band) & ~outside(y, first, full, band)
    top = highest(y, first)
    if seen[TOP] < 0.1 * full <= top:
        found |= 1 << first_of(at_least(y, first, 0.1 * full))
    if seen[TOP] < 0.9 * full <= top:
        found |= 1 << first_of(at_least(y, first, 0.9 * full))
    peaks = higher(y, before, first) & ~higher(y, before - 1, before)
    valleys = higher(y, first, before) & ~higher(y, before, before - 1)
    found |= peaks & above(y, before, seen[TOP] - BELOW * full)
    found |= (peaks | valleys) & outside(y, before, full, CREST * band)
    most, least = max(seen[MOST_U], highest(u, first)), min(seen[LEAST_U], lowest(u, first))
    near = BELOW * max(abs(most), abs(least))
    peaks = higher(u, before, first) & ~higher(u, before - 1, before)
    valleys = higher(u, first, before) & ~higher(u, before, before - 1)
    found |= peaks & above(u, before, seen[MOST_U] - near)
    return found | (valleys & below(u, before, seen[LEAST_U] + near))


@shared
def reached(
    w: int, i: int, height: float, level: int, sign: float, before: float, here: float, size: int
) -> float:
    """Return the sample at which y first is as high, between the one before column i and it."""
    t = work.track(w)
    take(t.block, i - 1, size, t.states[FOUND])
    return 1.0 + last(w, work.motion(w).output, -sign, -height, level, before, here, size)


@shared
def crest_of_u(w: int, level: int, way: float, k: float, end: float, size: int) -> float:
    """Return the effort at a crest or in a valley after FOUND."""
    m, zs = work.motion(w), work.track(w).states
    last(w, m.effort_moves, way, 0.0, level + 1, k, end, size)
    move(work.track(w).ladder[0], zs[FOUND], size, zs[THERE])
    return along(m.effort, zs[THERE], size)


@shared
def crest_of_y(
    w: int, count: int, n: int, level: int, sign: float, k: float, end: float, size: int
) -> bool:
    """Close in on a crest, also between the samples; return whether that is not known."""
    m, pieces, t = work.motion(w), work.pieces(w), work.track(w)
    zs, seen = t.states, t.seen
    k = last(w, m.output_moves, sign, 0.0, level + 1, k, end, size)
    unknown = False
    for shift in range(2):
        for piece in range(count):
            height, after, known = crest(w, piece, n, zs[FOUND], sign, size)
            unknown = unknown or not known
            if piece + 1 < count:
                corner = sign * along(pieces.y1[piece], zs[FOUND], size)
                if corner > height:
                    height, after = corner, pieces.ends[piece + 1]
            if height > seen[HIGHEST]:
                seen[HIGHEST], seen[WHEN] = height, k + shift + after
        if shift == 0:
            move(t.ladder[0], zs[FOUND], size, zs[THERE])
            y = sign * zs[THERE, 0]
            if y > seen[TOP]:
                seen[TOP], seen[K_TOP] = y, k + 1.0
            for j in range(size):
                zs[FOUND, j] = zs[THERE, j]
    return unknown


@shared
def crest_of_band(
    w: int, level: int, sign: float, full: float, side: float, k: float, end: float, size: int
) -> None:
    """Note where the band is left for less than a stride."""
    m, t = work.motion(w), work.track(w)
    zs, seen = t.states, t.seen
    k = last(w, m.output_moves, side * sign, 0.0, level + 1, k, end, size)
    move(t.ladder[0], zs[FOUND], size, zs[THERE])
    if side * (sign * zs[THERE, 0] - full) > BAND * full:
        for j in range(size):
            zs[FOUND, j] = zs[THERE, j]
        row, most = m.output, (BAND + side) * full
        seen[K_OUT] = last(w, row, side * sign, most, level + 1, k + 1.0, end, size)
