"""SciPy: the margins people write by hand, on a grid of 2000 points closed in on by brentq."""

import warnings
from collections.abc import Callable

import numpy as np
from benchmarks.torture.loops import Spec
from benchmarks.torture.score import Answer

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import scipy
    from scipy import optimize, signal

VERSION = f"SciPy {scipy.__version__}"
POINTS = 2000


def coefficients(spec: Spec) -> tuple[np.ndarray, np.ndarray] | str:
    """Return num and den of the loop, or what it is that SciPy cannot say."""
    if spec["form"] != "params":
        return np.array(spec["num"]), np.array(spec["den"])
    plant, law, dt = spec["plant"], spec["controller"], spec["dt"]
    samples = plant["dead_time"] / dt
    if abs(samples - round(samples)) > 1e-9:
        return "dead time of a fraction of a sample"
    num, den, _ = signal.cont2discrete((plant["num"], plant["den"]), dt, method="zoh")
    den = np.append(den, np.zeros(round(samples)))
    if "num" in law:
        return np.polymul(num[0], law["num"]), np.polymul(den, law["den"])
    half, d = law["ki"] * dt / 2, law["kd"] / dt
    if half and d:
        top = [law["kp"] + half + d, half - law["kp"] - 2 * d, d]
        bottom = [1.0, -1.0, 0.0]
    elif half:
        top, bottom = [law["kp"] + half, half - law["kp"]], [1.0, -1.0]
    else:
        top, bottom = ([law["kp"] + d, -d], [1.0, 0.0]) if d else ([law["kp"]], [1.0])
    return np.polymul(num[0], top), np.polymul(den, bottom)


def answer(spec: Spec) -> Answer:
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            made = coefficients(spec)
            if isinstance(made, str):
                return Answer(cannot=made)
            return _margins(*made, spec.get("dt"), spec.get("dead_time", 0.0))
        except Exception as error:  # whatever a tool raises is its answer
            return Answer(error=f"{type(error).__name__}: {error}")


def _margins(num: np.ndarray, den: np.ndarray, dt: float | None, dead_time: float) -> Answer:
    def at(w: np.ndarray) -> np.ndarray:
        x = np.exp(1j * w * dt) if dt else 1j * w
        return np.polyval(num, x) / np.polyval(den, x) * np.exp(-1j * w * dead_time)

    w = np.logspace(-3, np.log10(np.pi / dt) if dt else 4, POINTS)
    here = at(w)
    gains = [(x, _wrapped(np.degrees(np.angle(at(x))) - 180)) for x in _changes(
        lambda x: np.abs(at(x)) - 1, w, np.abs(here) - 1)]  # fmt: skip
    turns = _changes(lambda x: at(x).imag, w, here.imag)
    phases = [(x, float(-1 / at(x).real)) for x in turns if at(x).real < 0]
    distance = np.abs(1 + here)
    i = int(np.argmin(distance))
    low, high = w[max(i - 1, 0)], w[min(i + 1, POINTS - 1)]
    found = optimize.minimize_scalar(lambda x: abs(1 + at(x)), bounds=(low, high), method="bounded")
    roots = np.roots(np.polyadd(num, den))
    stable = None
    if not dead_time:
        stable = bool((abs(roots) < 1).all() if dt else (roots.real < 0).all())
    return Answer(
        stable=stable,
        gm=min((k for _, k in phases), key=lambda k: abs(np.log(k)), default=np.inf),
        pm_deg=min((pm for _, pm in gains), key=abs, default=np.inf),
        ms=float(1 / min(distance[i], found.fun)),
        gains=tuple(gains),
        phases=tuple(phases),
    )


def _changes(f: Callable[[float], float], w: np.ndarray, values: np.ndarray) -> list[float]:
    flips = np.flatnonzero(np.sign(values[1:]) * np.sign(values[:-1]) < 0)
    return [float(optimize.brentq(f, w[i], w[i + 1], xtol=1e-14 * w[i])) for i in flips]


def _wrapped(deg: float) -> float:
    return float(180 - (180 - deg) % 360)
