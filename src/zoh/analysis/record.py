"""What the records of a measured loop have in common, be it measured on a model or a table."""

from cmath import exp
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import radians
from typing import Any

from zoh import checks
from zoh.analysis.results import Gains, Margins
from zoh.errors import SpecError
from zoh.lti.forms import forms, sentences
from zoh.lti.systems import Sampled
from zoh.lti.written import fraction, number
from zoh.spec import Requirements

_SAME_GAIN = 1e-6  # two roads to one gain; they differ by rounding, another loop by far more


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """One loop: its labels, its controller, what was asked and what of it was missed.

    law, gains, name  labels
    controller        as given
    compute_delay     s, from sampling to output
    misses            one sentence for each requirement missed; empty where all is met
    """

    name: str
    law: str
    gains: Mapping[str, float]
    controller: Sampled
    compute_delay: float
    requirements: Requirements
    misses: tuple[str, ...] = ()

    @property
    def dt(self) -> float:
        """Return the sample time in s."""
        return self.controller.dt

    @property
    def forms(self) -> dict[str, Any]:
        """Return the gains in parallel, standard and series form; {} for a law without kp."""
        return forms(self.gains)

    @property
    def met(self) -> bool:
        """Return whether everything asked is met, stability first."""
        return not self.misses

    def _labels(self) -> dict[str, Any]:
        """Return the JSON form of what was designed."""
        return {
            "name": self.name,
            "law": self.law,
            "feasible": True,
            "reason": None,
            "gains": dict(self.gains),
            "forms": self.forms,
            "controller": coefficients(self.controller),
        }

    def _head(self, m: Margins, undecided: str) -> list[str]:
        """Return the first lines of a report, up to the gain margin."""
        gains = ", ".join(f"{k} = {number(v)}" for k, v in self.gains.items())
        controller = fraction(self.controller.num, self.controller.den, "z")
        verdict = {True: "stable", False: "UNSTABLE", None: undecided}[m.stable]
        return [
            f"{self.name}: {self.law}" + (f" with {gains}" if gains else ""),
            *(f"  {sentence}" for sentence in sentences(self.gains)),
            f"  D(z) = {controller}, dt = {self.dt:g} s",
            f"  closed loop {verdict}",
            f"  phase margin {m.phase_margin_deg:.6g} deg at {or_no(m.crossover)} rad/s,"
            f" gain margin {m.gain_margin_db:.4g} dB at {or_no(m.phase_crossover)} rad/s",
        ]


def coefficients(system: Sampled) -> dict[str, Any]:
    """Return the JSON form of a sampled system."""
    return {
        "num": list(system.num),
        "den": list(system.den),
        "dt": system.dt,
        "num_w": list(system.num_w),
        "den_w": list(system.den_w),
    }


def or_no(value: float | None) -> str:
    """Return a number in six digits, or that there is none.

    >>> or_no(1.5), or_no(None)
    ('1.5', 'no')
    """
    return "no" if value is None else f"{value:.6g}"


def crosses(gain: Callable[[float], complex], crossings: Iterable[tuple[float, float]]) -> bool:
    """Return whether a loop with this gain has these crossings, (rad/s, phase margin in deg).

    >>> crosses(lambda w: -1j / w, [(1.0, 90.0)]), crosses(lambda w: -1j / w, [(1.0, 80.0)])
    (True, False)
    """
    return all(abs(gain(wc) + exp(1j * radians(pm))) <= _SAME_GAIN for wc, pm in crossings)


def labels(law: str, gains: Mapping[str, float] | None, name: str | None) -> dict[str, Any]:
    """Return law, gains and name, checked."""
    law = checks.text("law", law)
    label = law if name is None else checks.text("name", name)
    return {"law": law, "gains": _checked(gains), "name": label or law}


def _checked(gains: Mapping[str, float] | None) -> Gains:
    if isinstance(gains, Gains):
        return gains
    if gains is None:
        gains = {}
    if not isinstance(gains, Mapping):
        raise SpecError("gains", "must name each gain", gains, 'such as {"kp": 2.0}')
    return Gains(
        {checks.text("gains", k): checks.number(f"gains[{k!r}]", v) for k, v in gains.items()}
    )
