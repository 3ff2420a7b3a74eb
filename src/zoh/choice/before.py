"""What cannot be, seen before any search: each reason is a proof, in words.

All of it is true of every stable loop that a choice may make, with gains of one sign and no slow
zero, whatever the crossover: what is left open is not searched where one of these stands against
it. Sections in series have a gain of 1 at rest.
Source: G. F. Franklin, J. D. Powell, A. Emami-Naeini, Feedback Control of Dynamic Systems,
sec. 4.2 (system type, and what the errors of a step add up to).
"""

from collections.abc import Mapping
from math import nan, pi

from zoh.analysis.asked import of_effort
from zoh.analysis.results import StepInfo
from zoh.choice.fastest import least_ms
from zoh.choice.judge import Judge
from zoh.lti.hidden import unstable_hidden
from zoh.spec import Requirements
from zoh.workbench import HIDES

_INTEGRATES = ("pi", "pid")
_ROUNDING = 1e-9  # relative: what misses by rounding alone is met


def why_never(judge: Judge, law: str, given: Mapping[str, float]) -> str:
    """Return why no loop of this law can meet everything asked; "" if one may."""
    return (
        hides_an_unstable_mode(judge)
        or contradicted(judge.requirements, given)
        or too_wide(judge)
        or too_soon(judge)
        or too_quiet(judge)
        or never_at_rest(judge, law)
        or always_beyond(judge, law, given)
        or pushed_the_wrong_way(judge, law)
    )


def hides_an_unstable_mode(judge: Judge) -> str:
    """Return that every loop is unstable, for what the plant hides is; "" if it is not."""
    return HIDES if unstable_hidden(judge.plant) else ""


def contradicted(asked: Requirements, given: Mapping[str, float]) -> str:
    """Return how the margin given contradicts what is required; "" if it does not."""
    return another_margin(asked, given) or peaks_by_itself(asked, given)


def another_margin(asked: Requirements, given: Mapping[str, float]) -> str:
    """Return that the margin given is less than the one required; "" if it is not."""
    least = asked.pm_deg
    if least is None or given.get("pm_deg", least) >= least * (1 - _ROUNDING):
        return ""
    return f"pm_deg must be at least {least:g}, and a margin of {given['pm_deg']:g} deg is asked"


def peaks_by_itself(asked: Requirements, given: Mapping[str, float]) -> str:
    """Return why no loop of the margin given is under the peak allowed; "" if one may be."""
    most = asked.ms
    if most is None or "pm_deg" not in given:
        return ""
    least = least_ms(given["pm_deg"])
    if least <= most * (1 + _ROUNDING):
        return ""
    margin = f"a margin of {given['pm_deg']:g} deg"
    return f"ms must be at most {most:g}, and {margin} alone makes it {least:.5g}"


def too_wide(judge: Judge) -> str:
    """Return why no sampled loop has the bandwidth asked; "" if one may."""
    asked, nyquist = judge.requirements.bandwidth, pi / judge.sampled.dt
    if asked is None or asked < nyquist:
        return ""
    return f"bandwidth must be at least {asked:g}, and the Nyquist frequency is {nyquist:.6g} rad/s"


def too_soon(judge: Judge) -> str:
    """Return why no step settles as soon as asked: it does not begin by then; "" if one may."""
    asked, plant = judge.requirements.settling_time, judge.plant
    late = max(plant.dead_time + judge.compute_delay, 0.0 if judge.through else judge.sampled.dt)
    if asked is None or asked >= late * (1 - _ROUNDING) or plant.num[-1] == 0:
        return ""
    return f"settling_time must be at most {asked:g}, and no response begins before {late:.6g} s"


def too_quiet(judge: Judge) -> str:
    """Return that every loop passes some of the sensor's noise on; "" if none is forbidden to."""
    if judge.requirements.noise_gain != 0:
        return ""
    return "noise_gain must be at most 0, and every controller passes some noise on"


def never_at_rest(judge: Judge, law: str) -> str:
    """Return why no loop of this law comes to the error at rest that is allowed; "" if one may."""
    allowed = judge.requirements.steady_state_error
    if allowed is None:
        return ""
    if judge.plant.num[-1] == 0:
        if allowed >= abs(judge.reference):
            return ""
        return "the plant has no gain at rest, so no loop follows a constant reference"
    integrates = law in _INTEGRATES or judge.plant.den[-1] == 0
    if integrates or allowed > 0 or judge.weights:
        return ""
    return "an error remains at rest, for neither the law nor the plant integrates"


def always_beyond(judge: Judge, law: str, given: Mapping[str, float]) -> str:
    """Return why every step overshoots though none may; "" if one may not.

    With two integrators in the loop the errors at the samples add up to 0, and the first is not. Of
    an integral that is given, next to nothing may be left of it: less than is counted.
    """
    if given.keys() - {"wc", "pm_deg"}:
        return ""
    plant, allowed = judge.plant, judge.requirements.overshoot_pct
    twice = plant.den[-1] == 0 and (law in _INTEGRATES or plant.den[-2] == 0)
    if allowed != 0 or not twice or plant.num[-1] == 0 or judge.weights:
        return ""
    way_out = "; a setpoint_weight below 1 may do" if law in _INTEGRATES else ""
    why = "with two integrators in the loop the errors of a step add up to 0: it overshoots"
    return why + way_out


def pushed_the_wrong_way(judge: Judge, law: str) -> str:
    """Return why the effort leaves its range at once, or at rest; "" if it may stay.

    With positive gains, sections whose zeros are stable and a plant without a negative path at
    once, the first u has the sign of the reference, or is 0, and with negative ones and no
    positive path the other; at rest an integrating plant needs none, and a law that integrates
    gives r/G(0).
    """
    asked, plant, r = judge.requirements, judge.plant, judge.reference
    low, high = asked.effort_min, asked.effort_max
    side = -1.0 if judge.back else 1.0
    first = r * side if judge.through * side >= 0 else nan
    if high is not None and high < 0 <= first:
        return f"effort_max must be at most {high:g}, and the first effort of a step is not below 0"
    if low is not None and low > 0 >= first:
        return f"effort_min must be at least {low:g}, and the first effort of a step is not above 0"
    gain = plant.sensor * plant.num[-1]
    if not gain or not (plant.den[-1] == 0 or law in _INTEGRATES):
        return ""
    rest = r * plant.den[-1] / gain
    for row in of_effort(asked, StepInfo(peak_effort=abs(rest), effort_range=(rest, rest))):
        if not row.met:
            return f"{row.demand}, and at rest it is {row.value:.6g}"
    return ""
