"""What is left of each mode of many responses: whether it can still show anything, how it turns."""

from dataclasses import dataclass
from math import inf

import numpy as np

from zoh.batch.arrays.look import Part, Seen, along, moved
from zoh.batch.arrays.rows import Array, Complex, Index, Mask, taken
from zoh.batch.tolerances import BAND, LOST, NEAR, QUIET


@dataclass(frozen=True, slots=True, kw_only=True)
class Modes:
    """Each loop's modes z = 1 + mu, and the weights that tell their amplitudes from n samples.

    With d_i the i-th difference of what moves, d_i = sum_m c_m mu_m^i, so that
    c_m = sum_i weights[m, i] d_i, Lagrange's polynomial through the other modes.
    turn  |log z|, shape (n, B);  creeping  which mode is the slowest and does not swing
    """

    turn: Array
    weights: Complex
    creeping: Mask
    end: Array

    @classmethod
    def of(cls, z: Complex, rows: int) -> "Modes":
        """Return the modes z of motions whose Z has so many rows."""
        decay, turn = -np.log(np.abs(z)), np.abs(np.log(z))
        slowest = np.min(decay, axis=0, initial=inf)
        mu = z - 1
        n = len(mu)
        weights = np.zeros((n, n, mu.shape[1]), complex)
        for m in range(n):
            weights[m, 0] = 1.0
            for other in range(n):
                if other != m:
                    apart = mu[m] - mu[other]
                    weights[m, 1:] = (weights[m, :-1] - mu[other] * weights[m, 1:]) / apart
                    weights[m, 0] *= -mu[other] / apart
        swings = np.abs(np.angle(z)) > 1e-9 * decay
        return cls(
            turn=turn, weights=weights, creeping=(decay == slowest) & ~swings,
            end=np.maximum(8.0, np.ceil(QUIET / np.maximum(slowest, 1e-14)) + 4 * rows),
        )  # fmt: skip

    def look(
        self, who: Index, k: Array, part: Part, effort: Array, at_rest: Array, z: Array,
        seen: Seen,
    ) -> tuple[Mask, Array]:  # fmt: skip
        """Return (which loops can show nothing new, how fast what is left of each still turns)."""
        size, top, most, least = part.size, seen.top[who], seen.most[who], seen.least[who]
        of_y, of_u = self._amplitudes(who, part, [(part.output, size), (effort, at_rest)], z)
        total, higher = self._beyond(who, of_y)
        still = total < NEAR * BAND * size
        with np.errstate(invalid="ignore"):
            still &= (higher <= top - size) | (total <= LOST * size)
            total, higher = self._beyond(who, of_u)
            _, lower = self._beyond(who, -of_u)
            reach = LOST * np.maximum(np.abs(most), np.abs(least))
            still &= (total <= reach) | ((at_rest + higher <= most) & (at_rest - lower >= least))
        alive = (np.abs(of_y) > LOST * size) | (np.abs(of_u) > reach)
        turning = np.max(np.where(alive, taken(self.turn, who), 0.0), axis=0, initial=0.0)
        return still | (k > self.end[who]), turning

    def _amplitudes(
        self, who: Index, part: Part, signals: list[tuple[Array, Array]], z: Array
    ) -> list[Complex]:
        """Return each signal's share of each mode at Z, shape (n, B)."""
        found = [np.zeros((len(self.turn), len(who)), complex) for _ in signals]
        for i in range(len(self.turn)):
            for (row, rest), into in zip(signals, found, strict=True):
                into += taken(self.weights[:, i], who) * (along(row, z) - (0.0 if i else rest))
            z = moved(part.delta, z)
        return found

    def _beyond(self, who: Index, shares: Complex) -> tuple[Array, Array]:
        """Return (a bound on what is left, a bound on how far it can go above its rest).

        What creeps from below outlives the others, and keeps what is left below if it is more.
        """
        sizes, creeping = np.abs(shares), taken(self.creeping, who)
        total = np.sum(sizes, axis=0)
        slow = np.sum(np.where(creeping, shares.real, 0.0), axis=0)
        others = total - np.sum(np.where(creeping, sizes, 0.0), axis=0)
        return total, np.where(others <= -slow, 0.0, others + np.maximum(slow, 0.0))
