"""Responses of sampled loops by powers of the closed loop's matrix. Shares no code with zoh.

The matrix holds exp(A t) at 60 digits, with the dead time splitting a sample interval in two,
and the difference equation as it is written. Floats only choose the piece where an extreme or
a crossing lies; root finding at 50 digits puts the number on it. A loop in which anything is
decided by less than a ten-thousandth is left out, so each answer is beyond dispute.
"""

import sys
from itertools import pairwise
from multiprocessing import Pool

import numpy as np
from mpmath import mp, mpf
from scipy.linalg import expm
from step_loops import PLANTS, candidates
from truth_hold import companion, hold_matrices, whole_and_rest

WORKING, DIGITS = 60, 22  # carried, written down
LEVELS = (0.1, 0.9, 0.98, 1.02)
LONGEST = 2_000_000  # samples
LONGEST_OTHERS = 1500  # samples of a loop that is excited otherwise, too
OTHERS = ("disturbance", "impulse", "ramp")
REST = 1e-6  # of itself is left of the slowest mode at the end


class Loop:
    """Z = (x, past inputs, past errors, r, 1), and what it becomes a sample later."""

    def __init__(self, spec):
        self.spec, self.dt = spec, mpf(spec["dt"])
        self.a, self.b, row, direct = companion(spec["num"], spec["den"])
        assert direct == 0
        self.n = self.a.rows
        self.c = [mpf(spec["sensor"]) * x for x in row]
        m, rest = whole_and_rest(mpf(spec["dead_time"]) + mpf(spec["compute_delay"]), self.dt)
        self.pieces = [(self.dt - rest, m), (rest, m - 1)] if rest else [(self.dt, m)]
        self.m, self.steps = m, [hold_matrices(self.a, self.b, t) for t, _ in self.pieces]
        self.fastest = float(np.abs(np.roots(spec["den"])).max())
        self.points = [self.grid(t) for t, _ in self.pieces]
        self.maps, self.flows = {}, {}

    def grid(self, duration):
        """Return where to look in a piece: evenly, and closely after its start."""
        fastest = self.fastest
        even = 24 if self.dt > 3e-3 else 4
        at = {duration * i / even for i in range(even + 1)}
        if fastest * duration > 2:
            early = np.geomspace(0.02 / fastest, float(duration), 60)[:-1]
            at |= {mpf(t) for t in early}
        return sorted(at)

    def closed(self, controller):
        """Return a copy with the matrix of this controller."""
        self.controller = top, bottom = [[mpf(c) for c in a] for a in controller]
        top = [mpf(0)] * (len(bottom) - len(top)) + top
        top, bottom = [c / bottom[0] for c in top], [c / bottom[0] for c in bottom]
        self.past, self.errors = max(self.m, len(bottom) - 1), len(top) - 1
        self.own = self.n + self.past + self.errors
        self.size = size = self.own + 2
        unit = mp.eye(size)
        e = -self.row_of(self.c) + unit[size - 2, :]
        u = top[0] * e
        for i in range(self.past):
            u += (-bottom[i + 1] if i + 1 < len(bottom) else 0) * unit[self.n + i, :]
        for i in range(self.errors):
            u += top[i + 1] * unit[self.n + self.past + i, :]
        self.u, self.e = u, e
        return self

    def row_of(self, c):
        return mp.matrix([[*c, *[mpf(0)] * (self.size - self.n)]])

    def held(self, piece, d):
        """Return the plant's input during a piece as a row on Z."""
        late = self.pieces[piece][1]
        out = mp.eye(self.size)[self.n + late - 1, :] if late else self.u.copy()
        out[0, self.size - 1] += d
        return out

    def excited(self, by):
        """Set the matrix for an excitation and return Z at k = 0."""
        self.by, size, n = by, self.size, self.n
        x = mp.eye(size)[:n, :]
        self.starts, self.inputs = [], []
        for p, (phi, gamma) in enumerate(self.steps):
            v = self.held(p, mpf(by == "disturbance"))
            self.starts.append(x)
            self.inputs.append(v)
            x = phi * x + gamma * v
        step = mp.zeros(size, size)
        step[:n, :] = x
        for first, count, new in ((n, self.past, self.u), (n + self.past, self.errors, self.e)):
            for i in range(count):
                step[first + i, :] = mp.eye(size)[first + i - 1, :] if i else new
        step[size - 1, size - 1] = 1
        step[size - 2, size - 2] = 0 if by == "impulse" else 1
        step[size - 2, size - 1] = self.dt if by == "ramp" else 0
        self.powers = [step]
        start = mp.zeros(size, 1)
        start[size - 1] = 1
        start[size - 2] = {"step": mpf(self.spec["reference"]), "impulse": mpf(1)}.get(by, mpf(0))
        self.start, self.known, self.known_series = start, {}, {}
        return start

    def state(self, k):
        """Return Z(k) from the binary powers of the matrix."""
        if k not in self.known:
            z, i, rest = self.start, 0, int(k)
            while rest:
                if i == len(self.powers):
                    self.powers.append(self.powers[-1] * self.powers[-1])
                if rest & 1:
                    z = self.powers[i] * z
                rest, i = rest >> 1, i + 1
            self.known[k] = z
        return self.known[k]

    def radius(self):
        a = floats(self.powers[0])[: self.own, : self.own]
        return float(np.abs(np.linalg.eigvals(a)).max())

    def at(self, k, p, t, *, slope=False):
        """Return the output (a ramp's is the error) at t in piece p of sample k, or its slope."""
        t = mpf(t)
        if self.fastest * t > 5:
            z = self.state(k)
            x, v = self.starts[p] * z, (self.inputs[p] * z)[0]
            if t not in self.maps:
                self.maps[t] = hold_matrices(self.a, self.b, t)
            phi, gamma = self.maps[t]
            now = phi * (self.a * x + self.b * v) if slope else phi * x + gamma * v
            y = sum(self.c[i] * now[i] for i in range(self.n))
        else:
            y = mp.polyval(self.series(k, p)[slope], t)
        if self.by == "ramp":
            return 1 - y if slope else self.time(k, p, t) - y
        return y

    def series(self, k, p):
        """Return the Taylor polynomials of the output and its slope from the piece's start on."""
        if (k, p) not in self.known_series:
            z = self.state(k)
            x, v = self.starts[p] * z, (self.inputs[p] * z)[0]
            low = [-self.a[self.n - 1, i] for i in range(self.n)]
            term, out = list(x), []
            for j in range(1, 90 + self.n):  # 5^90/90! is 1e-75
                out.append(sum(c * y for c, y in zip(self.c, term, strict=True)))
                last = (v if j == 1 else 0) - sum(c * y for c, y in zip(low, term, strict=True))
                term = [y / j for y in (*term[1:], last)]
            turned = [j * c for j, c in enumerate(out)][1:]
            self.known_series[k, p] = out[::-1], turned[::-1]
        return self.known_series[k, p]

    def time(self, k, p, t):
        return int(k) * self.dt + (self.pieces[0][0] if p else 0) + t

    def rows(self, p, t):
        """Return output and slope at t in piece p, as float rows on Z."""
        n, a, b = self.n, floats(self.a), floats(self.b)
        if t not in self.flows:
            both = np.block([[a, b], [np.zeros((1, n + 1))]])
            self.flows[t] = expm(both * float(t))
        flow = self.flows[t]
        c = np.array(self.c, float)
        start, held = floats(self.starts[p]), floats(self.inputs[p])
        out = [
            c @ (flow[:n, :n] @ start + flow[:n, n:] @ held),
            c @ flow[:n, :n] @ (a @ start + b @ held),
        ]
        if self.by == "ramp":
            r, one = np.eye(self.size)[-2:]
            out = [r + float(self.time(0, p, t)) * one - out[0], one - out[1]]
        return out


