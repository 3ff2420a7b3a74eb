"""Draw the loops: ``python -m benchmarks.torture.generate`` writes loops.json.gz.

Every loop has its own seed, "class/number", and is made of parameters of four digits; what has to
be sampled is sampled in many digits and rounded once, so that every machine draws the same bits.
"""

import random
from collections.abc import Callable, Iterator
from fractions import Fraction
from math import cos, log10, sin

from benchmarks.torture import loops, named
from benchmarks.torture.loops import Spec

Draw = random.Random
Roots = list[complex | float]


def rounded(x: float, digits: int = 4) -> float:
    """Return x to a few decimal digits."""
    return float(f"{x:.{digits}g}")


def decades(rng: Draw, low: float, high: float) -> float:
    return rounded(10 ** rng.uniform(low, high))


def expand(roots: Roots, gain: float = 1.0) -> list[float]:
    """Return gain prod(x - root), complex roots standing for their pair, rounded once."""
    out = [Fraction(gain)]
    for r in roots:
        if isinstance(r, complex):
            re, im = Fraction(r.real), Fraction(r.imag)
            factor = [Fraction(1), -2 * re, re * re + im * im]
        else:
            factor = [Fraction(1), -Fraction(r)]
        grown = [Fraction(0)] * (len(out) + len(factor) - 1)
        for i, x in enumerate(out):
            for j, y in enumerate(factor):
                grown[i + j] += x * y
        out = grown
    return [float(c) for c in out]


def size_at(num: list[float], den: list[float], w: float) -> float:
    """Return |num/den| at s = jw."""
    value = [0j, 0j]
    for i, a in enumerate((num, den)):
        for c in a:
            value[i] = value[i] * 1j * w + c
    return abs(value[0] / value[1])


def pid(rng: Draw, num: list[float], den: list[float], wc: float) -> dict[str, float]:
    """Return gains that put |L| near 1 at wc."""
    kp = 1 / size_at(num, den, wc)
    return {
        "kp": rounded(kp * rng.uniform(0.5, 1.0)),
        "ki": rounded(kp * wc * rng.uniform(0.02, 0.5)) if rng.random() < 0.8 else 0.0,
        "kd": rounded(kp / wc * rng.uniform(0.1, 1.0)) if rng.random() < 0.6 else 0.0,
    }


def joint(rng: Draw) -> tuple[list[float], list[float]]:
    """Return a robot's joint, K/(s(s + a)), now and then with the motor's electric pole."""
    k, a = decades(rng, -1, 2), decades(rng, -1.3, 1)
    if rng.random() < 0.3:
        return [rounded(k * 200)], expand([0.0, -a, -rounded(rng.uniform(100, 400))])
    return [k], [1.0, a, 0.0]


def process(rng: Draw, most: int = 5) -> tuple[list[float], list[float]]:
    """Return a plant of order 1 to ``most`` with poles over two and a half decades."""
    n = rng.randint(1, most)
    poles: Roots = []
    while n > 0:
        if n > 1 and rng.random() < 0.35:
            w, zeta = decades(rng, -0.3, 1.7), decades(rng, -2.5, -0.05)
            poles.append(complex(-rounded(w * zeta), rounded(w * (1 - zeta**2) ** 0.5)))
            n -= 2
        else:
            poles.append(-decades(rng, -1, 1.5))
            n -= 1
    real = [i for i, p in enumerate(poles) if not isinstance(p, complex)]
    if real and rng.random() < 0.45:
        poles[real[0]] = 0.0
    elif real and rng.random() < 0.12:
        poles[real[0]] = decades(rng, -1, 0.5)
    den = expand(poles)
    zeros: Roots = [
        rng.choice([-1.0, -1.0, -1.0, 1.0]) * decades(rng, -0.3, 1.5)
        for _ in range(rng.randint(0, max(0, min(2, len(den) - 2))))
    ]
    return expand(zeros, decades(rng, -1, 1)), den


def corner(den: list[float]) -> float:
    """Return the geometric mean of the poles that are not at 0; 1 rad/s without any."""
    low = next(i for i, c in enumerate(reversed(den)) if c)
    n = len(den) - 1 - low
    return abs(den[n] / den[0]) ** (1 / n) if n else 1.0


