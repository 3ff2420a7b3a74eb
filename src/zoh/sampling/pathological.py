"""Pathological sampling: the modes that a hold hides at a dt at which they look like others.

Poles s_i and s_j of a plant become the poles exp(s_i dt) and exp(s_j dt) of the sampled one. Where
these are one although s_i and s_j are two,

    (s_i - s_j) dt = 2 pi k j,    k = 1, 2, ...

a zero of the hold is on it: of the two modes only a sum is moved and seen at the samples, and
feedback leaves the rest of them as it is. A mode is hidden beside its own conjugate where
w dt is a multiple of pi. Next to such a dt the zero is next to the pole, and what would move the
mode are gains out of all proportion.
Source: R. E. Kalman, Y. C. Ho, K. S. Narendra, Controllability of Linear Dynamical Systems,
Contributions to Differential Equations 1(2), 1963; K. J. Astrom and B. Wittenmark,
Computer-Controlled Systems, 3rd ed., ch. 3 (loss of reachability and observability by sampling).
"""

from functools import lru_cache
from math import inf, tau

from zoh.lti import poly
from zoh.lti.poly import Poly
from zoh.lti.systems import Plant

_NEAR = 1e-3  # between two poles in z that are told of, of their size: a thousandth of the mode is
# left to be moved and seen, and the frequency of few machines is known to more digits than that
_GONE = -7.0  # s dt; a mode of which a sample leaves a thousandth is not missed
_SLOW = 3.0  # rad a sample; a mode that turns by less than half a turn is like no other
_SAFE = 2.0  # rad a sample, well below half a turn


def hidden_by_hold(plant: Plant, dt: float) -> tuple[str, ...]:
    """Return a sentence on each mode that the hold all but hides; mostly there is none.

    >>> hidden_by_hold(Plant(num=[1], den=[1, 0, 1]), dt=3.14)
    ()
    >>> said, = hidden_by_hold(Plant(num=[1], den=[1, 0, 1]), dt=3.1415)
    >>> said.partition(":")[0]
    'the hold at dt = 3.1415 s all but hides the mode at 1 rad/s'
    """
    return _hidden(plant.den, dt)


@lru_cache(maxsize=64)
def _hidden(den: Poly, dt: float) -> tuple[str, ...]:
    """Return ``hidden_by_hold`` of a plant with this denominator."""
    # no pole is larger than twice the largest of these (Fujiwara)
    reach = max([abs(c / den[0]) ** (1 / i) for i, c in enumerate(den) if i], default=0.0)
    if not _SLOW <= 2 * reach * dt < inf:
        return ()
    poles = [complex(s) for s in poly.roots(den).tolist() if s.imag > 0]
    alive = sorted([s for s in poles if s.real * dt > _GONE], key=_frequency)
    found: dict[str, str] = {}  # a mode that is repeated is named once
    for i, s in enumerate(alive):
        turns, off = _turns(2j * s.imag * dt)
        if turns and off < _NEAR:
            mode = f"the mode at {s.imag:.6g} rad/s"
            found[mode] = f"w dt is {_pi(turns, off / 2)}"
        for t in alive[:i]:
            if abs(s - t) * dt < _NEAR:  # one mode, repeated: it is named by itself
                continue
            between = f"one of the modes at {t.imag:.6g} and {s.imag:.6g} rad/s"
            for word, other in (("difference", t), ("sum", t.conjugate())):
                turns, off = _turns((s - other) * dt)
                if turns and off < _NEAR:
                    found[between] = f"the {word} of w dt is {_pi(2 * turns, off)}"
    if not found:
        return ()
    way_out = (
        f"choose another dt (below {_SAFE / max(map(_frequency, poles)):.3g} s none is hidden)"
    )
    return tuple([
        f"the hold at dt = {dt:.6g} s all but hides {mode}: {why}, and feedback moves and sees next"
        f" to nothing of it; {way_out}" for mode, why in found.items()
    ])  # fmt: skip


def _turns(apart: complex) -> tuple[int, float]:
    """Return (k, |apart - 2 pi k j|) of the whole turns that two poles are apart in a sample."""
    k = round(apart.imag / tau)
    return k, abs(apart - tau * k * 1j)


def _pi(times: int, off: float) -> str:
    """Return that many pi in words, and how far off.

    >>> _pi(1, 0.00012), _pi(2, 1e-16)
    ('pi but for 0.0001 rad', '2 pi to twelve digits')
    """
    said = "pi" if times == 1 else f"{times} pi"
    return f"{said} to twelve digits" if off < 1e-12 * times else f"{said} but for {off:.1g} rad"


def _frequency(s: complex) -> float:
    return s.imag
