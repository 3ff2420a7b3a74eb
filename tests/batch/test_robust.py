"""One controller for a set of plants: measured on each, best where it is worst, or refused."""

import pytest

import zoh

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
ENDS = {"plant.gain": zoh.Uniform(low=1.8, high=2.8), "plant.den.1": zoh.Uniform(low=0.6, high=1.0)}
GIVEN = {"wc": [1.0, 2.0], "pm_deg": [40, 50, 60]}


def brute(asked, requirements):
    """Return the worst Ms and margin of the controller of ``asked`` on each corner, one by one."""
    d = zoh.pd(ARM, dt=0.1, **asked)
    found = []
    for gain in (1.8, 2.8):
        for damping in (0.6, 1.0):
            plant = zoh.Plant(num=[gain], den=[1, damping, 0], sensor=12 / 180)
            try:
                m = zoh.verify(plant, d.controller, requirements=requirements).margins
            except zoh.NotMet:
                return None
            found.append((m.ms, m.phase_margin_deg))
    return max(ms for ms, _ in found), min(pm for _, pm in found)


def test_the_controller_is_the_best_of_all_by_its_worst_plant():
    asked_of_all = zoh.Requirements(pm_deg=35)
    found = zoh.robust(ARM, "pd", GIVEN, dt=0.1, over=zoh.corners(ENDS), requirements=asked_of_all)
    worst = {
        (wc, pm): brute({"wc": wc, "pm_deg": pm}, asked_of_all)
        for wc in GIVEN["wc"]
        for pm in GIVEN["pm_deg"]
    }
    best = min((w[0], at) for at, w in worst.items() if w is not None)[1]
    assert (found.asked["wc"], found.asked["pm_deg"]) == best
    # the plant's numbers are exact either way, so the figures are the same to the last bit or two
    assert found.worst_ms.value == pytest.approx(worst[best][0], rel=1e-12)
    assert found.worst_pm.value == pytest.approx(worst[best][1], rel=1e-12)
    assert found.tried == 6
    assert found.design.met
    assert len(found.sweep) == 4
    assert found.sweep.yield_() == 1.0


def test_the_plant_as_it_stands_is_judged_like_those_of_the_set():
    given = {"wc": [1.0, 1.5, 2.0, 3.0], "pm_deg": [40, 50, 60, 70]}
    asked = zoh.Requirements(overshoot_pct=20, settling_time=5)
    damped = [zoh.Plant(num=[2.3], den=[1, a, 0], sensor=12 / 180) for a in (2.0, 3.0)]
    worst = {}
    for wc in given["wc"]:
        for pm in given["pm_deg"]:
            try:
                controller = zoh.pd(ARM, dt=0.1, wc=wc, pm_deg=pm).controller
                each = [zoh.verify(p, controller, requirements=asked) for p in (ARM, *damped)]
            except (zoh.NotMet, zoh.Infeasible):
                continue
            worst[wc, pm] = max(d.margins.ms for d in each)
    assert (2.0, 60) in worst
    found = zoh.robust(
        ARM, "pd", given, dt=0.1, over={"plant.den.1": [2.0, 3.0]}, requirements=asked
    )
    assert (found.asked["wc"], found.asked["pm_deg"]) == min(worst, key=lambda at: worst[at])
    assert found.design.met


def test_what_no_controller_keeps_is_refused_with_the_plants_that_miss_it():
    hard = zoh.Requirements(ms=1.05)
    with pytest.raises(zoh.NotMet) as refused:
        zoh.robust(ARM, "pd", GIVEN, dt=0.1, over=zoh.corners(ENDS), requirements=hard)
    first = refused.value.misses[0]
    assert first.startswith(
        "at plant.gain = 1.8, plant.den.1 = 0.6 ms must be at most 1.05, measured"
    )
    assert refused.value.misses[-1] == "and 1 more of 4 plants"
    assert refused.value.measured.margins.stable


def test_a_plant_on_which_it_is_unstable_is_named():
    # kp of an integrator behind a hold: stable while the gain is below 2/kp
    one = zoh.Plant(num=[1.0], den=[1, 0])
    with pytest.raises(zoh.NotMet, match=r"at plant.gain = 4 the loop is unstable"):
        zoh.robust(one, "p", {"pm_deg": 45}, dt=1.0, over={"plant.gain": [1.0, 4.0]})


@pytest.mark.parametrize(
    ("given", "over", "argument"),
    [
        (GIVEN, {"wc": [1.0]}, "over"),
        (GIVEN, {"dt": [0.1]}, "over"),
        ({"wc": 1.0}, {"plant.gain": [1.0]}, "pm_deg"),
        ({"wc": "a", "pm_deg": 50}, {"plant.gain": [1.0]}, "wc"),
        ({"wc": [1.0, "a"], "pm_deg": 50}, {"plant.gain": [1.0]}, "wc"),
        ({"wc": 1.0, "pm_deg": None}, {"plant.gain": [1.0]}, "pm_deg"),
        ([("wc", 1.0)], {"plant.gain": [1.0]}, "given"),
        ({"wc": 1.0, "pm_deg": 170}, {"plant.gain": [1.0]}, "given"),
    ],
)
def test_a_malformed_request_is_refused(given, over, argument):
    with pytest.raises(zoh.SpecError) as refused:
        zoh.robust(ARM, "pd", given, dt=0.1, over=over)
    assert refused.value.argument == argument


@pytest.mark.parametrize("weight", [0.5, [1.0, 0.5]])
def test_weights_of_the_reference_are_no_part_of_one_controller(weight):
    asked = {"wc": 1.5, "pm_deg": 50, "setpoint_weight": weight}
    with pytest.raises(zoh.SpecError, match=r"setpoint_weight must be 1 for one controller over"):
        zoh.robust(ARM, "pd", asked, dt=0.1, over=zoh.corners(ENDS))
