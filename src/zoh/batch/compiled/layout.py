"""Arrays without an owner, for the time of one call.

Each function that is handed an array counts it as one more in use and at its end as one less, which
every core must see at once: of some fifty that takes longer than most of the work. An array
without an owner is not counted.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba.core import types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

T = TypeVar("T")


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
