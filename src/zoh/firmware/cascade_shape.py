"""What sections in series consist of in one number format: states, ranges, coefficients."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil
from typing import Self

from zoh.firmware.book import Features, Format
from zoh.firmware.factors import Exact
from zoh.firmware.lines import State
from zoh.firmware.realise import Section


@dataclass(frozen=True, slots=True, kw_only=True)
class CascadeShape:
    """Sections in series with their features in one format; ``delta`` says in which form.

    points  the binary point of each section's sum, "section1" and so on; 0 for floats
    """

    sections: tuple[Section, ...]
    features: Features
    format: Format
    delta: bool
    points: Mapping[str, int]

    @classmethod
    def begun(
        cls, sections: tuple[Section, ...], features: Features, form: Format, *, delta: bool
    ) -> Self:
        """Return the shape with its binary points as high as words have bits."""
        start = form.word - 2 if form.whole else 0
        points = {f"section{i}": start for i in range(1, len(sections) + 1)}
        return cls(sections=sections, features=features, format=form, delta=delta, points=points)

    def taken(self, i: int) -> tuple[Exact, Exact]:
        """Return (b, a) of section i in its form; the last one counts in steps of u per step.

        In floats an integrator's a are those that stay one when they are rounded.
        """
        section = self.sections[i]
        b, a = (section.b, section.a) if self.delta else section.in_z
        if not self.delta and not self.format.whole and 1 + sum(a) == 0:
            a2 = self.rounded(a[1])
            a = (-1 - a2, a2)
        gain = self.format.gain if i == len(self.sections) - 1 else Fraction(1)
        return tuple(c * gain for c in b), a

    def at_rest(self, i: int) -> Fraction:
        """Return a section's gain at z = 1, where d is 0."""
        section = self.sections[i]
        return section.b[section.order] / section.a[section.order - 1]

    def rounded(self, value: Fraction) -> Fraction:
        """Return a2 of an integrating section in floats so that -1 - a2 is held exactly too."""
        bits = 23 if self.format.number == "f32" else 52  # 1 + a2 is below 2
        return Fraction(round(value * (1 << bits)), 1 << bits)

    def states(self) -> tuple[State, ...]:
        """Return the states, in the order of the C struct."""
        states = []
        for i, section in enumerate(self.sections, 1):
            for k in range(1, section.order + 1):
                if k == 1 or self.second(i - 1):
                    says = f"section {i}: sum {k}"
                    ends = self.most(i - 1, k) if self.delta and self.format.whole else None
                    states.append(
                        State(
                            name=f"s{k}_{i}", says=says, group=f"section{i}",
                            least=None if ends is None else -ends, most=ends,
                        )
                    )  # fmt: skip
        if self.keeps_u:
            states.append(State(name="u", says="the last output"))
        return tuple(states)

    @property
    def keeps_u(self) -> bool:
        """Return whether the output is a state: a rate or a fault asks for it."""
        return not self.format.whole or self.features.change is not None

    def second(self, i: int) -> bool:
        """Return whether section i has a second state."""
        b, a = self.taken(i)
        return self.sections[i].order == 2 and bool(b[2] or a[1])

    def most(self, i: int, k: int) -> int:
        """Return the end of sum k: half more than x asks at rest, and all that u less ff can."""
        b, a = self.taken(i)
        on_x, on_y = (b[0], Fraction(1)) if k == 1 else (b[1], a[0])
        size = (3 * abs(on_x) + 2 * abs(on_y)) * -self.format.least
        return ceil(size * (1 << self.points[f"section{i + 1}"]))

    def moved(self, group: str) -> Self | None:
        """Return the same with one binary point a bit lower; None where there is no bit left."""
        points = dict(self.points)
        points[group] -= 1
        return replace(self, points=points) if points[group] >= 0 else None


def named(b: Exact, a: Exact) -> list[tuple[str, Fraction]]:
    """Return the constants by name; those of the output with the sign that they are added with."""
    return [(f"b{k}", c) for k, c in enumerate(b)] + [(f"m{k}", -c) for k, c in enumerate(a, 1)]


def in_books(name: str) -> str:
    """Return what books call a constant.

    >>> in_books("m1")
    '-a1'
    """
    return name.replace("m", "-a")
