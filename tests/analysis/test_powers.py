"""powers: loops whose states swing each other up, against recursions in 60 digits."""

from math import exp

import numpy as np
import pytest
from mpmath import mp, mpf

import zoh
from zoh.analysis.closed import closed_loop
from zoh.analysis.powers import Powers


def leads(n, dt, zero, pole, gain):
    """Return n leads in a row, each of gain 1/dt times a difference, and ``gain``."""
    z, p = 1 - zero * dt, exp(-pole * dt)
    top, bottom = np.poly([z] * n), np.poly([p] * n)
    return zoh.Sampled(num=(gain * ((1 - p) / dt) ** n * top).tolist(), den=bottom.tolist(), dt=dt)


def chain(n):
    """Return n integrators in a row."""
    return zoh.Plant(num=[1.0], den=[1.0] + [0.0] * n)


def recursion(n, controller, count, noise=False):
    """Return (y, u) of so many samples, shape (2, count), in 60 digits.

    Within a sample y is a polynomial of degree n: its derivatives add up by Taylor's series. The
    controller is its difference equation. With ``noise`` an impulse is added to the measurement,
    else the reference is 1.
    """
    with mp.workdps(60):
        dt = mpf(controller.dt)
        num, den = ([mpf(c) for c in a] for a in (controller.num, controller.den))
        assert len(num) == len(den)
        steps = [dt**j / mp.factorial(j) for j in range(n + 1)]
        x, es, us, out = [mpf(0)] * n, [mpf(0)] * len(num), [mpf(0)] * len(den), []
        for k in range(count):
            e = (-1 if k == 0 else 0) - x[0] if noise else 1 - x[0]
            es = [e, *es[:-1]]
            u = (mp.fdot(num, es) - mp.fdot(den[1:], us[:-1])) / den[0]
            us = [u, *us[:-1]]
            out.append((x[0], u))
            x = [mp.fdot(steps, [*x[i:], u][: n + 1 - i]) for i in range(n)]
        return np.array([[float(a) for a in row] for row in zip(*out, strict=True)])


CASES = [
    pytest.param(5, leads(4, 0.1, 0.1, 20, 0.5), 400, id="five integrators"),
    pytest.param(4, leads(3, 0.03, 0.2, 20, 2.0), 1200, id="a ball on a beam"),
    pytest.param(5, leads(4, 0.02, 0.2, 20, 2.0), 800, id="five, sampled fast"),
]


@pytest.mark.parametrize(("n", "controller", "count"), CASES)
def test_a_step_by_recursion(n, controller, count):
    y, _ = recursion(n, controller, count)
    motion = closed_loop(chain(n), controller)
    assert motion.output.dot(motion.from_start(count)) == pytest.approx(y, rel=0, abs=1e-9)
    step = zoh.measure(chain(n), controller).step
    assert step.peak == pytest.approx(y.max(), rel=1e-9)
    outside = np.flatnonzero(np.abs(y - 1) > 0.02)[-1]
    assert step.settling_time == (outside + 1) * controller.dt


@pytest.mark.parametrize(("n", "controller", "count"), CASES)
def test_noise_by_recursion(n, controller, count):
    rows = recursion(n, controller, 12 * count, noise=True)
    assert abs(rows[0, -1]) < 1e-8  # so its square, and those after it, add nothing
    wanted = np.sqrt((rows**2).sum(axis=1))
    assert zoh.noise_gains(chain(n), controller) == pytest.approx(wanted, rel=1e-9)


def test_six_lags_with_five_leads_have_the_figures_of_ninety_digits():
    # truth: exact rationals and balls of 560 bits by python-flint, stepped sample by sample
    plant = zoh.Plant(num=[1.0], den=np.poly([-0.1] * 6).tolist())
    design = zoh.measure(plant, leads(5, 0.1, 0.1, 20, 2.0))
    assert design.step.peak == pytest.approx(1.15639115480645, rel=1e-9)
    assert design.step.settling_time == pytest.approx(2.8, rel=1e-15)


def powers(delta, own, seen=None, wholly=False):
    """Return powers of which all states are seen where ``seen`` is left out."""
    seen = np.eye(len(delta)) if seen is None else np.array(seen)
    return Powers(delta=np.array(delta), own=own, seen=seen, whose="controller", wholly=wholly)


def test_powers_are_squares_of_squares():
    one = powers([[0.5]], 1)
    assert [one.small(i)[0, 0] for i in (3, 0, 1, 2)] == [1.5**8 - 1, 0.5, 1.25, 1.5**4 - 1]
    assert one.small(3) is one.small(3)


@pytest.mark.parametrize("wholly", [False, True])
def test_a_sum_of_squares_by_hand(wholly):
    # 1 + 1/4 + 1/16 ... of the state, 4 times that of twice the state
    one = powers([[-0.5]], 1, [[1.0], [2.0]], wholly)
    found = one.sum_of_squares(np.array([1.0]))
    assert found == pytest.approx([4 / 3, 16 / 3], rel=1e-15)


def test_a_state_made_of_far_more_than_itself_is_followed_in_whole_numbers():
    # Z(1) = 100 (a - b) + ...: with a = b the first state is 100 times smaller than its parts
    swinging = [[-0.5, 100.0, -100.0], [0.0, -0.5, 0.0], [0.0, 0.0, -0.5]]
    few, many = powers(swinging, 3), powers(swinging, 5)
    start = np.array([1.0, 1.0, 1.0])
    for one in (few, many):
        one.run(start, 2)
    assert not few.gives_up_floats(start[:, None], 2)  # three have little room for that
    assert many.gives_up_floats(start[:, None], 2)
    assert many.wholly
    assert not many.gives_up_floats(start[:, None], 2)


def test_a_state_that_nothing_is_seen_of_may_be_made_of_more():
    # x0 halves and is 1e6; x1 is 1e-3 of noise beside it, and y = x0 + x1
    delta = [[-0.5, 0.0, 0.0, 0.0], [1e-3, -0.5, 1e3, -1e3], [0, 0, -0.5, 0], [0, 0, 0, -0.5]]
    start = np.array([1e6, 1.0, 1.0, 1.0])
    for seen, given_up in (([[1.0, 1.0, 0.0, 0.0]], False), ([[0.0, 1.0, 0.0, 0.0]], True)):
        one = powers(delta, 5, seen)
        one.run(start, 2)
        assert one.gives_up_floats(start[:, None], 2) is given_up


def test_what_no_float_follows_is_refused():
    # what is stepped to in whole numbers is exact; so many samples are not
    one = powers([[-0.5, 1e10], [0.0, -0.5]], 2, wholly=True)
    assert not one.gives_up_floats(np.ones((2, 2)), 2)
    with pytest.raises(zoh.SpecError) as err:
        one.gives_up_floats(np.ones((2, 1_000_000)), 2)
    assert str(err.value) == (
        "controller must have a response that can be followed in 64-bit floats, got "
        "'2 states that swing each other up': use fewer sections, or spread them wider"
    )
