"""Polynomials with as many digits as an answer needs.

Coefficients are ``decimal.Decimal`` in descending powers, so a result that is a small
difference of large numbers costs digits, which are cheap, instead of truth. A float enters
exactly and leaves correctly rounded.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal, localcontext
from typing import TYPE_CHECKING, TypeVar

from zoh import checks
from zoh.errors import SpecError

if TYPE_CHECKING:
    from fractions import Fraction

Exact = tuple[Decimal, ...]

Number = TypeVar("Number", int, Decimal)

KEPT = 120  # digits kept of a coefficient that is not a float, such as a product of poles
_ZERO = Decimal(0)


@contextmanager
def precision(digits: int) -> Iterator[None]:
    """Work with this many digits, and with exponents that neither overflow nor underflow."""
    context = Context(prec=digits, Emax=MAX_EMAX, Emin=MIN_EMIN)
    with localcontext(context):
        yield


def exact(values: "Sequence[float | Fraction]") -> Exact:
    """Return floats as they are, fractions to ``KEPT`` digits.

    >>> from fractions import Fraction
    >>> exact([0.5, Fraction(1, 4)])
    (Decimal('0.5'), Decimal('0.25'))
    """
    floats = [v for v in values if isinstance(v, float)]
    if len(floats) == len(values):
        return tuple(map(Decimal, floats))  # exact, whatever the precision
    with precision(KEPT):
        return tuple(
            Decimal(v)
            if isinstance(v, float | int)
            else Decimal(v.numerator) / Decimal(v.denominator)
            for v in values
        )


def checked(name: str, a: Exact) -> Exact:
    """Return exact coefficients as a tuple; raise SpecError unless they are finite Decimals."""
    way_out = "give the coefficients as a list of Decimals in descending powers"
    items = checks.sequence(name, a, way_out)
    for i, c in enumerate(items):
        if not isinstance(c, Decimal) or not c.is_finite():
            raise SpecError(f"{name}[{i}]", "must be a finite Decimal", c, way_out)
    if not items:
        raise SpecError(name, "must have at least one coefficient", a, way_out)
    return tuple(items)


def rounded(a: Sequence[Decimal]) -> tuple[float, ...]:
    """Return the nearest floats."""
    return tuple(float(c) for c in a)


def times(a: Sequence[Number], b: Sequence[Number]) -> tuple[Number, ...]:
    """Return the product a b, of decimals in the current precision, of whole numbers exactly."""
    out = [a[0] * 0] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        if x:
            for j, y in enumerate(b):
                out[i + j] += x * y
    return tuple(out)


def plus(a: Sequence[Decimal], b: Sequence[Decimal]) -> Exact:
    """Return a + b in the current precision."""
    n = max(len(a), len(b))
    a, b = (_ZERO,) * (n - len(a)) + tuple(a), (_ZERO,) * (n - len(b)) + tuple(b)
    return tuple(x + y for x, y in zip(a, b, strict=True))


def span(values: Sequence[Decimal]) -> int:
    """Return how many digits span the values from the largest to the last digit of the least."""
    exponents = [(c.adjusted(), c.as_tuple().exponent) for c in values if c]
    if not exponents:
        return 1
    low = min(e for _, e in exponents if isinstance(e, int))
    return min(max(top for top, _ in exponents) - low + 1, 1200)


def from_roots(roots: Sequence[complex]) -> Exact:
    """Return the monic polynomial with these roots, complex ones given as exact conjugates.

    A pair a +- j b enters as s^2 - 2 a s + a^2 + b^2, so the product is real without rounding
    an imaginary part away.

    >>> rounded(from_roots([-1.0, -0.5 + 2j, -0.5 - 2j]))
    (1.0, 2.0, 5.25, 4.25)
    """
    shift = common_shift([x for r in roots for x in (complex(r).real, complex(r).imag)])
    return over_powers(monic(roots, shift), shift)


def over_powers(values: Sequence[int], shift: int, first: int = 0) -> Exact:
    """Return values[k] 2**-(first + shift k), to ``KEPT`` digits.

    >>> over_powers([1, 3, 5], 1)
    (Decimal('1'), Decimal('1.5'), Decimal('1.25'))
    """
    with precision(KEPT):
        return tuple(Decimal(c) / (1 << first + shift * k) for k, c in enumerate(values))


def monic(roots: Sequence[complex], shift: int) -> tuple[int, ...]:
    """Return the monic polynomial of the roots times 2**shift, which makes them whole.

    >>> monic([0.5, 1j, -1j], 1)
    (1, -1, 4, -4)
    """
    product: tuple[int, ...] = (1,)
    for r in map(complex, roots):
        re, im = scaled(r.real, shift), scaled(r.imag, shift)
        if im > 0:
            product = times(product, [1, -2 * re, re * re + im * im])
        elif not im:
            product = times(product, [1, -re])
    return product


def state_space(
    a: Sequence[Sequence[float]], b: Sequence[float], c: Sequence[float], d: float
) -> tuple[Exact, Exact]:
    """Return (num, den) of d + c (sI - A)^-1 b, exactly; shared factors stay in both.

    Faddeev and LeVerrier's recursion in whole numbers, where its divisions come out even:
    M_1 = I, c_k = -tr(A M_k)/k, M_{k+1} = A M_k + c_k I.
    Source: F. R. Gantmacher, The Theory of Matrices, vol. 1, ch. IV, sec. 5.

    >>> num, den = state_space([[0.0, 1.0], [-2.0, -3.0]], [0.0, 1.0], [1.0, 0.0], 0.0)
    >>> rounded(num), rounded(den)
    ((0.0, 0.0, 1.0), (1.0, 3.0, 2.0))
    """
    n = len(a)
    shift = common_shift([x for row in a for x in row])
    whole = [[scaled(x, shift) for x in row] for row in a]
    shift_bc = common_shift([*b, *c])
    col, row = [scaled(x, shift_bc) for x in b], [scaled(x, shift_bc) for x in c]
    m = [[int(i == j) for j in range(n)] for i in range(n)]
    g = max(2 * shift_bc, common_shift([d]))
    direct = scaled(d, g)
    num, den = [direct], [1]
    for k in range(1, n + 1):
        markov = sum(row[i] * sum(m[i][j] * col[j] for j in range(n)) for i in range(n))
        m = [[sum(whole[i][h] * m[h][j] for h in range(n)) for j in range(n)] for i in range(n)]
        coefficient = -sum(m[i][i] for i in range(n)) // k
        num.append(direct * coefficient + (markov << shift + g - 2 * shift_bc))
        den.append(coefficient)
        for i in range(n):
            m[i][i] += coefficient
    return over_powers(num, shift, g), over_powers(den, shift)


def common_shift(values: Sequence[float]) -> int:
    """Return s, 0 or more, so that every value times 2**s is whole.

    >>> common_shift([0.5, 3.0, 0.375])
    3
    """
    return max((float(x).as_integer_ratio()[1].bit_length() - 1 for x in values), default=0)


def scaled(x: float, shift: int) -> int:
    """Return x 2**shift as a whole number; shift comes from ``common_shift``.

    >>> scaled(0.375, 3)
    3
    """
    top, bottom = float(x).as_integer_ratio()
    return (top << shift) // bottom
