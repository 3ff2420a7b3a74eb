"""Where samples were left out, those that a metric may need are put in again.

What moves in a wide stretch is slow: a mode turns by a quarter of a radian at most from one
sample shown to the next, so a few points show where in it to look.
"""

import numpy as np

from zoh.analysis.loop import Array
from zoh.analysis.motion import Indices, Motion, Track

_LOSS = 0.01  # of what moves: a crest rises by less between samples a quarter radian apart
_LOOKED = 40  # the first crests, and the highest, that are looked at among many
_BAND = 0.02


def wanted(k: Indices, y: Array, u: Array, final: float) -> list[int]:
    """Return the rows before which samples were left out that a metric may need."""
    if k[-1] - k[0] < len(k):
        return []
    coarse = np.diff(k) > 1
    begin = int(coarse.argmax())
    marks = _crests(y, begin) | _crests(u, begin)
    size, up = abs(final), y if final >= 0 else -y
    if up[: begin + 1].max() < 0.9 * size:
        marks.update(int((up >= level * size).argmax()) for level in (0.1, 0.9))
    band = _BAND * size
    if max(y[begin:].max() - final, final - y[begin:].min()) > (1 - _LOSS) * band:
        off = np.abs(y - final)
        outside = (off > band).nonzero()[0]
        after = int(outside[-1]) if len(outside) else 0
        near = (off[after:] > (1 - _LOSS) * band).nonzero()[0]
        marks.update((after + near[:_LOOKED]).tolist(), [after])
    rows = {j for i in marks for j in (i - 1, i) if begin <= j < len(coarse)}
    return sorted(j for j in rows if coarse[j])


def _crests(a: Array, begin: int) -> set[int]:
    """Return the rows from ``begin`` on where a may be the largest or the least of all."""
    early, late = a[: begin + 1], a[begin:]
    top, bottom = float(late.max()), float(late.min())
    slack = _LOSS * (top - bottom)
    found: set[int] = set()
    if top + slack > early.max():
        found |= _tops(late, top - slack)
    if bottom - slack < early.min():
        found |= _tops(-late, -bottom - slack)
    return {begin + i for i in found}


def _tops(a: Array, level: float) -> set[int]:
    """Return where a has its tops above a level, the first ones and the highest."""
    high = (a >= level).nonzero()[0]
    inner = high[(high > 0) & (high < len(a) - 1)]
    inner = inner[(a[inner] >= a[inner - 1]) & (a[inner] >= a[inner + 1])]
    best = inner[(-a[inner]).argsort(kind="stable")]
    return {int(a.argmax()), *inner[:_LOOKED].tolist(), *best[:_LOOKED].tolist()}


def filled(motion: Motion, track: Track, rows: list[int]) -> Track:
    """Return the track with 15 to 31 samples more, or all, after each of these rows.

    What is left in a wide stretch is slow, so a few points show where in it to look next.
    """
    k, states = track.k, track.states
    ks, zs, at = [], [], 0
    for i in rows:
        ks.append(k[at : i + 1])
        zs.append(states[:, at : i + 1])
        gap = int(k[i + 1] - k[i])
        doublings = max(0, gap.bit_length() - 5)
        count = -(-gap >> doublings)  # rounded up, so that the row itself and these fill the gap
        ks.append(k[i] + (np.arange(1, count) << doublings))
        zs.append(motion.run(states[:, i], count, doublings)[:, 1:])
        at = i + 1
    ks.append(k[at:])
    zs.append(states[:, at:])
    return Track(k=np.concatenate(ks), states=np.concatenate(zs, axis=1), rests=track.rests)
