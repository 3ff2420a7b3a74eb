"""The bound on what rounding does, against loops that are run: the model beside doubles."""

import numpy as np
import pytest
from designs import LAWS, made

import zoh
from zoh.analysis.realised import realised
from zoh.firmware.model import Model
from zoh.firmware.plan import plan
from zoh.firmware.roundoff import round_off
from zoh.firmware.vectors import chance


class Chain:
    """A sampled system in double precision, in sums of its own; it knows nothing of the model."""

    def __init__(self, system):
        self.a, self.c, self.d = (np.array(x, dtype=float) for x in realised(system))
        self.x = np.zeros(len(self.a))

    def out(self, e=0.0):
        return float(self.c @ self.x + self.d * e)

    def step(self, e):
        moved = self.x.copy()
        if len(moved):
            moved[0] += e - self.a @ self.x
            moved[1:] += self.x[:-1]
        self.x = moved


def run(plan_, references):
    """Return y of the loop with the model and y of the loop without rounding."""
    model, units = Model(plan_), (float(plan_.format.y_unit), float(plan_.format.u_unit))
    plants = Chain(plan_.design.sampled), Chain(plan_.design.sampled)
    exact, with_model, without = Chain(plan_.quantised.controller), [], []
    whole = plan_.program.whole
    for r in references:
        y, true = plants[0].out(), plants[1].out()
        if whole:
            r = round(r / units[0]) * units[0]
            u = model.step(round(r / units[0]), round(y / units[0])) * units[1]
        else:
            u = float(model.step(r, y))
        e = r - true
        plants[1].step(exact.out(e))
        exact.step(e)
        plants[0].step(u)
        with_model.append(y)
        without.append(true)
    return np.array(with_model), np.array(without)


@pytest.mark.parametrize("number", ["q15", "q31", "f32"])
@pytest.mark.parametrize("law", LAWS)
def test_no_run_leaves_the_bound(law, number):
    made_ = made(law, number, u_min=-1200.0, u_max=1200.0, pm_loss_deg=1.0)
    found = round_off(made_)
    numbers = chance(9)
    steps = [(next(numbers) / 2**31 - 1) * 0.5 for _ in range(20)]
    references = [steps[k // 100] for k in range(2000)]
    y, true = run(made_, references)
    off = np.abs(y - true)
    # a half step of r, rounded in both loops alike, is in neither; floats' errors are scaled to
    # the largest step there is here: 1
    assert off.max() <= found.y_bound
    # and it is a bound, not a number from elsewhere: runs come within a factor of it
    assert off.max() > found.y_bound * (1 / 30 if number != "f32" else 1e-5)


@pytest.mark.parametrize("law", ["pi", "pid", "lead"])
def test_rest_is_a_limit_cycle_within_the_bound(law):
    """Long after the last step the loop is at rest or in a cycle, and stays as near as is said."""
    made_ = made(law, "q15", u_min=-1200.0, u_max=1200.0, pm_loss_deg=1.0)
    y, true = run(made_, [0.1234] * 6000)
    assert np.abs(y - true)[5000:].max() <= round_off(made_).y_bound
    assert np.ptp(true[5000:]) < 1e-6


def test_noise_is_as_large_as_said():
    """With a reference that never rests the errors are as good as random."""
    made_ = made("pid", "q15", u_min=-120.0, u_max=120.0)
    numbers = chance(4)
    y, true = run(made_, [(next(numbers) / 2**31 - 1) * 0.3 for _ in range(6000)])
    found = round_off(made_).y_noise
    assert np.std((y - true)[500:]) == pytest.approx(found, rel=0.25)  # some 100 time constants


def test_by_hand():
    # u = round(r - y), y(k+1) = y + u: y is what u was made of, a step late; half a step of y
    # where it is read, half a step of u where it is made
    d = zoh.p(zoh.Plant(num=[1], den=[1, 0]), dt=1.0, pm_deg=60)
    assert d.gains["kp"] == pytest.approx(1.0, abs=1e-12)
    found = round_off(plan(d, number="q15", y_range=(-1, 1), u_range=(-4, 4)))
    assert found.y_bound == pytest.approx(2.0**-16 + 2.0**-14, rel=1e-3)  # kp is 2^-13 off 1/4
    # each as wide as a step: h is 1 once, so that the variances add up
    assert found.y_noise == pytest.approx(np.sqrt((2.0**-30 + 2.0**-26) / 12), rel=1e-3)  # as above


def test_floats_scale_with_their_digits():
    f32, f64 = (round_off(made("pid", n)) for n in ("f32", "f64"))
    assert f32.y_bound / f64.y_bound == pytest.approx(
        2.0**29, rel=1e-3
    )  # their coefficients differ


def test_a_loop_that_waits_too_long_is_refused():
    far = zoh.Plant(num=[0.001], den=[1.0, 1.0], dead_time=60.0)
    d = zoh.verify(far, zoh.Sampled(num=[1.0], den=[1.0], dt=0.1))
    with pytest.raises(zoh.SpecError, match="500 samples of delay or fewer"):
        round_off(plan(d))
