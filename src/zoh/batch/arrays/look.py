"""Some loops of many, looked at from near: their signals at any sample, what was seen of them.

Z(k + 2^i) = Z(k) + S Z(k), S doubled i times, goes to any sample in a few products.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from math import ceil, inf, log2

import numpy as np

from zoh.batch.arrays.motion import Motion
from zoh.batch.arrays.rows import Array, Index, Mask, taken
from zoh.batch.tolerances import BAND


@dataclass(slots=True, kw_only=True)
class Seen:
    """What was seen of each loop, y counted in the direction of its final value.

    k_*  samples: of the highest, of those first reaching 10 % and 90 %, of the last outside the
    band; stride_* the stride at which it was met;  crest  what a crest between is not below
    """

    top: Array
    most: Array
    least: Array
    k_top: Array
    k_10: Array
    k_90: Array
    k_out: Array
    stride_10: Array
    stride_90: Array
    stride_out: Array
    crest: Array

    @classmethod
    def of(cls, count: int) -> "Seen":
        """Return what is seen before anything is."""
        start = {"top": -inf, "most": -inf, "least": inf, "crest": -inf}
        return cls(**{f.name: np.full(count, start.get(f.name, -1.0)) for f in fields(cls)})


@dataclass(frozen=True, slots=True, kw_only=True)
class Suspects:
    """Samples k of loops ``who``, Z there, and what y is not above until the next one."""

    who: Index
    k: Array
    z: Array
    bound: Array

    def only(self, keep: Mask) -> "Suspects":
        """Return some of them."""
        return Suspects(
            who=self.who[keep], k=self.k[keep], z=self.z[:, keep], bound=self.bound[keep]
        )

    @classmethod
    def above(cls, found: list["Suspects"], size: int, top: Array) -> "Suspects":
        """Return those of all that may go as high as this; size: of Z."""
        none = cls(
            who=np.zeros(0, np.intp), k=np.zeros(0), z=np.zeros((size, 0)), bound=np.zeros(0)
        )
        some = [none, *(one.only(one.bound >= top[one.who]) for one in found)]
        return cls(
            who=np.concatenate([s.who for s in some]), k=np.concatenate([s.k for s in some]),
            z=np.concatenate([s.z for s in some], axis=1),
            bound=np.concatenate([s.bound for s in some]),
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """Some of the loops, looked at where a long stride met something."""

    delta: Array
    start: Array
    output: Array
    size: Array
    _doubled: list[Array] = field(default_factory=list)

    @classmethod
    def of(cls, motion: Motion, sign: Array, size: Array, who: Index) -> "Part":
        """Return these loops, y counted in the direction of its final value."""
        return cls(
            delta=taken(motion.delta, who), start=taken(motion.start, who),
            output=taken(motion.output, who) * sign[who], size=size[who],
        )  # fmt: skip

    def y(self, z: Array) -> Array:
        """Return y at Z."""
        return along(self.output, z)

    def off(self, z: Array) -> Array:
        """Return how far y is from its final value."""
        return np.abs(self.y(z) - self.size)

    def out(self, z: Array) -> Mask:
        """Return whether y is outside its band."""
        return self.off(z) > BAND * np.abs(self.size)

    def slope(self, z: Array) -> Array:
        """Return by how much y grows to the next sample."""
        return along(self.output, moved(self.delta, z))

    def after(self, z: Array) -> Array:
        """Return Z one sample later."""
        return z + moved(self.delta, z)

    def state(self, k: Array) -> Array:
        """Return Z at sample k, by squaring."""
        z, bits, level = self.start, k.astype(np.int64), 0
        while bits.any():
            if (bits & 1).any():
                z = np.where(bits & 1, z + moved(self.doubled(level), z), z)
            bits >>= 1
            level += 1
        return z

    def doubled(self, level: int) -> Array:
        """Return by what Z moves in 2^level samples; each is worked out once."""
        if not self._doubled:
            self._doubled.append(self.delta)
        while len(self._doubled) <= level:
            self._doubled.append(twice(self._doubled[-1]))
        return self._doubled[level]

    def last(
        self, start: Array, end: Array, holds: Callable[["Part", Array], Mask]
    ) -> tuple[Array, Array]:
        """Return (the last sample before end up to which ``holds`` does from start on, Z there)."""
        k, z = start.copy(), self.state(start)
        furthest = float((end - start).max(initial=1.0))
        for level in range(max(ceil(log2(furthest)), 1) - 1, -1, -1):
            there = z + moved(self.doubled(level), z)
            go = (k + 2.0**level < end) & holds(self, there)
            k, z = np.where(go, k + 2.0**level, k), np.where(go, there, z)
        return k, z


def twice(s: Array) -> Array:
    """Return 2 s + s s: what moves twice as far."""
    out: Array = np.einsum("ijb,jkb->ikb", s, s)
    out += 2 * s
    return out


def moved(s: Array, z: Array) -> Array:
    """Return s z."""
    out: Array = np.einsum("ijb,jb->ib", s, z)
    return out


def along(row: Array, z: Array) -> Array:
    """Return row z."""
    out: Array = np.einsum("jb,jb->b", row, z)
    return out
