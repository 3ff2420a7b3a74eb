"""A block of samples, every one looked at."""

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.between import Pieces, estimate
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.motion import Motion
from zoh.batch.compiled.track import (
    AT_CREST,
    BLOCK,
    CREST,
    FALL,
    K1,
    K2,
    K_10,
    K_90,
    K_CREST,
    K_OUT,
    K_TOP,
    LANES,
    LEAST_U,
    MOST_U,
    NEXT,
    PAST,
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
def note(y: Array, u: Array, seen: Array, full: float, k: float) -> None:
    """Note what the samples of a block show; k is the first one's."""
    top, most, least = seen[TOP], seen[MOST_U], seen[LEAST_U]
    higher = more = out = 0
    for i in range(PAST, _END):
        higher |= int(y[i] > top)
        more |= int(u[i] > most) | int(u[i] < least)
        out |= int(abs(y[i] - full) > BAND * full)
    if higher:
        rises(y, seen, full, k)
    if more:
        for i in range(PAST, _END):
            most, least = max(most, u[i]), min(least, u[i])
        seen[MOST_U], seen[LEAST_U] = most, least
    if out:
        i = _END - 1
        while not abs(y[i] - full) > BAND * full:
            i -= 1
        seen[K_OUT] = k + (i - PAST)
    seen[K1], seen[K2] = k + (BLOCK - 1), k + (BLOCK - 2)


@compiled
def rises(y: Array, seen: Array, full: float, k: float) -> None:
    """Note where the response first reaches 10 %, 90 % and its highest sample."""
    top, place = seen[TOP], -1
    for i in range(PAST, _END):
        if y[i] > top:
            if top < 0.9 * full:
                if top < 0.1 * full <= y[i]:
                    seen[K_10] = k + (i - PAST)
                if y[i] >= 0.9 * full:
                    seen[K_90] = k + (i - PAST)
            top, place = y[i], i
    seen[TOP], seen[K_TOP] = top, k + (place - PAST)


@compiled
def every_sample(
    m: Motion, pieces: Pieces, count: int, n: int, block: Array, zs: Array, seen: Array,
    sign: float, full: float, k: float, size: int,
) -> None:  # fmt: skip
    """Look at a block of samples, one by one."""
    shown(m.output, sign, block, Y, size)
    shown(m.effort, 1.0, block, U, size)
    note(block[Y], block[U], seen, full, k)
    if n == 0:
        return
    is_state = count == 1 and pieces.input_slope[0] == 0.0  # the slope at a piece's end is then
    for piece in range(count):  # that at the next one's start
        end = _END + LANES if is_state else _END
        product(pieces.slope0[piece], sign, block, PAST, end, size, block[RISE])
        if is_state:
            for i in range(PAST, _END):
                block[FALL, i] = block[RISE, i + 1]
        else:
            shown(pieces.slope1[piece], sign, block, FALL, size)
        crests(pieces, piece, block, zs, seen, sign, k, size)
        if piece + 1 < count:
            corners(pieces, piece, block, zs, seen, sign, k, size)


@compiled
def crests(
    pieces: Pieces, piece: int, block: Array, zs: Array, seen: Array, sign: float, k: float,
    size: int,
) -> None:  # fmt: skip
    """Keep the crest that is about the highest."""
    rise, fall, any_crest = block[RISE], block[FALL], 0
    for i in range(PAST, _END):
        any_crest |= int(rise[i] > 0.0) & int(fall[i] < 0.0)
    if not any_crest:
        return
    span, there = pieces.ends[piece + 1] - pieces.ends[piece], zs[NEXT]
    for i in range(PAST, _END):
        if rise[i] > 0.0 > fall[i]:
            take(block, i, size, there)
            y0, y1 = along(pieces.y0[piece], there, size), along(pieces.y1[piece], there, size)
            height = estimate(sign * y0, sign * y1, rise[i] * span, fall[i] * span)
            if height >= seen[CREST]:  # a corner's own height: the crest behind it is higher
                keep(block, zs, seen, height, i, k, float(piece), size)


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
