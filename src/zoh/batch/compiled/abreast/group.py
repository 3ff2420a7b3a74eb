"""A group of loops around plants of order 2, a lane a loop, from the plant to the modes.

What takes the mathematical library, and the step response, is done one lane after the other.
"""

from math import inf, nan, pi, sqrt

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import laws, work
from zoh.batch.compiled.abreast.angles import angle, sine_cosine
from zoh.batch.compiled.abreast.margins import figures, margins
from zoh.batch.compiled.abreast.modes import modes
from zoh.batch.compiled.abreast.room import (
    A0,
    A1,
    B0,
    B1,
    BOTTOM,
    COSINE,
    DELTA,
    DT,
    ENTERS,
    FIRST,
    GAIN,
    LOOPS,
    OFF,
    PM_DEG,
    REACH,
    SECOND,
    SINE,
    THETA,
    TOP,
    UNIT,
    X,
)
from zoh.batch.compiled.abreast.stability import DOUBT, GOOD, stable
from zoh.batch.compiled.jit import compiled, shared
from zoh.batch.compiled.modes import alone
from zoh.batch.compiled.places import GAINS
from zoh.batch.compiled.room import LATE, WHOLE
from zoh.batch.tolerances import HELD, RESONANT

_DIRECT, _RESIDUES, _LEADS, _ENTERS, _MOVES, _GAINS = 0, 1, 3, 5, 7, 11  # places in ``law``


@compiled
def put(
    w: int, lane: int, i: int, num: Array, den: Array, count: int, dt: float, wc: float,
    pm_deg: float,
) -> None:  # fmt: skip
    """Put loop i of so many in a lane; num, den: rows of ascending powers of s, a column a loop."""
    r = work.abreast(w)
    p = r.plant
    r.loop[lane] = i
    p[B0, lane], p[B1, lane] = num[i], num[count + i]
    p[A0, lane], p[A1, lane] = den[i], den[count + i]
    p[DT, lane], p[X, lane], p[PM_DEG, lane] = dt, wc, pm_deg


@compiled
def aim(w: int) -> None:
    """Write what gain each lane's plant has at its crossover, and what turn is missing there."""
    p = work.abreast(w).plant
    for i in range(LOOPS):
        x = p[X, i]
        a, b = p[TOP, i] - x * x * p[TOP + 2, i], x * p[TOP + 1, i]
        c, d = p[BOTTOM, i] - x * x * p[BOTTOM + 2, i], x * p[BOTTOM + 1, i]
        over, under = a * a + b * b, c * c + d * d
        turn = (p[PM_DEG, i] - 180.0) * (pi / 180.0) - angle(b * c - a * d, a * c + b * d)
        turn = turn + 2.0 * pi if turn < -pi else turn  # above pi it is not: the margin is below pi
        p[THETA, i], p[GAIN, i] = turn, sqrt(over / under)
        p[SINE, i], p[COSINE, i] = sine_cosine(turn)
        top, bottom = abs(p[TOP + 2, i]), abs(p[BOTTOM + 2, i])
        top, bottom = top * x + abs(p[TOP + 1, i]), bottom * x + abs(p[BOTTOM + 1, i])
        top, bottom = top * x + abs(p[TOP, i]), bottom * x + abs(p[BOTTOM, i])
        clear = int(sqrt(over) > RESONANT * top) & int(sqrt(under) > RESONANT * bottom)
        clear &= int(abs(turn) <= pi)
        off = p[OFF, i]
        p[OFF, i] = off if clear else inf


@compiled
def solved(w: int, lane: int, code: int, spare: float, pole: float) -> float:
    """Write the law of a lane; return the room that it has, nan where floats do not tell."""
    r, law = work.abreast(w), work.law(w)
    q, dt = r.plant, r.plant[DT, lane]
    if not abs(q[OFF, lane]) <= HELD:
        return nan
    lag = 2.0 / (pole * dt) if pole > 0.0 else 1.0
    gain, theta, cosine, sine = q[GAIN, lane], q[THETA, lane], q[COSINE, lane], q[SINE, lane]
    laws.aimed(law, code, gain, theta, cosine, sine, q[X, lane], dt, spare, lag)
    kept = r.law[lane]
    for k in range(3):
        r.law_num[k, lane], r.law_den[k, lane] = law.num[k], law.den[k]
    kept[_DIRECT] = law.numbers[0]
    for k in range(2):
        kept[_RESIDUES + k], kept[_LEADS + k] = law.residues[k], law.leads[k]
        kept[_ENTERS + k] = law.enters[k]
        kept[_MOVES + 2 * k], kept[_MOVES + 2 * k + 1] = law.moves[k, 0], law.moves[k, 1]
    for k in range(GAINS):
        kept[_GAINS + k] = law.numbers[2 + k]
    return float(law.numbers[1])


