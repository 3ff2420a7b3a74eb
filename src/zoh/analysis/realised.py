"""A sampled system as states that move by small steps.

With delta = z - 1 a pole near z = 1 is a small number, kept to its last digit, and a small dt
costs nothing. A pole at z = -1 is no special case.
Source: R. H. Middleton and G. C. Goodwin, Digital Control and Estimation: A Unified Approach
(the delta operator).
"""

from decimal import Decimal
from math import comb

from zoh.lti import digits
from zoh.lti.poly import Poly
from zoh.lti.systems import Sampled


def realised(system: Sampled) -> tuple[list[float], list[float], float]:
    """Return (a, c, d), the system without its delay as a chain of sums.

    x_0(k+1) = x_0(k) - a x(k) + e(k), x_i(k+1) = x_i(k) + x_{i-1}(k), u = c x + d e.

    >>> realised(Sampled(num=[0.5], den=[1, -0.5], dt=1.0))
    ([0.5], [0.5], 0.0)
    """
    with digits.precision(digits.KEPT):
        num, den = (_in_delta(a, system.dt) for a in (system.num_w, system.den_w))
        b, a = [x / den[0] for x in num], [x / den[0] for x in den]
        c = [x - b[0] * y for x, y in zip(b[1:], a[1:], strict=True)]
    return [float(x) for x in a[1:]], [float(x) for x in c], float(b[0])


def _in_delta(a_w: Poly, dt: float) -> list[Decimal]:
    """Return (dt/2)^n (2 + delta)^n a(w) in delta, descending, w = (2/dt) delta/(2 + delta)."""
    n = len(a_w) - 1
    out, half, power = [Decimal(0)] * (n + 1), Decimal(dt) / 2, Decimal(1)
    for j, c in enumerate(a_w):  # c w^(n-j) becomes c (dt/2)^j delta^(n-j) (2 + delta)^j
        if c:
            scaled = Decimal(c) * power
            for i in range(j + 1):
                out[j - i] += scaled * (comb(j, i) * 2 ** (j - i))
        power *= half
    return out
