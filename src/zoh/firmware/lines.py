"""A routine of the firmware as data: straight lines, each of them one operation.

There are no branches: a choice is an operation (``atmost``, ``atleast``, ``unless``), so that every
reading of the lines, as numbers, as ranges, as formulas for a solver or as C, is a loop over them.
Names stand for inputs, states, coefficients and earlier lines alike.

    add sub mul neg   a + b, a - b, a b, -a; of floats each is rounded once
    asr low           floor(a / 2^shift), and what that leaves, a mod 2^shift; whole numbers only
    atmost atleast    the smaller, the larger of a and b; a where it is not a number
    unless            d, but c where a and b push the same way (a b > 0)
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

Number = Literal["f32", "f64", "q31", "q15"]
NUMBERS: tuple[Number, ...] = ("q15", "q31", "f32", "f64")
Operation = Literal["add", "sub", "mul", "neg", "asr", "low", "atmost", "atleast", "unless"]

ZERO = "0"  # the name of the constant that needs none


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """One operation: ``name`` = ``op``(``args``), said in words.

    shift  the power of two of asr and low
    group  which of a plan's binary points a value that does not fit asks to be moved
    """

    name: str
    op: Operation
    args: tuple[str, ...]
    shift: int = 0
    group: str = ""
    says: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Coefficient:
    """A constant of the firmware, exactly as the C has it.

    value  a float that the format holds, or a whole number
    point  the binary point of a whole number: it stands for value / 2^point
    """

    name: str
    value: float | int
    says: str
    point: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """A number that is kept from sample to sample.

    least, most  bounds that hold for all time, as the writer of the step claims them; None where
                 they are to be found. ``ranges`` proves either. Whole numbers only.
    """

    name: str
    says: str
    least: int | None = None
    most: int | None = None
    group: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Routine:
    """Lines with what they read and what they leave.

    stores  (state, name): written together, after the last line
    result  the name that is returned, None where nothing is
    guard   a sum that is finite only if all that is stored is; None for whole numbers
    """

    name: str
    inputs: tuple[str, ...]
    lines: tuple[Line, ...]
    stores: tuple[tuple[str, str], ...]
    result: str | None = None
    guard: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Program:
    """All routines of one controller."""

    number: Number
    states: tuple[State, ...]
    coefficients: tuple[Coefficient, ...]
    step: Routine
    track: Routine
    reset: Routine

    @property
    def whole(self) -> bool:
        """Return whether it works in whole numbers."""
        return self.number in ("q31", "q15")

    @property
    def routines(self) -> tuple[Routine, ...]:
        """Return step, track and reset."""
        return self.step, self.track, self.reset

    def value(self, name: str) -> float | int:
        """Return a coefficient's value."""
        return next(c.value for c in self.coefficients if c.name == name)


@dataclass(slots=True)
class Writer:
    """Writes lines, one method for each operation; each returns the name of what it made.

    >>> w = Writer()
    >>> w.add("v", w.mul("p", "kp", "e"), "ff")
    'v'
    >>> [line.op for line in w.lines]
    ['mul', 'add']
    """

    lines: list[Line] = field(default_factory=list)

    def _put(
        self, name: str, op: Operation, args: tuple[str, ...], says: str, group: str, shift: int = 0
    ) -> str:
        line = Line(name=name, op=op, args=args, shift=shift, group=group, says=says)
        self.lines.append(line)
        return name

    def add(self, name: str, a: str, b: str, says: str = "", group: str = "") -> str:
        """Return a + b."""
        return self._put(name, "add", (a, b), says, group)

    def sub(self, name: str, a: str, b: str, says: str = "", group: str = "") -> str:
        """Return a - b."""
        return self._put(name, "sub", (a, b), says, group)

    def mul(self, name: str, a: str, b: str, says: str = "", group: str = "") -> str:
        """Return a b; a is a coefficient."""
        return self._put(name, "mul", (a, b), says, group)

    def neg(self, name: str, a: str, says: str = "", group: str = "") -> str:
        """Return -a."""
        return self._put(name, "neg", (a,), says, group)

    def down(self, name: str, a: str, shift: int, says: str = "", group: str = "") -> str:
        """Return floor(a / 2^shift); ``a`` itself, and no line, where shift is 0."""
        return self._put(name, "asr", (a,), says, group, shift) if shift else a

    def low(self, name: str, a: str, shift: int, says: str = "", group: str = "") -> str:
        """Return what ``down`` leaves, in [0, 2^shift)."""
        return self._put(name, "low", (a,), says, group, shift)

    def atmost(self, name: str, a: str, b: str, says: str = "", group: str = "") -> str:
        """Return the smaller of a and b."""
        return self._put(name, "atmost", (a, b), says, group)

    def atleast(self, name: str, a: str, b: str, says: str = "", group: str = "") -> str:
        """Return the larger of a and b."""
        return self._put(name, "atleast", (a, b), says, group)

    def unless(
        self, name: str, a: str, b: str, kept: str, moved: str, says: str = "", group: str = ""
    ) -> str:
        """Return ``moved``, or ``kept`` where a and b have the same sign."""
        return self._put(name, "unless", (a, b, kept, moved), says, group)


def used(lines: list[Line], wanted: Iterable[str | None]) -> tuple[Line, ...]:
    """Return the lines that what is wanted depends on, in their order.

    >>> w = Writer()
    >>> [line.name for line in used(w.lines, [w.sub("e", "r", "y"), w.neg("p", "y")][1:])]
    ['p']
    """
    needed = set(wanted)
    kept = []
    for line in reversed(lines):
        if line.name in needed:
            kept.append(line)
            needed |= set(line.args)
    return tuple(kept[::-1])
