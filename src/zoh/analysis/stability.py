"""Is the closed loop stable? Decided by its poles, never by its margins.

Without delay the closed loop is a polynomial, and Routh's scheme in whole numbers decides. A few
whole samples of delay are multiplied in. A continuous dead time leaves no polynomial, and many
samples a long one: there the argument principle counts, with a proof between the points it looks
at.
"""

from collections.abc import Sequence
from functools import lru_cache
from math import exp, log, log10, pi

import numpy as np

from zoh.analysis.certificates import Proof
from zoh.analysis.discs import unstable_zeros
from zoh.analysis.limit import ROUTH, late, settled
from zoh.analysis.loop import Array, Loop
from zoh.analysis.sharp import as_v
from zoh.analysis.squares import size
from zoh.lti import poly, signs, whole

SHORT = 10  # samples of delay up to which Routh's scheme costs less than winding
LONGEST = 60  # samples of delay up to which it is asked where winding does not tell
NEXT_TO_IT = 1e-4  # |1 + L| below which rounding of a hold's coefficients may turn the answer
_LOST = 8  # bits that cancel only where a loop may be next to the limit; a float has 53
_TOLD = 0, 1, -1  # coefficients that no pivot tells of: 0 where a pole is at z = -1, at z = 1


def surely_stable(loop: Loop, modulus: float | None = None) -> bool:
    """Return whether 1 + L is known to have them there whatever a hold has rounded.

    modulus  the least |1 + L|, if that is known
    """
    return (surely if next_to_it(loop, modulus) else decided)(loop)[0] is True


def surely(loop: Loop) -> tuple[bool | None, Proof]:
    """Return what ``decided`` does, of a loop that may be next to the limit of stability."""
    found = decided(loop)
    return settled(loop) if found[1] is ROUTH else found


def next_to_it(loop: Loop, modulus: float | None = None) -> bool:
    """Return whether a loop may be next to the limit of stability.

    modulus  the least |1 + L|, if that is known: beside an undamped or a hidden mode it may be 1
    """
    return (modulus is not None and modulus < NEXT_TO_IT) or _has_cancelled(loop)


def _has_cancelled(loop: Loop) -> bool:
    """Return whether what Routh's scheme decides by, if it does, has cancelled."""
    return decided(loop)[1] is ROUTH and _by_routh(loop)[1]


@lru_cache(maxsize=8)
def _by_routh(loop: Loop) -> tuple[bool, bool]:
    """Return whether a loop is stable, and whether a coefficient or a pivot has cancelled."""
    num, den = late(loop, loop.exact)
    closed, lost = whole.plus(num, den), [0]
    stable = signs.hurwitz(closed, lost)
    return stable, max(lost) > _LOST or any(
        [abs(closed[i]) << _LOST < abs(den[i]) for i in _TOLD[: len(closed)]]
    )


@lru_cache(maxsize=8)
def decided(loop: Loop) -> tuple[bool | None, Proof]:
    """Return whether the closed loop is stable, and by which proof; None where none holds.

    That is where a delay leaves it on the boundary to within rounding.
    """
    m = 0 if loop.dt is None else round(loop.dead_time / loop.dt)
    if not loop.dead_time or (loop.dt is not None and m <= SHORT):
        return _by_routh(loop)[0], ROUTH
    found = _none_encircled(loop)
    if found is not None:
        return found, _WINDING
    if loop.dt is not None and m <= LONGEST:
        return settled(loop)
    return None, _NO_PROOF


_WINDING = Proof(holds=True, method="discs", detail="the zeros on the right counted by winding")
_NO_PROOF = Proof(holds=False, method="discs", detail="on the boundary, or too near to it to tell")


def hurwitz_floats(a: Sequence[float]) -> bool:
    """Return whether every root of a, its coefficients taken exactly, has a negative real part."""
    return signs.hurwitz(whole.of(a)[0][0])


def _none_encircled(loop: Loop) -> bool | None:
    """Return whether no zero of 1 + L is on the right; None where one is on the boundary."""
    if loop.dt is None and abs(loop.num[0]) >= abs(loop.den[0]):
        return False  # |L| >= 1 at infinity with dead time: infinitely many poles on the right
    sizes = [abs(r) for a in (loop.den, loop.num) for r in poly.roots(a) if r]
    # the closed loop without the delay: a weak loop around an integrator is as slow as its gain
    closed = [abs(r) for r in poly.roots(loop.closed()) if r]
    low = min([*sizes, *closed, 1 / loop.dead_time, *_slow_crossover(loop)]) * 1e-3
    if loop.dt is None and loop.num[0]:  # beyond where it is 1 it only turns: as a function of 1/v
        scale = max([*sizes, 1 / loop.dead_time, *_unities(loop)])
        high = scale * 10
    else:
        scale = max([*sizes, *closed, 1 / loop.dead_time])
        high = scale * 1e3
    even = np.geomspace(low, high, 300 + 20 * int(log10(scale / low)))
    v = np.unique(np.concatenate([even, _turns(loop, scale)]))
    zeros = unstable_zeros(loop, v[v > 0])
    return None if zeros is None else zeros == 0


def _unities(loop: Loop) -> list[float]:
    """Return every v at which |L| passes 1."""
    num, den = loop.exact
    return [as_v(q) for q in signs.odd_roots(whole.plus(size(num), size(den), -1))]


def _slow_crossover(loop: Loop) -> list[float]:
    """Return the v at which integrators alone would bring |L| to 1; nothing without them."""
    num, den = poly.trim(loop.num[::-1]), poly.trim(loop.den[::-1])
    more = len(loop.den) - len(den) - (len(loop.num) - len(num))
    if more <= 0:
        return []
    return [exp((log(abs(num[0])) - log(abs(den[0]))) / more)]


def _turns(loop: Loop, scale: float) -> Array:
    """Return frequencies at every 0.3 rad of the delay's phase or nearer, as far as it matters."""
    if loop.dt is None:
        return np.asarray(np.linspace(0, min(600.0 / loop.dead_time, scale * 10), 2000))
    half = np.linspace(0, pi / 2, max(2, round(loop.dead_time / loop.dt * 20)), endpoint=False)
    return np.asarray(2 / loop.dt * np.tan(half))
