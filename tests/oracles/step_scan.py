"""Where the extremes and crossings of a whole response are: floats look, digits close in."""

from itertools import pairwise

import numpy as np
from mpmath import mpf
from step_motion import floats


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
