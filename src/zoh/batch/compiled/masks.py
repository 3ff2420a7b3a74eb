"""What holds at which samples of a block, all of them asked at once.

A mask is a whole number, a bit a sample, the first one's the lowest; numba alone asks one sample
after the other. A row is asked from a column on, so that of the one before or after is, too.
Source: LLVM Language Reference Manual, "fcmp", "select" and "bitcast" of vectors, "llvm.cttz".
"""

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.room import BLOCK

_IR, _TYPES = cast(Any, ir), cast(Any, types)  # say no types
_WHOLE, _PLACE = _IR.IntType(64), _IR.IntType(32)


def _samples(context: Any, builder: Any, kind: Any, row: Any, first: Any) -> Any:
    """Return a block's samples of a row as one vector."""
    start = builder.gep(cast(Any, make_array)(kind)(context, builder, row).data, [first])
    vector = _IR.VectorType(_IR.DoubleType(), BLOCK)
    return builder.load(builder.bitcast(start, vector.as_pointer()), align=8)


def _everywhere(builder: Any, number: Any) -> Any:
    """Return a vector of the same number at every sample."""
    vector = _IR.VectorType(number.type, BLOCK)
    one = builder.insert_element(_IR.Constant(vector, None), number, _PLACE(0))
    places = _IR.Constant(_IR.VectorType(_PLACE, BLOCK), [0] * BLOCK)
    return builder.shuffle_vector(one, one, places)


def _mask(builder: Any, holds: Any) -> Any:
    return builder.zext(builder.bitcast(holds, _IR.IntType(BLOCK)), _WHOLE)


def _against(sign: str) -> Any:
    def compiled(_: Any, row: Any, first: Any, height: Any) -> Any:
        def made(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            there = _samples(context, builder, signature.args[0], *values[:2])
            return _mask(
                builder, builder.fcmp_ordered(sign, there, _everywhere(builder, values[2]))
            )

        return _TYPES.int64(row, _TYPES.int64, _TYPES.float64), made

    return intrinsic(compiled)


def _outside(_: Any, row: Any, first: Any, middle: Any, reach: Any) -> Any:
    def made(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        there = _samples(context, builder, signature.args[0], *values[:2])
        off = builder.fsub(there, _everywhere(builder, values[2]))
        above = builder.fcmp_ordered(">", off, _everywhere(builder, values[3]))
        below = builder.fcmp_ordered("<", off, _everywhere(builder, builder.fneg(values[3])))
        return _mask(builder, builder.or_(above, below))

    return _TYPES.int64(row, _TYPES.int64, _TYPES.float64, _TYPES.float64), made


def _higher(_: Any, row: Any, first: Any, second: Any) -> Any:
    def made(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        one, other = (
            _samples(context, builder, signature.args[0], values[0], at) for at in values[1:]
        )
        return _mask(builder, builder.fcmp_ordered(">", one, other))

    return _TYPES.int64(row, _TYPES.int64, _TYPES.int64), made


def _end(sign: str) -> Any:
    def compiled(_: Any, row: Any, first: Any) -> Any:
        def made(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            rest, count = _samples(context, builder, signature.args[0], *values), BLOCK
            while count > 1:
                count //= 2
                half = _IR.VectorType(_PLACE, count)
                low, high = (
                    builder.shuffle_vector(rest, rest, _IR.Constant(half, list(places)))
                    for places in (range(count), range(count, 2 * count))
                )
                rest = builder.select(builder.fcmp_ordered(sign, low, high), low, high)
            return builder.extract_element(rest, _PLACE(0))

        return _TYPES.float64(row, _TYPES.int64), made

    return intrinsic(compiled)


def _lowest_bit(_: Any, mask: Any) -> Any:
    def made(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.cttz(values[0], _IR.IntType(1)(1))

    return _TYPES.int64(_TYPES.int64), made


def _highest_bit(_: Any, mask: Any) -> Any:
    def made(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.sub(_WHOLE(63), builder.ctlz(values[0], _IR.IntType(1)(1)))

    return _TYPES.int64(_TYPES.int64), made


# masks of a row's samples from a column on: those above a height, at least as high, below it; those
# further from a middle than a reach; those higher than as many from another column on
above = cast(Callable[[Array, int, float], int], _against(">"))
at_least = cast(Callable[[Array, int, float], int], _against(">="))
below = cast(Callable[[Array, int, float], int], _against("<"))
outside = cast(Callable[[Array, int, float, float], int], intrinsic(_outside))
higher = cast(Callable[[Array, int, int], int], intrinsic(_higher))
# the highest and the lowest of a block's samples
highest = cast(Callable[[Array, int], float], _end(">"))
lowest = cast(Callable[[Array, int], float], _end("<"))
# the first and the last sample of a mask that is not 0
first_of = cast(Callable[[int], int], intrinsic(_lowest_bit))
last_of = cast(Callable[[int], int], intrinsic(_highest_bit))
