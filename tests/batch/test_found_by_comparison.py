"""Loops on which an arithmetic once differed from the single design: each by another road, too."""

from fractions import Fraction
from importlib.util import find_spec

import mpmath
import numpy as np
import pytest

import zoh
from zoh.batch import single
from zoh.batch.arrays import between, held, turns
from zoh.batch.arrays import run as arrays
from zoh.batch.arrays.asked import _fastest, _rates, _turns_once
from zoh.batch.job import Job
from zoh.batch.reason import Reason

RESONANT = zoh.Plant(
    num=(0.13933709426333085, 3.0167490488631135),
    den=(
        1.0, 12.172575948737794, 26.39066132412917, 17.701879923203805, 33.80627432126468,
        6.191750941462186, 10.809219817316364,
    ),
)  # fmt: skip
STIFF = zoh.Plant(
    num=(1.4627179974821598, 1.3696268269084604, 0.2664943358470262),
    den=(1.0, 6.819357342328861, 12.618825624653331, 3.975974207607738, 0.0),
)


def test_a_peak_of_a_loop_far_below_nyquist_is_not_missed():
    # two resonances, and a sample time four decades above them
    asked = {"dt": 0.0001250257041686786, "wc": 0.7831503540172946, "pm_deg": 26.567427063004608}
    asked["dc_gain"] = 0.004510111083703995
    columns = {name: np.array([value]) for name, value in asked.items()}
    job = Job(plant=RESONANT, law="lead", dt=0.1, reference=-2.0, varying=tuple(columns))
    found = arrays.run(job, columns)
    lead = zoh.Sampled.from_w(
        num_w=(
            asked["dc_gain"] * found["gains.wp"][0] / found["gains.w0"][0],
            asked["dc_gain"] * found["gains.wp"][0],
        ),
        den_w=(1.0, found["gains.wp"][0]),
        dt=asked["dt"],
    )
    w = np.geomspace(0.3, 3.0, 200_001)
    ms = 1 / np.abs(1 + lead.at(w) * zoh.sample(RESONANT, asked["dt"]).at(w)).min()
    # 1e-7: the grid's spacing squared, times how sharp the peak is
    assert found["ms"][0] == pytest.approx(ms, rel=1e-7)


def test_a_crest_behind_a_corner_is_the_peak_in_every_arithmetic():
    # the input arrives 0.3 of a sample late, and a fast pole turns the response round behind that
    pytest.importorskip("numba")
    from zoh.batch.compiled import run as compiled

    asked = {
        "dt": 0.22142958974769386, "compute_delay": 0.06642887692430816, "wc": 0.4891271250004877,
        "pm_deg": 75.05616190290894, "dc_gain": 49.96222575559649,
    }  # fmt: skip
    columns = {name: np.array([value]) for name, value in asked.items()}
    job = Job(plant=STIFF, law="lag", dt=0.1, reference=-2.0, varying=tuple(columns))
    truth = single.run(job, columns)
    for found in (arrays.run(job, columns), compiled.run(job, columns, threads=1)):
        for name in ("between.overshoot_pct", "between.peak_time"):
            # 1e-7: where a crest is, is known to half the digits of how high it is
            assert found[name][0] == pytest.approx(truth[name][0], rel=1e-7)
    assert truth["between.peak_time"][0] / asked["dt"] % 1 == pytest.approx(0.436, abs=1e-3)


