"""record: labels are checked, and what is one loop is told from what is another."""

from math import cos, radians, sin

import pytest

from zoh.analysis.record import crosses, labels, or_no
from zoh.errors import SpecError


@pytest.mark.parametrize(
    ("law", "gains", "name", "sentence"),
    [
        ("p", 3, None, 'gains must name each gain, got 3: such as {"kp": 2.0}'),
        ("p", {1: 2.0}, None, "gains must be a text, got 1: put it in quotes"),
        (5, None, None, "law must be a text, got 5: put it in quotes"),
        ("p", None, 5, "name must be a text, got 5: put it in quotes"),
    ],
)
def test_refusals_in_words(law, gains, name, sentence):
    with pytest.raises(SpecError) as err:
        labels(law, gains, name)
    assert str(err.value) == sentence


def test_a_gain_that_is_no_number_is_named():
    with pytest.raises(SpecError, match=r"^gains\['kp'\] must be"):
        labels("p", {"kp": "2"}, None)


@pytest.mark.parametrize(
    ("gains", "name", "wanted"),
    [
        (None, None, {"law": "p", "gains": {}, "name": "p"}),
        ({"kp": 2}, "mine", {"law": "p", "gains": {"kp": 2.0}, "name": "mine"}),
        ({}, "", {"law": "p", "gains": {}, "name": "p"}),
    ],
)
def test_labels_as_they_are_kept(gains, name, wanted):
    found = labels("p", gains, name)
    assert found | {"gains": dict(found["gains"])} == wanted


def test_or_no():
    assert (or_no(1.23456789), or_no(0.0), or_no(None)) == ("1.23457", "0", "no")


def test_a_loop_crosses_where_its_gain_says():
    angle = radians(40.0)  # at -140 deg
    gains = {1.0: complex(-cos(angle), -sin(angle)), 3.0: -1j}
    assert crosses(gains.__getitem__, [])
    assert crosses(gains.__getitem__, [(1.0, 40.0), (3.0, 90.0)])
    for off in (-1e-4, 1e-4):  # deg; a millionth is 6e-5 deg
        assert not crosses(gains.__getitem__, [(1.0, 40.0), (3.0, 90.0 + off)])
        assert crosses(gains.__getitem__, [(1.0, 40.0 + off / 2), (3.0, 90.0)])
