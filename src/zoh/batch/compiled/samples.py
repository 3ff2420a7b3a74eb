"""A block of samples, looked at one by one."""

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.between import Pieces, estimate
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.motion import Motion
from zoh.batch.compiled.track import (
    AT_CREST,
    BEFORE,
    BLOCK,
    CREST,
    K1,
    K2,
    K_10,
    K_90,
    K_CREST,
    K_OUT,
    K_TOP,
    LAST,
    LEAST_U,
    MOST_U,
    NARROW,
    PIECE,
    TOP,
    U1,
    U2,
    WIDE,
    Y1,
    Y2,
    Z,
    along,
    move,
)
from zoh.batch.tolerances import BAND


@compiled
def run(s: Array, block: Array, size: int) -> None:
    """Write Z at the samples of a block, one after the other, from its first row on."""
    if size > NARROW:
        for i in range(BLOCK):
            move(s, block[i], size, block[i + 1])
        return
    for i in range(BLOCK):
        a, b, c, d = block[i, 0], block[i, 1], block[i, 2], block[i, 3]
        e, f, g, h = block[i, 4], block[i, 5], block[i, 6], block[i, 7]
        for j in range(size):
            part = block[i, j]
            a += s[j, 0] * part
            b += s[j, 1] * part
            c += s[j, 2] * part
            d += s[j, 3] * part
            e += s[j, 4] * part
            f += s[j, 5] * part
            g += s[j, 6] * part
            h += s[j, 7] * part
        block[i + 1, 0], block[i + 1, 1], block[i + 1, 2], block[i + 1, 3] = a, b, c, d
        block[i + 1, 4], block[i + 1, 5], block[i + 1, 6], block[i + 1, 7] = e, f, g, h


@compiled
def note(
    block: Array, output: Array, effort: Array, seen: Array, sign: float, full: float, k: float,
    size: int,
) -> None:  # fmt: skip
    """Note what the samples of a block show."""
    top, most, least = seen[TOP], seen[MOST_U], seen[LEAST_U]
    k_out = seen[K_OUT]
    for i in range(BLOCK):
        y = u = 0.0
        for j in range(size):
            y += output[j] * block[i, j]
            u += effort[j] * block[i, j]
        y *= sign
        if y > top:
            if top < 0.9 * full:
                if top < 0.1 * full <= y:
                    seen[K_10] = k + i
                if y >= 0.9 * full:
                    seen[K_90] = k + i
            top, seen[K_TOP] = y, k + i
        most, least = max(most, u), min(least, u)
        if abs(y - full) > BAND * full:
            k_out = k + i
        if i >= BLOCK - 2:
            seen[Y2], seen[U2], seen[K2] = seen[Y1], seen[U1], seen[K1]
            seen[Y1], seen[U1], seen[K1] = y, u, k + i
    seen[TOP], seen[MOST_U], seen[LEAST_U] = top, most, least
    seen[K_OUT] = k_out


@compiled
def every_sample(
    m: Motion, pieces: Pieces, count: int, n: int, s: Array, block: Array, zs: Array, seen: Array,
    sign: float, full: float, k: float, size: int,
) -> None:  # fmt: skip
    """Look at a block of samples, one by one."""
    for j in range(WIDE):
        block[0, j] = zs[Z, j]
    run(s, block, size)
    note(block, m.output, m.effort, seen, sign, full, k, size)
    if count == 1 and n > 1 and pieces.input_slope[0] == 0.0:  # y' is a state then
        for i in range(BLOCK):
            if sign * block[i, 1] > 0.0 > sign * block[i + 1, 1]:
                note_crest(pieces, 0, block[i], zs, seen, sign, k + i, size)
    elif n:
        for piece in range(count):
            for i in range(BLOCK):
                rising = sign * along(pieces.slope0[piece], block[i], size) > 0.0
                if rising and sign * along(pieces.slope1[piece], block[i], size) < 0.0:
                    note_crest(pieces, piece, block[i], zs, seen, sign, k + i, size)
                if piece + 1 < count:
                    corner = sign * along(pieces.y1[piece], block[i], size)
                    if corner > seen[CREST]:
                        keep_crest(block[i], zs, seen, corner, k + i, piece + 0.5, size)
    for j in range(WIDE):
        zs[BEFORE, j], zs[LAST, j] = block[BLOCK - 2, j], block[BLOCK - 1, j]
        zs[Z, j] = block[BLOCK, j]


@compiled
def note_crest(
    pieces: Pieces, piece: int, z: Array, zs: Array, seen: Array, sign: float, k: float, size: int
) -> None:
    """Keep a crest that is about the highest."""
    span = pieces.ends[piece + 1] - pieces.ends[piece]
    y0, y1 = sign * along(pieces.y0[piece], z, size), sign * along(pieces.y1[piece], z, size)
    slope0 = sign * along(pieces.slope0[piece], z, size)
    slope1 = sign * along(pieces.slope1[piece], z, size)
    height = estimate(y0, y1, slope0 * span, slope1 * span)
    if height > seen[CREST]:
        keep_crest(z, zs, seen, height, k, float(piece), size)


@compiled
def keep_crest(
    z: Array, zs: Array, seen: Array, height: float, k: float, piece: float, size: int
) -> None:
    """Keep where a crest is, and Z before it."""
    seen[CREST], seen[K_CREST], seen[PIECE] = height, k, piece
    for j in range(size):
        zs[AT_CREST, j] = z[j]
