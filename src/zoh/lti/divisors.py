"""What polynomials in whole numbers share, with each other or with their derivative, exactly.

Coefficients are in descending powers.
"""

from math import gcd

from zoh.lti.whole import Whole, derivative, divided, times

_PRIME = (1 << 61) - 1  # a Mersenne prime, and so a divisor of hardly any lead


def common(a: Whole, b: Whole) -> list[int]:
    """Return the greatest common divisor, its coefficients without a common factor.

    >>> common((2, 2), (1, 0, -1))
    [1, 1]
    """
    one, other = _led(a), _led(b)
    if len(one) < len(other):
        one, other = other, one
    while other:
        one, other = other, _remainder(one, other)
    one = _reduced(one)
    return one if one[0] > 0 else [-c for c in one]


def share_nothing(a: Whole, b: Whole) -> bool:
    """Return whether no root is common to both, where a look modulo a prime can tell.

    What is common to both is so modulo a prime, too, unless that divides both leads.

    >>> share_nothing((1, 2), (1, 0, -1)), share_nothing((1, 1), (1, 0, -1))
    (True, False)
    """
    one, other = ([c % _PRIME for c in _led(x)] for x in (a, b))
    if not (one and other and (one[0] or other[0])):
        return False
    while other := _led(other):
        inverse = pow(other[0], -1, _PRIME)
        while len(one) >= len(other):
            factor = one[0] * inverse
            for i, c in enumerate(other):
                one[i] = (one[i] - factor * c) % _PRIME
            del one[0]
        one, other = other, one
    return len(one) == 1


def repeated(a: Whole) -> list[int]:
    """Return the greatest common divisor of a and its derivative, up to a factor.

    >>> repeated((1, -4, 5, -2))  # (x - 1)^2 (x - 2)
    [1, -1]
    """
    return common(a, derivative(a))


def each_once(a: Whole) -> Whole:
    """Return the polynomial that has every root of a once.

    >>> each_once((1, -4, 5, -2))  # (x - 1)^2 (x - 2)
    [1, -3, 2]
    """
    return a if share_nothing(a, derivative(a)) else divided(a, repeated(a))


def odd_once(a: Whole) -> Whole:
    """Return the polynomial that has once those roots that a has an odd number of times.

    >>> odd_once((1, -4, 5, -2))
    [1, -2]
    """
    if len(a) < 2 or share_nothing(a, derivative(a)):
        return a
    twice = repeated(a)  # a root is there one time less
    more = repeated(twice)
    alone = divided(divided(a, twice), divided(twice, more))
    return times(alone, odd_once(more))


def _led(a: Whole) -> list[int]:
    """Return the coefficients from the first that is not 0 on."""
    first = next((i for i, c in enumerate(a) if c), len(a))
    return list(a[first:])


def _remainder(a: Whole, b: Whole) -> list[int]:
    """Return a mod b times a whole number, its coefficients without a common factor."""
    rest, lead = list(a), b[0]
    while len(rest) >= len(b):
        factor = rest[0]
        for i in range(len(rest)):
            rest[i] = lead * rest[i] - (factor * b[i] if i < len(b) else 0)
        del rest[0]
    return _reduced(_led(rest))


def _reduced(a: list[int]) -> list[int]:
    unit = gcd(*a)
    return [c // unit for c in a] if unit > 1 else a
