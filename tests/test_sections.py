"""Sections in series with a law: at their frequency at any sample time, and the whole exact."""

from cmath import exp
from math import pi, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zoh
from zoh.app.project import read
from zoh.design.sections import in_series

FLEXIBLE = zoh.Plant.parse("40/(s*(s + 1)*(s^2 + 0.4 s + 40))")
WOBBLE = zoh.notch(w0=6.3, depth=0.1, width=0.8)


def in_z(system, wc):
    z = np.exp(1j * wc * system.dt)
    return np.polyval(system.num, z) / np.polyval(system.den, z)


@given(st.floats(0.05, 0.9), st.floats(0.01, 0.9), st.floats(0.1, 3), st.floats(1e-3, 10))
def test_a_notch_has_its_depth_at_its_frequency_and_none_at_the_ends(share, depth, width, dt):
    w0 = share * pi / dt
    s = zoh.notch(w0=w0, depth=depth, width=width).at_clock(dt)
    assert s.at(w0) == pytest.approx(depth, rel=1e-12)
    assert s.at(0.0) == pytest.approx(1, rel=1e-14)
    assert abs(s.at(pi / dt)) == pytest.approx(1, rel=1e-12)
    # 1e-9: z-coefficients near z = 1 lose digits to the frequency's square, 0.16^2
    assert in_z(s, w0) == pytest.approx(depth, rel=1e-9)


def test_a_silent_notch_has_its_zeros_on_the_circle():
    s = zoh.notch(w0=2.0, depth=0.0).at_clock(0.25)
    assert np.roots(s.num) == pytest.approx([exp(0.5j), exp(-0.5j)], abs=1e-14)


def test_pairs_over_pairs_by_hand():
    # at wc = 2 and dt small, S is the continuous (9/4)(4 - 4 + 2 0.1 2 2 j)/(9 - 4 + 2 0.5 3 2 j)
    s = zoh.SecondOrder(zeros_w0=2.0, zeros_zeta=0.1, poles_w0=3.0, poles_zeta=0.5).at_clock(1e-5)
    # 1e-9: warping at wc dt = 2e-5
    assert s.at(2.0) == pytest.approx(9 / 4 * 0.8j / (5 + 6j), rel=1e-9)
    assert s.at(0.0) == pytest.approx(1, rel=1e-14)


@pytest.mark.parametrize(
    ("law", "more"),
    [("pd", {}), ("pid", {"ki": 0.05}), ("pid", {"ti_td": 20.0}), ("pid", {"largest_ki_ms": 2.0}),
     ("lead", {"dc_gain": 0.4}), ("leadlag", {"dc_gain": 3.0})],
)  # fmt: skip
def test_every_law_is_exact_beside_sections(law, more):
    asked = {"wc": 0.9, "pm_deg": 50} | more
    d = zoh.design(FLEXIBLE, law, asked, dt=0.05, sections=[WOBBLE])
    loop = in_z(d.controller, 0.9) * in_z(d.sampled, 0.9)
    assert abs(loop + exp(1j * radians(50))) < 1e-9  # z-coefficients at wc dt = 0.045
    assert d.margins.stable
    assert d.margins.phase_margin_deg == pytest.approx(50, abs=1e-9)
    assert d.margins.crossover == pytest.approx(0.9, rel=1e-9)
    # the controller has the notch in it, whole
    gap = [in_z(d.controller, w) / in_z(WOBBLE.at_clock(0.05), w) for w in (6.2, 6.3, 6.4)]
    assert abs(gap[1]) == pytest.approx((abs(gap[0]) + abs(gap[2])) / 2, rel=1e-3)  # smooth


def test_a_section_saves_a_loop():
    with pytest.raises(zoh.NotMet, match="the closed loop is unstable"):
        zoh.pd(FLEXIBLE, dt=0.05, wc=2.0, pm_deg=50)
    assert zoh.pd(FLEXIBLE, dt=0.05, wc=2.0, pm_deg=50, sections=[WOBBLE]).margins.ms < 1.8


def test_two_sections_are_their_product():
    other = zoh.notch(w0=20.0)
    both = in_series([WOBBLE, other], 0.05)
    assert both.at(5.0) == pytest.approx(
        WOBBLE.at_clock(0.05).at(5.0) * other.at_clock(0.05).at(5.0), rel=1e-13
    )
    assert in_series([], 0.05) is None


def test_sections_on_a_table():
    w = np.geomspace(0.1, 50, 400)
    table = zoh.FrequencyResponse.from_complex(w=w, gain=zoh.sample(FLEXIBLE, 0.05).at(w), dt=0.05)
    d = zoh.pd(table, dt=0.05, wc=0.9, pm_deg=50, sections=[WOBBLE])
    assert d.margins.phase_margin_deg == pytest.approx(50, abs=1e-9)


PAIR = {"zeros_w0": 2.0, "zeros_zeta": 0.25, "poles_w0": 4.0, "poles_zeta": 0.75}
NYQUIST = "must be below the Nyquist frequency pi/dt = 62.8319 rad/s"


