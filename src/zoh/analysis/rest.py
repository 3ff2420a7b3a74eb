"""What a loop comes to: its gains at rest, each formed without a difference of what is nearly one.

With C, F and P the gains of controller, feedforward and plant at w = 0,

    T = (C + F) P/(1 + C P),    1 - T = (1 - F P)/(1 + C P)

each as a fraction, so that an error of 1e-12 has all its digits, which 1 - T has not. Where terms
of one sign cancel those of the other nevertheless (L near -1, or a feedforward that all but makes
up for the error), the sums are formed of the exact coefficients, in whole numbers.
Source: K. J. Astrom and R. M. Murray, Feedback Systems, 2nd ed., ch. 12 (the gang of four).
"""

from math import inf
from typing import NamedTuple, TypeVar

from zoh.lti.systems import Plant, Sampled

Number = TypeVar("Number", float, int)
_NEAR = 0.5  # |1 - T| that has lost digits
_LOST = 0.25  # of what a sum would be if nothing cancelled; seldom less with an unstable plant
Gain = tuple[Number, Number]  # num and den, both times any number


class AtRest(NamedTuple):
    """What a reference of 1 brings output and effort to, and the reference minus that output."""

    output: float
    effort: float
    error: float


def gains_at_rest(
    plant: Plant, controller: Sampled, feedforward: Sampled | None = None
) -> AtRest:  # fmt: skip
    """Return what y, u and the error settle to under a reference of 1.

    At rest a held plant has the plant's own gain.

    >>> plant = Plant(num=[1e16], den=[1, 1])
    >>> gains_at_rest(plant, Sampled(num=[1.0], den=[1.0], dt=0.1)).error  # 1/(1 + 1e16)
    1e-16
    """
    p, c = (plant.sensor * plant.num[-1], plant.den[-1]), _rounded(controller)
    f = (0.0, 1.0) if feedforward is None else _rounded(feedforward)
    if not _cancels(c[0] * p[0], c[1] * p[1]) and (not f[0] or not _lost_ahead(p, c, f)):
        return AtRest(*_under_a_reference(p, c, f))
    ahead = (0, 1) if feedforward is None else _exact(feedforward)
    return AtRest(*_under_a_reference(_exact(plant), _exact(controller), ahead))


def under_a_load(plant: Plant, controller: Sampled) -> tuple[float, float]:
    """Return what y and u settle to under a disturbance of 1 at the plant's input.

    >>> under_a_load(Plant(num=[1], den=[1, 1]), Sampled(num=[4.0], den=[1.0], dt=0.1))
    (0.2, -0.8)
    """
    p, c = (plant.sensor * plant.num[-1], plant.den[-1]), _rounded(controller)
    if not _cancels(c[0] * p[0], c[1] * p[1]):
        return _under_a_load(p, c)
    return _under_a_load(_exact(plant), _exact(controller))


def short_of_1(system: Plant | Sampled, final: float) -> float:
    """Return 1 less the gain at rest of a system by itself, ``final`` but for rounding.

    >>> short_of_1(Plant.parse("1/(s + 1.000000001)"), 1 / 1.000000001)  # 1e-9/(1 + 1e-9)
    9.99999999e-10
    """
    if abs(1 - final) > _NEAR:
        return 1 - final
    num, den = _exact(system)
    return (den - num) / den


def _rounded(system: Sampled) -> Gain[float]:
    return system.num_w[-1], system.den_w[-1]


def _exact(system: Plant | Sampled) -> Gain[int]:
    if isinstance(system, Sampled):
        num, den, _ = system.whole_w
        return num[-1], den[-1]
    parts = system.sensor, system.exact[0][-1], system.exact[1][-1]
    (sensor, one), (top, unit), (bottom, other) = (x.as_integer_ratio() for x in parts)
    return sensor * top * other, one * unit * bottom


def _cancels(x: float, y: float) -> bool:
    """Return whether the sum has lost more than two of its terms' bits."""
    size = abs(x) + abs(y)
    return not (0 < size < inf and abs(x + y) >= _LOST * size)


def _lost_ahead(p: Gain[float], c: Gain[float], f: Gain[float]) -> bool:
    """Return whether a sum with a feedforward in it has."""
    return _cancels(c[0] * f[1], f[0] * c[1]) or _cancels(p[1] * f[1], -f[0] * p[0])


def _under_a_reference(
    p: Gain[Number], c: Gain[Number], f: Gain[Number]
) -> tuple[float, float, float]:
    """Return output, effort and error under a reference of 1; infinite where L is -1."""
    closed = (c[0] * p[0] + c[1] * p[1]) * f[1]
    if not closed:
        return inf, inf, -inf
    path, left = c[0] * f[1] + f[0] * c[1], p[1] * f[1] - f[0] * p[0]
    return path * p[0] / closed, path * p[1] / closed, c[1] * left / closed


def _under_a_load(p: Gain[Number], c: Gain[Number]) -> tuple[float, float]:
    """Return output and effort under a disturbance of 1; infinite where L is -1."""
    closed = c[0] * p[0] + c[1] * p[1]
    if not closed:
        return inf, -inf
    return p[0] * c[1] / closed, -c[0] * p[0] / closed
