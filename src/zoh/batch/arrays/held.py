"""The zero-order hold of many plants at once, in floats, straight into the w-plane.

Time is counted in samples: with s -> s/dt a plant (a, b) becomes a_j dt^(n-j), b_j dt^(n-j). Its
state is the output and its derivatives, so that A is a companion matrix and B are the Markov
parameters h_j = C A^j B, which are 0 exactly where the plant's pole excess makes them so::

    delta = e^A - I,    B(t) = sum_m t^(m+1)/(m+1)! A^m B,    z x = (I + delta) x + B u

as series, halved first and doubled afterwards where the plant is fast. A delay of m samples
less the fraction ``lead`` adds (1 + (z - 1)) B(lead) and z^-m. The numerator C adj(x I - delta) B,
x = z - 1, comes from the Faddeev-LeVerrier recursion; p = w dt/2 = (z - 1)/(z + 1) is the variable
of the result. The gain at z = -1, where sampling puts a zero for an even excess, is made apart::

    G(-1) = sum_k E_k(lead) h_(k-1)/k!        (E_k: Euler's polynomials)

as 2 e^(x t)/(e^x + 1) = sum E_k(t) x^k/k!, and loses no digits at a small dt.
Source: K. J. Astrom, B. Wittenmark, Computer-Controlled Systems, 3rd ed., sec. 2.3 (hold, delays)
and 2.8 (zeros of sampled systems); NIST DLMF 24.2.6 (Euler's polynomials).
"""

from dataclasses import dataclass
from functools import cache
from math import factorial

import numpy as np
import numpy.typing as npt

from zoh.batch.tolerances import EULERS, SERIES, SLOW, SMALL

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """num, den in p = w dt/2, rows of ascending powers; delay in whole samples beside them.

    The same in time, u being the input ``delay`` samples ago: x moves by delta x + before u +
    after (u of one sample later - u), the output is x_0 + direct u. delta has the shape (n, n, B);
    x is the output and its derivatives by time in ``samples``, so many of which make a sample.

    off      by how much of it the gain at rest, or what an integrator makes of it, has come out off

    rows     C A^m, shape (m, n, B), in that unit of time;  markov  C A^m B
    """

    num: Array
    den: Array
    delay: npt.NDArray[np.int64]
    delta: Array
    before: Array
    after: Array
    direct: Array
    lead: Array
    samples: Array
    rows: Array
    markov: Array
    off: Array


def held(num: Array, den: Array, dt: Array, delay: npt.NDArray[np.int64], lead: Array) -> Held:
    """Return the hold of the plants num/den (rows of ascending powers of s, one column a plant).

    delay, lead  each plant's delay is (delay - lead) samples, 0 <= lead < 1
    The leading row of ``den`` is 1. num has as many rows as den.

    >>> one = np.ones(1)
    >>> h = held(np.array([[1.0], [0.0]]), np.array([[0.0], [1.0]]), one, np.array([0]), 0 * one)
    >>> h.num.ravel(), h.den.ravel()  # 1/(z - 1) is (1 - p)/(2 p)
    (array([ 1., -1.]), array([0., 2.]))
    """
    n = len(den) - 1
    powers = np.power(dt[None, :], np.arange(n, -1, -1.0)[:, None])
    a, b = den * powers, num * powers
    direct = b[n].copy()
    b = b[:n] - direct * a[:n]
    if not n:
        none = np.zeros((0, len(dt)))
        return Held(
            num=direct[None, :], den=np.ones((1, len(dt))), delay=delay, direct=direct,
            delta=none[None, :0], before=none, after=none, lead=lead, samples=np.ones_like(dt),
            rows=none[None, :0], markov=none, off=np.zeros_like(dt),
        )  # fmt: skip
    reach = _reach(a)
    halvings = _halvings(reach)
    h = _markov(a, b, max(SERIES + n, EULERS) + 1)
    unit = np.ldexp(1.0, -halvings)
    in_unit = a * np.power(unit[None, :], np.arange(n, -1, -1.0)[:, None])
    rows_ = powers_of(in_unit, SERIES)
    markov = h[: len(rows_)] * np.power(unit[None, :], np.arange(1.0, len(rows_) + 1)[:, None])
    delta, before = advanced(rows_, markov, halvings, np.ones_like(lead))
    after = advanced(rows_, markov, halvings, lead)[1] if lead.any() else np.zeros_like(before)
    char, rows = _adjugate(delta, _integrators(a))
    in_delta = _numerator(rows, before, after)
    top, bottom = _in_p(in_delta), _in_p(char)
    slow = reach <= SLOW
    if slow.any():
        at_nyquist = _at_nyquist(h[:, slow], lead[slow])
        top[n, slow] = at_nyquist * bottom[n, slow]
    return Held(
        num=top + direct * bottom, den=bottom, delay=delay,
        delta=delta, before=before, after=after, direct=direct, lead=lead, samples=1 / unit,
        rows=rows_, markov=markov, off=_off(a, b, top, bottom),
    )  # fmt: skip


def _off(a: Array, b: Array, top: Array, bottom: Array) -> Array:
    """Return how far the lowest powers are off: G is b_0/(a_i s^i) at rest, and so is its hold.

    A fast pole far beyond the others costs the low coefficients digits; they show it here.
    """
    i = np.argmax(a != 0, axis=0)[None, :]
    first, held_first = (np.take_along_axis(c, i, axis=0)[0] for c in (a, bottom))
    with np.errstate(all="ignore"):
        off = top[0] / held_first * 2.0 ** i[0] * first / b[0] - 1
    return np.where(b[0] == 0, 0.0, off)


