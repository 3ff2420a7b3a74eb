"""Setpoint weights: the loop stays, the reference's path is another; against 50 digits.

The simulation below knows the textbook's law alone: three parts that see b r - y, r - y and
c r - y, a plant behind a hold moved by its exact exponentials, and mpmath. It has no state space,
no feedforward and no w-plane polynomials in common with the library.
"""

from dataclasses import replace

import mpmath
import numpy as np
import pytest

import zoh
from zoh.analysis.curves import trace

K, A, DT, PER = 2, 0.75, 0.1, 8  # K/(s (s + A)); PER points between samples
PLANT = zoh.Plant(num=[K], den=[1, A, 0])
ASKED = {"dt": DT, "wc": 1.5, "pm_deg": 50}
CASES = [
    ("pid", {"ki": 0.2}, 0.0, 0.0),
    ("pid", {"ki": 0.2, "filter_pole": 9.0}, 0.6, 0.25),
    ("pid", {"ki": 0.2, "filter_pole": 9.0}, 1.0, 0.0),
    ("pd", {}, 0.5, 0.0),
]


def simulated(gains, b, c, count, section=None):
    """Return (y between the samples, u at the samples) after a step of the reference, mpmath."""
    kp, ki, kd = (mpmath.mpf(gains.get(name, 0.0)) for name in ("kp", "ki", "kd"))
    h, tau = mpmath.mpf(DT), 1 / mpmath.mpf(gains.get("filter_pole", 2 / DT))
    if gains.get("filter_pole") == 2 / DT:
        tau = h / 2
    y = v = total = slope = before = error = mpmath.mpf(0)
    u_all, ys, s = [], [], Section(section)
    for k in range(count):
        now = 1 - y
        # ki/w: u = u + ki h/2 (e + e before); kd w/(1 + tau w), w = (2/h)(z - 1)/(z + 1)
        total += ki * h / 2 * (now + (error if k else 0))
        seen = c - y
        slope = ((2 * tau - h) * slope + 2 * kd * (seen - (before if k else 0))) / (2 * tau + h)
        u = s.next(kp * (b - y) + total + slope)
        error, before = now, seen
        u_all.append(u)
        for j in range(PER):
            ys.append(moved(y, v, u, h * j / PER)[0])
        y, v = moved(y, v, u, h)
    return ys, u_all


def moved(y, v, u, t):
    """Return position and speed of K/(s (s + A)) after t under a constant input."""
    a, rest = mpmath.mpf(A), K * u / mpmath.mpf(A)
    decay = mpmath.exp(-a * t)
    return y + rest * t + (v - rest) * (1 - decay) / a, rest + (v - rest) * decay


class Section:
    """A second-order section in z, by its difference equation; none passes everything."""

    def __init__(self, section):
        self.past = [(mpmath.mpf(0), mpmath.mpf(0))] * 2
        self.section = None
        if section is not None:
            made = section.at_clock(DT)
            lead = mpmath.mpf(made.den[0])
            self.section = [[mpmath.mpf(x) / lead for x in part] for part in (made.num, made.den)]

    def next(self, x):
        if self.section is None:
            return x
        num, den = self.section
        out = num[0] * x
        for i, (then_in, then_out) in enumerate(self.past, 1):
            out += num[i] * then_in - den[i] * then_out
        self.past = [(x, out), self.past[0]]
        return out


def followed(d, count):
    t = trace(
        d.plant, d.controller, t_end=(count - 1) * DT, per_sample=PER, feedforward=d.feedforward
    )
    y = t.y_between.reshape(count, -1)[:, :-1]  # the last point of a sample is the next one's first
    return y, t.u


