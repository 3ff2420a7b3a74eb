"""Figures show what was measured, on the right branch, and are the same bytes every time."""

import subprocess
import sys
from math import inf, pi

import matplotlib
import numpy as np
import pytest

from zoh.analysis.margins import margins
from zoh.analysis.verify import measure
from zoh.errors import Infeasible, SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.report import figures
from zoh.report.canvas import RED
from zoh.report.curves import frequencies, lowest, phase_deg
from zoh.report.document import comparison, response
from zoh.report.text import in_w, in_z, number, slug

ARM = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
PD = Sampled(num=[50.0, -48.0], den=[1.0, -0.8], dt=0.1)
ONE = Sampled(num=[1.0], den=[1.0], dt=0.1)
TOO_MUCH = Sampled(num=[5000.0], den=[1.0], dt=0.1)


@pytest.fixture(scope="module")
def good():
    return measure(ARM, PD, law="lead", name="Lead | one")


# Low-frequency phase by counting: -90 per integrator, +90 per differentiator, -180 per minus.
@pytest.mark.parametrize(
    ("num", "den", "deg"),
    [
        ([1], [1, 0], -90),
        ([1], [1, 1, 0, 0], -180),
        ([1], [1, 0, 0, 0], -270),
        ([1, 0], [1, 1], 90),
        ([-1], [1, 1], -180),
        ([1], [1, -1], -180),  # 1/(s - 1) is -1 at s = 0
        ([-1, 1], [1, 1, 0], -90),  # a zero on the right: 1 at s = 0
    ],
)
def test_the_phase_starts_on_the_branch_that_integrators_say(num, den, deg):
    found = phase_deg(Plant(num=num, den=den), np.array([1e-9]))
    assert found[0] == pytest.approx(deg, abs=1e-6)  # 1e-9 rad/s is not 0


def test_the_phase_goes_on_falling_past_180_deg():
    found = phase_deg(Plant(num=[1], den=[1, 3, 3, 1]), np.array([1.0, 1e6]))
    assert found == pytest.approx([-135, -270], abs=1e-3)  # 1e6 rad/s is not infinity


def test_dead_time_turns_without_end():
    w = np.array([10.0, 100.0])
    found = phase_deg(Plant(num=[1], den=[1, 0], dead_time=1.0), w)
    assert found == pytest.approx(-90 - np.degrees(w), abs=1e-9)


def test_whole_samples_of_delay_turn_a_sampled_loop():
    late = Plant(num=[1], den=[1, 0], dead_time=0.3)
    loop = measure(late, ONE).loop
    w = np.array([1.0, 20.0])
    # a held integrator is exp(-s dt/2)/s, in phase, up to Nyquist
    assert phase_deg(loop, w) == pytest.approx(-90 - np.degrees(w * 0.35), abs=1e-9)


def test_a_sampled_axis_ends_below_nyquist_and_a_continuous_one_where_asked():
    w = frequencies(ONE, 0.01, 1e6)
    assert w[0] == 0.01
    assert w[-1] < pi / 0.1
    assert (np.diff(w) > 0).all()
    assert frequencies(ARM, 0.01, 1e6)[-1] == pytest.approx(1e6)
    assert lowest(ARM, None) == 0.01  # a decade below 0.7809, as a power of ten


def marked(ax):
    """Return the ends of every margin mark on an axis."""
    lines = [line for line in ax.lines if line.get_color() == RED and line.get_linewidth() > 2]
    return [(float(line.get_xdata()[0]), *sorted(map(float, line.get_ydata()))) for line in lines]


def test_margins_are_marked_where_they_were_measured(good):
    m = good.margins
    top, bottom = figures.bode(good.loop, m, title="x").axes
    ((at, low, high),) = marked(top)
    assert (at, low, high) == pytest.approx((m.phase_crossover, -m.gain_margin_db, 0))
    ((at, low, high),) = marked(bottom)
    assert (at, low, high) == pytest.approx((m.crossover, -180, -180 + m.phase_margin_deg))


def test_the_curve_passes_through_the_ends_of_the_marks(good):
    top, bottom = figures.bode(good.loop, good.margins, title="x").axes
    for ax in (top, bottom):
        ((at, low, high),) = marked(ax)
        x, y = ax.lines[0].get_data()
        value = float(np.interp(np.log(at), np.log(x), y))
        # 0.05 dB or deg: a straight line between two of a thousand points
        assert min(abs(value - low), abs(value - high)) < 0.05


def test_no_margin_no_mark():
    lag = Plant(num=[0.5], den=[1, 1])
    figure = figures.bode(lag, margins(lag), title="x")
    assert marked(figure.axes[0]) == marked(figure.axes[1]) == []
    assert "Gm = ∞,  Pm = ∞" in figure.axes[0].get_title(loc="left")
    assert margins(lag).gain_margin == inf


