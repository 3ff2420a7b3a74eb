"""The page that goes with exported firmware: what it is, how it is wired, what was proved."""

from collections.abc import Sequence

from zoh.analysis.results import Margins
from zoh.analysis.tabled.results import TableMargins
from zoh.firmware.book import IO_BITS
from zoh.firmware.equality import Equality
from zoh.firmware.plan import Plan
from zoh.firmware.words import result_type

_WIRING = """\
## Wiring a controller into a timer's interrupt

```c
#include "{name}.h"

static {name}_state controller;

void start(void)
{{
    if ({name}_selftest() != 0) {{
        for (;;) {{ }} /* this board does not compute what was verified */
    }}
    {name}_init(&controller);
}}

void every_dt(void) /* the timer's interrupt, every {dt:.9g} s */
{{
    output({name}_step(&controller, reference(), measurement(), {zero}));
}}
```

Measure, step and put the output out in this order: the design counts {delay:.9g} s from measuring
to putting out, and the examples keep to that. While a person or another program sets u, call
`{name}_track(&controller, r, y, ff, u)` in the place of the step, every sample, and the step that
follows takes over without a jump, unless something else is said of track above.
`{name}_reset(&controller, u)` sets it to rest at u. One state per loop; nothing else is kept.

`*_arduino.ino` and `*_stm32.c` do the same on a board, what must be fitted to it marked YOURS; they
are no part of the controller. Build it with any C99 or C++17 compiler and any optimisation but
-ffast-math and its parts, and call the self-test: it tells where a compiler computes otherwise.
"""


def readme(plans: Sequence[Plan], proofs: Sequence[Equality | None]) -> str:
    """Return README.md for these controllers."""
    first = plans[0]
    wiring = _WIRING.format(
        name=first.name, dt=first.dt, delay=first.design.compute_delay,
        zero="0" if first.format.whole else "0.0f" if first.number == "f32" else "0.0",
    )  # fmt: skip
    blocks = [_controller(p, e) for p, e in zip(plans, proofs, strict=True)]
    return "\n".join(["# Controllers, as verified\n", *blocks, wiring])


def _controller(plan: Plan, proof: Equality | None) -> str:
    lines = [
        f"## {plan.name}\n",
        f"`{plan.name}.h`, `{plan.name}.c`: {plan.design.law}, {plan.number} "
        f"({result_type(plan.number)}), {plan.realisation}, every {plan.dt:.9g} s.\n",
        *_units(plan),
        "| | phase margin, deg | crossover, rad/s | gain margin, dB | Ms |",
        "| --- | --- | --- | --- | --- |",
        _margins("designed", plan.design.margins),
        _margins("as built", plan.quantised.margins),
        "",
        *(f"- {sentence}" for sentence in plan.said),
        "",
        *_proof(proof),
    ]
    return "\n".join(lines)


def _units(plan: Plan) -> list[str]:
    if not plan.format.whole:
        return ["Reference, measurement and output are in the units of the design.\n"]
    half = 1 << IO_BITS[plan.number] - 1
    y, u = float(plan.format.y_unit), float(plan.format.u_unit)
    return [
        f"Reference and measurement: {half} is {half * y:.9g} of what the controller compares, a "
        f"step {y:.9g}. Output and feed-forward: {half} is {half * u:.9g}, a step {u:.9g}.\n"
    ]


def _margins(label: str, m: Margins | TableMargins) -> str:
    wc = "-" if m.crossover is None else f"{m.crossover:.7g}"
    return f"| {label} | {m.phase_margin_deg:.7g} | {wc} | {m.gain_margin_db:.5g} | {m.ms:.6g} |"


def _proof(proof: Equality | None) -> list[str]:
    if proof is None:
        return ["Equality with the model: not proved here; `zoh export --prove` does.\n"]
    looped = f", {proof.loop_samples} in the loop with the plant" if proof.loop_samples else ""
    rows = [
        f"| {b.target} | -{b.level} | {b.instructions[0]} | {b.instructions[1]:.1f} "
        f"| {b.instructions[2]} | {b.code_bytes} | {b.stack_bytes} |"
        for b in proof.builds
        if b.instructions is not None
    ]
    return [
        f"Equal to the model bit for bit in {len(proof.builds)} builds, on the machine that proved "
        f"it and on emulated cores: {proof.samples} samples with all states{looped}. "
        f"{proof.state_bytes} bytes of state. "
        "Instructions are those executed in a step; code is with constants and arithmetic in "
        "software, without the self-test; bytes.\n",
        "| core | level | least | mean | most | code | stack |",
        "| --- | --- | --- | --- | --- | --- | --- |",
        *rows,
        "",
    ]