def first_crest(law, wc_dt, pm_deg, rest):
    """Return (overshoot in %, samples to it) of a PD or a lead on 1/s^2, to some 50 digits.

    The hold makes 1/s^2 dt^2/2 (z + 1)/(z - 1)^2. The controller is rest + r (z - 1)/(z - 1 + a)
    and has one complex gain at the crossover, which is two equations: of a PD with its filter's
    pole at 2/dt a is 1, of a lead rest is its gain at w = 0; dt is 1.
    Z is (y, by what y moves without an input, the filter's x, 1), x moves by e - a x.
    """
    with mpmath.workdps(50):
        z = mpmath.expj(mpmath.mpf(wc_dt))
        wanted = -mpmath.expj(mpmath.radians(mpmath.mpf(pm_deg))) / ((z + 1) / (z - 1) ** 2 / 2)
        if law == "pd":
            a = mpmath.mpf(1)
            r = wanted.imag / ((z - 1) / z).imag
            rest = wanted.real - r * ((z - 1) / z).real
        else:  # r (z - 1) - a (wanted - rest) = (wanted - rest) (z - 1)
            rest = mpmath.mpf(rest)
            more = wanted - rest
            right = more * (z - 1)
            r, a = mpmath.lu_solve(
                mpmath.matrix([[(z - 1).real, -more.real], [(z - 1).imag, -more.imag]]),
                mpmath.matrix([right.real, right.imag]),
            )
        u = mpmath.matrix([[-(rest + r), 0, -r * a, rest + r]])
        moves = mpmath.matrix([[1, 1, 0, 0], [0, 1, 0, 0], [-1, 0, 1 - a, 1], [0, 0, 0, 1]])
        moves += mpmath.matrix([[mpmath.mpf(1) / 2], [1], [0], [0]]) * u
        powers = [moves]
        while (powers[-1] * mpmath.matrix([0, 0, 0, 1]))[0] < 1:
            powers.append(powers[-1] * powers[-1])
        state, k = mpmath.matrix([0, 0, 0, 1]), 0
        for level in range(len(powers) - 1, -1, -1):  # as long as y rises, from there on too
            there = powers[level] * state
            if (moves * there - there)[0] > 0:
                state, k = there, k + 2**level
        return float(100 * ((moves * state)[0] - 1)), k + 1


@pytest.mark.parametrize(
    ("law", "wc_dt", "pm_deg"),
    [("pd", 1e-4, 40), ("pd", 1e-5, 55), ("pd", 1e-6, 70), ("lead", 1e-3, 50), ("lead", 1e-5, 40)],
)
def test_a_lead_far_below_nyquist_keeps_its_digits(law, wc_dt, pm_deg):
    dt = 2.0**-10
    wc = wc_dt / dt
    rest = 0.3 * wc * wc
    overshoot, k = first_crest(law, wc_dt, pm_deg, rest * dt * dt)
    columns = {"wc": np.array([wc]), "pm_deg": np.array([float(pm_deg)])}
    asked = {"dc_gain": rest} if law == "lead" else {}
    job = Job(
        plant=zoh.Plant(num=[1], den=[1, 0, 0]), law=law, dt=dt, asked=asked,
        varying=("wc", "pm_deg"),
    )  # fmt: skip
    for found in fast(job, columns):
        assert found["overshoot_pct"][0] == pytest.approx(overshoot, rel=1e-12)
        # within one sample: y there is flat, and 1e-16 of it hides many of them
        assert found["peak_time"][0] / dt == pytest.approx(k, rel=1e-6)


def fast(job, columns):
    """Yield what the fast arithmetics find."""
    yield arrays.run(job, columns)
    if find_spec("numba"):
        from zoh.batch.compiled import run as compiled

        yield compiled.run(job, columns, threads=1)


