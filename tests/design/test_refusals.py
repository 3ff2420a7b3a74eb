"""Every refusal, word for word, its numbers worked by hand at z = j.

The integrator 1/(z - 1) has there |G| = 1/sqrt 2, arg G = -135 deg, v = 2 and x = v dt/2 = 1, so
45 deg of margin without a law, and a law needs a gain of sqrt 2 = 1.414.
"""

from itertools import count
from math import cos, pi, radians, sqrt

import numpy as np
import pytest

import zoh
from zoh.design import first_order, leadlag, p, pid
from zoh.design import pi as pi_law
from zoh.design.target import ABOVE, BELOW, Opposite, Target, nearest
from zoh.errors import Infeasible, SpecError
from zoh.lti.systems import Sampled
from zoh.spec import Crossover

INTEGRATOR = Sampled(num=(1.0,), den=(1.0, -1.0), dt=1.0)


def at_j(pm_deg):
    return Crossover(wc=pi / 2, pm_deg=pm_deg)


def sentence(law, gives, pm_deg, needs, best=None):
    text = f"{law} {gives}; a margin of {pm_deg} deg at 1.5708 rad/s needs {needs} deg and a gain"
    return (
        text + " of 1.414" + (f"; the best margin it can give here is {best} deg" if best else "")
    )


def turns(low, high):
    return f"turns the phase by {low} to {high} deg here"


# PID, ki = 1: k = |G|/v = 1/sqrt 8, asin k = 20.70 deg; acos(x k/sqrt 2) = acos(1/4) = 75.52 deg,
#   less atan x = 45 deg
# PID, ki = 5: x k/sqrt 2 = 5/4 is no cosine; it is 1 for ki = 4
# PID, ki = 3: k = 3/sqrt 8 is no sine, kd > 0 everywhere; acos(3/4) = 41.41 deg either way, less
#   45 deg; of the 41.4096 no more is offered than can be had
# lead, a0 = 1: acos(a0 |G|) = 45 deg;  lag, a0 = 5: acos(sqrt 2/5) = 73.57 deg
REFUSALS = [
    (p.solve, {}, 60, sentence("a P", "turns the phase by nothing here", 60, "+15", 45)),
    (p.solve, {}, 30, sentence("a P", "turns the phase by nothing here", 30, "-15", 45)),
    (pi_law.solve, {}, 60, sentence("a PI", turns("-90", 0), 60, "+15", 45)),
    (
        pid.solve,
        {"ki": 0.0},
        100,
        sentence("a PD with positive gains", turns(0, "+45"), 100, "+55", 90),
    ),
    (
        pid.solve,
        {"ki": 1.0},
        100,
        sentence(
            "a PID with ki = 1 and positive kp and kd",
            turns("-20.7", "+30.52"),
            100,
            "+55",
            "75.52",
        ),
    ),
    (
        pid.solve,
        {"ki": 3.0},
        60,
        sentence(
            "a PID with ki = 3 and positive kp and kd",
            turns("-86.41", "-3.59"),
            60,
            "+15",
            "41.4",
        ),
    ),
    (
        pid.solve,
        {"ki": 5.0},
        60,
        sentence(
            "a PID with ki = 5 and positive kp and kd",
            "has no positive kp here: its ki must be below 4",
            60,
            "+15",
        ),
    ),
    (
        first_order.lead,
        {"dc_gain": 1.0},
        100,
        sentence("a lead of dc_gain 1", turns(0, "+45"), 100, "+55", 90),
    ),
    (
        first_order.lead,
        {"dc_gain": 2.0},
        75,
        sentence("a lead of dc_gain 2", "has a gain above that everywhere", 75, "+30"),
    ),
    (
        first_order.lag,
        {"dc_gain": 5.0},
        60,
        sentence("a lag of dc_gain 5", turns("-73.57", 0), 60, "+15", 45),
    ),
    (
        first_order.lag,
        {"dc_gain": 1.0},
        30,
        sentence("a lag of dc_gain 1", "has a gain below that everywhere", 30, "-15"),
    ),
]


