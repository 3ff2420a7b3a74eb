"""A certificate holds for what is complete, and does not for what is not."""

from fractions import Fraction
from math import inf, pi, sqrt

import numpy as np
import pytest
from mpmath import mp

from zoh.analysis import discs
from zoh.analysis.certificates import Proof
from zoh.analysis.close import Close
from zoh.analysis.loop import Loop
from zoh.analysis.margins import margins, measure_loop, peak
from zoh.analysis.nyquist import closed_loop_stable
from zoh.analysis.proof import Found, Peak, _just_below, _least, counted, proved
from zoh.analysis.sparse import Sparse
from zoh.analysis.squares import ON_DEN, ON_NUM, ON_OPPOSITE, Squares
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

ROUTH = Proof(holds=True, method="Routh", detail="in whole numbers")
ARM = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
LOOPS = {
    "sampled": Sampled(num=[3.0], den=[1.0], dt=0.1) * sample(ARM, 0.1),
    "sampled, few samples late": sample(Plant(num=[1], den=[1, 1], dead_time=0.37), 0.1),
    "sampled, many samples late": sample(Plant(num=[2], den=[1, 1], dead_time=3.3), 0.1),
    "continuous": Plant(num=[10], den=[1, 3, 3, 1]),
    "continuous, late": Plant(num=[2], den=[1, 1], dead_time=0.5),
    "integrators, late": Plant(num=[1, 0.3], den=[1, 1, 0, 0], dead_time=0.1),
    "resonant": Plant(num=[0.2, 0.1], den=[1, 0.02, 4.0, 0.1]),
    "in and out, late": Plant(num=[0.5, 1.0], den=[1, 3.0], dead_time=0.3),
    "a gain, late": Plant(num=[0.5, 1.0], den=[1, 2.0], dead_time=0.3),
}


def looked(loop):
    """Return (loop, squares, look, what was found)."""
    loop = Loop.of(loop)
    squares = Squares.of(loop)
    look = Close.of(loop, squares)
    peaks = [peak(loop, squares, look, below) for below in (ON_DEN, ON_NUM, ON_OPPOSITE)]
    factor = measure_loop(loop).gain_margin
    return loop, squares, look, Found(look.unities(), look.turns(), look.drops(), peaks, factor)


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_what_is_complete_is_proved(loop):
    m = margins(loop)
    assert m.certificate.holds
    assert m.certificate.open() == []


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
@pytest.mark.parametrize("kind", ["unities", "turns", "drops"])
def test_a_crossing_withheld_or_invented_is_noticed(loop, kind):
    name = {"unities": "gain_crossings", "turns": "phase_crossings", "drops": "bandwidth"}[kind]
    loop, squares, look, found = looked(loop)
    assert getattr(proved(loop, squares, look, found, stable=ROUTH), name).holds
    crossings = getattr(found, kind)
    for wrong in ([1e-3, *crossings], crossings[1:]):
        if wrong != crossings:
            told = proved(loop, squares, look, found._replace(**{kind: wrong}), stable=ROUTH)
            assert not getattr(told, name).holds
            assert told.open() == [name]


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
@pytest.mark.parametrize("which", range(3))
def test_a_peak_said_lower_than_it_is_is_noticed(loop, which):
    name = ("modulus_margin", "mt", "disk_margin")[which]
    loop, squares, look, found = looked(loop)
    true = found.peaks[which]
    for factor, holds in ((1.0, True), (1 - 1e-4, True), (1 + 1e-5, False), (1.5, False)):
        peaks = list(found.peaks)
        peaks[which] = true._replace(least=true.least * factor)
        told = getattr(proved(loop, squares, look, found._replace(peaks=peaks), stable=ROUTH), name)
        if factor <= 1 or 0 < true.v < inf:  # at an end the least is a limit, not always there
            assert told.holds is holds


def test_the_methods_are_named():
    exact = margins(LOOPS["sampled"]).certificate
    late = margins(LOOPS["continuous, late"]).certificate
    assert {exact.gain_crossings.method, exact.mt.method} <= {"Descartes", "halving"}
    assert (late.phase_crossings.method, late.modulus_margin.method) == ("discs", "discs")
    assert late.gain_crossings.method in ("Descartes", "halving")  # a delay does not move |L|
    said = late.to_dict()
    assert said["holds"] is True
    assert set(said["mt"]) == {"holds", "method", "detail"}


