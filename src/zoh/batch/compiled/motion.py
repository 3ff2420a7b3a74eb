"""The motion of one closed loop; see ``zoh.batch.arrays.motion``."""

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import work
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.room import LATE, WHOLE, WIDE


@compiled
def closed(w: int, n: int, c: int, delay: int) -> int:
    """Write the motion after a reference step of 1; return the size of Z."""
    if n == 2 and c == 2 and delay == 0:  # of the usual ones the compiler knows every place
        return written(w, 2, 2, 0)
    return written(w, n, c, delay)


@compiled
def written(w: int, n: int, c: int, delay: int) -> int:
    """Do what ``closed`` does.

    What e moves by is taken from what the plant's first state does, never as a difference.
    """
    m, p, law, s = work.motion(w), work.plant(w), work.law(w), work.track(w).ladder[0]
    own, one = n + delay, n + delay + c
    size = one + 1
    direct = law.numbers[0]
    for i in range(size):
        m.output[i], m.effort[i], m.start[i] = 0.0, 0.0, 0.0
        for j in range(WIDE):
            s[i, j] = 0.0
    m.output[0] = 1.0
    for j in range(c):
        m.effort[own + j], m.start[own + j] = law.residues[j], law.leads[j]
    m.effort[one], m.start[one] = direct, 1.0
    m.effort[0] -= direct
    for i in range(n):
        for j in range(n):
            s[j, i] = p.delta[WHOLE, i, j]
        late, early = p.enters[WHOLE, i] - p.enters[LATE, i], p.enters[LATE, i]
        if delay:
            s[own - 1, i] += late
            if delay > 1:
                s[own - 2, i] += early
            else:
                for j in range(size):
                    s[j, i] += early * m.effort[j]
        else:
            for j in range(size):
                s[j, i] += late * m.effort[j]
    for j in range(delay):
        if j:
            s[n + j - 1, n + j] += 1.0
        else:
            for i in range(size):
                s[i, n] += m.effort[i]
        s[n + j, n + j] -= 1.0
    for j in range(c):
        for i in range(size):
            s[i, own + j] -= law.leads[j] * s[i, 0]
        s[0, own + j] -= law.enters[j]
        s[one, own + j] += law.enters[j]
        for i in range(c):
            s[own + i, own + j] += law.moves[j, i]
    for j in range(size):
        m.output_moves[j] = s[j, 0]
    moved_row(m.effort, s, size, m.effort_moves)
    top, bottom = law.num[0] * p.top[0], law.den[0] * p.bottom[0]
    m.numbers[0] = top / (top + bottom)
    m.numbers[1] = law.num[0] * p.bottom[0] / (top + bottom)
    return size


@compiled
def moved_row(row: Array, s: Array, size: int, out: Array) -> None:
    """Write row s, s by columns."""
    for j in range(size):
        total = 0.0
        for i in range(size):
            total += row[i] * s[j, i]
        out[j] = total
