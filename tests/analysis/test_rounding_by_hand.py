"""The bounds of rounding, each against its law in z, worked in 50 digits."""

from dataclasses import replace
from itertools import pairwise
from math import inf, pi

import pytest
from mpmath import mp, mpf

from zoh.analysis import rounding
from zoh.analysis.loop import Loop
from zoh.analysis.margins import measure_loop
from zoh.lti.systems import Plant, Sampled
from zoh.lti.wplane import warp

HALF_A_UNIT = mpf(2) ** -53
DT = 0.5
# the leading 1 and 0.25 are short and meant as they stand, the others are rounded
NUM, DEN = (0.1, 0.07), (1.0, -0.9, 0.25, 0.02)
GIVEN = Sampled(num=NUM, den=DEN, dt=DT)
LOOP = Loop.of(GIVEN)
OF_NUM, OF_DEN = mpf(0.1) + mpf(0.07), mpf(0.9) + mpf(0.02)  # their sizes
FREQUENCIES = [0.01, 0.7, 2.0, 5.5, pi / DT]


@pytest.fixture(autouse=True)
def _fifty_digits():
    with mp.workdps(50):
        yield


def near(value, rel=1e-12):
    """Return a value as it should come out; the least of a sum that cancels has 12 digits."""
    return pytest.approx(float(value), rel=rel, abs=0)


def poly(a, z):
    """Return a(z), its coefficients in descending powers."""
    return sum(mpf(c) * z**k for k, c in enumerate(reversed(a)))


def valued(a, w):
    """Return a(z) at z = exp(j w dt)."""
    return poly(a, mp.expj(mpf(w) * DT))


def at(w):
    """Return (num, den, part of the one, part of the other) at w in rad/s."""
    num, den = valued(NUM, w), valued(DEN, w)
    return num, den, HALF_A_UNIT * OF_NUM / abs(num), HALF_A_UNIT * OF_DEN / abs(den)


def slopes(w, f):
    """Return the derivative of log f(w) with respect to v = (2/dt) tan(w dt/2)."""
    return mp.diff(lambda x: mp.log(f(x)), w) * mp.cos(mpf(w) * DT / 2) ** 2


def open_loop(w):
    return valued(NUM, w) / valued(DEN, w)


def place(w):
    """Return (v, num, den) as the loop has them; their common factor is in no bound."""
    v = warp(w, DT)
    return v, *LOOP.point(v)


@pytest.mark.parametrize("w", FREQUENCIES)
def test_half_a_unit_of_each_coefficient(w):
    _, _, of_num, of_den = at(w)
    v = inf if w == pi / DT else warp(w, DT)
    assert rounding._parts(LOOP, v) == (near(of_num), near(of_den))


def test_the_parts_of_two_factors_add_up_and_those_of_a_made_one_do_not():
    other = Sampled(num=[0.3], den=[1, -0.7], dt=DT)
    made = Sampled.from_w(num_w=(2.0, 1.0), den_w=(1.0, 3.0), dt=DT)
    w = 0.7
    _, _, of_num, of_den = at(w)
    more_num = HALF_A_UNIT * mpf(0.3) / mpf(0.3)
    more_den = HALF_A_UNIT * mpf(0.7) / abs(valued((1, -0.7), w))
    both = Loop.of(GIVEN, made, other)
    wanted = near(of_num + more_num), near(of_den + more_den)
    assert rounding._parts(both, warp(w, DT)) == wanted
    assert rounding._parts(Loop.of(made), warp(w, DT)) == (0.0, 0.0)


def test_a_part_of_nothing():
    assert rounding._part((0.1,), 0.0) == inf
    assert rounding._part((0.5,), 0.0) == 0.0
    assert rounding._part((0.5, -3.0), 1.0) == 0.0
    assert rounding._part((-0.1, 0.3), 2.0) == near(HALF_A_UNIT * (mpf(0.1) + mpf(0.3)) / 2)


@pytest.mark.parametrize(
    ("c", "exact"),
    [(2.0**32 - 1, True), (2.0**32 + 1, False), (2.0**40, True), (1 + 2.0**-31, True),
     (1 + 2.0**-32, False), (-0.75, True), (-0.7, False)],
)  # fmt: skip
def test_a_coefficient_of_32_bits_is_meant_as_it_stands(c, exact):
    assert rounding._exact(c) is exact


