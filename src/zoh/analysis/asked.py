"""What was asked against what was measured."""

from dataclasses import dataclass

from zoh.analysis.results import Margins, StepInfo
from zoh.errors import SpecError
from zoh.spec import Requirements

OF_TIME = (
    "overshoot_pct", "rise_time", "settling_time", "steady_state_error", "peak_effort",
    "effort_min", "effort_max", "noise_gain",
)  # fmt: skip
"""The requirements that only a response in time shows."""

NOTHING_ASKED = Requirements()
_EQUAL = 1e-9  # 6 x 0.1 s is 0.6000000000000001: what equals a bound but for rounding meets it


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """One requirement beside what was measured; value None is what does not exist.

    at_least  whether the bound is the smallest value allowed, not the largest
    """

    name: str
    bound: float
    value: float | None
    at_least: bool

    @property
    def slack(self) -> float:
        """Return how far the value is inside its bound, relative; below 0 where it is outside.

        >>> Compared(name="ms", bound=2.0, value=1.5, at_least=False).slack
        0.25
        """
        if self.value is None:
            return -1.0
        room = self.value - self.bound if self.at_least else self.bound - self.value
        return room / abs(self.bound) if self.bound else room

    @property
    def met(self) -> bool:
        """Return whether the bound is kept, or missed by rounding alone."""
        if self.value is None:
            return False
        rounding = _EQUAL * abs(self.bound)
        if self.at_least:
            return self.value >= self.bound - rounding
        return self.value <= self.bound + rounding

    @property
    def sentence(self) -> str:
        """Return the requirement and the value in words, with the digits that tell them apart.

        >>> Compared(name="ms", bound=1.6, value=1.60000012, at_least=False).sentence
        'ms must be at most 1.6, measured 1.6000001'
        """
        shown = "none" if self.value is None else _apart(self.value, self.bound)
        return f"{self.demand}, measured {shown}"

    @property
    def demand(self) -> str:
        """Return the requirement in words.

        >>> Compared(name="ms", bound=1.6, value=None, at_least=False).demand
        'ms must be at most 1.6'
        """
        word = "at least" if self.at_least else "at most"
        bound = f"{self.bound:g}"
        bound = bound if float(bound) == self.bound else repr(self.bound)
        return f"{self.name} must be {word} {bound}"


def _apart(value: float, bound: float) -> str:
    """Return the value in six digits, or as many more as show on which side of the bound it is."""
    texts = (f"{value:.{digits}g}" for digits in range(6, 18))
    above, below = value > bound, value < bound
    shown = (t for t in texts if (float(t) > bound, float(t) < bound) == (above, below))
    return next(shown, repr(value))


def checked(asked: object) -> Requirements:
    """Return ``asked`` as it is; raise SpecError unless it is a ``Requirements``."""
    if not isinstance(asked, Requirements):
        way_out = "zoh.Requirements(ms=1.8)"
        raise SpecError("requirements", "must be zoh.Requirements", asked, way_out)
    return asked


def missed(
    asked: Requirements, margins: Margins, step: StepInfo | None, noise_gain: float | None = None
) -> list[str]:
    """Return a sentence for each requirement missed, instability first."""
    if margins.stable is None:
        return ["the closed loop is not proved to be stable"]
    if not margins.stable:
        return ["the closed loop is unstable"]
    if asked is NOTHING_ASKED or asked == NOTHING_ASKED:  # nearly always that very one
        return []
    found = of_margins(asked, margins)
    if step is not None:
        found += of_time(asked, step, noise_gain)
    return [row.sentence for row in found if not row.met]


def of_margins(asked: Requirements, margins: Margins) -> list[Compared]:
    """Return the requirements on the open loop that were asked, beside what was measured."""
    return _asked(
        ("pm_deg", asked.pm_deg, margins.phase_margin_deg, True),
        ("gain_margin_db", asked.gain_margin_db, abs(margins.gain_margin_db), True),
        ("delay_margin", asked.delay_margin, margins.delay_margin, True),
        ("ms", asked.ms, margins.ms, False),
        ("mt", asked.mt, margins.mt, False),
        ("bandwidth", asked.bandwidth, margins.bandwidth, True),
    )


def of_time(asked: Requirements, step: StepInfo, noise_gain: float | None) -> list[Compared]:
    """Return the requirements on the responses that were asked, beside what was measured.

    A time of 0 at the samples, a jump from one to the next, is what it is between them.
    """
    between = step.between_samples or step
    error = None if step.steady_state_error is None else abs(step.steady_state_error)
    return [
        *_asked(
            ("overshoot_pct", asked.overshoot_pct, between.overshoot_pct, False),
            ("rise_time", asked.rise_time, step.rise_time or between.rise_time, False),
            ("settling_time", asked.settling_time, step.settling_time, False),
            ("steady_state_error", asked.steady_state_error, error, False),
        ),
        *of_effort(asked, step),
        *_asked(("noise_gain", asked.noise_gain, noise_gain, False)),
    ]


def of_effort(asked: Requirements, step: StepInfo) -> list[Compared]:
    """Return the requirements on the effort that were asked, beside what was measured."""
    least, most = step.effort_range or (None, None)
    return _asked(
        ("peak_effort", asked.peak_effort, step.peak_effort, False),
        ("effort_min", asked.effort_min, least, True),
        ("effort_max", asked.effort_max, most, False),
    )


def _asked(*rows: tuple[str, float | None, float | None, bool]) -> list[Compared]:
    return [
        Compared(name=name, bound=bound, value=value, at_least=at_least)
        for name, bound, value, at_least in rows
        if bound is not None
    ]
