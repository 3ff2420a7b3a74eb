"""P controllers, D = kp: one degree of freedom, so wc or the margin, not both.

Where the plant's own phase is pm - 180 deg the gain is 1/|G|; the fastest such crossover comes
first.
Source: K. J. Astrom and R. M. Murray, Feedback Systems, 2nd ed., sec. 10.3 (the phase margin
read off the open loop).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import copysign, pi, radians, remainder, tau

import numpy as np
import numpy.typing as npt

from zoh.design.target import Phases, Response, Target, refusal
from zoh.lti.poly import roots as poly_roots
from zoh.lti.systems import Sampled
from zoh.spec import Crossover

_SAME = 1e-12  # rad; a phase this near to the one asked for is that one


@dataclass(frozen=True, slots=True, kw_only=True)
class P:
    """kp in u/y; dt in s."""

    kp: float
    dt: float

    @property
    def gains(self) -> Mapping[str, float]:
        """Return the gains by name."""
        return {"kp": self.kp}

    def controller(self) -> Sampled:
        """Return the same controller in z and in w."""
        return Sampled(num=(self.kp,), den=(1.0,), dt=self.dt)


def phases(target: Target) -> Phases:
    """Return the phases that a P can give: 0."""
    return -_SAME, _SAME


def solve(plant: Response, spec: Crossover, *, any_sign: bool = False) -> P:
    """Return kp = 1/|G(wc)|; raise Infeasible unless the plant alone has the margin there.

    With ``any_sign`` the plant's opposite will do, and kp is negative.

    >>> plant = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)
    >>> solve(plant, Crossover(wc=pi / 2, pm_deg=45))  # |G| = 1/sqrt(2), arg G = -135 deg
    P(kp=1.414213..., dt=1.0)
    """
    target = Target.of(plant, spec)
    able, kp = phases(target), 1 / target.size
    if any_sign and target.best_margin_deg(able, spec) is None:  # of the two signs one has some
        half = copysign(pi, target.theta)
        able, kp = (half - _SAME, half + _SAME), -kp
    if not target.inside(able):
        raise refusal("a P", target, spec, able, "")
    return P(kp=kp, dt=plant.dt)


def crossovers(plant: Sampled, pm_deg: float) -> list[float]:
    """Return every wc in rad/s at which the plant alone has this margin, fastest first.

    >>> plant = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)
    >>> crossovers(plant, 45.0)  # arg G = -90 deg - wc/2
    [1.570796...]
    """

    def off(wc: float) -> float:
        g = plant.at(wc)
        return remainder(float(np.angle(g)) - radians(pm_deg - 180), tau)

    wc = looked_at(plant)
    value = np.remainder(np.angle(plant.at(wc)) - radians(pm_deg - 180) + pi, tau) - pi
    # a jump of the wrapped angle from +pi to -pi is no root
    flips = np.flatnonzero(
        ((value[1:] >= 0) != (value[:-1] >= 0)) & (np.abs(value[1:] - value[:-1]) < pi)
    )
    return sorted((_root(off, float(wc[i]), float(wc[i + 1])) for i in flips), reverse=True)


def looked_at(plant: Sampled) -> npt.NDArray[np.float64]:
    """Return frequencies in rad/s between which the plant's phase turns by little.

    Sixty a decade around the plant's corners in w, more around each resonance, and every tenth
    of a radian of its delay.
    """
    roots = np.concatenate([poly_roots(plant.num_w), poly_roots(plant.den_w), [2 / plant.dt]])
    sizes = np.abs(roots[roots != 0])
    low, high = sizes.min() / 1e3, sizes.max() * 1e3
    even = np.geomspace(low, high, int(60 * np.log10(high / low)))
    around = np.abs(roots.imag)[:, None] + np.abs(roots.real)[:, None] * np.linspace(-4, 4, 33)
    v = np.concatenate([even, around.ravel()])
    turns = np.linspace(0, pi / plant.dt, 32 * (plant.delay + 1), endpoint=False)
    wc = np.concatenate([2 / plant.dt * np.arctan(v * plant.dt / 2), turns[1:]])
    return np.unique(wc[(wc > 0) & (wc < pi / plant.dt)])


def _root(off: Callable[[float], float], a: float, b: float) -> float:
    """Return where ``off`` changes sign in [a, b], by halving to the last bit."""
    rising = off(b) >= 0
    while a < (middle := (a + b) / 2) < b:
        if (off(middle) >= 0) == rising:
            b = middle
        else:
            a = middle
    return b
