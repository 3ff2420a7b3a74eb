"""A zero at w = 0 hides a pole there: what a table shows of it, and says.

The truth is the closed loop's polynomial num_c num_p + den_c den_p in whole fractions: where it is
0 at z = 1 it has a pole there, whatever the Nyquist curve, from which that pole has cancelled.
"""

from fractions import Fraction

import numpy as np
import pytest

import zoh
from zoh import FrequencyResponse, Plant, Sampled
from zoh.analysis.tabled.count import agreed, count
from zoh.analysis.tabled.path import Path, at_rest, low_end, settled
from zoh.errors import Infeasible, NotMet

DT = 0.1
W = np.geomspace(1e-3, np.pi / DT, 300)
WIDE = np.geomspace(1e-3, 90, 600)

PLANTS = {  # num and den in z, of dt = 0.1 s
    "gain at rest": ([0.5], [1, -0.5]),
    "zero": ([1, -1], [1, -0.5]),
    "two zeros": ([0.25, -0.5, 0.25], [1, -1, 0.25]),
    "integrator": ([0.1], [1, -1]),
    "two integrators": ([0.005, 0.005], [1, -2, 1]),
}
LAWS = {
    "gain": ([0.5], [1]),
    "pi": ([1.05, -1], [1, -1]),
    "zero": ([0.5, -0.5], [1, -0.25]),
    "two zeros": ([0.5, -1, 0.5], [1, -0.5, 0.0625]),
    "pole and zero": ([0.5, -0.5], [1, -1]),
}
# how many poles at z = 1 are hidden: the fewer of all zeros and all poles there
HIDDEN = {
    ("zero", "pi"): 1,
    ("two zeros", "pi"): 1,
    ("integrator", "zero"): 1,
    ("integrator", "two zeros"): 1,
    ("two integrators", "zero"): 1,  # and one is left
    ("two integrators", "two zeros"): 2,
    ("gain at rest", "pole and zero"): 1,
    ("zero", "pole and zero"): 1,
    ("two integrators", "pole and zero"): 1,
}
NOT_HIDDEN = [
    ("gain at rest", "gain"),
    ("gain at rest", "pi"),
    ("gain at rest", "zero"),
    ("zero", "gain"),
    ("zero", "zero"),
    ("two zeros", "two zeros"),
    ("integrator", "gain"),
]


def table(plant, w=W, **more):
    num, den = PLANTS[plant]
    z = np.exp(1j * w * DT)
    return FrequencyResponse.from_complex(
        w=w, gain=np.polyval(num, z) / np.polyval(den, z), dt=DT, **more
    )


def controller(law):
    num, den = LAWS[law]
    return Sampled(num=num, den=den, dt=DT)


def closed(plant, law):
    """Return the closed loop's polynomial, exactly."""
    top, bottom = (
        np.polymul(*([Fraction(c) for c in system[i]] for system in (PLANTS[plant], LAWS[law])))
        for i in (0, 1)
    )
    return np.polyadd(top, bottom)


def of(formula, w=WIDE):
    return FrequencyResponse.from_complex(w=w, gain=Plant.parse(formula).at(w))


@pytest.mark.parametrize(("plant", "law"), HIDDEN)
def test_a_pole_that_a_zero_hides_at_rest_is_counted(plant, law):
    assert sum(closed(plant, law)) == 0  # its value at z = 1
    path = Path.of(controller(law) * table(plant))
    found = count(path)
    assert found.unstable == HIDDEN[plant, law]
    assert found.hidden
    assert agreed(path, path.coarser()) == found
    assert zoh.margins(controller(law) * table(plant)).stable is False


@pytest.mark.parametrize(("plant", "law"), NOT_HIDDEN)
def test_a_loop_that_hides_nothing_at_rest_is_stable_as_its_poles_are(plant, law):
    assert np.abs(np.roots(closed(plant, law).astype(float))).max() < 1
    found = count(Path.of(controller(law) * table(plant)))
    assert (found.unstable, found.hidden) == (0, "")


