"""What a controller in parallel form consists of in one number format: states, ranges, gains."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, floor
from typing import Self

from zoh.firmware.book import Features, Format
from zoh.firmware.lines import State
from zoh.firmware.realise import Filter, Parallel

FED_BACK = ("back_calculation", "tracking")  # a share of what a limit took, or all of it


@dataclass(frozen=True, slots=True, kw_only=True)
class PidShape:
    """A law in parallel form with its features in one format.

    points  the binary points of whole numbers: "u" of the sums, "integral" and "ki" of the integral
            and of what it moves by, "filter" and "alpha" of each filter and of what that moves by;
            0 for floats
    """

    law: Parallel
    features: Features
    format: Format
    points: Mapping[str, int]

    @classmethod
    def begun(cls, law: Parallel, features: Features, form: Format) -> Self:
        """Return the shape with its binary points as high as words have bits."""
        start = form.word - 2 if form.whole else 0
        names = ["u", "integral", "ki"]
        names += [f"{name}{tail}" for tail, _ in tails(law) for name in ("filter", "alpha")]
        return cls(law=law, features=features, format=form, points=dict.fromkeys(names, start))

    @property
    def whole(self) -> bool:
        """Return whether the numbers are whole."""
        return self.format.whole

    @property
    def filters(self) -> list[tuple[str, Filter]]:
        """Return the filters with what their names end in: nothing where there is one."""
        return tails(self.law)

    @property
    def on_y(self) -> bool:
        """Return whether the filters see the measurement alone."""
        return self.features.d_weight == 0

    @property
    def keeps_u(self) -> bool:
        """Return whether the output is a state: a rate, a fault or an empty struct asks for it."""
        alone = not (self.law.ki or self.law.filters)
        return not self.whole or self.features.change is not None or alone

    @property
    def ki_finer(self) -> int:
        """Return by how many bits ki is finer than the integral that it moves."""
        return self._finer(abs(self.law.ki * self.format.gain), "integral", "ki")

    @property
    def back_coarser(self) -> int:
        """Return the bits of what a limit took that are left out for digits of the share fed back.

        Nothing is left out of nothing: where no limit is reached nothing is fed back.
        """
        if not self.whole or self.features.back == 1:
            return 0
        held = self.features.back * (1 << self.points["integral"])
        return max(0, self.format.word // 4 - floor(held).bit_length())

    def alpha_finer(self, tail: str, part: Filter) -> int:
        """Return by how many bits alpha is finer than the filter that it moves."""
        return 0 if part.alpha == 1 else self._finer(part.alpha, f"filter{tail}", f"alpha{tail}")

    def _finer(self, size: Fraction, state: str, gain: str) -> int:
        """Return the bits that give a gain its digits beyond the binary point of what it moves.

        At a fast clock a gain is so small that at the state's point it would have but a few. What
        the state cannot take then waits for the next sample.
        """
        if not self.whole:
            return 0
        digits, bits, point = self.format.word * 5 // 16, 0, self.points[state]
        while bits < self.points[gain] - point and size * (1 << point + bits) < 1 << digits:
            bits += 1
        return bits

    def states(self) -> tuple[State, ...]:
        """Return the states, in the order of the C struct."""
        states = []
        if self.law.ki:
            low, high = self.x_ends() if self.whole else (None, None)
            states.append(
                State(name="x", says="the integral", least=low, most=high, group="integral")
            )
            if self.ki_finer:
                states.append(State(name="x_rest", says="what waits for the integral", group="ki"))
        for tail, part in self.filters:
            says = "the filtered measurement" if self.on_y else "the filtered error"
            remembers = self.whole and part.alpha != 1
            low, high = self._filter_ends(tail, part) if remembers else (None, None)
            states.append(
                State(name=f"f{tail}", says=says, least=low, most=high, group=f"filter{tail}")
            )
            if self.alpha_finer(tail, part):
                says = "what waits for the filter"
                states.append(State(name=f"f_rest{tail}", says=says, group=f"alpha{tail}"))
        if self.keeps_u:
            states.append(State(name="u", says="the last output"))
        return tuple(states)

    def _filter_ends(self, tail: str, part: Filter) -> tuple[int, int]:
        """Return bounds of f: those of its input where alpha <= 1, wider where it rings."""
        least, most = self.format.least, self.format.most
        if not self.on_y:
            least, most = least - most, most - least
        if part.alpha > 1:
            most = ceil((part.alpha * most + 2) / (2 - part.alpha)) + 2
            least = -most
        point = self.points[f"filter{tail}"]
        return least << point, ((most + 1) << point) - 1

    def x_range(self) -> tuple[int, int]:
        """Return the bounds of the integral in steps of u: any u less any ff and any kr r - kp y.

        So wide that ``track`` can hold every output under every r and y. Where what a limit takes
        is fed back, so wide that it is never cut: with a share b, |x| <= M gives (1 - b) M + b (all
        that u, ff and the other parts can be) + |ki e|, which is M again.
        """
        law, f = self.law, self.format
        on_r = (law.kp - law.ki / 2) * self.features.r_weight + law.ki / 2
        rest = (abs(on_r) + abs(law.kp)) * f.gain * -f.least
        if self.features.limited and self.features.anti_windup in FED_BACK:
            rest += sum(self._most_of(tail, part) for tail, part in self.filters)
            rest += 2 * abs(law.ki) * f.gain * -f.least / self.features.back
        pad = ceil(rest) - f.least
        return f.least - pad, f.most + pad

    def _most_of(self, tail: str, part: Filter) -> Fraction:
        """Return the largest size of a filter's share in steps of u."""
        seen = (1 + self.features.d_weight) * -self.format.least
        point = self.points[f"filter{tail}"]
        kept = max(abs(end) >> point for end in self._filter_ends(tail, part)) + 1
        return abs(part.kd) * self.format.gain * (seen + kept)

    def x_ends(self) -> tuple[int, int]:
        """Return the same at the integral's binary point."""
        low, high = self.x_range()
        return low << self.points["integral"], high << self.points["integral"]

    def moved(self, group: str) -> Self | None:
        """Return the same with one binary point a bit lower; None where there is no bit left."""
        points = dict(self.points)
        points[group] -= 1
        points["u"] = min(points["u"], points["integral"])
        return replace(self, points=points) if points[group] >= 0 else None


def tails(law: Parallel) -> list[tuple[str, Filter]]:
    """Return each filter with what the names that belong to it end in."""
    if len(law.filters) == 1:
        return [("", law.filters[0])]
    return [(f"_{i}", part) for i, part in enumerate(law.filters, 1)]
