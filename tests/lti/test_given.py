"""given: what is no system is refused to the word, and what just is one is taken."""

from math import inf

import pytest

from zoh.errors import SpecError
from zoh.lti.given import MAX_ORDER, in_w
from zoh.lti.systems import Plant, Sampled

PAIRS = "give a list of numbers, complex ones in conjugate pairs"
IN_W = "give the coefficients as a list of real numbers in descending powers of w"
TWO = [[1, 2], [3, 4]]


def zeros(*values):
    return lambda: Plant.zpk(zeros=list(values), poles=[-1, -2], gain=1)


def num_w(value):
    return lambda: Sampled.from_w(num_w=value, den_w=[1, 1], dt=1.0)


REFUSED = [
    (
        lambda: Plant(num=[1], den=[0, 0]),
        "den must not be all zeros, got [0.0]: give at least one coefficient",
    ),
    (
        lambda: Plant(num=[0], den=[1, 1]),
        "num must not be all zeros, got [0.0]: a plant that does nothing has no loop",
    ),
    (
        lambda: Plant(num=[1, 2, 3], den=[1, 1]),
        "num must not have a higher degree in s than den (1), got 2: a proper system has "
        "deg num <= deg den",
    ),
    (
        lambda: Sampled(num=[1, 2, 3], den=[1, 1], dt=1.0),
        "num must not have a higher degree in z than den (1), got 2: a causal system has "
        "deg num <= deg den",
    ),
    (
        lambda: Plant(num=[1], den=[1] * 52),
        "den must have order 50 or less, got 51: reduce the model first",
    ),
    (zeros(1j), "zeros must come in conjugate pairs, got 1j: add -1j"),
    (zeros(1 + 1j, 1 + 1j, 1 - 1j), "zeros must come in conjugate pairs, got (1+1j): add (1-1j)"),
    (zeros(-1, "a"), f"zeros[1] must be a number, got 'a': {PAIRS}"),
    (zeros(True), f"zeros[0] must be a number, got True: {PAIRS}"),
    (zeros(10**400), f"zeros[0] must fit a 64-bit float, got 1{'0' * 56}...: {PAIRS}"),
    (zeros(inf), f"zeros[0] must be finite, got inf: {PAIRS}"),
    (
        lambda: Plant.ss([[1, 2]], [1], [1], 0),
        "A must be square, got [1, 2]: give n rows of n numbers",
    ),
    (
        lambda: Plant.ss([[[1]]], [1], [1], 0),
        "A must be square, got [1, 1, 1]: give n rows of n numbers",
    ),
    (
        lambda: Plant.ss([[0.0] * 51] * 51, [1] * 51, [1] * 51, 0),
        "A must have 50 rows or less, got 51: reduce the model first",
    ),
    (
        lambda: Plant.ss(TWO, [1], [1, 2], 0),
        "B must have 2 entries (one input, one output), got 1: SISO only",
    ),
    (
        lambda: Plant.ss(TWO, [1, 1], [1], 0),
        "C must have 2 entries (one input, one output), got 1: SISO only",
    ),
    (
        lambda: Plant.ss(TWO, [1, 1], [1, 1], [0, 0]),
        "D must have 1 entries (one input, one output), got 2: SISO only",
    ),
    *(
        (
            lambda arrays=[*[[[1]]] * i, "x", *[[[1]]] * (3 - i)]: Plant.ss(*arrays),
            f"{name} must be a matrix of numbers, got 'x': a list of rows",
        )
        for i, name in enumerate("ABCD")
    ),
    (num_w([]), f"num_w must have at least one coefficient, got []: {IN_W}"),
    (num_w([1, "x"]), f"num_w[1] must be a real number, got 'x': {IN_W}"),
    (num_w(3), f"num_w must be a list of numbers, got 3: {IN_W}"),
    (num_w((1.0, inf)), f"num_w[1] must be finite, got inf: {IN_W}"),
    (num_w(()), f"num_w must have at least one coefficient, got (): {IN_W}"),
]


@pytest.mark.parametrize(("make", "words"), REFUSED)
def test_what_is_no_system_is_refused_to_the_word(make, words):
    with pytest.raises(SpecError) as refused:
        make()
    assert str(refused.value) == words


def test_fifty_is_the_highest_order():
    assert MAX_ORDER == 50
    assert len(Plant(num=[1], den=[1] * 51).den) == 51


def test_fifty_are_the_most_rows():
    matrix = [[-1.0 * (i == j) for j in range(50)] for i in range(50)]
    assert Plant.ss(matrix, [1, *[0] * 49], [1, *[0] * 49], 0).at(0.0) == pytest.approx(
        1, rel=1e-14
    )


def test_coefficients_in_w_are_floats_whatever_was_given():
    made = (1.0, 0.0, 2.0)
    assert in_w("num_w", made) is made
    for value in ([1, 0, 2], (1, 0.0, 2), [1.0, 0.0, 2.0]):
        found = in_w("num_w", value)
        assert found == made
        assert [type(c) for c in found] == [float] * 3
