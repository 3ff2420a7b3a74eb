"""How a linear motion moves by 2^i samples: in floats, in whole numbers where floats lose too much.

Squaring S with Z(k + 2^i) = Z(k) + S Z(k) costs few digits as long as each state is made of little
more than itself. Many poles close together, a chain of integrators with as many leads, swing each
other up on the way: a state is then what is left of numbers far above it, and floats square them.
Source: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., sec. 18.1 (powers of
a matrix in floats).
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from math import inf, isfinite
from typing import Any

import numpy as np

from zoh.analysis.loop import Array
from zoh.errors import SpecError

_BITS = 320  # of the powers of what swings: those of a float, and what they grow by, squared
_EXPONENTS = 1023  # octaves above 1 that a float has
_FEW = 4  # states have little room to swing each other up: two leads on 1/s^2 lost 8e-9 at most
_SWINGS = 64.0  # of its size a state is made of: so far floats square it and keep 11 digits
_SWUNG_UP = 1e8  # of its size what is seen is made of: floats leave 8 digits of it
_WORTH = 3_000_000  # products of whole numbers, half a second; a chain of delays needs more
_PLAIN = 1e-3  # a decay per step that I + S holds to 13 digits: S by itself need not be kept
_ALONE = 1 << 18  # multiplications that OpenBLAS does not share out among threads
_DOUBLINGS = 200  # of the terms of a sum
_ALL = 10**17  # times what comes next is a sum's all


@dataclass(slots=True, kw_only=True)
class Powers:
    """The powers of I + delta, delta of shape (N, N).

    own     how many of the N states are the system's; the others are what drives it
    seen    rows on Z, shape (R, N): what is asked of the motion, its output and its effort
    whose   what a refusal calls it
    wholly  whether powers are had in whole numbers
    """

    delta: Array
    own: int
    seen: Array
    whose: str
    wholly: bool = False
    _small: list[Array] = field(default_factory=list, repr=False)
    _wholes: list[Any] = field(default_factory=list, repr=False)
    _taken: dict[int, Array] = field(default_factory=dict, repr=False)

    def small(self, i: int) -> Array:
        """Return S with Z(k + 2^i) = Z(k) + S Z(k), in floats."""
        powers = self._small
        if not powers:
            powers.append(self.delta)
        while len(powers) <= i:
            s = powers[-1]
            powers.append(s + s + s.dot(s))
        return powers[i]

    def whole(self, i: int) -> Any:
        """Return S 2^_BITS, shape (N, N), in whole numbers; raise SpecError beyond floats."""
        if not self._wholes:
            self._wholes.append(_whole(self.delta))
        while len(self._wholes) <= i:
            s = self._wholes[-1]
            s = s + s + (s.dot(s) >> _BITS)
            if max(x.bit_length() for x in s.flat) >= _BITS + _EXPONENTS:
                raise self.swung_up()
            self._wholes.append(s)
        return self._wholes[i]

    def _rounded(self, i: int) -> Array:
        """Return (I + S)' of 2^i samples, rounded once."""
        one = 1 << _BITS
        rows = (self.whole(i).T + one * np.eye(len(self.delta), dtype=object)).tolist()
        return np.array([[x / one for x in row] for row in rows])

    def run(self, first: Array, count: int, doublings: int = 0, slowest: float = 0.0) -> Array:
        """Return ``count`` columns, Z at every 2^doublings samples from ``first`` on.

        slowest  the decay per sample of the slowest mode, 0 where that is not known
        """
        out = np.empty((count, len(first)))  # a row a sample: what is next to come is one block
        out[0], done, step = first, 1, None
        if self.wholly:  # one after the other: of a longer way the roundings swing up, too
            self._step_wholly(out, doublings)
            return out.T
        few = count * self.delta.size <= _ALONE  # nearly always
        product = np.ndarray.dot if few else _products
        while done < count:
            after = min(2 * done, count)
            known, block = out[: after - done], out[done:after]
            if slowest * (1 << doublings) < _PLAIN:
                moved = self.small(doublings).T
                self._taken[doublings] = moved
                product(known, moved, block)
                block += known
            else:
                step = _one_and(self.small(doublings)) if step is None else step.dot(step)
                self._taken[doublings] = step
                product(known, step, block)
            done, doublings = after, doublings + 1
        return out.T

    def _exact(self, size: int) -> bool:
        """Return whether so many numbers are stepped to in whole numbers."""
        return size * len(self.delta) <= _WORTH

    def _step_wholly(self, out: Array, doublings: int) -> None:
        """Write rows after the first, each 2^doublings samples after the one before it."""
        if not self._exact(out.size):
            step = self._rounded(doublings)
            for here, there in pairwise(out):
                here.dot(step, out=there)
            return
        z, s, one = _whole(out[0]), self.whole(doublings), 1 << _BITS
        try:
            for there in out[1:]:
                z = z + (s.dot(z) >> _BITS)
                there[:] = [x / one for x in z]
        except OverflowError:
            raise self.swung_up() from None

    def gives_up_floats(self, states: Array, count: int) -> bool:
        """Return whether floats have lost digits of states, shape (N, K), within so many samples.

        From then on powers are had in whole numbers: what was had in floats is to be had again.
        Raises SpecError where that, too, is in vain.
        """
        if self.wholly:
            swings = self._left_of(states)
            if not self._exact(states.size):
                self.whole(count.bit_length() - 1)
                swings = max(swings, self._swing_by(states))
            if not swings < _SWUNG_UP:
                raise self.swung_up()
        elif self.own > _FEW:
            self.wholly = not self._swing_by(states) < _SWINGS
            return self.wholly
        return False

    def _left_of(self, states: Array) -> float:
        """Return how many times its size what is seen of exact states is made of, in floats."""
        reach, sizes = np.abs(states).max(axis=1), np.abs(self.seen.dot(states)).max(axis=1)
        return _times(np.abs(self.seen).dot(reach), sizes)

    def _swing_by(self, states: Array) -> float:
        """Return how many times its own size a state is made of on its way, at most.

        A rounding of what it is made of is so many roundings of the state: see ``_shown`` for
        where that is no loss.
        """
        # "C": the numbers of a state side by side, where their largest is found in no time
        reach = np.abs(states, order="C").max(axis=1)
        return self._most(reach, lambda: np.abs(self.seen.dot(states)).max(axis=1))

    def _most(self, reach: Array, sizes: Callable[[], Array]) -> float:
        """Return what ``_swing_by`` does of states and of rows that reach so far."""
        ways = [*self._taken.values()]
        if self.wholly:
            ways = [self._rounded(i) for i in range(len(self._wholes))]
        if not all(map(isfinite, reach.tolist())):
            return inf
        if not ways:
            return 0.0
        made_of = reach.dot(np.abs(np.array(ways))).max(axis=0)
        swings = _times(made_of, reach)
        return swings if swings < _SWINGS else min(swings, self._shown(ways, made_of, sizes()))

    def _shown(self, ways: list[Array], made_of: Array, sizes: Array) -> float:
        """Return how many times its size what is seen is made of, now and a way later."""
        one = np.eye(len(made_of))
        later = [self.seen.dot(w.T) for w in (one, *ways, *(w + one for w in ways))]
        return _times(np.abs(np.array(later)).max(axis=0).dot(made_of), sizes)

    def sum_of_squares(self, start: Array) -> Array:
        """Return sum over k of (r Z(k))^2 for each row r that is seen, Z(0) = ``start``.

        By doubling the number of terms. ``start`` has nothing of what drives the motion for ever.
        """
        known, self.wholly = self.wholly, False
        total = self._sum_in_floats(start)
        squares = np.asarray(np.einsum("ij,jk,ik->i", self.seen, total, self.seen))
        reach, sizes = np.sqrt(np.abs(total.diagonal())), np.sqrt(np.abs(squares))
        enough = self._most(reach, lambda: sizes) < _SWINGS
        self.wholly = known
        return squares if enough else self._sum_in_wholes(start)

    def _sum_in_floats(self, start: Array) -> Array:
        """Return sum over k of Z(k) Z(k)'."""
        total = np.outer(start, start)
        with np.errstate(over="ignore", invalid="ignore"):  # what comes of it is seen to be lost
            for i in range(_DOUBLINGS):
                s = self.small(i)
                self._taken[i] = s.T
                moved = total + s @ total
                added = moved + moved @ s.T
                # each state beside its own sum: a weak loop moves its plant by next to nothing
                if (added.diagonal() <= total.diagonal() / _ALL).all():
                    break
                total = total + added
        return total

    def _sum_in_wholes(self, start: Array) -> Array:
        """Return what ``sum_of_squares`` does, exact but for where 2^-_BITS ends."""
        z, by_row = _whole(start[:, None]), _whole(self.seen)
        total = z.dot(z.T)  # in units of 2^(-2 _BITS)
        for i in range(_DOUBLINGS):
            s = self.whole(i)
            moved = total + (s.dot(total) >> _BITS)
            added = moved + (moved.dot(s.T) >> _BITS)
            if (added.diagonal() * _ALL <= total.diagonal()).all():
                break
            total = total + added
        squares = (by_row.dot(total) >> _BITS).dot(by_row.T).diagonal() >> _BITS
        try:
            return np.array([max(x, 0) / (1 << 2 * _BITS) for x in squares])
        except OverflowError:
            raise self.swung_up() from None

    def swung_up(self) -> SpecError:
        """Return the refusal of what cannot be followed."""
        return SpecError(
            self.whose,
            "must have a response that can be followed in 64-bit floats",
            f"{self.own} states that swing each other up",
            "use fewer sections, or spread them wider",
        )


def _times(parts: Array, sizes: Array) -> float:
    """Return how many times a size its parts are, at most; what is nothing has none."""
    return float((parts / np.where(sizes > 0, sizes, inf)).max())


def _whole(s: Array) -> Any:
    """Return floats times 2^_BITS as whole numbers, to be multiplied without rounding."""
    out = np.empty(s.shape, object)
    for place, x in np.ndenumerate(s):
        top, bottom = float(x).as_integer_ratio()
        out[place] = (top << _BITS) // bottom
    return out


def _products(rows: Array, s: Array, out: Array) -> None:
    """Write rows s, as many at a time as BLAS takes on one thread: two of them mostly wait."""
    most = max(1, _ALONE // s.size)
    for first in range(0, len(rows), most):
        part = slice(first, first + most)
        rows[part].dot(s, out=out[part])


def _one_and(s: Array) -> Array:
    """Return (I + S)', which takes a row from one sample to the next."""
    whole = s.T.copy()
    whole.flat[:: len(s) + 1] += 1.0
    return whole