def test_noise_does_not_bring_back_what_is_hidden():
    # 3 sigma of 0.9 of a loop near -0.5 leave its turns open, and those do not matter
    noisy = table("integrator", uncertainty=0.9)
    assert count(Path.of(controller("gain") * noisy)).unstable is None
    assert zoh.margins(controller("zero") * noisy).stable is False


def test_what_is_hidden_or_left_open_is_so_whatever_points_are_left_out():
    """A hundred times the loop is further away than -1."""
    loud = FrequencyResponse.from_complex(w=W, gain=10 / (np.exp(1j * W * DT) - 1), dt=DT)
    moved = Path.of(controller("gain") * loud)
    path = Path.of(controller("zero") * table("integrator"))
    found = agreed(path, [moved])
    assert found == count(path)
    assert (found.unstable, found.hidden[:10]) == (1, "at z = 1: ")
    found = agreed(Path.of(controller("gain") * table("integrator", uncertainty=0.9)), [moved])
    assert found.unstable is None
    assert found.why.startswith("within its uncertainty (3 sigma) the loop may be -1 at ")


def first_words(loop):
    return zoh.margins(loop).warnings[0]


def test_what_is_hidden_is_said_with_what_is_taken_for_granted():
    said = "a hidden mode keeps the closed loop unstable, at z = 1: the controller has a "
    granted = "; taken for granted: below 0.001 rad/s its gain falls with w^{}, as its low end does"
    assert first_words(controller("pi") * table("zero")) == (
        f"{said}pole there, and the plant a zero{granted.format(1)}"
    )
    assert first_words(controller("zero") * table("two integrators")) == (
        f"{said}zero there, and the plant a pole{granted.format(-2)}"
    )
    assert (
        first_words(controller("pole and zero") * table("zero")) == f"{said}pole and a zero there"
    )


def test_of_a_continuous_loop_it_is_at_s_0():
    pi = Plant(num=[1, 1], den=[1, 0])
    assert first_words(pi * of("s/(s+1)^2")) == (
        "a hidden mode keeps the closed loop unstable, at s = 0: the controller has a pole there, "
        "and the plant a zero; taken for granted: below 0.001 rad/s its gain falls with w^1, as "
        "its low end does"
    )
    assert zoh.margins(pi * of("1/(s+1)^2")).stable is True


def test_zeros_and_poles_of_a_controller_at_rest():
    assert at_rest(None) == (0, 0)
    assert at_rest(controller("two zeros")) == (2, 0)
    assert at_rest(controller("pole and zero")) == (1, 1)
    assert at_rest(Plant(num=[1, 0], den=[1, 2, 0, 0])) == (1, 2)


@pytest.mark.parametrize(
    ("formula", "law"),
    [
        ("s/(s+1)^2", ([1.05, -1], [1, -1])),
        ("s^2/(s+1)^4", ([1.05, -1], [1, -1])),
        ("exp(-0.3 s) s/(s+1)^2", ([1.05, -1], [1, -1])),
        ("1/(s(s+1))", ([5, -5], [1, -0.3])),
        ("1/(s^2(s+1))", ([5, -5], [1, -0.3])),
        ("(s+0.1)/(s^2(s+1))", ([5, -5], [1, -0.3])),
    ],
)
def test_a_table_refuses_what_its_plant_refuses_in_the_same_words(formula, law):
    law = Sampled(num=law[0], den=law[1], dt=DT)
    with pytest.raises(NotMet) as on_the_plant:
        zoh.verify(Plant.parse(formula), law)
    with pytest.raises(NotMet) as on_the_table:
        zoh.verify_table(of(formula), law)
    assert (
        on_the_table.value.misses == on_the_plant.value.misses == ("the closed loop is unstable",)
    )
    assert on_the_table.value.measured.margins.stable is False


@pytest.mark.parametrize(
    ("law", "formula", "asked"),
    [
        ("pi", "s/(s+1)^2", {"wc": 2.0, "pm_deg": 120.0}),
        ("pid", "10 s/(s+1)^3", {"wc": 2.0, "pm_deg": 60.0, "ki": 0.5}),
        ("pid", "10 s/(s+1)^3", {"wc": 2.0, "pm_deg": 60.0, "ti_td": 4.0}),
    ],
)
def test_no_integral_is_designed_for_a_plant_that_blocks_constants(law, formula, asked):
    for plant in (of(formula), Plant.parse(formula)):
        with pytest.raises(NotMet) as refused:
            getattr(zoh, law)(plant, dt=DT, **asked)
        assert refused.value.misses == ("the closed loop is unstable",)


