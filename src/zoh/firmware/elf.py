"""What is in a linked image: its routines, their sizes, and what must not be there."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO

from zoh.firmware.cores import Core
from zoh.firmware.harness import ROUTINES, RUN, SIZE
from zoh.firmware.toolchain import package

# The names under which compiler-rt and libgcc know their arithmetic of floats in software
_SOFT_FLOAT = re.compile(
    r"(?:^|\.)__(?:aeabi_(?:[fd]\w+|[iul]+2[fd]|c[fd]\w+)"
    r"|(?:add|sub|mul|div|neg|cmp|unord|eq|ne|lt|le|gt|ge)[sd]f[23]"
    r"|(?:fix|fixuns)[sd]f[sd]i|(?:float|floatun)[sd]i[sd]f|extendsfdf2|truncdfsf2)$"
)
# vfma, vfmaeq (Arm), fmadd.s (RISC-V), vfmadd213ss (x86), fmadd and fmla (AArch64); vmla.f32
# rounds twice
_FUSED = re.compile(
    r"^(?:vfn?m[as](?:[a-z]{2})?\.f\d+|v?fn?m(?:add|sub)(?:\d+\w+)?(?:\.[sd])?|fml[as])$"
)
_MODES = {  # as capstone calls them
    "EM_ARM": ("CS_ARCH_ARM", "CS_MODE_THUMB", "CS_MODE_MCLASS"),
    "EM_RISCV": ("CS_ARCH_RISCV", "CS_MODE_RISCV32", "CS_MODE_RISCVC"),
    "EM_X86_64": ("CS_ARCH_X86", "CS_MODE_64"),
    "EM_AARCH64": ("CS_ARCH_ARM64",),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Symbol:
    """A routine or a table of an image: where it is, and how many bytes it takes."""

    address: int
    size: int
    routine: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Image:
    """A linked image: what is loaded where, and what it is called.

    machine    as ELF names it
    segments   (address, bytes) of what is loaded; code the same of its sections of code
    constants, variables   bytes of tables that do not change, and of ones that do
    """

    machine: str
    segments: tuple[tuple[int, bytes], ...]
    symbols: Mapping[str, Symbol]
    code: tuple[tuple[int, bytes], ...]
    constants: int
    variables: int

    def faults(self, name: str, number: str, core: Core) -> tuple[str, ...]:
        """Return what must not be in the image of a controller, or is not, one sentence each."""
        said = [f"{routine} is not in the image" for routine in self.absent(name)]
        if self.variables:
            said.append(f"{self.variables} bytes of variables outside of the state")
        if number not in ("f32", "f64") or number in core.hardware:
            helpers = sorted(s for s in self.symbols if _SOFT_FLOAT.search(s))
            said += [f"{h} computes floats in software" for h in helpers]
        return (*said, *self.fused())

    def absent(self, name: str) -> tuple[str, ...]:
        """Return the routines that a linker has lost."""
        wanted = (RUN, SIZE, *(f"{name}_{routine}" for routine in ROUTINES))
        return tuple(w for w in wanted if w not in self.symbols)

    def fused(self) -> tuple[str, ...]:
        """Return a sentence for each instruction that multiplies and adds with one rounding."""
        return tuple(
            f"{mnemonic} {operands} at {at:#x} rounds once where the model rounds twice"
            for address, data in self.code
            for at, mnemonic, operands in self._disassembled(address, data)
            if _FUSED.match(mnemonic)
        )

    def code_bytes(self, name: str) -> int:
        """Return the bytes of code and constants, without the driver and the self-test."""
        ours = (RUN, SIZE, f"{name}_selftest")
        beside = sum(s.size for n, s in self.symbols.items() if n.split(".")[0] in ours)
        return sum(len(data) for _, data in self.code) + self.constants - beside

    def step_bytes(self, name: str) -> int:
        """Return the bytes of the step alone."""
        return self.symbols[f"{name}_step"].size

    def _disassembled(self, address: int, data: bytes) -> Iterator[tuple[int, str, str]]:
        """Yield every routine's instructions; what stands between routines is no code."""
        capstone = package("capstone")
        family, *modes = (getattr(capstone, name) for name in _MODES[self.machine])
        decode = capstone.Cs(family, sum(modes))  # modes are bits
        decode.skipdata = True
        for symbol in self.symbols.values():
            start = (symbol.address & ~1 if self.machine == "EM_ARM" else symbol.address) - address
            if symbol.routine and 0 <= start < len(data):
                part = data[start : start + symbol.size]
                for at, _, mnemonic, operands in decode.disasm_lite(part, address + start):
                    yield at, mnemonic, operands


def read(data: bytes) -> Image:
    """Return what is in an ELF image."""
    file = package("elftools.elf.elffile").ELFFile(BytesIO(data))
    sections = {s.name: s for s in file.iter_sections()}
    table = sections.get(".symtab")
    found = () if table is None else [s for s in table.iter_symbols() if s.name]

    def size(*names: str) -> int:
        return sum(s["sh_size"] for name, s in sections.items() if name.startswith(names))

    return Image(
        machine=file["e_machine"],
        segments=tuple(
            (s["p_vaddr"], s.data())
            for s in file.iter_segments()
            if s["p_type"] == "PT_LOAD" and s["p_filesz"]
        ),
        symbols={
            s.name: Symbol(
                address=s["st_value"], size=s["st_size"], routine=s["st_info"]["type"] == "STT_FUNC"
            )
            for s in found
        },
        code=tuple((s["sh_addr"], s.data()) for n, s in sections.items() if n.startswith(".text")),
        constants=size(".rodata"),
        variables=size(".data", ".bss"),
    )
