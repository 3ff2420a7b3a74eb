"""Polynomials as sets of roots that nobody seeks: power sums, and the ring modulo one of them.

Modulo a polynomial D(u) the element u stands for all roots of D at once: an analytic function
of u in that ring is that function at every root, repeated or not, and its trace is the sum over
them. Elements are lists of coefficients in ascending powers; the digits are those of the
current precision.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

from zoh.lti.digits import Exact

_ZERO, _ONE = Decimal(0), Decimal(1)

Element = list[Decimal]


def power_sums(monic: Sequence[Decimal], count: int) -> Exact:
    """Return [sum of r**j over the roots r, j = 0 ... count - 1], by Newton's identities.

    >>> [int(s) for s in power_sums([Decimal(1), Decimal(-3), Decimal(2)], 4)]  # 1 and 2
    [2, 3, 5, 9]
    """
    n = len(monic) - 1
    sums = [Decimal(n)]
    for j in range(1, count):
        total = -j * monic[j] if j <= n else _ZERO
        for i in range(1, min(j - 1, n) + 1):
            total -= monic[i] * sums[j - i]
        sums.append(total)
    return tuple(sums)


def from_power_sums(sums: Sequence[Decimal]) -> Exact:
    """Return the monic polynomial whose roots have these sums of powers 1 ... n.

    >>> [int(c) for c in from_power_sums([Decimal(3), Decimal(5)])]
    [1, -3, 2]
    """
    monic = [_ONE]
    for k in range(1, len(sums) + 1):
        total = sum((monic[k - i] * sums[i - 1] for i in range(1, k + 1)), _ZERO)
        monic.append(-total / k)
    return tuple(monic)


def solve(matrix: Sequence[Sequence[Decimal]], right: Sequence[Decimal]) -> list[Decimal]:
    """Return x with matrix x = right, by elimination with the largest pivot of each column.

    Raises ZeroDivisionError for a singular matrix.

    >>> two, one = Decimal(2), Decimal(1)
    >>> [int(x) for x in solve([[one, one], [two, one]], [Decimal(3), Decimal(4)])]
    [1, 2]
    """
    rows = [[*row, r] for row, r in zip(matrix, right, strict=True)]
    n = len(rows)
    for i in range(n):
        pivot = max(range(i, n), key=[abs(row[i]) for row in rows].__getitem__)
        rows[i], rows[pivot] = rows[pivot], rows[i]
        if not rows[i][i]:
            raise ZeroDivisionError
        for k in range(i + 1, n):
            factor = rows[k][i] / rows[i][i]
            if factor:
                rows[k] = [a - factor * b for a, b in zip(rows[k], rows[i], strict=True)]
    x = [_ZERO] * n
    for i in reversed(range(n)):
        rest = sum((rows[i][j] * x[j] for j in range(i + 1, n)), _ZERO)
        x[i] = (rows[i][n] - rest) / rows[i][i]
    return x


@dataclass(frozen=True, slots=True, kw_only=True)
class Ring:
    """The polynomials modulo a monic one of degree n, given without its leading 1, ascending."""

    modulus: Exact

    @classmethod
    def of(cls, monic: Sequence[Decimal]) -> "Ring":
        """Return the ring modulo this polynomial, descending powers."""
        return cls(modulus=tuple(monic[:0:-1]))

    def constant(self, c: Decimal) -> Element:
        """Return the number c as an element."""
        return [c] + [_ZERO] * (len(self.modulus) - 1)

    def times_u(self, a: Element) -> Element:
        """Return u a."""
        top = a[-1]
        return [s - top * m for s, m in zip([_ZERO, *a[:-1]], self.modulus, strict=True)]

    def product(self, a: Element, b: Element) -> Element:
        """Return a b.

        >>> ring = Ring.of([Decimal(1), Decimal(0), Decimal(1)])  # u = j
        >>> [int(c) for c in ring.product([Decimal(1), Decimal(1)], [Decimal(1), Decimal(1)])]
        [0, 2]
        """
        out = [c * b[-1] for c in a]
        for factor in reversed(b[:-1]):
            out = [s + c * factor for s, c in zip(self.times_u(out), a, strict=True)]
        return out

    def inverse(self, a: Element) -> Element:
        """Return 1/a; raises ZeroDivisionError where a root of the modulus is one of a."""
        columns = [a]
        for _ in self.modulus[1:]:
            columns.append(self.times_u(columns[-1]))
        return solve(list(zip(*columns, strict=True)), self.constant(_ONE))

    def trace(self, a: Element, sums: Exact) -> Decimal:
        """Return the sum of a over the roots; sums are the power sums of u from 0 on."""
        return sum((c * s for c, s in zip(a, sums, strict=True)), _ZERO)
