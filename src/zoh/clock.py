"""What a sample time costs, and the largest one that still meets the requirements.

The same request is designed and verified at every dt of a grid. A longer dt costs the hold's
wc dt/2 and what the delay grows by; a shorter one costs bits, for zeros and poles crowd around
z = 1. Nothing says that what meets the requirements is one interval of dt: the grid is looked at
from its long end, and the edge beside the first dt that holds is closed in on by halving.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import degrees, pi
from typing import Any

import numpy as np

from zoh import checks
from zoh.analysis.asked import NOTHING_ASKED, OF_TIME, missed
from zoh.analysis.asked import checked as asked_for
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.on_target import not_as_asked
from zoh.analysis.results import Margins, jsonable
from zoh.analysis.word_length import word_length
from zoh.design.sections import SecondOrder, in_series
from zoh.errors import Infeasible, NotMet, SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.pipeline import design
from zoh.request import UNDER_MS, allowed, checked, is_closed
from zoh.sampling.hold import sample
from zoh.solving import by_gain_alone, own_margin, solved
from zoh.spec import Crossover, Requirements
from zoh.workbench import without_cancelled

Seen = tuple[Sampled, Sampled, Margins]  # plant, controller, and what their loop has
Try = Callable[[float], tuple[Seen | None, str | None]]  # a dt: what came of it, why not

TOLERANCE_DEG = 0.1  # by how much rounding the coefficients may move the phase margin
_LONGEST, _SHORTEST = 0.99, 1e-3  # of pi/wc, where the crossover is at Nyquist's frequency
_POINTS = 31  # ten for a factor of 10
# what is wrong at one sample time and not at others
_OF_THE_CLOCK = ("dt", "w0", "zeros_w0", "poles_w0")
EDGE = 1e-9  # of the largest sample time, to which its edge is closed in on


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleTime:
    """What one sample time costs.

    dt         s
    hold_deg   deg, what the hold turns at wc: -wc dt/2
    delay_deg  deg, what the compute delay turns at wc
    pm_deg     deg, measured; None where the law has no solution
    ms         as measured; None likewise
    bits       with which no rounding of the coefficients moves the margin by 0.1 deg; None where
               the loop is unstable, or 53 do not do
    failure    why the requirements are not met; None where they are
    """

    dt: float
    hold_deg: float
    delay_deg: float
    pm_deg: float | None = None
    ms: float | None = None
    bits: int | None = None
    failure: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        return {name: _plain(getattr(self, name)) for name in self.__slots__}


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleTimes:
    """What every sample time of a grid costs.

    rows        the shortest dt first
    largest     s, the largest dt that meets the requirements; None where none of the grid does
    limited_by  what fails just beyond it; None where the longest dt tried holds: ``largest`` is
                then only the longest that was tried
    gaps        s, shorter sample times of the grid that do not meet them
    fineness    the ratio of neighbours in the grid; an island narrower than it is not seen
    """

    rows: tuple[SampleTime, ...]
    largest: float | None
    limited_by: str | None
    gaps: tuple[float, ...]
    fineness: float

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        return {
            "rows": [row.to_dict() for row in self.rows],
            "largest": self.largest,
            "limited_by": self.limited_by,
            "gaps": list(self.gaps),
            "fineness": self.fineness,
        }


def sample_times(
    plant: Plant, law: str, given: Mapping[str, float], *,
    requirements: Requirements = NOTHING_ASKED, compute_delay: float = 0.0,
    delay_samples: float = 0.0, dts: Sequence[float] | None = None,
    sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (), reference: float = 1.0,
    fine: float = EDGE,
) -> SampleTimes:  # fmt: skip
    """Return what each sample time costs, and the largest that meets the requirements.

    law, given     as for ``zoh.design``; wc in rad/s must be among them
    sections, allow, reference  likewise
    compute_delay  s, the same at every dt; delay_samples  dt, in samples, added to it
    dts            s, at least two; None looks at 31 from pi/wc/1000 to just below pi/wc
    fine           of the largest, to which it is closed in on; a loop near its edge is slow to see

    A dt meets them where ``zoh.design`` returns a design; the step response is followed only where
    a requirement is about it. Raises SpecError for what no design function would take.

    >>> plant = Plant(num=[1], den=[1, 1, 0])
    >>> found = sample_times(plant, "pd", {"wc": 2.0, "pm_deg": 60}, dts=[0.01, 0.1, 1.0])
    >>> [(row.dt, round(row.hold_deg, 3), row.failure is None) for row in found.rows]
    [(0.01, -0.573, True), (0.1, -5.73, True), (1.0, -57.296, False)]
    >>> 0.1 < found.largest < 1.0
    True
    """
    if not isinstance(plant, Plant):
        raise SpecError("plant", "must be a zoh.Plant", plant, "a table was taken at one dt")
    words = allowed(allow)
    known = checked(law, given, words)
    wc = checks.positive("wc", known.get("wc"), "give the crossover in rad/s")
    wait = checks.not_negative("compute_delay", compute_delay, "give seconds, 0 or more")
    samples = checks.not_negative("delay_samples", delay_samples, "give samples, 0 or more")
    grid = _grid(dts, wc)
    checks.positive("fine", fine, "1e-7 gives six digits")
    checks.number("reference", reference, "give the size of the step")

    asked = _Asked(
        plant=plant, law=law, given=known, requirements=asked_for(requirements), sections=sections,
        words=words, reference=reference,
    )  # fmt: skip

    def tried(dt: float) -> tuple[Seen | None, str | None]:
        return asked.tried(dt, wait + samples * dt)

    rows = [_row(dt, wc, wait + samples * dt, *tried(dt)) for dt in grid]
    last = max((i for i, row in enumerate(rows) if row.failure is None), default=-1)
    largest: float | None = grid[last] if last >= 0 else None
    limited_by = rows[0].failure if last < 0 else None
    if 0 <= last < len(grid) - 1:
        largest, limited_by = _edge(tried, grid[last], grid[last + 1], fine)
    return SampleTimes(
        rows=tuple(rows), largest=largest, limited_by=limited_by,
        gaps=tuple(row.dt for row in rows[: max(last, 0)] if row.failure is not None),
        fineness=max(b / a for a, b in pairwise(grid)),
    )  # fmt: skip


def _edge(tried: Try, good: float, bad: float, fine: float) -> tuple[float, str | None]:
    """Return the working end of the edge between two sample times, and what fails beyond it."""
    while bad - good > fine * good and good < (middle := (good + bad) / 2) < bad:
        if tried(middle)[1] is None:
            good = middle
        else:
            bad = middle
    return good, tried(bad)[1]


def _grid(dts: Sequence[float] | None, wc: float) -> list[float]:
    if dts is None:
        spaced = np.geomspace(_SHORTEST, _LONGEST, _POINTS) * (pi / wc)
        return [float(dt) for dt in spaced]
    way_out = "give sample times in seconds"
    given = checks.sequence("dts", dts, way_out)
    grid = sorted({checks.positive("dts", dt, way_out) for dt in given})
    if len(grid) < 2:
        raise SpecError("dts", "must have two sample times or more", grid, "[1e-3, 1e-2]")
    return grid


@dataclass(frozen=True, slots=True, kw_only=True)
class _Asked:
    """The request that is made at every sample time."""

    plant: Plant
    law: str
    given: Mapping[str, float]
    requirements: Requirements
    sections: Sequence[SecondOrder]
    words: frozenset[str]
    reference: float

    def tried(self, dt: float, delay: float) -> tuple[Seen | None, str | None]:
        """Return what was measured, where there is a controller, and why it does not do."""
        given, requirements = self.given, self.requirements
        if not given["wc"] * dt < pi:
            return None, "wc is not below the Nyquist frequency pi/dt"
        closed = is_closed(self.law, given) and not any(k in given for k in UNDER_MS)
        closed = closed and ("pm_deg" in given or not self.words)  # a P of wc has either sign
        try:
            if closed and all(getattr(requirements, name) is None for name in OF_TIME):
                return self._by_margins(dt, delay)
            d = design(
                self.plant, self.law, given, dt=dt, compute_delay=delay, sections=self.sections,
                allow=sorted(self.words), requirements=requirements, reference=self.reference,
            )  # fmt: skip
        except NotMet as short:
            d, failure = short.measured, "; ".join(short.misses)
            return (d.sampled, d.controller, d.margins), failure
        except Infeasible as refused:
            return None, refused.reason
        except SpecError as refused:
            if refused.argument not in _OF_THE_CLOCK:  # the request is the trouble
                raise
            return None, str(refused)
        return (d.sampled, d.controller, d.margins), None

    def _by_margins(self, dt: float, delay: float) -> tuple[Seen, str | None]:
        """Return what ``design`` would measure and say, but for the step, which nobody asks about.

        Near the edge of what a law can do its poles come near z = -1, and their ringing is long.
        """
        wc, pm_deg = self.given["wc"], self.given.get("pm_deg")
        spec = None if pm_deg is None else Crossover(wc=wc, pm_deg=pm_deg)  # None: a P of its wc
        plant, _ = without_cancelled(self.plant, self.words)
        fixed, sampled = in_series(self.sections, dt), sample(plant, dt, delay)
        behind = fixed * sampled if fixed else sampled
        law = (
            solved(self.law, behind, spec, self.given, None, self.words)
            if spec
            else by_gain_alone(behind, wc)
        )
        controller = law.controller
        controller = controller * fixed if fixed else controller
        m = measure_loop(Loop.of(controller, sampled))
        asked = spec or own_margin(behind, wc)
        off = not_as_asked(m, asked, lambda w: controller.at(w) * sampled.at(w))
        misses = [*missed(self.requirements, m, None), *off]
        return (sampled, controller, m), "; ".join(misses) or None


def _row(dt: float, wc: float, delay: float, found: Seen | None, failure: str | None) -> SampleTime:
    bits, m = None, None if found is None else found[2]
    if found is not None and m is not None and m.stable and m.crossover:
        bits = word_length(*found, TOLERANCE_DEG)
    return SampleTime(
        dt=dt, hold_deg=-degrees(wc * dt / 2), delay_deg=-degrees(wc * delay),
        pm_deg=None if m is None else m.phase_margin_deg, ms=None if m is None else m.ms,
        bits=bits, failure=failure,
    )  # fmt: skip


def _plain(value: float | str | None) -> float | str | None:
    return jsonable(value) if isinstance(value, float) else value