def test_a_refusal_offers_no_law_that_hides_its_pole():
    # a PI turns by -90 to 0 deg, and 20 deg at 2 rad/s ask for more
    with pytest.raises(Infeasible) as refused:
        zoh.pi(of("s/(s+1)^2"), dt=DT, wc=2.0, pm_deg=20.0)
    assert refused.value.nearest_wc is None
    assert set(refused.value.laws_that_can).isdisjoint({"pi", "pid"})


UNSETTLED = (
    "the table does not decide stability: below {} rad/s, where the table begins, neither slope "
    "nor phase show how it goes on: measure further down, until they settle"
)


@pytest.mark.parametrize("first", [0.4, 0.6, 0.7, 0.8, 1.0])
def test_a_table_that_begins_at_a_crest_is_not_one_of_a_constant(first):
    # |s/(s+1)^2| is level at 1 rad/s, and the phase goes on from +90 deg to -90 deg through it
    begun = of("s/(s+1)^2", np.geomspace(first, 90, 300))
    loop = controller("pi") * zoh.sample(begun, DT)
    assert first_words(loop) == UNSETTLED.format(f"{first:g}")
    assert zoh.margins(loop).stable is None


def test_a_table_that_begins_at_a_trough_may_hide_an_integrator():
    # 60 (s+1)^2/(s (s+60)^2) is level at 1 rad/s between an integrator and a zero
    begun = of("60 (s+1)^2/(s(s+60)^2)", np.geomspace(0.75, 300, 400))
    assert low_end(begun).integrators == 0
    assert first_words(controller("zero") * zoh.sample(begun, DT)) == UNSETTLED.format("0.75")


def test_a_zero_at_rest_leaves_open_what_a_late_table_begins_with():
    # 0.1 of a dead time at -60 deg: neither a constant's phase nor an integrator's
    late = FrequencyResponse(w=[1, 2, 4], magnitude=[0.1] * 3, phase_deg=[-60, -120, -240], dt=DT)
    assert low_end(late) is None
    assert first_words(controller("zero") * late) == UNSETTLED.format("1")
    assert zoh.margins(controller("gain") * late).stable is True  # it is quiet below


@pytest.mark.parametrize("turned", [0.0, 180.0, -360.0, 540.0])
@pytest.mark.parametrize(("slope", "asymptote"), [(0, 0.0), (-1, -90.0), (1, 90.0), (-2, -180.0)])
def test_a_phase_settles_where_its_line_ends_within_45_deg_of_the_asymptote(
    slope, asymptote, turned
):
    def path(second):
        w = np.array([1.0, 1.5, 2.0, 8.0])
        # from -20 deg on a line to ``second`` at 2 rad/s, so 2 (-20) - second at w = 0
        phase = np.array([-20, (second - 20) / 2, second, 300.0]) + asymptote + turned
        return Path.of(FrequencyResponse(w=w, magnitude=w**slope, phase_deg=phase))

    for second, settles in ((-40, True), (-84.9, True), (-85.1, False), (4.9, True), (5.1, False)):
        assert path(second).low.integrators == -slope
        assert settled(path(second)) is settles


def test_what_has_no_asymptote_has_not_settled():
    steep = FrequencyResponse(w=[1, 2, 4], magnitude=[1, 0.7, 0.5], phase_deg=[-45] * 3)
    path = Path.of(steep)
    assert path.low is None
    assert settled(path) is False


def test_a_lag_and_a_delay_settle_wherever_they_are_taken_for_a_constant():
    # the lag's phase is 20 deg at 0.36 of its corner; the delay's is in line
    for formula in ("1/(s+1)", "exp(-s)", "exp(-0.5 s)/(s+1)"):
        for first in (0.05, 0.1, 0.2, 0.3):
            path = Path.of(of(formula, np.geomspace(first, 90, 300)))
            assert path.low.integrators == 0
            assert settled(path)
