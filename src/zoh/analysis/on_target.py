"""Whether a measured loop has the crossover and the margin that it was asked for, or why not.

A law solved in closed form makes L = exp(j (pm - 180 deg)) at wc, but for rounding. What is
measured may be another crossover with a smaller margin; none at all, where |L| is 1 without
passing it; or the same one, moved, where |L| is so flat that the rounding of the gains moves it.
"""

from cmath import rect
from collections.abc import Callable
from math import inf, radians

from zoh.analysis.results import Margins
from zoh.analysis.tabled.margins import Seen
from zoh.spec import Crossover

_MARGIN_TOL_DEG = 1e-9  # the promise of this library; the closed forms reach some 1e-13
_CROSSOVER_TOL = 1e-9  # relative
_SURELY = 0.1  # of both, for what a search finds: it is measured anew, and that rounds otherwise
_NEAR = 1e-6  # relative: farther than rounding moves a crossover, even one where |L| touches 1
_AS_SOLVED = 1e-9  # of L at wc, which is where it should be but for rounding
UNSTABLE, ELSEWHERE = "the loop is unstable", "the loop crosses over elsewhere"


def surely_on_target(m: Margins | Seen, spec: Crossover) -> bool:
    """Return whether the margin nearest to zero is surely the one that was asked for."""
    return surely_at(m.crossover, m.phase_margin_deg, spec)


def surely_at(crossover: float | None, pm_deg: float, spec: Crossover) -> bool:
    """Return whether a crossover and its margin are those asked for, with room for rounding.

    >>> asked = Crossover(wc=2.0, pm_deg=40.0)
    >>> surely_at(2.0, 40.0 + 5e-11, asked), surely_at(2.0, 40.0 + 5e-10, asked)
    (True, False)
    """
    return _within(_SURELY, crossover, pm_deg, spec)


def not_as_asked(m: Margins, spec: Crossover | None, loop: Callable[[float], complex]) -> list[str]:
    """Return what is not as the crossover was asked for; instability speaks for itself.

    loop  the open loop's gain at a frequency in rad/s
    """
    if spec is None or not m.stable or _within(1.0, m.crossover, m.phase_margin_deg, spec):
        return []
    wanted, is_ = _apart((spec.pm_deg, spec.wc), (m.phase_margin_deg, m.crossover))
    return [f"the phase margin is {is_}{_why(m, spec, loop(spec.wc), wanted)}"]


def _within(share: float, crossover: float | None, pm_deg: float, spec: Crossover) -> bool:
    """Return whether a crossover is as asked, to a share of the tolerances."""
    return (
        crossover is not None
        and abs(pm_deg - spec.pm_deg) <= share * _MARGIN_TOL_DEG
        and abs(crossover / spec.wc - 1) <= share * _CROSSOVER_TOL
    )


def _why(m: Margins, spec: Crossover, there: complex, wanted: str) -> str:
    """Return what the crossover measured has to do with the one that was wanted; L is ``there``."""
    near = min((w for w, _ in m.gain_crossings), key=lambda w: abs(w - spec.wc), default=inf)
    if abs(near / spec.wc - 1) > _NEAR:
        if abs(abs(there) - 1) <= _AS_SOLVED:
            return f", not {wanted}: |L| is 1 there, and does not pass it"
        return f", not {wanted}: the loop does not cross over there"
    if near != m.crossover:  # it does cross over where it should: elsewhere the margin is smaller
        return f", another crossover of this loop, not {wanted}"
    if abs(there + rect(1.0, radians(spec.pm_deg))) <= _AS_SOLVED:
        return f", not {wanted}: |L| is so flat there that rounded gains move its crossover"
    return f", not {wanted}"


def _apart(wanted: tuple[float, float], found: tuple[float, float | None]) -> list[str]:
    """Return two margins in words, in as many digits as tell them apart.

    >>> _apart((40.0, 2.0), (40.0, 2.0000001))
    ['40 deg at 2 rad/s', '40 deg at 2.0000001 rad/s']
    """
    said: list[str] = []
    for digits in (6, 12, 17):
        said = [
            f"{pm:.{digits}g} deg at " + ("no frequency" if w is None else f"{w:.{digits}g} rad/s")
            for pm, w in (wanted, found)
        ]
        if said[0] != said[1]:
            break
    return said
