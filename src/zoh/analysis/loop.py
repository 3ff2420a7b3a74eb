"""An open loop on its frequency axis, sampled or continuous, with or without delay.

Both kinds are num(j v)/den(j v) exp(-j psi(v)) for 0 <= v <= infinity. A continuous loop has
v = w and psi = v dead_time. A sampled loop has v = (2/dt) tan(w dt/2), so that infinity is the
Nyquist frequency, and psi = delay w dt. Everything that is measured is measured here.
"""

from cmath import exp
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf
from operator import is_
from typing import Any

import numpy as np
import numpy.typing as npt

from zoh.analysis.axis import scalar, with_slope
from zoh.analysis.series import These, clock, out_of_range, product
from zoh.lti import divisors, poly, whole
from zoh.lti.poly import Poly
from zoh.lti.systems import Plant, Sampled
from zoh.lti.whole import Whole
from zoh.lti.wplane import unwarp

Array = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loop:
    """num(jv)/den(jv) exp(-j psi(v)); two are equal where they are one.

    num, den   real polynomials of one length, descending powers of j v
    exact      the same in whole numbers, times one power of two: the product of the systems'
               coefficients without rounding, which num and den are the floats of
    dt         s, the sample time; None for a continuous loop
    dead_time  s, the delay kept apart from the polynomials
    factors    the systems that it is the product of
    """

    num: Poly
    den: Poly
    exact: tuple[Whole, Whole]
    dt: float | None
    dead_time: float
    factors: tuple[Plant | Sampled, ...] = ()

    @classmethod
    def of(cls, *systems: Plant | Sampled) -> "Loop":
        """Return the loop of these systems in series; raise SpecError for a mixture.

        The very same systems have the very same loop: a design is measured and looked at again.
        """
        return _in_series(These(systems))

    @property
    def rounded(self) -> tuple[Sampled, ...]:
        """Return the factors that were given as z-coefficients."""
        return tuple([s for s in self.factors if isinstance(s, Sampled) and not s.off])

    @property
    def made(self) -> tuple[Sampled, ...]:
        """Return the factors whose w-coefficients were computed, and are rounded."""
        return tuple([s for s in self.factors if isinstance(s, Sampled) and s.off])

    @property
    def given(self) -> bool:
        """Return whether all of it is coefficients that were given, so that exact is the truth.

        What a hold has made is rounded, and equals 1 or not but for that.
        """
        return not self.made

    @property
    def exact_but_for_gains(self) -> bool:
        """Return whether what a hold has made of it is gains alone, so that all roots are exact."""
        return all(len(s.den_w) == 1 for s in self.made)

    def finer(self) -> "Loop":
        """Return the loop with more digits of what a hold made; itself where no more are known."""
        finer = [s.finer if isinstance(s, Sampled) else s for s in self.factors]
        return self if all(map(is_, finer, self.factors)) else Loop.of(*finer)

    def frequency(self, v: float) -> float:
        """Return the real frequency in rad/s at v."""
        return v if self.dt is None else unwarp(v, self.dt)

    def psi(self, v: Any) -> Any:
        """Return the delay's phase lag in rad at v, a number or an array."""
        if not self.dead_time:
            return 0.0 * v
        return self.dead_time * (v if self.dt is None else 2 / self.dt * np.arctan(v * self.dt / 2))

    def psi_slope(self, v: Any) -> Any:
        """Return d psi/d v in s."""
        if self.dt is None or not self.dead_time:
            return self.dead_time
        return self.dead_time / (1 + (v * self.dt / 2) ** 2)

    def parts(self, v: Array) -> tuple[ComplexArray, ComplexArray]:
        """Return (num(jv) exp(-j psi), den(jv)) at an array of v, both over |1 + jv|**n.

        Only their ratio and the signs of what is made of both are meant: the common factor keeps
        high powers of a high frequency within a float.
        """
        size = np.hypot(1.0, v)
        x, y = 1j * v / size, 1 / size
        top, bottom = poly.homogeneous(self.num, x, y), poly.homogeneous(self.den, x, y)
        if self.dead_time:
            top = top * np.exp(-1j * self.psi(v))
        return top, bottom

    def point(self, v: float) -> tuple[complex, complex]:
        """Return (num(jv) exp(-j psi), den(jv)) at one v."""
        top, bottom = scalar(self.num, v), scalar(self.den, v)
        return (top * exp(-1j * self.psi(v)) if self.dead_time else top), bottom

    def excess(self, v: float) -> float:
        """Return |num| - |den| at one v, above 0 where |L| > 1."""
        return abs(scalar(self.num, v)) - abs(scalar(self.den, v))

    def side(self, v: float) -> float:
        """Return Im(num conj den), the delay in it, at one v."""
        top, bottom = self.point(v)
        return (top * bottom.conjugate()).imag

    def above(self, v: float, level: float) -> float:
        """Return |num| - level |den + num| at one v, above 0 where |T| > level."""
        top, bottom = self.point(v)
        return abs(top) - level * abs(bottom + top)

    def ratio(self, v: float, below: tuple[float, float]) -> float:
        """Return |den + num|/|b den + a num| at one v, below = (b, a); inf over 0."""
        top, bottom = self.point(v)
        under = abs(below[0] * bottom + below[1] * top)
        return abs(bottom + top) / under if under else inf

    def slopes(self, v: float) -> tuple[complex, complex, complex, complex]:
        """Return ``point`` and its derivatives with respect to v: (top, bottom, dtop, dbottom)."""
        top, dtop = with_slope(self.num, v)
        bottom, dbottom = with_slope(self.den, v)
        if self.dead_time:
            turned = exp(-1j * self.psi(v))
            dtop = (dtop - 1j * self.psi_slope(v) * top) * turned
            top = top * turned
        return top, bottom, dtop, dbottom

    def ends(self) -> tuple[tuple[float, float, float], ...]:
        """Return (v, num, den) where the loop is real whatever it is: v = 0 and infinity.

        A factor that num and den share there is left out. At infinity both are the leading
        coefficients; a delay kept apart turns a sampled loop by exp(-j pi m) there. A
        continuous loop with dead time that does not vanish turns for ever, through -1 too: that
        is what is given.
        """
        return _ends(self)

    def exact_end(self, v: float) -> tuple[int, int]:
        """Return (num, den) at an end, v = 0 or infinity, without what they share there, in whole
        numbers and but for their signs what ``ends`` has.
        """
        num, den = self.exact if v else (a[::-1] for a in self.exact)
        return next(pair for pair in zip(num, den, strict=True) if any(pair))

    def is_one_at(self, v: float) -> bool:
        """Return whether |L| is 1, exactly, at one of its ends."""
        top, bottom = self.exact_end(v)
        return abs(top) == abs(bottom)

    def closed(self, sign: float = 1.0) -> Poly:
        """Return den + sign num, the closed loop's polynomial where there is no delay."""
        return poly.plus(self.den, self.num, sign)

    def without_shared(self) -> "Loop | None":
        """Return the loop of the same gain whose num and den share nothing.

        On the axis a shared factor is 0/0: L is seen on both sides of it, and not there. None
        where nothing is shared.
        """
        num, den = self.exact
        if not any(num) or divisors.share_nothing(num, den):
            return None
        shared = divisors.common(num, den)
        if len(shared) == 1:
            return None
        num, den = whole.divided(num, shared), whole.divided(den, shared)
        unit = max(map(abs, [*num, *den]))
        top, bottom = (tuple([c / unit for c in a]) for a in (num, den))
        return replace(self, num=top, den=bottom, exact=(num, den))


