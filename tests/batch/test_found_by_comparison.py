"""Loops on which an arithmetic once differed from the single design: each by another road, too."""

from importlib.util import find_spec

import mpmath
import numpy as np
import pytest

import zoh
from zoh.batch import single
from zoh.batch.arrays import run as arrays
from zoh.batch.job import Job

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


@pytest.mark.parametrize(
    ("num", "den", "law", "asked", "dt", "late", "scanned"),
    [
        # an extreme or two between two samples, the highest of 2000 points of each by SciPy's expm
        ([36.0], [1, 3, 36.0], "pi", {"pm_deg": 70, "wc": 0.8}, 1.0, 0.0, 38.817716),
        ([6.1], [1, 0.036, 6.1, 0], "pi", {"pm_deg": 75.87, "wc": 0.12}, 1.0, 0.0,
         16.456292),
        ([1, 1.4], [1, 100.1, 2510, 250], "pi", {"pm_deg": 30.76, "wc": 0.54}, 1.0, 0.5,
         49.726095),
    ],
)  # fmt: skip
@pytest.mark.parametrize("arithmetic", ["arrays", "compiled"])
def test_a_plant_that_turns_more_than_once_in_a_sample(
    num, den, law, asked, dt, late, scanned, arithmetic
):
    if arithmetic == "compiled":
        pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")
    plant, wc = zoh.Plant(num=num, den=den), asked["wc"]
    rest = {key: value for key, value in asked.items() if key != "wc"}
    fast, single = (
        zoh.sweep(plant, law, rest, dt=dt, compute_delay=late, over={"wc": [wc]}, arithmetic=by)
        for by in (arithmetic, "single")
    )
    for name in ("reason", "between.overshoot_pct", "between.peak_time", "overshoot_pct"):
        assert fast[name] == pytest.approx(single[name], rel=1e-9, nan_ok=True), name
    # 3e-6: the points beside the highest one
    assert fast["between.overshoot_pct"][0] == pytest.approx(scanned, rel=3e-6)


def test_the_fastest_pole_is_bounded_by_hand():
    dt = np.array([0.5, 1.0, 1.1, 1.3])
    # a pole at -1 four times over, and the pair +-j beside -0.1: |s| dt is dt
    four = np.repeat([[1.0], [4.0], [6.0], [4.0], [1.0]], 4, axis=1)
    pair = np.repeat([[0.1], [1.0], [0.1], [1.0]], 4, axis=1)
    for den in (four, pair):
        bound = arrays._fastest(den, dt)
        assert (bound >= dt).all()
        assert (bound[1:] <= 1.17 * dt[1:]).all()


def test_two_real_poles_turn_once_however_fast():
    # s^2 + 5 s + 4, s^2 + 2 s + 1, s^2 + s + 1, s + 9, and three real poles
    two = np.array([[4.0, 1.0, 1.0], [5.0, 2.0, 1.0], [1.0, 1.0, 1.0]])
    assert arrays._turns_once(two).tolist() == [True, True, False]
    assert arrays._turns_once(np.array([[9.0], [1.0]])).tolist() == [True]
    assert arrays._turns_once(np.array([[6.0], [11.0], [6.0], [1.0]])).tolist() == [False]


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
