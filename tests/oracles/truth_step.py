"""Step responses of sampled loops by exact state propagation. Shares no code with zoh.

The plant's states go from one change of the held input to the next by exp(A t) at 40 digits,
with the dead time splitting a sample interval in two. Floats only choose the piece where an
extreme or a crossing lies; 40-digit root finding puts the number on it. A loop in which
anything is decided by less than a millionth is left out, so each answer is beyond dispute.
"""

import random
import sys
from itertools import pairwise

import numpy as np
from mpmath import mp, mpf
from truth_hold import SENSOR, companion, exact_hold, hold_matrices, whole_and_rest

POINTS = 24  # per piece, to look between them
DIGITS = 22  # written down
LEVELS = (0.1, 0.9, 0.98, 1.02)

PLANTS = [
    # name, num, den, sensor, time scale in s
    ("arm", [2.3], [1.0, 0.7809, 0.0], SENSOR, 1.0),
    ("double integrator", [1.0], [1.0, 0.0, 0.0], 1.0, 1.0),
    ("lag", [2.0], [1.0, 0.5], 1.0, 1.0),
    ("two lags", [3.0], [1.0, 3.0, 2.0], 1.0, 1.0),
    ("zero on the right", [-0.5, 2.0], [1.0, 2.5, 2.0], 1.0, 1.0),
    ("resonance", [9.0], [1.0, 0.9, 9.0], 1.0, 1.0),
    ("unstable lag", [1.5], [1.0, -0.5], 1.0, 1.0),
    ("fast motor", [4000.0], [1.0, 50.0, 0.0], 1.0, 0.02),
    ("zero and three poles", [4.0, 8.0], [1.0, 4.0, 6.0, 0.0], 1.0, 1.0),
]


class Loop:
    """One closed loop, run until what is left is below a millionth."""

    def __init__(self, spec, samples):
        self.spec, self.dt = spec, mpf(spec["dt"])
        self.a, self.b, row, _ = companion(spec["num"], spec["den"])
        self.n = self.a.rows
        self.c = [mpf(spec["sensor"]) * x for x in row]
        m, eps = whole_and_rest(mpf(spec["dead_time"]) + mpf(spec["compute_delay"]), self.dt)
        self.pieces = [(self.dt - eps, m), (eps, m - 1)] if eps else [(self.dt, m)]
        steps = [hold_matrices(self.a, self.b, t) for t, _ in self.pieces]
        x, self.y, self.u, self.runs, e = mp.zeros(self.n, 1), [], [], [], []
        top, bottom = spec["controller"]
        top = [0.0] * (len(bottom) - len(top)) + top
        for k in range(samples):
            self.y.append(self.out(x))
            e.append(mpf(spec["reference"]) - self.y[-1])
            u = sum(mpf(b) * e[k - i] for i, b in enumerate(top) if i <= k)
            u -= sum(mpf(a) * self.u[k - i] for i, a in enumerate(bottom) if 0 < i <= k)
            self.u.append(u / mpf(bottom[0]))
            for p, (phi, gamma) in enumerate(steps):
                late = k - self.pieces[p][1]
                v = self.u[late] if late >= 0 else mpf(0)
                self.runs.append((k, p, x, v))
                x = phi * x + gamma * v

    def out(self, x):
        return sum(self.c[i] * x[i] for i in range(self.n))

    def start(self, run):
        k, p, _, _ = self.runs[run]
        return k * self.dt + (self.pieces[0][0] if p else 0)

    def at(self, run, t):
        _, _, x, v = self.runs[run]
        phi, gamma = hold_matrices(self.a, self.b, mpf(t))
        return self.out(phi * x + gamma * v)

    def slope(self, run, t):
        _, _, x, v = self.runs[run]
        phi, _ = hold_matrices(self.a, self.b, mpf(t))
        return self.out(phi * (self.a * x + self.b * v))

    def nodes(self):
        """Return run, t, y, y' over a grid of the whole response, as float arrays."""
        rows = []
        for duration, _ in self.pieces:
            times = [duration * i / POINTS for i in range(POINTS + 1)]
            rows.append((times, [self.row(t) for t in times]))
        out = []
        for run, (_, p, x, v) in enumerate(self.runs):
            state = np.array([*(float(c) for c in x), float(v)])
            times, (value, turn) = rows[p][0], np.array(rows[p][1]).swapaxes(0, 1)
            out += zip([run] * len(times), times, value @ state, turn @ state, strict=True)
        return out

    def row(self, t):
        phi, gamma = hold_matrices(self.a, self.b, mpf(t))
        left = [sum(self.c[i] * phi[i, j] for i in range(self.n)) for j in range(self.n)]
        held = self.out(gamma)
        turn = [sum(left[i] * self.a[i, j] for i in range(self.n)) for j in range(self.n)]
        turned = sum(left[i] * self.b[i] for i in range(self.n))
        return [float(c) for c in (*left, held)], [float(c) for c in (*turn, turned)]


