"""A loop on intervals of its frequency axis, up to infinity: discs that hold num and den.

On an interval around c, |v - c| <= h, a polynomial stays within a disc around its value at c,
whose radius is its Taylor series with all signs positive, and exp(-j psi) within one of radius
|psi - psi(c)|. So num exp(-j psi) and den stay in discs. The last interval reaches to infinity:
there x = 1/v is the variable, and the polynomials are read backwards.
Source: R. E. Moore, Interval Analysis, 1966, ch. 3 (centred forms, subdivision).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from zoh.analysis.loop import Array, ComplexArray, Loop

_ROUNDING = 1e-14  # of the sum of a polynomial's terms, added to each radius
TURNED = 1e-15  # of a phase in rad, its rounding and that of its exponential
_MOST = 400_000  # intervals
_ROUNDS = 60  # halvings

Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Discs:
    """num exp(-j psi) and den, and their derivatives, on intervals [a, b]: centres and radii.

    top_least  what |num| is at least there, where the delay leaves no phase
    half       half of b - a; the blurs: how far off the centres themselves may be
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
    top_least: Array
    half: Array
    top_blur: Array
    bottom_blur: Array

    def where(self, chosen: Bools) -> "Discs":
        """Return the discs of some of the intervals."""
        return Discs(**{name: getattr(self, name)[chosen] for name in self.__slots__})


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
        top, top_radius, top_slope, top_slope_radius, top_blur = taylor(self.num, c, h)
        bottom, bottom_radius, bottom_slope, bottom_slope_radius, bottom_blur = taylor(
            self.den, c, h
        )
        least = np.maximum(np.abs(top) - top_radius, 0.0)
        if self.beyond and self.loop.dt is None:  # turns for ever: any phase
            size = np.abs(top) + top_radius
            free = np.full_like(size, np.inf)
            return Discs(
                top=0 * top, top_radius=size, bottom=bottom, bottom_radius=bottom_radius,
                top_slope=top_slope, top_slope_radius=free,
                bottom_slope=bottom_slope, bottom_slope_radius=bottom_slope_radius,
                top_least=least, half=h, top_blur=size, bottom_blur=bottom_blur,
            )  # fmt: skip
        psi, ends = self.psi(c), (self.psi(a), self.psi(b))
        swing = np.maximum(np.abs(ends[0] - psi), np.abs(ends[1] - psi))
        blur = TURNED * (np.abs(ends[0]) + np.abs(ends[1]))
        swing = swing + blur
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
            top_least=least, half=h, bottom_blur=bottom_blur,
            top_blur=np.where(loose, size, top_blur + blur * size),
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


def decided(part: Stretch, test: Callable[[Discs], Bools]) -> tuple[Array, Array] | None:
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


def product(x: ComplexArray, rx: Array, y: ComplexArray, ry: Array) -> Array:
    """Return the radius of the product of two discs around the product of their centres."""
    return np.asarray(np.abs(x) * ry + np.abs(y) * rx + rx * ry)


def taylor(
    a: ComplexArray, c: Array, h: Array
) -> tuple[ComplexArray, Array, ComplexArray, Array, Array]:
    """Return (a, radius, a', radius, rounding of a) on |x - c| <= h."""
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
    blur: Array = _ROUNDING * (n + 1) * np.asarray(np.polyval(np.abs(a), np.abs(c) + h))
    terms = np.abs(a[:-1]) * np.arange(n, 0, -1)  # of the derivative: the last one is not in it
    slope_blur = _ROUNDING * (n + 1) * np.polyval(terms, np.abs(c) + h)
    slope = series[n - 1] if n else np.zeros_like(series[0])
    return series[n], size + blur, slope, slope_size + slope_blur, blur
