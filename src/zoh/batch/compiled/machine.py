"""The kernel's machine code made a function by LLVM alone: numba takes a second to start.

Source: numba's manual for developers, "Numba architecture": a function is called with a place for
its result and a place for its exception before its arguments, and returns 0.
"""

import ctypes
from collections.abc import Callable
from functools import partial
from typing import Any, cast

import llvmlite.binding

Kernel = Callable[..., int]
WHOLES = 18  # arguments of the kernel that are whole numbers; the last one is a float
_LLVM = cast(Any, llvmlite.binding)  # says no types
_KEPT: list[object] = []  # code is there as long as its engine is


def processor() -> str:
    """Return what code is made for, and by which LLVM."""
    has = sorted(name for name, there in _LLVM.get_host_cpu_features().items() if there)
    made_for = [_LLVM.get_process_triple(), _LLVM.get_host_cpu_name(), *has]
    return " ".join([*made_for, *(str(n) for n in _LLVM.llvm_version_info)])


def loaded(name: str, code: bytes) -> Kernel:
    """Return the function of this name in an object file; raise LookupError where it has none."""
    _LLVM.initialize_native_target()
    _LLVM.initialize_native_asmprinter()
    machine = _LLVM.Target.from_default_triple().create_target_machine(jit=True)
    engine = _LLVM.create_mcjit_compiler(_LLVM.parse_assembly(""), machine)
    engine.add_object_file(_LLVM.ObjectFileRef.from_data(code))
    engine.finalize_object()
    address = engine.get_function_address(name)
    if not address:
        raise LookupError(f"the machine code has no function {name}")
    places = [ctypes.c_void_p] * 2 + [ctypes.c_int64] * WHOLES + [ctypes.c_double]
    found = ctypes.CFUNCTYPE(ctypes.c_int, *places)(address)
    result, wrong = ctypes.c_void_p(), ctypes.c_void_p()
    _KEPT.append((engine, result, wrong))
    return partial(found, ctypes.addressof(result), ctypes.addressof(wrong))
