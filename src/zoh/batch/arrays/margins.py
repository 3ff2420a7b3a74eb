"""All margins of many loops at once; the single measure in ``zoh.analysis`` says what each is.

A loop is num(u)/den(u) with u = w/v, v the frequency that the law was solved at: its crossover is
at u = j, where floats hold the most. Crossings are the sign changes of polynomials in q = (v/vc)^2,
polished on the complex response itself; a peak is proved by what is left of
|num + den|^2 - m |below|^2 without its double root, which has no positive root if m is the least.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from zoh.batch.arrays import rows
from zoh.batch.arrays.rows import Array, Mask
from zoh.batch.tolerances import DROP, ON_IT_DEG, PIVOT, UNITY

Index = npt.NDArray[np.intp]

_GRID = np.geomspace(1e-4, 1e7, 40)  # of q, where a peak is first looked for
_POLISH = 3
_FLAT = 1e-8  # of q: a/b is within its square of its least
_BESIDE = 1e-6  # of q: this far from the least the slope has a sign that rounding does not make
_STEPS = 100
_MISSED = 1e-10  # of the least value: where a glance saw one lower by more, a root was missed


@dataclass(frozen=True, slots=True, kw_only=True)
class Loops:
    """Open loops num(u)/den(u), rows of ascending powers, equally many.

    x   tan(wc dt/2): u = p/x;   dt  s
    """

    num: Array
    den: Array
    x: Array
    dt: Array

    def frequency(self, v: Array) -> Array:
        """Return rad/s of u = jv; pi/dt where v is inf."""
        return 2 / self.dt * np.arctan(self.x * v)


def stable(loops: Loops) -> tuple[Mask, Mask]:
    """Return (whether each closed loop is stable, whether rounding may have decided it).

    Routh's scheme of num + den, every row freed of its size.
    """
    c = (loops.num + loops.den)[::-1]
    c = c / np.max(np.abs(c), axis=0)
    above, row = c[::2].copy(), c[1::2].copy()
    good, doubt = c[0] * c[-1] > 0, np.zeros(c.shape[1], bool)
    sign = np.sign(c[0])
    with np.errstate(all="ignore"):
        for _ in range(len(c) - 1):
            width = len(row)
            pivot = row[0] * sign
            good &= pivot > 0
            doubt |= np.abs(row[0]) <= PIVOT * np.max(np.abs(row), axis=0)
            ratio = above[0] / row[0]
            following = above[1:].copy()
            minus = ratio * row[1:]
            bulk = np.abs(following)
            following[: width - 1] -= minus
            bulk[: width - 1] += np.abs(minus)
            if not len(following):
                break
            doubt |= np.abs(following[0]) <= PIVOT * bulk[0]
            above, row = row, following
    return good, doubt | ~np.isfinite(c).all(axis=0)


def measured(loops: Loops) -> tuple[dict[str, Array], Mask]:
    """Return (every margin by name, which loops had better be measured one by one)."""
    n, d = loops.num, loops.den
    nn, dd, aa = rows.squared(n), rows.squared(d), rows.squared(n + d)
    with np.errstate(all="ignore"):
        found, doubt = _by_gain(loops, nn - dd)
        more, unsure = _by_phase(loops)
        found |= more
        doubt |= unsure
        on_grid = _on_grid(aa)
        peaks = {"modulus": dd, "mt": nn, "disk": rows.squared(d - n)}
        for name, below in peaks.items():
            v, unsure = _lowest(aa, below, on_grid)
            doubt |= unsure
            found |= _peak(loops, name, v)
        found["bandwidth"], unsure = _bandwidth(loops, nn, aa)
    return found, doubt | unsure


def _by_gain(loops: Loops, gain: Array) -> tuple[dict[str, Array], Mask]:
    q, doubt = rows.positive_roots(gain)
    top, bottom = np.abs(loops.num[-1]), np.abs(loops.den[-1])
    doubt |= np.abs(top - bottom) <= UNITY * bottom
    doubt |= np.abs(np.abs(loops.num[0]) - np.abs(loops.den[0])) <= UNITY * np.abs(loops.den[0])
    v = np.sqrt(q)
    there = np.isfinite(v)
    v = np.where(there, v, 1.0)
    for _ in range(_POLISH):
        n, of_n = rows.on_axis(loops.num, v)
        d, of_d = rows.on_axis(loops.den, v)
        slope = -(of_n / n - of_d / d).imag
        v = v - (np.log(np.abs(n)) - np.log(np.abs(d))) / slope
    n, _ = rows.on_axis(loops.num, v)
    d, _ = rows.on_axis(loops.den, v)
    pm = np.degrees(np.angle(-n * np.conj(d)))
    pm = np.where(there, np.where(pm <= -180, 180.0, pm), np.inf)
    w = loops.frequency(v)
    late = np.where(np.abs(pm) < ON_IT_DEG, 0.0, np.radians(pm) % (2 * np.pi) / w)
    loud = (top >= bottom) & (top > 0)
    delay = np.min(np.where(there, late, np.inf), axis=0, initial=np.inf)
    nearest, none = _least(np.abs(pm)), np.asarray(~there.any(axis=0))
    return {
        "phase_margin_deg": np.where(none, np.inf, _taken(pm, nearest, none)),
        "crossover": np.where(none, np.nan, _taken(w, nearest, none)),
        "delay_margin": np.minimum(delay, np.where(loud, loops.dt, np.inf)),
    }, doubt


def _by_phase(loops: Loops) -> tuple[dict[str, Array], Mask]:
    (n_even, n_odd), (d_even, d_odd) = rows.halves(loops.num), rows.halves(loops.den)
    turn = _minus(rows.times(n_odd, d_even), rows.times(n_even, d_odd))
    q, doubt = rows.positive_roots(turn)
    v = np.sqrt(q)
    there = np.isfinite(v)
    v = np.where(there, v, 1.0)
    for _ in range(_POLISH):
        n, of_n = rows.on_axis(loops.num, v)
        d, of_d = rows.on_axis(loops.den, v)
        v = v - (n * d.conj()).imag / (of_n * d.conj() - n * of_d.conj()).real
    n, _ = rows.on_axis(loops.num, v)
    d, _ = rows.on_axis(loops.den, v)
    product = (n * d.conj()).real
    doubt |= (there & (np.abs(product) < 1e-10 * np.abs(n) * np.abs(d))).any(axis=0)
    there &= product < 0
    factor = np.where(there, -(np.abs(d) ** 2) / product, np.inf)
    ends = [(loops.num[0], loops.den[0], 0.0), (loops.num[-1], loops.den[-1], np.inf)]
    factors = [np.where(a * b < 0, -b / a, np.inf) for a, b, _ in ends]
    places = [np.full(v.shape[1], end) for *_, end in ends]
    factor, v = np.concatenate([factor, factors]), np.concatenate([v, places])
    there = np.isfinite(factor)
    nearest, none = _least(np.abs(np.log(factor))), np.asarray(~there.any(axis=0))
    return {
        "gain_margin": np.where(none, np.inf, _taken(factor, nearest, none)),
        "phase_crossover": np.where(none, np.nan, loops.frequency(_taken(v, nearest, none))),
    }, doubt


def _minus(a: Array, b: Array) -> Array:
    out = np.zeros((max(len(a), len(b)), a.shape[1]))
    out[: len(a)] += a
    out[: len(b)] -= b
    return out


def _least(size: Array) -> Index:
    return np.argmin(size, axis=0) if len(size) else np.zeros(size.shape[1], np.intp)


def _taken(values: Array, rows_: Index, none: Mask) -> Array:
    if not len(values):
        return np.full(len(none), np.nan)
    return np.asarray(np.take_along_axis(values, rows_[None, :], axis=0)[0])


def _lowest(a: Array, b: Array, on_grid: Array) -> tuple[Array, Mask]:
    """Return (v where a/b is least over q = v^2 in [0, inf], whether that is in doubt).

    on_grid  a at the points of the grid
    """
    ratio = on_grid / _on_grid(b)
    best = np.clip(np.argmin(ratio, axis=0), 1, len(_GRID) - 2)
    q, inside = _flat(a, b, _GRID[best - 1], _GRID[best + 1], _GRID[best])
    value = rows.at(a, q) / rows.at(b, q)
    v = np.sqrt(q)
    for end, here in ((0.0, a[0] / b[0]), (np.inf, a[-1] / b[-1])):
        lower = here <= value * (1 + 1e-14)
        v, value = np.where(lower, end, v), np.where(lower, here, value)
    proved = (inside | (v == 0) | np.isinf(v)) & _nothing_below(a - value * b, v * v)
    (open_,) = np.nonzero(~proved)
    doubt = np.zeros(len(v), bool)
    if len(open_):
        v[open_], least, doubt[open_] = _by_slopes(a[:, open_], b[:, open_])
        doubt[open_] |= value[open_] < least * (1 - _MISSED)
    return v, doubt


def _on_grid(a: Array) -> Array:
    return np.asarray(_GRID[:, None] ** np.arange(len(a)) @ a)


def _flat(a: Array, b: Array, low: Array, high: Array, q: Array) -> tuple[Array, Mask]:
    """Return (where the slope of a/b becomes positive in (low, high), whether it does).

    Half the digits of it are enough, as a/b is flat there; the last of Newton's steps has more.
    """
    da, db = rows.derivative(a), rows.derivative(b)
    out = np.empty_like(q)
    index, step, f = np.arange(len(q)), np.full(len(q), np.inf), (a, b, da, db)
    for _ in range(_STEPS):
        slope, bend = _slope(*f, q)
        left = slope < 0
        low, high = np.where(left, q, low), np.where(left, high, q)
        new = q - slope / bend
        inside = (new > low) & (new < high) & (2 * np.abs(new - q) <= step)
        last, q = q, np.where(inside, new, np.sqrt(low * high))
        step = np.abs(q - last)
        go = step > _FLAT * q
        if np.all(go):
            continue
        out[index[~go]] = q[~go]
        if not go.any():
            break
        index, low, high, q, step = index[go], low[go], high[go], q[go], step[go]
        f = (f[0][:, go], f[1][:, go], f[2][:, go], f[3][:, go])
    out[index] = q
    falls = _slope(a, b, da, db, out * (1 - _BESIDE))[0] < 0
    return out, falls & (_slope(a, b, da, db, out * (1 + _BESIDE))[0] > 0)


def _slope(a: Array, b: Array, da: Array, db: Array, q: Array) -> tuple[Array, Array]:
    """Return (a' b - a b', its derivative) at q."""
    at_a, at_b = rows.at(a, q), rows.at(b, q)
    (of_a, bend_a), (of_b, bend_b) = rows.with_slope(da, q), rows.with_slope(db, q)
    return of_a * at_b - at_a * of_b, bend_a * at_b - at_a * bend_b


def _nothing_below(rest: Array, q: Array) -> Mask:
    """Return whether ``rest``, which has its double root at q taken out, has no positive root."""
    inner = (q > 0) & np.isfinite(q)
    divided = rest
    for _ in range(2):
        divided = _without(divided, q)
    divided = np.where(inner, divided, _shorter(rest, q))
    count = rows.changes(divided)
    proved: Mask = np.equal(count, 0)
    (maybe,) = np.nonzero((count > 0) & (count % 2 == 0))
    if len(maybe):
        roots, doubt = rows.positive_roots(divided[:, maybe])
        proved[maybe] = ~np.isfinite(roots).any(axis=0) & ~doubt
    return proved


def _without(a: Array, q: Array) -> Array:
    """Return a/(x - q), the remainder dropped, in as many rows as before (the last is 0).

    From the top where q is below 1, from the bottom where it is above: the other way round the
    rounding of what is large would be all there is of the small coefficients.
    """
    out, other = np.zeros_like(a), np.zeros_like(a)
    carry, carried = np.zeros(a.shape[1]), np.zeros(a.shape[1])
    part = 1 / np.where(q > 1, q, 1.0)
    for k in range(len(a) - 1, 0, -1):
        carry = a[k] + q * carry
        out[k - 1] = carry
        j = len(a) - 1 - k
        carried = (carried - a[j]) * part
        other[j] = carried
    return np.where(q > 1, other, out)


def _shorter(rest: Array, q: Array) -> Array:
    """Return ``rest`` with the coefficient that its least at an end has made 0 left out."""
    out = rest.copy()
    out[0] = np.where(q == 0, 0.0, out[0])
    out[-1] = np.where(np.isinf(q), 0.0, out[-1])
    return out


def _by_slopes(a: Array, b: Array) -> tuple[Array, Array, Mask]:
    """Return (v where a/b is least, a/b there, whether in doubt), every flat place of it tried."""
    slope = rows.times(rows.derivative(a), b) - rows.times(a, rows.derivative(b))
    size = np.max(np.abs(slope), axis=0)
    q, doubt = rows.positive_roots(slope / np.where(size > 0, size, 1.0))
    inner = np.where(np.isfinite(q), q, 1.0)
    value = np.where(np.isfinite(q), rows.at(a, inner) / rows.at(b, inner), np.inf)
    value = np.concatenate([value, [a[0] / b[0], a[-1] / b[-1]]])
    places = np.concatenate([q, np.zeros((1, a.shape[1])), np.full((1, a.shape[1]), np.inf)])
    value = np.where(np.isnan(value), np.inf, value)
    best = np.argmin(value, axis=0)[None, :]
    v, least = (np.take_along_axis(x, best, axis=0)[0] for x in (np.sqrt(places), value))
    return v, least, doubt


def _peak(loops: Loops, name: str, v: Array) -> dict[str, Array]:
    end = np.isinf(v)
    at = np.where(end, 1.0, v)
    n, d = rows.on_axis(loops.num, at)[0], rows.on_axis(loops.den, at)[0]
    n, d = np.where(end, loops.num[-1], n), np.where(end, loops.den[-1], d)
    if name == "modulus":
        least = np.abs(n + d) / np.abs(d)
        return {"modulus_margin": least, "ms": 1 / least}
    if name == "mt":
        return {"mt": np.abs(n) / np.abs(n + d)}
    return {"disk_margin": 2 * np.abs(n + d) / np.abs(d - n)}


def _bandwidth(loops: Loops, nn: Array, aa: Array) -> tuple[Array, Mask]:
    at_rest = DROP * nn[0] / aa[0]
    q, doubt = rows.positive_roots(nn - at_rest * aa)
    first = q[0] if len(q) else np.full(len(at_rest), np.inf)
    falls = np.isfinite(first) & (at_rest > 0)
    return np.where(falls, loops.frequency(np.sqrt(np.where(falls, first, 1.0))), np.nan), doubt
