"""A design's firmware is the design: proved by running it, to the last bit.

    Python model == C on this machine == C on every core, at every level of optimisation

in all outputs, in all bytes of the state after each trial, and in the whole trajectory of the loop
with the plant. A proof by trial is as good as its samples: ``vectors`` and ``trials`` say which.
"""

from collections.abc import Sequence

from zoh import checks
from zoh.analysis.tabled.verify import TableVerified
from zoh.errors import SpecError, Unequal
from zoh.firmware import comparison, toolchain
from zoh.firmware.asked import Design
from zoh.firmware.c import emit
from zoh.firmware.closed_loop import Loop
from zoh.firmware.cores import NAMES, named
from zoh.firmware.equality import Equality
from zoh.firmware.export import planned
from zoh.firmware.model import Model
from zoh.firmware.plan import Plan
from zoh.firmware.trials import trials
from zoh.firmware.vectors import hostile

LEAST_SAMPLES, LOOP_SAMPLES = 20_000, 1_000


def prove(
    design: Design | Plan, *, number: str | None = None, targets: Sequence[str] = NAMES,
    levels: Sequence[str] = toolchain.LEVELS, samples: int = LEAST_SAMPLES,
    progress: comparison.Progress | None = None,
) -> Equality:  # fmt: skip
    """Return the proof that a design's firmware is the design, with what it costs on each core.

    design    a verified design, or its plan, which has limits and ranges, too
    number    f32, f64, q31, q15 or auto; f32 if left out; a plan has one already
    targets   cores, by name; levels of optimisation, "O2" and "Os"
    samples   hostile ones, 20 000 or more; edges, chance and hand-overs come on top
    progress  called after each build with how many are done, how many there are and which it was

    Raises Unequal where a single bit differs, SpecError for a bad request or a missing package.
    """
    made = planned(design, number)
    cores = named(targets)
    if not levels or any(level not in toolchain.LEVELS for level in levels):
        raise SpecError("levels", "must be of O2, Os", levels, 'such as ["O2"]')
    checks.whole("samples", samples, LEAST_SAMPLES, "leave it out")
    found = comparison.compared(
        comparison.Subject(
            name=made.name, number=made.number, sources=emit(made),
            begin=lambda: Model(made), sha256=made.sha256,
        ),
        trials(made.number, hostile(made, samples)),
        cores=cores, levels=levels, loop=loop_of(made), progress=progress,
    )  # fmt: skip
    if not found.holds:
        raise Unequal(found.differences, found)
    return found


def loop_of(made: Plan) -> Loop | None:
    """Return the loop of a plan, with the reference of the design or a quarter of y's range.

    None for a design on a table, which shows no motion.
    """
    design = made.design
    if isinstance(design, TableVerified):
        return None
    reference = design.reference
    if made.format.whole:
        quarter = float(made.format.most * made.format.y_unit) / 4
        reference = min(quarter, max(-quarter, reference))
    return Loop(plant=design.sampled, format=made.format, reference=reference, samples=LOOP_SAMPLES)
