"""The modes of loops side by side; see ``zoh.batch.compiled.modes``."""

from math import sqrt

from zoh.batch.compiled import work
from zoh.batch.compiled.abreast.room import LOOPS, X
from zoh.batch.compiled.jit import compiled
from zoh.batch.compiled.modes import ROOTS, STARTS
from zoh.batch.tolerances import APART

_TERM, _MOVES = 0, 5  # rows of the room: the polynomial; 1.0 where a loop's roots still move


@compiled
def modes(w: int, n: int) -> None:
    """Write z of each mode, |z|^2 - 1, |log z| where it is small, and the weights of its share."""
    start(w, n)
    for _ in range(ROOTS):
        if not approach(w, n):
            break
    turned(w, n)
    weights(w, n)


@compiled
def start(w: int, n: int) -> None:
    """Write the polynomial whose roots the modes are, and where they may be."""
    r = work.abreast(w)
    s, re, im = r.room, r.re, r.im
    for i in range(LOOPS):
        for k in range(n + 1):
            s[_TERM + k, i] = r.num[k, i] + r.den[k, i]
        for k in range(n):
            radius = abs(s[_TERM + k, i] / s[_TERM + k + 1, i])
            radius = radius if radius > 0.0 else 1.0
            radius = radius if radius < 1e300 else 1.0
            re[k, i], im[k, i] = radius * STARTS[0, n, k], radius * STARTS[1, n, k]
        s[_MOVES, i] = 1.0


@compiled
def approach(w: int, n: int) -> bool:
    """Move the roots by one step of Aberth's; return whether any of them has moved far."""
    r, far = work.abreast(w), 0
    s, re, im, at = r.room, r.re, r.im, r.roots
    for k in range(2 * n):
        for i in range(LOOPS):
            at[k, i] = 0.0
    for k in range(n):  # the sums of 1/(root - another); each pair's is worked out once
        for m in range(k + 1, n):
            for i in range(LOOPS):
                dr, di = re[k, i] - re[m, i], im[k, i] - im[m, i]
                square = dr * dr + di * di
                part = 1.0 / (square if square > 0.0 else 1.0)
                dr, di = dr * part, di * part
                at[2 * k, i] += dr
                at[2 * k + 1, i] -= di
                at[2 * m, i] -= dr
                at[2 * m + 1, i] += di
    for k in range(n):
        for i in range(LOOPS):
            a, b, tr, ti = re[k, i], im[k, i], at[2 * k, i], at[2 * k + 1, i]
            fr, fi, sr, si = s[_TERM + n, i], 0.0, 0.0, 0.0
            for m in range(n - 1, -1, -1):
                sr, si = sr * a - si * b + fr, sr * b + si * a + fi
                fr, fi = fr * a - fi * b + s[_TERM + m, i], fr * b + fi * a
            qr, qi = sr - (fr * tr - fi * ti), si - (fr * ti + fi * tr)
            square = qr * qr + qi * qi
            part = 1.0 / (square if square > 0.0 else 1.0)
            part = part if square > 0.0 else 0.0
            at[2 * k, i], at[2 * k + 1, i] = (fr * qr + fi * qi) * part, (fi * qr - fr * qi) * part
    for i in range(LOOPS):
        moves, on = s[_MOVES, i], 0
        for k in range(n):
            a, b, dr, di = re[k, i], im[k, i], at[2 * k, i] * moves, at[2 * k + 1, i] * moves
            on |= int(abs(dr) + abs(di) > APART * (abs(a) + abs(b)))
            re[k, i], im[k, i] = a - dr, b - di
        s[_MOVES, i] = 1.0 if on else 0.0
        far |= on
    return far != 0


@compiled
def turned(w: int, n: int) -> None:
    """Turn u = p/x into z; write |log z| where it is small, and |z|^2 - 1."""
    r = work.abreast(w)
    for i in range(LOOPS):
        x = r.plant[X, i]
        for k in range(n):
            a, b = r.re[k, i] * x, r.im[k, i] * x
            part = 1.0 / ((1.0 - a) * (1.0 - a) + b * b)
            r.re[k, i], r.im[k, i] = ((1.0 + a) * (1.0 - a) - b * b) * part, 2.0 * b * part
            r.turn[k, i], r.growth[k, i] = 2.0 * sqrt(a * a + b * b), 4.0 * a * part


@compiled
def weights(w: int, n: int) -> None:
    """Write the weights of each mode's share: the product of (S - mu_j + 1)/(mu_i - mu_j)."""
    r = work.abreast(w)
    re, im, wr, wi = r.re, r.im, r.wr, r.wi
    for k in range(n):
        for i in range(LOOPS):
            for m in range(n):
                wr[m * n + k, i], wi[m * n + k, i] = 0.0 if m else 1.0, 0.0
        for j in range(n):
            if j == k:
                continue
            for i in range(LOOPS):
                dr, di = re[k, i] - re[j, i], im[k, i] - im[j, i]
                part = 1.0 / (dr * dr + di * di)
                dr, di, sr, si = dr * part, -di * part, 1.0 - re[j, i], -im[j, i]
                a, b = 0.0, 0.0  # of the power below
                for m in range(n):
                    here, there = wr[m * n + k, i], wi[m * n + k, i]
                    c, d = a + here * sr - there * si, b + here * si + there * sr
                    wr[m * n + k, i], wi[m * n + k, i] = c * dr - d * di, c * di + d * dr
                    a, b = here, there
