"""The number format of a plan and its book of constants: what is rounded is rounded here."""

from dataclasses import dataclass, field
from fractions import Fraction
from math import ceil, floor, inf, nextafter

import numpy as np

from zoh.errors import SpecError
from zoh.firmware.lines import ZERO, Coefficient, Number, Routine, Writer, used

IO_BITS = {"q15": 16, "q31": 32}


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """A number format with its units; a float's are 1.

    y_unit, u_unit  what one step of r and y, and of u and ff, is in physical units
    """

    number: Number
    y_unit: Fraction = Fraction(1)
    u_unit: Fraction = Fraction(1)

    @property
    def whole(self) -> bool:
        """Return whether it has whole numbers."""
        return self.number in IO_BITS

    @property
    def word(self) -> int:
        """Return the bits of the words that sums are made in."""
        return 2 * IO_BITS[self.number]

    @property
    def least(self) -> int:
        """Return the least number of r, y, ff and u."""
        return -(1 << IO_BITS[self.number] - 1)

    @property
    def most(self) -> int:
        """Return the largest number of r, y, ff and u."""
        return -self.least - 1

    @property
    def gain(self) -> Fraction:
        """Return what a gain of 1 in physical units is in steps of u per step of y."""
        return self.y_unit / self.u_unit


@dataclass(frozen=True, slots=True, kw_only=True)
class Features:
    """What a controller has beside its law, in physical units; None is left out of the code.

    u_min, u_max     limits of the output
    change           the most that u may change by in a sample
    anti_windup      what an integral does at a limit
    r_weight, d_weight  shares of the reference in the proportional part and in the derivative
    back             the share of u - v that is fed back in a sample, of back_calculation
    """

    u_min: Fraction | None = None
    u_max: Fraction | None = None
    change: Fraction | None = None
    anti_windup: str = "none"
    r_weight: Fraction = Fraction(1)
    d_weight: Fraction = Fraction(1)
    back: Fraction = Fraction(1)

    @property
    def limited(self) -> bool:
        """Return whether u can differ from what the law asks for."""
        return not (self.u_min is self.u_max is self.change is None)


@dataclass(slots=True)
class Book:
    """The constants of one program, each written once under its name."""

    format: Format
    coefficients: dict[str, Coefficient] = field(default_factory=dict)

    def gain(self, name: str, value: Fraction, says: str, point: int = 0) -> str:
        """Write a constant, rounded to the nearest; return its name.

        Raises SpecError where a value that is not 0 is 0 in this format.
        """
        return self.fixed(name, self.nearest(name, value, says, point), says, point)

    def nearest(self, name: str, value: Fraction, says: str, point: int = 0) -> float | int:
        """Return a constant, rounded to the nearest; raise SpecError where it would vanish."""
        rounded = round(value * (1 << point)) if self.format.whole else self._nearest(value)
        if rounded == 0 and value != 0:
            raise SpecError(
                "number",
                f"must hold {name} ({says}), which needs steps of {float(abs(value)):.3g} or finer",
                f"{self.format.number} with steps of {2.0**-point:.3g}",
                "bring u_range nearer to what u needs, or choose a longer number",
            )
        return rounded

    def bound(self, name: str, value: Fraction, says: str, *, up: bool) -> str:
        """Write a limit of u, rounded inwards (a lower limit up); return its name."""
        whole = self.format.whole
        rounded: float | int
        if whole:
            inside = ceil(value / self.format.u_unit) if up else floor(value / self.format.u_unit)
            if (inside > self.format.most) if up else (inside < self.format.least):
                end = float((self.format.most if up else self.format.least) * self.format.u_unit)
                bound = f"must be within the range of u, which ends at {end:.6g}"
                raise SpecError(name, bound, float(value), "give a u_range that holds it")
            rounded = max(self.format.least, min(self.format.most, inside))
        else:
            rounded = self._nearest(value)
            if (Fraction(rounded) < value) if up else (Fraction(rounded) > value):
                rounded = self._next(rounded, up)
        if rounded == 0 and value != 0:
            raise SpecError(
                name, "must not vanish in this format", float(value), "choose a longer number"
            )
        return self.fixed(name, rounded, says)

    def fixed(self, name: str, value: float | int, says: str, point: int = 0) -> str:
        """Write a constant as it is; return its name."""
        made = Coefficient(name=name, value=value, says=says, point=point)
        if self.coefficients.setdefault(name, made) != made:
            raise AssertionError(f"two constants are called {name}")
        return name

    def _nearest(self, value: Fraction) -> float:
        if self.format.number == "f64":
            return float(value)
        with np.errstate(over="ignore"):  # said below
            near = np.float32(float(value))
        # a double that lies half-way between two floats hides to which side the value is
        beside = [np.nextafter(near, np.float32(s)) for s in (-inf, inf)]
        if not np.isfinite(near):
            raise SpecError(
                "number", f"must hold every constant, {float(value):.3g} among them",
                self.format.number, "choose f64",
            )  # fmt: skip
        finite = [x for x in (near, *beside) if np.isfinite(x)]
        return float(min(finite, key=lambda x: abs(Fraction(float(x)) - value)))

    def _next(self, value: float, up: bool) -> float:
        if self.format.number == "f64":
            return nextafter(value, inf if up else -inf)
        return float(np.nextafter(np.float32(value), np.float32(inf if up else -inf)))


