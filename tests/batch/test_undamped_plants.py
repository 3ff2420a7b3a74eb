"""Plants with undamped poles: |S| is 0 on the axis there, and rounding hides where."""

from importlib.util import find_spec

import mpmath
import numpy as np
import pytest

import zoh
from zoh.batch.arrays import modes, peaks
from zoh.batch.backend import WAYS
from zoh.batch.reason import Reason

SWING = zoh.Plant(num=[1], den=[1, 0, 1])
INSTALLED = [way.name for way in WAYS if way.needs is None or find_spec(way.needs)]
FAST = [name for name in INSTALLED if name != "single"]


def peaks_in_30_digits(num, den, dt):
    """Return (Ms, Mt, disk margin) of a controller on 1/(s^2 + 1), held.

    Its hold is (1 - cos dt)(z + 1)/(z^2 - 2 cos dt z + 1): Astrom, Wittenmark, Computer-Controlled
    Systems, 3rd ed., table 2.1. Each is looked for on a grid, then by thirds.
    """
    with mpmath.workdps(30):
        c = mpmath.cos(mpmath.mpf(dt))
        num, den = ([mpmath.mpf(x) for x in p] for p in (num, den))

        def parts(w):
            z = mpmath.expj(w * dt)
            n, d = (sum(x * z**k for k, x in enumerate(reversed(p))) for p in (num, den))
            return n * (1 - c) * (z + 1), d * (z * z - 2 * c * z + 1)

        def least(size):
            grid = [mpmath.pi / dt * k / 3000 for k in range(1, 3001)]
            best = min(range(len(grid)), key=lambda k: size(grid[k]))
            low, high = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
            for _ in range(90):
                left, right = (2 * low + high) / 3, (low + 2 * high) / 3
                low, high = (low, right) if size(left) < size(right) else (left, high)
            return size(low)

        def below(choice):
            def size(w):
                n, d = parts(w)
                return abs(n + d) / abs(choice(n, d))

            return least(size)

        of_s = below(lambda n, d: d)
        of_t = below(lambda n, d: n)
        return float(1 / of_s), float(1 / of_t), float(2 * below(lambda n, d: d - n))


@pytest.mark.parametrize(
    ("num", "den", "dt"),
    [([-0.1], [1], 1.0), ([0.3, -0.35], [1, -0.2], 0.1), ([2.0, -1.9], [1, 0.3], 0.1)],
)
@pytest.mark.parametrize("arithmetic", INSTALLED)
def test_the_peaks_beside_an_undamped_pole(num, den, dt, arithmetic):
    ms, mt, disk = peaks_in_30_digits(num, den, dt)
    controller = zoh.Sampled(num=num, den=den, dt=dt)
    found = zoh.sweep(
        SWING, "given", controller=controller, over={"plant.gain": [1.0]}, arithmetic=arithmetic
    )
    assert found["reason"].tolist() == [Reason.OK]
    assert found["ms"][0] == pytest.approx(ms, rel=1e-10)
    assert found["modulus_margin"][0] == pytest.approx(1 / ms, rel=1e-10)
    assert found["mt"][0] == pytest.approx(mt, rel=1e-10)
    assert found["disk_margin"][0] == pytest.approx(disk, rel=1e-10)


@pytest.mark.parametrize("arithmetic", FAST)
def test_no_loop_of_many_on_a_swing_has_an_ms_below_1(arithmetic):
    over = {"wc": np.linspace(1.05, 3, 200)}
    found = zoh.sweep(SWING, "pd", {"pm_deg": 50}, dt=0.1, over=over, arithmetic=arithmetic)
    assert (found["reason"] == Reason.OK).all()
    assert (found["ms"] > 1).all()
    some = slice(None, None, 40)
    truth = zoh.sweep(
        SWING, "pd", {"pm_deg": 50}, dt=0.1, over={"wc": over["wc"][some]}, arithmetic="single"
    )
    for name in ("ms", "mt", "disk_margin", "modulus_margin"):
        assert found[name][some] == pytest.approx(truth[name], rel=1e-10)