@pytest.mark.parametrize("w", FREQUENCIES[:-1])
def test_how_steep_gain_and_phase_are(w):
    _, _, of_num, of_den = at(w)
    slope = slopes(w, open_loop)
    rho, gain, turn = rounding._sensitivity(LOOP, w)
    assert rho == near(of_num + of_den)
    assert (gain, turn) == (near(slope.real, 1e-10), near(slope.imag, 1e-10))
    shift = mp.degrees((of_num + of_den) * (1 + abs(slope.imag / slope.real)))
    assert rounding._phase_shift(LOOP, w) == near(shift, 1e-10)
    moved = (of_num + of_den) * (1 + abs(slope.real / slope.imag))
    assert rounding._gain_shift(LOOP, w) == near(moved, 1e-10)


def test_at_both_ends_of_the_axis_a_phase_crossing_stays():
    nyquist = LOOP.frequency(inf)
    for w, z in ((0.0, 1), (nyquist, -1)):
        num, den = (poly(a, z) for a in (NUM, DEN))
        rho = HALF_A_UNIT * (OF_NUM / abs(num) + OF_DEN / abs(den))
        assert rounding._gain_shift(LOOP, w) == near(rho, 1e-9)  # of a v of 1e16


def test_where_the_loop_is_nothing_or_flat_a_crossing_may_be_anywhere():
    gain = Loop.of(Sampled(num=[0.3], den=[1.0], dt=DT))
    assert rounding._phase_shift(gain, 1.0) == inf
    assert rounding._gain_shift(gain, 1.0) == inf
    zero_at_rest = Loop.of(Sampled(num=[1, -1], den=[1, -0.3], dt=2.0))
    assert rounding._sensitivity(zero_at_rest, 0.0)[1:] == (inf, inf)
    pole_at_rest = Loop.of(Sampled(num=[0.3], den=[1, -1], dt=2.0))
    assert rounding._sensitivity(pole_at_rest, 0.0)[1:] == (inf, inf)


@pytest.mark.parametrize("w", FREQUENCIES)
def test_the_return_difference(w):
    num, den, *_ = at(w)
    wanted = HALF_A_UNIT * (OF_NUM + OF_DEN) / abs(num + den)
    # 1e-6: at Nyquist's frequency itself it is asked a billionth below, to which den is steep
    assert rounding._of_return(LOOP, w) == near(wanted, 1e-6 if w == pi / DT else 1e-12)


def test_what_is_nothing_at_an_end_moves_nothing():
    loop = Loop.of(Sampled(num=[0.1, 0.1], den=[1, -0.3], dt=DT))  # num is 0 at z = -1
    v, top, bottom = loop.ends()[1]
    assert top == 0
    assert rounding._moved(loop, v, top, bottom) == near(HALF_A_UNIT * mpf(0.3) / mpf(1.3))
    loop = Loop.of(Sampled(num=[0.3], den=[1, -1], dt=DT))  # den is 0 at z = 1
    v, top, bottom = loop.ends()[0]
    assert rounding._moved(loop, v, top, bottom) == near(HALF_A_UNIT)


@pytest.mark.parametrize("w", FREQUENCIES[:-1])
def test_t_and_the_disk(w):
    num, den, of_num, of_den = at(w)
    rho = of_num + of_den
    assert rounding._of_complementary(LOOP, place(w)) == near(rho * abs(den / (den + num)))
    disk = 2 * rho * abs(num * den / ((den + num) * (den - num)))
    assert rounding._of_disk(LOOP, place(w)) == near(disk)


def test_t_and_the_disk_where_rounding_says_nothing_of_them():
    assert rounding._of_complementary(LOOP, (1.0, 3j, 0j)) == 0.0
    assert rounding._of_disk(LOOP, (1.0, 3j, 0j)) == 0.0
    assert rounding._of_disk(LOOP, (1.0, 0j, 2j)) == 0.0
    assert rounding._of_complementary(LOOP, (1.0, -2j, 2j)) == inf  # L = -1
    assert rounding._of_disk(LOOP, (1.0, -2j, 2j)) == inf
    assert rounding._of_disk(LOOP, (1.0, 2j, 2j)) == inf


