"""Tables that the curve between their points meets exactly, so that figures follow by hand.

A gain k w^a at a phase p + b ln w is a line over ln w in both.
"""

from math import log

import pytest

from zoh import FrequencyResponse


def spiral(w, k=1.0, slope=-1.0, start=-90.0, turn=0.0, **more):
    """Return k w^slope at the phase ``start`` + ``turn`` ln w, in deg."""
    magnitude = [k * x**slope for x in w]
    phase_deg = [start + turn * log(x) for x in w]
    return FrequencyResponse(w=w, magnitude=magnitude, phase_deg=phase_deg, **more)


def near(truth, rel=1e-12):
    return pytest.approx(truth, rel=rel, abs=1e-300)
