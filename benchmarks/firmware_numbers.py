"""What each number format costs the robot arm's controllers, and what four printed digits cost.

    python -m benchmarks.firmware_numbers

prints the two tables of docs/firmware.md: the controllers of examples/robot_arm.toml as designed,
in 16 and 32 bits and in float32, and with their coefficients of z written in four digits; and the
paper's own controllers as its recipe makes them, as it prints them, and in 16 bits.
"""

from collections.abc import Iterator
from pathlib import Path

import zoh
from zoh.analysis.results import Margins
from zoh.app.commands import design_all
from zoh.app.paper.recipe import ARM, lag, lead, proportional_integral, three_terms
from zoh.app.project import read
from zoh.firmware.plan import plan
from zoh.firmware.roundoff import round_off

EXAMPLES = Path(__file__).parents[1] / "examples"
RANGES = {"u_min": -12.0, "u_max": 12.0, "y_range": (-12, 12)}
RECIPES = {
    "phase-lag": lag(wc=3.29, dc_gain=10),
    "phase-lead": lead(wc=2.5, pm_deg=40, dc_gain=10),
    "PI": proportional_integral(wc=0.8, pm_deg=40),
    "PID": three_terms(wc=1.95, pm_deg=40, ki=0.85),
}


def written(controller: zoh.Sampled, digits: int) -> zoh.Sampled:
    """Return the controller whose coefficients of z have this many significant digits."""
    num, den = ([float(f"{c:.{digits}g}") for c in a] for a in (controller.num, controller.den))
    return zoh.Sampled(num=num, den=den, dt=controller.dt)


def row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def margins(m: Margins) -> tuple[str, str, str]:
    return f"{m.phase_margin_deg:.6f}", f"{m.gain_margin_db:.4f}", f"{m.ms:.5f}"


def overshoot(found: zoh.Verified) -> str:
    return f"{(found.step.between_samples or found.step).overshoot_pct:.4f}"


def of_designs() -> Iterator[str]:
    """Yield the rows of the designs in every number format."""
    for entry in design_all(read((EXAMPLES / "robot_arm.toml").read_text())):
        design = entry.measured
        assert isinstance(design, zoh.Verified)
        yield row(entry.name, "design", *margins(design.margins), overshoot(design), "", "")
        for number in ("q15", "q31", "f32"):
            made = plan(design, number=number, **RANGES)
            moved = round_off(made)
            yield row(
                "", number, *margins(made.quantised.margins), overshoot(made.quantised),
                f"{moved.y_bound:.1e}", f"{moved.y_noise:.1e}",
            )  # fmt: skip
        cut = zoh.verify(design.plant, written(design.controller, 4))
        yield row("", "four digits", *margins(cut.margins), overshoot(cut), "", "")


def of_the_paper() -> Iterator[str]:
    """Yield the rows of the paper's controllers: by its recipe, as printed, in 16 bits."""
    printed = design_all(read((EXAMPLES / "robot_arm_as_printed.toml").read_text()))
    for entry in printed:
        recipe = zoh.verify(ARM, RECIPES[entry.name].controller)
        assert entry.measured is not None
        made = plan(recipe, number="q15", **RANGES)
        rows = {
            "by its recipe": recipe.margins, "as printed": entry.measured.margins,
            "its recipe in q15": made.quantised.margins,
        }  # fmt: skip
        for i, (what, m) in enumerate(rows.items()):
            moved = m.phase_margin_deg - recipe.margins.phase_margin_deg
            yield row("" if i else entry.name, what, *margins(m), f"{moved:+.4f}" if i else "")


def lines() -> Iterator[str]:
    """Yield both tables, a line at a time."""
    head = ("", "", "phase margin, deg", "gain margin, dB", "Ms")
    for more, rows in (
        (("overshoot, %", "rounding moves y by at most, V", "as noise"), of_designs()),
        (("costs, deg",), of_the_paper()),
    ):
        yield row(*head, *more)
        yield row(*["---"] * len((*head, *more)))
        yield from rows
        yield ""


if __name__ == "__main__":
    print(*lines(), sep="\n")
