"""Laws on tables: as asked at wc, near the design on the model, refused where nothing is known."""

from cmath import phase
from math import degrees, exp, inf, pi

import numpy as np
import pytest

import zoh
from zoh import FrequencyResponse, Requirements
from zoh.errors import Infeasible, NotMet, SpecError

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
DT = 0.1


def arm_at(w):
    """Return the arm behind its hold by the textbook's z-transform of k/(s (s + a))."""
    k, a, z = 2.3 * 12 / 180, 0.7809, np.exp(1j * w * DT)
    e = exp(-a * DT)
    return k * (DT / (a * (z - 1)) - (1 - e) / (a * a * (z - e)))


def arm_table(count=80, **more):
    w = np.geomspace(0.01, 30, count)
    return FrequencyResponse.from_complex(w=w, gain=arm_at(w), dt=DT, **more)


ASKED = {
    "p": {"wc": 0.8537977, "pm_deg": 40},
    "pi": {"wc": 0.8, "pm_deg": 40},
    "pd": {"wc": 3.0, "pm_deg": 50},
    "pid": {"wc": 1.95, "pm_deg": 40, "ki": 0.85},
    "lag": {"wc": 0.6, "pm_deg": 40, "dc_gain": 10.0},
    "lead": {"wc": 2.5, "pm_deg": 40, "dc_gain": 10.0},
}


@pytest.mark.parametrize("law", [law for law in ASKED if law != "p"])
def test_each_law_is_exact_on_the_table_and_near_the_model(law):
    table = arm_table()
    d = getattr(zoh, law)(table, dt=DT, **ASKED[law])
    wc, pm_deg = ASKED[law]["wc"], ASKED[law]["pm_deg"]
    loop = d.controller.at(wc) * table.at(wc)
    assert abs(loop) == pytest.approx(1.0, abs=1e-12)
    assert degrees(phase(-loop)) == pytest.approx(pm_deg, abs=1e-9)
    assert d.margins.phase_margin_deg == pytest.approx(pm_deg, abs=1e-9)
    assert d.margins.crossover == pytest.approx(wc, rel=1e-9)
    assert d.margins.stable is True
    assert isinstance(d, zoh.TableVerified)
    assert d.step is None
    # the truth is the plant's own formula at wc. The table's spacing is h = 0.1, and three
    # corners leave its curve off by 3 * 0.0963 h^3/12 = 2.4e-5, so 0.003 deg with the slopes
    true_loop = d.controller.at(wc) * arm_at(wc)
    assert degrees(phase(-true_loop)) == pytest.approx(pm_deg, abs=0.003)


def test_a_p_takes_the_fastest_crossover_that_holds():
    d = zoh.p(arm_table(), dt=DT, pm_deg=40)
    wc = d.margins.crossover
    assert degrees(phase(-arm_at(wc))) == pytest.approx(40, abs=0.003)  # as above
    assert d.gains["kp"] == pytest.approx(1 / abs(arm_at(wc)), rel=3e-5)
    by_wc = zoh.p(arm_table(), dt=DT, wc=1.0)
    assert by_wc.margins.crossover == pytest.approx(1.0, rel=1e-9)


def test_a_p_without_its_margin_anywhere_says_what_is_missing():
    with pytest.raises(Infeasible, match="at no frequency of its table") as refused:
        zoh.p(arm_table(), dt=DT, pm_deg=120)
    # the least lag is at the table's low end: -90 deg - 0.01/0.7809 rad - 0.01 DT/2
    lag_deg = 90 + degrees(np.arctan(0.01 / 0.7809) + 0.01 * DT / 2)
    assert refused.value.needed_deg == pytest.approx(120 - 180 + lag_deg, abs=1e-3)


def test_a_refusal_says_where_and_what_in_the_band():
    with pytest.raises(Infeasible) as refused:
        zoh.lag(arm_table(), dt=DT, wc=3.29, pm_deg=40, dc_gain=10)
    e = refused.value
    assert e.needed_deg == pytest.approx(40 - 180 - degrees(np.angle(arm_at(3.29))), abs=0.003)
    assert set(e.laws_that_can) == {"pd", "pid", "lead"}
    assert zoh.lag(arm_table(), dt=DT, wc=e.nearest_wc, pm_deg=40, dc_gain=10).margins.stable


def test_a_crossover_outside_the_table_is_refused_with_its_band():
    with pytest.raises(SpecError, match=r"wc must be inside the table, 0.01 to 30 rad/s, got 30.5"):
        zoh.pi(arm_table(), dt=DT, wc=30.5, pm_deg=40)
    with pytest.raises(SpecError, match="wc must be below the Nyquist frequency"):
        zoh.pi(arm_table(), dt=DT, wc=40.0, pm_deg=40)


