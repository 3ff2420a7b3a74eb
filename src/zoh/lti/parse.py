"""Formulas in s, such as "2.3/(s^2 + 0.7809 s)", read exactly and without eval.

::

    sum      = product {("+" | "-") product}
    product  = signed {("*" | "/") signed | power}      the last: an implied multiplication
    signed   = {"+" | "-"} power
    power    = atom [("^" | "**") whole number]
    atom     = number | "s" | "(" sum ")" | "exp" "(" sum ")"

A multiplication may be implied before s, exp and "(". After a division it may not: "1/2s" is
(1/2)*s to a computer and 1/(2*s) to many an engineer, so it is refused with both ways to write
it, because a silent guess would be a wrong number. A sign binds less than a power: -s^2 is
-(s^2). exp() is a delay: it takes -T*s with T >= 0 and is a factor of the whole.
"""

from collections.abc import Callable
from fractions import Fraction

from zoh import checks
from zoh.errors import SpecError
from zoh.lti.rational import Coefficients, Rational, Unreadable
from zoh.lti.words import Word, words

LONGEST = 2000  # characters
DEEPEST = 40  # parentheses and signs inside each other
LARGEST_POWER = 50
LARGEST_EXPONENT = 330  # of a decimal number; a 64-bit float ends at 308

_HINTS = {
    "S": "write a small s",
    "z": "a plant is written in s; give a sampled system by its coefficients",
    "e": "write exp(-T*s) for a delay",
    "j": "complex numbers go into zeros and poles",
    "i": "complex numbers go into zeros and poles",
}


def formula(text: str, name: str = "model") -> tuple[Coefficients, Coefficients, Fraction]:
    """Return (num, den, dead time in s) of a formula in s: exact, in descending powers.

    Nothing that the formula writes both above and below the line is cancelled. ``name`` is what
    an error calls the formula.

    >>> num, den, dead_time = formula("2.3 exp(-0.05 s)/(s^2 + 0.7809 s)")
    >>> [float(c) for c in num], [float(c) for c in den], dead_time
    ([2.3], [1.0, 0.7809, 0.0], Fraction(1, 20))
    >>> formula("1/2s")
    Traceback (most recent call last):
    zoh.errors.SpecError: model must not imply a multiplication after a division (position 4),
    got '1/2s': write (1/2)*s or 1/(2*s)
    """
    value = _Parser(text, name).whole()
    for c in (*value.num, *value.den):
        _as_float(c, text, name)
    return value.num, value.den, value.delay or Fraction(0)


def quotient(text_or_number: object, name: str) -> float:
    """Return a number that may be written as a quotient in quotes.

    >>> quotient("12/180", "sensor.gain")
    0.06666666666666667
    """
    if not isinstance(text_or_number, str):
        return checks.number(name, text_or_number, 'give a number, or a quotient such as "12/180"')
    value = _Parser(text_or_number, name).whole()
    if not value.is_number:
        raise SpecError(name, "must be a plain number", text_or_number, 'such as 0.5 or "12/180"')
    return _as_float(value.num[0], text_or_number, name)


def _as_float(c: Fraction, text: str, name: str) -> float:
    try:
        nearest = float(c)
    except OverflowError:
        nearest = 0.0
    if nearest == 0 and c:
        way_out = "use other units, for instance ms instead of s"
        raise SpecError(name, "must have coefficients that fit a 64-bit float", text, way_out)
    return nearest


