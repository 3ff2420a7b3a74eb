"""The highest point of a function on a unit interval or square, found by trying.

A grid comes first, for there may be several hills; the best of them are climbed by the simplex
of Nelder and Mead, which asks for no derivative: what is climbed here is the smallest of several
requirements, and bends where one takes over from another.
Source: J. A. Nelder, R. Mead, A simplex method for function minimization, The Computer Journal
7(4), 1965.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from itertools import product

Point = tuple[float, ...]
Height = Callable[[Point], float]

_SIDE = (1, 25, 15)  # points of the grid's side, by the number of coordinates
_ROUNDS = (0, 24, 70)  # of a simplex, at most
_LEVEL = 1e-6  # a simplex whose corners differ by less has arrived


class HighEnough(Exception):
    """Raised by a height function to end a climb."""


@lru_cache(maxsize=4)
def grid(size: int) -> tuple[Point, ...]:
    """Return the points of the grid on [0, 1]^size.

    >>> grid(0), len(grid(1)), len(grid(2))
    (((),), 25, 225)
    """
    side = _SIDE[size]
    return tuple(product([i / max(1, side - 1) for i in range(side)], repeat=size))


def coarse(points: Sequence[Point]) -> list[Point]:
    """Return every other point of the grid's each side.

    >>> len(coarse(grid(2))), len(coarse(grid(1)))
    (64, 13)
    """
    return [point for point in points if all(i % 2 == 0 for i in _place(point))]


def tops(heights: Mapping[Point, float], side: int = 1) -> list[Point]:
    """Return the points of a grid, of which some may be left out, that no neighbour exceeds.

    The highest comes first. ``side`` is the distance of neighbours, in points.

    >>> tops(dict(zip(grid(1), [0.0, 2.0, 1.0, 3.0, *range(0, -21, -1)]))) == [(3 / 24,), (1 / 24,)]
    True
    """
    by_place = {_place(point): point for point in heights}
    found = []
    for place, point in by_place.items():
        around = product(*([i - side, i, i + side] for i in place))
        if all(heights[by_place[n]] <= heights[point] for n in around if n in by_place):
            found.append(point)
    return sorted(found, key=lambda point: -heights[point])


def _place(point: Point) -> tuple[int, ...]:
    return tuple(round(c * (_SIDE[len(point)] - 1)) for c in point)


def climb(height: Height, start: Point, step: float | None = None) -> None:
    """Climb from ``start`` by a simplex; whoever calls remembers the points that were asked for.

    step  the simplex's size; the grid's where it is None

    >>> asked = {}
    >>> climb(lambda p: asked.setdefault(p, -abs(p[0] - 0.3) - abs(p[1] - 0.7)), (0.2, 0.7))
    >>> round(max(asked.values()), 3)
    -0.0
    """
    size = len(start)
    if not size:
        return
    step = step or 0.5 / (_SIDE[size] - 1)
    corners = [start]
    for i in range(size):
        moved = list(start)
        moved[i] += step if moved[i] + step <= 1 else -step
        corners.append(_inside(moved))
    ranked = sorted(((height(p), p) for p in corners), reverse=True)
    for _ in range(_ROUNDS[size]):
        if ranked[0][0] - ranked[-1][0] < _LEVEL:
            return
        ranked = _moved(height, ranked)


def _moved(height: Height, ranked: list[tuple[float, Point]]) -> list[tuple[float, Point]]:
    """Return the simplex after one move of its lowest corner, the highest first."""
    *others, (lowest, worst) = ranked
    middle = [sum(c) / len(others) for c in zip(*(p for _, p in others), strict=True)]

    def along(t: float) -> tuple[float, Point]:
        point = _inside([m + t * (m - w) for m, w in zip(middle, worst, strict=True)])
        return height(point), point

    found = along(1.0)
    if found[0] > others[0][0]:
        found = max(found, along(2.0))
    elif found[0] <= others[-1][0]:
        found = along(0.5 if found[0] > lowest else -0.5)
    if found[0] > lowest:
        return sorted([*others, found], reverse=True)
    best = others[0][1]  # all corners move towards it
    nearer = [tuple((a + b) / 2 for a, b in zip(best, p, strict=True)) for _, p in ranked[1:]]
    return sorted([others[0], *((height(p), p) for p in nearer)], reverse=True)


def _inside(point: Sequence[float]) -> Point:
    return tuple(min(1.0, max(0.0, c)) for c in point)
