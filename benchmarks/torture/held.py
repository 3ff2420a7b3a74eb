"""A plant held and sampled, from its state space, in as many digits as it takes.

With x' = A x + B u held over dt the matrix exponential of [[A, B], [0, 0]] gives
x+ = Phi x + Gamma u, and a dead time that ends e before a sample is read e later:
y = C Phi(e) x + (C Gamma(e) + D) u. The fraction in z follows from two determinants::

    den = det(zI - Phi),   num = det(zI - Phi + Gamma C') + (D' - 1) den

Source: K. J. Astrom, B. Wittenmark, Computer-Controlled Systems, 3rd ed., ch. 2.
"""

from collections.abc import Sequence
from math import ceil, log10

from mpmath import matrix, mp, mpf

Exact = list[mpf]


def held(
    num: Sequence[float], den: Sequence[float], dt: float, dead_time: float = 0.0
) -> tuple[Exact, Exact, int]:
    """Return (num, den, m): the held plant is num(z)/den(z) z**-m, ascending powers of z.

    Poles and zeros at s = 0 come out as exact ones at z = 1.
    """
    ratio = dead_time / dt
    whole = abs(ratio - round(ratio)) <= 1e-15 * ratio  # 0.3/0.1 is 3, but for its rounding
    m = round(ratio) if whole else ceil(ratio)
    with mp.workdps(digits_for(num, den, dt)):
        e = mpf(0) if whole else m * mpf(dt) - mpf(dead_time)
        a, b, c, d = state_space(num, den)
        phi, gamma = over(a, b, mpf(dt))
        if e:
            phi_e, gamma_e = over(a, b, e)
            c, d = c * phi_e, d + (c * gamma_e)[0]
        bottom = _characteristic(phi)
        moved = _characteristic(phi - gamma * c)
        top = [x + (d - 1) * y for x, y in zip(moved, bottom, strict=True)]
        k = _zeros_at_origin(den)
        zeros = min(_zeros_at_origin(num), 1) if k == 0 else 0
        return _at_one(top, zeros), _at_one(bottom, k), m


def digits_for(num: Sequence[float], den: Sequence[float], dt: float) -> int:
    """Return decimal digits that leave more than a hundred after every cancellation."""
    n = len(den) - 1
    sizes = [abs(c / den[0]) ** (1 / i) for i, c in enumerate(den) if i and c]
    fast = max(sizes, default=1.0) * dt
    slow = min(sizes, default=1.0) * dt
    spread = [log10(abs(c)) for c in (*num, *den) if c]
    lost = 2 * n * max(0.0, -log10(slow)) + 2 * n * fast / 2.3 + max(spread) - min(spread)
    return 140 + int(min(lost, 4000))


def state_space(num: Sequence[float], den: Sequence[float]) -> tuple[matrix, matrix, matrix, mpf]:
    n = len(den) - 1
    bottom = [mpf(c) / mpf(den[0]) for c in den]
    top = [mpf(0)] * (n + 1 - len(num)) + [mpf(c) / mpf(den[0]) for c in num]
    d = top[0]
    a, b, c = matrix(n, n), matrix(n, 1), matrix(1, n)
    for i in range(n - 1):
        a[i, i + 1] = 1
    for i in range(n):
        a[n - 1, i] = -bottom[n - i]
        c[0, i] = top[n - i] - d * bottom[n - i]
    if n:
        b[n - 1, 0] = 1
    return a, b, c, d


def over(a: matrix, b: matrix, t: mpf) -> tuple[matrix, matrix]:
    """Return Phi(t) and Gamma(t) by Taylor's series on a halved step, squared back."""
    n = a.rows
    whole = matrix(n + 1, n + 1)
    for i in range(n):
        for j in range(n):
            whole[i, j] = a[i, j] * t
        whole[i, n] = b[i, 0] * t
    size = max(sum(abs(whole[i, j]) for j in range(n + 1)) for i in range(n + 1)) + 1
    halvings = max(0, int(mp.ceil(mp.log(size, 2)))) + 6
    with mp.workdps(mp.dps + halvings):
        step = whole / mpf(2) ** halvings
        total, term, k = mp.eye(n + 1) + step, step, 1
        while mp.mnorm(term, 1) > mpf(10) ** -(mp.dps + 5):
            k += 1
            term = term * step / k
            total = total + term
        for _ in range(halvings):
            total = total * total
    return total[:n, :n], total[:n, n]


def _characteristic(a: matrix) -> Exact:
    """Return det(zI - a), ascending, by Faddeev and LeVerrier's scheme."""
    n = a.rows
    out, m = [mpf(1)], matrix(n, n)
    for k in range(1, n + 1):
        m = a * m + out[-1] * mp.eye(n)
        product = a * m
        out.append(-sum(product[i, i] for i in range(n)) / k)
    return out[::-1]


def _zeros_at_origin(a: Sequence[float]) -> int:
    return next(i for i, c in enumerate(reversed(a)) if c)


def _at_one(a: Exact, k: int) -> Exact:
    """Return ``a`` with a k-fold root exactly at 1, where it has one to within its digits."""
    for _ in range(k):
        quotient, rest = [], mpf(0)
        for c in reversed(a):
            rest = rest + c
            quotient.append(rest)
        a = quotient[:-1][::-1]
    for _ in range(k):
        pairs = zip([mpf(0), *a], [*a, mpf(0)], strict=True)
        a = [mp.fsub(above, here, exact=True) for above, here in pairs]
    return a
