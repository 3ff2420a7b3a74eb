"""What a controller is put through: samples with what is asked of it in each.

Every trial starts with init, so that two copies that have drifted apart are seen to have at its
end, where the bytes of their states are compared.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from zoh.firmware.book import IO_BITS
from zoh.firmware.harness import INIT, RESET, STEP, TRACK
from zoh.firmware.lines import Number

TYPES = {"f32": "<f4", "f64": "<f8", "q31": "<i4", "q15": "<i2"}  # of r, y, ff and u
Sample = tuple[float, float, float]
_LENGTH = 2000  # samples of a trial at most


class Controller(Protocol):
    """The routines of a controller, wherever it runs."""

    def reset(self, u0: float) -> None:
        """Rest at u0."""

    def step(self, r: float, y: float, ff: float = 0) -> Any:
        """Return u."""

    def track(self, r: float, y: float, ff: float, u_manual: float) -> None:
        """Follow u_manual: the same r, y and ff give it next."""

    def state_bytes(self) -> bytes:
        """Return the state as the C has it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """Samples: ``what`` is asked (a code of the harness) with ``given`` = (r, y, ff, u).

    counted  whether the instructions of this trial are counted, which makes it slower
    """

    title: str
    counted: bool = False
    what: NDArray[np.uint8]
    given: NDArray[Any]

    @property
    def samples(self) -> int:
        """Return how many there are."""
        return len(self.what)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What came out of a trial: the bytes of every output, and of the state at the end."""

    outputs: NDArray[Any]
    state: bytes


def trials(number: Number, hostile: Sequence[Sample]) -> tuple[Trial, ...]:
    """Return the trials of a number format: hostile samples, edges, chance, hand-overs.

    The first of each kind is counted.

    >>> [trial.title for trial in trials("q15", [(1, 2, 3)] * 5)]
    ['hostile', 'edges', 'any bits', 'handed over']
    """
    parts = [hostile[start : start + _LENGTH] for start in range(0, len(hostile), _LENGTH)]
    made = [_steps("hostile", number, part, counted=i == 0) for i, part in enumerate(parts)]
    edges = list(product(_edges(number), repeat=3))
    chance = np.random.PCG64(6)  # its raw numbers are the same in every version of NumPy
    bits = chance.random_raw(4 * _LENGTH).astype(np.uint64).reshape(-1, 4)
    size = np.dtype(TYPES[number]).itemsize
    any_bits = bits.astype(f"<u{size}").view(TYPES[number])
    between = [edge for pair in zip(edges, hostile, strict=False) for edge in pair]
    return (
        *made,
        _steps("edges", number, between),
        _steps("any bits", number, any_bits[:, :3]),
        _handed_over(number, any_bits, hostile),
    )


def run(trial: Trial, begin: Callable[[], Controller]) -> Outcome:
    """Return what a controller in Python answers; ``begin`` makes one that has just been set up."""
    model = begin()
    outputs = np.zeros(trial.samples, trial.given.dtype)
    for k, (what, (r, y, ff, u)) in enumerate(zip(trial.what.tolist(), trial.given, strict=True)):
        if what == STEP:
            outputs[k] = model.step(r, y, ff)
        elif what == TRACK:
            model.track(r, y, ff, u)
        elif what == RESET:
            model.reset(u)
        else:
            model = begin()
    return Outcome(outputs=outputs, state=model.state_bytes())


def differences(
    title: str, expected: Outcome, found: Outcome, given: NDArray[Any] | None = None
) -> Iterator[str]:
    """Yield what differs, bit by bit: the first output, and the first byte of the state."""
    raw = f"<u{expected.outputs.dtype.itemsize}"
    wrong = np.nonzero(expected.outputs.view(raw) != found.outputs.view(raw))[0]
    if len(wrong):
        k = int(wrong[0])
        at = "" if given is None else f" ({', '.join(str(x) for x in given[k])})"
        yield (
            f"{title}: {len(wrong)} of {len(expected.outputs)} outputs, the first at sample {k}"
            f"{at}: {found.outputs[k]!s} for {expected.outputs[k]!s}"
        )
    if expected.state != found.state:
        pairs = enumerate(zip(expected.state, found.state, strict=True))
        where = next(i for i, (a, b) in pairs if a != b)
        yield f"{title}: the state at the end, from byte {where} on"


def _steps(title: str, number: Number, samples: Any, *, counted: bool = True) -> Trial:
    given = np.zeros((len(samples) + 1, 4), TYPES[number])
    given[1:, :3] = samples
    what = np.full(len(given), STEP, np.uint8)
    what[0] = INIT
    return Trial(title=title, counted=counted, what=what, given=given)


def _handed_over(number: Number, any_bits: NDArray[Any], hostile: Sequence[Sample]) -> Trial:
    """Return steps between which a hand takes over, lets go, or sets the controller to rest."""
    trial = _steps("handed over", number, hostile[:_LENGTH])
    trial.given[:, 3] = np.roll(trial.given[:, 0], 1)  # a hand that was where the reference is
    k = np.arange(trial.samples)
    trial.what[(k % 97 > 80) & (k % 7 < 5)] = TRACK
    trial.what[k % 211 == 210] = RESET
    trial.what[k % 1009 == 1008] = INIT
    wild = k % 5 == 4
    trial.given[wild] = any_bits[k[wild] % len(any_bits)]
    trial.what[0] = INIT
    return trial


def _edges(number: Number) -> tuple[float, ...]:
    if number in IO_BITS:
        half = 1 << IO_BITS[number] - 1
        return (0, 1, -1, half - 1, -half, half // 2)
    info = np.finfo(TYPES[number])
    least, largest = float(info.smallest_subnormal), float(info.max)
    return (0.0, -0.0, 1.0, np.nan, np.inf, -np.inf, least, -float(info.tiny), largest, -largest)
