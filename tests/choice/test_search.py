"""The climb, the glance and the whole search, against answers by hand."""

from contextlib import suppress
from math import asin, pi, sin
from random import Random
from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks.choice.attack import FASTER, Glance, beaten, drawn, gridded

import zoh
from zoh.choice.climb import HighEnough, climb, grid, tops
from zoh.choice.judge import Judge
from zoh.choice.sieve import Sieve
from zoh.solving import SolvedLaw

INTEGRATOR = zoh.Plant(num=[1.0], den=[1.0, 0.0])
ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
OVEN = zoh.Plant(num=[2], den=[120, 1], dead_time=15)


@pytest.mark.parametrize("peak", [(0.5,), (0.0,), (1.0,), (0.31, 0.77), (0.0, 1.0), (0.2, 0.2)])
def test_a_climb_reaches_the_top_of_a_roof(peak):
    seen = {}

    def height(point):
        assert all(0 <= c <= 1 for c in point)
        return seen.setdefault(point, -max(abs(a - b) for a, b in zip(point, peak, strict=True)))

    best = max(grid(len(peak)), key=height)
    climb(height, best)
    assert max(seen.values()) > -2e-3


def test_a_climb_ends_when_told():
    def height(point):
        if point[0] > 0.4:
            raise HighEnough
        return point[0]

    with pytest.raises(HighEnough):
        climb(height, (0.3,))


def test_the_tops_of_two_hills_are_both_found():
    heights = {p: max(-abs(p[0] - 0.1), -2 * abs(p[0] - 0.9)) for p in grid(1)}
    assert [p[0] for p in tops(heights)] == pytest.approx([1 / 12, 11 / 12], abs=0.05)


@pytest.mark.parametrize("plant", [ARM, OVEN], ids=["arm", "oven"])
def test_a_glance_never_condemns_what_is_good(plant):
    dt = 0.1 if plant is ARM else 5.0
    sampled, rng = zoh.sample(plant, dt), np.random.default_rng(2)
    asked = zoh.Requirements(ms=1.7, mt=1.4)
    laws = [
        zoh.Sampled.from_w(num_w=(float(k), float(k * i)), den_w=(1.0, 0.0), dt=dt)
        for k, i in np.exp(rng.uniform(-4, 2, (60, 2)))
    ]
    judge = Judge(plant=plant, sampled=sampled, compute_delay=0, requirements=asked, reference=1)
    bounds = Sieve(judge).slack([SolvedLaw(controller=law, gains={}) for law in laws])
    for law, bound in zip(laws, bounds, strict=True):
        found = zoh.margins(law * sampled)
        assert min(1 - found.ms / 1.7, 1 - found.mt / 1.4) <= bound + 1e-9


@pytest.mark.parametrize("ms", [1.3, 1.7, 2.5])
def test_a_p_on_an_integrator_by_hand(ms):
    """L = k/(z - 1): Ms = 2/(2 - k) at z = -1, and |z - 1| = 2 sin(wc/2) = k at the crossover."""
    d = zoh.p(INTEGRATOR, dt=1.0, requirements=zoh.Requirements(ms=ms))
    by_hand = 2 * asin(1 - 1 / ms)
    # 2e-4: the edge is closed in on to 1e-4 of itself
    assert by_hand * (1 - 2e-4) < d.margins.crossover <= by_hand * (1 + 1e-9)
    assert d.choice.open == ("wc", "pm_deg")
    assert d.choice.assumed == ()
    assert "ms must be at most" in d.choice.limits[0]


def test_a_pi_on_an_integrator_by_its_phase():
    """Its own margin is 90 deg - wc/2; a PI takes atan(0.1) at least of it, and 45 are asked."""
    d = zoh.pi(INTEGRATOR, dt=1.0, requirements=zoh.Requirements(pm_deg=45))
    limit = 2 * (pi / 4 - np.arctan(0.1))
    assert limit * (1 - 2e-4) < d.margins.crossover <= limit * (1 + 1e-9)
    assert "cannot give a margin of 45 deg" in d.choice.limits[0]


def test_nothing_asked_is_said_to_be_assumed():
    d = zoh.pi(ARM, dt=0.1)
    assert d.choice.assumed == ("pm_deg = 45", "ms = 1.7")
    assert d.margins.ms <= 1.7 * (1 + 1e-9)
    assert d.margins.phase_margin_deg >= 45 - 1e-9
    assert "assumed, nothing being asked: pm_deg = 45, ms = 1.7" in d.report()
    asked = zoh.pi(ARM, dt=0.1, pm_deg=50)
    assert asked.choice.assumed[0].startswith("ms = 1.7")
    assert asked.margins.phase_margin_deg == pytest.approx(50, abs=1e-9)
    flat = zoh.pi(ARM, dt=0.1, pm_deg=20)  # |1 + L| is 2 sin(10 deg) at wc, and Ms its inverse
    assert flat.requirements.ms == pytest.approx(1.25 / (2 * sin(pi / 18)), rel=1e-12)


def test_at_a_given_crossover_the_most_slack_is_taken():
    d = zoh.pi(ARM, dt=0.1, wc=0.3)
    assert d.margins.crossover == pytest.approx(0.3, rel=1e-9)
    assert d.choice.open == ("pm_deg",)
    for pm in (d.margins.phase_margin_deg - 3, d.margins.phase_margin_deg - 10):
        other = zoh.pi(ARM, dt=0.1, wc=0.3, pm_deg=pm)
        slack = min(other.margins.phase_margin_deg / 45 - 1, 1 - other.margins.ms / 1.7)
        here = min(d.margins.phase_margin_deg / 45 - 1, 1 - d.margins.ms / 1.7)
        assert slack <= here + 1e-6  # where the climb ends


