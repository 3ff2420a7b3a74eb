"""How every function here is compiled: for this processor, free of Python's lock and of Python.

A product and a sum may be fused, nothing may be reordered; a division by 0 is inf, as in NumPy.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any, TypeVar, cast

from numba import njit, types
from numba.core import config
from numba.core.compiler_lock import global_compiler_lock

Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """Return the function, compiled into each place that calls it: no arrays are passed.

    It is compiled by itself first, all the same. What it does to two numbers alike may be a vector
    of the two by then (SLP), and a loop over lanes that calls it stays as it is.
    """
    made = njit(error_model="numpy", fastmath={"contract"}, forceinline=True)(function)
    return cast(Function, made)


def shared(function: Function) -> Function:
    """Return the function, compiled once for all who call it: it is long, or called from many.

    That must be said: what is not, it has from the function it is first called by.
    """
    made = njit(error_model="numpy", fastmath={"contract"}, forceinline=False)(function)
    return cast(Function, made)


def object_file(function: Callable[..., None], wholes: int) -> tuple[str, bytes]:
    """Return (the name, the object file) of a function of so many whole numbers and a float.

    Equal operations in a row are done as one (SLP). numba leaves that out unless its own setting
    says otherwise, which others' code goes by, too; so it is set under numba's own lock. Nothing
    is called but what LLVM finds without numba: no array is counted, none made.
    """
    made = cast(Any, njit)(
        error_model="numpy", fastmath={"contract"}, no_cpython_wrapper=True,
        no_cfunc_wrapper=True, _nrt=False,
    )(function)  # fmt: skip
    with cast(AbstractContextManager[None], global_compiler_lock):
        before = vars(config)["SLP_VECTORIZE"]
        vars(config)["SLP_VECTORIZE"] = 1
        try:
            made.compile((types.int64,) * wholes + (types.float64,))
            (found,) = made.overloads.values()
            name = found.fndesc.llvm_func_name
            found.library.get_pointer_to_function(name)
        finally:
            vars(config)["SLP_VECTORIZE"] = before
    _, _, (code, _) = found.library.serialize_using_object_code()
    return name, code