def robot(rng: Draw, low: float = -1.523, high: float = -0.523) -> Spec:
    """Return a joint with a PID and a sample time between two powers of ten."""
    num, den = joint(rng)
    dt = decades(rng, low, high)
    wc = rounded(min(corner(den) * 10 ** rng.uniform(-0.3, 0.8), rng.uniform(0.1, 0.9) / dt))
    plant = {"num": num, "den": den, "dead_time": 0.0}
    return {"form": "params", "plant": plant, "dt": dt, "controller": pid(rng, num, den, wc)}


def plain_process(rng: Draw, low: float, high: float, turn: float = 0.6) -> Spec:
    """Return a process with a PI or PID, its crossover at most ``turn``/dt."""
    num, den = process(rng)
    dt = decades(rng, low, high)
    wc = rounded(min(corner(den) * 10 ** rng.uniform(-0.7, 0.7), turn / dt))
    plant = {"num": num, "den": den, "dead_time": 0.0}
    return {"form": "params", "plant": plant, "dt": dt, "controller": pid(rng, num, den, wc)}


def parameters(rng: Draw) -> Spec:
    """Return a robot or a process with any sample time and, half the time, dead time."""
    dt = decades(rng, -6, -0.5)
    near = (log10(dt), log10(dt))
    spec = robot(rng, *near) if rng.random() < 0.5 else plain_process(rng, *near)
    fractions = rounded(rng.uniform(0.05, 0.95)), rounded(rng.uniform(1, 7))
    samples = rng.choice([0, 0, 0, 1, 2, *fractions])
    spec["plant"]["dead_time"] = samples * spec["dt"]
    return spec


def disc_roots(rng: Draw, n: int, radius: Callable[[], float]) -> Roots:
    out: Roots = []
    while n > 0:
        r = rounded(radius(), 7)
        if n > 1 and rng.random() < 0.5:
            turn = rng.uniform(0.03, 3.1)
            out.append(complex(rounded(r * cos(turn), 7), rounded(r * sin(turn), 7)))
            n -= 2
        else:
            out.append(r * rng.choice([1, 1, 1, -1]))
            n -= 1
    return out


def disc(rng: Draw, most: int = 6) -> Spec:
    """Return a loop drawn in the z-plane itself."""
    n = rng.randint(1, most)
    edge = rng.choice(["plain", "plain", "close", "outside"])
    radius = {
        "plain": lambda: rng.uniform(0.05, 0.99),
        "close": lambda: 1 - 10 ** rng.uniform(-4, -1),
        "outside": lambda: rng.uniform(0.4, 1.3),
    }[edge]
    poles = disc_roots(rng, n, radius)
    if rng.random() < 0.35:
        poles = [1.0, *disc_roots(rng, n - 1, radius)]
    zeros = disc_roots(rng, rng.randint(0, n), lambda: rng.uniform(0.05, 1.5))
    gain = decades(rng, -2.5, 0.5) * rng.choice([1, 1, 1, 1, -1])
    return {
        "form": "z", "num": expand(zeros, gain), "den": expand(poles),
        "dt": rng.choice([1.0, 0.1, 0.02, 1e-3]),
    }  # fmt: skip


def resonant(rng: Draw) -> Roots:
    """Return pairs of poles so close to the circle that a grid walks past them."""
    return disc_roots(rng, 2, lambda: 1 - 10 ** rng.uniform(-6, -2)) or [0.5]


