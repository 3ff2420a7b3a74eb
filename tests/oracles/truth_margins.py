"""The margins of loops by exact fractions and mpmath. Shares no code with zoh.

With z = exp(j theta) and u = 1 - cos(theta), |num|^2, |den|^2 and Im(num conj den)/sin(theta)
are polynomials in u with rational coefficients, since a float is a fraction. Their common and
repeated factors are removed exactly, and mpmath finds what is left to 60 digits; theta comes
back as 2 asin(sqrt(u/2)). A continuous loop does the same in u = w^2, sin(theta) -> w.
"""

import sys
from fractions import Fraction

from exact_poly import ONE, ZERO, add, horner, mul, roots_between, slope, squarefree, trim
from loops import continuous_loops, dead_time_loops, sampled_loops
from mpmath import mp, mpc, mpf
from truth_delay import with_dead_time

DIGITS = 25  # written down
CLOSE = 1e-4  # a crossing flatter than this, in d log|L| per d log w, is left out: ill-posed


class Sampled:
    """num(z)/den(z), ascending Fractions; u = 1 - cos(w dt) in (0, 2)."""

    def __init__(self, num, den, dt):
        self.num, self.den, self.dt, self.top = num, den, dt, Fraction(2)

    def product(self, a, b):
        """Return (even, odd) with a conj(b) = even(u) + j sin(theta) odd(u)."""
        n = max(len(a), len(b))
        lags = [ZERO] * (2 * n - 1)
        for i, x in enumerate(a):
            for j, y in enumerate(b):
                lags[i - j + n - 1] += x * y
        first, second = [ONE], [ONE, -ONE]  # Chebyshev T_k in u, cos = 1 - u
        below, here = [ZERO], [ONE]  # U_{k-1}
        even, odd = [lags[n - 1]], [ZERO]
        for k in range(1, n):
            even = add(even, mul([lags[n - 1 + k] + lags[n - 1 - k]], second))
            odd = add(odd, mul([lags[n - 1 + k] - lags[n - 1 - k]], here))
            first, second = second, add(mul([2 * ONE, -2 * ONE], second), first, -1)
            below, here = here, add(mul([2 * ONE, -2 * ONE], here), below, -1)
        return even, odd

    def frequency(self, u):
        return 2 * mp.asin(mp.sqrt(u / 2)) / mpf(self.dt)

    def at(self, w):
        z = mp.expj(w * mpf(self.dt))
        return horner(self.num, z) / horner(self.den, z)

    def ends(self):
        """Return (frequency, num, den) at both ends, where the loop is real."""
        for z, w in ((ONE, mpf(0)), (-ONE, mp.pi / mpf(self.dt))):
            yield w, *(sum(c * z**i for i, c in enumerate(a)) for a in (self.num, self.den))

    def stable(self):
        return all(abs(r) < 1 for r in closed_roots(self))


class Continuous(Sampled):
    """num(s)/den(s), ascending Fractions; u = w^2 in (0, infinity)."""

    def __init__(self, num, den):
        super().__init__(num, den, None)
        self.top = None

    def product(self, a, b):
        def halves(p):
            signs = (ONE, ONE, -ONE, -ONE)
            flat = [c * signs[i % 4] for i, c in enumerate(p)]
            return trim(flat[0::2] or [ZERO]), trim(flat[1::2] or [ZERO])

        (ae, ao), (be, bo) = halves(a), halves(b)
        even = add(mul(ae, be), mul([ZERO, ONE], mul(ao, bo)))
        return even, add(mul(ao, be), mul(ae, bo), -1)

    def frequency(self, u):
        return mp.sqrt(u)

    def at(self, w):
        s = mpc(0, w)
        return horner(self.num, s) / horner(self.den, s)

    def ends(self):
        yield mpf(0), self.num[0], self.den[0]
        if len(self.num) == len(self.den):
            yield mp.inf, self.num[-1], self.den[-1]

    def stable(self):
        return all(r.real < 0 for r in closed_roots(self))


def closed_roots(loop):
    a = add(loop.den, loop.num)
    if len(a) < len(loop.den):
        raise ArithmeticError("a closed-loop root at infinity")
    at_zero = next(i for i, c in enumerate(a) if c)
    a = squarefree(a[at_zero:])
    top_first = [mpf(c.numerator) / mpf(c.denominator) for c in reversed(a)]
    with mp.workdps(120):
        found = mp.polyroots(top_first, maxsteps=2000, extraprec=1000) if len(a) > 1 else []
        return [mpc(0)] * min(at_zero, 1) + list(map(mpc, found))


def least_ratio(loop, top, bottom):
    """Return (minimum, w) of |top|/|bottom| on the axis, ends included."""
    p, q = loop.product(top, top)[0], loop.product(bottom, bottom)[0]
    turning = add(mul(slope(p), q), mul(p, slope(q)), -1)
    places = roots_between(turning, loop.top) if any(turning) else []
    ends = [mpf(0)] if loop.top is None else [mpf(0), mpf(2)]
    found = []
    for u in [*ends, *places]:
        if abs(horner(q, u)) > mpf(10) ** -60 * sum(abs(c) for c in q):
            found.append((mp.sqrt(abs(horner(p, u) / horner(q, u))), loop.frequency(u)))
    if loop.top is None and len(q) >= len(p):
        ratio = p[-1] / q[-1] if len(q) == len(p) else ZERO
        found.append((mp.sqrt(mpf(ratio.numerator) / ratio.denominator), mp.inf))
    return min(found, key=lambda f: f[0])


