"""Proofs that no crossing was missed and no peak is higher than was found.

Descartes' rule bounds the number of positive roots of a polynomial from above, Sturm's chain
counts them; a peak is proved by a polynomial without positive roots, |D + N|^2 - m^2 |D|^2 for
a modulus margin just below m. All of it in whole numbers. Where a delay leaves no polynomial,
``discs`` proves the same between the points of a grid.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from zoh.analysis.loop import Loop
from zoh.analysis.results import Certificate, Proof
from zoh.analysis.squares import ON_DEN, ON_NUM, Below, Squares
from zoh.lti import whole
from zoh.lti.whole import Whole

PEAK_TOL = 1e-9  # relative; what is proved of a peak is that no point is higher by more than this


@dataclass(frozen=True, slots=True, kw_only=True)
class Peak:
    """The least |D + N|/|below|, and where it is in v."""

    v: float
    least: float
    below: Below


@dataclass(frozen=True, slots=True, kw_only=True)
class Drops:
    """How often |T| passes a level."""

    level: float
    found: int


def proved(
    loop: Loop, squares: Squares, unities: Sequence[float], turns: Sequence[float],
    peaks: Sequence[Peak], drops: Drops,
) -> Certificate:  # fmt: skip
    """Return the proofs for what was found: crossings, peaks, passages of |T|."""
    gain = counted(squares.gain, len(unities))
    if not squares.whole:
        unproved = Proof(holds=False, method="none", detail="a delay leaves no polynomial")
        return Certificate(
            gain_crossings=gain, phase_crossings=unproved, modulus_margin=unproved,
            mt=unproved, disk_margin=unproved, bandwidth=unproved,
        )  # fmt: skip
    modulus, complementary, disk = (_least(squares, peak) for peak in peaks)
    return Certificate(
        gain_crossings=gain,
        phase_crossings=counted(squares.turn, len(turns)),
        modulus_margin=modulus,
        mt=complementary,
        disk_margin=disk,
        bandwidth=_passed(squares, drops),
    )


def counted(a: Whole, found: int) -> Proof:
    """Return whether a has as many positive roots of odd multiplicity as were found.

    >>> counted((1, -3, 2), 2).method, counted((1, -3, 2), 1).holds
    ('Descartes', False)
    """
    most = whole.variations(a)
    if most == found:
        return Proof(holds=True, method="Descartes", detail=f"{most} sign changes, {found} found")
    number = whole.crossings(a)
    detail = f"{number} sign changes on the axis, {found} found"
    return Proof(holds=number == found, method="Sturm", detail=detail)


def _least(squares: Squares, peak: Peak) -> Proof:
    """Return whether the ratio is nowhere below its least value found, but for PEAK_TOL."""
    if peak.least in (0.0, inf):  # nothing is below 0; inf: there is nothing to measure against
        return Proof(holds=peak.least == 0.0, method="bound", detail="0 is the least there is")
    level, unit = (peak.least**2 * (1 - 2 * PEAK_TOL)).as_integer_ratio()
    above = [unit * c for c in squares.closed]
    method = whole.positive(whole.plus(above, squares.below(peak.below), -level), peak.v**2)
    return Proof(
        holds=method is not None,
        method=method or "Sturm",
        detail=f"nowhere below {peak.least:.9g} by more than {PEAK_TOL:g} of it",
    )


def _passed(squares: Squares, drops: Drops) -> Proof:
    level, unit = (drops.level**2).as_integer_ratio()
    if not drops.level:
        return Proof(holds=True, method="bound", detail="T is 0 or infinite at w = 0")
    return counted(whole.plus([unit * c for c in squares.top], squares.closed, -level), drops.found)


__all__ = ["ON_DEN", "ON_NUM", "Drops", "Peak", "counted", "proved"]
