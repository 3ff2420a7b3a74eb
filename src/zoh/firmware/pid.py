"""The step of a controller in parallel form, written once for floats and for whole numbers.

With d the filtered difference, x the integral and f the filter's state::

    d = (c r - y) - f        v = kr r - kp y + kd d + x + ff        u = v, limited
    f <- f + alpha d         x <- x + ki (r - y), but not further into a limit

kp is the proportional gain and half a step of the integral, whose trapezoid is so kept: with
b = 1, kr r - kp y = kp (r - y). In whole numbers sums have a binary point ("u"), the integral and
the filter finer ones of their own ("integral", "filter"), and what a state adds is never rounded:
there is no dead band in them.
Source: K. J. Astrom and T. Hagglund, Advanced PID Control, sec. 3.4 to 3.6 (set-point weights,
anti-windup), ch. 13 (implementation: word length, bumpless transfer).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil
from typing import Protocol

from zoh.firmware.book import Book, Features, Format, bounded, limited
from zoh.firmware.lines import ZERO, Program, Routine, State, Writer, used
from zoh.firmware.realise import Exact, Parallel

GROUPS = ("u", "integral", "filter")
Points = Mapping[str, int]


class Keeps(Protocol):
    """A step that knows its format and whether the output is a state."""

    @property
    def format(self) -> Format: ...  # noqa: D102
    @property
    def keeps_u(self) -> bool: ...  # noqa: D102


@dataclass(frozen=True, slots=True, kw_only=True)
class PidStep:
    """A law in parallel form with its features in one format, and the binary points chosen."""

    law: Parallel
    features: Features
    format: Format
    points: Points

    def program(self) -> Program:
        """Return step, track and reset."""
        book = Book(format=self.format)
        step, track, reset = self._step(book), self._track(book), self._reset(book)
        return Program(
            number=self.format.number,
            states=self._states(),
            coefficients=tuple(book.coefficients.values()),
            step=step, track=track, reset=reset,
        )  # fmt: skip

    def realised(self, program: Program) -> tuple[Exact, Exact]:
        """Return num and den in d of what the program's coefficients make, in physical units."""
        kp, ki, kd = (self._made(program, name) / self.format.gain for name in ("kp", "ki", "kd"))
        num: Exact = (kp + kd,)
        den: Exact = (Fraction(1),)
        if self.law.kd:
            alpha = self._made(program, "alpha") if self.law.alpha != 1 else Fraction(1)
            num, den = (kp + kd, kp * alpha), (Fraction(1), alpha)
        if self.law.ki:  # num/den + ki/d
            times_d = (*num, Fraction(0))
            num = tuple(
                a + ki * b for a, b in zip(times_d, (Fraction(0), *den), strict=True)
            )  # fmt: skip
            den = (*den, Fraction(0))
        return num, den

    def _made(self, program: Program, name: str) -> Fraction:
        found = [c for c in program.coefficients if c.name == name]
        return Fraction(found[0].value) / (1 << found[0].point) if found else Fraction(0)

    @property
    def _filtered(self) -> bool:
        return self.law.alpha != 1

    @property
    def _whole(self) -> bool:
        return self.format.whole

    @property
    def _on_y(self) -> bool:
        """Return whether the derivative sees the measurement alone."""
        return self.features.d_weight == 0

    def _states(self) -> tuple[State, ...]:
        states = []
        if self.law.ki:
            low, high = self._x_ends() if self._whole else (None, None)
            states.append(
                State(name="x", says="the integral", least=low, most=high, group="integral")
            )
        if self.law.kd:
            says = "the filtered measurement" if self._on_y else "the filtered error"
            least, most = self._filter_range() if self._whole and self._filtered else (None, None)
            states.append(State(name="f", says=says, least=least, most=most, group="filter"))
        if self.keeps_u:
            states.append(State(name="u", says="the last output"))
        return tuple(states)

    @property
    def keeps_u(self) -> bool:
        """Return whether the output is a state: a rate, a fault or an empty struct asks for it."""
        alone = not (self.law.ki or self.law.kd)
        return not self._whole or self.features.change is not None or alone

    def _filter_range(self) -> tuple[int, int]:
        """Return bounds of f: those of its input where alpha <= 1, wider where it rings."""
        least, most = self.format.least, self.format.most
        if not self._on_y:
            least, most = least - most, most - least
        if self.law.alpha > 1:
            most = ceil((self.law.alpha * most + 2) / (2 - self.law.alpha)) + 2
            least = -most
        return least << self.points["filter"], ((most + 1) << self.points["filter"]) - 1

    def _p(self, w: Writer, book: Book, e: str) -> str | None:
        """Write the proportional part; None where there is none."""
        law, b, unit = self.law, self.features.r_weight, self.format.gain
        if not law.kp and b == 1:
            return None
        point = self.points["u"]
        kp = book.gain("kp", law.kp * unit, "proportional gain, half a step of ki in it", point)
        if b == 1:
            return w.mul("p", kp, e, "proportional part", "u")
        on_r = (law.kp - law.ki / 2) * b + law.ki / 2
        kr = book.gain("kr", on_r * unit, "the same on the reference", point)
        p_y = w.mul("p_y", kp, "y", "proportional part of y", "u")
        if not on_r:
            return w.neg("p", p_y, "proportional part", "u")
        p_r = w.mul("p_r", kr, "r", "proportional part of r", "u")
        return w.sub("p", p_r, p_y, "proportional part", "u")

    def _weighted(self, w: Writer, book: Book, e: str) -> str:
        """Write what the derivative sees."""
        c = self.features.d_weight
        if c == 1:
            return e
        if c == 0:
            return "y"
        point = self.format.word // 2 - 2 if self._whole else 0
        name = book.gain("c", c, "share of the reference in the derivative", point)
        share = w.mul("r_c", name, "r")
        return w.sub("e_c", w.down("r_share", share, point), "y", "what the derivative sees")

    def _d(self, w: Writer, book: Book, e: str) -> tuple[str, str]:
        """Write the derivative; return it and the filter's next state."""
        seen, point = self._weighted(w, book, e), self.points["filter"] if self._filtered else 0
        now = w.down("f_now", "f", point, "the filter's output", "filter")
        a, b = (now, seen) if self._on_y else (seen, now)
        d = w.sub("d", a, b, "filtered difference")
        kd = book.gain(
            "kd", self.law.kd * self.format.gain, "gain of the difference", self.points["u"]
        )
        part = w.mul("d_part", kd, d, "derivative part", "u")
        if not self._filtered:
            return part, seen
        alpha = book.gain("alpha", self.law.alpha, "1 - the filter's pole", point)
        move = w.mul("f_move", alpha, d, "what the filter moves by", "filter")
        written = w.sub if self._on_y else w.add
        return part, written("f_new", "f", move, "the filter moves", "filter")

    def _step(self, book: Book) -> Routine:
        w, stores = Writer(), []
        e = w.sub("e", "r", "y", "error")
        parts = [p] if (p := self._p(w, book, e)) else []
        if self.law.kd:
            d, f = self._d(w, book, e)
            parts.append(d)
            stores.append(("f", f))
        if self.law.ki:
            point = self.points["integral"] - self.points["u"]
            parts.append(w.down("i_part", "x", point, "integral part", "u"))
        v = self._sum(w, book, parts)
        u = limited(w, book, self.features, v)
        if self.law.ki:
            stores.insert(0, ("x", self._x(w, book, e, v, u)))
        return finished("step", ("r", "y", "ff"), w, stores, v, u, self)

    def _sum(self, w: Writer, book: Book, parts: list[str]) -> str:
        total, point = parts[0], self.points["u"]
        for i, part in enumerate(parts[1:]):
            total = w.add(f"sum_{i + 1}", total, part, "", "u")
        if point:
            half = book.fixed("half", 1 << point - 1, "rounds the sum to the nearest", point)
            total = w.add("sum", total, half, "", "u")
        whole = w.down("law", total, point, "what the law asks for")
        return w.add("v", whole, "ff", "with the feed-forward")

    def _x(self, w: Writer, book: Book, e: str, v: str, u: str) -> str:
        """Write the integral's next state."""
        point, how = self.points["integral"], self.features.anti_windup
        ki = book.gain("ki", self.law.ki * self.format.gain, "gain of the integral, a step", point)
        move = w.mul("x_move", ki, e, "what the integral moves by", "integral")
        x = w.add("x_sum", "x", move, "", "integral")
        if self.features.limited and how == "conditional":
            over = w.sub("over", v, u, "what a limit took away")
            x = w.unless("x_on", over, move, "x", x, "not further into a limit", "integral")
        if self.features.limited and how in ("back_calculation", "tracking"):
            x = w.add("x_back", x, self._fed_back(w, book, v, u), "", "integral")
        return self._x_bounded(w, book, x)

    def _fed_back(self, w: Writer, book: Book, v: str, u: str) -> str:
        missing = w.sub("missing", u, v, "minus what a limit took away")
        if self.features.back == 1 and not self._whole:
            return missing
        if self._whole:
            span = self.format.most - self.format.least
            high = book.fixed("span", span, "all of u's range")
            low = book.fixed("minus_span", -span, "minus all of u's range")
            top = w.atmost("missing_top", missing, high)
            missing = w.atleast("missing_in", top, low, "at most a span")
        back = book.gain(
            "back",
            self.features.back,
            "share that is fed back in a sample",
            self.points["integral"],
        )
        return w.mul("x_fed", back, missing, "fed back", "integral")

    def _x_range(self) -> tuple[int, int]:
        """Return the bounds of the integral in steps of u: what u and its other parts leave it."""
        law, f = self.law, self.format
        rest = abs(1 - self.features.r_weight) * abs(law.kp - law.ki / 2) * f.gain * -f.least
        pad = ceil(rest) - f.least
        return f.least - pad, f.most + pad

    def _x_ends(self) -> tuple[int, int]:
        low, high = self._x_range()
        return low << self.points["integral"], high << self.points["integral"]

    def _x_bounded(self, w: Writer, book: Book, x: str) -> str:
        if not self._whole:
            return x
        point = self.points["integral"]
        low, high = self._x_ends()
        most = book.fixed("x_max", high, "upper end of the integral", point)
        least = book.fixed("x_min", low, "lower end of the integral", point)
        return w.atleast("x_new", w.atmost("x_top", x, most), least, "the integral in its range")

    def _track(self, book: Book) -> Routine:
        """Write the states with which the same r and y, without ff, would give u_manual next."""
        w, stores = Writer(), []
        u = bounded(w, book, self.features, "u_manual")
        e = w.sub("e", "r", "y", "error")
        if self.law.ki:
            p, point = self._p(w, book, e), self.points["u"]
            x = u
            if p and point:
                p = w.down("p_u", w.add("p_half", p, "half", "", "u"), point, "in steps of u")
            if p:
                x = w.sub("x_left", u, p, "what is left to the integral")
            if self._whole:
                low, high = self._x_range()
                most = book.fixed("i_max", high, "upper end of the integral in steps of u")
                least = book.fixed("i_min", low, "lower end of the integral in steps of u")
                x = w.atleast("x_in", w.atmost("x_below", x, most), least, "in its range")
            stores.append(("x", self._up(w, book, "x_new", x, "integral")))
        if self.law.kd:
            seen = self._weighted(w, book, e)
            stores.append(("f", self._up(w, book, "f_new", seen, "filter")))
        return finished("track", ("r", "y", "u_manual"), w, stores, u, u, self, returns=False)

    def _reset(self, book: Book) -> Routine:
        w, stores = Writer(), []
        u = bounded(w, book, self.features, "u0")
        if self.law.ki:
            stores.append(("x", self._up(w, book, "x_new", u, "integral")))
        if self.law.kd:
            stores.append(("f", ZERO))
        return finished("reset", ("u0",), w, stores, u, u, self, returns=False)

    def _up(self, w: Writer, book: Book, name: str, value: str, group: str) -> str:
        """Return the value at the binary point of a group."""
        point = self.points[group]
        if not point or (group == "filter" and not self._filtered):
            return value
        one = book.fixed(f"one_{group}", 1 << point, "1", point)
        return w.mul(name, one, value, "at its binary point", group)

    def moved(self, group: str) -> "PidStep | None":
        """Return the same with one binary point a bit lower; None where there is no bit left."""
        points = dict(self.points)
        points[group] -= 1
        points["u"] = min(points["u"], points["integral"])
        return replace(self, points=points) if points[group] >= 0 else None


def finished(
    name: str, inputs: tuple[str, ...], w: Writer, stores: list[tuple[str, str]], v: str, u: str,
    step: "Keeps", *, returns: bool = True,
) -> Routine:  # fmt: skip
    """Return the routine, with the sum that guards what floats store."""
    guard = None
    if not step.format.whole:
        guard = v
        for i, (_, value) in enumerate(s for s in stores if s[1] != ZERO):
            guard = w.add(f"guard_{i + 1}", guard, value, "finite only if all of it is")
    if step.keeps_u:
        stores = [*stores, ("u", u)]
    result = u if returns else None
    return Routine(
        name=name, inputs=inputs, lines=used(w.lines, (result, guard, *(n for _, n in stores))),
        stores=tuple(stores),
        result=result, guard=guard,
    )  # fmt: skip
