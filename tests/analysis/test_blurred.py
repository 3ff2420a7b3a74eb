"""Where the rounding of a made loop's coefficients moves a margin, and that it is said."""

from dataclasses import replace
from math import atan, degrees, inf

import pytest
from mpmath import mp, mpf

from zoh.analysis import blurred
from zoh.analysis.blurred import (
    _off,
    _part,
    _peak_off,
    _roots,
    _undamped,
    blurs,
    is_blurred,
    next_to_the_axis,
)
from zoh.analysis.loop import Loop
from zoh.analysis.margins import margins, measure_loop
from zoh.errors import AccuracyWarning
from zoh.laws import lead
from zoh.lti.systems import Plant, Sampled
from zoh.lti.wplane import warp
from zoh.sampling.hold import sample


def said_of(loop):
    """Return what is said, asked straight and not only where a crossing is seen to need it."""
    found = measure_loop(loop)
    return blurs(loop, found)


A_ROUNDING = 2.0**-53


def mode(damping, k, dt=0.5):
    """Return k/(w^2 + damping w + 1) in w."""
    return Loop.of(Sampled.from_w(num_w=[k], den_w=[1, damping, 1], dt=dt))


@pytest.mark.parametrize("loud", [2.0, 10.0])
@pytest.mark.parametrize("damping", [1e-9, 1e-10])
def test_beside_a_mode_by_hand(loud, damping):
    """k/(1 - q + j a v), k = loud a: |L| = 1 where |1 - q| = a sqrt(loud^2 - 1), all but.

    den is k there, of terms 2: rho is 2 units/k, and one unit of num. With x = 1 - q the phase
    is -arctan(a/x) and ln|L| is -ln(x^2 + a^2)/2: slopes of a/(x^2 + a^2) and x/(x^2 + a^2).
    """
    loop = mode(damping, loud * damping)
    found = measure_loop(loop)
    part = A_ROUNDING * (1 + 2 / (loud * damping))
    expected = part * (1 + 1 / (loud**2 - 1) ** 0.5)
    # 1e-3: q is taken as 1 in what is not a difference
    assert _off(loop, found.crossover, turning=True) == pytest.approx(expected, rel=1e-3)
    said = said_of(loop)
    assert said == (
        f"by the rounding of coefficients in w the phase margin at {found.crossover:.6g} rad/s "
        f"may be off by {degrees(expected):.1g} deg: "
        "a zero or a pole next to the axis is beside it",
    )
    assert said[0] in found.warnings


def test_a_margin_that_is_not_the_smallest_is_named():
    """5/(w + 1), a zero beside a pole of less damping: real near both, the pole's the less sure."""
    a = 1e-10
    loop = Loop.of(
        Sampled.from_w(num_w=[5.0], den_w=[1, 1], dt=0.5),
        Sampled.from_w(num_w=[1, 10 * a, 1.001], den_w=[1, a, 1], dt=0.5),
    )
    found = measure_loop(loop)
    (pole, _), (zero, _) = found.phase_crossings  # beside the pole L is 2.5e5, beside the zero 5e-5
    assert zero == found.phase_crossover != pole
    (said,) = said_of(loop)
    assert f"in w the gain margin at {pole:.6g} rad/s may be off by " in said


def test_what_is_damped_and_what_is_meant_are_not_doubted():
    for damping in (0.01, 1.0):
        assert said_of(mode(damping, 2 * damping)) == ()
    meant = Loop.of(Plant(num=[2e-7], den=[1, 1e-7, 1]))
    assert measure_loop(meant).warnings == ()
    z = Sampled(num=[0.1], den=[1, -0.9], dt=1.0)  # leaves at z = -1: the end of the axis
    assert said_of(Loop.of(z)) == ()
    made = Loop.of(sample(Plant(num=[1], den=[1, 1]), 0.1))
    assert said_of(made) == ()
    assert _off(made, 31.41592653589793, turning=False) == 0.0


