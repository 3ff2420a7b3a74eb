"""Random plants and requirements, and random controllers that are to beat a choice.

The attack uses no code of the choice. It takes a fine grid of crossovers above the chosen one,
margins and the law's free gain, solved here by hand; it draws the gains of the law around those
chosen, near and far; of both it keeps what crosses over faster by more than 0.1 %, and asks
``zoh.measure`` about the rest.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from math import exp, log, pi
from random import Random

import numpy as np

import zoh
from zoh.lti.forms import RINGS
from zoh.spec import Requirements

FASTER = 1.001  # what is faster by less does not count
SLOWEST = 0.1  # of wc: the slowest zero that a choice may have, as docs/choice.md says
_FASTER = (1.0011, 1.002, 1.004, 1.008, 1.015, 1.03, 1.06, 1.12, 1.25, 1.5, 2.0, 3.0)
_MARGINS = range(4, 100, 4)  # deg
_FREE = np.geomspace(1e-3, 1e3, 25)  # of the law's gain at wc


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


def gridded(
    task: Task, found: zoh.Verified
) -> Iterator[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Yield (num, den) in w of the law at every crossover, margin and free gain of a grid."""
    half, chosen = task.dt / 2, found.margins.crossover
    for wc in (chosen * x for x in _FASTER if chosen * x < 0.999 * pi / task.dt):
        v, plant = np.tan(wc * half) / half, complex(found.sampled.at(wc))
        if task.law == "p":
            yield (1 / abs(plant),), (1.0,)
            continue
        for pm_deg in _MARGINS:
            law = np.exp(1j * np.radians(pm_deg - 180)) / plant  # what the law must be at wc
            yield from _solved(task.law, complex(law), float(v), half)


def _solved(
    law: str, d: complex, v: float, half: float
) -> Iterator[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Yield the laws that are d at j v, with positive gains: two equations, linear in the gains."""
    if law == "pi":
        if d.real > 0 > d.imag:
            yield (d.real, -v * d.imag), (1.0, 0.0)
        return
    turn = 1j * v / (1 + 1j * v * half)  # the filtered derivative
    for free in (0.0,) if law == "pd" else _FREE * abs(d):
        if law in ("pd", "pid"):
            ki = v * free
            rest = d - ki / (1j * v)
            kd = rest.imag / turn.imag
            kp = rest.real - kd * turn.real
            if kp > 0 and kd > 0 and ki:
                yield (kp * half + kd, kp + ki * half, ki), (half, 1.0, 0.0)
            elif kp > 0 and kd > 0:
                yield (kp * half + kd, kp), (half, 1.0)
            continue
        pole = (d.real - free) / (d.imag * v)  # 1/wp and 1/w0
        zero = (d.imag / v + d.real * pole) / free
        if pole > 0 and zero > 0 and (zero > pole) == (law == "lead"):
            yield (free * zero / pole, free / pole), (1.0, 1 / pole)


@dataclass(frozen=True)
class Glance:
    """What a plant and what is asked show of a rival at some frequencies, before it is measured.

    s, plant  points of the w-plane and the plant there;  first  the index of the fastest crossover
              that is no win;  clear  the plant's polynomials in w, None where it is late
    """

    s: np.ndarray
    plant: np.ndarray
    first: int
    clear: tuple[tuple[float, ...], tuple[float, ...]] | None
    asked: Requirements

    @classmethod
    def of(cls, sampled: zoh.Sampled, wc: float, asked: Requirements) -> "Glance":
        """Return the frequencies: a coarse look below wc, a fine one above."""
        below, above = np.geomspace(wc / 300, wc, 150)[:-1], np.geomspace(wc, pi / sampled.dt, 400)
        w = np.concatenate([below, above])
        s, plant = 1j * 2 / sampled.dt * np.tan(w * sampled.dt / 2), sampled.at(w)
        clear = None if sampled.delay else (sampled.num_w, sampled.den_w)
        return cls(s=s, plant=plant, first=len(below), clear=clear, asked=asked)

    def hopeless(self, num: tuple[float, ...], den: tuple[float, ...]) -> bool:
        """Return whether the rival is no faster, unstable, or over its Ms, by what is seen alone.

        An Ms seen at some frequencies is never larger than Ms itself; a pole counts as unstable
        where rounding cannot have moved it across.
        """
        loop = np.polyval(num, self.s) / np.polyval(den, self.s) * self.plant
        size = np.abs(loop[self.first :])
        if not size[0] > 1 or not size[1:].min() < 1:
            return True
        if self.asked.ms is not None and 1 / np.abs(1 + loop).min() > self.asked.ms * (1 + 1e-9):
            return True
        if self.clear is None:
            return False
        closed = np.polyadd(np.polymul(num, self.clear[0]), np.polymul(den, self.clear[1]))
        roots = np.roots(closed)
        return bool((roots.real > 1e-3 * np.abs(roots)).any())


def beaten(
    task: Task, found: zoh.Verified, asked: Requirements, random: Random, tries: int,
    others: Iterable[tuple[tuple[float, ...], tuple[float, ...]]] = (),
) -> zoh.Measured | None:  # fmt: skip
    """Return the fastest rival, ``others`` among them, that meets everything; None without one."""
    wc = found.margins.crossover
    glance = Glance.of(found.sampled, wc * FASTER, asked)
    best, rings = None, 2 * RINGS / task.dt
    calm = found.gains.get("wp", 0.0) <= rings
    for num, den in chain(others, rivals(task, found, random, tries)):
        if glance.hopeless(num, den):
            continue
        if calm and task.law in ("lead", "lag") and den[1] > rings * den[0]:
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
