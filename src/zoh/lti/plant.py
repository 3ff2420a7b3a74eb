"""Plant: a continuous system with dead time and sensor."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from zoh import checks
from zoh.errors import SpecError
from zoh.lti import digits, poly
from zoh.lti.digits import Exact
from zoh.lti.given import check_fraction, checked_state_space, paired
from zoh.lti.partial import paired_terms, partial_fractions
from zoh.lti.poly import ComplexArray, Poly


@dataclass(frozen=True, slots=True, kw_only=True)
class Plant:
    """A continuous plant, sensor * num(s)/den(s) * exp(-s dead_time).

    num, den   coefficients in descending powers of s, shape (m + 1,) and (n + 1,), m <= n
    dead_time  s, 0 or more
    sensor     sensor units per output unit; part of the loop, in this one place

    Shared factors of num and den are kept: a hidden mode is a fact about the machine.
    Raises SpecError for an improper, empty or zero fraction.

    >>> Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180).at(1.0)
    (-0.095249...-0.074380...j)
    """

    num: Poly
    den: Poly
    dead_time: float = 0.0
    sensor: float = 1.0
    exact: tuple[Exact, Exact] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "num", checks.coefficients("num", self.num))
        put(self, "den", checks.coefficients("den", self.den))
        check_fraction(self.num, self.den, "s")
        put(self, "dead_time", checks.not_negative("dead_time", self.dead_time, "seconds, >= 0"))
        put(self, "sensor", checks.number("sensor", self.sensor, "give the sensor gain"))
        if self.sensor == 0:
            raise SpecError("sensor", "must not be 0", self.sensor, "a loop needs a sensor")
        put(self, "exact", (digits.exact(self.num), digits.exact(self.den)))

    @classmethod
    def from_exact(
        cls, num: Exact, den: Exact, *, dead_time: float = 0.0, sensor: float = 1.0
    ) -> "Plant":
        """Return the plant of these exact coefficients; num and den hold their nearest floats.

        num, den  finite Decimals in descending powers of s
        """
        num, den = digits.checked("num", num), digits.checked("den", den)
        made = cls(
            num=digits.rounded(num),
            den=digits.rounded(den),
            dead_time=dead_time,
            sensor=sensor,
        )
        put = object.__setattr__
        put(made, "exact", (num[len(num) - len(made.num) :], den[len(den) - len(made.den) :]))
        return made

    @classmethod
    def parse(cls, text: str, *, dead_time: float = 0.0, sensor: float = 1.0) -> "Plant":
        """Return the plant that a formula in s says, such as ``2.3/(s^2 + 0.7809 s)``.

        >>> Plant.parse("2.3/(s^2 + 0.7809 s)").den
        (1.0, 0.7809, 0.0)
        """
        from zoh.lti.parse import formula

        num, den, delay = formula(text)
        if delay and dead_time:
            raise SpecError(
                "dead_time",
                "must stand in one place",
                dead_time,
                f"the formula already has exp(-{float(delay):g} s)",
            )
        return cls.from_exact(
            digits.exact(num),
            digits.exact(den),
            dead_time=float(delay) or dead_time,
            sensor=sensor,
        )

    @classmethod
    def zpk(
        cls,
        *,
        zeros: Sequence[complex],
        poles: Sequence[complex],
        gain: float,
        dead_time: float = 0.0,
        sensor: float = 1.0,
    ) -> "Plant":
        """Return gain prod(s - zeros)/prod(s - poles); complex ones come in conjugate pairs.

        >>> Plant.zpk(zeros=[], poles=[0, -0.7809], gain=2.3).den
        (1.0, 0.7809, 0.0)
        """
        top = digits.from_roots(paired("zeros", zeros))
        bottom = digits.from_roots(paired("poles", poles))
        k = checks.number("gain", gain)
        with digits.precision(digits.KEPT):
            top = tuple(digits.exact([k])[0] * c for c in top)
        return cls.from_exact(top, bottom, dead_time=dead_time, sensor=sensor)

    @classmethod
    def residues(
        cls,
        *,
        residues: Sequence[complex],
        poles: Sequence[complex],
        direct: float = 0.0,
        dead_time: float = 0.0,
        sensor: float = 1.0,
    ) -> "Plant":
        """Return direct + sum residues_i/(s - poles_i)^k_i, the plant of its partial fractions.

        residues, poles  shape (n,), as scipy.signal.residue prints them: a pole that is listed
        q times stands for the powers k = 1 ... q, in this order; complex ones come in conjugate
        pairs with conjugate residues

        Raises SpecError for lists of different lengths, or a pole or residue without its
        conjugate.

        >>> Plant.residues(residues=[1, -1], poles=[-1, -2]).num  # 1/((s + 1)(s + 2))
        (1.0,)
        >>> Plant.residues(residues=[2, 3], poles=[-1, -1]).num  # 2/(s + 1) + 3/(s + 1)^2
        (2.0, 5.0)
        """
        terms = paired_terms(residues, poles)
        num, den = partial_fractions(terms, checks.number("direct", direct))
        return cls.from_exact(num, den, dead_time=dead_time, sensor=sensor)

    @classmethod
    def ss(
        cls, a: Any, b: Any, c: Any, d: Any = 0.0, *, dead_time: float = 0.0, sensor: float = 1.0
    ) -> "Plant":
        """Return the plant d + c (sI - a)^-1 b of a SISO state space.

        a has shape (n, n), b (n,) or (n, 1), c (n,) or (1, n), d is a number or shape (1, 1).

        >>> Plant.ss([[0, 1], [0, -0.7809]], [0, 2.3], [1, 0]).num
        (2.3,)
        """
        matrix, col, row, direct = checked_state_space(a, b, c, d)
        num, den = digits.state_space(matrix, col, row, direct)
        return cls.from_exact(num, den, dead_time=dead_time, sensor=sensor)

    @overload
    def at(self, wc: float) -> complex: ...
    @overload
    def at(self, wc: npt.ArrayLike) -> ComplexArray: ...
    def at(self, wc: Any) -> Any:
        """Return the complex gain at wc in rad/s, a number or an array; infinite at a pole."""
        w = checks.frequencies("wc", wc)
        size = np.hypot(1.0, w)  # counted in it no power of a high frequency overflows
        x, y = 1j * w / size, 1 / size
        top = poly.homogeneous(poly.padded(self.num, len(self.den)), x, y)
        late = self.sensor * np.exp(-1j * w * self.dead_time)
        value = poly.quotient(top * late, poly.homogeneous(self.den, x, y))
        return complex(value) if w.ndim == 0 else value

    def poles(self) -> ComplexArray:
        """Return the poles in rad/s, shape (n,)."""
        return poly.roots(self.den)

    def zeros(self) -> ComplexArray:
        """Return the zeros in rad/s, shape (m,)."""
        return poly.roots(self.num)