@lru_cache(maxsize=8)
def _in_series(these: These) -> Loop:
    """Return ``Loop.of``."""
    systems, dt = these.systems, clock(these.systems)
    num, den, unit, dead_time = product(systems)
    factors = tuple([f for s in systems for f in (s.factors if isinstance(s, Sampled) else (s,))])
    try:
        top, bottom = tuple([c / unit for c in num]), tuple([c / unit for c in den])
    except OverflowError:
        raise out_of_range([*systems]) from None
    return Loop(num=top, den=bottom, exact=(num, den), dt=dt, dead_time=dead_time, factors=factors)


@lru_cache(maxsize=8)
def _ends(loop: Loop) -> tuple[tuple[float, float, float], ...]:
    """Return ``Loop.ends``."""
    num, den = loop.num, loop.den
    while num[-1] == den[-1] == 0:
        num, den = num[:-1], den[:-1]
    found = [(0.0, num[-1], den[-1])]
    num, den = loop.num, loop.den
    while num[0] == den[0] == 0:
        num, den = num[1:], den[1:]
    if loop.dt is not None:
        odd = round(loop.dead_time / loop.dt) % 2
        found.append((inf, -num[0] if odd else num[0], den[0]))
    elif loop.dead_time and num[0] != 0:
        found.append((inf, -abs(num[0]), abs(den[0])))
    else:
        found.append((inf, num[0], den[0]))
    return tuple(found)