def solve(f, a, b):
    return mp.findroot(f, (a, b), solver="anderson", tol=mpf(10) ** -60, maxsteps=200)


def between(loop, final):
    """Return the metrics of the continuous output, or None where one is a close call."""
    nodes = loop.nodes()
    bumps = []
    for (run, t, y, s), (other, t2, _, s2) in pairwise(nodes):
        if run == other and s * s2 < 0:
            width = float(t2 - t)
            top = s / (s - s2) * width  # where a straight slope is zero
            about = y + s * top + (s2 - s) * top * top / (2 * width)
            bumps.append((run, t, t2, about, t + mpf(top)))
    close = [abs(b[3] / float(final) - level) for b in bumps for level in LEVELS]
    if min(close, default=1) < 1e-4:
        return None
    high, low = extreme(loop, nodes, bumps, 1), extreme(loop, nodes, bumps, -1)
    times = {level: first(loop, nodes, bumps, level * final) for level in (0.1, 0.9)}
    return {
        "overshoot_pct": percent(high[0] - final, final),
        "undershoot_pct": percent(-low[0], final),
        "rise_time": short(times[0.9] - times[0.1]),
        "settling_time": short(last(loop, nodes, bumps, final)),
        "peak": short(high[0]),
        "peak_time": short(high[1]),
    }


def percent(excess, final):
    return short(100 * max(excess, mpf(0)) / final)


def extreme(loop, nodes, bumps, sign):
    """Return (value, time) of the greatest (sign 1) or least (-1) output."""
    best = max(nodes, key=lambda n: sign * n[2])
    found = [(loop.at(best[0], best[1]), loop.start(best[0]) + best[1])]
    for run, t, t2, about, _ in bumps:
        if sign * about > sign * best[2] - 1e-3 * abs(best[2]) - 1e-12:
            top = solve(lambda x, r=run: loop.slope(r, x), t, t2)
            found.append((loop.at(run, top), loop.start(run) + top))
    return max(found, key=lambda f: sign * f[0])


def with_bumps(nodes, bumps):
    """Return (run, t, y) with the tops of the bumps put in, so no crossing hides under one."""
    spots = {(run, t): (run, top, about) for run, t, _, about, top in bumps}
    for run, t, y, _ in nodes:
        yield run, t, y
        if (run, t) in spots:
            yield spots[run, t]


def first(loop, nodes, bumps, level):
    here = None
    for run, t, y in with_bumps(nodes, bumps):
        if y >= level:
            start = here[1] if here and here[0] == run else mpf(0)
            return loop.start(run) + solve(lambda x, r=run: loop.at(r, x) - level, start, t)
        here = (run, t)
    raise ArithmeticError("never there")


def last(loop, nodes, bumps, final):
    spots = list(with_bumps(nodes, bumps))
    band = final * mpf(2) / 100
    out = max(i for i, (_, _, y) in enumerate(spots) if abs(y - final) > band)
    run, t, y = spots[out]
    _, t2, _ = spots[out + 1]
    edge = final + (band if y > final else -band)
    return loop.start(run) + solve(lambda x: loop.at(run, x) - edge, t, t2)


def at_samples(loop, final):
    y = loop.y
    if min(abs(v / final - level) for v in y for level in LEVELS) < 1e-7:
        return None
    ten, ninety = (next(k for k, v in enumerate(y) if v >= level * final) for level in (0.1, 0.9))
    settled = 1 + max(k for k, v in enumerate(y) if abs(v - final) > final / 50)
    top = max(range(len(y)), key=lambda k: y[k])
    return {
        "overshoot_pct": percent(y[top] - final, final),
        "undershoot_pct": percent(-min(y), final),
        "rise_time": short((ninety - ten) * loop.dt),
        "settling_time": short(settled * loop.dt),
        "peak": short(y[top]),
        "peak_time": short(top * loop.dt),
    }


