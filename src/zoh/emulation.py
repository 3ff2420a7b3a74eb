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

from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.results import Margins
from zoh.design.sections import SecondOrder, in_series
from zoh.errors import Infeasible, SpecError
from zoh.lti.poly import times, trim
from zoh.lti.systems import Plant, Sampled, sample_time
from zoh.lti.wplane import unwarp, warp
from zoh.request import check_whole, checked
from zoh.sampling.convert import discretise
from zoh.sampling.hold import sample
from zoh.solving import solved
from zoh.spec import Crossover

CARRIED_BY = ("tustin", "prewarp", "matched", "zoh", "backward", "forward")
EXACT = "exact, in w"
ALONE = "in s, plant alone"
HOLD_COUNTED = "in s, hold as a delay of dt/2"


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
    compute_delay: float = 0.0, sections: Sequence[SecondOrder] = (),
) -> tuple[Emulated, ...]:  # fmt: skip
    """Return the exact design and each emulated one for the same request, measured.

    law, parameters  as for ``zoh.design``, wc in rad/s and pm_deg in deg among them
    dt               s; wc must be below pi/dt, where no emulation is asked to do more
    sections         fixed, in series with the law; in s at the frequencies that they name

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
    known = checked(law, parameters)
    check_whole(law, known, f"to emulate {law}")
    dt = sample_time(dt)
    spec = Crossover(wc=known["wc"], pm_deg=known["pm_deg"]).below_nyquist(dt)
    fixed, sampled = in_series(sections, dt), sample(plant, dt, compute_delay)
    rows = [_exact(law, sampled, fixed, spec, known)]
    for designed, delay in ((ALONE, 0.0), (HOLD_COUNTED, dt / 2 + compute_delay)):
        try:
            continuous = _in_s(law, _InPlaceOfW(plant, dt, delay, sections), spec, known)
        except Infeasible as refused:
            rows.append(_refused(designed, None, _why(law, spec, refused)))
            continue
        rows += [_carried(continuous, designed, m, sampled, spec) for m in CARRIED_BY]
    return tuple(rows)


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


def _in_s(
    law: str, response: _InPlaceOfW, spec: Crossover, parameters: Mapping[str, float]
) -> Plant:
    """Return the law solved in s at s = j wc and the sections, as a continuous controller."""
    at = Crossover(wc=unwarp(spec.wc, response.dt), pm_deg=spec.pm_deg)
    found = solved(law, response, at, {**parameters, "wc": at.wc}).controller
    num, den = trim(found.num_w), found.den_w
    for section in response.fixed:
        num, den = times(num, section.num), times(den, section.den)
    return Plant(num=num, den=den)


def _exact(
    law: str, sampled: Sampled, fixed: Sampled | None, spec: Crossover,
    parameters: Mapping[str, float],
) -> Emulated:  # fmt: skip
    behind = fixed * sampled if fixed else sampled
    try:
        found = solved(law, behind, spec, parameters).controller
    except Infeasible as refused:
        return _refused(EXACT, None, _why(law, spec, refused))
    return _measured(EXACT, None, found * fixed if fixed else found, sampled)


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


def _why(law: str, spec: Crossover, refused: Infeasible) -> str:
    """Return why a law cannot, at the real crossover: in s it was solved at its image in w."""
    return f"{law} cannot give the {refused.needed_deg:+.4g} deg needed at {spec.wc:.6g} rad/s"