def floats(matrix):
    return np.array(matrix.tolist(), float)


class Scan:
    """The whole response in floats: values and slopes, in order of time, and the bumps between."""

    def __init__(self, loop, count):
        self.loop = loop
        z = floats(loop.start).T
        for i in range(count.bit_length()):
            step = floats(loop.powers[i])
            loop.powers += [loop.powers[i] * loop.powers[i]] if i + 1 == len(loop.powers) else []
            z = np.concatenate([z, z @ step.T])
        z = z[:count]
        self.places = [(p, t) for p, ts in enumerate(loop.points) for t in ts]
        pairs = [loop.rows(p, t) for p, t in self.places]
        self.y = z @ np.array([a for a, _ in pairs]).T
        slope = z @ np.array([b for _, b in pairs]).T
        self.u = z @ floats(loop.u)[0]
        pairs = list(pairwise(self.places))
        h = np.array([float(t2 - t) for (_, t), (_, t2) in pairs])
        one_piece = np.array([p == p2 for (p, _), (p2, _) in pairs])
        s, s2 = slope[:, :-1], slope[:, 1:]
        with np.errstate(divide="ignore", invalid="ignore"):
            top = np.where(s * s2 < 0, s / (s - s2), 0.0)
        about = self.y[:, :-1] + h * (s * top + (s2 - s) * top * top / 2)
        self.turns = (s * s2 < 0) & one_piece
        self.about = np.where(self.turns, about, self.y[:, :-1])

    def bump(self, k, j):
        """Return (k, p, t) of the top or bottom between place j and the next."""
        p, t = self.places[j]
        top = solve(lambda x: self.loop.at(k, p, x, slope=True), t, self.places[j + 1][1])
        return k, p, top

    def extreme(self, sign):
        """Return (value, time) of the largest sign * y."""
        k, j = np.unravel_index(np.argmax(sign * self.y), self.y.shape)
        best = sign * self.y[k, j]
        found = [(sign * self.loop.at(k, *self.places[j]), self.loop.time(k, *self.places[j]))]
        likely = self.turns & (sign * self.about > best - 1e-6 * abs(best) - 1e-12)
        rows = np.argwhere(likely)
        if len(rows) > 40:
            raise Disputed
        for k, j in rows:
            spot = self.bump(k, j)
            found.append((sign * self.loop.at(*spot), self.loop.time(*spot)))
        return max(found)

    def ordered(self):
        """Return y and the bumps' tops in order of time, shape (K, 2 places - 1)."""
        both = np.empty((len(self.y), 2 * len(self.places) - 1))
        both[:, 0::2], both[:, 1::2] = self.y, self.about
        return both

    def crossing(self, flat, width, level):
        """Return the time at which y crosses a level just before the flat index."""
        ends = []
        for i in (flat - 1, flat):
            k, j = divmod(i, width)
            ends.append((k, j // 2) if j % 2 == 0 or not self.turns[k, j // 2] else (k, j / 2))
        (k, j), (k2, j2) = ends
        if k != k2 or self.places[int(j)][0] != self.places[int(j2)][0]:
            raise Disputed  # on the seam of two pieces
        p = self.places[int(j2)][0]
        a, b = (self.places[int(x)][1] if x == int(x) else self.bump(k, int(x))[2] for x in (j, j2))
        return self.loop.time(k, p, solve(lambda x: self.loop.at(k, p, x) - level, a, b))


class Disputed(Exception):
    """A loop that is left out."""


def solve(f, a, b):
    """Return the zero of f between a and b: secants, and halves where they leave the bracket."""
    a, b = mpf(a), mpf(b)
    fa, fb = f(a), f(b)
    x, fx, old, f_old, width = a, fa, b, fb, b - a
    while fx and abs(x - old) > mpf(10) ** -50 * width:
        turn = (fx - f_old) / (x - old)
        new = x - fx / turn if turn else a
        if not a < new < b or abs(new - x) > (b - a) / 2:
            new = (a + b) / 2
        old, f_old, x = x, fx, new
        fx = f(x)
        if fa * fx <= 0:
            b, fb = x, fx
        else:
            a, fa = x, fx
    return x


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
