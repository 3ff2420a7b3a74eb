"""Zero-order hold by matrix exponentials in mpmath. Shares no code with zoh.

A held unit pulse through the delayed plant leaves h_k = s(k dt - theta) - s((k-1) dt - theta),
with s the step response of the plant without its dead time theta. Then
G(z) = num(z)/(den(z) z^m), m = ceil(theta/dt), den the characteristic polynomial of
exp(A dt), and num the first n + 1 coefficients of den(z) sum h_(m+j) z^-j.

The working precision doubles until two of them agree, so no digit is taken on trust.
"""

import random
import sys
from itertools import pairwise

from mpmath import mp, mpf

SENSOR = 12 / 180
DTS = (1e3, 10.0, 1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
DEAD = (0.0, 0.3, 1.0, 2.7)  # in dt
DIGITS = 45  # written down
LIMIT = 1000  # of the largest |pole| dt; a coefficient below 1e-308 is a zero in floats


def convolve(a, b):
    out = [a[0] * 0] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i + j] += x * y
    return out


def companion(num, den):
    """Return A, B, C, D (mp) of num/den, coefficients in descending powers, taken exactly."""
    lead = mpf(den[0])
    a = [mpf(x) / lead for x in den[1:]]
    n = len(a)
    b = [mpf(0)] * (n + 1 - len(num)) + [mpf(x) / lead for x in num]
    direct = b[0]
    matrix = mp.zeros(n, n)
    for i in range(n - 1):
        matrix[i, i + 1] = mpf(1)
    for i in range(n):
        matrix[n - 1, i] = -a[n - 1 - i]
    col = mp.zeros(n, 1)
    col[n - 1] = mpf(1)
    row = [b[n - i] - direct * a[n - 1 - i] for i in range(n)]
    return matrix, col, row, direct


def hold_matrices(matrix, col, t):
    """Return exp(A t) and the integral of exp(A tau) B over (0, t)."""
    n = matrix.rows
    if not t:
        return mp.eye(n), mp.zeros(n, 1)
    big = mp.zeros(n + 1, n + 1)
    for i in range(n):
        for j in range(n):
            big[i, j] = matrix[i, j] * t
        big[i, n] = col[i] * t
    out = mp.expm(big, method="taylor")
    return out[:n, :n], out[:n, n]


def characteristic(matrix):
    """Return the characteristic polynomial, by Faddeev and LeVerrier."""
    n = matrix.rows
    m, out = mp.eye(n), [mpf(1)]
    for k in range(1, n + 1):
        m = matrix * m
        c = -sum(m[i, i] for i in range(n)) / k
        out.append(c)
        for i in range(n):
            m[i, i] += c
    return out


def whole_and_rest(theta, dt):
    """Return (m, eps) with theta = m dt - eps, 0 <= eps < dt; whole to rounding means eps = 0."""
    ratio = mpf(theta) / mpf(dt)
    if abs(ratio - mp.nint(ratio)) <= mpf(2) ** -50 * max(ratio, 1):
        return int(mp.nint(ratio)), mpf(0)
    m = int(mp.ceil(ratio))
    return m, m * mpf(dt) - mpf(theta)


def once(num, den, gain, dt, theta):
    """Return (num, den, m) in z at the present working precision."""
    matrix, col, row, direct = companion(num, den)
    n = matrix.rows
    m, eps = whole_and_rest(theta, dt)
    phi, gamma = hold_matrices(matrix, col, mpf(dt))
    _, x = hold_matrices(matrix, col, eps)
    responses = []
    for _ in range(n + 1):
        responses.append(sum(row[i] * x[i] for i in range(n)) + direct)
        x = phi * x + gamma
    pulses = [responses[0]] + [b - a for a, b in pairwise(responses)]
    bottom = characteristic(phi)
    top = [sum(bottom[i] * pulses[j - i] for i in range(j + 1)) for j in range(n + 1)]
    return [mpf(gain) * c for c in top], bottom, m


def in_w(a, dt):
    """Return (1 - w dt/2)^n a(z), descending powers of w, by evaluating and adding up."""
    n = len(a) - 1
    h = mpf(dt) / 2
    total = [mpf(0)] * (n + 1)
    for i, c in enumerate(a):
        term = [c]
        for _ in range(n - i):
            term = convolve(term, [h, mpf(1)])
        for _ in range(i):
            term = convolve(term, [-h, mpf(1)])
        total = [x + y for x, y in zip(total, term, strict=True)]
    return total


def clean(values, digits):
    """Return values with what is only the rounding of a zero set to zero."""
    size = max(abs(v) for v in values)
    return [mpf(0) if abs(v) < size * mpf(10) ** (-digits * 0.8) else v for v in values]


def agree(one, two, digits):
    return all(abs(a - b) <= abs(b) * mpf(10) ** -digits for a, b in zip(one, two, strict=True))


