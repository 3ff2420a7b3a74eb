"""A sampled system as states that move by small steps.

With delta = z - 1 a pole near z = 1 is a small number, kept to its last digit, and a small dt
costs nothing. A pole at z = -1 is no special case. Many poles far from z = 1, those of a long FIR
or of a Smith predictor, have powers of 2 in delta that take each other back: a register has not.
Source: R. H. Middleton and G. C. Goodwin, Digital Control and Estimation: A Unified Approach
(the delta operator); A. V. Oppenheim and R. W. Schafer, Discrete-Time Signal Processing, 3rd ed.,
sec. 6.3 (direct form II).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import comb
from operator import mul

import numpy as np

from zoh.analysis.loop import Array
from zoh.lti import whole
from zoh.lti.systems import Sampled

_FAR = 64  # six poles at z = 0: the coefficients of more cost digits in delta
_GONE = 0.3  # a pole so near to z = 0 may be where it likes
_AT_REST = 1e-9  # of a pole: an integrator's distance from z = 1 is 0, and not to be kept


def realised(system: Sampled) -> tuple[list[float], list[float], float]:
    """Return (a, c, d), the system without its delay as a chain of sums.

    x_0(k+1) = x_0(k) - a x(k) + e(k), x_i(k+1) = x_i(k) + x_{i-1}(k), u = c x + d e.

    >>> realised(Sampled(num=[0.5], den=[1, -0.5], dt=1.0))
    ([0.5], [0.5], 0.0)
    """
    return _sums(*_wholes(system))


@dataclass(slots=True)
class Chain:
    """A chain of sums in a motion, u = c x + d e.

    steps      in the place of x_0 stands its step s = e - a x; a_0 x_0 = e - s - (a_1 x_1 + ...)
    registers  no sums: x_0(k+1) = e(k) - a x(k), x_i(k+1) = x_{i-1}(k)
    swings     whether its states may swing each other up on their way, far beyond what drives them
    """

    a: Sequence[float]
    c: Sequence[float]
    d: float
    steps: bool = False
    registers: bool = False
    swings: bool = False

    @classmethod
    def of(cls, system: Sampled) -> "Chain":
        """Return ``realised`` as a chain, or as a register where that keeps more digits."""
        wholes = _wholes(system)
        return cls._of_far(*wholes) or cls(*_sums(*wholes))

    @classmethod
    def _of_far(cls, num: Sequence[int], den: Sequence[int]) -> "Chain | None":
        """Return the better chain of a system with many poles far from z = 1, None of another.

        num, den  in delta

        >>> Chain.of(Sampled(num=[1, *[0] * 6, 0.5], den=[1, *[0] * 7], dt=1.0)).c  # 1 + z^-7/2
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5]
        """
        lead, size = den[0], sum(map(abs, den)) / abs(den[0])
        if size <= _FAR:
            return None
        (first, *nums), (_, *dens) = _in_z(num), _in_z(den)
        a = [x / lead for x in dens]
        if _spoilt(a) > size * size:
            return cls(*_sums(num, den), swings=True)
        c = [(x * lead - first * y) / (lead * lead) for x, y in zip(nums, dens, strict=True)]
        return cls(a, c, first / lead, registers=True, swings=True)

    @classmethod
    def followed(cls, system: Sampled) -> "Chain":
        """Return the chain whose u loses the fewest digits.

        Beside a fast pole c x takes back most of d e: a PD's gain at rest is wc dt of its d. By
        its step the sum takes nothing back: s is what e moves by, and little more.

        >>> Chain.followed(Sampled(num=[1001.0, -1000.0], den=[1, 0], dt=1e-3))
        Chain(a=[1.0], c=[1000.0], d=1.0, steps=True, registers=False, swings=False)
        """
        num, den = _wholes(system)
        if (far := cls._of_far(num, den)) is not None:
            return far
        (first, *nums), (lead, *dens) = num, den
        second, fast = (nums[0], dens[0]) if dens else (0, 0)
        if abs(second) * lead * lead >= fast * fast * abs(first):  # the step loses as many
            return cls(*_sums(num, den))
        a = [x / lead for x in dens]
        unit = lead * fast
        c = [(x * fast - second * y) / unit for x, y in zip(nums, dens, strict=True)]
        c[0] = (first * fast - second * lead) / unit
        return cls(a, c, second / fast, steps=True)

    def write(self, delta: Array, first: int, enters: Sequence[float]) -> None:
        """Write the states into delta from ``first`` on, in place; e is the row ``enters`` on Z.

        Where the first is a step, what e is made of must have been written before.
        """
        for i in range(first + 1, first + len(self.a)):
            delta[i, i - 1] = 1.0
            if self.registers:
                delta[i, i] = -1.0
        if not self.steps:
            row = [*enters]
            for i, part in enumerate(self.a, first):
                row[i] -= part
            row[first] -= 1.0 if self.registers else 0.0
            delta[first] = row
            return
        fast, *others = self.a
        if others:
            row = [*enters]
            for i, part in enumerate((1.0, *others), first):
                row[i] -= part
            delta[first + 1] = [part / fast for part in row]
        moved = np.array(enters).dot(delta)
        if others:
            moved -= np.array(others).dot(delta[first + 1 : first + len(self.a)])
        moved[first] -= fast
        delta[first] = moved


def _sums(num: Sequence[int], den: Sequence[int]) -> tuple[list[float], list[float], float]:
    """Return (a, c, d) of a fraction in delta as a chain of sums."""
    first, lead = num[0], den[0]
    unit = lead * lead
    # a quotient of whole numbers is rounded once
    a = [x / lead for x in den[1:]]
    c = [(x * lead - first * y) / unit for x, y in zip(num[1:], den[1:], strict=True)]
    return a, c, first / lead


def _wholes(system: Sampled) -> tuple[list[int], list[int]]:
    """Return numerator and denominator in delta, descending, of one length, in whole numbers."""
    *wholes, _ = system.whole_w  # what they have in common cancels
    half = (system.dt / 2).as_integer_ratio()
    num, den = _in_delta(wholes, half)
    for i in range(len(den) - len(system.num)):
        num[i] = 0  # what z says is nothing is not the rounding of w
    return num, den


def _spoilt(a: Sequence[float]) -> float:
    """Return how many roundings a pole's distance from z = 1 is off by, of itself, in a register.

    A part e of every coefficient of z^n + a_1 z^(n-1) + ... moves a simple root by
    e sum |a_i z^(n-i)|/|product of its distances from the others|, to first order.
    Source: J. H. Wilkinson, Rounding Errors in Algebraic Processes, ch. 2.
    """
    roots = np.roots([1.0, *a])
    apart = np.abs(roots[:, None] - roots)
    np.fill_diagonal(apart, 1.0)
    asked = np.abs(roots) > _GONE
    if not asked.any():
        return 0.0
    here, apart = roots[asked], apart[asked]
    from_one = np.abs(here - 1)
    with np.errstate(divide="ignore"):
        moved = (1 + sum(map(abs, a))) / apart.prod(axis=1)
    return float((moved / np.where(from_one > _AT_REST, from_one, 1.0)).max())


def _in_z(a: Sequence[int]) -> list[int]:
    """Return a(delta) in z, descending, delta = z - 1.

    >>> _in_z([1, 0, 0])
    [1, -2, 1]
    """
    return _turned_round(whole.shifted(_turned_round(a)))


def _turned_round(a: Sequence[int]) -> list[int]:
    """Return a(-x), descending."""
    n = len(a) - 1
    return [-c if (n - i) % 2 else c for i, c in enumerate(a)]


def _in_delta(parts: Sequence[Sequence[int]], half: tuple[int, int]) -> list[list[int]]:
    """Return h^n (2 + delta)^n a(w) of each a in delta, w = delta/(h (2 + delta)), h = dt/2.

    They have one length. Times the denominator of h to the n, so that all is whole and nothing is
    rounded.
    """
    n, (p, q) = len(parts[0]) - 1, half
    units, weights, found = [p**j * q ** (n - j) for j in range(n + 1)], _weights(n), []
    for a in parts:
        scaled = [*map(mul, a, units)]
        found.append([sum(map(mul, row, scaled)) for row in weights])
    return found


@lru_cache(maxsize=64)
def _weights(n: int) -> tuple[tuple[int, ...], ...]:
    """Return, by the power that comes out, what delta^(n-j) (2 + delta)^j, j = 0 ... n, has of it.

    >>> _weights(1)  # delta, and 2 + delta
    ((1, 1), (0, 2))
    """
    return tuple(
        tuple(comb(j, k) << k if k <= j else 0 for j in range(n + 1)) for k in range(n + 1)
    )