@shared
def looked_at(w: int, n: int) -> None:
    """Write of every lane whether the loop is stable, its margins, and its modes."""
    if n == 3:  # the compiler knows every place beforehand
        all_of(w, 3, 2, 1)
    else:
        all_of(w, 4, 3, 2)


@compiled
def all_of(w: int, n: int, before: int, c: int) -> None:
    """Do what ``looked_at`` does; n, n - 1 and n - 2 as numbers."""
    closed(w, n, c)
    stable(w, n)
    margins(w, n, before)
    modes(w, n)


@compiled
def closed(w: int, n: int, c: int) -> None:
    """Write every lane's loop in u = p/x."""
    r = work.abreast(w)
    for i in range(LOOPS):
        power, x = 1.0, r.plant[X, i]
        for k in range(n + 1):
            num = den = 0.0
            for j in range(c + 1):
                if 0 <= k - j <= 2:
                    num += r.plant[TOP + k - j, i] * r.law_num[j, i]
                    den += r.plant[BOTTOM + k - j, i] * r.law_den[j, i]
            r.num[k, i], r.den[k, i] = power * num, power * den
            power *= x


@compiled
def unstable(w: int, lane: int) -> bool:
    """Return whether a lane's loop is unstable for sure."""
    said = work.abreast(w).said
    return bool(said[GOOD, lane] == 0.0 and said[DOUBT, lane] == 0.0)


@compiled
def proved(w: int, n: int, lane: int, out: Array) -> bool:
    """Write a lane's margins; return whether they are, and its loop is stable."""
    said = work.abreast(w).said
    sure = said[GOOD, lane] > 0.0 and said[DOUBT, lane] == 0.0
    return bool(sure and figures(w, n, lane, out))


@compiled
def gains(w: int, lane: int, out: Array) -> None:
    """Write the gains of a lane's law."""
    kept = work.abreast(w).law[lane]
    for k in range(GAINS):
        out[k] = kept[_GAINS + k]


@compiled
def take(w: int, lane: int, n: int) -> float:
    """Put a lane's plant, law and modes where its response looks for them; return the least decay.

    n  how many modes
    """
    r, p, law, m = work.abreast(w), work.plant(w), work.law(w), work.motion(w)
    q, kept = r.plant, r.law[lane]
    for i in range(2):
        for j in range(2):
            p.delta[WHOLE, i, j] = q[DELTA + 2 * i + j, lane]
            law.moves[i, j] = kept[_MOVES + 2 * i + j]
        p.enters[WHOLE, i], p.enters[LATE, i] = q[ENTERS + i, lane], 0.0
        law.residues[i], law.leads[i] = kept[_RESIDUES + i], kept[_LEADS + i]
        law.enters[i] = kept[_ENTERS + i]
    p.rows[2, 0], p.rows[2, 1] = -q[A0, lane], -q[A1, lane]
    p.markov[0], p.markov[1] = q[FIRST, lane], q[SECOND, lane]
    p.top[0], p.bottom[0] = q[TOP, lane], q[BOTTOM, lane]
    p.numbers[0], p.numbers[1], p.numbers[2] = 1.0 / q[UNIT, lane], q[REACH, lane], q[OFF, lane]
    law.num[0], law.den[0] = r.law_num[0, lane], r.law_den[0, lane]
    law.numbers[0] = kept[_DIRECT]
    nearest = -1.0
    for k in range(n):
        m.re[k], m.im[k], m.turn[k] = r.re[k, lane], r.im[k, lane], r.turn[k, lane]
        m.creeping[k] = r.growth[k, lane]
        nearest = max(nearest, m.creeping[k])
        for j in range(n):
            m.wr[k, j], m.wi[k, j] = r.wr[k * n + j, lane], r.wi[k * n + j, lane]
    return alone(m, n, nearest)
