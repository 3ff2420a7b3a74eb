"""How well a loop carries a load: the integral of its absolute error (IAE) after a load step.

The load is a step of 1 at the plant's input, behind its dead time; the error is taken at the
samples, dt sum |y(k)|, and is finite with an integrator in the controller. Where y keeps its
sign it is 1/ki, whatever the plant, because u must come to -1.
Source: K. J. Astrom and T. Hagglund, Advanced PID Control, sec. 4.2 (IAE and IE of a load step).
"""

from math import ceil, inf

import numpy as np

from zoh.analysis.closed import closed_loop
from zoh.lti.systems import Plant, Sampled

_REST = 30.0  # exp(-30) of the slowest mode is 1e-13: the rest adds nothing that is asked for
_MOST = 200_000  # samples followed
_CHUNK = 4096


def load_iae(plant: Plant, controller: Sampled, compute_delay: float = 0.0) -> float:
    """Return dt sum |y(k)| in output units times s, y in the sensor's units; inf without an end.

    The loop must be stable. One that takes more than 200 000 samples to come to rest, or stands
    behind more than 64 samples of delay, is not followed and has inf as well.

    >>> plant, c = Plant(num=[1], den=[1, 1]), Sampled.from_w(num_w=[1, 1], den_w=[1, 0], dt=0.1)
    >>> round(load_iae(plant, c), 12)  # (w + 1)/w, y keeps its sign: 1/ki
    1.0
    """
    if controller.den_w[-1] != 0:
        return inf
    motion = closed_loop(plant, controller, compute_delay, "disturbance")
    slowest = min(rate for rate, _ in motion.rates())
    if motion.wait or not slowest * _MOST > _REST:
        return inf
    total, state = 0.0, motion.start
    for _ in range(ceil(_REST / slowest / _CHUNK)):
        states = motion.run(state, _CHUNK + 1)
        total += float(np.abs(motion.output @ states[:, :-1]).sum())
        state = states[:, -1]
    return total * motion.dt
