"""Arrays at known places: compiled code and Python see the same ones."""

from typing import Any, NamedTuple

import numpy as np
import pytest


class Two(NamedTuple):
    """A row and a square."""

    row: Any
    square: Any


def test_compiled_code_writes_where_python_reads():
    numba = pytest.importorskip("numba", reason="the compiled arithmetic needs numba: zoh[fast]")
    from zoh.batch.compiled.addresses import arrays
    from zoh.batch.compiled.layout import Layout, stretch

    before = Layout(Two, 0, row=(3,), square=(1, 1))
    layout = Layout(Two, before.end, square=(2, 2), row=(5,))  # in this order behind the others
    at = arrays(layout)

    @numba.njit
    def write(address, i, j):
        two = at(address)
        two.row[i], two.square[i, j] = 2.5, 7.0

    floats = stretch(layout.end)
    write(floats.ctypes.data, 1, 0)
    seen = layout.of(floats)
    assert seen.row.tolist() == [0, 2.5, 0, 0, 0]
    assert seen.square.tolist() == [[0, 0], [7, 0]]
    assert np.count_nonzero(floats) == 2
    assert floats.ctypes.data % 64 == 0
