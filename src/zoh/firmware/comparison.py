"""One controller in many places: model, this machine and emulated cores, bit against bit."""

import ctypes
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from zoh.firmware import elf, harness, toolchain
from zoh.firmware.closed_loop import Loop
from zoh.firmware.cores import CORES, Core
from zoh.firmware.emulated import Counts, Emulated
from zoh.firmware.equality import Build, Equality
from zoh.firmware.harness import INIT, STEP
from zoh.firmware.host import Host
from zoh.firmware.lines import Number
from zoh.firmware.trials import Controller, Outcome, Trial, differences, run

THIS_MACHINE = "this machine"
Progress = Callable[[int, int, str], None]  # builds done, builds in all, the one just done


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """A controller under proof: its C, and what makes its model, set up as init does.

    sha256  of the plan; empty where there is none
    """

    name: str
    number: Number
    sources: Mapping[str, str]
    begin: Callable[[], Controller]
    sha256: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Expected:
    """What the model answers to each trial, and in the loop."""

    trials: tuple[Trial, ...]
    outcomes: tuple[Outcome, ...]
    loop: Loop | None
    in_loop: Outcome

    @property
    def state_bytes(self) -> int:
        """Return the bytes of a state."""
        return len(self.in_loop.state)


class Machine(Protocol):
    """A controller's C, built and loaded."""

    @property
    def state(self) -> bytes:
        """The bytes of its state."""

    def run(self, trial: Trial) -> Outcome:
        """Return what comes out of a trial."""

    def call(self, routine: str) -> int:
        """Return what a routine without arguments returns."""


def compared(
    subject: Subject, trials: tuple[Trial, ...], *, cores: Sequence[Core] = CORES,
    levels: Sequence[str] = toolchain.LEVELS, loop: Loop | None = None,
    progress: Progress | None = None,
) -> Equality:  # fmt: skip
    """Return how a subject's C compares with its model, on this machine and on each core."""
    toolchain.zig()  # an absent compiler is named before the work
    order: list[tuple[Core | None, str]] = [(c, v) for v in levels for c in (None, *cores)]
    with (
        TemporaryDirectory(ignore_cleanup_errors=True) as folder,
        ThreadPoolExecutor(max_workers=os.cpu_count()) as pool,
    ):
        counter = _counter(Path(folder) / "counter")
        expected = _expected(subject, trials, loop)
        running = [
            pool.submit(_built, subject, expected, core, level, Path(folder) / str(i), counter)
            for i, (core, level) in enumerate(order)
        ]
        _watched(running, progress)
        builds = tuple(future.result() for future in running)
    return Equality(
        name=subject.name, number=subject.number, sha256=subject.sha256,
        state_bytes=expected.state_bytes,
        samples=sum(t.samples for t in trials), loop_samples=loop.samples if loop else 0,
        builds=builds,
    )  # fmt: skip


def _watched(running: Sequence[Future[Build]], progress: Progress | None) -> None:
    """Report each build when it is done; one that raised ends it all."""
    try:
        for count, future in enumerate(as_completed(running), 1):
            build = future.result()
            if progress is not None:
                progress(count, len(running), f"{build.target} -{build.level}")
    except BaseException:
        for future in running:
            future.cancel()
        raise


def _expected(subject: Subject, trials: tuple[Trial, ...], loop: Loop | None) -> Expected:
    outcomes = tuple(run(trial, subject.begin) for trial in trials)
    model, trajectory = subject.begin(), np.zeros(0)
    if loop is not None:
        trajectory = loop.trajectory(lambda given: model.step(*given))
    return Expected(
        trials=trials, outcomes=outcomes, loop=loop,
        in_loop=Outcome(outputs=trajectory, state=model.state_bytes()),
    )  # fmt: skip


def _built(
    subject: Subject, expected: Expected, core: Core | None, level: str, folder: Path,
    counter: ctypes.CDLL,
) -> Build:  # fmt: skip
    """Return one build, compared."""
    name, size = subject.name, expected.state_bytes
    sources = {**subject.sources, "driver.c": harness.driver(name, subject.number)}
    if core is None:
        library = toolchain.for_host(level, sources, folder)
        host = Host(library, size)
        lost = tuple(f"{routine} is not in the library" for routine in host.absent(name))
        found = lost or tuple(_differences(subject, expected, host, host))
        return Build(target=THIS_MACHINE, level=level, differences=(*_fused(library), *found))
    image = elf.read(toolchain.for_core(core, level, name, sources, folder))
    faults = image.faults(name, subject.number, core)
    if image.absent(name):
        return Build(target=core.title, level=level, differences=faults)
    counting = Emulated(core, image, name, size)
    counts = counting.counted(counter)
    machine = Emulated(core, image, name, size)
    try:
        found = tuple(_differences(subject, expected, machine, counting))
    except toolchain.package("unicorn").UcError as stopped:
        found = (f"the core stops: {stopped}",)
    return Build(
        target=core.title, level=level, instructions=_instructions(counts),
        code_bytes=image.code_bytes(name), step_bytes=image.step_bytes(name),
        stack_bytes=counts.deepest, differences=(*faults, *found),
    )  # fmt: skip


def _differences(
    subject: Subject, expected: Expected, machine: Machine, counting: Machine
) -> Iterator[str]:
    """Yield what differs from the model, one sentence each; ``counting`` runs what is counted."""
    if (size := machine.call(harness.SIZE)) != expected.state_bytes:
        yield f"the state has {size} bytes, the model's {expected.state_bytes}"
        return
    for trial, outcome in zip(expected.trials, expected.outcomes, strict=True):
        found = (counting if trial.counted else machine).run(trial)
        yield from differences(trial.title, outcome, found, trial.given)
    if expected.loop is not None:
        found = _in_the_loop(expected.loop, machine, expected.in_loop.outputs.dtype)
        yield from differences("in the loop", expected.in_loop, found)
    if failed := machine.call(f"{subject.name}_selftest"):
        yield f"the self-test fails at sample {failed}"


def _in_the_loop(loop: Loop, machine: Machine, kind: "np.dtype[Any]") -> Outcome:
    """Return the trajectory that the plant in Python and a machine's controller make together."""
    one = Trial(title="one", what=np.array([INIT], np.uint8), given=np.zeros((1, 4), kind))
    machine.run(one)
    one.what[0] = STEP

    def answer(given: NDArray[Any]) -> Any:
        one.given[0, :3] = given
        return machine.run(one).outputs[0]

    return Outcome(outputs=loop.trajectory(answer), state=machine.state)


def _instructions(counts: Counts) -> tuple[int, float, int] | None:
    if not counts.samples:
        return None
    return counts.least, counts.total / counts.samples, counts.most


def _fused(library: Path) -> tuple[str, ...]:
    """Return the fused operations of a library of this machine, where it is one that is read."""
    data = library.read_bytes()
    return elf.read(data).fused() if data.startswith(b"\x7fELF") else ()


def _counter(folder: Path) -> ctypes.CDLL:
    return ctypes.CDLL(str(toolchain.for_host("O2", {"counter.c": harness.COUNTER}, folder)))
