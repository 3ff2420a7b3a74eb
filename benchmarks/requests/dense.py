"""A dense search over a law's parameters, by code that shares nothing with the library's laws.

Every parameter that is left is swept, the loop's equation at wc is solved as it stands (two real
unknowns, by Cramer's rule on the complex equation, or by sweeping), and signs are looked at. What
is found is handed to the analysis alone. A law's own formulas, intervals and phases are not
used.
"""

from cmath import exp
from collections.abc import Iterator
from math import degrees, radians, tan

import numpy as np
from benchmarks.requests.drawn import Request

import zoh
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.analysis.nyquist import closed_loop_stable
from zoh.lti.wplane import warp

MARGIN_DEG, CROSSOVER = 1e-9, 1e-9  # what a request is met to
A_FLOAT = 8 * 2.0**-53  # of L: a law is solved on a hold whose eight coefficients are rounded


def meets(sampled: zoh.Sampled, controller: zoh.Sampled, wc: float, pm_deg: float) -> bool:
    """Return whether the loop is stable and its margin the one asked for, by analysis alone."""
    loop = Loop.of(controller, sampled)  # not their product, whose coefficients are rounded
    if not closed_loop_stable(loop):
        return False
    m = measure_loop(loop)
    return bool(
        m.crossover is not None
        and abs(m.phase_margin_deg - pm_deg) <= MARGIN_DEG + _level(loop, m.crossover)
        and abs(m.crossover / wc - 1) <= CROSSOVER
    )


def _level(loop: Loop, w: float) -> float:
    """Return the deg that rounding of L moves a margin by where |L| is all but level."""
    top, bottom, slope_top, slope_bottom = loop.slopes(warp(w, loop.dt))
    slope = slope_top / top - slope_bottom / bottom
    return degrees(A_FLOAT * abs(slope.imag / slope.real))


def candidates(request: Request, wc: float, pm_deg: float) -> Iterator[zoh.Sampled]:
    """Yield every controller of the law with positive parameters that is on target at wc."""
    dt, given = request.sampled.dt, request.parameters
    w = 2j / dt * tan(wc * dt / 2)
    wanted = -exp(1j * radians(pm_deg)) / request.sampled.at(wc)
    for num, den in _of_law(request.law, given, wanted, w, dt):
        yield zoh.Sampled.from_w(num_w=num, den_w=den, dt=dt)


def _of_law(law, given, wanted, w, dt):
    if law == "p":
        if abs(wanted.imag) < 1e-12 * abs(wanted) and wanted.real > 0:
            yield [wanted.real], [1.0]
    elif law == "pi":  # kp 1 + ki /w
        kp, ki = _two(1, 1 / w, wanted)
        if kp > 0 and ki > 0:
            yield [kp, ki], [1.0, 0.0]
    elif law in ("pd", "pid"):
        p = given.get("filter_pole", 2 / dt)
        for ki in _integrals(law, given, wanted, w, p):
            kp, kd = _two(1, w / (1 + w / p), wanted - ki / w)
            if kp > 0 and kd > 0:
                num, den = [kp / p + kd, kp], [1 / p, 1.0]
                yield ([num[0], kp + ki / p, ki], [*den, 0.0]) if ki else (num, den)
    else:
        yield from _sections(law, given, wanted, w)


def _two(a: complex, b: complex, wanted: complex) -> tuple[float, float]:
    """Return real (x, y) with a x + b y = wanted."""
    a, b = complex(a), complex(b)
    det = a.real * b.imag - a.imag * b.real
    x = (wanted.real * b.imag - wanted.imag * b.real) / det
    return x, (a.real * wanted.imag - a.imag * wanted.real) / det


def _integrals(law, given, wanted, w, p):
    """Yield the ki to try; for a ratio, each where kp^2 - r ki kd changes its sign, halved."""
    if law == "pd":
        yield 0.0
    elif "ki" in given:
        yield given["ki"]
    else:
        unit = abs(wanted * w)

        def off(ki):
            kp, kd = _two(1, w / (1 + w / p), wanted - ki / w)
            if kd <= 0:  # kd grows with ki: below the interval, where kp^2 is more
                return 1.0
            return -1.0 if kp <= 0 else kp * kp - given["ti_td"] * ki * kd

        yield from _zeros(off, unit * np.geomspace(1e-9, 1e9, 901))


def _zeros(off, grid):
    """Yield where ``off`` changes its sign between two points of the grid, by halving."""
    values = [off(x) for x in grid]
    for a, b, fa, fb in zip(grid, grid[1:], values, values[1:], strict=False):
        if fa is None or fb is None or (fa > 0) == (fb > 0):
            continue
        for _ in range(100):
            middle = (a + b) / 2
            a, b = (middle, b) if (off(middle) > 0) == (fa > 0) else (a, middle)
        yield float((a + b) / 2)


def _sections(law, given, wanted, w):
    """Yield lags, leads and lead-lags: c (1 + w s)/(1 + w t) is linear in (s, t)."""
    a0, v = given["dc_gain"], abs(w)
    if law != "leadlag":
        first = _section(wanted / a0, w)
        if first and (first[0] > first[1]) == (law == "lead"):
            s, t = first
            yield [a0 * s, a0], [t, 1.0]
        return
    zero = 1 / given.get("lag_corner", v / 10)
    ratios = [given["lag_ratio"]] if "lag_ratio" in given else _centred(wanted / a0, w, zero)
    for r in ratios:
        rest = _section(wanted / a0 / ((1 + w * zero) / (1 + w * zero * r)), w)
        if rest and rest[0] > rest[1]:
            yield (
                np.polymul([a0 * rest[0], a0], [zero, 1.0]).tolist(),
                np.polymul([rest[1], 1.0], [zero * r, 1.0]).tolist(),
            )


def _section(wanted: complex, w: complex) -> tuple[float, float] | None:
    """Return positive times (s, t) with (1 + w s)/(1 + w t) = wanted, which is linear in them."""
    if abs((wanted * w * w.conjugate()).imag) < 1e-14 * abs(wanted * w * w):
        return None
    s, t = _two(w, -wanted * w, wanted - 1)
    return (s, t) if s > 0 and t > 0 else None


def _centred(wanted, w, zero):
    """Yield the ratios of a lag whose lead has its largest phase at wc: s t v^2 = 1."""

    def off(log_r):
        r = float(np.exp(log_r))
        found = _section(wanted / ((1 + w * zero) / (1 + w * zero * r)), w)
        if found is None or found[0] <= found[1]:
            return None
        return found[0] * found[1] * abs(w) ** 2 - 1

    for log_r in _zeros(off, np.linspace(1e-6, 25, 201)):
        yield float(np.exp(log_r))
