"""What a tool got wrong, beside the truth.

Two measures. The strict one asks for PM within 1e-9 deg and everything else within 1e-9 relative.
The generous one asks for PM within 0.1 deg and 1 % of everything else; it accepts a gain margin
that counts z = 1 and z = -1 and one that does not, and it overlooks crossings far below
(1e-3 of) the highest gain crossover, which rounding makes up beside repeated poles at z = 1.
What cannot be decided is counted by neither.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from math import inf, isfinite, log, pi, radians, remainder, tau
from typing import Any

from benchmarks.torture import loops, truth
from benchmarks.torture.delay import QUIET
from benchmarks.torture.loops import Spec
from mpmath import mp, mpf

Crossing = tuple[float, float]
FAULTS = ("PM", "GM", "missed", "invented", "off", "Ms", "stable")
ONLY_STRICT = ("Mt", "disk", "delay")


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """What a tool said of a loop; None where it does not answer that question.

    gm and pm_deg are inf where the tool says that there is none; ``cannot`` names what kept it
    from trying at all (dead time that it does not know), ``error`` an exception; ``own_choice``:
    of several crossings it reports the margin of one by a rule that is not the suite's.
    """

    stable: bool | None = None
    gm: float | None = None
    pm_deg: float | None = None
    ms: float | None = None
    gains: tuple[Crossing, ...] | None = None
    phases: tuple[Crossing, ...] | None = None
    mt: float | None = None
    disk: float | None = None
    delay: float | None = None
    cannot: str | None = None
    error: str | None = None
    own_choice: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """How far off is wrong: deg for the phase margin, relative for the rest."""

    pm_deg: float
    relative: float
    generous: bool


STRICT = Measure(pm_deg=1e-9, relative=1e-9, generous=False)
GENEROUS = Measure(pm_deg=0.1, relative=1e-2, generous=True)
_SAME = 1e-2  # crossings this near to each other, relative, are meant to be one


def faults(spec: Spec, truth: dict[str, Any], said: Answer, by: Measure) -> frozenset[str]:
    """Return which of the figures a tool got wrong; all that it answers, where it failed."""
    if said.cannot:
        return frozenset()
    if said.error:
        return frozenset(("PM", "GM", "missed", "Ms", "stable"))
    true = _Truth(spec, truth, by)
    found = set()
    if said.stable is not None and "stable" not in truth["doubt"]:
        found |= {"stable"} if said.stable != truth["stable"] else set()
    for name, value, goals, near, tolerance in (
        ("GM", said.gm, true.gain_margins(said.own_choice) | true.excused("phases", said.phases),
         _close, by.relative),
        ("PM", said.pm_deg, true.phase_margins(said.own_choice)
         | true.excused("gains", said.gains), _turned, by.pm_deg),
    ):  # fmt: skip
        if value is not None and not any(near(value, goal, tolerance) for goal in goals):
            found.add(name)
    found |= _crossing_faults(true, said, by)
    for name, value, key in (("Ms", said.ms, "modulus"), ("Mt", said.mt, "mt"),
                             ("disk", said.disk, "disk")):  # fmt: skip
        goal = float(truth[key])
        goal = (1 / goal if goal else inf) if name == "Ms" else goal
        at_infinity = by.generous and name == "Ms" and _least_at_infinity(spec, 1 / goal)
        if value is not None and not at_infinity and not _close(value, goal, by.relative):
            found.add(name)
    if said.delay is not None and not any(
        _close(said.delay, goal, by.relative) for goal in true.delays()
    ):
        found.add("delay")
    if by.generous:  # what is right by the strict measure is right
        found &= faults(spec, truth, said, STRICT)
    return frozenset(found)


def _least_at_infinity(spec: Spec, modulus: float) -> bool:
    """Return whether a continuous loop comes nearest to -1 where no frequency is high enough."""
    if spec["form"] != "s":
        return False
    end = spec["num"][0] / spec["den"][0] if len(spec["num"]) == len(spec["den"]) else 0.0
    return _close(abs(1 + end), modulus, 1e-12)


class _Truth:
    """The true crossings of a loop, those that count for sure and those that may."""

    def __init__(self, spec: Spec, truth: dict[str, Any], by: Measure) -> None:
        self.nyquist = pi / spec["dt"] if spec.get("dt") else inf
        self.spec = spec
        self.sure: dict[str, list[Crossing]] = {}
        self.maybe: dict[str, list[Crossing]] = {}
        self.doubt: dict[str, list[Crossing]] = {}
        gains = [float(w) for w, _ in truth["gains"]]
        self.floor = 1e-3 * max(gains, default=0.0) if by.generous else 0.0
        self.quiet = QUIET * 0.99 if spec.get("dead_time") else inf
        for kind in ("gains", "phases"):
            doubt = truth["doubt"].get(kind, [])
            self.sure[kind] = _floats(c for c in truth[kind] if c not in doubt)
            self.doubt[kind] = _floats(doubt)
            self.maybe[kind] = _floats(doubt)
            low = [c for c in self.sure[kind] if c[0] < self.floor]
            self.maybe[kind] += low
            self.sure[kind] = [c for c in self.sure[kind] if c not in low]
        if by.generous:
            outer = [c for c in self.sure["phases"] if self.at_end(c)]
            self.maybe["phases"] += outer
            self.sure["phases"] = [c for c in self.sure["phases"] if c not in outer]

    def at_end(self, c: Crossing) -> bool:
        return c[0] == 0 or c[0] >= self.nyquist * (1 - 1e-9)

    def choices(self, kind: str) -> Iterable[list[Crossing]]:
        """Yield every list of crossings that is a fair reading of the loop, the whole one first."""
        yield self.sure[kind] + self.maybe[kind]
        maybe = self.maybe[kind][:6]
        for n in range(len(maybe) + 1):
            for some in combinations(maybe, n):
                yield [*self.sure[kind], *some]

    def in_doubt(self, kind: str, c: Crossing) -> bool:
        """Return whether a tool's crossing is one that the last bits decide about."""
        return any(_near(c[0], m[0], 3.0) for m in self.doubt[kind])

    def excused(self, kind: str, given: tuple[Crossing, ...] | None) -> set[float]:
        """Return the margins at a tool's crossings that are in doubt: no value there is wrong."""
        return {c[1] for c in given or () if self.in_doubt(kind, c)}

    def gain_margins(self, any_one: bool) -> set[float]:
        found = {
            min((k for _, k in c), key=lambda k: abs(log(k)), default=inf)
            for c in self.choices("phases")
        }
        return found | {k for _, k in self.sure["phases"] if any_one}

    def phase_margins(self, any_one: bool) -> set[float]:
        found = {min((pm for _, pm in c), key=abs, default=inf) for c in self.choices("gains")}
        return found | {pm for _, pm in self.sure["gains"] if any_one}

    def delays(self) -> set[float]:
        """Return the delay margins; what is loud to the end bears less than a sample, or none."""
        dt = self.spec.get("dt") or 0.0
        size = self.loudness()
        # what a hold makes is rounded: there the last bits of 16 digits decide whether it is 1
        in_doubt = self.spec["form"] == "params" and abs(size - 1) < 1e-12
        ends = ([dt], []) if in_doubt else ([dt],) if size >= 1 else ([],)
        return {
            min([radians(pm) % tau / w if pm else 0.0 for w, pm in c] + end, default=inf)
            for c in self.choices("gains")
            for end in ends
        }

    def loudness(self) -> float:
        """Return |L| at the highest frequency."""
        with mp.workdps(truth.WORK):
            loop = loops.exact_loop(self.spec)
            if loop.dt is not None:
                _, _, top, bottom = loop.ends()[1]
            else:
                top = loop.num[-1] if len(loop.num) == len(loop.den) else 0
                bottom = loop.den[-1]
            return float(abs(mpf(top) / bottom)) if bottom else inf