@pytest.mark.parametrize(
    ("a", "found", "holds", "method"),
    [
        ((1, -1, -2), [sqrt(2)], True, "Descartes"),
        ((1, -3, 2), [1.0, sqrt(2)], True, "Descartes"),
        ((1, -2, 2), [1.0, 1.5], False, "halving"),  # two sign changes and two said, but no root
        ((1, -3, 2), [1.0], False, "halving"),
        ((1, -3, 2), [1.0, 1.0], False, "halving"),  # one of them twice, the other missed
        ((1, -3, 2), [1.0, 1.0 + 1e-15], False, "halving"),
        ((1, -3, 2), [1.0, 1.4], False, "halving"),  # the other one elsewhere
        ((1, -3, 2), [1.0, sqrt(2) * (1 + 1e-9)], False, "halving"),
        ((1, -1, 1), [], True, "halving"),  # two sign changes, no root
        ((1, -2, 1), [], True, "halving"),  # touches, does not cross
        ((1, -3, 3, -1), [1.0], True, "halving"),  # three times the same root is one crossing
        ((1, -3, 3, -1), [1.1], False, "halving"),
        ((0,), [], True, "Descartes"),
    ],
)
def test_counts(a, found, holds, method):
    told = counted(a, found)
    assert (told.holds, told.method) == (holds, method)


def test_nothing_below_zero_needs_no_proof():
    told = margins(Sampled(num=[-0.5], den=[1, -0.5], dt=1.0)).certificate  # L(1) = -1
    assert told.modulus_margin.method == "bound"
    assert told.modulus_margin.holds


def test_the_sparse_look_alone_misses_a_needle_and_says_so():
    """A resonance a millionth of w wide: no point of the grid is on it."""
    zeta, wn = 1e-6, 7.0
    loop = Loop.of(Plant(num=[2.002 * zeta * wn, 0.0], den=[1.0, 2 * zeta * wn, wn**2]))
    squares = Squares.of(loop)
    look = Sparse.of(loop, squares)
    assert look.unities() == []
    assert not counted(squares.gain, []).holds
    assert len(measure_loop(loop).gain_crossings) == 2


@pytest.mark.parametrize("loop", [LOOPS["sampled"], LOOPS["continuous"], LOOPS["resonant"]])
def test_both_looks_see_the_same(loop):
    loop = Loop.of(loop)
    squares = Squares.of(loop)
    one, other = Sparse.of(loop, squares), Close.of(loop, squares)
    assert one.unities() == pytest.approx(other.unities(), rel=1e-12)
    assert one.turns() == pytest.approx(other.turns(), rel=1e-12)
    assert one.drops() == pytest.approx(other.drops(), rel=1e-12)
    for below in (ON_DEN, ON_NUM, ON_OPPOSITE):
        # 1e-8: a least value is flat, half a float's digits are all that its place has
        assert one.lowest(below) == pytest.approx(other.lowest(below), rel=1e-8)


# Worked by hand.  K exp(-s)/(s + 1) has a pair on the axis where w + arctan w = pi, K = sqrt(1+w^2)
# and the next where w + arctan w = 3 pi.  exp(-s tau)/s leaves at tau = pi/2, again at 5 pi/2.
def _late_lag(turn):
    w = turn - pi / 2 + 0.1
    for _ in range(200):
        w = turn - np.arctan(w)
    return sqrt(1 + w * w)


FIRST, SECOND = _late_lag(pi), _late_lag(3 * pi)


@pytest.mark.parametrize(
    ("plant", "zeros"),
    [
        (Plant(num=[FIRST * 0.999], den=[1, 1], dead_time=1.0), 0),
        (Plant(num=[FIRST * 1.001], den=[1, 1], dead_time=1.0), 2),
        (Plant(num=[SECOND * 0.999], den=[1, 1], dead_time=1.0), 2),
        (Plant(num=[SECOND * 1.001], den=[1, 1], dead_time=1.0), 4),
        (Plant(num=[1], den=[1, 0], dead_time=pi / 2 * 0.999), 0),
        (Plant(num=[1], den=[1, 0], dead_time=pi / 2 * 1.001), 2),
        (Plant(num=[1], den=[1, 0], dead_time=5 * pi / 2 * 1.001), 4),
        (Plant(num=[2], den=[1, -1], dead_time=0.1), 0),
        (Plant(num=[0.5], den=[1, -1], dead_time=0.1), 1),
    ],
)
def test_the_winding_number_counts_the_zeros_on_the_right(plant, zeros):
    loop = Loop.of(plant)
    assert discs.unstable_zeros(loop, np.geomspace(1e-3, 1e3, 50)) == zeros
    assert margins(plant).stable is (zeros == 0)


