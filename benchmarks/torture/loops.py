"""The loops of the suite: what a loop is, as exact whole numbers, and the files they are in.

A loop has a form:

z       num, den, dt: the floats are the loop
s       num, den, dead_time: a continuous loop
params  a plant (num, den, dead_time), dt and a controller (kp, ki, kd, or num and den in z):
        the loop is what these parameters say, and nobody has rounded its coefficients yet
"""

import gzip
import json
from fractions import Fraction
from math import lcm
from pathlib import Path
from typing import Any

from benchmarks.torture import exact, held
from benchmarks.torture.exact import Poly
from benchmarks.torture.truth import Loop

HERE = Path(__file__).resolve().parent
LOOPS = HERE / "loops.json.gz"
TRUTH = HERE / "truth.json.gz"

Spec = dict[str, Any]


def read(path: Path) -> list[Spec]:
    with gzip.open(path, "rt") as file:
        return list(json.load(file))


def write(path: Path, items: list[Spec]) -> None:
    """Write one item a line; the same items give the same bytes on every day."""
    lines = ",\n".join(json.dumps(item, separators=(",", ":")) for item in items)
    with open(path, "wb") as raw, gzip.GzipFile("", "wb", 9, raw, mtime=0) as file:
        file.write(f"[\n{lines}\n]\n".encode())


def exact_loop(spec: Spec) -> Loop:
    """Return the loop of a spec as whole numbers."""
    if spec["form"] == "params":
        num, den = _from_parameters(spec)
    else:
        num, den = exact.integers(spec["num"][::-1], spec["den"][::-1])
    dt, dead_time = spec.get("dt"), spec.get("dead_time", 0.0)
    return Loop(num=exact.trim(num), den=exact.trim(den), dt=dt, dead_time=dead_time)


def in_z(spec: Spec) -> Spec:
    """Return a params loop as z-coefficients, each rounded once: what other tools work with."""
    num, den = _from_parameters(spec)
    lead = den[-1]
    top, bottom = ([float(Fraction(c, lead)) for c in reversed(exact.trim(a))] for a in (num, den))
    return {"form": "z", "num": top, "den": bottom, "dt": spec["dt"]}


def _from_parameters(spec: Spec) -> tuple[Poly, Poly]:
    plant = spec["plant"]
    top, bottom, m = held.held(plant["num"], plant["den"], spec["dt"], plant["dead_time"])
    num, den = exact.integers(top, bottom)
    law_num, law_den = controller(spec)
    scale = lcm(*(c.denominator for c in (*law_num, *law_den)))
    whole = [[int(c * scale) for c in a] for a in (law_num, law_den)]
    return exact.mul(num, whole[0]), [0] * m + exact.mul(den, whole[1])


def controller(spec: Spec) -> tuple[list[Fraction], list[Fraction]]:
    """Return num and den of the controller in ascending powers of z, exact.

    kp + ki/w + kd w/(1 + w dt/2) is kp + ki dt/2 (z+1)/(z-1) + kd/dt (z-1)/z.

    >>> controller({"dt": 1.0, "controller": {"kp": 1.0, "ki": 2.0, "kd": 0.0}})[0]
    [Fraction(0, 1), Fraction(2, 1)]
    """
    law, dt = spec["controller"], Fraction(spec["dt"])
    if "num" in law:
        num, den = ([Fraction(c) for c in reversed(law[a])] for a in ("num", "den"))
        return num, den
    kp, i, d = Fraction(law["kp"]), Fraction(law["ki"]) * dt / 2, Fraction(law["kd"]) / dt
    zero, one = Fraction(0), Fraction(1)
    if i and d:
        return [d, i - kp - 2 * d, kp + i + d], [zero, -one, one]
    if i:
        return [i - kp, kp + i], [-one, one]
    return ([-d, kp + d], [zero, one]) if d else ([kp], [one])
