"""A PID's spare freedom: by a ratio, by the largest ki under Ms, by the least IAE under Ms.

The searches are checked by roads of their own: Ms on a dense grid in z with plain complex
arithmetic, and the load's response by its difference equation.
"""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import zoh

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
LATE = zoh.Plant(num=[1.0], den=[1, 1], dead_time=0.3)
CASES = [(ARM, 0.1, 1.95, 40.0), (LATE, 0.1, 1.2, 60.0), (ARM, 0.01, 3.0, 55.0)]


def poles_and_peak(d):
    """Return (largest |pole|, Ms) of d's loop from its z-coefficients; dt is 1e-2 or more."""
    num = np.polymul(d.controller.num, d.sampled.num)
    den = np.polymul(d.controller.den, d.sampled.den)
    z = np.exp(1j * np.geomspace(1e-4, pi, 100_001))
    peak = np.abs(np.polyval(den, z) / (np.polyval(den, z) + np.polyval(num, z))).max()
    return np.abs(np.roots(np.polyadd(den, num))).max(), peak


def with_ki(case, ki, **more):
    plant, dt, wc, pm_deg = case
    try:
        return zoh.pid(plant, dt=dt, wc=wc, pm_deg=pm_deg, ki=ki, **more)
    except (zoh.Infeasible, zoh.NotMet):
        return None


def load_iae(d):
    """Return dt sum |y| after a load step, y from the difference equation of G/(1 + D G)."""
    num = np.polymul(d.controller.den, d.sampled.num)
    den = np.polyadd(
        np.polymul(d.controller.den, d.sampled.den), np.polymul(d.controller.num, d.sampled.num)
    )
    num = np.concatenate([np.zeros(len(den) - len(num)), num]) / den[0]
    den, y = den / den[0], []
    for k in range(6000):
        fed = num[: k + 1].sum()
        y.append(fed - sum(a * y[k - i] for i, a in enumerate(den) if 0 < i <= k))
    return d.dt * float(np.abs(y).sum())


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("filter_pole", [None, 12.0])
def test_the_ratio_is_kept_and_so_is_the_target(case, filter_pole):
    plant, dt, wc, pm_deg = case
    for ti_td in (2.5, 4.0, 16.0):
        d = zoh.pid(plant, dt=dt, wc=wc, pm_deg=pm_deg, ti_td=ti_td, filter_pole=filter_pole)
        g = d.gains
        assert g["kp"] ** 2 / (g["ki"] * g["kd"]) == pytest.approx(ti_td, rel=1e-11)
        assert d.forms["standard"]["ti"] / d.forms["standard"]["td"] == pytest.approx(
            ti_td, rel=1e-11
        )
        assert d.margins.phase_margin_deg == pytest.approx(pm_deg, abs=1e-9)
        assert d.margins.crossover == pytest.approx(wc, rel=1e-9)


@given(st.floats(0.3, 40), st.floats(0.3, 100))
@settings(max_examples=40)
def test_any_filter_pole_is_solved_exactly(ratio, pole):
    try:
        d = zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ti_td=ratio, filter_pole=pole)
    except (zoh.Infeasible, zoh.NotMet):
        return
    g, z = d.gains, np.exp(1.95j * 0.1)
    w = 20 * (z - 1) / (z + 1)
    law = g["kp"] + g["ki"] / w + g["kd"] * w / (1 + w / pole)
    assert d.controller.at(1.95) == pytest.approx(law, rel=1e-12)
    assert g["filter_pole"] == pole
    assert min(g.values()) > 0
    assert d.margins.phase_margin_deg == pytest.approx(40, abs=1e-9)


def test_two_over_dt_is_what_is_meant_where_nothing_is_said():
    for dt in (0.1, 0.003, 7e-6):
        said = zoh.pd(ARM, dt=dt, wc=2.0, pm_deg=50, filter_pole=2 / dt)
        left = zoh.pd(ARM, dt=dt, wc=2.0, pm_deg=50)
        assert said.to_dict() == left.to_dict()
        assert left.controller.den[-1] == 0.0  # the pole is at z = 0 to the last bit


