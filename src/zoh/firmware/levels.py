"""Sections whose gains are levelled, so that whole numbers between them do not saturate."""

from dataclasses import replace
from fractions import Fraction
from math import floor, inf, log2

import numpy as np
import numpy.typing as npt

from zoh.firmware.realise import Section

_GRID = np.expm1(1j * np.geomspace(1e-7, np.pi, 400))  # d on the unit circle, z = 1 near by


def levelled(parts: tuple[Section, ...]) -> tuple[Section, ...]:
    """Return the same product, powers of two moved so that none before the last amplifies a sine.

    The product up to each of them has then a gain of 1/2 at most at every frequency looked at, so
    that a sine of twice full scale passes; what is taken away is given back by the last one.
    """
    passed = np.ones(_GRID.shape, complex)
    moved, owed = [], Fraction(1)
    for part in parts[:-1]:
        gain = _on_circle(part)
        peak = float(np.abs(passed * gain).max())
        factor = Fraction(2) ** (-2 - floor(log2(peak))) if 0 < peak < inf else Fraction(1)
        moved.append(replace(part, b=_scaled(part.b, factor)))
        passed, owed = passed * gain * float(factor), owed / factor
    last = parts[-1]
    return (*moved, replace(last, b=_scaled(last.b, owed)))


def _scaled(
    b: tuple[Fraction, Fraction, Fraction], c: Fraction
) -> tuple[Fraction, Fraction, Fraction]:
    return c * b[0], c * b[1], c * b[2]


def _on_circle(part: Section) -> npt.NDArray[np.complex128]:
    b, a = (np.array([float(c) for c in x]) for x in (part.b, (Fraction(1), *part.a)))
    n = part.order
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.polyval(b[: n + 1], _GRID) / np.polyval(a[: n + 1], _GRID)
    return np.asarray(found, complex)
