"""Three ways to write one PID: each must be the same rational function of w."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpc, mpf

from zoh.lti.forms import forms, sentences

positive = st.floats(1e-3, 1e3)


def parallel(f, w):
    return f["kp"] + mpf(f.get("ki", 0)) / w + f.get("kd", 0) * w / (1 + w / f["filter_pole"])


def standard(f, w):
    integral = 1 / (mpf(f["ti"]) * w) if "ti" in f else 0
    return f["kp"] * (1 + integral + f["td"] * w / (1 + w * f["td"] / mpf(f["n"])))


def series(f, w):
    integral = 1 / (mpf(f["ti"]) * w) if "ti" in f else 0
    return f["k"] * (1 + integral) * (1 + f["td"] * w) / (1 + w / mpf(f["filter_pole"]))


@given(positive, st.one_of(st.just(0.0), positive), positive, positive)
def test_the_forms_are_one_controller_or_its_zeros_are_complex(kp, ki, kd, pole):
    found = forms({"kp": kp, "ki": ki, "kd": kd, "filter_pole": pole})
    with mp.workdps(50):
        room = (kp + mpf(ki) / pole) ** 2 - 4 * mpf(ki) * (kd + mpf(kp) / pole)
        assert found["series"] is not None or room < 1e-12 * kp**2
        assert (found["series"] is None) == ("series" in found["refused"])
        for w in (mpc(0, 0.01), mpc(0, 1), mpc(0.3, 70)):
            expected = parallel(found["parallel"], w)
            # the size of the terms: they may cancel
            size = abs(kp) + abs(ki / w) + abs(kd * w)
            assert abs(standard(found["standard"], w) - expected) < 1e-13 * size
            if found["series"]:
                assert abs(series(found["series"], w) - expected) < 1e-13 * size


def test_without_a_filter_to_speak_of_the_bound_is_four():
    # Ti/Td = kp^2/(ki kd) = 4.01 and 3.99; 1e9 rad/s moves the bound by 1e-9
    for kp, there in ((4.01**0.5, True), (3.99**0.5, False)):
        found = forms({"kp": kp, "ki": 1.0, "kd": 1.0, "filter_pole": 1e9})
        assert (found["series"] is not None) == there


def test_the_filter_moves_the_bound():
    # Ti/Td = 9/3 = 3, yet (3 + 1/2)^2 = 12.25 is above 4 (3/2 + 3) ... at p = 2: 4 (3 + 1.5) = 18
    assert forms({"kp": 3.0, "ki": 1.0, "kd": 3.0, "filter_pole": 2.0})["series"] is None
    # at p = 1/2: (3 + 2)^2 = 25 against 4 (3 + 6) = 36; at p = 1/10: 13^2 = 169 against 4 * 33
    assert forms({"kp": 3.0, "ki": 1.0, "kd": 3.0, "filter_pole": 0.1})["series"] is not None


def test_the_longer_time_is_the_integrals():
    found = forms({"kp": 5.0, "ki": 1.0, "kd": 1.0, "filter_pole": 10.0})["series"]
    assert found["ti"] > found["td"]


@pytest.mark.parametrize(
    ("gains", "standard", "series"),
    [
        ({"kp": 2.0}, {"kp": 2.0}, {"k": 2.0}),
        ({"kp": 2.0, "ki": 4.0}, {"kp": 2.0, "ti": 0.5}, {"k": 2.0, "ti": 0.5}),
        (
            {"kp": 2.0, "kd": 1.0, "filter_pole": 4.0},
            {"kp": 2.0, "td": 0.5, "n": 2.0},
            {"k": 2.0, "td": 0.75, "filter_pole": 4.0},  # (2 + 3/2 w)/(1 + w/4)
        ),
    ],
)
def test_smaller_laws_by_hand(gains, standard, series):
    found = forms(gains)
    assert (found["standard"], found["series"], found["refused"]) == (standard, series, {})


def test_a_law_without_kp_has_no_forms():
    assert forms({"dc_gain": 1.0, "w0": 2.0, "wp": 3.0}) == {}
    assert sentences({"dc_gain": 1.0, "w0": 2.0, "wp": 3.0}) == []
    assert forms({"kp": 0.0, "ki": 1.0}) == {}
    assert forms({"kp": 1.0, "kd": 1.0}) == {}  # somebody's gains, their filter not said


def test_a_refused_form_says_so_to_people():
    lines = sentences({"kp": 1.0, "ki": 1.0, "kd": 1.0, "filter_pole": 1e3})
    assert lines[1].startswith("series form: zeros are complex")