@pytest.mark.parametrize(("solve", "more", "pm_deg", "text"), REFUSALS, ids=count())
def test_a_refusal_says_what_the_law_gives_and_what_is_needed(solve, more, pm_deg, text):
    with pytest.raises(Infeasible) as refused:
        solve(INTEGRATOR, at_j(pm_deg), **more)
    assert str(refused.value) == text
    assert refused.value.needed_deg == pytest.approx(pm_deg - 45, abs=1e-12)
    assert refused.value.needed_gain == pytest.approx(sqrt(2), rel=1e-14)
    gives = refused.value.gives_deg
    assert ("turns the phase" in text) == (gives is not None)
    for end in gives or ():
        assert f"{end:+.4g}" in text or abs(end) < 1e-7  # a P's interval is open, not empty


def test_a_lag_of_a_given_ratio_that_leaves_too_much_gain_is_refused():
    # wz = 2, r = 2: |lag| = sqrt(2/5), and 4/sqrt 2 of it is above 1: no lead lowers a gain
    with pytest.raises(Infeasible) as refused:
        leadlag.solve(INTEGRATOR, at_j(75), dc_gain=4.0, lag_corner=2.0, lag_ratio=2.0)
    assert str(refused.value) == sentence(
        "a lead-lag of dc_gain 4", "has a gain above that everywhere", 75, "+30"
    )


def test_a_pid_of_a_ratio_says_which_phases_any_pid_gives():
    # x = 1: -90 deg to 90 - 45 deg
    with pytest.raises(Infeasible) as refused:
        pid.solve_ratio(INTEGRATOR, at_j(100), ti_td=4.0)
    assert str(refused.value) == sentence(
        "a PID with positive gains", turns("-90", "+45"), 100, "+55", 90
    )
    assert refused.value.gives_deg == pytest.approx((-90, 45), rel=1e-14)


def test_the_largest_integral_gain_is_that_of_the_clock():
    # dt/(z - 1): |G| = dt/sqrt 2 and v = 2/dt at z = j, so 4/dt^2 = 16 in the place of 4
    fast = Sampled(num=(0.5,), den=(1.0, -1.0), dt=0.5)
    with pytest.raises(Infeasible, match="its ki must be below 16;"):
        pid.solve(fast, Crossover(wc=pi, pm_deg=60), ki=17.0)


@pytest.mark.parametrize(
    ("what", "num", "den"),
    [
        ("zero", (1.0, 0.0, 1.0), (1.0, -0.5, 0.06)),
        ("pole", (1.0, -0.5, 0.06), (1.0, 0.0, 1.0)),
        ("zero", (0.1, 0.0, 0.1), (1.0, -0.5, 0.06)),
        ("pole", (1.0, -0.5, 0.06), (10.0, 0.0, 10.0)),
    ],
)
def test_a_plant_without_a_gain_at_the_crossover_is_refused(what, num, den):
    with pytest.raises(SpecError) as refused:
        pi_law.solve(Sampled(num=num, den=den, dt=1.0), at_j(60))
    assert (refused.value.argument, refused.value.value) == ("wc", pi / 2)
    assert str(refused.value) == (
        f"wc must be where the plant has a gain, not at a {what} on the unit circle, "
        "got 1.5707963267948966: move wc away from it"
    )


def test_a_zero_beside_the_crossover_is_no_zero_at_it():
    # 1e-9 rad/s off z = j, G = j 2e-9/(z + 1/2): small, and a gain all the same
    notch = Sampled(num=(1.0, 0.0, 1.0), den=(1.0, 0.5, 0.0), dt=1.0)
    target = Target.of(notch, Crossover(wc=pi / 2 - 1e-9, pm_deg=60))
    assert target.size == pytest.approx(2e-9 / sqrt(1.25), rel=1e-6)  # wc holds 1e-9 to 1e-7


# Target.best_margin_deg: a law that turns nothing has pm - theta, here 60 deg - theta