@pytest.mark.parametrize("case", CASES)
def test_no_larger_ki_is_under_the_bound(case):
    plant, dt, wc, pm_deg = case
    bound = 1.8
    d = zoh.pid(plant, dt=dt, wc=wc, pm_deg=pm_deg, largest_ki_ms=bound)
    radius, peak = poles_and_peak(d)
    assert radius < 1
    assert peak <= bound * (1 + 1e-9)
    for ki in np.geomspace(1 + 1e-5, 50, 100) * d.gains["ki"]:
        other = with_ki(case, ki)
        # 1e-7: the grid of frequencies is below the peak by that much
        assert other is None or poles_and_peak(other)[1] > bound * (1 - 1e-7)


@pytest.mark.parametrize("case", CASES)
def test_no_other_ki_has_less_iae_under_the_bound(case):
    plant, dt, wc, pm_deg = case
    d = zoh.pid(plant, dt=dt, wc=wc, pm_deg=pm_deg, least_iae_ms=1.8)
    least = load_iae(d)
    assert poles_and_peak(d)[1] <= 1.8 * (1 + 1e-9)
    tried = 0
    for ki in np.geomspace(0.75, 1.5, 25) * d.gains["ki"]:
        other = with_ki(case, ki, requirements=zoh.Requirements(ms=1.8))
        if other is not None:
            tried += 1
            assert load_iae(other) >= least * (1 - 1e-9)
    assert tried > 5


def test_the_bound_is_met_by_the_requirement_too():
    d = zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, largest_ki_ms=1.7)
    assert d.requirements.ms == 1.7
    asked = zoh.Requirements(ms=1.5)
    with pytest.raises(zoh.NotMet, match=r"ms must be at most 1\.5"):
        zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, largest_ki_ms=1.7, requirements=asked)


def test_under_a_bound_below_what_the_margin_allows_there_is_none():
    # Ms is 1/(2 sin(pm/2)) = 1.46 at least
    for how in ("largest_ki_ms", "least_iae_ms"):
        with pytest.raises(zoh.Infeasible, match=r"Ms at most 1\.4"):
            zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, **{how: 1.4})


@pytest.mark.parametrize("how", ["ti_td", "largest_ki_ms"])
def test_a_phase_beyond_any_pid_is_refused_with_the_interval(how):
    with pytest.raises(zoh.Infeasible, match=r"turns the phase by -90 to \+") as refused:
        zoh.pid(ARM, dt=0.1, wc=15.0, pm_deg=60, **{how: 4.0})
    assert refused.value.needed_deg > 60


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"ki": 1.0, "ti_td": 4.0}, "ti_td must not be given beside ki"),
        ({"largest_ki_ms": 1.5, "least_iae_ms": 1.5}, "least_iae_ms must not be given beside"),
        ({"largest_ki_ms": 1.0}, "largest_ki_ms must be above 1"),
        ({"ki": 1.0, "filter_pole": 0.0}, "filter_pole must be above 0"),
    ],
)
def test_a_malformed_request_is_refused_by_name(more, words):
    with pytest.raises(zoh.SpecError, match=words):
        zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, **more)


def test_a_table_is_not_searched():
    table = zoh.FrequencyResponse.from_bode(
        hz=[0.1, 0.3, 1.0, 3.0], db=[0, -10, -20, -30], phase_deg=[-60, -90, -100, -120], dt=0.1
    )
    with pytest.raises(zoh.SpecError, match="must be searched on a model"):
        zoh.pid(table, dt=0.1, wc=3.0, pm_deg=60, largest_ki_ms=1.8)


def test_the_forms_travel_with_the_design():
    d = zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ki=0.85)
    out = d.to_dict()["forms"]
    assert out["parallel"] == dict(d.gains)
    assert out["series"]["ti"] > 4 * out["series"]["td"]
    assert "standard form: kp = " in d.report()
    assert "series form: k = " in d.report()
    assert zoh.lead(ARM, dt=0.1, wc=2.0, pm_deg=40, dc_gain=10).forms == {}


def test_the_best_margin_of_a_refusal_under_a_bound_is_had():
    # loops that take half a million samples to come to rest are among what it offers
    plant, request = zoh.Plant.parse("(s+2)/(s+1)"), {"dt": 0.001, "wc": 0.397987}
    with pytest.raises(zoh.Infeasible) as refused:
        zoh.pid(plant, pm_deg=20, least_iae_ms=2.03588, **request)
    best = refused.value.best_pm_deg - 1e-6  # the end itself is only approached
    d = zoh.pid(plant, pm_deg=best, least_iae_ms=2.03588, **request)
    assert d.margins.ms <= 2.03588
    assert d.margins.phase_margin_deg == pytest.approx(best, abs=1e-9)
