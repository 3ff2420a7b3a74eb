"""moves: a held plant inside a sample that its fastest mode outruns, against 120 digits."""

from dataclasses import replace
from decimal import Decimal
from math import comb, e, exp, factorial, sqrt

import numpy as np
import pytest
from mpmath import mp, mpf

from zoh.errors import SpecError
from zoh.lti.systems import Plant
from zoh.sampling import moves as room
from zoh.sampling.moves import Moves

REL = 1e-14  # of each number of the state's move; a float's rounding five times over


def truth(plant, dt, t):
    """Return exp(A t) of (state, input), its generator and y's row, t in samples."""
    den = [mpf(c) / mpf(plant.den[0]) for c in plant.den]
    n = len(den) - 1
    num = [mpf(0)] * (n + 1 - len(plant.num)) + [mpf(c) / mpf(plant.den[0]) for c in plant.num]
    a, row = mp.zeros(n + 1), mp.zeros(1, n + 1)
    for i in range(n - 1):
        a[i, i + 1] = mpf(1)
    for i in range(n):
        a[n - 1, i] = -den[n - i] * mpf(dt) ** (n - i)
        row[i] = (num[n - i] - num[0] * den[n - i]) * mpf(dt) ** (n - i) * mpf(plant.sensor)
    a[n - 1, n] = mpf(1)
    return mp.expm(a * mpf(t), method="taylor"), a, row


