"""A loop next to the limit of stability: which side of it, or on it to every digit there is.

What a hold makes of a plant is rounded, so its loop is one of a family: each coefficient of num
and den may be off by a part of itself. All of the family have as many unstable poles where nowhere
on the axis, both ends included, den + num is within what it may be off by. That is a polynomial
above 0, asked in whole numbers: of the floats first, and where they leave it open, of the same
coefficients with 256 bits. At w = 0 these have the plant's own gain, exactly: there a pole at
z = 1 is proved or excluded.
Source: Rouche's theorem; K. Mahler, An application of Jensen's formula to polynomials, Mathematika
7, 1960 (the terms of a product's factors are at most 2^n times its own).
"""

from collections.abc import Sequence
from math import comb, frexp, log10

from zoh.analysis.certificates import Proof
from zoh.analysis.loop import Loop
from zoh.analysis.squares import size
from zoh.lti import divisors, signs, whole
from zoh.lti.systems import Sampled
from zoh.lti.whole import Whole

ROUTH = Proof(holds=True, method="Routh", detail="in whole numbers")
Pair = tuple[Whole, Whole]


def settled(loop: Loop) -> tuple[bool | None, Proof]:
    """Return whether a loop without delay, or with whole samples of it, is stable; the proof.

    None where it is on the limit as far as 256 bits tell.

    >>> from zoh.lti.systems import Plant
    >>> from zoh.sampling.hold import sample
    >>> held = sample(Plant(num=[-1], den=[1, 5]), 0.001)
    >>> settled(Loop.of(held, Sampled(num=[5], den=[1], dt=0.001)))[0]  # 1 + L is 0 at z = 1
    False
    """
    if not (off := _off(loop)):
        return signs.hurwitz(whole.plus(*late(loop, loop.exact))), ROUTH
    found = _sure(loop, off, at_rest=False)
    if found is None:
        fine = loop.finer()
        found = _sure(fine, off := _off(fine), at_rest=True)
    return found, (_open(fine, off) if found is None else ROUTH)


def says_on_the_limit(why: Proof) -> bool:
    """Return whether this is the proof of ``settled`` for a loop that is nowhere settled."""
    return not why.holds and why.method == ROUTH.method


def late(loop: Loop, exact: Pair) -> Pair:
    """Return (num, den), these being ``exact``, with the m samples of delay multiplied in.

    They are num (1-p)^m and den (1+p)^m in p = w dt/2, both times one positive number.
    """
    if loop.dt is None or not (m := _samples(loop)):
        return exact
    num, den = _in_p(exact, loop.dt)
    grow = [comb(m, k) for k in range(m + 1)]
    fall = [c if (m - k) % 2 == 0 else -c for k, c in enumerate(grow)]
    return whole.times(num, fall), whole.times(den, grow)


def _samples(loop: Loop) -> int:
    return round(loop.dead_time / loop.dt) if loop.dt and loop.dead_time else 0


def _in_p(exact: Pair, dt: float) -> Pair:
    """Return the polynomials in p = w dt/2, both times one positive number."""
    top, bottom = (dt / 2).as_integer_ratio()
    n = len(exact[0]) - 1
    octaves = bottom.bit_length() - 1  # of a power of two
    unit = [top**i << octaves * (n - i) for i in range(n + 1)]  # w^(n-i) = (p bottom/top)^(n-i)
    num, den = ([c * s for c, s in zip(a, unit, strict=True)] for a in exact)
    return num, den


def _off(loop: Loop) -> float:
    """Return by which part of themselves the coefficients may be off that a hold has rounded."""
    return sum([s.unsure for s in loop.factors if isinstance(s, Sampled)])


def _sure(loop: Loop, off: float, *, at_rest: bool) -> bool | None:
    """Return whether the whole family of a loop is stable, or none of it is; None for neither.

    at_rest  whether the last coefficients of num and den are exact but for a common factor

    What num and den share, the loop hides: it is in each of the family, and decided by itself.
    """
    num, den = loop.exact
    if num[0] == den[0] == 0:  # at z = -1
        return False
    if not divisors.share_nothing(num, den):
        if not at_rest:  # floats may share by chance: what 256 bits share is shared by structure
            return None
        shared = divisors.common(num, den)
        if len(shared) > 3 and not signs.positive(_apart(shared, shared, _bits(loop, off))):
            return None  # up to degree 2 the signs of the coefficients tell, and these are sure
        if len(shared) > 1 and not signs.hurwitz(shared):
            return False
        num, den = whole.divided(num, shared), whole.divided(den, shared)
    closed = whole.plus(*late(loop, (num, den)))
    if at_rest and not closed[-1]:
        return False
    if not signs.positive(_beyond_doubt(loop, (num, den), closed, off, at_rest=at_rest)):
        return None
    return signs.hurwitz(closed)


def _beyond_doubt(
    loop: Loop, exact: Pair, closed: Whole, off: float, *, at_rest: bool
) -> list[int]:
    """Return a polynomial in v that is above 0 where |den + num| is more than it may be off by.

    An exact last term is left out; Mahler's bound is then kept by far, but not proved, where the
    factors' own terms beside it cancel.
    """
    num, den = exact
    m = _samples(loop)
    if m and loop.dt is not None:
        num, den = _in_p(exact, loop.dt)
    terms = [abs(a) + abs(b) for a, b in zip(num, den, strict=True)]
    if at_rest:
        terms[-1] = 0
    bits = _bits(loop, off)
    may_be_off = whole.times(terms, terms)
    square = whole.power([1, 0, 1], m)  # |1 +- jp|^2m
    up, down = 2 * max(bits, 0), 2 * max(-bits, 0)
    apart = [c << up for c in _in_v(size(closed))]
    return whole.plus(apart, [c << down for c in whole.times(may_be_off, square)], -1)


def _apart(a: Whole, terms: Whole, bits: int) -> list[int]:
    """Return a polynomial in v, above 0 where |a| is more than 2^-bits of the sum of ``terms``."""
    sizes = [abs(c) for c in terms]
    up, down = 2 * max(bits, 0), 2 * max(-bits, 0)
    square = [c << down for c in whole.times(sizes, sizes)]
    return whole.plus([c << up for c in _in_v(size(a))], square, -1)


def _bits(loop: Loop, off: float) -> int:
    """Return how many bits of the sum of its terms num and den are sure at a frequency.

    What may be off is less than 2^frexp of it. One a degree is for terms that cancel.
    """
    return 1 - frexp(off)[1] - len(loop.exact[0])


def _in_v(a: Sequence[int]) -> list[int]:
    """Return a(v^2) as a polynomial in v.

    >>> _in_v([1, 2, 3])
    [1, 0, 2, 0, 3]
    """
    out = [0] * (2 * len(a) - 1)
    out[::2] = a
    return out


def _open(loop: Loop, off: float) -> Proof:
    digits = int(_bits(loop, off) * log10(2))
    return Proof(
        holds=False,
        method=ROUTH.method,
        detail=f"on the limit of stability to {digits} digits: a pole is on the unit circle, or "
        "nearer to it than they tell",
    )
