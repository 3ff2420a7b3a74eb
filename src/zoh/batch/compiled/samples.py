"""A block of samples, every one looked at."""

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.between import estimate
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.room import BLOCK, LANES, PAST, Pieces
from zoh.batch.compiled.track import (
    AT_CREST,
    CREST,
    FALL,
    K1,
    K2,
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
    RISE,
    TOP,
    U,
    Y,
    along,
    product,
    take,
)
from zoh.batch.tolerances import BAND

_END = PAST + BLOCK


@compiled
def shown(row: Array, factor: float, block: Array, place: int, size: int) -> None:
    """Write factor row Z of a block's samples."""
    product(row, factor, block, PAST, _END, size, block[place])


@compiled
def note(y: Array, u: Array, zs: Array, seen: Array, full: float, k: float) -> None:
    """Note what the samples of a block show; k is the first one's."""
    most_y, least_y = extremes(y, zs)
    most_u, least_u = extremes(u, zs)
    if most_y > seen[TOP]:
        rises(y, seen, most_y, full, k)
    seen[MOST_U], seen[LEAST_U] = max(seen[MOST_U], most_u), min(seen[LEAST_U], least_u)
    if most_y - full > BAND * full or full - least_y > BAND * full:
        i = _END - 1
        while not abs(y[i] - full) > BAND * full:
            i -= 1
        seen[K_OUT] = k + (i - PAST)
    seen[K1], seen[K2] = k + (BLOCK - 1), k + (BLOCK - 2)


@compiled
def extremes(row: Array, zs: Array) -> tuple[float, float]:
    """Return the highest and the lowest that a row is in a block, found in ``LANES`` at once."""
    most, least = zs[NEXT], zs[OTHER]
    for lane in range(LANES):
        most[lane], least[lane] = row[PAST + lane], row[PAST + lane]
    for i in range(PAST + LANES, _END, LANES):
        for lane in range(LANES):
            x = row[i + lane]
            most[lane] = x if x > most[lane] else most[lane]
            least[lane] = x if x < least[lane] else least[lane]
    high, low = most[0], least[0]
    for lane in range(1, LANES):
        high = most[lane] if most[lane] > high else high
        low = least[lane] if least[lane] < low else low
    return high, low


@compiled
def rises(y: Array, seen: Array, top: float, full: float, k: float) -> None:
    """Note where the response first reaches 10 %, 90 % and its highest sample."""
    before = seen[TOP]
    if before < 0.1 * full <= top:
        seen[K_10] = k + first(y, 0.1 * full)
    if before < 0.9 * full <= top:
        seen[K_90] = k + first(y, 0.9 * full)
    seen[TOP], seen[K_TOP] = top, k + first(y, top)


@compiled
def first(row: Array, height: float) -> int:
    """Return the first sample of a block at which a row is as high; it is at one."""
    i = PAST
    while row[i] < height:
        i += 1
    return i - PAST


@compiled
def every_sample(w: int, count: int, n: int, sign: float, full: float, k: float, size: int) -> None:
    """Look at a block of samples, one by one."""
    pieces, t = work.pieces(w), work.track(w)
    block, zs, seen = t.block, t.states, t.seen
    if size == 4:  # of the usual sizes the compiler knows every place beforehand
        signals(w, n, sign, 4)
    elif size == 5:
        signals(w, n, sign, 5)
    else:
        signals(w, n, sign, size)
    note(block[Y], block[U], zs, seen, full, k)
    if n > 2:  # a crest is looked for wherever one may hide: see ``turns``
        if count == 2:
            corners(pieces, 0, block, zs, seen, sign, k, size)
        return
    is_state = count == 1 and work.plant(w).markov[0] == 0.0  # the slope at a piece's end is then
    for piece in range(count):  # that at the next one's start
        if piece:
            shown(pieces.slope0[piece], sign, block, RISE, size)
        if is_state:
            for i in range(PAST, _END):
                block[FALL, i] = block[RISE, i + 1]
        else:
            shown(pieces.slope1[piece], sign, block, FALL, size)
        crests(pieces, piece, block, zs, seen, sign, k, size)
        if piece + 1 < count:
            corners(pieces, piece, block, zs, seen, sign, k, size)


@compiled
def signals(w: int, n: int, sign: float, size: int) -> None:
    """Write what a block shows: output, effort, and slope, that of the next block, too."""
    m, block = work.motion(w), work.track(w).block
    for i in range(PAST, _END):
        block[Y, i] = sign * block[0, i]
    shown(m.effort, 1.0, block, U, size)
    if n <= 2:
        product(work.pieces(w).slope0[0], sign, block, PAST, _END + LANES, size, block[RISE])


@compiled
def crests(
    pieces: Pieces, piece: int, block: Array, zs: Array, seen: Array, sign: float, k: float,
    size: int,
) -> None:  # fmt: skip
    """Keep the crest that is about the highest."""
    rise, fall, there = block[RISE], block[FALL], zs[NEXT]
    span, i = pieces.ends[piece + 1] - pieces.ends[piece], PAST - 1
    while True:
        i = turning(rise, fall, i + 1)
        if i == _END:
            break
        take(block, i, size, there)
        y0, y1 = along(pieces.y0[piece], there, size), along(pieces.y1[piece], there, size)
        height = estimate(sign * y0, sign * y1, rise[i] * span, fall[i] * span)
        if height >= seen[CREST]:  # a corner's own height: the crest behind it is higher
            keep(block, zs, seen, height, i, k, float(piece), size)


@compiled
def turning(rise: Array, fall: Array, start: int) -> int:
    """Return the first sample from one on behind which there is a crest, or the block's end."""
    found = _END
    for i in range(PAST, _END):  # not left early: so many are looked at at once
        turns = int(rise[i] > 0.0) & int(fall[i] < 0.0) & int(i >= start)
        found = min(found, i if turns else _END)
    return found


@compiled
def corners(
    pieces: Pieces, piece: int, block: Array, zs: Array, seen: Array, sign: float, k: float,
    size: int,
) -> None:  # fmt: skip
    """Keep the corner between two parts of a sample, if it is about the highest."""
    shown(pieces.y1[piece], sign, block, RISE, size)
    for i in range(PAST, _END):
        if block[RISE, i] > seen[CREST]:
            keep(block, zs, seen, block[RISE, i], i, k, piece + 0.5, size)


@compiled
def keep(
    block: Array, zs: Array, seen: Array, height: float, i: int, k: float, piece: float, size: int
) -> None:
    """Keep where a crest is, and Z before it."""
    seen[CREST], seen[K_CREST], seen[PIECE] = height, k + (i - PAST), piece
    take(block, i, size, zs[AT_CREST])
