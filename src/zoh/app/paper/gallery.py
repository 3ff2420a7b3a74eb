"""The figures of the report: the paper's seven, then the exact designs side by side."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from zoh.analysis.margins import margins
from zoh.analysis.verify import Measured
from zoh.app.paper.printed import LAWS
from zoh.app.paper.recipe import MOTOR_AND_GEAR
from zoh.app.paper.study import NAMES, Study
from zoh.report import figures as fig
from zoh.report.document import response
from zoh.report.text import horizon

INPUT = 0.07  # V, the step of figure 12
BODE = {"lag": "fig5", "lead": "fig7", "pi": "fig9", "pid": "fig11"}
TWICE_END = 120.0  # s, past the settling time of the slowest loop of figure 12
EFFORT_END = 3.0  # s, the moves that cost

Drawing = tuple[str, str, Figure]  # file name, caption, figure


def drawings(found: Study) -> tuple[list[Drawing], list[Drawing]]:
    """Return (the paper's seven figures, ours)."""
    return list(_of_the_paper(found)), list(_compared(found))


def _of_the_paper(found: Study) -> Iterator[Drawing]:
    title = "Motor and gear alone, 2.3/(s² + 0.7809 s)"
    motor = fig.bode(MOTOR_AND_GEAR, margins(MOTOR_AND_GEAR), title=title)
    yield "fig2", "Figure 2: Bode plot of motor and gear alone, continuous", motor
    alone = found.as_printed["none"]
    title = "Plant and sensor, uncompensated open loop"
    yield "fig3", f"Figure 3: {title}", fig.bode(alone.loop, alone.margins, title=title)
    for law in LAWS:
        loop, name = found.as_printed[law], BODE[law]
        called = "phase-lag (in truth a lead)" if law == "lag" else NAMES[law]
        title = f"Open loop with the {called} as printed"
        figure = fig.bode(loop.loop, loop.margins, title=title)
        yield name, f"Figure {name[3:]}: {title}", figure
    yield _step_figure(found)


def _step_figure(found: Study) -> Drawing:
    designed = [found.as_printed[law] for law in LAWS]
    end = horizon(d.step for d in designed)
    twice = [_named(found.twice[law], law, TWICE_END, 2) for law in LAWS]
    once = [_named(d, law, end, 20) for law, d in zip(LAWS, designed, strict=True)]
    panels = [
        ("As printed: the sensor gain counted twice", twice),
        ("The loop as designed: the sensor gain counted once", once),
    ]
    title = "Closed loops, input 0.07 u(t)"
    figure = fig.step_pair(panels, reference=INPUT, title=title)
    return "fig12", "Figure 12: step responses of the four closed loops, both readings", figure


def _named(loop: Measured, law: str, t_end: float, per_sample: int) -> fig.Response:
    return response(loop, t_end=t_end, per_sample=per_sample, reference=INPUT, name=NAMES[law])


def _compared(found: Study) -> Iterator[Drawing]:
    designs = list(found.exact.values())
    end = horizon(d.step for d in designs)
    title = "Exact designs, open loops, every one at 40°"
    yield "exact-bode", title, fig.compare(designs, title=title)
    title = "Exact designs, unit step: dots at the samples, lines between them"
    shown = [response(d, t_end=end) for d in designs]
    yield "exact-step", title, fig.steps(shown, reference=1.0, title=title)
    title = "Exact designs, control effort, held from sample to sample"
    short = [response(d, t_end=EFFORT_END) for d in designs]
    yield "exact-effort", title, fig.efforts(short, title=title)
    title = "Exact designs, Nyquist: the circle round -1 that each loop just touches"
    yield "exact-nyquist", title, fig.nyquist(designs, title=title)
    for law, design in found.exact.items():
        title = f"{NAMES[law]}: real frequency and w-plane frequency"
        yield f"exact-scales-{law}", title, fig.both_scales(design, title=title)
        title = f"{NAMES[law]}: unit step at the samples and between them, and its effort"
        one = response(design, t_end=horizon([design.step]))
        yield f"exact-step-{law}", title, fig.step(one, reference=1.0, title=title)
