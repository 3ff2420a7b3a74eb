"""What a law leaves open at one crossover, as coordinates in [0, 1].

The first one is the margin, from the least allowed to the most that the law can give there; a
second one is a PID's ki, or the gain at w = 0 of a lag or lead, where it was not given. Every
point is a controller with positive gains that crosses over at wc, and every such controller is
one, but for margins below 1 deg, the last ten-thousandth of a second range, lead-lags whose lag is
neither given nor a decade below wc, and those with a zero whose real part is more than a decade
below wc. A slow zero lets
the loop creep, or ring, for ever behind a crossover that is fast in name alone: an integral that
does next to nothing, a derivative with next to no gain below it.
Where nothing may ring, no lead has a pole below z = -1/2: one there gains a degree or two, and
makes the effort turn at every sample, and the noise many times what it is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import atan, cos, degrees, exp, inf, pi, radians, sin, tan

from zoh.design import first_order, leadlag
from zoh.design import pid as pid_law
from zoh.design.target import Response, Target
from zoh.errors import SpecError
from zoh.lti.forms import RINGS, time_constant
from zoh.spec import Crossover

SLOWEST = 0.1  # of wc, in the w-plane: how slowly a controller's zeros may decay
_INSET = 1e-6  # of an open interval is left out at its ends
_WIDE = 9.0  # a second coordinate reaches to exp(-9) of its range
_LEAST_LEAD = 0.02  # rad that a lead-lag's lead turns: one of less is none, and rounding moves it
_SAME_DEG = 1e-9  # two roads to one angle
LEAST_DEG = 1.0  # a margin that nobody would ask for less of


@dataclass(frozen=True, slots=True, kw_only=True)
class Freedom:
    """What is open of a law at one crossover.

    pm      deg, the least and the largest margin; equal where it is given or cannot be chosen
    fixed   the parameters that are given
    size    how many coordinates there are
    tau     s, the time constant of a PD's and PID's derivative
    flat    the least time constant of a chosen lead's pole, in parts of 1/v; 0 where it may ring
    """

    law: str
    target: Target
    turn_deg: float
    wc: float
    pm: tuple[float, float]
    fixed: Mapping[str, float]
    size: int
    tau: float
    flat: float

    @classmethod
    def of(
        cls, law: str, sampled: Response, wc: float, fixed: Mapping[str, float], least_pm: float,
        *, calm: bool = False,
    ) -> "Freedom | None":  # fmt: skip
        """Return what is open at wc; None where the law cannot give the least margin there.

        calm  whether a lead whose gain at w = 0 is open may have no pole that rings
        """
        try:
            target = Target.of(sampled, Crossover(wc=wc, pm_deg=90.0))
        except SpecError:  # a pole or a zero on the circle, or no frequency below Nyquist's
            return None
        turn_deg = 90.0 - degrees(target.theta)  # the margin of a law that turns nothing
        flat = target.v * sampled.dt / (2 * RINGS) if calm else 0.0
        if law == "p":
            pm = _of_plant(turn_deg, fixed, least_pm)
        else:
            pm = _margins(_turns(law, target, fixed, flat), turn_deg, fixed, least_pm)
        if pm is None:
            return None
        second = second_is_open(law, fixed)
        tau = time_constant(fixed.get("filter_pole"), sampled.dt)
        return cls(
            law=law, target=target, turn_deg=turn_deg, wc=wc, pm=pm, fixed=fixed,
            size=(pm[0] < pm[1]) + second, tau=tau, flat=flat,
        )  # fmt: skip

    def parameters(self, x: Sequence[float]) -> dict[str, float]:
        """Return the law's parameters at a point of [0, 1]^size."""
        low, high = self.pm
        free = list(x)
        # finest at the least margin: beyond 90 deg there is seldom anything to be had
        pm_deg = low + (high - low) * free.pop(0) ** 1.5 if low < high else low
        found = {**self.fixed, "wc": self.wc, "pm_deg": pm_deg}
        if free:
            name, value = self._second(radians(pm_deg - self.turn_deg), free[0])
            found[name] = value
        return found

    def _second(self, theta: float, x: float) -> tuple[str, float]:
        """Return the second parameter and its value at a coordinate, the law turning by theta."""
        target, c = self.target, cos(theta)
        if self.law == "leadlag":
            return "dc_gain", _of_lead_lag(target, self.fixed, theta, x, self.flat)
        if self.law == "pid":
            low, high = _integrals(target, theta, self.tau)
            share = (exp(_WIDE * x) - 1) / (exp(_WIDE) - 1)  # finest at the least ki
            return "ki", (low + (high - low) * share) * target.v / target.size
        if self.law == "lead":
            return "dc_gain", _of_lead(theta, x, self.flat) / target.size
        slow = abs(sin(theta)) / SLOWEST  # how |1/r - c| is where the zero is the slowest
        # 1/r from c down, r the gain at w = 0 in parts of that at wc
        return "dc_gain", 1 / ((c + (max(0.0, c - slow) - c) * _both_ends(x)) * target.size)


