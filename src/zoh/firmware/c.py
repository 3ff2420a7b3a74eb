"""A plan as C99 that is valid C++17 too: one header, one source.

No library, no heap, no global that changes; every routine has one exit. Each line of the source is
one line of the plan, so that no expression is left to a compiler to order; contraction into fused
operations and arithmetic that is faster than IEEE 754's is switched off or refused by the source
itself. In whole numbers each line carries the range that is proved of it, and its type is the
smaller one that holds it.
"""

from collections.abc import Sequence

from zoh.firmware.head import Cost, header
from zoh.firmware.lines import ZERO, Coefficient, Line, Routine
from zoh.firmware.plan import Plan
from zoh.firmware.selftest import selftest
from zoh.firmware.words import float_literal, result_type, state_type

_SYMBOLS = {"add": "+", "sub": "-", "mul": "*"}
_FLOAT_GUARDS = """\
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "this code needs IEEE 754 arithmetic: build it without -ffast-math and its parts"
#endif
#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ != 0)
#error "this code looks for what is not finite: build it without -ffinite-math-only"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)
#error "this code needs every operation rounded to its own type"
#elif defined(__FLT_EVAL_METHOD__) && (__FLT_EVAL_METHOD__ != 0)
#error "this code needs every operation rounded to its own type"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#endif
"""


def emit(plan: Plan, costs: Sequence[Cost] = ()) -> dict[str, str]:
    """Return the texts of NAME.h and NAME.c, by file name; ``costs`` were measured by a proof.

    The same plan and costs give the same bytes.

    >>> import zoh
    >>> from zoh.firmware.plan import plan
    >>> d = zoh.p(zoh.Plant(num=[1], den=[1, 0]), dt=1.0, pm_deg=45)
    >>> sorted(emit(plan(d, name="loop", u_min=-1, u_max=1)))
    ['loop.c', 'loop.h']
    """
    return {f"{plan.name}.h": header(plan, costs), f"{plan.name}.c": _source(plan)}


def _source(plan: Plan) -> str:
    writer = _Source(plan)
    parts = [
        f"/* {plan.name}.c: see {plan.name}.h. Generated; design {plan.sha256}. */\n"
        f'#include "{plan.name}.h"\n',
        writer.protection(),
        "".join(map(writer.constant, plan.coefficients)),
        writer.init(),
        writer.routine(plan.program.reset),
        writer.routine(plan.program.step),
        writer.routine(plan.program.track),
        selftest(plan),
    ]
    return "\n".join(p for p in parts if p)


