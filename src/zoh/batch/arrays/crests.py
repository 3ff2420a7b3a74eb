"""Crests that a long stride may have stepped over: noted as they pass, closed in on at the end.

Three samples in a row of which the middle one is the highest have a crest between the outer ones.
Those that may matter are few: a crest whose samples stay 2 % below the highest is not the highest.
"""

from dataclasses import dataclass, field
from math import inf

import numpy as np

from zoh.batch.arrays.look import Part, Seen
from zoh.batch.arrays.motion import Motion
from zoh.batch.arrays.rows import Array, Index, Mask, taken
from zoh.batch.tolerances import BAND, BELOW, CREST


@dataclass(frozen=True, slots=True, kw_only=True)
class Crests:
    """Crests of a signal: of which loops, between which samples, how high the one in the middle."""

    who: Index
    start: Array
    end: Array
    height: Array

    @classmethod
    def of(cls, who: Index, k: Array, signal: Array, above: Array) -> "Crests":
        """Return those higher than ``above`` in rows of samples k, shape (rows, B)."""
        middle = signal[1:-1]
        row, lane = np.nonzero((middle >= signal[:-2]) & (middle > signal[2:]) & (middle > above))
        return cls(
            who=who[lane], start=k[row, lane], end=k[row + 2, lane], height=middle[row, lane]
        )

    def only(self, keep: Mask | Index) -> "Crests":
        """Return some of them."""
        return Crests(
            who=self.who[keep], start=self.start[keep], end=self.end[keep],
            height=self.height[keep],
        )  # fmt: skip


@dataclass(slots=True, kw_only=True)
class Passed:
    """The last two samples of each loop, and the crests met at strides of more than one."""

    k: Array
    y: Array
    u: Array
    of_y: list[Crests] = field(default_factory=list)
    of_band: dict[float, list[Crests]] = field(default_factory=lambda: {1.0: [], -1.0: []})
    of_u: dict[float, list[Crests]] = field(default_factory=lambda: {1.0: [], -1.0: []})

    @classmethod
    def of(cls, count: int) -> "Passed":
        """Return what has passed before anything has."""
        return cls(k=np.zeros((2, count)), y=np.zeros((2, count)), u=np.zeros((2, count)))

    def note(
        self, who: Index, ys: Array, us: Array, k: Array, stride: float, size: Array, top: Array,
        seen: Seen,
    ) -> None:  # fmt: skip
        """Note the samples of a block, k the first of them; top is the highest before it."""
        ks = k + stride * np.arange(len(ys))[:, None]
        if stride > 1:
            ks, y, u = (
                np.concatenate([taken(old, who), new])
                for old, new in ((self.k, ks), (self.y, ys), (self.u, us))
            )
            self.of_y.append(Crests.of(who, ks, y, top - BELOW * size))
            for side in (1.0, -1.0):
                off, best = side * (y - size), side * (seen.most if side > 0 else seen.least)[who]
                self.of_band[side].append(Crests.of(who, ks, off, CREST * BAND * size))
                self.of_u[side].append(Crests.of(who, ks, side * u, best - BELOW * np.abs(best)))
        self.k[:, who], self.y[:, who], self.u[:, who] = ks[-2:], ys[-2:], us[-2:]


@dataclass(frozen=True, slots=True, kw_only=True)
class Late:
    """Crests of responses met at a long stride: the sample before each, Z there and Z after it."""

    who: Index
    k: Array
    z: Array
    after: Array


def highest(motion: Motion, sign: Array, size: Array, seen: Seen, passed: Passed) -> Late:
    """Raise ``seen`` to the crests of y and of u; return those of y."""
    for side, best, raised in (
        (1.0, seen.most, np.maximum), (-1.0, seen.least, np.minimum),
    ):  # fmt: skip
        crests = _joined(passed.of_u[side], side * best - BELOW * np.abs(best))
        part = _part(motion, side * motion.effort, size, crests)
        _, z = _crest(part, crests)
        raised.at(best, crests.who, side * part.y(part.after(z)))
    crests = _joined(passed.of_y, seen.top - BELOW * size)
    part = _part(motion, sign * motion.output, size, crests)
    k, z = _crest(part, crests)
    after = part.after(z)
    top = part.y(after)
    order = np.argsort(top)  # of two of one loop the higher is written last
    order = order[top[order] > seen.top[crests.who[order]]]
    seen.top[crests.who[order]], seen.k_top[crests.who[order]] = top[order], k[order] + 1
    return Late(who=crests.who, k=k, z=z, after=after)


def earlier(
    motion: Motion, sign: Array, size: Array, passed: Passed, level: float, places: Array
) -> None:
    """Move the first samples as high as a level to crests that were so for less than a stride."""
    crests = _joined(passed.of_y, (level - BELOW) * size)
    first = np.where(places < 0, inf, places)
    crests = crests.only(
        (crests.height < level * size[crests.who]) & (crests.start < first[crests.who])
    )
    part = _part(motion, sign * motion.output, size, crests)
    k, z = _crest(part, crests)
    (high,) = np.nonzero(part.y(part.after(z)) >= level * part.size)
    again = _part(motion, sign * motion.output, size, crests.only(high))
    k = again.last(crests.start[high], k[high] + 1, lambda p, z: p.y(z) < level * p.size)[0]
    np.minimum.at(first, crests.who[high], k + 1)
    places[:] = np.where(np.isinf(first), places, first)


def later(motion: Motion, sign: Array, size: Array, seen: Seen, passed: Passed) -> None:
    """Move the last sample outside the band to where a crest left it for less than a stride."""
    for side in (1.0, -1.0):
        crests = _joined(passed.of_band[side], np.zeros(len(size)))
        crests = crests.only(crests.end > seen.k_out[crests.who])
        part = _part(motion, side * sign * motion.output, side * size, crests)
        k, z = _crest(part, crests)
        (left,) = np.nonzero(part.out(part.after(z)))
        again = _part(motion, side * sign * motion.output, side * size, crests.only(left))
        k = again.last(k[left] + 1, crests.end[left], Part.out)[0]
        np.maximum.at(seen.k_out, crests.who[left], k)


def _joined(found: list[Crests], above: Array) -> Crests:
    """Return all of these whose sample is above what is given of its loop."""
    none = Crests(who=np.zeros(0, np.intp), start=np.zeros(0), end=np.zeros(0), height=np.zeros(0))
    every = [none, *found]
    crests = Crests(
        who=np.concatenate([c.who for c in every]), start=np.concatenate([c.start for c in every]),
        end=np.concatenate([c.end for c in every]),
        height=np.concatenate([c.height for c in every]),
    )  # fmt: skip
    return crests.only(crests.height > above[crests.who])


def _part(motion: Motion, row: Array, size: Array, crests: Crests) -> Part:
    who = crests.who
    return Part(
        delta=taken(motion.delta, who), start=taken(motion.start, who), output=taken(row, who),
        size=size[who],
    )  # fmt: skip


def _crest(part: Part, crests: Crests) -> tuple[Array, Array]:
    """Return (the last sample that is left upwards, Z there)."""
    return part.last(crests.start, crests.end, lambda p, z: p.slope(z) > 0)
