"""The undamped poles and zeros of a loop: its phase jumps there, and it crosses no axis.

A factor g(s^2) of num or den is real at s = jv. It turns L by no angle but where it changes its
sign, and there by 180 deg, through infinity or through 0. So it is left out where crossings of a
loop are counted that is no polynomial. Where it is 0 is known exactly: it is what the even and the
odd part of the polynomial share.
"""

from dataclasses import replace
from functools import lru_cache

from zoh.analysis.loop import Loop
from zoh.analysis.sharp import as_v
from zoh.lti import divisors, signs, whole
from zoh.lti.whole import Whole


@lru_cache(maxsize=8)
def without_undamped(loop: Loop) -> tuple[Loop, tuple[float, ...]]:
    """Return the loop without such factors, and every v at which one of them changes its sign.

    What is left has the loop's angle but for 180 deg; its size it has not.

    >>> from zoh.lti.systems import Plant
    >>> left, jumps = without_undamped(Loop.of(Plant(num=[3, 1], den=[1, 2, 4, 8])))  # s^2 + 4
    >>> left.den, jumps
    ((-0.5, -1.0), (2.0,))
    """
    shared = [_undamped(a) for a in loop.exact]
    if all(len(g) == 1 for g in shared):
        return loop, ()
    left = [whole.divided(a, _in_s(g)) for a, g in zip(loop.exact, shared, strict=True)]
    length = max(len(a) - next(i for i, c in enumerate(a) if c) for a in left)
    num, den = ([0] * (length - len(a)) + a[-length:] for a in left)
    top, bottom = (tuple([c / max(map(abs, a)) for c in a]) for a in (num, den))
    jumps = tuple([as_v(q) for g in shared for q in signs.odd_roots(g)])
    return replace(loop, num=top, den=bottom, exact=(num, den)), jumps


def _undamped(a: Whole) -> list[int]:
    """Return the factor of a(jv) that is real, in q = v^2, a power of q left out.

    >>> _undamped((1, 2, 1, 2, 0))  # (s + 2)(s^2 + 1) s, and s^2 = -q
    [1, -1]
    >>> _undamped((3, 6))
    [1]
    """
    even, odd = whole.on_axis(a)
    if divisors.share_nothing(even, odd) or not any(a):
        return [1]
    return whole.trim(divisors.common(even, odd))


def _in_s(g: Whole) -> list[int]:
    """Return g(q) as a polynomial in s, s^2 = -q.

    >>> _in_s((1, -4))
    [-1, 0, -4]
    """
    out = [0] * (2 * len(g) - 1)
    out[::2] = [c * (-1) ** (len(g) - 1 - i) for i, c in enumerate(g)]
    return out