def test_a_place_is_an_end_where_it_is_one():
    ends = LOOP.ends()
    assert rounding._place(LOOP, 0.0) == ends[0]
    assert rounding._place(LOOP, LOOP.frequency(inf)) == ends[1]
    assert rounding._place(LOOP, 0.7) == place(0.7)


LOUD = Sampled(num=(0.6, 0.5), den=DEN, dt=DT)  # crosses 1


def loud(w):
    return valued((0.6, 0.5), w) / valued(DEN, w)


def test_the_least_delay_moves_with_its_phase_and_with_its_crossover():
    loop, found = Loop.of(LOUD), measure_loop(Loop.of(LOUD))
    ((w, pm_deg),) = found.gain_crossings
    slope = slopes(w, loud)
    rho = HALF_A_UNIT * ((mpf(0.6)) / abs(valued((0.6, 0.5), w)) + OF_DEN / abs(valued(DEN, w)))
    turn, v = mp.radians(pm_deg) % (2 * mp.pi), 2 / mpf(DT) * mp.tan(mpf(w) * DT / 2)
    wanted = rho * (1 + abs(slope.imag / slope.real)) / turn + rho / (abs(slope.real) * v)
    assert rounding._delay_shift(loop, found) == near(wanted, 1e-9)  # the slope's digits


def test_a_bandwidth_moves_with_t_there_and_with_t_at_rest():
    loop, found = Loop.of(LOUD), measure_loop(Loop.of(LOUD))

    def part(w):
        num, den = valued((0.6, 0.5), w), valued(DEN, w)
        rho = HALF_A_UNIT * (mpf(0.6) / abs(num) + OF_DEN / abs(den))
        return rho * abs(den / (den + num))

    w = found.bandwidth
    slope = slopes(w, lambda x: loud(x) / (1 + loud(x))).real
    wanted = (part(w) + part(0)) / (abs(slope) * 2 / mpf(DT) * mp.tan(mpf(w) * DT / 2))
    assert rounding._bandwidth_shift(loop, w) == near(wanted, 1e-9)


def test_no_delay_is_doubted_where_there_is_none_or_it_is_none_to_rely_on():
    weak = Loop.of(GIVEN)
    assert rounding._delay_shift(weak, measure_loop(weak)) == 0.0
    slow = Loop.of(Sampled(num=[1e-9], den=[1, -1], dt=DT))  # crosses at 2e-9 rad/s
    assert measure_loop(slow).delay_margin > 1e8
    assert rounding._delay_shift(slow, measure_loop(slow)) == 0.0
    for dt in (1e-3, DT, 1e3):  # 1e-7 a sample, turned by 90 deg: 3e-8 of Nyquist's frequency
        slow = Loop.of(Sampled(num=[1e-7], den=[1, -1], dt=dt))
        assert rounding._delay_shift(slow, measure_loop(slow)) == 0.0
    seen = Loop.of(Sampled(num=[1e-6], den=[1, -1], dt=DT))  # 1e-6 w dt: 3e-7 of Nyquist's
    # |L| = 1e-6/(v dt), turned by 90 deg and hardly more: u/(pi/2) + u
    wanted = HALF_A_UNIT * (1 + 2 / mp.pi)
    assert rounding._delay_shift(seen, measure_loop(seen)) == near(wanted, 1e-5)  # w dt is 1e-6


def test_stability_is_asked_for_at_what_was_found_and_on_seven_decades():
    loop = Loop.of(LOUD)
    found = measure_loop(loop)
    asked = list(rounding._frequencies(loop, found))
    known = [found.ms_frequency, found.mt_frequency, found.disk_frequency]
    known += [w for w, _ in (*found.gain_crossings, *found.phase_crossings)]
    assert asked[: len(known)] == known
    grid = asked[len(known) :]
    assert len(grid) == 60
    assert (grid[0], grid[-1]) == (near(mp.pi / DT), near(mp.pi / DT / 10**7))
    ratios = [b / a for a, b in pairwise(grid)]
    assert ratios == pytest.approx([10 ** (-7 / 59)] * 59, rel=1e-12)


