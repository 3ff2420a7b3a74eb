"""Named figures that are no margin of the suite: three on which peers were seen to go wrong.

All are of the arm, 0.1533/(s**2 + 0.7809 s): the matched transform at 0.1 s, the disk margin of
a gain of 3 held at 0.1 s, and the highest point of its step at 1 s, between the samples.
"""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from benchmarks.torture import exact, held, loops, truth
from benchmarks.torture.named import ARM
from mpmath import mp, mpf

import zoh
from zoh.sampling.convert import discretise

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import control

GRIDS = (20, 50, 200, 2000)


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A figure, what it is, and what each tool says."""

    name: str
    true: float
    said: dict[str, float]


def figures() -> Iterator[Figure]:
    """Yield the three figures."""
    with mp.workdps(60):
        yield _velocity_gain()
        yield _disk_margin()
        yield _peak()


def _velocity_gain() -> Figure:
    """Return (z - 1)/dt G(z) at z = 1 of the matched transform: that of the plant at s = 0."""
    made = discretise(zoh.Plant(**ARM), 0.1, "matched")
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        peer = control.c2d(control.tf(ARM["num"], ARM["den"]), 0.1, "matched")
    said = {"zoh": _ramp(made.num, made.den)}
    said["python-control"] = _ramp(peer.num[0][0], peer.den[0][0])
    return Figure(name="matched, velocity gain", true=float(mpf(0.1533) / mpf(0.7809)), said=said)


def _ramp(num: tuple[float, ...], den: tuple[float, ...]) -> float:
    slope = np.polyval(np.polyder(np.asarray(den)), 1.0)
    return float(np.polyval(num, 1.0) / slope / 0.1)


def _disk_margin() -> Figure:
    spec = {"form": "params", "plant": ARM, "dt": 0.1, "controller": {"num": [3.0], "den": [1.0]}}
    with mp.workdps(truth.WORK):
        loop = loops.exact_loop(spec)
        sides = (exact.add(loop.den, loop.num), exact.add(loop.den, loop.num, -1))
        true = float(2 * truth.least_ratio(loop, *sides)[0])
    held_gain = zoh.sample(zoh.Plant(**ARM), 0.1) * zoh.Sampled(num=[3.0], den=[1.0], dt=0.1)
    said = {"zoh": zoh.margins(held_gain).disk_margin}
    peer = 3 * control.c2d(control.tf(ARM["num"], ARM["den"]), 0.1, "zoh")
    for points in GRIDS:
        grid = np.logspace(-2, np.log10(np.pi / 0.1), points)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            margin = float(control.disk_margins(peer, grid)[0])
        said[f"python-control, {points} points"] = margin
    return Figure(name="disk margin", true=true, said=said)


def _peak() -> Figure:
    a, b, c, _ = held.state_space(ARM["num"], ARM["den"])
    x, peaks = mp.matrix(2, 1), []
    for _ in range(20):
        u = 3 * (1 - (c * x)[0])
        peaks.append(_highest(a, b, c, x, u))
        phi, gamma = held.over(a, b, mpf(1))
        x = phi * x + gamma * u
    step = zoh.measure(zoh.Plant(**ARM), zoh.Sampled(num=[3.0], den=[1.0], dt=1.0)).step
    peer = control.feedback(3 * control.c2d(control.tf(ARM["num"], ARM["den"]), 1.0, "zoh"), 1)
    said = {"python-control": float(control.step_info(peer)["Peak"])}
    if step is not None and step.between_samples is not None:
        said["zoh"] = step.between_samples.peak
    return Figure(name="peak of the step", true=float(max(peaks)), said=said)


def _highest(a: mp.matrix, b: mp.matrix, c: mp.matrix, x: mp.matrix, u: mpf) -> mpf:
    """Return the largest y in one second; the slope of y, an exponential, turns at most once."""

    def y_and_slope(t: mpf) -> tuple[mpf, mpf]:
        phi, gamma = held.over(a, b, t)
        then = phi * x + gamma * u
        return (c * then)[0], (c * (a * then + b * u))[0]

    low, high = mpf(0), mpf(1)
    if y_and_slope(low)[1] <= 0 or y_and_slope(high)[1] >= 0:
        return max(y_and_slope(low)[0], y_and_slope(high)[0])
    for _ in range(70):
        middle = (low + high) / 2
        low, high = (middle, high) if y_and_slope(middle)[1] > 0 else (low, middle)
    return y_and_slope(low)[0]
