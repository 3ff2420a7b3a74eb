"""Arrays that a loop needs, all in one stretch of memory, each at a place that is known beforehand.

Compiled code is handed the stretch's address alone. Where an array begins, how long it is and how
its rows follow are then constants of it: nothing of that is passed on, kept at hand or worked out,
and no array has an owner to be counted in and out at each call.
"""

from collections.abc import Callable
from math import prod
from typing import Any, Generic, TypeVar, cast

import numpy as np
from numba.core import cgutils, types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

from zoh.batch.arrays.rows import Array

T = TypeVar("T")
_TYPES, _GEP = cast(Any, types), cast(Any, cgutils.gep_inbounds)  # numba says no types of them
Shape = tuple[int, ...]
_FLOAT = 8  # bytes
_LINE = 8  # floats that come from memory at once


class Layout(Generic[T]):
    """Where the arrays of a named tuple are: its fields one after the other, from ``first`` on.

    end  the place after the last one;  at  what returns them in compiled code, given an address
    """

    def __init__(self, kind: type[T], first: int, **shapes: Shape) -> None:
        """Set the arrays out."""
        self._kind, self._first = kind, list[int]()
        self._shapes = [shapes[name] for name in cast(Any, kind)._fields]
        for shape in self._shapes:
            self._first.append(first)
            first += -(-prod(shape) // _LINE) * _LINE
        self.end = first
        self.at = cast(Callable[[int], T], intrinsic(self._compiled))

    def of(self, floats: Array) -> T:
        """Return the arrays of a stretch of memory."""
        return self._kind(
            *(
                floats[first : first + prod(shape)].reshape(shape)
                for first, shape in zip(self._first, self._shapes, strict=True)
            )
        )

    def _compiled(self, _: Any, address: Any) -> Any:
        arrays = [types.Array(types.float64, len(shape), "C") for shape in self._shapes]
        whole = _TYPES.NamedTuple(arrays, self._kind)

        def made(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            pointer = context.get_value_type(_TYPES.CPointer(types.float64))
            floats = builder.inttoptr(values[0], pointer)
            parts = [
                _array(context, builder, kind, _GEP(builder, floats, first), shape)
                for kind, first, shape in zip(arrays, self._first, self._shapes, strict=True)
            ]
            return context.make_tuple(builder, signature.return_type, parts)

        return whole(address), made


def _array(context: Any, builder: Any, kind: Any, data: Any, shape: Shape) -> Any:
    array = cast(Any, make_array)(kind)(context, builder)
    strides = [_FLOAT * prod(shape[k + 1 :]) for k in range(len(shape))]
    constants = [[context.get_constant(types.intp, x) for x in xs] for xs in (shape, strides)]
    size = context.get_constant(types.intp, _FLOAT)
    cast(Any, populate_array)(array, data, *constants, size, None)
    return array._getvalue()


def _bare(_: Any, kept: Any) -> Any:
    def made(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return _uncounted(context, builder, signature.args[0], values[0])

    return kept(kept), made


def _uncounted(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    if isinstance(kind, types.Array):
        array = cast(Any, make_array)(kind)(context, builder, value)
        array.meminfo = context.get_constant_null(cast(Any, types.MemInfoPointer)(kind.dtype))
        array.parent = context.get_constant_null(types.pyobject)
        return array._getvalue()
    for place, part in enumerate(kind.types):
        inner = _uncounted(context, builder, part, builder.extract_value(value, place))
        value = builder.insert_value(value, inner, place)
    return value


bare = cast(Callable[[T], T], intrinsic(_bare))
"""Return a tuple of arrays, or of such tuples, not counted: whoever calls must keep it alive."""


def stretch(length: int) -> Array:
    """Return so many floats, all 0, the first of them at the beginning of a line of memory."""
    floats = np.zeros(length + _LINE)
    skipped = -(floats.ctypes.data // _FLOAT) % _LINE
    return floats[skipped : skipped + length]
