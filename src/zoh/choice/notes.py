"""What a choice does not say by itself, and whoever ships it should know."""

from collections.abc import Mapping
from math import inf

import numpy as np

from zoh.analysis.verify import Verified
from zoh.choice.choose import MAY_RING
from zoh.choice.freedom import SLOWEST
from zoh.choice.judge import slowest_zero
from zoh.lti import poly
from zoh.lti.forms import ringing
from zoh.lti.systems import Sampled
from zoh.lti.wplane import warp

_CLEARLY = 0.999  # of the slowest zero that is chosen: at that end itself nothing is said
_DIPOLE = 0.01  # of a zero: a pole as near leaves less of its tail than settling counts
_OF_ROBUSTNESS = ("pm_deg", "gain_margin_db", "delay_margin", "ms", "mt")


def notes(found: Verified, given: Mapping[str, float], fixed: Sampled | None) -> tuple[str, ...]:
    """Return what is said of a chosen design: slow zeros, poles that ring, what nothing bounds.

    given  the parameters that were not chosen;  fixed  what is in series with the law
    """
    said, margins = [], found.margins
    asked = [name for name in _OF_ROBUSTNESS if getattr(found.requirements, name) is not None]
    if not asked and "pm_deg" not in given:
        said.append(
            "nothing that was asked bounds the robustness: the phase margin is "
            f"{margins.phase_margin_deg:.4g} deg, ms {margins.ms:.4g}"
        )
    if found.law in MAY_RING and ringing(found.gains, found.dt):
        said.append(f"no {found.law} without a pole that rings at every sample meets everything")
    slowest = slowest_zero(found.controller, fixed)
    poles = poly.roots(found.controller.den_w)
    if np.abs(poles + slowest).min(initial=inf) < _DIPOLE * slowest:
        slowest = inf
    allowed = _CLEARLY * SLOWEST * warp(margins.crossover or 0.0, found.controller.dt)
    if 0 < slowest < allowed:
        said.append(
            f"a zero of the controller, which what was given brings, is at {slowest:.4g} rad/s: "
            f"the loop creeps for some {1 / slowest:.3g} s behind a crossover at "
            f"{margins.crossover:.4g} rad/s"
        )
    return tuple(said)
