"""A linear motion, known at the samples and between them.

The state Z at a sample ends with what drives it: a one, and before it a signal where the drive
is no constant. Everything is linear in Z::

    Z(k+1) = Z(k) + delta Z(k),    y(k, t) = (a row that depends on t) Z(k)

with delta instead of delta + I, so that a small dt costs no digits. A delay too long to be
carried in Z is a queue beside it (see ``queue``).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import atan2, ceil, cos, hypot, inf, log, log1p, sqrt, tau
from operator import itemgetter
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from zoh.analysis.left import farthest
from zoh.analysis.loop import Array
from zoh.analysis.pieces import bernstein
from zoh.analysis.powers import Powers

Indices = npt.NDArray[np.int64]
Number = TypeVar("Number", np.int64, np.float64)

QUIET = 1e-10  # the slowest mode has fallen to this at the horizon: no peak after it has 9 digits
_SLOWEST = 1e-14
_AT_ONCE = 1e6  # the decay of a mode at z = 0
_GONE = 36.0  # exp(-36) of what it was is a rounding of it
_TURN = 0.25  # rad that a mode turns at most from one sample shown to the next
BAND = 0.02  # of its final value around that: in it a response has settled
NEAR = 0.9  # of the band: what creeps on from there has settled
STILL = 1e-4  # of the slowest mode is little enough to speak of rest
_FEW = 2000  # samples cost less to look at than to choose among
_MOST = 1_000_000  # samples shown; a loop that needs more has thousands of swings
_HALF_A_TURN = 3.0  # rad; a pair that turns by more in a sample shows no crest
_MANY = 20_000  # samples shown are dear: before, it is asked whether a metric is among them


@dataclass(slots=True, kw_only=True)
class Stretch:
    """A part of every sample interval over which the output is one Taylor series.

    begin, span  fractions of the sample
    rows         shape (terms, N): the coefficients of ((t - begin)/span)^j, times Z
    """

    begin: float
    span: float
    rows: Array


@dataclass(slots=True, kw_only=True)
class Track:
    """A motion at the samples that show it.

    k, states  which samples, shape (K,), and Z there, shape (N, K), a column a sample
    horizon    the sample to which it is known; after the last shown it only creeps to its rest
    rests      whether what moves has come to rest by the horizon
    """

    k: Indices
    states: Array
    horizon: int
    rests: bool


@dataclass(slots=True, kw_only=True)
class Motion:
    """A linear motion sampled every dt.

    delta      shape (N, N)
    start      shape (N,): Z at k = 0, at rest but for what drives it
    own        how many of the N states are the system's; the others are what drives it
    output     shape (N,): y at the samples; effort likewise for u, None where there is no u
    stretches  the parts of a sample interval; none where nothing is known between the samples
    wait, fed  the effort is back in state ``fed`` ``wait`` samples later; 0 where Z has it all
    swings     whether states are known to swing each other up: powers are had in whole numbers
    """

    dt: float
    delta: Array
    start: Array
    own: int
    output: Array
    effort: Array | None
    stretches: Sequence[Stretch]
    wait: int = 0
    fed: int = 0
    swings: bool = False
    powers: Powers = field(init=False, repr=False)

    def __post_init__(self) -> None:
        whose, effort = "controller", self.effort
        if effort is None:
            whose, effort = "system", np.zeros(len(self.output))
        self.powers = Powers(
            delta=self.delta, own=self.own, seen=np.array([self.output, effort]), whose=whose,
            wholly=self.swings,
        )  # fmt: skip

    def run(self, first: Array, count: int, doublings: int = 0, slowest: float = 0.0) -> Array:
        """Return ``count`` columns, Z at every 2^doublings samples from ``first`` on.

        slowest  the decay per sample of the slowest mode, 0 where that is not known
        """
        return self.powers.run(first, count, doublings, slowest)

    def from_start(self, count: int) -> Array:
        """Return ``count`` columns, Z at every sample from the start on."""
        states = self.run(self.start, count)
        if self.powers.gives_up_floats(states, count):
            states = self.run(self.start, count)
        return states

    def rates(self) -> list[tuple[float, float]]:
        """Return (-log |z|, |log z|) per sample of each own mode z, the fastest last."""
        moved = np.linalg.eigvals(self.delta[: self.own, : self.own]).tolist()
        return sorted([_rate(z) for z in moved], key=itemgetter(1))

    def farthest(self, state: Array) -> float:
        """Return a bound on |y - its rest| at all times from a state on; inf where none is known.

        None is where a mode does not decay or is not told from its neighbour, where what drives
        the motion still moves, and of a queue, whose state is not all there.
        """
        own, moves = self.own, self.delta.dot(state)
        if self.wait or moves[own:].any() or min(self.rates())[0] <= 0:
            return inf
        parts = [bernstein(len(part.rows)).dot(part.rows) for part in self.stretches]
        rows = np.concatenate([self.output[None], *parts])
        return farthest(self.delta[:own, :own], moves[:own], rows[:, :own])

    def track(self, final: float = 0.0) -> Track:
        """Return the motion from its start until its slowest mode is gone; y comes to ``final``.

        Every sample while fast modes live, then as few as show the slow ones; none of one that
        is left alone, does not swing and has y well within its band: that goes from where it is
        to its rest, and no metric is there. Nor is one in the many swings of a pair left alone
        that keeps y well within its band and whose crests have been higher. A mode too slow for
        its eigenvalue to have a sign is followed as far as floats count. Raises SpecError where
        the motion, which comes to rest, outgrows floats: many poles close together, their
        coefficients in one fraction, swing each other up in the rounding.
        """
        try:
            with np.errstate(over="raise", invalid="raise"):
                return self._followed(final)
        except FloatingPointError:
            if self.powers.wholly:
                raise self.powers.swung_up() from None
        self.powers.wholly = True
        return self.track(final)

    def _followed(self, final: float) -> Track:
        """Return the motion from its start until its slowest mode is gone."""
        rates = self.rates()
        slowest = max(min(rates, default=(inf, inf))[0], _SLOWEST)
        end = max(8, ceil(-log(QUIET) / slowest) + 4 * len(self.delta))
        ks, zs, k, z, shown, left = [], [], 0, self.start, 0, False
        while k <= end and shown < _MOST:
            alone, doublings, until = _pace(rates, k, end)
            stride = 1 << doublings
            left = alone and abs(float(self.output.dot(z)) - final) < NEAR * BAND * abs(final)
            if (until - k) >> doublings > _MANY and not left:
                passed = _crests(rates, end)
                left = k >= passed and self.farthest(z) < NEAR * BAND * abs(final)
                until = until if k >= passed else min(until, passed)
            if left:
                k += stride * (-(-(end - k) // stride) + 1)
                break
            count = min(-(-(until - k) // stride) + 1, _MOST - shown)
            states = self.run(z, count + 1, doublings, slowest)
            ks.append(np.arange(k, k + stride * count + 1, stride))
            zs.append(states)
            k, z, shown = k + stride * count, states[:, -1], shown + count
        if not zs:
            ks, zs = [np.array([0])], [z[:, None]]
        states = _joined(zs, left)
        if self.powers.gives_up_floats(states, k):
            return self._followed(final)
        return Track(
            k=_joined(ks, left), states=states, horizon=k - stride, rests=slowest * k > -log(STILL)
        )


def _joined(parts: list[npt.NDArray[Number]], left: bool) -> npt.NDArray[Number]:
    """Return the parts as one, without the last of each, which is the first of the next.

    left  whether the motion is left alone at the last of all, so that it is the first of none
    """
    last = parts[-1] if left else parts[-1][..., :-1]
    if len(parts) == 1:  # mostly
        return last
    return np.concatenate([*(part[..., :-1] for part in parts[:-1]), last], axis=-1)


def _rate(moved: complex) -> tuple[float, float]:
    """Return (decay, size of the logarithm) of the mode z = 1 + moved."""
    x, y = moved.real, moved.imag
    size = x * (2 + x) + y * y  # |z|^2 - 1
    if size <= -1:
        return _AT_ONCE, _AT_ONCE
    decay = -log1p(size) / 2
    return decay, hypot(decay, atan2(y, 1 + x))


def _pace(rates: list[tuple[float, float]], k: int, end: int) -> tuple[bool, int, int]:
    """Return (alone, doublings of the stride from sample k on, the sample until which it is kept).

    One mode alone that does not swing has no crest, and a few samples show it.
    """
    alive = [(decay, turn) for decay, turn in rates if decay * k <= _GONE]
    alone = len(alive) == 1 and alive[0][0] == alive[0][1]
    doublings = 0
    if end > _FEW:
        fastest = 0.0 if alone or not alive else alive[-1][1]
        most = max(1, (end - k) // (4 if alone else 32))
        doublings = min(max(int(_TURN / max(fastest, _TURN / most)).bit_length() - 1, 0), 60)
    over = [_GONE / decay for decay, turn in alive if decay > 0 and turn > _TURN / (4 << doublings)]
    until = min(end, max(k + 1, ceil(min(max(over, default=end), end))))
    return alone, doublings, until


def _crests(rates: list[tuple[float, float]], end: int) -> int:
    """Return the sample from which on the crests of the slowest pair, alone, have been higher.

    An output, at the samples or a part of one after each, is its rest and A r^k cos(x k + p). In
    each turn some sample is half a step or less from the crest, at least cos(x/2) of it; what r^k
    makes less than that is less than what was seen. ``end`` where no pair is left alone before.
    """
    (decay, size), *others = sorted(rates)
    if not others or others[0] != (decay, size):
        return end
    step = sqrt(max(size * size - decay * decay, 0.0))
    if decay <= 0 or not 0 < step < _HALF_A_TURN:
        return end
    alone = max([_GONE / fast for fast, _ in others[1:]], default=0.0)
    return ceil(min(end, alone + 1 + tau / step - log(cos(step / 2)) / decay))
