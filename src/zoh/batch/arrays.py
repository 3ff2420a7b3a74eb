"""Many loops at once with NumPy alone: hold, law, verification."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from zoh.batch import rows
from zoh.batch.held import Held, held
from zoh.batch.laws import LAWS, Solved, wanted
from zoh.batch.margins import Loops, measured, stable
from zoh.batch.rows import Array, Mask

_PM_TOL_DEG, _WC_TOL = 1e-9, 1e-9  # what a design promises of its crossover


@dataclass(frozen=True, slots=True, kw_only=True)
class Batch:
    """What is asked, one column a loop.

    num, den     the plant with its sensor, rows of ascending powers of s, equally many; the last
                 row of den is 1
    delay, lead  samples of dead time and compute delay: delay - lead, 0 <= lead < 1
    law          a name in ``LAWS``; given has its parameters but for wc and pm_deg
    """

    num: Array
    den: Array
    dt: Array
    delay: npt.NDArray[np.int64]
    lead: Array
    law: str
    wc: Array
    pm_deg: Array
    given: Mapping[str, Array]


def solved(batch: Batch) -> tuple[Loops, Held, Solved, Mask]:
    """Return the loops, the plants behind their holds, the laws, and which requests are none."""
    x = np.tan(batch.wc * batch.dt / 2)
    bad = ~((batch.wc * batch.dt > 0) & (batch.wc * batch.dt < np.pi))
    plant = held(batch.num, batch.den, batch.dt, batch.delay, batch.lead)
    top, bottom = plant.num, plant.den
    for more in range(int(plant.delay.max(initial=0))):
        late = plant.delay > more
        top = rows.times(top, np.stack([np.ones_like(x), np.where(late, -1.0, 0.0)]))
        bottom = rows.times(bottom, np.stack([np.ones_like(x), np.where(late, 1.0, 0.0)]))
    with np.errstate(all="ignore"):
        g = rows.on_axis(top, x)[0] / rows.on_axis(bottom, x)[0]
        law = LAWS[batch.law](wanted(g, batch.pm_deg, x, batch.dt), batch.given)
        num, den = rows.times(top, law.num), rows.times(bottom, law.den)
        powers = np.power(x[None, :], np.arange(float(len(den)))[:, None])
    loops = Loops(num=_as_long(num * powers[: len(num)], len(den)), den=den * powers, x=x, dt=batch.dt)
    return loops, plant, law, bad


def _as_long(a: Array, count: int) -> Array:
    return np.concatenate([a, np.zeros((count - len(a), a.shape[1]))])
