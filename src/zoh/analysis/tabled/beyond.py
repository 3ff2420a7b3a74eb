"""What a loop may do outside its table, by what ``path`` takes for granted there."""

from math import inf, log

import numpy as np

from zoh.analysis.tabled.path import Path, boundary_poles, quiet_below
from zoh.analysis.tabled.results import Beyond


def beyond(path: Path) -> Beyond:
    """Return bounds: below from the plant's asymptote, above from |L| <= ``path.above`` < 1."""
    known = [_within(path.above), _below(path)]
    return Beyond(
        gain_margin=min((b.gain_margin for b in known), key=_from_one),
        phase_margin_deg=min(b.phase_margin_deg for b in known),
        ms=max(b.ms for b in known),
        mt=max(b.mt for b in known),
    )


def _within(size: float) -> Beyond:
    """Return the bounds of a loop that stays below this size: those of L = -size."""
    if size >= 1:
        return Beyond(gain_margin=1.0, phase_margin_deg=0.0, ms=inf, mt=inf)
    return Beyond(
        gain_margin=1 / size if size else inf,
        phase_margin_deg=inf,
        ms=1 / (1 - size),
        mt=size / (1 - size),
    )


def _below(path: Path) -> Beyond:
    """Return the bounds below the table, where a plant of a known asymptote is known."""
    if path.low is None:
        return _within(float(abs(path.gain[0])) if quiet_below(path) else inf)
    gain = path.below()[1]
    distance = np.abs(1 + gain)
    if not distance.all():
        return _within(1.0)  # it is -1
    turns = np.flatnonzero((gain[1:].imag * gain[:-1].imag <= 0) & (gain[1:].real < 0))
    factors = [float(abs(1 / gain[k])) for i in turns.tolist() for k in (i, i + 1)]
    if path.low.integrators + boundary_poles(path.controller)[0] == 0 and gain[0].real < 0:
        factors.append(float(abs(1 / gain[0])))  # at w = 0 it is real
    passes = np.flatnonzero((np.abs(gain[1:]) - 1) * (np.abs(gain[:-1]) - 1) <= 0)
    margins = np.degrees(np.abs(np.angle(-gain)))  # on both sides of a crossing, the smaller holds
    return Beyond(
        gain_margin=min(factors, key=_from_one, default=inf),
        phase_margin_deg=float(margins[np.concatenate([passes, passes + 1])].min(initial=inf)),
        ms=max(1.0, 1 / float(distance.min())),
        mt=float((np.abs(gain) / distance).max()),
    )


def _from_one(factor: float) -> float:
    return abs(log(factor))
