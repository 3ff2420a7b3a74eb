"""Requirements on every loop of a batch at once: the same bounds as those of a single design."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from zoh.analysis.asked import Compared, checked
from zoh.batch.columns import Results
from zoh.batch.reason import Reason
from zoh.errors import SpecError
from zoh.spec import Requirements

Bools = npt.NDArray[np.bool_]
Values = npt.NDArray[np.float64]

NOTHING_ASKED = Requirements()
_EQUAL = 1e-9  # what equals a bound but for rounding meets it, as in the single design


@dataclass(frozen=True, slots=True, kw_only=True)
class _Rule:
    """The column that a requirement is about, what of it is compared, and in which direction."""

    column: str
    at_least: bool
    of: Callable[[Values], Values] = np.asarray


def _size_db(factor: Values) -> Values:
    size: Values = np.abs(20 * np.log10(factor))
    return size


RULES: Mapping[str, _Rule] = {
    "pm_deg": _Rule(column="phase_margin_deg", at_least=True),
    "gain_margin_db": _Rule(column="gain_margin", at_least=True, of=_size_db),
    "delay_margin": _Rule(column="delay_margin", at_least=True),
    "ms": _Rule(column="ms", at_least=False),
    "mt": _Rule(column="mt", at_least=False),
    "bandwidth": _Rule(column="bandwidth", at_least=True),
    "overshoot_pct": _Rule(column="between.overshoot_pct", at_least=False),
    "rise_time": _Rule(column="rise_time", at_least=False),
    "settling_time": _Rule(column="settling_time", at_least=False),
    "steady_state_error": _Rule(column="steady_state_error", at_least=False, of=np.abs),
    "peak_effort": _Rule(column="peak_effort", at_least=False),
}
"""The requirements that a batch can look at."""


def asked(requirements: Requirements) -> dict[str, float]:
    """Return the bounds that are given; raise SpecError for one that a batch does not measure."""
    given = {name: getattr(checked(requirements), name) for name in Requirements.__slots__}
    bounds = {name: float(bound) for name, bound in given.items() if bound is not None}
    for name, bound in bounds.items():
        if name not in RULES:
            way_out = f"a sweep looks at {', '.join(RULES)}"
            raise SpecError(f"requirements.{name}", "must be left out of a sweep", bound, way_out)
    return bounds


def keeps(name: str, bound: float, results: Results) -> Bools:
    """Return which loops keep one bound; what does not exist keeps none.

    >>> results = {"ms": np.array([1.5, 2.0 + 1e-12, 2.1, np.nan])}
    >>> keeps("ms", 2.0, results).tolist()
    [True, True, False, False]
    """
    rule = RULES[name]
    with np.errstate(all="ignore"):
        value = rule.of(results[rule.column].astype(np.float64, copy=False))
    rounding = _EQUAL * abs(bound)
    kept: Bools = value >= bound - rounding if rule.at_least else value <= bound + rounding
    return kept


def met(requirements: Requirements, results: Results) -> Bools:
    """Return which loops are as asked for and keep every bound."""
    good: Bools = results["reason"] == Reason.OK
    for name, bound in asked(requirements).items():
        good = good & keeps(name, bound, results)
    return good


def sentence(name: str, bound: float, results: Results) -> str:
    """Return a requirement and what the first loop has, in words.

    >>> sentence("ms", 2.0, {"ms": np.array([2.5])})
    'ms must be at most 2, measured 2.5'
    """
    rule = RULES[name]
    value = float(rule.of(results[rule.column].astype(np.float64, copy=False))[0])
    return Compared(name=name, bound=bound, value=value, at_least=rule.at_least).sentence
