"""The test that a controller carries: samples and the outputs that the model gave, replayed.

It needs nothing but the board: 0 says that compiler and processor compute what was verified.
"""

from collections.abc import Sequence

import numpy as np

from zoh.firmware.model import Model
from zoh.firmware.plan import Plan
from zoh.firmware.vectors import Sample, hostile, ordinary
from zoh.firmware.words import float_literal, result_type

_ORDINARY, _HOSTILE = 16, 8


def selftest(plan: Plan) -> str:
    """Return the C of NAME_selftest: steps, then a hand-over by track and one step more."""
    samples, outputs, faults = _replayed(plan)
    kind, n, name = result_type(plan.number), len(samples), plan.name
    tables = "".join(
        f"    static const {kind} {label}[{n}] = {{\n{_table(plan, column)}    }};\n"
        for label, column in zip(
            ("r", "y", "ff", "u"), [*zip(*samples, strict=True), outputs], strict=True
        )
    )
    check_faults = (
        "" if plan.program.whole else
        f"    if ((first == 0) && (s.faults != {faults}U)) {{\n        first = {n + 1};\n    }}\n"
    )  # fmt: skip
    return (
        f"int32_t {name}_selftest(void)\n{{\n{tables}"
        f"    {name}_state s;\n    int32_t first = 0;\n    int32_t k;\n"
        f"    {name}_init(&s);\n"
        f"    for (k = 0; k < {n}; k++) {{\n"
        f"        {kind} got;\n"
        f"        if (k == {n - 1}) {{\n"
        f"            {name}_track(&s, r[k], y[k], ff[k], u[0]);\n"
        "        }\n"
        f"        got = {name}_step(&s, r[k], y[k], ff[k]);\n"
        "        if ((first == 0) && !((got >= u[k]) && (got <= u[k]))) {\n"
        "            first = k + 1;\n"
        "        }\n"
        "    }\n"
        f"{check_faults}    return first;\n}}\n"
    )


def _replayed(plan: Plan) -> tuple[list[Sample], list[float], int]:
    """Return the samples, what the model answers and the faults it counts."""
    extreme = [s for s in hostile(plan, 512, start=7) if all(abs(x) < 1e300 for x in s)]
    samples = ordinary(plan, _ORDINARY) + extreme[:: len(extreme) // _HOSTILE][:_HOSTILE]
    if plan.number == "f32":
        samples.append((3e38, -3e38, 0.0))
    elif plan.number == "f64":
        samples.append((1e308, -1e308, 0.0))
    samples.append(samples[3])
    model = Model(plan)
    outputs: list[float] = []
    for k, sample in enumerate(samples):
        if k == len(samples) - 1:
            model.track(*sample, outputs[0])
        outputs.append(model.step(*sample))
    return samples, outputs, model.faults


def _table(plan: Plan, column: Sequence[float]) -> str:
    words = [
        str(int(x)) if plan.program.whole else float_literal(_of(plan, x), plan.number)
        for x in column
    ]
    rows = [", ".join(words[i : i + 6]) for i in range(0, len(words), 6)]
    return "".join(
        f"        {row}{',' if i < len(rows) - 1 else ''}\n" for i, row in enumerate(rows)
    )


def _of(plan: Plan, x: float) -> float:
    return float(np.float32(x)) if plan.number == "f32" else float(x)