@pytest.mark.parametrize(
    ("theta", "phases", "best"),
    [
        (20, (-30, 0), 40),  # the law can only take away
        (20, (0, 45), 85),
        (-110, (0, 45), 180),  # 170 ... 215 deg passes 180
        (-110, (-45, 10), 180),  # 125 ... 180 deg, approached
        (-130, (-15, 45), 180),  # 175 ... 235 deg
        (-130, (0, 45), None),  # 190 ... 235 deg are -170 ... -125: none above 0
        (60, (-30, 0), None),  # ends at 0
        (60, (-30, 1), 1),
        (20, None, None),
    ],
)
def test_the_best_margin_is_the_upper_end_of_what_a_law_can_turn(theta, phases, best):
    target = Target(v=2.0, size=1.0, theta=radians(theta), dt=1.0)
    ends = phases and tuple(radians(end) for end in phases)
    got = target.best_margin_deg(ends, at_j(60))
    assert got == (None if best is None else pytest.approx(best, abs=1e-12))


def test_the_ends_of_an_interval_are_not_inside():
    target = Target(v=2.0, size=1.0, theta=0.5, dt=1.0)
    assert target.inside((0.4, 0.6))
    assert not target.inside((0.5, 0.6))
    assert not target.inside((0.4, 0.5))
    assert not target.inside(None)


# phases: by hand at v = 2, dt = 1 (x = v/p = 1), |G| = 1/sqrt 2


def test_phases_by_hand():
    target = Target.of(INTEGRATOR, at_j(60))
    assert pi_law.phases(target) == (-pi / 2, 0.0)
    low, high = p.phases(target)
    assert low == -high
    assert 0 < high < 1e-9
    assert pid.phases(target, 0.0, 0.5) == pytest.approx((0, pi / 4), abs=1e-15)
    # k = ki/sqrt 8: the sine ends at k = 1, the cosine's reach k/sqrt 2 = ki/4 at ki = 4
    assert pid.phases(target, 4.0, 0.5) is None
    assert pid.phases(target, 3.999, 0.5) is not None
    # x = 3/4, k = 5/3: the reach is (3/4)(5/3)/(5/4) = 1
    assert pid.phases(Target(v=1.5, size=1.0, theta=0.1, dt=1.0), 2.5, 0.5) is None
    for ki in (2.9, 3.0):  # asin k = 90 deg at sqrt 8 = 2.83, and none is needed above
        turn = [-_acos(ki / 4) - pi / 4, _acos(ki / 4) - pi / 4]
        assert pid.phases(target, ki, 0.5) == pytest.approx(turn, abs=1e-14)
    half = Target(v=2.0, size=0.5, theta=0.1, dt=1.0)  # a0 |G| = 1 is neither above nor below
    assert first_order.lead_phases(half, 2.0) is None
    assert first_order.lag_phases(half, 2.0) is None
    assert first_order.lead_phases(target, 1.0) == pytest.approx((0, pi / 4), abs=1e-15)
    assert first_order.lag_phases(target, 2.0) == pytest.approx((-pi / 4, 0), abs=1e-15)


def _acos(c):
    """Return acos c by halving, for cosine falls on (0, pi)."""

    low, high = 0.0, pi
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if cos(middle) > c else (low, middle)
    return low


# nearest: on predicates whose edge is known


@pytest.mark.parametrize(
    ("works", "wc", "dt", "found"),
    [
        (lambda w: w >= sqrt(2), 1.0, 1.0, 1.414214),  # 1.41421356, up on its working side
        (lambda w: w <= sqrt(0.5), 1.0, 1.0, 0.7071067),  # 0.70710678, down
        (lambda w: w >= 20 * sqrt(2), 20.0, 0.1, 28.28428),  # 28.2842712
        (lambda w: w >= 1.30000005 or w <= 0.75, 1.0, 1.0, 1.300001),  # 1/1.3 = 0.769 > 0.75
        (lambda w: w >= 1.3 or w <= 0.80000005, 1.0, 1.0, 0.8),
        (lambda w: w <= 1.0000005e-3, 1.0, 1.0, 1e-3),  # as far as it looks
        (lambda w: w >= 3.0000005, 1.0, 1.0, 3.000001),  # below pi/dt
        (lambda w: w >= 3.2, 1.0, 1.0, None),  # above
        (lambda w: w >= 1.5000005, 1.0, 2.0, 1.500001),
        (lambda w: w >= 1.6, 1.0, 2.0, None),
        (lambda w: w <= 1e-4, 1.0, 1.0, None),  # too far
    ],
)
def test_the_nearest_frequency_that_works(works, wc, dt, found):
    got = nearest(lambda w: "" if works(w) else "no", wc, dt)
    assert got == (None if found is None else pytest.approx(found, rel=1e-14))
    assert got is None or works(got)