def test_of_several_crossings_the_one_whose_delay_is_least():
    """A resonance at 1 rad per sample of 1e-10 s, entered and left."""
    num, den, dt = (0.1, 0.0), (1.0, -1.08, 0.9), 1e-10
    loop = Loop.of(Sampled(num=num, den=den, dt=dt))
    found = measure_loop(loop)
    first, second = found.gain_crossings

    def bound(crossing):
        w, pm_deg = crossing
        angle, turn = mpf(w) * mpf(dt), mp.radians(pm_deg) % (2 * mp.pi)
        v, parts = 2 / mpf(dt) * mp.tan(angle / 2), mpf(0)
        for a, size in ((num, mpf(0.1)), (den, mpf(1.08) + mpf(0.9))):
            parts += HALF_A_UNIT * size / abs(poly(a, mp.expj(angle)))

        def log_of(x):
            return mp.log(poly(num, mp.expj(x)) / poly(den, mp.expj(x)))

        slope = mp.diff(log_of, angle) * mp.cos(angle / 2) ** 2 * mpf(dt)
        return parts * (1 + abs(slope.imag / slope.real)) / turn + parts / (abs(slope.real) * v)

    delays = [float(mp.radians(pm) % (2 * mp.pi) / w) for w, pm in (first, second)]
    assert delays[1] < 0.9 * delays[0]
    assert found.delay_margin == near(delays[1])
    assert rounding._delay_shift(loop, found) == near(bound(second), 1e-8)  # the slope's digits
    swapped = replace(found, gain_crossings=(second, first))
    assert rounding._delay_shift(loop, swapped) == near(bound(second), 1e-8)
    later = replace(found, delay_margin=delays[0])
    assert rounding._delay_shift(loop, later) == near(bound(first), 1e-8)


def test_a_crossing_that_no_delay_needs_to_turn_is_not_divided_by():
    found = measure_loop(Loop.of(LOUD))
    ((w, _),) = found.gain_crossings
    on_it = replace(found, gain_crossings=((w, 0.0),), delay_margin=0.0)
    assert rounding._delay_shift(Loop.of(LOUD), on_it) == 0.0


ALL = ["Ms", "Mt", "the disk margin", "the delay margin", "the bandwidth"]


@pytest.mark.parametrize(
    ("without", "missing"),
    [({}, None), ({"modulus_margin": 0.0}, "Ms"), ({"mt": inf}, "Mt"),
     ({"disk_margin": 0.0}, "the disk margin"), ({"bandwidth": None}, "the bandwidth")],
)  # fmt: skip
def test_a_figure_that_there_is_not_has_no_bound(without, missing):
    found = replace(measure_loop(Loop.of(LOUD)), **without)
    told = dict(rounding._relative(Loop.of(LOUD), found))
    assert list(told) == [name for name in ALL if name != missing]
    if missing is None:
        loop = Loop.of(LOUD)
        assert told["Ms"] == rounding._of_return(loop, found.ms_frequency)
        mt, disk = (rounding._place(loop, w) for w in (found.mt_frequency, found.disk_frequency))
        assert told["Mt"] == rounding._of_complementary(loop, mt)
        assert told["the disk margin"] == rounding._of_disk(loop, disk)
        assert told["the delay margin"] == rounding._delay_shift(loop, found)
        assert told["the bandwidth"] == rounding._bandwidth_shift(loop, found.bandwidth)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("_phase_shift", 0.1, []),
        ("_phase_shift", 0.1001, ["the phase margin may be off by 0.1 deg"]),
        ("_phase_shift", 2e4, ["the phase margin may be off by any number of deg"]),
        ("_gain_shift", 0.01, []),
        ("_gain_shift", 0.0123, ["the gain margin may be off by 1.2 %"]),
        ("_gain_shift", 2.0, ["the gain margin may be off by 200 %"]),
        ("_relative", [("Ms", 0.01), ("Mt", 2.5)], ["Mt may be off by 250 %"]),
        ("_of_return", 0.999, []),
        ("_of_return", 1.0, ["stability may be lost or won"]),
        ("_moved", 1.0, ["stability may be lost or won"]),
        ("_moved", 0.999, []),
    ],
)
def test_from_which_size_on_a_doubt_is_said(monkeypatch, name, value, said):
    quiet = {
        "_phase_shift": 0.0, "_gain_shift": 0.0, "_relative": [], "_of_return": 0.0, "_moved": 0.0
    }  # fmt: skip
    for what, size in {**quiet, name: value}.items():
        monkeypatch.setattr(rounding, what, lambda *_, size=size: size)
    assert rounding._of_z(LOOP, measure_loop(Loop.of(LOUD))) == said


