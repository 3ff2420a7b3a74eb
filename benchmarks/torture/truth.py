"""The margins of a loop, exactly: whole-number polynomials, roots proved to be all of them.

A sampled loop is looked at in y = sin(w dt/2)**2, a continuous one in y with
w**2 = s**2 y/(1 - y): either way 0 < y < 1, |num|**2, |den|**2 and Im(num conj den) are
polynomials in y with whole-number coefficients, and so are the places where |1 + L| turns.
Only dead time in a continuous loop needs more: there the phase is monotone between the roots of
one more polynomial, and every piece is closed in on by itself. Shares no line with zoh.
"""

from dataclasses import dataclass, field
from functools import lru_cache
from math import comb

from benchmarks.torture import delay, exact
from benchmarks.torture.exact import Poly, add, mul
from mpmath import mp, mpc, mpf

DIGITS = 20  # written down
WORK = 160  # decimal digits of what is not exact
_TINY = mpf(10) ** -90


@dataclass(frozen=True, kw_only=True)
class Loop:
    """num/den in z or in s, whole numbers in ascending powers, the two on one scale.

    dt         s; None for a continuous loop
    dead_time  s; only a continuous loop has it, whole samples are powers of z
    """

    num: Poly
    den: Poly
    dt: float | None
    dead_time: float = 0.0
    shift: int = field(init=False)  # w**2 = 4**shift y/(1 - y) for a continuous loop

    def __post_init__(self) -> None:
        low = next(i for i, c in enumerate(self.den) if c)
        n = len(self.den) - 1
        bits = self.den[low].bit_length() - self.den[-1].bit_length()
        shift = round(bits / (n - low)) if self.dt is None and n > low else 0
        object.__setattr__(self, "shift", shift)

    def w(self, y: mpf) -> mpf:
        """Return the frequency in rad/s at y."""
        if self.dt is None:
            return mp.inf if y == 1 else mp.ldexp(mp.sqrt(y / (1 - y)), self.shift)
        return 2 * mp.asin(mp.sqrt(y)) / mpf(self.dt)

    def product(self, a: Poly, b: Poly) -> tuple[Poly, Poly]:
        """Return (re, im) with a conj(b) = re(y) + j root(y) im(y), up to a positive factor.

        root(y) is sin(w dt) or w; the factor is the same for all products of two polynomials.
        """
        return _on_circle(a, b) if self.dt is not None else self._on_axis(a, b)

    def _on_axis(self, a: Poly, b: Poly) -> tuple[Poly, Poly]:
        n = max(len(self.num), len(self.den)) - 1
        (ae, ao), (be, bo) = halves(a), halves(b)
        even = add(mul(ae, be), mul([0, 1], mul(ao, bo)))
        odd = add(mul(ao, be), mul(ae, bo), -1)
        return self.in_y(even, n), self.in_y(odd, n)

    def in_y(self, a: Poly, n: int) -> Poly:
        """Return (1 - y)**n a(4**shift y/(1 - y)), times a power of two where shift < 0."""
        lift = max(0, -2 * self.shift * n)
        out = [0] * (n + 1)
        for k, c in enumerate(a):
            scaled = c << (2 * self.shift * k + lift)
            for i in range(n - k + 1):
                out[k + i] += scaled * comb(n - k, i) * (-1) ** i
        return exact.trim(out)

    def root(self, y: mpf) -> mpf:
        """Return the factor of ``product``'s imaginary part."""
        if self.dt is None:
            return self.w(y)
        return 2 * mp.sqrt(y * (1 - y))

    def ends(self) -> list[tuple[int, mpf, int, int]]:
        """Return (y, w, num, den) at both ends of the axis, where the loop is real."""
        if self.dt is not None:
            at_one = [sum(a) for a in (self.num, self.den)]
            at_minus = [sum(c if i % 2 == 0 else -c for i, c in enumerate(a))
                        for a in (self.num, self.den)]  # fmt: skip
            nyquist = mp.pi / mpf(self.dt)
            return [(0, mpf(0), *at_one), (1, nyquist, *at_minus)]
        top = self.num[-1] if len(self.num) == len(self.den) else 0
        found = [(0, mpf(0), self.num[0], self.den[0])]
        if not self.dead_time:
            found.append((1, mp.inf, top, self.den[-1]))
        return found

    def at(self, w: mpf) -> mpc:
        """Return L at w rad/s, straight from its coefficients: the road of the audit."""
        x = mpc(0, w) if self.dt is None else mp.expj(w * mpf(self.dt))
        return horner(self.num, x) / horner(self.den, x) * mp.expj(-w * mpf(self.dead_time))


