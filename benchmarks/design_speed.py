"""One fully verified PID design of the robot arm, beside python-control measuring the same loop.

zoh: sample, solve, every margin, Ms, Mt, disk margin, step metrics at and between the samples,
peak effort. python-control: c2d, margins, step_info and the effort's response; it solves nothing.
The two take turns in one process; the figure is the ratio of the medians.
"""

import statistics
import time
import warnings

import control
import numpy as np

import zoh

ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
GAINS = [81.31498772131907, -139.1116197065679, 57.88163198524884]


def by_zoh() -> object:
    return zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ki=0.85)


def by_control() -> object:
    plant = control.c2d(control.tf([2.3 * 12 / 180], [1, 0.7809, 0]), 0.1, "zoh")
    law = control.tf(GAINS, [1, -1, 0], 0.1)
    margins = control.stability_margins(law * plant)
    info = control.step_info(control.feedback(law * plant, 1))
    effort = control.step_response(control.feedback(law, plant), T=np.arange(0, 30, 0.1))
    return margins, info, effort


def main() -> None:
    warnings.simplefilter("ignore")
    ours, theirs = [], []
    for _ in range(30):
        for work, times in ((by_zoh, ours), (by_control, theirs)):
            start = time.perf_counter()
            work()
            times.append(time.perf_counter() - start)
    one, other = statistics.median(ours), statistics.median(theirs)
    print(f"zoh {zoh.__version__}, design and verification   {one * 1e3:8.2f} ms")
    print(f"python-control {control.__version__}, the loop measured {other * 1e3:8.2f} ms")
    print(f"ratio {other / one:.1f}")


if __name__ == "__main__":
    main()
