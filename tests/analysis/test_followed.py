"""Loops as motions, beside exact ones; a controller with a fast pole by the step of its sum."""

from fractions import Fraction

import pytest
from mpmath import mp, mpf

from zoh.analysis.closed import EXCITATIONS, closed_loop
from zoh.analysis.realised import Chain
from zoh.analysis.step import closed_loop_step
from zoh.lti.systems import Plant, Sampled

T = 2.0**-20


def gains(system, delta):
    """Return the chain's transfer function at a rational delta = z - 1, in fractions."""
    chain = Chain.followed(system)
    assert chain.steps
    a, c, d = [Fraction(x) for x in chain.a], [Fraction(x) for x in chain.c], Fraction(chain.d)
    # x_i = x_0/delta^i, s = delta x_0, e = s + a x for x_0 = 1
    x = [1 / Fraction(delta) ** i for i in range(len(a))]
    e = delta + sum(p * q for p, q in zip(a, x, strict=True))
    return (c[0] * delta + sum(p * q for p, q in zip(c[1:], x[1:], strict=True))) / e + d


@pytest.mark.parametrize(
    ("num", "den"),
    [
        ([9.0, -8.5], [1.0, 0.0]),
        ([9.0, -8.5], [2.0, -0.5]),
        ([-9.0, 8.5], [1.0, 0.75]),
        ([65.0, -127.0, 62.5], [1.0, -1.0, 0.0]),
        ([65.0, -127.0, 62.5], [1.0, -1.25, 0.25]),
        ([65.0, -170.0, 150.0, -44.5], [1.0, -1.0, 0.25, -0.25]),
    ],
)
def test_the_transfer_function_is_the_controllers(num, den):
    system = Sampled(num=num, den=den, dt=0.5)
    for delta in (Fraction(1, 3), Fraction(-5, 7), Fraction(11)):
        z = 1 + delta
        top, bottom = (
            sum(Fraction(x) * z**i for i, x in enumerate(reversed(part))) for part in (num, den)
        )
        assert float(gains(system, delta) / (top / bottom)) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize(
    ("num", "den"),
    [
        ([2.0], [1.0]),  # no state
        ([0.0, 1.0], [1.0, -0.5]),  # nothing direct
        ([1.0, -0.5], [1.0, -1.0]),  # an integrator alone has no step to speak of
        ([1.0, 0.5], [1.0, -0.5]),  # c x adds to d e
        # D(1) = 1/4, half of D(infinity), which is the pole's a_0: still one digit each
        ([0.5, -0.375], [1.0, -0.5]),
    ],
)
def test_the_sum_itself_where_nothing_is_taken_back(num, den):
    system = Sampled(num=num, den=den, dt=0.5)
    assert Chain.followed(system) == Chain.of(system)


def at(past, k):
    """Return what was k samples after the start, 0 before it."""
    return past[k] if k >= 0 else Fraction(0)


def answers(system, inputs):
    """Return what a sampled system answers to inputs, in fractions."""
    num, den = ([Fraction(x) for x in part] for part in (system.num, system.den))
    num, out = [Fraction(0)] * (len(den) - len(num)) + num, []
    for k in range(len(inputs)):
        total = sum(c * at(inputs, k - i) for i, c in enumerate(num))
        out.append((total - sum(c * at(out, k - i) for i, c in enumerate(den) if i)) / den[0])
    return out


