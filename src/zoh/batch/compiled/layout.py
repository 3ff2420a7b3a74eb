"""Arrays that a loop needs, all in one stretch of memory, each at a place that is known beforehand.

Compiled code is handed the stretch's address alone. Where an array begins, how long it is and how
its rows follow are then constants of it: nothing of that is passed on, kept at hand or worked out,
and no array has an owner to be counted in and out at each call.
"""

from math import prod
from typing import Any, Generic, TypeVar, cast

import numpy as np

from zoh.batch.arrays.rows import Array

T = TypeVar("T")
Shape = tuple[int, ...]
_FLOAT = 8  # bytes
_LINE = 8  # floats that come from memory at once


class Layout(Generic[T]):
    """Where the arrays of a named tuple are: its fields one after the other, from ``first`` on.

    kind, places, shapes  of the tuple, and of its fields;  end  the place after the last one
    """

    def __init__(self, kind: type[T], first: int, **shapes: Shape) -> None:
        """Set the arrays out."""
        self.kind, self.places = kind, list[int]()
        self.shapes = [shapes[name] for name in cast(Any, kind)._fields]
        for shape in self.shapes:
            self.places.append(first)
            first += -(-prod(shape) // _LINE) * _LINE
        self.end = first

    def of(self, floats: Array) -> T:
        """Return the arrays of a stretch of memory."""
        return self.kind(
            *(
                floats[first : first + prod(shape)].reshape(shape)
                for first, shape in zip(self.places, self.shapes, strict=True)
            )
        )


def stretch(length: int) -> Array:
    """Return so many floats, all 0, the first of them at the beginning of a line of memory."""
    floats = np.zeros(length + _LINE)
    skipped = -(floats.ctypes.data // _FLOAT) % _LINE
    return floats[skipped : skipped + length]
