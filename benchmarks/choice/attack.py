"""Random plants and requirements, and random controllers that are to beat a choice.

The attack knows nothing of margins, coordinates or grids: it draws the gains of the law around
those chosen, near and far, keeps what crosses over faster by more than 0.1 %, and asks
``zoh.measure`` about the rest.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import exp, log, pi
from random import Random

import numpy as np

import zoh
from zoh.spec import Requirements

FASTER = 1.001  # what is faster by less does not count
SLOWEST = 0.1  # of wc: the slowest zero that a choice may have, as docs/choice.md says


@dataclass(frozen=True)
class Task:
    """A plant, its clock, a law and what is asked."""

    plant: zoh.Plant
    dt: float
    law: str
    asked: Requirements


def drawn(random: Random) -> Task:
    """Return a task: lags, integrators, resonances, zeros on the right, dead times."""
    poles: list[complex] = [
        -exp(random.uniform(log(0.05), log(20))) for _ in range(random.randint(1, 3))
    ]
    if random.random() < 0.4:
        poles.append(0.0)
    if random.random() < 0.3:
        w, damping = exp(random.uniform(0, log(30))), random.uniform(0.05, 0.9)
        pole = complex(-damping * w, w * (1 - damping**2) ** 0.5)
        poles += [pole, pole.conjugate()]
    zeros = (
        [exp(random.uniform(log(1), log(30)))] if random.random() < 0.25 and len(poles) > 1 else []
    )
    zeros = [z if random.random() < 0.5 else -z for z in zeros]
    gain = exp(random.uniform(log(0.1), log(10)))
    if zeros and zeros[0] > 0:
        gain = -gain
    dead_time = random.choice([0.0, 0.0, exp(random.uniform(log(0.01), log(0.5)))])
    plant = zoh.Plant.zpk(zeros=zeros, poles=poles, gain=gain, dead_time=dead_time)
    dt = exp(random.uniform(log(0.005), log(0.3)))
    law = random.choice(["p", "pi", "pd", "lead", "lag", "pid"])
    asked = random.choice(
        [
            Requirements(),
            Requirements(ms=random.uniform(1.3, 2.0)),
            Requirements(pm_deg=random.uniform(30, 65), gain_margin_db=random.uniform(4, 12)),
            Requirements(ms=1.8, overshoot_pct=random.uniform(5, 30)),
            Requirements(pm_deg=45, ms=2.0, peak_effort=exp(random.uniform(log(0.5), log(50)))),
            Requirements(ms=1.7, delay_margin=exp(random.uniform(log(0.01), log(1.0)))),
        ]
    )
    return Task(plant=plant, dt=dt, law=law, asked=asked)


def rivals(
    task: Task, found: zoh.Verified, random: Random, tries: int
) -> Iterator[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Yield (num, den) in w of controllers of the law, their gains near the choice and far."""
    c, dt = found.controller, task.dt
    for i in range(tries):
        wide = 0.02 if i % 4 == 0 else 0.15 if i % 4 == 1 else 0.6 if i % 4 == 2 else 3.0

        def near(x: float, wide: float = wide) -> float:
            return x * exp(random.gauss(0, wide))

        if task.law == "p":
            yield (near(c.num_w[-1] / c.den_w[-1]),), (1.0,)
        elif task.law == "pi":
            kp, ki = found.gains["kp"], found.gains["ki"]
            yield (near(kp), near(ki)), (1.0, 0.0)
        elif task.law == "pd":
            kp, kd = near(found.gains["kp"]), near(found.gains["kd"])
            yield (kp * dt / 2 + kd, kp), (dt / 2, 1.0)
        elif task.law == "pid":
            kp, ki, kd = (near(found.gains[k]) for k in ("kp", "ki", "kd"))
            yield (kp * dt / 2 + kd, kp + ki * dt / 2, ki), (dt / 2, 1.0, 0.0)
        else:
            a0, w0, wp = (near(found.gains[k]) for k in ("dc_gain", "w0", "wp"))
            if (w0 < wp) == (task.law == "lead"):
                yield (a0 * wp / w0, a0 * wp), (1.0, wp)


def beaten(
    task: Task, found: zoh.Verified, asked: Requirements, random: Random, tries: int
) -> zoh.Measured | None:
    """Return the fastest rival that meets everything, None where there is none."""
    wc = found.margins.crossover
    w = np.geomspace(wc * FASTER, pi / task.dt, 400)
    s, plant = 1j * 2 / task.dt * np.tan(w * task.dt / 2), found.sampled.at(w)
    best = None
    for num, den in rivals(task, found, random, tries):
        loop = np.abs(np.polyval(num, s) / np.polyval(den, s) * plant)
        if not loop[0] > 1 or not loop[1:].min() < 1:
            continue
        rival = zoh.Sampled.from_w(num_w=num, den_w=den, dt=task.dt)
        margins = zoh.margins(rival * found.sampled)
        if not margins.stable or margins.crossover < wc * FASTER:
            continue
        if best is not None and margins.crossover < best.margins.crossover:
            continue
        v = 2 / task.dt * np.tan(margins.crossover * task.dt / 2)
        zeros = -np.roots(num).real if len(num) > 1 else np.array([np.inf])
        if zeros.min(initial=np.inf) < SLOWEST * v:
            continue
        if asked.ms is not None and margins.ms > asked.ms:
            continue
        measured = zoh.measure(task.plant, rival, requirements=asked)
        if measured.met:
            best = measured
    return best
