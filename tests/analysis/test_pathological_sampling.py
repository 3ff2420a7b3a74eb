"""Modes that a hold hides, or all but hides, and crossings beside them that no float tells.

By hand, with 1/(s (s^2 + 1)) = 1/s - s/(s^2 + 1) and T = dt:

    G(z) = T/(z - 1) - (z - 1) sin T/(z^2 - 2 z cos T + 1)

whose zeros are on the unit circle, where cos x = (T cos T - sin T)/(T - sin T).
"""

import warnings
from dataclasses import fields, replace
from math import pi, ulp

import pytest
from mpmath import acos, arg, cos, degrees, expj, findroot, mpf, sin, workdps

import zoh
from zoh.analysis.verify import Verified, measure
from zoh.sampling.pathological import hidden_by_hold

TWO_PI = 2 * pi
RINGING = zoh.Plant(num=[1], den=[1, 0, 1])
BOTH = zoh.Plant(num=[1], den=[1, 0, 1, 0])  # with an integrator
HIDES = (
    "the hold at dt = 6.28319 s all but hides the mode at 1 rad/s: w dt is 2 pi to twelve digits"
)


def gain(k: float, dt: float) -> zoh.Sampled:
    return zoh.Sampled(num=[k], den=[1], dt=dt)


def by_hand(k: float, dt: float):
    """Return the two (frequency, phase margin in deg) beside the zero that hides the mode."""
    t = mpf(dt)

    def loop(w):
        z = expj(w * t)
        return k * (t / (z - 1) - (z - 1) * sin(t) / (z * z - 2 * z * cos(t) + 1))

    zero = acos((t * cos(t) - sin(t)) / (t - sin(t))) / t
    found = []
    for side in (-1, 1):
        far, near = mpf("1e-25"), mpf("1e-60")  # of w: |L| passes 1 between, and not beyond
        for _ in range(400):
            middle = (far * near) ** 0.5
            if abs(loop(zero * (1 + side * middle))) > 1:
                far = middle
            else:
                near = middle
        w = zero * (1 + side * far)
        found.append((w, degrees(arg(-loop(w)))))
    return found


def test_two_crossings_that_are_one_float_are_told_apart_and_verified():
    k = 0.1
    with workdps(120):
        truth = [(float(w), float(pm)) for w, pm in by_hand(k, TWO_PI)]
    with pytest.warns(zoh.AccuracyWarning, match=HIDES):
        found = zoh.verify(BOTH, gain(k, TWO_PI))
    crossings = found.margins.gain_crossings
    assert len(crossings) == 3
    for (w, pm), (right, right_pm) in zip(crossings[:2], truth, strict=True):
        assert abs(w - right) <= ulp(right)
        assert pm == pytest.approx(right_pm, abs=1e-9)
    assert crossings[0][1] > 0 > crossings[1][1]
    assert found.margins.certificate.holds
    assert len(found.margins.warnings) == 1


@pytest.mark.parametrize("k", [1e-12, 1e-14])
def test_a_crossing_beside_an_undamped_pole_is_evidence(k):
    plant, dt = zoh.Plant(num=[1, 1], den=[1, 0, 1]), 0.1
    found = zoh.verify(plant, gain(k, dt)).margins.gain_crossings
    with workdps(60):
        t = mpf(dt)

        def loop(w):  # 1/(s^2 + 1) and s/(s^2 + 1) behind the hold
            z = expj(w * t)
            over = z * z - 2 * z * cos(t) + 1
            return mpf(k) * ((1 - cos(t)) * (z + 1) + sin(t) * (z - 1)) / over

        for w, pm in found:
            exact = findroot(lambda x: 1 / abs(loop(x)) - 1, mpf(w), tol=1e-40)
            assert abs(exact - w) <= ulp(w)
            assert pm == pytest.approx(float(degrees(arg(-loop(exact)))), abs=1e-9)


