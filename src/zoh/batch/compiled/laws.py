"""One law, solved at one crossover; see ``zoh.batch.arrays.laws``, its arithmetic."""

from math import acos, asin, atan, atan2, cos, nan, pi, sin, sqrt

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.polynomials import on_axis
from zoh.batch.compiled.room import Law, Plant
from zoh.batch.tolerances import RESONANT, SAME_TURN


@compiled
def solve(
    law: Law, p: Plant, n: int, delay: int, code: int, x: float, dt: float, pm_deg: float,
    spare: float, lag: float,
) -> int:  # fmt: skip
    """Write the law; return its order. spare: ki or dc_gain; lag: of the filter, in p."""
    a, b, _, _ = on_axis(p.top, n, x)
    c, d, _, _ = on_axis(p.bottom, n, x)
    size = sqrt((a * a + b * b) / (c * c + d * d))
    turn = (pm_deg - 180.0) * (pi / 180.0) - atan2(b * c - a * d, a * c + b * d)
    if delay:
        turn += 2.0 * delay * atan(x)
    theta = turn - 2.0 * pi * round(turn / (2.0 * pi))
    if resonant(p.top, n, x, sqrt(a * a + b * b)) or resonant(p.bottom, n, x, sqrt(c * c + d * d)):
        law.numbers[1] = nan
        return 0
    return aimed(law, code, size, theta, cos(theta), sin(theta), x, dt, spare, lag)


@compiled
def aimed(
    law: Law, code: int, size: float, theta: float, cosine: float, sine: float, x: float, dt: float,
    spare: float, lag: float,
) -> int:  # fmt: skip
    """Write the law that turns by theta where the plant's gain is this size; return its order.

    numbers: direct, room in rad (nan: floats do not tell), then the gains in the order of
    ``figures.gain_names``
    """
    real, imag, out = cosine / size, sine / size, law.numbers
    if code == 0:
        law.num[0], law.den[0] = 1.0 / size, 1.0
        out[0], out[1], out[2] = 1.0 / size, SAME_TURN - abs(theta), 1.0 / size
        return 0
    if code == 1:
        share = -x * imag
        law.num[0], law.num[1], law.den[0], law.den[1] = share, real, 0.0, 1.0
        pole(law, 0, 0.0, 2.0 * share)
        out[0], out[1] = real + share, min(theta + pi / 2.0, -theta)
        out[2], out[3] = real, share * (2.0 / dt)
        return 1
    if code <= 3:
        return pid(law, size, theta, imag, real, x, dt, spare if code == 3 else 0.0, lag, code == 3)
    ratio = spare * size
    turn = x * sine
    zero, corner = turn / (1.0 / ratio - cosine), turn / (cosine - ratio)
    law.num[0], law.num[1], law.den[0], law.den[1] = spare, spare / zero, 1.0, 1.0 / corner
    share = 1.0 / (1.0 + law.den[1])
    far = (law.num[0] + law.num[1]) * share
    if code == 5:
        lead(law, 0, 2.0 * share, far - spare)
        out[0], out[1] = spare, -1.0
    else:
        pole(law, 0, 2.0 * share, (spare - far) * 2.0 * share)
        out[0], out[1] = far, -1.0
    if code == 4 and ratio > 1.0:
        out[1] = min(theta + acos(1.0 / ratio), -theta)
    if code == 5 and ratio < 1.0:
        out[1] = min(theta, acos(ratio) - theta)
    out[2], out[3], out[4] = spare, zero * (2.0 / dt), corner * (2.0 / dt)
    return 1


@compiled
def resonant(a: Array, n: int, x: float, size: float) -> bool:
    """Return whether a(jx), of this size, lacks digits: an undamped root is beside it."""
    bulk = abs(a[n])
    for k in range(n - 1, -1, -1):
        bulk = bulk * x + abs(a[k])
    return not size > RESONANT * bulk


@compiled
def pid(
    law: Law, size: float, theta: float, imag: float, real: float, at: float, dt: float, ki: float,
    lag: float, integral: bool,
) -> int:  # fmt: skip
    """Write a PID or PD."""
    half = dt / 2.0
    x, share = at * lag, ki * half
    k = share * size / at
    reach = x * k / sqrt(1.0 + x * x)
    room = -1.0
    if reach < 1.0:
        bend, late = acos(reach), atan(x)
        low = max(-asin(k) if k < 1.0 else -pi, -bend - late)
        room = min(theta - low, bend - late - theta)
    imaginary = imag + share / at
    kp, rate = real - x * imaginary, imaginary * (1.0 + x * x) / at
    c = 1.0 / (1.0 + lag)
    out = law.numbers
    out[0], out[1] = kp + share, room
    shift = 1 if integral else 0
    lead(law, shift, 2.0 * c, rate * c)
    law.den[shift], law.den[shift + 1] = 1.0, lag
    law.num[shift], law.num[shift + 1] = kp + share * lag, kp * lag + rate
    out[2], out[3], out[4] = kp, rate * half, 1.0 / (lag * half)
    if integral:
        pole(law, 0, 0.0, 2.0 * share)
        law.num[0], law.den[0] = share, 0.0
        law.moves[0, 1], law.moves[1, 0] = 0.0, 0.0
        out[2], out[3], out[4], out[5] = kp, ki, rate * half, 1.0 / (lag * half)
    return 1 + shift


@compiled
def pole(law: Law, place: int, at: float, residue: float) -> None:
    """Write residue/(z - 1 + at)."""
    law.moves[place, place], law.residues[place] = -at, residue
    law.enters[place], law.leads[place] = 1.0, 0.0


@compiled
def lead(law: Law, place: int, at: float, residue: float) -> None:
    """Write residue (z - 1)/(z - 1 + at)."""
    law.moves[place, place], law.residues[place] = -at, residue
    law.enters[place], law.leads[place] = 0.0, 1.0
