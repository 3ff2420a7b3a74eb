"""No overflow, for all time: the lines read as ranges, and the ranges of the states by induction.

A value is a sum of unknowns, each in a range and with its factor; so what is subtracted from
itself is 0, and a filter f + alpha (e - f) is seen to stay within its input. floor(f/2^k) is
(f - rest)/2^k with an unknown rest in [0, 2^k): all values are whole, and their sums exact. The
inputs are any numbers of the format. If with the states in their ranges every routine leaves them
there, they are there for ever, since the first routine of all, reset, needs none of them.
Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, ch. 5; the
sums of unknowns are affine arithmetic without its rounding (J. Stolfi, L. H. de Figueiredo).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from zoh.firmware.book import IO_BITS
from zoh.firmware.lines import ZERO, Line, Program, Routine

Range = tuple[int, int]
_ROUNDS = 64  # of the induction as it is; from then on it goes ahead of ranges that close slowly


@dataclass(frozen=True, slots=True, kw_only=True)
class Ranges:
    """The range of every line, by routine and name, and of every state."""

    lines: Mapping[tuple[str, str], Range]
    states: Mapping[str, Range]


@dataclass(frozen=True, slots=True, kw_only=True)
class Overflow:
    """A value that does not fit its word.

    says, group  what the value is, and which binary point would have to move
    """

    name: str
    says: str
    group: str
    least: int
    most: int
    word: int


@dataclass(frozen=True, slots=True)
class _Sum:
    """(constant + sum of factor times unknown) / 2^point: whole numbers, so that sums are exact."""

    constant: int
    factors: Mapping[str, int]
    point: int = 0

    def plus(self, other: "_Sum", sign: int = 1) -> "_Sum":
        point = max(self.point, other.point)
        own, far = 1 << point - self.point, sign << point - other.point
        factors = {name: own * c for name, c in self.factors.items()}
        for name, c in other.factors.items():
            factors[name] = factors.get(name, 0) + far * c
        constant = own * self.constant + far * other.constant
        return _Sum(constant, {n: c for n, c in factors.items() if c}, point)

    def times(self, c: int) -> "_Sum":
        factors = {n: c * f for n, f in self.factors.items() if c}
        return _Sum(c * self.constant, factors, self.point)


@dataclass(slots=True)
class _Reading:
    """One routine read once."""

    ranges: dict[str, Range]
    values: dict[str, _Sum]
    split: dict[tuple[str, int], tuple[str, str]] = field(default_factory=dict)

    def range_of(self, value: _Sum) -> Range:
        low = high = value.constant
        for name, c in value.factors.items():
            least, most = self.ranges[name]
            low, high = low + c * (least if c > 0 else most), high + c * (most if c > 0 else least)
        return -(-low >> value.point), high >> value.point  # up from below, down from above

    def unknown(self, name: str, found: Range) -> _Sum:
        self.ranges[name] = found
        return _Sum(0, {name: 1}) if found[0] < found[1] else _Sum(found[0], {})

    def read(self, line: Line) -> _Sum:
        """Return the line's value."""
        a = self.values[line.args[0]]
        if line.op == "neg":
            return a.times(-1)
        if line.op in ("asr", "low"):
            return self._shifted(line)
        if line.op == "unless":
            ends = [self.range_of(self.values[name]) for name in line.args[2:]]
            return self.unknown(line.name, (min(e[0] for e in ends), max(e[1] for e in ends)))
        b = self.values[line.args[1]]
        if line.op == "add":
            return a.plus(b)
        if line.op == "sub":
            return a.plus(b, -1)
        if line.op == "mul":
            return b.times(a.constant)  # the first factor is a coefficient
        return self._chosen(line, a, b)

    def _chosen(self, line: Line, a: _Sum, b: _Sum) -> _Sum:
        (a0, a1), (b0, b1) = self.range_of(a), self.range_of(b)
        if line.op == "atmost":
            return a if a1 <= b0 else self.unknown(line.name, (min(a0, b0), min(a1, b1)))
        return a if a0 >= b1 else self.unknown(line.name, (max(a0, b0), max(a1, b1)))

    def _shifted(self, line: Line) -> _Sum:
        name, k = line.args[0], line.shift
        if (name, k) not in self.split:
            self._split(name, k)
        whole, rest = self.split[name, k]
        return self.values[whole if line.op == "asr" else rest]

    def _split(self, name: str, k: int) -> None:
        """Part a value into 2^k floor(value/2^k) and an unknown rest."""
        low, high = self.range_of(self.values[name])
        whole, rest, mask = f"{name} >> {k}", f"{name} mod 2^{k}", (1 << k) - 1
        one = low >> k == high >> k
        self.values[rest] = self.unknown(rest, (low & mask, high & mask) if one else (0, mask))
        parted = self.values[name].plus(self.values[rest], -1)
        self.values[whole] = _Sum(parted.constant, parted.factors, parted.point + k)
        self.split[name, k] = whole, rest


