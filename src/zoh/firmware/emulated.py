"""A controller on an emulated processor: whole trials in one call, or sample by sample.

The image is loaded, the driver is called, the outputs and the state are read back from memory. A
counter compiled for this machine is called before every instruction: in Python it would be forty
times slower.
"""

import ctypes
from typing import Any

import numpy as np

from zoh.firmware.cores import Core
from zoh.firmware.elf import Image
from zoh.firmware.harness import COUNT, END, RUN
from zoh.firmware.toolchain import package
from zoh.firmware.trials import Outcome, Trial

_CODE, _RAM, _BACK = 0x10000, 0x20000000, 0x70000000  # image; memory; where the driver returns to
_MEGABYTE = 1 << 20
_STATE, _WHAT, _GIVEN, _OUT, _TOP = (_RAM + k * _MEGABYTE for k in (0, 1, 2, 6, 8))
_REGISTERS = {
    "arm": ("unicorn.arm_const", "UC_ARM_REG_", ("R0", "R1", "R2", "R3"), "SP", "LR"),
    "riscv": ("unicorn.riscv_const", "UC_RISCV_REG_", ("A0", "A1", "A2", "A3"), "SP", "RA"),
}
_PROBES = 500  # samples in which the depth of the stack is looked at


class Counts(ctypes.Structure):
    """The counter's memory, as its C has it."""

    _fields_ = (
        ("entry", ctypes.c_uint64), ("first", ctypes.c_uint64), ("last", ctypes.c_uint64),
        ("read", ctypes.c_void_p), ("pointer", ctypes.c_int64), ("probes", ctypes.c_int64),
        ("running", ctypes.c_uint64), ("now", ctypes.c_uint64), ("samples", ctypes.c_uint64),
        ("least", ctypes.c_uint64), ("most", ctypes.c_uint64), ("total", ctypes.c_uint64),
        ("top", ctypes.c_uint32), ("deepest", ctypes.c_uint32),
    )  # fmt: skip


class Emulated:
    """One core with the image of a controller called ``name`` in its memory."""

    def __init__(self, core: Core, image: Image, name: str, state_bytes: int) -> None:
        self.core, self.image, self.name = core, image, name
        self._size = state_bytes
        home, prefix, arguments, *others = _REGISTERS[core.family]
        names = vars(package(home))
        self._arguments = [names[prefix + a] for a in arguments]
        self._pointer, self._link = (names[prefix + other] for other in others)
        self._thumb = 1 if core.family == "arm" else 0
        self._machine = _machine(core)
        for start, size in ((_CODE, 4 * _MEGABYTE), (_RAM, 8 * _MEGABYTE), (_BACK, 4096)):
            self._machine.mem_map(start, size)
        for address, data in image.segments:
            self._machine.mem_write(address, data)

    @property
    def state(self) -> bytes:
        """The bytes of the controller's state."""
        return bytes(self._machine.mem_read(_STATE, self._size))

    @state.setter
    def state(self, value: bytes) -> None:
        self._machine.mem_write(_STATE, value)

    def run(self, trial: Trial) -> Outcome:
        """Return what comes out of a trial."""
        kind = trial.given.dtype
        self._machine.mem_write(_WHAT, trial.what.tobytes() + bytes([END]))
        self._machine.mem_write(_GIVEN, trial.given.tobytes())
        self.call(RUN, _STATE, _WHAT, _GIVEN, _OUT)
        out = bytes(self._machine.mem_read(_OUT, trial.samples * kind.itemsize))
        return Outcome(outputs=np.frombuffer(out, kind), state=self.state)

    def call(self, routine: str, *arguments: int) -> int:
        """Return the word, with its sign, that a routine returns."""
        for register, value in zip(self._arguments, arguments, strict=False):
            self._machine.reg_write(register, value)
        self._machine.reg_write(self._pointer, _TOP - 256)
        self._machine.reg_write(self._link, _BACK | self._thumb)
        self._machine.emu_start(self._address(routine) | self._thumb, _BACK)
        word: int = self._machine.reg_read(self._arguments[0])
        return word - (1 << 32) if word >> 31 else word

    def counted(self, library: ctypes.CDLL) -> Counts:
        """Return the counts that the compiled counter fills in from now on."""
        run, unicorn = self._address(RUN), package("unicorn.unicorn_py3.unicorn").uclib
        counts = Counts(
            entry=self._address(f"{self.name}_step"), first=run,
            last=run + self.image.symbols[RUN].size, pointer=self._pointer, probes=_PROBES,
            read=ctypes.cast(unicorn.uc_reg_read, ctypes.c_void_p).value, least=(1 << 64) - 1,
        )  # fmt: skip
        everywhere = (ctypes.c_uint64(1), ctypes.c_uint64(0))  # an empty range stands for all
        failed = unicorn.uc_hook_add(
            self._machine._uch, ctypes.byref(ctypes.c_size_t()), package("unicorn").UC_HOOK_CODE,
            ctypes.cast(library[COUNT], ctypes.c_void_p), ctypes.byref(counts), *everywhere,
        )  # fmt: skip
        if failed:
            raise package("unicorn").UcError(failed)
        return counts

    def _address(self, routine: str) -> int:
        return self.image.symbols[routine].address & ~self._thumb


def _machine(core: Core) -> Any:
    """Return the emulator of a core, its floating-point unit switched on."""
    unicorn = package("unicorn")
    if core.family == "riscv":
        machine = unicorn.Uc(unicorn.UC_ARCH_RISCV, unicorn.UC_MODE_RISCV32)
        status = package("unicorn.riscv_const").UC_RISCV_REG_MSTATUS
        machine.reg_write(status, machine.reg_read(status) | 0x6000)  # FS: dirty
        return machine
    arm = package("unicorn.arm_const")
    full = core.model == "UC_CPU_ARM_MAX"
    mode = unicorn.UC_MODE_THUMB | (0 if full else unicorn.UC_MODE_MCLASS)
    machine = unicorn.Uc(unicorn.UC_ARCH_ARM, mode)
    machine.ctl_set_cpu_model(getattr(arm, core.model))
    if full:
        access = machine.reg_read(arm.UC_ARM_REG_C1_C0_2)
        machine.reg_write(arm.UC_ARM_REG_C1_C0_2, access | 0xF << 20)
        machine.reg_write(arm.UC_ARM_REG_FPEXC, 1 << 30)
    return machine
