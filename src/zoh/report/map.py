"""The map of a law as a figure: what it can give, what meets everything, what limits it."""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from zoh.choice.map import Array, Map
from zoh.report import canvas
from zoh.report.canvas import FAINT, INK, SOFT

_SERIES = (canvas.RED, canvas.BLUE, canvas.ORANGE, canvas.PINK, canvas.SKY, SOFT)
_GOOD = "#bfe3d3"
_HEIGHT = "pm_deg"  # the requirement that is a height of the map


def law_figure(
    found: Map, *, chosen: tuple[float, float] | None = None, title: str | None = None
) -> Figure:
    """Draw the map; ``chosen`` is a crossover in rad/s and its margin in deg, marked by a dot."""
    with canvas.style():
        figure = canvas.sheet(6.4, 4.4)
        ax = figure.subplots()
        ax.set_xscale("log")
        ax.set_xlim(float(found.wc[0]), float(found.wc[-1]))
        ax.set_ylim(0, 180)
        handles: list[Patch | Line2D] = [Patch(color=FAINT, label=f"a {found.law} can give")]
        for part in _runs(found):
            low, high = found.pm_deg[0, part], found.pm_deg[-1, part]
            ax.fill_between(found.wc[part], low, high, color=FAINT, linewidth=0)
            if found.met[:, part].any():
                good = np.clip(np.nan_to_num(found.slack[:, part], nan=-1.0, neginf=-1.0), -1, None)
                ax.contourf(*_places(found, part), good, [0, 1e9], colors=[_GOOD])
        if found.met.any():
            handles.append(Patch(color=_GOOD, label="meets everything"))
        handles += _bounds(ax, found)
        if chosen is not None:
            ax.plot(*chosen, "o", color=INK, markersize=6, zorder=5)
            handles.append(Line2D([], [], color=INK, marker="o", linestyle="", label="chosen"))
        ax.set_xlabel("crossover wc, rad/s")
        ax.set_ylabel("phase margin, deg")
        ax.set_yticks(range(0, 181, 30))
        ax.legend(handles=handles, loc="upper right", fontsize=8)
        ax.set_title(title or f"What a {found.law} can do")
    return figure


def _bounds(ax: Axes, found: Map) -> list[Line2D]:
    """Draw where each requirement is just met; return what the legend says of it."""
    handles = []
    for i, (name, values) in enumerate(found.values.items()):
        bound, colour = getattr(found.requirements, name), _SERIES[i % len(_SERIES)]
        if name == _HEIGHT:
            ax.axhline(bound, color=colour, linewidth=1.2)
        elif not np.nanmin(values, initial=np.inf) < bound < np.nanmax(values, initial=-np.inf):
            continue
        else:
            for part in _runs(found):
                shown = np.ma.masked_invalid(values[:, part])
                ax.contour(*_places(found, part), shown, [bound], colors=[colour], linewidths=1.2)
        handles.append(Line2D([], [], color=colour, label=f"{name} = {bound:g}"))
    return handles


def _places(found: Map, part: slice) -> tuple[Array, Array]:
    """Return the crossovers and margins of a run of columns, each of the map's shape."""
    pm_deg = found.pm_deg[:, part]
    return np.broadcast_to(found.wc[part], pm_deg.shape), pm_deg


def _runs(found: Map) -> Iterator[slice]:
    """Yield runs of two or more neighbouring crossovers at which the law can give something."""
    able = np.isfinite(found.pm_deg[0])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], able, [False]]).astype(int)))
    for begin, end in edges.reshape(-1, 2).tolist():
        if end - begin > 1:
            yield slice(begin, end)
