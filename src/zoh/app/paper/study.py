"""Every loop that the report needs, measured once: as printed, as typed in, and exact."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from zoh.analysis.margins import margins
from zoh.analysis.results import Margins
from zoh.analysis.verify import Measured, Verified, measure
from zoh.app.paper import recipe
from zoh.app.paper.printed import LAG_SEES_DEG, LAWS, MARGIN_ASKED_DEG, value, values
from zoh.app.paper.recipe import ARM, DT, POTENTIOMETER, Recipe
from zoh.errors import Infeasible, ZohError
from zoh.lti.systems import Plant, Sampled
from zoh.lti.wplane import warp
from zoh.pipeline import design

NAMES = {"none": "D = 1", "lag": "phase-lag", "lead": "phase-lead", "pi": "PI", "pid": "PID"}

# Only this loop, with the sensor in it twice, has the step responses of Table I.
ARM_TWICE = Plant(num=ARM.num, den=ARM.den, sensor=POTENTIOMETER**2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """The robot arm under every reading of the paper, by law: none, lag, lead, pi, pid.

    recipes        the controllers of the paper's recipe, unrounded
    as_printed     their loops
    as_typed       the loops of the coefficients that a reader would type in from the page
    twice          the loops of the recipe with the sensor counted twice
    exact          the library's own, at the paper's crossovers, and a lag that is one
    refused        what the library answers to the paper's own lag request
    printed_plant  G(z) with its printed digits, and the margins of D = 1 with it
    warped_lead    the recipe's lead with v = (2/dt) tan(wc dt/2) in the place of wc
    """

    recipes: Mapping[str, Recipe]
    as_printed: Mapping[str, Measured]
    as_typed: Mapping[str, Measured]
    twice: Mapping[str, Measured]
    exact: Mapping[str, Verified]
    refused: Infeasible
    printed_plant: tuple[Sampled, Margins]
    warped_lead: Measured


@lru_cache(maxsize=1)
def study() -> Study:
    """Return the study: nothing goes in, so it is made once."""
    recipes = _recipes()
    typed = Sampled(num=values("plant.Gd_numerator"), den=values("plant.Gd_denominator"), dt=DT)
    warped = recipe.lead(
        wc=value("lead.wc_rad_s"),
        pm_deg=MARGIN_ASKED_DEG,
        dc_gain=value("lead.dc_gain"),
        v=warp(value("lead.wc_rad_s"), DT),
    )
    return Study(
        recipes=recipes,
        as_printed={
            law: _measured(r.controller, law, "as printed", r.gains) for law, r in recipes.items()
        },
        as_typed={law: _measured(d, law, "as typed in") for law, d in _typed_in().items()},
        twice={
            law: _measured(recipes[law].controller, law, "sensor twice", plant=ARM_TWICE)
            for law in LAWS
        },
        exact=_exact(),
        refused=_refused(),
        printed_plant=(typed, margins(typed)),
        warped_lead=_measured(warped.controller, "lead", "with wc warped"),
    )


def _recipes() -> dict[str, Recipe]:
    pm = MARGIN_ASKED_DEG
    made = (
        recipe.nothing(),
        recipe.lag(wc=value("lag.wc_rad_s"), dc_gain=value("lag.dc_gain")),
        recipe.lead(wc=value("lead.wc_rad_s"), pm_deg=pm, dc_gain=value("lead.dc_gain")),
        recipe.proportional_integral(wc=value("pi.wc_rad_s"), pm_deg=pm),
        recipe.three_terms(wc=value("pid.wc_rad_s"), pm_deg=pm, ki=value("pid.KI")),
    )
    return {r.law: r for r in made}


def _typed_in() -> dict[str, Sampled]:
    """Return the controllers of the printed coefficients, misprints included."""
    gain = value("lead.D_gain")
    made = {
        law: Sampled(num=values(f"{law}.D_num"), den=values(f"{law}.D_den"), dt=DT)
        for law in ("lag", "pi", "pid")
    }
    made["lead"] = Sampled(
        num=(gain, -gain * value("lead.D_zero")), den=(1.0, -value("lead.D_pole")), dt=DT
    )
    return {law: made[law] for law in LAWS}


def _measured(
    controller: Sampled,
    law: str,
    reading: str,
    gains: Mapping[str, float] | None = None,
    plant: Plant = ARM,
) -> Measured:
    name = f"{NAMES[law]}, {reading}"
    return measure(plant, controller, law=law, gains=gains, name=name)


def _exact() -> dict[str, Verified]:
    """Return the library's designs.

    The lag stands where the paper's own section III would put one: where the plant is at
    -180 + 5 + 40 = -135 deg, so that 5 deg are left for the lag to take.
    """
    pm, gain = MARGIN_ASKED_DEG, value("lag.dc_gain")
    lag_wc = round(recipe.crossover_behind(180 + pm - LAG_SEES_DEG, pm), 2)
    asked = {
        "lag": {"wc": lag_wc, "pm_deg": pm, "dc_gain": gain},
        "lead": {"wc": value("lead.wc_rad_s"), "pm_deg": pm, "dc_gain": value("lead.dc_gain")},
        "pi": {"wc": value("pi.wc_rad_s"), "pm_deg": pm},
        "pid": {"wc": value("pid.wc_rad_s"), "pm_deg": pm, "ki": value("pid.KI")},
    }
    return {
        law: design(ARM, law, parameters, dt=DT, name=f"{NAMES[law]}, exact")
        for law, parameters in asked.items()
    }


def _refused() -> Infeasible:
    """Return the library's answer to the lag that the paper asks for."""
    asked = {
        "wc": value("lag.wc_rad_s"),
        "pm_deg": MARGIN_ASKED_DEG,
        "dc_gain": value("lag.dc_gain"),
    }
    try:
        design(ARM, "lag", asked, dt=DT)
    except Infeasible as refusal:
        return refusal
    raise ZohError("zoh.lag met the paper's lag request, which needs phase lead")
