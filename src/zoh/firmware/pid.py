"""The step of a controller in parallel form, written once for floats and for whole numbers.

With d a filtered difference, x the integral and f a filter's state::

    d = (c r - y) - f        v = kr r - kp y + kd d + x + ff        u = v, limited
    f <- f + alpha d         x <- x + ki (r - y), but not further into a limit

kp is the proportional gain and half a step of the integral, whose trapezoid is so kept: with
b = 1, kr r - kp y = kp (r - y). A lead-lag has two filters. In whole numbers sums have a binary
point ("u"), integral and filters finer ones of their own, and what a state adds is never rounded:
there is no dead band in them.
Source: K. J. Astrom and T. Hagglund, Advanced PID Control, sec. 3.4 to 3.6 (set-point weights,
anti-windup), ch. 13 (implementation: word length, bumpless transfer).
"""

from dataclasses import dataclass

from zoh.firmware.book import Book, bounded, finished, limited
from zoh.firmware.lines import ZERO, Program, Routine, Writer
from zoh.firmware.pid_shape import FED_BACK, PidShape
from zoh.firmware.realise import Filter

_STEP, _TRACK, _RESET = ("r", "y", "ff"), ("r", "y", "ff", "u_manual"), ("u0",)


@dataclass(frozen=True, slots=True, kw_only=True)
class PidStep(PidShape):
    """A law in parallel form that writes its routines."""

    def program(self) -> Program:
        """Return step, track and reset."""
        book = Book(format=self.format)
        step, track, reset = self._step(book), self._track(book), self._reset(book)
        return Program(
            number=self.format.number, states=self.states(),
            coefficients=tuple(book.coefficients.values()), step=step, track=track, reset=reset,
        )  # fmt: skip

    def _step(self, book: Book) -> Routine:
        w, stores = Writer(), []
        e = w.sub("e", "r", "y", "error")
        parts = [p] if (p := self._p(w, book, e)) else []
        seen = self._weighted(w, book, e)
        for tail, part in self.filters:
            d, states = self._filter(w, book, seen, tail, part)
            parts.append(d)
            stores += states
        if self.law.ki:
            point = self.points["integral"] - self.points["u"]
            parts.append(w.down("i_part", "x", point, "integral part", "u"))
        v = self._sum(w, book, parts)
        u = limited(w, book, self.features, v)
        if self.law.ki:
            stores = [*self._x(w, book, e, v, u), *stores]
        return finished("step", _STEP, w, stores, v=v, u=u, keeps_u=self.keeps_u, form=self.format)

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
        p_y = w.mul("p_y", kp, "y", "proportional part of y", "u")
        if not on_r:
            return w.neg("p", p_y, "proportional part", "u")
        kr = book.gain("kr", on_r * unit, "the same on the reference", point)
        p_r = w.mul("p_r", kr, "r", "proportional part of r", "u")
        return w.sub("p", p_r, p_y, "proportional part", "u")

    def _weighted(self, w: Writer, book: Book, e: str) -> str:
        """Write what the filters see."""
        c = self.features.d_weight
        if c == 1 or not self.filters:
            return e
        if c == 0:
            return "y"
        point = self.format.word // 2 - 2 if self.whole else 0
        name = book.gain("c", c, "share of the reference in the derivative", point)
        share = w.mul("r_c", name, "r")
        return w.sub("e_c", w.down("r_share", share, point), "y", "what the derivative sees")

    def _filter(
        self, w: Writer, book: Book, seen: str, tail: str, part: Filter
    ) -> tuple[str, list[tuple[str, str]]]:
        """Write a filtered difference; return its share in u and the filter's next states."""
        f, group = f"f{tail}", f"filter{tail}"
        point = self.points[group] if part.alpha != 1 else 0
        now = w.down(f"f_now{tail}", f, point, "the filter's output", group)
        a, b = (now, seen) if self.on_y else (seen, now)
        d = w.sub(f"d{tail}", a, b, "filtered difference")
        gain = part.kd * self.format.gain
        kd = book.gain(f"kd{tail}", gain, "gain of the filtered difference", self.points["u"])
        share = w.mul(f"d_part{tail}", kd, d, "derivative part", "u")
        if part.alpha == 1:
            return share, [(f, seen)]
        finer = self.alpha_finer(tail, part)
        alpha = book.gain(f"alpha{tail}", part.alpha, "1 - the filter's pole", point + finer)
        gains = f"alpha{tail}" if finer else group
        move = w.mul(f"f_move{tail}", alpha, d, "what the filter moves by", gains)
        move, rest = _carried(w, "f", tail, move, finer, gains)
        written = w.sub if self.on_y else w.add
        return share, [(f, written(f"f_new{tail}", f, move, "the filter moves", group)), *rest]

    def _sum(self, w: Writer, book: Book, parts: list[str]) -> str:
        total, point = parts[0], self.points["u"]
        for i, part in enumerate(parts[1:]):
            total = w.add(f"sum_{i + 1}", total, part, "", "u")
        if point:
            half = book.fixed("half", 1 << point - 1, "rounds the sum to the nearest", point)
            total = w.add("sum", total, half, "", "u")
        whole = w.down("law", total, point, "what the law asks for")
        return w.add("v", whole, "ff", "with the feed-forward")

    def _x(self, w: Writer, book: Book, e: str, v: str, u: str) -> list[tuple[str, str]]:
        """Write the integral's next state, and what waits for it."""
        finer, how = self.ki_finer, self.features.anti_windup
        point, group = self.points["integral"] + finer, "ki" if finer else "integral"
        ki = book.gain("ki", self.law.ki * self.format.gain, "gain of the integral, a step", point)
        move = w.mul("x_move", ki, e, "what the integral moves by", group)
        whole, rest = _carried(w, "x", "", move, finer, group)
        x = w.add("x_sum", "x", whole, "", "integral")
        if self.features.limited and how == "conditional":
            over = w.sub("over", v, u, "what a limit took away")
            x = w.unless("x_on", over, move, "x", x, "not further into a limit", "integral")
        if self.features.limited and how in FED_BACK:
            x = w.add("x_back", x, self._fed_back(w, book, v, u), "", "integral")
        return [("x", self._x_bounded(w, book, x)), *rest]

    def _fed_back(self, w: Writer, book: Book, v: str, u: str) -> str:
        missing = w.sub("missing", u, v, "minus what a limit took away")
        if self.features.back == 1 and not self.whole:
            return missing
        coarser = self.back_coarser
        point = self.points["integral"] + coarser
        back = book.gain("back", self.features.back, "share that is fed back in a sample", point)
        missing = w.down("missing_of", missing, coarser, "so that the share has digits")
        return w.mul("x_fed", back, missing, "fed back", "integral")

    def _x_bounded(self, w: Writer, book: Book, x: str) -> str:
        if not self.whole:
            return x
        point = self.points["integral"]
        low, high = self.x_ends()
        most = book.fixed("x_max", high, "upper end of the integral", point)
        least = book.fixed("x_min", low, "lower end of the integral", point)
        return w.atleast("x_new", w.atmost("x_top", x, most), least, "the integral in its range")

    def _track(self, book: Book) -> Routine:
        """Write the states with which the same r, y and ff would give u_manual next."""
        w, stores = Writer(), []
        u = bounded(w, book, self.features, "u_manual")
        e = w.sub("e", "r", "y", "error")
        if self.law.ki:
            x = self._left(w, self._p(w, book, e), u)
            stores.append(("x", self._up(w, book, "x_new", x, "integral")))
            stores += [("x_rest", ZERO)] if self.ki_finer else []
        seen = self._weighted(w, book, e)
        for tail, part in self.filters:
            f = seen
            if part.alpha != 1:
                f = self._up(w, book, f"f_new{tail}", seen, f"filter{tail}")
            stores.append((f"f{tail}", f))
            stores += [(f"f_rest{tail}", ZERO)] if self.alpha_finer(tail, part) else []
        return finished(
            "track", _TRACK, w, stores, v=u, u=u, keeps_u=self.keeps_u, form=self.format
        )

    def _left(self, w: Writer, p: str | None, u: str) -> str:
        """Write what the proportional part leaves of u to the integral, in steps of u."""
        if p and self.points["u"]:
            p = w.down("p_u", w.add("p_half", p, "half", "", "u"), self.points["u"], "in steps")
        law = w.sub("law", u, "ff", "what the law has to give")
        return w.sub("x_left", law, p, "what is left to the integral") if p else law

    def _reset(self, book: Book) -> Routine:
        w, stores = Writer(), []
        u = bounded(w, book, self.features, "u0")
        if self.law.ki:
            stores.append(("x", self._up(w, book, "x_new", u, "integral")))
            stores += [("x_rest", ZERO)] if self.ki_finer else []
        for tail, part in self.filters:
            stores.append((f"f{tail}", ZERO))
            stores += [(f"f_rest{tail}", ZERO)] if self.alpha_finer(tail, part) else []
        return finished(
            "reset", _RESET, w, stores, v=u, u=u, keeps_u=self.keeps_u, form=self.format
        )

    def _up(self, w: Writer, book: Book, name: str, value: str, group: str) -> str:
        """Return the value at the binary point of a group."""
        if not (point := self.points[group]):
            return value
        one = book.fixed(f"one_{group}", 1 << point, "1", point)
        return w.mul(name, one, value, "at its binary point", group)


def _carried(
    w: Writer, state: str, tail: str, move: str, finer: int, group: str
) -> tuple[str, list[tuple[str, str]]]:
    """Write what a state can take of a finer move; return it, and the rest that waits."""
    if not finer:
        return move, []
    rest = f"{state}_rest{tail}"
    fine = w.add(f"{state}_fine{tail}", rest, move, "with what has waited", group)
    carry = w.down(f"{state}_carry{tail}", fine, finer, "what can be taken", group)
    return carry, [(rest, w.low(f"{state}_waits{tail}", fine, finer, "what cannot"))]