def highest(plant, controller, late, samples, parts=40):
    """Return (the highest y in % above its final value, the time of it in samples), dt being 1.

    The loop runs in time, 30 digits throughout: the plant by the exponential of its companion
    matrix, 40 times a sample, the controller as its difference equation. Beside the highest of
    those points the extreme of y is where the slope's sign changes, by bisection.
    """
    with mpmath.workdps(30):
        n, den = len(plant.den) - 1, [mpmath.mpf(c) for c in plant.den]
        above = [mpmath.mpf(c) for c in reversed(plant.num)]
        out = mpmath.matrix([above + [0] * (n + 1 - len(above))])
        rates = mpmath.zeros(n + 1)  # of the state and of the input, which is held
        for j in range(n - 1):
            rates[j, j + 1] = 1
        for j in range(n):
            rates[n - 1, j] = -den[n - j] / den[0]
        rates[n - 1, n] = 1 / den[0]
        moves = mpmath.expm(rates / parts)
        num, under = ([mpmath.mpf(c) for c in p] for p in (controller.num, controller.den))
        num = [mpmath.mpf(0)] * (len(under) - len(num)) + num
        e, u = [mpmath.mpf(0)] * len(num), [mpmath.mpf(0)] * len(num)
        z, best = mpmath.zeros(n + 1, 1), (mpmath.mpf(0), -2, None)
        for i in range(samples * parts):
            if i % parts == 0:
                e = [1 - (out * z)[0], *e[:-1]]
                u = [
                    (sum(b * x for b, x in zip(num, e, strict=True))
                     - sum(a * x for a, x in zip(under[1:], u, strict=False))) / under[0],
                    *u[:-1],
                ]  # fmt: skip
            if i % parts == round(late * parts):
                z[n] = u[0]
            after = moves * z
            if (out * after)[0] > best[0]:
                best = ((out * after)[0], i, (z.copy(), after))
            elif i == best[1] + 1:
                best = (*best[:2], (*best[2][:1], z.copy()))
            z = after
        y, i, starts = best

        def slope(t, start):
            return (out * rates * mpmath.expm(rates * t / parts) * start)[0]

        for start, first in zip(starts, (i, i + 1), strict=True):
            low, high = mpmath.mpf(0), mpmath.mpf(1)
            if slope(low, start) > 0 > slope(high, start):
                for _ in range(50):
                    half = (low + high) / 2
                    low, high = (half, high) if slope(half, start) > 0 else (low, half)
                y, i = (out * mpmath.expm(rates * low / parts) * start)[0], first + low - 1
        loop = sum(num) * mpmath.mpf(plant.num[-1]), sum(under) * den[-1]
        final = loop[0] / (loop[0] + loop[1])
        return float(100 * (y / final - 1)), float((i + 1) / parts)


def designed(plant, law, asked, late):
    """Return the controller, also where another crossover has the smaller margin."""
    try:
        return zoh.design(plant, law, asked, dt=1.0, compute_delay=late).controller
    except zoh.NotMet as missed:
        return missed.measured.controller


@pytest.mark.parametrize(
    ("num", "den", "law", "asked", "late"),
    [  # an extreme or two between two samples
        ([36.0], [1, 3, 36.0], "pi", {"pm_deg": 70, "wc": 0.8}, 0.0),
        ([6.1], [1, 0.036, 6.1, 0], "pi", {"pm_deg": 75.87, "wc": 0.12}, 0.0),
        ([1, 1.4], [1, 100.1, 2510, 250], "pi", {"pm_deg": 30.76, "wc": 0.54}, 0.5),
        # two turns in a sample, no pole's |s| dt above 1.2
        (
            [1.0, 4.776045594888618, 7.586530232448329, 4.007060643568795],
            [1.0, 2.3835740716628613, 2.0590257137498345, 0.7538924298895958, 0.09631788286506618],
            "pid",
            {"pm_deg": 62.835996687097385, "ki": 0.08959380775146512, "wc": 0.7635967849319336},
            0.0,
        ),
        (
            [1.0], [1, 1.777, 0.8367, 0.04567, 0.000612],
            zoh.Sampled(num=[9.11, -17.1, 10.335, -2.053], den=[1, 2.468, 1.306, 0.043], dt=1.0),
            {}, 0.0,
        ),
        # two real poles, the fast one far beyond where a series keeps its digits
        ([30.0], [1, 30.5, 15.0], "pi", {"pm_deg": 40, "wc": 0.84}, 0.0),
        ([39.0], [1, 39.5, 19.5], "pi", {"pm_deg": 40, "wc": 0.84}, 0.3),
    ],
)  # fmt: skip
def test_the_highest_between_samples_where_a_plant_is_fast(num, den, law, asked, late):
    plant, given = zoh.Plant(num=num, den=den), None
    if isinstance(law, zoh.Sampled):
        law, given = "given", law
    job = Job(
        plant=plant, law=law, asked=asked, dt=1.0, compute_delay=late, controller=given,
        varying=("plant.gain",),
    )  # fmt: skip
    columns = {"plant.gain": np.array([num[0] / den[0]])}
    controller = given or designed(plant, law, asked, late)
    overshoot, when = highest(plant, controller, late, samples=60)
    for found in (single.run(job, columns), *fast(job, columns)):
        # 1e-9: what the rounding of the controller's coefficients, in z and in w, moves y by
        assert found["between.overshoot_pct"][0] == pytest.approx(overshoot, rel=1e-9)
        # 1e-7: where a crest is, is known to half the digits of how high it is
        assert found["between.peak_time"][0] == pytest.approx(when, rel=1e-7)


