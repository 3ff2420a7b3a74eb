"""A second look at the truth: the loop itself on a grid, in many digits, straight from its formula.

Nothing of the polynomials in y is used here. Each crossing must be one; between neighbours on
the grid |L| may pass 1 only where a crossing is known, L may pass the negative real axis only
where one is known, and nowhere may |1 + L| be less than its minimum.
"""

from itertools import pairwise

from benchmarks.torture import delay
from benchmarks.torture.truth import Crossings, Loop
from mpmath import mp, mpc, mpf

POINTS = 260


def check(loop: Loop, seen: Crossings, modulus: mpf) -> None:
    """Raise ArithmeticError where the truth and the loop on the grid disagree."""
    for w, pm in seen.gains:
        if w and abs(loop.at(w) + mp.expj(mp.radians(pm))) > mpf(10) ** -40:
            raise ArithmeticError(f"no gain crossing at {mp.nstr(w)}")
    for w, factor in seen.phases:
        if w and not mp.isinf(w) and abs(loop.at(w) * factor + 1) > mpf(10) ** -40:
            raise ArithmeticError(f"no phase crossing at {mp.nstr(w)}")
    points = _grid(loop, seen)
    values = [loop.at(w) for w in points]
    for (a, b), (here, there) in zip(pairwise(points), pairwise(values), strict=True):
        _between(loop, a, b, here, there, seen)
    if min(abs(1 + x) for x in values) < modulus * (1 - mpf(10) ** -15):
        raise ArithmeticError("|1 + L| is less on the grid than its minimum")


def _grid(loop: Loop, seen: Crossings) -> list[mpf]:
    known = [w for w, _ in (*seen.gains, *seen.phases) if w and not mp.isinf(w)]
    if loop.dt is not None:
        top = mp.pi / mpf(loop.dt) * (1 - mpf(10) ** -6)
        low = min([*known, top / 1000]) / 30
    else:
        low, top = min([*known, mpf(1)]) / 30, max([*known, mpf(1)]) * mpf("29.73")
    grow = (top / low) ** (mpf(1) / POINTS)
    even = [top * i / POINTS for i in range(1, POINTS)]
    if loop.dead_time:
        even += [mpf(i) / 2 / mpf(loop.dead_time) for i in range(1, 4 * POINTS)]
    return sorted({*(low * grow**i for i in range(POINTS + 1)), *even})


def _between(loop: Loop, a: mpf, b: mpf, here: mpc, there: mpc, seen: Crossings) -> None:
    flips = (abs(here) > 1) != (abs(there) > 1)
    if flips != (sum(a < w < b for w, _ in seen.gains) % 2 == 1):
        raise ArithmeticError(f"a gain crossing between {mp.nstr(a)} and {mp.nstr(b)}")
    if (b - a) * loop.dead_time > 1:
        return  # too long a step to tell a turn back from a turn round
    small_step = abs(there - here) < min(abs(here), abs(there))
    left = here.real < 0 and there.real < 0
    if loop.dead_time and min(abs(here), abs(there)) * delay.QUIET < 1:
        return  # so far out that the truth stops listing the dead time's turns
    if small_step and left and (here.imag > 0) != (there.imag > 0):
        if sum(a < w < b for w, _ in seen.phases) % 2 != 1:
            raise ArithmeticError(f"a phase crossing between {mp.nstr(a)} and {mp.nstr(b)}")
