"""Every printed number once more, from the plant, at full precision, by the paper's recipe.

What the paper chose (sample time, crossovers, the PID's KI) has no formula. Each is solved
back from another printed number that depends on it, so that a choice can be wrong too.
"""

from collections.abc import Iterator, Mapping

from zoh.app.paper import recipe, table
from zoh.app.paper.printed import LAWS, MARGIN_ASKED_DEG, METRICS, value, values
from zoh.app.paper.recipe import ARM, POTENTIOMETER
from zoh.app.paper.study import Study

Value = float | None


def recomputed(found: Study) -> Mapping[str, Value]:
    """Return a value for every id of ``printed.NUMBERS``; None for a metric without a value."""
    out: dict[str, Value] = dict(_plant(found))
    for law in LAWS:
        out.update(_design(found, law))
        out.update(_loop(found, law))
    twice = table.read_off(found.twice)
    out.update({f"table_1.{law}.{m}": twice[law][m] for law in LAWS for m in METRICS})
    out["table_1.steady_state_error"] = _worst_error(found)
    return out


def _plant(found: Study) -> Iterator[tuple[str, Value]]:
    pole_s, pole_z = ARM.den[1], values("plant.Gd_denominator")[2]
    yield "plant.sampling_time_s", recipe.sample_time_behind(pole_s, pole_z)
    yield "plant.potentiometer_V_per_deg", POTENTIOMETER
    yield "plant.Gc_numerator", ARM.num[0] * ARM.sensor
    yield from _listed("plant.Gc_denominator", ARM.den)
    sampled = found.as_printed["none"].sampled
    yield from _listed("plant.Gd_numerator", sampled.num)
    yield from _listed("plant.Gd_denominator", sampled.den)
    margin = found.as_printed["none"].margins.phase_margin_deg
    yield "plant.uncompensated_phase_margin_deg", margin


def _design(found: Study, law: str) -> Iterator[tuple[str, Value]]:
    made = found.recipes[law]
    yield from ((f"{law}.{key}", number) for key, number in made.parameters.items())
    yield from _listed(f"{law}.D_num", made.controller.num)
    yield from _listed(f"{law}.D_den", made.controller.den)
    if law in ("lag", "lead"):
        yield f"{law}.dc_gain", made.controller.at(0.0).real
    if law == "lag":
        yield "lag.wc_rad_s", value("lag.w0") / 0.1  # its rule: w0 = 0.1 wc
        return
    theta = value(f"{law}.theta_r_deg")
    yield f"{law}.wc_rad_s", recipe.crossover_behind(theta, MARGIN_ASKED_DEG)
    if law == "pid":
        ki = recipe.integral_gain_behind(
            value("pid.KD"), wc=value("pid.wc_rad_s"), pm_deg=MARGIN_ASKED_DEG
        )
        yield "pid.KI", ki


def _loop(found: Study, law: str) -> Iterator[tuple[str, Value]]:
    margins = found.as_printed[law].margins
    yield f"{law}.phase_margin_deg", margins.phase_margin_deg
    yield f"{law}.crossover_rad_s", margins.crossover
    yield f"{law}.gain_margin_dB", margins.gain_margin_db


def _worst_error(found: Study) -> Value:
    """Return the largest steady-state error of the four loops, as designed or sensor twice."""
    steps = [loops[law].step for loops in (found.as_printed, found.twice) for law in LAWS]
    ends = [step.steady_state_error if step else None for step in steps]
    errors = [abs(error) for error in ends if error is not None]
    return max(errors) if len(errors) == len(steps) else None


def _listed(name: str, numbers: tuple[float, ...]) -> Iterator[tuple[str, Value]]:
    return ((f"{name}.{i}", number) for i, number in enumerate(numbers))
