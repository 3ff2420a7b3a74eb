"""The firmware in Python: the same lines, each operation rounded as the processor rounds it.

NumPy's float32 scalars and Python's floats round every operation once, to nearest even, as IEEE 754
asks; Python's whole numbers never overflow, and ``ranges`` proves that the C's do not either.
"""

from collections.abc import Callable, Mapping
from functools import partial
from math import isfinite
from operator import add, index, mul, neg, sub
from struct import pack
from typing import Any, SupportsIndex

import numpy as np

from zoh.errors import SpecError
from zoh.firmware.lines import ZERO, Line, Program, Routine
from zoh.firmware.plan import Plan

Value = Any  # np.float32, float or int: one kind in one model

_CODES = {"f32": ("f", "I"), "f64": ("d", "Q"), "q31": ("q", ""), "q15": ("i", "")}
_FAULTS = {"f32": 2**32 - 1, "f64": 2**64 - 1}


def _at_most(a: Value, b: Value) -> Value:
    return b if a > b else a


def _at_least(a: Value, b: Value) -> Value:
    return b if a < b else a


def _unless_product(a: Value, b: Value, kept: Value, moved: Value) -> Value:
    return kept if a * b > 0 else moved


def _unless_sign(a: int, b: int, kept: int, moved: int) -> int:
    return kept if (a > 0 and b > 0) or (a < 0 and b < 0) else moved


def _shifted(k: int, a: int) -> int:
    return a >> k


def _lowest(k: int, a: int) -> int:
    return a & ((1 << k) - 1)


_OPS: Mapping[str, Callable[..., Value]] = {
    "add": add, "sub": sub, "mul": mul, "neg": neg, "atmost": _at_most, "atleast": _at_least,
}  # fmt: skip


class Model:
    """A controller that runs as its C does; ``state`` has each state's value by name.

    ``step`` and ``track`` take numbers of the plan's format: floats, or whole numbers of 16 or 32
    bits for q15 and q31. ``faults`` counts the samples that were not finite, and so were not used.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._program: Program = plan.program
        kind: Callable[[Any], Value] = {"f32": np.float32, "f64": float}.get(plan.number, int)
        self._number: Callable[[Any], Value] = self._whole_number if self._program.whole else kind
        zero = kind(0)
        self._held = {c.name: kind(c.value) for c in self._program.coefficients}
        self._held[ZERO] = zero
        self._compiled = {r.name: [self._compiled_line(x) for x in r.lines] for r in self._routines}
        self.state: dict[str, Value] = {s.name: zero for s in self._program.states}
        self.faults = 0
        self.reset(0)

    @property
    def _routines(self) -> tuple[Routine, ...]:
        return self._program.routines

    def reset(self, u0: float) -> None:
        """Set the states to rest at the output u0, with r = y = 0."""
        self._run(self._program.reset, (u0,))

    def step(self, r: float, y: float, ff: float = 0) -> Value:
        """Return the output after one sample."""
        return self._run(self._program.step, (r, y, ff))

    def track(self, r: float, y: float, ff: float, u_manual: float) -> None:
        """Follow an output that somebody else sets: the same r, y and ff give it next."""
        self._run(self._program.track, (r, y, ff, u_manual))

    def state_bytes(self) -> bytes:
        """Return the C struct's bytes, little endian; it has no padding."""
        code, faults = _CODES[self.plan.number]
        values = [self.state[s.name] for s in self._program.states]
        tail = [self.faults] if faults else []
        return pack("<" + code * len(values) + faults, *values, *tail)

    def _whole_number(self, value: SupportsIndex) -> int:
        """Return a number of the format; raise SpecError for what is none."""
        number, form = index(value), self.plan.format
        if not form.least <= number <= form.most:
            bound = f"must be within {form.least} and {form.most}, the numbers of {form.number}"
            raise SpecError("r, y, ff and u", bound, number, "limit it before it is given")
        return number

    def _run(self, routine: Routine, inputs: tuple[float, ...]) -> Value:
        values = {**self._held, **self.state}
        with np.errstate(all="ignore"):
            for name, given in zip(routine.inputs, inputs, strict=True):
                values[name] = self._number(given)
            for name, run, args in self._compiled[routine.name]:
                values[name] = run(*[values[a] for a in args])
            if routine.guard is not None and not isfinite(values[routine.guard]):
                self.faults = min(self.faults + 1, _FAULTS[self.plan.number])
                return self.state["u"]
        self.state.update((state, values[name]) for state, name in routine.stores)
        return None if routine.result is None else values[routine.result]

    def _compiled_line(self, line: Line) -> tuple[str, Callable[..., Value], tuple[str, ...]]:
        run: Callable[..., Value]
        if line.op == "asr":
            run = partial(_shifted, line.shift)
        elif line.op == "low":
            run = partial(_lowest, line.shift)
        elif line.op == "unless":
            run = _unless_sign if self._program.whole else _unless_product
        else:
            run = _OPS[line.op]
        return line.name, run, line.args
