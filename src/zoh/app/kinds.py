"""What kind of controller a fraction is, by its poles and zeros and not by its name.

In w a lead has its zero below its pole and a lag its pole below its zero; an integrator is a
pole at w = 0, and a pole at z = 0, w = -2/dt, is what a difference quotient costs.
"""

from collections.abc import Sequence
from math import degrees, inf, isclose, pi

import numpy as np

from zoh.lti import poly
from zoh.lti.systems import Sampled

KINDS = ("p", "pi", "pd", "pid", "lag", "lead", "leadlag")


def kinds(controller: Sampled) -> tuple[str, ...]:
    """Return the kinds that fit, the most telling first; a PD is a lead, too.

    >>> kinds(Sampled(num=[66.15, -64.01], den=[1, -0.7859], dt=0.1))
    ('lead',)
    >>> kinds(Sampled(num=[5.839, -5.823], den=[1, -1], dt=0.1))
    ('pi',)
    """
    order = len(controller.den_w) - 1 + controller.delay
    if order == 0:
        return ("p",)
    at_zero = [complex(-2 / controller.dt)] * controller.delay  # z = 0
    zero_roots = list(poly.roots(controller.num_w))
    pole_roots = [*poly.roots(controller.den_w), *at_zero]
    if any(r.real > 0 for r in (*zero_roots, *pole_roots)):
        return ()
    if 0 in pole_roots:
        return {1: ("pi",), 2: ("pid",)}.get(order, ()) if pole_roots.count(0) == 1 else ()
    if any(r.imag for r in (*zero_roots, *pole_roots)):
        return ()
    zeros, poles = _corners(zero_roots, order), _corners(pole_roots, order)
    if order == 1:
        if not zeros[0] < poles[0]:
            return ("lag",) if zeros[0] > poles[0] else ("p",)
        at_origin = isclose(poles[0], 2 / controller.dt, rel_tol=1e-9)  # z = 0, within rounding
        return ("pd", "lead") if at_origin else ("lead",)
    return _of_a_cascade(zeros, poles)


def _corners(roots: Sequence[complex], order: int) -> list[float]:
    """Return the corner frequencies of real roots in w, rad/s, rising; a missing one is at inf."""
    return sorted([-float(r.real) for r in roots] + [inf] * (order - len(roots)))


def _of_a_cascade(zeros: Sequence[float], poles: Sequence[float]) -> tuple[str, ...]:
    """Return the kind of a product of sections, by the order of the corners."""
    if poles[0] < zeros[0] and zeros[-1] < poles[-1]:
        return ("leadlag",)
    if all(z < p for z, p in zip(zeros, poles, strict=True)):
        return ("lead",)
    if all(z > p for z, p in zip(zeros, poles, strict=True)):
        return ("lag",)
    return ()


def described(controller: Sampled, wc: float | None) -> str:
    """Return zeros and poles in w and the phase at wc in rad/s, in one line."""
    parts = [
        _listed("zero", poly.roots(controller.num_w).tolist()),
        _listed("pole", poly.roots(controller.den_w).tolist()),
    ]
    if wc is not None and 0 < wc < pi / controller.dt:
        phase_deg = degrees(float(np.angle(controller.at(wc))))
        parts.append(f"{phase_deg:+.1f} deg at {wc:.4g} rad/s")
    return ", ".join(part for part in parts if part)


def _listed(what: str, roots: Sequence[complex]) -> str:
    if not roots:
        return ""
    several = "s" if len(roots) > 1 else ""
    return f"{what}{several} at w = " + " and ".join(
        f"{r.real:.4g}" if r.imag == 0 else f"{r:.4g}" for r in roots
    )