def test_a_gain_margin_beside_an_undamped_zero_is_doubted():
    """(w^2 + 1)/(w^2 + w + 1) on an integrator that is late by dt/2: real beside 1."""
    notch = Sampled.from_w(num_w=[1, 0, 1], den_w=[1, 1, 1], dt=1e-6)
    loop = notch * sample(Plant(num=[1], den=[1, 0]), 1e-6)
    with pytest.warns(
        AccuracyWarning, match=r"in w the gain margin at 1 rad/s may be off by .* %: a zero"
    ):
        found = margins(loop)
    assert found.phase_crossover == pytest.approx(1 - 2.5e-7, rel=1e-12)


@pytest.mark.parametrize("turning", [True, False])
@pytest.mark.parametrize(
    ("dt", "size"),
    [(0.5, 1.0), (1e-6, 4096.0)],  # v/dt is large: v dt is not
)
def test_the_bound_is_rounding_over_the_slope_of_both_parts(turning, dt, size):
    """Terms over values of num and den, and d ln L/dv, all in 50 digits, beside zero and pole."""
    num = [1.0, 1e-9 * size, (1 + 1e-7) * size**2]
    den = [1.0, 2e-9 * size, size**2]
    loop = Loop.of(Sampled.from_w(num_w=num, den_w=den, dt=dt))
    w = 2 / dt * float(mp.atan(size * (1 + 3e-8) * dt / 2))
    with mp.workdps(50):
        v = 2 / mpf(dt) * mp.tan(mpf(w) * mpf(dt) / 2)
        value, slope, part = [], [], mpf(0)
        for _, b, c in (num, den):
            value.append(mp.mpc(c - v * v, b * v))
            slope.append(mp.mpc(-2 * v, b))
            part += A_ROUNDING * (v * v + b * v + c) / abs(value[-1])
        gain = slope[0] / value[0] - slope[1] / value[1]
        own, other = (gain.imag, gain.real) if turning else (gain.real, gain.imag)
        expected = part * (1 + abs(own / other))
    # 1e-6: of what is left of num and den there, floats have 8 digits
    assert _off(loop, float(w), turning=turning) == pytest.approx(float(expected), rel=1e-6)


def test_both_margins_are_in_one_sentence(monkeypatch):
    monkeypatch.setattr(blurred, "_off", lambda loop, w, turning: w / 200)  # rad, and a part
    loop = mode(0.1, 1.0)
    found = replace(
        measure_loop(loop), gain_crossings=((1.0, 0.0), (2.99, 0.0)),
        phase_crossings=((2.99, 1.0), (0.0, 1.0)),
    )  # fmt: skip
    assert blurs(loop, found) == (
        "by the rounding of coefficients in w the phase margin at 2.99 rad/s may be off by 0.9 "
        "deg, the gain margin at 2.99 rad/s may be off by 1 %: a zero or a pole next to the axis "
        "is beside it",
    )


def test_without_damping_no_phase_moves():
    """1/(w^2 + 1): its phase is 0 or a half turn, and no gain margin is sure there."""
    undamped = mode(0.0, 1.0)
    assert _off(undamped, 0.9, turning=False) == inf
    assert _off(undamped, 0.9, turning=True) < 1e-14  # two terms of one sign each, a few roundings


def test_a_root_at_zero_by_structure_loses_nothing_there():
    """(w + 1)/(w (w + 2)) at v = 0: den has no terms there, and a 0 is no difference."""
    integrates = Loop.of(Sampled.from_w(num_w=[1, 1], den_w=[1, 2, 0], dt=0.5))
    assert _part(integrates, 0.0) == 2 * A_ROUNDING  # one of num, one of den


