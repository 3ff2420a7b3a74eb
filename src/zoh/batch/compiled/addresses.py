"""What is at an address, as arrays of compiled code; whoever calls it must keep it alive."""

from collections.abc import Callable
from math import prod
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt
from numba.core import cgutils, types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.layout import Layout, Shape

T = TypeVar("T")
_TYPES, _GEP = cast(Any, types), cast(Any, cgutils.gep_inbounds)  # numba says no types of them


def arrays(layout: Layout[T]) -> Callable[[int], T]:
    """Return what returns the arrays of a layout, in compiled code, given an address."""

    def compiled(_: Any, address: Any) -> Any:
        kinds = [types.Array(types.float64, len(shape), "C") for shape in layout.shapes]
        whole = _TYPES.NamedTuple(kinds, layout.kind)

        def made(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            pointer = context.get_value_type(_TYPES.CPointer(types.float64))
            floats = builder.inttoptr(values[0], pointer)
            parts = [
                _array(context, builder, kind, _GEP(builder, floats, first), shape)
                for kind, first, shape in zip(kinds, layout.places, layout.shapes, strict=True)
            ]
            return context.make_tuple(builder, signature.return_type, parts)

        return whole(address), made

    return cast(Callable[[int], T], intrinsic(compiled))


def _array(context: Any, builder: Any, kind: Any, data: Any, shape: Shape) -> Any:
    array = cast(Any, make_array)(kind)(context, builder)
    size = kind.dtype.bitwidth // 8
    strides = [size * prod(shape[k + 1 :]) for k in range(len(shape))]
    constants = [[context.get_constant(types.intp, x) for x in xs] for xs in (shape, strides)]
    cast(Any, populate_array)(array, data, *constants, context.get_constant(types.intp, size), None)
    return array._getvalue()


def _row(of: Any) -> Any:
    def compiled(_: Any, address: Any) -> Any:
        kind = types.Array(of, 1, "C")

        def made(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            data = builder.inttoptr(values[0], context.get_value_type(_TYPES.CPointer(of)))
            return _array(context, builder, kind, data, (_ANY,))

        return kind(address), made

    return intrinsic(compiled)


_ANY = 1 << 40  # places of a row whose length compiled code need not know
numbers = cast(Callable[[int], Array], _row(types.float64))
codes = cast(Callable[[int], "npt.NDArray[np.int8]"], _row(types.int8))
"""Return the floats, or the small whole numbers, from an address on."""
