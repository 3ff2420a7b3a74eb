"""Partial fractions: sum r/(s - p)^k, brought over one denominator without a rounding.

With s = S/2^h every pole P = p 2^h is a whole (Gaussian) number, and so is every coefficient.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from zoh.errors import SpecError
from zoh.lti import digits
from zoh.lti.digits import Exact
from zoh.lti.given import complex_numbers, paired

_SAME = 1e-9  # of a residue: what a tool's roundings make of two that are conjugate in truth


@dataclass(frozen=True, slots=True, kw_only=True)
class Term:
    """residue/(s - pole)^power, and its conjugate where the pole is complex (above the axis)."""

    residue: complex
    pole: complex
    power: int


def paired_terms(residues: Any, poles: Any) -> list[Term]:
    """Return the terms, real ones and conjugate pairs; the k-th mention of a pole has power k.

    Of two residues that are conjugate but for rounding the mean is taken. Raises SpecError for
    lists of different lengths and for a pole or residue without its conjugate.

    >>> paired_terms([1j, -1j], [-1 + 2j, -1 - 2j])
    [Term(residue=1j, pole=(-1+2j), power=1)]
    """
    roots = paired("poles", poles)
    found: dict[tuple[complex, int], complex] = {}
    for pole, residue in zip(roots, _as_many(residues, len(roots)), strict=True):
        power = 1
        while (pole, power) in found:
            power += 1
        found[pole, power] = residue
    terms = []
    for (pole, power), residue in found.items():
        other = found[pole.conjugate(), power].conjugate()
        if abs(residue - other) > _SAME * abs(residue):
            raise SpecError(
                "residues",
                "must be conjugate where the poles are, and real where they are",
                residue,
                f"give {residue.conjugate()} to {pole.conjugate()}, power {power}",
            )
        if pole.imag >= 0:
            mean = residue / 2 + other / 2  # their sum may be no float
            terms.append(Term(residue=mean, pole=pole, power=power))
    return terms


def _as_many(residues: Any, count: int) -> list[complex]:
    way_out = "give one residue to each pole"
    values = complex_numbers("residues", residues, way_out)
    if len(values) != count:
        bound = f"must be as many as the poles ({count})"
        raise SpecError("residues", bound, len(values), way_out)
    return values


def partial_fractions(terms: Sequence[Term], direct: float) -> tuple[Exact, Exact]:
    """Return (num, den) of direct + the sum of the terms, descending powers, den monic.

    The denominator has every pole as often as it is listed, whatever its residues are.

    >>> num, den = partial_fractions([Term(residue=1j, pole=-1 + 2j, power=1)], 0.0)
    >>> digits.rounded(num), digits.rounded(den)  # j/(s + 1 - 2j) - j/(s + 1 + 2j)
    ((0.0, 0.0, -4.0), (1.0, 2.0, 5.0))
    """
    poles = [p for t in terms for p in {t.pole, t.pole.conjugate()}]
    h = digits.common_shift([x for p in poles for x in (p.real, p.imag)])
    g = digits.common_shift([x for t in terms for x in (t.residue.real, t.residue.imag)])
    g = max(g, digits.common_shift([direct]))
    den = digits.monic(poles, h)
    num = [digits.scaled(direct, g) * c for c in den]
    for term in terms:
        rest = list(poles)
        for _ in range(term.power):
            for p in {term.pole, term.pole.conjugate()}:
                rest.remove(p)
        top = digits.times(_numerator(term, h, g), digits.monic(rest, h))
        for i, c in enumerate(reversed(top), 1):
            num[-i] += c << h * term.power
    return digits.over_powers(num, h, g), digits.over_powers(den, h)


def _numerator(term: Term, h: int, g: int) -> list[int]:
    """Return r, or r (S - P*)^k + r* (S - P)^k, in units of 2^-g."""
    re, im = [digits.scaled(term.residue.real, g)], [digits.scaled(term.residue.imag, g)]
    if not term.pole.imag:
        return re
    a, b = digits.scaled(term.pole.real, h), digits.scaled(term.pole.imag, h)
    for _ in range(term.power):  # times S - a + j b
        turned = [(-a * x - b * y, b * x - a * y) for x, y in zip(re, im, strict=True)]
        re = [x + y for x, y in zip([*re, 0], [0, *(t[0] for t in turned)], strict=True)]
        im = [x + y for x, y in zip([*im, 0], [0, *(t[1] for t in turned)], strict=True)]
    return [2 * x for x in re]