def test_the_first_law_that_can_is_taken_and_the_others_say_why_not():
    d = zoh.design(OVEN, "auto", {}, dt=5.0)
    assert d.law == "pi"  # a P leaves an error at rest
    assert [law for law, _ in d.choice.tried] == ["p"]
    assert d.choice.open[0] == "law"
    assert d.step.steady_state_error == 0.0
    fast = zoh.Requirements(pm_deg=50, bandwidth=3.0)
    d = zoh.design(ARM, "auto", {}, dt=0.1, requirements=fast)
    assert d.law == "pd"
    assert [law for law, _ in d.choice.tried] == ["p", "pi"]
    assert "bandwidth must be at least 3" in d.choice.tried[0][1]
    assert d.to_dict()["choice"]["tried"][0]["law"] == "p"


def test_a_ratio_of_times_leaves_no_slow_zero():
    d = zoh.pid(zoh.Plant(num=[1], den=[1, 0, 0]), dt=0.1, ti_td=4.0)
    v = 20 * np.tan(d.margins.crossover * 0.05)
    assert min(-np.roots(d.controller.num_w).real) >= 0.1 * v * (1 - 1e-9)
    kp, ki, kd = (d.gains[k] for k in ("kp", "ki", "kd"))
    assert kp * kp / (ki * kd) == pytest.approx(4, rel=1e-9)
    assert d.choice.open == ("wc", "pm_deg")


def test_what_nothing_can_meet_is_refused_with_the_nearest():
    slow = zoh.Requirements(ms=1.2, bandwidth=2.0)
    with pytest.raises(
        zoh.Infeasible, match="no pi meets everything asked; of a pi, it comes"
    ) as e:
        zoh.pi(ARM, dt=0.1, requirements=slow)
    assert "bandwidth must be at least 2" in str(e.value)
    assert -180 < e.value.needed_deg <= 180
    with pytest.raises(zoh.Infeasible, match=r"no law meets everything asked at 20 rad/s"):
        zoh.design(ARM, "auto", {"wc": 20.0}, dt=0.1)
    with pytest.raises(zoh.Infeasible, match=r"the law cannot give a margin of .* anywhere"):
        zoh.p(INTEGRATOR, dt=1.0, requirements=zoh.Requirements(pm_deg=91))


def test_a_table_leaves_nothing_open():
    w = np.geomspace(0.1, 25, 60)
    g = zoh.sample(ARM, 0.1).at(w)
    table = zoh.FrequencyResponse(
        w=w, magnitude=np.abs(g), phase_deg=np.degrees(np.unwrap(np.angle(g))), dt=0.1
    )
    with pytest.raises(zoh.SpecError, match="pm_deg must be given for pi on a table"):
        zoh.pi(table, dt=0.1, wc=0.5)


@pytest.mark.parametrize("seed", [0, 3, 7, 8, 9, 13, 16, 19])
def test_random_controllers_do_not_beat_a_choice(seed):
    task = drawn(Random(900_000 + seed))
    with suppress(zoh.Infeasible):
        found = zoh.design(task.plant, task.law, {}, dt=task.dt, requirements=task.asked)
        assert beaten(task, found, found.requirements, Random(seed), 120) is None


def test_a_glance_at_a_rival_condemns_none_that_measuring_would_not():
    tried = spared = 0
    for seed in (100_003, 100_004):
        task = drawn(Random(seed))
        found = zoh.design(task.plant, task.law, {}, dt=task.dt, requirements=task.asked)
        # half as fast, so that some rivals do win
        wc = found.margins.crossover / 2
        slower = SimpleNamespace(margins=SimpleNamespace(crossover=wc), sampled=found.sampled)
        glance = Glance.of(found.sampled, wc * FASTER, found.requirements)
        for num, den in list(gridded(task, slower))[::11]:
            rival = zoh.Sampled.from_w(num_w=num, den_w=den, dt=task.dt)
            margins = zoh.margins(rival * found.sampled)
            wins = margins.stable and (margins.crossover or 0) >= wc * FASTER
            wins = wins and zoh.measure(task.plant, rival, requirements=found.requirements).met
            tried, spared = tried + 1, spared + wins
            assert not (wins and glance.hopeless(num, den))
    assert tried > 50
    assert spared > 5  # or nothing would have been shown


def test_a_p_with_its_margin_given_is_tried_first():
    d = zoh.design(ARM, "auto", {"pm_deg": 60.0}, dt=0.1, requirements=zoh.Requirements(ms=2))
    plain = zoh.p(ARM, dt=0.1, pm_deg=60)
    assert (d.law, d.choice.tried) == ("p", ())
    assert d.margins.crossover == pytest.approx(plain.margins.crossover, rel=1e-9)
    with pytest.raises(zoh.Infeasible, match="ms must be at most"):  # 1.46 or more
        zoh.design(ARM, "auto", {"pm_deg": 40.0}, dt=0.1, requirements=zoh.Requirements(ms=1.4))


def test_a_loop_that_misses_by_far_is_nearer_than_none():
    slow = zoh.Plant(num=[1], den=[1, 0.2, 0])
    with pytest.raises(zoh.Infeasible, match="overshoot_pct must be at most 1, measured"):
        zoh.pi(slow, dt=0.1, requirements=zoh.Requirements(overshoot_pct=1))


def test_what_is_no_requirement_is_named_before_the_search():
    for asked in ("x", 3):
        with pytest.raises(zoh.SpecError, match="requirements must be zoh"):
            zoh.pi(ARM, dt=0.1, requirements=asked)
        with pytest.raises(zoh.SpecError, match="requirements must be zoh"):
            zoh.law_map(ARM, "pi", dt=0.1, requirements=asked)
