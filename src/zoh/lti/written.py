"""Polynomials and fractions as one line of text."""

from collections.abc import Sequence


def fraction(
    num: Sequence[float], den: Sequence[float], variable: str, digits: int | None = None
) -> str:
    """Return num/den as text, to so many significant digits; None writes every digit.

    >>> fraction((2.0, -1.0), (1.0, 0.0, -1.0), "z")
    '(2 z - 1)/(z^2 - 1)'
    >>> fraction((3.0, 0.5), (1.0,), "w")
    '3 w + 0.5'
    """
    top, bottom = polynomial(num, variable, digits), polynomial(den, variable, digits)
    if bottom == "1":
        return top
    return "/".join(f"({text})" if " " in text else text for text in (top, bottom))


def polynomial(a: Sequence[float], variable: str, digits: int | None = None) -> str:
    """Return a polynomial as text, zero terms left out.

    >>> polynomial((1.0, 0.0, -0.1 - 0.2), "z"), polynomial((1.0, 0.0, -0.1 - 0.2), "z", 6)
    ('z^2 - 0.30000000000000004', 'z^2 - 0.3')
    """
    n = len(a) - 1
    text = ""
    for i, c in enumerate(a):
        if c == 0:
            continue
        power = n - i
        size = "" if abs(c) == 1 and power else number(abs(c), digits)
        tail = "" if not power else variable if power == 1 else f"{variable}^{power}"
        joint = (" - " if c < 0 else " + ") if text else ("-" if c < 0 else "")
        text += joint + " ".join(part for part in (size, tail) if part)
    return text or "0"


def number(value: float, digits: int | None = None) -> str:
    """Return a float as text; with None the shortest that reads back as the same float.

    >>> number(2.0), number(0.1 + 0.2), number(0.1 + 0.2, 6)
    ('2', '0.30000000000000004', '0.3')
    """
    if digits is not None:
        return f"{value:.{digits}g}"
    text = repr(float(value))
    return text.removesuffix(".0")
