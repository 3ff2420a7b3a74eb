"""Does a tabled loop encircle -1? Counted on the table, or said to be undecided.

With P unstable poles and k integrators in the open loop and Z unstable poles in the closed one,
1 + L turns from w = 0+ to the top of the axis by

    pi (P - Z) + k pi/2

The turn inside the table is added up from point to point. Outside it two things are taken for
granted, and said: what ``Path`` has below and above the table, and how many poles are unstable.

What a zero hides in the open loop does not turn 1 + L, and stays a pole of the closed one. At w = 0
it is on the boundary, and what the plant has there is shown by its low end.
Source: K. J. Astrom and R. M. Murray, Feedback Systems, 2nd ed., sec. 10.2 (Nyquist's criterion
in general, with poles on the axis passed on the right).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, pi

import numpy as np

from zoh.analysis.tabled.path import Path, at_rest, boundary_poles, quiet_below, settled
from zoh.lti.curve import Array
from zoh.lti.poly import ComplexArray
from zoh.lti.systems import Plant

_SIGMAS = 3.0  # of the noise: nearer to -1 than this, either side is possible
_SIDE_DEG = 0.5  # nearer to -180 deg than this, no analyser tells the sides apart
_LOUD = 0.5  # |L| above this can reach -1 within a cell by a resonance of a factor of two
_SURE_DEG = 60.0  # a cell that turns by more may hide a resonance that turns it the other way
_STEP = 0.5  # rad; the path is refined until no step of 1 + L turns by more
_WHOLE = 0.1  # of the count from a whole number, where the path begins and ends far out


@dataclass(frozen=True, slots=True, kw_only=True)
class Count:
    """Unstable closed-loop poles, None where the table does not decide; and in words why.

    hidden  what hides a pole at w = 0, in words, "" where nothing does; then ``unstable`` is how
            many are hidden, and there may be others
    """

    unstable: int | None
    why: str
    hidden: str = ""


def count(path: Path) -> Count:
    """Return how many closed-loop poles are unstable, if the plant has those it is said to."""
    integrators, unstable = boundary_poles(path.controller)
    hidden = _hidden(path)
    if hidden is not None:  # whatever the turns
        return hidden
    open_loop = path.table.unstable_poles + unstable
    doubt = _blurred(path) or _unseen_above(path) or _unseen_below(path)
    if doubt:
        return Count(unstable=None, why=doubt)
    if path.low is not None:
        integrators += path.low.integrators
    z = open_loop + max(integrators, 0) / 2 - _turn(path) / pi
    if abs(z - round(z)) > _WHOLE:
        why = "the turns of 1 + L around 0 do not add up to a whole number"
        return Count(unstable=None, why=why)
    if round(z) < 0:
        why = f"it turns around -1 as only a loop with {-round(z)} more unstable poles does"
        return Count(unstable=None, why=f"{why} than the {open_loop} given")
    return Count(unstable=round(z), why=_granted(path))


def agreed(path: Path, coarser: Sequence[Path]) -> Count:
    """Return the count, undecided where the points left out in ``coarser`` might change it.

    By Rouche's theorem they cannot where the loop moves less than its distance from -1.
    """
    found = count(path)
    if found.unstable is None or found.hidden:
        return found
    exact = path.table.at(path.w)
    for other in coarser:
        moved = np.abs(path.gain) * np.abs(other.table.at(path.w) / exact - 1)
        far = moved >= np.abs(1 + path.gain)
        if far.any():
            at = path.w[int(np.argmax(far))]
            why = f"without every second point it may pass -1 on the other side at {at:.6g} rad/s"
            return Count(unstable=None, why=f"{why}: measure more points there")
    return found


def _hidden(path: Path) -> Count | None:
    """Return how many poles at w = 0 zeros there hide, None where none is known to be hidden."""
    zeros, poles = at_rest(path.controller)
    k = path.low.integrators if path.low is not None and settled(path) else 0
    hidden = min(zeros + max(-k, 0), poles + max(k, 0))
    if not hidden:
        return None
    place = "s = 0" if isinstance(path.controller, Plant) else "z = 1"
    if zeros and poles:
        both = f"at {place}: the controller has a pole and a zero there"
        return Count(unstable=hidden, why="", hidden=both)
    one, other = ("pole", "zero") if poles else ("zero", "pole")
    each = f"at {place}: the controller has a {one} there, and the plant a {other}"
    return Count(unstable=hidden, why=_granted_below(path, k), hidden=each)


def _blurred(path: Path) -> str | None:
    """Return why the points themselves leave the count open, None where they do not."""
    table, x = path.table, np.log(path.w)
    blur = np.zeros(len(x))
    for share, column in ((_SIGMAS, table.uncertainty), (1.0, table.neglected)):
        if column is not None:
            blur += share * np.interp(x, np.log(table.w), column)
    near = np.abs(1 + path.gain) <= blur * np.abs(path.gain)
    if near.any():
        at = path.w[int(np.argmax(near))]
        return f"within its uncertainty (3 sigma) the loop may be -1 at {at:.6g} rad/s"
    for i in np.flatnonzero(np.abs(np.diff(table.phase_deg)) > _SURE_DEG).tolist():
        a, b = table.w[i], table.w[i + 1]
        if max(abs(path.at(float(a))), abs(path.at(float(b)))) > _LOUD:
            return (
                f"from {a:.6g} to {b:.6g} rad/s the phase turns by "
                f"{abs(table.phase_deg[i + 1] - table.phase_deg[i]):.0f} deg, where |L| is above "
                f"{_LOUD:g}: it may have turned the other way; measure more points there"
            )
    return None


def _unseen_above(path: Path) -> str | None:
    if path.above < 1:
        return None
    return (
        f"|L| may be as large as {path.above:.4g} beyond {path.table.band[1]:.6g} rad/s, "
        "where the table ends: measure further, until it stays below 1"
    )


def _unseen_below(path: Path) -> str | None:
    first, size = path.table.band[0], abs(path.gain[0])
    zeros, poles = at_rest(path.controller)
    if path.low is None and not zeros and quiet_below(path):  # a zero may hide an integrator
        return None  # and no louder below: it stays away from -1
    if path.low is None or ((zeros or poles) and not settled(path)):
        return (
            f"below {first:.6g} rad/s, where the table begins, neither slope nor phase show how "
            "it goes on: measure further down, until they settle"
        )
    side = degrees(float(np.angle(-path.gain[0])))
    blur = 0.0 if path.table.uncertainty is None else degrees(3 * path.table.uncertainty[0])
    if size > 1 and abs(side) <= max(_SIDE_DEG, blur):
        return (
            f"it begins at {first:.6g} rad/s so near to -180 deg with |L| above 1 that the side "
            "cannot be told: measure further up or down"
        )
    return None


def _turn(path: Path) -> float:
    """Return the angle in rad by which 1 + L turns from w = 0+ to the top of the axis."""
    below = path.below()[1]
    if len(below):
        arc = np.linspace(0, 1, 9) * np.log(path.gain[0] / below[-1])  # the shorter way round
        below = np.concatenate([below, below[-1] * np.exp(arc)])
    else:
        below = np.zeros(1, complex)  # a quiet loop: from 0 straight to the first point
    points = 1 + np.concatenate([below, _refined(path)])
    first = float(np.angle(points[0]))
    end = first + float(np.angle(points[1:] / points[:-1]).sum())
    if path.table.reaches_nyquist:
        end = pi * round(end / pi)  # L is real there
    else:
        end -= float(np.angle(points[-1]))  # back to 0 without another turn: |L| < 1
    return end - first


def _refined(path: Path) -> ComplexArray:
    """Return L in the band on a path whose every step turns 1 + L by little."""
    w: Array = path.w
    gain = path.gain
    for _ in range(40):
        step = np.abs(np.angle((1 + gain[1:]) / (1 + gain[:-1])))
        wide = np.flatnonzero(step > _STEP)
        middle = np.sqrt(w[wide] * w[wide + 1])
        new = (middle > w[wide]) & (middle < w[wide + 1])
        if not new.any():
            break
        w = np.insert(w, wide[new] + 1, middle[new])
        gain = np.insert(gain, wide[new] + 1, [path.at(float(x)) for x in middle[new]])
    return gain


def _granted(path: Path) -> str:
    """Return what the count rests on, in words."""
    table = path.table
    p = table.unstable_poles
    parts = [f"the plant has {p or 'no'} unstable pole{'s' if p != 1 else ''}"]
    parts.append("no resonance hides between the points")
    if path.low is not None:
        parts.append(_granted_below(path, path.low.integrators))
    if not table.reaches_nyquist:
        parts.append(
            f"beyond {table.band[1]:.6g} rad/s its gain rises no more (then |L| stays below "
            f"{path.above:.4g})"
        )
    return "; ".join(parts)


def _granted_below(path: Path, integrators: int) -> str:
    """Return how the plant is taken to go on below its table, in words."""
    like = f"falls with w^{-integrators}" if integrators else "is constant"
    return f"below {path.table.band[0]:.6g} rad/s its gain {like}, as its low end does"
