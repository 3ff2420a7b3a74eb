"""What a law must do at the crossover: turn the phase, and make up the gain.

At wc the loop must be exp(j (pm - 180 deg)), so the law must be there

    D(j v) = exp(j theta)/|G|,    theta = pm - 180 deg - arg G,    v = (2/dt) tan(wc dt/2)

which is one complex equation. A law answers with the interval of theta it can give with
positive gains; inside it the equation has one solution in closed form, outside none.
Source: C. L. Phillips and H. T. Nagle, Digital Control System Analysis and Design, the chapter
on digital controller design by frequency response.
"""

from cmath import phase
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from heapq import merge
from math import ceil, degrees, floor, log, log10, pi, radians, remainder, sqrt, tau
from typing import Protocol

from zoh.errors import Infeasible, SpecError
from zoh.lti.poly import at
from zoh.lti.systems import Sampled
from zoh.lti.wplane import warp
from zoh.spec import Crossover

_CANCELLED = 1e-13  # of its terms: what is left of a polynomial at its own root, in floats

_STEP, _TURN = 0.03, 0.02  # of a frequency, and rad a sample: between two that are tried
_LEAST = 8e-4  # of wc: the slowest that is tried
_HALVINGS, _FEW = 40, 10  # of a step: where a phase is passed, and where a loop has to be measured
INWARDS = (0, 1, 3, 10)  # units of the seventh digit: where what is printed must work
_MORE = (9, 11, 13)  # digits, where seven do not: what works may be narrower than their last unit
_NONE = 1e-9  # rad, a phase that is none
BELOW, ABOVE = "the phase needed is below what it gives", "the phase needed is above what it gives"

Phases = tuple[float, float] | None  # an open interval in rad, None where a law can give nothing


class Response(Protocol):
    """What a law needs of a plant: its clock, and its complex gain at a frequency."""

    @property
    def dt(self) -> float:
        """Return the sample time in s."""

    def at(self, wc: float, /) -> complex:
        """Return the gain at wc in rad/s."""


class Opposite:
    """A plant that answers the other way round, for a law whose gains are all negative."""

    def __init__(self, plant: Response) -> None:
        self._plant, self.dt = plant, plant.dt

    def at(self, wc: float, /) -> complex:
        """Return the gain at wc in rad/s."""
        return -self._plant.at(wc)


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """One crossover of one plant.

    v      rad/s, wc in the w-plane
    size   |G| at wc
    theta  rad in (-pi, pi], the phase that the law must give
    dt     s
    """

    v: float
    size: float
    theta: float
    dt: float

    @classmethod
    def of(cls, plant: Response, spec: Crossover) -> "Target":
        """Return the target; raise SpecError where wc is not below Nyquist or G(wc) is no gain."""
        spec.below_nyquist(plant.dt)
        g, v = plant.at(spec.wc), warp(spec.wc, plant.dt)
        if isinstance(plant, Sampled):
            _refuse_no_gain(plant, spec.wc, v)
        theta = remainder(radians(spec.pm_deg - 180) - phase(g), tau)
        return cls(v=v, size=abs(g), theta=theta, dt=plant.dt)

    def inside(self, phases: Phases) -> bool:
        """Return whether the phase needed lies in an open interval."""
        return phases is not None and phases[0] < self.theta < phases[1]

    def best_margin_deg(self, phases: Phases, spec: Crossover) -> float | None:
        """Return the largest margin in (0, 180] deg that the interval allows, None if none.

        It is the interval's upper end, approached as near as one likes.
        """
        if phases is None:
            return None
        none = radians(spec.pm_deg) - self.theta  # the margin of a law that turns nothing
        high = remainder(none + phases[1], tau)
        low = high - (phases[1] - phases[0])
        if low < -pi:
            return 180.0  # which is -180 deg, inside
        return degrees(high) if high > 0 else None


def _refuse_no_gain(plant: Sampled, wc: float, v: float) -> None:
    for what, part in (("zero", plant.num_w), ("pole", plant.den_w)):
        if abs(at(part, 1j * v)) <= _CANCELLED * at(list(map(abs, part)), v):
            raise SpecError(
                "wc",
                f"must be where the plant has a gain, not at a {what} on the unit circle",
                wc,
                "move wc away from it",
            )


def refusal(law: str, target: Target, spec: Crossover, phases: Phases, why: str) -> Infeasible:
    """Return why a law cannot: the phases it gives, or ``why`` none, and what is needed."""
    needed = degrees(target.theta)
    gives = why if phases is None else f"turns the phase by {_span(phases)} here"
    asked = f"a margin of {spec.pm_deg:g} deg at {spec.wc:g} rad/s needs {needed:+.4g} deg"
    return Infeasible(
        f"{law} {gives}; {asked} and a gain of {1 / target.size:.4g}",
        needed_deg=needed,
        needed_gain=1 / target.size,
        gives_deg=None if phases is None else (degrees(phases[0]), degrees(phases[1])),
        best_pm_deg=target.best_margin_deg(phases, spec),
    )


