"""Setpoint weights: what share of the reference the proportional and the derivative part see.

    u = kp (b r - y) + ki/w (r - y) + kd w/(1 + w/p) (c r - y) = D(w) (r - y) + F(w) r
    F(w) = -(kp (1 - b) + kd (1 - c) w/(1 + w/p))

The loop, and so every margin, is that of D: b and c shape only how the reference enters. What
stands in series with the law stands in series with F, too.
Source: K. J. Astrom and T. Hagglund, Advanced PID Control, sec. 3.4 (set-point weighting).
"""

from collections.abc import Mapping

from zoh.errors import SpecError
from zoh.lti.forms import time_constant
from zoh.lti.sampled import Sampled
from zoh.lti.wplane import warp

WEIGHTS = ("setpoint_weight", "derivative_weight")  # b and c
_SAME = 1e-9  # two roads to one ratio of gains, which differ by rounding
_AT = (0.01, 0.3, 1.0)  # of 1/dt: frequencies below Nyquist's at which they are compared


def feedforward(
    gains: Mapping[str, float], setpoint: float, derivative: float, dt: float
) -> Sampled | None:
    """Return F of the gains, None where it is nothing; raise SpecError where there is no such part.

    >>> feedforward({"kp": 2.0, "ki": 1.0}, 0.75, 1.0, 0.1)
    Sampled(num=(-0.5,), den=(1.0,), dt=0.1)
    >>> feedforward({"kp": 2.0, "ki": 1.0}, 1.0, 1.0, 0.1) is None
    True
    """
    if setpoint == derivative == 1:
        return None
    for name, value, gain in zip(WEIGHTS, (setpoint, derivative), ("kp", "kd"), strict=True):
        if value != 1 and gain not in gains:
            raise SpecError(name, f"must be 1 for a law without {gain}", value, "leave it out")
    kp, kd = (1 - setpoint) * gains.get("kp", 0.0), (1 - derivative) * gains.get("kd", 0.0)
    if kp == kd == 0:
        return None
    if not kd:
        return Sampled(num=(-kp,), den=(1.0,), dt=dt)
    tau = time_constant(gains["filter_pole"], dt)
    return Sampled.from_w(num_w=(-(kp * tau + kd), -kp), den_w=(tau, 1.0), dt=dt)


def fits(
    controller: Sampled, ahead: Sampled, gains: Mapping[str, float], setpoint: float,
    derivative: float,
) -> bool:  # fmt: skip
    """Return whether F/D of the systems is that of the gains, whatever stands in series with both.

    >>> two = Sampled(num=(2.0,), den=(1.0,), dt=0.1)
    >>> fits(two, Sampled(num=(-0.5,), den=(1.0,), dt=0.1), {"kp": 2.0}, 0.75, 1.0)
    True
    """
    dt = controller.dt
    kp, ki, kd = (gains.get(name, 0.0) for name in ("kp", "ki", "kd"))
    tau = time_constant(gains.get("filter_pole"), dt)
    for share in _AT:
        w = 1j * warp(share / dt, dt)
        rate = w / (1 + w * tau)
        law = kp + ki / w + kd * rate
        told = -(kp * (1 - setpoint) + kd * (1 - derivative) * rate) / law if law else 0.0
        if not abs(ahead.at(share / dt) / controller.at(share / dt) - told) <= _SAME:
            return False
    return True


def reference_path(controller: Sampled, ahead: Sampled | None) -> Sampled:
    """Return D + F over D's denominator, of which F's is the first part: what u owes to r.

    >>> pi = Sampled.from_w(num_w=(2.0, 1.0), den_w=(1.0, 0.0), dt=2.0)
    >>> reference_path(pi, Sampled(num=(-2.0,), den=(1.0,), dt=2.0)).num_w
    (0.0, 1.0)
    """
    if ahead is None:
        return controller
    added = (*ahead.num_w, *(0.0,) * (len(controller.num_w) - len(ahead.num_w)))
    path = [a + b for a, b in zip(controller.num_w, added, strict=True)]
    return Sampled.from_w(num_w=path, den_w=controller.den_w, dt=controller.dt)
