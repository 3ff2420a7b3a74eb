"""What rounding has lost is said; what it has not is not."""

from itertools import product
from math import inf, nextafter, pi

import numpy as np
import pytest

import zoh
from zoh.analysis.loop import Loop
from zoh.analysis.margins import margins, measure_loop
from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

ARM = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)


def pid_loop(dt):
    """The paper's PID on the arm, built in w."""
    kp, ki, kd = 23.4, 0.85, 5.8
    law = Sampled.from_w(
        num_w=(kp * dt / 2 + kd, kp + ki * dt / 2, ki), den_w=(dt / 2, 1.0, 0.0), dt=dt
    )
    return law * sample(ARM, dt)


def as_typed(loop):
    return Sampled(num=loop.num, den=loop.den, dt=loop.dt)


@pytest.mark.parametrize("dt", [0.1, 1e-2])
def test_an_ordinary_sample_time_is_not_doubted(dt):
    assert margins(as_typed(pid_loop(dt))).warnings == ()


def test_at_ten_microseconds_the_typed_loop_is_lost_and_the_built_one_is_not():
    built = pid_loop(1e-5)
    assert margins(built).warnings == ()
    with pytest.warns(zoh.AccuracyWarning, match=r"phase margin .* build the loop from its"):
        typed = margins(as_typed(built))
    assert len(typed.warnings) == 1
    assert typed.to_dict()["warnings"] == list(typed.warnings)


def test_a_product_is_doubted_for_its_typed_factor():
    typed = as_typed(sample(ARM, 1e-7))
    law = Sampled.from_w(num_w=(23.4,), den_w=(1.0,), dt=1e-7)
    assert Loop.of(typed).rounded == (typed,)
    assert Loop.of(law * typed).rounded == Loop.of(law, typed).rounded == (typed,)
    assert Loop.of(law * sample(ARM, 1e-7)).rounded == ()
    assert measure_loop(Loop.of(law, typed)).warnings
    assert measure_loop(Loop.of(law * typed)).warnings
    assert not measure_loop(Loop.of(law, sample(ARM, 1e-7))).warnings


def test_short_numbers_are_meant_as_they_stand():
    """1e-6 (z + 1)/(z - 1)^2 / 2: with the poles exactly at 1 nothing is lost."""
    loop = Sampled(num=[0.5, 0.5], den=[1, -2, 1], dt=2.0**-20)
    assert not measure_loop(Loop.of(loop)).warnings


@pytest.mark.parametrize("dt", [1e-3, 1e-4, 3e-5])
def test_the_bound_is_what_changing_last_bits_does(dt):
    """Every coefficient one unit up or down, twice what rounding may do: the margins follow."""
    from zoh.analysis.rounding import _phase_shift

    loop = as_typed(pid_loop(dt))
    one = measure_loop(Loop.of(loop))
    bound = 2 * _phase_shift(Loop.of(loop), one.crossover)
    moved = []
    for ups in product((-inf, inf), repeat=3):
        # the leading 1 and any 0 are exact; three of the others are enough for 8 loops
        den = [c if i in (0, len(loop.den) - 1) else nextafter(c, ups[i % 3])
               for i, c in enumerate(loop.den)]  # fmt: skip
        num = [nextafter(c, ups[i % 3]) for i, c in enumerate(loop.num)]
        other = measure_loop(Loop.of(Sampled(num=num, den=den, dt=dt)))
        near = min(other.gain_crossings, key=lambda c: abs(c[0] - one.crossover))
        moved.append(abs(near[1] - one.phase_margin_deg))
    # 1.5: the bound is first order, the moves are not small; 1/200: eight moves of all there are
    assert bound / 200 < max(moved) < 1.5 * bound


FIGURES = {
    "Mt": "mt",
    "the disk margin": "disk_margin",
    "the delay margin": "delay_margin",
    "the bandwidth": "bandwidth",
}


@pytest.mark.parametrize("dt", [1e-3, 1e-4])
def test_the_bounds_of_the_other_figures_are_what_changing_last_bits_does(dt):
    from zoh.analysis.rounding import _relative

    loop = as_typed(pid_loop(dt))
    one = measure_loop(Loop.of(loop))
    bounds = {name: 2 * off for name, off in _relative(Loop.of(loop), one)}
    moved = dict.fromkeys(FIGURES, 0.0)
    for ups in product((-inf, inf), repeat=4):
        den = [1.0, *(nextafter(c, ups[i % 4]) if c else c for i, c in enumerate(loop.den[1:]))]
        num = [nextafter(c, ups[-1 - i % 4]) for i, c in enumerate(loop.num)]
        other = measure_loop(Loop.of(Sampled(num=num, den=den, dt=dt)))
        for name, figure in FIGURES.items():
            off = abs(getattr(other, figure) / getattr(one, figure) - 1)
            moved[name] = max(moved[name], off)
    for name in FIGURES:
        # 1.1: the bound is first order; 1/20: sixteen moves of all there are
        assert bounds[name] / 20 < moved[name] < 1.1 * bounds[name]


def test_every_figure_that_is_lost_is_named():
    lost = measure_loop(Loop.of(as_typed(pid_loop(1e-5)))).warnings[0]
    for name in ("phase margin", "gain margin", "Ms", *FIGURES):
        assert f"{name} may be off by" in lost
    assert "stability may be lost or won" in lost


def test_the_report_says_so_once():
    typed = as_typed(pid_loop(1e-5))
    with pytest.warns(zoh.AccuracyWarning) as told:
        margins(typed)
    assert len(told) == 1
    assert told[0].filename == __file__


def test_a_zero_on_the_circle_is_no_division_by_zero():
    loop = Sampled(num=[0.1, 0.1], den=[1, -0.5, 0.1], dt=0.1)  # zero at z = -1
    found = measure_loop(Loop.of(loop))
    assert found.warnings == ()
    assert np.isfinite(found.ms)
    assert found.ms_frequency <= pi / 0.1


def test_a_pole_at_an_end_that_rounding_puts_on_either_side():
    """1.9/(z - 0.9) has its pole at -1, or a bit inside, and 1.89 none near."""
    for num, said in (([1.9], True), ([1.89], False)):
        loop = Sampled(num=num, den=[1, -0.9], dt=1.0)
        told = " ".join(measure_loop(Loop.of(loop)).warnings)
        assert ("stability may be lost or won" in told) == said
    exact = Sampled(num=[0.5], den=[1, -0.5], dt=1.0)  # nothing is rounded
    assert measure_loop(Loop.of(exact)).warnings == ()
