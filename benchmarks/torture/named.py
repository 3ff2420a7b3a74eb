"""The loops with a name: cases on which a released tool was seen to print a wrong number.

The plant is a robot's arm, 0.1533/(s**2 + 0.7809 s), where nothing else is said.
"""

from collections.abc import Iterator
from math import exp
from typing import Any

Spec = dict[str, Any]

ARM: Spec = {"num": [0.1533], "den": [1.0, 0.7809, 0.0], "dead_time": 0.0}
CLOCKS = (0.1, 0.05, 0.02, 0.01, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6)


def named() -> Iterator[Spec]:
    """Yield every named loop."""
    yield from _arms()
    yield from _by_hand()
    yield from _continuous()


def _arms() -> Iterator[Spec]:
    for dt in CLOCKS:
        zero = float(f"{exp(-0.05 * dt):.16g}")
        law = {"num": [3.0, -3.0 * zero], "den": [1.0, -1.0]}
        laws = {"PI loop": law, "plant alone": {"num": [1.0], "den": [1.0]}}
        for label, controller in laws.items():
            spec = {"form": "params", "plant": ARM, "dt": dt, "controller": controller}
            yield {"name": f"arm, {label}, dt {dt:g}", **spec}
            yield {"name": f"arm, {label}, dt {dt:g}, z-coefficients", **spec, "form": "rounded"}
    gain = {"num": [3.0], "den": [1.0]}
    yield {"name": "arm, gain 3, dt 0.1", "form": "params", "plant": ARM, "dt": 0.1,
           "controller": gain}  # fmt: skip
    yield {"name": "arm, gain 3, dt 1", "form": "params", "plant": ARM, "dt": 1.0,
           "controller": gain}  # fmt: skip


def _by_hand() -> Iterator[Spec]:
    table = [
        # name, num, den, dt
        ("leaves at z = -1: gain margin 19, |L(1)| = 1 to rounding", [0.1], [1.0, -0.9], 1.0),
        ("leaves at z = -1: gain margin 38", [0.05], [1.0, -0.9], 1.0),
        ("leaves at z = -1: gain margin 9.5", [0.2], [1.0, -0.9], 1.0),
        ("leaves at z = -1: gain margin 1.5", [1.0], [1.0, -0.5], 1.0),
        ("leaves at z = -1: beyond its gain margin", [2.0], [1.0, -0.5], 1.0),
        ("integrator", [0.5], [1.0, -1.0], 0.2),
        ("pole at z = -1", [0.3], [1.0, 1.0], 1.0),
        ("poles at z = 1 and z = -1", [0.1, 0.05], [1.0, 0.0, -1.0], 1.0),
        ("double pole at z = -1", [0.02, 0.03], [1.0, 2.0, 1.0], 0.5),
        ("unstable, held", [0.5], [1.0, -1.2], 0.5),
        ("unstable with a positive phase margin", [2.4, -1.9], [1.0, -2.2, 1.17], 0.1),
        ("triple integrator, conditionally stable", [0.9, -1.6, 0.75], [1.0, -3.0, 3.0, -1.0], 0.1),
        ("thin resonance", [1e-3, 1e-3], [1.0, -1.2, 0.9998], 0.01),
        ("thinner resonance", [1e-5, 2e-5], [1.0, -1.2, 0.999998], 0.01),
        ("deadbeat plant", [0.25, 0.25, 0.25], [1.0, 0.0, 0.0, 0.0], 0.1),
        ("eight samples late", [0.1], [1.0, -0.9] + [0.0] * 8, 0.1),
        ("negative gain", [-0.2], [1.0, -0.9], 0.1),
        ("negative gain, unstable", [-2.0], [1.0, -0.9], 0.1),
        ("hidden unstable mode", [0.125, -0.15], [1.0, -2.1, 1.08], 0.1),
        ("zero at z = 1", [0.4, -0.4], [1.0, -0.3, 0.1], 0.1),
    ]
    for name, num, den, dt in table:
        yield {"name": name, "form": "z", "num": num, "den": den, "dt": dt}


def _continuous() -> Iterator[Spec]:
    table = [
        # name, num, den, dead time
        ("1/(s+1)^4 with a PI of 60 deg and ki < 0: unstable", [2.213, -1.223],
         [1.0, 4.0, 6.0, 4.0, 1.0, 0.0], 0.0),
        ("gain margin 6", [1.0], [1.0, 3.0, 2.0, 0.0], 0.0),
        ("triple integrator, conditionally stable", [5.0, 10.0, 5.0], [1.0, 0.0, 0.0, 0.0], 0.0),
        ("three gain crossings", [1.2, 0.3, 1.2], [1.0, 0.05, 4.0, 0.0], 0.0),
        ("unstable lag", [3.0], [1.0, -1.0], 0.0),
        ("integrator with dead time", [1.0], [1.0, 0.0], 0.1),
        ("unstable lag with dead time", [2.0], [1.0, -1.0], 0.2),
        ("arm with dead time", [1.2264], [1.0, 0.7809, 0.0], 0.05),
    ]  # fmt: skip
    for name, num, den, dead_time in table:
        yield {"name": f"s: {name}", "form": "s", "num": num, "den": den, "dead_time": dead_time}
