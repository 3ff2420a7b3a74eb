"""Bounds between the points of a grid, for loops whose delay leaves no polynomial.

On an interval num exp(-j psi) and den stay in the discs of ``stretches``, and what they cannot
do there is proved. An interval on which nothing is proved is halved.
Source: R. E. Moore, Interval Analysis, 1966, ch. 3 (centred forms, subdivision).
"""

from collections.abc import Callable, Sequence
from math import inf, isfinite, pi

import numpy as np

from zoh.analysis.certificates import Proof
from zoh.analysis.loop import Array, Loop
from zoh.analysis.squares import Below
from zoh.analysis.stretches import (
    TURNED,
    Bools,
    Discs,
    Stretch,
    decided,
    product,
    stretches,
    taylor,
)

DISC_TOL = 1e-6  # relative; nearer to a peak than this the intervals would become too many
_REAL = 1e-12  # of its size, an imaginary part that is rounding
_WHOLE = 0.1  # of a zero: the angles' rounding is a millionth of it, any mistake a half
_JUST_BEYOND = 1e-7  # of a root: far enough for its sign, near enough to have no other one


def floor_of(value: float) -> float:
    """Return what is proved of a peak's value: that no ratio is less."""
    return value * (1 - DISC_TOL)


def least(loop: Loop, v: Array, value: float, below: Below, *, upto_last: bool = False) -> Proof:
    """Return whether |den + num| >= value |below| everywhere, but for DISC_TOL of it.

    upto_last  whether what is beyond the last of v is known already

    From the discs at once; where num is loud and of any phase from its least size; else from
    the value at the centre and the slope.
    """
    floor = floor_of(value)

    def holds(d: Discs) -> Bools:
        """Ask L = top/bottom where it stays in a disc, and both apart where it may be infinite."""
        room = np.abs(d.bottom) - d.bottom_radius
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = d.top / d.bottom
            radius = (d.top_radius + np.abs(ratio) * d.bottom_radius) / room
            above, under = np.abs(1 + ratio) - radius, np.abs(below[0] + below[1] * ratio)
            one = (room > 0) & (above > floor * (under + abs(below[1]) * radius))
        above = np.abs(d.bottom + d.top) - d.top_radius - d.bottom_radius
        under = np.abs(below[0] * d.bottom + below[1] * d.top)
        radius = abs(below[0]) * d.bottom_radius + abs(below[1]) * d.top_radius
        apart = d.top_least - np.abs(d.bottom) - d.bottom_radius
        most = abs(below[0]) * (np.abs(d.bottom) + d.bottom_radius)
        most = most + abs(below[1]) * (np.abs(d.top) + d.top_radius)
        good = np.asarray(one | (above > floor * (under + radius)) | (apart > floor * most))
        good[~good] = _stays_above(d.where(~good), floor, below)
        return good

    parts = stretches(loop, v)[: 1 if upto_last else 2]
    proved = all(decided(part, holds) is not None for part in parts)
    detail = f"nowhere below {value:.9g} by more than {DISC_TOL:g} of it"
    return Proof(holds=proved, method="discs", detail=detail)


def _stays_above(d: Discs, floor: float, below: Below) -> Bools:
    """Return whether |den + num|^2 - floor^2 |below|^2 > 0, by its value and its slope.

    The slope is small where the ratio is all but constant, as that of a weak loop is.
    """

    def square(on_bottom: float, on_top: float) -> tuple[Array, Array, Array]:
        x, dx = (on_bottom * b + on_top * t for b, t in ((d.bottom, d.top), sloped))
        r, dr, blur = (abs(on_bottom) * b + abs(on_top) * t for b, t in radii)
        slope, slope_radius = 2 * (dx * np.conj(x)).real, 2 * product(dx, dr, x, r)
        return np.abs(x) ** 2, np.abs(x) * (2 * blur) + blur**2, np.array([slope, slope_radius])

    sloped = d.bottom_slope, d.top_slope
    radii = (
        (d.bottom_radius, d.top_radius),
        (d.bottom_slope_radius, d.top_slope_radius),
        (d.bottom_blur, d.top_blur),
    )
    level = floor * floor
    with np.errstate(invalid="ignore"):  # of any phase: no slope
        (above, off, up), (under, also, down) = square(1.0, 1.0), square(*below)
        slope = np.abs(up[0] - level * down[0]) + up[1] + level * down[1]
        return np.asarray(above - off - level * (under + also) > slope * d.half)