def _span(phases: tuple[float, float]) -> str:
    """Return the phases in words; of a P, which has one of them but for rounding, that one."""
    ends = [f"{degrees(end):+.4g}" if abs(end) > _NONE else "0" for end in phases]
    if phases[1] - phases[0] > _NONE:
        return f"{ends[0]} to {ends[1]} deg"
    return f"{ends[0]} deg" if ends[0] != "0" else "nothing"


def nearest(why_not: Callable[[float], str], wc: float, dt: float, late: int = 0) -> float | None:
    """Return the frequency nearest to wc (in log) at which nothing speaks against it, or None.

    Looked for from wc/1000 to 1000 wc, below Nyquist's frequency, 3 % at a time, less
    where the hold and ``late`` samples of delay turn faster; the edge is then closed in on, and
    left on its working side by rounding to seven digits, so that what is printed works too.

    why_not  the reason, "" where there is none; what works may be narrower than a step: where the
             reason changes between two frequencies, it is looked for where it changes
    """
    turn = _TURN / (dt * (1 + late / 4))
    reasons = dict.fromkeys((False, True), why_not(wc))  # below wc, above it
    sides = (_outwards(wc, side, turn, pi / dt) for side in (-1, 1))
    for _, probe, before in merge(*sides):
        there, here = reasons[probe > wc], why_not(probe)
        found = probe if not here else None
        if here and here != there:
            found = _between(why_not, before, probe, there, here)
        if found is not None:
            return _edge(lambda w: not why_not(w), before, found)
        reasons[probe > wc] = here
    return None


def _between(
    why_not: Callable[[float], str], start: float, end: float, there: str, here: str
) -> float | None:
    """Return a frequency that works where one reason gives way to another, None if none is seen."""
    for _ in range(_HALVINGS if {there, here} == {BELOW, ABOVE} else _FEW):
        middle = sqrt(start * end)
        found = why_not(middle)
        if not found:
            return middle
        start, end = (middle, end) if found == there else (start, middle)
    return None


def _outwards(
    wc: float, side: int, turn: float, top: float
) -> Iterator[tuple[float, float, float]]:
    """Yield (how far in log, the frequency, the one before it) on one side of wc."""
    before = wc
    while True:
        probe = before * (1 + min(_STEP, turn / before)) ** side
        if probe == before or not wc * _LEAST < probe < min(top, wc / _LEAST):
            return
        yield abs(log(probe / wc)), probe, before
        before = probe


def _edge(works: Callable[[float], bool], bad: float, good: float) -> float:
    """Return the working end of the edge between bad and good, in seven digits if they work.

    Each trial is a loop measured and proved: none is made that could not change a digit.
    """
    away = 1 if good > bad else -1
    known = False
    for _ in range(40):
        if not known and in_digits(good, away) == in_digits(bad, away):  # all between, too
            known = True
            printed = _printed(works, good, away)
            if printed is not None:
                return printed
        middle = (bad + good) / 2
        if works(middle):
            good = middle
        else:
            bad = middle
    printed = None if known else _printed(works, good, away)
    return in_more_digits(works, good, away) if printed is None else printed


def in_more_digits(works: Callable[[float], bool], good: float, away: int) -> float:
    """Return what works, in as few digits above seven as it does; all of them where none do."""
    rounded = (in_digits(good, away, digits=digits) for digits in _MORE)
    return next(filter(works, rounded), good)


def _printed(works: Callable[[float], bool], good: float, away: int) -> float | None:
    """Return the first of a few that works in seven digits, from good inwards; None if none does.

    Right at the edge a loop may be had by luck: rounding decides there.
    """
    for units in INWARDS:
        w = in_digits(good, away, units)
        if works(w):
            return w
    return None


def in_digits(w: float, away: int, units: int = 0, digits: int = 7) -> float:
    """Return w in some digits, rounded up where ``away`` is 1 and down where it is -1.

    units  of the last digit, that many farther

    >>> in_digits(1.23456789, 1), in_digits(1.23456789, -1, 2), in_digits(1.23456789, 1, digits=3)
    (1.234568, 1.234565, 1.24)
    """
    unit = 10.0 ** (floor(log10(w)) + 1 - digits)
    whole = ceil(w / unit) if away > 0 else floor(w / unit)
    return float(f"{(whole + away * units) * unit:.{digits}g}")
