"""What a law must do at the crossover: turn the phase, and make up the gain.

At wc the loop must be exp(j (pm - 180 deg)), so the law must be there

    D(j v) = exp(j theta)/|G|,    theta = pm - 180 deg - arg G,    v = (2/dt) tan(wc dt/2)

which is one complex equation. A law answers with the interval of theta it can give with
positive gains; inside it the equation has one solution in closed form, outside none.
Source: C. L. Phillips and H. T. Nagle, Digital Control System Analysis and Design, the chapter
on digital controller design by frequency response.
"""

from cmath import phase
from collections.abc import Callable
from dataclasses import dataclass
from math import degrees, pi, radians, remainder, tau

from zoh.errors import Infeasible, SpecError
from zoh.lti.poly import at
from zoh.lti.systems import Sampled
from zoh.lti.wplane import warp
from zoh.spec import Crossover

_CANCELLED = 1e-13  # of its terms: what is left of a polynomial at its own root, in floats

Phases = tuple[float, float] | None  # an open interval in rad, None where a law can give nothing


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
    def of(cls, plant: Sampled, spec: Crossover) -> "Target":
        """Return the target; raise SpecError where wc is not below Nyquist or G(wc) is no gain."""
        spec.below_nyquist(plant.dt)
        g, v = plant.at(spec.wc), warp(spec.wc, plant.dt)
        for what, part in (("zero", plant.num_w), ("pole", plant.den_w)):
            if abs(at(part, 1j * v)) <= _CANCELLED * at([abs(c) for c in part], v):
                raise SpecError(
                    "wc",
                    f"must be where the plant has a gain, not at a {what} on the unit circle",
                    spec.wc,
                    "move wc away from it",
                )
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


def refusal(law: str, can: str, target: Target, spec: Crossover, phases: Phases) -> Infeasible:
    """Return why a law cannot, with the phase it would have to give."""
    needed = degrees(target.theta)
    here = "" if phases is None else f" (here {_span(phases)})"
    return Infeasible(
        f"{law} {can}{here}; a margin of {spec.pm_deg:g} deg at {spec.wc:g} rad/s needs "
        f"{needed:+.4g} deg and a gain of {1 / target.size:.4g}",
        needed_deg=needed,
        best_pm_deg=target.best_margin_deg(phases, spec),
    )


def _span(phases: tuple[float, float]) -> str:
    return f"{degrees(phases[0]):+.4g} to {degrees(phases[1]):+.4g} deg"


def nearest(works: Callable[[float], bool], wc: float, dt: float) -> float | None:
    """Return the frequency nearest to wc (in log) at which ``works`` says yes, None if nowhere.

    Looked for from wc outwards, 1 % at a time down to wc/1000 and up to Nyquist's frequency;
    the edge is then closed in on, and the answer is on its working side.
    """
    top = pi / dt
    for step in range(1, 700):
        for wider, nearer in ((1.01**-step, 1.01 ** (1 - step)), (1.01**step, 1.01 ** (step - 1))):
            probe = wc * wider
            if probe < top and works(probe):
                return _edge(works, wc * nearer, probe)
    return None


def _edge(works: Callable[[float], bool], bad: float, good: float) -> float:
    for _ in range(40):
        middle = (bad + good) / 2
        if works(middle):
            good = middle
        else:
            bad = middle
    return good
