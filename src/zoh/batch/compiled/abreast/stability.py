"""Whether loops side by side are stable; see ``zoh.batch.compiled.stability``."""

from math import inf

from zoh.batch.compiled import work
from zoh.batch.compiled.abreast.room import LOOPS
from zoh.batch.compiled.jit import compiled
from zoh.batch.tolerances import PIVOT

GOOD, DOUBT = range(2)  # rows of what is said, 1.0 or 0.0


@compiled
def stable(w: int, n: int) -> None:
    """Write whether each loop, of degree 3 or 4, is stable, and whether rounding decided it."""
    r = work.abreast(w)
    num, den = r.num, r.den
    for i in range(LOOPS):
        e, d = num[0, i] + den[0, i], num[1, i] + den[1, i]
        c, b = num[2, i] + den[2, i], num[3, i] + den[3, i]
        good, a = 1, b
        doubt = little(e, abs(num[0, i]), abs(den[0, i]))  # a pole at z = 1, but for rounding
        doubt |= little(num[n, i] + den[n, i], abs(num[n, i]), abs(den[n, i]))  # or at z = -1
        if n == 4:  # one step of the scheme leaves a cubic
            a = num[n, i] + den[n, i]
            minus = a / b * d
            good &= same_sign(a, b)
            doubt |= little(b, abs(b), abs(d)) | little(c - minus, abs(c) + abs(minus), 0.0)
            a, b, c, d = b, c - minus, d, e
        else:
            a, b, c, d = b, c, d, e
        minus = a / b * d
        last = c - minus
        good &= same_sign(a, b) & same_sign(a, last) & same_sign(a, d)
        doubt |= little(b, abs(b), abs(d)) | little(last, abs(c) + abs(minus), 0.0)
        doubt |= little(d, abs(d), abs(b / last * c))
        doubt |= 1 - int(abs(a) + abs(b) + abs(c) + abs(d) + abs(last) < inf)
        r.said[GOOD, i], r.said[DOUBT, i] = float(good), float(doubt)


@compiled
def same_sign(a: float, b: float) -> int:
    """Return 1 where both have one sign, and are not 0."""
    return (int(a > 0.0) & int(b > 0.0)) | (int(a < 0.0) & int(b < 0.0))


@compiled
def little(pivot: float, one: float, other: float) -> int:
    """Return 1 where rounding may have made the sign of a pivot of terms of such sizes."""
    return int(abs(pivot) <= PIVOT * (one if one > other else other))
