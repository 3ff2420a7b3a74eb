"""Verified loops a second: the sweep's three arithmetics, others and a floor, in one run.

The job is the PID of K/(s (s + a)) behind its hold: law, stability, every margin, Ms, Mt, disk
margin, bandwidth, the step's metrics at and between the samples, effort. python-control is given
zoh's plant and controller and does what it can of that: margins, step_info, the effort's response.
SciPy and Octave are given the same and read margins off 2000 points and metrics off 500 samples, to
their spacing. The floor is ``floor.c``, one loop after the other in plain C for this machine: all
figures to the same digits, checked against zoh's here, but it is given what zoh finds out and
proves nothing, and is right of the nominal loops alone.
Nominal loops are an arm's, K, a, wc within 20 %; of the wide ones, with dt over four decades, half
cannot be designed, and the peers are given others. Everything takes turns, BLAS with one thread;
printed are least times of one loop in us, CPU time but where the clock is named, and the ratio to
python-control's.

    python -m benchmarks.sweep.speed --loops 65536 --limit-arrays 100 --limit-compiled 500

exits 1 where a ratio of nominal loops is below its limit.
"""

import argparse
import sys
import time
from collections.abc import Callable
from contextlib import suppress

import control
import numpy as np
from benchmarks.sweep.peers import Floor, by_control, by_scipy, octave_us

import zoh
from zoh.batch import single
from zoh.batch.arrays import run as arrays
from zoh.batch.job import Job

ARM = zoh.Plant(num=[1], den=[1, 1, 0])
ONE, TWO = "compiled, by the clock", "2 threads, by the clock"
TURNS = 5
PEERS = 8  # loops of python-control and of the single design in a turn


def nominal(rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
    return {
        "dt": rng.uniform(0.03, 0.15, n),
        "plant.num.0": 0.1533 * rng.uniform(0.8, 1.2, n),
        "plant.den.1": 0.7809 * rng.uniform(0.8, 1.2, n),
        "wc": 1.95 * rng.uniform(0.8, 1.2, n),
        "pm_deg": rng.uniform(35, 60, n),
        "ki": rng.uniform(0.3, 1.5, n),
    }


def wide(rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
    a, dt = 10 ** rng.uniform(-1.5, 1, n), 10 ** rng.uniform(-5, -0.3, n)
    gain = 10 ** rng.uniform(-1, 1, n)
    wc = np.minimum(10 ** rng.uniform(-1, 1, n) * a, 2.5 / dt)
    ki = 0.05 * wc / np.abs(gain / (1j * wc * (1j * wc + a))) * rng.uniform(0.1, 2, n)
    pm_deg = rng.uniform(20, 80, n)
    return {"dt": dt, "plant.num.0": gain, "plant.den.1": a, "wc": wc, "pm_deg": pm_deg, "ki": ki}


def solved(columns: dict[str, np.ndarray], count: int) -> list[zoh.Verified]:
    """Return the first designs of these loops: python-control is to measure what zoh does."""
    found: list[zoh.Verified] = []
    for at in (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)):
        plant = zoh.Plant(num=[at["plant.num.0"]], den=[1, at["plant.den.1"], 0])
        with suppress(zoh.NotMet):
            try:
                asked = {name: float(at[name]) for name in ("dt", "wc", "pm_deg", "ki")}
                found.append(zoh.pid(plant, **asked))
            except zoh.Infeasible:
                continue
        if len(found) == count:
            break
    return found


def least(work: Callable[[], object], clock: Callable[[], float]) -> float:
    begun = clock()
    work()
    return clock() - begun


def compared(columns: dict[str, np.ndarray], n: int, with_floor: bool) -> dict[str, float]:
    """Return the least us of one loop, by each arithmetic."""
    from zoh.batch.compiled import run as compiled

    job = Job(plant=ARM, law="pid", dt=0.1, varying=tuple(columns))
    few = {key: values[: n // 8] for key, values in columns.items()}
    designs = solved(columns, PEERS)
    one = {key: values[:PEERS] for key, values in columns.items()}
    ways: dict[str, tuple[Callable[[], object], int, Callable[[], float]]] = {
        "python-control": (
            lambda: [by_control(design) for design in designs], PEERS, time.process_time
        ),
        "SciPy": (lambda: [by_scipy(design) for design in designs], PEERS, time.process_time),
        "single": (lambda: single.run(job, one), PEERS, time.process_time),
        "arrays": (lambda: arrays.run(job, few), n // 8, time.process_time),
        "compiled": (lambda: compiled.run(job, columns, threads=1), n, time.process_time),
        ONE: (lambda: compiled.run(job, columns, threads=1), n, time.perf_counter),
        TWO: (lambda: compiled.run(job, columns, threads=2), n, time.perf_counter),
    }  # fmt: skip
    if with_floor:
        plain = Floor(columns)
        plain.run()
        plain.check(compiled.run(job, columns))
        ways["plain C, a floor"] = (plain.run, n, time.process_time)
    found = dict.fromkeys(ways, float("inf"))
    for turn in range(TURNS + 1):
        for name, (work, count, clock) in ways.items():
            taken = least(work, clock) / count * 1e6
            if turn:  # the first pays for imports and compilation
                found[name] = min(found[name], taken)
    by_octave = octave_us(designs)
    return found if by_octave is None else found | {"Octave": by_octave}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--loops", type=int, default=65536)
    parser.add_argument("--limit-arrays", type=float, default=0.0, help="least ratio, nominal")
    parser.add_argument("--limit-compiled", type=float, default=0.0, help="least ratio, nominal")
    asked = parser.parse_args()
    within = True
    for name, family in (("nominal", nominal), ("wide", wide)):
        columns = family(np.random.default_rng(1), asked.loops)
        found = compared(columns, asked.loops, family is nominal)
        base = found["python-control"]
        print(f"{name}: zoh {zoh.__version__}, python-control {control.__version__}")
        for way, us in found.items():
            print(f"  {way:24}{us:12.2f} us a loop{base / us:10.0f} times python-control's rate")
        if "Octave" not in found:
            print("  octave-cli is not installed, or did not run")
        print(f"  two threads do {found[ONE] / found[TWO]:.2f} times what one does")
        if family is nominal:
            over = found["compiled"] / found["plain C, a floor"]
            print(f"  compiled takes {over:.2f} times the floor")
            within &= base / found["arrays"] >= asked.limit_arrays
            within &= base / found["compiled"] >= asked.limit_compiled
    return 0 if within else 1


if __name__ == "__main__":
    sys.exit(main())
