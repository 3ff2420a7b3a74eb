"""The map of a law: over every crossover the margins that it can give, and what each is worth.

Where a law has a second open parameter, each point of the map shows the best of some values of
it. A point is measured as every design is, but for proofs that are dear; it is a picture to choose
by, and a design made from it is measured anew.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite, pi
from typing import Any

import numpy as np
import numpy.typing as npt

from zoh import checks
from zoh.analysis.asked import checked
from zoh.choice.choose import ASSUMED, nothing_asked, signs
from zoh.choice.fastest import slowest_corner
from zoh.choice.freedom import Freedom
from zoh.choice.judge import Judge, Judgement
from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.lti.weights import WEIGHTS
from zoh.request import OF_AUTO, UNDER_MS, allowed
from zoh.request import checked as checked_parameters
from zoh.sampling.hold import sample
from zoh.solving import opposite
from zoh.spec import Requirements
from zoh.workbench import without_cancelled

Array = npt.NDArray[np.float64]

MAPPED = ("pi", "pd", "pid", "lead", "lag")  # the laws with a map; a P has a line
_VALUES = 7  # of a second parameter, tried at each point
_AROUND = 30.0  # times below the slowest corner the map begins


@dataclass(frozen=True, slots=True, kw_only=True)
class Map:
    """What a law can do at each crossover, and how each design there meets what is asked.

    wc      rad/s, shape (n,)
    pm_deg  deg, shape (m, n): margins from the least that the law can give at wc to the most; NaN
            where it can give none
    slack   shape (m, n): the least relative slack of all that is asked, 0 or more where all is
            met; NaN where the law has no such design, -inf where it has and its loop is unstable
            or has a smaller margin elsewhere
    values  by the name of each requirement what is measured, shape (m, n); NaN where nothing is
    """

    law: str
    requirements: Requirements
    wc: Array
    pm_deg: Array
    slack: Array
    values: Mapping[str, Array] = field(default_factory=dict)

    @property
    def met(self) -> npt.NDArray[np.bool_]:
        """Return where everything asked is met, shape (m, n)."""
        return np.asarray(self.slack >= 0)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form; what is no finite number is None."""
        return {
            "law": self.law,
            "wc": self.wc.tolist(),
            "pm_deg": _jsonable(self.pm_deg),
            "slack": _jsonable(self.slack),
            "values": {name: _jsonable(value) for name, value in self.values.items()},
        }


def law_map(
    plant: Plant, law: str, *, dt: float, compute_delay: float = 0.0,
    requirements: Requirements | None = None, reference: float = 1.0,
    given: Mapping[str, float] | None = None, allow: Sequence[str] = (),
    points: tuple[int, int] = (40, 24),
) -> Map:  # fmt: skip
    """Return the map of a law, ``points`` crossovers by margins.

    ``given`` are parameters of the law that are not open (ki, dc_gain, filter_pole, ti_td, the
    setpoint weights); ``allow`` is as for ``zoh.design``. Where negative
    gains are allowed all of them have the sign of the one given, else the one that the plant needs.
    Without requirements those of an open choice are assumed: pm_deg 45 and ms 1.7. Raises
    SpecError for what is no plant, no law, or a table.

    >>> found = law_map(Plant(num=[1], den=[1, 0]), "pi", dt=1.0, points=(5, 4))
    >>> found.slack.shape, bool(found.met.any())
    ((4, 5), True)
    """
    if not isinstance(plant, Plant):
        raise SpecError("plant", "must be a zoh.Plant", plant, "a table has no map")
    if not isinstance(law, str) or law not in MAPPED:
        raise SpecError("law", f"must be one of {', '.join(MAPPED)}", law, "choose one of these")
    across, up = _grid(points)
    words = allowed(allow)
    fixed = _fixed(law, {} if given is None else given, words)
    weights = {name: fixed.pop(name) for name in WEIGHTS if name in fixed}
    asked = checked(Requirements() if requirements is None else requirements)
    asked = ASSUMED if nothing_asked(asked) else asked
    plant, _ = without_cancelled(plant, words)
    sampled = sample(plant, dt, compute_delay)
    back = signs(sampled, fixed, words)[0]
    judge = Judge(
        plant=plant, sampled=sampled, compute_delay=compute_delay, requirements=asked,
        reference=reference, weights=weights, back=back,
    )  # fmt: skip
    fixed = opposite(fixed) if back else fixed
    wc = _crossovers(sampled, across)
    pm_deg, slack = np.full((up, across), np.nan), np.full((up, across), np.nan)
    values = {name: np.full((up, across), np.nan) for name in _names(asked)}
    for j, w in enumerate(wc.tolist()):
        whole = Freedom.of(law, judge.facing, w, fixed, 0.0)
        if whole is None:
            continue
        pm_deg[:, j] = np.linspace(*whole.pm, up)
        for i, pm in enumerate(pm_deg[:, j].tolist()):
            best = _best(judge, Freedom.of(law, judge.facing, w, {**fixed, "pm_deg": pm}, 0.0))
            if best is not None:
                slack[i, j] = best.slack if best.rows else -inf
                for row in best.rows:
                    values[row.name][i, j] = np.nan if row.value is None else row.value
    return Map(law=law, requirements=asked, wc=wc, pm_deg=pm_deg, slack=slack, values=values)


def _best(judge: Judge, freedom: Freedom | None) -> Judgement | None:
    """Return the judgement of the best of some values of what is open; None where there is none."""
    if freedom is None:
        return None
    points = [(x,) for x in np.linspace(0, 1, _VALUES).tolist()] if freedom.size else [()]
    found = [judge.of(freedom.law, freedom.parameters(point)) for point in points]
    return max(found, key=lambda judgement: judgement.height)


def _fixed(law: str, given: Mapping[str, float], words: frozenset[str]) -> dict[str, float]:
    found = checked_parameters(law, given, words)
    for name, value in given.items():
        if name in OF_AUTO or name in UNDER_MS:
            raise SpecError(name, f"is no parameter of a map of {law}", value, "leave it out")
    return found


def _grid(points: object) -> tuple[int, int]:
    """Return the two numbers of points, checked."""
    way_out = "two numbers of points"
    counts = checks.sequence("points", points, way_out)
    if len(counts) != 2:
        raise SpecError("points", "must be two numbers", counts, "crossovers, margins: (40, 24)")
    across, up = (checks.whole("points", n, 2, way_out) for n in counts)
    return across, up


def _crossovers(sampled: Sampled, count: int) -> Array:
    """Return crossovers evenly in log, from below the slowest corner to just below Nyquist's."""
    top = 0.98 * pi / sampled.dt
    return np.geomspace(slowest_corner(sampled, top) / _AROUND, top, count)


def _names(asked: Requirements) -> list[str]:
    return [name for name in Requirements.__slots__ if getattr(asked, name) is not None]


def _jsonable(a: Array) -> list[Any]:
    if a.ndim > 1:
        return [_jsonable(row) for row in a]
    return [x if isfinite(x) else None for x in a.tolist()]
