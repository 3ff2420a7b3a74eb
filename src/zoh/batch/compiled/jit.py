"""How every function here is compiled: once, kept on disk, free of Python's lock.

A product and a sum may be fused, nothing may be reordered; a division by 0 is inf, as in NumPy.
What is kept on disk is known by one file's time alone, and would be used after a change in
another file that it calls. So only ``kept`` functions are, and they carry a stamp of the whole
folder in a variable that the key takes in.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
from hashlib import sha256
from importlib.resources import files
from typing import TypeVar, cast

from numba import njit
from numba.core import config
from numba.core.compiler_lock import global_compiler_lock

Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """Return the function, compiled into each place that calls it: no arrays are passed."""
    made = njit(nogil=True, error_model="numpy", fastmath={"contract"}, forceinline=True)(function)
    return cast(Function, made)


def shared(function: Function) -> Function:
    """Return the function, compiled once for all who call it: it is long, or called from many."""
    made = njit(nogil=True, error_model="numpy", fastmath={"contract"})(function)
    return cast(Function, made)


def kept(function: Function) -> Function:
    """Return the function, compiled when it is first called and kept on disk."""
    made = njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})(function)
    vars(made)["compile"] = side_by_side(made.compile)
    return cast(Function, made)


def side_by_side(plain: Callable[..., object]) -> Callable[..., object]:
    """Return what compiles as ``plain``, equal operations in a row done as one: SLP.

    numba leaves that out unless its own setting says otherwise, which others' code goes by, too.
    """

    def compiles(*signature: object) -> object:
        with cast(AbstractContextManager[None], global_compiler_lock):
            before = vars(config)["SLP_VECTORIZE"]
            vars(config)["SLP_VECTORIZE"] = 1
            try:
                return plain(*signature)
            finally:
                vars(config)["SLP_VECTORIZE"] = before

    return compiles


def stamp() -> int:
    """Return a number that changes with any source in this folder, and with the tolerances."""
    here = files(__package__)
    read = {f.name: f.read_bytes() for f in here.iterdir() if f.name.endswith(".py")}
    read["tolerances"] = files("zoh.batch").joinpath("tolerances.py").read_bytes()
    return int.from_bytes(sha256(repr(sorted(read.items())).encode()).digest()[:6])
