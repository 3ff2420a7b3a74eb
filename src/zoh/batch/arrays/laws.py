"""The laws of ``zoh.design``, solved for many crossovers at once.

Everything is in p = w dt/2, so that v dt/2 = tan(wc dt/2) =: x. The formulas are those of the
design modules, which name their sources; a law that cannot be solved gives no gains and says so.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi

import numpy as np
import numpy.typing as npt

from zoh.analysis.realised import realised
from zoh.batch.tolerances import SAME_TURN
from zoh.lti.systems import Sampled

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """What a law must do at the crossover, one entry a loop.

    size, theta  |G| there, and the phase in (-pi, pi] that the law must give
    x            tan(wc dt/2);  dt  s
    """

    size: Array
    theta: Array
    x: Array
    dt: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Solved:
    """num, den in p, rows of ascending powers; the gains by name.

    moves   of the same controller at the samples, shape (c, c, B): x moves by moves x + enters e
            + leads (what e moves by), x = leads e at first, u = residues x + direct e;  enters,
            leads, residues have the shape (c, B)
    room    rad, how far the phase needed is inside what the law can give; below 0 outside
    """

    num: Array
    den: Array
    direct: Array
    moves: Array
    enters: Array
    leads: Array
    residues: Array
    gains: Mapping[str, Array]
    room: Array

    @classmethod
    def of_poles(
        cls, *, num: Array, den: Array, direct: Array, poles: Array, residues: Array,
        gains: Mapping[str, Array], room: Array, led: Mask | None = None,
    ) -> "Solved":  # fmt: skip
        """Return what is direct + sum residues/(z - 1 + poles) at the samples.

        Those that are ``led``, shape (c,), are residues (z - 1)/(z - 1 + poles) instead: what a
        lead adds to its gain at rest. As the difference of a large direct part and what is nearly
        as large, that would be rounding alone where the loop is far below Nyquist's frequency.
        """
        moves = np.zeros((len(poles), len(poles), len(direct)))
        for j, pole in enumerate(poles):
            moves[j, j] = -pole
        leads = np.zeros_like(residues)
        if led is not None:
            leads[led] = 1.0
        return cls(
            num=num, den=den, direct=direct, moves=moves, enters=1.0 - leads, leads=leads,
            residues=residues, gains=gains, room=room,
        )  # fmt: skip


def wanted(g: npt.NDArray[np.complex128], pm_deg: Array, x: Array, dt: Array) -> Wanted:
    """Return what makes up the gain and the margin of the plant's complex gains ``g``."""
    turn = np.radians(pm_deg - 180.0) - np.angle(g)
    theta = turn - 2 * pi * np.round(turn / (2 * pi))
    return Wanted(size=np.abs(g), theta=theta, x=x, dt=dt)


def p(at: Wanted, _: Mapping[str, Array]) -> Solved:
    """Return kp = 1/|G| where the plant alone has the margin."""
    kp = 1 / at.size
    none = np.zeros((0, len(kp)))
    return Solved.of_poles(
        num=kp[None, :], den=np.ones((1, len(kp))), direct=kp, poles=none, residues=none,
        gains={"kp": kp}, room=SAME_TURN - np.abs(at.theta),
    )  # fmt: skip


def pi_(at: Wanted, _: Mapping[str, Array]) -> Solved:
    """Return kp = cos(theta)/|G|, ki = -v sin(theta)/|G|; 1/p is 1 + 2/(z - 1)."""
    kp, share = np.cos(at.theta) / at.size, -at.x * np.sin(at.theta) / at.size
    return Solved.of_poles(
        num=np.stack([share, kp]),
        den=np.stack([np.zeros_like(kp), np.ones_like(kp)]),
        direct=kp + share,
        poles=np.zeros((1, len(kp))),
        residues=2 * share[None, :],
        gains={"kp": kp, "ki": share * (2 / at.dt)},
        room=np.minimum(at.theta + pi / 2, -at.theta),
    )


def pd(at: Wanted, given: Mapping[str, Array]) -> Solved:
    """Return the PID of no integral gain."""
    found = pid(at, {**given, "ki": np.zeros_like(at.size)})
    gains = {name: gain for name, gain in found.gains.items() if name != "ki"}
    return Solved(
        num=found.num[1:], den=found.den[1:], direct=found.direct, moves=found.moves[1:, 1:],
        enters=found.enters[1:], leads=found.leads[1:], residues=found.residues[1:], gains=gains,
        room=found.room,
    )  # fmt: skip


