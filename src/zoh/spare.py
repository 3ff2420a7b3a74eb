"""A PID's spare freedom, closed by what its loop is worth: searched for, and measured.

The PIDs of one crossover are a line, their ki an interval known in closed form
(``design.pid.room``). Along it 400 values are looked at, dense towards both ends. A few hundred
frequencies give each a lower bound of Ms, and what the bound excludes is out for good; the rest
is measured. The edge of what is good is then halved forty times. So a feasible interval of ki is
missed only where it is narrower than a tenth of ki (of high - ki, near the other end) and shows
as no dip of the bound, for around each dip forty more values are looked at.
Source: K. J. Astrom and T. Hagglund, Advanced PID Control, sec. 4.2 and 7.2 (the largest ki, and
the least IAE, under a bound on Ms).
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import degrees, exp, inf, log, pi

import numpy as np
import numpy.typing as npt

from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.nyquist import closed_loop_stable
from zoh.analysis.results import Margins
from zoh.design import pid
from zoh.design.target import Target, refusal
from zoh.errors import Infeasible, SpecError
from zoh.lti.forms import time_constant
from zoh.lti.systems import Sampled
from zoh.spec import Crossover

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
Cost = Callable[[Sampled], float]

_VALUES, _FEW = 400, 40
_END = 18.0  # exp(-18) of the interval is left out at both ends
_HALVINGS = 40
_COSTLY = 48  # values of ki whose IAE is computed before the best is closed in on


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """The PIDs of one crossover: ki = low + (high - low)/(1 + exp(-y)), y any real number.

    ms          the largest peak of the sensitivity allowed
    acceptable  whether a loop's margins are those that were asked for
    """

    sampled: Sampled
    spec: Crossover
    filter_pole: float | None
    low: float
    high: float
    ms: float
    acceptable: Callable[[Margins], bool]

    @classmethod
    def of(
        cls, sampled: object, spec: Crossover, ms: float, filter_pole: float | None,
        acceptable: Callable[[Margins], bool],
    ) -> "Line":  # fmt: skip
        """Return the line; raise Infeasible where no PID is on it, SpecError on a table."""
        if not isinstance(sampled, Sampled):
            raise SpecError("ms", "must be searched on a model", ms, "on a table give ki or ti_td")
        tau, target = time_constant(filter_pole, sampled.dt), Target.of(sampled, spec)
        room = pid.room(target, tau)
        if room is None:
            able = pid.phases_of_any(target, tau)
            raise refusal("a PID with positive gains", target, spec, able, "")
        return cls(
            sampled=sampled, spec=spec, filter_pole=filter_pole, low=room[0], high=room[1],
            ms=ms, acceptable=acceptable,
        )  # fmt: skip

    def law(self, y: float) -> pid.PID:
        """Return the PID at y; raise Infeasible where rounding has left no positive gain."""
        ki = self.low + (self.high - self.low) / (1 + exp(-y))
        return pid.solve(self.sampled, self.spec, ki, self.filter_pole)

    def good(self, y: float) -> bool:
        """Return whether the loop at y is stable, on target and under the bound on Ms."""
        try:
            loop = Loop.of(self.law(y).controller(), self.sampled)
        except Infeasible:
            return False
        if not closed_loop_stable(loop):
            return False
        found = measure_loop(loop)
        return found.ms <= self.ms and self.acceptable(found)

    def least_ms(self, y: Array) -> Array:
        """Return a lower bound of Ms at each y: the largest |1/(1 + L)| of some frequencies."""
        dt, wc = self.sampled.dt, self.spec.wc
        top = pi / dt * (1 - 1e-9)
        w = np.concatenate(
            [np.geomspace(wc / 100, top, 200), np.geomspace(wc / 3, min(3 * wc, top), 100)]
        )
        v = 2j / dt * np.tan(w * dt / 2)
        first, last = self._at(0.25, v), self._at(0.75, v)
        share = 2 * (1 / (1 + np.exp(-y)) - 0.25)[:, None]  # the law is linear in ki
        with np.errstate(all="ignore"):
            returned = 1 + (first + share * (last - first)) * self.sampled.at(w)
            return np.asarray(1 / np.nanmin(np.abs(returned), axis=1))

    def _at(self, share: float, v: Complex) -> Complex:
        law = self.law(log(share / (1 - share)))
        tau = time_constant(self.filter_pole, self.sampled.dt)
        return np.asarray(law.kp + law.ki / v + law.kd * v / (1 + v * tau))

    def candidates(self, count: int = _VALUES) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Return (all y looked at, ascending; whether the lower bound of Ms leaves each open)."""
        y = self._with_dips(_FEW)
        if count > _FEW:  # what a look at few has found is among those of a look at many
            y = np.unique(np.concatenate([y, self._with_dips(count)]))
        return y, self.least_ms(y) <= self.ms * (1 + 1e-9)  # 1e-9: the bound is rounded too

    def _with_dips(self, count: int) -> Array:
        """Return values of y spread evenly, and more around each dip of the bound."""
        y = np.linspace(-_END, _END, count)
        bound = self.least_ms(y)
        dips = np.flatnonzero((bound[1:-1] < bound[:-2]) & (bound[1:-1] < bound[2:])) + 1
        return np.unique(np.concatenate([y, *(np.linspace(y[i - 1], y[i + 1], 40) for i in dips)]))

    def nothing(self) -> Infeasible:
        """Return that no value looked at is good."""
        target = Target.of(self.sampled, self.spec)
        tau = time_constant(self.filter_pole, self.sampled.dt)
        low, high = pid.phases_of_any(target, tau) or (0.0, 0.0)
        return Infeasible(
            f"no PID with positive gains has {self.spec.pm_deg:g} deg at {self.spec.wc:g} rad/s "
            f"and Ms at most {self.ms:g}",
            needed_deg=degrees(target.theta),
            needed_gain=1 / target.size,
            gives_deg=(degrees(low), degrees(high)),
            best_pm_deg=target.best_margin_deg((low, high), self.spec),
        )


