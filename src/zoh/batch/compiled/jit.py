"""How every function here is compiled: once, kept on disk, free of Python's lock.

A product and a sum may be fused, nothing may be reordered; a division by 0 is inf, as in NumPy.
"""

from collections.abc import Callable
from typing import TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """Return the function, compiled when it is first called."""
    made = njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})(function)
    return cast(Function, made)