def drawn(seed):
    """Return a plant of order 1 to 6 with modes from 1e-4 to 200 rad a sample, dt and a time."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 7))
    at_origin = int(rng.integers(0, min(n, 3)))
    poles = [0.0] * at_origin
    while len(poles) < n:
        size = 10 ** rng.uniform(-4, 2.3)
        if n - len(poles) >= 2 and rng.random() < 0.4:
            real = rng.uniform(0, 1)
            swing = 1j * sqrt(1 - real * real)
            poles += [size * (-real + swing), size * (-real - swing)]
        else:
            poles.append(-size if rng.random() < 0.85 else min(size, 20.0))
    dt = 10 ** rng.uniform(-3, 3)
    den = [c * dt**-i for i, c in enumerate(np.poly(poles).real.tolist())]
    if at_origin:
        den[-at_origin:] = [0.0] * at_origin
    num = rng.normal(size=int(rng.integers(1, n + 2))).tolist()
    plant = Plant(num=num, den=den, sensor=float(10 ** rng.uniform(-3, 3)))
    return plant, dt, [1.0, float(rng.uniform()), 1e-3][int(rng.integers(3))]


@pytest.mark.parametrize("seed", range(40))
def test_a_drawn_plant_moves_and_is_seen(seed):
    plant, dt, t = drawn(seed)
    n, moves = len(plant.den) - 1, Moves.of(plant, dt)
    span, terms = 0.01, 12
    with mp.workdps(120):
        whole, a, row = truth(plant, dt, t)
        moved = np.array((whole - mp.eye(n + 1)).tolist(), float)[:n]
        row[n] = mpf(0)  # the direct path is left out
        rows = []
        for j in range(terms):
            rows.append([float(x * mpf(span) ** j / mp.factorial(j)) for x in row * whole])
            row = row * a
    found = moves.moved(t)
    # a number 1e60 times smaller than the largest of its row is nothing beside it
    small = 1e-60 * np.abs(moved).max(axis=1, keepdims=True)
    assert np.all(np.abs(found - moved) <= np.maximum(REL * np.abs(moved), small))
    wanted = np.array(rows)
    off = np.abs(moves.series(t, span, terms) - wanted)
    assert np.all(off <= 1e-14 * np.abs(wanted).max(axis=0))  # of what a state adds at most


def test_what_integrators_leave_alone_is_zero():
    # 1/(s^2 (s + 30)): position and rate have no spring
    moved = Moves.of(Plant(num=[1], den=[1, 30, 0, 0]), 0.1).moved(1.0)
    assert moved[0, :2].tolist() == [0.0, 1.0]
    assert moved[1, :2].tolist() == [0.0, 0.0]
    assert moved[1, 2] == pytest.approx((1 - e**-3) / 3, rel=REL)
    assert moved[2, :3] == pytest.approx([0.0, 0.0, e**-3 - 1], rel=REL)


def test_a_time_of_forty_digits_is_no_float():
    third = Decimal("0.3333333333333333333333333333333333333333")
    lag = Moves.of(Plant(num=[1], den=[1, 30]), 1.0)
    with mp.workdps(50):
        wanted = float(mp.expm1(-mpf(10)))
    assert lag.moved(third)[0, 0] == pytest.approx(wanted, rel=2e-16)


def test_modes_a_billion_times_faster_than_the_sample_are_over():
    # 1/(s + 1e9)^5 with unit gain: within a sample the state comes to rest on its input
    den = [1e9**i * c for i, c in enumerate([1, 5, 10, 10, 5, 1])]
    moves = Moves.of(Plant(num=[den[-1]], den=den), 1.0)
    moved = moves.moved(1.0)
    assert moved[:, :5] == pytest.approx(-np.eye(5), rel=REL)
    assert moved[0, 5] == pytest.approx(1e-45, rel=REL)
    series = moves.series(0.5, 0.5, 30)
    assert series[0, 5] == pytest.approx(1.0, rel=REL)
    # the largest of a state's numbers is 1e45^(5/5): what it still adds is nothing beside that
    assert np.abs(series[1:]).max() < 1e-60
    assert np.abs(series[:, :5]).max() < 1e-60


def test_a_double_lag_that_is_all_but_over_has_every_digit():
    # 1/(s + 100)^2: Phi = exp(-100 t) ((1 + 100 t, t), (-1e4 t, 1 - 100 t)); 4e-44 stands beside 1
    moved = Moves.of(Plant(num=[1], den=[1, 200, 1e4]), 1.0).moved(1.0)
    left = exp(-100)
    assert moved[0] == pytest.approx([101 * left - 1, left, (1 - 101 * left) / 1e4], rel=REL)
    assert moved[1] == pytest.approx([-1e4 * left, -99 * left - 1, left], rel=REL)


@pytest.mark.parametrize("gain", [1.0, 1e-150, 1e150])
def test_what_a_lag_has_left_of_its_state_has_every_digit(gain):
    # y = gain x, x = (state - u/150) exp(-150 t) + u/150: from t = 1 on its powers in 150 (t - 1)
    moves = Moves.of(Plant(num=[gain], den=[1, 150]), 1.0)
    on_state, on_input = moves.series(1.0, 1 / 150, 9).T
    falls = np.array([exp(-150) * (-1) ** j / factorial(j) for j in range(9)])
    assert on_state == pytest.approx(gain * falls, rel=REL, abs=0)
    rests = -gain / 150 * falls
    rests[0] += gain / 150
    # of what the input adds at most: beside 1/150, 1e-68 is not asked for its digits
    assert on_input == pytest.approx(rests, rel=0, abs=REL * gain / 150)


def test_a_stretch_of_a_mode_that_is_over_may_be_long():
    # 75 rad: the powers of a lag grow, 75^27/27! is 4e22, and are right as those of a short one
    on_state, on_input = Moves.of(Plant(num=[150], den=[1, 150]), 1.0).series(0.5, 0.5, 28).T
    powers = [exp(-75) * (-75) ** j / factorial(j) for j in range(28)]
    assert on_state == pytest.approx(
        [150 * p for p in powers], rel=0, abs=REL * 150 * abs(powers[-1])
    )
    powers[0] -= 1
    assert on_input == pytest.approx([-p for p in powers], rel=0, abs=REL)


@pytest.mark.parametrize("bits", [70, 200, 2000])
def test_the_bits_to_begin_with_decide_nothing(bits):
    # 1/(s + a)^13 at a t = 2^-20: A + a is nilpotent, exp(A t) = exp(-a t) sum (A + a)^k t^k/k!
    n, a, t = 13, 2**30, 2.0**-50
    den = [comb(n, i) * a**i for i in range(n + 1)]
    moves = Moves.of(Plant(num=[1], den=den), 1.0)
    row, wanted = [1] + [0] * (n - 1), [mpf(0)] * n
    with mp.workdps(200):
        for k in range(n):
            wanted = [w + x * mpf(t) ** k / factorial(k) for w, x in zip(wanted, row, strict=True)]
            moved = zip(row, [0, *row[:-1]], den[:0:-1], strict=True)
            row = [a * x + y - row[-1] * c for x, y, c in moved]
        wanted = [w * mp.exp(-a * mpf(t)) for w in wanted]
        wanted[0] -= 1
    position = replace(moves, bits=bits).moved(t)[0]
    # t^8/8! is the last that is not beyond 2^-400 of the largest; the last row begins with 2^340
    assert position[:8] == pytest.approx([float(w) for w in wanted[:8]], rel=REL, abs=0)


def test_a_pole_far_below_the_fastest_moves_the_state_by_all_its_digits():
    # s^2 + 100 s + 2^-200: poles near -100 and -2^-200/100, so x_0 falls by 6e-63 of itself
    moves = replace(Moves.of(Plant(num=[1], den=[1, 100, 2.0**-200]), 1.0), held=70)
    with mp.workdps(200):
        a = -50 - mp.sqrt(2500 - mpf(2) ** -200)
        b = mpf(2) ** -200 / a
        fall = (b * mp.expm1(a) - a * mp.expm1(b)) / (b - a)
        rate = a * b * (mp.expm1(a) - mp.expm1(b)) / (b - a)
        wanted = [float(fall), float(rate)]
    assert moves.moved(1.0)[:, 0].tolist() == pytest.approx(wanted, rel=REL, abs=0)


def test_what_is_off_with_too_few_bits_is_within_its_bound():
    # x' = 100 x + u at 40 bits: exp(100) doubled up from exp(100/256) loses eight of them
    moves = Moves.of(Plant(num=[1], den=[1, -100]), 1.0)
    unit, grown = moves.exponent, exp(100)
    rows, errors = moves._rows(1.0, 40, unit * np.array([[0, -1]]), seen=False)
    found = rows[0] * moves.ratio ** np.array([0, -1])
    bounds = errors[0] * moves.ratio ** np.array([0, -1])
    off = abs(found - [grown - 1, (grown - 1) / 100])
    assert np.all(off > 1e-12 * abs(found))  # or there is nothing to bound
    assert np.all(off <= bounds)
    units = unit * np.array([[1, 0], [2, 1], [3, 2]]) + moves.scaled.gain
    rows, errors = moves._rows(1.0, 40, units, seen=True)
    for j, (row, bound) in enumerate(zip(rows, errors, strict=True)):
        power = moves.ratio ** np.array([j + 1, j])
        wanted = np.array([100.0, 1.0]) * (grown - np.array([0, not j])) * 100.0 ** (j - 1)
        off = abs(row * power - wanted)
        assert np.all(off > 1e-12 * wanted)
        assert np.all(off <= bound * power)


@pytest.mark.parametrize(
    ("gain", "den", "most"),
    [
        # position and rate of an integrator's chain keep zeros that no bits make sure
        (1, [1, 30, 0, 0], 300),
        # exp(-1e9) is nothing; 1e-45 beside 1, and 2^30 five times over, are something
        (1, [1e9**i * c for i, c in enumerate([1, 5, 10, 10, 5, 1])], 2000),
        # exp(-100) is 2^-144, and 58 bits of it are a float's; a gain changes nothing
        (1, [1, 200, 1e4], 400),
        (1e300, [1, 200, 1e4], 400),
    ],
)
def test_no_more_bits_are_taken_than_are_missing(monkeypatch, gain, den, most):
    asked, ring = [], room.FixedRing
    monkeypatch.setattr(room, "FixedRing", lambda **a: asked.append(a["bits"]) or ring(**a))
    moves = Moves.of(Plant(num=[gain], den=den), 1.0)
    for look in (lambda: moves.moved(1.0), lambda: moves.series(1.0, 1e-3, 12)):
        asked.clear()
        look()
        assert asked == sorted(asked)
        assert asked[-1] < most or asked == [moves.held]  # the hold has taken as many
        assert len(asked) <= 2  # the first says how many are missing


def test_a_moment_far_below_every_time_constant_moves_by_the_slope():
    # x' = u - 30 x for 2^-450 of a sample: 1e-135, and the next power 1e-270
    assert Moves.of(Plant(num=[1], den=[1, 30]), 1.0).moved(Decimal(2.0**-450)).tolist() == [
        [-30 * 2.0**-450, 2.0**-450]
    ]


def test_a_plant_that_falls_silent_within_a_sample_is_silent():
    # s/(s + 1e9)^2 answers a step with t exp(-1e9 t): no number is left to be sure of
    moves = Moves.of(Plant(num=[1, 0], den=[1, 2e9, 1e18]), 1.0)
    assert not moves.series(1.0, 0.5, 20).any()


def test_a_motion_beyond_floats_is_refused():
    moves = Moves.of(Plant(num=[1], den=[1.0, -699.0, -700.0]), 1.0)  # poles 700 and -1
    with mp.workdps(50):
        wanted = float((mp.exp(700) - mp.exp(-1)) / 701)
    assert moves.moved(1.0)[0, 1] == pytest.approx(wanted, rel=REL)
    with pytest.raises(SpecError, match="must keep the plant's motion within a sample") as refused:
        moves.series(1.0, 1.0, 12)  # 700^11 times that
    assert (refused.value.argument, refused.value.value) == ("dt", 1.0)
    assert refused.value.bound.endswith("within a float's range")
    assert refused.value.way_out == "sample faster, or leave the fast mode out of the model"


def test_a_mode_too_fast_for_any_exponent_is_refused():
    with pytest.raises(SpecError, match="must not be as long against the plant's fastest mode"):
        Moves.of(Plant(num=[1], den=[1, 1e19, 1]), 1.0)
