"""The figures of ``zoh sweep --figures``: a map, lines or bands of what matters most."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
from matplotlib.figure import Figure

from zoh.batch.bounds import RULES
from zoh.batch.figures import BY_NAME
from zoh.batch.result import Sweep
from zoh.batch.sources import Source
from zoh.batch.space import Grid
from zoh.batch.units import unit_and_name
from zoh.report.document import drawn
from zoh.report.figures import render
from zoh.report.sweep import Axis, bands, line, value_map
from zoh.report.text import slug

SHOWN = (
    "ms",
    "phase_margin_deg",
    "delay_margin",
    "between.overshoot_pct",
    "settling_time",
    "peak_effort",
)


def figures(sweeps: Iterable[tuple[str, Sweep]]) -> dict[str, str | bytes]:
    """Return {file name: contents}, an SVG and a PNG of each figure of each controller's sweep."""
    out: dict[str, str | bytes] = {}
    for name, sweep in sweeps:
        for what, figure in drawn_of(sweep, name):
            file = slug(f"{name} {what}", [taken.rpartition(".")[0] for taken in out])
            out |= drawn(file, render(figure))
    return out


def drawn_of(sweep: Sweep, name: str) -> Iterator[tuple[str, Figure]]:
    """Yield (what it shows, figure) of each figure that some loop of the sweep has."""
    axes, bound = _axes(sweep), _bounds(sweep)
    for shown in SHOWN:
        values = sweep.results[shown].astype(np.float64, copy=False)
        if not np.isfinite(values).any():
            continue
        value = Axis(
            values=np.where(np.isfinite(values), values, np.nan),
            label=_label(shown, sweep.job.plant),
        )
        title = f"{name}: {BY_NAME[shown].long_name}"
        if isinstance(sweep.space, Grid) and len(axes) == 2:
            grid = Axis(
                values=value.values.reshape([len(a.values) for a in axes]), label=value.label
            )
            yield shown, value_map(axes[0], axes[1], grid, bound=bound.get(shown), title=title)
        elif isinstance(sweep.space, Grid) and len(axes) == 1:
            yield shown, line(axes[0], value, bound=bound.get(shown), title=title)
        else:
            for key, column in sweep.columns.items():
                x = Axis(values=column, label=_label(key, sweep.job.plant))
                over = f"{title} over {key}"
                yield f"{shown} over {key}", bands(x, value, bound=bound.get(shown), title=over)


def _axes(sweep: Sweep) -> list[Axis]:
    """Return the axes of a grid that have more than one value; none of what is no grid."""
    if not isinstance(sweep.space, Grid):
        return []
    values = {key: np.asarray(axis) for key, axis in sweep.space.axes.items()}
    return [
        Axis(values=v, label=_label(key, sweep.job.plant))
        for key, v in values.items()
        if len(v) > 1
    ]


def _bounds(sweep: Sweep) -> Mapping[str, float]:
    """Return what is asked of a figure, where its requirement is in the figure's own unit."""
    asked = {rule.column: getattr(sweep.requirements, name) for name, rule in RULES.items()}
    return {column: bound for column, bound in asked.items() if bound is not None}


def _label(name: str, plant: Source) -> str:
    unit, long_name = unit_and_name(name, plant)
    return long_name if unit == "1" else f"{long_name}, {unit}"
