"""Bode plots: margins marked where they are read, over both frequency scales.

Nothing is measured here: margins come in as ``Margins``, curves are responses.
"""

from collections.abc import Sequence
from math import inf, isfinite, pi
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from zoh.analysis.results import Margins
from zoh.analysis.verify import Measured
from zoh.lti.systems import Plant, Sampled
from zoh.lti.wplane import warp
from zoh.report import canvas
from zoh.report.canvas import BLUE, FAINT, GREEN, RED, SOFT
from zoh.report.curves import Array, frequencies, lowest, phase_deg

NEAR_NYQUIST = 0.99  # where a line ends: past it v runs away, which the w-plane shows better

_MARK: dict[str, Any] = {"color": RED, "linewidth": 2.2, "solid_capstyle": "butt", "zorder": 4}
_GUIDE: dict[str, Any] = {"color": SOFT, "linewidth": 0.8, "linestyle": (0, (1, 2)), "zorder": 2}


def margin_title(found: Margins) -> str:
    """Return both margins and where they are, in the words of the usual margin plot."""
    gain = _at(f"Gm = {found.gain_margin_db:.3g} dB", found.phase_crossover)
    if found.phase_crossover is None:
        gain = "Gm = ∞"
    phase = _at(f"Pm = {found.phase_margin_deg:.3g}°", found.crossover)
    if found.crossover is None:
        phase = "Pm = ∞"
    return f"{gain},  {phase}"


def bode(
    loop: Plant | Sampled,
    found: Margins,
    *,
    title: str,
    name: str = "loop",
    beside: tuple[str, Plant | Sampled] | None = None,
) -> Figure:
    """Draw magnitude and phase of an open loop with its margins marked.

    ``beside`` is a second system, drawn thin for comparison.
    """
    with canvas.style():
        figure = canvas.sheet(6.0, 4.6)
        top, bottom = figure.subplots(2, 1, sharex=True)
        w = _axis(loop, found)
        lines = [(name, loop, BLUE, 1.9)]
        if beside is not None:
            lines.append((*beside, canvas.ORANGE, 1.4))
        for label, system, colour, width in lines:
            x = frequencies(system, float(w[0]), float(w[-1]))
            top.plot(x, _db(system, x), color=colour, linewidth=width, label=label)
            bottom.plot(x, phase_deg(system, x), color=colour, linewidth=width)
        _mark_margins(top, bottom, loop, found)
        if isinstance(loop, Sampled):
            _mark_nyquist(top, bottom, pi / loop.dt)
        _finish(top, bottom, (float(w[0]), _right_edge(loop, found, w)))
        top.set_title(f"{title}\n{margin_title(found)}")
        if beside is not None:
            _name_lines(top)
    return figure


def both_scales(measured: Measured, *, title: str | None = None) -> Figure:
    """Draw plant, controller and loop over the real frequency and over the w-plane's."""
    loop, found, dt = measured.loop, measured.margins, measured.dt
    w = frequencies(loop, lowest(loop, found.crossover), pi / dt * (1 - 1e-6))
    lines = (
        ("plant G", measured.sampled, SOFT, 1.3),
        ("controller D", measured.controller, GREEN, 1.3),
        ("loop L = D G", loop, BLUE, 2.0),
    )
    with canvas.style():
        figure = canvas.sheet(6.6, 4.6)
        axes = figure.subplots(2, 2, sharex="col", sharey="row")
        for column, x in enumerate((w, _warped(w, dt))):
            keep = x <= 100 * 2 / dt
            top, bottom = axes[0][column], axes[1][column]
            for label, system, colour, width in lines:
                db, angle = _db(system, w), phase_deg(system, w)
                top.plot(x[keep], db[keep], color=colour, linewidth=width, label=label)
                bottom.plot(x[keep], angle[keep], color=colour, linewidth=width)
            _cross(top, bottom, measured, warped=column == 1)
            edge = float(x[keep][-1])
            _finish(top, bottom, (float(x[0]), edge if column else 1.25 * edge))
        axes[0][1].set_ylabel("")
        axes[1][1].set_ylabel("")
        for ax in axes[:, 0]:
            ax.axvline(pi / dt, color=SOFT, linewidth=0.9, zorder=1)
        axes[1][0].set_xlabel(f"real frequency ω, rad/s (Nyquist {pi / dt:.3g})")
        axes[1][1].set_xlabel("w-plane frequency v, rad/s")
        figure.suptitle(title or measured.name, x=0.01, ha="left", fontsize=9.5, weight="bold")
        handles, names = axes[0][0].get_legend_handles_labels()
        figure.legend(
            handles, names, loc="outside lower center", ncols=3, labelcolor="linecolor",
            handlelength=1.1, borderaxespad=0.2,
        )  # fmt: skip
    return figure


def compare(designs: Sequence[Measured], *, title: str) -> Figure:
    """Draw the open loops of several designs, each crossover a dot."""
    with canvas.style():
        figure = canvas.sheet(6.0, 4.8)
        top, bottom = figure.subplots(2, 1, sharex=True)
        low = min(lowest(d.loop, d.margins.crossover) for d in designs)
        high = max(pi / d.dt for d in designs)
        paints = canvas.colours([d.law for d in designs])
        for design, colour in zip(designs, paints, strict=True):
            w = frequencies(design.loop, low, NEAR_NYQUIST * pi / design.dt)
            top.plot(w, _db(design.loop, w), color=colour, label=design.name)
            bottom.plot(w, phase_deg(design.loop, w), color=colour)
            wc = design.margins.crossover
            if wc:
                at = np.array([wc])
                dot: dict[str, Any] = {
                    "color": colour,
                    "markersize": 5.5,
                    "markeredgecolor": "white",
                    "zorder": 5,
                }
                top.plot(at, [0.0], "o", **dot)
                bottom.plot(at, phase_deg(design.loop, at), "o", **dot)
        top.axhline(0, **_GUIDE)
        bottom.axhline(-180, **_GUIDE)
        _mark_nyquist(top, bottom, high)
        _finish(top, bottom, (low, high * 1.25))
        canvas.key(top, columns=min(len(designs), 5))
        top.set_title(title, pad=22)
    return figure


