"""What a proof of equality found: which builds of a controller are the model, at what cost."""

from dataclasses import dataclass
from typing import Any

from zoh.firmware.head import Cost


@dataclass(frozen=True, slots=True, kw_only=True)
class Build:
    """One build of the firmware, for one processor at one level of optimisation.

    target, level  such as "Cortex-M4F", "O2"
    instructions   least, mean and most executed in a step; None where it was not counted
    code_bytes     code and constants, software arithmetic included, without the self-test
    step_bytes     the step alone; stack_bytes what it takes of the stack
    differences    one sentence each; empty where the build is the model
    """

    target: str
    level: str
    instructions: tuple[int, float, int] | None = None
    code_bytes: int | None = None
    step_bytes: int | None = None
    stack_bytes: int | None = None
    differences: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        low, mean, high = self.instructions or (None, None, None)
        return {
            "target": self.target,
            "level": self.level,
            "equal": not self.differences,
            "differences": list(self.differences),
            "instructions": {"min": low, "mean": mean, "max": high},
            "code_bytes": self.code_bytes,
            "step_bytes": self.step_bytes,
            "stack_bytes": self.stack_bytes,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Equality:
    """Python model, C on this machine and C on emulated cores, compared bit by bit.

    sha256        of the plan that was proved
    samples       of the trials, outputs and states; loop_samples of the loop with the plant
    state_bytes   of the controller's state, in every build
    """

    name: str
    number: str
    sha256: str
    samples: int
    loop_samples: int
    state_bytes: int
    builds: tuple[Build, ...]

    @property
    def holds(self) -> bool:
        """Return whether there are builds, and no bit differs in any."""
        return bool(self.builds) and not self.differences

    @property
    def differences(self) -> tuple[str, ...]:
        """Return one sentence for each difference, the build named."""
        return tuple(f"{b.target} -{b.level}: {d}" for b in self.builds for d in b.differences)

    @property
    def costs(self) -> tuple[Cost, ...]:
        """Return what was measured, as the header of the firmware says it."""
        return tuple(
            Cost(
                target=f"{b.target} -{b.level}",
                instructions=b.instructions,
                code_bytes=b.code_bytes,
                stack_bytes=b.stack_bytes,
            )
            for b in self.builds
            if b.instructions is not None and b.code_bytes is not None
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        return {
            "name": self.name,
            "number": self.number,
            "sha256": self.sha256,
            "equal": self.holds,
            "samples": self.samples,
            "loop_samples": self.loop_samples,
            "state_bytes": self.state_bytes,
            "builds": [b.to_dict() for b in self.builds],
        }

    def report(self) -> str:
        """Return the result as a table of lines."""
        verdict = "0 bits differ" if self.holds else f"{len(self.differences)} DIFFERENCES"
        looped = f" and {self.loop_samples} in the loop" if self.loop_samples else ""
        head = (
            f"{self.name} ({self.number}): {verdict}; {self.samples} samples{looped} on each "
            f"build; {self.state_bytes} bytes of state"
        )
        columns = f"{'build':<16}{'instructions a sample':>24}{'code':>8}{'step':>7}{'stack':>7}"
        return "\n".join([head, columns, *map(_row, self.builds), *self.differences])


def _row(build: Build) -> str:
    counted = build.instructions
    text = "" if counted is None else f"{counted[0]} ... {counted[1]:.1f} ... {counted[2]}"
    sizes = (build.code_bytes, build.step_bytes, build.stack_bytes)
    code, step, stack = ("" if size is None else str(size) for size in sizes)
    end = "" if not build.differences else "  DIFFERS"
    return f"{f'{build.target} -{build.level}':<16}{text:>24}{code:>8}{step:>7}{stack:>7}{end}"
