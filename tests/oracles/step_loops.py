"""The closed loops whose responses are worked out: plants of order 1 to 6 under drawn gains.

Resonances, unstable plants, stiff and slow modes, right-hand zeros; sample times from 1e-5 to
1 of the plant's time scale; dead time and compute delay of whole samples and of fractions.
"""

import random

from truth_hold import SENSOR, polynomial

PLANTS = [
    # name, num, den, sensor, time scale in s
    ("arm", [2.3], [1.0, 0.7809, 0.0], SENSOR, 1.0),
    ("double integrator", [1.0], [1.0, 0.0, 0.0], 1.0, 1.0),
    ("lag", [2.0], [1.0, 0.5], 1.0, 1.0),
    ("lag upside down", [-2.0], [1.0, 0.5], 1.0, 1.0),
    ("two lags", [3.0], [1.0, 3.0, 2.0], 1.0, 1.0),
    ("zero on the right", [-0.5, 2.0], [1.0, 2.5, 2.0], 1.0, 1.0),
    ("resonance", [9.0], [1.0, 0.9, 9.0], 1.0, 1.0),
    ("light resonance", [400.0], [1.0, 0.8, 400.0], 1.0, 0.3),
    ("unstable lag", [1.5], [1.0, -0.5], 1.0, 1.0),
    ("pendulum", [3.0], [1.0, 0.2, -9.81], 1.0, 0.3),
    ("fast motor", [4000.0], [1.0, 50.0, 0.0], 1.0, 0.02),
    ("zero and three poles", [4.0, 8.0], [1.0, 4.0, 6.0, 0.0], 1.0, 1.0),
    ("elastic joint", [50.0, 400.0], [1.0, 6.0, 900.0, 0.0], 1.0, 0.5),
    ("two resonances", [1.0, 0.4, 30.0], polynomial([(-0.5, 3.0), (-0.3, 8.0)]), 1.0, 1.0),
    ("four lags", [24.0], polynomial([-1.0, -2.0, -3.0, -4.0]), 1.0, 2.0),
    ("stiff", [500.0], polynomial([-1.0, -500.0]), 1.0, 1.0),
    ("stiff and slow", [10.0, 0.2], polynomial([-0.01, -1.0, -200.0]), 1.0, 1.0),
    ("stiff resonance", [9e4], polynomial([-1.0, (-40.0, 300.0)]), 1.0, 1.0),
    ("five poles", [60.0, 90.0], polynomial([-1.0, -1.5, -5.0, (-2.0, 4.0)]), 1.0, 1.5),
    ("six poles", [720.0], polynomial([-1.0, -2.0, -3.0, -4.0, -5.0, -6.0]), 1.0, 3.0),
    ("six with an integrator", [200.0, 500.0],
     polynomial([0.0, -2.0, -3.0, -8.0, (-3.0, 9.0)]), 1.0, 1.5),
]  # fmt: skip

SHARES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 1e-3, 1e-4, 1e-5)
DELAYS = ((0.0, 0.0), (0.0, 0.4), (0.7, 0.0), (1.3, 0.5), (6.25, 0.0))
TRIES = 60


def candidates(name, num, den, sensor, scale):
    """Yield loops of one plant with drawn gains; most are unstable or slow and fall through."""
    rng = random.Random(name)
    for share in SHARES:
        # the smallest sample times are long to work out
        for dead, compute in rng.sample(DELAYS, 2 if share > 3e-3 else 1):
            dt = share * scale
            for _ in range(TRIES):
                yield {
                    "name": f"{name}, dt {dt:g}, dead {dead:g} dt, compute {compute:g} dt",
                    "num": num, "den": den, "sensor": sensor, "dead_time": dead * dt,
                    "compute_delay": compute * dt, "dt": dt,
                    "reference": 1.0 if rng.random() < 0.7 else 2.5,
                    "controller": controller(rng, num, den, sensor, scale, dt),
                }  # fmt: skip


def controller(rng, num, den, sensor, scale, dt):
    """Return a P, PI, PD or PID whose gain is of the size that the plant's asks for."""
    at_rest = num[-1] / den[-1] if den[-1] else num[-1] / den[-2] * scale if den[-2] else num[-1]
    kp = 10 ** rng.uniform(-1.5, 1.0) / (abs(at_rest) * sensor)
    if at_rest < 0 and den[-1] > 0:
        kp = -kp
    kd = kp * scale * rng.choice([0.0, 0.2, 0.6, 1.2]) * (dt > 1e-3 * scale)
    return pid(kp, kp / scale * rng.choice([0.0, 0.1, 0.5, 1.0]), kd, dt)


def pid(kp, ki, kd, dt):
    """Return num, den of kp + ki dt z/(z-1) + kd (z-1)/(dt z), as short as they come."""
    if not ki:
        return [[kp + kd / dt, -kd / dt], [1.0, 0.0]] if kd else [[kp], [1.0]]
    if not kd:
        return [[kp + ki * dt, -kp], [1.0, -1.0]]
    d = kd / dt
    return [[kp + ki * dt + d, -kp - 2 * d, d], [1.0, -1.0, 0.0]]
