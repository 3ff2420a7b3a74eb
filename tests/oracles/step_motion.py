"""A sampled loop as powers of the closed loop's matrix, at many digits.

The matrix holds exp(A t), with the dead time splitting a sample interval in two, and the
difference equation as it is written.
"""

import numpy as np
from mpmath import mp, mpf
from scipy.linalg import expm
from truth_hold import companion, hold_matrices, whole_and_rest


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