def moved(plant, controller, late, by, count, feedforward=None):
    """Return y and u at ``count`` samples, in fractions; plant (b2 s^2 + b1 s + b0)/s^2.

    late  the delay in samples, a whole number of quarters
    """
    b2, b1, b0 = (Fraction(x) for x in (0.0, *plant.num)[-3:])
    t, late = Fraction(controller.dt), Fraction(late)
    wait = -(-late // 1)
    pieces = [((1 - wait + late) * t, wait)]
    if wait > late:
        pieces.append(((wait - late) * t, wait - 1))
    num, den = ([Fraction(x) for x in part] for part in (controller.num, controller.den))
    position, speed, outputs, errors = Fraction(0), Fraction(0), [], []
    efforts, mine = [], []
    reference = {"step": [Fraction(1)] * count, "impulse": [Fraction(1)] + [Fraction(0)] * count}
    reference |= {"ramp": [k * t for k in range(count)], "disturbance": [Fraction(0)] * count}
    ahead = answers(feedforward, reference[by]) if feedforward else [Fraction(0)] * count
    for k, r in zip(range(count), reference[by], strict=False):
        d = Fraction(by == "disturbance")
        # the plant's input right at the sample
        rest = sum(c * at(errors, k - i) for i, c in enumerate(num) if i)
        rest -= sum(c * at(mine, k - i) for i, c in enumerate(den) if i)
        free = b0 * position + b1 * speed + b2 * d
        if wait:
            outputs.append(free + b2 * at(efforts, k - wait))
            errors.append(r - outputs[k])
            # the controller remembers its own answers alone
            mine.append((num[0] * errors[k] + rest) / den[0])
            efforts.append(mine[k] + ahead[k])
        else:  # u = num0/den0 (r - free - b2 u) + rest/den0 + ahead
            direct = num[0] / den[0]
            efforts.append((direct * (r - free) + rest / den[0] + ahead[k]) / (1 + direct * b2))
            mine.append(efforts[k] - ahead[k])
            outputs.append(free + b2 * efforts[k])
            errors.append(r - outputs[k])
        for span, ago in pieces:
            u = at(efforts, k - ago) + d
            position += span * speed + span * span / 2 * u
            speed += span * u
    return outputs, efforts


@pytest.mark.parametrize("by", EXCITATIONS)
@pytest.mark.parametrize("late", [0.0, 0.25, 1.0, 1.5, 3.0])
@pytest.mark.parametrize("direct", [0.0, 0.0625])
@pytest.mark.parametrize(
    ("num", "den"),
    [
        ([9.0, -8.5], [1.0, 0.0]),
        ([9.0, -8.5], [1.0, -0.25]),
        ([65.0, -127.0, 62.5], [1.0, -1.25, 0.25]),
        ([65.0, -170.0, 150.0, -44.5], [1.0, -1.0, 0.25, -0.25]),
    ],
)
def test_every_motion_is_the_exact_one(num, den, late, direct, by):
    plant = Plant(num=[direct, 0.25, 0.5], den=[1.0, 0.0, 0.0], dead_time=late * 0.125)
    controller = Sampled(num=num, den=den, dt=0.125)
    motion = closed_loop(plant, controller, by=by)
    states = motion.run(motion.start, 24)
    assert_exact(motion, states, *moved(plant, controller, late, by, 24))


@pytest.mark.parametrize("by", EXCITATIONS)
@pytest.mark.parametrize("late", [0.0, 0.25, 1.0, 3.0])
@pytest.mark.parametrize("direct", [0.0, 0.0625])
@pytest.mark.parametrize(
    ("num", "den"),
    [
        ([0.75], [1.0]),
        ([2.0, -1.5], [1.0, -0.25]),
        ([1.0], [1.0, -0.5]),
        ([2.0, -1.0, 0.5], [2.0, -1.0, 0.25]),
    ],
)
def test_a_feedforward_adds_its_answer_to_the_reference(num, den, direct, late, by):
    plant = Plant(num=[direct, 0.25, 0.5], den=[1.0, 0.0, 0.0], dead_time=late * 0.125)
    controller = Sampled(num=[65.0, -127.0, 62.5], den=[1.0, -1.25, 0.25], dt=0.125)
    feedforward = Sampled(num=num, den=den, dt=0.125)
    motion = closed_loop(plant, controller, by=by, feedforward=feedforward)
    states = motion.run(motion.start, 24)
    assert_exact(motion, states, *moved(plant, controller, late, by, 24, feedforward))


def assert_exact(motion, states, y, u):
    size = max(map(abs, y)), max(map(abs, u))
    for got, truth, most in zip((motion.output, motion.effort), (y, u), size, strict=True):
        # 1e-12 of the largest: 24 samples of loops some of which are unstable
        wanted = [float(x) for x in truth]
        assert got.dot(states) == pytest.approx(wanted, rel=0, abs=1e-12 * float(most))


def test_the_effort_of_a_pd_keeps_its_digits():
    """1/s^2 under 1/16 + (z - 1)/(T z), sample by sample: u begins at a million and goes to -1."""
    gain, fast = Fraction(1, 16), Fraction(1 / T)
    pd = Sampled(num=[float(gain + fast), -float(fast)], den=[1.0, 0.0], dt=T)
    motion = closed_loop(Plant(num=[1.0], den=[1.0, 0.0, 0.0]), pd)
    x, v, before, t, state = Fraction(0), Fraction(0), Fraction(0), Fraction(T), motion.start
    for _ in range(40):
        e = 1 - x
        u = (gain + fast) * e - fast * before
        assert motion.effort.dot(state) == pytest.approx(float(u), rel=1e-13, abs=0)
        x, v, before = x + t * v + t * t / 2 * u, v + t * u, e
        state = state + motion.delta.dot(state)


def highest(top, bottom, near):
    """Return the largest y of 1/s^2 under a controller of order one, at 60 digits.

    near  a time close to that of the largest
    """
    mp.dps = 60
    t, (b0, b1), (a0, a1) = mpf(T), map(mpf, top), map(mpf, bottom)
    # Z = (position, speed, error before, effort before, 1)
    u = mp.matrix([[-b0 / a0, 0, b1 / a0, -a1 / a0, b0 / a0]])
    step = mp.zeros(5, 5)
    step[0, :] = mp.matrix([[1, t, 0, 0, 0]]) + t * t / 2 * u
    step[1, :] = mp.matrix([[0, 1, 0, 0, 0]]) + t * u
    step[2, :], step[3, :] = mp.matrix([[-1, 0, 0, 0, 1]]), u
    step[4, 4] = 1
    z = step ** (int(near / T) - 40) * mp.matrix([0, 0, 0, 0, 1])
    seen = []
    for _ in range(81):  # a flat crest may be named some samples from where it is
        push = (u * z)[0]
        at = min(max(-z[1] / push, mpf(0)), t)  # where the speed is 0, if that is in the sample
        seen.append(z[0] + at * z[1] + at * at / 2 * push)
        z = step * z
    assert max(seen) not in (seen[0], seen[-1])
    return max(seen)


@pytest.mark.parametrize(
    ("kp", "kd", "pole"),
    [(0.0625, 1.0, 0.0), (0.0625, 1.0, 0.5), (0.25, 0.75, -0.25), (0.5, 0.125, 0.0)],
)
def test_the_overshoot_of_a_pd_on_a_double_integrator(kp, kd, pole):
    # kp + kd/T (1 - pole) (z - 1)/(z - pole): its d is a million times its gain at rest
    fast = kd / T * (1 - pole)
    num, den = [kp + fast, -kp * pole - fast], [1.0, -pole]
    plant = Plant(num=[1.0], den=[1.0, 0.0, 0.0])
    got = closed_loop_step(plant, Sampled(num=num, den=den, dt=T)).between_samples
    truth = highest(num, den, got.peak_time)
    assert got.peak == pytest.approx(float(truth), rel=1e-14)
    assert got.overshoot_pct == pytest.approx(float(100 * (truth - 1)), rel=1e-12)
