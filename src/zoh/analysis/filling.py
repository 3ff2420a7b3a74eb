"""Where samples were left out, those that a metric may need are put in again.

What moves in a wide stretch is slow: a mode turns by a quarter of a radian at most from one
sample shown to the next, so a few points show where in it to look.
"""

from dataclasses import replace

import numpy as np

from zoh.analysis.loop import Array
from zoh.analysis.motion import NEAR, Indices, Motion, Track

_LOOKED = 40  # the first crests, and the highest, that are looked at among many
_AS_DEAR = 1000  # samples that cost as much to look at as one row does to fill
_ROUNDING = 1e-13  # of the largest: a crest that stands out by less does not


def leaves_out(k: Indices) -> bool:
    """Return whether samples between these are left out."""
    return int(k[-1]) - int(k[0]) >= len(k)


def wanted(k: Indices, seen: Array, final: float, band: float) -> list[int]:
    """Return the rows before which samples were left out that a metric may need.

    seen  output and effort at the samples k, and bounds of the output over each, shape (2 or 4, K)
    band  where the output is last further than this from ``final`` is looked for
    """
    if not leaves_out(k):
        return []
    coarse = k[1:] - k[:-1] > 1
    begin = int(coarse.argmax())
    early, late = seen[:, : begin + 1], seen[:, begin:]
    ends = [a.tolist() for a in (early.max(1), early.min(1), late.max(1), late.min(1))]
    marks: set[int] = set()
    for a, top, bottom, late_top, late_bottom in zip(seen, *ends, strict=True):
        near = 0.1 * (late_top - late_bottom)  # a crest rises by far less
        if late_top + near > top:
            marks |= _crests(k, a, begin, max(top, late_top))
        if late_bottom - near < bottom:
            marks |= _crests(k, -a, begin, -min(bottom, late_bottom))
    y, size = seen[0], abs(final)
    if (ends[0][0] if final >= 0 else -ends[1][0]) < 0.9 * size:
        up = y if final >= 0 else -y
        for level in (0.1, 0.9):
            marks |= _reaching(k, up, begin, level * size)
    if max(ends[2][0] - final, final - ends[3][0]) > NEAR * band:
        off = np.abs(y - final)
        outside = (off > band).nonzero()[0]
        after = int(outside[-1]) if len(outside) else 0
        marks |= {after} | _crests(k, off, max(after, begin), band)
    rows = {j for i in marks for j in (i - 1, i) if begin <= j < len(coarse)}
    return sorted(j for j in rows if coarse[j])


def _reaching(k: Indices, a: Array, begin: int, level: float) -> set[int]:
    """Return the rows beside which a may be as high as a level for the first time.

    That is the first of those shown, or a crest before it that is as high between two of them.
    """
    first = int((a >= level).argmax())
    until = first if a[first] >= level else len(a) - 1
    before = _crests(k[: until + 1], a[: until + 1], begin, level) if until > begin else set()
    return before | {first}


def _crests(k: Indices, a: Array, begin: int, level: float) -> set[int]:
    """Return the rows from ``begin`` on beside which a has a crest above a level."""
    first = {0} if begin == 0 and _first_may(k, a, level) else set()
    return _tops(k, a, begin, level) | first


def _tops(k: Indices, a: Array, begin: int, level: float) -> set[int]:
    """Return the rows from ``begin`` on beside which a has a crest above a level.

    The first ones and the highest. What is bent downwards stays below its chords' extensions.
    """
    left = max(begin, 1)
    steps = a[left:] - a[left - 1 : -1]
    crests = ((steps[:-1] >= 0) & (steps[1:] <= 0)).nonzero()[0]
    rise, fall, i = steps[crests], -steps[crests + 1], crests + left
    before, after = k[i] - k[i - 1], k[i + 1] - k[i]
    reach = np.maximum(rise * np.maximum(1, after / before), fall * np.maximum(1, before / after))
    found = i[a[i] + reach > level + _ROUNDING * max(abs(level), abs(float(a.max())))]
    best = found[(-a[found]).argsort(kind="stable")]
    looked = max(_LOOKED, len(k) // _AS_DEAR)
    return {*found[:looked].tolist(), *best[:looked].tolist()}


def _first_may(k: Indices, a: Array, level: float) -> bool:
    """Return whether a crest above the level may be before the second row; no row is before."""
    if len(a) < 3:
        return True
    slope = (a[1] - a[2]) / float(k[2] - k[1])
    return bool(a[1] + slope * float(k[1] - k[0]) > level)


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
    return replace(track, k=np.concatenate(ks), states=np.concatenate(zs, axis=1))
