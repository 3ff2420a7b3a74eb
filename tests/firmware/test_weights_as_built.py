"""What is said of a weighted reference as built is what the lines do, run in the loop."""

import numpy as np
import pytest

import zoh
from zoh.analysis.realised import realised
from zoh.firmware.c import emit
from zoh.firmware.model import Model

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
SAMPLES = 400
CASES = [
    (zoh.pid, {"wc": 1.95, "pm_deg": 40, "ki": 0.85}, 0.5, 0.0),
    (zoh.pid, {"wc": 1.95, "pm_deg": 40, "ki": 0.85}, 0.3, 0.4),
    (zoh.pi, {"wc": 0.6, "pm_deg": 40}, 0.0, None),
    (zoh.pd, {"wc": 1.9, "pm_deg": 60}, 0.7, 0.0),
    (zoh.p, {"wc": 0.8}, 0.6, None),
]


def weighted(law, asked, b, c):
    weights = {"setpoint_weight": b} | ({} if c is None else {"derivative_weight": c})
    return law(ARM, dt=0.1, **asked, **weights)


def in_the_loop(plan):
    """Return y and u, sample by sample, of the model with the sampled plant, for a step of 1."""
    a, c, _ = realised(plan.design.sampled)
    model, x, ys, us = Model(plan), np.zeros(len(a)), [], []
    y_unit, u_unit = float(plan.format.y_unit), float(plan.format.u_unit)
    given = (lambda v: round(v / y_unit)) if plan.format.whole else float
    for _ in range(SAMPLES):
        ys.append(float(np.dot(c, x)))
        us.append(float(model.step(given(1.0), given(ys[-1]), 0)) * u_unit)
        x = np.array([x[0] - np.dot(a, x) + us[-1], *(x[1:] + x[:-1])])
    return np.array(ys), np.array(us)


@pytest.mark.parametrize(("law", "asked", "b", "c"), CASES)
@pytest.mark.parametrize(
    ("number", "tolerance"),
    # what a rounding of every sample comes to in u, of its largest value: 2^-53, 2^-24, and the
    # step of y in q31 and q15 times the gain, some 2 to 60
    [("f64", 1e-12), ("f32", 1e-5), ("q31", 1e-6), ("q15", 1e-2)],
)
def test_the_effort_and_the_peak_as_built_are_those_of_the_lines(
    law, asked, b, c, number, tolerance
):
    d = weighted(law, asked, b, c)
    made = zoh.plan(d, number=number, y_range=(-2, 2), u_range=(-150, 150))
    built = made.quantised
    # q15: its gains have 16 bits and less
    assert built.setpoint_weight == pytest.approx(b, abs=1e-3)
    assert built.derivative_weight == pytest.approx(1.0 if c is None else c, abs=1e-3)
    ys, us = in_the_loop(made)
    assert np.abs(us).max() == pytest.approx(built.step.peak_effort, rel=tolerance)
    # a peak that is crept up to has not been reached at the end
    assert ys.max() <= built.step.peak * (1 + tolerance)
    if built.step.overshoot_pct:
        assert ys.max() == pytest.approx(built.step.peak, rel=tolerance)
    without = zoh.verify(ARM, built.controller).step
    assert abs(without.peak_effort - built.step.peak_effort) > 0.05 * without.peak_effort


def test_the_header_says_the_step_of_the_weighted_reference():
    d = weighted(*CASES[1])
    header = emit(zoh.plan(d))["controller.h"]
    (line,) = [x for x in header.splitlines() if "designed: overshoot" in x]
    assert line.count(f"{d.step.overshoot_pct:.5g} %") == 2


def test_a_bound_that_only_the_weighted_reference_keeps_is_kept_as_built():
    plain = zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ki=0.85).step.overshoot_pct
    asked = zoh.Requirements(overshoot_pct=plain / 2)
    d = zoh.pid(
        ARM, dt=0.1, wc=1.95, pm_deg=40, ki=0.85, setpoint_weight=0.3, derivative_weight=0.0,
        requirements=asked,
    )  # fmt: skip
    assert zoh.plan(d, number="q15", y_range=(-2, 2), u_range=(-20, 20)).quantised.met
    with pytest.raises(zoh.NotMet, match="overshoot_pct"):
        zoh.plan(d, setpoint_weight=1.0, derivative_weight=1.0)
