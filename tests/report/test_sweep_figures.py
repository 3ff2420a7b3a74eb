"""The figures of a sweep show its numbers: the cells of a map, the quantiles of a band."""

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from zoh.report.figures import render
from zoh.report.sweep import Axis, bands, line, value_map

X = Axis(values=np.array([1.0, 2.0, 3.0]), label="crossover, rad/s")
Y = Axis(values=np.array([0.01, 0.1, 1.0, 10.0]), label="sample time, s")


def of(shape, value):
    return Axis(values=np.asarray(value, float).reshape(shape), label="Ms")


def test_a_map_has_a_cell_for_each_loop_and_a_blank_for_each_that_is_none():
    values = np.arange(12.0)
    values[5] = np.nan
    figure = value_map(X, Y, of((3, 4), values), bound=6.5, title="a map")
    ax = figure.axes[0]
    mesh = ax.collections[0]
    assert mesh.get_array().shape == (4, 3)
    assert mesh.get_array()[1, 2] == values.reshape(3, 4)[2, 1]
    assert mesh.get_array().mask.sum() == 1
    assert (ax.get_xscale(), ax.get_yscale()) == ("linear", "log")
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "no stable loop", "bound, 6.5",
    ]  # fmt: skip
    assert render(figure) == render(value_map(X, Y, of((3, 4), values), bound=6.5, title="a map"))


def test_one_odd_loop_does_not_take_all_the_colours():
    values = np.append(np.linspace(1, 2, 399), 1000.0)
    x, y = (Axis(values=np.linspace(1, 2, n), label="") for n in (20, 20))
    mesh = value_map(x, y, of((20, 20), values)).axes[0].collections[0]
    assert mesh.get_clim()[1] < 2.1


def test_a_map_of_nothing_is_blank():
    figure = value_map(X, Y, of((3, 4), np.full(12, np.nan)))
    assert figure.axes[0].collections[0].get_array().mask.all()


def test_bands_are_the_quantiles_of_the_loops():
    # 100 loops at each of 10 places, with the values 0 to 99: the median is 49.5
    x = Axis(values=np.repeat(np.arange(1.0, 11.0), 100), label="gain")
    value = Axis(values=np.tile(np.arange(100.0), 10), label="Ms")
    figure = bands(x, value, bound=80.0)
    ax = figure.axes[0]
    median = next(drawn for drawn in ax.lines if drawn.get_label() == "median")
    assert len(median.get_xdata()) == 24
    wide = ax.collections[0].get_paths()[0].vertices[:, 1]
    assert wide.min() >= 0
    assert wide.max() <= 99
    few = Axis(values=np.full(15, np.nan), label="Ms")
    few.values[:3] = 1.0
    assert len(bands(Axis(values=np.arange(15.0), label="gain"), few).axes[0].lines) == 1


def test_a_line_ends_where_there_is_no_loop():
    figure = line(X, Axis(values=np.array([1.0, np.nan, 3.0]), label="Ms"), bound=2.0)
    drawn = figure.axes[0].lines[0]
    assert np.isnan(drawn.get_ydata()[1])
    assert [text.get_text() for text in figure.axes[0].get_legend().get_texts()] == ["bound, 2"]