def crossings(loop):
    """Return gain crossings (w, pm_deg), phase crossings (w, factor), the flattest of all."""
    size = add(loop.product(loop.num, loop.num)[0], loop.product(loop.den, loop.den)[0], -1)
    turn = loop.product(loop.num, loop.den)[1]
    gains, phases, flats = [], [], [mpf(1)]
    for u in roots_between(size, loop.top):
        w = loop.frequency(u)
        flat = abs(mp.log(abs(loop.at(w * (1 + mpf(10) ** -20)))) * mpf(10) ** 20)
        flats.append(flat)
        gains.append((w, mp.degrees(mp.arg(-loop.at(w)))))
    for u in roots_between(turn, loop.top) if any(turn) else []:
        w = loop.frequency(u)
        value = loop.at(w).real
        if value < 0:
            phases.append((w, -1 / value))
            near = loop.at(w * (1 + mpf(10) ** -20))
            flats.append(abs(near.imag / near.real) * mpf(10) ** 20)
    for w, top, bottom in loop.ends():
        if top * bottom < 0:
            ratio = -bottom / top
            phases.append((w, mpf(ratio.numerator) / mpf(ratio.denominator)))
    return gains, sorted(phases), min(flats)


def measure(loop):
    """Return every number asked of a margin routine, as decimal strings."""
    gains, phases, flat = crossings(loop)
    modulus, _ = least_ratio(loop, add(loop.den, loop.num), loop.den)
    inverse_mt, _ = least_ratio(loop, add(loop.den, loop.num), loop.num)
    disk, _ = least_ratio(loop, add(loop.den, loop.num), add(loop.den, loop.num, -1))
    found = described(loop.stable(), gains, phases, modulus, 1 / inverse_mt, 2 * disk)
    return found | {"flat": float(flat)}


def described(stable, gains, phases, modulus, mt, disk):
    nearest = min(phases, key=lambda f: abs(mp.log(f[1])), default=None)
    smallest = min(gains, key=lambda g: abs(g[1]), default=None)
    delays = [mp.radians(g[1] if g[1] >= 0 else g[1] + 360) / g[0] for g in gains]
    return {
        "stable": stable,
        "gain_crossings": [[short(w), short(pm)] for w, pm in gains],
        "phase_crossings": [[short(w), short(k)] for w, k in phases],
        "gain_margin": short(nearest[1]) if nearest else None,
        "phase_crossover": short(nearest[0]) if nearest else None,
        "phase_margin_deg": short(smallest[1]) if smallest else None,
        "crossover": short(smallest[0]) if smallest else None,
        "delay_margin": short(min(delays)) if delays else None,
        "modulus_margin": short(modulus),
        "mt": short(mt),
        "disk_margin": short(disk),
    }


def short(x):
    return "inf" if x == mp.inf else mp.nstr(x, DIGITS, min_fixed=0, max_fixed=0)


def fractions(values):
    return trim([Fraction(v) for v in reversed(values)])


def from_w(num_w, den_w, dt):
    """Return num, den in z (ascending Fractions) of a fraction in w = (2/dt)(z-1)/(z+1)."""
    n = max(len(num_w), len(den_w)) - 1
    padded = [[ZERO] * (n + 1 - len(a)) + [Fraction(c) for c in a] for a in (num_w, den_w)]
    return [in_z(a, Fraction(dt)) for a in padded]


def in_z(a, dt):
    n, total = len(a) - 1, [ZERO]
    for i, c in enumerate(a):
        term = [c * (2 / dt) ** (n - i)]
        for _ in range(n - i):
            term = mul(term, [-ONE, ONE])
        for _ in range(i):
            term = mul(term, [ONE, ONE])
        total = add(total, term)
    return total


def make():
    mp.dps = 60
    cases = []
    for spec in sampled_loops():
        if spec["form"] == "z":
            num, den = fractions(spec["num"]), fractions(spec["den"])
        else:
            num, den = from_w(spec["truth_num_w"], spec["truth_den_w"], spec["dt"])
            den = [ZERO] * spec["delay"] + den
        keep(cases, spec, measure(Sampled(num, den, spec["dt"])))
    for spec in continuous_loops():
        keep(cases, spec, measure(Continuous(fractions(spec["num"]), fractions(spec["den"]))))
    for spec in dead_time_loops():
        keep(cases, spec, with_dead_time(spec, described))
    return cases


def keep(cases, spec, found):
    flat = found.pop("flat", 1.0)
    if flat < CLOSE:
        sys.stderr.write(f"margins: {spec['name']} left out, a crossing as flat as {flat:.1g}\n")
        return
    spec = {k: v for k, v in spec.items() if not k.startswith("truth_")}
    cases.append(spec | {"truth": found})
    if len(cases) % 25 == 0:
        sys.stderr.write(f"margins: {len(cases)} loops\n")