def test_a_zero_on_the_axis_is_undecided_and_said():
    """-exp(-s)/(s + 1) is -1 at w = 0, exactly."""
    loop = Loop.of(Plant(num=[-1], den=[1, 1], dead_time=1.0))
    assert discs.unstable_zeros(loop, np.geomspace(1e-3, 1e3, 50)) is None
    found = measure_loop(loop)
    assert not found.stable
    assert "stable" in found.certificate.open()
    assert any("stable" in sentence for sentence in found.warnings)


@pytest.mark.parametrize(
    ("k", "a", "dead_time"), [(0.5, 1e6, 1.0), (0.45, 3e5, 1.0), (0.45, 1e6, 0.3), (0.1, 1e6, 1.0)]
)
def test_a_quiet_loop_is_stable_however_often_it_turns(k, a, dead_time):
    """k a/(s + a) exp(-s T): |L| <= k < 1 everywhere."""
    loop = Loop.of(Plant(num=[k * a], den=[1, a], dead_time=dead_time))
    assert closed_loop_stable(loop)


def test_a_touch_is_no_change_of_sign_and_has_its_margin():
    """|L| <= 1, and 1 at w = 1 alone, where L is -j: a lag of 90 deg there puts it on -1."""
    loop = Plant(num=[-0.5, 0.5, 0], den=[1, 1.5, 1.5, 1])
    assert np.polyval([-0.5, 0.5, 0], 1j) / np.polyval([1, 1.5, 1.5, 1], 1j) == -1j
    found = margins(loop)
    assert found.gain_crossings == ((1.0, pytest.approx(90.0, rel=1e-15)),)
    assert found.certificate.gain_crossings.holds
    assert "0 sign changes on the axis, 0 found" in found.certificate.gain_crossings.detail


def test_many_samples_late_agrees_with_routh():
    """The same loops by the argument principle and by Routh's scheme."""
    for m in (20, 40, 59):
        for gain in (0.5, 0.99, 1.01, 2.0):
            # z^-m k/(z-1): the characteristic z^m (z - 1) + k leaves at k = 2 sin(pi/(4m+2))
            k = gain * 2 * np.sin(pi / (4 * m + 2))
            late = Sampled.from_w(num_w=(-k / 2, k), den_w=(1.0, 0.0), dt=1.0, delay=m)
            loop = Loop.of(late)
            assert margins(late).stable is (gain < 1)
            zeros = discs.unstable_zeros(loop, np.geomspace(1e-4, 1e3, 200))
            assert (zeros == 0) is (gain < 1)


def test_bandwidth_of_a_first_order_loop():
    """T = k/(z - b), b = 1 - k: 1 - 2 b cos w + b^2 = 10^0.3 (1 - b)^2."""
    k = 0.3
    b = 1 - k
    wanted = np.arccos((1 + b * b - 10**0.3 * k * k) / (2 * b)) / 0.05
    found = margins(Sampled(num=[k], den=[1, -1], dt=0.05))
    assert found.bandwidth == pytest.approx(wanted, rel=1e-13)
    continuous = margins(Plant(num=[5.0], den=[1, 0]))
    assert continuous.bandwidth == pytest.approx(5 * sqrt(10**0.3 - 1), rel=1e-13)


def test_bandwidth_does_not_exist_where_t_starts_at_zero_or_never_drops():
    assert margins(Plant(num=[1.0, 0.0], den=[1, 2, 1])).bandwidth is None
    assert margins(Plant(num=[0.5], den=[1])).bandwidth is None
    assert margins(Plant(num=[-1.0], den=[1, 1])).bandwidth is None  # T(0) is infinite
    assert margins(Plant(num=[0.5], den=[1])).to_dict()["bandwidth"] is None


def test_bandwidth_of_a_late_loop_is_where_t_drops():
    found = margins(LOOPS["continuous, late"])
    loop = LOOPS["continuous, late"].at(found.bandwidth)
    # T(0) = 2/3
    assert abs(loop / (1 + loop)) == pytest.approx(2 / 3 * 10**-0.15, rel=1e-9)
    w = np.linspace(1e-3, found.bandwidth * (1 - 1e-6), 2000)
    before = LOOPS["continuous, late"].at(w)
    assert (abs(before / (1 + before)) > 2 / 3 * 10**-0.15).all()


def test_the_disk_margin_is_where_it_says():
    for loop in LOOPS.values():
        found = margins(loop)
        if 0 < found.disk_frequency < inf:
            value = loop.at(found.disk_frequency)
            assert 2 * abs((1 + value) / (1 - value)) == pytest.approx(found.disk_margin, rel=1e-9)


