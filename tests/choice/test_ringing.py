"""Poles near z = -1: chosen where nothing else does, and said wherever they come from.

A pole at w = -p is at z = (1 - p dt/2)/(1 + p dt/2), by hand: below -1/2 where p is above 6/dt.
"""

from math import atan, degrees, exp, log, pi, tan

import numpy as np
import pytest

import zoh
from zoh.choice.freedom import SLOWEST, Freedom
from zoh.lti.systems import Sampled
from zoh.solving import solved
from zoh.spec import Crossover

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
MOTOR = zoh.Plant(num=[1], den=[1, 1, 0])
RINGS = "no lead without a pole that rings at every sample meets everything"


def fastest(d):
    """Return the fastest pole of a lag, lead or lead-lag in rad/s (w-plane)."""
    return max(value for name, value in d.gains.items() if name in ("wp", "lag_pole", "lead_pole"))


@pytest.mark.parametrize(
    ("plant", "dt", "wc", "pm_deg"), [(MOTOR, 0.1, 1.0, 60.0), (MOTOR, 0.2, 1.7, 50.0)]
)
def test_a_lead_whose_gain_is_open_does_not_ring(plant, dt, wc, pm_deg):
    d = zoh.lead(plant, dt=dt, wc=wc, pm_deg=pm_deg)
    assert fastest(d) <= 6 / dt
    assert d.choice.notes == ()
    assert "rings" not in d.report()
    least = zoh.lead(plant, dt=dt, wc=wc, pm_deg=pm_deg, dc_gain=0.999 * d.gains["dc_gain"])
    assert d.margins.ms < least.margins.ms  # of those that do not ring it is the best still


@pytest.mark.parametrize(
    ("law", "given"),
    [
        ("lead", {}),
        ("lead", {"wc": 2.0}),
        ("lead", {"wc": 2.0, "dc_gain": 4.0}),  # the margin alone is chosen
        ("lag", {}),
        ("leadlag", {}),
        ("leadlag", {"lag_ratio": 4.0}),
        ("leadlag", {"wc": 2.0, "dc_gain": 100.0}),
    ],
)
def test_nothing_chosen_rings_where_all_can_be_had_without(law, given):
    d = zoh.design(ARM, law, given, dt=0.1)
    assert fastest(d) <= 6 / 0.1
    assert all(pole.real >= -0.5 - 1e-9 for pole in np.roots(d.controller.den))
    assert not any("that rings" in note for note in d.choice.notes)


def test_what_can_only_be_had_with_a_ringing_pole_is_and_says_so():
    best = zoh.lead(MOTOR, dt=0.1, wc=1, pm_deg=60).margins.ms
    asked = zoh.Requirements(ms=best - 1e-3)
    d = zoh.lead(MOTOR, dt=0.1, wc=1, pm_deg=60, requirements=asked)
    assert fastest(d) > 6 / 0.1
    assert d.choice.notes == (RINGS,)
    assert f"NOTE: wp = {d.gains['wp']:g} is far above 2/dt = 20: its pole at z = -0." in d.report()


def test_the_nearest_crossover_may_need_a_ringing_pole():
    """A calm lead meets this up to 0.154 rad/s, a ringing one up to 0.2116."""
    asked = {"dt": 0.1, "requirements": zoh.Requirements(ms=1.01, pm_deg=60)}
    with pytest.raises(zoh.Infeasible) as refused:
        zoh.lead(MOTOR, wc=1, **asked)
    there = zoh.lead(MOTOR, wc=refused.value.nearest_wc, **asked)
    assert fastest(there) > 6 / 0.1
    with pytest.raises(zoh.Infeasible):
        zoh.lead(MOTOR, wc=1.02 * refused.value.nearest_wc, **asked)


def test_auto_takes_no_ringing_lead_where_a_later_law_does_without():
    best = zoh.lead(MOTOR, dt=0.1, wc=1, pm_deg=60).margins.ms
    asked = zoh.Requirements(ms=best - 1e-3)
    d = zoh.design(MOTOR, "auto", {"wc": 1, "pm_deg": 60}, dt=0.1, requirements=asked)
    assert d.law == "pid"
    assert "lead" in dict(d.choice.tried)
    assert not any("that rings" in note for note in d.choice.notes)


def test_auto_takes_a_ringing_lead_where_no_other_law_does():
    """On a double integrator P, PI and lag are unstable."""
    plant = zoh.Plant(num=[1], den=[1, 0, 0])
    ms = [zoh.design(plant, n, {"wc": 1, "pm_deg": 60}, dt=0.1).margins.ms for n in ("pd", "lead")]
    asked = zoh.Requirements(ms=min(ms) - 1e-3)
    d = zoh.design(plant, "auto", {"wc": 1, "pm_deg": 60}, dt=0.1, requirements=asked)
    assert d.law == "lead"
    assert fastest(d) > 6 / 0.1
    assert list(dict(d.choice.tried)) == ["p", "pi", "pd", "lag", "pid", "leadlag"]
    assert RINGS in d.choice.notes


