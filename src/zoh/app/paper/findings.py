"""What does not agree, and why: one sentence each, its numbers taken from the study."""

from cmath import phase
from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees
from typing import Any

from zoh.app.paper import recipe, table
from zoh.app.paper.printed import LAWS, MARGIN_ASKED_DEG, METRICS, value
from zoh.app.paper.recipe import DT
from zoh.app.paper.study import Study
from zoh.lti.wplane import warp


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One discrepancy.

    name      short, for a heading
    ids       the printed numbers that it explains
    verdict   what kind it is, where the numbers do not agree
    sentence  the explanation
    """

    name: str
    ids: tuple[str, ...]
    verdict: str
    sentence: str

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form; the verdict stands with each number."""
        return {"name": self.name, "ids": list(self.ids), "sentence": self.sentence}


def findings(found: Study) -> tuple[Finding, ...]:
    """Return every known discrepancy, in the paper's order."""
    return (
        _four_digits(found),
        _mislabelled(found),
        _crossover(found),
        _cosine(found),
        _pole(found),
        _warp(found),
        _table(found),
    )


def by_id(found: Study) -> Mapping[str, Finding]:
    """Return the finding that explains each id."""
    return {number: finding for finding in findings(found) for number in finding.ids}


def _four_digits(found: Study) -> Finding:
    system, rounded = found.printed_plant
    outside = max(abs(pole) for pole in system.poles())
    true = found.as_printed["none"].margins.phase_margin_deg
    return Finding(
        name="Four digits of G(z)",
        ids=tuple(f"plant.Gd_denominator.{i}" for i in range(3)),
        verdict="not-as-claimed",
        sentence=(
            "Rounded to four digits, the denominator of G(z) no longer sums to zero, so the "
            f"integrator at z = 1 becomes an unstable pole at z = {outside:.4f}, and typed in "
            f"like this it costs {true - rounded.phase_margin_deg:.2f} deg: the uncompensated "
            f"phase margin falls from {true:.2f} to {rounded.phase_margin_deg:.2f} deg."
        ),
    )


def _mislabelled(found: Study) -> Finding:
    p, wc = found.recipes["lag"].parameters, value("lag.wc_rad_s")
    turn = degrees(phase(found.recipes["lag"].controller.at(wc)))
    in_w = recipe.turn_in_w(wc, w0=p["w0"], wp=p["wp"])
    return Finding(
        name="A lead called lag",
        ids=("lag.kind",),
        verdict="mislabelled",
        sentence=(
            f"The controller called phase-lag is a phase-lead: its zero at {p['w0']:.3f} rad/s "
            f"lies below its pole at {p['wp']:.3f} rad/s, and at {wc:g} rad/s it turns the phase "
            f"by {turn:+.1f} deg ({in_w:+.1f} deg where the paper, without the warp, looks)."
        ),
    )


def _crossover(found: Study) -> Finding:
    loop, wc = found.as_printed["lag"], value("lag.crossover_rad_s")
    return Finding(
        name="The lag's crossover",
        ids=("lag.crossover_rad_s",),
        verdict="not-as-claimed",
        sentence=(
            f"The loop crosses over at {loop.margins.crossover or 0:.2f} instead of {wc:g} "
            "rad/s: the textbook lag rule takes the gain that is needed at wc for the "
            "high-frequency gain, which this controller has not reached there, so that |D G| at "
            f"{wc:g} rad/s is {abs(loop.loop.at(wc)):.3f} and not 1."
        ),
    )


def _cosine(found: Study) -> Finding:
    p = found.recipes["lead"].parameters
    return Finding(
        name="cos θ_r of the lead",
        ids=("lead.cos_theta_r",),
        verdict="misprint",
        sentence=(
            f"Printed is cos θ_r = {value('lead.cos_theta_r'):g}, but the cosine of the printed "
            f"θ_r = {value('lead.theta_r_deg'):g} deg is {p['cos_theta_r']:.4f}, and the printed "
            "a1 and b1 follow only from that one."
        ),
    )


def _pole(found: Study) -> Finding:
    typed, made = found.as_typed["lead"].margins, found.as_printed["lead"].margins
    return Finding(
        name="The pole of the lead",
        ids=("lead.D_pole",),
        verdict="misprint",
        sentence=(
            f"Printed is a pole at {value('lead.D_pole'):g}, with two digits swapped, for "
            f"{found.recipes['lead'].parameters['D_pole']:.4f}: typed in as printed, the loop has "
            f"{typed.phase_margin_deg:.1f} deg and {typed.gain_margin_db:.1f} dB instead of "
            f"{made.phase_margin_deg:.1f} deg and {made.gain_margin_db:.1f} dB."
        ),
    )


def _warp(found: Study) -> Finding:
    wc, margin = value("lead.wc_rad_s"), found.as_printed["lead"].margins.phase_margin_deg
    mended = found.warped_lead.margins.phase_margin_deg
    return Finding(
        name="The missing frequency warp",
        ids=("lead.phase_margin_deg",),
        verdict="not-as-claimed",
        sentence=(
            f"The lead is {MARGIN_ASKED_DEG - margin:.3f} deg short of {MARGIN_ASKED_DEG:g}, "
            "less than its printed digits show, because the recipe takes G at the real frequency "
            f"wc = {wc:g} rad/s but puts this wc, and not the warped (2/T) tan(wc T/2) = "
            f"{warp(wc, DT):.4f} rad/s, into the w-plane formulas; with the warp it has "
            f"{mended:.3f} deg."
        ),
    )


def _table(found: Study) -> Finding:
    designed, twice = table.read_off(found.as_printed), table.read_off(found.twice)
    overshoot = [designed[law]["overshoot_pct"] or 0.0 for law in LAWS]
    faster = [
        (twice[law]["settling_s"] or 0.0) / (designed[law]["settling_s"] or 1.0) for law in LAWS
    ]
    return Finding(
        name="Table I",
        ids=tuple(f"table_1.{law}.{metric}" for law in LAWS for metric in METRICS),
        verdict="artefact",
        sentence=(
            "Table I counts the sensor gain twice: 0.1533 already contains 12/180, and only with "
            "the loop gain multiplied by 12/180 once more do its entries come out, while the "
            f"loop that was designed has {min(overshoot):.0f} to {max(overshoot):.0f} % overshoot "
            f"and settles {min(faster):.1f} to {max(faster):.1f} times faster."
        ),
    )
