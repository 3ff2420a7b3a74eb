"""From a plant's motion over a sample to its transfer function in p."""

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.room import LATE, WHOLE, Plant


@compiled
def transfer(p: Plant, n: int) -> None:
    """Write top and bottom in p, from delta, before and after (Faddeev-LeVerrier)."""
    delta, m, product, rows = p.delta[WHOLE], p.matrix, p.other, p.fl
    integrators = 0
    while integrators < n - 1 and p.a[integrators] == 0.0:
        integrators += 1
    if integrators == n - 1 and p.a[n - 1] == 0.0:
        integrators = n
    char, top = p.b, p.top
    char[n] = 1.0
    for i in range(n):
        for j in range(n):
            m[i, j] = 1.0 if i == j else 0.0
            rows[i, j] = 0.0
    rows[n - 1, 0] = 1.0
    for k in range(n - 1, -1, -1):
        trace = 0.0
        for i in range(n):
            for j in range(n):
                total = 0.0
                for q in range(n):
                    total += delta[i, q] * m[q, j]
                product[i, j] = total
            trace += product[i, i]
        char[k] = -trace / (n - k) if k >= integrators else 0.0
        if k:
            for i in range(n):
                for j in range(n):
                    m[i, j] = product[i, j]
                m[i, i] += char[k]
            for j in range(n):
                rows[k - 1, j] = m[0, j]
    for k in range(n + 1):
        total = 0.0
        for i in range(n):
            if k < n:
                total += rows[k, i] * p.enters[WHOLE, i]
            if k:
                total += rows[k - 1, i] * p.enters[LATE, i]
        top[k] = total
    in_p(top, n, rows)
    for k in range(n + 1):
        p.bottom[k] = char[k]
    in_p(p.bottom, n, rows)


@compiled
def in_p(x: Array, n: int, work: Array) -> None:
    """Turn powers of z - 1 into powers of p, times (1 - p)^n: Horner's scheme in 2p and 1 - p."""
    out, power = work[0], work[1]
    for k in range(n + 1):
        out[k], power[k] = 0.0, 0.0
    power[0] = 1.0
    out[0] = x[n]
    for k in range(n - 1, -1, -1):
        degree = n - k
        for j in range(degree, 0, -1):
            power[j] -= power[j - 1]
            out[j] = 2.0 * out[j - 1]
        out[0] = 0.0
        for j in range(degree + 1):
            out[j] += x[k] * power[j]
    for k in range(n + 1):
        x[k] = out[k]