class _Parser:
    """Recursive descent: one method for each line of the grammar."""

    def __init__(self, text: str, name: str) -> None:
        self.name = name
        self.text = self._checked(text)
        self.depth = 0
        self.index = 0
        self.words = words(self.text, name)

    def whole(self) -> Rational:
        """Return the value of the whole text."""
        if self.here.kind == "end":
            raise SpecError(
                self.name, "must not be empty", self.text, "write a formula or a number"
            )
        value = self.sum()
        if self.here.text == ")":
            raise self.refused("must have a '(' for every ')'", "remove it or open it earlier")
        if self.here.kind != "end":
            raise self.refused(f"must have an operator before {self.here.text!r}", "add + - * / ^")
        return value

    def sum(self) -> Rational:
        """Return sum = product {("+" | "-") product}."""
        value = self.product()
        while self.here.text in ("+", "-"):
            operator = self.taken()
            other, sign = self.product(), 1 if operator.text == "+" else -1
            value = self.done(value.plus, other, sign, at=operator)
        return value

    def product(self) -> Rational:
        """Return product = signed {("*" | "/") signed | power}."""
        start = self.here.start
        value = self.signed()
        slash: Word | None = None
        while True:
            operator = self.here
            if operator.text in ("*", "/"):
                self.index += 1
                divides = operator.text == "/"
                slash = operator if divides else None
                other = self.signed()
                value = self.done(value.over if divides else value.times, other, at=operator)
            elif operator.kind == "name" or operator.text == "(":
                if slash is not None:
                    raise self.ambiguous(start, slash)
                value = self.done(value.times, self.power(), at=operator)
            else:
                return value

    def signed(self) -> Rational:
        """Return signed = {"+" | "-"} power."""
        negative = False
        while self.here.text in ("+", "-"):
            negative ^= self.taken().text == "-"
        value = self.power()
        return value.times(Rational(num=(Fraction(-1),))) if negative else value

    def power(self) -> Rational:
        """Return power = atom [("^" | "**") whole number]."""
        base = self.atom()
        if self.here.text not in ("^", "**"):
            return base
        operator = self.taken()
        exponent = self.exponent()
        if self.here.text in ("^", "**"):
            raise self.refused("must not raise a power to a power without parentheses", "add them")
        return self.done(base.power, exponent, at=operator)

    def exponent(self) -> int:
        """Return a whole number, signed, in parentheses or not."""
        closes = self.here.text == "("
        self.index += closes
        negative = self.here.text == "-"
        self.index += self.here.text in ("+", "-")
        word = self.here
        if word.kind != "number" or not word.text.isdigit():
            raise self.refused("must have a whole number as the exponent", "such as s^2 or s^-1")
        if len(word.text) > 9 or int(word.text) > LARGEST_POWER:
            raise self.refused(f"must have exponents of {LARGEST_POWER} or less", "lower it")
        self.index += 1
        if closes:
            self.close()
        return -int(word.text) if negative else int(word.text)

    def atom(self) -> Rational:
        """Return atom = number | "s" | "(" sum ")" | "exp" "(" sum ")"."""
        word = self.here
        if word.kind == "number":
            return Rational(num=(self.number(),))
        if word.text == "s":
            self.index += 1
            return Rational(num=(Fraction(1), Fraction(0)))
        if word.text == "(":
            return self.group()
        if word.text == "exp":
            self.index += 1
            if self.here.text != "(":
                raise self.refused("must have a '(' after exp", "write exp(-0.05*s)")
            return self.done(self.group().as_delay, at=word)
        if word.kind == "name":
            hint = _HINTS.get(word.text, "put the value of a constant in its place")
            raise self.refused(f"must have only numbers, s and exp, not {word.text!r}", hint)
        found = "it ends" if word.kind == "end" else f"there is {word.text!r}"
        raise self.refused(f"must have a number, s, exp or '(' where {found}", "complete it")

    def number(self) -> Fraction:
        """Return the next word as the exact decimal that it is."""
        word = self.here
        mantissa, _, exponent = word.text.lower().partition("e")
        if len(exponent) > 6 or abs(int(exponent or "0")) > LARGEST_EXPONENT:
            raise self.refused(f"must fit a 64-bit float, which {word.text} does not", "rescale it")
        self.index += 1
        return Fraction(mantissa) * Fraction(10) ** int(exponent or "0")

    def group(self) -> Rational:
        """Return what stands between "(" and ")"."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise self.refused(f"must have {DEEPEST} nested parentheses or fewer", "simplify it")
        self.index += 1
        value = self.sum()
        self.close()
        self.depth -= 1
        return value

    def close(self) -> None:
        """Step over a ")"."""
        if self.here.kind == "end":
            raise self.refused("must have a ')' for every '('", "close it")
        if self.here.text != ")":
            raise self.refused(f"must have an operator or ')' before {self.here.text!r}", "add it")
        self.index += 1

    @property
    def here(self) -> Word:
        """The next word."""
        return self.words[self.index]

    def taken(self) -> Word:
        """Return the next word and step over it."""
        self.index += 1
        return self.words[self.index - 1]

    def done(
        self, operation: Callable[..., Rational], *operands: Rational | int, at: Word
    ) -> Rational:
        """Return the operation's value; say where in the text it has none."""
        try:
            return operation(*operands)
        except Unreadable as e:
            raise self.refused(e.bound, e.way_out, at) from None

    def ambiguous(self, start: int, slash: Word) -> SpecError:
        """Return the refusal of an implied multiplication after a division, with both readings."""
        factor = self.here
        divided = self.text[start : slash.start].strip()
        divisor = self.text[slash.end : factor.start].strip()
        self.power()  # a mistake inside the factor is reported first
        times = self.text[factor.start : self.words[self.index - 1].end]
        both = f"write ({divided}/{divisor})*{times} or {divided}/({divisor}*{times})"
        if len(both) > 120:
            both = "put parentheses around the divisor, or around the quotient"
        bound = "must not imply a multiplication after a division"
        return self.refused(bound, both, factor)

    def refused(self, bound: str, way_out: str, at: Word | None = None) -> SpecError:
        """Return the error of this place."""
        place = (at or self.here).start + 1
        return SpecError(self.name, f"{bound} (position {place})", self.text, way_out)

    def _checked(self, text: object) -> str:
        if not isinstance(text, str):
            raise SpecError(self.name, "must be a formula in quotes", text, 'write "1/(s + 1)"')
        if len(text) > LONGEST:
            raise SpecError(
                self.name,
                f"must have {LONGEST} characters or fewer (it has {len(text)})",
                text,
                "give num and den as lists instead",
            )
        return text