def some_ki(line: Line) -> pid.PID:
    """Return a PID with Ms at most ``line.ms``, to know that there is one; raise Infeasible.

    Looked for among a tenth of the values: enough for where else a request could be met.
    """
    return line.law(_highest_good(line, _FEW)[0])


def largest_ki(line: Line) -> pid.PID:
    """Return the PID of the largest ki with Ms at most ``line.ms``; raise Infeasible without one.

    It is good, and what is 36/400/2^40 above it in y is not.
    """
    good, bad = _highest_good(line)
    if bad is None:
        return line.law(good)
    for _ in range(_HALVINGS):
        middle = (good + bad) / 2
        if line.good(middle):
            good = middle
        else:
            bad = middle
    return line.law(good)


def least_iae(line: Line, iae: Cost) -> pid.PID:
    """Return the PID of the least ``iae`` with Ms at most ``line.ms``; raise Infeasible.

    The best of some fifty good values spread over the line, then closed in on, six times
    more closely each time, to 1e-6 in y.
    """

    def cost(y: float) -> tuple[float, float]:
        return (iae(line.law(y).controller()) if line.good(y) else inf), y

    y, fits = line.candidates()
    spread = y[fits][:: max(1, int(fits.sum()) // _COSTLY)].tolist()
    best = min(map(cost, [*spread, _highest_good(line)[0]]))
    step = 2 * _END / _COSTLY
    while step > 1e-6:
        best = min(best, *(cost(best[1] + step * k / 6) for k in range(-6, 7) if k))
        step /= 6
    if best[0] == inf:  # there are some, see ``_highest_good``
        bound = "must be of loops whose load error ends: these swing for a million samples"
        raise SpecError("least_iae_ms", bound, line.ms, "give largest_ki_ms, or sample more slowly")
    return line.law(best[1])


def _highest_good(line: Line, count: int = _VALUES) -> tuple[float, float | None]:
    """Return (the highest good y looked at, the next one above it); raise Infeasible."""
    y, fits = line.candidates(count)
    above: float | None = None
    for one, fit in zip(reversed(y.tolist()), reversed(fits.tolist()), strict=True):
        if fit and line.good(one):
            return one, above
        above = one
    raise line.nothing()