@pytest.mark.parametrize("at", [0.0123, 0.5017, 7.7777, 333.3])
@pytest.mark.parametrize(("part", "below", "above"), [(1e-6, BELOW, ABOVE), (1e-3, "a", "b")])
def test_what_is_narrower_than_the_search_is_found_where_the_reason_changes(at, part, below, above):
    """A millionth of a frequency where a phase is passed, a thousandth where a loop is measured."""

    def why_not(w):
        return below if w < at else above if w > at * (1 + part) else ""

    got = nearest(why_not, 1.0, 0.001)
    assert not why_not(got)
    assert nearest(lambda w: why_not(w) and "no", 1.0, 0.001) is None  # unless a step falls on it


@pytest.mark.parametrize(
    ("bad", "offered"), [({1.414214}, 1.414215), ({1.414214, 1.414215, 1.414217}, 1.414224)]
)
def test_the_nearest_is_a_few_units_inside_where_the_first_seven_digits_do_not_work(bad, offered):
    asked = []

    def why_not(w):
        asked.append(w)
        return "" if sqrt(2) < w and w not in bad else "no"

    assert nearest(why_not, 1.0, 1.0) == offered
    assert all(asked.count(w) == 1 for w in bad)  # a trial is a loop measured and proved


@pytest.mark.parametrize("away", [1, -1])
def test_what_is_narrower_than_a_seventh_digit_is_offered_in_a_few_more(away):
    """What works is 2e-8 to 4e-8 wide, beside 10 sqrt(2) = 14.14213562373095."""
    low, high = 10 * sqrt(2) - 1e-8 * (away < 0), 10 * sqrt(2) + 4e-8 - 2e-8 * (away < 0)
    wc = 13.0 if away > 0 else 15.0

    def why_not(w):
        return BELOW if w < low else ABOVE if w > high else ""

    got = nearest(why_not, wc, 0.01)
    assert low < got < high
    # its width, 2e-8 or more, holds numbers of eleven digits, 1e-9 apart; none is given more
    assert len(repr(got).replace(".", "")) <= 11
    assert f"is {got!r} rad/s" in str(Infeasible("no", needed_deg=0.0, nearest_wc=got))


def test_the_nearest_is_the_edge_itself_where_no_rounded_digits_work():
    asked = []
    bad = {1.414214, 1.414215, 1.414217, 1.414224, 1.41421357, 1.4142135624, 1.414213562374}

    def why_not(w):
        asked.append(w)
        return "" if sqrt(2) < w and w not in bad else "no"

    got = nearest(why_not, 1.0, 1.0)
    assert got == pytest.approx(sqrt(2), rel=1e-12)
    assert got > sqrt(2)
    assert asked.count(1.414214) == 1
    # what is printed is what works: all its digits, then
    assert f"{got!r} rad/s" in str(Infeasible("no", needed_deg=0.0, nearest_wc=got))
    assert "is 1.414214 rad/s" in str(Infeasible("no", needed_deg=0.0, nearest_wc=1.414214))


@pytest.mark.parametrize(
    ("best", "said"),
    [(129.26423, "129.2"), (44.999999, "44.99"), (45.0, "45"), (0.0012349, "0.001234")],
)
def test_a_best_margin_is_said_to_be_no_more_than_it_is(best, said):
    text = str(Infeasible("no", needed_deg=0.0, best_pm_deg=best))
    assert f"the best margin it can give here is {said} deg" in text


