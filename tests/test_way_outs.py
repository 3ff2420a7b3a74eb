"""A way out that a refusal offers is one that is taken: as a number, and as it is printed."""

import re

import mpmath
import pytest

import zoh

DISTILLATION = zoh.Plant(num=[0.864], den=[75, 1], dead_time=30)
BUCK = zoh.Plant(num=[28.0], den=[25e-9, 50e-6 / 3, 1])
BOOST = zoh.Plant(num=[-48 * 50e-6 / 0.75, 48], den=[50e-6 * 500e-6 / 0.25, 50e-6 / 0.75, 1])
FAST = zoh.Plant(num=[1], den=[2e-19, 1.2e-9, 1], dead_time=1.5e-9)
BAND_PASS = zoh.Plant(num=[1, 0], den=[1, 2, 1])
BIPROPER = zoh.Plant(num=[1, 2], den=[1, 5])

# a share of Nyquist's frequency, a margin in deg: refused there, and what can be had instead ends
# where |L| is as flat as rounding bears, or at the end of the phases
REFUSED = [
    (BUCK, 1e-5, "pi", 0.003, 80, {}),
    (BUCK, 1e-5, "lag", 0.003, 45, {"dc_gain": 20}),
    (BUCK, 1e-5, "pid", 0.003, 5, {"ti_td": 4}),
    (BUCK, 1e-5, "leadlag", 0.003, 10, {"dc_gain": 20}),
    (BUCK, 1e-5, "lead", 0.9, 45, {"dc_gain": 0.5}),
    (BOOST, 1e-5, "pi", 0.003, 5, {}),
    (BOOST, 1e-5, "lag", 0.003, 80, {"dc_gain": 20}),
    (BOOST, 1e-5, "pid", 0.003, 45, {"ti_td": 4}),
    (BOOST, 1e-5, "pid", 0.05, 45, {"ki": 0.1}),
    (FAST, 1e-10, "pd", 0.06, 50, {}),
    (FAST, 1e-10, "pd", 0.8, 100, {}),
    (BAND_PASS, 0.1, "pd", 0.3, 10, {}),
    (BIPROPER, 0.1, "pid", 0.8, 10, {"ti_td": 4}),
]


def refusal(plant, dt, law, share, pm_deg, more):
    asked = {"wc": share * float(mpmath.pi) / dt, "pm_deg": pm_deg, **more}
    with pytest.raises(zoh.Infeasible) as refused:
        zoh.design(plant, law, asked, dt=dt)
    return refused.value, asked


def printed(refused, what, unit):
    (number,) = re.findall(rf"{what} is (\S+) {unit}", str(refused))
    return float(number)


@pytest.mark.parametrize(("plant", "dt", "law", "share", "pm_deg", "more"), REFUSED)
def test_what_is_offered_is_had(plant, dt, law, share, pm_deg, more):
    refused, asked = refusal(plant, dt, law, share, pm_deg, more)
    ways = []
    if refused.nearest_wc is not None:
        near = printed(refused, "the nearest crossover where it can", "rad/s")
        assert near == refused.nearest_wc  # no digit is left out that decides
        ways.append({"wc": near})
    if refused.best_pm_deg is not None:
        best = printed(refused, "the best margin it can give here", "deg")
        assert refused.best_pm_deg * (1 - 1e-3) < best <= refused.best_pm_deg
        ways += [{"pm_deg": refused.best_pm_deg}, {"pm_deg": best}]
    assert ways
    for way in ways:
        d = zoh.design(plant, law, {**asked, **way}, dt=dt)
        wanted = {**asked, **way}
        assert d.margins.crossover == pytest.approx(wanted["wc"], rel=1e-9)
        assert d.margins.phase_margin_deg == pytest.approx(wanted["pm_deg"], abs=1e-9)


@pytest.mark.filterwarnings("ignore::zoh.AccuracyWarning")  # 30 samples of delay, flat to 1e-6
def test_the_crossover_offered_to_a_distillation_column_is_one_in_fifty_digits():
    # G = 0.864 (1 - E)/(z - E) z^-30, E = exp(-1/75), and kp + kd (1 - 1/z)
    refused, asked = refusal(DISTILLATION, 1.0, "pd", 0.05, 5, {})
    wc = printed(refused, "the nearest crossover where it can", "rad/s")
    assert wc == refused.nearest_wc
    gains = zoh.pd(DISTILLATION, dt=1, wc=wc, pm_deg=5).gains
    with mpmath.workdps(50):
        z, e = mpmath.expj(mpmath.mpf(wc)), mpmath.exp(-mpmath.mpf(1) / 75)
        law = mpmath.mpf(gains["kp"]) + mpmath.mpf(gains["kd"]) * (1 - 1 / z)
        loop = law * mpmath.mpf(0.864) * (1 - e) / (z - e) * z**-30
        assert abs(abs(loop) - 1) < 1e-14
        assert abs(mpmath.degrees(mpmath.arg(-loop)) - 5) < 1e-12
    assert wc < asked["wc"]


@pytest.mark.filterwarnings("ignore::zoh.AccuracyWarning")  # as above
def test_where_rounding_moves_the_only_crossover_that_is_what_is_said():
    # |L| has one crossover there, which is the one asked for: 5.00000000102 deg is no other margin
    with pytest.raises(zoh.NotMet, match="rounded gains move its crossover") as missed:
        zoh.pd(DISTILLATION, dt=1, wc=0.09852319509692892, pm_deg=5)
    assert "another" not in str(missed.value)
    assert len(missed.value.measured.margins.gain_crossings) == 1


def test_the_crossover_offered_where_a_margin_is_left_open_is_printed_in_full():
    arm = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    asked = zoh.Requirements(ms=1.6)
    with pytest.raises(zoh.Infeasible) as refused:
        zoh.pi(arm, dt=0.1, wc=3.0, requirements=asked)
    near = printed(refused.value, "the nearest crossover where it can", "rad/s")
    assert near == refused.value.nearest_wc == float(f"{near:.7g}")
    assert zoh.pi(arm, dt=0.1, wc=near, requirements=asked).met
