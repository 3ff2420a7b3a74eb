"""One look for every figure, and figures as bytes that never change.

The Agg canvas only, no pyplot and no state of the user's: the same loop gives the same bytes.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO, StringIO
from typing import Any

try:
    import matplotlib
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
except ModuleNotFoundError as absent:
    way_out = 'figures need matplotlib: pip install "zoh[plot]"'
    raise ModuleNotFoundError(way_out, name=absent.name) from absent

INK, SOFT, FAINT = "#1a1a1a", "#6b6b6b", "#d9d9d9"

# After Okabe and Ito, whose colours colour-blind eyes tell apart; two darker, to be read on white.
BLUE, RED, GREEN, ORANGE, PINK, SKY = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#C98A00",
    "#A8508A",
    "#3A9BD0",
)
_BY_LAW = {
    "none": "#555555",
    "p": ORANGE,
    "pd": SKY,
    "lag": PINK,
    "lead": RED,
    "pi": BLUE,
    "pid": GREEN,
}
_SERIES = (BLUE, RED, GREEN, ORANGE, PINK, SKY, "#555555")

_STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Arial", "Helvetica", "sans-serif"],
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 8.0,
    "axes.labelsize": 9.0,
    "axes.labelcolor": INK,
    "axes.edgecolor": SOFT,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#ececec",
    "grid.linewidth": 0.7,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "lines.linewidth": 1.7,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "figure.facecolor": "white",
    "savefig.dpi": 200.0,
    "svg.fonttype": "none",
    "svg.hashsalt": "zoh",
    "axes.unicode_minus": True,
}


@contextmanager
def style() -> Iterator[None]:
    """Draw inside this: matplotlib's defaults and ours, nothing of the user's."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_STYLE)
        yield


def sheet(width: float = 6.0, height: float = 4.2) -> Figure:
    """Return an empty figure of this size in inches, 100 px to the inch on a page."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def render(figure: Figure) -> tuple[str, bytes]:
    """Return (SVG text, PNG bytes): the same figure gives the same bytes, on any day.

    >>> with style():
    ...     figure = sheet()
    >>> render(figure) == render(figure)
    True
    """
    with style():
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # laid out once: twice is slow, and not the same twice
        png = BytesIO()
        figure.savefig(png, format="png", metadata={"Software": None})
        svg = StringIO()
        figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": None})
    return svg.getvalue(), png.getvalue()


def colours(laws: list[str]) -> list[str]:
    """Return one colour per law; a law has its own, and where two share it, a series is used.

    >>> colours(["lead", "pi"]) == [RED, BLUE]
    True
    """
    if len(set(laws)) == len(laws) and all(law in _BY_LAW for law in laws):
        return [_BY_LAW[law] for law in laws]
    return [_SERIES[i % len(_SERIES)] for i in range(len(laws))]


def key(ax: Axes, columns: int) -> None:
    """Write the names of the lines above the axis, each in its line's colour."""
    ax.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=columns,
        labelcolor="linecolor",
        handlelength=1.1,
        handletextpad=0.5,
        columnspacing=1.4,
        borderaxespad=0.2,
        borderpad=0.2,
    )