def turns(loop: Loop, v: Array, found: int) -> Proof:
    """Return whether Im(num conj den) changes sign as often as was found.

    A continuous dead time turns the loop for ever: there it is counted up to the last of v.
    """
    if not any(loop.num):
        return Proof(holds=True, method="bound", detail="L is 0")

    def value(d: Discs) -> tuple[Array, Array]:
        radius = product(d.top, d.top_radius, d.bottom, d.bottom_radius)
        return (d.top * np.conj(d.bottom)).imag, radius

    def slope(d: Discs) -> tuple[Array, Array]:
        one = (d.top_slope * np.conj(d.bottom)).imag + (d.top * np.conj(d.bottom_slope)).imag
        radius = product(d.top_slope, d.top_slope_radius, d.bottom, d.bottom_radius)
        radius = radius + product(d.top, d.top_radius, d.bottom_slope, d.bottom_slope_radius)
        return one, radius

    def at(part: Stretch, x: Array) -> Array:
        top, bottom = part.at(x)
        side = (top * np.conj(bottom)).imag
        real = (x == 0) & (np.abs(side) <= (_REAL + TURNED * part.psi(x)) * np.abs(top * bottom))
        return np.asarray(np.where(real, 0.0, side))

    parts = [part.over_powers() for part in stretches(loop, v)[: 1 if loop.dt is None else 2]]
    upto = f" up to {v[-1]:.6g} rad/s" if loop.dt is None else ""
    return _counted([_changes(part, value, slope, at) for part in parts], found, upto)


def passages(loop: Loop, v: Array, level: float, found: Sequence[float]) -> Proof:
    """Return whether |num|^2 - level^2 |den + num|^2 changes sign first where it was found to.

    Beyond that it may do so without end where a continuous dead time turns the loop.
    """
    if not level:
        return Proof(holds=not found, method="bound", detail="T is 0 or infinite at w = 0")
    if found:
        end = min(found[0] * (1 + _JUST_BEYOND), (found[0] + min(found[1:], default=inf)) / 2)
        v = np.append(v[v < end], end)
    square = level * level

    def value(d: Discs) -> tuple[Array, Array]:
        closed, closed_radius = d.top + d.bottom, d.top_radius + d.bottom_radius
        radius = product(d.top, d.top_radius, d.top, d.top_radius)
        radius = radius + square * product(closed, closed_radius, closed, closed_radius)
        return np.abs(d.top) ** 2 - square * np.abs(closed) ** 2, radius

    def slope(d: Discs) -> tuple[Array, Array]:
        closed, closed_radius = d.top + d.bottom, d.top_radius + d.bottom_radius
        moved = d.top_slope + d.bottom_slope
        moved_radius = d.top_slope_radius + d.bottom_slope_radius
        one = (d.top_slope * np.conj(d.top)).real - square * (moved * np.conj(closed)).real
        radius = product(d.top_slope, d.top_slope_radius, d.top, d.top_radius)
        return one, radius + square * product(moved, moved_radius, closed, closed_radius)

    def at(part: Stretch, x: Array) -> Array:
        top, bottom = part.at(x)
        return np.asarray(np.abs(top) ** 2 - square * np.abs(top + bottom) ** 2)

    def sure(d: Discs) -> Bools:
        return _off_at_any_phase(d, level)

    upto, beyond = stretches(loop, v)
    counts = [_changes(upto, value, slope, at, sure)]
    if not found and loop.dt is None:
        counts.append(0 if _keeps_off(beyond, level) else None)
    elif not found:
        counts.append(_changes(beyond, value, slope, at))
    return _counted(counts, len(found[:1]))


