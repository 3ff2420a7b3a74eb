"""A batch with NumPy alone: hold, law, verification, each done for thousands of loops at a time.

What floats cannot decide, or only in many steps, is left to the single design: a pivot that may
be rounding, an extreme that may touch 0, a request at the edge of what its law can do.
"""

from dataclasses import replace

import numpy as np

from zoh.batch.arrays import laws, rows
from zoh.batch.arrays.asked import Batch, batch, lacks
from zoh.batch.arrays.held import Held, held
from zoh.batch.arrays.laws import Solved
from zoh.batch.arrays.margins import Loops, measured, stable
from zoh.batch.arrays.motion import motion, poles
from zoh.batch.arrays.rows import Array, Mask, only
from zoh.batch.arrays.steps import step_metrics
from zoh.batch.chunks import in_chunks
from zoh.batch.columns import Columns, Results, empty
from zoh.batch.figures import BY_NAME
from zoh.batch.job import GIVEN, Job
from zoh.batch.reason import Reason
from zoh.batch.tolerances import HELD, ON_TARGET, RESONANT, ROOM, SHARP

CHUNK = 4096  # loops at a time: fewer are ruled by Python's calls, more leave a core's own cache


def run(job: Job, columns: Columns) -> Results:
    """Return the columns of ``zoh.batch.figures``, as ``zoh.batch.single`` does.

    >>> from zoh.lti.systems import Plant
    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> job = Job(plant=arm, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc",))
    >>> found = run(job, {"wc": np.array([0.8, 3.0, 40.0])})
    >>> [Reason(code).name for code in found["reason"]]
    ['OK', 'INFEASIBLE', 'BEYOND_NYQUIST']
    """
    return in_chunks(job, columns, CHUNK, some)


def some(job: Job, columns: Columns, n: int) -> tuple[Results, Mask]:
    """Return (the results of a chunk, which loops are left to the single design)."""
    wanted = batch(job, columns, n)
    out, left = empty(job, n), ~(wanted.regular | wanted.beyond)
    out["reason"][wanted.beyond] = Reason.BEYOND_NYQUIST
    for delay in np.unique(wanted.delay[wanted.regular]):
        (who,) = np.nonzero(wanted.regular & (wanted.delay == delay))
        found, doubt = _alike(job, only(wanted, who), int(delay))
        for name, values in found.items():
            out[name][who] = values
        left[who] = doubt
    return out, left


def _alike(job: Job, wanted: Batch, delay: int) -> tuple[Results, Mask]:
    """Return the results of loops that are equally many whole samples late."""
    n = len(wanted.dt)
    with np.errstate(all="ignore"):
        plant = held(wanted.num, wanted.den, wanted.dt, wanted.delay, wanted.lead)
        loops, law = closed(job, wanted, plant, delay)
        good, doubt = stable(loops)
    able = law.room > 0
    unsure = ~(np.abs(plant.off) <= HELD)
    unsure |= ~(np.abs(law.room) > ROOM)  # whether the law is able, too
    out = empty(job, n)
    out["reason"][:] = np.where(able, np.where(good, Reason.OK, Reason.UNSTABLE), Reason.INFEASIBLE)
    for name, values in law.gains.items():
        out[f"gains.{name}"][able] = values[able]
    (who,) = np.nonzero(able & good)
    if len(who):
        good_ones = only(loops, who)
        figures, rounded = measured(good_ones)
        doubt[who] |= rounded
        if len(plant.before) > 2:
            doubt[who] |= ~(figures["ms"] <= SHARP)
        held_ones = only(plant, who)
        moves = motion(held_ones, only(law, who), delay)
        late, rounded = step_metrics(
            moves, held_ones, delay, poles(good_ones), good_ones.dt, job.reference
        )
        doubt[who] |= rounded | ~(np.abs(held_ones.off * (1 - moves.final)) <= HELD)
        out["stable"][who] = True
        for name in BY_NAME:
            out[name][who] = late[name] if name in late else figures[name]
        if "pm_deg" in wanted.asked:
            off = np.abs(figures["phase_margin_deg"] - wanted.asked["pm_deg"][who]) > ON_TARGET
            off |= np.abs(figures["crossover"] / wanted.asked["wc"][who] - 1) > ON_TARGET
            out["reason"][who[off]] = Reason.OFF_TARGET
    return out, unsure | (doubt & able)


def closed(job: Job, wanted: Batch, plant: Held, delay: int) -> tuple[Loops, Solved]:
    """Return the loops on their frequency axes, and the laws."""
    count = len(wanted.dt)
    top, bottom = plant.num, plant.den
    one = np.ones(count)
    for _ in range(delay):
        top, bottom = (
            rows.times(top, np.stack([one, -one])),
            rows.times(bottom, np.stack([one, one])),
        )
    if job.law == GIVEN and job.controller is not None:
        law = laws.given(job.controller, count)
        num, den = rows.times(top, law.num), rows.times(bottom, law.den)
        x = _crossover(num, den)
    else:
        x = np.tan(wanted.asked["wc"] * wanted.dt / 2)
        over, under = rows.on_axis(plant.num, x)[0], rows.on_axis(plant.den, x)[0]
        g = over / under * ((1 - 1j * x) / (1 + 1j * x)) ** delay
        at = laws.wanted(g, wanted.asked["pm_deg"], x, wanted.dt)
        law = laws.LAWS[job.law](at, wanted.asked)
        known = np.abs(over) > RESONANT * rows.at(np.abs(plant.num), x)
        known &= np.abs(under) > RESONANT * rows.at(np.abs(plant.den), x)
        law = replace(law, room=np.where(known, law.room, np.nan))
        num, den = rows.times(top, law.num), rows.times(bottom, law.den)
    powers = np.power(x[None, :], np.arange(float(len(den)))[:, None])
    num = np.concatenate([num, np.zeros((len(den) - len(num), count))])
    return Loops(num=num * powers, den=den * powers, x=x, dt=wanted.dt), law


def _crossover(num: Array, den: Array) -> Array:
    """Return about the highest |p| at which the gain is 1, or where it is nearest to 1."""
    x = np.geomspace(1e-7, 1e4, 111)
    ones = np.ones((len(x), num.shape[1]))
    size = np.abs(rows.on_axis(num, x[:, None] * ones)[0] / rows.on_axis(den, x[:, None] * ones)[0])
    last = len(x) - 1 - np.argmax(size[::-1] >= 1, axis=0)
    nearest = np.argmin(np.abs(np.log(size)), axis=0)
    return np.asarray(x[np.where((size >= 1).any(axis=0), last, nearest)])


__all__ = ["CHUNK", "lacks", "run"]