def test_an_edge_at_seven_digits_that_do_not_work_goes_to_the_next_that_do():
    assert nearest(lambda w: "" if w > 1.25 else "no", 1.0, 1.0) == 1.250001
    assert nearest(lambda w: "" if w < 0.875 else "no", 1.0, 1.0) == 0.8749999


def test_a_plant_turned_round_keeps_its_clock_and_its_size():
    plant = Sampled(num=[0.5], den=[1.0, -1.0], dt=0.25)
    turned = Opposite(plant)
    assert turned.dt == 0.25
    assert [turned.at(w) for w in (0.5, 3.0)] == [-plant.at(w) for w in (0.5, 3.0)]


def test_no_more_frequencies_are_tried_than_seven_digits_need():
    asked = []

    def why_not(w):
        asked.append(w)
        return "" if w >= sqrt(2) else "no"

    assert nearest(why_not, 1.0, 0.01) == 1.414214
    # 1.03^12 is above sqrt(2), and there are as many down, but for the last; wc itself
    outwards = 2 * 12 - 1 + 1
    # 3 % of sqrt(2) is 2^15.4 units of 1e-6; four more for an edge near a unit's end, one at last
    assert outwards < len(asked) <= outwards + 16 + 4 + 1


def test_the_nearest_is_looked_for_below_nyquist_alone():
    asked = []
    assert nearest(lambda w: asked.append(w) or "no", 1.0, 0.01) is None
    assert asked.pop(0) == 1.0
    assert 0.99 * pi / 0.01 < max(asked) < pi / 0.01
    # outwards from wc, to both sides in turn, 3 % at a time
    assert sorted(asked[:2]) == pytest.approx([1 / 1.03, 1.03], rel=1e-14)
    assert sorted(asked[2:4]) == pytest.approx([1.03**-2, 1.03**2], rel=1e-14)
    assert min(asked) == pytest.approx(1e-3, rel=0.25)  # "down to wc/1000": where steps end


@pytest.mark.parametrize("late", [0, 8])
def test_near_nyquist_the_phase_is_what_is_stepped_through(late):
    asked = []
    assert nearest(lambda w: asked.append(w) or "no", 1.0, 1.0, late) is None
    up = np.array(sorted(w for w in asked if w > 1))
    # 0.02 rad of the clock, a third of it with eight samples of delay
    assert np.diff(up) == pytest.approx(0.02 / (1 + late / 4), rel=1e-9)


def test_a_plant_that_answers_backwards_is_named():
    backwards = zoh.Plant(num=[-1], den=[1, 1])
    for asked in ({"wc": 0.8, "pm_deg": 60}, {}):
        with pytest.raises(zoh.Infeasible, match="a negative sensor gain turns it round"):
            zoh.pi(backwards, dt=0.1, **asked)
    turned = zoh.Plant(num=[-1], den=[1, 1], sensor=-1)
    assert zoh.pi(turned, dt=0.1, wc=0.8, pm_deg=60).met
    with pytest.raises(zoh.Infeasible) as plain:
        zoh.pi(turned, dt=0.1, wc=0.8, pm_deg=175)
    assert "sensor" not in str(plain.value)


def test_the_nearest_crossover_around_a_long_delay_is_had():
    """118 samples of delay, and |L| all but 1 below Nyquist's: it is offered where it is proved."""
    plant = zoh.Plant(num=[-0.596, 0.397], den=[1.503, 1], dead_time=5.9)
    asked = {"dt": 0.05, "pm_deg": 80, "ti_td": 4}
    with pytest.raises(zoh.Infeasible) as refused:
        zoh.pid(plant, wc=0.5024, **asked)
    for share in (1, 1 - 1e-7, 1 - 1e-6, 1 - 1e-5):
        found = zoh.pid(plant, wc=share * refused.value.nearest_wc, **asked)
        assert found.margins.phase_margin_deg == pytest.approx(80, rel=1e-9)
