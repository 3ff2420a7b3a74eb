"""What is asked of all samples of a block at once, beside NumPy."""

import numpy as np
import pytest

pytest.importorskip("numba")

from numba import njit

from zoh.batch.compiled import masks
from zoh.batch.compiled.room import BLOCK, PAST


@njit
def _asked(row, height, out):
    out[0] = masks.above(row, PAST, height)
    out[1] = masks.below(row, PAST + 1, height)
    out[2] = masks.at_least(row, PAST, row[PAST + 7])
    out[3] = masks.outside(row, PAST, height, 0.25)
    out[4] = masks.higher(row, PAST, PAST - 1)
    out[5], out[6] = masks.first_of(out[0]), masks.last_of(out[0])
    return masks.highest(row, PAST), masks.lowest(row, PAST)


def test_every_sample_of_a_block_is_marked_by_itself():
    row = np.random.default_rng(7).normal(size=PAST + BLOCK + 1)
    row[PAST + 3] = 0.5  # on the height: neither above nor below, and not outside
    here, later, before = row[PAST:-1], row[PAST + 1 :], row[PAST - 1 : -2]
    out = np.zeros(7, np.int64)
    ends = _asked(row, 0.5, out)
    found = [(int(m) >> np.arange(BLOCK)) & 1 for m in out[:5]]
    wanted = (here > 0.5, later < 0.5, here >= here[7], abs(here - 0.5) > 0.25, here > before)
    assert np.array_equal(found, wanted)
    assert tuple(out[5:]) == (np.flatnonzero(here > 0.5)[0], np.flatnonzero(here > 0.5)[-1])
    assert ends == (here.max(), here.min())
