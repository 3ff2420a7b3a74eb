"""No overflow, for all time, by a solver: the same lines read as formulas over whole numbers.

A second proof that shares no arithmetic with ``ranges``: the solver is asked for states within
their ranges and inputs of the format with which some value leaves its word or some state its range.
That there are none, is the proof. Everything is linear, since the coefficients are numbers.
Source: L. de Moura, N. Bjorner, Z3: An Efficient SMT Solver, TACAS 2008.
"""

from collections.abc import Callable
from typing import Any

from zoh.errors import SpecError
from zoh.firmware.book import IO_BITS
from zoh.firmware.lines import ZERO, Line, Program, Routine
from zoh.firmware.plan import Plan
from zoh.firmware.ranges import Ranges


def overflow_excluded(plan: Plan, timeout_s: float = 60.0) -> bool:
    """Return whether the solver proves that no value of a plan in whole numbers overflows.

    Raises SpecError for a plan in floats, and where z3-solver is not installed or finds no answer
    in time.
    """
    if plan.ranges is None:
        raise SpecError("plan", "must be in whole numbers", plan.number, "floats do not overflow")
    return excluded(plan.program, plan.ranges, timeout_s)


def excluded(program: Program, ranges: Ranges, timeout_s: float) -> bool:
    """Return the same of lines and of the states' ranges that are claimed of them."""
    z3 = _z3()
    return all(_holds(z3, program, ranges, r, timeout_s) for r in program.routines)


def _z3() -> Any:
    try:
        import z3
    except ImportError:
        way_out = "pip install 'zoh[firmware]'"
        raise SpecError("solver", "must be installed", "no z3-solver", way_out) from None
    return z3


def _holds(z3: Any, program: Program, ranges: Ranges, routine: Routine, timeout_s: float) -> bool:
    """Return whether a routine leaves every value and every state in its range."""
    bits, solver = IO_BITS[program.number], z3.Solver()
    solver.set("timeout", int(1000 * timeout_s))
    values: dict[str, Any] = {c.name: z3.IntVal(int(c.value)) for c in program.coefficients}
    values[ZERO] = z3.IntVal(0)
    wrong = []
    for name in routine.inputs:
        values[name] = z3.Int(name)
        solver.add(_inside(z3, values[name], _word(bits)))
    for name, found in ranges.states.items():
        values[name] = z3.Int(f"state {name}")
        solver.add(_inside(z3, values[name], found))
    for line in routine.lines:
        values[line.name] = _value(z3, line, values, solver.add)
        claimed = ranges.lines[routine.name, line.name]  # of which its type in C is the smallest
        wrong.append(z3.Not(_inside(z3, values[line.name], claimed)))
    for state, name in routine.stores:
        wrong.append(z3.Not(_inside(z3, values[name], ranges.states[state])))
    if routine.result is not None:
        wrong.append(z3.Not(_inside(z3, values[routine.result], _word(bits))))
    solver.add(z3.Or(wrong))
    found = solver.check()
    if found == z3.unknown:
        way_out = "allow more time; the ranges of the plan are proved without the solver"
        raise SpecError("timeout_s", f"must suffice for {routine.name}", timeout_s, way_out)
    return bool(found == z3.unsat)


def _word(bits: int) -> tuple[int, int]:
    return -(1 << bits - 1), (1 << bits - 1) - 1


def _inside(z3: Any, value: Any, found: tuple[int, int]) -> Any:
    return z3.And(value >= found[0], value <= found[1])


def _value(z3: Any, line: Line, values: dict[str, Any], claim: Callable[[Any], None]) -> Any:
    """Return the formula of a line; a shift brings two new unknowns, and says what they are."""
    args = [values[name] for name in line.args]
    if line.op in ("asr", "low"):
        whole = z3.Int(f"{line.args[0]} >> {line.shift}")
        rest = args[0] - (1 << line.shift) * whole
        claim(_inside(z3, rest, (0, (1 << line.shift) - 1)))
        return whole if line.op == "asr" else rest
    if line.op == "neg":
        return -args[0]
    a, b = args[:2]
    if line.op == "unless":
        same = z3.Or(z3.And(a > 0, b > 0), z3.And(a < 0, b < 0))
        return z3.If(same, args[2], args[3])
    if line.op == "atmost":
        return z3.If(a > b, b, a)
    if line.op == "atleast":
        return z3.If(a < b, b, a)
    return {"add": a + b, "sub": a - b, "mul": a * b}[line.op]
