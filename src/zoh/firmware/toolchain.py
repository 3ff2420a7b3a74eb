"""The compiler of the proof: clang with its own C runtime for every target, from one package.

``zig cc`` of the pip package ziglang cross-compiles without anything else installed. It builds its
soft-float routines at the first use of a target and level, which takes some ten seconds, and keeps
them in its cache: ~/.cache/zig, or where ZIG_GLOBAL_CACHE_DIR says.
"""

import subprocess
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from zoh.errors import SpecError
from zoh.firmware import harness
from zoh.firmware.cores import Core

LEVELS = ("O2", "Os")
_DISTRIBUTIONS = {"elftools": "pyelftools"}
# No -ffp-contract=off: that nothing is fused is the source's own promise, and is proved of it.
_COMMON = ("-std=c99", "-g", "-fno-sanitize=all")
_BARE = (  # a frame pointer, which zig keeps and other compilers do not, is two instructions more
    "-ffreestanding", "-ffunction-sections", "-fdata-sections", "-fomit-frame-pointer",
    "-fno-unwind-tables", "-fno-asynchronous-unwind-tables",
)  # fmt: skip


def zig() -> str:
    """Return the path of the compiler; raise SpecError where it is not installed."""
    return str(Path(package("ziglang").__file__).parent / "zig")


def package(name: str) -> Any:
    """Return a module of a package that only a proof needs; raise SpecError where it is absent."""
    try:
        return import_module(name)
    except ModuleNotFoundError as absent:
        top = name.split(".")[0]
        if (absent.name or "").split(".")[0] != top:
            raise
        way_out = "pip install 'zoh[firmware]' brings it"
        bound = f"must have {_DISTRIBUTIONS.get(top, top)}"
        raise SpecError("prove", bound, "none", way_out) from None


def for_core(core: Core, level: str, name: str, sources: Mapping[str, str], folder: Path) -> bytes:
    """Return the ELF image of a controller called ``name`` and its driver, for a core."""
    written(folder, {**sources, "link.ld": harness.LINK % {"name": name}})
    target = ("-target", core.triple, f"-mcpu={core.cpu}", *core.flags)
    linked = ("-Wl,-T,link.ld", f"-Wl,--entry={harness.RUN}")
    run_zig((*target, *_COMMON, *_BARE, f"-{level}", *_c(sources), *linked, "-o", "image"), folder)
    return (folder / "image").read_bytes()


def for_host(level: str, sources: Mapping[str, str], folder: Path) -> Path:
    """Return the path of a shared library for this machine, every unit of its processor used."""
    written(folder, sources)
    run_zig((*_COMMON, f"-{level}", "-shared", "-fPIC", *_c(sources), "-o", "library"), folder)
    return folder / "library"


def run_zig(arguments: Sequence[str], folder: Path) -> None:
    """Run ``zig cc`` in a folder; raise SpecError with its first error where it fails."""
    command = [zig(), "cc", *arguments]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, errors="replace", check=False
    )
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if "error" in line] or ["no reason said"]
        way_out = "if it is about its cache, ZIG_GLOBAL_CACHE_DIR names a folder it may write to"
        raise SpecError("prove", f"must build it: {lines[0]}", "no image", way_out)


def written(folder: Path, texts: Mapping[str, str]) -> None:
    """Write texts into a folder of their own."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (folder / name).write_text(text)


def _c(sources: Mapping[str, str]) -> tuple[str, ...]:
    return tuple(sorted(name for name in sources if name.endswith(".c")))