def test_what_cannot_be_held_is_left_and_never_called_infeasible():
    # an unstable pole grows by e^158 within a sample, and takes all digits of the slow one with it
    plant = zoh.Plant(num=[1.0, 1.0958], den=[1, -157.92, -60.116])
    asked = {"pm_deg": 75.1, "ki": 0.00983, "wc": 0.0179}
    job = Job(plant=plant, law="pid", asked=asked, dt=1.0, varying=("plant.gain",))
    columns = {"plant.gain": np.array([1.0])}
    truth = single.run(job, columns)
    assert truth["reason"] == [Reason.UNSTABLE]
    assert [found["reason"].tolist() for found in fast(job, columns)] in (
        [[Reason.UNSTABLE]], [[Reason.UNSTABLE]] * 2,
    )  # fmt: skip


@pytest.mark.parametrize("varied", ["plant.gain", "plant.num.1"])
def test_a_response_that_dies_out_settles_to_nothing(varied):
    # a zero at s = 0: the loop is run sample by sample, y = 2 (2 x_2 - x_1)
    plant = zoh.Plant(num=[2.0, 0.0], den=[1, 3, 2])
    controller = zoh.Sampled(num=[0.1], den=[1], dt=0.1)
    job = Job(plant=plant, law="given", controller=controller, dt=0.1, varying=(varied,))
    with mpmath.workdps(30):
        step = mpmath.mpf(1) / 10
        slow, fast_ = mpmath.exp(-step), mpmath.exp(-2 * step)
        x, ys = [mpmath.mpf(0)] * 2, []
        for _ in range(100):
            ys.append(2 * (2 * x[1] - x[0]))  # of s/((s + 1)(s + 2)) = 2/(s + 2) - 1/(s + 1)
            u = step * (1 - ys[-1])
            x = [slow * x[0] + (1 - slow) * u, fast_ * x[1] + (1 - fast_) / 2 * u]
    for found in fast(job, {varied: np.array([2.0 if varied == "plant.gain" else 0.0])}):
        assert found["peak"][0] == pytest.approx(float(max(ys)), rel=1e-12)
        assert found["steady_state_error"][0] == 1.0
        for name in ("overshoot_pct", "rise_time", "settling_time", "between.overshoot_pct"):
            assert np.isnan(found[name][0]), name


@pytest.mark.parametrize("left", [0.0, -1e-12, 1e-12])
def test_a_final_value_of_next_to_nothing_has_no_time_to_it(left):
    # 0.3 - 0.1 - 0.2 is -2.8e-17 in floats: the loop moves by 0.03, and rests 1e-11 of it or less
    controller = zoh.Sampled(num=[0.3, -0.1, -0.2 + left], den=[1, -0.9, 0.1], dt=0.1)
    plant = zoh.Plant(num=[1.0], den=[1, 3, 2])
    job = Job(plant=plant, law="given", controller=controller, dt=0.1, varying=("plant.gain",))
    for found in fast(job, {"plant.gain": np.array([0.5])}):
        # L(1), which is y at rest but for its square
        at_rest = sum(map(Fraction, controller.num)) / sum(map(Fraction, controller.den)) / 4
        assert found["steady_state_error"][0] == pytest.approx(1 - float(at_rest), rel=1e-15)
        assert np.isnan(found["settling_time"][0])
        assert not found["rise_time"][0] < 0


def test_a_bend_is_bounded_by_hand():
    # 1/s^3 under an input u moves y'' by u t: over 1/2 it is x_2 + u/2 at most
    span, one = np.array([1.0, 0.5]), np.ones(2)
    num, den = np.zeros((4, 2)), np.zeros((4, 2))
    num[0], den[3] = one, one
    plant = held.held(num, den, one, np.zeros(2, np.int64), 0 * one)
    of_state, of_input = turns._curvature(plant, span * plant.samples)
    assert of_state.tolist() == [[0, 0], [0, 0], [1 / 8, 1 / 32]]
    assert of_input.tolist() == [1 / 8, 1 / 64]