def exact_hold(num, den, gain, dt, theta, digits=DIGITS + 3):
    """Return num_z, den_z, num_w, den_w, m; each coefficient correct to ``digits`` digits."""
    work, last = 200, None
    while work < 20000:
        with mp.workdps(work):
            top, bottom, m = once(num, den, gain, dt, theta)
            wide = max(mp.mpf(dt), 1 / mp.mpf(dt))
            # a w-coefficient is a dt^k fraction of the z-coefficients: judge it on that scale
            scale = int(mp.log10(wide)) * len(den)
            parts = [clean(top, work), clean(bottom, work)]
            parts += [rescaled(in_w(p, dt), dt, work - scale) for p in parts]
            if last and all(agree(a, b, digits) for a, b in zip(last, parts, strict=True)):
                return *parts, m
            last = parts
        work *= 2
    raise ArithmeticError("no agreement")


def rescaled(a, dt, digits):
    """Clean a polynomial in w after scaling w to 1/dt."""
    n = len(a) - 1
    h = mpf(dt)
    flat = clean([c / h ** (n - k) for k, c in enumerate(a)], digits)
    return [c * h ** (n - k) for k, c in enumerate(flat)]


def polynomial(roots):
    out = [1.0]
    for r in roots:
        pair = isinstance(r, tuple)
        out = convolve(out, [1.0, -2 * r[0], r[0] ** 2 + r[1] ** 2] if pair else [1.0, -r])
    return out


def plants():
    """Return (name, num, den, sensor); the floats are the plant, exactly."""
    rng = random.Random(20)
    poles = [-rng.uniform(0.2, 3) for _ in range(4)]
    poles += [(-rng.uniform(0.1, 1), rng.uniform(0.5, 4)) for _ in range(3)]
    zeros = [-rng.uniform(0.2, 3) for _ in range(3)] + [(-rng.uniform(-0.3, 1), 2.2)]
    return [
        ("arm", [2.3], [1.0, 0.7809, 0.0], SENSOR),
        ("double integrator", [1.0], [1.0, 0.0, 0.0], 1.0),
        ("four equal lags", [1.0], [1.0, 4.0, 6.0, 4.0, 1.0], 1.0),
        ("lag", [3.7], [1.0, 0.37], 1.0),
        ("resonance", [25.0], [1.0, 0.1, 25.0], 1.0),
        ("unstable", [1.0], [1.0, 1.0, -2.0], 1.0),
        ("order 10", [2.0 * c for c in polynomial(zeros)], polynomial(poles), 1.0),
        ("repeated pairs", [1.0, 3.0], polynomial([(-0.5, 2.0), (-0.5, 2.0), -1.0, -1.0]), 1.0),
        ("triple integrator", [0.5, 1.0], [1.0, 0.0, 0.0, 0.0], 1.0),
        ("feedthrough", [1.0, 2.0], [1.0, 1.0], 1.0),
        ("stiff", [100.0], polynomial([-1e-2, -1e4]), 1.0),
        ("zero at the origin", [1.0, 0.0], [1.0, 3.0, 2.0], 1.0),
        ("zero on the right", [-1.0, 2.0], [1.0, 3.0, 3.0, 1.0], 1.0),
        ("den[0] is not 1", [0.2, 1.0], [4.0, 0.3, 0.7], -2.5),
    ]


FASTEST = {
    "arm": 0.78,
    "double integrator": 0.0,
    "triple integrator": 0.0,
    "lag": 0.37,
    "feedthrough": 1.0,
    "stiff": 1e4,
    "order 10": 4.2,
    "resonance": 5.0,
}


def text(values):
    return [mp.nstr(v, DIGITS, min_fixed=0, max_fixed=0) for v in values]


def make():
    cases = []
    for name, num, den, sensor in plants():
        for dt in DTS:
            if FASTEST.get(name, 2.3) * dt > LIMIT:
                continue
            for share in DEAD:
                theta = share * dt
                cases.append(one_case(name, num, den, sensor, dt, theta))
        sys.stderr.write(f"hold: {name}, {len(cases)} cases\n")
    cases.append(one_case("arm", [2.3], [1.0, 0.7809, 0.0], SENSOR, 0.1, 3 * 0.1))
    cases.append(one_case("arm", [2.3], [1.0, 0.7809, 0.0], SENSOR, 0.1, 0.6))
    return cases


def one_case(name, num, den, sensor, dt, theta):
    top, bottom, top_w, bottom_w, m = exact_hold(num, den, sensor, dt, theta)
    return {
        "plant": name,
        "num": num,
        "den": den,
        "sensor": sensor,
        "dt": dt,
        "dead_time": theta,
        "m": m,
        "num_z": text(top),
        "den_z": text(bottom),
        "num_w": text(top_w),
        "den_w": text(bottom_w),
    }