@pytest.mark.parametrize("moved", [(0.0, 1e-4), (1e-14, 0.0)])
def test_what_is_no_crossing_beside_an_undamped_pole_is_no_evidence(moved):
    found = measure(zoh.Plant(num=[1, 1], den=[1, 0, 1]), gain(1e-12, 0.1))
    (w, pm), *rest = found.margins.gain_crossings
    forged = ((w + moved[0], pm + moved[1]), *rest)
    margins = replace(found.margins, gain_crossings=forged)
    parts = {f.name: getattr(found, f.name) for f in fields(found)}
    with pytest.raises(zoh.NotMet, match="the evidence is not this loop's"):
        Verified(**parts | {"margins": margins})


def test_gains_out_of_all_proportion_are_not_silent():
    with pytest.warns(zoh.AccuracyWarning, match=HIDES):
        found = zoh.pd(RINGING, wc=0.0159, pm_deg=60, dt=TWO_PI)
    assert found.gains["kp"] > 1e28
    assert HIDES in found.report()
    with pytest.raises(zoh.Infeasible, match=HIDES) as refused:
        zoh.pi(RINGING, wc=0.0159, pm_deg=60, dt=TWO_PI)
    assert str(refused.value).count("all but hides") == 1


def test_what_is_missed_names_the_mode():
    match = r"all but hides the mode at 1 rad/s: w dt is pi to twelve digits.*below 2 s none"
    with pytest.warns(zoh.AccuracyWarning), pytest.raises(zoh.NotMet, match=match):
        zoh.verify(BOTH, gain(0.1, pi))
    # the dip at the hidden mode crosses 1 with no margin: strictly, the PI is refused
    with pytest.warns(zoh.AccuracyWarning), pytest.raises(zoh.NotMet, match=HIDES):
        zoh.pi(BOTH, wc=0.05, pm_deg=50, dt=TWO_PI)


@pytest.mark.parametrize(
    ("den", "dt", "said"),
    [
        # |w dt - k pi|, by hand; two poles in z are twice that apart
        ([1, 0, 1], pi - 4e-4, ("the mode at 1 rad/s: w dt is pi but for 0.0004 rad",)),
        ([1, 0, 1], pi - 6e-4, ()),
        ([1, 0, 1], 3 * pi + 4e-4, ("the mode at 1 rad/s: w dt is 3 pi but for 0.0004 rad",)),
        ([1, 0, 1], 1.0, ()),
        # (s^2 + 1)(s^2 + 9): 3 - 1 = 2 and 3 + 1 = 4, and each alone has w dt = k pi at pi
        ([1, 0, 10, 0, 9], pi / 2, ("one of the modes at 1 and 3 rad/s: the sum of w dt is 2 pi",)),
        # s^2 + 2 s + 5: -1 +- 2j, damped by exp(-pi/2) a sample
        ([1, 2, 5], pi / 2, ("the mode at 2 rad/s: w dt is pi to twelve digits",)),
        # s^2 + 20 s + 101: -10 +- j has died by the next sample
        ([1, 20, 101], pi, ()),
        # -7.5/pi +- j: exp(-7.5) of it is left, and of -6.5/pi +- j exp(-6.5)
        ([1, 15 / pi, (7.5 / pi) ** 2 + 1], pi, ()),
        ([1, 13 / pi, (6.5 / pi) ** 2 + 1], pi, ("the mode at 1 rad/s: w dt is pi",)),
        ([1, 3, 2], 100.0, ()),  # real poles are like no others
        # (s^2 + 1)^2: one mode, twice
        ([1, 0, 2, 0, 1], pi, ("the mode at 1 rad/s: w dt is pi but for",)),
    ],
)
def test_the_modes_that_are_named(den, dt, said):
    found = hidden_by_hold(zoh.Plant(num=[1], den=den), dt)
    assert len(found) == len(said)
    for sentence, part in zip(found, said, strict=True):
        assert part in sentence


def test_an_ordinary_loop_is_not_warned_of():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        zoh.verify(zoh.Plant(num=[1], den=[1, 0.1, 1]), gain(0.1, 0.1))


def test_a_gain_beside_a_held_plant_is_not_called_a_loss_in_z():
    # 1/(s^2 + 1) at 2 pi is (z + 1)/(z - 1)^2 times next to nothing: with a gain, next to the limit
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        measure(RINGING, gain(0.1, TWO_PI))
    said = [str(w.message) for w in caught]
    assert any(s.startswith("by the rounding of the given gain alone") for s in said)
    assert not any("from its parameters" in s for s in said)
