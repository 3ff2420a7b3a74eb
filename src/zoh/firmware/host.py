"""A controller on the machine at hand: its C compiled into a shared library and called."""

import ctypes
from pathlib import Path

import numpy as np

from zoh.firmware.harness import END, ROUTINES, RUN
from zoh.firmware.trials import Outcome, Trial


class Host:
    """The library of a controller with its state."""

    def __init__(self, library: Path, state_bytes: int) -> None:
        self._library = ctypes.CDLL(str(library))
        # aligned as malloc aligns, and longer than the state, lest a wrong size does harm
        self._state = ctypes.create_string_buffer(state_bytes + 256)
        self._size = state_bytes

    @property
    def state(self) -> bytes:
        """The bytes of the controller's state."""
        return self._state.raw[: self._size]

    def absent(self, name: str) -> tuple[str, ...]:
        """Return the routines of a controller that the library does not have."""
        wanted = (f"{name}_{routine}" for routine in ROUTINES)
        return tuple(w for w in wanted if not hasattr(self._library, w))

    def run(self, trial: Trial) -> Outcome:
        """Return what comes out of a trial."""
        outputs = np.zeros(trial.samples, trial.given.dtype)
        given = np.ascontiguousarray(trial.given)
        self._library[RUN](
            self._state, trial.what.tobytes() + bytes([END]),
            ctypes.c_void_p(given.ctypes.data), ctypes.c_void_p(outputs.ctypes.data),
        )  # fmt: skip
        return Outcome(outputs=outputs, state=self.state)

    def call(self, routine: str) -> int:
        """Return the word that a routine without arguments returns."""
        return int(self._library[routine]())
