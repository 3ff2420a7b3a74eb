"""The step read as sums: every line a row on states, inputs and rounding errors, limits open."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from zoh.firmware.lines import ZERO, Line, Program

Array = npt.NDArray[np.float64]
READ = "y read"  # the error of a measurement that is brought to whole steps


@dataclass(slots=True)
class Rows:
    """Every line of a step as a row on (states, r, y, 1, errors); limits are taken as open."""

    program: Program
    rows: dict[str, Array]
    sites: list[tuple[str, float, str]]  # (name, the column's mean, the line that errs)

    @classmethod
    def of(cls, program: Program) -> "Rows":
        """Return the rows of a program's step."""
        names = [s.name for s in program.states] + ["r", "y", "1"]
        sites = sites_of(program)
        eye = np.eye(len(names) + len(sites))
        rows = {name: eye[i] for i, name in enumerate(names)}
        one = rows["1"]
        rows |= {"ff": 0 * one, ZERO: 0 * one}
        for c in program.coefficients:
            rows[c.name] = float(c.value) * one
        made = cls(program=program, rows=rows, sites=[(k, m, n) for k, m, n in sites])
        errors = {key: eye[len(names) + i] for i, (key, _, _) in enumerate(sites)}
        rows["y"] = rows["y"] + errors.get(READ, 0.0)
        for line in program.step.lines:
            rows[line.name] = made._row(line, errors)
        return made

    def _row(self, line: Line, errors: Mapping[str, Array]) -> Array:
        a = self.rows[line.args[0]]
        if line.op in ("asr", "low"):
            error = errors[key_of(line)]
            one = 2.0**line.shift
            return a / one - error if line.op == "asr" else one * error
        return self._exact(line, a) + errors.get(line.name, 0.0)

    def _exact(self, line: Line, a: Array) -> Array:
        if line.op in ("atmost", "atleast"):
            return a
        if line.op == "neg":
            return -a
        if line.op == "unless":
            return self.rows[line.args[3]]
        b = self.rows[line.args[1]]
        if line.op == "mul":
            return float(self.program.value(line.args[0])) * b
        return a + b if line.op == "add" else a - b


def key_of(line: Line) -> str:
    """Return the name of what a floor leaves, the same for asr and low."""
    return f"{line.args[0]} mod 2^{line.shift}"


def sites_of(program: Program) -> list[tuple[str, float, str]]:
    """Return (key, mean, line) of every error: of floors in [0, 1), of floats around 0."""
    if program.whole:
        floors = {key_of(x): x.name for x in program.step.lines if x.op == "asr"}
        return [(READ, 0.0, "y"), *((key, 0.5, name) for key, name in floors.items())]
    guards = {x.name for x in program.step.lines if x.name.startswith("guard")}
    rounding = [x.name for x in program.step.lines if x.op in ("add", "sub", "mul")]
    return [(name, 0.0, name) for name in rounding if name not in guards]