def test_the_nearest_crossover_stays_inside_the_table():
    w = np.geomspace(2.0, 20, 60)  # the arm's PI would have to go below 1 rad/s
    table = FrequencyResponse.from_complex(w=w, gain=arm_at(w), dt=DT)
    with pytest.raises(Infeasible) as refused:
        zoh.pi(table, dt=DT, wc=3.0, pm_deg=40)
    assert refused.value.nearest_wc is None


def test_requirements_are_checked_and_steps_are_not_known():
    table = arm_table()
    ask = ASKED["pid"]
    met = Requirements(pm_deg=39.9, ms=1.7, gain_margin_db=10, delay_margin=0.3, mt=1.6)
    assert zoh.pid(table, dt=DT, **ask, requirements=met).met
    with pytest.raises(NotMet, match=r"ms must be at most 1.2, measured 1.57") as missed:
        zoh.pid(table, dt=DT, **ask, requirements=Requirements(ms=1.2))
    assert missed.value.measured.margins.crossover == pytest.approx(1.95, rel=1e-9)
    with pytest.raises(NotMet) as missed:
        zoh.pid(table, dt=DT, **ask, requirements=Requirements(overshoot_pct=50, rise_time=9.0))
    assert missed.value.misses == (
        "overshoot_pct is asked, and a table of margins does not show it",
        "rise_time is asked, and a table of margins does not show it",
    )


def test_what_is_met_in_the_band_only_is_a_miss():
    # 1/s, sampled slowly and known up to |L| = 1/2: Ms outside is bounded by 2 only
    w = np.geomspace(0.05, 2.0, 40)
    plant = FrequencyResponse.from_complex(w=w, gain=1 / (1j * w), dt=DT)
    one = zoh.Sampled(num=[1.0], den=[1.0], dt=DT)
    for asked in (Requirements(ms=1.5), Requirements(gain_margin_db=8), Requirements(mt=0.9)):
        with pytest.raises(NotMet):
            zoh.verify_table(plant, one, requirements=asked)
    with pytest.raises(NotMet, match=r"ms must be at most 1.5, .* no more than 2 is known"):
        zoh.verify_table(plant, one, requirements=Requirements(ms=1.5))
    assert zoh.verify_table(plant, one, requirements=Requirements(ms=2.1, gain_margin_db=5.9)).met


def test_an_unstable_and_an_undecided_loop_are_not_verified():
    with pytest.raises(NotMet, match="the closed loop is unstable"):
        zoh.verify_table(arm_table(), zoh.Sampled(num=[300.0], den=[1.0], dt=DT))
    short = FrequencyResponse(w=[0.1, 0.2, 0.4], magnitude=[9, 4, 2], phase_deg=[-95] * 3, dt=DT)
    with pytest.raises(NotMet, match="the table does not decide stability"):
        zoh.verify_table(short, zoh.Sampled(num=[1.0], den=[1.0], dt=DT))


def test_another_crossover_of_smaller_margin_is_not_what_was_asked():
    # a resonance above the crossover lifts |L| over 1 again, at a margin of its own
    w = np.geomspace(0.05, 30, 2000)
    s = 1j * w
    gain = 1 / s * 400 / (s * s + 0.4 * s + 400) * np.exp(-0.05 * s)
    plant = FrequencyResponse.from_complex(w=w, gain=gain, dt=DT)
    with pytest.raises(NotMet):
        zoh.p(plant, dt=DT, wc=1.0)
    with pytest.raises(NotMet):
        zoh.pi(plant, dt=DT, wc=1.0, pm_deg=60)


def test_verified_evidence_cannot_be_made_up():
    d = zoh.pi(arm_table(), dt=DT, **ASKED["pi"])
    fields = {name: getattr(d, name) for name in zoh.TableMeasured.__dataclass_fields__}
    assert zoh.TableVerified(**fields).margins is d.margins
    other = zoh.Sampled(num=[1.0], den=[1.0], dt=DT)
    with pytest.raises(NotMet, match="the evidence is not this loop's"):
        zoh.TableVerified(**{**fields, "controller": other})
    with pytest.raises(NotMet, match=r"ms must be at most 1\.01"):
        zoh.TableVerified(**{**fields, "requirements": Requirements(ms=1.01)})


def test_a_continuous_table_is_sampled_on_the_way():
    w = np.geomspace(0.01, 3000, 2000)
    k, a = 2.3 * 12 / 180, 0.7809
    table = FrequencyResponse.from_complex(w=w, gain=k / (1j * w * (1j * w + a)))
    d = zoh.pid(table, dt=DT, compute_delay=0.03, wc=1.95, pm_deg=40, ki=0.85)
    model = zoh.pid(ARM, dt=DT, compute_delay=0.03, wc=1.95, pm_deg=40, ki=0.85)
    # the curve's error at h = 0.006 is 3 * 0.0963 h^3/12 = 5e-9, and 1e-9 is left out at wc
    for name, value in model.gains.items():
        assert d.gains[name] == pytest.approx(value, rel=1e-6)
    assert d.sampled.dt == DT
    assert d.plant.dt is None


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"dt": 0.2}, "dt must be the table's 0.1 s, got 0.2"),
        ({"dt": 0.1, "compute_delay": 0.05}, "compute_delay must be 0: a sampled table has its"),
    ],
)
def test_a_sampled_table_has_one_clock_and_its_delay(more, says):
    with pytest.raises(SpecError, match=says):
        zoh.pi(arm_table(), **more, wc=0.8, pm_deg=40)


