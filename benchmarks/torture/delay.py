"""Continuous loops with dead time: the only transcendental ones.

Gain crossings do not see the dead time. The phase is monotone between the roots of one
polynomial, so that each piece is counted and closed in on by itself. Stability is followed from
no dead time at all: poles cross the axis only at gain crossings, when the dead time reaches the
margin there, outwards where |L| falls and inwards where it rises.
Source: K. Walton, J. E. Marshall, Direct method for TDS stability analysis, IEE Proc. D 134(2),
1987.
"""

import warnings
from collections.abc import Callable
from itertools import pairwise
from math import atan, ceil, floor, pi
from typing import TYPE_CHECKING

import numpy as np
from benchmarks.torture import exact, truth
from benchmarks.torture.exact import Poly, add, mul
from mpmath import mp, mpf

if TYPE_CHECKING:
    from benchmarks.torture.truth import Loop

QUIET = 200  # crossings with |L| under 1/200 are not asked for, but for the first of them
_GRID = 40_000
_VALLEYS = 4


def parts(loop: "Loop") -> tuple[Poly, Poly]:
    """Return (C, S) in w**2 with num conj den = C + j w S, dead time left out."""
    (ae, ao), (be, bo) = truth.halves(loop.num), truth.halves(loop.den)
    even = add(mul(ae, be), mul([0, 1], mul(ao, bo)))
    return even, add(mul(ao, be), mul(ae, bo), -1)


def phase_crossings(loop: "Loop") -> list[tuple[mpf, mpf]]:
    """Return (frequency, factor onto -1) of every phase crossing with |L| > 1/QUIET.

    The loudest of the others comes with them: it may be the gain margin.
    """
    even, odd = parts(loop)
    last = _loudest(loop) + 4 * pi / loop.dead_time
    unwrapped = _Phase(loop)
    cuts = [0.0, *(w for w in _turning_points(loop, even, odd) if w < last), last]
    found = []
    for a, b in pairwise(cuts):
        fa, fb = unwrapped(max(a, 1e-12 * last)), unwrapped(b)
        low, high = sorted((fa, fb))
        for k in range(ceil((low / pi - 1) / 2), floor((high / pi - 1) / 2) + 1):
            near = _bisected(unwrapped, (2 * k + 1) * pi, max(a, 1e-12 * last), b, fb > fa)
            found.append(_closed_in(loop, near))
    loud = [(w, k) for w, k in found if k < QUIET]
    quiet = sorted(((w, k) for w, k in found if k >= QUIET), key=lambda c: c[1])
    return loud + quiet[:1]


class _Phase:
    """The phase of L in rad as a continuous function of w, by the angles of poles and zeros."""

    def __init__(self, loop: "Loop") -> None:
        self.theta = loop.dead_time
        self.signs, self.roots = [], []
        for a, sign in ((loop.num, 1), (loop.den, -1)):
            found = _roots(a)
            self.roots += found
            self.signs += [sign] * len(found)
        lead = (loop.num[-1] > 0) == (loop.den[-1] > 0)
        zeros = [next(i for i, c in enumerate(a) if c) for a in (loop.num, loop.den)]
        self.start = (0.0 if lead else pi) + (zeros[0] - zeros[1]) * pi / 2

    def __call__(self, w: float) -> float:
        total = self.start - w * self.theta
        for sign, root in zip(self.signs, self.roots, strict=True):
            # jw - r: to the right of a stable root, to the left of an unstable one
            angle = atan((w - root.imag) / -root.real)
            total += sign * (angle if root.real < 0 else pi + angle)
        return total


def _roots(a: Poly) -> list[complex]:
    """Return the roots, those at 0 left out."""
    a = a[next(i for i, c in enumerate(a) if c) :]
    n = len(a) - 1
    if n < 1:
        return []
    with mp.workdps(80), warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of descending order, from 1.4 on
        top = [mpf(c) / mpf(a[-1]) for c in reversed(a)]
        return [complex(r) for r in mp.polyroots(top, maxsteps=4000, extraprec=600, cleanup=False)]


def _turning_points(loop: "Loop", even: Poly, odd: Poly) -> list[float]:
    """Return the w where (S'C - C'S)/(C**2 + S**2) = theta, S = w odd(w**2), C = even(w**2)."""
    theta, shift = exact.dyadic(loop.dead_time)
    slopes = mul(even, add(odd, mul([0, 2], exact.slope(odd))))
    slopes = add(slopes, mul([0, 2], mul(exact.slope(even), odd)), -1)
    size = add(mul(even, even), mul([0, 1], mul(odd, odd)))
    lifted = [c << max(0, -shift) for c in slopes]
    turning = add(lifted, size, -(theta << max(0, shift)))
    if not any(turning):
        return []
    in_y = loop.in_y(turning, len(turning) - 1)
    return sorted(float(loop.w(exact.number(at))) for at, _ in exact.roots(in_y))


def _loudest(loop: "Loop") -> float:
    """Return the last frequency with |L| = 1/QUIET."""
    top = [QUIET**2 * c for c in loop.product(loop.num, loop.num)[0]]
    square = add(top, loop.product(loop.den, loop.den)[0], -1)
    return max((float(loop.w(exact.number(at))) for at, _ in exact.roots(square)), default=0.0)


def _bisected(f: Callable[[float], float], level: float, a: float, b: float, up: bool) -> float:
    for _ in range(200):
        middle = (a + b) / 2
        if (f(middle) < level) == up:
            a = middle
        else:
            b = middle
    return (a + b) / 2


