"""Responses of sampled loops by powers of the closed loop's matrix. Shares no code with zoh.

The matrix holds exp(A t) at 60 digits, with the dead time splitting a sample interval in two,
and the difference equation as it is written. Floats only choose the piece where an extreme or
a crossing lies; root finding at 50 digits puts the number on it. A loop in which anything is
decided by less than a ten-thousandth is left out, so each answer is beyond dispute.
"""

import sys
from multiprocessing import Pool

import numpy as np
from mpmath import mp, mpf
from step_loops import PLANTS, candidates
from step_motion import Loop
from step_scan import Disputed, Scan

WORKING, DIGITS = 60, 22  # carried, written down
LEVELS = (0.1, 0.9, 0.98, 1.02)
LONGEST = 2_000_000  # samples
LONGEST_OTHERS = 1500  # samples of a loop that is excited otherwise, too
OTHERS = ("disturbance", "impulse", "ramp")
REST = 1e-6  # of itself is left of the slowest mode at the end


def close(values, marks, by):
    return any(bool((np.abs(values - mark) < by).any()) for mark in marks)


def between(scan, final):
    """Return the metrics of the continuous output."""
    sign, size = (1, final) if final > 0 else (-1, -final)
    all_y = sign * scan.ordered()
    if close(all_y[:, 1::2][scan.turns] / float(size), LEVELS, 1e-4):
        raise Disputed
    flat, width = all_y.ravel(), all_y.shape[1]
    high, low = scan.extreme(sign), scan.extreme(-sign)
    ten, ninety = (
        scan.crossing(int(np.argmax(flat >= float(level * size))), width, sign * level * size)
        for level in (mpf(1) / 10, mpf(9) / 10)
    )
    out = int(np.flatnonzero(np.abs(flat - float(size)) > float(size) / 50)[-1])
    edge = size * (1 + (mpf(1) if flat[out] > float(size) else mpf(-1)) / 50)
    return {
        "overshoot_pct": percent(high[0] - size, size),
        "undershoot_pct": percent(low[0], size),
        "rise_time": short(ninety - ten),
        "settling_time": short(scan.crossing(out + 1, width, sign * edge)),
        "peak": short(high[0]),
        "peak_time": short(high[1]),
    }


def at_samples(scan, final):
    loop, size = scan.loop, abs(float(final))
    y = scan.y[:, 0] * (1 if final > 0 else -1)
    if close(y / size, LEVELS, 1e-9 if len(y) > 20_000 else 1e-7):
        raise Disputed
    ten, ninety = (int(np.argmax(y >= level * size)) for level in (0.1, 0.9))
    settled = 1 + int(np.flatnonzero(np.abs(y - size) > size / 50)[-1])
    sign = 1 if final > 0 else -1
    top, bottom = (exact_top(y, side, lambda k: sign * loop.at(k, 0, 0)) for side in (1, -1))
    return {
        "overshoot_pct": percent(top[1] - abs(final), abs(final)),
        "undershoot_pct": percent(-bottom[1], abs(final)),
        "rise_time": short((ninety - ten) * loop.dt),
        "settling_time": short(settled * loop.dt),
        "peak": short(top[1]),
        "peak_time": short(top[0] * loop.dt),
    }


def exact_top(values, sign, exact):
    """Return (k, value) where sign * values is largest, the value exact."""
    high = sign * values
    near = np.flatnonzero(high >= high.max() - 1e-12 * np.abs(high).max())
    k = max(near[:5].tolist(), key=lambda i: sign * exact(i))
    return k, exact(k)


def percent(excess, final):
    return short(100 * max(excess, mpf(0)) / final)


def short(x):
    return mp.nstr(x, DIGITS, min_fixed=0, max_fixed=0)


def at_rest(spec):
    r = mpf(spec["reference"])
    if not spec["den"][-1] or not sum(spec["controller"][1]):
        return r
    k = mpf(spec["sensor"]) * mpf(spec["num"][-1]) / mpf(spec["den"][-1])
    k *= mp.fsum(map(mpf, spec["controller"][0])) / mp.fsum(map(mpf, spec["controller"][1]))
    return r * k / (1 + k)


def effort_at_rest(spec, final):
    """Return the input that holds the output where it ends, the limit of u."""
    return final * mpf(spec["den"][-1]) / (mpf(spec["num"][-1]) * mpf(spec["sensor"]))


def effort(scan, limit):
    """Return the least and the largest input, its limit included."""

    def exact(k):
        return (scan.loop.u * scan.loop.state(k))[0]

    ends = [exact_top(scan.u, sign, exact)[1] for sign in (-1, 1)]
    return min(ends[0], limit), max(ends[1], limit)


def other(loop, by, count):
    """Return the furthest the output gets under another excitation, between samples too."""
    if by == "ramp" and loop.spec["den"][-1] and sum(loop.spec["controller"][1]):
        return None  # nothing integrates: the error grows without end
    loop.excited(by)
    scan = Scan(loop, count)
    if by != "impulse" and abs(scan.y[-1, 0]) > 0.999 * np.abs(scan.y).max():
        return None  # creeps up to its limit: no peak
    peak, time = max(scan.extreme(1), scan.extreme(-1))
    if time > 0.7 * count * loop.dt:
        return None  # approached, between the samples, too
    return {"peak": short(peak), "peak_time": short(time)}


def one(loop, spec):
    loop.spec = spec
    loop.closed(spec["controller"]).excited("step")
    radius = loop.radius()
    count = int(np.log(REST) / np.log(radius)) + 20 + loop.m if 0.05 < radius < 1 else LONGEST
    final = at_rest(spec)
    if count * sum(map(len, loop.points)) > 2 * LONGEST or abs(final) <= 0.2:
        return None
    scan = Scan(loop, count)
    if abs(scan.y[-1, 0] / float(final) - 1) > 1e-4:
        return None
    try:
        low, high = effort(scan, effort_at_rest(spec, final))
        found = spec | {
            "final_value": short(final),
            "peak_effort": short(max(-low, high)),
            "effort_range": [short(low), short(high)],
            "at_samples": at_samples(scan, final),
            "between_samples": between(scan, final),
            "y": [short(loop.at(k, 0, 0)) for k in range(12)],
            "u": [short((loop.u * loop.state(k))[0]) for k in range(12)],
            "y_half_way": [short(half_way(loop, k)) for k in range(12)],
        }
    except Disputed:
        return None
    if count < LONGEST_OTHERS:
        try:
            found["others"] = {by: other(loop, by, count) for by in OTHERS}
        except Disputed:
            pass
    return found


def half_way(loop, k):
    """Return y at (k + 1/2) dt."""
    first_piece, t = loop.pieces[0][0], loop.dt / 2
    return loop.at(k, 0, t) if t <= first_piece else loop.at(k, 1, t - first_piece)


def of_plant(plant):
    """Return the cases of one plant, at most one a name."""
    mp.dps = WORKING
    cases, name, loop = [], None, None
    for spec in candidates(*plant):
        if cases and cases[-1]["name"] == spec["name"]:
            continue
        if spec["name"] != name:
            name, loop = spec["name"], Loop(spec)
        found = one(loop, spec)
        if found is not None:
            cases.append(found)
            sys.stderr.write(f"step: {spec['name']}\n")
    return cases


def make():
    with Pool(2) as pool:
        return [case for cases in pool.map(of_plant, PLANTS, chunksize=1) for case in cases]
