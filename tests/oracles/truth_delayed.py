"""Loops that wait for a hundred to ten thousand samples, by the plain recursion at 50 digits.

A lag under a PI: between two changes of its input the lag goes straight for its new end, so its
extremes are at the changes and it crosses a level at tau ln((x - v)/(level - v)).
"""

import sys
from itertools import pairwise

from mpmath import mp, mpf
from truth_hold import whole_and_rest
from truth_step import percent, short

LOOPS = [
    # dead time and compute delay in samples, lag's time constant, gain, PI's gain over 1/(K m)
    (64.0, 0.0, 300.0, 2.0, 0.35),
    (65.0, 0.0, 300.0, 2.0, 0.6),
    (66.5, 0.25, 40.0, 0.5, 0.5),
    (100.0, 0.3, 1000.0, -3.0, 0.5),
    (400.0, 1.0, 5000.0, 1.0, 0.5),
    (401.25, 0.0, 20.0, 1.0, 0.25),
    (1000.0, 0.0, 3000.0, 2.0, 0.6),  # a thermal plant: 10 s at 10 ms
    (3000.4, 0.7, 3000.0, 2.0, 0.5),
    (10000.0, 0.0, 9000.0, 1.0, 0.5),
]
DELAYS, LEAST = 14, 12_000  # followed for so many, and so many samples


class Run:
    """The loop from sample to sample; ``spots`` are (time, y, what y goes for from there on)."""

    def __init__(self, spec, tau):
        self.dt, self.tau = mpf(spec["dt"]), mpf(tau)
        gain = mpf(spec["num"][0]) * mpf(spec["sensor"])
        waits = mpf(spec["dead_time"]) + mpf(spec["compute_delay"])
        self.m, rest = whole_and_rest(waits, self.dt)
        (b0, b1), _ = spec["controller"]
        pieces = [(self.dt - rest, self.m), (rest, self.m - 1)] if rest else [(self.dt, self.m)]
        falls = [mp.exp(-t / self.tau) for t, _ in pieces]
        x = u = e_before = mpf(0)
        self.y, self.u, self.spots = [], [], []
        for k in range(max(DELAYS * self.m, LEAST)):
            e = 1 - x
            u += mpf(b0) * e + mpf(b1) * e_before
            e_before = e
            self.y.append(x)
            self.u.append(u)
            t = k * self.dt
            for (length, late), fall in zip(pieces, falls, strict=True):
                v = gain * self.u[k - late] if k >= late else mpf(0)
                self.spots.append((t, x, v))
                x, t = v + (x - v) * fall, t + length
        self.spots.append((t, x, x))

    def crossing(self, i, level):
        """Return when y crosses a level after spot i."""
        t, x, v = self.spots[i]
        return t + self.tau * mp.log((x - v) / (level - v))


def metrics(run):
    at = {
        level: run.crossing(next(i for i, s in enumerate(run.spots) if s[1] >= level) - 1, level)
        for level in (mpf(1) / 10, mpf(9) / 10)
    }
    (ten, ninety), band = at.values(), mpf(2) / 100
    out = max(i for i, s in enumerate(run.spots) if abs(s[1] - 1) > band)
    edge = 1 + (band if run.spots[out][1] > 1 else -band)
    t, peak, _ = max(run.spots, key=lambda s: s[1])
    return {
        "overshoot_pct": percent(peak - 1, mpf(1)),
        "undershoot_pct": percent(-min(s[1] for s in run.spots), mpf(1)),
        "rise_time": short(ninety - ten),
        "settling_time": short(run.crossing(out, edge)),
        "peak": short(peak),
        "peak_time": short(t),
    }


def at_samples(run):
    y, dt = run.y, run.dt
    ten, ninety = (next(k for k, v in enumerate(y) if v >= level) for level in (0.1, 0.9))
    settled = max(k for k, v in enumerate(y) if abs(v - 1) > mpf(2) / 100) + 1
    top = max(range(len(y)), key=lambda k: y[k])
    return {
        "overshoot_pct": percent(y[top] - 1, mpf(1)),
        "undershoot_pct": percent(-min(y), mpf(1)),
        "rise_time": short((ninety - ten) * dt),
        "settling_time": short(settled * dt),
        "peak": short(y[top]),
        "peak_time": short(top * dt),
    }


def make():
    mp.dps = 50
    cases = []
    for dead, compute, tau, gain, share in LOOPS:
        dt = 0.01
        kp = share * (tau / gain) / (dead + compute)
        ki = share / gain / (dead + compute) / dt
        spec = {
            "name": f"{dead:g} and {compute:g} samples, lag of {tau:g}",
            "num": [gain], "den": [tau * dt, 1.0], "sensor": 1.0, "dead_time": dead * dt,
            "compute_delay": compute * dt, "dt": dt,
            "controller": [[kp + ki * dt, -kp], [1.0, -1.0]],
        }  # fmt: skip
        run = Run(spec, mpf(spec["den"][0]))
        assert all(abs(b - a) < 1e-2 for (_, a, _), (_, b, _) in pairwise(run.spots[-run.m :]))
        ends = [*run.u, 1 / mpf(gain)]  # the input that holds the output at 1, its limit
        cases.append(
            spec
            | {
                "at_samples": at_samples(run),
                "between_samples": metrics(run),
                "peak_effort": short(max(map(abs, ends))),
                "effort_range": [short(min(ends)), short(max(ends))],
                "samples": [
                    [k, short(run.y[k]), short(run.u[k])]
                    for k in range(0, len(run.y), len(run.y) // 12)
                ],
            }
        )
        sys.stderr.write(f"delayed: {spec['name']}\n")
    return cases
