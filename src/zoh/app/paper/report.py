"""The pages: REPORT.md and its figures, in the paper's order."""

from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure

from zoh.analysis.margins import margins
from zoh.analysis.verify import Measured
from zoh.app.paper.printed import LAWS, METRICS
from zoh.app.paper.recipe import MOTOR_AND_GEAR
from zoh.app.paper.study import NAMES, Study
from zoh.app.paper.terminal import WAYS, WORDS, counted, lag_sentence, text_of
from zoh.report import figures as fig
from zoh.report.document import Files, drawn, picture, response
from zoh.report.text import design_table, horizon, in_w, in_z, number, table

INPUT = 0.07  # V, the step of figure 12
BODE = {"lag": "fig5", "lead": "fig7", "pi": "fig9", "pid": "fig11"}
TWICE_END = 120.0  # s, past the PI's settling time of figure 12
NOTE = (
    "What the paper chose rather than computed (sample time, crossovers, the PID's KI) is solved "
    "back from another printed number that depends on it."
)


def pages(result: dict[str, Any], found: Study) -> Files:
    """Return {file name: content} for the whole report."""
    files: Files = {}
    captions: dict[str, str] = {}
    for name, (caption, draw) in _drawings(found).items():
        files.update(drawn(name, fig.render(draw())))
        captions[name] = picture(name, caption)
    return {"REPORT.md": _text(result, found, captions), **files}


def _drawings(found: Study) -> dict[str, tuple[str, Callable[[], Figure]]]:
    """Return {file name: (caption, what draws it)}: the paper's seven figures, then ours."""
    return {**_paper_bodes(found), **_steps(found), **_comparisons(found)}


def _paper_bodes(found: Study) -> dict[str, tuple[str, Callable[[], Figure]]]:
    alone = found.as_printed["none"]
    drawings: dict[str, tuple[str, Callable[[], Figure]]] = {
        "fig2": ("Figure 2: motor and gear alone", lambda: _motor(alone)),
        "fig3": (
            "Figure 3: plant and sensor, the uncompensated open loop",
            lambda: fig.bode(alone.loop, alone.margins, title="Plant and sensor, D = 1"),
        ),
    }
    for law, name in BODE.items():
        loop = found.as_printed[law]
        called = f"{NAMES[law]}-compensated open loop, as printed"
        drawings[name] = (f"Figure {name[3:]}: the {called}", _margin_plot(loop, called))
    return drawings


def _margin_plot(loop: Measured, called: str) -> Callable[[], Figure]:
    title = called[0].upper() + called[1:]
    return lambda: fig.bode(loop.loop, loop.margins, title=title)


def _motor(alone: Measured) -> Figure:
    return fig.bode(
        MOTOR_AND_GEAR,
        margins(MOTOR_AND_GEAR),
        title="Motor and gear alone, 2.3/(s² + 0.7809 s)",
        name="continuous",
    )


def _steps(found: Study) -> dict[str, tuple[str, Callable[[], Figure]]]:
    end = horizon(found.as_printed[law].step for law in LAWS)

    def fig12() -> Figure:
        twice = [response(found.twice[law], t_end=TWICE_END, per_sample=2) for law in LAWS]
        designed = [response(found.as_printed[law], t_end=end) for law in LAWS]
        return fig.step_pair(
            [
                ("as printed: the sensor gain counted twice", twice),
                ("the loop as designed", designed),
            ],
            reference=INPUT,
            title="Closed loops, input 0.07 u(t)",
        )

    caption = "Figure 12: step responses of the four closed loops, input 0.07 u(t)"
    return {"fig12": (caption, fig12)}