def test_the_margins_of_a_lead_on_an_integrator_of_five_modes():
    """A loop that is asked for its blur at v = 0, too; pm as it was designed."""
    plant = Plant(
        num=[1.6130226873330313, 9.824735791616826, 12.348278940420329],
        den=[
            1.0, 1.8616500971667507, 24.774994124874574, 39.89429703109592, 16.406078412237033, 0.0,
        ],
    )  # fmt: skip
    dt = 0.003949342032231476
    found = lead(
        plant, dt=dt, compute_delay=dt, wc=0.4858016807696745, pm_deg=61.368872295224286,
        dc_gain=0.5493424015953792,
    )  # fmt: skip
    assert found.margins.phase_margin_deg == pytest.approx(61.368872295224286, rel=1e-9)


def without_figures(loop):
    """Return margins of no crossing and of peaks at rest alone."""
    return replace(
        measure_loop(loop), gain_crossings=(), phase_crossings=(), ms_frequency=0.0,
        mt_frequency=0.0, disk_frequency=0.0,
    )  # fmt: skip


@pytest.mark.parametrize("dt", [1e-6, 0.5])
def test_a_place_beside_a_mode_where_nothing_was_found_is_asked_too(dt):
    """w^2 + 1e-13 W w + W^2 at W: terms of 2 W^2 over 1e-13 W^2, so 20 units of 2^-53 in 1e-12."""
    corner = 4096.0  # corner/dt is beyond the end of the axis at 1e-6 s, corner dt is not
    loop = Loop.of(
        Sampled.from_w(num_w=[1e-20], den_w=[1, 1e-13 * corner, corner**2], dt=dt),
    )
    nothing = without_figures(loop)
    assert _part(loop, corner) == pytest.approx(A_ROUNDING * (1 + 2e13), rel=1e-9)
    assert is_blurred(loop, nothing, [corner])
    assert is_blurred(loop, nothing, [corner / 3, corner])
    assert not is_blurred(loop, nothing, [corner / 3])
    assert not is_blurred(loop, nothing, [])
    assert not is_blurred(loop, nothing, [2e9 / dt])  # the end of the axis, where L is real


def resonance(damping):
    """Return 1e-3/(w^2 + damping w + 1), dt 1/2, and the frequency at which w is j."""
    loop = mode(damping, 1e-3)
    return loop, 4 * atan(0.25)


def test_each_figure_by_itself_asks_for_more_digits():
    """At j den is j a, of terms 2 + a, and d ln L/dv = -1 - 2j/a.

    So L is off by 2/a units there, the phase of a crossing by 2/a times that, and its gain by
    hardly more. At a = 3e-4 that is 7.4e-13, 2.8e-7 deg and 7.4e-13; at 1e-9 L is off by 2.2e-7.
    """
    damped, w = resonance(3e-4)
    nothing = without_figures(damped)
    assert is_blurred(damped, replace(nothing, gain_crossings=((w, 0.0),)), [])
    assert not is_blurred(damped, replace(nothing, phase_crossings=((w, 1.0),)), [])
    assert not is_blurred(damped, replace(nothing, mt_frequency=w), [])
    undamped, w = resonance(1e-9)
    nothing = without_figures(undamped)
    assert not is_blurred(undamped, nothing, [])
    for told in (
        {"gain_crossings": ((w, 0.0),)},
        {"phase_crossings": ((w, 1.0),)},
        {"ms_frequency": w},
        {"mt_frequency": w},
        {"disk_frequency": w},
    ):
        assert is_blurred(undamped, replace(nothing, **told), [])


def test_what_is_meant_as_it_stands_has_all_its_digits():
    meant = Loop.of(Plant(num=[1e-3], den=[1, 0, 1]))
    found = replace(measure_loop(meant), gain_crossings=((1.0, 0.0),))
    assert not is_blurred(meant, found, [1.0])