@pytest.mark.parametrize(
    ("slope", "once"),
    [
        ([0.21, -1.0, 1.0], False),  # (t - 0.3)(t - 0.7)
        ([-0.21, 1.0, -1.0], False),
        ([0.51, -2.0, 1.0], True),  # (t - 0.3)(t - 1.7)
        ([0.3, -1.0, 0.0], True),
        ([2.0, -1.0, 1.0], True),  # never 0
        ([1e-14, -4e-14, 3.5e-14], True),  # below what a y of 1 is rounded by
        ([-0.105, 0.71, -1.5, 1.0], False),  # (t - 0.3)(t - 0.5)(t - 0.7)
    ],
)
def test_two_turns_are_seen_by_hand(slope, once):
    rows = np.array(slope)[:, None]
    assert between._turns_once(rows, np.ones(1)).tolist() == [once]


def test_the_fastest_pole_is_bounded_by_hand():
    dt = np.array([0.5, 1.0, 1.1, 1.3])
    # a pole at -1 four times over, and the pair +-j beside -0.1: |s| dt is dt
    four = np.repeat([[1.0], [4.0], [6.0], [4.0], [1.0]], 4, axis=1)
    pair = np.repeat([[0.1], [1.0], [0.1], [1.0]], 4, axis=1)
    for den in (four, pair):
        bound = _fastest(_rates(den, dt))
        assert (bound >= dt).all()
        assert (bound[1:] <= 1.17 * dt[1:]).all()


def test_two_real_poles_turn_once_however_fast():
    # s^2 + 5 s + 4, s^2 + 2 s + 1, s^2 + s + 1, s + 9, and three real poles
    two = np.array([[4.0, 1.0, 1.0], [5.0, 2.0, 1.0], [1.0, 1.0, 1.0]])
    assert _turns_once(two).tolist() == [True, True, False]
    assert _turns_once(np.array([[9.0], [1.0]])).tolist() == [True]
    assert _turns_once(np.array([[6.0], [11.0], [6.0], [1.0]])).tolist() == [False]


def crest_in_50_digits(gain, a, design):
    """Return when the output of K/(s (s + a)) behind a hold first turns, by its two states."""
    with mpmath.workdps(50):
        gain, a, dt = mpmath.mpf(gain), mpmath.mpf(a), mpmath.mpf(design.controller.dt)
        num = [mpmath.mpf(c) for c in design.controller.num]
        den = [mpmath.mpf(c) for c in design.controller.den]
        fall, y, v, k = mpmath.exp(-a * dt), mpmath.mpf(0), mpmath.mpf(0), 0
        errors, efforts = [mpmath.mpf(0)] * len(num), [mpmath.mpf(0)] * len(den)
        while True:
            errors, efforts = [1 - y, *errors[:-1]], [mpmath.mpf(0), *efforts[:-1]]
            total = sum(c * e for c, e in zip(num, errors, strict=True))
            efforts[0] = (total - sum(c * u for c, u in zip(den, efforts, strict=True))) / den[0]
            rest = gain * efforts[0] / a
            later = rest + (v - rest) * fall
            if v > 0 > later:
                return float(k * dt + mpmath.log((rest - v) / rest) / a)
            y, v, k = y + rest * dt + (v - rest) * (1 - fall) / a, later, k + 1


@pytest.mark.parametrize(
    "at",
    [  # 6e-7 of a sample behind one, and where Newton's method ends on the crest to the last bit
        (0.041925423656474475, 0.14174282414456899, 0.7200927976256158, 1.885186046336924,
         41.1561806038065, 1.2512216158371106),
        (0.14938030266859018, 0.12688613345711242, 0.7034237235631398, 2.333284870667704,
         40.47861213152852, 0.9869772246117472),
    ],
)  # fmt: skip
def test_when_a_crest_is_to_eleven_digits(at):
    names = ("dt", "plant.num.0", "plant.den.1", "wc", "pm_deg", "ki")
    dt, gain, a, wc, pm_deg, ki = at
    design = zoh.pid(zoh.Plant(num=[gain], den=[1, a, 0]), dt=dt, wc=wc, pm_deg=pm_deg, ki=ki)
    job = Job(plant=zoh.Plant(num=[1], den=[1, 1, 0]), law="pid", dt=dt, varying=names)
    columns = {name: np.array([x]) for name, x in zip(names, at, strict=True)}
    truth = crest_in_50_digits(gain, a, design)
    for found in fast(job, columns):
        assert found["between.peak_time"][0] == pytest.approx(truth, rel=1e-11)