def pid(at: Wanted, given: Mapping[str, Array]) -> Solved:
    """Return kp, kd of the given ki; the filter's pole is ``filter_pole``, or 2/dt.

    With c = 1/(1 + lag), p/(1 + lag p) is c (z - 1)/(z - 1 + 2 c).
    """
    ki, half = given["ki"], at.dt / 2
    lag = 1 / (given["filter_pole"] * half) if "filter_pole" in given else np.ones_like(half)
    x, share = at.x * lag, ki * half  # ki/w is share/p
    cos, sin = np.cos(at.theta), np.sin(at.theta)
    k = share * at.size / at.x
    reach = x * k / np.hypot(1.0, x)
    with np.errstate(invalid="ignore"):
        low = np.where(k < 1, -np.arcsin(k), -pi)
        bend = np.arccos(reach) - np.arctan(x)
    low = np.maximum(low, -np.arccos(np.minimum(reach, 1.0)) - np.arctan(x))
    imaginary = sin / at.size + share / at.x
    kp, rate = cos / at.size - x * imaginary, imaginary * (1 + x * x) / at.x
    c = 1 / (1 + lag)
    return Solved.of_poles(
        num=np.stack([share, kp + share * lag, kp * lag + rate]),
        den=np.stack([np.zeros_like(kp), np.ones_like(kp), lag]),
        direct=kp + share,
        poles=np.stack([np.zeros_like(kp), 2 * c]),
        residues=np.stack([2 * share, rate * c]),
        led=np.array([False, True]),
        gains={"kp": kp, "ki": ki, "kd": rate * half, "filter_pole": 1 / (lag * half)},
        room=np.where(reach < 1, np.minimum(at.theta - low, bend - at.theta), -1.0),
    )


def lag(at: Wanted, given: Mapping[str, Array]) -> Solved:
    """Return the lag of this gain at w = 0."""
    ratio = given["dc_gain"] * at.size
    with np.errstate(invalid="ignore"):
        inside = np.minimum(at.theta + np.arccos(1 / ratio), -at.theta)
    return _section(at, given["dc_gain"], np.where(ratio > 1, inside, -1.0), led=False)


def lead(at: Wanted, given: Mapping[str, Array]) -> Solved:
    """Return the lead of this gain at w = 0."""
    ratio = given["dc_gain"] * at.size
    with np.errstate(invalid="ignore"):
        inside = np.minimum(at.theta, np.arccos(ratio) - at.theta)
    return _section(at, given["dc_gain"], np.where(ratio < 1, inside, -1.0), led=True)


def _section(at: Wanted, dc_gain: Array, room: Array, led: bool) -> Solved:
    """Return a0 (1 + p/z)/(1 + p/q): with c = 1/(1 + 1/q), h + (a0 - h) 2 c/(z - 1 + 2 c).

    Or, ``led``, a0 + (h - a0) (z - 1)/(z - 1 + 2 c): the smaller part is the direct one.
    """
    ratio, turn = dc_gain * at.size, at.x * np.sin(at.theta)
    with np.errstate(divide="ignore", invalid="ignore"):
        zero, pole = turn / (1 / ratio - np.cos(at.theta)), turn / (np.cos(at.theta) - ratio)
        num = np.stack([dc_gain, dc_gain / zero])
        den = np.stack([np.ones_like(pole), 1 / pole])
        c = 1 / (1 + den[1])
        far = (num[0] + num[1]) * c
    rate = 2 / at.dt
    return Solved.of_poles(
        num=num, den=den, direct=dc_gain if led else far, poles=2 * c[None, :],
        residues=(far - dc_gain if led else (dc_gain - far) * 2 * c)[None, :],
        led=np.array([led]),
        gains={"dc_gain": dc_gain, "w0": zero * rate, "wp": pole * rate}, room=room,
    )  # fmt: skip


def given(controller: Sampled, count: int) -> Solved:
    """Return ``count`` times a controller that was made elsewhere; the same equation at any dt.

    num_w and den_w have powers of w = p (2/dt), whatever dt was.
    """
    rate = 2 / controller.dt
    a, c, direct = realised(controller)
    powers = rate ** np.arange(float(len(controller.den_w)))
    num, den = (np.array(w[::-1]) * powers for w in (controller.num_w, controller.den_w))
    n = len(a)
    moves, enters = np.zeros((n, n)), np.zeros(n)
    if n:
        moves[1:] = np.eye(n)[:-1]
        moves[0] = -np.array(a)
        enters[0] = 1.0

    def many(x: Array) -> Array:
        return np.repeat(x[..., None], count, axis=-1)

    return Solved(
        num=many(num), den=many(den), direct=np.full(count, direct), moves=many(moves),
        enters=many(enters), leads=many(np.zeros(n)), residues=many(np.array(c)), gains={},
        room=np.ones(count),
    )  # fmt: skip


LAWS: Mapping[str, Callable[[Wanted, Mapping[str, Array]], Solved]] = {
    "p": p, "pi": pi_, "pd": pd, "pid": pid, "lag": lag, "lead": lead,
}  # fmt: skip
"""Every law of a batch, by name."""
