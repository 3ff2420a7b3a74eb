"""What a sweep runs over: a grid, rows, corners or a random sample; any stretch of it by its place.

Each has ``keys``, a ``size``, and ``columns(start, stop)``, the batch of loops start ... stop - 1.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod

import numpy as np

from zoh import checks
from zoh.batch import draws
from zoh.batch.sources import FloatArray
from zoh.batch.spread import Normal, Spread
from zoh.errors import SpecError

MOST_LOOPS = 2**53  # counted in floats where they are stored


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grid:
    """Every combination of the values of each key, the last key changing fastest.

    >>> Grid(axes={"wc": [1.0, 2.0], "dt": [0.1, 0.2]}).columns(1, 3)
    {'wc': array([1., 2.]), 'dt': array([0.2, 0.1])}
    """

    axes: Mapping[str, Sequence[float] | FloatArray]

    def __post_init__(self) -> None:
        object.__setattr__(self, "axes", _columns("axes", self.axes))
        _checked_size(self.size)

    @property
    def keys(self) -> tuple[str, ...]:
        """Return the keys, in the order of their columns."""
        return tuple(self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the number of values of each key."""
        return tuple(len(axis) for axis in self.axes.values())

    @property
    def size(self) -> int:
        """Return the number of loops."""
        return prod(self.shape)

    def columns(self, start: int, stop: int) -> dict[str, FloatArray]:
        """Return the batch of loops start ... stop - 1."""
        places = np.unravel_index(np.arange(start, stop), self.shape)
        axes = self.axes.items()
        return {k: np.asarray(axis)[p] for (k, axis), p in zip(axes, places, strict=True)}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rows:
    """Loops one by one: row i has value i of each key.

    >>> Rows(values={"wc": [1.0, 2.0], "dt": [0.1, 0.2]}).columns(1, 2)
    {'wc': array([2.]), 'dt': array([0.2])}
    """

    values: Mapping[str, Sequence[float] | FloatArray]

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", _columns("values", self.values))
        lengths = sorted({len(column) for column in self.values.values()})
        if len(lengths) > 1:
            raise SpecError("values", "must be of one length", lengths, "complete the short ones")

    @property
    def keys(self) -> tuple[str, ...]:
        """Return the keys, in the order of their columns."""
        return tuple(self.values)

    @property
    def size(self) -> int:
        """Return the number of loops."""
        return len(next(iter(self.values.values())))

    def columns(self, start: int, stop: int) -> dict[str, FloatArray]:
        """Return the batch of loops start ... stop - 1."""
        return {key: np.asarray(column)[start:stop] for key, column in self.values.items()}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Random:
    """A random sample: count loops, each key drawn from its spread, independent of the others.

    seed   the same one gives the same sample, and a key's column whatever stands beside it
    latin  a Latin hypercube: of count equally likely cells each key is in every one once, in a
           random order (M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21, 1979)

    >>> from zoh.batch.spread import Uniform
    >>> spreads = {"wc": Uniform(low=0.0, high=4.0)}
    >>> cells = Random(spreads=spreads, count=4, seed=1, latin=True).columns(0, 4)["wc"]
    >>> sorted(np.floor(cells).tolist())
    [0.0, 1.0, 2.0, 3.0]
    """

    spreads: Mapping[str, Spread]
    count: int
    seed: int = 0
    latin: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "spreads", _spreads(self.spreads))
        object.__setattr__(self, "count", checks.whole("count", self.count, 1, "count the loops"))
        object.__setattr__(self, "seed", checks.whole("seed", self.seed, 0, "a whole number"))
        _checked_size(self.count)

    @property
    def keys(self) -> tuple[str, ...]:
        """Return the keys, in the order of their columns."""
        return tuple(self.spreads)

    @property
    def size(self) -> int:
        """Return the number of loops."""
        return self.count

    def columns(self, start: int, stop: int) -> dict[str, FloatArray]:
        """Return the batch of loops start ... stop - 1; it needs no other loop."""
        return {k: spread.at(self._shares(k, start, stop)) for k, spread in self.spreads.items()}

    def _shares(self, key: str, start: int, stop: int) -> FloatArray:
        drawn = draws.uniform(self.seed, key, start, stop)
        if not self.latin:
            return drawn
        cells = draws.permuted(self.seed, key, self.count, start, stop)
        inside: FloatArray = (cells + drawn) / self.count
        return np.minimum(inside, 1 - 2.0**-53)  # the last cell's end may round to 1


Space = Grid | Rows | Random


def corners(spreads: Mapping[str, Spread]) -> Grid:
    """Return every combination of the ends of each spread, 2^k loops.

    >>> from zoh.batch.spread import Uniform
    >>> corners({"plant.gain": Uniform(low=2.0, high=3.0)}).columns(0, 2)
    {'plant.gain': array([2., 3.])}
    """
    ends = {}
    for key, spread in _spreads(spreads).items():
        if isinstance(spread, Normal):
            way_out = "give zoh.Uniform(low=..., high=...)"
            raise SpecError(f"spreads[{key!r}]", "must have ends", spread, way_out)
        ends[key] = [spread.low, spread.high]
    return Grid(axes=ends)


def as_space(over: object) -> Space:
    """Return a space as it is, a mapping of values as the grid of them."""
    if isinstance(over, Grid | Rows | Random):
        return over
    if isinstance(over, Mapping):
        if any(isinstance(values, Spread) for values in over.values()):
            way_out = "zoh.Random(spreads=..., count=...) draws from them, zoh.corners has the ends"
            raise SpecError("over", "must have lists of values", dict(over), way_out)
        return Grid(axes=_columns("over", over))
    way_out = 'such as {"wc": [1, 2, 3]}, zoh.Random(...), zoh.Rows(...) or zoh.corners(...)'
    raise SpecError("over", "must say what varies", over, way_out)


def _columns(name: str, given: object) -> dict[str, FloatArray]:
    """Return the values by key as read-only float64 columns."""
    if not isinstance(given, Mapping) or not given:
        raise SpecError(name, "must name a key or more", given, 'such as {"wc": [1, 2, 3]}')
    found = {checks.text(name, k): checks.column(f"{name}[{k!r}]", v) for k, v in given.items()}
    for key, column in found.items():
        if not len(column):
            raise SpecError(f"{name}[{key!r}]", "must have a value", [], "or leave the key out")
    return found


def _spreads(given: object) -> dict[str, Spread]:
    way_out = 'such as {"plant.gain": zoh.Uniform(low=2, high=3)}'
    if not isinstance(given, Mapping) or not given:
        raise SpecError("spreads", "must name a key or more", given, way_out)
    for key, spread in given.items():
        if not isinstance(spread, Spread):
            raise SpecError(f"spreads[{key!r}]", "must be a spread", spread, way_out)
    return {checks.text("spreads", key): spread for key, spread in given.items()}


def _checked_size(size: int) -> None:
    if size > MOST_LOOPS:
        raise SpecError("over", f"must have {MOST_LOOPS} loops or fewer", size, "coarser axes")
