"""The processors that firmware is proved on: how to compile for each, and what emulates it.

A Cortex-M4 "with hard floats" still computes in software unless its floating-point unit is named
beside it, and an emulator whose Cortex-M7 knows no doubles needs another model that does: what a
target really takes is written here once.
Source: Arm, Procedure Call Standard for the Arm Architecture (AAPCS32); RISC-V ELF psABI.
"""

from dataclasses import dataclass
from typing import Literal

from zoh.errors import SpecError

THUMB_SOFT = "thumb-freestanding-eabi"
THUMB_HARD = "thumb-freestanding-eabihf"
RISCV = "riscv32-freestanding-none"


@dataclass(frozen=True, slots=True, kw_only=True)
class Core:
    """One processor core.

    name      as a user writes it; title as people read it
    triple, cpu, flags   what the compiler is told
    model     the emulator's model of it, by the name of unicorn's constant; "" its default
    hardware  the number formats whose floats this core computes in hardware
    """

    name: str
    title: str
    family: Literal["arm", "riscv"]
    triple: str
    cpu: str
    flags: tuple[str, ...] = ()
    model: str = ""
    hardware: tuple[str, ...] = ()


CORES = (
    Core(
        name="cortex-m0+", title="Cortex-M0+", family="arm", triple=THUMB_SOFT,
        cpu="cortex_m0plus", model="UC_CPU_ARM_CORTEX_M0",
    ),
    Core(
        name="cortex-m3", title="Cortex-M3", family="arm", triple=THUMB_SOFT,
        cpu="cortex_m3", model="UC_CPU_ARM_CORTEX_M3",
    ),
    Core(
        name="cortex-m4f", title="Cortex-M4F", family="arm", triple=THUMB_HARD,
        cpu="cortex_m4+vfp4d16sp", model="UC_CPU_ARM_CORTEX_M4", hardware=("f32",),
    ),
    Core(
        name="cortex-m33", title="Cortex-M33", family="arm", triple=THUMB_HARD,
        cpu="cortex_m33+fp_armv8d16sp", model="UC_CPU_ARM_CORTEX_M33", hardware=("f32",),
    ),
    Core(
        # the emulator's own Cortex-M7 has no doubles; its largest Arm core runs the same Thumb code
        name="cortex-m7", title="Cortex-M7", family="arm", triple=THUMB_HARD,
        cpu="cortex_m7+fp_armv8d16", model="UC_CPU_ARM_MAX", hardware=("f32", "f64"),
    ),
    Core(
        name="rv32imac", title="RV32IMAC", family="riscv", triple=RISCV,
        cpu="generic_rv32+m+a+c", flags=("-mabi=ilp32",),
    ),
    Core(
        name="rv32imafc", title="RV32IMAFC", family="riscv", triple=RISCV,
        cpu="generic_rv32+m+a+f+c", flags=("-mabi=ilp32f",), hardware=("f32",),
    ),
)  # fmt: skip
NAMES = tuple(core.name for core in CORES)


def named(targets: object) -> tuple[Core, ...]:
    """Return the cores of these names, in the table's order; raise SpecError for another name.

    >>> [core.title for core in named(["cortex-m7", "cortex-m3"])]
    ['Cortex-M3', 'Cortex-M7']
    """
    if isinstance(targets, str) or not isinstance(targets, (list, tuple)):
        raise SpecError("targets", "must be a list of cores", targets, f'such as ["{NAMES[2]}"]')
    if not targets:
        raise SpecError("targets", "must have a core", targets, "leave it out for all of them")
    for target in targets:
        if target not in NAMES:
            raise SpecError("targets", f"must be of {', '.join(NAMES)}", target, "choose of these")
    return tuple(core for core in CORES if core.name in targets)
