"""A stretch of loops, each from its hold to its step: law, stability, margins on the way.

Those around plants of order 2 without a delay go side by side; what is unusual goes alone.
"""

from math import inf, log, tan

import numpy as np
import numpy.typing as npt

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import between, laws, motion, steps, turns, work
from zoh.batch.compiled.abreast import group
from zoh.batch.compiled.abreast.hold import hold
from zoh.batch.compiled.abreast.room import LOOPS
from zoh.batch.compiled.addresses import codes, numbers
from zoh.batch.compiled.jit import compiled, object_file, shared
from zoh.batch.compiled.machine import WHOLES
from zoh.batch.compiled.margins import measured
from zoh.batch.compiled.modes import modes
from zoh.batch.compiled.places import CROSSOVER, GAINS, GIVEN, MARGINS, MS, PID, PM, STEPS
from zoh.batch.compiled.plant import held
from zoh.batch.compiled.polynomials import on_axis, times
from zoh.batch.compiled.stability import stable
from zoh.batch.tolerances import HELD, ON_TARGET, ROOM, SHARP

Codes = npt.NDArray[np.int8]
_FLOAT = 8  # bytes
_GRID = np.geomspace(1e-7, 1e4, 45)  # of |p|

OK, INFEASIBLE, UNSTABLE, OFF_TARGET = 0, 1, 2, 4  # of ``Reason``
ALONE = 2  # of ``left``, for as long as the kernel has it: a loop to be done by itself


@compiled
def one(
    w: int, code: int, n: int, reference: float, num: Array, den: Array, dt: float, delay: int,
    lead: float, wc: float, pm_deg: float, spare: float, pole: float, i: int, count: int,
    gains: Array, margin: Array, step: Array, reason: Codes,
) -> bool:  # fmt: skip
    """Write what becomes of loop i of so many; return whether it is left to the single design."""
    p, law = work.plant(w), work.law(w)
    for k in range(n + 1):
        p.b[k], p.a[k] = num[k * count + i], den[k * count + i]
    held(w, n, dt, lead)
    if not abs(p.numbers[2]) <= HELD:
        return True
    x = tan(wc * dt / 2.0)
    if code == GIVEN:
        c = int(pole)
        x = crossover(w, n, c)
    else:
        lag = 2.0 / (pole * dt) if pole > 0.0 else 1.0
        c = laws.solve(law, p, n, delay, code, x, dt, pm_deg, spare, lag)
    room = law.numbers[1]
    if not abs(room) > ROOM:
        return True
    if room < 0.0:
        reason[i] = INFEASIBLE
        return False
    for k in range(GAINS):
        gains[k] = law.numbers[2 + k]
    degree = closed(w, n, c, delay, x)
    good, doubt = stable(w, degree)
    if doubt:
        return True
    if not good:
        reason[i] = UNSTABLE
        return False
    if measured(w, degree, x, dt, margin) or (n > 2 and not margin[MS] <= SHARP):
        return True
    slowest = modes(w, degree, x)
    if response(w, n, c, delay, lead, degree, slowest, dt, reference, step):
        return True
    reason[i] = OK if code == GIVEN else judged(margin, wc, pm_deg)
    return False


@shared
def response(
    w: int, n: int, c: int, delay: int, lead: float, degree: int, slowest: float, dt: float,
    reference: float, step: Array,
) -> bool:  # fmt: skip
    """Write the metrics of the step response; return any doubt. The modes are known."""
    size = motion.closed(w, n, c, delay)
    off = work.plant(w).numbers[2] * (1.0 - work.motion(w).numbers[0])
    if not abs(off) <= HELD:  # of the final value
        return True
    count = between.cut(w, n, delay, lead, size)
    if n > 2:
        turns.weigh(w, n, delay, count)
    return steps.step_metrics(w, count, n, degree, size, slowest, dt, reference, step)


@compiled
def judged(margin: Array, wc: float, pm_deg: float) -> int:
    """Return whether a loop has what was asked for."""
    off = abs(margin[PM] - pm_deg) > ON_TARGET or abs(margin[CROSSOVER] / wc - 1.0) > ON_TARGET
    return OFF_TARGET if off else OK


@compiled
def crossover(w: int, n: int, c: int) -> float:
    """Return about the highest |p| at which the gain is 1, or where it is nearest to 1."""
    p, law = work.plant(w), work.law(w)
    last, nearest, least = 0.0, 1.0, inf
    for x in _GRID:
        a, b, _, _ = on_axis(p.top, n, x)
        e, f, _, _ = on_axis(law.num, c, x)
        over = (a * a + b * b) * (e * e + f * f)
        a, b, _, _ = on_axis(p.bottom, n, x)
        e, f, _, _ = on_axis(law.den, c, x)
        size = over / ((a * a + b * b) * (e * e + f * f))
        if size >= 1.0:
            last = x
        if abs(log(size)) < least:
            nearest, least = x, abs(log(size))
    return last if last > 0.0 else nearest


