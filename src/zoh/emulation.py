"""The price of emulation: a controller designed in s, carried over to z, and what it really has.

With s in the place of w a law is its continuous self: kp + ki/s, the PID's filter at s = -2/dt,
the corners of a lead. So the continuous design is the law solved on P(j wc) where the exact one is
solved on the sampled plant, and its Tustin form is that same law read in w. Two such designs
are carried over by each method: one on the plant alone, as if the loop were continuous, and one
on the plant with the hold counted as a delay of dt/2 and the compute delay with it. What they
are worth is measured in the sampled loop.
Source: G. F. Franklin, J. D. Powell and M. L. Workman, Digital Control of Dynamic Systems, 3rd
ed., ch. 6 (design by emulation and discrete equivalents).
"""

from cmath import exp
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from zoh.analysis.load_error import load_iae
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.results import Margins
from zoh.design.sections import SecondOrder, in_series
from zoh.errors import Infeasible, SpecError
from zoh.lti.poly import times, trim
from zoh.lti.systems import Plant, Sampled, sample_time
from zoh.lti.wplane import unwarp, warp
from zoh.request import UNDER_MS, allowed, check_whole, checked
from zoh.sampling.convert import discretise
from zoh.sampling.hold import sample
from zoh.solving import solved
from zoh.spec import Crossover
from zoh.workbench import without_cancelled

CARRIED_BY = ("tustin", "prewarp", "matched", "zoh", "backward", "forward")
EXACT = "exact, in w"
ALONE = "in s, plant alone"
HOLD_COUNTED = "in s, hold as a delay of dt/2"
_NO_KI = "its ki is that of the exact design, and there is none"


@dataclass(frozen=True, slots=True, kw_only=True)
class Emulated:
    """One way to a sampled controller, and what its loop really has.

    designed    how the law was solved: exactly in w, or in s with or without the hold's delay
    method      how it came to z, one of ``CARRIED_BY``; None for the exact design, and for one
                that the law cannot make
    controller  None where there is none, and ``reason`` says why
    margins     measured in the sampled loop; None without a controller
    """

    designed: str
    method: str | None
    controller: Sampled | None = None
    margins: Margins | None = None
    reason: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        law, m = self.controller, self.margins
        return {
            "designed": self.designed,
            "method": self.method,
            "controller": None if law is None else {"num": list(law.num), "den": list(law.den)},
            "margins": None if m is None else m.to_dict(),
            "reason": self.reason,
        }