def pair(**changed):
    return zoh.SecondOrder(**(PAIR | changed))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: zoh.notch(w0=0.0),
            "w0 must be above 0, got 0.0: give the frequency to be silenced in rad/s",
        ),
        (
            lambda: zoh.notch(w0=1.0, depth=1.0),
            "depth must be below 1, got 1.0: a notch takes away",
        ),
        (
            lambda: zoh.notch(w0=1.0, depth=-0.1),
            "depth must be 0 or more, got -0.1: give the gain at w0",
        ),
        (
            lambda: zoh.notch(w0=1.0, width=0.0),
            "width must be above 0, got 0.0: give the width as a share of w0",
        ),
        (
            lambda: zoh.notch(w0=70.0).at_clock(0.05),
            f"w0 {NYQUIST}, got 70.0: lower it, or sample faster",
        ),
        (
            lambda: pair(zeros_w0=70.0).at_clock(0.05),
            f"zeros_w0 {NYQUIST}, got 70.0: lower it, or sample faster",
        ),
        (
            lambda: pair(poles_w0=80.0).at_clock(0.05),
            f"poles_w0 {NYQUIST}, got 80.0: lower it, or sample faster",
        ),
        (
            lambda: pair(zeros_zeta=-1.0),
            "zeros_zeta must be 0 or more, got -1.0: give zero or more",
        ),
        (
            lambda: pair(poles_zeta=0.0),
            "poles_zeta must be above 0, got 0.0: give a number above zero",
        ),
        (lambda: pair(poles_w0=0.0), "poles_w0 must be above 0, got 0.0: give a number above zero"),
        (
            lambda: in_series([WOBBLE, 1.0], 0.05),
            "sections[1] must be a section, got 1.0: zoh.notch(w0=...) or zoh.SecondOrder(...)",
        ),
        (
            lambda: in_series(7, 0.05),
            "sections must be a list of sections, got 7: put it in brackets: [zoh.notch(w0=...)]",
        ),
    ],
)
def test_a_malformed_section_is_refused_to_the_word(make, words):
    with pytest.raises(zoh.SpecError) as refused:
        make()
    assert str(refused.value) == words


def test_the_frequency_must_be_below_nyquists_and_not_at_it():
    dt = 2.0**-4
    with pytest.raises(zoh.SpecError, match="must be below the Nyquist"):
        zoh.notch(w0=16 * pi).at_clock(dt)
    assert zoh.notch(w0=15.99 * pi).at_clock(dt).at(0.0) == pytest.approx(1, rel=1e-12)


def test_the_continuous_section_by_hand():
    """4 (s^2 + s + 4)/(s^2 + 6 s + 16), 1 at 0."""
    plant = pair().in_s()
    assert (plant.num, plant.den) == ((4.0, 4.0, 16.0), (1.0, 6.0, 16.0))


def test_a_notch_is_a_tenth_deep_and_as_wide_as_its_frequency_unless_asked():
    plain = zoh.notch(w0=3.0)
    assert plain == zoh.SecondOrder(zeros_w0=3.0, zeros_zeta=0.05, poles_w0=3.0, poles_zeta=0.5)


FILE = """
plant.model = "40/(s*(s + 1)*(s^2 + 0.4 s + 40))"
sampling.dt = 0.05
[[controller]]
law = "pid"
wc = 0.9
pm_deg = 50
ti_td = 20
filter_pole = 30
"""


def test_a_project_file_has_sections_and_every_option():
    text = FILE + "sections = [{w0 = 6.3, width = 0.8}, {zeros_w0 = 2, zeros_zeta = 0.1, "
    request = read(text + "poles_w0 = 3, poles_zeta = 1}]").controllers[0]
    assert request.parameters == {"wc": 0.9, "pm_deg": 50, "ti_td": 20, "filter_pole": 30}
    pair = zoh.SecondOrder(zeros_w0=2, zeros_zeta=0.1, poles_w0=3, poles_zeta=1)
    assert request.sections == (WOBBLE, pair)


@pytest.mark.parametrize(
    ("sections", "words"),
    [
        ("3", "must be a list of tables"),
        ("[{depth = 0.1}]", r"sections\[0\]\.w0 must be given"),
        ("[{w0 = 1, q = 2}]", r"sections\[0\]\.q"),
        ("[{w0 = 80}]", r"sections\[0\]\.w0 must be below the Nyquist"),
    ],
)
def test_a_malformed_section_of_a_file_has_the_name_of_its_key(sections, words):
    with pytest.raises(zoh.SpecError, match=words):
        read(FILE + f"sections = {sections}")


def test_one_section_without_brackets_is_named():
    with pytest.raises(zoh.SpecError, match="sections must be a list of sections"):
        zoh.pi(zoh.Plant(num=[1], den=[1, 1]), dt=0.1, wc=1, pm_deg=60, sections=zoh.notch(w0=9))