def _crossing_faults(true: _Truth, said: Answer, by: Measure) -> set[str]:
    found = set()
    for kind, given in (("gains", said.gains), ("phases", said.phases)):
        if given is None:
            continue
        pairs, missed, invented = paired(true.sure[kind], list(given))
        if kind == "phases":  # a dead time's turns are not listed for ever
            missed = [c for c in missed if c[1] < true.quiet]
            invented = [c for c in invented if c[1] < true.quiet]
        allowed = [
            c for c in invented
            if c[0] < true.floor or (by.generous and kind == "phases" and true.at_end(c))
            or true.in_doubt(kind, c)
        ]  # fmt: skip
        found |= {"missed"} if missed else set()
        found |= {"invented"} if len(invented) > len(allowed) else set()
        for a, b in () if by.generous else pairs:
            off = a[0] != b[0] and not _close(b[0], a[0], by.relative)
            if kind == "gains":
                off = off or not _turned(b[1], a[1], by.pm_deg)
            else:
                off = off or not _close(b[1], a[1], by.relative)
            found |= {"off"} if off else set()
    return found


def paired(
    one: list[Crossing], two: list[Crossing]
) -> tuple[list[tuple[Crossing, Crossing]], list[Crossing], list[Crossing]]:
    """Return (pairs, left of one, left of two): the nearest take each other, within _SAME."""
    near = sorted(
        (0.0 if a[0] == b[0] else abs(a[0] - b[0]) / max(a[0], b[0]), i, j)
        for i, a in enumerate(one)
        for j, b in enumerate(two)
        if a[0] == b[0] or abs(a[0] - b[0]) <= _SAME * max(a[0], b[0]) < inf
    )
    free, pairs = (set(range(len(one))), set(range(len(two)))), []
    for _, i, j in near:
        if i in free[0] and j in free[1]:
            free[0].remove(i)
            free[1].remove(j)
            pairs.append((one[i], two[j]))
    return pairs, [one[i] for i in sorted(free[0])], [two[j] for j in sorted(free[1])]


def _floats(pairs: Iterable[Iterable[str]]) -> list[Crossing]:
    return [(float(w), float(x)) for w, x in pairs]


def _near(a: float, b: float, factor: float) -> bool:
    return a == b or (min(a, b) > 0 and max(a, b) / min(a, b) < factor)


def _close(value: float, goal: float, relative: float) -> bool:
    if not (isfinite(goal) and isfinite(value)):
        return value == goal
    return abs(value - goal) <= relative * abs(goal)


def _turned(value: float, goal: float, pm_deg: float) -> bool:
    if not (isfinite(goal) and isfinite(value)):
        return value == goal
    return abs(remainder(value - goal, 360.0)) <= pm_deg