def emulate(
    plant: Plant, law: str, parameters: Mapping[str, float], *, dt: float,
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (), allow: Sequence[str] = (),
) -> tuple[Emulated, ...]:  # fmt: skip
    """Return the exact design and each emulated one for the same request, measured.

    law, parameters  as for ``zoh.design``, wc in rad/s and pm_deg in deg among them
    dt               s; wc must be below pi/dt, where no emulation is asked to do more
    sections         fixed, in series with the law; in s at the frequencies that they name
    allow            as for ``zoh.design``

    In s a PID with ``largest_ki_ms`` or ``least_iae_ms`` has the ki of the exact design.
    A design that the law cannot make, and a method that cannot carry it over, leave a row with
    the reason. Raises SpecError for what no design function would take.

    >>> rows = emulate(Plant(num=[1], den=[1, 1, 0]), "pd", {"wc": 2.0, "pm_deg": 50}, dt=0.2)
    >>> for row in rows[:2]:
    ...     print(row.designed, row.method, round(row.margins.phase_margin_deg, 6))
    exact, in w None 50.0
    in s, plant alone tustin 38.792317
    """
    if not isinstance(plant, Plant):
        raise SpecError("plant", "must be a zoh.Plant", plant, "a table has no form in s")
    words = allowed(allow)
    known = checked(law, parameters, words)
    check_whole(law, known, f"to emulate {law}")
    dt = sample_time(dt)
    spec = Crossover(wc=known["wc"], pm_deg=known["pm_deg"]).below_nyquist(dt)
    plant, _ = without_cancelled(plant, words)
    asked = _Asked(
        plant=plant, law=law, spec=spec, words=words, compute_delay=compute_delay,
        fixed=in_series(sections, dt), sampled=sample(plant, dt, compute_delay),
    )  # fmt: skip
    exact = asked.exact(known)
    rows = [exact.row]
    if any(name in exact.parameters for name in UNDER_MS):
        return (*rows, *(_refused(designed, None, _NO_KI) for designed in (ALONE, HOLD_COUNTED)))
    for designed, delay in ((ALONE, 0.0), (HOLD_COUNTED, dt / 2 + compute_delay)):
        try:
            continuous = asked.in_s(_InPlaceOfW(plant, dt, delay, sections), exact.parameters)
        except Infeasible as refused:
            rows.append(_refused(designed, None, asked.why(refused)))
            continue
        rows += [_carried(continuous, designed, m, asked.sampled, spec) for m in CARRIED_BY]
    return tuple(rows)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Exact:
    """The row of the exact design, and the parameters that it is to be made with in s."""

    row: Emulated
    parameters: Mapping[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Asked:
    """The request that is made in w and in s."""

    plant: Plant
    law: str
    spec: Crossover
    words: frozenset[str]
    compute_delay: float
    fixed: Sampled | None
    sampled: Sampled

    def exact(self, parameters: Mapping[str, float]) -> _Exact:
        """Return the exact design; a ki that is searched for there is the same one in s."""
        fixed = self.fixed
        behind = fixed * self.sampled if fixed else self.sampled
        try:
            found = solved(self.law, behind, self.spec, parameters, self._iae, self.words)
        except Infeasible as refused:
            return _Exact(row=_refused(EXACT, None, self.why(refused)), parameters=parameters)
        whole = found.controller * fixed if fixed else found.controller
        known = dict(parameters)
        for name in UNDER_MS:
            if known.pop(name, None) is not None:
                known["ki"] = found.gains["ki"]
        return _Exact(row=_measured(EXACT, None, whole, self.sampled), parameters=known)

    def in_s(self, response: "_InPlaceOfW", parameters: Mapping[str, float]) -> Plant:
        """Return the law solved in s at s = j wc and the sections, as a continuous controller."""
        at = Crossover(wc=unwarp(self.spec.wc, response.dt), pm_deg=self.spec.pm_deg)
        known = {**parameters, "wc": at.wc}
        found = solved(self.law, response, at, known, None, self.words).controller
        num, den = trim(found.num_w), found.den_w
        for section in response.fixed:
            num, den = times(num, section.num), times(den, section.den)
        return Plant(num=num, den=den)

    def why(self, refused: Infeasible) -> str:
        """Return why the law cannot, at the real crossover: in s it is solved at its image in w."""
        needed = f"{refused.needed_deg:+.4g} deg needed at {self.spec.wc:.6g} rad/s"
        return f"{self.law} cannot give the {needed}"

    def _iae(self, law: Sampled) -> float:
        whole = law * self.fixed if self.fixed else law
        return load_iae(self.plant, whole, self.compute_delay)


class _InPlaceOfW:
    """The continuous plant where a law expects a sampled one: s stands in the place of w."""

    def __init__(
        self, plant: Plant, dt: float, delay: float, sections: Sequence[SecondOrder]
    ) -> None:
        self._plant, self._delay, self.dt = plant, delay, dt
        self.fixed = [section.in_s() for section in sections]

    def at(self, wc: float, /) -> complex:
        """Return P(j v) exp(-j v delay) and the sections at the v that wc is in the w-plane."""
        v = warp(wc, self.dt)
        gain = self._plant.at(v) * exp(-1j * v * self._delay)
        for section in self.fixed:
            gain *= section.at(v)
        return gain


def _carried(
    continuous: Plant, designed: str, method: str, sampled: Sampled, spec: Crossover
) -> Emulated:
    prewarp = spec.wc if method == "prewarp" else None
    try:
        found = discretise(continuous, sampled.dt, method, prewarp)
    except SpecError as refused:
        return _refused(designed, method, str(refused))
    return _measured(designed, method, found, sampled)


def _measured(designed: str, method: str | None, law: Sampled, sampled: Sampled) -> Emulated:
    margins = measure_loop(Loop.of(law, sampled))
    return Emulated(designed=designed, method=method, controller=law, margins=margins)


def _refused(designed: str, method: str | None, reason: str) -> Emulated:
    return Emulated(designed=designed, method=method, reason=reason)