def test_a_late_loops_peak_is_no_lower_than_a_fine_grids():
    loop = LOOPS["in and out, late"]
    found = margins(loop)
    w = np.geomspace(1e-3, 1e4, 400_001)
    value = loop.at(w)
    # 1e-6: the tolerance of the proof, and the grid is as fine
    assert found.modulus_margin <= abs(1 + value).min() * (1 + 1e-12)
    assert found.modulus_margin == pytest.approx(abs(1 + value).min(), rel=1e-6)


def test_a_hand_worked_peak():
    """0.5/(z - 1): |1 + L| = |z - 0.5|/|z - 1| falls to 3/4 at z = -1; T = 0.5/(z - 0.5)."""
    found = margins(Sampled(num=[0.5], den=[1, -1], dt=1.0))
    assert found.modulus_margin == pytest.approx(0.75, rel=1e-15)
    assert found.ms_frequency == pi
    assert found.mt == pytest.approx(1.0, rel=1e-15)
    assert found.mt_frequency == 0.0


def test_what_each_proof_says():
    assert counted((1, -1, -2), [sqrt(2)]).detail == "1 sign changes, 1 found"
    assert counted((1, -3, 2), [1.0]).detail == "2 sign changes on the axis, 1 found"
    twice = "2 sign changes on the axis, 2 found, not each with a sign change of its own"
    assert counted((1, -3, 2), [1.0, 1.0]).detail == twice
    everywhere = margins(Sampled(num=[1.0], den=[1.0], dt=1.0))  # L = 1: |D - N| is 0
    assert everywhere.disk_margin == inf
    assert everywhere.certificate.disk_margin == Proof(
        holds=True, method="bound", detail="measured against 0 everywhere"
    )
    through = margins(Plant(num=[6], den=[1, 3, 2, 0]))  # through -1 at sqrt(2)
    assert through.certificate.modulus_margin == Proof(
        holds=True, method="bound", detail="0 but for rounding, the least there is"
    )
    first = margins(Plant(num=[1], den=[1, 1])).certificate.mt
    assert (first.holds, first.method) == (True, "Descartes")
    assert first.detail == "nowhere below 2 by more than 1e-09 of it"  # |1 + 1/L| at w = 0


@pytest.mark.parametrize("least", [1.0, 0.75, 3e-5, 2.0**60])
def test_a_square_a_little_below_that_of_the_least_value(least):
    level, down = _just_below(least)
    part = level / Fraction(2) ** down / Fraction(least) ** 2
    assert 1 - 2e-9 <= part <= 1 - 1.998e-9  # a thousandth of 2e-9 is left to rounding
    assert level.bit_length() <= 41


def test_how_a_peak_inside_is_proved_and_how_one_said_too_low_is_not():
    """1/(s (s + 1) (s + 2)): seen from its peaks every sign is plain."""
    loop, squares, look, found = looked(Plant(num=[1], den=[1, 3, 2, 0]))
    for peak_ in found.peaks:
        assert 0 < peak_.v < inf
        told = _least(squares, peak_)
        assert (told.holds, told.method) == (True, "Descartes")
        told = _least(squares, peak_._replace(least=1.01 * peak_.least))
        assert (told.holds, told.method) == (False, "halving")
    certificate = proved(loop, squares, look, found, stable=ROUTH)
    assert certificate.modulus_margin == _least(squares, found.peaks[0])


@pytest.mark.parametrize("quiet", [2.0**-30, 2.0**-12, 2.0**12])
def test_a_peak_is_proved_whatever_its_size(quiet):
    """k/(s^2 + s/2 + 1): |1 + 1/L| is least where (1 + k - q)^2 + q/4 is, q = 7/8 + k, over k."""
    squares = Squares.of(Loop.of(Plant(num=[quiet], den=[1, 0.5, 1])))
    q = Fraction(7, 8) + Fraction(quiet)
    square = ((1 + Fraction(quiet) - q) ** 2 + q / 4) / Fraction(quiet) ** 2
    with mp.workdps(30):
        least = float(mp.sqrt(mp.mpf(square.numerator) / square.denominator))
    there = Peak(v=float(q) ** 0.5, least=least, below=ON_NUM)
    assert _least(squares, there).holds
    assert _least(squares, there._replace(least=least * (1 - 1e-6))).holds
    assert not _least(squares, there._replace(least=least * (1 + 2e-9))).holds  # proved to 1e-9