def _closed_in(loop: "Loop", near: float) -> tuple[mpf, mpf]:
    """Return (w, factor) of the phase crossing that floats found, by Newton's method."""
    w = mpf(near)
    for _ in range(60):
        h = w * mpf(10) ** -60
        here = mp.arg(-loop.at(w))
        step = here * h / (mp.arg(-loop.at(w + h)) - here)
        w -= step
        if abs(step) < abs(w) * mpf(10) ** -45:
            break
    else:
        raise ArithmeticError("no phase crossing where there must be one")
    if abs(w / near - 1) > 1e-6:
        raise ArithmeticError("a phase crossing ran away")
    return w, -1 / mp.re(loop.at(w))


def stable(loop: "Loop") -> bool:
    """Return whether den + num exp(-s theta) has all its zeros on the left."""
    if len(loop.num) == len(loop.den) and abs(loop.num[-1]) >= abs(loop.den[-1]):
        return False  # |L| >= 1 for ever: infinitely many zeros on the right
    bare = truth.Loop(num=loop.num, den=loop.den, dt=None)
    right = _on_the_right(add(loop.den, loop.num))
    top, bottom = (loop.product(a, a)[0] for a in (loop.num, loop.den))
    square = add(top, bottom, -1)
    re, im = loop.product(loop.num, loop.den)
    for at, flips in exact.roots(square):
        w = loop.w(exact.number(at))
        pm = truth.margin_at(bare, exact.value(re, at), exact.value(im, at), exact.number(at))
        turn = mp.radians(pm) % (2 * mp.pi)
        crossed = int(mp.floor((w * mpf(loop.dead_time) - turn) / (2 * mp.pi))) + 1
        if flips and crossed > 0:
            falls = exact.sign(exact.slope(square), at) < 0
            right += 2 * crossed if falls else -2 * crossed
    return right == 0


def _on_the_right(a: Poly) -> int:
    return (a[0] == 0) + sum(r.real >= 0 for r in _roots(a))


def least_ratio(loop: "Loop", top: tuple[int, int], bottom: tuple[int, int]) -> tuple[mpf, mpf]:
    """Return (min |a den + b num|/|c den + d num|, w); (a, b) is ``top``, (c, d) ``bottom``.

    The lowest valleys of a grid of 80 000 points, dense by decades, by the dead time's turns and
    around every resonance, are followed down in many digits.
    """

    def ratio(w: mpf) -> mpf:
        here = loop.at(w)
        return abs((top[0] + top[1] * here) / (bottom[0] + bottom[1] * here))

    w, values = _seen(loop, top, bottom)
    low = np.flatnonzero((values[1:-1] <= values[:-2]) & (values[1:-1] <= values[2:])) + 1
    best = (mpf(values[0]), mpf(0)) if values[0] <= values[-1] else (mpf(values[-1]), mp.inf)
    if best[1] == 0:
        best = (_at_zero(loop, top, bottom), mpf(0))
    elif best[1] == mp.inf:
        best = (abs(mpf(top[0]) / mpf(bottom[0])) if bottom[0] else mp.inf, mp.inf)
    for i in low[np.argsort(values[low])][:_VALLEYS]:
        found = _down(ratio, mpf(w[i - 1]), mpf(w[i + 1]))
        best = min(best, (ratio(found), found), key=lambda f: f[0])
    return best


def _at_zero(loop: "Loop", top: tuple[int, int], bottom: tuple[int, int]) -> mpf:
    num, den = mpf(loop.num[0]), mpf(loop.den[0])
    below = bottom[0] * den + bottom[1] * num
    return abs((top[0] * den + top[1] * num) / below) if below else mp.inf


def _seen(
    loop: "Loop", top: tuple[int, int], bottom: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    roots = [r for a in (loop.num, loop.den) for r in _roots(a)]
    sizes = [abs(r) for r in roots] + [1 / loop.dead_time]
    last = max(_loudest(loop), 10 / loop.dead_time)
    around = [abs(r.imag) + r.real * x for r in roots for x in np.linspace(-5, 5, 401)]
    w = np.unique(np.concatenate([
        np.geomspace(min(sizes) * 1e-4, max(sizes) * 1e4, _GRID),
        np.linspace(0, last, _GRID)[1:], [x for x in around if x > 0],
    ]))  # fmt: skip
    s = 1j * w
    lift = max(c.bit_length() for c in (*loop.num, *loop.den))
    num, den = (np.polyval([float(mp.ldexp(c, -lift)) for c in reversed(a)], s)
                for a in (loop.num, loop.den))  # fmt: skip
    num = num * np.exp(-s * loop.dead_time)
    with np.errstate(all="ignore"):  # at a zero and far out; those points win nothing
        return w, np.abs((top[0] * den + top[1] * num) / (bottom[0] * den + bottom[1] * num))


def _down(f: Callable[[mpf], mpf], a: mpf, b: mpf) -> mpf:
    """Return where f is least in [a, b]: golden sections, then parabolas by three points."""
    golden = (mp.sqrt(5) - 1) / 2
    c, d = b - golden * (b - a), a + golden * (b - a)
    for _ in range(60):
        if f(c) < f(d):
            b, d = d, c
            c = b - golden * (b - a)
        else:
            a, c = c, d
            d = a + golden * (b - a)
    x = (a + b) / 2
    for _ in range(6):
        h = x * mpf(10) ** -25
        left, here, right = (mp.log(f(x + i * h)) for i in (-1, 0, 1))
        bend = right - 2 * here + left
        if bend <= 0:  # no valley, only the grid's rounding
            break
        x -= h * (right - left) / 2 / bend
    return x
