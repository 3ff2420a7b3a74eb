"""A lag or an integrator under a sampled controller, put together from its closed form.

x' = -a x + b v. Under a constant v a lag goes monotonously towards b v/a and an integrator
straight, so every extreme is at a knot: a sample, or an instant at which v changes. Crossing
times in between are logarithms.
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import exp, log

COUNT = 400  # samples


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop:
    """delay, dt in s as fractions; num, den of the controller in z, den[0] = 1."""

    a: float
    b: float
    delay: Fraction
    dt: Fraction
    num: tuple[float, ...]
    den: tuple[float, ...]

    def moved(self, x, v, t):
        if not self.a:
            return x + self.b * v * t
        fall = exp(-self.a * t)
        return x * fall + self.b * v / self.a * (1 - fall)

    def when(self, x, v, level):
        """Return how long x takes to a level that is on its way."""
        if not self.a:
            return (level - x) / (self.b * v)
        end = self.b * v / self.a
        return log((x - end) / (level - end)) / self.a

    def knots(self, by="step", count=COUNT):
        """Return ([(t, x, v from then on)], [y at the samples], [u])."""
        samples = {k * self.dt: k for k in range(count)}
        switches = {k * self.dt + self.delay: k for k in range(count)}
        times = sorted(t for t in {*samples, *switches} if t <= (count - 1) * self.dt)
        extra = 1.0 if by == "disturbance" else 0.0
        x, v, now, out, y, e, u = 0.0, extra, Fraction(0), [], [], [], []
        for t in times:
            x, now = self.moved(x, v, float(t - now)), t
            if t in samples:
                k = samples[t]
                r = {"step": 1.0, "impulse": float(k == 0), "ramp": float(t)}.get(by, 0.0)
                y.append(x)
                e.append(r - x)
                u.append(self.answer(e, u, k))
            if t in switches:
                v = u[switches[t]] + extra
            out.append((float(t), x, v))
        return out, y, u

    def answer(self, e, u, k):
        late = len(self.den) - len(self.num)
        total = sum(c * e[k - i - late] for i, c in enumerate(self.num) if k >= i + late)
        return total - sum(c * u[k - i] for i, c in enumerate(self.den) if 0 < i <= k)

    def reaches(self, knots, level):
        """Return the first instant with x >= level, a level above the start."""
        for (t, x, v), (_, x_next, _) in pairwise(knots):
            if x >= level:
                return t
            if x_next >= level:
                return t + self.when(x, v, level)
        return None

    def settles(self, knots, final, band):
        """Return the instant from which on |x - final| <= band."""
        inside = [abs(x - final) <= band for _, x, _ in knots]
        last = max((i for i, yes in enumerate(inside) if not yes), default=None)
        if last is None:
            return 0.0
        t, x, v = knots[last]
        return t + self.when(x, v, final + (band if x > final else -band))


def loop(a, b, delay, dt, num, den):
    """Return a loop of these numbers, the times as text so that they are exact."""
    return Loop(
        a=a, b=b, delay=Fraction(delay), dt=Fraction(dt), num=tuple(num), den=tuple(den)
    )  # fmt: skip
