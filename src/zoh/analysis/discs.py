"""Bounds between the points of a grid, for loops whose delay leaves no polynomial.

On an interval around c, |v - c| <= h, a polynomial stays within a disc around its value at c,
whose radius is its Taylor series with all signs positive, and exp(-j psi) within one of radius
|psi - psi(c)|. So num exp(-j psi) and den stay in discs, and what they cannot do there is
proved. An interval on which nothing is proved is halved. The last one reaches to infinity:
there x = 1/v is the variable, and the polynomials are read backwards.
Source: R. E. Moore, Interval Analysis, 1966, ch. 3 (centred forms, subdivision).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np
import numpy.typing as npt

from zoh.analysis.loop import Array, ComplexArray, Loop
from zoh.analysis.results import Proof
from zoh.analysis.squares import Below

PEAK_TOL = 1e-6  # relative; nearer to a peak than this the intervals would become too many
_ROUNDING = 1e-14  # of the sum of a polynomial's terms, added to each radius
_REAL = 1e-12  # of its size, an imaginary part that is rounding
_TURNED = 1e-15  # of a phase in rad, its rounding and that of its exponential
_JUST_BEYOND = 1e-7  # of a root: far enough for its sign, near enough to have no other one
_MOST = 400_000  # intervals
_ROUNDS = 60  # halvings

Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Discs:
    """num exp(-j psi) and den, and their derivatives, on intervals [a, b]: centres and radii.

    Shapes (K,).
    """

    top: ComplexArray
    top_radius: Array
    bottom: ComplexArray
    bottom_radius: Array
    top_slope: ComplexArray
    top_slope_radius: Array
    bottom_slope: ComplexArray
    bottom_slope_radius: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """The loop as a function of a real variable: v up to the last point, 1/v beyond.

    num, den  complex coefficients, descending powers; ends the intervals' ends, ascending
    """

    loop: Loop
    num: ComplexArray
    den: ComplexArray
    ends: Array
    beyond: bool

    def psi(self, x: Array) -> Array:
        """Return the delay's phase lag in rad."""
        loop = self.loop
        if not self.beyond:
            return np.asarray(loop.psi(x))
        dt = loop.dt or 0.0
        return loop.dead_time * 2 / dt * np.arctan2(dt / 2, x) if dt else np.full_like(x, np.inf)

    def psi_slope(self, x: Array) -> Array:
        """Return d psi/dx, in size largest at the interval's near end."""
        loop = self.loop
        if not self.beyond:
            return np.broadcast_to(np.asarray(loop.psi_slope(x)), x.shape)
        half = (loop.dt or 0.0) / 2
        return -loop.dead_time / (x * x + half * half)

    def discs(self, a: Array, b: Array) -> Discs:
        """Return the discs of the intervals [a, b]."""
        c, h = (a + b) / 2, (b - a) / 2
        top, top_radius, top_slope, top_slope_radius = _taylor(self.num, c, h)
        bottom, bottom_radius, bottom_slope, bottom_slope_radius = _taylor(self.den, c, h)
        if self.beyond and self.loop.dt is None:  # turns for ever: any phase
            size = np.abs(top) + top_radius
            free = np.full_like(size, np.inf)
            return Discs(
                top=0 * top, top_radius=size, bottom=bottom, bottom_radius=bottom_radius,
                top_slope=top_slope, top_slope_radius=free,
                bottom_slope=bottom_slope, bottom_slope_radius=bottom_slope_radius,
            )  # fmt: skip
        psi, ends = self.psi(c), (self.psi(a), self.psi(b))
        swing = np.maximum(np.abs(ends[0] - psi), np.abs(ends[1] - psi))
        swing = swing + _TURNED * (np.abs(ends[0]) + np.abs(ends[1]))
        loose = swing >= 1  # a disc around 0 that holds every phase is smaller then
        turned = np.exp(-1j * psi)
        slope_a, slope_c, slope_b = (self.psi_slope(x) for x in (a, c, b))
        rate = np.maximum(np.abs(slope_a - slope_c), np.abs(slope_b - slope_c))
        size = np.abs(top) + top_radius
        moved = top_slope - 1j * slope_c * top
        moved_radius = top_slope_radius + np.abs(slope_c) * top_radius + rate * size
        return Discs(
            top=np.where(loose, 0, top * turned),
            top_radius=np.where(loose, size, top_radius + swing * size),
            bottom=bottom, bottom_radius=bottom_radius,
            top_slope=moved * turned,
            top_slope_radius=moved_radius
            + np.minimum(swing, 2.0) * (np.abs(moved) + moved_radius),
            bottom_slope=bottom_slope, bottom_slope_radius=bottom_slope_radius,
        )  # fmt: skip

    def at(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Return (num exp(-j psi), den) at x."""
        top = np.polyval(self.num, x)
        if self.beyond and self.loop.dt is None:
            top = np.where(x == 0, 0, top * np.exp(-1j * self.loop.dead_time / np.where(x, x, 1)))
        else:
            top = top * np.exp(-1j * self.psi(x))
        return np.asarray(top), np.asarray(np.polyval(self.den, x))

    def over_powers(self) -> "Stretch":
        """Return num and den each over the power of x that it has as a factor.

        That turns L by no angle, and leaves it a direction where it is 0 or infinite at x = 0.
        """
        num, den = (np.trim_zeros(a, "b") for a in (self.num, self.den))
        return replace(self, num=num, den=den)


def stretches(loop: Loop, v: Array) -> tuple[Stretch, Stretch]:
    """Return the loop up to the last of v and beyond it; there num and den are over (jv)^n."""
    n = len(loop.den) - 1
    powers = 1j ** np.arange(n, -1, -1)
    num, den = np.array(loop.num) * powers, np.array(loop.den) * powers
    backwards = (-1j) ** np.arange(n, -1, -1)  # (jv)^-i = (-j x)^i
    last = float(v[-1])
    return (
        Stretch(loop=loop, num=num, den=den, ends=np.concatenate([[0.0], v]), beyond=False),
        Stretch(
            loop=loop, num=np.array(loop.num[::-1]) * backwards,
            den=np.array(loop.den[::-1]) * backwards, ends=np.array([0.0, 1 / last]), beyond=True,
        ),
    )  # fmt: skip


def least(loop: Loop, v: Array, value: float, below: Below) -> Proof:
    """Return whether |den + num| >= value |below| everywhere, but for PEAK_TOL of it."""
    floor = value * (1 - PEAK_TOL)

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
        return np.asarray(one | (above > floor * (under + radius)))

    proved = all(_decided(part, holds) is not None for part in stretches(loop, v))
    detail = f"nowhere below {value:.9g} by more than {PEAK_TOL:g} of it"
    return Proof(holds=proved, method="discs", detail=detail)


def turns(loop: Loop, v: Array, found: int) -> Proof:
    """Return whether Im(num conj den) changes sign as often as was found.

    A continuous dead time turns the loop for ever: there it is counted up to the last of v.
    """
    if not any(loop.num):
        return Proof(holds=True, method="bound", detail="L is 0")

    def value(d: Discs) -> tuple[Array, Array]:
        radius = _product(d.top, d.top_radius, d.bottom, d.bottom_radius)
        return (d.top * np.conj(d.bottom)).imag, radius

    def slope(d: Discs) -> tuple[Array, Array]:
        one = (d.top_slope * np.conj(d.bottom)).imag + (d.top * np.conj(d.bottom_slope)).imag
        radius = _product(d.top_slope, d.top_slope_radius, d.bottom, d.bottom_radius)
        radius = radius + _product(d.top, d.top_radius, d.bottom_slope, d.bottom_slope_radius)
        return one, radius

    def at(part: Stretch, x: Array) -> Array:
        top, bottom = part.at(x)
        side = (top * np.conj(bottom)).imag
        real = (x == 0) & (np.abs(side) <= (_REAL + _TURNED * part.psi(x)) * np.abs(top * bottom))
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
        end = found[0] * (1 + _JUST_BEYOND)
        v = np.append(v[v < end], end)
    square = level * level

    def value(d: Discs) -> tuple[Array, Array]:
        closed, closed_radius = d.top + d.bottom, d.top_radius + d.bottom_radius
        radius = _product(d.top, d.top_radius, d.top, d.top_radius)
        radius = radius + square * _product(closed, closed_radius, closed, closed_radius)
        return np.abs(d.top) ** 2 - square * np.abs(closed) ** 2, radius

    def slope(d: Discs) -> tuple[Array, Array]:
        closed, closed_radius = d.top + d.bottom, d.top_radius + d.bottom_radius
        moved = d.top_slope + d.bottom_slope
        moved_radius = d.top_slope_radius + d.bottom_slope_radius
        one = (d.top_slope * np.conj(d.top)).real - square * (moved * np.conj(closed)).real
        radius = _product(d.top_slope, d.top_slope_radius, d.top, d.top_radius)
        return one, radius + square * _product(moved, moved_radius, closed, closed_radius)

    def at(part: Stretch, x: Array) -> Array:
        top, bottom = part.at(x)
        return np.asarray(np.abs(top) ** 2 - square * np.abs(top + bottom) ** 2)

    upto, beyond = stretches(loop, v)
    counts = [_changes(upto, value, slope, at)]
    if not found and loop.dt is None:
        counts.append(0 if _keeps_off(beyond, level) else None)
    elif not found:
        counts.append(_changes(beyond, value, slope, at))
    return _counted(counts, len(found[:1]))


def _keeps_off(beyond: Stretch, level: float) -> bool:
    """Return whether |T| keeps off the level whichever way a dead time turns L."""
    half = beyond.ends[1:] / 2
    top, bottom = (_taylor(a, half, half) for a in (beyond.num, beyond.den))
    (low, high), (least, most) = ((abs(x[0]) - x[1], abs(x[0]) + x[1]) for x in (top, bottom))
    return bool((low > level * (most + low)).all() or (high < level * (least - high)).all())


def unstable_zeros(loop: Loop, v: Array) -> int | None:
    """Return how many zeros den + num exp(-j psi) has on the right; None if one is on the axis.

    Over (jv + r)^n it goes to a constant, and from v = 0 to infinity its argument changes by
    -pi for each zero on the right. Within an interval whose disc leaves 0 out, the argument
    changes by the angle between its ends.
    Source: Mikhailov's criterion, the argument principle on the imaginary axis; for polynomials
    with exponentials R. Bellman and K. L. Cooke, Differential-Difference Equations, ch. 13.
    """

    def leaves_out_zero(d: Discs) -> Bools:
        return np.asarray(np.abs(d.bottom + d.top) > d.top_radius + d.bottom_radius)

    turned = 0.0
    for part in stretches(loop, v):
        ends = _decided(part, leaves_out_zero)
        if ends is None:
            return None
        f, g = (np.add(*part.at(x)) for x in ends)
        step = np.angle(g * np.conj(f)).sum()
        turned += -step if part.beyond else step
    return round(((len(loop.den) - 1) * pi / 2 - turned) / pi)


Claim = Callable[[Discs], tuple[Array, Array]]


def _changes(
    part: Stretch, value: Claim, slope: Claim, at: Callable[[Stretch, Array], Array]
) -> int | None:
    """Return the sign changes of a function inside a stretch; None where it is not decided.

    On each interval either its value keeps its sign or its slope does.
    """

    def one_way(d: Discs) -> Bools:
        (y, r), (s, q) = value(d), slope(d)
        return np.asarray((np.abs(y) > r) | (np.abs(s) > q))

    ends = _decided(part, one_way)
    if ends is None:
        return None
    first, last = (np.sign(at(part, x)) for x in ends)
    return int(np.count_nonzero(first * last < 0))


def _counted(numbers: list[int | None], found: int, upto: str = "") -> Proof:
    if None in numbers:
        return Proof(
            holds=False, method="discs", detail="two crossings, or none, nearer than discs tell"
        )
    number = sum(n for n in numbers if n is not None)
    detail = f"{number} sign changes on the axis{upto}, {found} found"
    return Proof(holds=number == found, method="discs", detail=detail)


def _decided(part: Stretch, test: Callable[[Discs], Bools]) -> tuple[Array, Array] | None:
    """Return intervals (a, b) on each of which the test holds; None where there are none."""
    a, b = part.ends[:-1], part.ends[1:]
    done: list[tuple[Array, Array]] = []
    total = 0
    for _ in range(_ROUNDS):
        with np.errstate(invalid="ignore"):  # a radius may be infinite: nothing is proved there
            good = test(part.discs(a, b))
        done.append((a[good], b[good]))
        a, b = a[~good], b[~good]
        total += len(good)
        if not a.size:
            return np.concatenate([x for x, _ in done]), np.concatenate([x for _, x in done])
        if total > _MOST:
            return None
        middle = (a + b) / 2
        a, b = np.concatenate([a, middle]), np.concatenate([middle, b])
    return None


def _product(x: ComplexArray, rx: Array, y: ComplexArray, ry: Array) -> Array:
    """Return the radius of the product of two discs around the product of their centres."""
    return np.asarray(np.abs(x) * ry + np.abs(y) * rx + rx * ry)


def _taylor(a: ComplexArray, c: Array, h: Array) -> tuple[ComplexArray, Array, ComplexArray, Array]:
    """Return (a, radius, a', radius) on |x - c| <= h."""
    series = [np.full(c.shape, x) for x in a]
    n = len(series) - 1
    for end in range(n + 1, 1, -1):  # divided by x - c again and again: the remainders
        for j in range(1, end):
            series[j] = series[j] + c * series[j - 1]
    size, slope_size, power = np.zeros_like(h), np.zeros_like(h), np.ones_like(h)
    for k in range(1, n + 1):
        term = np.abs(series[n - k])
        if k > 1:
            slope_size = slope_size + k * term * power
        power = power * h
        size = size + term * power
    blur = _ROUNDING * (n + 1) * np.polyval(np.abs(a), np.abs(c) + h)
    terms = np.abs(a[:-1]) * np.arange(n, 0, -1)  # of the derivative: the last one is not in it
    slope_blur = _ROUNDING * (n + 1) * np.polyval(terms, np.abs(c) + h)
    slope = series[n - 1] if n else np.zeros_like(series[0])
    return series[n], size + blur, slope, slope_size + slope_blur