def test_what_is_next_to_the_axis_and_what_is_not():
    assert next_to_the_axis(mode(1e-9, 1.0)) == [1.0]
    assert next_to_the_axis(mode(0.1, 1.0)) == []
    both = Loop.of(Sampled.from_w(num_w=[1, 0, 9], den_w=[1, 1e-9, 4], dt=0.5))
    assert sorted(next_to_the_axis(both)) == [2.0, 3.0]
    assert next_to_the_axis(Loop.of(Plant(num=[1], den=[1, 0, 1]))) == []
    # (w^2 + 1) (w^2 + 4) (w^2 + 9), its even part of three roots
    three = _undamped((1.0, 0.0, 14.0, 0.0, 49.0, 0.0, 36.0))
    assert sorted(three) == pytest.approx([1.0, 2.0, 3.0], rel=1e-12)
    assert _undamped((1.0, 1.0, 0.0, 0.0, 0.0, 1.0)) == ()  # an odd part of w^5 alone


@pytest.mark.parametrize(
    ("a", "roots"),
    [
        ((2.0, 4.0), [-2.0]),
        ((1.0, -0.5), []),
        ((1e-300, 1e300), []),  # beyond floats
        ((2.0, 6.0, 4.0), [-2.0, -1.0]),
        ((1.0, 0.0, 0.0), []),
        ((1.0, 1e9, -1.0), [-1e9]),  # and 1e-9
        ((1.0, -1e9, -1.0), [-1e-9]),  # and 1e9
        ((0.0, 0.0, 1.0, 3.0), [-3.0]),
        ((1.0, 6.0, 11.0, 6.0), [-3.0, -2.0, -1.0]),
        ((1.0, 2.0, -1.0, -2.0), [-2.0, -1.0]),  # and 1
        ((7.0,), []),
    ],
)
def test_the_roots_below_zero_and_no_others(a, roots):
    assert sorted(_roots(a)) == pytest.approx(roots, rel=1e-12)


def test_at_a_root_itself_a_polynomial_is_off_by_all_of_itself():
    """w^2 + 1 at j: a rounding of its terms, over the least that a float of them tells from 0."""
    assert _part(mode(0.0, 1.0), 1.0) == pytest.approx(1.0, rel=1e-15)


def test_where_the_loop_is_nothing_no_crossing_moves():
    starts_at_nothing = Loop.of(Sampled.from_w(num_w=[1, 0], den_w=[1, 2], dt=0.5))
    for turning in (True, False):
        assert _off(starts_at_nothing, 0.0, turning=turning) == 0.0


@pytest.mark.parametrize(("dt", "size"), [(0.5, 1.0), (1e-6, 4096.0)])
@pytest.mark.parametrize(("gain", "swells"), [(1.2e-7, True), (-1.2e-7, False)])
def test_the_return_difference_moves_by_l_over_it(dt, size, gain, swells):
    """|1 + L| by rho |L|, or by rho of itself, in 50 digits: den is -6e-8 there, L -2 or 2."""
    den = [1.0, 2e-9 * size, size**2]
    loop = Loop.of(Sampled.from_w(num_w=[gain * size**2], den_w=den, dt=dt))
    w = 2 / dt * float(mp.atan(size * (1 + 3e-8) * dt / 2))
    with mp.workdps(50):
        v = 2 / mpf(dt) * mp.tan(mpf(w) * mpf(dt) / 2)
        bottom = mp.mpc(mpf(den[2]) - v * v, den[1] * v)
        part = A_ROUNDING * (1 + (v * v + den[1] * v + den[2]) / abs(bottom))
        over = abs(loop.num[-1] / (loop.num[-1] + bottom))
        assert (over > 1.9) is swells
        expected = part * max(mpf(1), over)
    # 1e-6: of what is left of den there, floats have 8 digits
    assert _peak_off(loop, w) == pytest.approx(float(expected), rel=1e-6)
    assert _peak_off(loop, 0.0) == 0.0  # the ends of the axis, where L is what it is
    assert _peak_off(loop, 3.141592653589793 / dt) == 0.0


def test_where_the_loop_is_minus_one_its_peak_may_be_any():
    """3/(w^2 + 1) at 2j, to the last bit of the float that is 2 there."""
    w = 4 * atan(0.5)
    v = warp(w, 0.5)
    assert _peak_off(mode(0.0, v * v - 1), w) == inf