def horner(a: Poly, x: mpc) -> mpc:
    """Return a(x)."""
    total = mpc(0)
    for c in reversed(a):
        total = total * x + c
    return total


def halves(a: Poly) -> tuple[Poly, Poly]:
    """Return (e, o) with a(j w) = e(w**2) + j w o(w**2)."""
    signed = [c * (1, 1, -1, -1)[i % 4] for i, c in enumerate(a)]
    return exact.trim(signed[0::2] or [0]), exact.trim(signed[1::2] or [0])


def _on_circle(a: Poly, b: Poly) -> tuple[Poly, Poly]:
    """Return a conj(b) on |z| = 1 by its lags: sum of r_k z**k, cosines and sines apart."""
    n = max(len(a), len(b))
    lags = [0] * (2 * n - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            lags[n - 1 + i - j] += x * y
    re, im = [lags[n - 1]], [0]
    for k in range(1, n):
        cosine, sine = _waves(k)
        re = add(re, cosine, lags[n - 1 + k] + lags[n - 1 - k])
        im = add(im, sine, lags[n - 1 + k] - lags[n - 1 - k])
    return re, im


@lru_cache(maxsize=200)
def _waves(k: int) -> tuple[Poly, Poly]:
    """Return cos(k t) and sin(k t)/sin(t) as polynomials in y = sin(t/2)**2."""
    twice = [2, -4]  # 2 cos(t)
    below, cosine = [1], [1, -2]
    under, sine = [0], [1]
    for _ in range(k - 1):
        below, cosine = cosine, add(mul(twice, cosine), below, -1)
        under, sine = sine, add(mul(twice, sine), under, -1)
    return cosine, sine


@dataclass(frozen=True, kw_only=True)
class Crossings:
    """Where |L| is 1, with the phase margin in deg; where L < 0, with the factor onto -1.

    touches counts the places where one of the two only just happens and no sign changes.
    """

    gains: list[tuple[mpf, mpf]]
    phases: list[tuple[mpf, mpf]]
    touches: int


def crossings(loop: Loop) -> Crossings:
    """Return every crossing of a loop."""
    re, im = loop.product(loop.num, loop.den)
    top, bottom = loop.product(loop.num, loop.num)[0], loop.product(loop.den, loop.den)[0]
    square = add(top, bottom, -1)
    gains, phases, touches = [], [], 0
    for at, flips in exact.roots(square) if any(square) else []:
        touches += not flips
        if flips:
            y = exact.number(at)
            gains.append((loop.w(y), margin_at(loop, exact.value(re, at), exact.value(im, at), y)))
    if loop.dead_time:
        phases = delay.phase_crossings(loop)
    else:
        for at, flips in exact.roots(im) if any(im) else []:
            real = exact.value(re, at)
            if real >= 0 or abs(real) < _TINY * sum(abs(c) for c in re):
                continue  # on the positive side; or a pole or zero on the axis itself
            touches += not flips
            if flips:
                phases.append((loop.w(exact.number(at)), -exact.value(bottom, at) / real))
    for _, w, above, below in loop.ends():
        if above * below < 0:
            phases.append((w, -mpf(below) / mpf(above)))
        if abs(above) == abs(below):
            touches += 1
            if above == -below:
                gains.append((w, mpf(0)))
    return Crossings(gains=sorted(gains), phases=sorted(phases), touches=touches)


def margin_at(loop: Loop, re: mpf, im: mpf, y: mpf) -> mpf:
    """Return the angle in deg from -1 to L, in (-180, 180]."""
    turn = mp.expj(-loop.w(y) * mpf(loop.dead_time)) if loop.dead_time else 1
    return mp.degrees(mp.arg(-mpc(re, im * loop.root(y)) * turn))


def stable(loop: Loop) -> bool:
    """Return whether all closed-loop poles are strictly inside; a pole on the edge is not.

    Schur and Cohn's recursion on the polynomial in z; one in s is mapped by s = (z-1)/(z+1).
    Source: E. I. Jury, Theory and Application of the z-Transform Method, ch. 3.
    """
    if loop.dead_time:
        return delay.stable(loop)
    return rational_stable(loop)


def rational_stable(loop: Loop) -> bool:
    """Return ``stable`` of the loop without its dead time."""
    closed = [a + b for a, b in zip(loop.den, loop.num + [0] * len(loop.den), strict=False)]
    if loop.dt is None:
        closed = _by_bilinear(closed)
    if closed[-1] == 0:
        return False
    with mp.workdps(1500):
        a = [mpf(c) for c in closed]
        while len(a) > 1:
            low, high = a[0], a[-1]
            gap = (abs(high) - abs(low)) / (abs(high) + abs(low))
            if abs(gap) < mpf(10) ** -700:
                return False  # a pole on the edge, or a pair mirrored in it
            if gap < 0:
                return False
            pairs = zip(a[1:], a[-2::-1], strict=True)
            a = [(high * x - low * y) / high for x, y in pairs]
    return True


def _by_bilinear(a: Poly) -> Poly:
    """Return (z + 1)**n a((z - 1)/(z + 1)): a root at infinity becomes one at z = 1."""
    n = len(a) - 1
    out = [0] * (n + 1)
    for k, c in enumerate(a):
        factor = [1]
        for i in range(n):
            factor = mul(factor, [-1, 1] if i < k else [1, 1])
        for i, f in enumerate(factor):
            out[i] += c * f
    return out


def least_ratio(loop: Loop, above: Poly, below: Poly) -> tuple[mpf, mpf]:
    """Return (minimum of |above|/|below| on the axis, frequency), ends included.

    It turns where A'B = AB'; all of these places are known, and one more count proves that
    nothing is below (1 - 1e-25) of what was found.
    """
    top, bottom = loop.product(above, above)[0], loop.product(below, below)[0]
    turning = add(mul(exact.slope(top), bottom), mul(top, exact.slope(bottom)), -1)
    turns = [at for at, _ in exact.roots(turning)] if any(turning) else []
    places = [(at, loop.w(exact.number(at))) for at in turns]
    ends = [((0, 0), mpf(0)), ((1, 0), loop.w(mpf(1)))]
    found = []
    for at, w in [*ends, *places]:
        size = exact.value(bottom, at)
        if abs(size) > mpf(10) ** -200 * sum(abs(c) for c in bottom):
            found.append((mp.sqrt(abs(exact.value(top, at) / size)), w))
    if not found:
        raise ArithmeticError("no place to look at")
    best = min(found, key=lambda f: f[0])
    if best[0] > 0:
        _certify(top, bottom, best[0])
    return best


def _certify(top: Poly, bottom: Poly, least: mpf) -> None:
    level, shift = exact.dyadic(least**2 * (1 - mpf(10) ** -25))
    lifted = [c << max(0, -shift) for c in top]
    under = add(lifted, bottom, -(level << max(0, shift)))
    if exact.roots(under):
        raise ArithmeticError(f"something is below {mp.nstr(least, 20)}")
