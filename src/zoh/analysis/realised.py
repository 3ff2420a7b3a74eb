"""A sampled system as states that move by small steps.

With delta = z - 1 a pole near z = 1 is a small number, kept to its last digit, and a small dt
costs nothing. A pole at z = -1 is no special case.
Source: R. H. Middleton and G. C. Goodwin, Digital Control and Estimation: A Unified Approach
(the delta operator).
"""

from collections.abc import Sequence
from functools import lru_cache
from math import comb
from operator import mul

from zoh.lti.systems import Sampled


def realised(system: Sampled) -> tuple[list[float], list[float], float]:
    """Return (a, c, d), the system without its delay as a chain of sums.

    x_0(k+1) = x_0(k) - a x(k) + e(k), x_i(k+1) = x_i(k) + x_{i-1}(k), u = c x + d e.

    >>> realised(Sampled(num=[0.5], den=[1, -0.5], dt=1.0))
    ([0.5], [0.5], 0.0)
    """
    *wholes, _ = system.whole_w  # what they have in common cancels
    half = (system.dt / 2).as_integer_ratio()
    num, den = (_in_delta(a, half) for a in wholes)
    for i in range(len(den) - len(system.num)):
        num[i] = 0  # what z says is nothing is not the rounding of w
    first, lead = num[0], den[0]
    # a quotient of whole numbers is rounded once
    a = [x / lead for x in den[1:]]
    c = [(x * lead - first * y) / (lead * lead) for x, y in zip(num[1:], den[1:], strict=True)]
    return a, c, first / lead


def _in_delta(a_w: Sequence[int], half: tuple[int, int]) -> list[int]:
    """Return h^n (2 + delta)^n a(w) in delta, descending, w = delta/(h (2 + delta)), h = dt/2.

    Times the denominator of h to the n, so that all is whole and nothing is rounded.
    """
    n, (p, q) = len(a_w) - 1, half
    scaled = [c * p**j * q ** (n - j) for j, c in enumerate(a_w)]
    return [sum(map(mul, row, scaled)) for row in _weights(n)]


@lru_cache(maxsize=64)
def _weights(n: int) -> tuple[tuple[int, ...], ...]:
    """Return, by the power that comes out, what delta^(n-j) (2 + delta)^j, j = 0 ... n, has of it.

    >>> _weights(1)  # delta, and 2 + delta
    ((1, 1), (0, 2))
    """
    return tuple(
        tuple(comb(j, k) << k if k <= j else 0 for j in range(n + 1)) for k in range(n + 1)
    )
