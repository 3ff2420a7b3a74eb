"""What is left of each mode of many responses: whether it can still show anything, how it turns."""

from dataclasses import dataclass
from math import inf

import numpy as np

from zoh.batch.arrays.look import Seen, moved
from zoh.batch.arrays.rows import Array, Complex, Index, Mask, taken
from zoh.batch.tolerances import BAND, GONE, LOST, NEAR, NOTHING, QUIET, REST, SHOWN, TURN


@dataclass(frozen=True, slots=True, kw_only=True)
class Modes:
    """Each loop's modes z = 1 + mu, and the weights that tell their amplitudes from n samples.

    With d_i the i-th difference of what moves, d_i = sum_m c_m mu_m^i, so that
    c_m = sum_i weights[m, i] d_i, Lagrange's polynomial through the other modes.
    turn  |log z|, shape (n, B);  weights  real and imaginary parts, shape (2, n, n, B)
    creeping  which mode is the slowest and does not swing
    """

    turn: Array
    weights: Array
    creeping: Mask
    end: Array

    @classmethod
    def of(cls, z: Complex, rows: int) -> "Modes":
        """Return the modes z of motions whose Z has so many rows."""
        log_z = np.log(z)
        decay = -log_z.real
        slowest = np.min(decay, axis=0, initial=inf)
        mu = z - 1
        n = len(mu)
        weights = np.zeros((n, n, mu.shape[1]), complex)
        for m in range(n):
            weights[m, 0] = 1.0
            for other in range(n):
                if other != m:
                    part = 1 / (mu[m] - mu[other])
                    weights[m, 1:] = (weights[m, :-1] - mu[other] * weights[m, 1:]) * part
                    weights[m, 0] *= -mu[other] * part
        swings = np.abs(log_z.imag) > 1e-9 * decay
        return cls(
            turn=np.abs(log_z), weights=np.stack([weights.real, weights.imag]),
            creeping=(decay == slowest) & ~swings,
            end=np.maximum(8.0, np.ceil(QUIET / np.maximum(slowest, 1e-14)) + 4 * rows),
        )  # fmt: skip

    def look(
        self, who: Index, k: Array, delta: Array, signals: Array, rest: Array, z: Array, seen: Seen
    ) -> tuple[Mask, Array]:
        """Return (which loops can show nothing new, how fast what is left of each still turns).

        signals, rest  rows on Z of y and u, shape (2, N, B), and what they settle to, (2, B)
        """
        size, at_rest = rest
        top, most, least = seen.top[who], seen.most[who], seen.least[who]
        real, imag = self._shares(who, delta, signals, rest, z)
        sizes = np.sqrt(real * real + imag * imag)
        total, higher, lower = self._beyond(who, real, sizes)
        with np.errstate(invalid="ignore"):
            lost = LOST * np.stack([size, np.maximum(np.abs(most), np.abs(least))])
            still = total[0] < NEAR * BAND * size
            still &= (higher[0] <= top - size) | (total[0] <= NOTHING * size)
            inside = (at_rest + higher[1] <= most) & (at_rest - lower[1] >= least)
            still &= (total[1] <= lost[1]) | inside
            alive = (sizes > lost).any(axis=1)
        turning = np.max(np.where(alive, taken(self.turn, who), 0.0), axis=0, initial=0.0)
        return still | (k > self.end[who]), turning

    def _shares(self, who: Index, delta: Array, signals: Array, rest: Array, z: Array) -> Array:
        """Return each mode's share of each signal at Z, (real and imaginary, modes, signals, B)."""
        n = len(self.turn)
        moves = np.empty((n, *rest.shape))
        for i in range(n):
            np.einsum("sjb,jb->sb", signals, z, out=moves[i])
            z = moved(delta, z) if i + 1 < n else z
        moves[:1] -= rest
        shares: Array = np.einsum("cmib,isb->cmsb", taken(self.weights, who), moves)
        return shares

    def _beyond(self, who: Index, real: Array, sizes: Array) -> tuple[Array, Array, Array]:
        """Return (a bound on what is left, bounds on how far it can go above its rest and below).

        What creeps from below outlives the others, and keeps what is left below if it is more.
        """
        creeping = taken(self.creeping, who)[:, None]
        total = np.sum(sizes, axis=0)
        slow = np.sum(np.where(creeping, real, 0.0), axis=0)
        others = total - np.sum(np.where(creeping, sizes, 0.0), axis=0)
        higher, lower = (
            np.where(others <= -side, 0.0, others + np.maximum(side, 0.0)) for side in (slow, -slow)
        )
        return total, higher, lower


def restless(z: Complex) -> Mask:
    """Return which motions the single design may not follow to their rest.

    Whether such a motion has settled is for a bound on what is left of it to say. The single
    design's stride is TURN of the fastest mode that lives, rounded down to a power of 2, and may be
    kept until one that turns a quarter as fast has gone: so TURN/8 is the least. What swings is a
    pair that is followed once.
    """
    log_z = np.log(z)
    decay, turn = np.maximum(-log_z.real, 1e-14), np.abs(log_z)
    rest = REST / np.min(decay, axis=0, initial=inf)
    shown = np.minimum(GONE / decay, rest) * np.minimum(1.0, turn * (8 / TURN))
    found: Mask = np.sum(np.where(np.abs(log_z.imag) > decay, shown / 2, shown), axis=0) > SHOWN
    return found
