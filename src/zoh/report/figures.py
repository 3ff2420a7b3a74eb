"""Every drawing of zoh, under one roof: measured values in, a matplotlib figure out.

Bode plots are in ``report.bode``; here are the responses in time, the control effort and the
Nyquist plot. ``render`` turns a figure into SVG text and PNG bytes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from zoh.analysis.curves import Trace
from zoh.analysis.verify import Measured
from zoh.report import canvas
from zoh.report.bode import bode, both_scales, compare, margin_title
from zoh.report.canvas import FAINT, INK, SOFT, render
from zoh.report.curves import frequencies, lowest

__all__ = [
    "Response",
    "bode",
    "both_scales",
    "compare",
    "efforts",
    "margin_title",
    "nyquist",
    "render",
    "step",
    "step_pair",
    "steps",
]


DOTS = 200  # samples that stay apart on a page 600 px wide; a longer response is its line


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """One line of a step plot: its name, the law that gives its colour, and its trace."""

    name: str
    law: str
    trace: Trace


def step(response: Response, *, reference: float, title: str) -> Figure:
    """Draw one response, at the samples and between them, above its control effort."""
    with canvas.style():
        figure = canvas.sheet(6.0, 4.6)
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        (colour,) = canvas.colours([response.law])
        trace = response.trace
        top.axhline(reference, color=INK, linewidth=0.8, linestyle=(0, (4, 3)))
        top.plot(trace.t_between, trace.y_between, color=colour, label="between the samples")
        top.plot(
            trace.t, trace.y, "o", color=colour, markersize=3.6, markeredgecolor="white",
            markeredgewidth=0.5, label="at the samples",
        )  # fmt: skip
        top.legend(loc="lower right", labelcolor=INK)
        bottom.step(trace.t, trace.u, where="post", color=colour, linewidth=1.4)
        bottom.axhline(0, color=SOFT, linewidth=0.7)
        _peak(bottom, response)
        top.set_ylabel("output")
        bottom.set_ylabel("controller output")
        bottom.set_xlabel("time, s")
        top.set_xlim(0, float(trace.t[-1]))
        top.set_title(title)
    return figure


def steps(responses: Sequence[Response], *, reference: float, title: str) -> Figure:
    """Draw the responses of several loops: lines between the samples, dots at them."""
    with canvas.style():
        figure = canvas.sheet(6.0, 3.8)
        ax = figure.subplots()
        _steps_on(ax, responses, reference)
        canvas.key(ax, columns=min(len(responses), 5))
        ax.set_title(title, pad=22)
    return figure


def step_pair(
    panels: Sequence[tuple[str, Sequence[Response]]], *, reference: float, title: str
) -> Figure:
    """Draw the same loops under two readings, one above the other, each on its own clock."""
    with canvas.style():
        figure = canvas.sheet(6.0, 6.2)
        axes = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
        for i, (ax, (name, responses)) in enumerate(zip(axes, panels, strict=True)):
            _steps_on(ax, responses, reference)
            ax.set_title(f"{title}\n{name}" if i == 0 else name, pad=22 if i == 0 else 8)
            if i == 0:
                canvas.key(ax, columns=len(responses))
    return figure


def efforts(responses: Sequence[Response], *, title: str) -> Figure:
    """Draw what each controller asks of the actuator, held from sample to sample."""
    with canvas.style():
        figure = canvas.sheet(6.0, 3.6)
        ax = figure.subplots()
        ends = []
        for response, colour in _painted(responses):
            trace = response.trace
            peak = float(np.max(np.abs(trace.u)))
            ax.step(
                trace.t, trace.u, where="post", color=colour, linewidth=1.5,
                label=f"{response.name}, peak {peak:.3g}",
            )  # fmt: skip
            ends.append(float(trace.t[-1]))
        ax.axhline(0, color=SOFT, linewidth=0.7)
        ax.set_xlim(0, min(ends))
        ax.set_ylabel("controller output")
        ax.set_xlabel("time, s")
        ax.legend(loc="upper right", labelcolor="linecolor", handlelength=1.1)
        ax.set_title(title)
    return figure


def nyquist(designs: Sequence[Measured], *, title: str) -> Figure:
    """Draw each loop near -1, with the circle it just touches: its radius is 1/Ms."""
    with canvas.style():
        columns = 1 if len(designs) == 1 else 2
        rows = -(-len(designs) // columns)
        figure = canvas.sheet(3.1 * columns + (1.2 if columns == 1 else 0), 3.0 * rows + 0.4)
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        paints = canvas.colours([d.law for d in designs])
        for ax, design, colour in zip(axes, designs, paints, strict=False):
            _nyquist_on(ax, design, colour)
        for ax in axes[len(designs) :]:
            ax.set_axis_off()
        figure.suptitle(title, x=0.01, ha="left", fontsize=9.5, weight="bold")
    return figure


def _painted(responses: Sequence[Response]) -> list[tuple[Response, str]]:
    paints = canvas.colours([r.law for r in responses])
    return list(zip(responses, paints, strict=True))


def _steps_on(ax: Axes, responses: Sequence[Response], reference: float) -> None:
    ax.axhline(reference, color=INK, linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)
    for response, colour in _painted(responses):
        trace = response.trace
        ax.plot(trace.t_between, trace.y_between, color=colour, linewidth=1.5, label=response.name)
        if len(trace.t) <= DOTS:
            ax.plot(trace.t, trace.y, "o", color=colour, markersize=2.6)
    ax.set_xlim(0, max(float(r.trace.t[-1]) for r in responses))
    lowest_y = min(float(r.trace.y_between.min()) / reference for r in responses)
    if lowest_y > -1e-6:  # of the reference: nothing undershoots, so the axis starts at 0
        ax.set_ylim(bottom=0)
    ax.set_ylabel("output")
    ax.set_xlabel("time, s")


def _peak(ax: Axes, response: Response) -> None:
    k = int(np.argmax(np.abs(response.trace.u)))
    t, u = float(response.trace.t[k]), float(response.trace.u[k])
    ax.annotate(
        f"peak {u:.3g} at {t:.3g} s", (1, 1), xycoords="axes fraction", xytext=(-2, -4),
        textcoords="offset points", ha="right", va="top", fontsize=8.5, color=INK,
    )  # fmt: skip


def _nyquist_on(ax: Axes, design: Measured, colour: str) -> None:
    w = frequencies(design.loop, lowest(design.loop, design.margins.crossover), pi / design.dt)
    response = design.loop.at(w)
    turn = np.linspace(0, 2 * pi, 200)
    ax.plot(np.cos(turn), np.sin(turn), color=FAINT, linewidth=1.0)
    radius = design.margins.modulus_margin
    ax.add_patch(Circle((-1, 0), radius, facecolor=colour, alpha=0.12, linewidth=0))
    ax.add_patch(Circle((-1, 0), radius, fill=False, edgecolor=colour, linewidth=1.0))
    ax.plot(response.real, response.imag, color=colour)
    ax.plot(response.real, -response.imag, color=colour, linewidth=0.8, linestyle=(0, (2, 2)))
    touch = design.loop.at(design.margins.ms_frequency)
    ax.plot([touch.real], [touch.imag], "o", color=colour, markersize=4)
    ax.plot([-1], [0], "+", color=INK, markersize=8, markeredgewidth=1.6)
    ax.set_aspect("equal")
    ax.set_xlim(-2.4, 1.3)
    ax.set_ylim(-1.8, 1.8)
    ax.set_title(f"{design.name}: Ms = {design.margins.ms:.3g}")
    ax.set_xlabel("real")
    ax.set_ylabel("imaginary")
