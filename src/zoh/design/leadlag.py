"""Lead-lag: a lag for the gain at w = 0, a lead for the phase, solved exactly at one crossover.

    D(w) = a0 (1 + w/wz)/(1 + w/wp) (1 + w/w0)/(1 + w/w1)        wp < wz, w0 < w1

Four corners meet two equations. The lag's zero wz is given, or a decade below the crossover
(wz = v/10). The lag's ratio wz/wp is given, or is the one that puts the lead's largest phase at
the crossover (w0 w1 = v^2). The lead is then the one section that is left.
Source: K. Ogata, Modern Control Engineering, sec. 7.13 (lag-lead by frequency response: the
lag a decade below the crossover, the lead around it).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import acos, asin, atan, hypot, sin, sqrt, tan

from zoh.design.first_order import FirstOrder, corners
from zoh.design.target import Phases, Response, Target, refusal
from zoh.lti.systems import Sampled
from zoh.spec import Crossover


@dataclass(frozen=True, slots=True, kw_only=True)
class LeadLag:
    """A lag of gain 1 at w = 0 and a lead that has the law's; corners in rad/s (w-plane)."""

    lag: FirstOrder
    lead: FirstOrder

    @property
    def gains(self) -> Mapping[str, float]:
        """Return the gains by name."""
        return {
            "dc_gain": self.lead.dc_gain, "lag_zero": self.lag.w0, "lag_pole": self.lag.wp,
            "lead_zero": self.lead.w0, "lead_pole": self.lead.wp,
        }  # fmt: skip

    def controller(self) -> Sampled:
        """Return the two sections in series."""
        return self.lag.controller() * self.lead.controller()


def phases(target: Target, dc_gain: float, turn: float, ratio: float | None) -> Phases:
    """Return the phases a lead-lag can give, ``turn`` = v/wz.

    With m = a0 |G|: a given ratio r leaves the lead's, 0 to acos(m |lag|), on top of the lag's
    atan(turn) - atan(r turn). A free one has those between the ends and the least of ``_Centred``.
    """
    m = dc_gain * target.size
    if ratio is not None:
        least = m * hypot(1.0, turn) / hypot(1.0, ratio * turn)
        lag = atan(turn) - atan(ratio * turn)
        return (lag, lag + acos(least)) if least < 1 else None
    centred = _Centred.of(m, turn)
    ends = [centred.beyond(g) for g in (0.0, centred.least, centred.most)]
    return atan(turn) + min(ends), atan(turn) + max(ends)


def solve(
    plant: Response, spec: Crossover, dc_gain: float, lag_corner: float | None = None,
    lag_ratio: float | None = None,
) -> LeadLag:  # fmt: skip
    """Return the lead-lag of this gain at w = 0 whose loop crosses 1 at wc with the margin asked.

    ``lag_corner`` is wz in rad/s (w-plane), ``lag_ratio`` wz/wp, above 1. Raises Infeasible
    where the phase is not among ``phases``.

    >>> from math import pi
    >>> plant = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)
    >>> law = solve(plant, Crossover(wc=pi / 2, pm_deg=75), dc_gain=10.0)  # v = 2
    >>> round(law.lag.w0, 12), round(law.lead.w0 * law.lead.wp, 12)
    (0.2, 4.0)
    """
    target = Target.of(plant, spec)
    zero = target.v / 10 if lag_corner is None else lag_corner
    turn = target.v / zero
    able = phases(target, dc_gain, turn, lag_ratio)
    if not target.inside(able):
        why = "has a gain above that everywhere"
        raise refusal(f"a lead-lag of dc_gain {dc_gain:g}", target, spec, able, why)
    ratio = lag_ratio or _Centred.of(dc_gain * target.size, turn).ratio(target.theta)
    lag = FirstOrder(dc_gain=1.0, w0=zero, wp=zero / ratio, dt=plant.dt)
    rest = Target(
        v=target.v,
        size=target.size * hypot(1.0, turn) / hypot(1.0, ratio * turn),
        theta=target.theta - atan(turn) + atan(ratio * turn),
        dt=plant.dt,
    )
    return LeadLag(lag=lag, lead=corners(rest, dc_gain))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Centred:
    """The lags whose lead is centred, by what such a lag's pole lacks of 90 deg at the crossover.

    With g = 90 deg - atan(r turn) and k = m sqrt(1 + turn^2) the lag has |lag| m = k sin(g), and
    the centred lead of that gain gives 90 deg - 2 atan(k sin(g)); both together turn by

        atan(turn) + g - 2 atan(k sin(g)),    0 < g < most

    which falls until cos(g) = (sqrt(2 + k^2) - 1)/k and rises from there on.

    most   where the lag is none (r = 1), or the lead (k sin(g) = 1)
    least  where the phase is the least, an end where that is one
    """

    k: float
    turn: float
    most: float
    least: float

    @classmethod
    def of(cls, m: float, turn: float) -> "_Centred":
        k = m * hypot(1.0, turn)
        most = min(atan(1 / turn), asin(min(1.0, 1 / k)))
        least = acos(min(1.0, (sqrt(2 + k * k) - 1) / k)) if k > 0.5 else 0.0
        return cls(k=k, turn=turn, most=most, least=min(least, most))

    def beyond(self, g: float) -> float:
        """Return the phase in rad less atan(turn)."""
        return g - 2 * atan(self.k * sin(g))

    def ratio(self, theta: float) -> float:
        """Return the ratio r of this phase by halving, the smaller one where there are two."""
        wanted = theta - atan(self.turn)
        rises = wanted < self.beyond(self.most)
        low, high = (self.least, self.most) if rises else (0.0, self.least)
        while low < (middle := (low + high) / 2) < high:
            if (self.beyond(middle) < wanted) == rises:
                low = middle
            else:
                high = middle
        return 1 / (self.turn * tan(high))
