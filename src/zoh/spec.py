"""What is asked of a loop."""

from dataclasses import dataclass, fields
from math import pi

from zoh import checks
from zoh.errors import SpecError


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossover:
    """Where the loop gain must be 1, and with which margin.

    wc      rad/s, a real frequency (z = exp(j wc dt)), above 0
    pm_deg  deg, phase margin at wc, inside (0, 180)
    """

    wc: float
    pm_deg: float

    def __post_init__(self) -> None:
        checks.positive("wc", self.wc, "give the crossover in rad/s")
        pm = checks.number("pm_deg", self.pm_deg, "give the phase margin in degrees")
        if not 0 < pm < 180:
            raise SpecError(
                "pm_deg", "must be inside (0, 180)", self.pm_deg, "30 to 70 deg is usual"
            )

    def below_nyquist(self, dt: float) -> "Crossover":
        """Return self, or raise SpecError where wc is not below the Nyquist frequency pi/dt."""
        dt = checks.positive("dt", dt, "give the sample time in seconds")
        if not self.wc * dt < pi:
            raise SpecError(
                "wc",
                f"must be below the Nyquist frequency pi/dt = {pi / dt:.6g} rad/s",
                self.wc,
                f"lower wc, or sample faster than dt = {pi / self.wc:.4g} s",
            )
        return self


_OF_ANY_SIGN = ("effort_min", "effort_max")


@dataclass(frozen=True, slots=True, kw_only=True)
class Requirements:
    """Bounds that a measured loop must meet; None asks nothing.

    pm_deg          deg, smallest phase margin allowed
    gain_margin_db  dB, smallest gain margin allowed, up or down
    delay_margin    s, smallest delay margin allowed
    ms              largest peak of the sensitivity |1/(1 + L)| allowed
    mt              largest peak of |L/(1 + L)| allowed
    overshoot_pct   %, largest overshoot allowed, between the samples too
    rise_time       s, largest 10 to 90 % rise time allowed, at the samples; of a jump from one to
                    the next, between them
    settling_time   s, largest 2 % settling time allowed, at the samples
    steady_state_error  largest size of the error at rest allowed, in the reference's units
    peak_effort     largest |u| allowed, in input units
    bandwidth       rad/s, smallest bandwidth allowed
    effort_min, effort_max  the least and the largest u allowed, in input units
    noise_gain      largest standard deviation of u per unit of white measurement noise allowed
    """

    pm_deg: float | None = None
    gain_margin_db: float | None = None
    delay_margin: float | None = None
    ms: float | None = None
    mt: float | None = None
    overshoot_pct: float | None = None
    rise_time: float | None = None
    settling_time: float | None = None
    steady_state_error: float | None = None
    peak_effort: float | None = None
    bandwidth: float | None = None
    effort_min: float | None = None
    effort_max: float | None = None
    noise_gain: float | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None and field.name not in _OF_ANY_SIGN:
                checks.not_negative(field.name, value)
        low, high = (
            None if value is None else checks.number(name, value)
            for name, value in (("effort_min", self.effort_min), ("effort_max", self.effort_max))
        )
        if low is not None and high is not None and not low < high:
            raise SpecError(
                "effort_max", f"must be above effort_min = {low:g}", high, "swap the two"
            )
        if self.pm_deg is not None and not self.pm_deg < 180:
            raise SpecError("pm_deg", "must be inside [0, 180)", self.pm_deg, "30 to 70 is usual")
        if self.ms is not None and self.ms < 1:
            raise SpecError("ms", "must be 1 or more", self.ms, "1.4 to 2 is usual")
