"""The open loops whose margins are worked out: named ones, robots, and random ones by seed.

A spec has a form: "z" (num, den: the floats are the loop, exactly), "w" (num_w, den_w, delay),
"plant" (a continuous plant held and sampled, times a controller given in w), or "s".
"""

import random
from fractions import Fraction

from mpmath import mp
from truth_hold import SENSOR, convolve, exact_hold, polynomial

NAMED = [
    # name, num, den, dt
    ("gain margin 17 at Nyquist", [0.11], [1.0, -0.9], 0.1),
    ("gain margin 1.5 at Nyquist", [1.0], [1.0, -0.5], 1.0),
    ("beyond its gain margin", [2.0], [1.0, -0.5], 1.0),
    ("integrator", [0.5], [1.0, -1.0], 0.2),
    ("double integrator with lead", [0.9, -0.8], [1.0, -2.0, 1.0], 0.1),
    ("double integrator alone", [0.005, 0.005], [1.0, -2.0, 1.0], 0.1),
    ("triple integrator with leads", [0.9, -1.6, 0.75], [1.0, -3.0, 3.0, -1.0], 0.1),
    ("unstable pole held", [0.5], [1.0, -1.2], 0.5),
    ("unstable pole, too little gain", [0.15], [1.0, -1.2], 0.5),
    ("pole at -1", [0.3], [1.0, 1.0], 1.0),
    ("poles at +1 and -1", [0.1, 0.05], [1.0, 0.0, -1.0], 1.0),
    ("double pole at -1", [0.02, 0.03], [1.0, 2.0, 1.0], 0.5),
    ("one sample of delay", [0.11], [1.0, -0.9, 0.0], 0.1),
    ("five samples of delay", [0.13], [1.0, -0.9, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1),
    ("integrator and ten samples", [0.02], [1.0, -1.0] + [0.0] * 10, 0.1),
    ("negative gain", [-0.2], [1.0, -0.9], 0.1),
    ("negative gain, unstable", [-2.0], [1.0, -0.9], 0.1),
    ("negative gain, integrator", [-0.2], [1.0, -1.0], 0.1),
    ("all of it below one", [0.05], [1.0, -0.9], 0.1),
    ("all of it above one", [3.0, 0.5], [1.0, 0.2], 0.1),
    ("constant above one", [2.0], [1.0], 0.1),
    ("constant below one", [0.4], [1.0], 0.1),
    ("constant, negative", [-0.4], [1.0], 0.1),
    ("resonance over one", [0.011, 0.013], [1.0, -1.6, 0.98], 0.1),
    ("thin resonance", [1e-3, 1e-3], [1.0, -1.2, 0.9998], 0.01),
    ("thinner resonance", [1e-5, 2e-5], [1.0, -1.2, 0.999998], 0.01),
    ("notch beside a resonance", [0.1, -0.12, 0.0999], [1.0, -2.1, 2.0799, -0.97902], 0.01),
    ("zero outside", [-0.05, 0.2], [1.0, -1.5, 0.56], 0.1),
    ("unstable pair", [0.5, -0.4], [1.0, -2.1, 1.15], 0.1),
    ("finite impulse response", [0.25, 0.25, 0.25], [1.0, 0.0, 0.0, 0.0], 0.1),
    ("slow and fast", [1e-4], [1.0, -1.1, 0.1 + 1e-7], 1e-3),
    ("zero at Nyquist", [0.1, 0.1], [1.0, -1.3, 0.4], 0.1),
    ("zero at +1", [0.4, -0.4], [1.0, -0.3, 0.1], 0.1),
    ("shared factor", [0.14, -0.07], [1.0, -1.4, 0.45], 0.1),
    ("shared unstable factor", [0.125, -0.15], [1.0, -2.1, 1.08], 0.1),
    ("conditionally stable", [0.5, -0.9, 0.41], [1.0, -3.0, 3.0, -1.0], 0.1),
]

ROBOTS = [
    # name, num_s, den_s, sensor, dead time, kp, ki, kd
    ("arm PID", [2.3], [1.0, 0.7809, 0.0], SENSOR, 0.0, 23.4, 0.85, 5.8),
    ("arm PI", [2.3], [1.0, 0.7809, 0.0], SENSOR, 0.0, 2.9, 0.1, 0.0),
    ("arm P, dead time", [2.3], [1.0, 0.7809, 0.0], SENSOR, 0.013, 5.0, 0.0, 0.0),
    ("axis PID", [40.0], [1.0, 12.0, 0.0], 1.0, 0.0, 20.0, 30.0, 0.4),
    ("stage PD", [1.0], [1.0, 0.0, 0.0], 1.0, 0.0, 9.0, 0.0, 4.2),
    ("stage PID, dead time", [1.0], [1.0, 0.0, 0.0], 1.0, 0.027, 9.0, 2.0, 4.2),
    ("elastic joint P", [50.0], [1.0, 0.6, 900.0, 0.0], 1.0, 0.0, 4.0, 0.0, 0.0),
    ("motor speed PI", [1200.0], [1.0, 130.0, 2200.0], 1.0, 0.0, 0.8, 9.0, 0.0),
    ("pendulum PID", [3.0], [1.0, 0.2, -9.81], 1.0, 0.0, 12.0, 4.0, 3.0),
]


def sampled_loops():
    for name, num, den, dt in NAMED:
        yield {"name": name, "form": "z", "num": num, "den": den, "dt": dt}
    yield from robots()
    yield from random_loops()


def robots():
    for name, num, den, sensor, dead, kp, ki, kd in ROBOTS:
        for dt in (0.3, 0.1, 0.01, 1e-3, 1e-4, 1e-5):
            if dead and dead / dt > 60:
                continue
            top = [kp * dt / 2 + kd, kp + ki * dt / 2, ki]
            bottom = [dt / 2, 1.0, 0.0]
            if not ki:
                top, bottom = top[:-1], bottom[:-1]
            _, _, num_w, den_w, m = exact_hold(num, den, sensor, dt, dead, digits=80)
            held = [as_fractions(a) for a in (num_w, den_w)]
            given = [[Fraction(c) for c in a] for a in (top, bottom)]
            exact = [convolve(a, b) for a, b in zip(held, given, strict=True)]
            truth = {"truth_num_w": exact[0], "truth_den_w": exact[1], "delay": m}
            base = {"name": f"{name}, dt {dt:g}", "dt": dt}
            yield (
                base
                | truth
                | {
                    "form": "plant",
                    "plant": [num, den, dead, sensor],
                    "controller_w": [top, bottom],
                }
            )
            if dt in (0.1, 1e-3, 1e-5):  # the same loop as rounded coefficients, in w and in z
                given = [[float(c) for c in a] for a in exact]
                yield base | {
                    "form": "w", "num_w": given[0], "den_w": given[1], "delay": m,
                    "truth_num_w": given[0], "truth_den_w": given[1],
                }  # fmt: skip


def as_fractions(values):
    return [Fraction(mp.nstr(v, 90)) for v in values]


def random_roots(rng, n, radius):
    out = []
    while n > 0:
        if n > 1 and rng.random() < 0.5:
            r, turn = radius(), rng.uniform(0.05, 3.1)
            out.append((r * mp.cos(turn), r * mp.sin(turn)))
            n -= 2
        else:
            out.append(radius() * rng.choice([1, 1, 1, -1]))
            n -= 1
    return [tuple(map(float, r)) if isinstance(r, tuple) else float(r) for r in out]


def random_loops(count=110):
    rng = random.Random(1909)
    for i in range(count):
        n = rng.randint(1, 7)
        kind = rng.choice(["plain", "plain", "edge", "unstable"])
        radius = {
            "plain": lambda: rng.uniform(0.1, 0.99),
            "edge": lambda: 1 - 10 ** rng.uniform(-5, -1),
            "unstable": lambda: rng.uniform(0.5, 1.3),
        }[kind]
        poles = random_roots(rng, n, radius)
        if rng.random() < 0.4:
            poles = [1.0, *random_roots(rng, n - 1, radius)]
        zeros = random_roots(rng, rng.randint(0, n), lambda: rng.uniform(0.1, 1.5))
        gain = 10 ** rng.uniform(-3, 0.5) * rng.choice([1, 1, 1, -1])
        num = [float(gain * c) for c in polynomial(zeros)]
        yield {
            "name": f"random {i}, {kind}",
            "form": "z",
            "num": num,
            "den": [float(c) for c in polynomial(poles)],
            "dt": rng.choice([1.0, 0.1, 0.01, 1e-3]),
        }


CONTINUOUS = [
    ("gain margin 6", [1.0], [1.0, 3.0, 2.0, 0.0]),
    ("three equal lags", [10.0], [1.0, 3.0, 3.0, 1.0]),
    ("three equal lags, stable", [5.0], [1.0, 3.0, 3.0, 1.0]),
    ("integrator", [10.0], [1.0, 0.0]),
    ("double integrator with lead", [2.0, 1.0], [1.0, 0.0, 0.0]),
    ("triple integrator with leads", [5.0, 10.0, 5.0], [1.0, 0.0, 0.0, 0.0]),
    ("conditionally stable", [20.0, 40.0, 20.0], [1.0, 5.0, 0.0, 0.0, 0.0]),
    ("lead at high frequency", [3.0, 30.0], [1.0, 2.0]),
    ("zero on the right", [-0.01, 0.1], [1.0, 3.0, 2.0]),
    ("all pass", [-1.0, 2.0], [2.0, 5.0]),
    ("unstable lag held", [3.0], [1.0, -1.0]),
    ("unstable lag not held", [0.5], [1.0, -1.0]),
    ("negative at zero", [-0.5], [1.0, 2.0, 1.0]),
    ("resonance over one", [0.5], [1.0, 0.02, 1.0, 0.0]),
    ("three gain crossings", [1.2, 0.3, 1.2], [1.0, 0.05, 4.0, 0.0]),
    ("four resonances", [1.0], polynomial([-0.1, (-0.01, 1.0), (-0.02, 2.0), (-0.01, 3.0)])),
    ("stiff", [1e8], polynomial([-0.01, -1e4, -3e4])),
    ("constant", [0.5], [1.0]),
    ("no crossing at all", [0.2], [1.0, 1.0]),
    ("differentiator", [0.3, 0.0], [1.0, 2.0, 4.0]),
    ("arm in s", [2.3 * 12 / 180 * 20], [1.0, 0.7809, 0.0]),
]


def continuous_loops():
    for name, num, den in CONTINUOUS:
        yield {"name": f"s: {name}", "form": "s", "num": num, "den": den}
    rng = random.Random(77)
    for i in range(20):
        n = rng.randint(1, 6)
        poles = [-(10 ** rng.uniform(-2, 2)) for _ in range(n)]
        if rng.random() < 0.5:
            poles.append((-rng.uniform(0.001, 0.5), rng.uniform(0.5, 30)))
        if rng.random() < 0.3:
            poles[0] = 0.0
        if rng.random() < 0.2:
            poles[0] = rng.uniform(0.1, 1)
        count = rng.randint(0, n - 1)
        zeros = [rng.choice([-1, -1, 1]) * 10 ** rng.uniform(-1, 2) for _ in range(count)]
        den, num = polynomial(poles), polynomial(zeros)
        gain = 10 ** rng.uniform(-1, 2) * abs(den[-1] or den[-2]) / abs(num[-1])
        yield {"name": f"s: random {i}", "form": "s", "num": [gain * c for c in num], "den": den}


def dead_time_loops():
    table = [
        ("integrator", [1.0], [1.0, 0.0], 0.1),
        ("integrator, too long", [1.0], [1.0, 0.0], 2.0),
        ("lag", [3.0], [1.0, 1.0], 0.5),
        ("lag, unstable", [5.0], [1.0, 1.0], 0.5),
        ("unstable lag", [2.0], [1.0, -1.0], 0.2),
        ("two lags", [8.0], [1.0, 3.0, 2.0], 0.3),
        ("arm", [2.3 * 12 / 180 * 8], [1.0, 0.7809, 0.0], 0.05),
        ("resonance", [0.3], [1.0, 0.1, 1.0], 1.0),
        ("gain below one", [0.5], [1.0, 1.0], 3.0),
    ]
    for name, num, den, dead in table:
        yield {"name": f"dead time: {name}", "form": "s", "num": num, "den": den, "dead_time": dead}
