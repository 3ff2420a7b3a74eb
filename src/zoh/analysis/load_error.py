"""How well a loop carries a load: the integral of its absolute error (IAE) after a load step.

The load is a step of 1 at the plant's input, behind its dead time; the error is taken at the
samples, dt sum |y(k)|, and is finite with an integrator in the controller. Where y keeps its
sign it is 1/ki, whatever the plant, because u must come to -1.
Source: K. J. Astrom and T. Hagglund, Advanced PID Control, sec. 4.2 (IAE and IE of a load step).
"""

from math import ceil, inf

import numpy as np

from zoh.analysis import queue
from zoh.analysis.closed import closed_loop
from zoh.analysis.motion import Motion
from zoh.lti.systems import Plant, Sampled

_REST = 30.0  # exp(-30) of a mode is 1e-13: the rest adds nothing that is asked for
_MOST = 1_000_000  # samples followed
_CHUNK = 4096


def load_iae(plant: Plant, controller: Sampled, compute_delay: float = 0.0) -> float:
    """Return dt sum |y(k)| in output units times s, y in the sensor's units; inf without an end.

    The loop must be stable. One that swings for more than a million samples is not followed, and
    has inf as well. Once one mode that does not swing is left, y keeps its sign: all of it
    together, ki dt sum y(k) = 1, says what is still to come.

    >>> plant, c = Plant(num=[1], den=[1, 1]), Sampled.from_w(num_w=[1, 1], den_w=[1, 0], dt=0.1)
    >>> round(load_iae(plant, c), 12)  # (w + 1)/w, y keeps its sign: 1/ki
    1.0
    """
    if controller.den_w[-1] != 0:
        return inf
    motion = closed_loop(plant, controller, compute_delay, "disturbance")
    if motion.wait:
        track = queue.track(motion, (0.0, -1.0))
        total = float(np.abs(motion.output @ track.states).sum()) * motion.dt
        return total if track.rests else inf
    count, keeps_sign = _samples(motion)
    if count > _MOST:
        return inf
    states, signed, total = motion.from_start(_CHUNK + 1), 0.0, 0.0
    for i in range(ceil(count / _CHUNK)):
        states = motion.run(states[:, -1], _CHUNK + 1) if i else states
        y = motion.output @ states[:, :-1]
        signed, total = signed + float(y.sum()), total + float(np.abs(y).sum())
    whole = controller.den_w[-2] / controller.num_w[-1]  # 1/ki
    to_come = abs(whole - signed * motion.dt) if keeps_sign else 0.0
    return total * motion.dt + to_come


def _samples(motion: Motion) -> tuple[float, bool]:
    """Return how many samples to follow, and whether y keeps its sign after them."""
    rates = sorted(motion.rates()) or [(inf, inf)]
    decay, turn = rates[0]
    at_rest = _REST / decay if decay > 0 else inf
    ahead = rates[1][0] - decay if len(rates) > 1 else inf
    alone = _REST / ahead if decay == turn and ahead > 0 else inf
    return min(at_rest, alone), alone < at_rest
