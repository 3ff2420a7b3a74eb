"""All margins of many loops at once; the single measure in ``zoh.analysis`` says what each is.

A loop is num(u)/den(u) with u = w/v, v the frequency that the law was solved at: its crossover is
at u = j, where floats hold the most. Crossings are the sign changes of polynomials in q = (v/vc)^2,
polished on the complex response itself; ``peaks`` finds where a sensitivity is highest.
"""

from dataclasses import dataclass

import numpy as np

from zoh.batch.arrays import peaks, rows
from zoh.batch.arrays.roots import positive_roots
from zoh.batch.arrays.rows import Array, Index, Mask
from zoh.batch.tolerances import DROP, ON_IT_DEG, PIVOT, UNITY

_POLISH = 3


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
    c, bulk = (loops.num + loops.den)[::-1], (np.abs(loops.num) + np.abs(loops.den))[::-1]
    ends = np.abs(c[[0, -1]]) <= PIVOT * bulk[[0, -1]]  # a pole at z = -1, or 1, but for rounding
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
    return good, doubt | ends.any(axis=0) | ~np.isfinite(c).all(axis=0)


def measured(loops: Loops) -> tuple[dict[str, Array], Mask]:
    """Return (every margin by name, which loops had better be measured one by one)."""
    n, d = loops.num, loops.den
    nn, dd, aa = rows.squared(n), rows.squared(d), rows.squared(n + d)
    with np.errstate(all="ignore"):
        found, doubt = _by_gain(loops, nn - dd)
        more, unsure = _by_phase(loops)
        found |= more
        doubt |= unsure
        v, unsures = peaks.lowest(aa, [dd, nn, rows.squared(d - n)])
        doubt |= unsures.any(axis=0)
        found |= _peaks(loops, v)
        found["bandwidth"], unsure = _bandwidth(loops, nn, aa)
    return found, doubt | unsure


def _by_gain(loops: Loops, gain: Array) -> tuple[dict[str, Array], Mask]:
    q, doubt = positive_roots(gain)
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
    q, doubt = positive_roots(turn)
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


def _peaks(loops: Loops, v: Array) -> dict[str, Array]:
    """Return what is highest or lowest at v, a row for each of |1/S|, |1/T|, |(1 + L)/(1 - L)|."""
    end = np.isinf(v)
    at = np.where(end, 1.0, v)
    n, d = rows.on_axis(loops.num, at)[0], rows.on_axis(loops.den, at)[0]
    n, d = np.where(end, loops.num[-1], n), np.where(end, loops.den[-1], d)
    modulus, of_t, disk = np.abs(n + d) / np.abs([d[0], n[1], d[2] - n[2]])
    return {"modulus_margin": modulus, "ms": 1 / modulus, "mt": 1 / of_t, "disk_margin": 2 * disk}


def _bandwidth(loops: Loops, nn: Array, aa: Array) -> tuple[Array, Mask]:
    at_rest = DROP * nn[0] / aa[0]
    above = nn - at_rest * aa
    q, doubt = positive_roots(above)
    first = q[0] if len(q) else np.full(len(at_rest), np.inf)
    falls = np.isfinite(first) & (at_rest > 0)
    first = np.where(falls, first, 1.0)
    value, slope = rows.with_slope(above, first)
    return np.where(falls, loops.frequency(np.sqrt(first - value / slope)), np.nan), doubt
