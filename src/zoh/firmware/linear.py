"""The step read as sums: every line on states, inputs and rounding errors, limits open, exactly.

What a processor is going to compute is so taken from the very lines that it will run, not from the
law that they were written for: a line that is missing or wrong is another transfer function, and
another margin.
Source: D. K. Faddeev, V. N. Faddeeva, Computational Methods of Linear Algebra, sec. 47 (the
adjugate of d I - A together with its determinant).
"""

from collections.abc import Mapping
from fractions import Fraction
from operator import mul

from zoh.firmware.factors import Exact
from zoh.firmware.lines import ZERO, Line, Program

Row = Mapping[str, Fraction]  # what a value is made of: a factor for each name, "1" a constant
READ = "y read"  # the error of a measurement that is brought to whole steps


def rows(program: Program, errors: Mapping[str, str] | None = None) -> dict[str, Row]:
    """Return every line of the step as a sum of states, r, y, ff, 1 and errors.

    errors  the name of the error that a line makes, by line; a floor's is what it leaves
    """
    errors = errors or {}
    found: dict[str, Row] = {ZERO: {}}
    for name in (*program.step.inputs, *(s.name for s in program.states)):
        found[name] = {name: Fraction(1)}
    for c in program.coefficients:
        found[c.name] = {"1": Fraction(c.value)}
    if READ in errors.values():
        found["y"] = {"y": Fraction(1), READ: Fraction(1)}
    for line in program.step.lines:
        row = _row(program, line, found)
        own = errors.get(line.name)
        found[line.name] = row if own is None or own == left(line) else _plus(row, {own: 1})
    return found


def left(line: Line) -> str:
    """Return the name of what a floor leaves of its argument, the same for asr and low."""
    return f"{line.args[0]} mod 2^{line.shift}" if line.op in ("asr", "low") else ""


def transfer(program: Program) -> tuple[Exact, Exact]:
    """Return num and den in d = z - 1 of the step from -y to u, with r = ff = 0, in steps.

    It is what the loop is closed with; ``reference_path`` is the same from r.

    >>> from zoh.firmware.lines import Coefficient, Routine, State, Writer
    >>> w = Writer()
    >>> x = w.add("new", "x", w.sub("e", "r", "y"))
    >>> step = Routine(
    ...     name="step", inputs=("r", "y"), lines=tuple(w.lines), stores=(("x", x),), result="x"
    ... )
    >>> program = Program(
    ...     number="f64", states=(State(name="x", says=""),), coefficients=(), step=step,
    ...     track=step, reset=step,
    ... )
    >>> transfer(program) == ((0, 1), (1, 0))  # 1/(z - 1)
    True
    """
    return _from_input(program, "y", -1)


def reference_path(program: Program) -> tuple[Exact, Exact]:
    """Return num and den in d = z - 1 of the step from r to u, with y = ff = 0, in steps."""
    return _from_input(program, "r", 1)


def _from_input(program: Program, name: str, sign: int) -> tuple[Exact, Exact]:
    found, stores = rows(program), dict(program.step.stores)
    u = found[str(program.step.result)]
    states = _acting(found, stores, u, name)
    moved = [found[stores[s]] for s in states]
    a = [
        [row.get(t, Fraction(0)) - (s == t) for t in states]
        for s, row in zip(states, moved, strict=True)
    ]
    b = [sign * row.get(name, Fraction(0)) for row in moved]
    c = [u.get(s, Fraction(0)) for s in states]
    return _fraction(a, b, c, sign * u.get(name, Fraction(0)))


def _acting(found: Mapping[str, Row], stores: Mapping[str, str], u: Row, name: str) -> list[str]:
    """Return the states that reach u, at once or later, and are reached by a state or the input."""
    moved = {s for s in stores if found[stores[s]].keys() & {*stores, name}}
    acting = [s for s in stores if s in u and s in moved]
    for state in acting:
        row = found[stores[state]]
        acting += [s for s in stores if s in row and s in moved and s not in acting]
    return acting


def _fraction(
    a: list[list[Fraction]], b: list[Fraction], c: list[Fraction], direct: Fraction
) -> tuple[Exact, Exact]:
    """Return c adj(d I - a) b + direct det(d I - a), and the determinant.

    All numbers are over a power of two; over the largest one they are whole, and stay so.
    """
    n = len(b)
    unit = max(x.denominator for x in (*b, *c, *(x for row in a for x in row), Fraction(1)))
    whole, b_whole, c_whole = ([_times_unit(row, unit) for row in rows] for rows in (a, [b], [c]))
    den, num = [Fraction(1)], [direct]
    m = [[int(i == j) for j in range(n)] for i in range(n)]
    for k in range(1, n + 1):
        through = sum(map(mul, c_whole[0], (sum(map(mul, row, b_whole[0])) for row in m)))
        columns = list(zip(*m, strict=True))
        m = [[sum(map(mul, row, column)) for column in columns] for row in whole]
        trace = -sum(m[i][i] for i in range(n)) // k  # a whole number: det's coefficient
        den.append(Fraction(trace, unit**k))
        num.append(direct * den[k] + Fraction(through, unit ** (k + 1)))
        for i in range(n):
            m[i][i] += trace
    return tuple(num), tuple(den)


def _times_unit(row: list[Fraction], unit: int) -> list[int]:
    return [x.numerator * (unit // x.denominator) for x in row]


def _row(program: Program, line: Line, found: Mapping[str, Row]) -> Row:
    a = found[line.args[0]]
    if line.op == "asr" and not a:
        return {}  # of nothing a floor leaves nothing
    if line.op == "asr":
        return _plus(_times(a, Fraction(1, 1 << line.shift)), {left(line): -1})
    if line.op == "low":
        return {left(line): Fraction(1 << line.shift)}
    if line.op in ("atmost", "atleast"):
        return a
    if line.op == "neg":
        return _times(a, Fraction(-1))
    if line.op == "unless":
        return found[line.args[3]]
    b = found[line.args[1]]
    if line.op == "mul":
        return _times(b, Fraction(program.value(line.args[0])))
    return _plus(a, b if line.op == "add" else _times(b, Fraction(-1)))


def _plus(a: Row, b: Mapping[str, Fraction | int]) -> Row:
    total = dict(a)
    for name, c in b.items():
        total[name] = total.get(name, Fraction(0)) + c
    return {name: c for name, c in total.items() if c}


def _times(a: Row, c: Fraction) -> Row:
    return {name: c * x for name, x in a.items() if c}