def proved(program: Program) -> Ranges | Overflow:
    """Return the ranges of a program in whole numbers, or the first value that does not fit.

    Ranges that have not closed after 64 rounds are widened by more than they grew, twice as much
    in every round: a wider range is as good a proof, and what has no end leaves its word.
    """
    states = {
        s.name: (0, 0) if s.least is None or s.most is None else (s.least, s.most)
        for s in program.states
    }
    for s in program.states:  # before what is made of them: their own binary points come first
        if not _fits(states[s.name], word := 2 * IO_BITS[program.number]):
            return _too_large(s.name, s.says, s.group, states[s.name], word)
    rounds = 0
    while True:
        found = _all_read(program, states)
        if isinstance(found, Overflow):
            return found
        lines, left = found
        if left == states:  # what is left holds what it came from
            return Ranges(lines=lines, states=states)
        states = _ahead(states, left, rounds - _ROUNDS) if rounds >= _ROUNDS else left
        rounds += 1


def _ahead(
    states: Mapping[str, Range], left: Mapping[str, Range], doublings: int
) -> dict[str, Range]:
    """Return ranges that are wider than what is left by 2^doublings times what was added."""
    return {
        n: (low - ((a - low) << doublings), high + ((high - b) << doublings))
        for (n, (a, b)), (low, high) in zip(states.items(), left.values(), strict=True)
    }


def _all_read(
    program: Program, states: Mapping[str, Range]
) -> tuple[dict[tuple[str, str], Range], dict[str, Range]] | Overflow:
    """Return the ranges of all lines, and the union of what the routines leave in each state."""
    bits = IO_BITS[program.number]
    lines: dict[tuple[str, str], Range] = {}
    left = dict(states)
    for routine in program.routines:
        reading = _begun(program, routine, states)
        for line in routine.lines:
            value = reading.read(line)
            reading.values[line.name] = value
            found = reading.range_of(value)
            lines[routine.name, line.name] = found
            if not _fits(found, 2 * bits):
                return _too_large(line.name, line.says, line.group, found, 2 * bits)
        for state, name in routine.stores:
            low, high = reading.range_of(reading.values[name])
            left[state] = min(low, left[state][0]), max(high, left[state][1])
            if not _fits(left[state], 2 * bits):
                owner = next(s for s in program.states if s.name == state)
                return _too_large(state, owner.says, owner.group, left[state], 2 * bits)
        if routine.result is not None:
            assert _fits(reading.range_of(reading.values[routine.result]), bits), "u is limited"
    return lines, left


def _begun(program: Program, routine: Routine, states: Mapping[str, Range]) -> _Reading:
    """Return a reading that knows constants, inputs and states."""
    half = 1 << IO_BITS[program.number] - 1
    reading = _Reading(ranges={}, values={ZERO: _Sum(0, {})})
    for c in program.coefficients:
        reading.values[c.name] = _Sum(int(c.value), {})
    for name in routine.inputs:
        reading.values[name] = reading.unknown(name, (-half, half - 1))
    for name, found in states.items():
        reading.values[name] = reading.unknown(name, found)
    return reading


def _fits(found: Range, bits: int) -> bool:
    return -(1 << bits - 1) <= found[0] and found[1] < 1 << bits - 1


def _too_large(name: str, says: str, group: str, found: Range, word: int) -> Overflow:
    return Overflow(
        name=name, says=says or name, group=group, least=found[0], most=found[1], word=word
    )
