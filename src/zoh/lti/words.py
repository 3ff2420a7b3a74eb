"""The words of a formula in s: numbers, names, signs, and where each stands."""

import re
from dataclasses import dataclass

from zoh.errors import SpecError

_WORD = re.compile(
    r"(?P<number>(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[A-Za-z_]+)"
    r"|(?P<sign>\*\*|[-+*/^()])"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Word:
    """One word.

    kind        "number", "name", "sign", or "end" after the last
    text        the word itself
    start, end  where it stands, in characters from the beginning
    """

    kind: str
    text: str
    start: int
    end: int


def words(text: str, name: str) -> list[Word]:
    """Return the words of ``text``, the end among them; ``name`` is what an error calls it.

    >>> [word.text for word in words("2.3/(s^2)", "model")]
    ['2.3', '/', '(', 's', '^', '2', ')', '']
    """
    found, at = [], 0
    while at < len(text):
        if text[at] in " \t\r\n":
            at += 1
            continue
        match = _WORD.match(text, at)
        if match is None:
            allowed = "must have only numbers, s, exp, + - * / ^ and parentheses"
            here = f"(position {at + 1} has {text[at]!a})"
            raise SpecError(name, f"{allowed} {here}", text, "remove or replace that character")
        kind = match.lastgroup or ""
        found.append(Word(kind=kind, text=match.group(), start=at, end=match.end()))
        at = match.end()
    return [*found, Word(kind="end", text="", start=at, end=at)]