def rise_in_30_digits(gain, dt):
    """Return the rise in s of gain/(s (s^2 + s/16 + 1)) in unity feedback, held: each sample."""
    with mpmath.workdps(30):
        rates = mpmath.matrix(
            [[0, 1, 0, 0], [0, 0, 1, 0], [0, -1, -mpmath.mpf(1) / 16, 1], [0] * 4]
        )
        moves = [[x for x in row] for row in mpmath.expm(rates * dt).tolist()[:3]]
        state, reached = [mpmath.mpf(0)] * 3, []
        for k in range(20_000):
            if (
                len(reached) < 2
                and state[0] >= (mpmath.mpf("0.1"), mpmath.mpf("0.9"))[len(reached)]
            ):
                reached.append(k)
            if len(reached) == 2:
                return float((reached[1] - reached[0]) * dt)
            z = [*state, gain * (1 - state[0])]
            state = [mpmath.fdot(row, z) for row in moves]
    raise AssertionError


@pytest.mark.parametrize("beyond", [-1e-6, 1e-6, 1e-5, 1e-4])
def test_a_crest_that_is_90_percent_high_for_less_than_a_stride_ends_the_rise(beyond):
    # at this gain a crest of the swing on the rise is 0.9 high, and the next one comes 1.4 s later
    gain, dt = 0.021513271226745 * (1 + beyond), 2.0**-7
    plant = zoh.Plant(num=[gain], den=[1, 0.0625, 1, 0])
    job = Job(plant=plant, law="given", controller=zoh.Sampled(num=[1], den=[1], dt=dt), dt=dt,
              varying=("dt",))  # fmt: skip
    columns = {"dt": np.array([dt])}
    truth = rise_in_30_digits(gain, dt)
    for found in (single.run(job, columns), *fast(job, columns)):
        assert found["rise_time"][0] == truth


NARROW = [  # dt, samples of delay, gain of the plant, gain of the controller
    (0.006003089532626517, 0.5, 0.24409277094113924, 0.053752093413025295),
    (0.0004592418667064479, 0.3, 0.5140631652594367, 3.674954151892555),
]


@pytest.mark.parametrize(("dt", "late", "gain", "k"), NARROW)
def test_a_narrow_peak_of_t_is_met_to_its_last_digits(dt, late, gain, k):
    """A tiny step of Newton's is followed by halvings from afar: the last of them is no end."""
    pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")
    from zoh.batch.compiled import run as compiled

    controller = zoh.Sampled(num=[k, -0.875 * k], den=[1, -0.7], dt=0.1)
    columns = {"dt": np.array([dt]), "compute_delay": np.array([late * dt])}
    columns["plant.gain"] = np.array([gain])
    job = Job(
        plant=zoh.Plant(num=[1.0], den=[1.0, 0.0, 0.0]), law="given", controller=controller,
        dt=0.1, varying=tuple(columns),
    )  # fmt: skip
    truth = highest_t(mpmath.mpf(dt), mpmath.mpf(late * dt), gain, controller)
    for way in (arrays, compiled):
        assert way.run(job, columns)["mt"][0] == pytest.approx(truth, rel=1e-9)