def _keeps_off(beyond: Stretch, level: float) -> bool:
    """Return whether |T| keeps off the level whichever way a dead time turns L."""
    half = beyond.ends[1:] / 2
    top, bottom = (taylor(a, half, half) for a in (beyond.num, beyond.den))
    (low, high), (least, most) = ((abs(x[0]) - x[1], abs(x[0]) + x[1]) for x in (top, bottom))
    return bool((low > level * (most + low)).all() or (high < level * (least - high)).all())


def _off_at_any_phase(d: Discs, level: float) -> Bools:
    """Return where |T| keeps off the level for the size of L alone: it is |L|/|1 + L|.

    So nobody has to follow the turns of a delay where L is loud enough, or quiet enough.
    """
    least, most = np.abs(d.bottom) - d.bottom_radius, np.abs(d.bottom) + d.bottom_radius
    low, high = d.top_least, np.abs(d.top) + d.top_radius
    return np.asarray((low > level * (most + low)) | (high < level * (least - high)))


def unstable_zeros(loop: Loop, v: Array) -> int | None:
    """Return how many zeros den + num exp(-j psi) has on the right; None where that is not proved.

    Over (jv + r)^n it goes to a constant, and from v = 0 to infinity its argument changes by
    -pi for each zero on the right. Within an interval whose disc leaves 0 out, the argument
    changes by the angle between its ends; a zero on the axis is in every disc around it. What
    then is no whole number has been followed along no closed path.
    Source: Mikhailov's criterion, the argument principle on the imaginary axis; for polynomials
    with exponentials R. Bellman and K. L. Cooke, Differential-Difference Equations, ch. 13.
    """

    def leaves_out_zero(d: Discs) -> Bools:
        return np.asarray(np.abs(d.bottom + d.top) > d.top_radius + d.bottom_radius)

    turned = 0.0
    for part in stretches(loop, v):
        ends = decided(part, leaves_out_zero)
        if ends is None:
            return None
        f, g = (np.add(*part.at(x)) for x in ends)
        f, g = f / np.abs(f), g / np.abs(g)  # their product may be beyond floats
        step = np.angle(g * np.conj(f)).sum()
        turned += -step if part.beyond else step
    zeros = (len(loop.den) - 1) / 2 - turned / pi
    return round(zeros) if isfinite(zeros) and abs(zeros - round(zeros)) <= _WHOLE else None


Claim = Callable[[Discs], tuple[Array, Array]]


def _changes(
    part: Stretch, value: Claim, slope: Claim, at: Callable[[Stretch, Array], Array],
    sure: Callable[[Discs], Bools] | None = None,
) -> int | None:  # fmt: skip
    """Return the sign changes of a function inside a stretch; None where it is not decided.

    On each interval either its value keeps its sign, for what ``sure`` knows, too, or its slope
    does. From one of the former to the next it is monotonous: only theirs, and those at the
    stretch's ends, are signs that no rounding beside a root makes.
    """
    signed: list[Bools] = []

    def one_way(d: Discs) -> Bools:
        (y, r), (s, q) = value(d), slope(d)
        clear = np.abs(y) > r
        if sure:
            clear = clear | sure(d)
        kept = np.asarray(clear | (np.abs(s) > q))
        signed.append(clear[kept])
        return kept

    ends = decided(part, one_way)
    if ends is None:
        return None
    a, b = ends
    clear = np.concatenate(signed)
    x = np.unique(np.concatenate([a[clear], b[clear], [a.min(), b.max()]]))
    signs = np.sign(at(part, x))
    signs = signs[signs != 0]
    return int(np.count_nonzero(signs[1:] != signs[:-1]))


def _counted(numbers: list[int | None], found: int, upto: str = "") -> Proof:
    if None in numbers:
        return Proof(
            holds=False, method="discs", detail="two crossings, or none, nearer than discs tell"
        )
    number = sum(n for n in numbers if n is not None)
    detail = f"{number} sign changes on the axis{upto}, {found} found"
    return Proof(holds=number == found, method="discs", detail=detail)
