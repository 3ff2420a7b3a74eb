"""Random numbers by their place: draw i of a stream needs the seed, the stream's name and i.

So any stretch of a sample can be made anywhere, in any order, in blocks of any length, and a
stream does not change when another one is added beside it. The generator counts: Philox 4x64
(J. K. Salmon et al., Parallel Random Numbers: As Easy as 1, 2, 3, SC11), which gives four numbers
for each step of its counter.
"""

from math import isqrt
from zlib import crc32

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Counts = npt.NDArray[np.uint64]

_PER_STEP = 4
_GRAIN = 2.0**-52  # a draw is in the middle of one of 2^52 cells, so never 0 and never 1
_ROUNDS = 4  # each of them moves both


def uniform(seed: int, name: str, start: int, stop: int) -> FloatArray:
    """Return draws start to stop - 1 of a stream, uniform in the open interval (0, 1).

    >>> bool((uniform(7, "wc", 3, 9) == uniform(7, "wc", 0, 9)[3:]).all())
    True
    """
    stream = np.random.Philox(_sequence(seed, name, 0))
    stream.advance(start // _PER_STEP)
    skipped = start % _PER_STEP
    raw = np.random.Generator(stream).random(stop - start + skipped)[skipped:]
    drawn: FloatArray = (np.floor(raw / _GRAIN) + 0.5) * _GRAIN
    return drawn


def permuted(seed: int, name: str, count: int, start: int, stop: int) -> Counts:
    """Return places start to stop - 1 of a random order of 0 ... count - 1.

    A place is a row and a column of a rectangle that has count cells or a few more. In turns the
    rows are moved on by a number that hangs on the column, and the columns by one that hangs on
    the row; what falls outside is sent through again until it is inside (J. Black, P. Rogaway,
    Ciphers with Arbitrary Finite Domains, CT-RSA 2002). No place knows of another, so nothing of
    the length of count is ever held.

    >>> sorted(permuted(7, "wc", 5, 0, 5).tolist())
    [0, 1, 2, 3, 4]
    """
    keys = _sequence(seed, name, 1).generate_state(2 * _ROUNDS, np.uint64)
    rows = isqrt(count - 1) + 1
    columns = -(-count // rows)
    found = np.arange(start, stop, dtype=np.uint64)
    outside = np.ones(len(found), bool)
    while outside.any():
        row, column = np.divmod(found[outside], np.uint64(columns))
        for one, other in keys.astype(np.uint64).reshape(_ROUNDS, 2):
            row = _moved(row, _mixed(column ^ one), np.uint64(rows))
            column = _moved(column, _mixed(row ^ other), np.uint64(columns))
        found[outside] = row * np.uint64(columns) + column
        outside = found >= count
    return found


def _moved(x: Counts, by: Counts, size: np.uint64) -> Counts:
    """Return x, in 0 ... size - 1, moved on around by a share of the size; below 2^32."""
    half = np.uint64(32)
    moved: Counts = x + ((by >> half) * size >> half)
    return np.where(moved >= size, moved - size, moved)


def _mixed(x: Counts) -> Counts:
    """Return x with its bits mixed: the end of G. Steele's SplitMix64 (OOPSLA 2014)."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed: Counts = x ^ (x >> np.uint64(31))
    return mixed


def _sequence(seed: int, name: str, kind: int) -> np.random.SeedSequence:
    return np.random.SeedSequence(seed, spawn_key=(crc32(name.encode()), kind))
