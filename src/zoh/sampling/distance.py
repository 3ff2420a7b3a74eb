"""How far apart two sampled systems are, in the digits that matter.

A coefficient's error is measured against the size that the roots give it, which is read off
Newton's polygon: the least concave line above the logarithms of all coefficients. A middle
coefficient that cancels is then not asked for digits it cannot have, while small coefficients
of slow or fast roots are asked for all of theirs.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import inf, log2

from zoh.lti import poly
from zoh.lti.systems import Sampled

_NOTHING = 2.0**-48  # of the largest: beside a zero by structure, rounding is allowed


def distance(one: Sampled, other: Sampled) -> float:
    """Return the largest error of a coefficient of ``other`` in z or w, over its size.

    Both have the same dt and no delay of their own. Systems of different order are infinitely
    far apart.

    >>> g = Sampled(num=[1], den=[1, -0.5], dt=1.0)
    >>> distance(g, Sampled(num=[2], den=[2, -1], dt=1.0))
    0.0
    >>> distance(g, Sampled(num=[1.25], den=[1, -0.5], dt=1.0))
    0.25
    """
    if len(one.den) != len(other.den):
        return inf
    in_z = _of_forms((one.num, one.den), (other.num, other.den))
    return max(in_z, _of_forms((one.num_w, one.den_w), (other.num_w, other.den_w)))


def _of_forms(one: tuple[poly.Poly, poly.Poly], other: tuple[poly.Poly, poly.Poly]) -> float:
    """Return the distance of two fractions, whatever factor each has above and below."""
    n = len(one[1])
    ones, others = ([poly.padded(a, n) for a in form] for form in (one, other))
    sizes = [newton_sizes(a) for a in ones]
    shared = max(range(n), key=lambda i: abs(ones[1][i]) / sizes[1][i] if sizes[1][i] else -1.0)
    if not others[1][shared]:
        return inf
    factor = ones[1][shared] / others[1][shared]
    worst = 0.0
    for a, b, size in zip(ones, others, sizes, strict=True):
        largest = max(map(abs, a))
        for x, y, s in zip(a, b, size, strict=True):
            gap = abs(x - y * factor)
            if s:
                worst = max(worst, gap / s)
            elif gap > _NOTHING * largest:
                worst = inf
    return worst


def newton_sizes(a: Sequence[float]) -> list[float]:
    """Return the size each coefficient has on Newton's polygon; 0 outside the nonzero ones.

    >>> newton_sizes([0.0, 1.0, 0.0, 4.0])
    [0.0, 1.0, 2.0, 4.0]
    """
    points = [(i, log2(abs(c))) for i, c in enumerate(a) if c]
    hull: list[tuple[int, float]] = []
    for point in points:
        while len(hull) > 1 and _below(hull[-2], hull[-1], point):
            hull.pop()
        hull.append(point)
    sizes = [0.0] * len(a)
    for (i, x), (j, y) in pairwise(hull[:1] + hull):
        for k in range(i, j + 1):
            sizes[k] = 2.0 ** (x + (y - x) * (k - i) / max(j - i, 1))
    return sizes


def _below(left: tuple[int, float], middle: tuple[int, float], right: tuple[int, float]) -> bool:
    """Return whether the middle point lies on or below the line between the other two."""
    (i, x), (j, y), (k, z) = left, middle, right
    return (y - x) * (k - i) <= (z - x) * (j - i)