def highest_t(dt, delay, gain, controller):
    """Return max |T| of a double integrator in 50 digits, by a grid and thirds.

    Held for dt - delay it moves by the last input, before that by the one before.
    """
    with mpmath.workdps(50):
        last = dt - delay
        num, den = ([mpmath.mpf(c) for c in a] for a in (controller.num, controller.den))

        def size(w):
            z = mpmath.expj(w * dt)
            # x1 moves by x2 dt + u last^2/2 + u_1 (dt^2 - last^2)/2, x2 by u last + u_1 delay
            speed = (last + delay / z) / (z - 1)
            place = (dt * speed + last**2 / 2 + (dt**2 - last**2) / 2 / z) / (z - 1)
            loop = gain * place * (num[0] * z + num[1]) / (den[0] * z + den[1])
            return abs(loop / (1 + loop))

        grid = [mpmath.mpf(10) ** (mpmath.mpf(i) / 500) * 1e-5 / dt for i in range(2600)]
        best = max(range(1, len(grid) - 1), key=lambda i: size(grid[i]))
        low, high = grid[best - 1], grid[best + 1]
        for _ in range(120):
            left, right = (2 * low + high) / 3, (low + 2 * high) / 3
            low, high = (left, high) if size(left) < size(right) else (low, right)
        return float(size(low))


def test_a_loop_at_a_ten_thousandth_of_its_limit_is_the_single_designs():
    # Ms is 9601, and rounding of 1e-13 in L was 2.7e-9 of the peak effort
    if find_spec("numba") is None:
        pytest.skip("the compiled arithmetic needs numba: zoh[fast]")
    from zoh.batch.compiled import run as compiled

    controller = zoh.Sampled(
        num=(5542685.977883064, -7597899.971406108, 4965827.035784662, -1119317.269705678),
        den=(1.0000000000099658, 4.720598770800832, 3.818028161730096, 0.3108016179606703),
        dt=0.045565181264452255,
    )
    plant = zoh.Plant(
        num=[1.407165913236862],
        den=[1, 10.205159738686298, 16.312686571305182, 8.694304945922593, 1.407165913236862],
    )
    columns = {"plant.gain": 1.3850382674772288 * np.array([1.0, 1.0001, 1.0002, 1.0003])}
    job = Job(
        plant=plant, law="given", controller=controller, dt=controller.dt, varying=tuple(columns)
    )
    truth = single.run(job, columns)
    (sharp,) = np.nonzero(truth["ms"] > 2000)
    assert len(sharp) == 4
    for way in (arrays, compiled):
        found = way.run(job, columns)
        for name in ("peak_effort", "between.overshoot_pct"):
            assert found[name][sharp].tolist() == truth[name][sharp].tolist()


FAST = [  # law, b1, b0, a1, a0, what is asked: one real pole falls to 1/10 to 1/100 in a sample
    ("lead", 0.0, 5.817151054075037, 4.0032272054168665, 0.0, {
        "dt": 0.828642406930723, "wc": 3.004002427702014, "pm_deg": 28.075228489787794,
        "dc_gain": 0.08614599020746615,
    }),
    ("lead", -1.2607461109507674, 3.567666909846711, 5.0160231861399325, 5.406981182857899, {
        "dt": 1.0937895486351126, "wc": 2.122546153133021, "pm_deg": 56.04400679081602,
        "dc_gain": 0.2476302158140439,
    }),
    ("pi", -0.9862366514215456, 0.2845218047906153, 6.095247426393025, 3.0734447967389036, {
        "dt": 0.8408248436979445, "wc": 0.3047090040248935, "pm_deg": 28.58130877018995,
    }),
]  # fmt: skip


@pytest.mark.parametrize(("law", "b1", "b0", "a1", "a0", "asked"), FAST)
def test_of_two_crests_of_a_fast_pole_the_higher_one_is_taken(law, b1, b0, a1, a0, asked):
    # a cubic through the ends of a sample had the crest of another sample for the highest
    ways = [arrays]
    if find_spec("numba"):
        from zoh.batch.compiled import run as compiled

        ways.append(compiled)
    plant = zoh.Plant(num=(b1, b0), den=(1.0, a1, a0))
    columns = {name: np.array([value]) for name, value in asked.items()}
    job = Job(plant=plant, law=law, dt=0.1, varying=tuple(columns))
    design = getattr(zoh, law)(plant, **asked)
    over, when = highest_between(b1, b0, a1, a0, asked["dt"], design.controller)
    for way in ways:
        found = way.run(job, columns)
        # 1e-9: what every figure of a sweep is promised to
        assert found["between.overshoot_pct"][0] == pytest.approx(100 * (over - 1), rel=1e-9)
        # 1e-7: where the top is flat, the last half of the digits say nothing of its time
        assert found["between.peak_time"][0] == pytest.approx(when, rel=1e-7)


