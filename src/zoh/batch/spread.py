"""How one number is spread: each spread is the inverse of its distribution function.

So every kind of random sample is made of numbers that are uniform in (0, 1), one for each loop.
Source of the normal's inverse: M. J. Wichura, Algorithm AS 241, Applied Statistics 37 (1988),
routine PPND16; as in ``statistics.NormalDist.inv_cdf``, but for whole arrays.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from zoh import checks
from zoh.errors import SpecError

FloatArray = npt.NDArray[np.float64]

_FURTHEST = np.array([2.0**-106, 1 - 2.0**-53])  # of a Latin hypercube of 2^53 loops


@dataclass(frozen=True, slots=True, kw_only=True)
class Uniform:
    """Anywhere between low and high alike.

    >>> Uniform(low=1.0, high=3.0).at(np.array([0.25]))
    array([1.5])
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        _check_ends(self, checks.number)

    def at(self, u: FloatArray) -> FloatArray:
        """Return the values below which a share u of all lies."""
        return self.low + u * (self.high - self.low)


@dataclass(frozen=True, slots=True, kw_only=True)
class LogUniform:
    """Anywhere between low and high, both above 0, alike in the logarithm.

    >>> LogUniform(low=1.0, high=100.0).at(np.array([0.5])).round(12)
    array([10.])
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        _check_ends(self, checks.positive)

    def at(self, u: FloatArray) -> FloatArray:
        """Return the values below which a share u of all lies."""
        spread: FloatArray = self.low * np.exp(u * np.log(self.high / self.low))
        return spread


@dataclass(frozen=True, slots=True, kw_only=True)
class Normal:
    """Normal with this mean and this standard deviation, which is above 0.

    >>> Normal(mean=10.0, sd=2.0).at(np.array([0.5, 0.8413447460685429])).round(12)
    array([10., 12.])
    """

    mean: float
    sd: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "mean", checks.number("mean", self.mean))
        object.__setattr__(self, "sd", checks.positive("sd", self.sd))
        _check_draws(self, "sd")

    def at(self, u: FloatArray) -> FloatArray:
        """Return the values below which a share u of all lies."""
        return self.mean + self.sd * standard_normal(u)


Spread = Uniform | LogUniform | Normal

_CENTRE = (
    (2509.0809287301226727, 33430.575583588128105, 67265.770927008700853, 45921.953931549871457,
     13731.693765509461125, 1971.5909503065514427, 133.14166789178437745, 3.387132872796366608),
    (5226.495278852545925, 28729.085735721942674, 39307.89580009271061, 21213.794301586595867,
     5394.1960214247511077, 687.1870074920579083, 42.313330701600911252, 1.0),
)  # fmt: skip
_NEAR = (
    (7.7454501427834140764e-4, 0.0227238449892691845833, 0.24178072517745061177,
     1.27045825245236838258, 3.64784832476320460504, 5.7694972214606914055,
     4.6303378461565452959, 1.42343711074968357734),
    (1.05075007164441684324e-9, 5.475938084995344946e-4, 0.0151986665636164571966,
     0.14810397642748007459, 0.68976733498510000455, 1.6763848301838038494,
     2.05319162663775882187, 1.0),
)  # fmt: skip
_FAR = (
    (2.01033439929228813265e-7, 2.71155556874348757815e-5, 0.0012426609473880784386,
     0.026532189526576123093, 0.29656057182850489123, 1.7848265399172913358,
     5.4637849111641143699, 6.6579046435011037772),
    (2.04426310338993978564e-15, 1.4215117583164458887e-7, 1.8463183175100546818e-5,
     7.868691311456132591e-4, 0.0148753612908506148525, 0.13692988092273580531,
     0.59983220655588793769, 1.0),
)  # fmt: skip


def standard_normal(u: FloatArray) -> FloatArray:
    """Return the inverse of the standard normal's distribution function, u inside (0, 1).

    >>> standard_normal(np.array([0.5, 0.975])).round(12)
    array([0.        , 1.95996398])
    """
    q = u - 0.5
    found: FloatArray = q * _ratio(_CENTRE, 0.180625 - q * q)
    (outside,) = np.nonzero(np.abs(q) > 0.425)
    tail = np.sqrt(-np.log(np.minimum(u, 1 - u)[outside]))
    size = np.where(tail <= 5.0, _ratio(_NEAR, tail - 1.6), _ratio(_FAR, tail - 5.0))
    found[outside] = np.copysign(size, q[outside])
    return found


def _ratio(parts: tuple[tuple[float, ...], tuple[float, ...]], x: FloatArray) -> FloatArray:
    top, bottom = (np.polyval(part, x) for part in parts)
    found: FloatArray = top / bottom
    return found


def _check_draws(spread: Spread, name: str) -> None:
    """Raise SpecError, of this argument, where the furthest draws are beyond a float."""
    with np.errstate(all="ignore"):
        finite = np.isfinite(spread.at(_FURTHEST)).all()
    if not finite:
        value, way_out = getattr(spread, name), "give a narrower spread"
        raise SpecError(name, f"must leave every draw of {spread} a float", value, way_out)


def _check_ends(spread: "Uniform | LogUniform", check: Callable[[str, object], float]) -> None:
    for name in ("low", "high"):
        object.__setattr__(spread, name, check(name, getattr(spread, name)))
    if not spread.low < spread.high:
        nothing = "nothing varies between equal ends: leave the key out"
        way_out = nothing if spread.low == spread.high else "swap the two"
        raise SpecError("high", f"must be above low = {spread.low!r}", spread.high, way_out)
    _check_draws(spread, "high")