def _at(text: str, frequency: float | None) -> str:
    return text if frequency is None else f"{text} (at {frequency:.3g} rad/s)"


def _db(system: Plant | Sampled, w: Array) -> Array:
    size = np.abs(system.at(w))
    return np.asarray(20 * np.log10(np.maximum(size, 1e-300)))


def _warped(w: Array, dt: float) -> Array:
    return np.array([warp(float(x), dt) for x in w])


def _axis(loop: Plant | Sampled, found: Margins) -> Array:
    marks = (found.crossover, found.phase_crossover)
    low = lowest(loop, *marks)
    known = [m for m in marks if m and isfinite(m)]
    high = (
        NEAR_NYQUIST * pi / loop.dt if isinstance(loop, Sampled) else 100 * max(known, default=1.0)
    )
    return frequencies(loop, low, high)


def _right_edge(loop: Plant | Sampled, found: Margins, w: Array) -> float:
    return float(w[-1]) * (1.25 if isinstance(loop, Sampled) else 1.0)


def _mark_margins(top: Axes, bottom: Axes, loop: Plant | Sampled, found: Margins) -> None:
    top.axhline(0, **_GUIDE)
    wc, wpc = found.crossover, found.phase_crossover
    reference = -180.0
    if wc and isfinite(found.phase_margin_deg):
        at = float(phase_deg(loop, np.array([wc]))[0])
        reference = at - found.phase_margin_deg
        top.axvline(wc, **_GUIDE)
        bottom.axvline(wc, **_GUIDE)
        bottom.plot([wc, wc], [reference, at], **_MARK)
        _tag(bottom, wc, (reference + at) / 2, f"{found.phase_margin_deg:.1f}°", above=False)
    bottom.axhline(reference, **_GUIDE)
    if wpc and isfinite(wpc) and found.gain_margin < inf:
        top.axvline(wpc, **_GUIDE)
        bottom.axvline(wpc, **_GUIDE)
        top.plot([wpc, wpc], [-found.gain_margin_db, 0], **_MARK)
        over = max(0.0, -found.gain_margin_db)
        _tag(top, wpc, over, f"{found.gain_margin_db:.1f} dB", above=True)


def _tag(ax: Axes, x: float, y: float, text: str, *, above: bool) -> None:
    """Write a margin beside its mark, on the side where a falling loop leaves room."""
    offset, sides = ((0, 4), ("center", "bottom")) if above else ((-6, 0), ("right", "center"))
    ax.annotate(
        text, (x, y), xytext=offset, textcoords="offset points", ha=sides[0], va=sides[1],
        color=RED, weight="bold", fontsize=9, zorder=5,
    )  # fmt: skip


def _mark_nyquist(top: Axes, bottom: Axes, nyquist: float) -> None:
    for ax in (top, bottom):
        ax.axvline(nyquist, color=SOFT, linewidth=0.9, zorder=1)
    top.annotate(
        f"Nyquist {nyquist:.3g}", (nyquist, 1), xycoords=("data", "axes fraction"),
        xytext=(-3, -2), textcoords="offset points", ha="right", va="top",
        fontsize=8, color=SOFT, rotation=90,
    )  # fmt: skip


def _cross(top: Axes, bottom: Axes, measured: Measured, *, warped: bool) -> None:
    """Mark the crossover on one of the two scales."""
    wc = measured.margins.crossover
    top.axhline(0, **_GUIDE)
    bottom.axhline(-180, **_GUIDE)
    if not wc:
        return
    x = warp(wc, measured.dt) if warped else wc
    for ax in (top, bottom):
        ax.axvline(x, **_GUIDE)
    at = float(phase_deg(measured.loop, np.array([wc]))[0])
    bottom.plot([x, x], [at - measured.margins.phase_margin_deg, at], **_MARK)
    top.plot([x], [0.0], "o", color=RED, markersize=5, zorder=5)
    top.annotate(
        f"{'v' if warped else 'ω'} = {x:.4g}", (x, 0), xycoords=("data", "axes fraction"),
        xytext=(-4, 4), textcoords="offset points", ha="right",
        color=RED, weight="bold", fontsize=8.5,
    )  # fmt: skip


def _finish(top: Axes, bottom: Axes, limits: tuple[float, float]) -> None:
    top.set_xscale("log")
    top.set_xlim(*limits)
    top.set_ylabel("magnitude, dB")
    bottom.set_ylabel("phase, deg")
    bottom.set_xlabel("frequency, rad/s")
    low, high = bottom.get_ylim()
    bottom.yaxis.set_major_locator(MultipleLocator(45 if high - low <= 300 else 90))
    bottom.xaxis.set_major_formatter(lambda x, _: f"{x:g}")
    top.tick_params(which="both", bottom=False)
    bottom.tick_params(which="minor", length=2, color=FAINT)


def _name_lines(ax: Axes) -> None:
    ax.legend(loc="lower left", labelcolor="linecolor", handlelength=1.3)
