"""Every point is a controller as promised, and every such controller is a point."""

from math import degrees, exp, log, pi, tan

import numpy as np
import pytest

from zoh.choice.freedom import SECOND, SLOWEST, Freedom
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample
from zoh.solving import solved
from zoh.spec import Crossover

DT = 0.1
PLANTS = {
    "arm": sample(Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180), DT),
    "lag": sample(Plant(num=[2.0], den=[3.0, 1.0]), DT),
    "late": sample(Plant(num=[1.0], den=[1.0, 2.0, 5.0], dead_time=0.13), DT),
    "two integrators": sample(Plant(num=[1.0, 0.3], den=[1.0, 40.0, 0.0, 0.0]), DT),
}
OPEN = ("pi", "pd", "pid", "lead", "lag")  # whose every controller is a point
POINTS = (*OPEN, "leadlag")


def warped(wc):
    return 2 / DT * tan(wc * DT / 2)


def slowest_zero(controller):
    return min(-np.roots(controller.num_w).real, default=np.inf)


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("law", POINTS)
def test_a_point_is_a_controller_that_crosses_over_as_said(law, name):
    rng, plant, seen = np.random.default_rng(5), PLANTS[name], 0
    for wc in np.geomspace(0.05, 25, 25):
        freedom = Freedom.of(law, plant, float(wc), {}, 30.0)
        if freedom is None:
            continue
        assert freedom.size == 1 + (law in SECOND)
        for x in (*np.eye(freedom.size), *rng.uniform(0, 1, (8, freedom.size))):
            found = freedom.parameters(x.tolist())
            assert 30 <= found["pm_deg"] < 180
            spec = Crossover(wc=float(wc), pm_deg=found["pm_deg"])
            controller = solved(law, plant, spec, found).controller
            gain = controller.at(float(wc)) * plant.at(float(wc))
            assert abs(gain) == pytest.approx(1, rel=1e-9)
            turned = np.remainder(np.degrees(np.angle(gain)) + 180 - found["pm_deg"] + 180, 360)
            assert turned - 180 == pytest.approx(0, abs=1e-8)  # deg, of a sum of several
            assert min(*controller.num_w, *controller.den_w) >= 0
            # 1e-5: ends of open intervals are left out by 1e-6
            assert slowest_zero(controller) >= SLOWEST * warped(wc) * (1 - 1e-5)
            seen += 1
    assert seen > 20


def drawn(law, rng):
    """Return (num_w, den_w) with positive gains."""
    a, b, c = np.exp(rng.uniform(log(1e-2), log(1e2), 3)).tolist()
    if law == "pi":
        return (1.0, a), (1.0, 0.0)
    if law == "pd":
        return (DT / 2 + a, 1.0), (DT / 2, 1.0)
    if law == "pid":
        return (a * DT / 2 + b, a + c * DT / 2, c), (DT / 2, 1.0, 0.0)
    w0, wp = (min(a, b), max(a, b)) if law == "lead" else (max(a, b), min(a, b))
    return (wp / w0, wp), (1.0, wp)


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("law", OPEN)
def test_no_controller_is_left_out(law, name):
    rng, plant, seen = np.random.default_rng(6), PLANTS[name], 0
    for _ in range(3000):
        num, den = drawn(law, rng)
        wc = exp(rng.uniform(log(0.05), log(25)))
        shape = Sampled.from_w(num_w=num, den_w=den, dt=DT)
        size = 1 / abs(shape.at(wc) * plant.at(wc))
        pm = degrees(np.angle(-shape.at(wc) * plant.at(wc)))
        if not 31 < pm < 178 or slowest_zero(shape) < SLOWEST * warped(wc) * 1.001:
            continue
        freedom = Freedom.of(law, plant, wc, {}, 30.0)
        assert freedom is not None
        assert freedom.pm[0] <= pm <= freedom.pm[1]
        if law in SECOND:
            wanted = size * (num[-1] if law == "pid" else num[-1] / den[-1])
            x = ((pm - freedom.pm[0]) / (freedom.pm[1] - freedom.pm[0])) ** (2 / 3)
            ends = [freedom.parameters((x, e))[SECOND[law]] for e in (0.0, 1.0)]
            # a lag or lead with a ratio beyond exp(9), or next to none, is not reached
            if law == "pid" or max(num[0] / num[1] * warped(wc), 1) < 50:
                assert min(ends) * 0.99 <= wanted <= max(ends) * 1.01
        seen += 1
    assert seen > 30


def test_what_is_given_is_no_coordinate():
    plant = PLANTS["arm"]
    assert Freedom.of("pid", plant, 2.0, {"pm_deg": 50.0, "ki": 1.0}, 0.0).size == 0
    fixed = Freedom.of("pid", plant, 2.0, {"pm_deg": 50.0}, 0.0)
    assert (fixed.size, fixed.pm) == (1, (50.0, 50.0))
    assert fixed.parameters((0.5,))["pm_deg"] == 50.0
    assert Freedom.of("pid", plant, 2.0, {"ki": 1.0}, 0.0).size == 1
    assert (
        Freedom.of("lead", plant, 2.0, {"dc_gain": 10.0}, 0.0).parameters((0.5,))["dc_gain"] == 10
    )
    own = Freedom.of("p", plant, 0.5, {}, 0.0)
    assert (own.size, own.pm[0]) == (0, pytest.approx(degrees(np.angle(-plant.at(0.5))), abs=1e-9))


def test_where_a_law_can_nothing_there_is_no_freedom():
    plant = PLANTS["arm"]
    assert Freedom.of("pi", plant, 5.0, {}, 45.0) is None  # it would have to lead
    assert Freedom.of("pid", plant, pi / DT, {}, 45.0) is None
    assert Freedom.of("p", plant, 0.5, {}, 80.0) is None
    assert Freedom.of("pi", plant, 0.5, {"pm_deg": 100.0}, 0.0) is None
    shared = Sampled(num=[1.0, -1.2, 1.0], den=[1.0, 0.0, 0.0], dt=DT)  # zeros on the circle
    assert Freedom.of("pi", shared, float(np.arccos(0.6) / DT), {}, 0.0) is None
