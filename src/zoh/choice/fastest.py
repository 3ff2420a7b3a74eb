"""The fastest crossover at which a law meets everything that is asked.

Crossovers are tried from Nyquist's frequency down, in longer steps where more is missed, to far
below every corner of the plant, and below that while a slower one misses by less. At each, the
law's free coordinates are searched for the point where the least slack is largest; where that is
not below 0 the request can be met. The edge above the first such crossover is closed in on by
halving.
What can be met between two crossovers tried, and at neither, is not seen.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import asin, degrees, inf, pi, radians, sin

from zoh.choice.climb import Height, HighEnough, Point, climb, coarse, grid, tops
from zoh.choice.freedom import LEAST_DEG, SLOWEST, Freedom, keeps_zeros_fast, second_is_open
from zoh.choice.judge import Judge, Judgement
from zoh.choice.sieve import Sieve
from zoh.errors import Infeasible, SpecError
from zoh.lti.systems import Sampled
from zoh.lti.wplane import warp
from zoh.request import Progress
from zoh.solving import SolvedLaw, solved
from zoh.spec import Crossover

STEP = (0.005, 0.015, 0.03)  # of wc, between two that are tried; by the number of coordinates
EDGE = 1e-4  # of wc, to which the edge is closed in on
_FAR = -0.1  # of slack: where a glance says that no point of the grid is above it, none is near
_BY_ITS_SIZE = -1.0  # of slack: by how much a first effort misses that is judged by it alone
_HOPELESS = -0.5  # of height, the same: the grid may be coarse
_LOW = -1.0  # a hill that starts lower is no loop at all, and not climbed
_STRIDE = 8.0  # times longer steps where a crossover misses by all
_HILLS = 4  # that are climbed
_NEAR = (0.02, 0.1, 0.004)  # the simplex's sizes where a point near the highest is known
_PUSHES = (0.01, 0.002, 0.0005)  # of wc, by which a crossover found is tried to be passed
_BELOW = 100.0  # times below the plant's slowest corner its response does nothing new
_LEAST = 1e-6  # of that, where the search ends in any case
_BETTER = 1e-6  # of slack: a slower crossover that gains less, below the corners, is the last
_ROUNDING_DEG = 1e-6  # below the least margin that a peak allows, so that rounding leaves it in
_NYQUIST = 0.999  # of pi/dt is the fastest that is tried
_TOLD = 50  # designs measured at one crossover between two words of progress
_NOWHERE = -5.0  # slack: the law cannot give the least margin there


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """The best that a law can do at one crossover in rad/s; no parameters where it can nothing."""

    wc: float
    judgement: Judgement
    point: Point = ()
    parameters: Mapping[str, float] | None = None

    @property
    def met(self) -> bool:
        """Return whether everything asked is met."""
        return self.judgement.slack >= 0

    def gains_on(self, other: "Trial") -> bool:
        """Return whether this one misses by clearly less than another."""
        slack, before = self.judgement.slack, other.judgement.slack
        return self.judgement.compared and slack > before + _BETTER * abs(before)


@dataclass(frozen=True, slots=True, kw_only=True)
class Edge:
    """The fastest trial that is met and the next one above it, None where it is the first one.

    Where none is met, ``best`` is the one that comes nearest, and ``tried`` the slowest and the
    fastest crossover in rad/s that were tried. ``is_first``: no faster one is tried.
    """

    best: Trial
    above: Trial | None
    is_first: bool = False
    tried: tuple[float, float] | None = None


class Search:
    """A law of which something is open, ``fixed`` what is given, and who judges its designs."""

    def __init__(
        self, judge: Judge, law: str, fixed: Mapping[str, float], progress: Progress | None = None
    ) -> None:
        self.judge, self.law, self.fixed, self.progress = judge, law, fixed, progress
        self.sieve = Sieve(judge)

    def fastest(self) -> Edge:
        """Return the fastest crossover that is met."""
        above: Trial | None = None
        nearest: Trial | None = None
        step, better = STEP[coordinates(self.law, self.fixed)], True
        top, bottom = _ends(self.judge.facing)
        wc = top
        while wc > bottom or (better and wc > bottom * _LEAST):
            if self.progress is not None:
                self.progress(f"{self.law}: is everything met at {wc:.4g} rad/s?")
            here = self.at(wc)
            if here.met and above:
                return self._pushed(*self.closed_in(here, above))
            if here.met:
                return Edge(best=here, above=None, is_first=True)
            better = above is None or here.gains_on(above)
            if nearest is None or here.judgement.height > nearest.judgement.height:
                nearest = here
            above = here
            far = min(0.0, here.judgement.height - _FAR) if wc > bottom else -1.0
            wc /= 1 + step * min(_STRIDE, 1 - (_STRIDE - 1) * far)
        if above is None or nearest is None:
            return Edge(best=Trial(wc=top, judgement=self._nowhere(top, 0.0)), above=None)
        return Edge(best=nearest, above=None, tried=(above.wc, top))

    def at(
        self, wc: float, seed: Point | None = None, enough: float = 0.0, *, seeded: bool = False
    ) -> Trial:
        """Return the trial at wc: the first point found of ``enough`` slack, or the best one.

        seed    a point near which to look first;  seeded  only there, but thoroughly
        """
        ms = self.judge.requirements.ms
        of_peak = 0.0 if ms is None else degrees(2 * asin(min(1.0, 1 / (2 * ms)))) - _ROUNDING_DEG
        least = max(self.judge.requirements.pm_deg or 0.0, of_peak)
        calm = self.judge.calm
        freedom = Freedom.of(self.law, self.judge.facing, wc, self.fixed, least, calm=calm)
        if freedom is None:
            return Trial(wc=wc, judgement=self._nowhere(wc, least))
        known: dict[Point, Judgement] = {}

        def height(point: Point) -> float:
            if point not in known:
                if self.progress is not None and known and len(known) % _TOLD == 0:
                    self.progress(f"{self.law}: {len(known)} measured at {wc:.7g} rad/s")
                known[point] = self.judge.of(self.law, freedom.parameters(point), _BY_ITS_SIZE)
                if known[point].slack >= enough:
                    raise HighEnough
            return known[point].height

        with suppress(HighEnough):
            if seed is not None and len(seed) == freedom.size:
                for size in _NEAR[: 3 if seeded else 1]:
                    climb(height, seed, size)
            if not seeded or not known:
                self._look(freedom, height, known)
        best = max(known, key=lambda p: known[p].height)
        return Trial(wc=wc, point=best, parameters=freedom.parameters(best), judgement=known[best])

    def _nowhere(self, wc: float, least: float) -> Judgement:
        """Return that the law cannot give the margin given, or the least one in degrees, at wc."""
        wanted, slow = self.fixed.get("pm_deg", max(least, LEAST_DEG)), ""
        if keeps_zeros_fast(self.law, self.fixed):
            slow = f" with no zero slower than {SLOWEST * warp(wc, self.judge.facing.dt):.4g} rad/s"
            calm = self.judge.calm and self.law != "lag"  # of which every phase is had without
            slow += " and without a pole that rings" if calm else ""
        if self.law == "leadlag" and "lag_ratio" not in self.fixed:
            slow += ", its lead centred (a lag_ratio moves it)"
        failed = f"the law cannot give a margin of {wanted:.4g} deg{slow}"
        return Judgement(slack=_NOWHERE, failed=failed)

    def _look(self, freedom: Freedom, height: Height, known: dict[Point, Judgement]) -> None:
        """Try the points of the grid that a glance leaves, and climb from the best of them.

        Of a plane every other point is tried first; the rest only where not all misses by far.
        """
        points = grid(freedom.size)
        bounds = dict(zip(points, self._bounds(freedom, points), strict=True))
        order = sorted(points, key=lambda p: (bounds[p], p), reverse=True)
        if bounds[order[0]] < _FAR:
            height(order[0])
            return
        left = [point for point in order if bounds[point] >= _FAR]
        first = coarse(left) if freedom.size > 1 else left
        side = 2 if max(map(height, first), default=0.0) < _HOPELESS else 1
        if side == 1:
            for point in left:
                height(point)
        for start in tops({p: known[p].height for p in points if p in known}, side)[:_HILLS]:
            if known[start].height >= _LOW:
                climb(height, start)

    def _bounds(self, freedom: Freedom, points: Sequence[Point]) -> list[float]:
        """Return for each point a bound that its slack is not above, -inf where the law refuses."""
        if not self.sieve.tells or len(points) == 1:
            return [inf] * len(points)
        bounds, some = [-inf] * len(points), list[int]()
        laws = list[SolvedLaw]()
        for i, point in enumerate(points):
            parameters = freedom.parameters(point)
            spec = Crossover(wc=freedom.wc, pm_deg=parameters["pm_deg"])
            with suppress(Infeasible, SpecError):
                laws.append(solved(self.law, self.judge.facing, spec, parameters))
                some.append(i)
        if laws:
            for i, bound in zip(some, self.sieve.slack(laws), strict=True):
                bounds[i] = bound
        return bounds

    def closed_in(self, good: Trial, bad: Trial) -> tuple[Trial, Trial]:
        """Return the edge between a crossover that is met and one on either side that is not."""
        while abs(bad.wc - good.wc) > EDGE * min(good.wc, bad.wc):
            here = self.at((good.wc * bad.wc) ** 0.5, good.point)
            if here.met:
                good = here
            else:
                bad = here
        return good, bad

    def _pushed(self, best: Trial, above: Trial) -> Edge:
        """Return the edge, passed as far as a thorough look around its best point goes."""
        pushes = list(_PUSHES)
        while pushes:
            above = self.at(best.wc * (1 + pushes[0]), best.point, seeded=True)
            if above.met:
                best = above
            else:
                del pushes[0]
        return Edge(best=best, above=above)


def least_ms(pm_deg: float) -> float:
    """Return the least Ms of a margin: |1 + L| is 2 sin(pm/2) at the crossover.

    >>> round(least_ms(60.0), 12)
    1.0
    """
    return 1 / (2 * sin(radians(pm_deg) / 2))


def coordinates(law: str, fixed: Mapping[str, float]) -> int:
    """Return how many coordinates a law has at a crossover."""
    return (law != "p" and "pm_deg" not in fixed) + second_is_open(law, fixed)


def _ends(sampled: Sampled) -> tuple[float, float]:
    """Return the fastest and the slowest crossover to be tried in rad/s."""
    top = _NYQUIST * pi / sampled.dt
    return top, slowest_corner(sampled, top) / _BELOW


def slowest_corner(sampled: Sampled, top: float) -> float:
    """Return the slowest of the plant's corners in rad/s, its delay's among them; top at most.

    >>> slowest_corner(Sampled(num=[1.0], den=[1.0, 0.0, 0.0], dt=0.5), 9.0)
    1.0
    """
    late = [1 / (sampled.delay * sampled.dt)] if sampled.delay else []
    return float(min([top, *late, *sampled.corners().tolist()]))