def _reach(a: Array) -> Array:
    """Return a bound on the poles' sizes (Fujiwara's)."""
    n = len(a) - 1
    bound: Array = 2 * np.max([np.abs(a[j]) ** (1 / (n - j)) for j in range(n)], axis=0)
    return bound


def _halvings(reach: Array) -> npt.NDArray[np.int64]:
    """Return how often the time must be halved until no pole is further than 1/2."""
    with np.errstate(divide="ignore"):
        wanted = np.ceil(np.log2(reach / SMALL))
    return np.maximum(wanted, 0.0).astype(np.int64)


def _markov(a: Array, b: Array, count: int) -> Array:
    """Return C A^j B for j < count."""
    n = len(b)
    h = np.zeros((count, a.shape[1]))
    for j in range(count):
        if j < n:
            h[j] = b[n - 1 - j]
        for i in range(1, min(j, n) + 1):
            h[j] -= a[n - i] * h[j - i]
    return h


def powers_of(a: Array, terms: int) -> Array:
    """Return C A^m of the companion matrix for m < n + terms, shape (n + terms, n, B)."""
    n = len(a) - 1
    rows = np.zeros((n + terms, n, a.shape[1]))
    rows[:n] = np.eye(n)[:, :, None]
    for m in range(n, n + terms):
        rows[m, 1:] = rows[m - 1, :-1]
        rows[m] -= rows[m - 1, -1] * a[:n]
    return rows


def advanced(
    rows: Array, h: Array, halvings: npt.NDArray[np.int64], t: Array
) -> tuple[Array, Array]:
    """Return (delta (n, n, B), B (n, B)) over t samples, 0 <= t <= 1, h the Markov parameters."""
    n = rows.shape[1]
    delta, b = np.zeros((n, n, len(t))), np.zeros((n, len(t)))
    for m in range(SERIES, 0, -1):
        delta = (delta + rows[m : m + n]) * (t / m)
        b = (b + h[m - 1 : m - 1 + n]) * (t / m)
    for k in range(int(halvings.max(initial=0))):
        more = halvings > k
        delta, b = _twice(delta, b, more)
    return delta, b


def _twice(delta: Array, b: Array, more: npt.NDArray[np.bool_]) -> tuple[Array, Array]:
    d = delta[:, :, more]
    delta, b = delta.copy(), b.copy()
    b[:, more] = 2 * b[:, more] + np.einsum("ijb,jb->ib", d, b[:, more])
    delta[:, :, more] = 2 * d + np.einsum("ijb,jkb->ikb", d, d)
    return delta, b


def _integrators(a: Array) -> int:
    """Return how many poles at 0 every one of the plants has."""
    count = 0
    while count < len(a) - 1 and not a[count].any():
        count += 1
    return count


def _adjugate(delta: Array, integrators: int) -> tuple[Array, Array]:
    """Return det(x I - delta), (n+1, B), and C adj(x I - delta), (n, n, B), by powers of x."""
    n = len(delta)
    char = np.zeros((n + 1, delta.shape[2]))
    char[n] = 1.0
    rows = np.zeros_like(delta)
    rows[n - 1, 0] = 1.0
    matrix = np.repeat(np.eye(n)[:, :, None], delta.shape[2], axis=2)
    for k in range(n - 1, -1, -1):
        product = np.einsum("ijb,jkb->ikb", delta, matrix)
        if k >= integrators:
            char[k] = -np.einsum("iib->b", product) / (n - k)
        if k:
            matrix = product + char[k] * np.eye(n)[:, :, None]
            rows[k - 1] = matrix[0]
    return char, rows


def _numerator(rows: Array, before: Array, after: Array) -> Array:
    """Return C adj(x I - delta) (before + x after), (n+1, B)."""
    n = len(rows)
    top = np.zeros((n + 1, rows.shape[2]))
    top[:n] = np.einsum("kib,ib->kb", rows, before)
    top[1:] += np.einsum("kib,ib->kb", rows, after)
    return top


def _in_p(x: Array) -> Array:
    """Return sum_k x_k (2p)^k (1 - p)^(n-k) by powers of p; z - 1 is 2p/(1 - p)."""
    out = np.zeros_like(x)
    n = len(x) - 1
    for k in range(n + 1):
        for j in range(n - k + 1):
            binomial = factorial(n - k) // (factorial(j) * factorial(n - k - j))
            out[k + j] += (-1) ** j * binomial * 2**k * x[k]
    return out


def _at_nyquist(h: Array, lead: Array) -> Array:
    """Return the plants' gain at z = -1 but for their whole samples of delay."""
    if not lead.any():
        return np.asarray(_euler(EULERS)[1:, 0] @ h[:EULERS])
    powers = np.vander(lead, EULERS + 1, increasing=True).T
    return np.asarray(np.sum((_euler(EULERS)[1:] @ powers) * h[:EULERS], axis=0))


@cache
def _euler(count: int) -> Array:
    """Return the coefficients of E_k(t)/k!, a row for each k up to count, by ascending powers.

    From 2 e^(xt) = (e^x + 1) sum_k E_k(t)/k! x^k.
    """
    found = np.zeros((count + 1, count + 1))
    for k in range(count + 1):
        found[k, k] = 2 / factorial(k)
        for j in range(k):
            found[k] -= found[j] / factorial(k - j)
        found[k] /= 2
    return found
