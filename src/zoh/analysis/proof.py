"""Proofs that no crossing was missed and no peak is higher than was found.

Descartes' rule bounds the number of positive roots of a polynomial from above, and on intervals
that are halved it counts them; a peak is proved by a polynomial without positive roots,
|D + N|^2 - m^2 |D|^2 for a modulus margin just below m. All of it in whole numbers. Where a delay
leaves no polynomial, ``discs`` proves the same between the points of a grid.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import frexp, inf, ldexp
from typing import NamedTuple

from zoh.analysis import discs
from zoh.analysis.certificates import Certificate, Proof
from zoh.analysis.close import Close
from zoh.analysis.endless import keeps_above, none_decides
from zoh.analysis.isolated import Isolated
from zoh.analysis.loop import Loop
from zoh.analysis.sharp import apart, places
from zoh.analysis.sparse import Sparse
from zoh.analysis.squares import Below, Squares, squared
from zoh.analysis.undamped import without_undamped
from zoh.lti import signs, whole
from zoh.lti.whole import Whole

_ROUNDING = 1e-13  # |D + N| of its terms where a loop runs through -1
PEAK_TOL = 1e-9  # relative; what is proved of a peak is that no point is higher by more than this
_BY_MORE = f"by more than {PEAK_TOL:g} of it"
_BESIDE = 1e-7  # relative, of a crossing: there a float has the sign of Im L
_NOT_APART = ", not each with a sign change of its own"
_NONE_BEYOND = ", no gain nearer to 1 beyond"
_MAYBE_BEYOND = ", beyond that the gain may be nearer to 1"
_BITS = 41  # of the square of a peak: its last one is less than a thousandth of PEAK_TOL


Look = Sparse | Close | Isolated


class Peak(NamedTuple):
    """The least |D + N|/|below|, and where it is in v."""

    v: float
    least: float
    below: Below


class Found(NamedTuple):
    """What was found, in v: |L| = 1, L real, |T| at its level, and the peaks.

    factor  the gain margin, None where L is nowhere negative
    """

    unities: Sequence[float]
    turns: Sequence[float]
    drops: Sequence[float]
    peaks: Sequence[Peak]
    factor: float | None = None


def proved(loop: Loop, squares: Squares, look: Look, found: Found, *, stable: Proof) -> Certificate:
    """Return the proofs for what was found in a look."""
    gain = counted(squares.gain, found.unities)
    if not isinstance(look, Close) or squares.whole:
        modulus, complementary, disk = [_least(squares, peak) for peak in found.peaks]
        phases = counted(squares.turn, found.turns)
        passages = counted(squares.drop, found.drops)
    else:
        v, level = look.v, squares.level
        modulus, complementary, disk = (_between(loop, squares, look, peak) for peak in found.peaks)
        phases = _turns(loop, squares, look, found)
        passages = discs.passages(loop, v, level, found.drops)
    return Certificate(
        stable=stable, gain_crossings=gain, phase_crossings=phases,
        modulus_margin=modulus, mt=complementary, disk_margin=disk, bandwidth=passages,
    )  # fmt: skip


def counted(a: Whole, found: Sequence[float]) -> Proof:
    """Return whether the positive roots of a of odd multiplicity are those found, v = sqrt(q).

    One sign change of the coefficients is one root and none is none; a root like that is found in
    floats, where terms of one sign cancel those of the other there alone. Of more of them each
    must lie in an interval of its own at whose ends a has different signs; no more roots than sign
    changes there are, and those that are fewer are counted. Two that are one float have such
    intervals where no float is: each was found where exact arithmetic has it.

    >>> counted((1, -1, -2), [2**0.5]).method, counted((1, -5, 4), [1.0, 2.0]).method
    ('Descartes', 'Descartes')
    >>> counted((1, -5, 4), [1.0]).holds, counted((1, -5, 4), [1.0, 1.0]).holds
    (False, False)
    """
    most = signs.variations(a)
    if most == len(found) <= 1 or (most == len(found) and _apart(a, found)):
        detail = f"{most} sign changes, {len(found)} found"
        return Proof(holds=True, method="Descartes", detail=detail)
    number = signs.crossings(a)
    detail = f"{number} sign changes on the axis, {len(found)} found"
    holds = number == len(found)
    if holds and not _apart(a, found) and None in places(a, found):
        holds, detail = False, detail + _NOT_APART
    return Proof(holds=holds, method="halving", detail=detail)


def _turns(loop: Loop, squares: Squares, look: Close, found: Found) -> Proof:
    """Return the proof for where L is real, an undamped pole or zero not counted among it."""
    left, jumps = without_undamped(loop)
    upto = [x for x in found.turns if x <= look.reach]
    phases = discs.turns(left, look.v[look.v <= look.reach], len(upto))
    if loop.dt is None and any(loop.num):
        phases = _decided(phases, squares, found.factor, look.reach)
    beside = any(abs(x - v) <= _BESIDE * v for v in jumps for x in found.turns)
    if beside or not apart(left.side, found.turns, _BESIDE):
        return replace(phases, holds=False, detail=phases.detail + _NOT_APART)
    return phases


def _decided(phases: Proof, squares: Squares, factor: float | None, reach: float) -> Proof:
    """Return the proof for the turns up to ``reach``, and that none beyond decides."""
    if factor and none_decides(squares, factor, reach):
        return replace(phases, detail=phases.detail + _NONE_BEYOND)
    return replace(phases, holds=False, detail=phases.detail + _MAYBE_BEYOND)


def _apart(a: Whole, found: Sequence[float]) -> bool:
    return apart(lambda v: whole.at_fraction(a, *squared(v)), found)


def _least(squares: Squares, peak: Peak) -> Proof:
    """Return whether the ratio is nowhere below its least value found, but for PEAK_TOL."""
    below = squares.below(peak.below)
    if nothing := _nothing_below(peak):
        return nothing
    if peak.least == inf:
        return Proof(holds=not any(below), method="bound", detail="measured against 0 everywhere")
    level, down = _just_below(peak.least)
    if down < 0:
        level, down = level << -down, 0
    above = [(c << down) - level * b for c, b in zip(squares.closed, below, strict=True)]
    method = signs.positive(above, peak.v**2)
    return Proof(
        holds=method is not None,
        method=method or "halving",
        detail=f"nowhere below {peak.least:.9g} {_BY_MORE}",
    )


def _just_below(least: float) -> tuple[int, int]:
    """Return (level, down): level 2^-down is a little below the square of the least value.

    By PEAK_TOL of the value or up to a thousandth of that less: so it has few bits.
    """
    mantissa, exponent = frexp(least)
    return int(ldexp(mantissa * mantissa * (1 - 2 * PEAK_TOL), _BITS)) + 1, _BITS - 2 * exponent


def _between(loop: Loop, squares: Squares, look: Close, peak: Peak) -> Proof:
    """Return ``discs.least``, or that there is nothing to prove.

    Beyond the turns that a continuous dead time is followed along, the size of L may tell.
    """
    if nothing := _nothing_below(peak):
        return nothing
    v, floor = look.v, discs.floor_of(peak.least)
    known = look.reach < inf and keeps_above(squares, floor, peak.below, look.reach)
    if known:
        v = v[v <= look.reach]
    return discs.least(loop, v, peak.least, peak.below, upto_last=known)


def _nothing_below(peak: Peak) -> Proof | None:
    if peak.least <= _ROUNDING:
        return Proof(holds=True, method="bound", detail="0 but for rounding, the least there is")
    return None
