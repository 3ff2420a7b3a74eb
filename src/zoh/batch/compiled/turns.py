"""Samples in which a crest may hide; see ``zoh.batch.arrays.turns``.

Here they are looked at as they pass, the one with the highest bound first: what it shows rules out
the others, but for few.
"""

from math import inf

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.between import PARTS, crest
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.lanes import everywhere, plus_sizes, put, taken
from zoh.batch.compiled.masks import at_least, first_of, highest
from zoh.batch.compiled.room import BLOCK, LANES, PAST, Pieces
from zoh.batch.compiled.samples import shown
from zoh.batch.compiled.track import FALL as BOUND
from zoh.batch.compiled.track import HIGHEST, NEXT, TOP, WHEN, U, Y, take
from zoh.batch.compiled.track import RISE as CORNER
from zoh.batch.tolerances import NOTHING

_END = PAST + BLOCK
_WEIGHT, _REST, _ROW = range(3)


@shared
def weigh(w: int, n: int, delay: int, count: int) -> None:
    """Write what bounds the bends: of each state and input its weight, its rest, and its row."""
    if n == 3:  # of the usual orders the compiler knows every place beforehand
        weighed(w, 3, delay, count)
    elif n == 4:
        weighed(w, 4, delay, count)
    else:
        weighed(w, n, delay, count)


@compiled
def weighed(w: int, n: int, delay: int, count: int) -> None:
    """Do what ``weigh`` does."""
    p, q, m = work.plant(w), work.pieces(w), work.motion(w)
    bends, of_state, at_rest = q.bends, p.matrix[0], m.numbers[1]
    for j in range(n + count):
        rest = -p.markov[j - 1] * at_rest if j < n else at_rest
        row = U if j - n >= delay else n + delay - 1 - (j - n)
        bends[_WEIGHT, j], bends[_REST, j], bends[_ROW, j] = 0.0, rest, j if j < n else row
    bends[_REST, 0] = m.numbers[0]
    for piece in range(count):
        span = (q.ends[piece + 1] - q.ends[piece]) * p.numbers[0]
        weight, of_input = span * span / 8.0, 0.0
        for j in range(n):
            of_state[j] = 0.0
        for k in range(2, n + int(p.numbers[3]) + 1):
            for j in range(n):
                of_state[j] += weight * abs(p.rows[k, j])
            of_input += weight * abs(p.markov[k - 1])
            weight *= span * PARTS[k - 1]
        for i in range(n + piece):  # what the input before has left of itself, too
            place = i if i < n else n + delay - 1
            own = left(q, of_state, piece, n, place)
            bends[_WEIGHT, i] = max(bends[_WEIGHT, i], own)
        bends[_WEIGHT, n + piece] = max(bends[_WEIGHT, n + piece], of_input)


@compiled
def left(q: Pieces, of_state: Array, piece: int, n: int, place: int) -> float:
    """Return the weight that a place of Z has by the state at the beginning of a piece."""
    total = 0.0
    for j in range(n):
        total += of_state[j] * abs(q.state[piece, j, place])
    return total


@compiled
def suspected(w: int, count: int, n: int, sign: float, full: float, k: float, size: int) -> bool:
    """Look at the samples of a block that may hide a crest; return whether one is not known."""
    q, t = work.pieces(w), work.track(w)
    block, zs, seen = t.block, t.states, t.seen
    bound, there = block[BOUND], zs[NEXT]
    if n == 3:
        bent(q.bends, block, 3 + count, bound)
    else:
        bent(q.bends, block, n + count, bound)
    if count == 2:
        shown(q.y1[0], sign, block, CORNER, size)
    most = raised(block, sign, count)
    best = max(max(seen[TOP], seen[HIGHEST]), full * (1.0 + NOTHING))
    while most > best:
        i = PAST + first_of(at_least(bound, PAST, most))
        take(block, i, size, there)
        for piece in range(count):
            height, after, known = crest(w, piece, n, there, sign, size)
            if not known:
                return True
            if height > seen[HIGHEST]:
                seen[HIGHEST], seen[WHEN] = height, k + (i - PAST) + after
        best = max(best, seen[HIGHEST])
        bound[i] = -inf
        most = highest(bound, PAST)
    return False


@compiled
def bent(bends: Array, block: Array, columns: int, out: Array) -> None:
    """Write by how much y may be above its corners within each sample of a block."""
    for i in range(PAST, _END, LANES):
        total = everywhere(0.0)
        for j in range(columns):
            at = taken(block[int(bends[_ROW, j])], i)
            total = plus_sizes(total, bends[_WEIGHT, j], at, bends[_REST, j])
        put(total, out, i)


@compiled
def raised(block: Array, sign: float, count: int) -> float:
    """Add the highest corner of each sample to its bound; return the highest bound."""
    bound, corner, y = block[BOUND], block[CORNER], block[Y]
    for i in range(PAST, _END):
        after = sign * block[0, i + 1]
        high = y[i] if y[i] > after else after
        if count == 2:
            high = corner[i] if corner[i] > high else high
        bound[i] += high
    return highest(bound, PAST)
