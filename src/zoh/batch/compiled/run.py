"""A batch by the compiled arithmetic, on every core that is given.

What floats cannot decide is left to the single design, as by ``zoh.batch.arrays``.
"""

from concurrent.futures import ThreadPoolExecutor
from threading import local

import numpy as np
import numpy.typing as npt

from zoh.analysis.realised import realised
from zoh.batch.arrays.asked import Batch, batch, lacks
from zoh.batch.arrays.rows import Array, Mask
from zoh.batch.backend import CORES
from zoh.batch.chunks import in_chunks
from zoh.batch.columns import Columns, Results, length
from zoh.batch.compiled import layout, places, room
from zoh.batch.compiled.abreast.room import LENGTH
from zoh.batch.compiled.machine import Kernel
from zoh.batch.figures import gain_names
from zoh.batch.first_use import cores, kernel
from zoh.batch.job import Job
from zoh.batch.reason import Reason

CHUNK = 16384  # loops whose columns are made at once, at most
_FEWEST = 1024  # loops that a core is worth
_TURNS = 4  # that each core takes at least, for loops are not equally long
_SPARE = {"pid": "ki", "lag": "dc_gain", "lead": "dc_gain"}
_MARGINS = {
    "gain_margin": places.GM, "phase_crossover": places.PHASE_CROSSOVER,
    "phase_margin_deg": places.PM, "crossover": places.CROSSOVER,
    "delay_margin": places.DELAY, "modulus_margin": places.MODULUS, "ms": places.MS,
    "mt": places.MT, "disk_margin": places.DISK, "bandwidth": places.BANDWIDTH,
}  # fmt: skip
_STEPS = {
    "overshoot_pct": places.OVERSHOOT, "rise_time": places.RISE, "settling_time": places.SETTLING,
    "peak": places.PEAK, "peak_time": places.PEAK_TIME, "steady_state_error": places.ERROR,
    "peak_effort": places.EFFORT, "between.overshoot_pct": places.BETWEEN_OVERSHOOT,
    "between.peak_time": places.BETWEEN_TIME,
}  # fmt: skip


def run(
    job: Job, columns: Columns, threads: int | None = None, by: Kernel | None = None
) -> Results:
    """Return the columns of ``zoh.batch.figures``, as ``zoh.batch.single`` does.

    threads  how many cores at most; where it is left out, what ``backend.CORES`` says
    by       what computes a stretch of loops, ``first_use.kernel()`` where it is left out

    >>> from zoh.lti.systems import Plant
    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> job = Job(plant=arm, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc",))
    >>> found = run(job, {"wc": np.array([0.8, 3.0, 40.0])})
    >>> [Reason(code).name for code in found["reason"]]
    ['OK', 'INFEASIBLE', 'BEYOND_NYQUIST']
    """
    n, compute = length(job, columns), by or kernel()
    many = max(1, min(threads or CORES.get() or cores(), -(-n // _FEWEST)))
    chunk = min(CHUNK, max(_FEWEST, -(-n // (_TURNS * many))))
    own = local()  # arrays of one core: new ones for each chunk would be new pages of memory

    def some(job: Job, columns: Columns, n: int) -> tuple[Results, Mask]:
        if not hasattr(own, "floats"):
            own.floats, own.rows = _work(job), _rows(chunk)
        return _some(compute, own.floats, [row[:n] for row in own.rows], job, columns, n)

    with ThreadPoolExecutor(many) as pool:
        return in_chunks(job, columns, chunk, some, pool.map)


def _work(job: Job) -> Array:
    """Return the arrays of one core, a given controller written into them."""
    floats = layout.stretch(LENGTH)
    if job.controller is None:
        return floats
    given, law = job.controller, room.LAW.of(floats)
    a, c, direct = realised(given)
    powers = (2 / given.dt) ** np.arange(float(len(given.den_w)))
    law.num[: len(powers)] = np.array(given.num_w[::-1]) * powers
    law.den[: len(powers)] = np.array(given.den_w[::-1]) * powers
    for i, feedback in enumerate(a):
        law.moves[0, i], law.residues[i] = -feedback, c[i]
        law.moves[i, i - 1] += 1.0 if i else 0.0
    law.enters[0] = 1.0 if a else 0.0
    law.numbers[0], law.numbers[1] = direct, 1.0
    return floats


def _rows(n: int) -> list[Array]:
    """Return room for gains, margins and metrics of so many loops, a row a loop."""
    return [np.empty((n, many)) for many in (places.GAINS, places.MARGINS, places.STEPS)]


def _some(
    compute: Kernel, floats: Array, rows: list[Array], job: Job, columns: Columns, n: int
) -> tuple[Results, Mask]:
    """Return (the results of a chunk, which loops are left to the single design).

    The results are views of the rows.
    """
    wanted = batch(job, columns, n)
    for row in rows:
        row.fill(np.nan)
    reason, left = np.full(n, Reason.MALFORMED, np.int8), ~wanted.regular
    reason[wanted.beyond] = Reason.BEYOND_NYQUIST
    asked = (wanted.num, wanted.den, wanted.dt, wanted.delay, wanted.lead, *_asked(job, wanted, n))
    read = [np.ascontiguousarray(row, np.float64) for row in asked]
    compute(
        floats.ctypes.data, places.CODES[job.law], len(wanted.den) - 1, n,
        *(row.ctypes.data for row in (*read, *rows)), reason.ctypes.data, left.ctypes.data,
        job.reference,
    )  # fmt: skip
    return _results(job, rows, reason), left & ~wanted.beyond


def _asked(job: Job, wanted: Batch, n: int) -> tuple[Array, Array, Array, Array]:
    """Return the columns wc, pm_deg, ki or dc_gain, and the filter's pole (0: 2/dt)."""
    zero = np.zeros(n)
    if job.controller is not None:
        order = len(job.controller.den_w) - 1
        return np.ones(n), zero, zero, np.full(n, float(order))
    asked = wanted.asked
    spare = asked[_SPARE[job.law]] if job.law in _SPARE else zero
    return asked["wc"], asked["pm_deg"], spare, asked.get("filter_pole", zero)


def _results(job: Job, rows: list[Array], reason: npt.NDArray[np.int8]) -> Results:
    """Return the columns of what was written; what is left may be written in part."""
    gains, margin, step = rows
    out: Results = {name: gains[:, place] for place, name in enumerate(gain_names(job.law))}
    for names, values in ((_MARGINS, margin), (_STEPS, step)):
        out |= {name: values[:, place] for name, place in names.items()}
    out["stable"], out["reason"] = (reason == Reason.OK) | (reason == Reason.OFF_TARGET), reason
    return out


__all__ = ["CHUNK", "lacks", "run"]
