"""A sweep as figures: a figure of every loop of a grid as a map, of a sample's loops as bands."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from zoh.report import canvas
from zoh.report.canvas import BLUE, FAINT, INK, RED

Array = npt.NDArray[np.float64]

_BINS, _LEAST = 24, 20  # bands have so many places at most, and so many loops at each at least
_WIDE, _NARROW = (5.0, 95.0), (25.0, 75.0)  # % of the loops at a place
_COLOURED = (2.0, 98.0)  # % of the values: one odd loop does not take all the colours
_LOG = 20.0  # an axis of numbers above 0 that spans more than this factor is logarithmic


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """Values and what they are: one for each row, column or loop; NaN where there is none."""

    values: Array
    label: str

    @property
    def scale(self) -> str:
        """Return "log" where the values are above 0 and span orders of magnitude.

        >>> Axis(values=np.array([1.0, 100.0]), label="dt, s").scale
        'log'
        """
        low, high = float(np.min(self.values)), float(np.max(self.values))
        return "log" if low > 0 and high > _LOG * low else "linear"


def value_map(
    x: Axis, y: Axis, value: Axis, *, bound: float | None = None, title: str | None = None
) -> Figure:
    """Draw a value over a grid, shape (len(x), len(y)); ``bound`` is a contour, NaN is no loop."""
    with canvas.style():
        figure = canvas.sheet(6.2, 4.4)
        ax = figure.subplots()
        ax.set_facecolor(FAINT)
        ax.grid(visible=False)
        shown = np.ma.masked_invalid(value.values.T)
        ends, beyond = _colours(shown.compressed())
        mesh = ax.pcolormesh(
            x.values, y.values, shown, shading="nearest", cmap="viridis", vmin=ends[0], vmax=ends[1]
        )
        figure.colorbar(mesh, ax=ax, label=value.label, extend=beyond)
        handles: list[Patch | Line2D] = []
        if shown.mask.any():
            handles.append(Patch(color=FAINT, label="no stable loop"))
        if bound is not None and shown.count() and shown.min() < bound < shown.max():
            ax.contour(x.values, y.values, shown, [bound], colors=[RED], linewidths=1.4)
            handles.append(Line2D([], [], color=RED, label=f"bound, {bound:g}"))
        if handles:
            figure.legend(handles=handles, loc="outside lower left", ncols=2)
        _label(ax, x, y)
        ax.set_title(title or value.label)
    return figure


def bands(x: Axis, value: Axis, *, bound: float | None = None, title: str | None = None) -> Figure:
    """Draw how a value is spread along x: the median, and what 50 and 90 % of the loops have.

    x, value  one entry for each loop; loops are put together in places of equally many
    """
    with canvas.style():
        figure = canvas.sheet(6.0, 3.8)
        ax = figure.subplots()
        at, quantiles = _spread(x.values, value.values)
        for (low, high), alpha in ((_WIDE, 0.18), (_NARROW, 0.35)):
            ends = quantiles[low], quantiles[high]
            label = f"{high - low:g} % of the loops"
            ax.fill_between(at, *ends, color=BLUE, alpha=alpha, linewidth=0, label=label)
        ax.plot(at, quantiles[50.0], color=BLUE, label="median")
        if bound is not None:
            ax.axhline(bound, color=RED, linewidth=1.2, label=f"bound, {bound:g}")
        _label(ax, x, value)
        ax.legend(loc="best", labelcolor=INK)
        ax.set_title(title or value.label)
    return figure


def line(x: Axis, value: Axis, *, bound: float | None = None, title: str | None = None) -> Figure:
    """Draw a value along one axis, a dot for each loop; where there is no loop the line ends."""
    with canvas.style():
        figure = canvas.sheet(6.0, 3.8)
        ax = figure.subplots()
        ax.plot(x.values, value.values, "o-", color=BLUE, markersize=3)
        for none in x.values[np.isnan(value.values)]:
            ax.axvline(none, color=FAINT, linewidth=3, zorder=0)
        if bound is not None:
            ax.axhline(bound, color=RED, linewidth=1.2, label=f"bound, {bound:g}")
            ax.legend(loc="best", labelcolor=INK)
        _label(ax, x, value)
        ax.set_title(title or value.label)
    return figure


def _colours(values: Array) -> tuple[tuple[float | None, float | None], str]:
    """Return the ends of the colours, within which nearly all values are, and what is beyond.

    >>> _colours(np.array([1.0] * 99 + [50.0]))[1]
    'max'
    """
    if not values.size:
        return (None, None), "neither"
    low, high = (float(np.percentile(values, q)) for q in _COLOURED)
    beyond = bool(values.min() < low), bool(values.max() > high)
    names = {(False, False): "neither", (True, False): "min", (False, True): "max"}
    return (low, high), names.get(beyond, "both")


def _spread(x: Array, value: Array) -> tuple[Array, dict[float, Array]]:
    """Return the middle of each place, and the quantiles of the values there by their percent."""
    there = np.flatnonzero(np.isfinite(value))
    order = there[np.argsort(x[there], kind="stable")]
    places = np.array_split(order, max(1, min(_BINS, len(order) // _LEAST)))
    places = [place for place in places if len(place)]
    at = np.array([np.median(x[place]) for place in places])
    levels = (*_WIDE, *_NARROW, 50.0)
    return at, {q: np.array([np.percentile(value[p], q) for p in places]) for q in levels}


def _label(ax: Axes, x: Axis, y: Axis) -> None:
    ax.set_xscale(x.scale)
    if np.isfinite(y.values).all():
        ax.set_yscale(y.scale)
    ax.set_xlabel(x.label)
    ax.set_ylabel(y.label)