def highest_between(b1, b0, a1, a0, dt, controller):
    """Return (the highest y over its final value, its time), in 40 digits; y is b0 x1 + b1 x2."""
    with mpmath.workdps(40):
        a = mpmath.matrix([[0, 1, 0], [-mpmath.mpf(a0), -mpmath.mpf(a1), 1], [0, 0, 0]])
        out, step = mpmath.matrix([[b0, b1, 0]]), mpmath.expm(a * mpmath.mpf(dt))
        num, den = ([mpmath.mpf(c) for c in row] for row in (controller.num, controller.den))
        final = b0 * sum(num) / (b0 * sum(num) + a0 * sum(den))
        x, before, best = mpmath.matrix([0, 0, 0]), (mpmath.mpf(0), mpmath.mpf(0)), (0, 0)
        for k in range(60):
            error = 1 - (out * x)[0]
            x[2] = (num[0] * error + num[1] * before[0] - den[1] * before[1]) / den[0]
            before = error, x[2]

            def slope(t, x=x):
                return (out * a * mpmath.expm(a * t) * x)[0]

            if slope(mpmath.mpf(0)) > 0 > slope(mpmath.mpf(dt)):  # two real poles turn once
                low, high = mpmath.mpf(0), mpmath.mpf(dt)
                for _ in range(70):
                    middle = (low + high) / 2
                    low, high = (middle, high) if slope(middle) > 0 else (low, middle)
                best = max(best, ((out * mpmath.expm(a * low) * x)[0] / final, k * dt + low))
            x = step * x
            best = max(best, ((out * x)[0] / final, (k + 1) * dt))
        return float(best[0]), float(best[1])


SLOW = [  # b1, b0, a1, a0, dc_gain, wc, pm_deg, and % of overshoot by a dense simulation of its own
    (0.997, 0.00369, 0.798, 0.0106, 15.95, 0.642, 116.0, 0.0247404),
]


@pytest.mark.parametrize(("b1", "b0", "a1", "a0", "dc_gain", "wc", "pm_deg", "over"), SLOW)
def test_a_slow_response_whose_slope_leaps_is_seen_at_every_sample(
    b1, b0, a1, a0, dc_gain, wc, pm_deg, over
):
    # at a long stride the one crest that is above the final value was stepped over
    ways = [arrays]
    if find_spec("numba"):
        from zoh.batch.compiled import run as compiled

        ways.append(compiled)
    columns = {"wc": np.array([wc])}
    plant = zoh.Plant(num=(b1, b0), den=(1.0, a1, a0))
    asked = {"pm_deg": pm_deg, "dc_gain": dc_gain}
    job = Job(plant=plant, law="lag", asked=asked, dt=1.0, varying=("wc",))
    (truth,) = single.run(job, columns)["between.overshoot_pct"]
    assert truth == pytest.approx(over, abs=1e-7)  # the digits that are printed of it
    for way in ways:
        assert way.run(job, columns)["between.overshoot_pct"][0] == pytest.approx(truth, rel=1e-9)


@pytest.mark.parametrize(
    ("num", "den", "gain", "controller"),
    [
        ([37.5], [1, 37.5], 37.5, zoh.Sampled(num=[1.0], den=[1.0], dt=1.0)),
        ([0.15], [1, -0.45], 0.15000000000000002, zoh.Sampled(num=[3.0], den=[1.0], dt=1.0)),
    ],
)
def test_one_rounding_from_the_limit_floats_do_not_decide(num, den, gain, controller):
    ways = [arrays]
    if find_spec("numba"):
        from zoh.batch.compiled import run as compiled

        ways.append(compiled)
    plant = zoh.Plant(num=num, den=den)
    job = Job(
        plant=plant, law="given", controller=controller, dt=1.0, varying=("plant.gain",),
    )  # fmt: skip
    columns = {"plant.gain": np.array([gain])}
    truth = single.run(job, columns)
    assert truth["stable"].all()
    for way in ways:
        assert way.run(job, columns)["reason"].tolist() == truth["reason"].tolist()