@pytest.mark.parametrize(("law", "more", "b", "c"), CASES)
def test_the_step_is_that_of_the_weighted_law_at_and_between_samples(law, more, b, c):
    weights = {"setpoint_weight": b, "derivative_weight": c}
    d = zoh.design(PLANT, law, {"wc": 1.5, "pm_deg": 50, **more, **weights}, dt=DT)
    with mpmath.workdps(50):
        ys, us = simulated(d.gains, mpmath.mpf(b), mpmath.mpf(c), 120)
    y, u = followed(d, 120)
    got = y[:, :: max(1, y.shape[1] // PER)].ravel()
    assert np.abs(got - np.array([float(x) for x in ys])).max() < 1e-12
    assert np.abs(u - np.array([float(x) for x in us])).max() < 1e-11 * max(map(abs, us))
    assert d.step.peak_effort == pytest.approx(float(max(map(abs, us))), rel=1e-11)
    assert d.step.overshoot_pct == pytest.approx(
        max(0.0, 100 * float(max(ys[::PER]) / (1 if law == "pid" else b) - 1)), abs=1e-7
    )


def test_with_a_notch_in_series_the_weights_are_behind_it():
    notch = zoh.notch(w0=8.0, depth=0.2)
    d = zoh.pid(PLANT, ki=0.2, setpoint_weight=0.3, derivative_weight=0, sections=[notch], **ASKED)
    with mpmath.workdps(50):
        ys, us = simulated(d.gains, mpmath.mpf(0.3), mpmath.mpf(0), 120, notch)
    y, u = followed(d, 120)
    got = y[:, :: max(1, y.shape[1] // PER)].ravel()
    # 1e-10: the simulation takes the notch's z-coefficients, which are rounded
    assert np.abs(got - np.array([float(x) for x in ys])).max() < 1e-10
    assert np.abs(u - np.array([float(x) for x in us])).max() < 1e-10 * max(map(abs, us))


@pytest.mark.parametrize(
    ("law", "asked"),
    [
        ("p", {"wc": 0.5}),
        ("pi", {"wc": 0.5, "pm_deg": 50}),
        ("pd", {"wc": 1.5, "pm_deg": 50}),
        ("pid", {"wc": 1.5, "pm_deg": 50, "ki": 0.2}),
    ],
)
def test_weights_leave_the_margins_as_they_are(law, asked):
    c = {"derivative_weight": 0.0} if law in ("pd", "pid") else {}
    plain = zoh.design(PLANT, law, asked, dt=DT)
    weighted = zoh.design(PLANT, law, {**asked, "setpoint_weight": 0.5, **c}, dt=DT)
    assert weighted.margins == plain.margins
    assert weighted.controller == plain.controller
    assert weighted.gains == plain.gains
    assert weighted.step.peak_effort < plain.step.peak_effort
    assert weighted.setpoint_weight == 0.5
    assert weighted.derivative_weight == c.get("derivative_weight", 1.0)


def test_at_rest_an_integral_sees_the_whole_reference_and_a_p_its_share():
    plant = zoh.Plant(num=[2], den=[1, 1])
    p = zoh.p(plant, dt=0.1, wc=1.0, setpoint_weight=0.25)
    kp = p.gains["kp"]
    assert p.step.final_value == pytest.approx(0.25 * kp * 2 / (1 + kp * 2), rel=1e-14)
    pi = zoh.pi(plant, dt=0.1, wc=1.0, pm_deg=70, setpoint_weight=0.25)
    assert pi.step.final_value == 1.0


def test_the_path_of_the_reference_has_the_controllers_denominator():
    d = zoh.pid(PLANT, ki=0.2, setpoint_weight=0.0, derivative_weight=0.0, **ASKED)
    path = d.reference_path
    assert path.den == d.controller.den
    w = np.array([0.3, 1.0, 5.0])
    s = 2j / DT * np.tan(w * DT / 2)
    assert np.abs(path.at(w) * s / 0.2 - 1).max() < 1e-13  # the integral alone is left: ki/w
    out = d.to_dict()
    assert (out["setpoint_weight"], out["derivative_weight"]) == (0.0, 0.0)
    assert out["reference_path"]["den"] == out["controller"]["den"]
    assert "reference weighted by b = 0, c = 0" in d.report()
    assert zoh.pid(PLANT, ki=0.2, **ASKED).to_dict()["reference_path"] is None


def test_a_given_controller_is_measured_with_weights_that_fit_its_gains():
    d = zoh.pid(PLANT, ki=0.2, setpoint_weight=0.5, **ASKED)
    same = zoh.verify(PLANT, d.controller, gains=d.gains, setpoint_weight=0.5)
    assert same.step == d.step
    with pytest.raises(zoh.SpecError, match="gains must be those of the controller"):
        zoh.verify(PLANT, d.controller, gains={**d.gains, "kp": 1.0}, setpoint_weight=0.5)
    with pytest.raises(zoh.SpecError, match="setpoint_weight must be 1 for a law without kp"):
        zoh.verify(PLANT, d.controller, setpoint_weight=0.5)


def test_weights_that_the_evidence_does_not_bear_do_not_travel():
    d = zoh.pid(PLANT, ki=0.2, setpoint_weight=0.5, **ASKED)
    for lie in ({"setpoint_weight": 0.6}, {"feedforward": None}, {"derivative_weight": 0.0}):
        with pytest.raises(zoh.NotMet, match="the evidence is not this loop's"):
            replace(d, **lie)


@pytest.mark.parametrize(
    ("law", "more", "line"),
    [
        ("pi", {"derivative_weight": 0.5}, "derivative_weight is no parameter of pi"),
        ("lead", {"dc_gain": 1, "setpoint_weight": 0.5}, "setpoint_weight is no parameter of lead"),
        ("pid", {"ki": 1, "setpoint_weight": -0.5}, "setpoint_weight must be 0 or more, got -0.5"),
        ("pid", {"ki": 1, "derivative_weight": "0"}, "derivative_weight must be a real number"),
    ],
)
def test_malformed_weights_are_refused_by_name(law, more, line):
    with pytest.raises(zoh.SpecError, match=f"^{line}"):
        zoh.design(PLANT, law, {"wc": 1.5, "pm_deg": 50, **more}, dt=DT)


def test_a_choice_counts_with_the_weights():
    lags = zoh.Plant(num=[1], den=[1, 1.5, 0.5])
    asked = zoh.Requirements(ms=1.6, peak_effort=1.2)
    plain = zoh.pi(lags, dt=0.1, pm_deg=60, requirements=asked)
    weighted = zoh.pi(lags, dt=0.1, pm_deg=60, setpoint_weight=0.0, requirements=asked)
    assert weighted.margins.crossover > 1.05 * plain.margins.crossover
    assert weighted.step.peak_effort <= 1.2


def test_a_table_shows_no_step_and_takes_no_weights():
    rows = {"w": [0.5, 1, 2], "magnitude": [2, 1, 0.5], "phase_deg": [-90, -100, -110]}
    table = zoh.FrequencyResponse(**rows, dt=0.1)
    with pytest.raises(zoh.SpecError, match="setpoint_weight must be left out on a table"):
        zoh.pi(table, dt=0.1, wc=1.0, pm_deg=60, setpoint_weight=0.5)