@compiled
def closed(w: int, n: int, c: int, delay: int, x: float) -> int:
    """Write the loop in u = p/x; return its degree."""
    if n == 2 and c == 2 and delay == 0:  # of the usual ones the compiler knows every place
        return product(w, 2, 2, 0, x)
    return product(w, n, c, delay, x)


@compiled
def product(w: int, n: int, c: int, delay: int, x: float) -> int:
    """Do what ``closed`` does."""
    p, law, num, den = work.plant(w), work.law(w), work.lines(w).num, work.lines(w).den
    degree = times(p.top, n, law.num, c, num)
    times(p.bottom, n, law.den, c, den)
    for _ in range(delay):
        for k in range(degree + 1, 0, -1):
            num[k] = (num[k] if k <= degree else 0.0) - num[k - 1]
            den[k] = (den[k] if k <= degree else 0.0) + den[k - 1]
        degree += 1
    power = 1.0
    for k in range(1, degree + 1):
        power *= x
        num[k] *= power
        den[k] *= power
    return degree


def stretch(
    w: int, code: int, order: int, count: int, num: int, den: int, dt: int, delay: int, lead: int,
    wc: int, pm_deg: int, spare: int, pole: int, gains: int, margin: int, step: int, reason: int,
    left: int, reference: float,
) -> None:  # fmt: skip
    """Write gains, figures and reasons of so many loops, a row a loop; arrays are addresses.

    w         of ``abreast.room.LENGTH`` floats
    num, den  rows of ascending powers of s, up to the order;  delay  whole samples, as floats
    left      what is not regular comes in 1; what floats cannot decide goes out 1
    """
    above, below, times_, lates = numbers(num), numbers(den), numbers(dt), numbers(delay)
    leads, at, degs, spares, poles = (
        numbers(lead), numbers(wc), numbers(pm_deg), numbers(spare), numbers(pole)
    )  # fmt: skip
    why, doubt, waiting = codes(reason), codes(left), 0
    for i in range(count):
        if doubt[i] == 0:
            if order == 2 and 0 < code < GIVEN and lates[i] == 0.0 and leads[i] == 0.0:
                group.put(w, waiting, i, above, below, count, times_[i], at[i], degs[i])
                waiting += 1
            else:
                doubt[i] = ALONE
        if waiting == LOOPS or (waiting and i == count - 1):
            side_by_side(
                w, code, waiting, times_, at, degs, spares, poles, gains, margin, step, why, doubt,
                reference,
            )  # fmt: skip
            waiting = 0
    for i in range(count):
        if doubt[i] == ALONE:
            doubt[i] = int(one(
                w, code, order, reference, above, below, times_[i], int(lates[i]), leads[i], at[i],
                degs[i], spares[i], poles[i], i, count, numbers(gains + i * GAINS * _FLOAT),
                numbers(margin + i * MARGINS * _FLOAT), numbers(step + i * STEPS * _FLOAT), why,
            ))  # fmt: skip


@compiled
def side_by_side(
    w: int, code: int, waiting: int, dt: Array, wc: Array, pm_deg: Array, spare: Array,
    pole: Array, gains: int, margin: int, step: int, why: Codes, doubt: Codes, reference: float,
) -> None:  # fmt: skip
    """Write what becomes of the loops that wait in the lanes; the unusual are left to be ALONE."""
    loops, degree = work.abreast(w).loop, 4 if code == PID else 3
    hold(w)
    group.aim(w)
    for lane in range(waiting):
        j = int(loops[lane])
        room = group.solved(w, lane, code, spare[j], pole[j])
        if room > ROOM:
            continue
        loops[lane] = -1.0
        if room < -ROOM:
            why[j] = INFEASIBLE
        else:
            doubt[j] = ALONE
    group.looked_at(w, degree)
    for lane in range(waiting):
        j = int(loops[lane])
        if j < 0:
            continue
        row, to = numbers(margin + j * MARGINS * _FLOAT), numbers(step + j * STEPS * _FLOAT)
        group.gains(w, lane, numbers(gains + j * GAINS * _FLOAT))
        if group.unstable(w, lane):
            why[j] = UNSTABLE
        elif group.proved(w, degree, lane, row):
            slowest = group.take(w, lane, degree)
            unknown = response(w, 2, degree - 2, 0, 0.0, degree, slowest, dt[j], reference, to)
            doubt[j], why[j] = int(unknown), judged(row, wc[j], pm_deg[j])
        else:
            doubt[j] = ALONE


def machine_code() -> tuple[str, bytes]:
    """Return ``stretch`` compiled for this processor: its name, and an object file."""
    return object_file(stretch, WHOLES)
