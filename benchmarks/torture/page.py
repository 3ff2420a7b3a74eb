"""docs/torture.md: what was asked, who was asked, what came out."""

import platform
from collections.abc import Sequence

import numpy as np
from benchmarks.torture import table
from benchmarks.torture.figures import Figure
from benchmarks.torture.holds import Row
from benchmarks.torture.loops import Spec
from benchmarks.torture.table import Tally

_HEAD = """# Who gets which loop wrong

`python -m benchmarks.torture --write docs/torture.md` wrote this page ({versions}).

{count} open loops, drawn from committed seeds or named after the case on which a released tool
was seen to be wrong. The truth is exact: polynomials with whole-number coefficients, their roots
isolated by Descartes' rule of signs, so that a missing crossing is ruled out by proof; a second
look evaluates each loop straight from its formula in 160 digits. It shares no line with zoh.

## How it is counted

- A loop given as z-coefficients is the loop of exactly these floats. A loop given as parameters
  (plant, sample time, dead time, gains) is that of exactly these parameters, and each tool makes
  its own z-coefficients or does without.
- `PM > 0.1 deg`, `GM > 1 %`, `Ms > 1 %`: loops where that figure is off by more. `missed` and
  `invented`: loops with a crossing too few or too many (1 % apart is the same crossing). `stable`:
  the verdict on the closed loop. `any`: loops with any of these wrong.
- The generous columns accept a gain margin that counts z = 1 and z = -1 and one that does not, and
  overlook crossings below 1e-3 of the highest gain crossover. Ms is not asked of a continuous loop
  that comes nearest to -1 at infinite frequency.
- The `1e-9` columns and `any, strict` ask for PM within 1e-9 deg and for GM, Ms and the place
  of each crossing within 1e-9, and count z = 1 and z = -1 wherever L is negative real there; Mt,
  disk and delay margins are asked where a tool gives them.
- `tried` leaves out loops that a tool has no words for (dead time); nothing there is held against
  it. An exception is.
- In {undecided} loops the last bit of the input decides whether some crossing exists (|L(1)| = 1 to
  rounding, a pole at z = 1 that rounding has moved) or whether the closed loop is stable. That
  crossing, margin or verdict is counted for nobody; the rest of the loop is.

The ordinary regime is the row `robot PID, 0.03-0.3 s`. {small} loops are sampled at 1 ms or faster
and given as z-coefficients, which is hard for everybody; totals depend on that mix, so read them by
class. python-control is a general library; that SciPy has margins at all is our own hand-written
grid of 2000 points, not SciPy's. Margins of several crossings: the gain nearest 1 in log, the phase
smallest in magnitude, as python-control and zoh both take them; Octave has another rule, and any
true one is right there. Its `margin` gives one crossing of each kind, so none is missed or
invented, and Ms is asked of it where it finds the loop stable.

## Margins
"""

_HOLDS = """
## The hold

The largest relative error of any z-coefficient against the exact one. The peers are asked only
without dead time, which they do not know; their coefficients at both ends agree because
python-control calls SciPy.

"""

_FIGURES = """
## Three more figures of the arm

The matched transform at 0.1 s and its velocity gain (an integrator is no obstacle), the disk
margin of a gain of 3 at 0.1 s (no grid of the caller's has a say in it), and the highest point of
its step at 1 s, which lies between two samples.

"""


def text(
    found: Sequence[Tally], rows: Sequence[Row], figures: Sequence[Figure],
    specs: Sequence[Spec], truths: Sequence[Spec], wrong: Sequence[tuple[str, list[str], str]],
) -> str:  # fmt: skip
    """Return the page."""
    versions = f"Python {platform.python_version()}, NumPy {np.__version__}"
    small = sum(spec["form"] == "z" and spec["dt"] <= 1e-3 for spec in specs)
    undecided = sum(bool(truth["doubt"]) for truth in truths)
    head = _HEAD.format(versions=versions, count=len(specs), undecided=undecided, small=small)
    margins, hold = table.markdown(found), table.hold_markdown(rows)
    return f"{head}\n{margins}{_failures(wrong)}{_HOLDS}{hold}{_FIGURES}{_named(figures)}"


def _named(figures: Sequence[Figure]) -> str:
    lines = ["| figure | true | tool | said |", "| --- | --: | --- | --: |"]
    for figure in figures:
        for tool, value in figure.said.items():
            lines.append(f"| {figure.name} | {figure.true:.8g} | {tool} | {value:.8g} |")
    return "\n".join(lines) + "\n"


def _failures(wrong: Sequence[tuple[str, list[str], str]]) -> str:
    if not wrong:
        return ""
    lines = [f"- {name}: {', '.join(faults)} {error}".rstrip() for name, faults, error in wrong]
    return "\n## What zoh has wrong, by the strict measure\n\n" + "\n".join(lines) + "\n"
