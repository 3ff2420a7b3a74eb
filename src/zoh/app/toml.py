"""TOML with its literals kept, and tables that answer with the full name of a key."""

import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from difflib import get_close_matches
from re import search
from typing import Any

from zoh import checks
from zoh.errors import SpecError

LONGEST = 1_000_000  # characters; a project file has a few thousand


class Literal(float):
    """A float that remembers how it was written, so that the printed digits are known."""

    text: str

    def __new__(cls, text: str) -> "Literal":
        """Return the float of a TOML literal such as ``1_000.50``."""
        made = super().__new__(cls, text)
        made.text = text.replace("_", "")
        return made

    @property
    def half_a_digit(self) -> Decimal:
        """Half a unit of the last digit that was written.

        >>> Literal("14.30").half_a_digit, Literal("40").half_a_digit
        (Decimal('0.005'), Decimal('0.5'))
        """
        return Decimal(5).scaleb(int(Decimal(self.text).as_tuple().exponent) - 1)


class _Missing:
    """What an error shows for a key that is not there."""

    def __repr__(self) -> str:
        return "nothing"


def tables(text: str) -> "Section":
    """Return the top table of a TOML text."""
    if not isinstance(text, str):
        raise SpecError("file", "must be a text", text, "decode it from UTF-8 first")
    if len(text) > LONGEST:
        raise SpecError("file", f"must have {LONGEST} characters or fewer", len(text), "shorten it")
    try:
        return Section(path="", data=tomllib.loads(text, parse_float=Literal))
    except RecursionError:
        raise SpecError("file", "must not nest so deeply", "TOML", "flatten it") from None
    except ValueError as e:  # TOMLDecodeError, and whole numbers of thousands of digits
        raise SpecError("file", "must be TOML", _line_of(text, str(e)), str(e)) from None


def _line_of(text: str, message: str) -> str:
    """Return the line that tomllib complains about; the last one where it names none."""
    lines = text.splitlines() or [""]
    found = search(r"at line ([0-9]+)", message)
    return lines[min(int(found[1]), len(lines)) - 1 if found else -1]


@contextmanager
def within(path: str) -> Iterator[None]:
    """Put ``path`` before the argument of a SpecError from inside."""
    try:
        yield
    except SpecError as e:
        raise SpecError(f"{path}{e.argument}", e.bound, e.value, e.way_out) from None


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """One table of the file; ``path`` stands before every key in a message."""

    path: str
    data: Mapping[str, Any]

    def only(self, known: Iterable[str]) -> None:
        """Raise SpecError for a key that nobody knows, with the nearest that somebody does."""
        names = list(known)
        for key in self.data:
            if key not in names:
                near = get_close_matches(key, names, n=1, cutoff=0.5)  # pm is near pm_deg
                way_out = f"did you mean {near[0]}?" if near else f"known are {', '.join(names)}"
                bound = "must be a key that zoh knows"
                raise SpecError(f"{self.path}{key}", bound, self.data[key], way_out)

    def missing(self, key: str, way_out: str) -> SpecError:
        """Return the error for a key that has to be there."""
        return SpecError(f"{self.path}{key}", "must be given", _Missing(), way_out)

    def section(self, key: str) -> "Section":
        """Return a table inside this one, empty where there is none."""
        value = self.data.get(key, {})
        if not isinstance(value, dict):
            name = f"{self.path}{key}"
            raise SpecError(name, "must be a table", value, f"write [{name}]")
        return Section(path=f"{self.path}{key}.", data=value)

    def number(self, key: str) -> Literal | None:
        """Return a finite number with its digits, None where there is none."""
        if key not in self.data:
            return None
        value = self.data[key]
        checks.number(f"{self.path}{key}", value)
        return value if isinstance(value, Literal) else Literal(repr(value))

    def text(self, key: str) -> str | None:
        """Return a short text without control characters, None where there is none."""
        value = self.data.get(key)
        if value is None:
            return None
        name, way_out = f"{self.path}{key}", "give a short text in quotes"
        if not isinstance(value, str):
            raise SpecError(name, "must be a text", value, way_out)
        if not 0 < len(value) <= 60 or not value.isprintable() or not value.strip():
            raise SpecError(name, "must have 1 to 60 printable characters", value, way_out)
        return value

    def numbers(self, key: str) -> Sequence[float]:
        """Return a list of finite numbers."""
        value, name = self.data.get(key), f"{self.path}{key}"
        if not isinstance(value, list):
            raise SpecError(name, "must be a list of numbers", value, "such as [1, 0.5, 0]")
        return [checks.number(f"{name}[{i}]", x) for i, x in enumerate(value)]
