"""A real fraction as sections of first and second order, and what each turns the phase by.

Every section is 1 at zero frequency, an integrator and a differentiator apart, so that its
phase starts at 0 and runs on without a jump::

    1 - s/r              turns by -atan(v/r) at s = j v: up to 90 deg, down for r > 0
    1 - 2 a s/c + s^2/c  turns by atan2(-2 a v, c - v^2), c = a^2 + b^2, for r = a +- j b
    s                    turns by 90 deg

and a pole by as much the other way. What is left is a gain, whose sign is 0 or -180 deg.
Source: H. W. Bode, Network Analysis and Feedback Amplifier Design; in this form K. J. Astrom and
R. M. Murray, Feedback Systems, 2nd ed., sec. 9.6 (Bode plots of products).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan, atan2, degrees

from zoh.lti import poly


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """What a factor of a fraction turns the phase by: its name, and deg at the frequency asked."""

    name: str
    deg: float


def sections(num: Sequence[float], den: Sequence[float], v: float) -> tuple[Section, ...]:
    """Return the sections of num/den, polynomials in descending powers of s or w, at v rad/s.

    The gain's sign comes first where it is negative, then zeros and poles, the slow ones first.

    >>> [(s.name, round(s.deg, 9)) for s in sections((1.0, 1.0), (1.0, 0.0), 1.0)]
    [('zero at -1 rad/s', 45.0), ('integrator', -90.0)]
    >>> [(s.name, round(s.deg, 9)) for s in sections((1.0,), (1.0, -1.0), 1.0)]
    [('negative gain', -180.0), ('pole at 1 rad/s', 45.0)]
    """
    negative = (_last(num) < 0) != (_last(den) < 0)
    found = [Section(name="negative gain", deg=-180.0)] if negative else []
    found += [Section(name=f"zero {where}", deg=turn) for where, turn in _turns(num, v)]
    found += [Section(name=f"pole {where}", deg=-turn) for where, turn in _turns(den, v)]
    named = {"zero at 0": "differentiator", "pole at 0": "integrator"}
    return tuple(Section(name=named.get(s.name, s.name), deg=s.deg) for s in found)


def _turns(a: Sequence[float], v: float) -> Iterator[tuple[str, float]]:
    """Yield where each root or pair of roots is, and by how many deg a zero there turns."""
    for r in sorted(poly.roots(a).tolist(), key=lambda r: (abs(r), r.real)):
        if r == 0:
            yield "at 0", 90.0
        elif r.imag == 0:
            yield f"at {r.real:.4g} rad/s", degrees(-atan(v / r.real))
        elif r.imag > 0:  # its conjugate is in the same section
            size = abs(r)
            ratio = v / size
            # + 0.0: an undamped pair is the limit of a damped one, not of a growing one
            turn = atan2(-2 * (r.real / size) * ratio + 0.0, 1 - ratio * ratio)
            yield f"pair at {r.real:.4g} +- {r.imag:.4g}j rad/s", degrees(turn)


def _last(a: Sequence[float]) -> float:
    """Return the last coefficient that is not 0, the gain at s = 0 without what vanishes there."""
    return next(c for c in reversed(a) if c)
