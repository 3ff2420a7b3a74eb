"""Designs side by side on one page: a table, and the figures that belong to it.

Returns ``{file name: content}``; whoever called writes the files.
"""

from collections.abc import Sequence

from matplotlib.figure import Figure

from zoh.analysis.curves import trace
from zoh.analysis.tabled.verify import Evidence, TableMeasured
from zoh.analysis.verify import Measured
from zoh.errors import ZohError
from zoh.report import figures as fig
from zoh.report.text import cell, design_table, horizon, slug

Files = dict[str, str | bytes]


def comparison(
    results: Sequence[Evidence],
    *,
    title: str = "Controllers side by side",
    refused: Sequence[tuple[str, ZohError]] = (),
) -> Files:
    """Return REPORT.md with its figures for designs that were measured and some refused.

    ``refused`` holds (name, what was raised), shown below the table with its numbers. Loops of
    tabled plants come without figures, and with what their margins rest on.
    """
    parts = [f"# {title}\n"]
    files: Files = {}
    if results:
        parts.append(design_table(results) + "\n")
    parts += [f"**{cell(d.name)}** misses: {'; '.join(d.misses)}.\n" for d in results if d.misses]
    if refused:
        parts.append("## Refused\n")
        parts += [f"- **{cell(name)}**: {error}." for name, error in refused]
        parts.append("")
    tabled = [d for d in results if isinstance(d, TableMeasured)]
    parts += [f"**{cell(d.name)}**: {note}.\n" for d in tabled for note in d.margins.warnings]
    drawable = [d for d in results if isinstance(d, Measured)]
    if drawable:
        pages, files = _figures(drawable)
        parts.append(pages)
    return {"REPORT.md": "\n".join(parts), **files}


def picture(name: str, caption: str) -> str:
    """Return a Markdown picture from the SVG, with its caption below."""
    return f"![{caption}]({name}.svg)\n\n*{caption}* ([PNG]({name}.png))\n"


def drawn(name: str, svg_and_png: tuple[str, bytes]) -> Files:
    """Return a rendered figure as its two files."""
    return {f"{name}.svg": svg_and_png[0], f"{name}.png": svg_and_png[1]}


def _figures(results: Sequence[Measured]) -> tuple[str, Files]:
    """Return the Markdown that shows the figures, and the figures."""
    text, files, taken = ["## Figures\n"], Files(), {"bode", "nyquist", "step", "effort"}

    def add(name: str, caption: str, figure: Figure) -> None:
        files.update(drawn(name, fig.render(figure)))
        text.append(picture(name, caption))

    add("bode", "Open loops", fig.compare(results, title="Open loops"))
    stable = [d for d in results if d.step is not None]
    if stable:
        end = horizon(d.step for d in stable)
        shown = [response(d, t_end=end) for d in stable]
        ref = stable[0].reference
        add("step", "Step responses", fig.steps(shown, reference=ref, title="Step responses"))
        short = [response(d, t_end=end / 3) for d in stable]
        add("effort", "Control effort", fig.efforts(short, title="Control effort"))
    add("nyquist", "Nyquist plots", fig.nyquist(results, title="Distance from -1"))
    for d in results:
        name = slug(d.name, taken)
        taken.add(name)
        text.append(f"### {cell(d.name)}\n")
        margins = fig.bode(d.loop, d.margins, title=d.name)
        add(f"bode-{name}", f"{cell(d.name)}: the open loop and its margins", margins)
        add(f"scales-{name}", f"{cell(d.name)}: over ω and over v", fig.both_scales(d))
        if d.step is not None:
            one = response(d, t_end=horizon([d.step]))
            figure = fig.step(one, reference=d.reference, title=d.name)
            add(f"step-{name}", f"{cell(d.name)}: at the samples and between them", figure)
    return "\n".join(text), files


def response(
    d: Measured,
    *,
    t_end: float,
    per_sample: int = 20,
    reference: float | None = None,
    name: str | None = None,
) -> fig.Response:
    """Return the step response of a measured loop, ready to draw.

    ``reference`` and ``name`` stand in for the design's own where given.
    """
    found = trace(
        d.plant,
        d.controller,
        compute_delay=d.compute_delay,
        reference=d.reference if reference is None else reference,
        t_end=t_end,
        per_sample=per_sample,
        feedforward=d.feedforward,
    )
    return fig.Response(name=d.name if name is None else name, law=d.law, trace=found)