def test_margins_that_do_not_exist_are_not_doubted(monkeypatch):
    monkeypatch.setattr(rounding, "_phase_shift", lambda *_: inf)
    monkeypatch.setattr(rounding, "_gain_shift", lambda *_: inf)
    found = replace(measure_loop(Loop.of(LOUD)), crossover=None, phase_crossover=None)
    told = " ".join(rounding._of_z(Loop.of(LOUD), found))
    assert "phase margin" not in told
    assert "gain margin" not in told


# b/(s + a) or b/(z - a), |L| beside 1 at rest: by how much rounding leaves it in doubt
#   in s: half a unit of each coefficient and as much of the fraction, unless it is 1 exactly
#   in z: half a unit of b over b, and of a over 1 - a
def test_how_near_to_one_an_end_is_in_doubt():
    in_s = Loop.of(Plant(num=[0.1 + 0.2], den=[1, 0.3]))
    assert rounding._in_doubt(in_s, 0.0) == 2.0**-51
    assert rounding._in_doubt(Loop.of(Plant(num=[0.3], den=[1, 0.3])), 0.0) == -1.0
    both = Loop.of(Plant(num=[1, 0.1 + 0.2], den=[1, 0.3]))  # 1 at infinity, and not at rest
    assert (rounding._in_doubt(both, 0.0), rounding._in_doubt(both, inf)) == (2.0**-51, -1.0)
    in_z = Loop.of(Sampled(num=[-0.1], den=[1, -0.9], dt=1.0))
    wanted = HALF_A_UNIT * (1 + mpf(0.9) / (1 - mpf(0.9)))
    assert rounding._in_doubt(in_z, 0.0) == near(wanted)
    exact = Loop.of(Sampled(num=[-0.5], den=[1, -0.5], dt=1.0))
    assert rounding._in_doubt(exact, 0.0) == -1.0
    nothing = Loop.of(Sampled(num=[0.1, -0.1], den=[1, -0.5], dt=1.0))  # 0, or its last bit
    assert rounding._in_doubt(nothing, 0.0) == -1.0


def test_the_sentence_of_each_kind():
    found = measure_loop(Loop.of(Plant(num=[-0.3], den=[1, 0.1 + 0.2])))
    assert found.warnings == (
        "by the rounding of the given coefficients alone |L| may pass through 1 beside 0 rad/s or "
        "not: give them so that |L| is 1, or is not, in the digits that you know",
    )
    found = measure_loop(Loop.of(Sampled(num=[-0.1], den=[1, -0.9], dt=1.0)))
    (told,) = found.warnings
    assert told.startswith(
        "by the rounding of the given z-coefficients alone |L| may pass through 1 beside 0 rad/s "
        "or not, "
    )
    assert told.endswith(
        "stability may be lost or won: build the loop from its parameters (zoh.sample, "
        "Sampled.from_w) or sample more slowly"
    )


def test_an_end_as_near_to_one_as_its_doubt_is_doubted(monkeypatch):
    loop = Loop.of(Sampled(num=[-0.75], den=[1, -0.5], dt=1.0))  # L(1) = -1.5
    found = measure_loop(loop)
    for doubt, said in ((0.5, 1), (0.499, 0)):
        monkeypatch.setattr(rounding, "_in_doubt", lambda *_, doubt=doubt: doubt)
        assert len(rounding.doubts(loop, found)) == said
    positive = Loop.of(Sampled(num=[0.75], den=[1, -0.5], dt=1.0))  # 1.5: near 1 it costs nothing
    monkeypatch.setattr(rounding, "_in_doubt", lambda _, v: -1.0 if v else 1.0)
    assert rounding.doubts(positive, measure_loop(positive)) == ()


def test_a_hundred_is_shown_with_its_digits():
    assert [rounding._shown(x) for x in (9.96, 42.0, 99.5, 100.0, 1e4, inf)] == [
        "10", "42", "100", "100", "10000", "any number of",
    ]  # fmt: skip
