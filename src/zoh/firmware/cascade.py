"""Second-order sections in series, in powers of z^-1 or in sums (delta), written once for all.

A section with input x and output y is the transposed direct form::

    y = b0 x + s1        s1 <- b1 x - a1 y + s2        s2 <- b2 x - a2 y             cascade
    y = b0 x + s1        s1 <- s1 + (b1 x - a1 y + s2)  s2 <- s2 + (b2 x - a2 y)      delta

What the last section is told is its *limited* output: at a limit its states follow what the
actuator got, which is anti-windup by a deadbeat observer, without a parameter. In whole numbers a
section's sum has a binary point of its own; what its output leaves of the sum goes back into s1,
so that the error has no mean, and no dead band is left where there is an integrator.
Source: A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, ch. 6 (transposed form,
error feedback); K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed., sec. 9.4
(anti-windup by an observer); R. H. Middleton and G. C. Goodwin, Digital Control and Estimation.
"""

from dataclasses import dataclass
from fractions import Fraction

from zoh.firmware.book import Book, bounded, finished, limited
from zoh.firmware.cascade_shape import CascadeShape, in_books, named
from zoh.firmware.lines import ZERO, Program, Routine, Writer
from zoh.firmware.realise import Section


@dataclass(frozen=True, slots=True, kw_only=True)
class CascadeStep(CascadeShape):
    """Sections in series that write their routines."""

    def program(self) -> Program:
        """Return step, track and reset."""
        book = Book(format=self.format)
        for i in range(len(self.sections)):
            self._write_section(book, i)
        step, track, reset = self._step(book), self._track(book), self._reset(book)
        return Program(
            number=self.format.number, states=self.states(),
            coefficients=tuple(book.coefficients.values()), step=step, track=track, reset=reset,
        )  # fmt: skip

    def _write_section(self, book: Book, i: int) -> None:
        """Write the constants of a section."""
        if self.format.whole:
            self._write_whole(book, i)
            return
        for name, c in named(*self.taken(i)):
            if c not in (0, 1):  # what needs no product
                book.gain(f"{name}_{i + 1}", c, f"section {i + 1}: {in_books(name)}")

    def _write_whole(self, book: Book, i: int) -> None:
        """Write them in whole numbers: rounded in d = z - 1, and from there to z exactly.

        At frequencies far below the clock's an error in d is divided by d or by its square; one in
        z is not, and would move the slow poles and the gain at rest by all of it.
        """
        section, point, says = self.sections[i], self.points[f"section{i + 1}"], f"section {i + 1}"
        gain = self.format.gain if i == len(self.sections) - 1 else Fraction(1)
        one = 1 << point
        b, a = (
            [
                Fraction(round(book.nearest(f"{kind}{k}_{i + 1}", scale * c, says, point)), one)
                for k, c in enumerate(part, first)
            ]
            for kind, part, scale, first in (("b", section.b, gain, 0), ("a", section.a, 1, 1))
        )
        rounded = Section(b=(b[0], b[1], b[2]), a=(a[0], a[1]), order=section.order)
        for name, c in named(*((rounded.b, rounded.a) if self.delta else rounded.in_z)):
            if c:
                book.gain(f"{name}_{i + 1}", c, f"{says}: {in_books(name)}", point)

    def _step(self, book: Book) -> Routine:
        w, stores = Writer(), []
        x, v, u = w.sub("e", "r", "y", "error"), "", ""
        last = len(self.sections) - 1
        for i in range(len(self.sections)):
            total, y = self._output(w, book, i, x)
            if i == last:
                v = w.add("v", y, "ff", "with the feed-forward")
                u = limited(w, book, self.features, v)
                y = self._told(w, book, y, v, u)
            elif self.format.whole:
                y = self._inside(w, book, f"y_{i + 1}", y)
            stores += self._next(w, book, i, x, y, total)
            x = y
        return finished(
            "step", ("r", "y", "ff"), w, stores, v=v, u=u, keeps_u=self.keeps_u, form=self.format
        )

    def _output(self, w: Writer, book: Book, i: int, x: str) -> tuple[str, str]:
        """Write a section's sum and its output."""
        name, point = f"section{i + 1}", self.points[f"section{i + 1}"]
        total = f"s1_{i + 1}"
        if (part := self._times(w, book, f"b0_{i + 1}", f"x0_{i + 1}", x, i)) is not None:
            total = w.add(f"sum_{i + 1}", part, total, f"section {i + 1}", name)
        return total, w.down(f"out_{i + 1}", total, point, f"output of section {i + 1}")

    def _times(self, w: Writer, book: Book, constant: str, name: str, x: str, i: int) -> str | None:
        """Write constant x; x itself where it is a 1 that was not written, None where it is 0."""
        if constant in book.coefficients:
            return w.mul(name, constant, x, "", f"section{i + 1}")
        b, a = self.taken(i)
        value = {"b": b, "m": (Fraction(0), *(-c for c in a))}[constant[0]][int(constant[1])]
        return x if value == 1 else None

    def _told(self, w: Writer, book: Book, y: str, v: str, u: str) -> str:
        """Write what the last section is told of its output."""
        if self.features.anti_windup == "none" or not self.features.limited:
            return self._inside(w, book, "y_told", y) if self.format.whole else y
        if self.format.whole:
            return w.sub("told", u, "ff", "what the actuator got of it")
        over = w.sub("lost", u, v, "minus what a limit took away")
        return w.add("told", y, over, "what the actuator got of it")

    def _inside(self, w: Writer, book: Book, name: str, y: str) -> str:
        """Write a section's output within its format."""
        high = book.fixed("most", self.format.most, "largest number of the format")
        low = book.fixed("least", self.format.least, "least number of the format")
        return w.atleast(name, w.atmost(f"{name}_top", y, high), low, "within the format")

    def _next(
        self, w: Writer, book: Book, i: int, x: str, y: str, total: str | None
    ) -> list[tuple[str, str]]:
        """Write a section's next states; return (state, name) of each."""
        n, group, stores = i + 1, f"section{i + 1}", []
        for k in (2, 1):
            state = f"s{k}_{n}"
            if k == 2 and not self.second(i):
                continue
            parts = [
                self._times(w, book, f"b{k}_{n}", f"x{k}_{n}", x, i),
                self._times(w, book, f"m{k}_{n}", f"y{k}_{n}", y, i),
                f"s2_{n}" if k == 1 and self.second(i) else None,
                self._left(w, n, total) if k == 1 and self.format.whole and total else None,
                state if self.delta else None,
            ]
            made = self._sum(w, f"{state}_new", parts, group)
            stores.append((state, self._kept_in(w, book, i, k, made)))
        return stores[::-1]

    def _kept_in(self, w: Writer, book: Book, i: int, k: int, value: str) -> str:
        """Write a sum of the delta form within the range that it has at rest, and half as much.

        A sum adds for ever, so that only a limit keeps it in its word; one in powers of z^-1
        forgets, and is kept by what it adds.
        """
        if not (self.delta and self.format.whole):
            return value
        high, point = self.most(i, k), self.points[f"section{i + 1}"]
        most = book.fixed(f"s{k}_{i + 1}_max", high, f"upper end of sum {k}", point)
        least = book.fixed(f"s{k}_{i + 1}_min", -high, f"lower end of sum {k}", point)
        name, group = f"s{k}_{i + 1}", f"section{i + 1}"
        top = w.atmost(f"{name}_top", value, most, "", group)
        return w.atleast(f"{name}_in", top, least, "the sum in its range", group)

    def _left(self, w: Writer, n: int, total: str) -> str | None:
        """Write what the output leaves of a section's sum."""
        point = self.points[f"section{n}"]
        if self.delta or not point:  # in the delta form the sum itself is the state that is kept
            return None
        return w.low(f"left_{n}", total, point, "what rounding took, given back")

    def _sum(self, w: Writer, name: str, parts: list[str | None], group: str) -> str:
        there = [p for p in parts if p is not None]
        total = there[0] if there else ZERO
        for j, part in enumerate(there[1:], 1):
            here = name if j == len(there) - 1 else f"{name}_{j}"
            total = w.add(here, total, part, "", group)
        return total

    def _track(self, book: Book) -> Routine:
        """Write the states with which the same r, y and ff would give u_manual next."""
        w, stores = Writer(), []
        u = bounded(w, book, self.features, "u_manual")
        x = w.sub("e", "r", "y", "error")
        for i in range(len(self.sections) - 1):
            y = self._settled(w, book, i, x)
            stores += self._held(w, book, i, x, y)
            x = y
        law = w.sub("law", u, "ff", "what the sections have to give")
        stores += self._held(w, book, len(self.sections) - 1, x, law)
        return finished(
            "track", ("r", "y", "ff", "u_manual"), w, stores, v=u, u=u, keeps_u=self.keeps_u,
            form=self.format,
        )  # fmt: skip

    def _settled(self, w: Writer, book: Book, i: int, x: str) -> str:
        """Write a section's output at rest under x."""
        point = self.points[f"section{i + 1}"]
        name = book.gain(f"rest_{i + 1}", self.at_rest(i), f"section {i + 1}: gain at rest", point)
        y = w.mul(f"rest_of_{i + 1}", name, x, "", f"section{i + 1}")
        y = w.down(f"at_rest_{i + 1}", y, point, f"output of section {i + 1} at rest")
        return self._inside(w, book, f"y_{i + 1}", y) if self.format.whole else y

    def _held(self, w: Writer, book: Book, i: int, x: str, y: str) -> list[tuple[str, str]]:
        """Write the states with which x gives y: s1 = y - b0 x, s2 as the step writes it."""
        n, group, point = i + 1, f"section{i + 1}", self.points[f"section{i + 1}"]
        at_point = y
        if point:
            one = book.fixed(f"one_{n}", 1 << point, "1", point)
            at_point = w.mul(f"y_at_point_{n}", one, y, "at its binary point", group)
        first = at_point
        if (part := self._times(w, book, f"b0_{n}", f"x0_{n}", x, i)) is not None:
            first = w.sub(f"s1_{n}_new", at_point, part, "", group)
        stores = [(f"s1_{n}", first)]
        if self.second(i):
            stores.append((f"s2_{n}", self._second_held(w, book, i, x, y)))
        return stores

    def _second_held(self, w: Writer, book: Book, i: int, x: str, y: str) -> str:
        """Write s2: b2 x - a2 y, or what keeps s1 at rest in the delta form, a1 y - b1 x."""
        n, group, k = i + 1, f"section{i + 1}", 1 if self.delta else 2
        on_x = self._times(w, book, f"b{k}_{n}", f"x{k}_{n}", x, i)
        on_y = self._times(w, book, f"m{k}_{n}", f"y{k}_{n}", y, i)
        total = self._sum(w, f"s2_{n}_new", [on_x, on_y], group)
        if not self.delta or total == ZERO:
            return total
        return w.neg(f"s2_{n}_held", total, "holds the other sum", group)

    def _reset(self, book: Book) -> Routine:
        """Write the states at rest with output u0 and no error."""
        w, stores = Writer(), []
        u = bounded(w, book, self.features, "u0")
        for i in range(len(self.sections)):
            names = [f"s{k}_{i + 1}" for k in (1, 2) if k == 1 or self.second(i)]
            stores += [(name, ZERO) for name in names]
        last = len(self.sections)
        point = self.points[f"section{last}"]
        s1 = u
        if point:
            one = book.fixed(f"one_{last}", 1 << point, "1", point)
            s1 = w.mul(f"y_at_point_{last}", one, u, "at its binary point", f"section{last}")
        made = {f"s1_{last}": s1}
        if self.second(last - 1):
            made[f"s2_{last}"] = self._second_alone(w, book, last - 1, u)
        stores = [(name, made.get(name, value)) for name, value in stores]
        return finished(
            "reset", ("u0",), w, stores, v=u, u=u, keeps_u=self.keeps_u, form=self.format
        )

    def _second_alone(self, w: Writer, book: Book, i: int, u: str) -> str:
        n, group, k = i + 1, f"section{i + 1}", 1 if self.delta else 2
        on_y = self._times(w, book, f"m{k}_{n}", f"y{k}_{n}", u, i)
        if on_y is None or not self.delta:
            return on_y or ZERO
        return w.neg(f"s2_{n}_held", on_y, "holds the other sum", group)