def hard(rng: Draw) -> Spec:
    """Return a loop of the kinds that break margin routines."""
    kind = rng.choice(
        ["resonance", "notch", "conditional", "unstable", "nyquist", "negative", "high", "late"]
    )
    inside = disc_roots(rng, rng.randint(1, 3), lambda: rng.uniform(0.3, 0.95))
    zeros = disc_roots(rng, rng.randint(0, len(inside)), lambda: rng.uniform(0.1, 1.4))
    gain = decades(rng, -2.5, 0)
    if kind == "resonance":
        poles = [*resonant(rng), *inside]
        gain = gain * 1e-2
    elif kind == "notch":
        poles = [*resonant(rng), *inside]
        zeros = [
            complex(rounded(p.real * (1 - 1e-3), 7), rounded(p.imag * (1 + 1e-3), 7))
            for p in poles
            if isinstance(p, complex)
        ]
    elif kind == "conditional":
        poles = [1.0] * rng.choice([2, 3]) + inside[:1]
        zeros = disc_roots(rng, 2, lambda: rng.uniform(0.85, 0.99))
        gain = decades(rng, -1, 0.3)
    elif kind == "unstable":
        poles = [rounded(rng.uniform(1.01, 1.6)), *inside]
        gain = decades(rng, -1.5, 0.5)
    elif kind == "nyquist":
        poles = [-1.0, *inside]
    elif kind == "negative":
        poles, gain = [rng.choice([1.0, 0.9]), *inside], -gain
    elif kind == "high":
        poles = disc_roots(rng, rng.randint(7, 10), lambda: rng.uniform(0.2, 0.97))
        zeros = disc_roots(rng, rng.randint(0, 6), lambda: rng.uniform(0.2, 1.2))
    else:
        poles = [rng.choice([1.0, 0.95]), *inside, *[0.0] * rng.randint(1, 9)]
    num, den = expand(zeros, rounded(gain)), expand(poles)
    if len(num) > len(den):
        num = num[-len(den) :]
    return {"form": "z", "num": num, "den": den, "dt": rng.choice([1.0, 0.1, 1e-3]), "kind": kind}


def continuous(rng: Draw) -> Spec:
    """Return a continuous loop of a process and a PI, PD or gain."""
    num, den = process(rng, most=6)
    wc = rounded(corner(den) * 10 ** rng.uniform(-0.7, 0.9))
    gain = rounded(rng.choice([1, 1, 1, 1, -1]) / size_at(num, den, wc))
    law_num, law_den = rng.choice(
        [([1.0], [1.0]), ([1.0, rounded(wc / 5)], [1.0, 0.0]), ([1.0, rounded(wc)], [rounded(wc)])]
    )
    num = _product([gain * c for c in num], law_num)
    den = _product(den, law_den)
    if len(num) > len(den):
        den = _product(den, [rounded(0.1 / wc), 1.0])
    return {"form": "s", "num": num, "den": den, "dead_time": 0.0}


def late(rng: Draw) -> Spec:
    """Return a strictly proper continuous loop with dead time."""
    while True:
        spec = continuous(rng)
        if len(spec["num"]) < len(spec["den"]):
            break
    wc = corner(spec["den"])
    return {**spec, "dead_time": rounded(10 ** rng.uniform(-1.5, 0.5) / wc)}


def _product(a: list[float], b: list[float]) -> list[float]:
    out = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i + j] += Fraction(x) * Fraction(y)
    return [float(c) for c in out]


def as_coefficients(draw: Callable[[Draw], Spec]) -> Callable[[Draw], Spec]:
    """Return the same draw with its z-coefficients rounded."""
    return lambda rng: loops.in_z(draw(rng))


CLASSES: dict[str, tuple[int, Callable[[Draw], Spec]]] = {
    "robot PID, 0.03-0.3 s": (250, as_coefficients(robot)),
    "random z-plane": (350, disc),
    "sampled, 1e-2-1e-3 s": (200, as_coefficients(lambda r: plain_process(r, -3, -2))),
    "sampled, 1e-4 s": (100, as_coefficients(lambda r: plain_process(r, -4, -4))),
    "sampled, 1e-5 s": (50, as_coefficients(lambda r: plain_process(r, -5, -5))),
    "robot PID, 1e-3-1e-5 s": (50, as_coefficients(lambda r: robot(r, -5, -3))),
    "from parameters": (200, parameters),
    "hard": (200, hard),
    "continuous": (150, continuous),
    "continuous, dead time": (50, late),
}


def draws() -> Iterator[Spec]:
    """Yield every loop of the suite, the named ones first."""
    for spec in named.named():
        if spec["form"] == "rounded":
            name = spec["name"]
            spec = {"name": name, **loops.in_z(spec)}
        yield {"class": "named", **spec}
    for label, (count, draw) in CLASSES.items():
        for i in range(count):
            yield {"name": f"{label} #{i}", "class": label, **draw(random.Random(f"{label}/{i}"))}


def main() -> None:
    loops.write(loops.LOOPS, list(draws()))


if __name__ == "__main__":
    main()
