"""The zero-order hold: the worst relative error of any z-coefficient, tool by tool."""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from benchmarks.torture import held
from benchmarks.torture.named import ARM
from mpmath import mp, mpf

import zoh

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import control
    from scipy import signal

CLOCKS = tuple(10.0**k for k in range(3, -8, -1))
DELAYS = (0.0, 0.3, 1.0, 2.7)
PLANTS: dict[str, tuple[list[float], list[float], tuple[float, ...]]] = {
    "arm": (ARM["num"], ARM["den"], CLOCKS),
    "1/s^2": ([1.0], [1.0, 0.0, 0.0], CLOCKS),
    "order 10, poles -1 ... -10": ([3628800.0], [float(c) for c in np.poly(-np.arange(1.0, 11))],
                                   CLOCKS[3:]),
    "order 10, (s + 1)^10": ([1.0], [float(c) for c in np.poly(-np.ones(10))], CLOCKS[3:]),
}  # fmt: skip
Pair = tuple[list[float], list[float]]
Exact = tuple[list[mpf], list[mpf]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One plant, sample time and dead time (in samples), and each tool's worst relative error."""

    plant: str
    dt: float
    delay: float
    errors: dict[str, float | None]


def rows() -> Iterator[Row]:
    """Yield the table; a tool without dead time is asked only where there is none."""
    for name, (num, den, clocks) in PLANTS.items():
        for dt in clocks:
            for delay in DELAYS:
                dead_time = delay * dt
                truth = _truth(num, den, dt, dead_time)
                peers = PEERS if delay == 0 else {}
                errors = {"zoh": _worst(_by_zoh(num, den, dt, dead_time), truth)}
                errors |= {tool: _worst(f(num, den, dt), truth) for tool, f in peers.items()}
                yield Row(plant=name, dt=dt, delay=delay, errors=errors)


def _truth(num: list[float], den: list[float], dt: float, dead_time: float) -> Exact:
    with mp.workdps(held.digits_for(num, den, dt)):
        top, bottom, m = held.held(num, den, dt, dead_time)
        return top[::-1], bottom[::-1] + [mpf(0)] * m


def _worst(said: Pair | None, truth: Exact) -> float | None:
    """Return the largest |coefficient/true - 1| of those that a float can hold."""
    if said is None:
        return None
    worst = 0.0
    for given, true in zip(said, truth, strict=True):
        top = _trimmed(true)
        got = [0.0] * (len(top) - len(given)) + list(np.trim_zeros(given, "f"))
        got = [0.0] * (len(top) - len(got)) + got
        for x, t in zip(got[-len(top) :], top, strict=True):
            if abs(t) > 1e-307:
                worst = max(worst, float(abs(mpf(x) / t - 1)))
    return worst


def _trimmed(a: list[mpf]) -> list[mpf]:
    start = next(i for i, c in enumerate(a) if abs(c) > mpf(10) ** -1000)
    return a[start:]


def _by_zoh(num: list[float], den: list[float], dt: float, dead_time: float) -> Pair:
    made = zoh.sample(zoh.Plant(num=num, den=den, dead_time=dead_time), dt)
    return list(made.num), list(made.den)


def _by_control(num: list[float], den: list[float], dt: float) -> Pair:
    made = control.c2d(control.tf(num, den), dt, "zoh")
    return list(made.num[0][0]), list(made.den[0][0])


def _by_scipy(num: list[float], den: list[float], dt: float) -> Pair:
    top, bottom, _ = signal.cont2discrete((num, den), dt, method="zoh")
    return list(top[0]), list(bottom)


def _quietly(f: Callable[[list[float], list[float], float], Pair]) -> Callable[..., Pair | None]:
    def tried(num: list[float], den: list[float], dt: float) -> Pair | None:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            try:
                return f(num, den, dt)
            except Exception:  # whatever a tool raises is its answer
                return None

    return tried


PEERS = {"python-control": _quietly(_by_control), "SciPy": _quietly(_by_scipy)}
