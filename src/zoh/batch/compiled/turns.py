"""Samples in which a crest may hide; see ``zoh.batch.arrays.turns``.

Here they are looked at as they pass: there are few of them, and what they show rules out others.
"""

from math import inf

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.between import PARTS, crest
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.room import BLOCK, LANES, PAST, SIZE, Pieces
from zoh.batch.compiled.samples import shown
from zoh.batch.compiled.track import FALL as BEND
from zoh.batch.compiled.track import HIGHEST, NEXT, OTHER, TOP, WHEN, U, Y, take
from zoh.batch.compiled.track import RISE as CORNER
from zoh.batch.tolerances import NOTHING

_END = PAST + BLOCK


@shared
def weigh(w: int, n: int, delay: int, count: int) -> None:
    """Write what bounds the bends: the weights of Z's places, of the effort, and all at rest."""
    p, q, m = work.plant(w), work.pieces(w), work.motion(w)
    weights, rest, of_state, at_rest = q.bends, q.rest, p.matrix[0], m.numbers[1]
    for j in range(SIZE + 1):
        weights[j], rest[j] = 0.0, at_rest
    rest[0] = m.numbers[0]
    for j in range(1, n):
        rest[j] = -p.markov[j - 1] * at_rest
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
        for i in range(n):
            weights[i] = max(weights[i], left(q, of_state, piece, n, i))
        if piece:  # what the input before has left of itself
            before = n + delay - 1
            weights[before] = max(weights[before], left(q, of_state, piece, n, before))
        place = n + delay - 1 - piece if delay > piece else SIZE
        weights[place] = max(weights[place], of_input)


@compiled
def left(q: Pieces, of_state: Array, piece: int, n: int, place: int) -> float:
    """Return the weight that a place of Z has by the state at the beginning of a piece."""
    total = 0.0
    for j in range(n):
        total += of_state[j] * abs(q.state[piece, j, place])
    return total


@compiled
def suspected(
    w: int, count: int, n: int, sign: float, full: float, k: float, size: int
) -> bool:  # fmt: skip
    """Look at the samples of a block that may hide a crest; return whether one is not known."""
    q, t = work.pieces(w), work.track(w)
    block, zs, seen = t.block, t.states, t.seen
    bend, corner, y, over, there = block[BEND], block[CORNER], block[Y], zs[OTHER], zs[NEXT]
    weight, rest = q.bends[SIZE], q.rest[SIZE]
    for i in range(PAST, _END):
        bend[i] = weight * abs(block[U, i] - rest)
    for j in range(size):
        weight, rest = q.bends[j], q.rest[j]
        if weight > 0.0:
            for i in range(PAST, _END):
                bend[i] += weight * abs(block[j, i] - rest)
    if count == 2:
        shown(q.y1[0], sign, block, CORNER, size)
    else:
        for i in range(PAST, _END):
            corner[i] = y[i]
    for i in range(PAST, _END):
        after = sign * block[0, i + 1]
        high = y[i] if y[i] > after else after
        corner[i] = high if high > corner[i] else corner[i]
    for lane in range(LANES):
        over[lane] = -inf
    for i in range(PAST, _END, LANES):
        for lane in range(LANES):
            x = corner[i + lane] + bend[i + lane]
            over[lane] = x if x > over[lane] else over[lane]
    most = over[0]
    for lane in range(1, LANES):
        most = over[lane] if over[lane] > most else most
    best = max(max(seen[TOP], seen[HIGHEST]), full * (1.0 + NOTHING))
    if not most > best:
        return False
    for i in range(PAST, _END):
        if corner[i] + bend[i] > max(best, corner[i]):
            take(block, i, size, there)
            for piece in range(count):
                height, after, known = crest(w, piece, n, there, sign, size)
                if not known:
                    return True
                if height > seen[HIGHEST]:
                    seen[HIGHEST], seen[WHEN] = height, k + (i - PAST) + after
                    best = max(best, height)
    return False
