"""Fully verified designs, each beside python-control measuring the same loop in the same run.

zoh: sample, solve, every margin, Ms, Mt, disk margin, step metrics at and between the samples,
peak effort. python-control: c2d, stability_margins, step_info and the effort's response; it
solves nothing, knows no sample of a fraction (it is given ours), and looks at no time between.
The two take turns in one process, alike long: python-control with one loop, zoh with as many
designs as fit into the time that took. No two designs have the same plant, so that nothing kept
from one can help the next. Printed, in ms: the median and the least of one design; the median of
the first of a turn, which finds nothing of its own in the processor's caches; python-control's
median and least; and the ratio of the medians.

    python -m benchmarks.design_speed --repeats 30 --limit-ratio 20 --limit-ms 1.0

exits 1 where a ratio is below the one limit or the median of the arm's PID above the other; the
ratio holds on any machine, the time on the one that it was chosen for.
"""

import argparse
import statistics
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain, count

import control
import numpy as np

import zoh


@dataclass(frozen=True)
class Case:
    """A design whose plant moves a little each time: x in [0.9, 1.1] is its first pole."""

    name: str
    den: Callable[[float], list[float]]
    law: Callable[..., zoh.Verified]
    asked: dict[str, float]
    compute_delay: float = 0.0

    def plant(self, x: float) -> zoh.Plant:
        return zoh.Plant(num=[2.3], den=self.den(x), sensor=12 / 180)

    def designed(self, plant: zoh.Plant) -> zoh.Verified:
        return self.law(plant, dt=0.1, compute_delay=self.compute_delay, **self.asked)


def arm(x: float) -> list[float]:
    return [1, 0.7809 * x, 0]


def slow_motor_and_filter(x: float) -> list[float]:
    return np.poly([0, -0.7809 * x, -20, -30]).tolist()


CASES = [
    Case("PID, arm", arm, zoh.pid, {"wc": 1.95, "pm_deg": 40, "ki": 0.85}),
    Case("lag, arm", arm, zoh.lag, {"wc": 0.6, "pm_deg": 40, "dc_gain": 10}),
    Case("PI, arm, compute delay 0.3 dt", arm, zoh.pi, {"wc": 0.6, "pm_deg": 40}, 0.03),
    Case("PD, order 4", slow_motor_and_filter, zoh.pd, {"wc": 1.2, "pm_deg": 60}),
]


def measured(case: Case, plant: zoh.Plant, design: zoh.Verified) -> object:
    """Return what python-control says about the loop of this design."""
    if case.compute_delay:
        held = zoh.sample(plant, 0.1, case.compute_delay)
        sampled = control.tf(held.num, held.den, 0.1)
    else:
        continuous = control.tf(np.multiply(plant.num, plant.sensor), plant.den)
        sampled = control.c2d(continuous, 0.1, "zoh")
    law = control.tf(design.controller.num, design.controller.den, 0.1)
    margins = control.stability_margins(law * sampled)
    info = control.step_info(control.feedback(law * sampled, 1))
    effort = control.step_response(control.feedback(law, sampled), T=np.arange(0, 30, 0.1))
    return margins, info, effort


def timed(work: Callable[[], object]) -> tuple[float, object]:
    start = time.perf_counter()
    result = work()
    return (time.perf_counter() - start) * 1e3, result


def spread() -> Iterator[float]:
    """Yield numbers in [0.9, 1.1] without end, no two alike, spread evenly however many."""
    golden = (5**0.5 - 1) / 2
    for i in count():
        yield 0.9 + 0.2 * (i * golden % 1)


def compared(case: Case, repeats: int) -> tuple[list[list[float]], list[float]]:
    """Return the times in ms of zoh, turn by turn, and of python-control."""
    plants = map(case.plant, spread())
    ours, theirs, plant = [], [], next(plants)
    design = case.designed(plant)
    for _ in range(repeats + 1):
        other, _ = timed(lambda p=plant, d=design: measured(case, p, d))
        turn: list[float] = []
        while sum(turn) < other:
            plant = next(plants)
            mine, design = timed(lambda p=plant: case.designed(p))
            turn.append(mine)
        ours.append(turn)
        theirs.append(other)
    return ours[1:], theirs[1:]  # the first pays for imports and tables


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=30)
    parser.add_argument("--limit-ratio", type=float, default=0.0, help="least ratio of medians")
    parser.add_argument("--limit-ms", type=float, default=float("inf"), help="of the arm's PID")
    limits = parser.parse_args()
    warnings.simplefilter("ignore")
    print(f"ms: zoh {zoh.__version__} designs and verifies; python-control "
          f"{control.__version__} measures")  # fmt: skip
    print(f"{'':32}{'zoh':>8}{'least':>8}{'first':>8}{'control':>10}{'least':>8}{'ratio':>8}")
    within = True
    for case in CASES:
        turns, theirs = compared(case, limits.repeats)
        ours, first = list(chain(*turns)), statistics.median(turn[0] for turn in turns)
        one, other = statistics.median(ours), statistics.median(theirs)
        print(f"{case.name:32}{one:8.2f}{min(ours):8.2f}{first:8.2f}{other:10.2f}"
              f"{min(theirs):8.2f}{other / one:8.1f}")  # fmt: skip
        within &= other / one >= limits.limit_ratio
        within &= case is not CASES[0] or one <= limits.limit_ms
    return 0 if within else 1


if __name__ == "__main__":
    sys.exit(main())