def test_no_lead_that_does_not_ring_is_left_out():
    """Random leads, their corners drawn and their poles below 6/dt, are points; no point rings."""
    dt, rng, seen = 0.1, np.random.default_rng(8), 0
    plant = zoh.sample(ARM, dt)
    for _ in range(2000):
        w0, wp = np.sort(np.exp(rng.uniform(log(1e-2), log(6 / dt), 2))).tolist()
        wc = exp(rng.uniform(log(0.05), log(25)))
        v = 2 / dt * tan(wc * dt / 2)
        if w0 < 1.001 * SLOWEST * v:
            continue
        shape = Sampled.from_w(num_w=(wp / w0, wp), den_w=(1.0, wp), dt=dt)
        turned = degrees(atan(v / w0) - atan(v / wp))
        pm = turned + 180 + degrees(np.angle(plant.at(wc)))
        if not 31 < pm < 178 or wp < 1.02 * w0:
            continue
        freedom = Freedom.of("lead", plant, wc, {}, 30.0, calm=True)
        assert freedom.pm[0] <= pm <= freedom.pm[1]
        x = ((pm - freedom.pm[0]) / (freedom.pm[1] - freedom.pm[0])) ** (2 / 3)
        low, high = sorted(freedom.parameters((x, e))["dc_gain"] for e in (0.0, 1.0))
        # 1 %: a ten-thousandth of the range at either end is left out
        assert 0.99 * low <= 1 / abs(shape.at(wc) * plant.at(wc)) <= 1.01 * high
        for point in ((x, 0.0), (x, 1.0), (1.0, 1.0), (0.0, 1.0)):
            found = freedom.parameters(point)
            law = solved("lead", plant, Crossover(wc=wc, pm_deg=found["pm_deg"]), found)
            # 1e-6: the pole is from a difference that a small turn makes small
            assert law.gains["wp"] <= 6 / dt * (1 + 1e-6)
        seen += 1
    assert seen > 100


@pytest.mark.parametrize(
    ("den", "told"),
    [
        ([1, 0.9888], ["-0.9888"]),
        ([1, 1], ["-1"]),  # Tustin's derivative: it never dies out
        ([1, 1.6, 0.64], ["-0.8", "-0.8"]),  # twice
        ([1, 0.45], []),
        ([1, -0.95], []),
        ([1, 0, 0.9], []),  # a pair at +-0.95j, a quarter of the clock
    ],
)
def test_a_given_controllers_pole_is_noted(den, told):
    plant = zoh.Plant(num=[1], den=[1, 1])
    controller = Sampled(num=[0.01], den=den, dt=0.1)
    said = zoh.measure(plant, controller).report().splitlines()
    notes = [line.strip() for line in said if "rings" in line]
    assert notes == [
        f"NOTE: a pole of the controller at z = {z} rings at every sample" for z in told
    ]


def test_a_law_and_its_sections_are_noted_once_each():
    """Two poles of a section at w = -20 tan(30 0.1/2) each: at z = (1 - tan 1.5)/(1 + tan 1.5)."""
    section = zoh.SecondOrder(zeros_w0=28.0, zeros_zeta=0.5, poles_w0=30.0, poles_zeta=1.0)
    d = zoh.pd(ARM, dt=0.1, wc=0.5, pm_deg=70, filter_pole=380.0, sections=[section])
    said = [line.removeprefix("  NOTE: ") for line in d.report().splitlines() if "rings" in line]
    named = "filter_pole = 380 is far above 2/dt = 20: its pole at z = -0.9 rings at every sample"
    z = (1 - tan(1.5)) / (1 + tan(1.5))
    other = f"a pole of the controller at z = {z:.4g} rings at every sample"
    assert said == [named, other, other]


def test_a_ringing_pole_is_noted_on_a_table_too():
    w = np.geomspace(0.01, pi / 0.1, 300)
    seen = zoh.sample(MOTOR, 0.1).at(w)
    angle = np.degrees(np.unwrap(np.angle(seen)))
    table = zoh.FrequencyResponse(w=w, magnitude=np.abs(seen), phase_deg=angle, dt=0.1)
    d = zoh.lead(table, dt=0.1, wc=1, pm_deg=60, dc_gain=1.34)
    z = (1 - d.gains["wp"] / 20) / (1 + d.gains["wp"] / 20)
    assert z < -0.5
    named = f"wp = {d.gains['wp']:g} is far above 2/dt = 20: its pole at z = {z:.4g} rings"
    assert f"note: {named}" in d.report()
