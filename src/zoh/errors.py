"""What can go wrong, each with its numbers.

Every error that zoh raises on purpose is a ``ZohError`` (a ``ValueError``) whose text is one
line that names the argument, the bound, the value and a way out.
"""

import sys
from collections.abc import Iterable
from math import floor, log10
from types import FrameType
from typing import Any
from warnings import warn


class ZohError(ValueError):
    """The base of everything zoh raises on purpose."""


class SpecError(ZohError):
    """A request is malformed.

    ``argument`` is what was passed (a name or a dotted key), ``bound`` what it must be,
    ``value`` what it was, ``way_out`` what to do instead.

    >>> raise SpecError("dt", "must be above 0", -1.0, "give the sample time in seconds")
    Traceback (most recent call last):
    zoh.errors.SpecError: dt must be above 0, got -1.0: give the sample time in seconds
    """

    def __init__(self, argument: str, bound: str, value: object, way_out: str) -> None:
        self.argument, self.bound, self.value, self.way_out = argument, bound, value, way_out
        super().__init__(f"{argument} {bound}, got {shown(value)}: {way_out}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.argument, self.bound, self.value, self.way_out)


class Infeasible(ZohError):
    """A request is well formed, but this law cannot meet it.

    needed_deg     the phase in degrees, in (-180, 180], that the law would have to give at wc
    needed_gain    the gain it would have to give there, None where wc is not given
    gives_deg      the open interval of phases in degrees that it can give there with positive
                   gains, None where it gives none
    best_pm_deg    a phase margin in degrees of a stable loop of this law that crosses over at
                   this wc, the largest but for some 1e-6; None where there is none
    nearest_wc     the crossover in rad/s nearest to the requested one at which this law meets the
                   request, None where there is none
    laws_that_can  the names of the laws that meet the request as it stands

    The request of these three is the law, its parameters, wc and pm_deg: requirements besides are
    not counted where nothing was left open. Where something was, they are, and all that is open
    was searched: there is no better margin to name, nor a nearest crossover where wc was open.

    A law's own ``solve`` knows nothing of stability: its ``best_pm_deg`` is the end of the phases,
    which is approached as near as one likes and not attained.
    """

    def __init__(
        self,
        reason: str,
        *,
        needed_deg: float,
        needed_gain: float | None = None,
        gives_deg: tuple[float, float] | None = None,
        best_pm_deg: float | None = None,
        nearest_wc: float | None = None,
        laws_that_can: tuple[str, ...] = (),
    ) -> None:
        self.reason = reason
        self.needed_deg = needed_deg
        self.needed_gain = needed_gain
        self.gives_deg = gives_deg
        self.best_pm_deg = best_pm_deg
        self.nearest_wc = nearest_wc
        self.laws_that_can = laws_that_can
        super().__init__("; ".join([reason, *self._advice()]))

    def because(self, more: str) -> "Infeasible":
        """Return the same refusal with one more reason, itself where that is empty."""
        if not more:
            return self
        fields = {name: value for name, value in vars(self).items() if name != "reason"}
        return _infeasible(f"{self.reason}; {more}", fields)

    def __reduce__(self) -> tuple[Any, ...]:
        fields = {name: value for name, value in vars(self).items() if name != "reason"}
        return _infeasible, (self.reason, fields)

    def _advice(self) -> list[str]:
        advice = []
        if self.best_pm_deg is not None:
            advice.append(f"the best margin it can give here is {_below(self.best_pm_deg)} deg")
        if self.nearest_wc is not None:
            short = f"{self.nearest_wc:.7g}"  # where those digits are all of it, as they mostly are
            wc = short if float(short) == self.nearest_wc else repr(self.nearest_wc)
            advice.append(f"the nearest crossover where it can is {wc} rad/s")
        if self.laws_that_can:
            advice.append(f"laws that can here: {', '.join(self.laws_that_can)}")
        return advice


def _below(pm_deg: float) -> str:
    """Return a margin in four digits, never more than it is but for rounding.

    >>> _below(129.26423), _below(45 - 1e-6), _below(45.0), _below(8.04 * 3), _below(0.0)
    ('129.2', '44.99', '45', '24.12', '0')
    """
    short = f"{pm_deg:.4g}"
    if float(short) <= pm_deg + 1e-12 * abs(pm_deg):
        return short
    return f"{float(short) - 10.0 ** (floor(log10(abs(pm_deg))) - 3):.4g}"


class AccuracyWarning(UserWarning):
    """A figure is not what it seems: rounding of z-coefficients has lost it, or no proof holds."""


def warn_of_accuracy(sentences: Iterable[str]) -> None:
    """Warn of each sentence at the line that called this package, however deep inside it is."""
    for sentence in sentences:
        frame: FrameType | None = sys._getframe(1)
        level = 2
        while frame is not None and frame.f_globals.get("__name__", "").split(".")[0] == "zoh":
            frame, level = frame.f_back, level + 1
        warn(sentence, AccuracyWarning, stacklevel=level)


class NotMet(ZohError):
    """A design, or a given controller, that fails its requirements.

    ``misses`` has one sentence for each requirement missed; ``measured`` is the evidence
    (a ``zoh.analysis.verify.Measured``), so that what was found is not lost; ``way_out`` says
    what to ask for instead, "" where nothing is known.
    """

    def __init__(self, misses: tuple[str, ...], measured: Any, way_out: str = "") -> None:
        self.misses = misses
        self.measured = measured
        self.way_out = way_out
        super().__init__("not met: " + "; ".join([*misses, *([way_out] if way_out else [])]))

    def advising(self, more: str) -> "NotMet":
        """Return the same with one more way out, itself where that is empty."""
        if not more:
            return self
        ways = [self.way_out, more] if self.way_out else [more]
        return NotMet(self.misses, self.measured, "; ".join(ways))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.misses, self.measured, self.way_out)


class Unequal(ZohError):
    """Firmware that is not what was verified: ``differences`` has one sentence for each.

    ``found`` is the ``zoh.Equality`` that does not hold, with all that was measured.
    """

    def __init__(self, differences: tuple[str, ...], found: Any) -> None:
        self.differences = differences
        self.found = found
        super().__init__("the firmware is not the design: " + "; ".join(differences))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.differences, self.found)


def _infeasible(reason: str, fields: dict[str, Any]) -> Infeasible:
    return Infeasible(reason, **fields)


def shown(value: object, longest: int = 60) -> str:
    """Return ``value`` as one short line.

    >>> shown("a" * 100, longest=8)
    "'aaaa..."
    """
    text = " ".join(repr(value).split())
    return text if len(text) <= longest else text[: longest - 3] + "..."
