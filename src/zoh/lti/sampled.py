"""Sampled: a system in z and in w, with its sample time."""

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from zoh import checks
from zoh.errors import SpecError
from zoh.lti import poly
from zoh.lti.given import MOST_DELAY, check_fraction, delay_at_zero, in_w
from zoh.lti.poly import ComplexArray, Poly
from zoh.lti.whole import of, times
from zoh.lti.wplane import roots_in_z, w_to_z, z_to_w

Wholes = tuple[list[int], list[int], int]  # num, den, and the one number that they are times

_A_FLOAT = 2.0**-53  # of a coefficient: what rounding it to a float puts it off by


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampled:
    """A sampled system num(z)/den(z) with its sample time dt in s.

    num, den  coefficients in descending powers of z
    num_w, den_w, delay  the same system as num_w(w)/den_w(w) z^-delay with
    w = (2/dt)(z-1)/(z+1); both have the same length, leading zeros are roots at z = -1.
    The work is done in w, where digits survive a small dt; z is what goes in and out.
    factors  the systems that this one is the product of; itself, unless it is one
    off      by which part of itself a coefficient of ``whole_w`` may be off, of one factor: 0 where
    the z-coefficients were given, which may have lost digits that no later care brings back

    Raises SpecError for dt <= 0, an acausal, an empty or a zero fraction.

    >>> Sampled(num=[1], den=[1, -1], dt=0.5).num_w  # z/(z-1) is (1 + w/4)/(w/2)
    (-0.25, 1.0)
    """

    num: Poly
    den: Poly
    dt: float
    num_w: Poly = field(init=False, repr=False, compare=False)
    den_w: Poly = field(init=False, repr=False, compare=False)
    delay: int = field(init=False, repr=False, compare=False)
    off: float = field(init=False, repr=False, compare=False)
    _factors: "tuple[Sampled, ...]" = field(init=False, repr=False, compare=False)
    _whole: Wholes | None = field(init=False, repr=False, compare=False)
    _finer: "Callable[[], Sampled] | None" = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "num", checks.coefficients("num", self.num))
        put(self, "den", checks.coefficients("den", self.den))
        put(self, "dt", sample_time(self.dt))
        check_fraction(self.num, self.den, "z")
        delay = delay_at_zero(self.num, self.den)
        n = len(self.den) - 1 - delay
        (num, above), (den, below) = (z_to_w(a, self.dt, n) for a in (self.num, self.den[: n + 1]))
        unit = max(above, below)  # both are powers of two
        num, den = [c * (unit // above) for c in num], [c * (unit // below) for c in den]
        put(self, "num_w", _floats(num, unit))
        put(self, "den_w", _floats(den, unit))
        put(self, "delay", delay)
        put(self, "off", 0.0)
        put(self, "_factors", ())
        put(self, "_whole", (num, den, unit))
        put(self, "_finer", None)

    @property
    def factors(self) -> "tuple[Sampled, ...]":
        """Return the systems that this one is the product of; itself, unless it is one."""
        return self._factors or (self,)

    @property
    def finer(self) -> "Sampled":
        """Return the factor with more digits in ``whole_w``; itself where no more are known.

        With them the gain at w = 0 is exact, a ratio of whole numbers.
        """
        return self if self._finer is None else self._finer()

    @property
    def unsure(self) -> float:
        """Return ``off`` where more digits are known; 0 where the coefficients are all there is."""
        return self.off if self._finer is not None else 0.0

    @property
    def whole_w(self) -> Wholes:
        """Return (num, den, unit): the w-form times unit in whole numbers, exactly; kept.

        Of given z-coefficients it is what these say, of others what the floats of num_w and
        den_w say, or more digits; a plant's hidden modes are in both, exactly, and a product is
        that of these.
        """
        if self._whole is None:
            (num, den), unit = of(self.num_w, self.den_w)
            object.__setattr__(self, "_whole", (num, den, unit))
            return num, den, unit
        return self._whole

    @classmethod
    def made(
        cls, *, num: Poly, den: Poly, dt: float, num_w: Poly, den_w: Poly, delay: int = 0,
        exact: Wholes | None = None, off: float = _A_FLOAT, factors: "tuple[Sampled, ...]" = (),
        finer: "Callable[[], Sampled] | None" = None,
    ) -> "Sampled":  # fmt: skip
        """Return a system whose two forms were computed together, from parameters.

        exact, off, factors  ``whole_w`` where it is more than the floats, and as above
        finer                what computes the same with more digits in ``whole_w``
        """
        system, put = object.__new__(cls), object.__setattr__
        put(system, "num", num if num[0] else poly.trim(num))
        put(system, "den", den if den[0] else poly.trim(den))
        put(system, "dt", dt)
        put(system, "num_w", num_w)
        put(system, "den_w", den_w)
        put(system, "delay", delay)
        put(system, "off", off)
        put(system, "_factors", factors)
        put(system, "_whole", exact)
        put(system, "_finer", finer)
        return system

    def holding(self, exact: Wholes, off: float) -> "Sampled":
        """Return this system with another ``whole_w``, each coefficient off by a part of itself."""
        return Sampled.made(
            num=self.num, den=self.den, dt=self.dt, num_w=_floats(exact[0], exact[2]),
            den_w=_floats(exact[1], exact[2]), delay=self.delay, exact=exact, off=off,
            finer=self._finer,
        )  # fmt: skip

    @classmethod
    def from_w(
        cls, *, num_w: Sequence[float], den_w: Sequence[float], dt: float, delay: int = 0
    ) -> "Sampled":
        """Return the system num_w(w)/den_w(w) z^-delay; z-coefficients scaled to den[0] = 1.

        Raises SpecError for dt <= 0, a negative delay or a denominator of zeros.

        >>> Sampled.from_w(num_w=[1.0], den_w=[1.0, 0.0], dt=2.0)  # 1/w = (z+1)/(z-1)
        Sampled(num=(1.0, 1.0), den=(1.0, -1.0), dt=2.0)
        """
        dt, num_w, den_w = sample_time(dt), in_w("num_w", num_w), in_w("den_w", den_w)
        if type(delay) is not int or delay < 0:
            delay = checks.whole("delay", delay, 0, "count the samples")
        if delay > MOST_DELAY:
            raise SpecError(
                "delay", f"must be {MOST_DELAY} samples or fewer", delay, "sample more slowly"
            )
        n = max(len(num_w), len(den_w))
        num_w, den_w = poly.padded(num_w, n), poly.padded(den_w, n)
        (num, den), unit = of(num_w, den_w)
        return cls._exactly((num, den, unit), dt, delay)

    @classmethod
    def _exactly(
        cls, exact: Wholes, dt: float, delay: int, factors: "tuple[Sampled, ...]" = ()
    ) -> "Sampled":
        """Return the system whose w-form this is; num and den of one length."""
        num, den, unit = exact
        (top, _), (bottom, _) = w_to_z(num, dt), w_to_z(den, dt)  # both times one factor
        for name, part in (("num_w", top), ("den_w", bottom)):
            if not any(part):
                raise SpecError(name, "must not be all zeros", [0.0], "give one coefficient")
        lead = next(filter(None, bottom))
        return cls.made(
            num=_floats(top, lead),
            den=_floats(bottom, lead) + (0.0,) * delay,
            dt=dt,
            num_w=_floats(num, unit),
            den_w=_floats(den, unit),
            delay=delay,
            exact=exact,
            factors=factors,
        )

    @overload
    def at(self, wc: float) -> complex: ...
    @overload
    def at(self, wc: npt.ArrayLike) -> ComplexArray: ...
    def at(self, wc: Any) -> Any:
        """Return the complex gain at wc in rad/s, a number or an array; infinite at a pole.

        >>> abs(Sampled(num=[1], den=[1, -1], dt=1.0).at(np.pi) + 0.5) < 1e-15
        True
        """
        if isinstance(wc, float) and math.isfinite(wc):
            return self._at(wc)
        w = checks.frequencies("wc", wc)
        sin, cos = 2 / self.dt * np.sin(w * self.dt / 2), np.cos(w * self.dt / 2)
        size = np.hypot(sin, cos)
        x, y = 1j * sin / size, cos / size  # v = x/y; Nyquist is y = 0, no overflow there
        top = poly.homogeneous(self.num_w, x, y) * np.exp(-1j * w * self.dt * self.delay)
        value = poly.quotient(top, poly.homogeneous(self.den_w, x, y))
        return complex(value) if w.ndim == 0 else value

    def _at(self, wc: float) -> complex:
        """Return what ``at`` does, for one number."""
        sin, cos = 2 / self.dt * math.sin(wc * self.dt / 2), math.cos(wc * self.dt / 2)
        size = math.hypot(sin, cos)
        x, y = complex(0.0, sin / size), cos / size
        bottom = poly.homogeneous(self.den_w, x, y)
        if bottom == 0:
            return complex(math.inf, 0.0)
        late = cmath.exp(complex(0.0, -wc * self.dt * self.delay)) if self.delay else 1.0
        value = complex(poly.homogeneous(self.num_w, x, y) * late / bottom)
        return value if cmath.isfinite(value) else complex(math.inf, 0.0)

    def __mul__(self, other: "Sampled") -> "Sampled":
        """Return the two in series, of ``whole_w`` nothing rounded; both must have the same dt."""
        if not isinstance(other, Sampled):
            return NotImplemented
        if self.dt != other.dt:
            raise SpecError(
                "dt",
                f"must be the same in both systems ({self.dt!r} s in the first)",
                other.dt,
                "sample both with one clock",
            )
        mine, its = self.whole_w, other.whole_w
        exact = times(mine[0], its[0]), times(mine[1], its[1]), mine[2] * its[2]
        return Sampled._exactly(
            exact, self.dt, self.delay + other.delay, self.factors + other.factors
        )

    def corners(self) -> npt.NDArray[np.float64]:
        """Return the sizes of the zeros and poles in w that are not 0, in rad/s.

        >>> Sampled.from_w(num_w=[1.0, 3.0], den_w=[1.0, 0.5, 0.0], dt=0.1).corners().tolist()
        [3.0, 0.5]
        """
        sizes = np.abs(np.concatenate([poly.roots(self.num_w), poly.roots(self.den_w)]))
        return np.asarray(sizes[sizes > 0])

    def poles(self) -> ComplexArray:
        """Return the poles in z, those of the delay at 0 included."""
        return np.concatenate([roots_in_z(self.den_w, self.dt), np.zeros(self.delay)])

    def zeros(self) -> ComplexArray:
        """Return the finite zeros in z."""
        found = roots_in_z(self.num_w, self.dt)
        # in w a zero at z = infinity is one at 2/dt: those that num does not have are such
        return found[np.argsort(np.abs(found))][: len(self.num) - 1]


def sample_time(dt: object) -> float:
    """Return dt in s, or raise SpecError unless it is positive and finite."""
    return checks.positive("dt", dt, "give the sample time in seconds")


def _floats(values: Sequence[int], unit: int) -> Poly:
    """Return values over unit, each the nearest float."""
    try:
        return tuple([c / unit for c in values])
    except OverflowError:
        raise SpecError(
            "coefficients",
            "must be within a 64-bit float's range in z and in w",
            "beyond 1e308",
            "count time in another unit",
        ) from None
