"""Random plants and requests: lags, integrators, resonances, zeros on the right, dead times.

Half of the requests are drawn around where the law has work to do, the others anywhere, so that
both answers come often.
"""

from cmath import phase
from dataclasses import dataclass
from math import degrees, exp, log, pi
from random import Random

import zoh

LAWS = ("p", "pi", "pd", "pid", "lag", "lead", "leadlag")


@dataclass(frozen=True)
class Request:
    """One request: a plant behind its hold, a law, and all its parameters."""

    plant: zoh.Plant
    sampled: zoh.Sampled
    law: str
    parameters: dict[str, float]


def drawn(law: str, seed: int) -> Request:
    """Return the request of this law and seed."""
    random = Random(f"{law} {seed}")
    dt = exp(random.uniform(log(1e-4), log(0.3)))
    plant = _plant(random, dt)
    sampled = zoh.sample(plant, dt)
    wc = min(exp(random.uniform(log(0.05), log(20))), random.uniform(0.02, 0.95) * pi / dt)
    g = sampled.at(wc)
    pm_deg = random.uniform(5, 120)
    if random.random() < 0.5:  # a turn that the law can often make
        low, high = {"pi": (-80, 0), "lag": (-60, 0), "p": (0, 0)}.get(law, (-30, 60))
        turned = (degrees(phase(g)) + 180 + random.uniform(low, high)) % 360
        pm_deg = turned if 0 < turned < 180 else pm_deg
    parameters = {"wc": wc, "pm_deg": pm_deg}
    if law == "pid":
        parameters |= _spare(random, wc / abs(g))
    if law in ("pd", "pid") and random.random() < 0.5:
        parameters["filter_pole"] = wc * exp(random.uniform(log(0.5), log(100)))
    if law in ("lag", "lead", "leadlag"):
        parameters["dc_gain"] = exp(random.uniform(log(0.05), log(20))) / abs(g)
    if law == "leadlag" and random.random() < 0.5:
        parameters["lag_ratio"] = exp(random.uniform(log(1.2), log(30)))
    if law == "leadlag" and random.random() < 0.3:
        parameters["lag_corner"] = wc * exp(random.uniform(log(0.02), log(2)))
    return Request(plant=plant, sampled=sampled, law=law, parameters=parameters)


def _spare(random: Random, unit: float) -> dict[str, float]:
    if random.random() < 0.5:
        return {"ki": unit * exp(random.uniform(log(1e-3), log(3)))}
    return {"ti_td": exp(random.uniform(log(1), log(30)))}


def _plant(random: Random, dt: float) -> zoh.Plant:
    poles: list[complex] = [
        -exp(random.uniform(log(0.05), log(20))) for _ in range(random.randint(1, 3))
    ]
    if random.random() < 0.4:
        poles.append(0.0)
    if random.random() < 0.15:
        poles.append(exp(random.uniform(log(0.05), log(2))))  # unstable
    if random.random() < 0.3:
        w, damping = exp(random.uniform(0, log(30))), random.uniform(0.05, 0.9)
        pole = complex(-damping * w, w * (1 - damping**2) ** 0.5)
        poles += [pole, pole.conjugate()]
    zeros = []
    if random.random() < 0.3 and len(poles) > 1:
        zeros = [random.choice((-1, 1)) * exp(random.uniform(log(0.3), log(30)))]
    gain = exp(random.uniform(log(0.1), log(10))) * (-1 if zeros and zeros[0] > 0 else 1)
    late = random.choice([0.0, 0.0, exp(random.uniform(log(0.01), log(0.5)))])
    dead_time = min(late, 12 * dt)  # a longer one only takes longer
    return zoh.Plant.zpk(zeros=zeros, poles=poles, gain=gain, dead_time=dead_time)