def _both_ends(x: float) -> float:
    """Return a share of (0, 1), finest at both ends."""
    return 1 / (1 + exp(_WIDE * (1 - 2 * x)))


def _of_lead(theta: float, x: float, flat: float) -> float:
    """Return a lead's gain at w = 0 in parts of that at wc.

    It is r: the zero is the slowest where 1/r is c + s/SLOWEST, the pole the fastest where r is
    c - s flat, with c and s the cosine and the sine of theta.
    """
    c, slow = cos(theta), sin(theta) / SLOWEST
    return 1 / (c + slow) + (c - sin(theta) * flat - 1 / (c + slow)) * _both_ends(x)


def _of_lead_lag(
    target: Target, fixed: Mapping[str, float], theta: float, x: float, flat: float
) -> float:
    """Return a lead-lag's gain at w = 0.

    Of a given ratio r the lead's coordinate is taken, behind the lag. Of a free one it is g, see
    ``design.leadlag``: the centred lead's zero is at v tan((g - d)/2), d = theta - atan(v/wz), and
    its pole at v/tan((g - d)/2).
    """
    turn = _lag_turn(target, fixed)
    b = atan(turn)
    if "lag_ratio" in fixed:
        a = atan(fixed["lag_ratio"] * turn)
        return _of_lead(theta - b + a, x, flat) / (target.size * cos(a) / cos(b))
    low = max(0.0, theta - b + 2 * atan(max(SLOWEST, flat)))
    high = min(pi / 2 - b, pi / 2 - _LEAST_LEAD + theta - b)
    g = low + (high - low) * _both_ends(x)
    return tan((g - theta + b) / 2) * cos(b) / sin(g) / target.size


def _lag_turn(target: Target, fixed: Mapping[str, float]) -> float:
    """Return v/wz, the lag's zero at wz."""
    return target.v / fixed["lag_corner"] if "lag_corner" in fixed else 10.0


def _lead_lag_turns(
    target: Target, fixed: Mapping[str, float], flat: float
) -> tuple[float, float] | None:
    """Return the phases of a lead-lag; a lag's zero that is given may be as slow as it is."""
    turn, ratio = _lag_turn(target, fixed), fixed.get("lag_ratio")
    if "dc_gain" in fixed:
        return leadlag.phases(target, fixed["dc_gain"], turn, ratio)
    b = atan(turn)
    if ratio is None:
        return b - pi / 2 + _LEAST_LEAD, pi / 2 - 2 * atan(max(SLOWEST, flat))
    lag = b - atan(ratio * turn)
    return lag, lag + atan(1 / SLOWEST) - atan(flat)


def _integrals(target: Target, theta: float, tau: float) -> tuple[float, float]:
    """Return the least and the largest ki |G|/v of a PID that turns by theta.

    With k = ki |G|/v, x = v tau and c = cos(theta) - x sin(theta) the numerator of
    kp + ki/w + kd w/(1 + w tau), in units of w/v, is ((x cos(theta) + sin(theta) + k), c, k). A
    zero at -q or a pair of size q bounds k from below, as kd > 0 does; a pair with real part -q
    does from above, as kp > 0 does.
    """
    x, q = target.v * tau, SLOWEST
    c, lead = cos(theta) - x * sin(theta), x * cos(theta) + sin(theta)
    real, pair = (q * c - q * q * lead) / (1 + q * q), q * q * lead / (1 - q * q)
    low = max(-sin(theta), real, pair) * (1 + _INSET)
    return low, max(min(c / x, c / (2 * q) - lead) * (1 - _INSET), low)