def test_a_quotient_by_what_rounding_left_of_a_double_root_is_no_least():
    # (q - 1)^2 but for a rounding, which is below 0 beside 1; 2 + q^2 by it falls to 1 far away
    a = np.array([[2.0], [0.0], [1.0]])
    b = np.array([[1 - 2.0**-52], [-2.0], [1.0]])
    v, doubt = peaks.lowest(a, [b])
    assert v.tolist() == [[np.inf]]
    assert doubt.tolist() == [[False]]


def test_a_peak_beside_an_undamped_pole_is_left_where_rounding_may_have_made_it():
    # (q - 1)^2 + 1e-13 by (q - 1)^2 + 1e-12 is 0.1 at 1, and 1 elsewhere
    a, b = (np.array([[1 + more], [-2.0], [1.0]]) for more in (1e-13, 1e-12))
    _, doubt = peaks.lowest(a, [b])
    assert doubt.tolist() == [[True]]


@pytest.mark.parametrize("arithmetic", INSTALLED)
@pytest.mark.parametrize(
    ("law", "asked"),
    [("pi", {}), ("pd", {}), ("pid", {"ki": 0.1}), ("lag", {"dc_gain": 3}),
     ("lead", {"dc_gain": 0.1})],
)  # fmt: skip
def test_a_crossover_on_an_undamped_pole_is_no_request(law, asked, arithmetic):
    plant = zoh.Plant(num=[1], den=[1, 0, 1, 0])
    with pytest.raises(zoh.SpecError, match="wc must be where the plant has a gain"):
        zoh.design(plant, law, {"wc": 1.0, "pm_deg": 45, **asked}, dt=0.1)
    found = zoh.sweep(
        plant, law, {"pm_deg": 45, **asked}, dt=0.1, over={"wc": [1.0]}, arithmetic=arithmetic
    )
    assert found["reason"].tolist() == [Reason.MALFORMED]


@pytest.mark.parametrize("arithmetic", FAST)
@pytest.mark.parametrize("beside", [1e-12, 1e-9, 1e-6, 1e-3, 0.1])
def test_a_crossover_beside_an_undamped_pole_has_the_gains_of_the_single_design(beside, arithmetic):
    asked = {"over": {"wc": [1 - beside, 1 + beside]}, "dt": 0.1}
    truth = zoh.sweep(SWING, "pd", {"pm_deg": 50}, arithmetic="single", **asked)
    found = zoh.sweep(SWING, "pd", {"pm_deg": 50}, arithmetic=arithmetic, **asked)
    assert found["reason"].tolist() == truth["reason"].tolist()
    for name in ("gains.kp", "gains.kd", "ms"):
        assert found[name] == pytest.approx(truth[name], rel=1e-9, nan_ok=True)


@pytest.mark.parametrize(
    ("decay", "turn", "left"),
    [
        (1e-7, 1e-2, True),  # 9.2e7 samples to its rest, at a stride of 25 at most
        (1e-6, 1e-2, True),  # 9.2e6: at a stride of 25 less than 1e6, at one of 3 more
        (1e-4, 1e-2, False),  # 9.2e4
        (1e-7, 1.0, True),  # 9.2e7, and no stride
        (3e-5, 1.0, False),  # 3.1e5
        (1e-9, 0.0, False),  # it creeps: a few samples show it
    ],
)
def test_what_may_have_no_rest_within_a_million_samples_by_hand(decay, turn, left):
    z = np.exp(np.array([[-decay + 1j * turn], [-decay - 1j * turn], [-1.0]]))
    assert modes.restless(z).tolist() == [left]


def test_a_swing_without_a_rest_has_one_settling_time_in_every_arithmetic():
    # closed, a pole is beside the undamped zero: |z| is 1 - 7e-8 there, and its swing within 2 %
    plant = zoh.Plant(num=[1, 0, 1.4904335264800324], den=[1, 0, 3.0295523025717, 0, 2.1666858305])
    over = {"wc": [9.279319214673976]}
    every = [
        zoh.sweep(plant, "pd", {"pm_deg": 21.5}, dt=0.0019332386, over=over, arithmetic=arithmetic)
        for arithmetic in INSTALLED
    ]
    for found in every:
        assert found["reason"].tolist() == [Reason.OFF_TARGET]
        for name in ("settling_time", "rise_time", "overshoot_pct"):
            assert np.array_equal(found[name], every[0][name], equal_nan=True)
