"""Responses with a slow mode under every excitation, at 50 digits. Shares no code with zoh.

What is slow is left after everything else: a zero of the controller close to 1, a weak gain, a
light resonance. As in ``truth_step`` floats choose the piece, root finding at 50 digits puts the
number on it, and what is decided by less than a ten-thousandth is left out.
"""

import random
import sys
from multiprocessing import Pool

import numpy as np
from mpmath import mp, mpf
from step_motion import Loop
from step_scan import Disputed, Scan
from truth_hold import SENSOR
from truth_step import close, exact_top, short

WORKING = 60
LONGEST = 100_000  # samples
REST = 1e-7  # of itself is left of the slowest mode at the end
EXCITATIONS = ("step", "impulse", "ramp", "disturbance")

PLANTS = [
    # name, num, den, sensor
    ("lag", [1.0], [1.0, 1.0], 1.0),
    ("integrator", [1.0], [1.0, 0.0], 1.0),
    ("arm", [2.3], [1.0, 0.7809, 0.0], SENSOR),
    ("lag upside down", [-2.0], [1.0, 0.5], 1.0),
    ("light resonance", [1.0], [1.0, 0.1, 1.0], 1.0),
    ("integrator and resonance", [1.0], [1.0, 2.0, 7.0, 0.0], 1.0),
    ("zero and three poles", [4.0, 8.0], [1.0, 4.0, 6.0, 0.0], 1.0),
    ("zero on the right", [-0.5, 2.0], [1.0, 2.5, 2.0], 1.0),
    ("slow zero", [1.0, 0.03], [1.0, 0.6, 0.05], 1.0),
    ("slow and fast", [3.0], [1.0, 20.01, 0.2], 1.0),
]
DELAYS = ((0.0, 0.0), (0.0, 0.4), (0.5, 0.0), (1.3, 0.5))  # in dt
SLOW = (1e-2, 3e-3, 1e-3, 3e-4)


def drawn(rng, plant, dt):
    """Return num, den in z of a controller that leaves something slow behind."""
    _, num, den, sensor = plant
    at_rest = num[-1] / den[-1] if den[-1] else num[-1] / den[-2]
    k = float(f"{10 ** rng.uniform(-1.3, 0.3) / (at_rest * sensor):.3g}")
    zero = 1 - rng.choice(SLOW)
    kind = rng.choice(["P", "PI", "PI", "PID"])
    if kind == "P":
        return [[k / 3], [1.0]]
    if kind == "PI":
        return [[k, -k * zero], [1.0, -1.0]]
    return [[k, -k * (zero + 0.8), k * 0.8 * zero], [1.0, -1.0, 0.0]]


def at_rest(loop, by):
    """Return what the output (a ramp's error) and the effort come to; None for what grows."""
    spec = loop.spec
    num, den = [[mpf(c) for c in spec[a]] for a in ("num", "den")]
    num = [mpf(spec["sensor"]) * c for c in num]
    top, bottom = [[mpf(c) for c in a] for a in spec["controller"]]
    in_c, in_p = sum(bottom) == 0, den[-1] == 0
    c = mpf(0) if in_c else sum(top) / sum(bottom)
    p = mpf(0) if in_p else num[-1] / den[-1]
    if by == "impulse":
        return mpf(0), mpf(0)
    if by == "step":
        y = mpf(1) if in_c or in_p else c * p / (1 + c * p)
        return y, y * den[-1] / num[-1]
    if by == "disturbance":
        if in_c or in_p:
            return (mpf(0) if in_c else 1 / c), mpf(-1)
        return p / (1 + c * p), -c * p / (1 + c * p)
    if not in_p:
        return None  # u grows without end, or y does not follow
    velocity = den[-2] / num[-1]
    return (mpf(0) if in_c else velocity / c), velocity


def under(loop, by, count):
    """Return the figures under an excitation, None where one is in dispute."""
    ends = at_rest(loop, by)
    if ends is None:
        return None
    final, limit = ends
    loop.excited(by)
    scan = Scan(loop, count)
    try:
        peak, when = max(scan.extreme(1), scan.extreme(-1))
        if peak <= abs(final):
            peak, when = abs(final), None  # approached
        elif when > 0.7 * count * loop.dt or flat_top(scan, float(peak)):
            return None
        band = max(peak, abs(final)) / 50
        off = np.abs(scan.ordered() - float(final))
        if close(off[:, 1::2][scan.turns] / float(band), [1.0], 1e-4):
            return None
        flat, width = off.ravel(), off.shape[1]
        out = int(np.flatnonzero(flat > float(band))[-1])
        if out == len(flat) - 1:
            return None
        above = scan.ordered().ravel()[out] > float(final)
        settled = scan.crossing(out + 1, width, final + (band if above else -band))
    except Disputed:
        return None
    tops = [abs(exact_top(scan.u, s, lambda k: (loop.u * loop.state(k))[0])[1]) for s in (1, -1)]
    return {
        "peak": short(peak), "peak_time": when and short(when), "final_value": short(final),
        "settling_time": short(settled), "peak_effort": short(max(*tops, abs(limit))),
    }  # fmt: skip


def flat_top(scan, peak):
    """Return whether more than the end of a sample, which is the next one's start, is as high."""
    return (np.abs(scan.y) > (1 - 1e-13) * peak).sum() > 2


def noise(loop):
    """Return the root of the sum of squares of y and u after a reference of 1 at k = 0 alone."""
    start = loop.excited("impulse").copy()
    start[loop.size - 1] = 0
    total, step = start * start.T, loop.powers[0]
    while True:
        added = step * total * step.T
        total, step = total + added, step * step
        if mp.mnorm(step[: loop.own, : loop.own], 1) < mpf(10) ** -40:
            break
    rows = loop.row_of(loop.c), loop.u
    return [short(mp.sqrt((row * total * row.T)[0])) for row in rows]


def of_plant(plant):
    """Return four loops of one plant, each with three excitations or more beyond dispute."""
    mp.dps = WORKING
    name, num, den, sensor = plant
    rng, cases = random.Random(name), []
    while len(cases) < 4:
        dt, (dead, compute) = rng.choice([0.5, 0.1, 0.03]), rng.choice(DELAYS)
        spec = {
            "name": f"{name}, dt {dt:g}, dead {dead:g} dt, compute {compute:g} dt",
            "num": num, "den": den, "sensor": sensor, "dead_time": dead * dt,
            "compute_delay": compute * dt, "dt": dt, "reference": 1.0,
            "controller": drawn(rng, plant, dt),
        }  # fmt: skip
        loop = Loop(spec).closed(spec["controller"])
        loop.excited("step")
        radius = loop.radius()
        if not 0.98 < radius < REST ** (1 / LONGEST):
            continue
        count = int(np.log(REST) / np.log(radius)) + 20 + loop.m
        found = {by: under(loop, by, count) for by in EXCITATIONS}
        if sum(case is not None for case in found.values()) < 2 + (den[-1] == 0):
            continue
        cases.append(spec | {"noise": noise(loop), "responses": found})
        sys.stderr.write(f"response: {spec['name']}, {count} samples\n")
    return cases


def make():
    with Pool(2) as pool:
        return [case for cases in pool.map(of_plant, PLANTS, chunksize=1) for case in cases]