def test_both_scales_mark_the_same_crossover(good):
    figure = figures.both_scales(good)
    (real, *_), (warped, *_) = marked(figure.axes[2])[0], marked(figure.axes[3])[0]
    assert real == pytest.approx(good.margins.crossover)
    assert warped == pytest.approx(20 * np.tan(good.margins.crossover / 20))


def test_dots_are_the_samples_and_the_line_meets_them(good):
    one = response(good, t_end=2.0)
    top, bottom = figures.step(one, reference=1.0, title="x").axes
    dots = next(line for line in top.lines if line.get_marker() == "o")
    assert np.array_equal(dots.get_ydata(), one.trace.y)
    line = next(line for line in top.lines if len(line.get_xdata()) == len(one.trace.t_between))
    meets = np.interp(dots.get_xdata(), *line.get_data())
    assert meets == pytest.approx(one.trace.y, abs=1e-9)
    assert any(len(line.get_ydata()) == len(one.trace.u) for line in bottom.lines)


def test_the_circle_of_the_nyquist_plot_touches_the_loop(good):
    (ax,) = figures.nyquist([good], title="x").axes
    radius = ax.patches[0].get_radius()
    curve = max(ax.lines, key=lambda line: len(line.get_xdata()) if line.get_linewidth() > 1 else 0)
    x, y = curve.get_data()
    away = np.hypot(x + 1, y)
    assert radius == pytest.approx(1 / good.margins.ms)
    # 1e-4 of the radius: between two points of the curve the least distance is a parabola's
    assert away.min() == pytest.approx(radius, rel=1e-4)


def drawings(good):
    one = response(good, t_end=2.0)
    return [
        figures.bode(good.loop, good.margins, title="x"),
        figures.both_scales(good),
        figures.compare([good, good], title="x"),
        figures.step(one, reference=1.0, title="x"),
        figures.steps([one, one], reference=1.0, title="x"),
        figures.step_pair([("a", [one]), ("b", [one])], reference=1.0, title="x"),
        figures.efforts([one], title="x"),
        figures.nyquist([good, good, good], title="x"),
    ]


def test_the_same_loop_gives_the_same_bytes_whatever_the_user_prefers(good):
    once = [figures.render(figure) for figure in drawings(good)]
    with matplotlib.rc_context({"lines.linewidth": 9, "font.size": 30, "svg.hashsalt": "y"}):
        again = [figures.render(figure) for figure in drawings(good)]
        assert matplotlib.rcParams["font.size"] == 30  # and the user's are left as they were
    assert once == again
    for svg, png in once:
        assert svg.startswith("<?xml")
        assert "<dc:date>" not in svg
        assert png.startswith(b"\x89PNG")
        assert b"tIME" not in png


def test_pyplot_and_a_display_are_never_touched():
    code = "import sys, zoh.report.document; print('matplotlib.pyplot' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_a_comparison_of_good_unstable_and_refused_designs(good):
    unstable = measure(ARM, TOO_MUCH, law="p", name="Lead | one")
    refusals = [
        ("Lag", Infeasible("a lag cannot", needed_deg=36.1, laws_that_can=("lead",))),
        ("Odd", SpecError("wc", "must be above 0", -1, "give rad/s")),
    ]
    files = comparison([good, unstable], title="Mixed", refused=refusals)
    text = files["REPORT.md"]
    assert text.startswith("# Mixed\n")
    assert "**unstable**" in text
    assert "the closed loop is unstable" in text
    assert "laws that can here: " in text
    assert "must be above 0" in text
    assert "Lead \\| one" in text  # a name cannot break its table
    assert f"| phase margin, deg | {good.margins.phase_margin_deg:.4g} |" in text
    assert {"bode-lead-one.svg", "bode-lead-one-2.svg", "step-lead-one.svg"} <= set(files)
    assert "step-lead-one-2.svg" not in files  # an unstable loop has no step to show
    assert all(f"]({name})" in text for name in files if name != "REPORT.md")


def test_a_comparison_of_nothing_but_refusals():
    files = comparison([], refused=[("Lag", Infeasible("cannot", needed_deg=1.0))])
    assert list(files) == ["REPORT.md"]
    assert "cannot" in files["REPORT.md"]


def test_controllers_read_as_they_are_written():
    assert in_z(PD) == "(50 z - 48)/(z - 0.8)"
    assert in_z(ONE) == "1"
    # w = 20 (z - 1)/(z + 1) takes (z - 1)/z to 2 w/(w + 20)
    assert in_w(Sampled(num=[1.0, -1.0], den=[1.0, 0.0], dt=0.1)) == "(2 w)/(w + 20)"


def test_numbers_and_names_for_people():
    assert [number(x) for x in (None, inf, 0.0, 40.0, -0.25)] == ["-", "∞", "0", "40", "-0.25"]
    assert slug("") == "design"
    assert slug("A/B", ["a-b", "a-b-2"]) == "a-b-3"