class _Source:
    """The words of one plan's source."""

    def __init__(self, plan: Plan) -> None:
        self.plan, self.name, self.whole = plan, plan.name, plan.program.whole
        self.io, self.kept = result_type(plan.number), state_type(plan.number)
        self.states = {s.name for s in plan.program.states}
        self.constants = {c.name: c for c in plan.coefficients}

    def protection(self) -> str:
        """Return what the source needs of its compiler, and the shift that C leaves open."""
        if not self.whole:
            return _FLOAT_GUARDS
        types = sorted({self._type_in(r, line.args[0]) for r in self.plan.program.routines
                        for line in r.lines if line.op == "asr"})  # fmt: skip
        if not types:
            return ""
        text = (
            "/* C leaves it open what a shift of a negative number is; this code needs floor. */\n"
        )
        text += f"typedef char {self.name}_shift_is_floor[((-3) >> 1 == -2) ? 1 : -1];\n"
        for kind in types:
            text += (
                f"static {kind} {self._shift(kind)}({kind} a, unsigned int k)\n"
                "{\n    return a >> k;\n}\n"
            )
        return text

    def _shift(self, kind: str) -> str:
        return f"{self.name}_floor{kind[3:5]}"

    def constant(self, c: Coefficient) -> str:
        """Return the definition of a coefficient."""
        kind = self._constant_type(c)
        if isinstance(c.value, float):
            text, exact = float_literal(c.value, self.plan.number), c.value.hex()
        else:
            text = _whole_literal(c.value, "LL" if kind == "int64_t" else "")
            exact = f"{c.value / 2**c.point:.9g} 2^{c.point}" if c.point else f"{c.value}"
        return f"static const {kind} {self.name}_{c.name} = {text}; /* {exact}: {c.says} */\n"

    def _constant_type(self, c: Coefficient) -> str:
        return self.kept if isinstance(c.value, float) else _smallest(c.value, c.value)

    def init(self) -> str:
        """Return the routine that sets every member, the fault counter too."""
        zero = float_literal(0.0, self.plan.number) if not self.whole else "0"
        body = "".join(f"    s->{s.name} = {zero};\n" for s in self.plan.program.states)
        if not self.whole:
            body += "    s->faults = 0U;\n"
        return (
            f"void {self.name}_init({self.name}_state *s)\n{{\n{body}"
            f"    {self.name}_reset(s, {zero});\n}}\n"
        )

    def routine(self, routine: Routine) -> str:
        """Return one routine of the plan."""
        used = {a for line in routine.lines for a in line.args} | {n for _, n in routine.stores}
        given = "".join(f", {self.io} {name}" for name in routine.inputs)
        returns = self.io if routine.result is not None else "void"
        unused = [f"    (void){n};\n" for n in routine.inputs if n not in used]
        return (
            f"{returns} {self.name}_{routine.name}({self.name}_state *s{given})\n{{\n"
            + "".join(unused)
            + "".join(self._line(routine, line) for line in routine.lines)
            + self._end(routine)
            + "}\n"
        )

    def _end(self, routine: Routine) -> str:
        """Return the stores and the return, behind the guard where there is one."""
        stores = [f"s->{s} = {self._read(routine, n, self.kept)};\n" for s, n in routine.stores]
        returned = routine.result is not None
        if routine.guard is None:
            text = "".join(f"    {s}" for s in stores)
            if returned:
                text += f"    return {self._read(routine, str(routine.result), self.io)};\n"
            return text
        guard = routine.guard
        most = "UINT32_MAX" if self.plan.number == "f32" else "UINT64_MAX"
        text = f"    {self.io} out = s->u; /* what stays if a number is not finite */\n"
        text = text if returned else ""
        text += (
            f"    if (({guard} - {guard}) >= {float_literal(0.0, self.plan.number)}) {{\n"
            + "".join(f"        {s}" for s in stores)
            + (f"        out = {routine.result};\n" if returned else "")
            + f"    }} else {{\n        if (s->faults < {most}) {{\n"
            + "            s->faults += 1U;\n        }\n    }\n"
        )
        return text + ("    return out;\n" if returned else "")

    def _line(self, routine: Routine, line: Line) -> str:
        kind = self._type_in(routine, line.name)
        words = [line.says] if line.says else []
        if self.plan.ranges is not None:
            low, high = self.plan.ranges.lines[routine.name, line.name]
            words.append(f"{low} ... {high}")
        comment = f" /* {': '.join(words)} */" if words else ""
        return f"    const {kind} {line.name} = {self._expression(routine, line, kind)};{comment}\n"

    def _expression(self, routine: Routine, line: Line, kind: str) -> str:
        if line.op == "unless":
            return self._unless(routine, line, kind)
        kinds = [self._type_in(routine, a) for a in line.args]
        wide = max([kind, *kinds], key=_width)
        read = [self._read(routine, a, wide) for a in line.args]
        if line.op == "neg":
            return _cast(f"-{read[0]}", wide, kind)
        if line.op in _SYMBOLS:
            return _cast(f"{read[0]} {_SYMBOLS[line.op]} {read[1]}", wide, kind)
        if line.op == "asr":
            own = self._read(routine, line.args[0], kinds[0])
            return _cast(f"{self._shift(kinds[0])}({own}, {line.shift}U)", kinds[0], kind)
        if line.op == "low":
            own = self._read(routine, line.args[0], kinds[0])
            mask = f"{(1 << line.shift) - 1}U{'LL' if kinds[0] == 'int64_t' else ''}"
            return f"({kind})((u{kinds[0]}){own} & {mask})"
        chosen = [self._read(routine, a, kind) for a in line.args]
        sign = ">" if line.op == "atmost" else "<"
        return f"({read[0]} {sign} {read[1]}) ? {chosen[1]} : {chosen[0]}"

    def _unless(self, routine: Routine, line: Line, kind: str) -> str:
        a, b = (self._read(routine, n, self._type_in(routine, n)) for n in line.args[:2])
        kept, moved = (self._read(routine, n, kind) for n in line.args[2:])
        same = f"(({a} > 0) && ({b} > 0)) || (({a} < 0) && ({b} < 0))"
        if not self.whole:
            same = f"({a} * {b}) > {float_literal(0.0, self.plan.number)}"
        return f"({same}) ? {kept} : {moved}"

    def _type_in(self, routine: Routine, name: str) -> str:
        """Return the C type of a name in a routine."""
        if not self.whole:
            return self.kept
        if name in routine.inputs:
            return self.io
        if name in self.constants:
            return self._constant_type(self.constants[name])
        if name in self.states:
            return self.kept
        if name == ZERO:
            return "int32_t"
        assert self.plan.ranges is not None
        return _smallest(*self.plan.ranges.lines[routine.name, name])

    def _read(self, routine: Routine, name: str, kind: str) -> str:
        """Return the words that read a name as a value of this type."""
        own = self._type_in(routine, name)
        if name == ZERO:
            return float_literal(0.0, self.plan.number) if not self.whole else "0"
        if name in self.constants:
            word = f"{self.name}_{name}"
        else:
            word = f"s->{name}" if name in self.states else name
        return word if own == kind else f"({kind}){word}"


def _whole_literal(value: int, suffix: str) -> str:
    """Return a literal; the least of a type is no literal of that type in C, but a difference."""
    if value in (-(2**31), -(2**63)):
        return f"(-{-value - 1}{suffix} - 1)"
    return f"{value}{suffix}"


def _cast(text: str, own: str, kind: str) -> str:
    return text if own == kind else f"({kind})({text})"


def _smallest(low: int, high: int) -> str:
    return "int32_t" if -(2**31) <= low and high < 2**31 else "int64_t"


def _width(kind: str) -> int:
    return {"int16_t": 16, "int32_t": 32, "int64_t": 64}.get(kind, 0)
