"""A block of samples, every one looked at."""

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.between import crest, doubtful, estimate
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.masks import (
    above,
    at_least,
    below,
    first_of,
    highest,
    last_of,
    lowest,
    outside,
)
from zoh.batch.compiled.room import BLOCK, PAST, Pieces
from zoh.batch.compiled.track import (
    FALL,
    HIGHEST,
    K1,
    K2,
    K_10,
    K_90,
    K_OUT,
    K_TOP,
    LEAST_U,
    MOST_U,
    NEXT,
    RISE,
    TOP,
    UNKNOWN,
    WHEN,
    U,
    Y,
    along,
    product,
    take,
)
from zoh.batch.tolerances import BAND

_END = PAST + BLOCK
_ABOVE = 0.15  # a cubic is above its ends by 4/27 of its slopes' difference at most


@compiled
def shown(row: Array, factor: float, block: Array, place: int, size: int) -> None:
    """Write factor row Z of a block's samples."""
    product(row, factor, block, PAST, _END, size, block[place])


@compiled
def note(y: Array, u: Array, seen: Array, full: float, k: float, stride: float) -> None:
    """Note what the samples of a block show by themselves; k is the first one's."""
    top, far = highest(y, PAST), outside(y, PAST, full, BAND * full)
    if top > seen[TOP]:
        if seen[TOP] < 0.1 * full <= top:
            seen[K_10] = k + stride * first_of(at_least(y, PAST, 0.1 * full))
        if seen[TOP] < 0.9 * full <= top:
            seen[K_90] = k + stride * first_of(at_least(y, PAST, 0.9 * full))
        seen[TOP], seen[K_TOP] = top, k + stride * first_of(at_least(y, PAST, top))
    seen[MOST_U] = max(seen[MOST_U], highest(u, PAST))
    seen[LEAST_U] = min(seen[LEAST_U], lowest(u, PAST))
    if far:
        seen[K_OUT] = k + stride * last_of(far)
    seen[K1], seen[K2] = k + stride * (BLOCK - 1), k + stride * (BLOCK - 2)


@compiled
def every_sample(w: int, count: int, n: int, sign: float, full: float, k: float, size: int) -> None:
    """Look at a block of samples, one by one."""
    t = work.track(w)
    if n == 2 and count == 1 and work.plant(w).markov[0] == 0.0:
        if size == 4:  # of the usual sizes the compiler knows every place beforehand
            steady(w, sign, full, k, 4)
        elif size == 5:
            steady(w, sign, full, k, 5)
        else:
            steady(w, sign, full, k, size)
        return
    signals(w, sign, size)
    note(t.block[Y], t.block[U], t.seen, full, k, 1.0)
    if n <= 2:
        in_pieces(w, count, n, sign, full, k, size)
    elif count == 2:  # a crest is looked for wherever one may hide: see ``turns``
        corners(work.pieces(w), 0, t.block, t.seen, sign, k, size)


@compiled
def signals(w: int, sign: float, size: int) -> None:
    """Write what a block shows: output and effort."""
    m, block = work.motion(w), work.track(w).block
    for i in range(PAST, _END):
        block[Y, i] = sign * block[0, i]
    shown(m.effort, 1.0, block, U, size)


@compiled
def steady(w: int, sign: float, full: float, k: float, size: int) -> None:
    """Look at a block where the input is held over whole samples and y's slope is the second state.

    A piece is a sample then, and at its end y and its slope are what they are at the next one.
    """
    t, part = work.track(w), sign * work.pieces(w).slope0[0, 1]
    block, y, slope, seen = t.block, t.block[Y], t.block[1], t.seen
    reach = work.plant(w).numbers[1]
    signals(w, sign, size)
    note(y, block[U], seen, full, k, 1.0)
    rises, falls = above(slope, PAST, 0.0), below(slope, PAST, 0.0)
    if part < 0.0:
        rises, falls = falls, rises
    found = rises & (falls >> 1 | int(part * slope[_END] < 0.0) << (BLOCK - 1))  # at the next one
    while found:
        i = PAST + first_of(found)
        found &= found - 1
        before, after = y[i], sign * block[0, i + 1]
        rise, fall = part * slope[i], part * slope[i + 1]
        off, best = doubtful(reach, rise - fall), max(max(seen[TOP], seen[HIGHEST]), full)
        if max(before, after) + _ABOVE * (rise - fall) + off < best:
            continue
        if estimate(before, after, rise, fall) + off >= best:
            raise_to(w, 0, 2, i, sign, k, size)


@shared
def in_pieces(w: int, count: int, n: int, sign: float, full: float, k: float, size: int) -> None:
    """Look for crests in every piece of a sample, and for corners between them."""
    pieces, t = work.pieces(w), work.track(w)
    block = t.block
    for piece in range(count):
        shown(pieces.slope0[piece], sign, block, RISE, size)
        shown(pieces.slope1[piece], sign, block, FALL, size)
        found = above(block[RISE], PAST, 0.0) & below(block[FALL], PAST, 0.0)
        while found:
            i = PAST + first_of(found)
            found &= found - 1
            if may_be(w, piece, i, sign, full, size):
                raise_to(w, piece, n, i, sign, k, size)
        if piece + 1 < count:
            corners(pieces, piece, block, t.seen, sign, k, size)


@compiled
def may_be(w: int, piece: int, i: int, sign: float, full: float, size: int) -> bool:
    """Return whether the crest in a piece of a sample may be the highest so far."""
    pieces, t = work.pieces(w), work.track(w)
    there, span = t.states[NEXT], pieces.ends[piece + 1] - pieces.ends[piece]
    take(t.block, i, size, there)
    y0, y1 = along(pieces.y0[piece], there, size), along(pieces.y1[piece], there, size)
    rise, fall = t.block[RISE, i] * span, t.block[FALL, i] * span
    height = estimate(sign * y0, sign * y1, rise, fall)
    off = doubtful(work.plant(w).numbers[1] * span, rise - fall)
    return bool(height + off >= max(max(t.seen[TOP], t.seen[HIGHEST]), full))


@compiled
def raise_to(w: int, piece: int, n: int, i: int, sign: float, k: float, size: int) -> None:
    """Raise the highest between samples to the crest in a piece of a sample."""
    t = work.track(w)
    there, seen = t.states[NEXT], t.seen
    take(t.block, i, size, there)
    height, after, known = crest(w, piece, n, there, sign, size)
    if not known:
        seen[UNKNOWN] = 1.0
    if height > seen[HIGHEST]:
        seen[HIGHEST], seen[WHEN] = height, k + (i - PAST) + after


@compiled
def corners(
    pieces: Pieces, piece: int, block: Array, seen: Array, sign: float, k: float, size: int
) -> None:
    """Raise the highest between samples to the corner between two parts of one."""
    shown(pieces.y1[piece], sign, block, RISE, size)
    height = highest(block[RISE], PAST)
    if height > seen[HIGHEST]:
        i = PAST + first_of(at_least(block[RISE], PAST, height))
        seen[HIGHEST], seen[WHEN] = height, k + (i - PAST) + pieces.ends[piece + 1]