def short(x):
    return mp.nstr(x, DIGITS, min_fixed=0, max_fixed=0)


def slowest(spec):
    """Return the largest closed-loop pole's size, in floats; it only picks loops."""
    dead = spec["dead_time"] + spec["compute_delay"]
    held = exact_hold(spec["num"], spec["den"], spec["sensor"], spec["dt"], dead, digits=20)
    top = np.convolve([float(c) for c in held[0]], spec["controller"][0])
    bottom = np.convolve([float(c) for c in held[1]] + [0.0] * held[4], spec["controller"][1])
    closed = np.polyadd(bottom, top)
    return float(max(abs(np.roots(closed)), default=0.0))


def candidates():
    """Yield loops with drawn gains; most are unstable or slow and fall through."""
    rng = random.Random(4)
    for name, num, den, sensor, scale in PLANTS:
        for dt_share in (1.0, 0.3, 0.1, 0.03, 0.01, 0.003):
            for dead, compute in ((0.0, 0.0), (0.0, 0.4), (0.7, 0.0), (1.3, 0.5)):
                for _ in range(12):
                    dt = dt_share * scale
                    kp = 10 ** rng.uniform(-1, 1.5) / sensor / (scale**-1 * abs(num[-1]) / 2)
                    kd = kp * scale * rng.choice([0.0, 0.2, 0.6, 1.2])
                    ki = kp / scale * rng.choice([0.0, 0.1, 0.5])
                    yield {
                        "name": f"{name}, dt {dt:g}, dead {dead:g} dt, compute {compute:g} dt",
                        "num": num, "den": den, "sensor": sensor, "dead_time": dead * dt,
                        "compute_delay": compute * dt, "dt": dt,
                        "reference": 1.0 if rng.random() < 0.7 else 2.5,
                        "controller": pid(kp, ki, kd, dt),
                    }  # fmt: skip


def pid(kp, ki, kd, dt):
    """Return num, den of kp + ki dt z/(z-1) + kd (z-1)/(dt z), as short as they come."""
    if not ki:
        return [[kp + kd / dt, -kd / dt], [1.0, 0.0]] if kd else [[kp], [1.0]]
    if not kd:
        return [[kp + ki * dt, -kp], [1.0, -1.0]]
    d = kd / dt
    return [[kp + ki * dt + d, -kp - 2 * d, d], [1.0, -1.0, 0.0]]


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


def one(spec):
    radius = slowest(spec)
    if not 0.05 < radius < 0.992:
        return None
    samples = int(np.log(1e-6) / np.log(radius)) + 20
    final = at_rest(spec)
    if final <= 0.2 or samples > 1500:
        return None
    loop = Loop(spec, samples)
    if abs(loop.y[-1] / final - 1) > 1e-4:
        return None
    seen, dense = at_samples(loop, final), between(loop, final)
    if seen is None or dense is None:
        return None
    return spec | {
        "final_value": short(final),
        "peak_effort": short(max(abs(u) for u in [*loop.u, effort_at_rest(spec, final)])),
        "at_samples": seen,
        "between_samples": dense,
        "y": [short(v) for v in loop.y[:12]],
        "u": [short(v) for v in loop.u[:12]],
        "y_half_way": [short(half_way(loop, k)) for k in range(12)],
    }


def half_way(loop, k):
    """Return y at (k + 1/2) dt."""
    first_piece, per = loop.pieces[0][0], len(loop.pieces)
    t = loop.dt / 2
    return loop.at(per * k, t) if t <= first_piece else loop.at(per * k + 1, t - first_piece)


def make():
    mp.dps = 40
    cases, seen = [], {}
    for spec in candidates():
        if seen.get(spec["name"]):
            continue
        found = one(spec)
        if found is not None:
            seen[spec["name"]] = True
            cases.append(found)
            sys.stderr.write(f"step: {len(cases)}, {spec['name']}\n")
    return cases