def limited(w: Writer, book: Book, features: Features, v: str) -> str:
    """Write the limits of the rate, then those of the output; return what is left of v."""
    if features.change is not None:
        if book.format.whole:
            steps = floor(features.change / book.format.u_unit)
            if steps < 1:
                raise SpecError(
                    "rate",
                    f"must allow a change of one step ({float(book.format.u_unit):.3g}) a sample",
                    f"{float(features.change):.3g}",
                    "choose a longer number or a smaller u_range",
                )
            change = book.fixed("change", min(steps, 2 * book.format.most), "the most u may move")
        else:
            change = book.gain("change", features.change, "the most u may move in a sample")
        v = w.atmost("slow_up", v, w.add("u_above", "u", change), "no faster up")
        v = w.atleast("slow", v, w.sub("u_below", "u", change), "no faster down")
    return bounded(w, book, features, v)


def bounded(w: Writer, book: Book, features: Features, v: str) -> str:
    """Write the limits of the output; return what is left of v.

    An input of the type needs no limit at the type's ends.
    """
    typed = book.format.whole and v in ("u_manual", "u0")
    if features.u_max is not None:
        most = book.bound("u_max", features.u_max, "upper limit of u", up=False)
        if not (typed and book.coefficients[most].value == book.format.most):
            v = w.atmost("u_top", v, most, "not above the upper limit")
    if features.u_min is not None:
        least = book.bound("u_min", features.u_min, "lower limit of u", up=True)
        if features.u_max is not None:
            _apart(book, features)
        if not (typed and book.coefficients[least].value == book.format.least):
            v = w.atleast("u_new", v, least, "not below the lower limit")
    return v


def _apart(book: Book, features: Features) -> None:
    """Raise SpecError where the format leaves nothing between the limits of the output."""
    low, high = (book.coefficients[name].value for name in ("u_min", "u_max"))
    if not low < high:
        bound = f"must be above u_min = {float(features.u_min or 0):.9g} in this format, too"
        way_out = "choose limits farther apart, or a longer number"
        raise SpecError("u_max", bound, float(features.u_max or 0), way_out)


def finished(
    name: str, inputs: tuple[str, ...], w: Writer, stores: list[tuple[str, str]], *,
    v: str, u: str, keeps_u: bool, form: Format,
) -> Routine:  # fmt: skip
    """Return the routine; of floats with the sum that guards what is stored.

    v, u  what was asked for, and what is left of it by the limits: what a step returns
    """
    guard = None
    if not form.whole:
        guard = v
        for i, (_, value) in enumerate(s for s in stores if s[1] != ZERO):
            guard = w.add(f"guard_{i + 1}", guard, value, "finite only if all of it is")
    if keeps_u:
        stores = [*stores, ("u", u)]
    result = u if name == "step" else None
    wanted = (result, guard, *(value for _, value in stores))
    return Routine(
        name=name, inputs=inputs, lines=used(w.lines, wanted), stores=tuple(stores),
        result=result, guard=guard,
    )  # fmt: skip