SECOND = {"pid": "ki", "lag": "dc_gain", "lead": "dc_gain", "leadlag": "dc_gain"}


def second_is_open(law: str, fixed: Mapping[str, float]) -> bool:
    """Return whether the law has a second parameter that nothing given closes."""
    return law in SECOND and not any(name in fixed for name in (SECOND[law], "ti_td"))


def keeps_zeros_fast(law: str, fixed: Mapping[str, float]) -> bool:
    """Return whether a zero that would be too slow can keep a law from a margin.

    It can where a zero is chosen: a ki or dc_gain that is given brings its own.
    """
    return law in ("pi", "pd") or second_is_open(law, fixed)


def _turns(
    law: str, target: Target, fixed: Mapping[str, float], flat: float
) -> tuple[float, float] | None:
    """Return the interval of phases in rad that the law can give, any second parameter."""
    tau, q = time_constant(fixed.get("filter_pole"), target.dt), SLOWEST
    x = target.v * tau
    if law == "pi":
        return -pi / 2, -atan(q)
    if law == "pd":
        low, high = pid_law.phases(target, 0.0, tau) or (0.0, 0.0)
        return low, min(high, atan(1 / q) - atan(x))
    if law == "pid":
        if "ki" in fixed:
            return pid_law.phases(target, fixed["ki"], tau)
        return _room(x, q)
    if law == "leadlag":
        return _lead_lag_turns(target, fixed, flat)
    given = fixed.get("dc_gain")
    if law == "lag":
        return (-pi / 2, 0.0) if given is None else first_order.lag_phases(target, given)
    if given is not None:
        return first_order.lead_phases(target, given)
    return 0.0, atan(1 / q) - atan(flat)  # the largest where both ends of _of_lead are one


def _room(x: float, q: float) -> tuple[float, float] | None:
    """Return the phases for which ``_integrals`` leaves room: tan(theta) bound by bound.

    The last bound, of a zero at -q below the ki where kp is 0, is one from below where x > 1/q.
    """
    k, a = 2 * q / (1 - q * q), (1 + q * q) / x - q + q * q * x
    above = [(1 - q * q) / x - q * q * x, (1 - k * x) / (x + k), (1 - 2 * q * x) / x]
    last = a / (1 - q * x) if q * x != 1 else inf
    if q * x < 1:
        above.append(last)
    low, high = (atan(last) if q * x > 1 else -pi / 2), atan(min(above))
    return (low, high) if low < high else None


def _margins(
    turns: tuple[float, float] | None, turn_deg: float, fixed: Mapping[str, float], least_pm: float
) -> tuple[float, float] | None:
    """Return the margins in deg from the least on that phases in rad allow, a given one alone."""
    if turns is None:
        return None
    low, high = (turn_deg + degrees(t) for t in turns)
    inset = _INSET * (high - low)
    found = []
    for whole in (-360.0, 0.0, 360.0):
        least = max(low + inset + whole, least_pm, LEAST_DEG)
        most = min(high - inset + whole, 180.0 - _INSET)
        given = fixed.get("pm_deg")
        if given is not None and low + whole < given < high + whole:
            return given, given
        if given is None and least < most:
            found.append((least, most))
    return max(found, key=lambda span: span[1] - span[0], default=None)


def _of_plant(
    turn_deg: float, fixed: Mapping[str, float], least_pm: float
) -> tuple[float, float] | None:
    """Return the plant's own margin, where it is allowed."""
    pm_deg = turn_deg % 360.0
    if abs(fixed.get("pm_deg", pm_deg) - pm_deg) > _SAME_DEG:
        return None
    if not max(least_pm, LEAST_DEG) <= pm_deg < 180.0:
        return None
    return pm_deg, pm_deg