@pytest.mark.parametrize(
    ("plant", "controller", "requirements", "says"),
    [
        (ARM, None, None, "plant must be a zoh.FrequencyResponse"),
        (None, "PI", None, "controller must be a zoh.Sampled"),
        (None, None, {"ms": 2}, "requirements must be zoh.Requirements"),
    ],
)
def test_wrong_types_are_named(plant, controller, requirements, says):
    with pytest.raises(SpecError, match=says):
        zoh.measure_table(
            plant or arm_table(),
            controller or zoh.Sampled(num=[1.0], den=[1.0], dt=DT),
            requirements=requirements,
        )


def test_the_report_says_what_it_rests_on():
    d = zoh.pid(arm_table(uncertainty=0.001), dt=DT, **ASKED["pid"])
    text = d.report()
    assert "closed loop stable" in text
    assert "taken for granted: the plant has no unstable poles" in text
    assert "1 sigma of the points is, to first order, 1 sigma of PM, GM and Ms" in text
    out = d.to_dict()
    assert out["step"] is None
    assert out["margins"]["stable"] is True
    assert out["gains"] == dict(d.gains)
    assert inf not in out["margins"].values()
    assert d.loop.at(1.95) == d.controller.at(1.95) * d.sampled.at(1.95)
    assert d.dt == DT
    assert pi / DT > d.margins.band[1]


def test_a_crossing_of_the_controller_below_the_table_counts_against_the_margin():
    # a flat plant of 0.5 and an integrator: |L| passes 1 below the table, at -90 deg, by 0.5/w
    plant = FrequencyResponse(w=[2, 3, 5, 8, 12], magnitude=[0.5] * 5, phase_deg=[0] * 5, dt=DT)
    law = zoh.Sampled.from_w(num_w=[1.0], den_w=[1.0, 0.0], dt=DT)
    found = zoh.measure_table(plant, law)
    assert found.margins.gain_crossings == ()
    assert found.margins.beyond.phase_margin_deg == pytest.approx(90.0, abs=1e-9)
    assert zoh.verify_table(plant, law, requirements=Requirements(pm_deg=89)).met
    with pytest.raises(NotMet, match=r"pm_deg must be at least 95, .* no more than 90 is known"):
        zoh.verify_table(plant, law, requirements=Requirements(pm_deg=95))


def test_a_p_with_several_crossovers_takes_the_fastest():
    # the phase is -140 deg at 1, 3 and 9 rad/s, points of the table; |G| = 1/w falls throughout
    plant = FrequencyResponse(
        w=[0.2, 0.5, 1, 2, 3, 5, 9, 15, 25],
        magnitude=[1 / w for w in (0.2, 0.5, 1, 2, 3, 5, 9, 15, 25)],
        phase_deg=[-100, -120, -140, -150, -140, -130, -140, -150, -155],
        dt=DT,
    )
    d = zoh.p(plant, dt=DT, pm_deg=40)
    assert d.margins.crossover == pytest.approx(9.0, rel=1e-9)
    assert d.gains["kp"] == pytest.approx(9.0, rel=1e-9)


@pytest.mark.parametrize("given", [{"wc": 0.8}, {"pm_deg": 40}])
def test_a_p_of_a_negative_gain_where_that_is_allowed(given):
    table = arm_table()
    turned = FrequencyResponse.from_complex(w=table.w, gain=-arm_at(table.w), dt=DT)
    there = zoh.p(table, dt=DT, **given)
    with pytest.raises((Infeasible, NotMet)):
        zoh.p(turned, dt=DT, **given)
    d = zoh.p(turned, dt=DT, **given, allow=["negative_gains"])
    # the same loop: -k of -G; the angles of its table are rounded a half turn away
    assert d.gains["kp"] == pytest.approx(-there.gains["kp"], rel=1e-9)
    assert d.margins.phase_margin_deg == pytest.approx(there.margins.phase_margin_deg, abs=1e-9)


def test_a_p_on_a_table_that_crosses_over_elsewhere_with_less_is_refused():
    plant = zoh.Plant.parse("1.8697/(s^4 + 3.4493 s^3 + 144.38 s^2 + 354.75 s)")
    w, dt = np.geomspace(0.01, 200, 4000), 0.0151
    table = FrequencyResponse.from_complex(w=w, gain=zoh.sample(plant, dt).at(w), dt=dt)
    with pytest.raises(NotMet, match=r"at 10\.8\d+ rad/s, another crossover of this loop"):
        zoh.p(table, dt=dt, wc=4.963)
