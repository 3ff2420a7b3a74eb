"""The logarithm of all roots of a polynomial at once: from poles in z back to poles in s.

With p = (z-1)/(z+1), a pole z = exp(sigma) is p = tanh(sigma/2), so sigma/2 = artanh p. In the
ring modulo the poles' polynomial in p that is one power series, after as many halvings ::

    tanh(x/2) = p/(1 + sqrt(1 - p^2)),      p = tanh(x)

as make it short. The square root with positive real part is that of |Im sigma| < pi: the
principal branch, poles within the Nyquist frequency. Roots need not be simple, nor be known.
Source: N. J. Higham, Functions of Matrices, SIAM 2008, ch. 6 and 11 (Newton's square root,
inverse scaling and squaring).
"""

from collections.abc import Sequence
from decimal import Decimal, getcontext
from math import ceil, isfinite, log2

import numpy as np

from zoh.lti import poly
from zoh.lti.digits import Exact
from zoh.sampling.algebra import Element, Ring, from_power_sums, power_sums

_ONE = Decimal(1)
_SHORT = 0.125  # artanh's series is summed up to here: two terms for three digits and a half
_STEPS = 400  # of Newton's square root: enough for z = 1e-200, or for 1e-100 rad off the axis


class NoLogarithm(ArithmeticError):
    """A root has no principal logarithm: z is 0 or negative, to within the digits at hand."""


def artanh_of_roots(monic: Sequence[Decimal]) -> Exact:
    """Return the monic polynomial whose roots are artanh p for the roots p of ``monic``.

    The digits are those of the current precision. Raises NoLogarithm where a root p is real
    with |p| >= 1.

    >>> half = artanh_of_roots([Decimal(1), Decimal("0.5")])  # artanh(-1/2) = -log(3)/2
    >>> float(half[1])
    0.549306144334054...
    """
    n = len(monic) - 1
    if n == 0:
        return (_ONE,)
    size = _size(monic)
    scaled = [c / size**i for i, c in enumerate(monic)]
    ring = Ring.of(scaled)
    p = ring.times_u(ring.constant(size))
    halvings = _halvings(monic)
    for _ in range(halvings):
        p = _halved(ring, p)
    x = [c * 2**halvings for c in _artanh(ring, p)]
    power, traces, sums = ring.constant(_ONE), [], power_sums(scaled, n)
    for _ in range(n):
        power = ring.product(power, x)
        traces.append(ring.trace(power, sums))
    return from_power_sums(traces)


def _size(monic: Sequence[Decimal]) -> Decimal:
    """Return a power of 2 about as large as the largest |a_i|^(1/i): the roots' size (Fujiwara)."""
    logs = [(c.adjusted() + 1) / i for i, c in enumerate(monic) if i and c]
    return Decimal(2) ** ceil(max(logs, default=0.0) * log2(10))


def _halvings(monic: Sequence[Decimal]) -> int:
    """Return how often x must be halved; a rough figure, for speed alone."""
    p = poly.roots([float(c) for c in monic])
    with np.errstate(all="ignore"):
        largest = float(np.abs(np.arctanh(p)).max(initial=_SHORT))
    return ceil(log2(largest / _SHORT)) if isfinite(largest) else 12


def _halved(ring: Ring, p: Element) -> Element:
    """Return tanh(x/2) for p = tanh(x)."""
    square = ring.product(p, p)
    root = _square_root(ring, [a - b for a, b in zip(ring.constant(_ONE), square, strict=True)])
    root[0] += 1
    return ring.product(p, ring.inverse(root))


def _square_root(ring: Ring, a: Element) -> Element:
    """Return sqrt(a) with positive real part at every root, by Newton's iteration.

    At a negative number the iteration wanders for ever: that is how one is found.
    """
    x = ring.constant(_ONE)
    near = Decimal(10) ** (-getcontext().prec // 2)
    try:
        for _ in range(_STEPS):
            quotient = ring.product(a, ring.inverse(x))
            better = [(b + c) / 2 for b, c in zip(x, quotient, strict=True)]
            step = max(abs(b - c) for b, c in zip(x, better, strict=True))
            x = better
            if step < near * max(map(abs, x)):
                return x  # the last step squared what was left: all digits there are
    except ZeroDivisionError:
        pass
    raise NoLogarithm


def _artanh(ring: Ring, p: Element) -> Element:
    """Return p + p^3/3 + p^5/5 + ..."""
    square, power, total, k = ring.product(p, p), p, p, 1
    small = Decimal(10) ** -getcontext().prec
    while max(map(abs, power)) > small * max(map(abs, total)):
        power, k = ring.product(power, square), k + 2
        total = [a + b / k for a, b in zip(total, power, strict=True)]
    return total
