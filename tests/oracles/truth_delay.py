"""Margins of a strictly proper continuous loop with dead time, by scanning and closing in.

The phase crossings are endless; those up to ``limit`` = 40/dead_time are written down. The
zeros of den + num exp(-s theta) on the right are counted by the argument principle.
"""

import cmath
from itertools import pairwise
from math import pi

from mpmath import mp, mpc, mpf


def with_dead_time(spec, described):
    num, den, theta = spec["num"], spec["den"], spec["dead_time"]

    def loop(w):
        s = mpc(0, w)
        return ratio(num, den, s) * mp.exp(-s * mpf(theta))

    limit = 40 / theta
    points = grid(theta, limit)
    gains = [(w, mp.degrees(mp.arg(-loop(w)))) for w in size_crossings(loop, points)]
    phases = []
    for a, b in changes(lambda w: complex(loop(w)).imag, points):
        w = close_in(lambda x: loop(x).imag, a, b)
        if loop(w).real < 0:
            phases.append((w, -1 / loop(w).real))
    at_zero = num[-1] / den[-1] if den[-1] else 0.0
    if at_zero < 0:
        phases.insert(0, (mpf(0), -1 / mpf(at_zero)))
    start = mpf(num[-1]) / mpf(den[-1]) if den[-1] else mp.inf  # L(0); L(infinity) is 0
    if start == mp.inf:
        ends = (start, 1), (1, mp.inf), (1, 1)
    else:
        ends = (1 + start, 1), (1 + 1 / start, mp.inf), ((1 + start) / (1 - start), 1)
    ends = [[abs(mpf(x)) for x in pair] for pair in ends]
    modulus = least(lambda w: abs(1 + loop(w)), points, ends[0])
    inverse_mt = least(lambda w: abs(1 + 1 / loop(w)), points, ends[1])
    disk = least(lambda w: abs((1 + loop(w)) / (1 - loop(w))), points, ends[2])
    stable = zeros_on_the_right(num, den, theta) == 0
    found = described(stable, gains, phases, modulus, 1 / inverse_mt, 2 * disk)
    return found | {"limit": limit}


def ratio(num, den, s):
    top, bottom = mpc(0), mpc(0)
    for c in num:
        top = top * s + mpf(c)
    for c in den:
        bottom = bottom * s + mpf(c)
    return top / bottom


def grid(theta, limit):
    low = [1e-4 * 10 ** (i / 150) for i in range(900)]
    fine = [i * 0.02 / theta for i in range(1, 2000)]
    return sorted({w for w in low + fine if w < limit})


def changes(f, points):
    values = [f(w) for w in points]
    pairs = zip(points, points[1:], values, values[1:], strict=False)
    return [(a, b) for a, b, fa, fb in pairs if (fa > 0) != (fb > 0)]


def close_in(f, a, b):
    return mp.findroot(f, (mpf(a), mpf(b)), solver="anderson", tol=mpf(10) ** -90, maxsteps=300)


def size_crossings(loop, points):
    return [
        close_in(lambda x: mp.log(abs(loop(x))), a, b)
        for a, b in changes(lambda w: float(abs(loop(w))) - 1, points)
    ]


def least(f, points, ends):
    """Return the minimum of f, by golden sections around the least point of the grid.

    ``ends`` are its values at w = 0 and at infinity.
    """
    values = [float(f(w)) for w in points]
    i = values.index(min(values))
    a, b = mpf(points[max(i - 1, 0)]), mpf(points[min(i + 1, len(points) - 1)])
    golden = (mp.sqrt(5) - 1) / 2
    for _ in range(140):  # 0.618^140 = 1e-29 of the bracket; the minimum is quadratically better
        c, d = b - golden * (b - a), a + golden * (b - a)
        if f(c) < f(d):
            b = d
        else:
            a = c
    return min(f((a + b) / 2), *ends)


def zeros_on_the_right(num, den, theta):
    """Count the zeros of den + num exp(-s theta) inside a large half disc, by its turning."""

    def f(s):
        top = sum(c * s ** (len(num) - 1 - i) for i, c in enumerate(num))
        bottom = sum(c * s ** (len(den) - 1 - i) for i, c in enumerate(den))
        return bottom + top * cmath.exp(-s * theta)

    radius = 100 * (1 + sum(map(abs, [*num, *den])))
    count = int(radius * theta * 20) + 20000
    axis = [1j * radius * (1 - 2 * i / count) for i in range(count + 1)]
    arc = [radius * cmath.exp(1j * pi * (i / 20000 - 0.5)) for i in range(20001)]
    total = 0.0
    for path in (axis, arc):
        values = [f(s) for s in path]
        for a, b in pairwise(values):
            step = cmath.phase(b / a)
            if abs(step) > 1.5:
                raise ArithmeticError("the path is too coarse")
            total += step
    return round(total / (2 * pi))
